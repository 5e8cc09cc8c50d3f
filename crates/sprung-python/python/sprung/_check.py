"""Checks of logs before any fit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sprung._finding import Finding, findings
from sprung._identification import Unknown
from sprung._record import record
from sprung._report import Pickled, Report

if TYPE_CHECKING:
    from sprung import _sprung


@dataclass(frozen=True)
class CheckedColumn:
    """Figures of one column of a log, in the unit of its quantity.

    Attributes:
        column: name of the column.
        quantity: for example ``link_position``.
        joint: name of the joint.
        unit: unit of the figures.
        min, max, mean: smallest, largest and mean value.
        deviation: standard deviation.
        noise: standard deviation of white noise.
        longest_still_s: longest time without a change, s.
        step: smallest step between values; ``None`` if the values have no steps.
        effective_bits: resolution beside the range of motion, bits; ``None`` without noise and steps.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> column = experiment.check(experiment.simulate()).logs[0].columns[0]
        >>> column.quantity, column.joint, column.unit, f"{column.step:.3g}"
        ('link_position', 'joint1', 'rad', '0.000383')
    """

    column: str
    quantity: str
    joint: str
    unit: str
    min: float
    max: float
    mean: float
    deviation: float
    noise: float | None = None
    longest_still_s: float | None = None
    step: float | None = None
    effective_bits: float | None = None


@dataclass(frozen=True)
class CheckedLog:
    """Figures of one log.

    Attributes:
        file: path or digest of the log.
        samples: number of samples.
        period_s: sampling period, s.
        rate_hz: sampling rate, Hz.
        duration_s: time between the first and the last sample, s.
        sampling: ``even``, ``on-cycle`` or ``as-stamped``.
        jitter_percent: largest deviation of a time step from the period, %.
        dropped, repeated, without_value, frozen, gaps: numbers of faulty samples and of gaps.
        columns: figures of the columns.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> log = experiment.check(experiment.simulate()).logs[0]
        >>> log.samples, round(log.rate_hz), log.dropped
        (10000, 1000, 0)
    """

    file: str
    samples: int
    period_s: float
    rate_hz: float
    duration_s: float
    columns: list[CheckedColumn]
    sampling: str = ""
    jitter_percent: float = 0.0
    dropped: int = 0
    repeated: int = 0
    without_value: int = 0
    frozen: int = 0
    gaps: int = 0


class Check(Report):
    """A check of a log.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> check = experiment.check(experiment.simulate())
        >>> check.refused, [
        ...     finding.severity for finding in check.findings if finding.severity == "error"
        ... ]
        (False, [])
    """

    def __init__(self, handle: _sprung.Checked | Pickled) -> None:
        self._handle = handle

    @cached_property
    def logs(self) -> list[CheckedLog]:
        """Figures of the logs and their columns."""
        return [record(CheckedLog, log) for log in self._contents["logs"]]

    @cached_property
    def unknowns(self) -> list[Unknown]:
        """What the first log shows beyond its description, with sizes; empty if nothing was found."""
        return [record(Unknown, unknown) for unknown in self._contents["unknowns"]]

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the log, with remedies."""
        return findings(self._contents["findings"])

    @property
    def refused(self) -> bool:
        """Whether `Experiment.identify` refuses the log."""
        return bool(self._contents["refused"])

    def to_json(self) -> str:
        """Returns the text of ``check.json``."""
        return self._handle.json()

    def _html(self) -> str:
        return self._handle.report()

    def __reduce__(self) -> tuple[Any, ...]:
        return _check, (self.to_json(), self._html())

    def __repr__(self) -> str:
        lines = [str(finding) for finding in self.findings] or ["no findings"]
        return "\n".join(lines)


def _check(json_text: str, page: str) -> Check:
    return Check(Pickled(json_text, page))
