"""The dataset of a fleet: Parquet files, one per part, that any program reads together.

Each row is a parameter of one log (``kind = 'parameter'``), a finding or a failure. A part is one file, and a file
appears only when it is complete; so whatever is there is valid, and a run resumes with the tasks that are missing.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from . import files
from .arrow import pa, pc, pq
from .errors import DatasetError
from .manifest import Task

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


def schema(covariates: Sequence[str]) -> Any:
    """Returns the Arrow schema of a part.

    Raises DatasetError if a covariate has the name of another column.
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
    return pa.schema(fields, metadata={_FORMAT_KEY: str(FORMAT).encode()})


def rows_of(task: Task, identification: Mapping[str, Any]) -> list[Row]:
    """Returns the rows of an identification, the contents of identification.json."""
    base = _base(task)
    log = identification.get("log") or {}
    base |= {"samples": log.get("samples"), "duration_s": log.get("duration_s")}
    rows = [base | _finding(finding) for finding in identification.get("findings", [])]
    for result in identification["results"]:
        own = base | {"estimator": result["estimator"], "verdict": result.get("verdict")}
        for parameter in result["parameters"]:
            low, high = parameter.get("ci95") or (None, None)
            rows.append(
                own
                | {"kind": "parameter", "parameter": parameter["name"], "ci95_low": low, "ci95_high": high}
                | {name: parameter.get(name) for name in ("unit", "value", "standard_error", "nominal", "identifiable")}
            )
        rows += [own | _finding(finding) for finding in result.get("warnings", [])]
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


def write_part(out: str, name: str, rows: Sequence[Row], covariates: Sequence[str]) -> int:
    """Writes the file of a part and returns its size in bytes. The same rows give the same bytes.

    Raises OSError if it cannot be written; the dataset is then as it was before.
    """
    table = pa.Table.from_pylist(list(rows), schema=schema(covariates))
    return _write_table(f"{out.rstrip('/')}/{name}.parquet", table)


def _write_table(url: str, table: Any) -> int:
    buffer = io.BytesIO()
    pq.write_table(table, buffer, compression="zstd")
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
    _refuse_newer(written, url)
    return dict(about)


def _refuse_newer(written: int, place: str) -> None:
    if written > FORMAT:
        raise DatasetError(
            f"{place} has format {written}, and this version of sprung knows formats up to {FORMAT}",
            code="dataset-newer",
            place=place,
            remedy="install the version of sprung that wrote it, or a newer one: pip install --upgrade sprung",
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
    """A dataset in memory."""

    url: str
    table: Any
    """All rows, a pyarrow.Table with the columns ``COLUMNS`` and the covariates of the manifest."""

    @classmethod
    def read(cls, url: str, columns: Sequence[str] | None = None) -> Dataset:
        """Reads all parts of a dataset, or some columns of them.

        Raises DatasetError if there is no dataset, if it cannot be read or if a newer version wrote it.
        """
        tables = [table for _, table in _tables(str(url), columns)]
        if not tables:
            raise DatasetError(
                f"{url} has no dataset",
                code="dataset-missing",
                place=str(url),
                remedy="give the folder that sprung.fleet.identify wrote",
            )
        return cls(str(url), pa.concat_tables(tables, promote_options="default"))

    @property
    def covariates(self) -> list[str]:
        """Names of the numeric columns of the manifest."""
        return [name for name in self.table.column_names if name not in COLUMNS]

    def rows(self, kind: str) -> Any:
        """Returns the rows of one kind (``parameter``, ``finding``, ``failure``), a pyarrow.Table.

        They are in the order of robot, level, log, estimator, parameter and code.
        """
        chosen = self.table.filter(pc.equal(self.table["kind"], kind))
        keys = ("robot", "level", "log", "estimator", "parameter", "code")
        return chosen.sort_by([(key, "ascending") for key in keys])


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


def _tables(out: str, columns: Sequence[str] | None) -> Iterable[tuple[str, Any]]:
    about_of(out)

    def read(url: str) -> tuple[str, Any]:
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
        _refuse_newer(written, url)
        if written == 0:
            raise DatasetError(
                f"{url} is not a part of a dataset of sprung",
                code="dataset-foreign",
                place=url,
                remedy="move it to another folder",
            )
        return url, table.read(columns=None if columns is None else list(columns))

    parts = _parts(out)
    with ThreadPoolExecutor(_READERS) as pool:
        for start in range(0, len(parts), 8 * _READERS):
            yield from pool.map(read, parts[start : start + 8 * _READERS])


def done(out: str) -> dict[str, tuple[tuple[str, str, str], bool]]:
    """Returns the tasks of a dataset by their key: identity, and whether the task failed."""
    found: dict[str, tuple[tuple[str, str, str], bool]] = {}
    for _, table in _tables(out, ("kind", "task", "level", "robot", "log", "experiment")):
        for row in table.group_by(table.column_names).aggregate([]).to_pylist():
            identity = (row["level"], row["robot"], row["log"] if row["level"] == "log" else row["experiment"])
            failed = row["kind"] == "failure" or found.get(row["task"], (identity, False))[1]
            found[row["task"]] = (identity, failed)
    return found


def remove(out: str, unwanted: Callable[[str], bool]) -> None:
    """Removes the rows of tasks, whose keys `unwanted` selects, each part at once."""
    for url, table in _tables(out, None):
        keep = pa.array([not unwanted(key) for key in table["task"].to_pylist()])
        if pc.all(keep).as_py():
            continue
        left = table.filter(keep)
        if left.num_rows == 0:
            files.remove(url)
        else:
            _write_table(url, left)
