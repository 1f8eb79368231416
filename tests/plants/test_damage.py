"""Mass properties and forces of a damaged vehicle, compared with sums by hand, and what is refused."""

from __future__ import annotations

import shutil
from itertools import pairwise

import numpy as np
import pytest

from flying import HALE, bare, deflected, flown, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft
from uavftc.core.program import Program
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim.damage import told
from uavftc.plants.jsbsim.events import Schedule as Events
from uavftc.plants.jsbsim.load import inertia, initialised
from uavftc.plants.mass import at_a_time, damaged, impossible, piece_of, points_of
from uavftc.plants.schedule import Schedule, Struck, row_at
from uavftc.scenario.damage import Damage, outer_part
from uavftc.scenario.load import load_scenario

LB_KG = 0.45359237  # exact
JSBSIM_LB_SLUG = 32.174049  # lb per slug, JSBSim's own g
SLUG_KG = 4.4482216152605 / 0.3048
J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])  # hale's
LOSS = Damage.model_validate(
    {
        "start_s": 0.1, "end_s": 0.2, "mass_kg": -30, "cg_m": [0.2, 0.5, 0.05],
        "inertia_kgm2": {
            "ixx_kgm2": -2000, "iyy_kgm2": -500, "izz_kgm2": -2500, "ixy_kgm2": -60, "ixz_kgm2": 40, "iyz_kgm2": 100
        },
    }
)  # fmt: skip
DJ = np.array([[-2000.0, 60.0, -40.0], [60.0, -500.0, -100.0], [-40.0, -100.0, -2500.0]])  # matrix signs


def mass_of(fdm) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, kg, centre of gravity, m, body axes from the structural origin, and inertia, kg m^2."""
    cg = np.array([-fdm["inertia/cg-x-in"], fdm["inertia/cg-y-in"], -fdm["inertia/cg-z-in"]]) * 0.0254
    return fdm["inertia/mass-slugs"] * SLUG_KG, cg, inertia(fdm)


def about(J_own: np.ndarray, mass: float, r: np.ndarray) -> np.ndarray:
    """Return an inertia about a point that is r away from the body's own centre of gravity: parallel axes."""
    return J_own + mass * (np.dot(r, r) * np.eye(3) - np.outer(r, r))


def plant_of(*entries: Damage, rate_hz: float = 200.0, substeps: int = 1):
    struck = [
        Struck(e, row_at(e.start_s, rate_hz), None if e.end_s is None else row_at(e.end_s, rate_hz)) for e in entries
    ]
    return jsbsim_plant(
        load_aircraft("hale"), Timing(1.0 / rate_hz, substeps), told=[told(load_aircraft("hale"), struck, J)]
    )


def test_points_have_the_mass_and_moments_of_the_piece():
    piece = piece_of(LOSS, 425.0)
    masses, places = points_of(piece, 7.3)
    assert np.sum(masses) == pytest.approx(-30.0, rel=1e-12)
    np.testing.assert_allclose(masses @ places, 395.0 * np.array(LOSS.cg_m), rtol=1e-12)
    np.testing.assert_allclose((places.T * masses) @ places, piece.second, atol=1e-9)


def test_mass_centre_and_inertia_in_jsbsim_are_those_asked_for():
    # the change of J is about the centre of gravity, which has moved
    plant = plant_of(LOSS)
    rows = deflected(61, [0.0, 0.0, 0.0], HALE)
    program, fdm = bare(plant), plant.fdm
    before = mass_of(fdm)
    assert before[0] == pytest.approx(425.0, rel=2e-8)  # JSBSim's g
    plant.run(program, rows, 0, 20)
    assert mass_of(fdm)[0] == before[0]
    plant.run(program, rows, 20, 21)  # the row at 0.1 s
    mass, cg, after = mass_of(fdm)
    assert mass == pytest.approx(395.0, rel=1e-7)
    np.testing.assert_allclose(cg - before[1], LOSS.cg_m, rtol=1e-7)
    np.testing.assert_allclose(after, J + DJ, rtol=1e-7, atol=1e-3)  # 1e-3 of 6e4
    plant.run(program, rows, 21, 40)
    np.testing.assert_array_equal(mass_of(fdm)[2], after)
    plant.run(program, rows, 40, 61)  # and back, to the bit
    assert mass_of(fdm)[0] == before[0]
    np.testing.assert_array_equal(mass_of(fdm)[1], before[1])
    np.testing.assert_array_equal(mass_of(fdm)[2], before[2])


