"""Fleets on other engines: one function per log, Arrow in and Arrow out, as Ray, Daft and Spark call their functions.

`missing_logs` gives the engine its rows, `identify_batch` is the function that it maps over them, and `write_rows`
writes the results. `sprung.fleet.identify` does the same three steps with Dask or with processes.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import dataset, files, resume, work
from .arrow import ArrowTable, arrow_table, pa, texts
from .errors import DatasetError, FleetError, ManifestError
from .manifest import REQUIRED, TIME, Digests, Manifest, Part, Task, checked_columns, key_of
from .run import Overrides, Summary, assignments, check

if TYPE_CHECKING:
    import pyarrow

PART = "part"
TASK = "task"


def missing_logs(
    manifest: str | os.PathLike[str] | ArrowTable,
    *,
    out: str | os.PathLike[str],
    overrides: Overrides = (),
    logs_per_part: int = 32,
    retry_failures: bool = False,
) -> pyarrow.Table:
    """Returns the logs of a manifest that a dataset does not have, for `identify_batch` on any engine.

    - manifest, out, overrides, logs_per_part, retry_failures: as in `identify`. The folder `out` is made if it does
      not exist.

    The table has the columns ``robot``, ``experiment``, ``log`` with whole paths, ``time``, the covariates, and
    ``part`` and ``task``, by which `write_rows` divides the results into files. It has no rows if nothing is missing.

    Raises ManifestError for a manifest that cannot be read or contradicts itself, DatasetError for an `out` that
    cannot be used.

    >>> import tempfile
    >>> from sprung import fleet
    >>> folder = tempfile.mkdtemp()
    >>> manifest = fleet.demo(folder, robots=2, logs=1)
    >>> todo = fleet.missing_logs(manifest, out=f"{folder}/results")
    >>> todo.column_names
    ['part', 'task', 'robot', 'experiment', 'log', 'time', 'temperature_c']
    >>> todo["robot"].to_pylist()
    ['robot0', 'robot1']
    """
    check(logs_per_part=logs_per_part)
    url, settings = str(out).rstrip("/"), assignments(overrides)
    loaded = Manifest.read(manifest)
    dataset.schema(loaded.covariates)
    if PART in loaded.covariates:
        raise ManifestError(
            f"the manifest {loaded.place} has a covariate {PART}, and other engines need this name",
            code="manifest-columns",
            place=loaded.place,
            remedy="rename the column",
        )
    dataset.prepare(url, {"overrides": list(settings)})
    parts = resume.missing(dataset.done(url), loaded.parts(settings, ["log"], logs_per_part), retry_failures)
    return _table(parts, loaded.covariates)


def identify_batch(
    batch: ArrowTable, *, overrides: Overrides = (), identify_one: work.Identify = work.identify
) -> pyarrow.Table:
    """Identifies each log of a batch and returns its rows of the dataset. A log that fails is a row with its message.

    - batch: rows of `missing_logs`, or of a manifest with whole paths: a table with the columns ``robot``,
      ``experiment``, ``log``, optionally ``time`` and numeric columns. Other columns are ignored.
    - overrides: settings of all experiments, the same as in `missing_logs`.
    - identify_one: how a log is identified, as in `identify`.

    The rows of a log follow each other, in the order of the logs, with the columns of `schema`. One thread does the
    work, because engines run many batches at a time.

    Raises ManifestError for a batch with wrong columns, and ImportError, MemoryError or OSError if this computer lacks
    a package, memory or space: the engine can then repeat the batch on another one.

    >>> import tempfile
    >>> from sprung import fleet
    >>> folder = tempfile.mkdtemp()
    >>> overrides = {"identify.estimator": "least-squares"}
    >>> todo = fleet.missing_logs(fleet.demo(folder, robots=1, logs=1), out=f"{folder}/results", overrides=overrides)
    >>> rows = fleet.identify_batch(todo, overrides=overrides)
    >>> sorted(set(rows["kind"].to_pylist()))
    ['finding', 'parameter']
    >>> rows.schema == fleet.schema(["temperature_c"])
    True
    """
    table = arrow_table(batch)
    columns, covariates = checked_columns(table, "of the batch")
    settings = work.Settings("", assignments(overrides), covariates, identify_one)
    given = table[TASK].to_pylist() if TASK in table.column_names else [None] * table.num_rows
    digests = Digests()
    tasks = [
        _task(row, key, covariates, settings.overrides, digests)
        for row, key in zip(columns.to_pylist(), given, strict=True)
    ]
    return work.identify_tasks(tasks, settings)


def write_rows(rows: Iterable[ArrowTable], todo: ArrowTable, *, out: str | os.PathLike[str]) -> Summary:
    """Writes the rows of `identify_batch` into a dataset. The files are those that `identify` writes, byte for byte.

    - rows: tables from the engine, in any order and of any size; the rows of one log need to follow each other.
    - todo: the table of `missing_logs` that the engine had.
    - out: folder or URL of the dataset, the same as in `missing_logs`.

    The rows of a part are written as soon as all of its logs are there, so that memory holds only the parts that have
    begun. Earlier rows of logs that failed or whose experiment changed are removed first.

    Raises DatasetError if `out` is no dataset, FleetError if rows are missing or belong to other logs, and OSError if
    a file cannot be written. What is written stays, and `missing_logs` finds the rest.

    >>> import tempfile
    >>> from sprung import fleet
    >>> folder = tempfile.mkdtemp()
    >>> overrides = {"identify.estimator": "least-squares"}
    >>> todo = fleet.missing_logs(fleet.demo(folder, robots=1, logs=2), out=f"{folder}/results", overrides=overrides)
    >>> rows = (fleet.identify_batch(batch, overrides=overrides) for batch in todo.to_batches(max_chunksize=1))
    >>> fleet.write_rows(rows, todo, out=f"{folder}/results").tasks
    2
    """
    url, plan = str(out).rstrip("/"), arrow_table(todo)
    absent = [name for name in (PART, TASK, "robot", "log") if name not in plan.column_names]
    if absent:
        raise FleetError(
            f"todo has no column {', '.join(absent)}; it has {', '.join(plan.column_names)}",
            code="rows-unknown",
            place=url,
            remedy="give the table of missing_logs",
        )
    if dataset.about_of(url) is None:
        raise dataset.no_dataset(url)
    known = dataset.done(url)
    logs = zip(texts(plan, "robot"), texts(plan, "log"), strict=True)
    resume.remove_replaced(url, known, [("log", robot, log) for robot, log in logs])
    covariates = [name for name in checked_columns(plan, "of todo")[1] if name not in (PART, TASK)]
    parts = _Parts(url, plan, dataset.schema(covariates))
    for table in rows:
        parts.add(arrow_table(table))
    return parts.finish()


class _Parts:
    """Rows of parts that have begun."""

    def __init__(self, out: str, todo: pyarrow.Table, schema: pyarrow.Schema) -> None:
        self.out = out
        self.schema = schema
        self.part_of = dict(zip(texts(todo, TASK), texts(todo, PART), strict=True))
        self.tasks: dict[str, list[str]] = {}
        for task, part in self.part_of.items():
            self.tasks.setdefault(part, []).append(task)
        self.rows: dict[str, list[Any]] = {}
        """Tables of each task whose part is not written."""
        self.ended: set[str] = set()
        self.current: str | None = None
        self.failed = self.bytes = 0

    def add(self, table: pyarrow.Table) -> None:
        """Takes rows. The rows of one task may go on in the next table."""
        table = self._cast(table)
        for start, end, task in _runs(texts(table, TASK)):
            if task != self.current:
                self._end()
                self._begin(task, table.slice(start, 1))
            # A slice would keep the whole table in memory.
            self.rows[task].append(table.take(pa.array(range(start, end))))

    def finish(self) -> Summary:
        """Ends the last task. Raises FleetError if rows of a task are missing."""
        self._end()
        missing = [task for task in self.part_of if task not in self.ended]
        if missing:
            raise FleetError(
                f"{len(missing)} of {len(self.part_of)} logs have no rows, for example the task {missing[0]}",
                code="rows-missing",
                place=self.out,
                remedy="call missing_logs again and give its logs to the engine",
            )
        files.remove_unfinished(self.out)
        return Summary(self.out, len(self.part_of), 0, self.failed, self.bytes, 0)

    def _cast(self, table: pyarrow.Table) -> pyarrow.Table:
        absent = [name for name in self.schema.names if name not in table.column_names]
        if absent:
            raise DatasetError(
                f"the rows have no column {', '.join(absent)}; they have {', '.join(table.column_names)}",
                code="rows-columns",
                place=self.out,
                remedy="give all columns that identify_batch returns",
            )
        return table.select(self.schema.names).cast(self.schema)

    def _begin(self, task: str, row: pyarrow.Table) -> None:
        (first,) = row.select(["robot", "log"]).to_pylist()
        place = f"robot {first['robot']}, log {first['log']}"
        if task not in self.part_of:
            raise FleetError(
                f"rows of {place} belong to no log of todo",
                code="rows-unknown",
                place=place,
                remedy="give identify_batch the same overrides as missing_logs; if an experiment file changed "
                "meanwhile, call missing_logs again",
            )
        if task in self.ended:
            raise FleetError(
                f"rows of {place} come twice, or with rows of other logs between them",
                code="rows-scattered",
                place=place,
                remedy="keep the rows of a batch together and in their order: do not sort or shuffle them",
            )
        self.current = task
        self.rows[task] = []

    def _end(self) -> None:
        """Ends the current task, and writes its part if all others of it have ended."""
        if self.current is None:
            return
        self.ended.add(self.current)
        part, self.current = self.part_of[self.current], None
        tasks = self.tasks[part]
        if not self.ended.issuperset(tasks):
            return
        table = pa.concat_tables([table for task in tasks for table in self.rows.pop(task)])
        self.failed += dataset.failed_tasks(table)
        self.bytes += dataset.write_part(self.out, part, table)


def _runs(values: Sequence[str]) -> Iterator[tuple[int, int, str]]:
    """Yields start, end and value of equal values that follow each other."""
    start = 0
    for end in range(1, len(values) + 1):
        if end == len(values) or values[end] != values[start]:
            yield start, end, values[start]
            start = end


def _table(parts: Sequence[Part], covariates: Sequence[str]) -> pyarrow.Table:
    """Returns the tasks of parts, one log each, as rows of a manifest."""
    kinds = [(name, pa.string()) for name in (PART, TASK, *REQUIRED)]
    kinds += [(TIME, pa.timestamp("us", tz="UTC")), *((name, pa.float64()) for name in covariates)]
    rows = [
        {PART: part.name, TASK: task.key, "robot": task.robot, "experiment": task.experiment, "log": task.logs[0]}
        | {TIME: task.time}
        | dict(task.covariates)
        for part in parts
        for task in part.tasks
    ]
    table: pyarrow.Table = pa.Table.from_pylist(rows, schema=pa.schema(kinds))
    return table


def _task(
    row: dict[str, Any], given: str | None, covariates: Sequence[str], settings: Sequence[str], digests: Digests
) -> Task:
    base = str(Path.cwd())
    experiment, log = files.resolve(row["experiment"], base), files.resolve(row["log"], base)

    def key(digest: str) -> str:
        return key_of("log", row["robot"], experiment, digest, [log], settings)

    digest = digests.of(experiment)
    # An experiment file that only the caller, or only this computer, can read has no digest on the other side.
    unknown = digest == "" or given == key("")
    values = tuple((name, row[name]) for name in covariates)
    return Task(given if given and unknown else key(digest), "log", row["robot"], experiment, (log,), row[TIME], values)
