"""What JSBSim loads is a copy: nothing that a model says writes, opens or listens; what it lacks is declared there."""

from __future__ import annotations

import contextlib
import json
import re
import socket
import subprocess
import sys
import xml.etree.ElementTree as ET

import pytest

from uavftc.aircraft.definition import load_aircraft, stock_names
from uavftc.core import cache
from uavftc.errors import InputError
from uavftc.plants.jsbsim import copy, strict
from uavftc.plants.jsbsim.copy import edited
from uavftc.plants.jsbsim.load import initialised, load, missing
from uavftc.plants.jsbsim.model import notes, trimmed_model

PARTS = "<flight_control><channel><pure_gain name='g'><input>a/b</input><output>c/d</output></pure_gain></channel>"
SYSTEM = f"<metrics/>\n{PARTS}</flight_control>\n"


def without(section, head=""):
    """Return what is left of an aircraft that has a section between two others, no moment added."""
    return edited(f"{head}<fdm_config>{SYSTEM}{section}<aerodynamics/></fdm_config>".encode(), moment=False).decode()


# --- the text -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "section",
    [
        "<output/>",
        '<output file="out"/>',
        '<output name="a>b" type="CSV" rate="1">\n <property>a/b</property>\n\n</output>',
        "<output><output/><!-- </output> --><![CDATA[</output>]]></output>",
        '<input port="5137"/>',
        '<input port="5137" type="QTJSBSIM">\n</input >',
        '<output/>\n<input port="1"/><output\n/>',
    ],
)
def test_outputs_and_inputs_of_the_aircraft_are_taken_out(section):
    # All else stays, the <input> and <output> of components too, and every line keeps its number.
    kept = "\n" * section.count("\n")
    assert without(section) == f"<fdm_config>{SYSTEM}{kept}<aerodynamics/></fdm_config>"


@pytest.mark.parametrize("section", ["", "<!-- <output/> -->", "<system><output/></system>", "<?a <output/>?>", "\r\n"])
def test_nothing_else_is_touched(section):
    # JSBSim reads outputs as children of the root alone; what has none is the author's file to the byte.
    head = '\ufeff<?xml version="1.0"?>\r\n<?xml-stylesheet href="x"?><!-- <output/> -->\n'
    assert without(section, head) == f"{head}<fdm_config>{SYSTEM}{section}<aerodynamics/></fdm_config>"


def test_the_bytes_of_another_encoding_stay():
    text = '<?xml version="1.0" encoding="ISO-8859-1"?><a><b c="\xe9"/><output name="\xe9"/><d>\xfc</d></a>'
    kept = text.replace('<output name="\xe9"/>', "").encode("latin-1")
    assert edited(text.encode("latin-1"), moment=False) == kept


def test_an_aircraft_that_carries_another_is_refused(edited):
    # JSBSim would load the other as it is, and adds its mass to the first: neither to be flown nor to be left out.
    folder = edited("hale.xml", ("</fdm_config>", '<child name="other"/></fdm_config>'))
    with pytest.raises(InputError, match="<child>"):
        copy.copy_of(load_aircraft(str(folder)))


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_becomes_utf_8(encoding):
    text = '\ufeff<?xml version="1.0" encoding="UTF-16"?>\n<a><b c="\xe9"/><output/></a>'
    root = ET.fromstring(edited(text.encode(encoding), moment=True, declared=["x/y"]))
    assert [child.tag for child in root] == ["system", "b", "external_reactions"]
    assert root.find("b").get("c") == "\xe9"


@pytest.mark.parametrize("entity", ["<!ENTITY o '<output/>'>", "<!ENTITY % p 'x'>", "<!ENTITY e SYSTEM 'e.xml'>"])
def test_an_entity_is_refused(entity, edited):
    # What it stands for is read by JSBSim and is not in the text.
    folder = edited("hale.xml", ("<fdm_config", f"<!DOCTYPE fdm_config [{entity}]>\n<fdm_config"))
    with pytest.raises(InputError, match="<!ENTITY>") as error:
        copy.copy_of(load_aircraft(str(folder)))
    assert str(folder / "hale.xml") in error.value.where


