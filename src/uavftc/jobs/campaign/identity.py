"""What a campaign is: its file, what it is made of and the versions that fly it. A resumed one must be the same."""

from __future__ import annotations

import functools
import hashlib
import json
import platform
from collections.abc import Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import uavftc
from uavftc.aircraft.definition import load_aircraft
from uavftc.control.custom.module import checksum
from uavftc.jobs.campaign.variants import Variant
from uavftc.scenario.campaign import Campaign
from uavftc.scenario.controllers import CustomController
from uavftc.scenario.load import scenario_text

FILE = "campaign.json"
_PACKAGES = ("uavftc", "jsbsim", "numpy", "scipy", "numba")
_NOT_FLOWN = ("cli", "report")  # parts of the code that no flight depends on


def identity(campaign: Campaign, variants: Sequence[Variant]) -> dict[str, Any]:
    """Return the document of `campaign.json`: everything that the rows of the table depend on."""
    said = campaign.model_dump(mode="json", by_alias=True, exclude_none=True)
    said["vary"] = [{"key": key, **rest} for key, rest in said["vary"].items()]  # their order counts
    return {
        "campaign": said,
        "campaign_sha256": hashlib.sha256(json.dumps(said).encode()).hexdigest(),
        "variants": of_variants(variants),
        "versions": versions(),
    }


def of_variants(variants: Sequence[Variant]) -> dict[str, Any]:
    """Return the checksums of the scenario, aircraft and custom controller of each variant."""
    return {" ".join(variant[:3]): _of(variant) for variant in variants}


def versions() -> dict[str, Any]:
    """Return the versions of what flies in this process, and the checksum of our code."""
    return {
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in _PACKAGES},
        "code_sha256": code_sha256(),
    }


def _of(variant: Variant) -> dict[str, Any]:
    scenario = variant.scenario
    found: dict[str, Any] = {
        "scenario_sha256": hashlib.sha256(scenario_text(scenario).encode()).hexdigest(),
        "aircraft_sha256": load_aircraft(scenario.aircraft).sha256(),
    }
    if isinstance(scenario.controller, CustomController):
        found["controller_sha256"] = checksum(scenario.controller.kind)
    return found


@functools.cache
def code_sha256() -> str:
    """Return the checksum of the code that flies."""
    package = Path(uavftc.__file__).parent
    digest = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        name = file.relative_to(package)
        if name.parts[0] not in _NOT_FLOWN:
            digest.update(name.as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def differences(before: Any, now: Any, key: str = "") -> Iterator[str]:
    """Yield what differs between two such documents, a line each: the key, what was and what is."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        names = [*before, *(name for name in now if name not in before)]
        for name in names:
            if name != "campaign_sha256":
                yield from differences(before.get(name), now.get(name), f"{key}.{name}" if key else name)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, (one, other) in enumerate(zip(before, now, strict=True)):
            yield from differences(one, other, f"{key}[{i}]")
    elif before != now:
        yield f"{key}: was {_short(before)}, is {_short(now)}"


def _short(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