def test_two_pieces_at_a_time_add_up_as_two_bodies_do():
    # by parallel axes, body by body: the remainder of each alone is known, so each piece is; both are taken away
    other = Damage.model_validate(
        {"mass_kg": -12.0, "cg_m": [0.19, 0, 0.04], "inertia_kgm2": {"iyy_kgm2": -600, "izz_kgm2": -570}}
    )
    plant = plant_of(LOSS, other)
    rows = deflected(25, [0.0, 0.0, 0.0], HALE)
    start = mass_of(plant.fdm)
    plant.run(bare(plant), rows, 0, 25)
    mass, cg, found = mass_of(plant.fdm)
    total, first, second = start[0], np.zeros(3), start[2]  # about the undamaged centre
    for entry, dJ in ((LOSS, DJ), (other, np.diag([0.0, -600.0, -570.0]))):
        left, shift = start[0] + entry.mass_kg, np.array(entry.cg_m)
        total += entry.mass_kg
        first = first + left * shift
        second = second + about(start[2] + dJ, left, shift) - start[2]
    expected = about(second, -total, first / total)
    assert mass == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(cg - start[1], first / total, rtol=1e-9)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-5)


def test_a_point_mass_weighs_by_jsbsims_own_g():
    plant = plant_of(Damage(mass_kg=-10.0))
    assert plant.fdm["inertia/weight-lbs"] == pytest.approx(plant.fdm["inertia/mass-slugs"] * JSBSIM_LB_SLUG, rel=1e-14)
    plant.run(bare(plant), deflected(1, [0.0, 0.0, 0.0], HALE), 0, 1)
    assert plant.fdm["inertia/weight-lbs"] == pytest.approx(936.964614286 - 10.0 / LB_KG, rel=2e-8)


def test_the_centre_of_gravity_keeps_its_velocity_when_it_moves():
    # w x s is not added: the new centre of gravity has the velocity of the old one, turning or not
    turning = deflected(40, [0.05, 0.0, 0.0], HALE)
    plants = [plant_of(), plant_of(Damage(start_s=0.1, mass_kg=-30.0, cg_m=[0.2, 0.5, 0.05]))]
    seen = []
    for plant in plants:
        plant.run(bare(plant), turning.copy(), 0, 21)
        seen.append([plant.fdm[f"velocities/{v}"] for v in ("u-fps", "v-fps", "w-fps", "p-rad_sec")])
    assert seen[0] == seen[1]
    assert abs(seen[0][3]) > 1e-2
    assert plants[1].fdm["inertia/cg-y-in"] == pytest.approx(0.5 / 0.0254, rel=1e-7)


def test_an_aircraft_with_point_masses_of_its_own_keeps_them():
    # those of a damage come behind them
    aircraft = load_aircraft("jsbsim:c172p")
    bare_fdm = initialised(aircraft, 0.005)
    own = [bare_fdm[f"inertia/pointmass-weight-lbs[{i}]"] for i in range(3)]
    assert max(own) > 0.0
    struck = [Struck(LOSS, 0, None)]
    of_damage = told(aircraft, struck, np.array(mass_of(bare_fdm)[2]))
    fdm = initialised(aircraft, 0.005, of_damage.additions)
    before = mass_of(fdm)
    Events(fdm, of_damage.at_start(fdm)).write(0)
    fdm.run()
    fdm.run()  # JSBSim counts tanks about the centre of gravity of the frame before
    assert [fdm[f"inertia/pointmass-weight-lbs[{i}]"] for i in range(3)] == own
    mass, cg, after = mass_of(fdm)
    assert mass == pytest.approx(before[0] - 30.0, rel=1e-12)
    np.testing.assert_allclose(cg - before[1], LOSS.cg_m, rtol=1e-9)
    np.testing.assert_allclose(after, before[2] + DJ, rtol=1e-9, atol=1e-6)


