"""Findings: observations that the user must know, with evidence and remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Evidence:
    """Place in a log that shows a finding, and its value.

    Attributes:
        file: path or digest of the log.
        value: what the log shows there.
        unit: unit of the value.
        column: column of the log; ``None`` if the finding belongs to none.
        time_s: time in the log, s; ``None`` if the finding belongs to the whole log.

    Example:
        >>> import sprung
        >>> sprung.Evidence("run.csv", 0.17, "rad", column="q1_rad", time_s=2.5).column
        'q1_rad'
    """

    file: str
    value: float
    unit: str
    column: str | None = None
    time_s: float | None = None


@dataclass(frozen=True)
class Finding:
    """A finding.

    Attributes:
        code: stable name, for example ``impossible-robot``.
        severity: ``info``, ``warning``, ``serious`` or ``error``.
        text: observation with values and units, and its likely cause.
        remedy: what to do.
        parameters: names of the parameters concerned.
        evidence: place in a log, if there is one.
        setting: table and line of ``experiment.toml`` that correct the cause, if there is one.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> [
        ...     finding.code
        ...     for finding in result.findings
        ...     if finding.severity in ("serious", "error")
        ... ]
        []
    """

    code: str
    severity: str
    text: str
    remedy: str
    parameters: tuple[str, ...] = ()
    evidence: Evidence | None = None
    setting: str | None = None

    def __str__(self) -> str:
        return f"{self.severity}: {self.code}: {self.text}; {self.remedy}"


def findings(given: Iterable[dict[str, Any]]) -> list[Finding]:
    """Returns findings from their JSON."""
    return [
        Finding(
            code=one["code"],
            severity=one["severity"],
            text=one["text"],
            remedy=one["remedy"],
            parameters=tuple(one.get("parameters", ())),
            evidence=Evidence(**one["evidence"]) if one.get("evidence") else None,
            setting=one.get("setting"),
        )
        for one in given
    ]
