"""Write the JSBSim aircraft in aircraft/hale from the figures the paper prints and the geometry chosen here.

    python tools/hale_aircraft.py            write the XML files and the coefficient table of the README
    python tools/hale_aircraft.py --check    write nothing; fail if the files on disk differ from what would be written

Source "paper": Zhou, Liu, Li, Liu, Actuators 2025, 14(9), 437, section 4.  The paper prints the mass properties, the
wing dimensions and the control matrix B_m, and no aerodynamic coefficient.  Everything else is derived here from the
theory named on its line, or chosen with the reason on its line.  SI units and radians, unless a suffix says otherwise.

The script reads nothing but this file and runs in three steps: the inputs, the coefficients computed from them
(`coefficients`), and the XML they are written into.
"""

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from xml.sax.saxutils import escape

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "aircraft" / "hale"
PLANET = ROOT / "src" / "uavftc" / "plants" / "jsbsim" / "flat_planet.xml"  # of the aircraft that name none

# ----------------------------------------------------------------------------------------- the paper, section 4
MASS = 425.0  # kg
J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])  # kg m^2, so Ixz = +8435
WING_AREA = 80.0  # m^2
SPAN = 50.0  # m
CHORD = 1.634  # m, the mean aerodynamic chord c_A
AIRSPEED = 30.0  # m/s
ALTITUDE = 1000.0  # m
B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])  # 1/s^2 per rad: x2' = ... + g2 u, g2 = B_m

# -------------------------------------------------------------------------- flat, non-rotating planet, constant gravity
PLANET_RADIUS = 6.371e8  # m; a hundred Earth radii: 1 km of height changes gravity by 3 parts in a million
GRAVITY = 9.80665  # m/s^2, standard gravity
PLANET_GM = GRAVITY * PLANET_RADIUS**2  # m^3/s^2; standard gravity at the surface

# ------------------------------------------------------------------------------------------- chosen: wing and tail
DIHEDRAL = math.radians(4.0)  # effective, bent wing included; below 3.5 deg the spiral mode is unstable (see README.md)
TAIL_ARM = 6.5  # m, centre of gravity to both tails; gives the tail volumes below with booms an eighth of the span long
HTAIL_AREA = 7.0  # m^2; volume coefficient 0.35, the low end of 0.35 to 0.5 that sailplanes have
HTAIL_ASPECT_RATIO = 6.0  # usual for a sailplane's tailplane (4 to 7)
FIN_AREA = 5.5  # m^2, one fin or two halves; volume coefficient 0.009, small because the span is long
FIN_ASPECT_RATIO = 2.4  # effective, end-plate effect of the boom and the tailplane included (1.5 to 3)
STATIC_MARGIN = 0.09  # of the chord; 0.05 to 0.15 is usual
SECTION_LIFT_SLOPE = 2.0 * math.pi  # per rad; thin-airfoil theory
CD0 = 0.010  # a clean sailplane at 3 million Reynolds (0.008 to 0.013), on the wing area
CL_P = -0.5  # per rad; between the lifting line's -0.77 and the paper's A_m, -0.27; see README.md

# ------------------------------------------------------------------------------------------- chosen: power and rest
MOTOR_POWER = 25000.0  # W each; 3.4 times what level flight takes: full throttle climbs at 11 deg, the paper asks for 5
MOTOR_Y = 5.0  # m outboard, on the line through the centre of gravity: thrust gives no pitching moment
PROP_DIAMETER = 2.0  # m; level flight at 844 rpm, J = 1.07, efficiency 0.84
PROP_INERTIA = 0.5  # kg m^2; two blades of 0.75 kg as slender rods: m (D/2)^2 / 3 each, without spinner
PROP_TABLE = (  # J, C_T, C_P: a fixed-pitch two-blade propeller, pitch over diameter near 1.3; peak efficiency 0.86
    (0.0, 0.1300, 0.0950),  # static figure of merit 0.39: the inner blade is stalled
    (0.5, 0.1050, 0.0950),
    (1.0, 0.0650, 0.0800),
    (1.5, 0.0100, 0.0300),
    (2.0, -0.0500, -0.0300),  # windmilling
)
SURFACE_STOP = math.radians(25.0)  # mechanical stop, a usual plain-flap travel; the paper's limits are far inside it

