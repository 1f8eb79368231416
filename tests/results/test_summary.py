"""summary.json keeps the published shape, never holds a NaN, and imports no plant to find its version."""

from __future__ import annotations

import json
import platform
import subprocess
import sys

import numpy as np
import pytest

import uavftc
from uavftc.analysis.metrics import METRICS
from uavftc.results.summary import provenance, summary, write_json

FIGURES = dict.fromkeys((metric.name for metric in METRICS), 0.5)


def document(**changes):
    arguments = {
        "scenario": "scenario3",
        "aircraft": "hale",
        "plant": "jsbsim",
        "controller": "nndondi-l1",
        "completed": True,
        "ended_because": None,
        "axes": {axis: FIGURES for axis in ("yaw", "pitch", "roll")},
        "timing": {"flight_wall_s": 0.2, "controller_steps": 4000, "us_per_controller_step": 50.0},
        "provenance": provenance(seed=0, scenario_sha256="ab", aircraft_sha256="cd"),
    }
    return summary(**(arguments | changes))


def test_every_published_key_is_there_and_in_its_order():
    published = {
        "": "scenario aircraft plant controller completed ended_because axes timing provenance",
        "axes": "roll pitch yaw",
        "timing": "flight_wall_s controller_steps us_per_controller_step",
        "provenance": "uavftc jsbsim numpy python seed scenario_sha256 aircraft_sha256",
    }
    made = document()
    for part, keys in published.items():
        have = list(made[part] if part else made)
        assert [key for key in have if key in keys.split()] == keys.split(), part
    assert list(made["axes"]["roll"]) == [
        "steady_state_error_deg", "convergence_time_s", "iae", "ise", "itae", "itse", "control_activity_rad"
    ]  # fmt: skip


def test_what_does_not_apply_is_null_and_numpy_numbers_are_plain(tmp_path):
    roll = FIGURES | {"convergence_time_s": None, "steady_state_error_deg": np.float64("nan"), "iae": np.float32(0.25)}
    made = document(
        completed=np.bool_(False),
        ended_because="ground contact",
        ended_at_s=np.float64(3.5),
        axes={"roll": roll, "pitch": FIGURES | {"ise": float("inf")}, "yaw": FIGURES},
        timing={"flight_wall_s": np.float64(1.0), "controller_steps": np.int64(700), "us_per_controller_step": 1.0},
    )
    write_json(tmp_path / "summary.json", made)
    back = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert back["axes"]["roll"]["convergence_time_s"] is None
    assert back["axes"]["roll"]["steady_state_error_deg"] is None
    assert back["axes"]["roll"]["iae"] == 0.25
    assert back["axes"]["pitch"]["ise"] is None
    assert back["completed"] is False
    assert back["ended_at_s"] == 3.5
    assert back["timing"]["controller_steps"] == 700


def test_a_missing_figure_is_noticed_before_anything_is_written():
    short = {key: value for key, value in FIGURES.items() if key != "itse"}
    with pytest.raises(KeyError, match="itse"):
        document(axes={"roll": short, "pitch": FIGURES, "yaw": FIGURES})


def test_json_refuses_nan_and_leaves_no_file(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "x.json", {"a": float("nan")})
    assert not (tmp_path / "x.json").exists()


def test_json_text_is_stable_utf8_and_ends_with_a_newline(tmp_path):
    write_json(tmp_path / "x.json", {"b": 1, "a": {"φ": None}})
    assert (tmp_path / "x.json").read_bytes() == '{\n  "b": 1,\n  "a": {\n    "φ": null\n  }\n}\n'.encode()


def test_provenance_names_the_installed_versions_and_takes_more():
    made = provenance(seed=3, scenario_sha256="ab", aircraft_sha256=None, plant_settings={"rate_hz": 400})
    assert made["numpy"] == np.__version__
    assert made["uavftc"] == uavftc.__version__
    assert made["python"] == platform.python_version()
    assert made["seed"] == 3
    assert made["plant_settings"] == {"rate_hz": 400}


def test_provenance_imports_none_of_what_it_names():
    code = (
        "import sys; from uavftc.results.summary import provenance;"
        "provenance(seed=0, scenario_sha256='', aircraft_sha256='');"
        "print(sorted({'jsbsim', 'numba', 'matplotlib', 'pyarrow'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
