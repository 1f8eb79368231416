"""A flight that is paced and sent is the same flight, and an independent decoder reads its history from the packets."""

from __future__ import annotations

import json
import math
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from uavftc.cli.app import single
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.jobs.live.flightgear import LATITUDE, LONGITUDE, PACKET, place, stops_of
from uavftc.jobs.live.pace import Pace, checked_pace
from uavftc.jobs.live.target import target_of
from uavftc.results.history import read_history
from uavftc.scenario.load import load_scenario

fdm_v24 = pytest.importorskip("flightgear_python.fdm_v24")


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        heard.bind(("127.0.0.1", 0))
        heard.settimeout(1.0)
        yield heard


def address(heard: socket.socket) -> str:
    return f"flightgear:127.0.0.1:{heard.getsockname()[1]}"


def packets(heard: socket.socket) -> list[Any]:
    heard.setblocking(False)
    found = []
    while True:
        try:
            found.append(fdm_v24.fdm_struct.parse(heard.recv(2000)))
        except BlockingIOError:
            return found


def fly(*arguments: str) -> Any:
    return CliRunner().invoke(single, ["beyond/fault-stuck", "--set", "duration_s=1", "--no-plots", *arguments])


def test_a_packet_is_as_long_as_jsbsims() -> None:
    assert PACKET.itemsize == 408 == fdm_v24.fdm_struct.sizeof()  # JSBSim 1.3 sends 408 bytes


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_an_independent_decoder_reads_the_rows_of_the_history(
    plant: str, listener: socket.socket, tmp_path: Path
) -> None:
    out = tmp_path / "live"
    done = fly("--plant", plant, "--live", address(listener), "--pace", "4", "--out", str(out))
    assert done.exit_code == 0, done.output
    heard, history = packets(listener), read_history(out / "history.parquet")
    rows = [*range(3, 201, 4), 200]  # every fourth of 200 Hz is 50 Hz, and the last
    assert len(heard) == len(rows)
    at = {name: values[rows] for name, values in history.items()}

    def sent(name: str) -> np.ndarray:
        return np.array([packet[name] for packet in heard])

    single_precision = {"rel": 1e-6, "abs": 1e-7}
    phi, theta, psi = (at[f"{name}_rad"] for name in ("phi", "theta", "psi"))
    assert sent("phi_rad") == pytest.approx(phi, **single_precision)
    assert sent("theta_rad") == pytest.approx(theta, **single_precision)
    assert sent("psi_rad") == pytest.approx(psi % (2 * math.pi), **single_precision)
    for i in range(len(rows)):  # body rates are E times the rates of the angles
        E = np.array(
            [
                [1, 0, -math.sin(theta[i])],
                [0, math.cos(phi[i]), math.sin(phi[i]) * math.cos(theta[i])],
                [0, -math.sin(phi[i]), math.cos(phi[i]) * math.cos(theta[i])],
            ]
        )
        turning = [heard[i][f"{name}dot_rad_per_s"] for name in ("phi", "theta", "psi")]
        assert E @ turning == pytest.approx([at[f"{name}_radps"][i] for name in "pqr"], rel=1e-5, abs=1e-7)
    stops = stops_of(build_flight(load_scenario("beyond/fault-stuck", plant=plant)))
    assert sent("left_aileron") * stops[0] == pytest.approx(at["aileron_rad"], **single_precision)
    assert sent("right_aileron") * stops[0] == pytest.approx(-at["aileron_rad"], **single_precision)
    assert sent("elevator") * stops[1] == pytest.approx(-at["elevator_rad"], **single_precision)  # down counts
    assert sent("rudder") * stops[2] == pytest.approx(at["rudder_rad"], **single_precision)
    assert np.abs(at["aileron_rad"]).max() > 1e-3
    if plant == "analytic":  # it turns on the spot
        assert (sent("lat_rad") == LATITUDE).all()
        assert (sent("alt_m") == 1000.0).all()
        return
    assert sent("alt_m") == pytest.approx(at["altitude_m"], rel=1e-15)
    assert sent("alpha_rad") == pytest.approx(at["alpha_rad"], **single_precision)
    # metres in a degree of latitude and longitude, by the series of the WGS 84 ellipsoid at sea level
    f = LATITUDE
    of_latitude = 111132.954 - 559.822 * math.cos(2 * f) + 1.175 * math.cos(4 * f)
    of_longitude = 111412.84 * math.cos(f) - 93.5 * math.cos(3 * f) + 0.118 * math.cos(5 * f)
    higher = 1 + at["altitude_m"] / 6.371e6
    north = np.degrees(sent("lat_rad") - LATITUDE) * of_latitude * higher
    east = np.degrees(sent("lon_rad") - LONGITUDE) * of_longitude * higher
    assert north == pytest.approx(at["north_m"], rel=1e-5)
    assert east == pytest.approx(at["east_m"], rel=1e-4, abs=1e-6)
    assert at["north_m"][-1] > 20.0
    speed = np.sqrt(sum(sent(f"v_body_{axis}") ** 2 for axis in "uvw")) * 0.3048
    assert speed == pytest.approx(at["airspeed_mps"], rel=1e-6)
    over_ground = np.array([heard[-1][f"v_{name}_ft_per_s"] for name in ("north", "east", "down")]) * 0.3048
    flown = [(history[c][200] - history[c][198]) / 0.01 for c in ("north_m", "east_m", "altitude_m")]
    assert over_ground == pytest.approx([flown[0], flown[1], -flown[2]], abs=0.02)