def test_no_aircraft_that_jsbsim_ships_keeps_an_output():
    # As they are written: comments, style sheets, Latin-1. Some of them would write a file or open a socket.
    live = []
    for name in stock_names():
        if name == "blank":  # of an older format, and not well-formed
            continue
        aircraft = load_aircraft(f"jsbsim:{name}")
        root, bare = ET.parse(aircraft.xml).getroot(), ET.parse(copy.copy_of(aircraft)).getroot()
        gone = [child.tag for child in root if child.tag in ("output", "input")]
        live += [name] * bool(gone)
        assert [c.tag for c in bare if c.tag != "external_reactions"] == [
            c.tag for c in root if c.tag not in ("output", "input", "external_reactions")
        ]
    assert {"737", "B17", "c172x", "global5000"} <= set(live)


# --- the aircraft ---------------------------------------------------------------------------------------------------

LOG = '<output name="{name}" type="CSV" rate="200"><property>aero/beta-rad</property></output>'
WRITES = """<channel name="state file"><fcs_function name="w"><function><value>1</value></function>
 <output>simulation/write-state-file</output></fcs_function></channel>"""


@pytest.fixture
def ports():
    """Return a UDP and a TCP socket that listen on loopback, and a port on which nobody listens."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp,
        socket.socket(socket.AF_INET, socket.SOCK_STREAM) as tcp,
        socket.socket(socket.AF_INET, socket.SOCK_STREAM) as free,
    ):
        for listener in (udp, tcp, free):
            listener.bind(("127.0.0.1", 0))
        tcp.listen()
        udp.setblocking(False)
        tcp.setblocking(False)
        port = free.getsockname()[1]
        free.close()
        yield udp, tcp, port


@pytest.fixture
def talker(edited, ports):
    """Return the folder of an aircraft that logs, sends and listens in every way that JSBSim has; no companion."""
    udp, tcp, port = ports
    socket_to = '<output name="127.0.0.1" type="{type}" port="{port}" protocol="{protocol}" rate="200"/>'
    sections = [
        LOG.format(name="talker.csv"),
        socket_to.format(type="SOCKET", port=udp.getsockname()[1], protocol="UDP"),
        socket_to.format(type="FLIGHTGEAR", port=udp.getsockname()[1], protocol="UDP"),
        socket_to.format(type="SOCKET", port=tcp.getsockname()[1], protocol="TCP"),
        '<output file="log"/>',
        f'<input port="{port}"/>',
        f'<input port="{port}" type="QTJSBSIM" rate="20"><property>fcs/aileron-cmd-norm</property></input>',
        '<system file="radio"/>',
    ]
    end = "</fdm_config>"
    folder = edited("hale.xml", (end, "\n".join(sections) + end), ("</flight_control>", f"{WRITES}</flight_control>"))
    (folder / "uavftc.yaml").unlink()
    (folder / "log.xml").write_text(LOG.format(name="included.csv"))
    (folder / "systems/radio.xml").write_text(f'<system name="radio">{LOG.format(name="system.csv")}</system>')
    return folder


def contents(*folders):
    """Return all files with their bytes and times."""
    files = [p for folder in folders for p in folder.rglob("*")]
    return {str(p): (p.stat().st_mtime_ns, p.is_file() and p.read_bytes()) for p in files}


def silent(udp, tcp):
    """Return whether nothing was sent to either socket."""
    heard = []
    with contextlib.suppress(BlockingIOError):
        heard.append(udp.recv(4096))
    with contextlib.suppress(BlockingIOError):
        caller, _ = tcp.accept()
        caller.close()
        heard.append(caller)
    return not heard


def test_jsbsim_itself_would_log_send_and_listen(talker, ports):
    # The control: without the copy the same aircraft does all of it, so the tests below can see it.
    code = f"""
import os, socket, sys
import jsbsim
fdm = jsbsim.FGFDMExec({str(talker.parent)!r})
fdm.set_debug_level(0)
fdm.set_aircraft_path({str(talker.parent)!r})
fdm.set_engine_path({str(talker / "engine")!r})
fdm.set_systems_path({str(talker / "systems")!r})
fdm.load_model("hale")
fdm.run_ic()
for _ in range(5):
    fdm.run()
with socket.socket() as listener:
    try:
        listener.bind(("127.0.0.1", {ports[2]}))
    except OSError:
        print("JSBSim listens")
