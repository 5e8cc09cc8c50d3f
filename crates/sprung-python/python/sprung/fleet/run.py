"""Identifies all logs of a manifest."""

# mypy: disable-error-code="import-untyped, import-not-found, unused-ignore"

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from . import dataset, files, resume, work
from .arrow import ArrowTable
from .engines import Dask, Engine, Processes, WorkerDied
from .errors import FleetError
from .manifest import Manifest, Part, part
from .work import Done, Settings

if TYPE_CHECKING:
    from distributed import Client

ATTEMPTS = 4
"""How often a part is computed whose file cannot be written."""
DEATHS = 8
"""How many workers may die with a part before its logs are computed one by one, and with one log before it fails."""
LEVELS = ("log", "robot")

Progress = Callable[[int, int], object]
Value: TypeAlias = "str | bool | int | float | Sequence[Value]"
Overrides: TypeAlias = "Mapping[str, Value] | Sequence[str]"
"""Settings of all experiments: ``{"identify.estimator": "least-squares"}`` or ``["identify.estimator=least-squares"]``."""


@dataclass(frozen=True)
class Summary:
    """What a run did.

    >>> import tempfile
    >>> import pyarrow
    >>> from sprung import fleet
    >>> manifest = pyarrow.table({"robot": ["A-1"], "experiment": ["arm.toml"], "log": ["lost.csv"]})
    >>> out = tempfile.mkdtemp()
    >>> todo = fleet.missing_logs(manifest, out=out)
    >>> summary = fleet.write_rows([fleet.identify_batch(todo)], todo, out=out)
    >>> summary.tasks, summary.failed
    (1, 1)
    """

    out: str
    tasks: int
    """Tasks of the manifest: logs alone, and robots with all their logs."""
    resumed: int
    """Tasks that the dataset had already."""
    failed: int
    """Tasks of this run whose rows are failures; ``Dataset.rows("failure")`` has their messages."""
    bytes: int
    """Written by this run."""
    repeated: int
    """Parts that were computed again, because a worker died or a file could not be written."""


def identify(
    manifest: str | os.PathLike[str] | ArrowTable,
    *,
    out: str | os.PathLike[str],
    client: Client | None = None,
    overrides: Overrides = (),
    levels: Sequence[str] = ("log",),
    workers: int | None = None,
    logs_per_part: int = 32,
    in_flight: int | None = None,
    retry_failures: bool = False,
    progress: Progress | bool = True,
    identify_one: work.Identify = work.identify,
) -> Summary:
    """Identifies every log of a manifest and writes a dataset. A log that fails is a row, not an exception.

    - manifest: path or URL of a CSV or Parquet file, or a table of pyarrow, pandas or polars, with the columns
      ``robot``, ``experiment``, ``log``. Optional are ``time`` and numeric columns, for example ``temperature_c``.
      Paths are relative to the folder of the file, and may be any fsspec URL.
    - out: folder or URL of the dataset. A run resumes: it computes only tasks that the dataset does not have.
    - client: ``distributed.Client`` of a cluster; without it, processes of this computer work.
    - overrides: settings of all experiments, as in ``--set`` of the command line, for example
      ``{"identify.estimator": "least-squares"}``.
    - levels: ``"log"`` identifies each log alone, ``"robot"`` all logs of a robot together, in one task.
    - workers: number of processes; as many as processors if it is not given. Not used with a client.
    - logs_per_part: logs that one task of the engine identifies and writes into one file.
    - in_flight: parts that the engine has at a time; it bounds the memory of the caller.
    - retry_failures: whether logs that failed earlier are identified again.
    - progress: called with the finished and the total number of logs; ``True`` draws a bar if tqdm is installed.
    - identify_one: how a worker identifies: a function of the paths of experiment and logs and of the settings, which
      returns the text of identification.json.

    A script that uses processes needs ``if __name__ == "__main__":``, because they import it.

    Raises ManifestError for a manifest that cannot be read or contradicts itself, DatasetError for an `out` that
    cannot be used, and FleetError if parts could not be written; all other parts are written then.

    >>> import tempfile
    >>> import pyarrow
    >>> from sprung import fleet
    >>> manifest = pyarrow.table({"robot": ["A-1"], "experiment": ["arm.toml"], "log": ["lost.csv"]})
    >>> summary = fleet.identify(manifest, out=tempfile.mkdtemp(), workers=1, progress=False)
    >>> fleet.Dataset.read(summary.out).rows("failure")["code"].to_pylist()
    ['file-missing']
    """
    check(levels, workers=workers, logs_per_part=logs_per_part, in_flight=in_flight)
    table = Manifest.read(manifest)
    settings = Settings(str(out).rstrip("/"), assignments(overrides), table.covariates, identify_one)
    dataset.schema(table.covariates)
    dataset.prepare(settings.out, {"overrides": list(settings.overrides)})
    engine: Engine = Dask(client, in_flight) if client is not None else Processes(workers, in_flight)
    run = _Run(settings, engine)
    todo = run.missing(list(table.parts(settings.overrides, levels, logs_per_part)), retry_failures)
    with _Bar(progress, run.logs, run.logs_done) as bar:
        run.work(iter(todo), bar)
    files.remove_unfinished(settings.out)
    return run.summary()


