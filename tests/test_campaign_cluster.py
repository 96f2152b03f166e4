"""Campaigns on a scheduler and workers that are processes of their own, over TCP."""

import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from parkproof.campaign import cluster
from parkproof.campaign.definition import Campaign, campaign_from_dict
from parkproof.campaign.rows import parquet_of
from parkproof.campaign.run import run_campaign
from parkproof.errors import InputError
from test_campaign import bits, names_in

pytest.importorskip("distributed")

START = {"kind": "uniform", "low": -2.0, "high": -0.5}
CAMPAIGN = {
    "law": "corrected",
    "trials": 2048,
    "seed": 5,
    "distributions": {"start.pose[0]": START},
    "start": {"pose": [-1.0, 0.2, 0.0]},
    "run": {"duration": 1.0, "control_period": 0.01},
}


def campaign(**changes: Any) -> Campaign:
    return campaign_from_dict(CAMPAIGN | changes, where="campaign")


class Cluster:
    """A scheduler and workers of one thread each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []
        with closing(socket.socket()) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", str(port))
        while not re.search("Scheduler at", (folder / "0.log").read_text("utf-8")):
            assert self.scheduler.poll() is None, (folder / "0.log").read_text("utf-8")
            time.sleep(0.02)

    def start(self, *arguments: str) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", "dask", *arguments, "--dashboard-address", "127.0.0.1:0"]
        with (self.folder / f"{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder)
        self.processes.append(process)
        return process

    def worker(self) -> "subprocess.Popen[bytes]":
        return self.start("worker", self.address, "--no-nanny", "--nthreads", "1")


@pytest.fixture
def running(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    monkeypatch.chdir(tmp_path)
    found = Cluster(tmp_path)
    yield found
    for process in found.processes:
        process.kill()
        process.wait()


def test_workers_that_are_killed_lose_nothing(running: Cluster, tmp_path: Path) -> None:
    workers = [running.worker() for _ in range(2)]

    def kill_one(done: int, asked: int) -> None:
        if 0 < done < asked and workers[0].poll() is None:
            workers[0].send_signal(signal.SIGKILL)

    run_campaign(campaign(), Path("cluster"), scheduler=running.address, progress=kill_one)
    assert workers[0].wait(10) == -signal.SIGKILL
    assert workers[1].poll() is None
    run_campaign(campaign(), Path("threads"), threads=2)
    assert bits(tmp_path / "cluster") == bits(tmp_path / "threads")
    assert names_in("cluster/trials") == names_in("threads/trials")


def test_a_scheduler_that_is_lost_is_a_sentence_and_the_rows_stay(
    running: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    running.worker()
    monkeypatch.setattr(cluster, "CONNECTING", 1.0)

    def kill_scheduler(done: int, asked: int) -> None:
        if 0 < done < asked:
            running.scheduler.kill()

    with pytest.raises(InputError, match=r"the scheduler was lost.*the same command goes on"):
        run_campaign(campaign(), Path("out"), scheduler=running.address, progress=kill_scheduler)
    assert 0 < len(names_in("out/trials")) < 16
    run_campaign(campaign(), Path("out"), threads=2)
    assert len(names_in("out/trials")) == 16


def test_a_scheduler_without_workers_is_given_up(
    running: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    monkeypatch.setattr(cluster, "LOOK", 0.1)
    with pytest.raises(InputError, match=r"has had no worker for .* start some"):
        run_campaign(campaign(), Path("out"), scheduler=running.address)


def test_a_scheduler_that_is_not_there_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "CONNECTING", 0.5)
    with closing(socket.socket()) as taken:  # bound, but nobody listens
        taken.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(InputError, match=r"there is no scheduler .* leave --scheduler out"):
            run_campaign(campaign(), tmp_path / "out", scheduler=address)
    assert not (tmp_path / "out").exists()


def test_workers_of_another_version_are_refused() -> None:
    with pytest.raises(InputError, match=r"the campaign needs 0\.0\.1; install the same version"):
        parquet_of("{}", 0, 4, version="0.0.1")


def test_a_missing_library_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    import parkproof.extras

    monkeypatch.setattr(parkproof.extras, "find_spec", lambda _: None)
    with (
        pytest.raises(InputError, match=r"pip install 'parkproof\[cluster\]'"),
        cluster.connected("tcp://127.0.0.1:9"),
    ):
        pass
