"""Watches the robots of a fleet: the first log of each robot is that of the healthy one."""

from __future__ import annotations

import contextlib
import itertools
import os
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, TypeAlias

from . import work
from .arrow import ArrowTable, pa
from .manifest import Manifest, Task
from .run import assignments

if TYPE_CHECKING:
    import pyarrow

Overrides: TypeAlias = Sequence[str] | Mapping[str, Any]

#: Columns of the table of events.
COLUMNS = ("robot", "log", "code", "joint", "begins_s", "ends_s", "torque_nm", "text")


def watch(
    manifest: str | os.PathLike[str] | ArrowTable,
    *,
    overrides: Overrides = (),
    false_alarms_per_h: float = 1.0,
    workers: int | None = None,
) -> pyarrow.Table:
    """Watches every robot of a manifest; returns a table of events. A robot that fails is a row with the code of its error.

    - manifest, overrides, workers: as for `identify`. The first log of each robot, by time, is identified and is that of the
      healthy robot; its later logs are watched.
    - false_alarms_per_h: false alarms of all joints of a robot together that the thresholds promise.

    A script needs ``if __name__ == "__main__":``, because processes import it.

    Raises ManifestError for a manifest that cannot be read or contradicts itself.

    >>> import tempfile
    >>> from sprung import fleet
    >>> manifest = fleet.demo(tempfile.mkdtemp(), robots=1, logs=2)
    >>> fleet.watch(manifest, overrides={"identify.estimator": "least-squares"}, workers=1).num_rows
    0
    """
    settings = assignments(overrides)
    parts = Manifest.read(manifest).parts(settings, ("log",), 1)
    tasks = [task for part in parts for task in part.tasks]
    robots = [list(group) for _, group in itertools.groupby(tasks, key=lambda task: task.robot)]
    given = [(group, settings, false_alarms_per_h) for group in robots]
    if workers == 1:
        rows = [row for one in given for row in watch_robot(*one)]
    else:
        with ProcessPoolExecutor(workers) as pool:
            rows = [row for found in pool.map(_watch_robot, given) for row in found]
    kinds = [pa.string()] * 4 + [pa.float64()] * 3 + [pa.string()]
    columns = zip(COLUMNS, kinds, strict=True)
    table: pyarrow.Table = pa.table({name: pa.array([row[name] for row in rows], kind) for name, kind in columns})
    return table


def _watch_robot(given: tuple[list[Task], tuple[str, ...], float]) -> list[dict[str, Any]]:
    return watch_robot(*given)


def watch_robot(tasks: Sequence[Task], settings: Sequence[str], false_alarms_per_h: float) -> list[dict[str, Any]]:
    """Watches the later logs of one robot with the first one; returns its events."""
    from sprung import Experiment, SprungWarning

    first, *later = tasks
    try:
        with contextlib.ExitStack() as stack, warnings.catch_warnings():
            # Findings of the identification are not those of the watch.
            warnings.simplefilter("ignore", category=SprungWarning)
            experiment, (healthy,) = work.local(first, stack)
            logs = {work.local(task, stack)[1][0]: task.logs[0] for task in later}
            robot = Experiment(experiment, overrides=[*settings, f"log.file={os.path.abspath(healthy)}"])
            result = robot.identify(threads=1)
            if not logs:
                return []
            watched = result.watch(list(logs), false_alarms_per_h=false_alarms_per_h, threads=1)
    except (ImportError, MemoryError):
        raise
    except Exception as error:
        row = work.failure(first, error)
        return [dict.fromkeys(COLUMNS) | {"robot": first.robot, "code": row["code"], "text": row["text"]}]
    return [
        {
            "robot": first.robot,
            "log": logs.get(event.log, event.log),
            "code": event.finding.code,
            "joint": event.joint,
            "begins_s": event.begins_s,
            "ends_s": event.ends_s,
            "torque_nm": event.torque_nm,
            "text": event.finding.text,
        }
        for event in watched.events
    ]
