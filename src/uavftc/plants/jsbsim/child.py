"""The child process that measures an aircraft and prints its trimmed models; some aircraft crash the process."""

from __future__ import annotations

import json
import os
import sys

from uavftc.aircraft.definition import load_aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.measure import models_of
from uavftc.plants.jsbsim.model import NoTrimError, read, with_step, written
from uavftc.plants.jsbsim.step_check import check


def main(reference: str, altitude: str, *speeds: str) -> None:
    """Measure and print one JSON document: the models at the speeds that trim, or the nearest refusal.

    With `step` for the altitude: the step check of the model that is on standard input.
    """
    try:
        aircraft = load_aircraft(reference)
        if altitude == "step":
            print(json.dumps({"step": check(aircraft, read(json.load(sys.stdin))), "lasting": True}))
        else:
            models = models_of(aircraft, tuple(map(float, speeds)), float(altitude))
            if len(speeds) == 1:  # of many, only the one that is flown is checked, by `stepped`
                models = [with_step(m, check(aircraft, m)) for m in models]
            print(json.dumps({"models": [written(m) for m in models], "lasting": True}))
    except InputError as error:
        fields = {key: getattr(error, key) for key in ("where", "found", "expected", "remedy")}
        # a load error names the path, and another file with the same content has another path
        print(json.dumps({"error": fields, "lasting": isinstance(error, NoTrimError)}))
    sys.stdout.flush()
    os._exit(0)  # some aircraft crash JSBSim as it is taken down


if __name__ == "__main__":
    main(*sys.argv[1:])
