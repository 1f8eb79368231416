"""Damage in flight: the shipped cases compared with plain JSBSim, driven without this package."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

import jsbsim
import numpy as np
import pytest

from flying import flown
from uavftc.config.shipped import aircraft_dir, scenario_dir
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.numerical import Tape, replay
from uavftc.scenario.load import load_scenario, scenario_text
from uavftc.scenario.schema import Scenario

HALE = aircraft_dir() / "hale"
ALL = sorted(path.stem for path in (scenario_dir() / "damage").glob("*.yaml"))
CASES = [case for case in ALL if not case.endswith("-c172p")]
RATES = {"rate/rotational": 4, "rate/translational": 3, "position/rotational": 5, "position/translational": 4}
INPUTS = [f"fcs/{name}-cmd-norm" for name in ("left-aileron", "right-aileron", "elevator", "rudder")]
STATE = [f"attitude/{x}-rad" for x in ("phi", "theta", "psi")] + [f"velocities/{x}-rad_sec" for x in "pqr"]
LOADS = [f"forces/fb{x}-total-lbs" for x in "xyz"] + [f"moments/{x}-total-lbsft" for x in "lmn"]
SLUG_KG = 14.593902937206363
MASS = 936.964614286 / 32.174049 * SLUG_KG  # kg, hale's weight by JSBSim's own g: 1.4e-8 less than 425
OVER = ("damage[0].start_s=1", "duration_s=4")
D = 10.0  # m, arm of the dumb-bells below


def dumb_bells(entry, mass: float) -> tuple[np.ndarray, np.ndarray]:
    """Return point masses, kg, and their places, m, body axes, that change a vehicle's mass properties as asked.

    Not as the package makes them: a pair along each axis for a square, four in each plane for a product, a pair along
    each axis for the centre of gravity, and one in the middle for the mass.
    """
    e = entry.inertia_kgm2
    left, s = mass + entry.mass_kg, np.array(entry.cg_m)
    squares = 0.5 * np.array([
        e.iyy_kgm2 + e.izz_kgm2 - e.ixx_kgm2, e.ixx_kgm2 + e.izz_kgm2 - e.iyy_kgm2, e.ixx_kgm2 + e.iyy_kgm2 - e.izz_kgm2
    ]) + left * s**2  # fmt: skip
    products = {(0, 1): e.ixy_kgm2, (0, 2): e.ixz_kgm2, (1, 2): e.iyz_kgm2}
    axes, found = np.eye(3), []
    for i in range(3):
        found += [(squares[i] / (2 * D**2), sign * D * axes[i]) for sign in (1, -1)]
        found += [(sign * left * s[i] / (2 * D), sign * D * axes[i]) for sign in (1, -1)]
    for (i, j), product in products.items():
        m = (product + left * s[i] * s[j]) / (4 * D**2)
        found += [(a * b * m, D * (a * axes[i] + b * axes[j])) for a in (1, -1) for b in (1, -1)]
    found.append((entry.mass_kg - sum(m for m, _ in found), np.zeros(3)))
    return np.array([m for m, _ in found]), np.array([r for _, r in found])


def text_of_forces(entry) -> str:
    """Return the lost lift and the coefficients as external reactions of hale, by hand: S = 80, b = 50, c = 1.634 m."""
    switch = "<property>test/on</property>"
    out = []

    def reaction(kind: str, frame: str, direction: tuple[int, int, int], body: str, y: float = 0.0) -> None:
        at = f'<location unit="M"><x>0</x><y>{y!r}</y><z>0</z></location>' if kind == "force" else ""
        x, y_, z = direction
        towards = f"<direction><x>{x}</x><y>{y_}</y><z>{z}</z></direction>"
        function = f"<function><product>{switch}{body}</product></function>"
        out.append(f'<{kind} name="test-{len(out)}" frame="{frame}">{at}{towards}{function}</{kind}>')

    if entry.lift_lost:
        side = -1.0 if entry.lift_lost.side == "left" else 1.0
        # hale's lift, in lb: q S (CL_0 + CL_alpha alpha)
        lift = (
            "<property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>"
            "<sum><value>0.104143099427</value><product><value>5.83765</value><property>aero/alpha-rad</property>"
            f"</product></sum><value>{entry.lift_lost.fraction / 2!r}</value>"
        )
        reaction("force", "WIND", (0, 0, 1), lift, side * entry.lift_lost.span_position * 25.0)
    wind = {"D": (-1, 0, 0), "Y": (0, 1, 0), "L": (0, 0, -1)}
    body = {"l": (1, 0, 0), "m": (0, 1, 0), "n": (0, 0, 1)}
    for name, value in entry.coefficients.items():
        axis, of = name[1], name[3:]
        terms = f"<value>{value!r}</value><property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>"
        if axis in body:
            terms += f"<property>metrics/{'cbarw' if axis == 'm' else 'bw'}-ft</property>"
        if of in ("alpha", "beta"):
            terms += f"<property>aero/{of}-rad</property>"
        else:
            span = "cbarw" if of == "q" else "bw"
            terms += f"<property>velocities/{of}-aero-rad_sec</property><property>metrics/{span}-ft</property>"
            terms += "<quotient><value>0.5</value><property>velocities/vt-fps</property></quotient>"
        if axis in wind:
            reaction("force", "WIND", wind[axis], terms)
        else:
            reaction("moment", "BODY", body[axis], terms)
    return "".join(out)


def plain(folder: Path, entry, trim: dict) -> tuple[jsbsim.FGFDMExec, list[tuple[str, float]]]:
    """Return plain JSBSim with hale at its trim, and what to write when the damage begins."""
    masses, places = dumb_bells(entry, MASS)
    points = "".join(
        f'<pointmass name="m{i}"><weight unit="LBS">0</weight><location unit="M">'
        f"<x>{-x!r}</x><y>{y!r}</y><z>{-z!r}</z></location></pointmass>"
        for i, (x, y, z) in enumerate(places.tolist())
    )
    shutil.copytree(HALE, folder / "hale")
    file = folder / "hale" / "hale.xml"
    text = file.read_text(encoding="utf-8")
    text = text.replace("</mass_balance>", f"{points}</mass_balance>")
    text = text.replace("<external_reactions>", f"<external_reactions>{text_of_forces(entry)}")
    switch = '<system name="test"><property value="0">test/on</property></system>'
    text = text.replace('<system file="hale_autothrottle"/>', f'{switch}<system file="hale_autothrottle"/>')
    file.write_text(text, encoding="utf-8")
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.set_aircraft_path(str(folder))
    fdm.set_engine_path(str(folder / "hale" / "engine"))
    fdm.set_systems_path(str(folder / "hale" / "systems"))
    fdm.set_dt(0.005)
    assert fdm.load_model("hale")
    fdm.load_planet(str(folder / "hale" / "flat_planet.xml"), False)
    for name in RATES:
        fdm[f"simulation/integrator/{name}"] = 0
    start = {"vt-fps": 30 / 0.3048, "h-sl-ft": 1000 / 0.3048, "alpha-rad": trim["alpha"], "theta-rad": trim["alpha"]}
    for name, value in {
        "psi-true-rad": 0,
        "lat-geod-deg": 0,
        "long-gc-deg": 0,
        "terrain-elevation-ft": 0,
        **start,
    }.items():
        fdm[f"ic/{name}"] = value
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["fcs/throttle-cmd-norm[0]"] = fdm["fcs/throttle-cmd-norm[1]"] = trim["throttle"]
    fdm["fcs/elevator-cmd-norm"] = trim["surfaces"][2]
    fdm["ap/vt-set-fps"] = 30 / 0.3048
    for _ in range(1000):
        fdm.run()
    fdm["ap/at-on"] = 1
    for name, code in RATES.items():
        fdm[f"simulation/integrator/{name}"] = code
    pounds = masses / SLUG_KG * 32.174049  # by JSBSim's own g
    return fdm, [*((f"inertia/pointmass-weight-lbs[{i}]", w) for i, w in enumerate(pounds.tolist())), ("test/on", 1.0)]


def loads_of(case: str) -> tuple[object, np.ndarray, np.ndarray]:
    """Fly a case row by row; return the flight, its rows, and JSBSim's total forces and moments behind each row."""
    flight = build_flight(load_scenario(f"damage/{case}", overrides=list(OVER)))
    rows = empty_rows(flight.steps + 1, flight.shape)
    records = as_records(rows, flight.shape)
    flight.inputs.fill(records, 0)
    loads = []
    for k in range(len(rows)):
        assert flight.plant.run(flight.program, rows, k, k + 1) == k + 1
        loads.append([flight.plant.fdm[name] for name in LOADS])
    return flight, records, np.array(loads)


