"""Tests the statistics of fleets on simulated fleets with known truth.

    python benches/fleet/statistics.py [--fleets 200]

It needs the installed module sprung with `sprung[fleet]`.

The estimates are drawn: each robot has its own parameters, each log its own scatter and standard error, and the
scatter of one estimate is 0.7 % in all. The table has for each kind of fleet the mean part of false discoveries among
the named robots at the level of 5 %, and the part of the changed robots that are found. The exit code is 1 if the
former exceeds the level by more than four standard errors of a mean of as many fleets, or if a loss of stiffness of 5 % in
1 of 200 robots is found in less than 95 % of the fleets. Kinds with one log of each robot have ten times as many fleets.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from figure import note  # noqa: E402

FALSE_LEVEL = 0.05
FOUND_AT_LEAST = 0.95
PARAMETERS = ("joint1.stiffness", "joint1.rotor_inertia", "joint1.motor_viscous", "joint1.motor_coulomb")
DAY_S = 86400.0


@dataclass(frozen=True)
class Kind:
    """A kind of fleet. Relative scatters; `changed` robots have `change` in their stiffness."""

    name: str
    robots: int = 200
    logs: int = 10
    between: float = 0.005
    within: float = 0.0035
    error: float = 0.0035
    changed: int = 0
    change: float = -0.05
    over_time: str = ""
    unequal: float = 0.0
    """Scatter of the logarithm of the scatter within robots."""
    decides: bool = False
    shared: float = 0.0
    """Error that all robots share, and which their standard errors contain."""


KINDS = (
    Kind("no robot changed"),
    Kind("1 of 200, 5 % softer", changed=1, decides=True),
    Kind("1 of 200, one log each", logs=1, changed=1, decides=True),
    Kind("10 of 200, 5 % softer", changed=10),
    Kind("40 of 200, 5 % softer", changed=40),
    Kind("10 of 200, 2 % softer", changed=10, change=-0.02),
    Kind("3 of 20, 5 % softer", robots=20, changed=3),
    Kind("1 of 200 softens at a time", changed=1, over_time="step"),
    Kind("10 of 200 soften at a time", changed=10, over_time="step"),
    Kind("10 of 200, unequal logs", changed=10, over_time="step", unequal=0.4),
    Kind("10 of 200, 30 logs, 2 %", logs=30, changed=10, change=-0.02, over_time="step", unequal=0.3),
    Kind("10 of 200 soften slowly", changed=10, over_time="trend"),
    Kind("common motion and bias", robots=20, logs=1, shared=0.3),
    Kind("the same, 1 of 20 softer", robots=20, logs=1, between=0.002, shared=0.3, changed=1, decides=True),
)


def simulate(kind: Kind, seed: int):
    """Draws a fleet. Returns its rows, the changed robots and their times of change."""
    import numpy as np
    from sprung.fleet.population import Rows

    random = np.random.default_rng(seed)
    count = kind.robots * kind.logs
    robot = np.repeat(np.arange(kind.robots), kind.logs)
    time_s = np.sort(random.uniform(0, 365, (kind.robots, kind.logs)), axis=1).ravel() * DAY_S
    changed = random.choice(kind.robots, kind.changed, replace=False)
    moment = random.uniform(60, 300, kind.robots) * DAY_S
    rows = []
    unequal = np.exp(kind.unequal * random.standard_normal(kind.robots))[robot]
    for parameter in PARAMETERS:
        error = kind.error * np.exp(0.3 * random.standard_normal(count))
        value = 1.0 + kind.between * random.standard_normal(kind.robots)[robot]
        value += kind.within * unequal * random.standard_normal(count) + error * random.standard_normal(count)
        value += kind.shared * random.standard_normal()
        error = np.hypot(error, kind.shared)
        if parameter == PARAMETERS[0]:
            part = {"": 1.0, "step": time_s > moment[robot], "trend": time_s / (365 * DAY_S)}[kind.over_time]
            value += np.where(np.isin(robot, changed), kind.change * part, 0.0)
        rows.append((value, error))
    names = np.array([f"robot{number:04}" for number in robot], dtype=object)
    repeated = len(PARAMETERS)
    fleet = Rows(
        robot=np.tile(names, repeated),
        parameter=np.repeat(np.array(PARAMETERS, dtype=object), count),
        unit=np.full(count * repeated, "1", dtype=object),
        value=np.concatenate([value for value, _ in rows]),
        standard_error=np.concatenate([error for _, error in rows]),
        time_s=np.tile(time_s, repeated),
    )
    return fleet, {f"robot{number:04}": moment[number] for number in changed}


def one(kind: Kind, seed: int) -> dict[str, list[float]]:
    """Analyses one fleet: false part of the named, found part of the changed, coverages."""
    from sprung.fleet.population import analyse

    fleet, changed = simulate(kind, seed)
    analysis = analyse(fleet)
    result: dict[str, list[float]] = {key: [] for key in ("false", "found", "time", "change")}
    named = analysis.moved() if kind.over_time else analysis.outliers()
    right = [pair for pair in named if pair[1].robot in changed and pair[0].parameter == PARAMETERS[0]]
    result["false"] = [(len(named) - len(right)) / max(len(named), 1)]
    if changed:
        result["found"] = [len(right) / len(changed)]
    if kind.over_time == "step":
        for _, moved in right:
            low, high = moved.drift.time_ci95_s
            result["time"].append(float(low <= changed[moved.robot] <= high))
            low, high = moved.drift.change_ci95
            result["change"].append(float(low <= kind.change <= high))
    return result


def false_at_most(fleets: int) -> float:
    """Returns the limit of the mean false part: no part between 0 and 1 scatters more than one that is 0 or 1."""
    return FALSE_LEVEL + 4 * math.sqrt(FALSE_LEVEL * (1 - FALSE_LEVEL) / fleets)


def mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else float("nan")


def percent(value: float) -> str:
    return "-" if value != value else f"{100 * value:.1f} %"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fleets", type=int, default=200, help="simulated fleets of each kind")
    arguments = parser.parse_args()
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[variable] = "1"
    print(f"{'kind of fleet':<28} {'false':>7} {'found':>8} {'time in':>8} {'change in':>9} {'s/fleet':>8}")
    failed = []
    with ProcessPoolExecutor() as pool:
        for number, kind in enumerate(KINDS):
            start = time.perf_counter()
            fleets = arguments.fleets * (10 if kind.logs == 1 else 1)
            seeds = [1_000_000 * number + fleet for fleet in range(fleets)]
            results = list(pool.map(one, [kind] * len(seeds), seeds, chunksize=5))
            figures = {key: mean([v for r in results for v in r[key]]) for key in ("false", "found", "time", "change")}
            seconds = (time.perf_counter() - start) / fleets
            cells = [percent(figures[key]) for key in ("false", "found", "time", "change")]
            print(f"{kind.name:<28} {cells[0]:>7} {cells[1]:>8} {cells[2]:>8} {cells[3]:>9} {seconds:8.2f}", flush=True)
            note(f"{kind.name}, false", f"{kind.name}: false among the named robots", 100 * figures["false"], "%", scatter=0.5)
            if figures["found"] == figures["found"]:
                note(f"{kind.name}, found", f"{kind.name}: changed robots found", 100 * figures["found"], "%",
                     better="higher", scatter=0.05)
            for key in ("time", "change"):
                if figures[key] == figures[key]:
                    note(f"{kind.name}, {key}", f"{kind.name}: 95 % intervals of the {key} of the found robots that contain it",
                         100 * figures[key], "%", better="none")
            if figures["false"] > false_at_most(fleets) or (kind.decides and figures["found"] < FOUND_AT_LEAST):
                failed.append(kind.name)
    print("time in, change in: part of the 95 % intervals of the found steps that contain the truth")
    for name in failed:
        print(f"above the limits: {name}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
