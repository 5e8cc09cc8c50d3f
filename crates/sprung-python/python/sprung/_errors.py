"""Exceptions and warnings."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from sprung._record import record
from sprung._results import Finding


class SprungError(Exception):
    """An error of sprung.

    Attributes:
        code: code of the first finding, or ``usage``, ``log``, ``file``, ``stopped``, or the word of
            a wrong argument.
        text: the fault.
        remedy: what to do; ``None`` if the text says it.
        place: file, line and column; ``None`` if the error has no place.
        findings: findings for which a log was refused.

    Example:
        >>> import sprung
        >>> try:
        ...     sprung.Experiment.demo({"identify.estimator": "magic"})
        ... except sprung.SprungError as error:
        ...     type(error).__name__, error.code
        ('ExperimentError', 'usage')
    """

    def __init__(
        self,
        text: str,
        code: str = "usage",
        remedy: str | None = None,
        place: str | None = None,
        findings: Sequence[Finding] = (),
    ) -> None:
        super().__init__(text, code, remedy, place, findings)
        self.text = text
        self.code = code
        self.remedy = remedy
        self.place = place
        self.findings: list[Finding] = list(findings)

    def __str__(self) -> str:
        return self.text if self.remedy is None else f"{self.text}; {self.remedy}"


class ExperimentError(SprungError, ValueError):
    """The experiment or the request is wrong (exit code 2 of the command line).

    Example:
        >>> import sprung
        >>> sprung.Experiment.demo({"robot.nam": "arm"})
        Traceback (most recent call last):
        sprung._errors.ExperimentError: ...
    """


class LogError(SprungError, ValueError):
    """A log is wrong or was refused (exit code 3).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> log = experiment.simulate()
        >>> log["phi1_rad"][:] = 0.0131                  # as of an encoder that is not connected
        >>> experiment.identify(log)
        Traceback (most recent call last):
        sprung._errors.LogError: ...
    """


class FileError(SprungError):
    """A file cannot be read or written (exit code 4).

    Example:
        >>> import sprung
        >>> sprung.Experiment("there-is-no-such-folder/experiment.toml")
        Traceback (most recent call last):
        sprung._errors.FileError: ...
    """


class InputError(SprungError, ValueError):
    """An argument of a call is wrong.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> result.model.gravity([0.0, 0.0, 0.0])
        Traceback (most recent call last):
        sprung._errors.InputError: q has the shape (3,); give (2,) or (samples, 2) for all arguments
    """


class Stopped(SprungError):
    """The progress callback stopped the run by returning ``False``.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo()
        >>> log = experiment.simulate()
        >>> experiment.identify(log, progress=lambda phase, done, total: False)
        Traceback (most recent call last):
        sprung._errors.Stopped: ...
    """


class SprungWarning(UserWarning):
    """A warning about a log or a result.

    Attributes:
        finding: the finding behind it; ``None`` for a warning about an argument.

    Example:
        >>> import warnings, sprung
        >>> warnings.simplefilter("ignore", sprung.SprungWarning)
    """

    def __init__(self, message: str, finding: Finding | None = None) -> None:
        super().__init__(message)
        self.finding = finding

    @classmethod
    def of(cls, finding: Finding) -> SprungWarning:
        """Returns the warning of a finding."""
        return cls(f"{finding.code}: {finding.text}; {finding.remedy}", finding)


def findings(given: str | Iterable[Mapping[str, Any]]) -> list[Finding]:
    """Returns findings from their JSON or its text."""
    return [record(Finding, one) for one in (json.loads(given or "[]") if isinstance(given, str) else given)]


def warn(*given: SprungWarning) -> None:
    """Gives Python warnings at the line that called the package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals["__name__"].split(".")[0] == "sprung":
        frame, level = frame.f_back, level + 1
    for warning in given:
        warnings.warn(warning, stacklevel=level)


def warn_of(found: Iterable[Finding]) -> None:
    """Gives a Python warning for each warning among findings."""
    warn(*(SprungWarning.of(finding) for finding in found if finding.severity in {"warning", "serious"}))


def one_of(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Refuses a word that is not allowed."""
    if value not in allowed:
        raise InputError(
            f'{name} = "{value}" is not known', name, f"give one of {', '.join(allowed)}"
        )


def whole(name: str, value: int) -> None:
    """Refuses a number that is not whole, negative or too large for the library."""
    if not isinstance(value, int | np.integer) or not 0 <= value < 2**64:
        raise InputError(f"{name} = {value!r}", name, "give a whole number from 0")


def described(
    kind: str, text: str, code: str, remedy: str | None, place: str | None, found: str
) -> SprungError:
    """Returns the exception of an error of the library.

    Args:
        kind: name of its class.
        found: findings for which a log was refused, as JSON.
    """
    classes = (ExperimentError, LogError, FileError, InputError, Stopped)
    (error_class,) = (one for one in classes if one.__name__ == kind)
    return error_class(text, code, remedy, place, findings(found))