@pytest.mark.parametrize("case", CASES)
def test_each_case_has_the_forces_and_moments_of_plain_jsbsim(case, tmp_path):
    # driven by the deflections of the flight, with masses and forces of another making: 1e-9 of the largest
    flight, records, loads = loads_of(case)
    (entry,) = flight.scenario.damage
    fdm, begins = plain(tmp_path, entry, flight.model.trim)
    trim = np.array([e.trim_rad for e in flight.model.effectors])
    states, found = [], []
    for k in range(len(records)):
        states.append([fdm[name] for name in STATE])
        if k == 200:
            for name, value in begins:
                fdm[name] = value
        for name, value in zip(INPUTS, trim + records["effectors"]["deflection"][k], strict=True):
            fdm[name] = value
        fdm.run()
        found.append([fdm[name] for name in LOADS])
    scale = np.repeat([np.max(np.abs(loads[:, :3])), np.max(np.abs(loads[:, 3:]))], 3)
    np.testing.assert_allclose(np.array(found) / scale, loads / scale, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.unwrap(np.array(states)[:, :3], axis=0), records["x1"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.array(states)[:, 3:], records["x2"], rtol=0, atol=1e-9)
    assert np.max(np.abs(loads[210:] - loads[199])) > 1.0  # the damage did something


def test_there_are_six_cases():
    assert CASES == [
        "fin-off", "left-elevator-off", "left-flap-off", "left-stabiliser-off", "left-wing-tip-off", "rudder-off"
    ]  # fmt: skip
    assert sorted(set(ALL) - set(CASES)) == [f"{case}-c172p" for case in CASES]


@pytest.mark.parametrize("case", CASES)
def test_each_case_is_flown(case):
    flight, records, outcome = flown(f"damage/{case}")
    if case == "fin-off":  # neither stable nor controlled in yaw: it turns until the airspeed is lost
        assert outcome.ended_because is not None
        assert "airspeed" in outcome.ended_because
        return
    assert outcome.completed
    error = np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1]
    if case == "rudder-off":
        assert error[2] > 1.0  # no yaw control
    else:
        assert np.max(error) < 0.1
    assert flight.scenario.damage[0].label.startswith("loss of ")


