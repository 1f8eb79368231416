"""Loading is strict: what JSBSim lets pass, aborts on or crashes on is an InputError that names the place.

Each case is one typing error in a copy of hale. Every other path through the same code is the shipped aircraft, which
must load; so a check that refused everything would fail here too.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys

import jsbsim
import numpy as np
import pytest

from flying import bare, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft
from uavftc.core.signals import as_records, empty_rows
from uavftc.errors import InputError
from uavftc.plants.jsbsim import measure, model
from uavftc.plants.jsbsim.load import load


def make(folder):
    """Load an aircraft as a flight does: companion, trimmed model from a child process, load."""
    return jsbsim_plant(load_aircraft(str(folder)), has_moment=True)


def measured(aircraft):
    return model.trimmed_model(aircraft, 30.0, 1000.0)


def kept(aircraft):
    """Return the files that remember this aircraft's trimmed models."""
    return list(model.cache_dir().glob(f"{aircraft.sha256()[:32]}-*"))


@pytest.fixture
def no_child(monkeypatch):
    """Make a child process an error, and let nothing be known in this process."""

    def child(*_args, **_options):
        raise AssertionError("a child process was started")

    monkeypatch.setattr(subprocess, "Popen", child)
    model._cached.cache_clear()


def line_of(folder, file, text):
    """Return the number of the first line of a file that holds the text."""
    lines = (folder / file).read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, start=1) if text in line)


IXZ = '<ixz unit="SLUG*FT2">6221.33672915</ixz>'

# name: file, changes, what the error must hold; {line} is the line of the first changed text
TYPOS = {
    # an element that JSBSim passes over in silence
    "emptywt": ("hale.xml", [("emptywt", "emptywgt")], ["hale.xml, line {line}", "<emptywgt>", "write <emptywt>"]),
    "ixz": ("hale.xml", [(IXZ, IXZ.replace("ixz", "ixzz"))], ["hale.xml, line {line}", "<ixzz>", "ixz, iyy"]),
    "iyy": ("hale.xml", [("iyy", "iyyy")], ["hale.xml, line {line}", "<iyyy>", "write <iyy>"]),
    "root tag": ("hale.xml", [("fdm_config", "fdm_konfig")], ["hale.xml, line 3", "<fdm_konfig>", "fdm_config"]),
    "section": (
        "hale.xml",
        [("mass_balance", "mas_balance")],
        ["hale.xml, line {line}", "<mas_balance>", "write <mass_balance>"],
    ),
    # a value that says something else than the companion file
    "sign of ixz": ("hale.xml", [(IXZ, IXZ.replace("6221", "-6221"))], ["hale.xml", "inertia", "8435", "-8435"]),
    "KG*M2": (
        "hale.xml",
        [('<iyy unit="SLUG*FT2">4656.96741054</iyy>', '<iyy unit="KG*M2">6314</iyy>')],
        ["hale.xml", "inertia", "6313.43", "9e-5 off"],
    ),
    "mass claimed": ("uavftc.yaml", [("mass_kg: 425", "mass_kg: 426")], ["mass", "426 kg", "uavftc.yaml"]),
    "span claimed": ("uavftc.yaml", [("span_m: 50", "span_m: 50.001")], ["span", "50.001 m", "uavftc.yaml"]),
    # what JSBSim refuses itself, in a way that must not escape as another exception
    "unit": ("hale.xml", [('<wingarea unit="M2">', '<wingarea unit="M22">')], ["hale.xml, line {line}", '"M22"']),
    "no number": ("hale.xml", [(">50</wingspan>", ">fifty</wingspan>")], ["hale.xml, line {line}", "fifty"]),
    "axis": ("hale.xml", [('axis name="ROLL"', 'axis name="ROL"')], ["hale.xml, line {line}", "ROL"]),
    "operator": (
        "hale.xml",
        [("<pow>", "<powe>"), ("</pow>", "</powe>")],
        ["hale.xml, line", "<powe>"],
    ),
    "malformed": ("hale.xml", [("</metrics>", "</metric>")], ["hale.xml, line {line}", "malformed XML"]),
    "malformed engine": (
        "engine/hale_motor.xml",
        [("</electric_engine>", "")],
        ["engine/hale_motor.xml, line 7", "malformed XML"],
    ),
    "missing engine": ("hale.xml", [('file="hale_motor"', 'file="no_motor"')], ["line {line}", "no_motor"]),
    "missing system": ("hale.xml", [('file="hale_autothrottle"', 'file="no_system"')], ["line {line}", "no_system"]),
    "missing planet": ("uavftc.yaml", [("planet: flat_planet", "planet: no_planet")], ["no_planet.xml"]),
    "unit in planet": ("flat_planet.xml", [("RAD/SEC", "RAD/SECOND")], ["flat_planet.xml, line {line}", "RAD/SECOND"]),
    "space in an XML property": (
        "hale.xml",
        [("<property>aero/beta-rad</property>", "<property>aero/beta rad</property>")],
        ["hale.xml", "aero/beta rad"],
    ),
    # what aborts the process from native code
    "property of an aerodynamic function": (
        "hale.xml",
        [("<property>aero/beta-rad</property>", "<property>aero/bata-rad</property>")],
        ["hale.xml", "aero/bata-rad"],
    ),
    "input of a component": (
        "hale.xml",
        [("<input>fcs/elevator-sum</input>", "<input>fcs/elevator-summ</input>")],
        ["hale.xml", "fcs/elevator-summ"],
    ),
    # names in the companion file: JSBSim would create them silently
    "command": ("uavftc.yaml", [("fcs/left-aileron-cmd-norm", "fcs/aileron-cmd")], ["uavftc.yaml", "aileron.command"]),
    "elevator": ("uavftc.yaml", [("fcs/elevator-cmd-norm", "fcs/elevator-cmd")], ["uavftc.yaml", "elevator.command"]),
    "position": ("uavftc.yaml", [("fcs/rudder-pos-rad", "fcs/ruder-pos-rad")], ["uavftc.yaml", "rudder.position"]),
    "throttle": (
        "uavftc.yaml",
        [("fcs/throttle-cmd-norm[0]", "fcs/throtle[0]")],
        ["uavftc.yaml", "left_motor.throttle"],
    ),
    "autothrottle": ("uavftc.yaml", [("ap/at-on", "ap/att-on")], ["uavftc.yaml", "autothrottle.switch", "ap/att-on"]),
    "moment": ("uavftc.yaml", [("moment: dist ", "moment: dst ")], ["uavftc.yaml", "disturbance_moment", "dst/l"]),
    # names that abort the process as soon as JSBSim is asked for them
    "name with a space": (
        "uavftc.yaml",
        [("fcs/rudder-cmd-norm", "fcs/rudder cmd")],
        ["uavftc.yaml, line {line}, key effectors.rudder.command", "fcs/rudder cmd"],
    ),
    "name with a mark": ("uavftc.yaml", [("fcs/rudder-cmd-norm", "fcs/rudder!")], ["line {line}", "fcs/rudder!"]),
    "name with a digit first": ("uavftc.yaml", [("fcs/rudder-cmd-norm", "fcs/9r")], ["line {line}", "fcs/9r"]),
}


