"""Write scenarios/damage/*.yaml: the six damage cases of NASA's GTM design simulation, in kind, on hale and a c172p.

    python tools/damage_cases.py            # write them, and the tables of docs/damage.md
    python tools/damage_cases.py --check    # exit code 1 if they are not what this script writes

Source: github.com/nasa/GTM_DesignSim, gtm_design/config/DamageModels_T2.m and AC_baseparams_T2.m: for each case the
surfaces without effect and the changes of weight, centre of gravity and inertia, of a jet transport model of 5.5 %.

Scaled by mass and length: masses by the aircraft's over the model's without its fuel, lengths along and up by the arm
of the fin (hale's 6.5 m over that of the model, from its case 2), lengths across by the span for pieces of the wing and
by the arm for pieces of the tail. All by the span, the fin would be 24 m aft and hold more than hale's whole pitch
inertia. Second moments S = tr(J)/2 I - J scale by mass and two lengths.

The source's aerodynamic tables are of another shape and are not used: what aerodynamics a piece takes with it follows
from the geometry and the coefficients of the aircraft, below.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np

from uavftc.plants.mass import inertia_of, second_moments
from uavftc.scenario.damage import outer_part

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "scenarios" / "damage"
PAGE = ROOT / "docs" / "damage.md"

LB_KG, FT_M, SLUGFT2_KGM2 = 0.45359237, 0.3048, 1.3558179483314004
GTM_MASS = (57.75 - 2 * 5.74) * LB_KG  # kg, gross weight less the fuel of two tanks
GTM_SPAN = 6.8488 * FT_M  # m

FLAP = 0.3  # share of fin or tailplane that is rudder or elevator; usual


class Vehicle(NamedTuple):
    """An aircraft to which the cases are scaled."""

    name: str
    suffix: str
    """Of its files."""
    keys: tuple[str, ...]
    """Lines of its scenarios next to those of every case."""
    on: str
    """Behind the title in a description."""
    start_s: float
    duration_s: float
    mass: float
    """kg."""
    span: float
    """m."""
    arm: float
    """Of fin and tailplane, m."""
    half_tail: float
    """Where the lift of one half of the tailplane acts, to the side, m."""
    taper: float
    """Of the wing, tip over root."""
    fin: dict[str, float]
    """What the fin gives."""
    tail: dict[str, float]
    """What the tailplane gives."""
    Cl_p: float
    """Roll damping of the wing."""
    Cl_beta: float
    """Its dihedral effect."""
    aileron: dict[str, float]
    """Control power without the left aileron."""
    notes: dict[str, tuple[str, ...]]
    """What is said of a case on this aircraft."""


def hale() -> Vehicle:
    """Return hale: aircraft/hale/README.md has its geometry and where its coefficients are from."""
    span, area, chord, arm = 50.0, 80.0, 1.634, 6.5  # m, m^2, m, m
    fin = {"CY_beta": -0.202323452297, "Cn_beta": 0.0263020487986}  # all of hale's is the fin's
    fin["Cn_r"] = 2.0 * fin["CY_beta"] * (arm / span) ** 2
    downwash = 1.0 - 2.0 * 5.83765 / (math.pi * span**2 / area)  # 1 - d eps/d alpha, elliptic wing
    slope, tail_area = 4.53, 7.0  # 1/rad and m^2, of hale's tailplane
    tail = {
        "CL_alpha": slope * downwash * tail_area / area,
        "Cm_alpha": -slope * downwash * tail_area * arm / (area * chord),
        "Cm_q": -2.0 * slope * tail_area * arm**2 / (area * chord**2),
    }
    notes = {
        "fin-off": ("All of the fin's CY_beta, Cn_beta and Cn_r is gone; hale has no other Cn_beta, so none is left.",),
        "left-flap-off": ("hale has no flaps: what is lost is",),
        "left-elevator-off": ("hale has one elevator, of which half is gone.",),
    }
    return Vehicle(
        "hale", "", (), "", 5, 20, 425.0, span, arm, 1.1, 0.597, fin, tail, -0.5, -0.0866758431808,
        {"left_aileron": 0.0}, notes,
    )  # fmt: skip


def c172p() -> Vehicle:
    """Return JSBSim's c172p: metrics and coefficients of its XML, mass with pilot and fuel.

    Its yaw damping is taken as all the fin's and its pitch damping as all the tailplane's, both at one arm; Cm_alphadot
    over Cm_q is d eps/d alpha.
    """
    span, chord, arm = 35.8 * FT_M, 4.9 * FT_M, 15.7 * FT_M
    Cn_r, Cm_q, Cm_adot = -0.0937, -12.4, -7.27
    CY_beta = Cn_r / (2.0 * (arm / span) ** 2)
    fin = {"CY_beta": CY_beta, "Cn_beta": -CY_beta * arm / span, "Cn_r": Cn_r}
    Cm_alpha = Cm_q * chord / (2.0 * arm) * (1.0 - Cm_adot / Cm_q)
    tail = {"CL_alpha": -Cm_alpha * chord / arm, "Cm_alpha": Cm_alpha, "Cm_q": Cm_q}
    of_fin = "The fin's share is taken from Cn_r, as if that were all the fin's, at the arm of the tailplane."
    notes = {
        "rudder-off": (of_fin,),
        "fin-off": (
            "All of the fin's CY_beta, Cn_beta and Cn_r is gone. " + of_fin,
            f"Its Cn_beta of {fin['Cn_beta']:.3f} is more than the {0.0205 / 0.349:.3f} of the whole aircraft: what is "
            "left turns away from the wind.",
        ),
        "left-flap-off": ("Its flaps are up, so what is lost is",),
        "left-elevator-off": ("JSBSim's c172p has one elevator, of which half is gone.",),
    }
    return Vehicle(
        "c172p", "-c172p", ("aircraft: jsbsim:c172p",), " on a c172p", 3, 12, 1880.0 * LB_KG, span, arm,
        1.1 / 6.5 * arm, 0.69, fin, tail, -0.484, -0.0322 / 0.349, {"aileron": 0.5}, notes,
    )  # fmt: skip


class Case(NamedTuple):
    """One case as the source has it, and what an aircraft loses of its aerodynamics."""

    file: str
    title: str
    weight: float
    """lb."""
    cg: tuple[float, float, float]
    """in, forward, right, down."""
    inertia: tuple[float, float, float, float, float, float]
    """slug ft^2: xx, yy, zz, xz, yz, xy; products as integrals."""
    wing: bool
    """Whether it is a piece of the wing."""
    control_power: dict[str, float]
    coefficients: dict[str, float]
    lift_lost: dict[str, Any] | None
    why: tuple[str, ...]
    """Where the aerodynamics come from, in lines."""


def lost(whole: dict[str, float], share: float) -> dict[str, float]:
    """Return the increments that take a share of coefficients away."""
    return {name: -share * value for name, value in whole.items()}


def outer(power: int, taper: float, eta: float = 0.75) -> float:
    """Return the share of the integral of c(y) y^power over a half wing that lies outside eta of the half span."""

    def up_to(x: float) -> float:
        return x ** (power + 1) / (power + 1) - (1.0 - taper) * x ** (power + 2) / (power + 2)

    return 1.0 - up_to(eta) / up_to(1.0)


def elliptic(eta: float = 0.75) -> float:
    """Return the share of an elliptic lift that a half wing carries outside eta."""
    x = math.asin(eta)
    return 1.0 - (2.0 * x + math.sin(2.0 * x)) / math.pi


def tail_lost(of: Vehicle, share: float) -> dict[str, float]:
    """Return what goes with a share of the tailplane on its left, with the roll that its lift made about the x axis."""
    return lost(of.tail, share) | {"Cl_alpha": -share * of.tail["CL_alpha"] * of.half_tail / of.span}


def cases(of: Vehicle) -> list[Case]:
    """Return the six cases on an aircraft."""
    flap_chord, flap_span, flap_place = 0.25, 0.2, 0.51
    ailerons = "half of the ailerons" if "aileron" in of.aileron else "the left aileron"
    found = [
        Case(
            "rudder-off", "loss of the rudder",
            -0.13, (0.126, 0.0, 0.028), (-0.00346, -0.06698, -0.06352, -0.01409, 0.00001, 0.00003), False,
            {"rudder": 0.0}, lost(of.fin, FLAP), None,
            (f"The rudder is {FLAP:g} of the fin's area: that share of the fin's CY_beta, Cn_beta and Cn_r is gone.",
             *of.notes.get("rudder-off", ())),
        ),
        Case(
            "fin-off", "loss of the vertical fin",
            -1.31, (1.166, 0.0, 0.277), (-0.03507, -0.57604, -0.54102, -0.13113, 0.00006, 0.00024), False,
            {"rudder": 0.0}, lost(of.fin, 1.0), None, of.notes["fin-off"],
        ),
        Case(
            "left-flap-off", "loss of the left outboard flap",
            -0.09, (0.014, 0.041, 0.001), (-0.01018, -0.00120, -0.01137, -0.00009, -0.00027, -0.00347), True,
            {}, {}, {"side": "left", "fraction": flap_chord * flap_span, "span_position": flap_place},
            (
                *of.notes["left-flap-off"],
                f"{flap_chord:g} of the chord over {flap_span:g} of the half span,",
                f"and as much of the lift there, {flap_place:g} of the way to the tip, where the source's flap is.",
            ),
        ),
        Case(
            "left-wing-tip-off", "loss of the outer quarter of the left wing",
            -0.81, (0.148, 0.628, 0.032), (-0.25821, -0.01727, -0.27400, -0.00295, -0.01346, -0.05998), True,
            of.aileron,
            {"Cl_p": -0.5 * outer(2, of.taper) * of.Cl_p, "Cl_beta": -0.5 * outer(1, of.taper) * of.Cl_beta},
            {"side": "left", "fraction": elliptic(), "span_position": outer_part(elliptic())},
            (
                f"An elliptic lift has {elliptic():.3f} of one side's outside 3/4 of the half span. Of the left half's",
                f"roll damping, by strips, {outer(2, of.taper):.3f} is gone, of its dihedral effect "
                f"{outer(1, of.taper):.3f}, and {ailerons}.",
            ),
        ),
        Case(
            "left-elevator-off", "loss of the left elevator",
            -0.07, (0.065, 0.010, 0.004), (-0.00097, -0.03391, -0.03467, -0.00188, -0.00029, -0.00510), False,
            {"elevator": 0.5}, tail_lost(of, FLAP / 2.0), None,
            (
                *of.notes["left-elevator-off"],
                f"It is {FLAP:g} of the tailplane: half of that share of",
                "the tail's CL_alpha, Cm_alpha and Cm_q goes with it, and the roll by its lift",
                f"{of.half_tail:.1f} m to the left.",
            ),
        ),
        Case(
            "left-stabiliser-off", "loss of the left stabiliser",
            -0.59, (0.553, 0.088, 0.032), (-0.00918, -0.27315, -0.28049, -0.01559, -0.00265, -0.04370), False,
            {"elevator": 0.5}, tail_lost(of, 0.5), None,
            (
                "Half of the tailplane is gone: half of the tail's CL_alpha, Cm_alpha and Cm_q, the roll by its lift",
                f"{of.half_tail:.1f} m to the left, and half of the elevator.",
            ),
        ),
    ]  # fmt: skip
    return [case._replace(file=case.file + of.suffix) for case in found]


def arm_of_the_source() -> float:
    """Return how far aft of the centre of gravity the source's fin is, m."""
    fin = cases(hale())[1]
    return (GTM_MASS / LB_KG + fin.weight) * fin.cg[0] / -fin.weight * FT_M / 12.0


