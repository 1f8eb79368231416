"""The captions of the paper's Figures 2 to 11, as printed, and our remark next to figures of control activity."""

from __future__ import annotations

_TRACKING = "(a) Tracking curves of roll angle; (b) tracking curves of pitch angle; (c) tracking curves of yaw angle."
_WITHOUT_AND_WITH = (
    "(a) {Outer} without input saturation; (b) {outer} with input saturation; "
    "(c) {inner} without input saturation; (d) {inner} with input saturation."
)
_TWO_CONTROLLERS = (
    "(a) {Outer} of the proposed NNDONDI-L1 controller; (b) {inner} of the proposed NNDONDI-L1 controller; "
    "(c) {outer} of NNDONDI-MRAC controller; (d) {inner} of NNDONDI-MRAC controller."
)
_CONTROL = {
    "Outer": "Control outputs of the outer loop",
    "outer": "control outputs of the outer loop",
    "inner": "control outputs of the inner loop",
}
_ESTIMATES = {
    "Outer": "Disturbance estimations for the outer loop",
    "outer": "disturbance estimations for the outer loop",
    "inner": "disturbance estimations for the inner loop",
}
_LUMPED = _ESTIMATES | {"inner": "lumped disturbance estimations for the inner loop"}

HEADINGS: dict[int, str] = {
    2: "The response curves for sat(v2) and h(v2).",
    3: "Tracking performance of NNDONDI-L1 controller.",
    4: "Control output curves of NNDONDI-L1 controller.",
    5: "Disturbance estimation curves of NNDONDI-L1 controller.",
    6: "Tracking performance in scenario 2.",
    7: "Control output curves in scenario 2.",
    8: "Disturbance estimation curves in scenario 2.",
    9: "Tracking performance in scenario 3.",
    10: "Control output curves in scenario 3.",
    11: "Disturbance estimation curves in scenario 3.",
}
"""First sentence of each caption."""

_PANELS: dict[int, str] = {
    2: "",
    3: _TRACKING,
    4: _WITHOUT_AND_WITH.format(**_CONTROL),
    5: _WITHOUT_AND_WITH.format(**_LUMPED),
    6: _TRACKING,
    7: _TWO_CONTROLLERS.format(**_CONTROL),
    8: _TWO_CONTROLLERS.format(**_ESTIMATES),
    9: _TRACKING,
    10: _TWO_CONTROLLERS.format(**_CONTROL),
    11: _TWO_CONTROLLERS.format(**_ESTIMATES),
}

CAPTIONS: dict[int, str] = {number: f"{HEADINGS[number]} {_PANELS[number]}".strip() for number in HEADINGS}
"""Whole captions, without "Figure N." before them."""

NOISY = (
    "The gyro is exact here. With white noise of 0.05 deg/s rms on it the surfaces of L1 travel 22 to 35 rad in "
    "scenario 3 on JSBSim (without: 0.1 to 1.0) and those of MRAC 106 to 143: four to five times as far, not a hundred "
    "(python tools/noise_activity.py)."
)
"""Measured by the tool it names; tests/control/test_noise.py repeats it."""
