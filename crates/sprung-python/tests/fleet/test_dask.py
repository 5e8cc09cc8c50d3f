"""Runs on Dask: workers killed, the scheduler restarted, object stores."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fleets
import pytest

from sprung import fleet

distributed = pytest.importorskip("distributed")


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", fleets.environment()["PYTHONPATH"])


@pytest.fixture
def cluster() -> Iterator[Any]:
    """Two worker processes with one thread each."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
    ) as local_cluster:
        yield local_cluster


def run(manifest: str | Path, out: object, client: Any, **more: Any) -> fleet.Summary:
    settings: dict[str, Any] = {"logs_per_part": 1, "progress": False, "identify_one": fleets.slow}
    return fleet.identify(manifest, out=str(out), client=client, **(settings | more))


class Killer:
    """Kills a worker process after every 40 logs; its nanny starts another."""

    def __init__(self, cluster: Any) -> None:
        self.cluster = cluster
        self.killed: list[int] = []

    def __call__(self, done: int, total: int) -> None:
        if done < 40 * (len(self.killed) + 1) or done > total - 20:
            return
        nannies = list(self.cluster.workers.values())
        process = nannies[len(self.killed) % len(nannies)].process
        if process is not None and process.pid:
            self.killed.append(process.pid)
            with contextlib.suppress(ProcessLookupError):
                os.kill(process.pid, signal.SIGKILL)


def test_killed_workers_change_nothing(tmp_path: Path, cluster: Any) -> None:
    manifest = fleets.manifest(tmp_path, robots=60)
    fleet.identify(
        manifest,
        out=tmp_path / "whole",
        workers=2,
        logs_per_part=1,
        progress=False,
        identify_one=fleets.identification,
    )
    killer = Killer(cluster)
    with distributed.Client(cluster) as client:
        summary = run(manifest, tmp_path / "out", client, progress=killer)
    assert len(killer.killed) >= 2
    assert (summary.tasks, summary.failed) == (180, 0)
    assert fleets.contents(tmp_path / "out") == fleets.contents(tmp_path / "whole")


def test_a_log_that_always_kills_its_worker_is_a_failure(
    tmp_path: Path, cluster: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sprung.fleet.run.DEATHS", 1)
    manifest = fleets.manifest(tmp_path, robots=2)
    with distributed.Client(cluster) as client:
        client.run_on_scheduler(_fewer_failures)
        # One part at a time, because all parts of a worker that dies are suspects.
        summary = run(manifest, tmp_path / "out", client, identify_one=fleets.dies, in_flight=1)
    assert summary.failed == 1
    (failure,) = fleet.Dataset.read(summary.out).rows("failure").to_pylist()
    assert failure["code"] == "worker-died" and failure["log"].endswith("log-3.csv")
    assert fleet.Dataset.read(summary.out).rows("parameter").num_rows == 5


def _fewer_failures(dask_scheduler: Any) -> None:
    dask_scheduler.allowed_failures = 1


def free_port() -> int:
    with socket.socket() as tcp_socket:
        tcp_socket.bind(("127.0.0.1", 0))
        return int(tcp_socket.getsockname()[1])


class Processes:
    """`dask scheduler` and `dask worker` as processes of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.all: list[subprocess.Popen[bytes]] = []

    def start(self, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", *arguments]
        with (self.folder / "dask.txt").open("ab") as output:
            process = subprocess.Popen(
                command, cwd=self.folder, env=fleets.environment(), stdout=output, stderr=output
            )
        self.all.append(process)
        return process

    def scheduler(self) -> subprocess.Popen[bytes]:
        port = self.address.rsplit(":", 1)[1]
        return self.start("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")

    def worker(self) -> subprocess.Popen[bytes]:
        arguments = ["--nthreads", "1", "--no-dashboard", "--death-timeout", "60"]
        return self.start("worker", self.address, *arguments)

    def end(self) -> None:
        for one in reversed(self.all):
            one.terminate()
        for one in self.all:
            try:
                one.wait(10)
            except subprocess.TimeoutExpired:
                one.kill()


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    group = Processes(tmp_path)
    try:
        yield group
    finally:
        group.end()


def test_a_restarted_scheduler_is_waited_for(tmp_path: Path, processes: Processes) -> None:
    manifest = fleets.manifest(tmp_path, robots=60)
    scheduler = processes.scheduler()
    processes.worker()
    processes.worker()
    done: list[int] = []
    restarted = threading.Event()

    def restart() -> None:
        while len(done) < 20:
            time.sleep(0.05)
        scheduler.kill()
        scheduler.wait()
        processes.scheduler()
        processes.worker()
        processes.worker()
        restarted.set()

    thread = threading.Thread(target=restart)
    thread.start()
    with distributed.Client(processes.address, timeout=60) as client:
        try:
            summary = run(manifest, tmp_path / "out", client, progress=lambda n, _: done.append(n))
        except fleet.FleetError as error:
            # The scheduler was away too long for this client: a new one resumes.
            assert error.code == "scheduler-lost"
            thread.join()
            with distributed.Client(processes.address, timeout=60) as again:
                summary = run(manifest, tmp_path / "out", again)
    thread.join()
    assert restarted.is_set() and summary.failed == 0
    fleet.identify(
        manifest,
        out=tmp_path / "whole",
        workers=2,
        logs_per_part=1,
        progress=False,
        identify_one=fleets.identification,
    )
    assert fleets.contents(tmp_path / "out") == fleets.contents(tmp_path / "whole")


def test_logs_experiments_and_datasets_in_an_object_store(
    tmp_path: Path, cluster: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    moto = pytest.importorskip("moto.server")
    s3fs = pytest.importorskip("s3fs")

    server = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    try:
        host, port = server.get_host_and_port()
        environment = {
            "AWS_ENDPOINT_URL": f"http://{host}:{port}",
            "AWS_ACCESS_KEY_ID": "test",
            "AWS_SECRET_ACCESS_KEY": "test",
            "AWS_DEFAULT_REGION": "us-east-1",
        }
        for key, value in environment.items():
            monkeypatch.setenv(key, value)
        manifest = fleets.manifest(tmp_path)
        (tmp_path / "log-5.csv").unlink()
        store = s3fs.S3FileSystem()
        store.mkdir("fleet")
        for path in tmp_path.glob("*.*"):
            store.put_file(str(path), f"fleet/{path.name}")
        with distributed.Client(cluster) as client:
            client.run(fleets.set_environment, environment)
            summary = run(f"s3://fleet/{manifest.name}", "s3://fleet/out", client, identify_one=fleets.reads)
            assert (summary.tasks, summary.failed) == (12, 1)
            assert run(f"s3://fleet/{manifest.name}", "s3://fleet/out", client).resumed == 12
        found = fleet.Dataset.read("s3://fleet/out")
        (failure,) = found.rows("failure").to_pylist()
        assert failure["code"] == "file-missing" and failure["log"] == "s3://fleet/log-5.csv"
        assert sorted(found.rows("parameter").to_pandas().value) == [n for n in range(12) if n != 5]
    finally:
        server.stop()


def test_an_unreachable_store_is_refused_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for key in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(key, "test")
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("AWS_MAX_ATTEMPTS", "1")
    manifest = fleets.manifest(tmp_path)
    with pytest.raises(fleet.DatasetError, match="s3://fleet/unreachable cannot be") as caught:
        fleet.identify(manifest, out="s3://fleet/unreachable", progress=False)
    assert caught.value.code == "dataset-unreachable"
