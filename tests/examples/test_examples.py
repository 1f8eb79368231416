"""A new effect is one file and its place in one tuple: each of these is flown from a scenario that names its keys."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

import uavftc

HERE = Path(__file__).parent


def flown(folder, scenario, chain, name, *, before="-", controller="-", wrong=()):
    """Fly a scenario with a module in its chain, in a separate process; return the records and what was found."""
    (folder / "scenario.yaml").write_text(scenario)
    for i, text in enumerate(wrong):
        (folder / f"wrong-{i}.yaml").write_text(text)
    command = [sys.executable, HERE / "flown.py", *chain.rsplit(".", 1), name, before, controller, folder]
    environment = os.environ | {"PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    assert found["same"]  # the scenario as flown, written and read again, is the same
    return np.load(folder / "records.npy"), SimpleNamespace(**found)


HEAD = "name: example\nduration_s: 4\nplant: analytic\nreference: {phi_deg: 5, theta_deg: 3, psi_deg: -2}\n"
LIMITS = "saturation: {min_rad: -0.02, max_rad: 0.03}\n"


def limited(records):
    return np.clip(records["v2"], -0.02, 0.03)


class TestSoftLinkage:
    CHAIN = ("uavftc.actuators.CHAIN", "soft_linkage")
    CONSTANT = (
        "import numpy as np\n"
        "def create(design, h, options):\n"
        "    v2 = np.array(options['v2'])\n"
        "    return lambda t, x1_c, x1, x2: v2\n"
    )

    @pytest.mark.parametrize("substeps", [1, 4])
    def test_a_step_of_the_command_is_followed_by_the_closed_form(self, tmp_path, substeps):
        # y = c (1 - exp(-w t)) at the end of each plant step, of which the row keeps the first
        (tmp_path / "constant.py").write_text(self.CONSTANT)
        scenario = (
            f"name: lag\nduration_s: 0.5\nplant: analytic\nsimulation: {{substeps: {substeps}}}\n"
            "controller: {kind: ./constant.py, options: {v2: [0.004, -0.5, 0.002]}}\n"
            f"{LIMITS}actuators: {{linkage_radps: 25}}\n"
        )
        records, found = flown(tmp_path, scenario, *self.CHAIN, before="effectiveness")
        assert found.completed
        steps = substeps * np.arange(len(records)) + 1
        expected = np.outer(1.0 - np.exp(-25.0 * 0.005 / substeps * steps), [0.004, -0.02, 0.002])
        np.testing.assert_allclose(records["u2"], expected, rtol=0, atol=1e-15)

    def test_it_stands_behind_the_limits_and_filters_the_loop(self, tmp_path):
        # of the limited command, recomputed from the published columns by another filter
        scenario = f"{HEAD}{LIMITS}actuators: {{linkage_radps: 25}}\n"
        wrong = [
            HEAD + "actuators: {linkage_radp: 25}\n",
            HEAD + "actuators: {linkage_radps: 0}\n",
            HEAD + "actuator: {linkage_radps: 25}\n",
        ]
        records, found = flown(tmp_path, scenario, *self.CHAIN, before="effectiveness", wrong=wrong)
        assert found.completed
        names = found.blocks[found.blocks.index("allocation") : found.blocks.index("gather")]
        assert names[:3] == ["allocation", "saturation", "soft_linkage"]
        share = 1.0 - np.exp(-25.0 * found.plant_step)
        assert np.abs(limited(records) - records["v2"]).max() > 0.01  # it met the limits
        expected = lfilter([share], [1.0, share - 1.0], limited(records), axis=0)
        np.testing.assert_allclose(records["u2"], expected, rtol=0, atol=1e-15)
        assert "linkage_radps: 25.0" in found.text
        assert "linkage_radps" in found.schema["$defs"]["Actuators"]["properties"]
        unknown, zero, section = found.refused.values()
        assert "line 5, key actuators.linkage_radp" in unknown
        assert "the unknown key 'linkage_radp'" in unknown
        assert "linkage_radps, or the name of a surface with a section of its own" in unknown
        assert "did you mean linkage_radps?" in unknown
        assert "a number greater than 0, rad/s" in zero
        assert "did you mean actuators?" in section

    def test_one_surface_has_its_own_and_the_servo_of_the_project_acts_before_it(self, tmp_path):
        # the names of effectors take the keys of a new effect too, and each leaves out what it does not change
        actuators = "actuators: {backlash_deg: 0.1, linkage_radps: 25, rudder: {linkage_radps: null}}\n"
        records, found = flown(tmp_path, HEAD + LIMITS + actuators, *self.CHAIN, before="effectiveness")
        names = found.blocks[found.blocks.index("allocation") : found.blocks.index("gather")]
        assert names[:4] == ["allocation", "saturation", "backlash", "soft_linkage"]
        play, half = np.zeros_like(records["v2"]), np.radians(0.05)
        for k, u in enumerate(limited(records)):
            play[k] = np.clip(play[k - 1] if k else 0.0, u - half, u + half)
        share = 1.0 - np.exp(-25.0 * found.plant_step)
        followed = lfilter([share], [1.0, share - 1.0], play, axis=0)
        np.testing.assert_allclose(records["u2"][:, :2], followed[:, :2], rtol=0, atol=1e-15)
        np.testing.assert_allclose(records["u2"][:, 2], play[:, 2], rtol=0, atol=1e-15)

    def test_without_its_key_it_is_not_there(self, tmp_path):
        # an effect that does nothing costs nothing: no block of it, and the flight is that without it
        records, found = flown(tmp_path, HEAD + LIMITS, *self.CHAIN, before="effectiveness")
        assert "soft_linkage" not in found.blocks
        np.testing.assert_array_equal(records["u2"], limited(records))
        assert "linkage_radps: null" in found.text


class TestJam:
    CHAIN = ("uavftc.actuators.CHAIN", "jam")
    FAULTS = (
        "faults:\n"
        "  - {surface: aileron, start_s: 0.5, effectiveness: 0.5}\n"
        "  - {kind: jam, surface: elevator, start_s: 1, end_s: 2}\n"
        "  - {kind: effectiveness, surface: rudder, end_s: 1, bias_deg: 0.1}\n"
        "  - {kind: jam, surface: rudder, start_s: 2.5}\n"
    )

    def test_a_surface_stays_where_it_was_inside_its_window(self, tmp_path):
        # the others, and the same one outside, do as commanded
        records, found = flown(tmp_path, HEAD + LIMITS + self.FAULTS, *self.CHAIN, before="stops")
        assert found.completed
        assert [name for name in found.blocks if name.startswith("jam")] == ["jam 0", "jam 1"]
        expected, t = limited(records), records["t"]
        expected[t >= 0.5, 0] *= 0.5
        expected[t < 1.0, 2] += np.radians(0.1)
        for surface, window in ((1, (t >= 1.0) & (t < 2.0)), (2, t >= 2.5)):
            assert np.ptp(expected[window, surface]) > 1e-4  # it was commanded to move
            expected[window, surface] = expected[np.argmax(window) - 1, surface]
        np.testing.assert_allclose(records["u2"], expected, rtol=0, atol=1e-15)

    def test_its_kind_is_one_of_those_listed_and_written(self, tmp_path):
        # messages, schema and text come of the files in the chain; an entry without a kind is the paper's fault
        wrong = [
            HEAD + "faults: [{kind: jam, surface: elevator, effectiveness: 0.5}]\n",
            HEAD + "faults: [{kind: stock, surface: elevator}]\n",
            HEAD + "faults: [{kind: jam, surface: 3}]\n",
            HEAD + "faults: [{kind: jam, surface: rudder, start_s: 1}, {surface: rudder, start_s: 2}]\n",
        ]
        _, found = flown(tmp_path, HEAD + self.FAULTS, *self.CHAIN, before="stops", wrong=wrong)
        assert "- {kind: jam, surface: elevator, start_s: 1.0, end_s: 2.0}" in found.text
        assert "- {surface: aileron, start_s: 0.5, end_s: null, effectiveness: 0.5, bias_deg: 0.0}" in found.text
        assert '"jam"' in json.dumps(found.schema["$defs"])
        key, kind, surface, overlap = found.refused.values()
        assert "line 5, key faults[0].effectiveness" in key
        assert "expected: one of kind, start_s, end_s, known, known_after_s, surface" in key
        assert "it belongs to kind effectiveness" in key
        assert "key faults[0].kind" in kind
        assert "effectiveness, intermittent" in kind
        assert "did you mean stuck?" in kind
        assert "key faults[0].surface" in surface
        assert "expected: a text" in surface
        assert "faults[1] on [2, end) s overlaps faults[0] on [1, end) s, both on the rudder" in overlap


class TestGyroRange:
    CHAIN = ("uavftc.sensors.CHAIN", "gyro_range")

    def test_the_controller_is_shown_rates_within_the_range(self, tmp_path):
        # after the bias, as in the chain; the vehicle's own rates stay what they are
        sensors = "sensors: {gyro_bias_degps: [0.1, 0, 0], gyro_range_degps: [0.5, 1.5, 20]}\n"
        wrong = [HEAD + "sensors: {gyro_rang_degps: 0.02}\n"]
        records, found = flown(tmp_path, HEAD + sensors, *self.CHAIN, wrong=wrong)
        assert found.completed
        assert [name for name in found.blocks if name in ("exact", "sensor_bias", "gyro_range")] == [
            "exact", "sensor_bias", "gyro_range",
        ]  # fmt: skip
        most = np.radians([0.5, 1.5, 20.0])
        assert (np.abs(records["x2"]).max(axis=0) > most).tolist() == [True, True, False]
        expected = np.clip(records["x2"] + np.radians([0.1, 0.0, 0.0]), -most, most)
        np.testing.assert_array_equal(records["x2_meas"], expected)
        assert "  gyro_range_degps: [0.5, 1.5, 20.0]" in found.text
        assert "gyro_range_degps" in found.schema["$defs"]["Sensors"]["properties"]
        (unknown,) = found.refused.values()
        assert "line 5, key sensors.gyro_rang_degps" in unknown
        assert "did you mean gyro_range_degps?" in unknown


class TestProportional:
    CHAIN = ("uavftc.control.inner.KINDS", "proportional")

    def test_it_flies_as_a_controller_by_name(self, tmp_path):
        # --controller nndondi-proportional; the command is recomputed from the published columns
        scenario = HEAD.replace("duration_s: 4", "duration_s: 20")
        records, found = flown(tmp_path, scenario, *self.CHAIN, controller="nndondi-proportional")
        assert found.completed
        assert found.controller == "nndondi-proportional"
        assert found.warnings == []
        error = records["v1"] - records["x2_meas"]
        expected = np.linalg.solve(np.array(found.B), 6.0 * error.T).T
        np.testing.assert_allclose(records["v2"], expected, rtol=1e-12, atol=1e-15)
        left = np.degrees(np.abs(records["x1_c"] - records["x1"])[-1])
        assert left.max() < 0.1  # of 5 deg: the roll damping, 8.5 rad/s against k = 6, slows the loop to 0.2 rad/s
        assert "kind: proportional, gain_radps: 6.0" in found.text

    def test_it_is_chosen_by_a_scenario_with_its_keys(self, tmp_path):
        # and refuses those of another law, by the name of the law they belong to
        wrong = [
            HEAD + "controller: {inner: {kind: proportional, filter_bandwidth: 9}}\n",
            HEAD + "controller: {inner: {kind: proportionate}}\n",
        ]
        scenario = HEAD + "controller: {outer: {kind: ndi}, inner: {kind: proportional, gain_radps: 9}}\n"
        records, found = flown(tmp_path, scenario, *self.CHAIN, wrong=wrong)
        assert found.controller == "ndi-proportional"
        expected = np.linalg.solve(np.array(found.B), 9.0 * (records["v1"] - records["x2_meas"]).T).T
        np.testing.assert_allclose(records["v2"], expected, rtol=1e-12, atol=1e-15)
        assert "proportional" in json.dumps(found.schema)
        assert "gain_radps" in json.dumps(found.schema)
        key, kind = found.refused.values()
        assert "key controller.inner.filter_bandwidth" in key
        assert "expected: one of kind, gain_radps" in key
        assert "it belongs to kind l1" in key
        assert "expected: one of l1, mrac, proportional" in kind

    def test_it_flies_an_aircraft_of_six_degrees_of_freedom(self, tmp_path):
        # one without a linear pair too: trimmed, judged for its authority, and flown
        scenario = HEAD.replace("analytic", "jsbsim").replace("duration_s: 4", "duration_s: 2")
        scenario += "aircraft: jsbsim:c172p\ninitial: {airspeed_mps: 55, altitude_m: 1000}\n"
        records, found = flown(tmp_path, scenario, *self.CHAIN, controller="ndi-proportional")
        assert found.completed
        expected = np.linalg.solve(np.array(found.B), 6.0 * (records["v1"] - records["x2_meas"]).T).T
        np.testing.assert_allclose(records["v2"], expected, rtol=1e-12, atol=1e-15)


class TestDoublet:
    CHAIN = ("uavftc.environment.KINDS", "doublet")
    ENTRY = "disturbances:\n  - {kind: doublet, start_s: 1, length_s: 2, peak_degps2: 3}\n"

    def test_it_is_the_disturbance_of_the_rows_and_turns_the_vehicle(self, tmp_path):
        # d2 by its closed form; over the first sample of it the roll rate gains h d2
        wrong = [
            HEAD + "disturbances: [{kind: doublet, start_s: 1, length_s: 2, peak_degps: 3}]\n",
            HEAD + "disturbances: [{kind: dublet}]\n",
            HEAD + "disturbances: [{kind: doublet, length_s: 2, peak_degps2: t}]\n",
            HEAD + "disturbances: [{kind: turbulence}]\n",
        ]
        records, found = flown(tmp_path, HEAD + self.ENTRY, *self.CHAIN, wrong=wrong)
        assert found.completed
        t = records["t"]
        expected = np.radians(3.0) * (1.0 * ((t >= 1.0) & (t < 2.0)) - 1.0 * ((t >= 2.0) & (t < 3.0)))
        np.testing.assert_allclose(records["d2"], np.outer(expected, [1.0, 0.0, 0.0]), rtol=1e-15)
        still, _ = flown(tmp_path, HEAD, *self.CHAIN)
        gained = (records["x2"] - still["x2"])[:202]
        assert not gained[:201].any()  # t = 1 s is row 200, and its rate is from before
        np.testing.assert_allclose(gained[201], [0.005 * np.radians(3.0), 0.0, 0.0], rtol=0.03, atol=1e-5)
        assert "- {kind: doublet, start_s: 1.0, length_s: 2.0, peak_degps2: 3.0}" in found.text
        assert "peak_degps2" in json.dumps(found.schema)
        key, kind, expression, turbulence = found.refused.values()
        assert "key disturbances[0].peak_degps" in key
        assert "expected: one of kind, start_s, length_s, peak_degps2" in key
        assert "did you mean peak_degps2?" in key
        assert "angular-acceleration, attitude-rate, wind, shear, gust, gust-train, turbulence, doublet" in kind
        assert "did you mean doublet?" in kind
        assert "a finite number, deg/s^2" in expression
        assert "give severity: light, moderate or severe" in turbulence