# --- forces ---------------------------------------------------------------------------------------------------------


def external(*entries: Damage, row: int = 1, **options) -> tuple[np.ndarray, np.ndarray, object]:
    """Return force, N, moment, N m, in body axes, of what a damage adds, and the FDM."""
    plant = plant_of(*entries)
    plant.run(bare(plant), deflected(row, [0.0, 0.0, 0.0], HALE), 0, row)
    fdm = plant.fdm
    force = np.array([fdm[f"forces/fb{axis}-external-lbs"] for axis in "xyz"]) * 4.4482216152605
    moment = np.array([fdm[f"moments/{axis}-external-lbsft"] for axis in "lmn"]) * 1.3558179483314004
    return force, moment, fdm


def test_lost_lift_acts_at_its_place_on_the_span():
    force, moment, fdm = external(
        Damage.model_validate({"lift_lost": {"side": "left", "fraction": 0.1, "span_position": 0.8}})
    )
    weight = 425.0 * fdm["accelerations/gravity-ft_sec2"] * 0.3048  # level at alpha = 0: the lift
    assert force[2] == pytest.approx(0.05 * weight, rel=1e-6)
    assert moment[0] == pytest.approx(-20.0 * force[2], rel=1e-8)  # the left wing falls
    assert abs(force[0]) < 1e-6 * force[2]


def test_lift_is_lost_at_the_centre_of_the_outer_part():
    # of an elliptic lift, by quadrature
    for eta in (0.0, 0.3, 0.75, 0.95):
        y = np.linspace(eta, 1.0, 400_001)
        lift = np.sqrt(1.0 - y**2)
        share = np.trapezoid(lift, y) * 4.0 / np.pi
        assert outer_part(share) == pytest.approx(np.trapezoid(lift * y, y) / np.trapezoid(lift, y), rel=1e-6)


