"""Identifies a simulated fleet on two Dask workers, and compares with two bare processes and with Ray.

    python benches/fleet/throughput.py FOLDER [--robots 200] [--logs 10] [--kill-every 20] [--without-kills]
                                              [--second-engine] [--rounds 2]

It needs the installed module sprung with `sprung[fleet]` and distributed, and ray[data] for the second engine. FOLDER
keeps the simulated logs (10 s each) and the datasets. With the second engine, both engines take turns in each round,
and the bare processes and the killed workers are left out. The exit code is 1 if the Dask workers reach less than
85 % of the throughput of the bare processes, if the memory of the client grows, if killed workers or the second
engine change a byte of the dataset, or if the second engine takes more than 1.2 times as long as Dask.
"""

from __future__ import annotations

import argparse
import csv
import functools
import json
import multiprocessing
import os
import resource
import shutil
import signal
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

LEAST_SQUARES = {"identify.estimator": "least-squares"}
THROUGHPUT_AT_LEAST = 0.85
SECOND_ENGINE_AT_MOST = 1.2
LOGS_PER_PART = 10
# Growth of the client between the first tenth of the run and its end; Python's allocator needs a little.
GROWTH_AT_MOST_MB = 20.0
WORKERS = 2
ROBOTS_OF_THE_PLAN, LOGS_A_DAY = 100_000, 10


