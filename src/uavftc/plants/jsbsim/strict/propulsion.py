"""Engines, thrusters and tanks, and their files."""

from __future__ import annotations

from uavftc.plants.jsbsim.strict.grammar import Kind, kind

_MOUNT = {"place": "location", "angles": "orient", "tank-number": "feed*"}
_ENGINES = "piston_engine turbine_engine turboprop_engine rocket_engine electric_engine brushless_dc_motor"
_THRUSTERS = "propeller nozzle rotor direct"
_FUNCTIONS = {"declaration": "property*", "function": "function*"}


def _engine(children: dict[str, str]) -> Kind:
    merged = {**_FUNCTIONS, **_MOUNT, **children}
    return kind({**merged, "thruster": "thruster"}, "name version=number")


def _thruster(children: dict[str, str], attributes: str = "name") -> Kind:
    return kind({**_FUNCTIONS, **children}, attributes)


KINDS: dict[str, Kind] = {
    "propulsion": kind(
        {**_FUNCTIONS, "engine": "engine*", "tank": "tank*", "number": "dump-rate refuel-rate"}, "name", file=True
    ),
    "engine": kind({**_MOUNT, "thruster": "thruster!", **{name: name for name in _ENGINES.split()}}, "name", file=True),
    "thruster": kind(
        {"place": "location!", "angles": "orient pointing", "number": "sense p_factor"}
        | {name: name for name in _THRUSTERS.split()},
        "name",
        file=True,
    ),
    "tank-number": kind(form="number"),
    "tank": kind(
        {
            "place": "location! drain_location",
            "number": "capacity! contents! temperature standpipe density unusable-volume priority radius "
            "inertia_factor",
            "fuel": "type",
            "grain": "grain_config",
        },
        "type!=FUEL|OXIDIZER name number=number",
        file=True,
    ),
    "fuel": kind(form="any"),
    "grain": kind(
        {"number": "length bore_diameter", "inertia": "ixx iyy izz"}, "type!=CYLINDRICAL|ENDBURNING|FUNCTION"
    ),
    "inertia": kind({"function": "function!"}, "unit=unit"),
    # engines
    "electric_engine": _engine({"number": "power!"}),
    "brushless_dc_motor": _engine({"number": "maxvolts! velocityconstant! coilresistance! noloadcurrent"}),
    "piston_engine": _engine(
        {
            "number": "minmp! maxmp! displacement! maxhp! cycles! idlerpm! maxrpm! maxthrottle minthrottle "
            "sparkfaildrop bore stroke compression-ratio cylinders bsfc volumetric-efficiency numboostspeeds "
            "boostoverride boostmanual boost-loss-factor ram-air-factor man-press-lag takeoffboost static-friction "
            "static-fmep dynamic-fmep peak-piston-speed starter-rpm cylinder-head-mass cooling-factor "
            "air-intake-impedance-factor design-oil-temp-degK oil-pressure-relief-valve-psi oil-pressure-rpm-max "
            "oil-viscosity-index "
            + " ".join(f"rated{what}{i}" for what in ("boost", "power", "rpm", "altitude") for i in (1, 2, 3)),
            "plain": "starter-torque",
            "label": "injected",
            "table": "table*",
        }
    ),
    "turbine_engine": _engine(
        {
            "number": "milthrust! maxthrust bypassratio bleed idlen1 idlen2 maxn1 maxn2 ignitionn1 "
            "ignitionn2 augmented augmethod injected injection-time injection-N1-inc injection-N2-inc n1spinup "
            "n2spinup n1spindown n2spindown n1startrate n2startrate disable-windmill",
            "tsfc": "tsfc atsfc",
        }
    ),
    "tsfc": kind({"function": "function"}, "unit=unit", form="maybe-number"),
    "turboprop_engine": _engine(
        {
            "number": "milthrust! idlen1 idlen2 maxn1 maxn2 maxpower n1idle_max_delay maxstartingtime startern1 "
            "itt_delay betarangeend reversemaxpower idlefuelflow",
            "plain": "ielumaxtorque psfc",
            "table": "table*",
        }
    ),
    "rocket_engine": _engine(
        {
            "tsfc": "isp!",
            "number": "maxthrottle minthrottle slfuelflowmax sloxiflowmax propflowmax mixtureratio builduptime",
            "table": "thrust_table",
            "variation": "variation",
        }
    ),
    "variation": kind({"number": "thrust total_isp"}),
    # thrusters
    "propeller": _thruster(
        {
            "number": "ixx! diameter! numblades! gearratio ct_factor cp_factor p_factor sense",
            "plain": "minpitch maxpitch minrpm maxrpm constspeed reversepitch",
            "propeller-table": "table+",
        },
        "name version=number",
    ),
    "propeller-table": kind(
        {"variable": "independentVar*", "data": "tableData+"},
        "name!=C_THRUST|C_POWER|CT_MACH|CP_MACH type=internal|internal",
    ),
    # pe, expr, nzl_eff and diam are of JSBSim's old nozzle, read no more
    "nozzle": _thruster({"number": "area!", "label": "pe expr nzl_eff diam"}),
    "direct": _thruster({}),
    "rotor": _thruster(
        {
            "number": "diameter! numblades! gearratio nominalrpm minrpm maxrpm chord liftcurveslope twist hingeoffset "
            "flappingmoment polarmoment inflowlag tiplossfactor maxbrakepower gearloss gearmoment "
            "groundeffectexp groundeffectshift ExternalRPM sense",
            "mass-moment": "massmoment",
            "controlmap": "controlmap",
            # read no more
            "label": "xhub yhub zhub shafttilt cantangle cgroundeffect tailrotor",
        }
    ),
    "mass-moment": kind(attributes="unit Xunit", form="number"),
    "controlmap": kind(form="any", words="MAIN TAIL TANDEM"),
    "label": kind(attributes="unit", form="prose"),
}
