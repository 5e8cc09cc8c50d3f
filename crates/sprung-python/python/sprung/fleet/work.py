"""The work of one part, on any worker: identify its logs, write its file."""

from __future__ import annotations

import contextlib
import functools
import re
import tempfile
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from . import dataset, files
from .manifest import Part, Task, experiment_file

if TYPE_CHECKING:
    import pyarrow

Identify: TypeAlias = Callable[[str, list[str], list[str]], str]
"""Identifies an experiment (path) from logs (paths) with settings (``key=value``); the text of identification.json."""


@dataclass(frozen=True)
class Settings:
    """The same for all parts of a run."""

    out: str
    overrides: tuple[str, ...]
    covariates: tuple[str, ...]
    identify: Identify


@dataclass(frozen=True)
class Done:
    """Counts of a part that is written."""

    tasks: int
    logs: int
    failed: int
    bytes: int


def identify(experiment: str, logs: list[str], overrides: list[str]) -> str:
    """Identifies with one thread, because the workers share the processors."""
    from sprung import Experiment, SprungWarning

    log: Any = logs[0] if len(logs) == 1 else logs
    with warnings.catch_warnings():
        # The dataset has the findings.
        warnings.simplefilter("ignore", category=SprungWarning)
        return Experiment(experiment, overrides=overrides).identify(log, threads=1).to_json()


def identify_tasks(tasks: Sequence[Task], settings: Settings) -> pyarrow.Table:
    """Identifies tasks one after the other; returns their rows of the dataset. A task that fails has a failure.

    Every engine calls this function. Raises ImportError, MemoryError, and OSError if a disk is full: another worker
    can then do the same tasks.
    """
    rows = [row for task in tasks for row in _rows(task, settings)]
    return dataset.table_of(rows, settings.covariates)


def run_part(part: Part, settings: Settings) -> Done:
    """Identifies the logs of a part and writes its file. Raises as `identify_tasks`, and OSError without the file."""
    table = identify_tasks(part.tasks, settings)
    size = dataset.write_part(settings.out, part.name, table)
    return Done(len(part.tasks), sum(len(task.logs) for task in part.tasks), dataset.failed_tasks(table), size)


def _rows(task: Task, settings: Settings) -> list[dataset.Row]:
    try:
        with contextlib.ExitStack() as stack:
            experiment, logs = local(task, stack)
            return dataset.rows_of(task, settings.identify(experiment, logs, list(settings.overrides)))
    except (ImportError, MemoryError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and files.is_full(error):
            raise
        return [failure(task, error)]


def local(task: Task, stack: contextlib.ExitStack) -> tuple[str, list[str]]:
    """Returns local paths of experiment and logs. Copies are removed with the stack."""
    remote = not all(files.is_local(url) for url in task.logs)
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="sprung-"))) if remote else Path()
    logs = [str(files.fetch(url, folder, number)) for number, url in enumerate(task.logs)]
    return _local_experiment(task.experiment), logs


@functools.lru_cache(maxsize=1024)
def _local_experiment(url: str) -> str:
    """Returns the local path of an experiment: its own, or that of a copy with the robot's description."""
    if files.is_local(url):
        return files.local_path(url)
    file = experiment_file(url)
    # The copies live as long as this process: every log of the robot needs them.
    folder = tempfile.mkdtemp(prefix="sprung-experiment-")
    path = files.fetch(file, Path(folder))
    for name in re.findall(r'"([^"\n]+\.(?:urdf|toml|json))"', path.read_text(encoding="utf-8")):
        if "://" in name or Path(name).is_absolute():
            continue
        target = path.parent / name
        if not target.resolve().is_relative_to(path.parent.resolve()):
            continue
        with contextlib.suppress(FileNotFoundError):
            target.parent.mkdir(parents=True, exist_ok=True)
            files.fetch(f"{files.parent(file)}/{name}", Path(folder) / "fetched").replace(target)
    return str(path)


def failure(task: Task, error: Exception) -> dataset.Row:
    """Describes an error of one task; errors of sprung have a code, a place and a remedy."""
    code = getattr(error, "code", None)
    remedy = getattr(error, "remedy", None)
    if code is None:
        code, remedy = _described(error)
    text = str(error) or type(error).__name__
    return dataset.failure_row(task, str(code), text, getattr(error, "place", None), remedy)


def _described(error: Exception) -> tuple[str, str]:
    if isinstance(error, FileNotFoundError):
        return "file-missing", "correct the path in the manifest, or put the file there"
    if isinstance(error, ConnectionError):
        return "file-unreachable", "check server and credentials, then run again with retry_failures=True"
    return "defect", "report it with the experiment and the log"


def died(part: Part, settings: Settings, reason: str) -> Done:
    """Writes the failure of a part with one task whose worker died again and again."""
    (task,) = part.tasks
    remedy = "look at the memory of the workers; identify this log alone"
    row = dataset.failure_row(task, "worker-died", f"the worker died while it identified this: {reason}", None, remedy)
    size = dataset.write_part(settings.out, part.name, dataset.table_of([row], settings.covariates))
    return Done(1, len(task.logs), 1, size)


def split(part: Part, make: Callable[[Sequence[Task]], Part]) -> list[Part]:
    """Divides a part into its tasks."""
    return [make([task]) for task in part.tasks]