# ------------------------------------------------------------------------------------------ units: JSBSim's own factors
FT = 0.3048  # m, exact
LB = 0.45359237  # kg, exact
SLUG_FT2 = 1.3558179483314004  # kg m^2; JSBSim's KG*M2 factor is 9e-5 off, so inertias are written in SLUG*FT2


def standard_density(altitude: float) -> float:
    """Density, kg/m^3, at a geometric altitude, m, in the troposphere; constants of JSBSim's FGStandardAtmosphere."""
    gas_constant = 8.31432 / 28.9645e-3  # J/(kg K)
    lapse = (518.67 - 389.97) / 1.8 / (36089.2388 * FT)  # K/m, first interval of its temperature table
    geopotential = altitude * 6356766.0 / (6356766.0 + altitude)
    sea_level_temperature = 518.67 / 1.8
    temperature = sea_level_temperature - lapse * geopotential
    psf = LB * 32.174049 * FT / FT**2  # Pa per lb/ft^2, with JSBSim's 32.174049 ft/s^2
    pressure = 2116.228 * psf * (temperature / sea_level_temperature) ** (GRAVITY / (gas_constant * lapse))
    return pressure / (gas_constant * temperature)


def helmbold(aspect_ratio: float) -> float:
    """Lift-curve slope per rad of a straight wing of any aspect ratio (Helmbold 1942, section slope 2 pi)."""
    return 2.0 * math.pi * aspect_ratio / (2.0 + math.sqrt(aspect_ratio**2 + 4.0))


def taper_ratio() -> float:
    """Taper of the straight-tapered wing whose mean aerodynamic chord and area are the paper's.

    c_A = (4/3) (S/b) (1 - t / (1 + t)^2), solved for the root below 1.
    """
    m = 1.0 - 0.75 * CHORD * SPAN / WING_AREA  # = t / (1 + t)^2
    half = (1.0 - 2.0 * m) / (2.0 * m)
    return half - math.sqrt(half**2 - 1.0)


@dataclass(frozen=True)
class Wing:
    """What the lifting line says of the wing; derivatives per rad, rates normalised by b/2V."""

    cl_alpha: float
    efficiency: float  # inviscid span efficiency
    roll_due_to_roll: float  # Cl_p of the rigid wing
    roll_due_to_sideslip: float  # Cl_b per rad of dihedral
    roll_due_to_yaw: float  # Cl_r per unit lift coefficient


def lifting_line(aspect_ratio: float, taper: float, stations: int = 200) -> Wing:
    """Prandtl's lifting-line equation for a straight-tapered wing, Gamma = 2 b V sum A_k sin(k theta).

    One collocation matrix serves three distributions of incidence: 1 (lift), 2y/b (roll rate) and sign(y) (dihedral).
    """
    theta = (np.arange(1, stations + 1) - 0.5) * math.pi / stations
    eta = np.cos(theta)  # 2y/b
    chord = 2.0 / (aspect_ratio * (1.0 + taper)) * (1.0 - (1.0 - taper) * np.abs(eta))  # over the span
    mu = SECTION_LIFT_SLOPE * chord / 4.0
    k = np.arange(1, stations + 1)
    matrix = np.sin(np.outer(theta, k)) * (1.0 + mu[:, None] * k / np.sin(theta)[:, None])
    lift, roll, dihedral = np.linalg.solve(matrix, np.column_stack([mu, mu * eta, mu * np.sign(eta)])).T
    cl_alpha = math.pi * aspect_ratio * lift[0]
    cl_p = -math.pi * aspect_ratio * roll[1] / 4.0
    figures = (
        cl_alpha,
        1.0 / np.sum(k * (lift / lift[0]) ** 2),
        cl_p,
        -math.pi * aspect_ratio * dihedral[1] / 4.0,
        # The advancing wing has more circulation (the roll solution, turned round) and more speed (the second moment).
        -cl_p / cl_alpha + (1.0 + lift[2] / lift[0]) / 8.0,
    )
    return Wing(*(float(f"{figure:.6g}") for figure in figures))  # so that every machine writes the same file


@dataclass(frozen=True)
class Coefficient:
    """One stability or control derivative: its symbol, value, unit, what it multiplies in the XML, and its source."""

    symbol: str
    value: float
    unit: str
    axis: str
    factors: tuple[str, ...]
    source: str


