"""Campaigns on a Dask cluster of this machine: the table of a local campaign, whatever becomes of the workers."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella
from uavftc.jobs.campaign.evaluate import Job, Plan
from uavftc.jobs.campaign.table import content
from uavftc.jobs.campaign.variants import variants_of
from uavftc.scenario.campaign import load_campaign

pytestmark = pytest.mark.slow
START_S = 120.0

FILE = """\
name: small
base: scenario1
seed: 7
cases: 60
vary:
  "reference.phi_deg": {uniform: [1, 5]}
controllers: [ndi-l1, nndondi-mrac]
plants: [jsbsim]
"""

# A controller that does what its options say once it is flown.
ENDING = """\
import os, signal
import numpy as np


def create(design, h, options):
    def step(t, x1_c, x1, x2):
        if options.get("ends") and t > 0.5:
            os.kill(os.getpid(), signal.SIGKILL)
        while options.get("hangs") and t > 0.5:
            pass
        return np.zeros(3)

    return step
"""


class Cluster:
    """A scheduler and two workers, each a process of this test."""

    def __init__(self, folder):
        self._folder, self._processes, self.workers = folder, [], []

    def begin(self, nanny):
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.address = self._said("scheduler", "Scheduler at:").split()[-1]
        self._worker = ["worker", self.address, "--nthreads", "1", "--no-dashboard", nanny]
        self.workers = [self.join(name) for name in ("one", "two")]

    def join(self, name):
        local = ["--name", name, "--local-directory", self._folder / name]
        process = self._start(*self._worker, *local, name=name)
        self._said(name, "Registered to:")
        return process

    def _start(self, *arguments, name="scheduler"):
        command = [sys.executable, "-m", "dask", *map(str, arguments)]
        failures = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
        with (self._folder / f"{name}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, env={**os.environ, **failures})
        self._processes.append(process)
        return process

    def _said(self, name, what):
        limit = time.monotonic() + START_S
        while time.monotonic() < limit:
            for line in (self._folder / f"{name}.log").read_text(encoding="utf-8").splitlines():
                if what in line:
                    return line
            time.sleep(0.1)
        raise AssertionError(f"{name} did not say {what}")

    def end(self):
        for process in reversed(self._processes):
            process.terminate()
            process.wait(60)


@pytest.fixture
def clusters(tmp_path):
    pytest.importorskip("distributed")
    made = Cluster(tmp_path)
    yield made
    made.end()


@pytest.fixture
def cluster(clusters):
    clusters.begin("--no-nanny")
    return clusters


@pytest.fixture
def nannies(clusters):
    """A cluster whose workers are started again when they end."""
    clusters.begin("--nanny")
    return clusters


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


def run(*arguments):
    return CliRunner().invoke(umbrella, ["sweep", *map(str, arguments)])


def ending(tmp_path):
    """Return the plan of a controller that ends, or hangs, as its options say."""
    (tmp_path / "ending.py").write_text(ENDING, encoding="utf-8")
    path = tmp_path / "ending.yaml"
    path.write_text(FILE.replace("[ndi-l1, nndondi-mrac]", "[ending.py]").replace("jsbsim", "analytic"), "utf-8")
    return Plan(variants_of(load_campaign(path)), None, "none")


def flown(engine, jobs):
    return {row["case"]: row for row in engine.fly(iter(jobs)) if row is not None}


def test_the_table_is_that_of_one_local_worker_though_a_worker_of_the_cluster_is_killed(cluster, file, tmp_path):
    from uavftc.jobs.campaign.sweep import Sweep, ready

    assert run(file, "--workers", 1, "--out", tmp_path / "local", "--quiet").exit_code == 0

    def kill(done, total, failures):
        if done > 20 and cluster.workers[0].poll() is None:
            cluster.workers[0].send_signal(signal.SIGKILL)

    made = ready(load_campaign(file))
    summary = Sweep(made, tmp_path / "cluster").fly(cluster=cluster.address, progress=kill)
    assert cluster.workers[0].wait() == -signal.SIGKILL
    assert summary["flights"] == 120
    assert content(tmp_path / "cluster").equals(content(tmp_path / "local"))


def test_histories_come_from_the_cluster_and_are_those_of_a_local_campaign(cluster, file, tmp_path):
    few = ("--set", "cases=2", "--set", "histories={worst: 1}", "--quiet")
    assert run(file, *few, "--out", tmp_path / "local").exit_code == 0
    assert run(file, *few, "--out", tmp_path / "far", "--cluster", cluster.address).exit_code == 0
    (here,) = (tmp_path / "local" / "histories").iterdir()
    assert (tmp_path / "far" / "histories" / here.name).read_bytes() == here.read_bytes()


def test_a_flight_that_ends_its_workers_is_an_error_and_the_others_are_flown(nannies, tmp_path):
    from uavftc.jobs.campaign.cluster import ClusterEngine

    jobs = [Job(case, 0, {"duration_s": 2.0}) for case in range(12)]
    jobs[2] = Job(2, 0, {"duration_s": 2.0, "controller.options": {"ends": True}})
    with ClusterEngine(ending(tmp_path), nannies.address, 60.0) as engine:
        rows = flown(engine, jobs)
    assert sorted(rows) == list(range(12))
    assert {case for case, row in rows.items() if row["outcome"] == "error"} == {2}
    assert "KilledWorker" in rows[2]["reason"]


def test_a_flight_that_takes_too_long_or_hangs_is_an_error(nannies, tmp_path, monkeypatch):
    from uavftc.jobs.campaign import cluster

    plan = ending(tmp_path)
    with cluster.ClusterEngine(plan, nannies.address, 60.0) as engine:
        assert flown(engine, [Job(0, 0, {"duration_s": 2.0})])[0]["outcome"] != "error"  # loads and compiles
    monkeypatch.setattr(cluster, "GRACE_S", 10.0)
    jobs = [
        Job(0, 0, {"duration_s": 3000.0}),
        Job(1, 0, {"duration_s": 2.0, "controller.options": {"hangs": True}}),
        Job(2, 0, {"duration_s": 0.5}),
    ]
    with cluster.ClusterEngine(plan, nannies.address, 1.0) as engine:
        rows = flown(engine, jobs)
    assert rows[0]["reason"] == "not done within 1 s"
    assert "KilledWorker" in rows[1]["reason"]
    assert rows[2]["outcome"] != "error"


def test_a_cluster_that_is_gone_ends_the_campaign_which_goes_on_here(cluster, file, tmp_path):
    from uavftc.jobs.campaign.sweep import Sweep, ready

    def end(done, total, failures):
        if done > 20 and cluster.scheduler.poll() is None:
            cluster.scheduler.kill()

    made, out = ready(load_campaign(file)), tmp_path / "out"
    sweep = Sweep(made, out)
    with pytest.raises(ConnectionError, match="is gone"):
        sweep.fly(cluster=cluster.address, progress=end)
    assert 20 < sweep.kept < 120
    assert run(file, "--out", out, "--resume", "--workers", 1, "--quiet").exit_code == 0
    assert run(file, "--out", tmp_path / "whole", "--workers", 1, "--quiet").exit_code == 0
    assert content(out).equals(content(tmp_path / "whole"))