class Scaled(NamedTuple):
    """Mass properties of a case on an aircraft."""

    mass: float
    cg: np.ndarray
    inertia: np.ndarray
    """Matrix signs."""
    place: np.ndarray
    """Where what is lost had its centre, m."""


def scaled(case: Case, of: Vehicle) -> Scaled:
    """Return a case's change of mass, kg, centre of gravity, m, and inertia, kg m^2, scaled to an aircraft."""
    masses, along = of.mass / GTM_MASS, of.arm / arm_of_the_source()
    L = np.diag([along, of.span / GTM_SPAN if case.wing else along, along])
    xx, yy, zz, xz, yz, xy = np.array(case.inertia) * SLUGFT2_KGM2
    J = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
    mass, cg = masses * case.weight * LB_KG, L @ np.array(case.cg) * FT_M / 12.0
    place = (of.mass + mass) * cg / mass
    return Scaled(mass, cg, inertia_of(masses * L @ second_moments(J) @ L), place)


def number(value: float) -> str:
    """Return a number of a file, six digits."""
    return f"{value + 0.0:.6g}"


def flow(values: dict[str, float]) -> str:
    """Return a map on one line."""
    return "{" + ", ".join(f"{k}: {v if isinstance(v, str) else number(v)}" for k, v in values.items()) + "}"