QS = ("aero/qbar-psf", "metrics/Sw-sqft")
QSB = (*QS, "metrics/bw-ft")
QSC = (*QS, "metrics/cbarw-ft")
P_HAT = ("aero/bi2vel", "velocities/p-aero-rad_sec")  # b p / 2V
Q_HAT = ("aero/ci2vel", "velocities/q-aero-rad_sec")  # c q / 2V
R_HAT = ("aero/bi2vel", "velocities/r-aero-rad_sec")  # b r / 2V
ALPHA, BETA = "aero/alpha-rad", "aero/beta-rad"
ELEVATOR, RUDDER = "fcs/elevator-pos-rad", "fcs/rudder-pos-rad"
SIDES = {"left": 1.0, "right": -1.0}  # what a positive deflection, trailing edge down on the right, does to the roll
AILERONS = "<sum>" + "".join(f"<property>aero/moment/{side}-aileron</property>" for side in SIDES) + "</sum>"


def control_derivatives(dynamic_pressure: float) -> np.ndarray:
    """Moment coefficients (Cl, Cm, Cn) per rad of (aileron, elevator, rudder) that make J^-1 M_delta equal B_m."""
    reference = dynamic_pressure * WING_AREA * np.array([SPAN, CHORD, SPAN])
    return (J @ B_M) / reference[:, None]


