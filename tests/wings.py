"""Aircraft with fewer than three axes: hale with a surface taken out of its XML, left to weathercock or dihedral."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from xml.etree import ElementTree

from uavftc.config.shipped import aircraft_dir

MOMENTS = {"rudder": ("Cl_dr", "Cn_dr"), "aileron": ("Cl_da", "Cn_da"), "elevator": ("Cm_de",)}


def without(folder: Path, *surfaces: str) -> Path:
    """Write into `folder` the hale without what its surfaces move, and without its rotational model; return it."""
    shutil.copytree(aircraft_dir() / "hale", folder)
    xml = folder / f"{folder.name}.xml"
    (folder / "hale.xml").rename(xml)
    tree = ElementTree.parse(xml)
    for surface in surfaces:
        controls = tree.find("flight_control")
        assert controls is not None
        (channel,) = (c for c in controls.findall("channel") if c.get("name") == surface)
        controls.remove(channel)
        for axis in tree.iterfind("aerodynamics/axis"):
            for function in axis.findall("function"):
                if function.get("name", "").rsplit("/", 1)[-1] in MOMENTS[surface]:
                    axis.remove(function)
    tree.write(xml)
    companion = folder / "uavftc.yaml"
    text = companion.read_text(encoding="utf-8").split("analytic:")[0]
    for surface in surfaces:
        text = re.sub(rf"\n  {surface}: .*", "", text)
    companion.write_text(text.replace("name: hale", f"name: {folder.name}"), encoding="utf-8")
    return folder