def scenario(case: Case, of: Vehicle) -> str:
    """Return the text of a case's scenario file."""
    new = scaled(case, of)
    J = new.inertia
    moments = dict(zip(("ixx_kgm2", "iyy_kgm2", "izz_kgm2"), np.diag(J), strict=True))
    products = {"ixy_kgm2": -J[0, 1], "ixz_kgm2": -J[0, 2], "iyz_kgm2": -J[1, 2]}
    x, y, z = new.place
    across = "the span" if case.wing else "the fin's arm"
    lines = [
        "# Written by tools/damage_cases.py: change that script, not this file. docs/damage.md says how it is scaled.",
        "# Mass, centre of gravity and inertia: those of NASA's GTM design simulation (gtm_design, DamageModels_T2.m),",
        f"# masses by that of the aircraft, lengths along and up by the fin's arm, across by {across}.",
        f"# So the piece is {-new.mass:.3g} kg at {x:.2f} m forward, {y:.2f} m right and {z:.2f} m down of the centre "
        "of gravity.",
        *(f"# {line}" for line in wrap(" ".join(case.why), 116)),
        f"name: {case.file}",
        f"description: {case.title[0].upper()}{case.title[1:]} at {of.start_s:g} s{of.on}, the paper's step of 5 deg "
        "on each axis.",
        f"duration_s: {of.duration_s:g}",
        *of.keys,
        "reference: {phi_deg: 5, theta_deg: 5, psi_deg: 5}",
        "damage:",
        f"  - name: {case.title}",
        f"    start_s: {of.start_s:g}",
        f"    mass_kg: {number(new.mass)}",
        f"    cg_m: [{', '.join(map(number, new.cg))}]",
        "    inertia_kgm2:",
        *(f"      {key}: {number(value)}" for key, value in (moments | products).items()),
    ]
    if case.lift_lost:
        lines.append(f"    lift_lost: {flow(case.lift_lost)}")
    if case.coefficients:
        lines.append(f"    coefficients: {flow(case.coefficients)}")
    if case.control_power:
        lines.append(f"    control_power: {flow(case.control_power)}")
    return "\n".join(lines) + "\n"