def coefficients() -> list[Coefficient]:
    """Every aerodynamic coefficient of the aircraft, computed."""
    gravity = PLANET_GM / (PLANET_RADIUS + ALTITUDE) ** 2
    dynamic_pressure = 0.5 * standard_density(ALTITUDE) * AIRSPEED**2
    taper = taper_ratio()
    aspect_ratio = SPAN**2 / WING_AREA
    wing = lifting_line(aspect_ratio, taper)
    strip_yaw = (1.0 + 3.0 * taper) / (6.0 * (1.0 + taper))  # integral of 4 c y^2 / (S b^2) dy over the span

    cl0 = MASS * gravity / (dynamic_pressure * WING_AREA)
    oswald = 1.0 / (1.0 / wing.efficiency + 0.38 * CD0 * math.pi * aspect_ratio)
    tail_slope = helmbold(HTAIL_ASPECT_RATIO)
    tail_volume = HTAIL_AREA * TAIL_ARM / (WING_AREA * CHORD)
    side_slope = -helmbold(FIN_ASPECT_RATIO) * FIN_AREA / WING_AREA
    arm = TAIL_ARM / SPAN
    control = control_derivatives(dynamic_pressure)
    printed = "J B_m / (q S b) at 30 m/s and 1000 m; B_m and J from the paper"

    return [
        Coefficient(
            "CL_0", cl0, "-", "LIFT", QS, "m g / (q S): alpha = theta = 0 is the level trim at 30 m/s and 1000 m"
        ),
        Coefficient(
            "CL_alpha",
            wing.cl_alpha,
            "/rad",
            "LIFT",
            (*QS, ALPHA),
            f"lifting line, aspect ratio {aspect_ratio:g}, taper {taper:.3f}, section slope 2 pi",
        ),
        Coefficient("CD_0", CD0, "-", "DRAG", QS, "chosen: clean sailplane at 3 million Reynolds (0.008 to 0.013)"),
        Coefficient(
            "k",
            1.0 / (math.pi * aspect_ratio * oswald),
            "-",
            "DRAG",
            QS,
            f"1 / (pi e A) on CL^2; 1/e = 1/{wing.efficiency:.3f} (lifting line) + 0.38 CD_0 pi A (Kroo), "
            f"e = {oswald:.3f}",
        ),
        Coefficient(
            "CY_beta",
            side_slope,
            "/rad",
            "SIDE",
            (*QS, BETA),
            f"fin: -a_v S_v / S, a_v = {helmbold(FIN_ASPECT_RATIO):.2f} (Helmbold, aspect ratio "
            f"{FIN_ASPECT_RATIO:g}), S_v = {FIN_AREA:g} m^2",
        ),
        Coefficient(
            "Cl_beta",
            wing.roll_due_to_sideslip * DIHEDRAL,
            "/rad",
            "ROLL",
            (*QSB, BETA),
            f"lifting line: {wing.roll_due_to_sideslip:.3f} per rad of dihedral, {math.degrees(DIHEDRAL):g} deg",
        ),
        Coefficient(
            "Cl_p",
            CL_P,
            "/rad",
            "ROLL",
            (*QSB, *P_HAT),
            f"chosen: between the lifting line's {wing.roll_due_to_roll:.2f} and the paper's A_m; see below",
        ),
        Coefficient(
            "Cl_r",
            wing.roll_due_to_yaw * cl0,
            "/rad",
            "ROLL",
            (*QSB, *R_HAT),
            f"lifting line: {wing.roll_due_to_yaw:.3f} CL (elliptic: CL/4), at the trim CL",
        ),
        Coefficient("Cl_da", control[0, 0], "/rad", "ROLL", (AILERONS,), printed),
        Coefficient("Cl_dr", control[0, 2], "/rad", "ROLL", (*QSB, RUDDER), printed),
        Coefficient(
            "Cm_alpha",
            -STATIC_MARGIN * wing.cl_alpha,
            "/rad",
            "PITCH",
            (*QSC, ALPHA),
            f"-(static margin) CL_alpha, margin {STATIC_MARGIN:g}",
        ),
        Coefficient(
            "Cm_q",
            -1.1 * 2.0 * tail_slope * tail_volume * TAIL_ARM / CHORD,
            "/rad",
            "PITCH",
            (*QSC, *Q_HAT),
            f"tail: -2 a_t V_H l_t / c and a tenth more for the wing; a_t = {tail_slope:.2f} (Helmbold, aspect "
            f"ratio {HTAIL_ASPECT_RATIO:g}), V_H = {tail_volume:.3f}",
        ),
        Coefficient("Cm_de", control[1, 1], "/rad", "PITCH", (*QSC, ELEVATOR), printed.replace("S b", "S c")),
        Coefficient(
            "Cn_beta", -side_slope * arm, "/rad", "YAW", (*QSB, BETA), f"fin: -CY_beta l_v / b, l_v = {TAIL_ARM:g} m"
        ),
        Coefficient(
            "Cn_p", -cl0 / 8.0, "/rad", "YAW", (*QSB, *P_HAT), "wing: -CL/8 (elliptic lifting line), at the trim CL"
        ),
        Coefficient(
            "Cn_r",
            2.0 * side_slope * arm**2 - CD0 * strip_yaw,
            "/rad",
            "YAW",
            (*QSB, *R_HAT),
            "fin: 2 CY_beta (l_v / b)^2; wing: profile drag of the faster half, strip theory",
        ),
        Coefficient("Cn_da", control[2, 0], "/rad", "YAW", (AILERONS,), printed),
        Coefficient("Cn_dr", control[2, 2], "/rad", "YAW", (*QSB, RUDDER), printed),
    ]


# ----------------------------------------------------------------------------------------------------------- the XML
HEADER = """\
<?xml version="1.0" encoding="UTF-8"?>
<!-- Written by tools/hale_aircraft.py: change that script, not this file. -->
"""

AXES = {  # JSBSim axis: folder of its properties, frame note
    "LIFT": ("force", "wind axes, positive up"),
    "DRAG": ("force", "wind axes, positive aft"),
    "SIDE": ("force", "wind axes, positive right"),
    "ROLL": ("moment", "body axes, positive right wing down"),
    "PITCH": ("moment", "body axes, positive nose up"),
    "YAW": ("moment", "body axes, positive nose right"),
}


def number(value: float) -> str:
    """Twelve significant digits: a part in 10^12 is below every tolerance and the same text on every machine."""
    return f"{value:.12g}"


def function_xml(coefficient: Coefficient, lift: list[str]) -> str:
    """One aerodynamic contribution; `lift` is the XML of the lift coefficient's terms, whose sum the drag squares."""
    factors = [name if name == AILERONS else f"<property>{name}</property>" for name in coefficient.factors]
    factors.append(f"<value>{number(coefficient.value)}</value>")
    if coefficient.symbol == "k":
        factors += ["<pow>", "  <sum>", *(f"    {term}" for term in lift), "  </sum>", "  <value>2</value>", "</pow>"]
    lines = "\n".join(f"          {factor}" for factor in factors)
    return f"""\
      <function name="aero/{AXES[coefficient.axis][0]}/{coefficient.symbol}">
        <description>
{fill(escape(coefficient.source), 118, initial_indent=" " * 10, subsequent_indent=" " * 10)}
        </description>
        <product>
{lines}
        </product>
      </function>
"""


