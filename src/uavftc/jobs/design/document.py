"""A design as numbers: trim, linear pair, gains, L1 norms, and the bounds of the paper's theorems where they exist.

The document is what `uavftc design --json` prints. `trimmed.py` puts together what the trim and the linear model of
JSBSim give, `reference.py` what a flight adds; the theory of the inner loop is here. Where a number does not exist it
is None, and a `reason` next to it says why. Names ending in `_A_m` are the figures with A_m, the matrix of the plant
(27), in place of A_s.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from uavftc.aircraft.definition import load_aircraft
from uavftc.analysis.l1_condition import (
    ACCURACY,
    Given,
    Norms,
    condition_33,
    norms_of,
    theorem_2,
    theorem_2_weighted,
    theorem_3,
)
from uavftc.control.gains import erzberger_K_0, lyapunov_P, reference_gain
from uavftc.control.inner import l1
from uavftc.control.inner.matrices import MAX_CONDITION, condition_number
from uavftc.core.axes import ALL, Controlled, embedded, indices, reduced
from uavftc.errors import InputError
from uavftc.jobs.design.reference import flight_document, inner_of, l1_of
from uavftc.jobs.design.trimmed import design_model, held_axes, trimmed_sections
from uavftc.plants.jsbsim.model import notes, stepped
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

DEFAULT_SCENARIO = "scenario1"  # steps of 5 deg on every axis
NO_INVERSE = "B_m has no inverse: not every axis answers to its surface"
_NORMS = {
    "l1_norm_H": "H",
    "l1_norm_G": "G",
    "l1_norm_HCK": "HCK",
    "l1_norm_C": "C",
    "l1_norm_initial": "initial",
    "l1_norm_HCH_s": "HCH_s",
    "l1_norm_CH_s": "CH_s",
}


def design_document(
    aircraft_name: str,
    *,
    scenario: Scenario | None = None,
    flight: Scenario | None = None,
    given: Given | None = None,
    omega: tuple[float, float, float] = (1.0, 1.0, 1.0),
) -> dict[str, Any]:
    """Return the design of an aircraft's inner loop as one document of numbers, lists, texts and None.

    Parameters
    ----------
    aircraft_name
        As `load_aircraft`.
    scenario
        Controller, initial condition and reference are taken from it; default: those of `flight`, or of
        `DEFAULT_SCENARIO`, which is the paper's controller, the aircraft's condition, and 5 deg on each axis.
    flight
        Flown, and compared with the bounds; its controller must be that of `scenario`, where both are given.
    given
        What condition (33) and Theorem 3 are stated for.
    omega
        Effectiveness of aileron, elevator and rudder in C(s).

    Raises
    ------
    InputError
        If the aircraft cannot be loaded or trimmed, or the inner loop is not L1. An aircraft that trims but that the
        controller cannot fly is not an error here: its `verdict` is `refused`, with the `reasons`.
    """
    given = given or Given()
    aircraft = load_aircraft(aircraft_name, "AIRCRAFT")
    source = scenario or flight or load_scenario(DEFAULT_SCENARIO, aircraft=aircraft_name)
    inner = l1_of(inner_of(source), source)
    if scenario is not None and flight is not None and inner_of(flight) != inner:
        raise InputError(
            f"--flight {flight.name}",
            found=f"another inner loop than that of --scenario {scenario.name}",
            expected="one design: its bounds, and a flight with it",
            remedy="leave --scenario out; the design is then that of the flight",
        )
    model = stepped(aircraft, design_model(source, aircraft))
    document: dict[str, Any] = {
        "aircraft": aircraft.name,
        **trimmed_sections(source, aircraft, model),
        "warnings": notes(aircraft, model),
    }
    B_m = np.array(inner.B_m or (aircraft.analytic.B_m if aircraft.analytic else model.B_rates))
    document |= theory(inner, model.A_rates, B_m, given, omega, held_axes(model))
    if flight is not None:
        document["flight"] = flight_document(flight)
    return plain(document)


def theory(
    inner: l1.Config,
    A: np.ndarray,
    B_m: np.ndarray,
    given: Given,
    omega: tuple[float, float, float],
    axes: Controlled = ALL,
) -> dict[str, Any]:
    """Return gains, norms and bounds of an inner loop on a plant x2' = A x2 + B_m u; what has no B_m^-1 is None.

    Where an axis is not controlled, the system is that of the others, and its row and column are None in each matrix.
    """

    def whole(matrix: np.ndarray | None) -> np.ndarray | None:
        return None if matrix is None else embedded(matrix, axes, np.nan)

    A, B_m = reduced(A, axes), reduced(B_m, axes)
    A_m, K_1, Q, K_0 = (reduced(np.array(m), axes) for m in (inner.A_m, inner.K_1, inner.Q, inner.K_0))
    A_s = A_m + K_1
    P = lyapunov_P(A_s, Q)
    invertible = condition_number(B_m) < MAX_CONDITION
    K = reference_gain(A_m if inner.reference_gain == "plant" else A_s, B_m) if invertible else None
    document: dict[str, Any] = {
        name: whole(m) for name, m in (("B_m", B_m), ("A_m", A_m), ("K_1", K_1), ("A_s", A_s), ("Q", Q))
    }
    document |= {
        "reference_gain": inner.reference_gain,
        "K": whole(K),
        "K_2": whole(reference_gain(A_s, B_m) if invertible else None),
        "K_0": whole(K_0),
        "K_0_matching_A": whole(erzberger_K_0(A, A_m, B_m) if invertible else None),
        "P": whole(P),
        "lyapunov_residual": float(np.max(np.abs(A_s.T @ P + P @ A_s + Q))),
        "eigenvalues_A_m": _pairs(A_m),
        "eigenvalues_A_s": _pairs(A_s),
        "adaptation_gain": inner.adaptation_gain,
        "filter_bandwidth": inner.filter_bandwidth,
        "omega": [factor if own else None for factor, own in zip(omega, axes, strict=True)],
        "l1_norm_accuracy": ACCURACY,
        **given._asdict(),
    }
    factors = np.array(omega)[indices(axes)]
    for suffix, matrix in (("", A_s), ("_A_m", A_m)):
        if K is None:
            document |= bounds(None, given, suffix, NO_INVERSE)
            continue
        try:
            norms = norms_of(matrix, A_s=A_s, B_m=B_m, K=K, filter_bandwidth=inner.filter_bandwidth, omega=factors)
        except ValueError as error:  # A_m need not be stable, A_s is
            document |= bounds(None, given, suffix, str(error))
        else:
            document |= bounds(norms, given, suffix)
    document["theorem_2"] = _theorem_2(A_s, B_m, Q)
    return document


def bounds(norms: Norms | None, given: Given, suffix: str, reason: str | None = None) -> dict[str, Any]:
    """Return norms, condition (33) and Theorem 3 under their names in the document; all None for no norms."""
    if norms is None:
        keys = [*_NORMS, "sigma_in", "condition_holds", "lipschitz_max", "gamma_1", "gamma_2"]
        texts = ["condition_reason", "lipschitz_max_is", "reason"]
        return {f"{k}{suffix}": None for k in keys} | {f"{k}{suffix}": reason for k in texts}
    condition = condition_33(norms, given)
    theorem = theorem_3(norms, given, condition)
    values = {name: getattr(norms, field) for name, field in _NORMS.items()} | {
        "sigma_in": condition.sigma_in,
        "condition_holds": condition.holds,
        "condition_reason": condition.reason,
        "lipschitz_max": condition.lipschitz_max,
        "lipschitz_max_is": condition.lipschitz_max_is,
        **theorem._asdict(),
    }
    return {f"{name}{suffix}": value for name, value in values.items()}


def _theorem_2(A_s: np.ndarray, B_m: np.ndarray, Q: np.ndarray) -> dict[str, Any]:
    """Return Theorem 2's factors: as printed where they exist, weighted for any Q, and as printed for Q = 2 I."""
    result: dict[str, Any] = {"lambda_min_Q": float(np.linalg.eigvalsh(Q)[0]), "per_V": None, "per_e": None}
    result["reason"] = "lambda_min(Q) is not above 1: eq. (44) as printed divides by lambda_min(Q) - 1"
    if (own := theorem_2(lyapunov_P(A_s, Q), B_m, Q)) is not None:
        result |= own._asdict() | {"reason": None}
    result["weighted"] = theorem_2_weighted(lyapunov_P(A_s, Q), B_m, Q)._asdict()
    doubled_Q = 2.0 * np.eye(len(A_s))
    doubled = theorem_2(lyapunov_P(A_s, doubled_Q), B_m, doubled_Q)
    return result | {"with_Q_2I": None if doubled is None else doubled._asdict()}


def _pairs(matrix: np.ndarray) -> list[list[float]]:
    """Return the eigenvalues as [real, imaginary], the slowest first."""
    values = sorted(np.linalg.eigvals(matrix), key=lambda z: (-z.real, z.imag))
    return [[float(z.real), float(z.imag)] for z in values]


def plain(value: Any) -> Any:
    """Return a document with NumPy's numbers and arrays as Python's, and None for what is not finite."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