@pytest.mark.parametrize("case", CASES)
def test_each_case_is_flown_on_a_stock_aircraft(case):
    # without its fin it turns away from the wind at once; without its rudder it holds all but the heading
    flight, records, outcome = flown(f"damage/{case}-c172p")
    error = np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1]
    if case == "fin-off":
        assert outcome.ended_because is not None
        assert "ended by attitude outside the envelope" in outcome.ended_because
        return
    assert outcome.completed
    if case == "rudder-off":
        assert error[2] > 1.0
    else:
        assert np.max(error) < 0.15
    mass = flight.plant.fdm["inertia/mass-slugs"] * SLUG_KG
    lost = flight.scenario.damage[0].mass_kg / (1880 * 0.45359237)
    gtm = {"rudder-off": 0.13, "left-flap-off": 0.09, "left-wing-tip-off": 0.81, "left-elevator-off": 0.07}
    assert lost == pytest.approx(-gtm.get(case, 0.59) / (57.75 - 2 * 5.74), rel=1e-5)  # the share of the source
    fuel = 1880 * 0.45359237 * (1 + lost) - mass  # burnt; 12 s at some 8 gallons an hour are 0.07 kg
    assert 0.0 <= fuel < 0.2


@pytest.mark.parametrize("case", CASES)
def test_the_flight_before_the_damage_is_the_undamaged_one_to_the_bit(case):
    _, records, _ = flown(f"damage/{case}", "jsbsim", None, OVER)
    _, undamaged, _ = flown(f"damage/{case}", "jsbsim", None, ("damage=[]", "duration_s=4"))
    before = records["t"] < 1.0
    for name in ("x1", "x2", "airspeed", "altitude", "alpha", "beta", "throttle", "v2", "u2", "d1_hat"):
        np.testing.assert_array_equal(records[name][before], undamaged[name][before], err_msg=name)
    assert not np.array_equal(records["x2"], undamaged["x2"])


J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])  # kg m^2, hale's as printed


