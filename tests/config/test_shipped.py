"""Shipped files: in a checkout and in an installed package."""

from __future__ import annotations

import re
import subprocess
import sys

from uavftc.config import shipped as resources
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario


def test_the_checkout_is_read_where_it_stands():
    assert (resources.scenario_dir() / "scenario3.yaml").is_file()
    assert resources.scenario_names() == sorted(resources.scenario_names())
    assert "scenario3" in resources.scenario_names()


def test_an_installed_package_carries_its_own(tmp_path, monkeypatch):
    (tmp_path / "data" / "scenarios").mkdir(parents=True)
    (tmp_path / "data" / "scenarios" / "one.yaml").write_text("name: one\n")
    for name in ("glider", "_drafts", ".hidden"):
        (tmp_path / "data" / "aircraft" / name).mkdir(parents=True)
    monkeypatch.setattr(resources, "_PACKAGE", tmp_path)
    assert resources.scenario_names() == ["one"]
    assert resources.aircraft_names() == ["glider"]


def test_nothing_shipped_is_no_crash(tmp_path, monkeypatch):
    monkeypatch.setattr(resources, "_PACKAGE", tmp_path)
    monkeypatch.setattr(resources, "_CHECKOUT", tmp_path)
    assert resources.scenario_names() == []
    assert resources.aircraft_names() == []


def test_loading_a_scenario_needs_none_of_the_heavy_libraries():
    # a refused scenario must be reported at once, not after seconds of imports; numba is imported, because the keys
    # of a law are in the file of the law, and numba looks for scipy
    code = (
        "import sys; from uavftc.scenario.load import load_scenario; load_scenario('scenario1');"
        "print([m for m in ('scipy.linalg', 'matplotlib', 'jsbsim', 'pyarrow') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_example_of_the_reference_is_a_scenario(tmp_path):
    # documentation that does not load is worse than none
    text = (resources.scenario_dir().parent / "docs" / "scenarios.md").read_text(encoding="utf-8")
    examples = re.findall(r"```yaml\n(.*?)```", text, flags=re.S)
    assert len(examples) >= 6
    for i, example in enumerate(examples):
        path = tmp_path / f"{i}.yaml"
        path.write_text(example if example.startswith("name:") else f"name: example\nduration_s: 20\n{example}")
        load_scenario(path)


def test_every_key_is_in_the_reference():
    text = (resources.scenario_dir().parent / "docs" / "scenarios.md").read_text(encoding="utf-8")
    schema = Scenario.model_json_schema()
    keys = {key for section in (schema, *schema["$defs"].values()) for key in section.get("properties", {})}
    assert {"gyro_bias_degps", "offset_bound", "duration_s"} < keys
    assert {key for key in keys if not re.search(rf"\b{key}\b", text)} == set()
