"""The estimates of a dataset for its report, read parameter by parameter, so that memory does not hold all rows.

The first pass over the parts counts. Each further pass collects the estimates of as many parameters as fit into
``ESTIMATES_AT_A_TIME``, and of at least one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrow import pa, pc
from .dataset import COLUMNS, Dataset, no_dataset, tables
from .population import Rows, Strings
from .statistics import Floats

if TYPE_CHECKING:
    import pyarrow

ESTIMATES_AT_A_TIME = 1_000_000
"""Estimates in memory; each takes about 150 bytes."""
FAILURES_SHOWN = 200
"""Failures in memory: those that the report shows."""
TABLES_AT_A_TIME = 256
"""Tables of parts that are merged together."""
_ORDER = ("robot", "level", "log", "estimator", "parameter", "code")
_COUNTED = ("kind", "task", *_ORDER, "text", "remedy", "value", "standard_error", "identifiable")
_COLLECTED = ("robot", "log", "time", "parameter", "unit", "value", "standard_error")


@dataclass(frozen=True)
class Source:
    """Where rows come from: the parts of a dataset, which each pass reads again, or a dataset that the caller holds."""

    dataset: Dataset | str

    @property
    def url(self) -> str:
        """Names the dataset."""
        return self.dataset if isinstance(self.dataset, str) else self.dataset.url

    def tables(self, wanted: Callable[[str], bool]) -> Iterator[pyarrow.Table]:
        """Yields all rows in the order of the parts, with the columns whose names are wanted."""
        if isinstance(self.dataset, str):
            return (table for _, table in tables(self.dataset, wanted))
        table = self.dataset.table
        return iter([table.select([name for name in table.column_names if wanted(name)])])


@dataclass(frozen=True)
class Failure:
    """A log that failed."""

    robot: str
    log: str | None
    code: str
    text: str
    remedy: str | None


@dataclass
class Counts:
    """What the first pass finds in a dataset."""

    covariates: list[str] = field(default_factory=list)
    robots: int = 0
    logs: int = 0
    """Logs that were identified alone, or failed."""
    failed: int = 0
    """Tasks with a failure."""
    failures: int = 0
    """Rows of failures, one for each log."""
    failure_codes: list[tuple[str, int]] = field(default_factory=list)
    """The most frequent first."""
    first_failures: list[Failure] = field(default_factory=list)
    """The first ``FAILURES_SHOWN`` in the order of robots and logs."""
    estimators: list[str] = field(default_factory=list)
    """Of single logs, in the order of robots and logs."""
    parameters: dict[tuple[str, str], int] = field(default_factory=dict)
    """Usable estimates of single logs by estimator and parameter."""


def count(source: Source) -> Counts:
    """Counts robots, logs, failures and estimates. Raises DatasetError if there are no rows."""
    counts = Counts()
    robots, logs, failed = _Distinct(), _Distinct(), _Distinct()
    failures, first = _Failures(), _First()
    parameters: Counter[tuple[str, str]] = Counter()
    covariates: dict[str, None] = {}
    for table in source.tables(lambda name: name in _COUNTED or name not in COLUMNS):
        covariates |= dict.fromkeys(name for name in table.column_names if name not in COLUMNS)
        robots.add(table["robot"])
        logs.add(table.filter(pc.equal(table["level"], "log"))["task"])
        failed_rows = table.filter(pc.equal(table["kind"], "failure"))
        failed.add(failed_rows["task"])
        failures.add(failed_rows)
        estimates = _single_logs(table)
        for estimator in pc.unique(estimates["estimator"]).to_pylist():
            mine = estimates.filter(pc.equal(estimates["estimator"], estimator))
            robot = pc.min(mine["robot"])
            log = pc.min(mine.filter(pc.equal(mine["robot"], robot))["log"])
            first.add(estimator, (robot.as_py(), log.as_py(), estimator))
        grouped = _usable(estimates).group_by(["estimator", "parameter"]).aggregate([([], "count_all")])
        for row in grouped.to_pylist():
            parameters[row["estimator"], row["parameter"]] += row["count_all"]
    if len(robots) == 0:
        raise no_dataset(source.url)
    counts.covariates = list(covariates)
    counts.robots, counts.logs, counts.failed = len(robots), len(logs), len(failed)
    counts.failures, counts.failure_codes, counts.first_failures = failures.rows, failures.by_code(), failures.first()
    counts.estimators = first.names()
    counts.parameters = dict(sorted(parameters.items()))
    return counts


def estimates(
    source: Source, counts: Counts, estimator: str, covariates: Sequence[str]
) -> Iterator[tuple[str, Rows]]:
    """Yields the estimates of each parameter from single logs, sorted by robot and log; parameters by name."""
    sizes = {parameter: size for (candidate, parameter), size in counts.parameters.items() if candidate == estimator}
    columns = {"kind", "level", "estimator", "identifiable", *_COLLECTED, *covariates}
    for group in _groups(sizes):
        names = pa.array(group)
        collected = _Collected()
        for table in source.tables(columns.__contains__):
            rows = _usable(_single_logs(table))
            rows = rows.filter(pc.and_(pc.equal(rows["estimator"], estimator), pc.is_in(rows["parameter"], names)))
            collected.add(rows.drop_columns(["kind", "level", "estimator", "identifiable"]))
        together = collected.table()
        for name in group:
            rows = together.filter(pc.equal(together["parameter"], name))
            yield name, _rows(rows.sort_by([("robot", "ascending"), ("log", "ascending")]), covariates)


def _groups(sizes: Mapping[str, int]) -> Iterator[list[str]]:
    """Divides parameters into groups of at most ``ESTIMATES_AT_A_TIME`` estimates, or of one parameter."""
    group: list[str] = []
    for name, size in sizes.items():
        if group and sum(sizes[one] for one in group) + size > ESTIMATES_AT_A_TIME:
            yield group
            group = []
        group.append(name)
    if group:
        yield group


def _single_logs(table: pyarrow.Table) -> pyarrow.Table:
    return table.filter(pc.and_(pc.equal(table["kind"], "parameter"), pc.equal(table["level"], "log")))


def _usable(table: pyarrow.Table) -> pyarrow.Table:
    finite = pc.and_(pc.is_finite(table["value"]), pc.is_finite(table["standard_error"]))
    return table.filter(pc.and_(pc.fill_null(table["identifiable"], True), pc.fill_null(finite, False)))


def _rows(table: pyarrow.Table, covariates: Sequence[str]) -> Rows:
    return Rows(
        robot=_objects(table["robot"]),
        parameter=_objects(table["parameter"]),
        unit=_objects(table["unit"]),
        value=_floats(table["value"]),
        standard_error=_floats(table["standard_error"]),
        time_s=_floats(pc.cast(table["time"], pa.int64())) * 1e-6,
        covariates={name: _floats(table[name]) for name in covariates},
    )


def _objects(column: Any) -> Strings:
    # Equal texts share one object.
    encoded = column.combine_chunks().dictionary_encode()
    values: Strings = np.array(encoded.dictionary.to_pylist(), dtype=object)[encoded.indices.to_numpy()]
    return values


def _floats(column: Any) -> Floats:
    numbers: Floats = pc.fill_null(pc.cast(column, pa.float64()), float("nan")).to_numpy()
    return numbers


def _sorted(table: pyarrow.Table) -> pyarrow.Table:
    return table.sort_by([(name, "ascending") for name in _ORDER])


class _Distinct:
    """Distinct texts, without an object for each."""

    def __init__(self) -> None:
        self.found = pa.array([], pa.string())
        self.new: list[Any] = []

    def add(self, column: Any) -> None:
        self.new.append(pc.unique(column))
        if len(self.new) >= TABLES_AT_A_TIME:
            self._merge()

    def __len__(self) -> int:
        self._merge()
        return len(self.found)

    def _merge(self) -> None:
        self.found = pc.unique(pa.chunked_array([self.found, *self.new]))
        self.new = []


class _First:
    """The smallest key of each name. ``None`` is larger than every text, as in the order of Arrow."""

    def __init__(self) -> None:
        self.keys: dict[str, list[tuple[bool, str]]] = {}

    def add(self, name: str, key: Iterable[str | None]) -> None:
        sort_key = [(part is None, part or "") for part in key]
        self.keys[name] = min(sort_key, self.keys.get(name, sort_key))

    def names(self) -> list[str]:
        return sorted(self.keys, key=self.keys.__getitem__)


class _Failures:
    """Counts of failures, and the first of them."""

    def __init__(self) -> None:
        self.rows = 0
        self.codes: Counter[str] = Counter()
        self.order = _First()
        self.shown: Any = None

    def add(self, failures: pyarrow.Table) -> None:
        if failures.num_rows == 0:
            return
        self.rows += failures.num_rows
        for row in failures.select(_ORDER).to_pylist():
            self.codes[row["code"]] += 1
            self.order.add(row["code"], row.values())
        details = failures.select([*_ORDER, "text", "remedy"])
        together = details if self.shown is None else pa.concat_tables([self.shown, details])
        self.shown = _sorted(together).slice(0, FAILURES_SHOWN).combine_chunks()

    def by_code(self) -> list[tuple[str, int]]:
        return sorted(((name, self.codes[name]) for name in self.order.names()), key=lambda one: -one[1])

    def first(self) -> list[Failure]:
        if self.shown is None:
            return []
        rows = self.shown.to_pylist()
        return [Failure(row["robot"], row["log"], row["code"], row["text"], row["remedy"]) for row in rows]


class _Collected:
    """Rows of many small tables."""

    def __init__(self) -> None:
        self.small: list[pyarrow.Table] = []
        self.large: list[pyarrow.Table] = []

    def add(self, table: pyarrow.Table) -> None:
        self.small.append(table)
        if len(self.small) >= TABLES_AT_A_TIME:
            self._merge()

    def table(self) -> pyarrow.Table:
        self._merge()
        whole: pyarrow.Table = pa.concat_tables(self.large, promote_options="default")
        return whole

    def _merge(self) -> None:
        if self.small:
            # A small table has more overhead than contents.
            self.large.append(pa.concat_tables(self.small, promote_options="default").combine_chunks())
            self.small = []
