"""The manifest of a fleet: which log belongs to which robot and experiment."""

from __future__ import annotations

import datetime
import hashlib
import io
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import files
from .arrow import ArrowTable, arrow_table, csv, pa, pc, pq
from .errors import ManifestError

if TYPE_CHECKING:
    import pyarrow

REQUIRED = ("robot", "experiment", "log")
TIME = "time"
"""Optional column: the time of the log, a timestamp or text by ISO 8601; UTC if it names no zone."""


@dataclass(frozen=True)
class Task:
    """One identification: a log alone, or all logs of a robot together."""

    key: str
    """Digest of robot, logs, experiment with its contents, and settings."""
    level: str
    """``log`` or ``robot``."""
    robot: str
    experiment: str
    logs: tuple[str, ...]
    time: datetime.datetime | None
    covariates: tuple[tuple[str, float | None], ...]

    @property
    def identity(self) -> tuple[str, str, str]:
        """Level, robot, and log or experiment: a dataset has one result of each."""
        return self.level, self.robot, self.logs[0] if self.level == "log" else self.experiment


@dataclass(frozen=True)
class Part:
    """The tasks that one worker computes and writes together."""

    name: str
    tasks: tuple[Task, ...]


class Manifest:
    """A checked manifest. Its memory is that of the table."""

    def __init__(self, table: Any, base: str, place: str) -> None:
        self.place = place
        self.base = base
        checked, self.covariates = checked_columns(table, place)
        if table.num_rows == 0:
            raise _empty(place)
        self.table = checked.sort_by([("robot", "ascending"), (TIME, "ascending"), ("log", "ascending")])
        self._refuse_duplicates()
        self._digests = Digests()

    @classmethod
    def read(cls, source: str | os.PathLike[str] | ArrowTable) -> Manifest:
        """Reads a manifest: a path or URL of a CSV or Parquet file, or a table of pyarrow, pandas or polars.

        Raises ManifestError if it cannot be read, a column is absent or empty, or a key occurs twice.
        """
        if not isinstance(source, str | os.PathLike):
            return cls(arrow_table(source), str(Path.cwd()), "table")
        url = str(source)
        try:
            content = files.read(url)
        except Exception as error:
            raise ManifestError(
                f"the manifest {url} cannot be read: {type(error).__name__}: {error}",
                code="manifest-unreadable",
                place=url,
                remedy="check the path or URL, its server and its credentials",
            ) from error
        if not content.strip():
            raise _empty(url)
        try:
            if content[:4] == b"PAR1":
                table = pq.read_table(io.BytesIO(content))
            else:
                texts = csv.ConvertOptions(column_types=dict.fromkeys(REQUIRED, pa.string()))
                table = csv.read_csv(io.BytesIO(content), convert_options=texts)
        except pa.ArrowException as error:
            raise ManifestError(
                f"the manifest {url} is neither Parquet nor CSV: {error}",
                code="manifest-unreadable",
                place=url,
                remedy="write it as Parquet, or as CSV with one header line",
            ) from error
        return cls(table, files.parent(url), url)

    def parts(self, settings: Sequence[str], levels: Sequence[str], logs_per_part: int) -> Iterator[Part]:
        """Divides the tasks into parts. The division depends only on the manifest and the arguments."""
        batch: list[Task] = []
        count = 0
        for group in self._robots():
            tasks: list[Task] = []
            if "log" in levels:
                tasks += [self._task("log", [row], settings) for row in group]
            if "robot" in levels:
                tasks += [
                    self._task("robot", [row for row in group if row["experiment"] == experiment], settings)
                    for experiment in sorted({row["experiment"] for row in group})
                ]
            for task in tasks:
                if batch and count + len(task.logs) > logs_per_part:
                    yield part(batch)
                    batch, count = [], 0
                batch.append(task)
                count += len(task.logs)
        if batch:
            yield part(batch)

    def _robots(self) -> Iterator[list[dict[str, Any]]]:
        """The rows of one robot after the other."""
        group: list[dict[str, Any]] = []
        for batch in self.table.to_batches(max_chunksize=4096):
            for row in batch.to_pylist():
                if group and row["robot"] != group[0]["robot"]:
                    yield group
                    group = []
                group.append(row)
        yield group

    def _task(self, level: str, rows: list[dict[str, Any]], settings: Sequence[str]) -> Task:
        first = rows[0]
        experiment = files.resolve(first["experiment"], self.base)
        logs = tuple(files.resolve(row["log"], self.base) for row in rows)
        key = key_of(level, first["robot"], experiment, self._digests.of(experiment), logs, settings)
        alone = level == "log"
        covariates = tuple((name, first[name] if alone else None) for name in self.covariates)
        return Task(key, level, first["robot"], experiment, logs, first[TIME] if alone else None, covariates)

    def _refuse_duplicates(self) -> None:
        counts = self.table.group_by(["robot", "log"]).aggregate([([], "count_all")])
        double = counts.filter(pc.greater(counts["count_all"], 1))
        if double.num_rows == 0:
            return
        robot, log = double["robot"][0].as_py(), double["log"][0].as_py()
        raise ManifestError(
            f"the manifest {self.place} names {double.num_rows} logs more than once, for example robot {robot}, log {log}",
            code="manifest-duplicates",
            place=f"{self.place}, robot {robot}, log {log}",
            remedy="keep one row for each robot and log",
        )


