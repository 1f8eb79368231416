"""Functions, tables and tests: the operators that JSBSim 1.3 knows, each with its number of arguments."""

from __future__ import annotations

from uavftc.plants.jsbsim.strict.grammar import Kind, kind

_ARGUMENTS: dict[tuple[int, int | None], str] = {
    (1, None): "product sum avg difference min max",
    (2, None): "and or switch",
    (2, 2): "quotient pow fmod atan2 mod lt le gt ge eq nq",
    (1, 1): "toradians todegrees sqrt log2 ln log10 sign exp abs sin cos tan asin acos atan floor ceil fraction "
    "integer not",
    (1, 2): "roundmultiple",
    (3, 3): "ifthen",
    (5, None): "interpolate1d",
    (6, 6): "rotation_alpha_local rotation_beta_local rotation_gamma_local",
    (7, 7): "rotation_bf_to_wf rotation_wf_to_bf",
}
_TERMS = {
    "read": "property* p*",
    "constant": "value* v*",
    "mark": "pi*",
    "table": "table* t*",
    "random": "random*",
    "urandom": "urandom*",
    **{f"op-{name}": f"{name}*" for names in _ARGUMENTS.values() for name in names.split()},
}

KINDS: dict[str, Kind] = {
    # a function has one term: JSBSim evaluates the first and passes over the others
    "function": kind(_TERMS, "name type=pre|post|template apply_at_cg=true|false", arguments=(1, 1)),
    **{
        f"op-{name}": kind(_TERMS, "name", arguments=arguments)
        for arguments, names in _ARGUMENTS.items()
        for name in names.split()
    },
    "read": kind(attributes="apply", form="argument"),
    "constant": kind(form="number"),
    "mark": kind(),
    "random": kind(attributes="seed=seed mean=number stddev=number"),
    "urandom": kind(attributes="seed=seed lower=number upper=number"),
    "table": kind({"variable": "independentVar*", "data": "tableData+"}, "name type=internal|internal"),
    "variable": kind(attributes="lookup=axis", form="argument"),
    "data": kind({"data": "tableData*"}, "breakPoint=number", form="rows"),
    # <test> of a switch and of a distributor; tests nest
    "test": kind({"inner-test": "test*"}, "value!=value logic=OR|AND", form="conditions"),
    "inner-test": kind({"inner-test": "test*"}, "logic=OR|AND", form="conditions"),
    "condition": kind({"inner-test": "test*"}, "logic=OR|AND", form="conditions"),
}