def aileron_xml(side: str, sign: float) -> str:
    """The part of one aileron, per unit of Cl_da and Cn_da: half of q S b times its deflection.

    Outside the axes, so that the two are added first: an aileron of twice half the effect flies the same to the bit.
    """
    factors = "".join(f"        <property>{name}</property>\n" for name in (*QSB, f"fcs/{side}-aileron-pos-rad"))
    return f"""\
    <function name="aero/moment/{side}-aileron"> <!-- lb ft per unit of Cl_da and Cn_da -->
      <product>
{factors}        <value>{number(0.5 * sign)}</value>
      </product>
    </function>
"""


def aerodynamics_xml() -> str:
    """The aerodynamics section: the two ailerons, then axis by axis."""
    table = coefficients()
    value = {c.symbol: number(c.value) for c in table}
    lift = [
        f"<value>{value['CL_0']}</value>",
        f"<product><value>{value['CL_alpha']}</value><property>{ALPHA}</property></product>",
    ]
    axes = "".join(aileron_xml(*side) for side in SIDES.items())
    for axis, (_, note) in AXES.items():
        functions = "".join(function_xml(c, lift) for c in table if c.axis == axis)
        axes += f'    <axis name="{axis}"> <!-- {note} -->\n{functions}    </axis>\n'
    return axes


def contact_xml(name: str, location: tuple[float, float, float], stiffness: float, damping: float) -> str:
    """One skid of the airframe; structural axes: x aft, y right, z up, from the centre of gravity."""
    x, y, z = location
    return f"""\
    <contact type="STRUCTURE" name="{name}">
      <location unit="M"><x>{number(x)}</x><y>{number(y)}</y><z>{number(z)}</z></location>
      <static_friction>0.8</static_friction>
      <dynamic_friction>0.5</dynamic_friction>
      <spring_coeff unit="N/M">{number(stiffness)}</spring_coeff>
      <damping_coeff unit="N/M/SEC">{number(damping)}</damping_coeff>
    </contact>
"""


def contacts_xml() -> str:
    """Skids whose springs carry the weight over some 0.15 m, damped at 0.7 of critical for the mass each one moves."""
    tip_z = 0.5 * SPAN * math.tan(DIHEDRAL)
    inertia_roll, inertia_pitch = J[0, 0], J[1, 1]
    skids = (
        # name, location, mass that the contact moves
        ("NOSE_SKID", (-1.0, 0.0, -1.0), MASS / 2.0),
        ("BELLY_SKID", (1.0, 0.0, -1.0), MASS / 2.0),
        ("TAIL_BUMPER", (TAIL_ARM, 0.0, -0.3), inertia_pitch / TAIL_ARM**2),
        ("LEFT_TIP", (0.0, -0.5 * SPAN, tip_z), inertia_roll / (0.5 * SPAN) ** 2),
        ("RIGHT_TIP", (0.0, 0.5 * SPAN, tip_z), inertia_roll / (0.5 * SPAN) ** 2),
    )
    text = ""
    for name, location, mass in skids:
        stiffness = mass * GRAVITY / 0.15
        text += contact_xml(name, location, round(stiffness, -2), round(2.0 * 0.7 * math.sqrt(stiffness * mass), -1))
    return text


def engine_xml(side: float, sense: int) -> str:
    """One motor with its propeller; sense 1 turns clockwise seen from behind."""
    return f"""\
    <engine file="hale_motor">
      <thruster file="hale_prop">
        <location unit="M"><x>0</x><y>{number(side)}</y><z>0</z></location>
        <orient unit="DEG"><roll>0</roll><pitch>0</pitch><yaw>0</yaw></orient>
        <sense>{sense}</sense>
      </thruster>
    </engine>
"""


SURFACES = (("elevator", "pitch", ELEVATOR), ("rudder", "yaw", RUDDER))


