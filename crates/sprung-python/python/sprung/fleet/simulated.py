"""A small simulated fleet, to try everything without logs of one's own."""

from __future__ import annotations

import datetime
import os
from pathlib import Path

import numpy as np

from .arrow import csv, pa

BETWEEN_ROBOTS = 0.005
"""Relative standard deviation of the parameters between robots."""


def demo(folder: str | os.PathLike[str], *, robots: int = 3, logs: int = 4) -> Path:
    """Simulates logs of robots like that of `Experiment.demo` and returns their manifest.

    - folder: where experiments, logs and ``manifest.csv`` are written; it is made if it does not exist.
    - robots, logs: number of robots, and of logs of each robot. A log has 10 s and takes 1.3 MB.

    The parameters of the robots differ by 0.5 %. The logs of a robot are a week apart. The same numbers give the same
    files.

    Raises ValueError for a number below 1, OSError if a file cannot be written.

    >>> import tempfile
    >>> from sprung import fleet
    >>> manifest = fleet.demo(tempfile.mkdtemp(), robots=1, logs=1)
    >>> print(manifest.read_text().splitlines()[0])
    robot,experiment,log,time,temperature_c
    """
    if robots < 1 or logs < 1:
        raise ValueError(f"robots is {robots} and logs is {logs}; both need to be at least 1")
    path = Path(folder)
    lines = ["robot,experiment,log,time,temperature_c"]
    for robot in range(robots):
        lines += simulate_robot(path, robot, logs)
    manifest = path / "manifest.csv"
    manifest.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return manifest


def simulate_robot(folder: Path, robot: int, logs: int) -> list[str]:
    """Writes the experiment and the logs of one robot; returns its lines of the manifest. Logs that exist are kept."""
    from sprung import Experiment

    random = np.random.default_rng(robot)
    original = Experiment.demo()
    truth = {name: value * (1 + BETWEEN_ROBOTS * random.standard_normal()) for name, value in original.truth().items()}
    name = f"robot{robot}"
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    (place / "experiment.toml").write_text(original.text, encoding="utf-8")
    values = "".join(f'"{parameter}" = {float(value)!r}\n' for parameter, value in truth.items())
    (place / "truth.toml").write_text(values, encoding="utf-8")
    experiment = Experiment(place / "experiment.toml")
    start = datetime.datetime(2026, 1, 5, tzinfo=datetime.timezone.utc)
    lines = []
    for log in range(logs):
        path = place / f"log{log}.csv"
        if not path.exists():
            columns = experiment.simulate(seed=1000 * robot + log, threads=1)
            partial = path.with_suffix(".part")
            csv.write_csv(pa.table(dict(columns)), partial)
            partial.rename(path)
        time = start + datetime.timedelta(weeks=log)
        temperature_c = round(20.0 + 2.0 * random.standard_normal(), 1)
        lines.append(f"{name},{name},{name}/{path.name},{time:%Y-%m-%dT%H:%M:%SZ},{temperature_c}")
    return lines