def mass_properties(fdm: jsbsim.FGFDMExec) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, kg, centre of gravity, m, body axes from the structural origin, and the matrix J, kg m^2."""
    place = np.array([-fdm["inertia/cg-x-in"], fdm["inertia/cg-y-in"], -fdm["inertia/cg-z-in"]]) * 0.0254
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # the binding returns a numpy.matrix
        found = np.array(fdm.get_mass_balance().get_J())
    return fdm["inertia/mass-slugs"] * SLUG_KG, place, found * SLUG_KG * 0.3048**2


@pytest.mark.parametrize("case", CASES)
def test_each_case_has_the_mass_properties_that_its_file_says(case):
    # by hand, from the numbers of the file, to 1e-7: the mass by JSBSim's g, J of its largest moment
    (entry,) = load_scenario(f"damage/{case}").damage
    flight, _, _ = flown(f"damage/{case}", "jsbsim", None, OVER)
    undamaged, _, _ = flown(f"damage/{case}", "jsbsim", None, ("damage=[]", "duration_s=4"))
    mass, place, found = mass_properties(flight.plant.fdm)
    e = entry.inertia_kgm2
    change = np.diag([e.ixx_kgm2, e.iyy_kgm2, e.izz_kgm2])
    for (i, j), product in {(0, 1): e.ixy_kgm2, (0, 2): e.ixz_kgm2, (1, 2): e.iyz_kgm2}.items():
        change[i, j] = change[j, i] = -product
    assert mass == pytest.approx(MASS + entry.mass_kg, rel=1e-7)
    np.testing.assert_allclose(place - mass_properties(undamaged.plant.fdm)[1], entry.cg_m, rtol=0, atol=1e-7)
    np.testing.assert_allclose(found, J + change, rtol=0, atol=1e-7 * J[2, 2])


def test_mass_properties_come_back_at_the_end_of_the_window():
    over = ("damage[0].start_s=1", "damage[0].end_s=2", "duration_s=3")
    flight, _, _ = flown("damage/left-wing-tip-off", "jsbsim", None, over)
    undamaged, _, _ = flown("damage/left-wing-tip-off", "jsbsim", None, ("damage=[]", "duration_s=3"))
    for name in ("mass-slugs", "cg-x-in", "cg-y-in", "ixx-slugs_ft2", "ixy-slugs_ft2"):
        assert flight.plant.fdm[f"inertia/{name}"] == undamaged.plant.fdm[f"inertia/{name}"]
    assert flight.plant.fdm["forces/fbz-external-lbs"] == 0.0


def test_a_slice_or_a_chunk_does_not_move_a_window():
    # 256 rows are flown at a time; a window from row 250 to row 520 spans two ends of slices
    over = ("duration_s=4", "damage=[{start_s: 1.25, end_s: 2.6, moment_nm: [500, 0, 0]}]")
    flight, records, _ = flown("scenario1", "jsbsim", None, over)
    again = build_flight(load_scenario("scenario1", overrides=list(over)))
    rows = empty_rows(flight.steps + 1, flight.shape)
    again.inputs.fill(as_records(rows, flight.shape), 0)
    for k in range(len(rows)):
        again.plant.run(again.program, rows, k, k + 1)
    for name in ("x1", "x2", "u2"):
        np.testing.assert_array_equal(as_records(rows, flight.shape)[name], records[name])
    _, undamaged, _ = flown("scenario1", "jsbsim", None, ("duration_s=4",))
    first = int(np.argmax(np.any(records["x2"] != undamaged["x2"], axis=1)))
    assert first == 252  # written before the frame from row 250; the rates move a frame later


def test_a_lost_flight_is_replayed_with_its_damage():
    # with the same deflections it is lost again because of the damage, and without the damage it is not
    over = ["duration_s=10", "damage=[{start_s: 1, moment_nm: [400000, 0, 0]}]"]
    flight = build_flight(load_scenario("scenario1", overrides=over))
    records, outcome = fly_to_memory(flight)
    assert not outcome.completed
    assert not outcome.numerical
    tape = Tape(flight)
    tape.take(records)
    rows = len(records) - 1
    assert all(replay(flight, tape, rows, n, None) is True for n in (1, 2, 4))
    object.__setattr__(flight, "scenario", flight.scenario.model_copy(update={"damage": ()}))
    assert replay(flight, tape, rows, 1, None) is False


def test_the_scenario_as_flown_has_the_damage(tmp_path):
    scenario = load_scenario("damage/left-wing-tip-off")
    file = tmp_path / "as-flown.yaml"
    file.write_text(scenario_text(scenario), encoding="utf-8")
    assert load_scenario(file) == scenario


def test_a_damage_has_a_label():
    made = Scenario.model_validate(
        {
            "name": "x", "duration_s": 1,
            "damage": [{"mass_kg": -3, "control_power": {"rudder": 0.5}}, {"name": "bird strike", "mass_kg": -1}],
        }
    )  # fmt: skip
    assert [entry.label for entry in made.damage] == ["-3 kg, rudder 50 %", "bird strike"]


def test_the_shipped_cases_are_what_their_script_writes():
    import subprocess
    import sys

    tool = Path(__file__).parents[2] / "tools" / "damage_cases.py"
    done = subprocess.run([sys.executable, str(tool), "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