def surface_xml(name: str, trim: str, output: str) -> str:
    """One surface: the command in radians plus the trim command, through the mechanical stop."""
    stop = number(SURFACE_STOP)
    return f"""\
    <channel name="{name}">
      <summer name="fcs/{name}-sum">
        <input>fcs/{name}-cmd-norm</input>
        <input>fcs/{trim}-trim-cmd-norm</input>
      </summer>
      <actuator name="fcs/{name}-actuator"> <!-- no lag: its malfunction properties and its stop only -->
        <input>fcs/{name}-sum</input>
        <clipto><min>-{stop}</min><max>{stop}</max></clipto>
        <output>{output}</output>
      </actuator>
    </channel>
"""


def ailerons_xml() -> str:
    """The two ailerons: the command of each, and the stick and the trim command, which move them against each other."""
    stop = number(SURFACE_STOP)
    text = "".join(f'    <property value="0">fcs/{side}-aileron-cmd-norm</property>\n' for side in SIDES)
    text += '    <channel name="aileron">\n'
    for side, sign in SIDES.items():
        minus = "-" if sign < 0.0 else ""
        text += f"""\
      <summer name="fcs/{side}-aileron-sum">
        <input>fcs/{side}-aileron-cmd-norm</input>
        <input>{minus}fcs/aileron-cmd-norm</input>
        <input>{minus}fcs/roll-trim-cmd-norm</input>
      </summer>
      <actuator name="fcs/{side}-aileron-actuator"> <!-- no lag: its malfunction properties and its stop only -->
        <input>fcs/{side}-aileron-sum</input>
        <clipto><min>-{stop}</min><max>{stop}</max></clipto>
        <output>fcs/{side}-aileron-pos-rad</output>
      </actuator>
"""
    return text + "    </channel>\n"


def aircraft_xml() -> str:
    """hale.xml."""
    inertia = J / SLUG_FT2
    printed = ", ".join(number(x) for x in (J[0, 0], J[1, 1], J[2, 2], J[0, 2]))
    surfaces = ailerons_xml() + "".join(surface_xml(*s) for s in SURFACES)
    return f"""\
{HEADER}<fdm_config name="hale" version="2.0" release="PRODUCTION">
  <fileheader>
    <author>The uavftc developers</author>
    <license licenseName="MIT" licenseURL="https://opensource.org/license/mit"/>
    <filecreationdate>2026-01-01</filecreationdate>
    <version>1.0</version>
    <description>
      High-altitude long-endurance UAV with the mass properties, wing dimensions and control matrix of Zhou, Liu, Li,
      Liu, Actuators 2025, 14(9), 437, section 4. The paper prints no aerodynamic coefficient; README.md gives the
      source or the reason of each one here.
    </description>
    <limitation>Linear aerodynamics: no stall, no compressibility, no propeller slipstream, a rigid wing.</limitation>
  </fileheader>

  <metrics> <!-- wing from the paper, tails chosen; all moments are taken about the centre of gravity -->
    <wingarea unit="M2">{number(WING_AREA)}</wingarea>
    <wingspan unit="M">{number(SPAN)}</wingspan>
    <chord unit="M">{number(CHORD)}</chord>
    <htailarea unit="M2">{number(HTAIL_AREA)}</htailarea>
    <htailarm unit="M">{number(TAIL_ARM)}</htailarm>
    <vtailarea unit="M2">{number(FIN_AREA)}</vtailarea>
    <vtailarm unit="M">{number(TAIL_ARM)}</vtailarm>
    <location name="AERORP" unit="M"><x>0</x><y>0</y><z>0</z></location>
    <location name="EYEPOINT" unit="M"><x>0</x><y>0</y><z>0</z></location>
    <location name="VRP" unit="M"><x>0</x><y>0</y><z>0</z></location>
  </metrics>

  <!-- From the paper: {number(MASS)} kg; J11, J22, J33, J13 = {printed} kg m^2 (JSBSim's ixz is -J13).
       In SLUG*FT2 and LBS by the exact factors, because JSBSim's own factor for KG*M2 is 9e-5 off. -->
  <mass_balance negated_crossproduct_inertia="false">
    <ixx unit="SLUG*FT2">{number(inertia[0, 0])}</ixx>
    <iyy unit="SLUG*FT2">{number(inertia[1, 1])}</iyy>
    <izz unit="SLUG*FT2">{number(inertia[2, 2])}</izz>
    <ixy unit="SLUG*FT2">0</ixy>
    <ixz unit="SLUG*FT2">{number(-inertia[0, 2])}</ixz>
    <iyz unit="SLUG*FT2">0</iyz>
    <emptywt unit="LBS">{number(MASS / LB)}</emptywt>
    <location name="CG" unit="M"><x>0</x><y>0</y><z>0</z></location>
  </mass_balance>

  <ground_reactions> <!-- structural axes: x aft, y right, z up -->
{contacts_xml()}  </ground_reactions>

  <!-- Disturbance moment: direction in external_reactions/dist/l, m and n, size in
       external_reactions/dist/magnitude-lbsft. JSBSim multiplies the two: with magnitude 1 they are lb ft. -->
  <external_reactions>
    <moment name="dist" frame="BODY">
      <direction><x>1</x><y>0</y><z>0</z></direction>
    </moment>
  </external_reactions>

  <propulsion> <!-- counter-rotating, so that their torques and gyroscopic moments cancel -->
{engine_xml(-MOTOR_Y, 1)}{engine_xml(MOTOR_Y, -1)}  </propulsion>

  <system file="hale_autothrottle"/>

  <!-- The surface commands and trim commands are in radians, whatever their "norm" says; positive gives a positive
       moment about its axis: aileron rolls right, elevator pitches up, rudder yaws right. Each aileron has its command;
       fcs/aileron-cmd-norm is the stick, added to the left one and taken from the right one. -->
  <flight_control name="surfaces">
{surfaces}  </flight_control>

  <aerodynamics>
{aerodynamics_xml()}  </aerodynamics>
</fdm_config>
"""