def test_drag_force_and_moment_are_those_written():
    force, moment, fdm = external(Damage(drag_area_m2=0.2, drag_at_m=[0, -20, 0]))
    q = fdm["aero/qbar-psf"] * 47.88025898033584  # lb/ft^2 in Pa, exact by ft and lb
    assert q == pytest.approx(500.25, rel=1e-4)
    drag = -0.2 * q  # against the airspeed, which is in the x axis to 1e-10 rad at this trim
    np.testing.assert_allclose(force, [drag, 0.0, 0.0], rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(moment, [0.0, 0.0, 20.0 * drag], rtol=1e-9, atol=1e-6)  # nose left
    force, moment, _ = external(
        Damage(force_n=[0, 10, 5], force_area_m2=[0, 0.1, 0], force_at_m=[-6, 0, -1], moment_nm=[1, 2, 3])
    )
    f = np.array([0.0, 10.0 + 0.1 * q, 5.0])
    np.testing.assert_allclose(force, f, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(moment, np.add(np.cross([-6.0, 0.0, -1.0], f), [1.0, 2.0, 3.0]), rtol=1e-9)


def test_places_are_from_the_undamaged_centre_of_gravity_and_arms_from_the_new_one():
    _, moment, _ = external(Damage(mass_kg=-20.0, cg_m=[0.5, 0, 0], force_n=[0, 0, 100.0], force_at_m=[-6, 0, 0]))
    assert moment[1] == pytest.approx(6.5 * 100.0, rel=1e-7)


@pytest.mark.parametrize(
    ("name", "state", "length"),
    [
        ("Cl_beta", "beta", 50.0), ("Cm_alpha", "alpha", 1.634), ("Cn_p", "p", 50.0), ("Cm_q", "q", 1.634),
        ("Cn_r", "r", 50.0), ("Cm_0", "", 1.634),
    ],
)  # fmt: skip
def test_a_coefficient_makes_its_moment(name, state, length):
    # after half a second of rolling, in body axes: J is hale's, so all states are other than zero
    rows = deflected(100, [0.02, 0.05, 0.02], HALE)
    plant = plant_of(Damage.model_validate({"coefficients": {name: 0.3}}))
    plant.run(bare(plant), rows, 0, 100)
    fdm = plant.fdm
    V = fdm["velocities/vt-fps"] * 0.3048
    value = {
        "": lambda: 1.0,
        "alpha": lambda: fdm["aero/alpha-rad"],
        "beta": lambda: fdm["aero/beta-rad"],
        **{rate: lambda rate=rate: fdm[f"velocities/{rate}-aero-rad_sec"] * length / (2.0 * V) for rate in "pqr"},
    }[state]()
    assert value != 0.0
    q = fdm["aero/qbar-psf"] * 47.88025898033584
    moment = fdm[f"moments/{name[1]}-external-lbsft"] * 1.3558179483314004
    assert moment == pytest.approx(0.3 * value * q * 80.0 * length, rel=1e-6)


@pytest.mark.parametrize(("name", "axis", "sign"), [("CD_0", 0, -1), ("CY_0", 1, 1), ("CL_0", 2, -1)])
def test_a_force_coefficient_acts_in_wind_axes_at_the_reference_point(name, axis, sign):
    force, moment, fdm = external(Damage.model_validate({"coefficients": {name: 0.02}}))
    q = fdm["aero/qbar-psf"] * 47.88025898033584
    assert force[axis] == pytest.approx(sign * 0.02 * q * 80.0, rel=1e-6)  # alpha = beta = 0
    np.testing.assert_allclose(moment, 0.0, atol=1e-6)


# --- when -----------------------------------------------------------------------------------------------------------


def test_a_schedule_acts_between_rows_and_leaves_the_others_in_one_piece():
    pieces, done = [], []
    schedule = Schedule([(5, lambda: done.append(("on", len(pieces)))), (9, lambda: done.append(("off", len(pieces))))])

    def fly(_program, _rows, first, last):
        pieces.append((first, last))
        return last

    rows = np.zeros((8, 1))
    assert schedule.fly(fly, Program([]), rows, 0, 8) == 8  # rows 0 to 7 of the flight
    assert schedule.fly(fly, Program([]), rows, 0, 8) == 8  # rows 8 to 15, in a chunk of their own
    assert pieces == [(0, 5), (5, 8), (0, 1), (1, 8)]
    assert done == [("on", 1), ("off", 3)]


@pytest.mark.parametrize("rate", [200.0, 30.0, 1000.0, 7.3])
def test_a_window_begins_at_the_row_that_the_other_windows_begin_at(rate):
    times = np.arange(5000) / rate
    for start in (0.0, 0.1, 1.0, 1.1, 2.0 / 3.0, times[137], np.nextafter(times[137], 10.0)):
        assert row_at(start, rate) == int(np.searchsorted(times, start))


def test_a_window_between_two_samples_does_nothing():
    scenario = load_scenario("scenario1", overrides=["damage=[{start_s: 0.001, end_s: 0.004, mass_kg: -30}]"])
    flight = build_flight(scenario)
    assert flight.plant._events.row == np.inf


@pytest.mark.parametrize("substeps", [1, 3])
def test_the_pieces_in_which_it_is_flown_do_not_matter(substeps):
    entries = (LOSS, Damage(start_s=0.15, moment_nm=[30, 0, 0]))
    rows = [deflected(61, [0.01, 0.0, 0.005], HALE) for _ in range(2)]
    for given, ends in zip(rows, ([0, 61], [0, 1, 19, 20, 21, 33, 61]), strict=True):
        plant = plant_of(*entries, substeps=substeps)
        program = bare(plant)
        for first, last in pairwise(ends):
            assert plant.run(program, given, first, last) == last
    np.testing.assert_array_equal(*rows)


def test_what_acts_together_is_known_at_each_time():
    entries = [
        Damage(start_s=0, end_s=4, mass_kg=-1),
        Damage(start_s=2, mass_kg=-1),
        Damage(start_s=3, end_s=4, mass_kg=-1),
    ]
    assert at_a_time(entries) == [(0, [0]), (2, [0, 1]), (3, [0, 1, 2]), (4, [1])]


# --- refused --------------------------------------------------------------------------------------------------------


def refusal(*overrides: str, scenario: str = "scenario1", **options) -> str:
    with pytest.raises(InputError) as error:
        build_flight(load_scenario(scenario, overrides=list(overrides), **options))
    return str(error.value)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ("{mass_kg: -425.1}", "a mass of -0.1"),
        ("{mass_kg: -425}", "a mass of "),
        ("{inertia_kgm2: {iyy_kgm2: -6314}}", "principal moments of inertia of "),
        ("{inertia_kgm2: {ixy_kgm2: 20000}}", "principal moments of inertia of -"),
    ],
)
def test_what_is_no_rigid_body_is_refused(damage, said):
    text = refusal(f"damage=[{damage}]")
    assert "damage[0]" in text
    assert said in text


