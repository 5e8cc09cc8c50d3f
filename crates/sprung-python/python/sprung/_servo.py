"""Position servos, whose logs have targets and positions and no torque."""

from __future__ import annotations

import json
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sprung import _sprung
from sprung._errors import ExperimentError, findings, warn_of
from sprung._arguments import Log, Overrides, Table, assignments
from sprung._experiment import Experiment
from sprung._files import write_all
from sprung._named import Named
from sprung._parameters import Parameter, Parameters
from sprung._progress import Progress, running
from sprung._report import Field, Report
from sprung._results import Finding, ServoErrors, ServoLog

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Servo:
    """A position servo on a pendulum, its logs, and its digital twin.

    Args:
        source: path of ``experiment.toml`` or of its folder, a dict with the same tables, or an
            `Experiment`.
        overrides: keys of the experiment and their values, as ``--set`` of the command line.
        folder: folder to which the paths in a dict are relative; the working folder if absent.

    Raises:
        ExperimentError: if the experiment is wrong or describes no servo.

    Example:
        >>> import sprung
        >>> servo = sprung.Servo.demo({"simulate.duration_s": 16.0})
        >>> logs = servo.simulate()                             # one for each known mass
        >>> servo.check(logs).least_errors["servo.armature"] < 1e-4
        True
        >>> result = servo.identify(logs)
        >>> print(result.parameters["servo.armature"])
        servo.armature = 0.02... ± ... kg·m²
        >>> result.scale, result.usable, [round(log.load_torque_nm, 2) for log in result.logs]
        ('known-load', True, [2.06, 5.98])
        >>> result.braking.value > result.braking.standard_error
        True
        >>> result.position_errors.position_rms_over_noise < 1.5
        True
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Table | Experiment,
        overrides: Overrides = (),
        *,
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        if isinstance(source, Experiment):
            self._experiment = source._with(overrides)
        else:
            self._experiment = Experiment(source, overrides, folder=folder)
        if not self._experiment._session.is_servo:
            raise ExperimentError(
                f"{self._experiment.robot} is no position servo",
                "no-servo",
                "use sprung.Experiment, or add [robot.joint.servo] to its joint",
            )

    @classmethod
    def demo(cls, overrides: Overrides = ()) -> Servo:
        """Returns a servo on a pendulum with two known masses, and its digital twin."""
        return cls(Experiment._of(("demo-servo",), assignments(overrides)))

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self._experiment

    def check(
        self, log: Log | None = None, *, threads: int = 0, progress: Progress = None
    ) -> ServoCheck:
        """Tells before any fit which parameters the logs determine.

        Args:
            log, threads, progress: as for `identify`.

        Raises:
            LogError: if a log cannot be read.
        """
        session, logs = self._experiment._given(log)
        with running("checking", threads, progress) as run:
            return ServoCheck(session.check_servo(logs, run))

    def identify(
        self, log: Log | None = None, *, threads: int = 0, progress: Progress = None
    ) -> ServoResult:
        """Identifies the parameters.

        Args:
            log: nothing for the logs that the experiment names; otherwise columns in memory with
                the names of ``[log]``, or paths, as for `Experiment.identify`. Payloads belong to the
                files that the experiment names: give columns for each of them, in their order.
            threads, progress: as for `Experiment.identify`.

        Returns:
            The result, with a Python warning for each warning about it.

        Raises:
            LogError: if a log cannot be read, or the servo does not move in it.
            ExperimentError: if columns or settings are wrong.
            Stopped: if the callback stopped the run.
        """
        session, logs = self._experiment._given(log)
        with running("identifying", threads, progress) as run:
            result = ServoResult(session.identify_servo(logs, run))
        warn_of(result.findings)
        return result

    def simulate(
        self,
        *,
        result: ServoResult | None = None,
        seed: int | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> list[dict[str, NDArray[np.float64]]]:
        """Simulates the logs of the digital twin that ``[simulate]`` describes.

        Args:
            result: identification with the parameters of the twin; ``[simulate]`` if absent.
            seed: seed of encoder phases and disturbances.
            threads, progress: as for `identify`.

        Returns:
            a log for each file of the experiment: columns by name, each with the shape (samples,).
        """
        handle = None if result is None else result._identified()
        with running("simulating", threads, progress) as run:
            logs = self._experiment._session.simulate_servo(handle, seed, run)
        return [columns for _, columns in logs]

    def truth(self) -> dict[str, float]:
        """Returns the true parameters of the digital twin, by name."""
        return self._experiment._session.truth_of_servo()

    def __repr__(self) -> str:
        return f"<sprung.Servo of {self._experiment.robot!r}>"


class ServoResult(Report):
    """The identified parameters of a position servo."""

    _type = "ServoIdentification"
    _kept = ("json", "report", "parameters_csv")

    joint: Field[str] = Field()
    braking: Field[Parameter] = Field()
    scale: Field[str] = Field()
    position_errors: Field[ServoErrors] = Field("fit")
    logs: Field[list[ServoLog]] = Field()
    findings: Field[list[Finding]] = Field()

    def _identified(self) -> _sprung.IdentifiedServo:
        if isinstance(self._handle, _sprung.IdentifiedServo):
            return self._handle
        raise ExperimentError(
            "this result came out of a pickle, which has no parameters for a twin",
            "servo-pickled",
            "identify again",
        )

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters, by name."""
        return Parameters._of(self._contents["parameters"])

    @property
    def usable(self) -> bool:
        """Whether no finding is serious."""
        return all(finding.severity not in ("serious", "error") for finding in self.findings)

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung identify``: result, parameters, report."""
        texts = {
            "parameters.csv": self._handle.parameters_csv(),
            "report.html": self._html(),
            "servo.json": self.to_json(),
        }
        return write_all(folder, texts)

    def __repr__(self) -> str:
        return "\n".join(f"  {parameter}" for parameter in self.parameters.values())


class ServoCheck:
    """What the logs of a servo can tell, before any fit."""

    def __init__(self, json_text: str) -> None:
        self._json = json_text

    @cached_property
    def _contents(self) -> dict[str, Any]:
        contents: dict[str, Any] = json.loads(self._json)
        return contents

    @property
    def least_errors(self) -> Named[float | None]:
        """Smallest standard error of each parameter; ``None`` if it is given or not determined."""
        errors = {one["name"]: one["least_error"] for one in self._contents["parameters"]}
        return Named(errors, "parameter")

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the logs, with remedies."""
        return findings(self._contents["findings"])

    def to_json(self) -> str:
        """Returns the text of ``servo-check.json``."""
        return self._json

    def __repr__(self) -> str:
        return "\n".join(map(str, self.findings)) or "no findings"
