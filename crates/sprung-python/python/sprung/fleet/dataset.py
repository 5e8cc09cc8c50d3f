"""The dataset of a fleet: Parquet files, one per part, that any program reads together.

Each row is a parameter of one log (``kind = 'parameter'``), a finding or a failure. A part is one file, and a file
appears only when it is complete; so all files are valid, and a run resumes with the missing tasks.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import files
from .arrow import pa, pc, pq, texts
from .errors import DatasetError
from .manifest import Task

if TYPE_CHECKING:
    import pyarrow

FORMAT = 1
"""Version of the columns. A reader refuses newer ones."""
ABOUT = "_sprung_fleet.json"
"""Format and settings of a dataset, beside its parts."""
_FORMAT_KEY = b"sprung_fleet_format"
_READERS = 8

_COLUMNS: tuple[tuple[str, Any], ...] = (
    ("kind", pa.string()),  # parameter, finding, failure
    ("task", pa.string()),
    ("level", pa.string()),  # log, robot
    ("robot", pa.string()),
    ("log", pa.string()),  # null for all logs of the robot
    ("experiment", pa.string()),
    ("time", pa.timestamp("us", tz="UTC")),
    ("samples", pa.int64()),
    ("duration_s", pa.float64()),
    ("estimator", pa.string()),
    ("verdict", pa.string()),
    ("parameter", pa.string()),
    ("unit", pa.string()),  # of value, standard_error, ci95_low, ci95_high, nominal
    ("value", pa.float64()),
    ("standard_error", pa.float64()),
    ("ci95_low", pa.float64()),
    ("ci95_high", pa.float64()),
    ("nominal", pa.float64()),
    ("identifiable", pa.bool_()),
    ("code", pa.string()),
    ("severity", pa.string()),
    ("parameters", pa.list_(pa.string())),
    ("text", pa.string()),
    ("place", pa.string()),
    ("remedy", pa.string()),
)
COLUMNS = tuple(name for name, _ in _COLUMNS)
"""Columns of every dataset; numeric columns of the manifest follow them."""

Row = dict[str, Any]


def schema(covariates: Sequence[str] = ()) -> pyarrow.Schema:
    """Returns the Arrow schema of the rows of a dataset.

    - covariates: names of the numeric columns of the manifest.

    Raises DatasetError if a covariate has the name of another column.

    >>> from sprung import fleet
    >>> fleet.schema(["temperature_c"]).names[-3:]
    ['place', 'remedy', 'temperature_c']
    """
    for name in covariates:
        if name in COLUMNS:
            raise DatasetError(
                f"column {name} of the manifest has the name of a column of the dataset",
                code="manifest-columns",
                place=name,
                remedy="rename it in the manifest",
            )
    fields = [pa.field(name, kind) for name, kind in _COLUMNS]
    fields += [pa.field(name, pa.float64()) for name in covariates]
    made: pyarrow.Schema = pa.schema(fields, metadata={_FORMAT_KEY: str(FORMAT).encode()})
    return made


def rows_of(task: Task, text: str) -> list[Row]:
    """Returns the rows of an identification, the text of identification.json."""
    identification = json.loads(text)
    base = _base(task)
    log = identification.get("log") or {}
    base |= {"samples": log.get("samples"), "duration_s": log.get("duration_s")}
    rows = [base | _finding(finding) for finding in identification.get("findings", [])]
    for result in identification["results"]:
        common = base | {"estimator": result["estimator"], "verdict": result.get("verdict")}
        for parameter in result["parameters"]:
            low, high = parameter.get("ci95") or (None, None)
            rows.append(
                common
                | {"kind": "parameter", "parameter": parameter["name"], "ci95_low": low, "ci95_high": high}
                | {name: parameter.get(name) for name in ("unit", "value", "standard_error", "nominal", "identifiable")}
            )
        rows += [common | _finding(finding) for finding in result.get("warnings", [])]
    if not any(row["kind"] == "parameter" for row in rows):
        rows.append(
            base
            | {
                "kind": "failure",
                "code": "no-parameters",
                "text": "the identification has no parameters",
                "remedy": "look at the findings of this log",
            }
        )
    return rows


def failure_row(task: Task, code: str, text: str, place: str | None, remedy: str | None) -> Row:
    """Returns the row of a log that failed."""
    return _base(task) | {"kind": "failure", "code": code, "text": text, "place": place, "remedy": remedy}


def _base(task: Task) -> Row:
    return {
        "task": task.key,
        "level": task.level,
        "robot": task.robot,
        "log": task.logs[0] if task.level == "log" else None,
        "experiment": task.experiment,
        "time": task.time,
        **dict(task.covariates),
    }


def _finding(finding: Mapping[str, Any]) -> Row:
    names = ("code", "severity", "parameters", "text", "remedy")
    return {"kind": "finding"} | {name: finding.get(name) for name in names}


def table_of(rows: Sequence[Row], covariates: Sequence[str]) -> pyarrow.Table:
    """Returns rows as a table with the schema of the dataset."""
    table: pyarrow.Table = pa.Table.from_pylist(list(rows), schema=schema(covariates))
    return table


def failed_tasks(rows: pyarrow.Table) -> int:
    """Returns the number of tasks that have a failure among rows."""
    return len(pc.unique(rows.filter(pc.equal(rows["kind"], "failure"))["task"]))


def write_part(out: str, name: str, rows: pyarrow.Table) -> int:
    """Writes the file of a part and returns its size in bytes. The same rows give the same bytes.

    - rows: a table with the schema of the dataset.

    Raises OSError if it cannot be written; the dataset is then as it was before.
    """
    return _write_table(f"{out.rstrip('/')}/{name}.parquet", rows)


def _write_table(url: str, table: Any) -> int:
    buffer = io.BytesIO()
    # Chunks would change the pages of the file.
    pq.write_table(table.combine_chunks(), buffer, compression="zstd")
    content = buffer.getvalue()
    files.write(url, content)
    return len(content)


def prepare(out: str, settings: Mapping[str, Any]) -> None:
    """Makes the folder of a dataset, or checks that an existing one has the same format and settings.

    Raises DatasetError if it has not, or if the folder cannot be written.
    """
    url = f"{out.rstrip('/')}/{ABOUT}"
    about = about_of(out)
    if about is not None:
        if about["settings"] != dict(settings):
            raise DatasetError(
                f"the dataset {out} was made with the settings {json.dumps(about['settings'])}, "
                f"and this run has {json.dumps(dict(settings))}",
                code="dataset-settings",
                place=url,
                remedy="use another folder for these settings",
            )
        return
    try:
        files.write(url, json.dumps({"format": FORMAT, "settings": dict(settings)}, indent=2).encode())
    except Exception as error:
        raise _unreachable(out, "written", error) from error


def about_of(out: str) -> dict[str, Any] | None:
    """Returns format and settings of a dataset; None if there is none.

    Raises DatasetError if a newer version wrote it or if it cannot be read.
    """
    url = f"{out.rstrip('/')}/{ABOUT}"
    try:
        about = json.loads(files.read(url))
        written = int(about["format"])
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError) as error:
        raise DatasetError(
            f"{url} is not that of a dataset: {error}",
            code="dataset-damaged",
            place=url,
            remedy="use an empty folder, or write the file again from another dataset with the same settings",
        ) from error
    except Exception as error:
        raise _unreachable(out, "read", error) from error
    _refuse_other_format(written, url)
    return dict(about)


def _refuse_other_format(written: int, place: str) -> None:
    if written == FORMAT:
        return
    newer = written > FORMAT
    raise DatasetError(
        f"{place} has format {written}, and this version of sprung knows format {FORMAT} only",
        code="dataset-newer" if newer else "dataset-format",
        place=place,
        remedy="install the version of sprung that wrote it, or a newer one: pip install --upgrade sprung"
        if newer
        else "identify the logs again into another folder",
    )


def _refuse_other_columns(found: pyarrow.Schema, url: str) -> None:
    """Refuses a part that lacks a column, or has one of another type; all other columns are covariates."""
    covariates = [name for name in found.names if name not in COLUMNS]
    wrong = []
    for field in schema(covariates):
        if field.name not in found.names:
            wrong.append(f"no column {field.name}")
        elif found.field(field.name).type != field.type:
            wrong.append(f"{field.name} of type {found.field(field.name).type} instead of {field.type}")
    if wrong:
        raise DatasetError(
            f"{url} has other columns than a part of a dataset: {', '.join(wrong)}",
            code="dataset-columns",
            place=url,
            remedy="remove this file and run identify again: it computes the missing part",
        )


def _unreachable(out: str, what: str, error: Exception) -> DatasetError:
    return DatasetError(
        f"the dataset {out} cannot be {what}: {type(error).__name__}: {error}",
        code="dataset-unreachable",
        place=out,
        remedy="check the path or URL, its server, its credentials and the free space",
    )


@dataclass(frozen=True)
class Dataset:
    """A dataset in memory.

    >>> import tempfile
    >>> import pyarrow
    >>> from sprung import fleet
    >>> names = ["robot", "experiment", "log", "temperature_c"]
    >>> manifest = pyarrow.table([["A-1"], ["arm.toml"], ["lost.csv"], [21.5]], names=names)
    >>> out = tempfile.mkdtemp()
    >>> todo = fleet.missing_logs(manifest, out=out)
    >>> summary = fleet.write_rows([fleet.identify_batch(todo)], todo, out=out)
    >>> dataset = fleet.Dataset.read(out)
    >>> dataset.covariates
    ['temperature_c']
    >>> dataset.rows("failure").select(["robot", "code"]).to_pylist()
    [{'robot': 'A-1', 'code': 'file-missing'}]
    """

    url: str
    table: pyarrow.Table
    """All rows, with the columns ``COLUMNS`` and the covariates of the manifest."""

    @classmethod
    def read(cls, url: str | os.PathLike[str], columns: Sequence[str] | None = None) -> Dataset:
        """Reads all parts of a dataset, or some columns of them.

        Raises DatasetError if there is no dataset, if it cannot be read or if a newer version wrote it.
        """
        parts = [table for _, table in tables(str(url), None if columns is None else columns.__contains__)]
        if not parts:
            raise no_dataset(str(url))
        return cls(str(url), pa.concat_tables(parts, promote_options="default"))

    @property
    def covariates(self) -> list[str]:
        """Names of the numeric columns of the manifest."""
        return [name for name in self.table.column_names if name not in COLUMNS]

    def rows(self, kind: str) -> pyarrow.Table:
        """Returns the rows of one kind (``parameter``, ``finding``, ``failure``), a pyarrow.Table.

        They are in the order of robot, level, log, estimator, parameter and code.
        """
        chosen = self.table.filter(pc.equal(self.table["kind"], kind))
        keys = ("robot", "level", "log", "estimator", "parameter", "code")
        return chosen.sort_by([(key, "ascending") for key in keys])


def no_dataset(url: str) -> DatasetError:
    """The error of a folder without parts."""
    return DatasetError(
        f"{url} has no dataset",
        code="dataset-missing",
        place=url,
        remedy="give the folder that sprung.fleet.identify wrote",
    )


def _parts(out: str) -> list[str]:
    """Returns the URLs of all parts, sorted."""
    try:
        system, path = files.filesystem(out)
        system.invalidate_cache()
        names = [entry.rsplit("/", 1)[-1] for entry in system.ls(path, detail=False)]
    except FileNotFoundError:
        return []
    except Exception as error:
        raise _unreachable(out, "read", error) from error
    return [f"{out.rstrip('/')}/{name}" for name in sorted(names) if name.endswith(".parquet") and name[0] not in "._"]


def tables(out: str, wanted: Callable[[str], bool] | None = None) -> Iterator[tuple[str, pyarrow.Table]]:
    """Yields URL and rows of each part, sorted by URL.

    - wanted: whether a column is read; all are if it is not given.

    Raises DatasetError if the dataset or a part cannot be read, or if another format or program wrote it.
    """
    about_of(out)

    def read(url: str) -> tuple[str, pyarrow.Table]:
        try:
            table = pq.ParquetFile(io.BytesIO(files.read(url)))
            written = int((table.schema_arrow.metadata or {}).get(_FORMAT_KEY, b"0"))
        except (pa.ArrowException, OSError, ValueError) as error:
            raise DatasetError(
                f"{url} cannot be read: {error}",
                code="dataset-damaged",
                place=url,
                remedy="remove this file and run identify again: it computes the missing part",
            ) from error
        if written == 0:
            raise DatasetError(
                f"{url} is not a part of a dataset of sprung",
                code="dataset-foreign",
                place=url,
                remedy="move it to another folder",
            )
        _refuse_other_format(written, url)
        _refuse_other_columns(table.schema_arrow, url)
        names = table.schema_arrow.names
        return url, table.read(columns=names if wanted is None else [name for name in names if wanted(name)])

    parts = _parts(out)
    with ThreadPoolExecutor(_READERS) as pool:
        for start in range(0, len(parts), 8 * _READERS):
            yield from pool.map(read, parts[start : start + 8 * _READERS])


def done(out: str) -> dict[str, tuple[tuple[str, str, str], bool]]:
    """Returns the tasks of a dataset by their key: identity, and whether the task failed."""
    found: dict[str, tuple[tuple[str, str, str], bool]] = {}
    for _, table in tables(out, {"kind", "task", "level", "robot", "log", "experiment"}.__contains__):
        for row in table.group_by(table.column_names).aggregate([]).to_pylist():
            identity = (row["level"], row["robot"], row["log"] if row["level"] == "log" else row["experiment"])
            failed = row["kind"] == "failure" or found.get(row["task"], (identity, False))[1]
            found[row["task"]] = (identity, failed)
    return found


def remove(out: str, unwanted: Callable[[str], bool]) -> None:
    """Removes the rows of tasks, whose keys `unwanted` selects, each part at once."""
    for url, table in tables(out):
        tasks = texts(table, "task")
        keep = pa.array([not unwanted(key) for key in tasks])
        if pc.all(keep).as_py():
            continue
        left = table.filter(keep)
        if left.num_rows == 0:
            files.remove(url)
        else:
            _write_table(url, left)
