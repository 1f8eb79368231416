"""A small aircraft as models are published: a left and a right aileron and a V-tail, each with a command of its own,
servos with lag, delay and backlash, a turbine, and no companion file.
"""

from __future__ import annotations

from pathlib import Path

LAG_RADPS, DELAY_S, BACKLASH_RAD, STOP_RAD = 40.0, 0.02, 0.01745, 0.5
EFFECTORS = ("ail_l", "ail_r", "tail_l", "tail_r")
SERVO = {"lag_radps": LAG_RADPS, "delay_s": DELAY_S, "backlash_rad": BACKLASH_RAD}

CY_b = -0.3
CL_0, CL_A, CD_0, CD_i = 0.2, 5.0, 0.03, 0.05
C_L = {"aero/beta-rad": -0.05, "p": -0.5, "r": 0.05, "ail_l": 0.12, "ail_r": -0.12, "tail_l": 0.01, "tail_r": -0.01}
C_M = {"aero/alpha-rad": -0.8, "q": -12.0, "ail_l": -0.05, "ail_r": -0.05, "tail_l": -0.4, "tail_r": -0.4}
C_N = {"aero/beta-rad": 0.06, "p": -0.02, "r": -0.12, "ail_l": -0.004, "ail_r": 0.004, "tail_l": -0.03, "tail_r": 0.03}

_PRESSURE = "<property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>"

_TURBINE = """<?xml version="1.0"?>
<turbine_engine name="small"><milthrust unit="LBS">4</milthrust><bypassratio>0</bypassratio><tsfc>0.1</tsfc>
<bleed>0</bleed><idlen1>30</idlen1><idlen2>60</idlen2><maxn1>100</maxn1><maxn2>100</maxn2><augmented>0</augmented>
<injected>0</injected>
<function name="IdleThrust"><value>0.05</value></function>
<function name="MilThrust"><value>1</value></function>
</turbine_engine>
"""


def write(parent: Path, name: str = "vtail", *, extra: str = "") -> Path:
    """Write the aircraft into a new folder and return it; `extra` is put into its flight controls."""
    folder = parent / name
    (folder / "engine").mkdir(parents=True)
    (folder / "engine" / "small.xml").write_text(_TURBINE, encoding="utf-8")
    (folder / "engine" / "direct.xml").write_text('<?xml version="1.0"?>\n<direct name="direct"/>\n', encoding="utf-8")
    (folder / f"{name}.xml").write_text(_xml(name, extra), encoding="utf-8")
    return folder


def _xml(name: str, extra: str) -> str:
    declared = "".join(f'<property value="0">fcs/cmd_{e}_rad</property>\n' for e in EFFECTORS)
    servos = "".join(
        f'<actuator name="fcs/act_{e}"><input>fcs/cmd_{e}_rad</input><lag>{LAG_RADPS}</lag>'
        f'<delay type="time">{DELAY_S}</delay><hysteresis_width>{BACKLASH_RAD}</hysteresis_width>'
        f"<clipto><min>{-STOP_RAD}</min><max>{STOP_RAD}</max></clipto><output>fcs/{e}_rad</output></actuator>\n"
        for e in EFFECTORS
    )
    lift = (
        f"<sum><value>{CL_0}</value><product><value>{CL_A}</value><property>aero/alpha-rad</property></product></sum>"
    )
    drag = f"<sum><value>{CD_0}</value><product><value>{CD_i}</value>{lift}{lift}</product></sum>"
    side = f"<product><value>{CY_b}</value><property>aero/beta-rad</property></product>"
    return f"""<?xml version="1.0"?>
<fdm_config name="{name}" version="2.0" release="BETA">
<metrics><wingarea unit="M2">0.6</wingarea><wingspan unit="M">2</wingspan><chord unit="M">0.3</chord>
<location name="AERORP" unit="M"><x>0</x><y>0</y><z>0</z></location></metrics>
<mass_balance><ixx unit="KG*M2">0.15</ixx><iyy unit="KG*M2">0.2</iyy><izz unit="KG*M2">0.33</izz>
<emptywt unit="KG">3</emptywt><location name="CG" unit="M"><x>0</x><y>0</y><z>0</z></location></mass_balance>
<ground_reactions/>
<propulsion>
<engine file="small"><feed>0</feed>
<thruster file="direct"><location unit="M"><x>0</x><y>0</y><z>0</z></location>
<orient unit="DEG"><roll>0</roll><pitch>0</pitch><yaw>0</yaw></orient></thruster></engine>
<tank type="FUEL"><location unit="M"><x>0</x><y>0</y><z>0</z></location><capacity unit="KG">0.2</capacity>
<contents unit="KG">0.2</contents></tank>
</propulsion>
<flight_control name="controls">
{declared}{extra}<channel name="servos">
{servos}</channel></flight_control>
<aerodynamics>
<axis name="LIFT"><function name="aero/lift"><product>{_PRESSURE}{lift}</product></function></axis>
<axis name="DRAG"><function name="aero/drag"><product>{_PRESSURE}{drag}</product></function></axis>
<axis name="SIDE"><function name="aero/side"><product>{_PRESSURE}{side}</product></function></axis>
<axis name="ROLL">{_moment("roll", "metrics/bw-ft", "aero/bi2vel", C_L)}</axis>
<axis name="PITCH">{_moment("pitch", "metrics/cbarw-ft", "aero/ci2vel", C_M)}</axis>
<axis name="YAW">{_moment("yaw", "metrics/bw-ft", "aero/bi2vel", C_N)}</axis>
</aerodynamics>
</fdm_config>
"""


def _moment(name: str, length: str, per_speed: str, coefficients: dict[str, float]) -> str:
    terms = ""
    for what, value in coefficients.items():
        if what in "pqr":
            factors = f"<property>velocities/{what}-aero-rad_sec</property><property>{per_speed}</property>"
        else:
            factors = f"<property>{what if '/' in what else f'fcs/{what}_rad'}</property>"
        terms += f"<product><value>{value}</value>{factors}</product>"
    return (
        f'<function name="aero/{name}"><product>{_PRESSURE}<property>{length}</property><sum>{terms}</sum></product>'
        "</function>"
    )