def test_pacing_changes_no_bit_and_is_reported(listener: socket.socket, tmp_path: Path) -> None:
    assert fly("--out", str(tmp_path / "free")).exit_code == 0
    started = time.perf_counter()
    done = fly("--live", address(listener), "--pace", "2", "--out", str(tmp_path / "paced"))
    assert time.perf_counter() - started >= 0.49  # a second of flight in half a second
    assert done.exit_code == 0
    free, paced = (tmp_path / name / "history.parquet" for name in ("free", "paced"))
    assert free.read_bytes() == paced.read_bytes()
    timing = json.loads((tmp_path / "paced" / "summary.json").read_text(encoding="utf-8"))["timing"]
    assert timing["wall_pace"] == 2.0
    assert timing["wall_packets_sent"] == 51
    assert timing["wall_packets_refused"] == 0
    assert 0.0 <= timing["wall_lateness_median_s"] <= timing["wall_lateness_p99_s"] <= timing["wall_lateness_max_s"]
    assert timing["flight_wall_s"] < 0.49  # the waits are no part of the loop
    assert "pace 2: late by" in done.output
    assert "51 packets sent" in done.output


def test_a_pace_alone_sends_nothing(tmp_path: Path) -> None:
    done = fly("--pace", "50", "--out", str(tmp_path / "paced"))
    assert done.exit_code == 0
    timing = json.loads((tmp_path / "paced" / "summary.json").read_text(encoding="utf-8"))["timing"]
    assert timing["wall_pace"] == 50.0
    assert "wall_packets_sent" not in timing


def test_a_wait_is_given_up_when_the_user_ends_the_flight() -> None:
    flight = build_flight(load_scenario("scenario1", plant="analytic", set={"duration_s": 1.0}))
    from uavftc.flight.fly import fly_to_memory

    records, _ = fly_to_memory(flight)
    pace = Pace(flight, 1e-3)  # the next row is due in twenty seconds
    pace.take(records[0])
    assert pace.take(records[4], lambda: True) < 1.0


@pytest.mark.slow
def test_ctrl_c_ends_a_paced_flight_and_keeps_what_was_flown(listener: socket.socket, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "uavftc", "fly", "scenario1", "--no-plots", "--quiet", "--pace", "0.05"]
    flying = subprocess.Popen([*command, "--live", address(listener), "--out", str(tmp_path / "cut")])
    try:
        listener.settimeout(60.0)
        listener.recv(2000)  # it flies
        time.sleep(0.5)
        flying.send_signal(signal.SIGINT)
        assert flying.wait(30.0) == 130
    finally:
        flying.kill()
    summary = json.loads((tmp_path / "cut" / "summary.json").read_text(encoding="utf-8"))
    assert "interrupted by the user" in summary["ended_because"]
    assert 0.0 < summary["ended_at_s"] < 19.0
    rows = len(read_history(tmp_path / "cut" / "history.parquet")["time_s"])
    assert rows == round(200 * summary["ended_at_s"]) + 1


@pytest.mark.parametrize(
    ("text", "family", "address"),
    [
        ("flightgear", socket.AF_INET, ("127.0.0.1", 5550)),
        ("flightgear:", socket.AF_INET, ("127.0.0.1", 5550)),
        ("flightgear:127.0.0.2", socket.AF_INET, ("127.0.0.2", 5550)),
        ("flightgear:127.0.0.1:65535", socket.AF_INET, ("127.0.0.1", 65535)),
        ("flightgear::6000", socket.AF_INET, ("127.0.0.1", 6000)),
        ("flightgear:[::1]:6000", socket.AF_INET6, ("::1", 6000)),
    ],
)
def test_an_address_is_read_as_written(text: str, family: int, address: tuple[str, int]) -> None:
    assert target_of(text) == (family, address)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--live=xplane", "flightgear, flightgear:HOST or flightgear:HOST:PORT"),
        ("--live=flightgear:127.0.0.1:0", "1 to 65535"),
        ("--live=flightgear:127.0.0.1:65536", "1 to 65535"),
        ("--live=flightgear:127.0.0.1:x", "1 to 65535"),
        ("--live=flightgear:no host", "which has no address"),
        ("--pace=0", "above 0"),
        ("--pace=nan", "above 0"),
        ("--pace=-1", "above 0"),
    ],
)
def test_a_wrong_address_or_pace_is_refused_before_the_flight(option: str, said: str, tmp_path: Path) -> None:
    done = fly(option, "--out", str(tmp_path / "none"))
    assert done.exit_code == 2
    assert said in " ".join(done.stderr.split())
    assert list(tmp_path.iterdir()) == []


def test_a_pace_is_one_where_none_is_given() -> None:
    assert checked_pace(None) == 1.0
    with pytest.raises(InputError, match="above 0"):
        checked_pace(math.inf)


def test_the_start_is_where_it_is_said_to_be() -> None:
    assert place(0.0, 0.0, 1000.0) == (math.radians(37.6136), math.radians(-122.3569))
