"""Aircraft with fewer than three axes: hale with a surface taken out of its XML, left to weathercock or dihedral."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from xml.etree import ElementTree

from uavftc.config.shipped import aircraft_dir
from uavftc.core.signals import SURFACES

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
        text = re.sub(rf"\n  (left_|right_)?{surface}: .*", "", text)
    companion.write_text(text.replace("name: hale", f"name: {folder.name}"), encoding="utf-8")
    return folder


def rotational(folder: Path, *surfaces: str) -> Path:
    """Write into `folder` the hale whose rotational model has no such surfaces: columns of zeros in B_m; return it."""
    shutil.copytree(aircraft_dir() / "hale", folder)
    (folder / "hale.xml").rename(folder / f"{folder.name}.xml")
    B_m = [[10, 0, 0.225], [0, 7.5, 0], [1.125, 0, 6.75]]
    kept = [[value * (name not in surfaces) for value, name in zip(row, SURFACES, strict=True)] for row in B_m]
    companion = folder / "uavftc.yaml"
    text = companion.read_text(encoding="utf-8")
    assert str(B_m) in text
    companion.write_text(text.replace(f"B_m: {B_m}", f"B_m: {kept}"), encoding="utf-8")
    return folder
