"""Measures the memory of a report over many logs, against that of a report whose rows are all in memory.

    python benches/fleet/report_memory.py FOLDER [--robots 2000] [--logs 100] [--parameters 15] [--limit 700]

It needs the installed module sprung with `sprung[fleet]`. FOLDER keeps the datasets, whose estimates are drawn: one of
all robots and one of a quarter of them. Each report runs in a separate process. The exit code is 1 if the report of
the folder needs more memory than the limit (in MB), or if the page differs from that of the rows in memory.
"""

from __future__ import annotations

import argparse
import hashlib
import resource
import subprocess
import sys
import time
from pathlib import Path

LOGS_PER_PART = 32
FAILED = 0.01
NOT_IDENTIFIABLE = 0.01
START_US = 1_767_225_600_000_000
DAY_US = 86_400_000_000


def draw(out: Path, robots: int, logs: int, parameters: int) -> None:
    """Writes a dataset: one robot in a hundred is 5 % softer, one in a hundred becomes so."""
    import numpy as np
    from sprung.fleet import dataset

    if out.exists():
        return
    partial = out.with_suffix(".partial")
    dataset.prepare(str(partial), {"overrides": []})
    random = np.random.default_rng(0)
    truth = 1 + 0.005 * random.standard_normal((robots, parameters))
    truth[::100, 0] *= 0.95
    for start in range(0, robots * logs, LOGS_PER_PART):
        numbers = np.arange(start, min(start + LOGS_PER_PART, robots * logs))
        table = part(random, truth, numbers, logs)
        dataset.write_part(str(partial), f"part-{start:08}", table)
    partial.rename(out)


def part(random, truth, numbers, logs: int):
    """Returns the rows of some logs: an estimate of each parameter and a finding, or a failure."""
    import numpy as np
    import pyarrow as pa
    from sprung.fleet import schema

    robots, parameters = truth.shape
    robot, log = numbers // logs, numbers % logs
    failed = random.random(numbers.size) < FAILED
    counts = np.where(failed, 1, parameters + 1)
    row_log = np.repeat(np.arange(numbers.size), counts)
    place = np.concatenate([np.arange(count) for count in counts])
    estimate = ~failed[row_log] & (place < parameters)
    finding = ~failed[row_log] & (place == parameters)
    parameter = np.minimum(place, parameters - 1)
    soft = (robot[row_log] % 100 == 7) & (log[row_log] > logs // 2) & (parameter == 1)
    value = truth[robot[row_log], parameter] * np.where(soft, 0.95, 1.0) + 0.005 * random.standard_normal(row_log.size)
    temperature_c = random.uniform(10, 40, numbers.size)[row_log]
    names = [f"robot{one:06}" for one in robot[row_log]]

    def text(where, values):
        return pa.array([value if here else None for here, value in zip(where, values)], pa.string())

    def constant(where, value: str):
        return text(where, [value] * row_log.size)

    columns = {name: pa.nulls(row_log.size, kind) for name, kind in zip(schema().names, schema().types)}
    columns |= {
        "kind": pa.array(np.where(estimate, "parameter", np.where(finding, "finding", "failure")).tolist()),
        "task": pa.array([f"{number:020x}" for number in numbers[row_log]]),
        "level": pa.array(["log"] * row_log.size),
        "robot": pa.array(names),
        "log": pa.array([f"s3://logs/{name}/2026/run-{one:05}.parquet" for name, one in zip(names, log[row_log])]),
        "experiment": pa.array([f"s3://robots/{name}/experiment.toml" for name in names]),
        "time": pa.array(START_US + DAY_US * log[row_log], pa.timestamp("us", tz="UTC")),
        "estimator": constant(~failed[row_log], "least-squares"),
        "parameter": text(estimate, [f"joint{1 + one // 5}.parameter{one % 5}" for one in parameter]),
        "unit": constant(estimate, "N·m/rad"),
        "value": pa.array(value, mask=~estimate),
        "standard_error": pa.array(np.full(row_log.size, 0.003), mask=~estimate),
        "identifiable": pa.array(random.random(row_log.size) >= NOT_IDENTIFIABLE, mask=~estimate),
        "code": text(~estimate, np.where(failed[row_log], "file-missing", "noisy").tolist()),
        "text": constant(~estimate, "what was found in this log, in one sentence of usual length"),
        "remedy": constant(~estimate, "what to do about it"),
        "temperature_c": pa.array(temperature_c),
    }
    return pa.table(columns).cast(schema(["temperature_c"]))


def measure(out: str, in_memory: bool) -> None:
    """Prints seconds, peak of memory in MB, rows of failures and the digest of the page."""
    from sprung import fleet

    start = time.perf_counter()
    made = fleet.report(fleet.Dataset.read(out) if in_memory else out)
    digest = hashlib.sha256(made.html.encode()).hexdigest()
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    print(time.perf_counter() - start, peak_mb, digest)


def measured(out: Path, in_memory: bool) -> tuple[float, float, str]:
    command = [sys.executable, __file__, str(out), "--measure", "memory" if in_memory else "folder"]
    seconds, peak_mb, digest = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return float(seconds), float(peak_mb), digest


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--robots", type=int, default=2000)
    parser.add_argument("--logs", type=int, default=100, help="of each robot")
    parser.add_argument("--parameters", type=int, default=15)
    parser.add_argument("--limit", type=float, default=700.0, help="memory in MB")
    parser.add_argument("--measure", choices=["folder", "memory"], help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        measure(str(arguments.folder), arguments.measure == "memory")
        return 0
    failed = []
    for robots in (arguments.robots // 4, arguments.robots):
        out = arguments.folder / f"{robots}-robots"
        draw(out, robots, arguments.logs, arguments.parameters)
        print(f"{robots * arguments.logs} logs of {robots} robots, {arguments.parameters} parameters", flush=True)
        pages = set()
        for name, in_memory in (("parts one by one", False), ("all rows in memory", True)):
            seconds, peak_mb, digest = measured(out, in_memory)
            pages.add(digest)
            print(f"  {name:<20} {peak_mb:6.0f} MB, {seconds:.0f} s", flush=True)
            if not in_memory and peak_mb > arguments.limit:
                failed.append(f"memory of {robots} robots")
        if len(pages) > 1:
            failed.append(f"page of {robots} robots")
    for what in failed:
        print(f"beyond the limits: {what}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
