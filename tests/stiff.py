"""Hale with its roll damping and its ailerons made so many times as strong: a fast roll mode that answers as before."""

from __future__ import annotations

import shutil
from pathlib import Path
from xml.etree import ElementTree

from uavftc.config.shipped import aircraft_dir


def stiff(folder: Path, factor: float, *, scaled: tuple[str, ...] = ("Cl_p", "Cl_da")) -> Path:
    """Write into `folder` the hale with these functions of its rolling moment times `factor`; return it.

    Its companion file has no rotational model, so all that is known of it is measured.
    """
    shutil.copytree(aircraft_dir() / "hale", folder)
    xml = folder / f"{folder.name}.xml"
    (folder / "hale.xml").rename(xml)
    tree = ElementTree.parse(xml)
    found = 0
    for axis in tree.iterfind("aerodynamics/axis"):
        for function in axis.findall("function"):
            if function.get("name", "").rsplit("/", 1)[-1] in scaled:
                product = function.find("product")
                assert product is not None
                value = ElementTree.SubElement(product, "value")
                value.text = repr(factor)
                found += 1
    assert found == len(scaled), "the aircraft is another: nothing is changed"
    tree.write(xml)
    companion = folder / "uavftc.yaml"
    text = companion.read_text(encoding="utf-8").split("analytic:")[0]
    companion.write_text(text.replace("name: hale", f"name: {folder.name}"), encoding="utf-8")
    return folder