def simulate(folder: Path, robot: int, logs: int) -> list[dict[str, str]]:
    """Simulates the logs of one robot, whose parameters differ by 0.5 % from the mean, as CSV files."""
    import numpy as np
    from sprung import Experiment

    robot_folder = folder / f"robot{robot:04}"
    demo = Experiment.demo()
    random = np.random.default_rng(robot)
    truth = {name: value * (1 + 0.005 * random.standard_normal()) for name, value in demo.truth().items()}
    robot_folder.mkdir(parents=True, exist_ok=True)
    (robot_folder / "experiment.toml").write_text(demo.text, encoding="utf-8")
    lines = [f'"{name}" = {float(value)!r}' for name, value in truth.items()]
    (robot_folder / "truth.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    experiment = Experiment(robot_folder / "experiment.toml")
    rows = []
    for log in range(logs):
        path = robot_folder / f"log{log:02}.csv"
        if not path.exists():
            columns = experiment.simulate(seed=1000 * robot + log, threads=1)
            table = np.column_stack(list(columns.values()))
            partial = path.with_suffix(".part")
            np.savetxt(partial, table, delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
            partial.rename(path)
        rows.append({"robot": robot_folder.name, "experiment": str(robot_folder), "log": str(path)})
    return rows


def bare(rows: list[dict[str, str]]) -> float:
    """Identifies logs without fleet, dataset and engine. Returns the seconds of processor that it took."""
    import warnings

    from sprung import Experiment

    warnings.simplefilter("ignore")
    start = time.process_time()
    for row in rows:
        experiment = Experiment(row["experiment"], overrides=LEAST_SQUARES)
        assert json.loads(experiment.identify(row["log"], threads=1).to_json())["results"]
    return time.process_time() - start


def memory_mb() -> float:
    """Memory of this process now, in MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def fleet(manifest: Path, out: Path, client: object) -> tuple[float, list[float], object]:
    """Runs the fleet. Returns seconds, memory of the client after each part in MB, and the summary."""
    import sprung.fleet

    memory: list[float] = []
    shutil.rmtree(out, ignore_errors=True)
    start = time.perf_counter()
    summary = sprung.fleet.identify(
        manifest,
        out=out,
        client=client,
        overrides=LEAST_SQUARES,
        logs_per_part=LOGS_PER_PART,
        progress=lambda *_: memory.append(memory_mb()),
    )
    return time.perf_counter() - start, memory, summary


def with_ray(manifest: Path, out: Path) -> float:
    """Runs the fleet on Ray, which has the function of `sprung.fleet` as its own. Returns seconds."""
    import ray
    import sprung.fleet

    shutil.rmtree(out, ignore_errors=True)
    start = time.perf_counter()
    todo = sprung.fleet.missing_logs(manifest, out=out, overrides=LEAST_SQUARES, logs_per_part=LOGS_PER_PART)
    logs = ray.data.from_arrow(todo, override_num_blocks=-(-todo.num_rows // LOGS_PER_PART))
    identify = functools.partial(sprung.fleet.identify_batch, overrides=LEAST_SQUARES)
    rows = logs.map_batches(identify, batch_format="pyarrow", batch_size=None)
    sprung.fleet.write_rows(rows.iter_batches(batch_format="pyarrow", batch_size=None), todo, out=out)
    return time.perf_counter() - start


def second_engine(folder: Path, manifest: Path, rows: list[dict[str, str]], rounds: int) -> list[str]:
    """Compares Dask and Ray, which take turns. Returns what is beyond the limits."""
    import distributed
    import ray

    few = folder / "few.csv"
    few.write_text("\n".join(manifest.read_text().splitlines()[: 2 * LOGS_PER_PART + 1]) + "\n")
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    # Ray's workers would yield to every other process of a busy computer, and those of Dask would not.
    os.environ["RAY_worker_niceness"] = "0"
    ray.init(num_cpus=WORKERS, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    ray.data.DataContext.get_current().enable_progress_bars = False
    options = {"n_workers": WORKERS, "threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    dask_s = ray_s = 0.0
    same = True
    with distributed.LocalCluster(**options, silence_logs=50) as cluster, distributed.Client(cluster) as client:
        # Workers start and import sprung before they are measured.
        fleet(few, folder / "out", client)
        with_ray(few, folder / "ray")
        for number in range(rounds):
            one_s, _, _ = fleet(manifest, folder / "out", client)
            other_s = with_ray(manifest, folder / "ray")
            dask_s, ray_s = dask_s + one_s, ray_s + other_s
            same = same and contents(folder / "out") == contents(folder / "ray")
            rates = f"Dask {len(rows) / one_s:.1f} logs/s, Ray {len(rows) / other_s:.1f} logs/s"
            print(f"round {number + 1}: {rates}, {'the same bytes' if same else 'OTHER BYTES'}", flush=True)
    ray.shutdown()
    print(f"Ray takes {ray_s / dask_s:.2f} times as long as Dask")
    beyond = [] if same else ["bytes of the second engine"]
    return beyond if ray_s <= SECOND_ENGINE_AT_MOST * dask_s else [*beyond, "throughput of the second engine"]


def kill(cluster: object, every_s: float, stop: threading.Event, killed: list[int]) -> None:
    """Kills one worker process after the other; the nanny starts a new one."""
    while not stop.wait(every_s):
        nannies = list(cluster.workers.values())
        process = nannies[len(killed) % len(nannies)].process
        if process is not None and process.pid:
            killed.append(process.pid)
            os.kill(process.pid, signal.SIGKILL)


def contents(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


def write_manifest(folder: Path, robots: int, logs: int) -> tuple[Path, list[dict[str, str]]]:
    with ProcessPoolExecutor(WORKERS, mp_context=multiprocessing.get_context("spawn")) as pool:
        groups = pool.map(simulate, [folder / "logs"] * robots, range(robots), [logs] * robots)
        rows = [row for group in groups for row in group]
    manifest = folder / "manifest.csv"
    with manifest.open("w", newline="") as file:
        writer = csv.DictWriter(file, ["robot", "experiment", "log"])
        writer.writeheader()
        writer.writerows(rows)
    return manifest, rows


def plan(rows: list[dict[str, str]], processor_s: float, size: int) -> None:
    """Prints what a day of a large fleet costs, from the figures of this run."""
    logs = len(rows)
    log_bytes = sum(Path(row["log"]).stat().st_size for row in rows) / logs
    core_s = processor_s / logs
    day = ROBOTS_OF_THE_PLAN * LOGS_A_DAY
    print(f"per log of 10 s: {core_s:.3f} core seconds, {log_bytes / 1e6:.2f} MB read, {size / logs / 1e3:.2f} kB written")
    print(
        f"{ROBOTS_OF_THE_PLAN} robots with {LOGS_A_DAY} logs a day: {day * core_s / 3600:.0f} core hours, "
        f"{day * log_bytes / 1e12:.2f} TB read, {day * size / logs / 1e9:.1f} GB written, "
        f"{day / 32:.0f} parts of 32 logs"
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--robots", type=int, default=200)
    parser.add_argument("--logs", type=int, default=10)
    parser.add_argument("--kill-every", type=float, default=20.0, help="seconds between two kills")
    parser.add_argument("--without-kills", action="store_true")
    parser.add_argument("--second-engine", action="store_true", help="compare Dask and Ray")
    parser.add_argument("--rounds", type=int, default=2, help="runs of each of both engines")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    import distributed

    manifest, rows = write_manifest(folder, arguments.robots, arguments.logs)
    count = len(rows)
    if arguments.second_engine:
        failed = second_engine(folder, manifest, rows, arguments.rounds)
        for what in failed:
            print(f"beyond the limits: {what}")
        return 1 if failed else 0
    failed = []
    with ProcessPoolExecutor(WORKERS, mp_context=multiprocessing.get_context("spawn")) as pool:
        list(pool.map(bare, [rows[:2], rows[-2:]]))
        start = time.perf_counter()
        processor_s = sum(pool.map(bare, [rows[k::WORKERS] for k in range(WORKERS)]))
        bare_s = time.perf_counter() - start
    print(f"two bare processes: {bare_s:.1f} s, {count / bare_s:.1f} logs/s", flush=True)
    options = {"n_workers": WORKERS, "threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options, silence_logs=50) as cluster, distributed.Client(cluster) as client:
        fleet_s, memory, summary = fleet(manifest, folder / "out", client)
        ratio = bare_s / fleet_s
        growth = max(memory[len(memory) // 2 :]) - max(memory[: max(1, len(memory) // 10)])
        print(f"two Dask workers:   {fleet_s:.1f} s, {count / fleet_s:.1f} logs/s: {100 * ratio:.0f} % of the bare processes")
        print(f"client: {max(memory):.0f} MB at most, {growth:+.1f} MB from the first tenth of the run to its second half")
        if ratio < THROUGHPUT_AT_LEAST:
            failed.append("throughput")
        if growth > GROWTH_AT_MOST_MB:
            failed.append("memory of the client")
        if not arguments.without_kills:
            stop, killed = threading.Event(), []
            killer = threading.Thread(target=kill, args=(cluster, arguments.kill_every, stop, killed))
            killer.start()
            try:
                killed_s, _, of_killed = fleet(manifest, folder / "killed", client)
            finally:
                stop.set()
                killer.join()
            same = contents(folder / "killed") == contents(folder / "out")
            print(
                f"a worker killed every {arguments.kill_every:.0f} s: {len(killed)} killed, {killed_s:.1f} s, "
                f"{of_killed.failed} failures, {'the same bytes' if same else 'OTHER BYTES'}"
            )
            if not same or not killed:
                failed.append("killed workers")
    if summary.failed:
        failed.append(f"{summary.failed} logs")
    plan(rows, processor_s, summary.bytes)
    for what in failed:
        print(f"beyond the limits: {what}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