@pytest.mark.parametrize("name", TYPOS)
def test_a_typing_error_is_reported_with_its_place(name, edited):
    # Given hale with one typing error, when it is made ready for flight, then the error names file, place and word.
    file, changes, expected = TYPOS[name]
    folder = edited(file, *changes)
    line = line_of(folder, file, changes[0][1]) if changes[0][1] else 0
    with pytest.raises(InputError) as error:
        make(folder)
    text = str(error.value)
    for part in expected:
        assert part.format(line=line) in text
    assert error.value.found
    assert error.value.remedy


def test_hale_loads_and_is_remembered(hale, own_cache, request):
    # A good aircraft passes, and the next process starts no child: a flight must not pay for one each time.
    model._cached.cache_clear()  # of what this process knows already
    first = measured(hale)
    assert own_cache in model.cache_dir().parents
    assert len(kept(hale)) >= 1
    request.getfixturevalue("no_child")
    assert measured(hale) == first


def test_a_changed_engine_file_is_measured_again(edited, no_child):
    # What is kept goes by the checksum of all files: a change in an engine file makes another aircraft of it.
    folder = edited("engine/hale_motor.xml", ("25000", "26000"))
    changed = load_aircraft(str(folder))
    assert changed.sha256() != load_aircraft("hale").sha256()
    assert not kept(changed)
    with pytest.raises(AssertionError, match="child process was started"):
        measured(changed)


def test_a_crash_is_not_remembered(edited):
    # What aborted once must be refused at the second try as well, and be tried again once JSBSim is another.
    # A function of itself runs JSBSim out of its stack.
    folder = edited("hale.xml", ("<property>aero/beta-rad</property>", "<property>aero/force/CY_beta</property>"))
    aircraft = load_aircraft(str(folder))
    for _ in range(2):
        with pytest.raises(InputError, match="SIGSEGV") as error:
            measured(aircraft)
        assert str(folder / "hale.xml") in error.value.where
        assert "crashes" in error.value.found
    assert not kept(aircraft)


def test_what_does_not_load_is_reported_with_its_own_path(edited, tmp_path):
    # Two folders with the same mistake have the same checksum: a message about one must not be repeated for the other.
    folder = edited("hale.xml", ("emptywt", "emptywgt"))
    other = tmp_path / "other" / "hale"
    shutil.copytree(folder, other)
    for place in (folder, other):
        with pytest.raises(InputError, match=re.escape(str(place / "hale.xml"))):
            measured(load_aircraft(str(place)))


def test_a_condition_without_a_trim_is_remembered(hale, request):
    # Finding no trim takes longer than finding one; the second refusal says the same without another search.
    def refusal():
        with pytest.raises(InputError, match="trim at 3 m/s") as error:
            model.trimmed_model(hale, 3.0, 1000.0)
        return str(error.value)

    first = refusal()
    request.getfixturevalue("no_child")
    assert refusal() == first


