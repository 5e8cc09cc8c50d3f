"""The analysis of a fleet: population of each parameter, outlier robots, drift of robots, effects of covariates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .drift import FEWEST_LOGS, CovariateEffect, Drift, Series, covariate_effects, drift, prior
from .outliers import Central, Tests, adjust, test
from .statistics import Estimates, Floats, RobotMeans, Scatter, moments, robot_means, scatter, variances

Strings: TypeAlias = NDArray[np.object_]

RATE = 0.05
"""Rate of false discoveries among the robots that are named."""


@dataclass(frozen=True)
class Rows:
    """Estimates of all parameters from single logs: [n] each, in any order.

    >>> import numpy as np
    >>> from sprung import fleet
    >>> rows = fleet.Rows(
    ...     robot=np.array(["A-1", "A-2"], dtype=object),
    ...     parameter=np.array(["joint1.stiffness"] * 2, dtype=object),
    ...     unit=np.array(["N·m/rad"] * 2, dtype=object),
    ...     value=np.array([10.0, 10.2]),
    ...     standard_error=np.array([0.1, 0.1]),
    ...     time_s=np.array([np.nan, np.nan]),
    ... )
    >>> fleet.analyse(rows).populations[0].scatter.robots
    2
    """

    robot: Strings
    parameter: Strings
    unit: Strings
    value: Floats
    """In the unit of the row."""
    standard_error: Floats
    time_s: Floats
    """Time of the log; NaN where it is unknown."""
    covariates: Mapping[str, Floats] = field(default_factory=dict)
    """[n] each, by name; NaN where one is unknown."""


@dataclass(frozen=True, slots=True)
class Robot:
    """One robot in the population of one parameter."""

    robot: str
    logs: int
    value: float
    deviation: float
    """From the central robots."""
    p_value: float
    adjusted_p_value: float
    """By Benjamini and Hochberg over all robots and parameters; NaN where a robot is not tested."""


@dataclass(frozen=True)
class Moved:
    """The test for drift of one parameter of one robot."""

    robot: str
    drift: Drift
    adjusted_p_value: float
    series: Series
    """Values at the mean covariates."""


@dataclass(frozen=True)
class Population:
    """One parameter in the fleet."""

    parameter: str
    unit: str
    scatter: Scatter
    central: Central | None
    robots: list[Robot]
    tested_for_drift: int
    """Robots with enough logs at known times."""
    drifts: list[Moved]
    """Of those of them whose p-value is at most the rate of false discoveries before it is adjusted."""
    covariates: dict[str, CovariateEffect]


@dataclass(frozen=True)
class Analysis:
    """The result for a fleet.

    >>> from sprung import fleet
    >>> fleet.Analysis([], rate=0.05).outliers()
    []
    """

    populations: list[Population]
    rate: float

    def outliers(self) -> list[tuple[Population, Robot]]:
        """Robots that do not belong to the population, the clearest first."""
        named = [
            (population, robot)
            for population in self.populations
            for robot in population.robots
            if robot.adjusted_p_value <= self.rate
        ]
        return sorted(named, key=lambda pair: (pair[1].p_value, pair[1].robot, pair[0].parameter))

    def moved(self) -> list[tuple[Population, Moved]]:
        """Parameters of robots that changed over time, the clearest first."""
        named = [
            (population, moved)
            for population in self.populations
            for moved in population.drifts
            if moved.adjusted_p_value <= self.rate
        ]
        return sorted(named, key=lambda pair: (pair[1].drift.p_value, pair[1].robot, pair[0].parameter))


def analyse(rows: Rows, rate: float = RATE) -> Analysis:
    """Analyses a fleet.

    - rows: estimates from single logs. Rows whose value or standard error is not finite are left out.
    - rate: rate of false discoveries, between 0 and 1.

    The covariates are explained first: all tests use values at the mean covariates of the fleet.

    Raises ValueError if the rate is not between 0 and 1, if columns differ in length, or if one parameter has two
    units.

    Twenty robots, of which one is 5 % softer:

    >>> import numpy as np
    >>> from sprung import fleet
    >>> value = 10 + 0.02 * np.random.default_rng(0).standard_normal(20)
    >>> value[7] *= 0.95
    >>> rows = fleet.Rows(
    ...     robot=np.array([f"A-{number}" for number in range(20)], dtype=object),
    ...     parameter=np.array(["joint1.stiffness"] * 20, dtype=object),
    ...     unit=np.array(["N·m/rad"] * 20, dtype=object),
    ...     value=value,
    ...     standard_error=np.full(20, 0.01),
    ...     time_s=np.full(20, np.nan),
    ... )
    >>> [(robot.robot, population.parameter) for population, robot in fleet.analyse(rows).outliers()]
    [('A-7', 'joint1.stiffness')]
    """
    check_rate(rate)
    _same_length(rows)
    names = sorted({str(name) for name in rows.parameter[_usable(rows)]})
    return analyse_parameters(((name, _chosen(rows, rows.parameter == name)) for name in names), rate)


def check_rate(rate: float) -> None:
    """Raises ValueError if a rate of false discoveries is not between 0 and 1."""
    if not 0 < rate < 1:
        raise ValueError(f"the rate of false discoveries is {rate}; it needs to be between 0 and 1")


def analyse_parameters(parameters: Iterable[tuple[str, Rows]], rate: float) -> Analysis:
    """Analyses a fleet whose parameters come one after the other, in ascending order of their names.

    - parameters: the name and the estimates of each parameter, which are needed until the next one comes.
    - rate: rate of false discoveries, between 0 and 1.

    Raises ValueError if one parameter has two units.
    """
    parts = [_Part.of(_chosen(rows, _usable(rows)), name, rate) for name, rows in parameters if _usable(rows).any()]
    adjusted = adjust([part.p_values() for part in parts])
    moved = adjust([part.drift_p_values for part in parts])
    triples = zip(parts, adjusted, moved, strict=True)
    return Analysis([part.population(p_robots, p_drifts) for part, p_robots, p_drifts in triples], rate)


def _usable(rows: Rows) -> NDArray[np.bool_]:
    return np.isfinite(rows.value) & np.isfinite(rows.standard_error)


def _columns(rows: Rows) -> dict[str, Any]:
    """Returns the columns of rows that are no covariates."""
    return {name: column for name, column in vars(rows).items() if name != "covariates"}


def _chosen(rows: Rows, chosen: NDArray[np.bool_]) -> Rows:
    covariates = {name: column[chosen] for name, column in rows.covariates.items()}
    return Rows(**{name: column[chosen] for name, column in _columns(rows).items()}, covariates=covariates)


def _same_length(rows: Rows) -> None:
    for name, column in {**_columns(rows), **rows.covariates}.items():
        if column.shape != rows.value.shape or column.ndim != 1:
            raise ValueError(f"column {name} has the shape {column.shape}; value has {rows.value.shape}")


@dataclass(frozen=True)
class _Part:
    """One parameter while it is analysed. It holds the values of robots, not those of logs."""

    name: str
    unit: str
    robots: list[str]
    scatter: Scatter
    means: RobotMeans
    tests: Tests | None
    drift_p_values: Floats
    """Of all robots that are tested for drift."""
    drifts: dict[int, tuple[str, Drift, Series]]
    """Those that can be named, by their position in the p-values: adjusted p-values are not smaller."""
    covariates: dict[str, CovariateEffect]

    @classmethod
    def of(cls, rows: Rows, name: str, rate: float) -> _Part:
        units = sorted({str(unit) for unit in rows.unit})
        if len(units) > 1:
            raise ValueError(
                f"parameter {name} has the units {', '.join(units)}: analyse experiments with other units apart"
            )
        robots, numbers = np.unique(rows.robot.astype(str), return_inverse=True)
        # The order of Estimates.of, so that times and covariates follow the estimates.
        order = np.argsort(numbers, kind="stable")
        estimates = Estimates.of(numbers[order], rows.value[order], rows.standard_error[order])
        effects: dict[str, CovariateEffect] = {}
        known = [c for c, column in rows.covariates.items() if np.isfinite(column).all()]
        if known:
            columns = np.stack([rows.covariates[c][order] for c in known], axis=1)
            found, values = covariate_effects(estimates, moments(estimates)[1], columns)
            effects = dict(zip(known, found, strict=True))
            estimates = Estimates(estimates.robot, values, estimates.standard_error)
        described = scatter(estimates)
        means = robot_means(estimates, described.within)
        series = _series(estimates, described.within, rows.time_s[order])
        moderation = prior(list(series.values()))
        tested = [
            (robot, one, time_series)
            for robot, time_series in series.items()
            if (one := drift(time_series, moderation)) is not None
        ]
        p_values = np.array([one.p_value for _, one, _ in tested], dtype=np.float64)
        return cls(
            name=name,
            unit=units[0],
            robots=[str(robot) for robot in robots],
            scatter=described,
            means=means,
            tests=test(means),
            drift_p_values=p_values,
            drifts={k: (str(robots[tested[k][0]]), *tested[k][1:]) for k in np.flatnonzero(p_values <= rate).tolist()},
            covariates=effects,
        )

    def p_values(self) -> Floats:
        return np.full(len(self.robots), np.nan) if self.tests is None else self.tests.p_value

    def population(self, p_robots: Floats, p_drifts: Floats) -> Population:
        deviation = np.full(len(self.robots), np.nan) if self.tests is None else self.tests.deviation
        columns = (self.means.logs, self.means.value, deviation, self.p_values(), p_robots)
        cells = zip(self.robots, *(column.tolist() for column in columns), strict=True)
        return Population(
            parameter=self.name,
            unit=self.unit,
            scatter=self.scatter,
            central=None if self.tests is None else self.tests.central,
            robots=[Robot(*row) for row in cells],
            tested_for_drift=int(self.drift_p_values.size),
            drifts=[Moved(robot, one, float(p_drifts[k]), series) for k, (robot, one, series) in self.drifts.items()],
            covariates=self.covariates,
        )


def _series(estimates: Estimates, within: float, time_s: Floats) -> dict[int, Series]:
    """Returns the estimates over time of each robot whose logs all have a time."""
    variance = variances(estimates, within)
    ends = np.searchsorted(estimates.robot, np.arange(estimates.robots + 1))
    series = {}
    for robot in range(estimates.robots):
        part = slice(ends[robot], ends[robot + 1])
        time = time_s[part]
        if time.size >= FEWEST_LOGS and np.isfinite(time).all():
            order = np.argsort(time, kind="stable")
            series[robot] = Series(time[order], estimates.value[part][order], variance[part][order])
    return series
