"""A flight that leaves what the aircraft's documentation trusts says so, and is otherwise the same."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from uavftc.aircraft.definition import Trusted, load_aircraft
from uavftc.core.signals import as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.trusted import TrustedRange
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.fly import fly_mission
from uavftc.scenario.load import load_scenario

FAR = ("reference={phi_deg: 0, theta_deg: 0, psi_deg: 170}", "envelope.bank_deg=180")


def rows(alpha_deg=(), airspeed=()):
    records = as_records(empty_rows(max(len(alpha_deg), len(airspeed))))
    records["t"] = np.arange(len(records)) * 0.5
    if len(alpha_deg):
        records["alpha"] = np.radians(alpha_deg)
    if len(airspeed):
        records["airspeed"] = airspeed
    return records


def test_the_furthest_value_is_told_with_its_time_and_when_it_began():
    # across chunks, and furthest from the range, not from zero: -6 deg is 4 outside [-2, 10], 13 deg is 3 outside
    watch = TrustedRange(Trusted(alpha_deg=(-2, 10)))
    watch.take(rows(alpha_deg=[0, 11, 13, 9]))
    watch.take(rows(alpha_deg=[0, -6, -5, 0]))
    (line,) = watch.remarks()
    assert "angle of attack" in line
    assert "-2 to 10 deg" in line
    assert "from t = 0.5 s on" in line
    assert "furthest -6.00 deg at t = 0.5 s" in line


def test_within_the_range_and_without_air_data_nothing_is_said():
    watch = TrustedRange(Trusted(alpha_deg=(-10, 10), airspeed_mps=(20, 45)))
    watch.take(rows(alpha_deg=[-9.999, 9.999, 0], airspeed=[20, 45, math.nan]))
    watch.take(rows()[:0])
    assert watch.remarks() == ()
    everything = TrustedRange(Trusted())
    everything.take(rows(alpha_deg=[80, 80, 80]))
    assert everything.remarks() == ()


def test_hale_trusts_what_its_readme_says():
    trusted = load_aircraft("hale").trusted
    assert trusted == Trusted(alpha_deg=(-10, 10), beta_deg=(-10, 10), airspeed_mps=(20, 45))
    readme = (load_aircraft("hale").folder / "README.md").read_text(encoding="utf-8")
    assert "within about 10° of incidence and sideslip and between 20 and 45 m/s" in " ".join(readme.split())


def test_a_flight_that_leaves_it_is_warned_of_alone_and_among_many(tmp_path: Path):
    # a reference of 170 deg of heading skids the aircraft through 33 deg of sideslip
    scenario = load_scenario("scenario1", overrides=FAR)
    alone, _ = fly_mission(scenario, tmp_path / "far", figures=False)
    lines = [line for line in alone["warnings"] if "trusts" in line]
    assert lines[0].startswith("sideslip outside what the aircraft's documentation trusts, -10 to 10 deg")
    assert "furthest -33.1" in lines[0]
    assert [line for line in fly_one(scenario).summary()["warnings"] if "trusts" in line] == lines


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
@pytest.mark.parametrize("name", ["scenario1", "scenario2", "scenario3"])
def test_the_papers_scenarios_stay_within_it(name, plant):
    assert fly_one(load_scenario(name, plant=plant), keep_history=False).remarks == ()


@pytest.mark.parametrize("value", ["[10, -10]", "10", "[1, 2, 3]", "[5, 5]"])
def test_a_range_that_is_none_is_refused(value: str, tmp_path: Path):
    folder = tmp_path / "kite"
    folder.mkdir()
    (folder / "kite.xml").write_text("<fdm_config/>")
    (folder / "uavftc.yaml").write_text(f"name: kite\ntrusted: {{alpha_deg: {value}}}\n")
    with pytest.raises(InputError) as error:
        load_aircraft(str(folder))
    assert "trusted.alpha_deg" in error.value.where
    assert "[least, greatest]" in error.value.expected
