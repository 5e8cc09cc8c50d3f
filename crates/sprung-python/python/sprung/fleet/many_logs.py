"""All logs of one robot together, by map and reduce.

A map task reduces one log of a robot to the factors of least squares, on any worker, and writes them beside the
dataset. The part of the robot merges the factors of its logs. A log that fails leaves a failure, and the others count.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import files
from .manifest import Part, Task

if TYPE_CHECKING:
    from sprung import Choices, LogFactors

_FOLDER = "factors"
_ESTIMATOR = "identify.estimator="


@dataclass(frozen=True)
class Failed:
    """A log without factors."""

    log: str
    code: str
    text: str
    place: str | None
    remedy: str | None


def is_mapped(task: Task, overrides: Sequence[str]) -> bool:
    """Whether the logs of a task are reduced one by one: several logs of a robot, and least squares alone."""
    estimators = [one.removeprefix(_ESTIMATOR) for one in overrides if one.startswith(_ESTIMATOR)]
    linear = bool(estimators) and estimators[-1].strip("\"'[] ") == "least-squares"
    return task.level == "robot" and len(task.logs) > 1 and linear


def maps(parts: Iterable[Part], out: str, overrides: Sequence[str]) -> Iterator[Part]:
    """Yields a part for each log of a robot that has no factors yet."""
    for one in parts:
        for task in one.tasks:
            if is_mapped(task, overrides):
                there = _there(out, task)
                for order in range(len(task.logs)):
                    if f"{order:05d}.json" not in there:
                        yield Part(f"{task.key}-{order:05d}", (task,))


def order_of(part: Part) -> int:
    """Returns the number of the log that a part of `maps` reduces."""
    return int(part.name.rsplit("-", 1)[1])


def store(out: str, task: Task, order: int, outcome: LogFactors | Failed) -> int:
    """Writes the factors of a log, or its failure; returns the number of bytes."""
    if isinstance(outcome, Failed):
        content: dict[str, Any] = {"failed": outcome.__dict__}
    else:
        content = {"factors": outcome.to_json()}
    data = json.dumps(content).encode()
    files.write(_url(out, task, order), data)
    return len(data)


def stored(out: str, task: Task, order: int) -> LogFactors | Failed | None:
    """Returns the factors of a log, or its failure; ``None`` if there are none."""
    from sprung import LogFactors

    try:
        content = json.loads(files.read(_url(out, task, order)))
        if "failed" in content:
            return Failed(**content["failed"])
        return LogFactors.from_json(content["factors"])
    except (FileNotFoundError, ValueError):
        return None


def forget(out: str) -> None:
    """Removes all factors, which a finished run does not need."""
    system, path = files.filesystem(f"{out}/{_FOLDER}")
    if system.exists(path):
        system.rm(path, recursive=True)


def reduce_log(task: Task, order: int, experiment: str, paths: Sequence[str], overrides: tuple[str, ...]) -> LogFactors:
    """Reduces a log of a robot with the choices of its first log.

    - paths: local paths of the first log and of this one.
    """
    first, path = paths
    made = _choices(experiment, overrides, task.logs[0], first)
    reduced: LogFactors = _experiment(experiment, overrides).factors(
        path, order, made, name=task.logs[order], threads=1
    )
    return reduced


def identify(task: Task, factors: Sequence[LogFactors], experiment: str, first: str, overrides: tuple[str, ...]) -> str:
    """Identifies a robot from the factors of its logs; returns the text of identification.json."""
    loaded = _experiment(experiment, overrides)
    return str(loaded.identify_factors(factors, first, name=task.logs[0], threads=1).to_json())


@functools.lru_cache(maxsize=64)
def _experiment(path: str, overrides: tuple[str, ...]) -> Any:
    from sprung import Experiment

    return Experiment(path, overrides=overrides)


@functools.lru_cache(maxsize=256)
def _choices(experiment: str, overrides: tuple[str, ...], name: str, first: str) -> Choices:
    made: Choices = _experiment(experiment, overrides).choices(first, name=name, threads=1)
    return made


def _url(out: str, task: Task, order: int) -> str:
    return f"{out}/{_FOLDER}/{task.key}/{order:05d}.json"


def _there(out: str, task: Task) -> set[str]:
    system, path = files.filesystem(f"{out}/{_FOLDER}/{task.key}")
    system.invalidate_cache()
    if not system.exists(path):
        return set()
    return {entry.rsplit("/", 1)[-1] for entry in system.ls(path, detail=False)}
