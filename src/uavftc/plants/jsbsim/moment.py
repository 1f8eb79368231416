"""A moment input for an aircraft that has none: a copy of its folder with an <external_reactions> moment added.

A disturbance d2 enters as the body moment J d2. JSBSim takes it through an external reaction, which most aircraft do
not define. The aircraft's files are never touched; the copy is in the user's cache under their checksum.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from pathlib import Path

from uavftc.aircraft.definition import Aircraft
from uavftc.core.cache import cache_folder

MOMENT = "uavftc-disturbance"
_ELEMENT = f"""
  <moment name="{MOMENT}" frame="BODY"><direction><x>1</x><y>0</y><z>0</z></direction></moment>
"""


def moment_name(aircraft: Aircraft) -> str:
    """Return the name of the moment that carries d2."""
    return aircraft.disturbance_moment or MOMENT


def add_moment(xml: str) -> str:
    """Return the text of an aircraft's XML with the moment added, inside its <external_reactions> or a new one."""
    bare = re.sub("<!--.*?-->", lambda comment: " " * len(comment[0]), xml, flags=re.DOTALL)  # places stay
    found = re.search(r"<external_reactions\b[^>]*?(/?)>", bare)
    if found is None:
        end = bare.rindex("</fdm_config>")
        return f"{xml[:end]}<external_reactions>{_ELEMENT}</external_reactions>\n{xml[end:]}"
    if found[1]:  # <external_reactions/>
        return f"{xml[: found.start()]}<external_reactions>{_ELEMENT}</external_reactions>{xml[found.end() :]}"
    return f"{xml[: found.end()]}{_ELEMENT}{xml[found.end() :]}"


def copy_with_moment(aircraft: Aircraft) -> Path:
    """Return the folder of a copy of the aircraft that has the moment, made at the first call."""
    cache = cache_folder("with-moment")
    base = cache / aircraft.sha256()[:32]
    folder = base / aircraft.folder.name
    if folder.is_dir():
        return folder
    partial = Path(tempfile.mkdtemp(prefix=".partial-", dir=cache))
    copy = partial / aircraft.folder.name
    shutil.copytree(aircraft.folder, copy)
    xml = copy / aircraft.xml.name
    os.chmod(xml, 0o644)
    text = xml.read_text(encoding="utf-8", errors="surrogateescape")
    xml.write_text(add_moment(text), encoding="utf-8", errors="surrogateescape")
    try:
        partial.rename(base)
    except OSError:  # another process was first
        shutil.rmtree(partial, ignore_errors=True)
    return folder
