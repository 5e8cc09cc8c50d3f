"""Results of identifications."""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sprung import _sprung
from sprung._columns import given
from sprung._curves import curves
from sprung._errors import InputError, findings, one_of, whole
from sprung._files import write_all
from sprung._model import Model
from sprung._named import Named
from sprung._parameters import Parameters
from sprung._progress import Progress, running
from sprung._report import Field, Report
from sprung._results import (
    Applied,
    Finding,
    LogUsed,
    Payload,
    PromisedErrors,
    Refinement,
    RigidJoint,
    SensedSpring,
    StandardParameter,
    Unknown,
)
from sprung._samples import Samples
from sprung._validation import Validation
from sprung._watch import Watch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung._arguments import Log
    from sprung._control import Control
    from sprung._curves import Curves
    from sprung._experiment import Experiment
    from sprung._plots import Plots

_FORMATS = ("urdf", "mjcf", "sdf", "json", "c", "rust")


class Result(Report):
    """An identification.

    Attributes of the first estimator stand here; `by` returns those of another one.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> result.estimator, result.verdict
        ('least-squares', 'good')
        >>> print(result.parameters["joint2.stiffness"])
        joint2.stiffness = 4.2... ± ... N·m/rad
        >>> [(finding.code, finding.evidence) for finding in result.findings if finding.severity in ("serious", "error")]
        []
        >>> log = result.logs[0]
        >>> log.samples, log.period_s, log.sampling, log.gaps, log.delay_s, log.sign, log.gain, log.window
        (10000, 0.001, 'even', 0, {}, {}, {}, None)
        >>> [f"{100 * joint.torque_error_nm / joint.torque_nm:.0f} %" for joint in result.promise]
        ['7 %', '13 %']

        The demo's model and its log are complete, both springs are visible, and it carries no payload:

        >>> result.applied, result.unknowns, result.payloads, list(result.standard_parameters)
        ([], [], [], [])
        >>> [joint.hold_out for joint in result.rigid_joints]
        []
        >>> [spring.stiffness_nm_per_rad for spring in result.sensed_springs]    # it has motor torques
        []

        A result of the refinement has its figures:

        >>> experiment = sprung.Experiment.demo({"identify.estimator": "prediction-error"})
        >>> refinement = experiment.identify(experiment.simulate()).refinement
        >>> refinement.used, refinement.converged, [rung.name for rung in refinement.rungs if rung.used]
        (True, True, ['free'])
        >>> refinement.held_out_residual.refined < refinement.held_out_residual.linear
        True
        >>> [disturbance.row for disturbance in refinement.disturbances if disturbance.at_bound]
        []
        >>> [offset.joint for offset in refinement.encoder_offsets]
        ['joint1', 'joint2']
        >>> max(abs(delay.delay_s) for delay in refinement.delays) < 1e-4    # the twin has no delay
        True
        >>> [noise.column for noise in refinement.sensor_noise]
        []
        >>> refinement.presliding_levels, refinement.stribeck_velocities, refinement.sharpnesses
        ([], [], [])
    """

    _type = "Identification"

    robot: Field[str] = Field()
    estimator: Field[str] = Field("results.estimator")
    verdict: Field[str] = Field("results.verdict")
    sentence: Field[str] = Field("results.decision.sentence")
    covariance_names: Field[list[str]] = Field("results.covariance.parameters")
    refinement: Field[Refinement | None] = Field("results.refinement")
    promise: Field[list[PromisedErrors]] = Field("results.promise")
    applied: Field[list[Applied]] = Field()
    unknowns: Field[list[Unknown]] = Field()
    payloads: Field[list[Payload]] = Field()
    rigid_joints: Field[list[RigidJoint]] = Field()
    sensed_springs: Field[list[SensedSpring]] = Field()
    _log: Field[LogUsed] = Field("log")
    _further_logs: Field[list[LogUsed]] = Field("further_logs")
    _standard_parameters: Field[list[StandardParameter]] = Field("results.standard_parameters")

    def __init__(
        self, handle: _sprung.Identified, experiment: Experiment, index: int = 0
    ) -> None:
        super().__init__(handle)
        self._experiment = experiment
        self._index = index

    @property
    def _result(self) -> dict[str, Any]:
        result: dict[str, Any] = self._contents["results"][self._index]
        return result

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self._experiment

    @property
    def estimators(self) -> list[str]:
        """Names of all estimators of the identification."""
        return [result["estimator"] for result in self._contents["results"]]

    def by(self, estimator: str) -> Result:
        """Returns the same identification, with the attributes of another estimator."""
        one_of("estimator", estimator, tuple(self.estimators))
        return Result(self._handle, self._experiment, self.estimators.index(estimator))

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters, by name."""
        return Parameters._of(self._result["parameters"])

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the logs and the result, the most severe first."""
        order = ["error", "serious", "warning", "info"]
        found = findings([*self._contents["findings"], *self._result["warnings"]])
        return sorted(found, key=lambda finding: order.index(finding.severity))

    @cached_property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the errors of the determined parameters, in the order of `covariance_names`.

        Its diagonal has the squares of the standard errors.
        """
        rows = (self._result.get("covariance") or {"values": []})["values"]
        matrix = np.zeros((len(rows), len(rows)))
        for i, row in enumerate(rows):
            matrix[i, : i + 1] = row
            matrix[: i + 1, i] = row
        return matrix

    @cached_property
    def logs(self) -> list[LogUsed]:
        """Figures of the logs."""
        return [self._log, *self._further_logs]

    @cached_property
    def standard_parameters(self) -> Named[StandardParameter]:
        """Inertial parameters of single links and rotors, by name; empty for ``planar-2r``."""
        return Named({one.name: one for one in self._standard_parameters}, "standard parameter")

    @property
    def residual_rms(self) -> Named[float]:
        """Root mean square residual of each row, N·m (N)."""
        return Named(self._result["residual_rms"], "row")

    @cached_property
    def model(self) -> Model:
        """The identified robot as functions of its motion."""
        return Model(self, self._index)

    @property
    def plot(self) -> Plots:
        """Plots by matplotlib, which the extra ``sprung[plot]`` installs."""
        from sprung._plots import Plots

        return Plots(self)

    @cached_property
    def trace(self) -> Named[Curves]:
        """Every parameter over growing parts of the log, by estimator and name; ``t`` has the time, s."""
        return curves(self._handle.trace(), "estimator")

    @cached_property
    def fit_curves(self) -> Named[Curves]:
        """Filtered torques and deflections over time, ``measured`` and by estimator; ``t`` has the time, s."""
        return curves(self._handle.fit(), "source")

    def validate(
        self, log: Log | None = None, *, threads: int = 0, progress: Progress = None
    ) -> Validation:
        """Predicts other logs with the identified model, and compares the errors with the promise.

        Args:
            log: nothing for the ``[[validate]]`` runs of the experiment; otherwise as for
                `Experiment.identify`, one run for each log. The controllers of the runs count in their order.
            threads, progress: as for `Experiment.identify`.

        Raises:
            LogError: if a log cannot be read, or was refused.
            ExperimentError: if columns of the experiment are missing in a log.

        Example:
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> result = experiment.identify(experiment.simulate())
            >>> result.validate(experiment.simulate(seed=7)).runs[0].sets[0].promise_kept
            True
        """
        session = self._experiment._session
        files, columns = given(log, session.log_columns)
        with running("validating", threads, progress) as run:
            return Validation(session.validate(self._handle, columns, files, run))

    def watch(
        self,
        log: Log | None = None,
        *,
        healthy: Log | None = None,
        false_alarms_per_h: float = 1.0,
        accept_unusable: bool = False,
        threads: int = 0,
        progress: Progress = None,
    ) -> Watch:
        """Watches logs of the running robot: contacts, changes, sensors that show nothing.

        Args:
            log: logs to watch, as for `Experiment.identify`; nothing to learn only the thresholds.
            healthy: columns of the healthy robot; the logs of the experiment if absent. Needed for a result of
                columns in memory.
            false_alarms_per_h: false alarms of all joints together that the thresholds promise.
            accept_unusable: whether a result whose verdict is ``unusable`` is taken.
            threads, progress: as for `Experiment.identify`.

        Raises:
            LogError: if a log cannot be read, or has another sampling rate than the healthy ones.
            InputError: if the number of false alarms is not positive.
        """
        if not false_alarms_per_h > 0.0:
            raise InputError(
                f"{false_alarms_per_h} false alarms per hour", "false_alarms_per_h", "give a positive number"
            )
        session, identified = self._experiment._session, (self._handle, self._index)
        files, columns = given(log, session.log_columns)
        paths, before = given(healthy, session.log_columns)
        if paths is not None or (before is not None and columns is None and log is not None):
            raise InputError(
                "healthy logs are files, or columns beside files to watch",
                "healthy",
                "give columns for both, or name the healthy logs in the experiment",
            )
        if before is not None and columns is None:
            columns = []
        request = (float(false_alarms_per_h), accept_unusable)
        with running("watching", threads, progress) as run:
            return Watch(session.watch(identified, columns, files, before, request, run))

    def score(
        self, log: Log | None = None, *, threads: int = 0, progress: Progress = None
    ) -> float:
        """Returns the part of the mean square of the motor torques that the model predicts on other logs.

        One for a perfect prediction, zero for a model that predicts no torque: the mean over joints and logs
        of ``1 - (error / torque)²``, of root mean squares of filtered torques. `validate` tells more.

        Args:
            log, threads, progress: as for `validate`.

        Raises:
            InputError: if a parameter has no value, so that nothing is predicted.
            LogError: if a log cannot be read, or was refused.
            ExperimentError: if columns of the experiment are missing in a log.

        Example:
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> result = experiment.identify(experiment.simulate())
            >>> result.score(experiment.simulate(seed=7)) > 0.98
            True
        """
        return self.validate(log, threads=threads, progress=progress).score(self.estimator)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung identify``: identification, parameters, trace, fit, report.

        Each file is written whole or not at all; ``identification.json`` comes last.
        """
        texts = {
            "parameters.csv": self._handle.parameters_csv(),
            "trace.csv": self._handle.trace_csv(),
            "fit.csv": self._handle.fit_csv(),
            "report.html": self._html(),
            "identification.json": self.to_json(),
        }
        return write_all(folder, texts)

    def export(
        self,
        format: str,
        folder: str | os.PathLike[str] | None = None,
        *,
        rigid: bool = False,
        control: Control | None = None,
        watch: Watch | None = None,
    ) -> dict[str, str]:
        """Returns the identified robot for simulators and controllers, and writes it to a folder.

        The values are those of the estimator of this result (`by`).

        Args:
            format: ``urdf``, ``mjcf``, ``sdf``, ``json``, ``c`` or ``rust``.
            folder: folder for the files; nothing is written if absent.
            rigid: whether to write rigid joints with armature instead of springs.
            control: a designed controller, which code in ``c`` or ``rust`` then contains.
            watch: a watch, whose observer of torques from outside code then contains.

        Returns:
            texts by file name.
        """
        one_of("format", format, _FORMATS)
        session, identified = self._experiment._session, (self._handle, self._index)
        beside = (
            None if control is None else control.to_json(),
            None if watch is None else watch.to_json(),
        )
        with running("exporting") as run:
            texts = dict(session.export(identified, format, rigid, beside, "identification.json", run))
        if folder is not None:
            write_all(folder, texts)
        return texts

    def sample(self, n: int, seed: int = 0, *, accept_unusable: bool = False) -> Samples:
        """Draws robots that can exist from the posterior of the identification.

        Args:
            n: number of robots, 1 to 100 000.
            seed: the same seed gives the same robots.
            accept_unusable: whether robots are drawn from a result whose verdict is ``unusable`` as well.

        Raises:
            ExperimentError: if the result is unusable or has no covariance, or no robot can exist.
            InputError: if ``n`` or ``seed`` is not a whole number from 0.

        Example:
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> result = experiment.identify(experiment.simulate())
            >>> result.sample(1000)
            <sprung.Samples: 1000 robots with 15 parameters>
        """
        whole("n", n)
        whole("seed", seed)
        session = self._experiment._session
        with running("drawing") as run:
            drawn = session.sample(self._handle, self._index, (n, seed), accept_unusable, run)
        return Samples._of(drawn, self, seed)

    def _html(self) -> str:
        page: str = self._handle.report(None)
        return page

    def __reduce__(self) -> tuple[Any, ...]:
        handle = self._handle
        parts = (handle.json(), handle.trace_csv(), handle.fit_csv(), handle.text)
        return _result, (parts, self._experiment, self._index)

    def __repr__(self) -> str:
        lines = "\n".join(f"  {parameter}" for parameter in self.parameters.values())
        return f"{self.sentence or self.verdict}\n{lines}"


def _result(parts: tuple[str, str, str, str], experiment: Experiment, index: int) -> Result:
    return Result(_sprung.Identified.of_parts(*parts), experiment, index)


def load(path: str | os.PathLike[str], experiment: Experiment) -> Result:
    """Reads an identification that the command line or `Result.save` wrote.

    Args:
        path: ``identification.json``, a folder of results, or the folder of an experiment.
        experiment: the experiment of the robot.

    Example:
        >>> import tempfile, sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     sprung.load(result.save(folder), experiment) == result
        True
    """
    handle, _ = _sprung.read_results(os.path.abspath(path), experiment.text)
    return Result(handle, experiment)
