"""Systems, autopilot and flight control: channels and their components."""

from __future__ import annotations

from uavftc.plants.jsbsim.strict.grammar import Kind, kind

_ALL = {"source": "input* init*", "target": "output*", "clipto": "clipto", "delay": "delay"}
"""What every component may have."""


def _component(children: dict[str, str] | None = None, attributes: str = "", *, one_of: tuple[str, ...] = ()) -> Kind:
    merged = dict(_ALL)
    for of, names in (children or {}).items():
        merged[of] = f"{merged[of]} {names}" if of in merged else names
    return kind(merged, f"name {attributes}", one_of=one_of)


_FILTERS = "lag_filter washout_filter lead_lag_filter second_order_filter"
_COMPONENTS = (
    "summer pure_gain scheduled_gain aerosurface_scale deadband switch kinematic fcs_function pid integrator actuator "
    "sensor accelerometer gyro magnetometer waypoint_heading waypoint_distance angle distributor linear_actuator"
)
_SYSTEM = {"declaration": "property*", "function": "function*", "channel": "channel*"}

_ERRORS = {
    "noise": "noise",
    "quantization": "quantization",
    "number": "bias gain drift_rate lag",
}
_MOUNTED = {**_ERRORS, "sense-axis": "axis", "angles": "orientation"}
_POINTS = {"angle-source": "target_latitude! target_longitude! source_latitude! source_longitude!", "plain": "radius"}

KINDS: dict[str, Kind] = {
    "system": kind(_SYSTEM, "name", file=True),
    "channel": kind(
        {f"{name}": f"{name}*" for name in (*_FILTERS.split(), *_COMPONENTS.split())},
        "name=prose execute=property execrate=number",
    ),
    # parts of components
    "source": kind(form="property"),
    "target": kind(form="property"),
    "clipto": kind({"value": "min! max!"}, "type=cyclic|cyclic"),
    "delay": kind(attributes="type=time|frames", form="value"),
    "value": kind(form="value"),
    "limits": kind({"number": "min! max!"}),
    "noise": kind(attributes="variation=PERCENT|ABSOLUTE distribution=UNIFORM|GAUSSIAN", form="number"),
    "quantization": kind({"number": "bits! min! max!"}, "name"),
    "sense-axis": kind(form="any", words="X Y Z x y z"),
    "angle-source": kind(attributes="unit=DEG|RAD", form="property"),
    # components
    **{name: _component({"value": "c1! c2 c3 c4 c5 c6"}, one_of=("input",)) for name in _FILTERS.split()[2:]},
    **{name: _component({"value": "c1!"}, one_of=("input",)) for name in _FILTERS.split()[:2]},
    "summer": _component({"number": "bias"}, one_of=("input",)),
    "pure_gain": _component({"value": "gain!"}, one_of=("input",)),
    "scheduled_gain": _component({"value": "gain", "table": "table!"}, one_of=("input",)),
    "aerosurface_scale": _component(
        {"value": "gain", "limits": "domain range!", "number": "zero_centered"}, one_of=("input",)
    ),
    "deadband": _component({"value": "width! gain"}, one_of=("input",)),
    "switch": _component({"default": "default", "test": "test*"}, one_of=("test|default",)),
    "default": kind(attributes="value!=value"),
    "kinematic": _component({"traverse": "traverse!", "mark": "noscale"}, one_of=("input",)),
    "traverse": kind({"setting": "setting+"}),
    "setting": kind({"number": "position! time!"}),
    "fcs_function": _component({"function": "function!"}),
    "pid": _component(
        {"value": "kp kd", "integral": "ki", "source": "trigger pvdot"},
        "type=standard|standard",
        one_of=("input", "kp|ki|kd"),
    ),
    "integral": kind(attributes="type=rect|trap|ab2|ab3", form="value"),
    "integrator": _component({"integral": "c1!", "source": "trigger"}, one_of=("input",)),
    "actuator": _component(
        {"value": "lag", "rate": "rate_limit*", "number": "bias deadband_width hysteresis_width"}, one_of=("input",)
    ),
    "rate": kind(attributes="sense=incr|increasing|decr|decreasing", form="value"),
    "sensor": _component(_ERRORS, one_of=("input",)),
    "gyro": _component({**_MOUNTED, "label": "location"}),  # where it sits does not matter, and is often said
    "accelerometer": _component({**_MOUNTED, "place": "location!"}),
    "magnetometer": _component({**_MOUNTED, "place": "location!"}),
    "waypoint_heading": _component(_POINTS, "unit=DEG|RAD"),
    "waypoint_distance": _component(_POINTS, "unit=FT|M"),
    "angle": _component({"angle-source": "source_angle! target_angle!"}, "unit=DEG|RAD"),
    "distributor": _component({"case": "case+"}, "type!=inclusive|exclusive"),
    "case": kind({"condition": "test", "distributed": "property+"}),
    "distributed": kind(attributes="value!=value", form="property"),
    "linear_actuator": _component(
        {"source": "set reset versus", "property-or-number": "bias", "number": "module hysteresis lag rate gain"},
        one_of=("input",),
    ),
    "property-or-number": kind(form="value"),
}
