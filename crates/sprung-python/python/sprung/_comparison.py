"""Several identifications of one robot side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from sprung import _sprung
from sprung._errors import InputError
from sprung._report import Field, Kept, Report
from sprung._results import Combined, ComparedResult, DriftOverTime, Finding

if TYPE_CHECKING:
    from sprung._result import Result


class Comparison(Report):
    """Several identifications side by side.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> four = [experiment.identify(experiment.simulate(seed=seed)) for seed in range(4)]
        >>> comparison = sprung.compare(four, ["first", "second", "third", "fourth"])
        >>> print(comparison)
        The results agree: ...
        >>> [result.label for result in comparison.compared]
        ['first', 'second', 'third', 'fourth']
        >>> comparison.compared[0].settings.position_cutoff_choice.sweep[0].cutoff_hz > 0.0
        True
        >>> (combined,) = comparison.combined
        >>> parameter = combined.parameters[0]
        >>> combined.estimator, parameter.name, parameter.results, parameter.freedom
        ('least-squares', 'link1.inertia_total', 4, 3)
        >>> parameter.error_parts.sampling < parameter.standard_error
        True
        >>> (drift,) = comparison.drift
        >>> drift.times, drift.time_unit, [parameter.name for parameter in drift.parameters if parameter.drifts]
        ([1.0, 2.0, 3.0, 4.0], 'run', [])
    """

    _type = "Comparison"
    _kept = ("json", "report", "conclusion")

    compared: Field[list[ComparedResult]] = Field()
    combined: Field[list[Combined]] = Field()
    drift: Field[list[DriftOverTime]] = Field()
    findings: Field[list[Finding]] = Field()

    @property
    def conclusion(self) -> list[str]:
        """Whether the results agree and whether parameters drift, in sentences."""
        sentences: list[str] = self._handle.conclusion()
        return sentences

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
    return Comparison(Kept(dict(zip(Comparison._kept, _sprung.compare(given), strict=True))))