def table(of: Vehicle) -> str:
    """Return the table of docs/damage.md of an aircraft."""
    lines = [
        "| file | lost | mass, kg | centre of gravity, m | ixx, iyy, izz, kg m² | ixy, ixz, iyz, kg m² "
        "| control power |",
        "|---|---|---|---|---|---|---|",
    ]
    for case in cases(of):
        new, J = scaled(case, of), scaled(case, of).inertia
        cg = ", ".join(f"{v + 0.0:.4f}" for v in new.cg)
        moments = ", ".join(f"{v:.4g}" for v in np.diag(J))
        products = ", ".join(f"{-v + 0.0:.3g}" for v in (J[0, 1], J[0, 2], J[1, 2]))
        power = ", ".join(f"{n} {100 * v:g} %" for n, v in case.control_power.items()) or "-"
        what = case.title.removeprefix("loss of ")
        lines.append(f"| `{case.file}` | {what} | {new.mass:.3f} | {cg} | {moments} | {products} | {power} |")
    return "\n".join(lines)


def written() -> dict[Path, str]:
    """Return the text of each file."""
    page, files = PAGE.read_text(encoding="utf-8"), {}
    for of in (hale(), c172p()):
        begin, end = f"<!-- cases of {of.name}: written by tools/damage_cases.py -->\n", "\n<!-- end of cases -->"
        head, rest = page.split(begin)
        page = head + begin + table(of) + rest[rest.index(end) :]
        files |= {FOLDER / f"{case.file}.yaml": scenario(case, of) for case in cases(of)}
    return {**files, PAGE: page}


def main() -> int:
    """Write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    stale = [p for p, text in written().items() if not p.is_file() or p.read_text(encoding="utf-8") != text]
    for path in stale:
        print(f"{path.relative_to(ROOT)} is {'not what this script writes' if check else 'written'}")
        if not check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(written()[path], encoding="utf-8")
    return int(check and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
