"""What all kinds of moving air share."""

from __future__ import annotations

FIELDS: tuple[str, ...] = ("wind_n",)
REFUSED_ON = {
    "analytic": (
        "no moving air: the analytic model is rotational only, it has no airspeed for the air to change",
        "fly it with plant: jsbsim (--plant jsbsim)",
    )
}


def name(kind: str, place: int) -> str:
    """Return the name of the block of the `place`-th entry of a kind."""
    return kind if place == 0 else f"{kind} {place + 1}"
