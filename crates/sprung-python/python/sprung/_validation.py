"""Predictions of other logs, compared with the promise."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from sprung._curves import curves
from sprung._errors import InputError
from sprung._named import Named
from sprung._report import Field, Report
from sprung._results import ValidationRun

if TYPE_CHECKING:
    from sprung._curves import Curves


class Validation(Report):
    """Prediction errors on other logs beside the promised ones.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> validation = result.validate(experiment.simulate(seed=7))
        >>> print(validation)
        The promise is kept: ...
        >>> (run,) = validation.runs
        >>> run.name, run.same_log, run.samples
        ('direct', False, 10000)
        >>> (validated,) = run.sets
        >>> validated.parameters, validated.outcome, validated.promise_kept
        ('least-squares', 'simulated', True)
        >>> [joint.torque_ratio < 1.5 for joint in validated.predictions]
        [True, True]
        >>> validated.e_rms.q_rad["joint1"] < 1e-3
        True
    """

    _type = "Validation"
    _kept = ("json", "report", "sentence", "signals")

    runs: Field[list[ValidationRun]] = Field()

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        sentence: str = self._handle.sentence()
        return sentence

    @cached_property
    def signals(self) -> Named[Curves]:
        """Measured and simulated signals by ``run/parameters``."""
        return curves(self._handle.signals(), "run")

    def score(self, estimator: str) -> float:
        """Returns the part of the mean square of the motor torques that the parameters of an estimator
        predict, mean over joints and runs; see `Result.score`.

        Raises:
            InputError: if a parameter has no value.
        """
        errors = [
            joint
            for run in self.runs
            for candidate in run.sets
            if candidate.parameters == estimator and candidate.modified is None
            for joint in candidate.predictions
        ]
        if not errors:
            raise InputError(
                f"{estimator} predicts no torque",
                "score",
                "a parameter has no value: see result.findings for those that the log does not determine",
            )
        return sum(
            1.0 - (joint.torque_error_nm / joint.torque_nm) ** 2 for joint in errors
        ) / len(errors)

    def __repr__(self) -> str:
        return self.sentence
