"""The sections of an aircraft file, and a planet's file."""

from __future__ import annotations

from uavftc.plants.jsbsim.strict.grammar import Kind, kind

_MODEL = {"declaration": "property*", "function": "function*"}
"""What every section may have: properties declared, functions run before or after it."""

_SYSTEM = {**_MODEL, "channel": "channel*"}
_GAS = {
    "place": "location!",
    "number": "x_radius y_radius z_radius x_width y_width z_width max_overpressure valve_coefficient fullness",
    "functions": "heat",
}
_GAS_SIZE = ("x_radius|x_width",)
_SWITCHES = (
    "simulation aerosurfaces rates velocities forces moments atmosphere massprops position coefficients aerodynamics "
    "ground_reactions fcs propulsion"
)

KINDS: dict[str, Kind] = {
    "fdm_config": kind(
        {
            "prose": "fileheader",
            "planet": "planet",
            "metrics": "metrics!",
            "mass_balance": "mass_balance!",
            "ground_reactions": "ground_reactions!",
            "external_reactions": "external_reactions",
            "buoyant_forces": "buoyant_forces",
            "propulsion": "propulsion",
            "system": "system*",
            "autopilot": "autopilot",
            "flight_control": "flight_control",
            "aerodynamics": "aerodynamics!",
            "aircraft-input": "input*",
            "aircraft-output": "output*",
            "child-aircraft": "child*",
        },
        "name version release",
    ),
    # leaves
    "prose": kind(attributes="*", form="prose"),
    "number": kind(
        attributes="unit=unit dispersion=number type=uniform|uniformsigned|gaussian|gaussiansigned", form="number"
    ),
    "plain": kind(attributes="unit", form="number"),
    "declaration": kind(attributes="value=number persistent=true|false", form="property"),
    "place": kind({"coordinate": "x! y! z!"}, "unit=unit name"),
    "angles": kind({"coordinate": "roll! pitch! yaw!"}, "unit=unit name"),
    "direction": kind({"coordinate": "x! y! z!"}, "unit=unit"),
    "coordinate": kind(
        attributes="dispersion=number type=uniform|uniformsigned|gaussian|gaussiansigned", form="number"
    ),
    "functions": kind({"function": "function+"}),
    # sections
    "metrics": kind(
        {
            **_MODEL,
            "number": "wingarea! wingspan! chord! wing_incidence htailarea htailarm vtailarea vtailarm",
            "reference-point": "location+",
        },
        "name",
        file=True,
    ),
    "reference-point": kind({"coordinate": "x! y! z!"}, "unit=unit name!=AERORP|EYEPOINT|VRP"),
    "mass_balance": kind(
        {**_MODEL, "number": "ixx iyy izz ixy ixz iyz emptywt", "centre": "location", "pointmass": "pointmass*"},
        "name negated_crossproduct_inertia=true|false",
        one_of=tuple(f"{name}|pointmass" for name in ("ixx", "iyy", "izz", "emptywt", "location")),
        file=True,
    ),
    "centre": kind({"coordinate": "x! y! z!"}, "unit=unit name!=CG|CG"),
    "pointmass": kind({"number": "weight!", "place": "location!", "form": "form"}, "name"),
    "form": kind({"number": "radius length"}, "shape!=tube|cylinder|sphere|ball"),
    "ground_reactions": kind({**_MODEL, "contact": "contact*"}, "name", file=True),
    "contact": kind(
        {
            "place": "location!",
            "number": "static_friction! dynamic_friction! rolling_friction spring_coeff max_steer retractable castered",
            "damping": "damping_coeff damping_coeff_rebound",
            "strut": "strut_force",
            "brake_group": "brake_group",
            "angles": "orientation",
            "cornering": "table*",
        },
        "name! type!=BOGEY|STRUCTURE",
        one_of=("spring_coeff|strut_force", "damping_coeff|strut_force"),
    ),
    "damping": kind(attributes="unit=unit type=SQUARE|LINEAR", form="number"),
    "strut": kind({"function": "function!"}),
    "brake_group": kind(form="any", words="LEFT RIGHT CENTER NOSE TAIL NONE"),
    "cornering": kind(
        {"variable": "independentVar*", "data": "tableData+"},
        "name!=CORNERING_COEFF|CORNERING_COEFF type=internal|internal",
    ),
    "external_reactions": kind({**_MODEL, "force": "force*", "moment": "moment*"}, "name", file=True),
    "force": kind(
        {"place": "location!", "direction": "direction", "function": "function"},
        "name! frame!=BODY|LOCAL|WIND|INERTIAL unit",
    ),
    "moment": kind({"direction": "direction!", "function": "function"}, "name! frame!=BODY|LOCAL|WIND|INERTIAL unit"),
    "buoyant_forces": kind({**_MODEL, "gas_cell": "gas_cell*"}, "name", file=True),
    "gas_cell": kind({**_GAS, "ballonet": "ballonet*"}, "type!=HYDROGEN|HELIUM|AIR name", one_of=_GAS_SIZE),
    "ballonet": kind({**_GAS, "functions": "heat blower_input"}, "type!=AIR|AIR name", one_of=_GAS_SIZE),
    "autopilot": kind(_SYSTEM, "name", file=True),
    "flight_control": kind(_SYSTEM, "name", file=True),
    "aerodynamics": kind(
        {
            **_MODEL,
            "axis": "axis*",
            "angle-limits": "alphalimits hysteresis_limits",
            "functions": "aero_ref_pt_shift_x",
        },
        "name",
        file=True,
    ),
    "axis": kind(
        {"function": "function*"},
        "name!=LIFT|DRAG|SIDE|AXIAL|NORMAL|X|Y|Z|ROLL|PITCH|YAW frame=BODY|STABILITY|WIND unit",
    ),
    "angle-limits": kind({"number": "min! max!"}, "unit=unit"),
    "aircraft-input": kind(
        {"declaration": "property*"},
        "name type=SOCKET|QTJSBSIM|NONE port=number rate=number action protocol=UDP|TCP",
        file=True,
    ),
    "aircraft-output": kind(
        {
            "logged": "property*",
            "function": "function*",
            "on-off": _SWITCHES,
            "time": "time",
        },
        "name type=CSV|TABULAR|SOCKET|FLIGHTGEAR|TERMINAL|NONE port=number rate=number protocol=UDP|TCP",
        file=True,
    ),
    "logged": kind(attributes="caption apply", form="property"),
    "on-off": kind(form="any", words="ON OFF"),
    "time": kind(attributes="type=simulation|real resolution=number"),
    "child-aircraft": kind({"place": "location!", "angles": "orient"}, "name! mated=true|false internal=true|false"),
    "planet": kind(
        {"number": "semimajor_axis equatorial_radius semiminor_axis polar_radius rotation_rate! GM! J2!"},
        "name",
        one_of=("semimajor_axis|equatorial_radius", "semiminor_axis|polar_radius"),
        file=True,
    ),
}
