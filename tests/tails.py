"""Aircraft derived from hale: one with a V-tail, of which each surface serves two axes; one with a servo."""

from __future__ import annotations

import shutil
from pathlib import Path

from uavftc.config.shipped import aircraft_dir

STOP = 0.436332312999  # rad, hale's

V_TAIL = """\
    <property value="0">fcs/left-tail-cmd-rad</property>
    <property value="0">fcs/right-tail-cmd-rad</property>
    <channel name="tail">
      <actuator name="fcs/left-tail-actuator">
        <input>fcs/left-tail-cmd-rad</input>
        <clipto><min>-0.436332312999</min><max>0.436332312999</max></clipto>
        <output>fcs/left-tail-pos-rad</output>
      </actuator>
      <actuator name="fcs/right-tail-actuator">
        <input>fcs/right-tail-cmd-rad</input>
        <clipto><min>-0.436332312999</min><max>0.436332312999</max></clipto>
        <output>fcs/right-tail-pos-rad</output>
      </actuator>
      <pure_gain name="fcs/left-half"><input>fcs/left-tail-pos-rad</input><gain>0.5</gain></pure_gain>
      <pure_gain name="fcs/right-half"><input>fcs/right-tail-pos-rad</input><gain>0.5</gain></pure_gain>
      <summer name="fcs/tail-together">
        <input>fcs/left-half</input>
        <input>fcs/right-half</input>
        <output>fcs/elevator-pos-rad</output>
      </summer>
      <summer name="fcs/tail-apart">
        <input>fcs/left-half</input>
        <input>-fcs/right-half</input>
        <output>fcs/rudder-pos-rad</output>
      </summer>
    </channel>
"""
V_TAIL_EFFECTORS = """\
  left_tail: {command: fcs/left-tail-cmd-rad, position: fcs/left-tail-pos-rad, stop_rad: 0.436332312999}
  right_tail: {command: fcs/right-tail-cmd-rad, position: fcs/right-tail-pos-rad, stop_rad: 0.436332312999}
"""
V_TAIL_GANGS = """\
  elevator: {left_tail: 1, right_tail: 1}
  rudder: {left_tail: 1, right_tail: -1}
"""


def _copy(folder: Path) -> tuple[Path, str, Path, str]:
    shutil.copytree(aircraft_dir() / "hale", folder)
    xml, companion = folder / f"{folder.name}.xml", folder / "uavftc.yaml"
    (folder / "hale.xml").rename(xml)
    text = companion.read_text(encoding="utf-8").replace("name: hale", f"name: {folder.name}")
    return xml, xml.read_text(encoding="utf-8"), companion, text


def _between(text: str, begin: str, end: str, new: str) -> str:
    """Return the text with what is from `begin` to before `end` replaced; both must be there."""
    first = text.index(begin)
    return text[:first] + new + text[text.index(end, first) :]


def v_tail(folder: Path) -> Path:
    """Write into `folder` the hale with a V-tail that moves as its elevator and rudder do; return it."""
    xml, model, companion, text = _copy(folder)
    xml.write_text(_between(model, '    <channel name="elevator">', "  </flight_control>", V_TAIL), encoding="utf-8")
    text = _between(text, "  elevator: {command", "  left_motor", V_TAIL_EFFECTORS)
    companion.write_text(_between(text, "  elevator: {elevator", "autothrottle", V_TAIL_GANGS), encoding="utf-8")
    return folder


def with_servo(folder: Path) -> Path:
    """Write into `folder` the hale whose rudder lags by a servo of 20 rad/s and reports degrees; return it."""
    xml, model, companion, text = _copy(folder)
    model = _between(
        model,
        "        <input>fcs/rudder-sum</input>",
        "        <clipto>",
        "        <input>fcs/rudder-sum</input>\n        <lag>20</lag>\n",
    )
    degrees = (
        '      </actuator>\n      <pure_gain name="fcs/rudder-servo-deg">\n        <input>fcs/rudder-pos-rad</input>\n'
        "        <gain>57.29577951308232</gain>\n      </pure_gain>\n"
    )
    model = _between(model, "      </actuator>\n    </channel>\n  </flight", "    </channel>\n  </flight", degrees)
    xml.write_text(model, encoding="utf-8")
    text = text.replace("position: fcs/rudder-pos-rad", "position: fcs/rudder-servo-deg")
    companion.write_text(text, encoding="utf-8")
    return folder
