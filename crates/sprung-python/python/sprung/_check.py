"""Checks of logs before any fit."""

from __future__ import annotations

from sprung._report import Field, Report
from sprung._results import CheckedLog, Finding, Unknown


class Check(Report):
    """A check of a log.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> check = experiment.check(experiment.simulate())
        >>> check.refused, [finding.evidence for finding in check.findings if finding.severity == "error"]
        (False, [])
        >>> [(unknown.id, unknown.competing, unknown.law) for unknown in check.unknowns]    # the log is complete
        []
        >>> (log,) = check.logs
        >>> log.samples, round(log.rate_hz), log.dropped
        (10000, 1000, 0)
        >>> column = log.columns[0]
        >>> column.quantity, column.joint, column.unit, f"{column.step:.3g}"
        ('link_position', 'joint1', 'rad', '0.000383')
    """

    _type = "CheckReport"

    logs: Field[list[CheckedLog]] = Field()
    unknowns: Field[list[Unknown]] = Field()
    findings: Field[list[Finding]] = Field()
    refused: Field[bool] = Field()

    def __repr__(self) -> str:
        return "\n".join(map(str, self.findings)) or "no findings"
