"""What all kinds of moving air share."""

from __future__ import annotations

FIELD = "wind_n"
REFUSED_ON = {
    "analytic": (
        "no moving air: the analytic model is rotational only, it has no airspeed for the air to change",
        "fly it with plant: jsbsim (--plant jsbsim)",
    )
}
