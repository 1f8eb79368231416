"""Variants: one controller flown again with keys changed, under a name of its own; files, figures and tables say so."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from uavftc.errors import InputError
from uavftc.jobs.compare import compare, load_combinations
from uavftc.report.palette import looks
from uavftc.report.side_by_side import markdown, tidy_csv, variant_lines
from uavftc.results.history import read_history, read_metadata

SOURCE = """
import numpy as np
def create(design, h, options):
    B_inverse, k = np.linalg.pinv(design.B), options.get("k", 4.0)
    return lambda t, x1_c, x1, x2: B_inverse @ (k * (0.5 * (x1_c - x1) - x2))
"""


@pytest.fixture
def controller(tmp_path):
    (tmp_path / "mine.py").write_text(SOURCE, encoding="utf-8")
    return str(tmp_path / "mine.py")


def test_one_file_is_flown_twice_with_other_options(controller, tmp_path):
    loaded = load_combinations(
        "scenario1", plants="analytic", controllers=f"{controller},pid", overrides=["duration_s=2"],
        variants=["k6:controller.options.k=6"],
    )  # fmt: skip
    assert list(loaded) == [("analytic", "mine"), ("analytic", "pid"), ("analytic", "k6")]
    document = compare(loaded, tmp_path / "out", figures=True)
    assert document["controllers"] == ["mine", "pid", "k6"]
    assert document["completed"]
    flight = document["combinations"][2]
    assert flight["controller"] == "k6"
    assert flight["variant"] == {"of": "mine", "changes": ["controller.options.k=6"]}
    assert "variant" not in document["combinations"][0]
    mine, k6 = (read_history(tmp_path / "out" / "histories" / f"analytic-{n}.parquet") for n in ("mine", "k6"))
    B_inverse = np.linalg.inv([[10, 0, 0.225], [0, 7.5, 0], [1.125, 0, 6.75]])
    for history, k in ((mine, 4.0), (k6, 6.0)):  # at the first sample x1 = x2 = 0
        expected = B_inverse @ (k * 0.5 * np.array([history[f"{a}_ref_rad"][0] for a in ("phi", "theta", "psi")]))
        shown = [history[f"{s}_cmd_rad"][0] for s in ("aileron", "elevator", "rudder")]
        np.testing.assert_allclose(shown, expected, rtol=1e-9)
    assert "k: 6" in read_metadata(tmp_path / "out" / "histories" / "analytic-k6.parquet")["scenario"]
    assert variant_lines(document) == ["k6: mine with controller.options.k=6"]
    assert "- k6: mine with controller.options.k=6" in markdown(document)
    assert {row["controller"] for row in csv.DictReader(io.StringIO(tidy_csv(document)))} == {"mine", "pid", "k6"}
    assert looks(list(loaded))["analytic", "k6"]["label"] == "k6"
    compare(loaded, tmp_path / "out", figures=False)  # its own folder is replaced


def test_a_variant_of_the_scenarios_controller_on_each_plant_and_of_several_keys():
    variants = [
        "fast:controller.inner.filter_bandwidth=120", "late:controller.delay_s=0.01",
        "fast:controller.rate_hz=400",
    ]  # fmt: skip
    loaded = load_combinations("scenario2", variants=variants)
    assert list(loaded) == [(p, c) for p in ("jsbsim", "analytic") for c in ("nndondi-l1", "fast", "late")]
    base, fast, late = (loaded["jsbsim", name].controller for name in ("nndondi-l1", "fast", "late"))
    assert fast.inner.filter_bandwidth == 120 != base.inner.filter_bandwidth
    assert (base.rate_hz, fast.rate_hz, late.rate_hz) == (200, 400, 200)
    assert (base.delay_s, late.delay_s) == (0.0, 0.01)
    assert loaded.variants["fast"]["changes"] == [variants[0][5:], variants[2][5:]]
    assert loaded["analytic", "fast"].plant == "analytic"


WRONG = {
    "controller.delay_s=1": ("no name before a colon", "NAME:KEY=VALUE"),
    "a b:controller.delay_s=1": ("the name 'a b'", "letters, digits"),
    "../x:controller.delay_s=1": ("the name '../x'", "letters, digits"),
    "pid:controller.delay_s=1": ("pid, which is one of the controllers", "a name of its own"),
    "x:plant=analytic": ("the key plant", "below controller"),
    "x:controller.kind=./b.py": ("the key controller.kind", "name another controller in --controllers"),
    "x:": ("no key", "below controller"),
    "x:controller.delay_s": ("no '='", "KEY=VALUE"),
    "x:controller.delay=1": ("delay", "did you mean"),
}


@pytest.mark.parametrize("text", WRONG)
def test_a_variant_that_is_wrong_is_refused_with_its_option(text):
    words = WRONG[text]
    with pytest.raises(InputError) as error:
        load_combinations("scenario1", plants="analytic", controllers="pid", variants=[text])
    message = str(error.value)
    assert f"--variant {text}" in message
    for word in words:
        assert word in message, message


def test_the_same_controller_twice_is_told_of_variants():
    with pytest.raises(InputError, match="--variant NAME:KEY=VALUE flies it with other options"):
        load_combinations("scenario1", controllers="pid,pid")
