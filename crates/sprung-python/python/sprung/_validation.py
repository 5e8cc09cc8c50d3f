"""Predictions of other logs, compared with the promise."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from sprung import _sprung
from sprung._curves import curves
from sprung._errors import InputError
from sprung._finding import Finding
from sprung._named import Named
from sprung._record import record
from sprung._report import Pickled, Report

if TYPE_CHECKING:
    from sprung._curves import Curves


@dataclass(frozen=True)
class JointErrors:
    """Errors of the predicted motor torque and deflection of a joint, filtered, root mean squares.

    Attributes:
        joint: name of the joint.
        torque_nm: motor torque, N·m (N).
        torque_error_nm: error of the motor torque, N·m (N).
        torque_promised_nm: promised error, N·m (N); ``None`` without an identification.
        torque_ratio: error over promised error.
        deflection_rad: deflection of the spring, rad (m); ``None`` without a spring.
        deflection_error_rad, deflection_promised_rad, deflection_ratio: the same for the deflection.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> errors = result.validate(experiment.simulate(seed=7)).runs[0].sets[0].predictions
        >>> [joint.torque_ratio < 1.5 for joint in errors]
        [True, True]
    """

    joint: str
    torque_nm: float
    torque_error_nm: float
    torque_promised_nm: float | None = None
    torque_ratio: float | None = None
    deflection_rad: float | None = None
    deflection_error_rad: float | None = None
    deflection_promised_rad: float | None = None
    deflection_ratio: float | None = None


@dataclass(frozen=True)
class LoopErrors:
    """Measured minus simulated signals of a closed loop, root mean squares by joint.

    Attributes:
        tau_nm: motor torques, N·m (N).
        q_rad: link positions, rad (m).
        phi_rad: motor positions, rad (m).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> loop = result.validate(experiment.simulate(seed=7)).runs[0].sets[0].e_rms
        >>> loop.q_rad["joint1"] < 1e-3
        True
    """

    tau_nm: Named[float]
    q_rad: Named[float]
    phi_rad: Named[float]


@dataclass(frozen=True)
class ValidatedSet:
    """One set of parameters on one log.

    Attributes:
        parameters: origin of the parameters: the estimator, or a file.
        outcome: ``simulated``, ``ran-away``, ``not-simulable`` or ``no-controller``.
        torque_residual_nm: residual of the filtered motor torque, root mean square by joint, N·m (N).
        torque_relative_residual: the same over the torque.
        findings: findings about these parameters.
        predictions: errors of each joint beside the promised ones; empty if a value is missing.
        promise_kept: whether no error exceeds 1.5 times the promised one; ``None`` without a promise.
        e_rms: errors of the simulated closed loop; ``None`` unless it was simulated.
        modified: changes of the parameters that make the loop stable; ``None`` without.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> (validated,) = result.validate(experiment.simulate(seed=7)).runs[0].sets
        >>> validated.parameters, validated.outcome, validated.promise_kept
        ('least-squares', 'simulated', True)
    """

    parameters: str
    outcome: str
    torque_residual_nm: Named[float]
    torque_relative_residual: Named[float]
    findings: list[Finding]
    predictions: list[JointErrors] = field(default_factory=list)
    promise_kept: bool | None = None
    e_rms: LoopErrors | None = None
    modified: str | None = None


@dataclass(frozen=True)
class ValidationRun:
    """One log and all sets of parameters on it.

    Attributes:
        name: name of the run.
        log: path or digest of the log.
        same_log: whether the parameters come from this log, so that it proves nothing.
        samples: number of samples.
        simulated: whether the closed loop was simulated, which needs a controller.
        findings: findings about the log.
        sets: the sets of parameters.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> (run,) = result.validate(experiment.simulate(seed=7)).runs
        >>> run.name, run.same_log, run.samples
        ('direct', False, 10000)
    """

    name: str
    log: str
    same_log: bool
    samples: int
    simulated: bool
    findings: list[Finding]
    sets: list[ValidatedSet]


class Validation(Report):
    """Prediction errors on other logs beside the promised ones.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> print(result.validate(experiment.simulate(seed=7)))
        The promise is kept: ...
    """

    def __init__(self, handle: _sprung.Validated | Pickled, sentence: str | None = None) -> None:
        self._handle = handle
        self._sentence = sentence

    @cached_property
    def runs(self) -> list[ValidationRun]:
        """The runs, with the errors of each set of parameters."""
        return [record(ValidationRun, run) for run in self._contents["runs"]]

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        if self._sentence is None and isinstance(self._handle, _sprung.Validated):
            self._sentence = self._handle.sentence()
        return self._sentence or ""

    @cached_property
    def signals(self) -> Named[Curves]:
        """Measured and simulated signals by ``run/parameters``; empty after a pickle."""
        if isinstance(self._handle, _sprung.Validated):
            return curves(self._handle.signals(), "run")
        return Named({})

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

    def to_json(self) -> str:
        """Returns the text of ``validation.json``."""
        return self._handle.json()

    def _html(self) -> str:
        return self._handle.report()

    def __reduce__(self) -> tuple[Any, ...]:
        return _validation, (self.to_json(), self._html(), self.sentence)

    def __repr__(self) -> str:
        return self.sentence


def _validation(json_text: str, page: str, sentence: str) -> Validation:
    return Validation(Pickled(json_text, page), sentence)