def test_two_damages_that_together_leave_nothing_are_refused_with_their_time():
    one = "{start_s: 0, end_s: 6, mass_kg: -300}, {start_s: 5, end_s: 7, mass_kg: -200}"
    text = refusal(f"damage=[{one}]")
    assert "damage[1]" in text
    assert "from 5 s with damage[0]" in text
    after = load_scenario(
        "scenario1", overrides=[f"damage=[{one.replace('start_s: 5', 'start_s: 6')}]", "duration_s=1"]
    )
    build_flight(after)  # one after the other they can be flown


def test_the_triangle_inequality_holds_where_the_aircraft_keeps_it():
    # 3 + 4 < 8 is no body; hale as the paper prints it is none either (46,786 + 6,314 < 64,708), and is not asked
    box = np.diag([3.0, 4.0, 6.0])
    entry = Damage.model_validate({"inertia_kgm2": {"izz_kgm2": 2.0}})
    text = impossible(1.0, box, [piece_of(entry, 1.0)])
    assert text is not None
    assert "the greatest above the sum" in text
    assert impossible(1.0, box, [piece_of(Damage.model_validate({"inertia_kgm2": {"izz_kgm2": 0.9}}), 1.0)]) is None
    principal = np.linalg.eigvalsh(J)
    assert principal[0] + principal[1] < principal[2]
    assert impossible(425.0, J, [piece_of(LOSS, 425.0)]) is None


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ("{}", "changes nothing"),
        ("{start_s: 2}", "changes nothing"),
        ("{coefficients: {Cx_beta: 1}}", "one of D Y L l m n"),
        ("{control_power: {rudder: 1.5}}", "at most 1"),
        ("{lift_lost: {side: top, fraction: 0.1}}", "one of left, right"),
        ("{lift_lost: {side: left, fraction: 0}}", "greater than 0"),
        ("{cg_m: 3, mass_kg: -1}", "[forward, right, down]"),
        ("{mass: -3}", "did you mean mass_kg?"),
        ("{control_power: {left_ailleron: 0}}", "did you mean left_aileron?"),
        ("{start_s: 3, end_s: 3, mass_kg: -1}", "after start_s"),
    ],
)
def test_what_is_written_wrong_is_refused_at_its_key(damage, said):
    text = refusal(f"damage=[{damage}]")
    assert said in text
    assert "damage[0]" in text


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        ("{mass_kg: -10}", "no mass"),
        ("{cg_m: [0.1, 0, 0]}", "no centre of gravity"),
        ("{lift_lost: {side: left, fraction: 0.1}}", "no forces"),
        ("{coefficients: {Cn_beta: -0.02}}", "no dynamic pressure"),
        ("{moment_nm: [1, 0, 0]}", "angular-acceleration"),
        ("{inertia_kgm2: {ixy_kgm2: 5}}", "plane of symmetry"),
    ],
)
def test_the_analytic_plant_refuses_what_it_does_not_represent(damage, said):
    text = refusal(f"damage=[{damage}]", plant="analytic")
    assert said in text
    assert "control_power and inertia_kgm2" in text


def hale_with(tmp_path, old: str, new: str) -> str:
    """Return a hale with its XML changed."""
    folder = tmp_path / "hale"
    shutil.copytree(load_aircraft("hale").folder, folder)
    xml = folder / "hale.xml"
    text = xml.read_text(encoding="utf-8")
    assert old in text
    xml.write_text(text.replace(old, new), encoding="utf-8")
    return str(folder)


def test_an_aircraft_with_a_name_of_ours_is_refused(tmp_path):
    folder = hale_with(tmp_path, '<moment name="dist"', '<!-- uavftc-damage --><moment name="dist"')
    with pytest.raises(InputError, match="the name uavftc-damage"):
        told(load_aircraft(folder), [Struck(LOSS, 0, None)], J)


