"""Experiments: a robot, its log, and the settings of the identification."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sprung import _sprung
from sprung._arguments import (
    Log,
    Overrides,
    Table,
    Values,
    assignments,
    path_of,
    plain,
    session_of,
    values_of,
)
from sprung._check import Check
from sprung._columns import Named, given
from sprung._control import Control
from sprung._errors import ExperimentError, InputError, SprungWarning, findings, one_of, warn, warn_of
from sprung._excitation import Excitation
from sprung._files import write_text
from sprung._progress import Progress, running
from sprung._result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

_METHODS = ("optimal", "paper", "random")


class Experiment:
    """A robot, its log, and the settings of the identification.

    Args:
        source: path of ``experiment.toml`` or of its folder, or a dict with the same tables.
        overrides: keys of the experiment and their values, as ``--set`` of the command line.
        folder: folder to which the paths in a dict are relative; the working folder if absent.

    Raises:
        ExperimentError: if the experiment is wrong; ``place`` names the line.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment(
        ...     {
        ...         "format": 1,
        ...         "robot": {
        ...             "name": "two joints in a plane",
        ...             "kinematics": "planar-2r",
        ...             "joint": [{"name": "shoulder"}, {"name": "elbow"}],
        ...         },
        ...     }
        ... )
        >>> experiment.joints
        ['shoulder', 'elbow']
    """

    def __init__(
        self,
        source: str | os.PathLike[str] | Table,
        overrides: Overrides = (),
        *,
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        settings = assignments(overrides)
        if isinstance(source, Mapping):
            text = _sprung.toml_of_json(json.dumps(source, default=plain))
            place = os.path.abspath(folder or os.curdir)
            self._become(("text", "experiment", text, place), settings)
        else:
            if folder is not None:
                raise InputError(
                    "folder belongs to an experiment from a dict", "folder", "leave it out"
                )
            self._become(("file", os.path.abspath(source)), settings)

    def _become(self, origin: tuple[str, ...], overrides: list[str]) -> None:
        self._origin = origin
        self._overrides = overrides
        self._session = session_of(origin, overrides)

    @classmethod
    def _of(cls, origin: tuple[str, ...], overrides: list[str]) -> Experiment:
        experiment = cls.__new__(cls)
        experiment._become(origin, overrides)
        return experiment

    def _with(self, overrides: Overrides) -> Experiment:
        settings = assignments(overrides)
        return Experiment._of(self._origin, [*self._overrides, *settings]) if settings else self

    @classmethod
    def from_text(
        cls,
        text: str,
        overrides: Overrides = (),
        *,
        folder: str | os.PathLike[str] | None = None,
        name: str = "experiment",
    ) -> Experiment:
        """Returns an experiment from the text of an ``experiment.toml``."""
        place = os.path.abspath(folder or os.curdir)
        return cls._of(("text", name, text, place), assignments(overrides))

    @classmethod
    def demo(cls, overrides: Overrides = ()) -> Experiment:
        """Returns the paper's experiment, with a digital twin that `simulate` runs."""
        return cls._of(("demo",), assignments(overrides))

    @classmethod
    def from_urdf(
        cls,
        urdf: str | os.PathLike[str],
        joints: Sequence[str] | Mapping[str, Table] | None = None,
        log: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] | None = None,
        overrides: Overrides = (),
        *,
        progress: Progress = None,
    ) -> Experiment:
        """Returns the experiment of a robot with a URDF.

        Args:
            urdf: its URDF.
            joints: names of the joints to identify, or a table of ``[[robot.joint]]`` for each, for
                example ``{"elbow": {"transmission": "rigid"}}``; all joints that move if absent.
            log: logs in which sprung looks for the columns; without it, `identify` takes arrays.
            overrides: keys of the experiment and their values.
            progress: as for `identify`.

        Raises:
            ExperimentError: if a joint is not in the URDF, or if values are missing that only you
                know; the message names them.
        """
        path = Path(os.path.abspath(urdf))
        if log is not None:
            logs = [log] if isinstance(log, str | os.PathLike) else list(log)
            experiment = cls.from_log(logs, urdf=path, overrides=overrides, progress=progress)
            if joints is None:
                return experiment
            raise InputError("joints and log are both given", "joints", "give one of them")
        known = _sprung.joints_of_urdf(path)
        tables: Mapping[str, Table]
        tables = joints if isinstance(joints, Mapping) else dict.fromkeys(joints or known, {})
        unknown = [name for name in tables if name not in known]
        if unknown:
            raise ExperimentError(
                f"{path} has no joint {unknown[0]!r} that moves",
                "usage",
                f"give some of {', '.join(known)}",
                str(path),
            )
        description = {
            "format": 1,
            "robot": {
                "name": path.stem,
                "urdf": str(path),
                "joint": [{"name": name, **tables[name]} for name in known if name in tables],
            },
        }
        return cls(description, overrides, folder=path.parent)

    @classmethod
    def from_log(
        cls,
        log: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
        *,
        urdf: str | os.PathLike[str] | None = None,
        joints: int | None = None,
        topics: str | None = None,
        overrides: Overrides = (),
        progress: Progress = None,
    ) -> Experiment:
        """Returns an experiment whose columns sprung chose by their names and contents.

        Args:
            log: the log, or several logs with the same columns.
            urdf: URDF of the robot; a table of Denavit and Hartenberg if absent.
            joints: number of joints if the names of the columns do not tell.
            topics: beginning of the topics of a bag that belong to the robot; all topics if absent.
            overrides: keys of the experiment and their values, for example those that only you know.
            progress: as for `identify`.

        Raises:
            ExperimentError: if values are missing that only you know; ``place`` names the line.
        """
        logs = [log] if isinstance(log, str | os.PathLike) else list(log)
        paths = [Path(os.path.abspath(one)) for one in logs]
        folder = Path(os.path.abspath(os.curdir))
        with running("reading the log", progress=progress) as run:
            text, found = _sprung.experiment_from_log(
                paths,
                None if urdf is None else Path(os.path.abspath(urdf)),
                joints,
                topics,
                folder,
                run,
            )
        warn(*map(SprungWarning.of, findings(found)))
        return cls.from_text(text, overrides, folder=folder)

    @property
    def text(self) -> str:
        """Text of the experiment file."""
        return self._session.text

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return self._session.robot

    @property
    def joints(self) -> list[str]:
        """Names of the joints."""
        return self._session.joints

    @property
    def parameter_units(self) -> dict[str, str]:
        """Units of the parameters of the model, by name."""
        return dict(self._session.parameters)

    @property
    def log_columns(self) -> list[str]:
        """Names of the columns that ``[log]`` names, the time first."""
        return self._session.log_columns

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the experiment file, without the overrides; returns its path."""
        return write_text(path, self.text)

    def check(
        self,
        log: Log | None = None,
        *,
        threads: int = 0,
        progress: Progress = None,
    ) -> Check:
        """Checks a log before any fit: rate, units, signs, delays, faults.

        Args:
            log, threads, progress: as for `identify`.

        Raises:
            LogError: if the log cannot be read. A faulty log is not an error: the check has findings.
        """
        session, logs = self._given(log)
        with running("checking", threads, progress) as run:
            return Check(session.check(logs, run))

    def identify(
        self,
        log: Log | None = None,
        *,
        laws_from: Sequence[Result] = (),
        threads: int = 0,
        progress: Progress = None,
    ) -> Result:
        """Identifies the parameters.

        Args:
            log: nothing for the logs that the experiment names; a path or several paths; or columns
                in memory: a dict of arrays, a DataFrame of pandas or polars, a table of Arrow, or a
                list of these. The names are columns that ``[log]`` names, or quantities:
                ``t`` in s, ``q`` (link positions) and ``phi`` (motor positions after the gear) in rad
                or m, ``tau`` (motor torques after the gear) and ``tau_joint`` in N·m or N, each with
                the shape (samples, joints); or keys of ``[log]``, such as ``motor_current_a``.
            laws_from: earlier results of this robot; the model gets the laws that they found, the union of
                all, and no others. So results of several logs have one model.
            threads: number of threads; 0 for one per processor. Results do not depend on it.
            progress: callback with phase, work done and total; it stops the run by returning
                ``False``. ``True`` shows a bar of tqdm, as notebooks do without it.

        Returns:
            The result, with a Python warning for each warning about it.

        Raises:
            LogError: if the log cannot be read, or was refused.
            ExperimentError: if columns or settings are wrong.
            Stopped: if the callback stopped the run.
        """
        session, logs = self._given(log)
        if laws_from:
            session = session.with_laws_from([earlier._handle for earlier in laws_from])
        with running("identifying", threads, progress) as run:
            result = Result(session.identify(logs, run), self)
        warn_of(result.findings)
        return result

    def simulate(
        self,
        run: str | None = None,
        *,
        result: Values | None = None,
        seed: int | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> dict[str, NDArray[np.float64]]:
        """Simulates the log of the digital twin that ``[simulate]`` describes.

        Args:
            run: name of a ``[[validate]]`` run whose controller and columns replace the experiment's.
            result: parameters of the twin: a result, a drawn robot, a dict of values by name, or a file of
                values; those of ``[simulate]`` if absent.
            seed: seed of encoder phases and noise.
            threads, progress: as for `identify`.

        Returns:
            Columns by name, each with the shape (samples,).
        """
        values = None if result is None else values_of(result, with_laws=True)
        with running("simulating", threads, progress) as settings:
            return self._session.simulate(run, values, seed, settings)

    def excite(
        self,
        *,
        method: str = "optimal",
        warm_up: bool = False,
        parameters: Values | None = None,
        from_log: str | os.PathLike[str] | None = None,
        reference: str | os.PathLike[str] | None = None,
        threads: int = 0,
        progress: Progress = None,
    ) -> Excitation:
        """Designs an experiment: a motion within the limits of the robot that determines its parameters
        best, and the standard errors that it promises.

        Args:
            method: ``optimal`` for a search with the settings of ``[excite]``; ``paper`` for the
                reference of the paper, ``random`` for a random motion, both judged without a search.
            warm_up: whether the robot is unknown, and a first small motion is wanted.
            parameters: values for which the motion is designed: a result, ``identification.json`` or
                a TOML file of values, or a dict of values by name; the nominal values if absent.
            from_log: path of a recorded log, beside which the new motion counts.
            reference: path of a file with a ``[controller.reference]``, whose motion is judged instead
                of a new one.
            threads: number of threads; 0 for one per processor. Results do not depend on it.
            progress: callback with phase, work done and total; it ends the search by returning
                ``False``, and the best motion so far is returned. ``True`` shows a bar of tqdm.

        Returns:
            The motion, how near it comes to each limit, and its promise.

        Raises:
            ExperimentError: if limits or values are missing, or no motion keeps the limits.
            LogError: if the recorded log cannot be read.
            FileError: if the file of the values cannot be read.
        """
        one_of("method", method, _METHODS)
        values = None if parameters is None else values_of(parameters)
        log = None if from_log is None else path_of("from_log", from_log, "give the path of a log")
        motion = None if reference is None else path_of("reference", reference, "give the path of a file")
        with running("designing", threads, progress) as run:
            files = (log, motion)
            return Excitation(self._session.excite(method, warm_up, values, files, run))

    def control(
        self,
        parameters: Values,
        *,
        accept_unusable: bool = False,
        threads: int = 0,
        progress: Progress = None,
    ) -> Control:
        """Designs a controller for an identified robot with the settings of ``[control]``, and proves it on
        robots from the posterior.

        Args:
            parameters: a result, ``identification.json`` or a TOML file of values, or a dict of values by
                name; values that come from no identification count as exact.
            accept_unusable: whether a result whose verdict is ``unusable`` counts.
            threads, progress: as for `identify`.

        Returns:
            The controller, its margins, the vibrations, the input shaper, and what simulations show.

        Raises:
            ExperimentError: if settings do not fit the robot, no controller keeps margins and limits, or the
                result is unusable.
            FileError: if the file of the values cannot be read.
            Stopped: if the callback stopped the run.
        """
        values = values_of(parameters)
        with running("designing", threads, progress) as run:
            return Control(self._session.control(values, accept_unusable, run))

    def truth(self) -> dict[str, float]:
        """Returns the true parameters of the digital twin, by name."""
        return self._session.truth()

    def _given(self, log: Log | None) -> tuple[_sprung.Session, list[Named] | None]:
        """Returns the session and the logs in memory, if there are any."""
        paths, columns = given(log, self._session.log_columns)
        if paths:
            overrides = [*self._overrides, f"log.file={json.dumps(paths)}"]
            return session_of(self._origin, overrides), None
        return self._session, columns

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Experiment):
            return NotImplemented
        return (self.text, self._overrides) == (other.text, other._overrides)

    def __hash__(self) -> int:
        return hash((self.text, *self._overrides))

    def __reduce__(self) -> tuple[Any, ...]:
        return Experiment._of, (self._origin, self._overrides)

    def __repr__(self) -> str:
        return f"<sprung.Experiment of {self.robot!r}: {', '.join(self.joints)}>"