def motor_xml() -> str:
    """engine/hale_motor.xml."""
    return f"""\
{HEADER}<!-- Chosen: shaft power at full throttle, proportional to the throttle. -->
<electric_engine name="hale_motor">
  <power unit="WATTS">{number(MOTOR_POWER)}</power>
</electric_engine>
"""


def propeller_xml() -> str:
    """engine/hale_prop.xml."""

    def table(name: str, column: int) -> str:
        rows = "\n".join(f"      {row[0]:.1f} {row[column]: .4f}" for row in PROP_TABLE)
        return f'  <table name="{name}" type="internal">\n    <tableData>\n{rows}\n    </tableData>\n  </table>\n'

    return f"""\
{HEADER}<!-- Chosen: fixed-pitch two-blade propeller, pitch over diameter near 1.3; tables against J = V / (n D). -->
<propeller name="hale_prop" version="1.1">
  <ixx unit="SLUG*FT2">{number(PROP_INERTIA / SLUG_FT2)}</ixx>
  <diameter unit="M">{number(PROP_DIAMETER)}</diameter>
  <numblades>2</numblades>
  <gearratio>1</gearratio>
{table("C_THRUST", 1)}{table("C_POWER", 2)}</propeller>
"""


def autothrottle_xml() -> str:
    """systems/hale_autothrottle.xml."""
    return f"""\
{HEADER}<!--
  PI on true airspeed, added to the base throttle of each motor, fcs/throttle-cmd-norm[0] (left) and [1] (right). The
  integral rests while the left throttle is at its end.
    ap/at-on        0 off, the base throttle passes; 1 on
    ap/vt-set-fps   airspeed to hold, ft/s
  Gains chosen: 0.15 per ft/s moves half the throttle for 1 m/s; the integral, 0.05 per ft, takes over in 3 s.
-->
<system name="autothrottle">
  <property value="0">ap/at-on</property>
  <property value="{number(AIRSPEED / FT)}">ap/vt-set-fps</property>
  <channel name="autothrottle">
    <summer name="ap/vt-err">
      <input>ap/vt-set-fps</input>
      <input>-velocities/vt-fps</input>
    </summer>
    <!-- PID trigger: 0 integrates, above 0 holds (the throttle is at its end), below 0 resets the integral (off). -->
    <switch name="ap/at-trigger">
      <default value="0"/>
      <test logic="AND" value="-1">
        ap/at-on LT 0.5
      </test>
      <test logic="AND" value="1">
        ap/at-throttle GE 0.999
        ap/vt-err GT 0
      </test>
      <test logic="AND" value="1">
        ap/at-throttle LE 0.001
        ap/vt-err LT 0
      </test>
    </switch>
    <pid name="ap/at-pi">
      <input>ap/vt-err</input>
      <kp>0.15</kp>
      <ki type="trap">0.05</ki>
      <kd>0</kd>
      <trigger>ap/at-trigger</trigger>
    </pid>
    <switch name="ap/at-gate">
      <default value="0"/>
      <test logic="AND" value="ap/at-pi">
        ap/at-on GE 0.5
      </test>
    </switch>
    <summer name="ap/at-throttle">
      <input>fcs/throttle-cmd-norm[0]</input>
      <input>ap/at-gate</input>
      <clipto><min>0</min><max>1</max></clipto>
      <output>fcs/throttle-pos-norm[0]</output>
    </summer>
    <summer name="ap/at-throttle-right">
      <input>fcs/throttle-cmd-norm[1]</input>
      <input>ap/at-gate</input>
      <clipto><min>0</min><max>1</max></clipto>
      <output>fcs/throttle-pos-norm[1]</output>
    </summer>
  </channel>
</system>
"""