def test_an_aircraft_with_its_masses_in_another_file_is_damaged_as_any(tmp_path):
    # a point mass of its own there has another index than in the main file, and keeps its weight
    text = (load_aircraft("hale").folder / "hale.xml").read_text(encoding="utf-8")
    section = text[text.index("<mass_balance") : text.index("</mass_balance>")]
    folder = hale_with(tmp_path, f"{section}</mass_balance>", '<mass_balance file="masses"/>')
    own = '<pointmass name="own"><weight unit="LBS">7</weight><location unit="IN"><x>9</x><y>0</y><z>0</z></location>'
    other = f'<?xml version="1.0"?>\n{section}{own}</pointmass></mass_balance>'
    (tmp_path / "hale" / "masses.xml").write_text(other, encoding="utf-8")
    companion = tmp_path / "hale" / "uavftc.yaml"
    claimed = companion.read_text(encoding="utf-8")
    begin, end = claimed.index("mass_properties:"), claimed.index("effectors:")
    companion.write_text(claimed[:begin] + claimed[end:], encoding="utf-8")
    aircraft = load_aircraft(folder)
    of_damage = told(aircraft, [Struck(LOSS, 0, None)], J)
    fdm = initialised(aircraft, 0.005, of_damage.additions)
    before = mass_of(fdm)
    Events(fdm, of_damage.at_start(fdm)).write(0)
    fdm.run()
    mass, cg, after = mass_of(fdm)
    weights = [fdm[f"inertia/pointmass-weight-lbs[{i}]"] for i in range(8)]
    assert weights.count(7.0) == 1
    assert mass == pytest.approx(before[0] - 30.0, rel=1e-12)
    np.testing.assert_allclose(cg - before[1], LOSS.cg_m, rtol=1e-9)
    np.testing.assert_allclose(after, before[2] + DJ, rtol=1e-9, atol=1e-6)


# --- the analytic plant ---------------------------------------------------------------------------------------------


def test_the_analytic_plant_flies_with_another_inertia():
    # moments stay and J is another: one step of Runge-Kutta against Euler's equation, differenced
    over = ("duration_s=0.5", "simulation.substeps=20")
    entry = (
        "{start_s: 0.2, end_s: 0.3, inertia_kgm2: {ixx_kgm2: -5000, iyy_kgm2: -600, izz_kgm2: -5500, ixz_kgm2: -500}}"
    )
    flight, records, _ = flown("scenario1", "analytic", None, (*over, f"damage=[{entry}]"))
    _, undamaged, _ = flown("scenario1", "analytic", None, over)
    aircraft = flight.aircraft
    A, B = np.array(aircraft.analytic.A_l), np.array(aircraft.analytic.B_m)
    new = J + np.array([[-5000.0, 0.0, 500.0], [0.0, -600.0, 0.0], [500.0, 0.0, -5500.0]])
    before = records["t"] <= 0.2
    np.testing.assert_array_equal(records["x2"][before], undamaged["x2"][before])

    def rate(J_now, x2, u2):
        return np.linalg.solve(J_now, J @ (A @ x2 + B @ u2) - np.cross(x2, J_now @ x2))

    for t, J_now in ((0.25, new), (0.35, J)):
        k = round(t * 200)
        x2, u2, h = records["x2"][k].copy(), records["u2"][k], 1.0 / 200 / 200
        for _ in range(200):  # Euler's rule, midpoint
            x2 = x2 + h * rate(J_now, x2 + 0.5 * h * rate(J_now, x2, u2), u2)
        np.testing.assert_allclose(records["x2"][k + 1], x2, rtol=0, atol=1e-9)
    assert np.max(np.abs(records["x2"] - undamaged["x2"])) > 5e-5


def test_the_sum_of_pieces_is_the_body_asked_for():
    body = damaged(425.0, J, [piece_of(LOSS, 425.0)])
    assert body.mass == 395.0
    np.testing.assert_allclose(body.cg, LOSS.cg_m, rtol=1e-14)
    np.testing.assert_allclose(body.inertia, J + DJ, rtol=1e-12)