sys.stdout.flush()
os._exit(0)
"""
    child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert "JSBSim listens" in child.stdout
    written = {p.name for p in talker.parent.iterdir()} - {"hale"}
    assert {"talker.csv", "included.csv"} < written
    assert any(name.startswith("initfile") for name in written)
    assert "system.csv" not in written  # JSBSim reads no output in what it includes
    assert not silent(*ports[:2])


def test_a_loaded_aircraft_writes_sends_and_hears_nothing(talker, ports, tmp_path, monkeypatch):
    # While it flies: the port of its <input> is free.
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    before = contents(tmp_path)
    fdm = initialised(load_aircraft(str(talker)), 0.005)
    for _ in range(100):
        fdm.run()
    for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
        with socket.socket(socket.AF_INET, kind) as listener:
            listener.bind(("127.0.0.1", ports[2]))
    assert silent(*ports[:2])
    assert contents(tmp_path) == before
    assert fdm["simulation/sim-time-sec"] == pytest.approx(0.5)


def command(*arguments, cwd):
    """Run uavftc in a folder."""
    line = [sys.executable, "-m", "uavftc", *map(str, arguments)]
    return subprocess.run(line, cwd=cwd, capture_output=True, text=True, timeout=300, check=False)


FLY = ("--set", "saturation=null", "--set", "duration_s=0.5", "--set", "initial.airspeed_mps=30", "--no-plots")


@pytest.mark.slow
def test_design_and_fly_leave_nothing_but_their_results(talker, ports, tmp_path):
    # From the command line, with the aircraft's folder read-only: beside it and in the working folder nothing is new.
    here = tmp_path / "here"
    here.mkdir()
    before = contents(talker.parent / "hale")
    names = set(tmp_path.iterdir())
    for folder in (talker, talker / "engine", talker / "systems"):
        folder.chmod(0o555)
    design = command("design", talker, "--airspeed-mps", 30, "--altitude-m", 1000, cwd=here)
    fly = command("fly", "scenario1", "--aircraft", talker, *FLY, "--out", "out", cwd=here)
    for folder in (talker, talker / "engine", talker / "systems"):
        folder.chmod(0o755)
    assert design.returncode == 0, design.stderr
    assert fly.returncode == 0, fly.stderr
    assert contents(talker.parent / "hale") == before
    assert set(tmp_path.iterdir()) == names
    assert [p.name for p in here.iterdir()] == ["out"]
    assert {p.suffix for p in here.rglob("*") if p.is_file()} == {".json", ".parquet", ".yaml"}
    assert silent(*ports[:2])


# --- what it lacks --------------------------------------------------------------------------------------------------

GEAR = """<channel name="gear" execute="/sim/freeze">
 <pure_gain name="g/a"><input>-/controls/gear/brake[1]</input><gain>1</gain></pure_gain>
 <switch name="g/b"><default value="-systems/a/volts"/><test value="1">
   systems/b[0]/on == 1
   g/a gt -/sim/c
 </test></switch>
 <fcs_function name="g/c"><function><table><independentVar>sim/d</independentVar>
   <tableData>0 1
   1 2
   </tableData></table></function></fcs_function>
 <actuator name="g/d"><input>aero/beta-rad</input><rate_limit>systems/rate</rate_limit>
   <clipto><min>-systems/stop</min><max>systems/stop</max></clipto></actuator>