def planet_xml() -> str:
    """flat_planet.xml."""
    return f"""\
{HEADER}<!-- The paper's assumptions 2 and 3: flat, not rotating, constant gravity. A sphere of a hundred Earth radii
     with standard gravity at its surface; gravity falls by 3 parts in a million over 1 km of height. -->
<planet name="flat">
  <equatorial_radius unit="M">{number(PLANET_RADIUS)}</equatorial_radius>
  <polar_radius unit="M">{number(PLANET_RADIUS)}</polar_radius>
  <rotation_rate unit="RAD/SEC">0</rotation_rate>
  <GM unit="M3/SEC2">{PLANET_GM:.17g}</GM>
  <J2>0</J2>
</planet>
"""


# --------------------------------------------------------------------------------------------- README table and files
TABLE_BEGIN = "<!-- coefficients: written by tools/hale_aircraft.py -->"
TABLE_END = "<!-- end of coefficients -->"


def coefficient_table() -> str:
    """The coefficients as a Markdown table."""
    rows = "\n".join(f"| `{c.symbol}` | {c.value:.6g} | {c.unit} | {c.source} |" for c in coefficients())
    return f"{TABLE_BEGIN}\n| symbol | value | unit | source or reason |\n|---|---|---|---|\n{rows}\n{TABLE_END}"


def with_table(readme: str) -> str:
    """The README text with its coefficient table renewed."""
    before, begin, rest = readme.partition(TABLE_BEGIN)
    _, end, after = rest.partition(TABLE_END)
    if not (begin and end):
        raise SystemExit(f"README.md: expected the lines {TABLE_BEGIN!r} and {TABLE_END!r} around the table")
    return before + coefficient_table() + after


def files(folder: Path) -> dict[Path, str]:
    """Every file this script answers for, with the text it should have."""
    texts = {
        folder / "hale.xml": aircraft_xml(),
        folder / "engine" / "hale_motor.xml": motor_xml(),
        folder / "engine" / "hale_prop.xml": propeller_xml(),
        folder / "systems" / "hale_autothrottle.xml": autothrottle_xml(),
        folder / "flat_planet.xml": planet_xml(),
    }
    if folder == FOLDER:
        texts[PLANET] = planet_xml()
    readme = folder / "README.md"
    if readme.exists():
        texts[readme] = with_table(readme.read_text(encoding="utf-8"))
    return texts


def main(arguments: list[str] | None = None) -> int:
    """Write the files, or compare them; the exit code is 1 when --check finds a difference."""
    parser = argparse.ArgumentParser(description="Write the JSBSim aircraft in aircraft/hale.")
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file differs")
    parser.add_argument("--folder", type=Path, default=FOLDER, help="the aircraft's folder (default: aircraft/hale)")
    options = parser.parse_args(arguments)

    stale = []
    for path, text in files(options.folder).items():
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(path)
        if not options.check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
            print(f"wrote {path}")
    if options.check and stale:
        names = ", ".join(str(path) for path in stale)
        print(f"differs from what tools/hale_aircraft.py writes: {names}; run it to renew them", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