def assignments(overrides: Overrides) -> tuple[str, ...]:
    """Returns overrides as texts ``key=value``. Raises ValueError for a text instead of a list."""
    if isinstance(overrides, str):
        raise ValueError('overrides is a text; write ["key=value"] or {"key": value}')
    if isinstance(overrides, Mapping):
        return tuple(f"{key}={_value(value)}" for key, value in sorted(overrides.items()))
    return tuple(overrides)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(f'"{one}"' if isinstance(one, str) else _value(one) for one in value) + "]"
    return str(value)


def check(levels: Sequence[str] = LEVELS, **counts: int | None) -> None:
    """Raises ValueError for an unknown level or a count below 1."""
    unknown = [level for level in levels if level not in LEVELS]
    if unknown or not levels or isinstance(levels, str):
        raise ValueError(f"levels is {levels!r}; it needs to be a list of 'log' and 'robot'")
    for name, count in counts.items():
        if count is not None and count < 1:
            raise ValueError(f"{name} is {count}; it needs to be at least 1")


class _Run:
    """The state of one run: parts to compute, attempts, counts."""

    def __init__(self, settings: Settings, engine: Engine) -> None:
        self.settings = settings
        self.engine = engine
        self.deaths: Counter[str] = Counter()
        self.errors: Counter[str] = Counter()
        self.unwritten: list[tuple[Part, BaseException]] = []
        self.tasks = self.resumed = self.failed = self.bytes = self.repeated = 0
        self.logs = self.logs_done = 0

    def missing(self, parts: list[Part], retry_failures: bool) -> list[Part]:
        """Returns the parts that the dataset does not have, and removes rows that this run replaces."""
        known = dataset.done(self.settings.out)
        left = resume.missing(known, parts, retry_failures)
        tasks = [task for one in left for task in one.tasks]
        resume.remove_replaced(self.settings.out, known, [task.identity for task in tasks])
        self.tasks = sum(len(one.tasks) for one in parts)
        self.resumed = self.tasks - len(tasks)
        self.logs = sum(len(task.logs) for one in parts for task in one.tasks)
        self.logs_done = self.logs - sum(len(task.logs) for task in tasks)
        return left

    def work(self, parts: Iterator[Part], bar: _Bar) -> None:
        for one, outcome in self.engine.run(work.run_part, self.settings, parts):
            if isinstance(outcome, Done):
                self._count(outcome, bar)
            elif isinstance(outcome, WorkerDied):
                self._died(one, outcome, bar)
            else:
                self._not_written(one, outcome)
        if self.unwritten:
            one, error = self.unwritten[0]
            raise FleetError(
                f"{len(self.unwritten)} parts could not be written, for example {one.name}: "
                f"{type(error).__name__}: {error}",
                code="parts-missing",
                place=self.settings.out,
                remedy="remove the cause, for example a full disk, and call identify again: it resumes",
            ) from error

    def _count(self, done: Done, bar: _Bar) -> None:
        self.failed += done.failed
        self.bytes += done.bytes
        self.logs_done += done.logs
        bar.update(self.logs_done)

    def _died(self, one: Part, error: WorkerDied, bar: _Bar) -> None:
        self.deaths[one.name] += 1
        if self.deaths[one.name] < DEATHS:
            self.repeated += 1
            self.engine.again(one)
        elif len(one.tasks) > 1:
            for single in work.split(one, part):
                self.engine.again(single)
        else:
            self._count(work.died(one, self.settings, str(error)), bar)

    def _not_written(self, one: Part, error: BaseException) -> None:
        self.errors[one.name] += 1
        # A worker without sprung fails with every part, so repeating is useless.
        if isinstance(error, ImportError) and self.logs_done == 0:
            raise FleetError(
                f"a worker cannot import what it needs: {error}",
                code="worker-import",
                remedy="install the same versions on all workers: pip install 'sprung[fleet]'",
            ) from error
        if self.errors[one.name] < ATTEMPTS:
            self.repeated += 1
            self.engine.again(one)
        else:
            self.unwritten.append((one, error))

    def summary(self) -> Summary:
        return Summary(self.settings.out, self.tasks, self.resumed, self.failed, self.bytes, self.repeated)


class _Bar:
    """Tells a callback, or draws a bar if tqdm is installed."""

    def __init__(self, progress: Progress | bool, total: int, done: int) -> None:
        self.total = total
        self.callback = progress if callable(progress) else None
        self.bar: Any = None
        if progress is True:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                return
            self.bar = tqdm(total=total, initial=done, unit="log")

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()

    def update(self, done: int) -> None:
        if self.callback is not None:
            self.callback(done, self.total)
        if self.bar is not None:
            self.bar.update(done - self.bar.n)
