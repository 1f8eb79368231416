"""The scenarios of a campaign in its folder, one a variant, so that any flight of it can be flown again from there.

`scenarios/<variant>.yaml` is what the cases change: the base with that controller, plant and aircraft, every default
filled in. A case is that file with its values at the varied keys, and flies alone to the same margin, to the bit.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from uavftc.jobs.campaign.variants import Variant, names_of
from uavftc.scenario.text import scenario_text, value_text

FOLDER = "scenarios"


def write_scenarios(folder: Path, variants: Sequence[Variant]) -> None:
    """Write the scenario of each variant into the folder of a campaign."""
    (folder / FOLDER).mkdir(exist_ok=True)
    for name, variant in zip(names_of(variants), variants, strict=True):
        path = folder / FOLDER / f"{name}.yaml"
        path.write_text(scenario_text(variant.scenario), encoding="utf-8", newline="\n")


def command(scenario: Path, values: Mapping[str, Any]) -> str:
    """Return the one command that flies a case alone, quoted for a POSIX shell.

    Parameters
    ----------
    scenario
        The file of its variant.
    values
        Of the varied keys.
    """
    words = ["uavftc-fly", str(scenario)]
    for key, value in values.items():
        words += ["--set", f"{key}={value_text(value)}"]
    return shlex.join(words)