def test_a_child_that_does_not_end_is_reported(hale, monkeypatch):
    # An aircraft at which JSBSim hangs must not hang the command line.
    monkeypatch.setattr(model, "TIMEOUT_S", 0.01)
    with pytest.raises(InputError, match=re.escape("does not finish loading and trimming it within 0.01 s")):
        model.trimmed_model(hale, 29.0, 1000.0)


def test_a_folder_without_its_files_is_reported(edited):
    # The two files that make an aircraft are named when one is missing.
    folder = edited("hale.xml", ("hale", "hale"))
    (folder / "hale.xml").unlink()
    with pytest.raises(InputError, match=re.escape("without hale.xml")):
        make(folder)


def test_every_flight_has_a_fresh_executive(hale, monkeypatch):
    # load_model twice on one FGFDMExec crashes at its destruction, and a reset keeps wind and moments.
    made = []

    class Counting(jsbsim.FGFDMExec):
        def __init__(self, *args):
            made.append([self, 0])

        def load_model(self, *args):
            next(entry for entry in made if entry[0] is self)[1] += 1
            return super().load_model(*args)

    monkeypatch.setattr(jsbsim, "FGFDMExec", Counting)
    plants = [jsbsim_plant(hale, has_moment=True) for _ in range(3)]
    assert len(made) >= len(plants)
    assert {loads for _, loads in made} == {1}
    assert len({id(plant.fdm) for plant in plants}) == 3


def test_flights_in_one_process_do_not_disturb_each_other(hale):
    # Given a flight that was pushed by d2, when another starts after it and in step with it, it is as if alone.
    def fly(pushed):
        plant = jsbsim_plant(hale, has_moment=True)
        rows = empty_rows(200, 4)
        as_records(rows)["d2"] = (0.3, 0.1, 0.2) if pushed else 0.0
        return plant, bare(plant), rows

    plant, program, alone = fly(pushed=False)
    plant.run(program, alone, 0, 200)
    flights = [fly(pushed=True), fly(pushed=False)]
    for k in range(200):
        for plant, program, rows in flights:
            plant.run(program, rows, k, k + 1)
    assert flights[1][2].tobytes() == alone.tobytes()
    assert np.ptp(as_records(flights[0][2])["x2"][:, 0]) > 0.01


def test_dt_is_set_before_the_load(hale):
    # FCS components keep the frame time they are loaded with: another dt after the load would falsify their filters.
    assert load(hale, 0.002).get_delta_t() == 0.002


def test_first_load_off_the_main_thread_is_refused():
    # Installing JSBSim's logger off the main thread crashes the process; the guard says so in Python instead.
    code = """
import threading
from uavftc.aircraft.definition import load_aircraft
from uavftc.plants.jsbsim.load import load
def work():
    try:
        load(load_aircraft("hale"), 0.005)
    except RuntimeError as error:
        print("refused:", error)
thread = threading.Thread(target=work)
thread.start()
thread.join()
load(load_aircraft("hale"), 0.005)
print("main thread loads")
"""
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert child.returncode == 0, child.stderr
    assert "refused:" in child.stdout
    assert "main thread" in child.stdout.splitlines()[0]
    assert child.stdout.splitlines()[-1] == "main thread loads"


def test_nothing_is_printed(hale, capfd):
    # JSBSim writes a page on every load by default; a user's console shows none of it.
    jsbsim_plant(hale, has_moment=True)
    out, err = capfd.readouterr()
    assert out == err == ""


def test_an_effector_that_the_companion_names_and_that_does_nothing_is_refused(edited):
    # the other one of the pair would trim and fly the aircraft all the same
    folder = edited("hale.xml", ("<output>fcs/right-aileron-pos-rad</output>", ""))
    with pytest.raises(InputError) as error:
        model.trimmed_model(load_aircraft(str(folder)), 30.0, 1000.0)
    assert error.value.where.endswith("key effectors.right_aileron")
    assert error.value.found == "it moves nothing: 0 rad/s^2 at full command"


def test_an_engine_whose_throttle_moves_nothing_is_refused(edited):
    # a throttle that is no throttle of the aircraft: the other motor carries it, with rudder
    folder = edited("uavftc.yaml", ('{throttle: "fcs/throttle-cmd-norm[1]"}', "{throttle: fcs/flap-cmd-norm}"))
    with pytest.raises(InputError) as error:
        model.trimmed_model(load_aircraft(str(folder)), 30.0, 1000.0)
    assert error.value.where.endswith("key effectors.right_motor")
    assert error.value.found.startswith("it moves no thrust: ")


def test_a_search_that_ran_out_of_time_is_no_answer_to_remember(hale, monkeypatch):
    # a busy machine must not refuse an aircraft for good: only a `NoTrimError` is kept in the cache
    monkeypatch.setattr(measure, "DEADLINE_S", 0.0)
    with pytest.raises(InputError, match="no steady flight found within 0 s") as error:
        measure.models_of(hale, (30.0,), 1000.0)
    assert not isinstance(error.value, model.NoTrimError)
