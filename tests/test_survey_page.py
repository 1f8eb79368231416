"""The page of tools/survey_aircraft.py: its two parts are written apart, and a verdict gives the numbers."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def tool():
    file = Path(__file__).parents[1] / "tools" / "survey_aircraft.py"
    spec = importlib.util.spec_from_file_location("survey_aircraft", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ONE = {"measured": {"airspeed": 20.0, "servo": ["lag 50 rad/s"]}}
GOOD = {
    "completed": True, "ended_because": None, "iae": [0.1, 0.2, None], "error_deg": [0.1, 0.19, None],
    "airspeed_change_mps": 1.0, "at_stop": {"left": 0.5},
}  # fmt: skip


def test_each_part_is_replaced_and_the_other_stays(tool):
    stock, models = f"{tool.STOCK_BEGINS}\nold\n", f"{tool.MODELS_BEGIN}\nold models\n"
    page = tool.joined("", stock, models)
    assert page == f"{stock}\n{models}"
    assert tool.joined(page, "new\n", None) == f"new\n\n{models}"
    assert tool.joined(page, None, "new models\n") == f"{stock}\nnew models\n"
    assert tool.joined(stock, stock, None) == stock


def test_a_flight_within_bounds_lacks_nothing_whatever_its_stops(tool):
    assert tool.against(ONE, GOOD, iae=0.25) == []


def test_what_is_outside_is_said_in_numbers_with_what_may_have_caused_it(tool):
    slow = GOOD | {"error_deg": [0.1, 1.4, None], "iae": [0.3, 0.2, None], "airspeed_change_mps": 5.0}
    assert tool.against(ONE, slow, iae=0.25) == [
        "pitch 1.4 deg off",
        "roll 0.30 rad s",
        "airspeed changes by 5.0 of 20 m/s",
        "left at its stop 50 % of the time",
        "servo with lag 50 rad/s",
    ]
    lost = GOOD | {"completed": False, "ended_because": "bank angle outside the envelope"}
    assert tool.against(ONE, lost, iae=None)[0] == "lost: bank angle outside the envelope"
