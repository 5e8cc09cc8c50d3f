"""Several identifications of one robot side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sprung import _sprung
from sprung._errors import InputError
from sprung._finding import Finding, findings
from sprung._record import record
from sprung._report import Report

if TYPE_CHECKING:
    from sprung._result import Result


@dataclass(frozen=True)
class ComparedResult:
    """One of the compared results.

    Attributes:
        label: its name.
        robot: name of the robot.
        log: names of its logs.
        estimator: name of the estimator.
        verdict: ``good``, ``doubtful`` or ``unusable``.
        samples: number of samples of all logs.
        duration_s: duration of all logs, s.
        date_s: beginning of the first log since 1970, s; ``None`` if its times are no dates.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> both = [experiment.identify(experiment.simulate(seed=seed)) for seed in (1, 2)]
        >>> [result.label for result in sprung.compare(both, ["before", "after"]).compared]
        ['before', 'after']
    """

    label: str
    robot: str
    log: str
    estimator: str
    verdict: str
    samples: int
    duration_s: float
    date_s: float | None = None


@dataclass(frozen=True)
class CombinedParameter:
    """One parameter from several results.

    Attributes:
        name: name of the parameter.
        unit: unit of the numbers.
        results: number of results with an interval.
        value: mean, weighted by the information of each result.
        standard_error: its standard error.
        ci95: 95 % confidence interval.
        chi_square: sum of the squared distances from the mean over the squared standard errors.
        freedom: its degrees of freedom.
        probability: probability of at least this sum if the results agree.
        i_squared_percent: part of the scatter that the standard errors do not explain, %.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> both = [experiment.identify(experiment.simulate(seed=seed)) for seed in (1, 2)]
        >>> parameter = sprung.compare(both).combined[0].parameters[0]
        >>> parameter.name, parameter.results, parameter.freedom
        ('link1.inertia_total', 2, 1)
    """

    name: str
    unit: str
    results: int
    value: float
    standard_error: float
    ci95: tuple[float, float]
    chi_square: float
    freedom: int
    probability: float
    i_squared_percent: float


@dataclass(frozen=True)
class Combined:
    """Results of one estimator from different logs, combined.

    Attributes:
        estimator: name of the estimator.
        results: labels of the results.
        parameters: those that at least two results determine with an interval.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> both = [experiment.identify(experiment.simulate(seed=seed)) for seed in (1, 2)]
        >>> [entry.estimator for entry in sprung.compare(both).combined]
        ['least-squares']
    """

    estimator: str
    results: list[str]
    parameters: list[CombinedParameter]


@dataclass(frozen=True)
class DriftOfParameter:
    """A line through the estimates of one parameter over time.

    Attributes:
        name: name of the parameter.
        unit: unit of the numbers.
        results: number of results with an interval.
        span: times of the first and the last of them.
        first: value of the line at the first of them.
        change: change of the line to the last of them.
        standard_error: standard error of the change.
        between_runs: standard deviation of the results about the line beyond their errors.
        probability: probability of at least this change without drift.
        adjusted_probability: the same, adjusted for the number of parameters.
        drifts: whether it is below 1 %.
        change_percent: change, % of the first value; ``None`` if this value is not significant.
        change_per_day: change per day; ``None`` without dates.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> four = [experiment.identify(experiment.simulate(seed=seed)) for seed in range(4)]
        >>> (drift,) = sprung.compare(four).drift
        >>> [parameter.name for parameter in drift.parameters if parameter.drifts]
        []
    """

    name: str
    unit: str
    results: int
    span: tuple[float, float]
    first: float
    change: float
    standard_error: float
    between_runs: float
    probability: float
    adjusted_probability: float
    drifts: bool
    change_percent: float | None = None
    change_per_day: float | None = None


@dataclass(frozen=True)
class DriftOverTime:
    """Results of one estimator from at least four logs over time.

    Attributes:
        estimator: name of the estimator.
        results: labels of the results, from the first to the last.
        times: days since the first log, or numbers of the runs.
        time_unit: ``d`` or ``run``.
        parameters: the tested parameters.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> four = [experiment.identify(experiment.simulate(seed=seed)) for seed in range(4)]
        >>> (drift,) = sprung.compare(four).drift
        >>> drift.times, drift.time_unit
        ([1.0, 2.0, 3.0, 4.0], 'run')
    """

    estimator: str
    results: list[str]
    times: list[float]
    time_unit: str
    parameters: list[DriftOfParameter]


class Comparison(Report):
    """Several identifications side by side.

    Attributes:
        conclusion: whether they agree and whether parameters drift, in sentences.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> both = [experiment.identify(experiment.simulate(seed=seed)) for seed in (1, 2)]
        >>> print(sprung.compare(both))
        The results agree: ...
    """

    def __init__(self, json_text: str, page: str, conclusion: list[str]) -> None:
        self._json = json_text
        self._page = page
        self.conclusion = conclusion

    @cached_property
    def compared(self) -> list[ComparedResult]:
        """The compared results; differences refer to the first one."""
        return [record(ComparedResult, result) for result in self._contents["compared"]]

    @cached_property
    def combined(self) -> list[Combined]:
        """Means over results of different logs, one entry per estimator."""
        return [record(Combined, entry) for entry in self._contents.get("combined", [])]

    @cached_property
    def drift(self) -> list[DriftOverTime]:
        """Tests for drift, one entry per estimator with four results or more."""
        return [record(DriftOverTime, entry) for entry in self._contents.get("drift", [])]

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings of the comparison."""
        return findings(self._contents["findings"])

    def to_json(self) -> str:
        """Returns the text of ``comparison.json``."""
        return self._json

    def _html(self) -> str:
        return self._page

    def __reduce__(self) -> tuple[Any, ...]:
        return Comparison, (self._json, self._page, self.conclusion)

    def __repr__(self) -> str:
        return "\n".join(self.conclusion)


def compare(results: Sequence[Result], labels: Sequence[str] | None = None) -> Comparison:
    """Compares identifications of one robot with the first one: estimators, settings, runs.

    Four or more results of different logs are tested for drift, in the order of the dates of the logs if
    all have one.

    Args:
        results: two or more identifications.
        labels: a name for each; ``result 1``, ``result 2`` if absent.

    Raises:
        ExperimentError: if they are of different robots, or share no parameters.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> both = [experiment.identify(experiment.simulate(seed=seed)) for seed in (1, 2)]
        >>> sprung.compare(both).findings
        []
    """
    names = list(labels or (f"result {k}" for k in range(1, len(results) + 1)))
    if len(names) != len(results):
        raise InputError(
            f"{len(names)} labels for {len(results)} results", "labels", "give one for each"
        )
    given = [(name, result.to_json()) for name, result in zip(names, results, strict=True)]
    return Comparison(*_sprung.compare(given))