</channel>"""
LACKS = [
    "/sim/freeze", "/controls/gear/brake[1]", "systems/a/volts", "systems/b[0]/on", "/sim/c", "sim/d", "systems/rate",
    "systems/stop", "/systems/hook",
]  # fmt: skip
HOOK = '<system name="hook"><channel name="h"><pure_gain name="h/a"><input>/systems/hook</input></pure_gain></channel>'


@pytest.fixture
def flightgear(edited):
    """Return the folder of an aircraft that reads what only FlightGear provides, with a companion file."""
    folder = edited(
        "hale.xml",
        ("</flight_control>", f"{GEAR}</flight_control>"),
        ("</fdm_config>", '<system file="hook"/></fdm_config>'),
    )
    (folder / "systems/hook.xml").write_text(HOOK.replace("</input>", "</input><gain>1</gain>") + "</system>")
    return folder


def allow(folder, warnings):
    """Write the key `warnings` into the companion file, and return the aircraft."""
    with (folder / "uavftc.yaml").open("a") as file:
        file.write(f"\nwarnings: {warnings}\n")
    return load_aircraft(str(folder))


def test_what_nothing_defines_is_found_and_declared(flightgear):
    # Each as JSBSim looks it up, with its slash and index and without its sign; and nothing that is there.
    (flightgear / "uavftc.yaml").unlink()
    aircraft = load_aircraft(str(flightgear))
    assert sorted(missing(aircraft)) == sorted(LACKS)
    fdm = initialised(aircraft, 0.005)
    manager = fdm.get_property_manager()
    assert [manager.get_node(name).get_double_value() for name in LACKS] == [0.0] * len(LACKS)


def test_a_declared_property_changes_no_line(flightgear):
    # A message of JSBSim about the copy names a line of the author's file.
    aircraft = load_aircraft(str(flightgear))
    lines = copy.copy_of(aircraft, LACKS).read_text().splitlines()
    assert len(lines) == len(aircraft.xml.read_text().splitlines())


def test_a_flight_and_a_design_name_what_was_declared(flightgear, tmp_path):
    # On standard error, in summary.json and in the design's document.
    (flightgear / "uavftc.yaml").unlink()
    fly = command("fly", "scenario1", "--aircraft", flightgear, *FLY, "--out", "out", cwd=tmp_path)
    assert fly.returncode == 0, fly.stderr
    (warning,) = (w for w in json.loads((tmp_path / "out/summary.json").read_text())["warnings"] if "hale.xml" in w)
    shown = "".join(fly.stderr.split())
    for name in LACKS:
        assert name in warning
        assert name in shown
    at = ("--airspeed-mps", 30, "--altitude-m", 1000)
    design = command("design", flightgear, *at, "--json", cwd=tmp_path)
    assert json.loads(design.stdout)["warnings"] == [warning]
    design = command("design", flightgear, *at, cwd=tmp_path)
    assert all(name in "".join(design.stderr.split()) for name in LACKS)


def test_a_companion_file_claims_that_all_is_there(flightgear):
    # A typing error is refused, unless the file says that complaints are allowed.
    with pytest.raises(InputError, match="/sim/freeze"):
        load(load_aircraft(str(flightgear)), 0.005)
    aircraft = allow(flightgear, "allow")
    assert not aircraft.strict
    assert sorted(missing(aircraft)) == sorted(LACKS)
    assert initialised(aircraft, 0.005)["g/d"] == 0.0


@pytest.mark.parametrize("name", ["a b", "1a/b", "a//b", "a/!b", "nan", "-", "a/b[x]", "a" * 201, "&lt;a"])
def test_a_name_that_aborts_jsbsim_never_reaches_it(name, edited):
    # Neither asked for nor declared.
    gain = f'<channel name="x"><pure_gain name="g"><input>{name}</input><gain>1</gain></pure_gain></channel>'
    folder = edited("hale.xml", ("</flight_control>", f"{gain}</flight_control>"))
    (folder / "uavftc.yaml").unlink()
    known = set(strict.reads(load_aircraft("hale")))
    assert set(strict.reads(load_aircraft(str(folder)))) - known <= {"a", "b"}


# --- the key `warnings` ---------------------------------------------------------------------------------------------

UNKNOWN = ("<htailarea", "<htailareax"), ("</htailarea", "</htailareax")
LOUD = ("</fdm_config>", '<system file="no_such"/></fdm_config>')


def test_warnings_strict_is_the_default(edited):
    folder = edited("hale.xml", *UNKNOWN)
    with pytest.raises(InputError, match="htailareax"):
        strict.refuse(load_aircraft(str(folder)))
    with pytest.raises(InputError, match="htailareax"):
        strict.refuse(allow(folder, "strict"))


def test_warnings_allow_takes_every_complaint_as_a_warning(edited):
    # The check of the files says it still; mass properties and names of the companion file must hold still.
    aircraft = allow(edited("hale.xml", *UNKNOWN), "allow")
    strict.refuse(aircraft)
    assert any("htailareax" in line for line in notes(aircraft, trimmed_model(aircraft, 30.0, 1000.0)))


def test_warnings_allow_keeps_what_the_companion_file_claims(edited):
    aircraft = allow(edited("uavftc.yaml", ("mass_kg: 425", "mass_kg: 426")), "allow")
    with pytest.raises(InputError, match="mass"):
        trimmed_model(aircraft, 30.0, 1000.0)


def test_a_list_of_warnings_allows_those_and_no_other(edited):
    folder = edited("hale.xml", *UNKNOWN, ("vtailarm", "vtailarmx"))
    aircraft = allow(folder, "[<htailareax>]")
    with pytest.raises(InputError, match="vtailarmx") as error:
        strict.refuse(aircraft)
    assert "htailareax" not in str(error.value)
    text = (folder / "uavftc.yaml").read_text().replace("[<htailareax>]", "[<htailareax>, <vtailarmx>]")
    (folder / "uavftc.yaml").write_text(text)
    aircraft = load_aircraft(str(folder))
    strict.refuse(aircraft)
    assert [re.search("<.*?>", line)[0] for line in strict.warnings(aircraft)] == ["<htailareax>", "<vtailarmx>"]
    assert initialised(aircraft, 0.005)["inertia/mass-slugs"] > 0.0


def test_a_complaint_of_jsbsim_itself_can_be_allowed(edited):
    # A component asks for a file of the state at each frame: refused, or not written and said nothing about.
    folder = edited("hale.xml", ("</flight_control>", f"{WRITES}</flight_control>"))
    with pytest.raises(InputError, match="Could not open and/or write"):
        initialised(load_aircraft(str(folder)), 0.005)
    aircraft = allow(folder, "[write the state to the initial conditions file]")
    assert aircraft.strict
    initialised(aircraft, 0.005)


def test_what_crashes_jsbsim_is_refused_even_if_all_is_allowed(edited):
    aircraft = allow(
        edited("hale.xml", ("<property>aero/beta-rad</property>", "<property>aero/force/CY_beta</property>")), "allow"
    )
    with pytest.raises(InputError, match="crashes"):
        trimmed_model(aircraft, 30.0, 1000.0)


@pytest.mark.parametrize("value", ["[]", "true", "3", "all", "['']", "[1]", "[' ']", "{a: 1}", "null"])
def test_another_form_is_refused(value, edited):
    folder = edited("hale.xml", ("hale", "hale"))
    with pytest.raises(InputError) as error:
        allow(folder, value)
    assert "key warnings" in error.value.where
    assert "strict, allow, or a list of texts" in error.value.expected


# --- the place of the copy ------------------------------------------------------------------------------------------


def test_the_copy_is_one_file_in_the_cache_made_once(own_cache):
    aircraft = load_aircraft("jsbsim:c172p")
    file = copy.copy_of(aircraft)
    assert own_cache in file.parents
    assert [p.name for p in file.parent.iterdir()] == ["c172p.xml"]
    stamp = file.stat().st_mtime_ns
    assert copy.copy_of(aircraft) == file
    assert file.stat().st_mtime_ns == stamp
    file.write_text("spoilt")
    assert copy.copy_of(aircraft).read_bytes() == edited(aircraft.xml.read_bytes(), moment=True)


def test_what_the_aircraft_includes_is_read_where_it_is(flightgear, tmp_path):
    # Also from above its folder, and through a link to the folder.
    outside = '<system name="above"><property value="7">above/x</property></system>'
    (tmp_path / "above.xml").write_text(outside)
    xml = flightgear / "hale.xml"
    xml.write_text(xml.read_text().replace("</fdm_config>", '<system file="../above.xml"/></fdm_config>'))
    (flightgear / "uavftc.yaml").unlink()
    (tmp_path / "deep/er").mkdir(parents=True)
    (tmp_path / "deep/er/hale").symlink_to(flightgear)
    for folder in (flightgear, tmp_path / "deep/er/hale"):
        assert initialised(load_aircraft(str(folder)), 0.005)["above/x"] == 7.0


@pytest.mark.parametrize("home", ["missing/deep/home", "a file"])
def test_without_a_home_for_the_cache_it_flies_from_a_temporary_one(home, tmp_path, monkeypatch):
    (tmp_path / "a file").write_text("")
    monkeypatch.setenv("UAVFTC_CACHE_DIR", str(tmp_path / home))
    monkeypatch.setattr(copy, "cache_folder", cache.cache_folder)
    assert load(load_aircraft("hale"), 0.005).get_propulsion().get_num_engines() == 2


def test_a_message_names_the_authors_file_and_line(edited):
    # Not the copy, which the author does not know; lines count as in the author's file.
    folder = edited("hale.xml", ("<metrics>", f"{LOG.format(name='a')}\n<metrics>"), ('name="ROLL"', 'name="ROL"'))
    (folder / "uavftc.yaml").unlink()
    lines = (folder / "hale.xml").read_text().splitlines()
    number = next(k for k, line in enumerate(lines, start=1) if 'name="ROL"' in line)
    with pytest.raises(InputError) as error:
        load(load_aircraft(str(folder)), 0.005)
    assert f"hale.xml:{number}" in error.value.found.replace(", line ", ":")
    assert str(copy.copy_of(load_aircraft(str(folder))).parent) not in error.value.found
