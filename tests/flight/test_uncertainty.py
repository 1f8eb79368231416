"""The vehicle that flies is not the one that the controller is designed for: compared with plain JSBSim."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import jsbsim
import numpy as np
import pytest

from flying import flown
from uavftc.config.shipped import aircraft_dir
from uavftc.core.signals import as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.jobs.twin import unfaulted
from uavftc.plants.jsbsim.load import inertia
from uavftc.plants.rigid_body import coefficients
from uavftc.scenario.load import load_scenario, scenario_text

HALE = aircraft_dir() / "hale"
RATES = {"rate/rotational": 4, "rate/translational": 3, "position/rotational": 5, "position/translational": 4}
INPUTS = [f"fcs/{name}-cmd-norm" for name in ("left-aileron", "right-aileron", "elevator", "rudder")]
STATE = [f"attitude/{x}-rad" for x in ("phi", "theta", "psi")] + [f"velocities/{x}-rad_sec" for x in "pqr"]
LOADS = [f"forces/fb{x}-total-lbs" for x in "xyz"] + [f"moments/{x}-total-lbsft" for x in "lmn"]
SLUG_KG = 14.593902937206363
POUNDS, IXX, IYY, IZZ, IXZ = 936.964614286, 38886.4891963, 4656.96741054, 43347.2650752, 6221.33672915  # of hale.xml
FACTORS, SHIFT = (1.2, 0.9, 1.1), (0.1, 0.02, -0.05)
UNCERTAIN = (
    "uncertainty={mass_factor: 1.1, inertia_factor: [1.2, 0.9, 1.1], cg_shift_m: [0.1, 0.02, -0.05], "
    "coefficients: {Cl_p: 1.3, aero/moment/Cm_alpha: 0.8, CD_0: 1.5}}"
)
CONTRACT = ("x1", "x2", "v2", "u2", "airspeed", "altitude", "alpha", "beta", "throttle", "d1_hat")


def plain(folder: Path, trim: dict) -> jsbsim.FGFDMExec:
    """Return plain JSBSim at the nominal trim with an XML edited by hand: other numbers in it, no point mass."""
    shutil.copytree(HALE, folder / "hale")
    file = folder / "hale" / "hale.xml"
    text = file.read_text(encoding="utf-8")
    x, y, z = SHIFT
    for old, new in (
        (f"<ixx unit=\"SLUG*FT2\">{IXX!r}<", f"<ixx unit=\"SLUG*FT2\">{1.2 * IXX!r}<"),
        (f"<iyy unit=\"SLUG*FT2\">{IYY!r}<", f"<iyy unit=\"SLUG*FT2\">{0.9 * IYY!r}<"),
        (f"<izz unit=\"SLUG*FT2\">{IZZ!r}<", f"<izz unit=\"SLUG*FT2\">{1.1 * IZZ!r}<"),
        (f"<ixz unit=\"SLUG*FT2\">{IXZ!r}<", f"<ixz unit=\"SLUG*FT2\">{(1.2 * 1.1) ** 0.5 * IXZ!r}<"),
        (f"<emptywt unit=\"LBS\">{POUNDS!r}<", f"<emptywt unit=\"LBS\">{1.1 * POUNDS!r}<"),
        ('<location name="CG" unit="M"><x>0</x><y>0</y><z>0</z>',
         f'<location name="CG" unit="M"><x>{-x!r}</x><y>{y!r}</y><z>{-z!r}</z>'),
    ):  # fmt: skip
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    for name, factor in (("moment/Cl_p", 1.3), ("moment/Cm_alpha", 0.8), ("force/CD_0", 1.5)):
        begin = text.index("<product>", text.index(f'<function name="aero/{name}">'))
        text = f"{text[:begin]}<product><value>{factor!r}</value>{text[begin + len('<product>') :]}"
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
    still = {"psi-true-rad": 0, "lat-geod-deg": 0, "long-gc-deg": 0, "terrain-elevation-ft": 0}
    for name, value in {**still, **start}.items():
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
    return fdm


def test_the_vehicle_that_flies_is_plain_jsbsim_with_another_xml(tmp_path):
    # driven by the deflections of the flight; forces and moments to 1e-9 of the largest, motion to 1e-9 rad and rad/s
    flight = build_flight(load_scenario("scenario3", overrides=[UNCERTAIN, "duration_s=6"]))
    rows = empty_rows(flight.steps + 1, flight.shape)
    records = as_records(rows, flight.shape)
    flight.inputs.fill(records, 0)
    loads = []
    for k in range(len(rows)):
        assert flight.plant.run(flight.program, rows, k, k + 1) == k + 1
        loads.append([flight.plant.fdm[name] for name in LOADS])
    fdm = plain(tmp_path, flight.model.trim)
    assert flight.plant.fdm["inertia/mass-slugs"] == pytest.approx(fdm["inertia/mass-slugs"], rel=1e-12)
    states, found = [], []
    trim = np.array([e.trim_rad for e in flight.model.effectors])
    dist = [f"external_reactions/dist/{axis}" for axis in "lmn"]
    fdm["external_reactions/dist/magnitude-lbsft"] = 1.0
    J = inertia(fdm) / 1.3558179483314004
    for k in range(len(records)):
        states.append([fdm[name] for name in STATE])
        for name, value in zip(INPUTS, trim + records["effectors"]["deflection"][k], strict=True):
            fdm[name] = value
        for name, value in zip(dist, J @ records["d2"][k], strict=True):
            fdm[name] = value
        fdm.run()
        found.append([fdm[name] for name in LOADS])
    loads, found, states = np.array(loads), np.array(found), np.array(states)
    scale = np.repeat([np.max(np.abs(loads[:, :3])), np.max(np.abs(loads[:, 3:]))], 3)
    np.testing.assert_allclose(found / scale, loads / scale, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.unwrap(states[:, :3], axis=0), records["x1"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[:, 3:], records["x2"], rtol=0, atol=1e-9)
    _, nominal, _ = flown("scenario3", "jsbsim", None, ("duration_s=6",))
    assert np.max(np.abs(nominal["x1"] - records["x1"])) > 1e-3


@pytest.mark.parametrize("aircraft", ["hale", "jsbsim:c172p"])
def test_mass_centre_and_inertia_are_those_asked_for_before_the_first_frame(aircraft):
    # the Cessna has tanks, of which JSBSim counts the inertia about the centre of gravity of the frame before
    over = [f"aircraft={aircraft}", "saturation=null"]
    fdms = [build_flight(load_scenario("scenario1", overrides=[*over, *more])).plant.fdm for more in ([], [MASSES])]
    (mass, place, J), (now_mass, now_place, now_J) = [
        (fdm["inertia/mass-slugs"] * SLUG_KG, [fdm[f"inertia/cg-{x}-in"] * 0.0254 for x in "xyz"], inertia(fdm))
        for fdm in fdms
    ]
    assert now_mass == pytest.approx(1.1 * mass, rel=1e-7)
    np.testing.assert_allclose(np.subtract(now_place, place), [-0.1, 0.02, 0.05], rtol=0, atol=1e-7)
    root = np.sqrt(FACTORS)
    np.testing.assert_allclose(now_J, J * np.outer(root, root), rtol=0, atol=1e-7 * np.max(J))
    for name, factor in zip(("ixx", "iyy", "izz"), FACTORS, strict=True):
        held = [fdm[f"inertia/{name}-slugs_ft2"] for fdm in fdms]
        assert held[1] == pytest.approx(factor * held[0], rel=1e-7)
    for _ in range(3):
        fdms[1].run()
    np.testing.assert_allclose(inertia(fdms[1]), now_J, rtol=0, atol=1e-7 * np.max(J))


MASSES = UNCERTAIN.split(", coefficients", maxsplit=1)[0] + "}"


def test_it_starts_at_the_nominal_trim_and_is_not_in_equilibrium_there():
    flight, records, _ = flown("scenario1", "jsbsim", None, ("uncertainty.mass_factor=1.1", "duration_s=2"))
    nominal, first, _ = flown("scenario1", "jsbsim", None, ("duration_s=2",))
    for name in ("x1", "x2", "airspeed", "altitude", "alpha", "throttle"):
        np.testing.assert_array_equal(records[name][0], first[name][0])
    assert flight.model == nominal.model
    # a tenth heavier with the same lift: it falls with g / 11; read at row 0, before anything has moved
    assert first["load_factor"][0][2] == pytest.approx(-1.0, rel=1e-5)
    assert records["load_factor"][0][2] == pytest.approx(first["load_factor"][0][2] / 1.1, rel=1e-12)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_the_controller_is_that_of_the_nominal_aircraft(plant):
    over = ["uncertainty.inertia_factor=1.3"] + (["uncertainty.coefficients.Cm_de=0.5"] if plant == "jsbsim" else [])
    design = [build_flight(load_scenario("scenario1", plant=plant, overrides=o)).given.design for o in ([], over)]
    for a, b in zip(*design, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_factors_of_one_change_no_bit(plant):
    ones = "{mass_factor: 1, inertia_factor: 1, cg_shift_m: [0, 0, 0], coefficients: {Cl_p: 1.0}}"
    _, nominal, _ = flown("scenario3", plant)
    flight, records, _ = flown("scenario3", plant, None, (f"uncertainty={ones}",))
    for name in CONTRACT:
        np.testing.assert_array_equal(records[name], nominal[name], err_msg=name)
    assert "uncertainty" not in flight.plant.settings


def test_on_the_analytic_plant_the_moments_stay_and_the_inertia_is_another():
    plant = build_flight(load_scenario("scenario1", plant="analytic", overrides=[INERTIA])).plant
    nominal = build_flight(load_scenario("scenario1", plant="analytic")).plant
    J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])  # hale's as printed
    now = np.diag([1.2, 0.9, 1.1]) @ np.diag(np.diag(J))
    now[0, 2] = now[2, 0] = -8435.0 * (1.2 * 1.1) ** 0.5
    for name in ("A_l", "B_m"):
        moment = J @ nominal._params[name][0]
        np.testing.assert_allclose(now @ plant._params[name][0], moment, rtol=0, atol=1e-9 * np.max(np.abs(moment)))
    np.testing.assert_allclose(plant._params["c"][0], coefficients(now), rtol=1e-12, atol=1e-12)


INERTIA = "uncertainty.inertia_factor=[1.2, 0.9, 1.1]"


def test_a_disturbance_accelerates_the_vehicle_that_flies():
    push = "disturbances=[{kind: angular-acceleration, start_s: 0.5, p_degps2: 10}]"
    change = []
    for more in ((), ("uncertainty.inertia_factor=[1.5, 1, 1]",)):
        over = ("controller.delay_s=1", "reference={}", "duration_s=1", *more)
        rates = [flown("scenario1", "jsbsim", None, (*over, with_))[1]["x2"] for with_ in (push, "disturbances=[]")]
        change.append(np.degrees(rates[0] - rates[1])[102, 0])
    assert change[0] == pytest.approx(change[1], rel=0.02)  # damping has acted for a frame
    assert change[0] > 0.05


def test_damage_strikes_the_vehicle_that_flies():
    over = ("uncertainty={mass_factor: 0.5, cg_shift_m: [0.1, 0, 0]}", "duration_s=1")
    hit = "damage=[{start_s: 0.5, mass_kg: -30, cg_m: [0.2, 0, 0]}]"
    flight, _, _ = flown("scenario1", "jsbsim", None, (*over, hit))
    fdm = flight.plant.fdm
    assert fdm["inertia/mass-slugs"] * SLUG_KG == pytest.approx(0.5 * 425 - 30, rel=1e-7)
    assert fdm["inertia/cg-x-in"] * 0.0254 == pytest.approx(-0.3, rel=1e-7)
    with pytest.raises(InputError, match="damage"):
        build_flight(load_scenario("scenario1", overrides=[*over, "damage=[{mass_kg: -300}]"]))


def test_the_twin_without_faults_keeps_it():
    scenario = load_scenario("scenario3", overrides=[UNCERTAIN])
    assert unfaulted(scenario).uncertainty == scenario.uncertainty


def test_the_scenario_as_flown_has_it(tmp_path):
    scenario = load_scenario("scenario3", overrides=[UNCERTAIN])
    file = tmp_path / "flown.yaml"
    file.write_text(scenario_text(scenario), encoding="utf-8")
    assert load_scenario(file) == scenario


def fly(arguments: list[str]) -> tuple[int, str]:
    command = [sys.executable, "-c", "from uavftc.cli.app import main_fly; main_fly()", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    return done.returncode, " ".join(done.stderr.split())


def test_the_summary_says_what_is_flown(tmp_path):
    out = tmp_path / "out"
    over = ["--set", UNCERTAIN, "--set", "duration_s=1"]
    assert fly(["scenario1", *over, "--out", str(out)])[0] == 0
    document = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    found = document["provenance"]["plant_settings"]["uncertainty"]
    assert found["mass_kg"] == pytest.approx(467.5, rel=1e-7)
    assert found["cg_shift_m"] == [0.1, 0.02, -0.05]
    assert np.diag(found["inertia_kgm2"]) == pytest.approx(np.multiply(FACTORS, [52723.0, 6314.0, 58771.0]), rel=1e-7)
    assert found["factors"] == {"aero/moment/Cl_p": 1.3, "aero/moment/Cm_alpha": 0.8, "aero/force/CD_0": 1.5}
    (line,) = [text for text in document["warnings"] if text.startswith("uncertainty: ")]
    assert "mass x 1.1 (467.5 kg); inertia x 1.2, 0.9, 1.1" in line
    assert "aero/moment/Cl_p x 1.3" in line


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (["uncertainty.coefficients.Clp=1.3"], ["'Clp'", "one of left-aileron, ", "did you mean Cl_p?"]),
        (["uncertainty.coefficients={Cl_p: 1, aero/moment/Cl_p: 2}"], ["which is Cl_p again"]),
        (["uncertainty.coefficients.Cl_p=.inf"], ["uncertainty.coefficients.Cl_p"]),
        (["uncertainty.mass_factor=0"], ["uncertainty.mass_factor", "greater than 0"]),
        (["uncertainty.mass_factor=-1"], ["uncertainty.mass_factor", "greater than 0"]),
        (["uncertainty.mass_factor=1e-12"], ["a mass of 4.25018e-10 kg"]),
        (["uncertainty.inertia_factor=[1, 0, 1]"], ["uncertainty.inertia_factor[1]"]),
        (["uncertainty.cg_shift_m=1"], ["a list of three"]),
        (["uncertainty.cg_shift_m=[1e300, 0, 0]"], ["uncertainty.cg_shift_m[0]"]),
        (["uncertainty.mass=2"], ["mass_factor"]),
        (["aircraft=jsbsim:c172p", "uncertainty.inertia_factor=[1, 1, 2]"], ["the greatest above the sum"]),
        (["plant=analytic", "uncertainty.mass_factor=1.1"], ["the rotational model has no mass"]),
        (["plant=analytic", "uncertainty.cg_shift_m=[0, 0, 1]"], ["has no centre of gravity"]),
        (["plant=analytic", "uncertainty.coefficients.Cl_p=2"], ["has no aerodynamic functions"]),
    ],
)  # fmt: skip
def test_what_cannot_be_flown_is_refused(overrides, said):
    with pytest.raises(InputError) as error:
        build_flight(load_scenario("scenario1", overrides=overrides))
    for part in said:
        assert part in str(error.value)


def test_a_refusal_ends_with_exit_code_2_and_nothing_written(tmp_path):
    out = tmp_path / "out"
    code, text = fly(["scenario1", "--set", "uncertainty.coefficients.Clp=1.3", "--out", str(out)])
    assert code == 2
    assert not out.exists()
    assert "key uncertainty.coefficients.Clp" in text
    assert "did you mean Cl_p?" in text
    assert "Traceback" not in text


def hale_with(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    folder = tmp_path / "hale"
    shutil.copytree(HALE, folder)
    file = folder / "hale.xml"
    text = file.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")
    return folder


def test_a_name_that_ours_begin_with_is_refused(tmp_path):
    folder = hale_with(tmp_path, ("</fdm_config>", "<!-- uavftc-uncertainty --></fdm_config>"))
    with pytest.raises(InputError, match="uavftc-uncertainty"):
        build_flight(load_scenario("scenario1", overrides=[f"aircraft={folder}", "uncertainty.mass_factor=2"]))


def test_an_ambiguous_name_is_refused_with_the_whole_ones(tmp_path):
    folder = hale_with(tmp_path, ('name="aero/moment/Cm_q"', 'name="aero/other/Cl_p"'))
    over = [f"aircraft={folder}", "uncertainty.coefficients.Cl_p=2"]
    with pytest.raises(InputError) as error:
        build_flight(load_scenario("scenario1", overrides=over))
    assert "aero/moment/Cl_p, aero/other/Cl_p" in str(error.value)