class Digests:
    """Digests of experiment files, each of which is read once."""

    def __init__(self) -> None:
        self._known: dict[str, str] = {}

    def of(self, experiment: str) -> str:
        """The digest of an experiment file; empty if it cannot be read, which its logs then report as failures."""
        if experiment not in self._known:
            try:
                self._known[experiment] = hashlib.sha256(files.read(experiment_file(experiment))).hexdigest()
            except Exception:
                self._known[experiment] = ""
        return self._known[experiment]


def key_of(
    level: str, robot: str, experiment: str, digest: str, logs: Sequence[str], settings: Sequence[str]
) -> str:
    """Returns the key of a task.

    - digest: that of the contents of the experiment file.
    """
    content = [level, robot, experiment, digest, list(logs), list(settings)]
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:20]


def checked_columns(table: pyarrow.Table, place: str) -> tuple[pyarrow.Table, tuple[str, ...]]:
    """Returns the columns of a manifest with the types of the dataset, and the names of the covariates.

    - place: the name of the manifest in messages.

    Raises ManifestError if a column is absent, has an empty cell, or has values that are no texts or times.
    """
    missing = [name for name in REQUIRED if name not in table.column_names]
    if missing:
        raise ManifestError(
            f"the manifest {place} has no column {', '.join(missing)}; it has {', '.join(table.column_names)}",
            code="manifest-columns",
            place=place,
            remedy="name the columns robot, experiment and log",
        )
    covariates = tuple(
        field.name for field in table.schema if field.name not in (*REQUIRED, TIME) and _is_number(field.type)
    )
    columns = {name: _texts(table, name, place) for name in REQUIRED}
    columns[TIME] = _times(table, place)
    for name in covariates:
        columns[name] = pc.cast(table[name].combine_chunks(), pa.float64())
    return pa.table(columns), covariates


def _texts(table: Any, name: str, place: str) -> Any:
    column = table[name].combine_chunks()
    if pa.types.is_integer(column.type):
        column = pc.cast(column, pa.string())
    try:
        column = pc.utf8_trim_whitespace(pc.cast(column, pa.string()))
    except pa.ArrowException as error:
        raise _bad_column(place, name, f"is of type {column.type}", "write texts") from error
    empty = pc.fill_null(pc.equal(column, ""), True)
    if pc.any(empty).as_py():
        row = pc.index(empty, True).as_py()
        raise _bad_column(place, name, f"is empty in row {row + 1}", "fill it in, or leave the row out")
    return column


def _times(table: Any, place: str) -> Any:
    kind = pa.timestamp("us", tz="UTC")
    if TIME not in table.column_names:
        return pa.nulls(table.num_rows, kind)
    column = table[TIME].combine_chunks()
    try:
        if pa.types.is_null(column.type):
            return pa.nulls(table.num_rows, kind)
        if str(column.type) in ("string", "large_string", "string_view"):
            texts = column.to_pylist()
            return pa.array([None if text is None else _utc(text) for text in texts], kind)
        if pa.types.is_timestamp(column.type) or pa.types.is_date(column.type):
            return pc.cast(pc.cast(column, pa.timestamp("us", tz=getattr(column.type, "tz", None))), kind, safe=False)
    except (ValueError, pa.ArrowException) as error:
        raise _bad_column(place, TIME, f"has a value that is no time: {error}", "write 2026-03-01T12:00:00Z") from error
    raise _bad_column(
        place, TIME, f"is of type {column.type}", "write timestamps, or text such as 2026-03-01T12:00:00Z"
    )


def _bad_column(place: str, name: str, what: str, remedy: str) -> ManifestError:
    text = f"column {name} of the manifest {place} {what}"
    return ManifestError(text, code="manifest-value", place=f"{place}, column {name}", remedy=remedy)


def _empty(place: str) -> ManifestError:
    return ManifestError(
        f"the manifest {place} has no rows", code="manifest-empty", place=place, remedy="add a row for each log"
    )


def part(tasks: Sequence[Task]) -> Part:
    """Makes a part; its name follows from its tasks."""
    digest = hashlib.sha256("".join(task.key for task in tasks).encode()).hexdigest()[:20]
    return Part(f"part-{digest}", tuple(tasks))


def experiment_file(experiment: str) -> str:
    """The file of an experiment that is given as a file or as the folder of experiment.toml."""
    return experiment if experiment.endswith(".toml") else f"{experiment.rstrip('/')}/experiment.toml"


def _is_number(kind: Any) -> bool:
    return bool(pa.types.is_floating(kind) or pa.types.is_integer(kind))


def _utc(text: str) -> datetime.datetime:
    # Python 3.10 does not read the letter Z.
    time = datetime.datetime.fromisoformat(text.strip().replace("Z", "+00:00"))
    return time if time.tzinfo else time.replace(tzinfo=datetime.timezone.utc)
