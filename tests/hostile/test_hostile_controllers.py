"""Hostile controllers end with exit code 2 at the trial and 3 in flight, one message each, and the history kept."""

from __future__ import annotations

from pathlib import Path

import pytest
from hostile_controllers import FLIGHT, TRIAL, cases, report, run_all


def test_there_are_as_many_cases_as_promised_and_each_has_a_name() -> None:
    # a generator that yields nothing would pass for a suite without defects
    names = [case.name for case in cases()]
    assert len(set(names)) == len(names) >= 130
    assert {case.code for case in cases()} == {TRIAL, FLIGHT}


@pytest.mark.slow
def test_no_hostile_controller_breaks_its_promise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # exit code, no traceback, one message, nothing written at the trial, every row kept in flight
    n, found = run_all(tmp_path)
    with capsys.disabled():
        print(f"\n{report(n, found)}")
    assert n >= 130
    assert found == []
