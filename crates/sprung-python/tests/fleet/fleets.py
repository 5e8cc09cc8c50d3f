"""Fleets for tests: simulated logs, manifests, and identifications that misbehave."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from pathlib import Path

from sprung.fleet.arrow import pa, pq

FOLDER = Path(__file__).resolve().parent
DEMO = Path(__file__).resolve().parents[3] / "sprung-base" / "src" / "demo"
OVERRIDES = {"identify.estimator": "least-squares"}


def environment() -> dict[str, str]:
    """The environment of workers, which import this file."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(FOLDER), *(path for path in sys.path if path)])}


def set_environment(variables: dict[str, str]) -> None:
    """Changes the environment of this process."""
    os.environ.update(variables)


def identification(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """Instead of an identification: the numbers of the log's name, quickly."""
    names = [Path(log).stem for log in logs]
    value = sum(float(name.split("-")[1]) for name in names) / len(names)
    parameter = {
        "name": "joint1.stiffness",
        "unit": "N·m/rad",
        "value": value,
        "standard_error": 0.1,
        "ci95": [value - 0.2, value + 0.2],
        "nominal": None,
        "identifiable": True,
    }
    finding = {"code": "noisy", "severity": "info", "parameters": ["joint1.stiffness"], "text": "t", "remedy": "r"}
    result = {"estimator": "least-squares", "verdict": "good", "parameters": [parameter], "warnings": [finding]}
    return json.dumps({"log": {"samples": 1000, "duration_s": 0.999}, "findings": [], "results": [result]})


def slow(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """As `identification`, in 0.05 s."""
    time.sleep(0.05)
    return identification(experiment, logs, overrides)


def dies_once(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """Kills its own process at the first log named "-3" that it sees; the file beside the log remembers that."""
    mark = Path(logs[0]).parent / "died"
    if logs[0].endswith("-3.csv") and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return identification(experiment, logs, overrides)


def dies(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """Kills its own process at every log named "-3"."""
    if logs[0].endswith("-3.csv"):
        os.kill(os.getpid(), signal.SIGKILL)
    return identification(experiment, logs, overrides)


def reads(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """As `identification`, but reads all files."""
    for path in (experiment, *logs):
        Path(path).read_bytes()
    return identification(experiment, logs, overrides)


def counts_calls(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """As `identification`; appends each log to the file ``calls`` beside it."""
    with (Path(logs[0]).parent / "calls").open("a") as calls:
        calls.write(f"{Path(logs[0]).name}\n")
    return identification(experiment, logs, overrides)


def calls(folder: Path) -> list[str]:
    """The logs that `counts_calls` identified since the last call of this function, sorted."""
    path = folder / "calls"
    found = sorted(path.read_text().split()) if path.exists() else []
    path.unlink(missing_ok=True)
    return found


def full_disk(url: str, content: bytes) -> None:
    """Instead of writing: the error of a full disk."""
    raise OSError(28, "No space left on device", url)


def manifest(folder: Path, robots: int = 4, logs: int = 3) -> Path:
    """Writes a manifest whose logs are for `identification`, with an experiment file."""
    (folder / "experiment.toml").write_text("format = 1\n")
    lines = ["robot,experiment,log,time,temperature_c"]
    for robot in range(robots):
        for log in range(logs):
            number = robot * logs + log
            (folder / f"log-{number}.csv").write_text(f"{number}\n")
            lines.append(f"{robot:03},experiment.toml,log-{number}.csv,2026-01-{log + 1:02},{20 + log}")
    path = folder / "manifest.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def simulated(folder: Path, robots: int, logs: int) -> Path:
    """Simulates logs of the demo's robot, whose stiffness differs between robots. Returns the manifest."""
    from sprung import Experiment

    experiment = (DEMO / "experiment.toml").read_text(encoding="utf-8")
    truth = (DEMO / "truth.toml").read_text(encoding="utf-8")
    rows = []
    for robot in range(robots):
        robot_folder = folder / f"robot{robot}"
        robot_folder.mkdir(parents=True)
        (robot_folder / "experiment.toml").write_text(experiment, encoding="utf-8")
        (robot_folder / "truth.toml").write_text(
            scaled(truth, "joint1.stiffness", 1 + 0.01 * robot), encoding="utf-8"
        )
        for log in range(logs):
            columns = Experiment(robot_folder / "experiment.toml").simulate(seed=100 * robot + log)
            pq.write_table(pa.table(dict(columns)), robot_folder / f"log{log}.parquet")
            rows.append(
                {
                    "robot": f"robot{robot}",
                    "experiment": str(robot_folder),
                    "log": str(robot_folder / f"log{log}.parquet"),
                }
            )
    path = folder / "manifest.parquet"
    pq.write_table(pa.Table.from_pylist(rows), path)
    return path


def scaled(truth: str, name: str, factor: float) -> str:
    """Multiplies one value of a truth file."""
    lines = []
    for line in truth.splitlines():
        key, _, value = line.partition("=")
        if key.strip().strip('"') == name:
            line = f"{key}= {float(value.split('#')[0]) * factor!r}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def contents(out: Path) -> dict[str, bytes]:
    """All files of a dataset."""
    return {path.name: path.read_bytes() for path in sorted(out.iterdir())}


