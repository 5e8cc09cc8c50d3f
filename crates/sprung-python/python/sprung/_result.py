"""Results of checks, identifications, validations and comparisons."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sprung import _sprung
from sprung._errors import InputError, one_of, whole
from sprung._files import write_text
from sprung._finding import Finding, findings
from sprung._model import Model
from sprung._parameters import Parameter, Parameters
from sprung._samples import Samples

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung._control import Control
    from sprung._experiment import Experiment
    from sprung._plots import Plots

_FORMATS = ("urdf", "mjcf", "sdf", "json", "c", "rust")


class _Report:
    """What all results have: JSON and a report."""

    def _html(self) -> str:
        raise NotImplementedError

    def to_json(self) -> str:
        """Returns the text of the file that the command line writes."""
        raise NotImplementedError

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Writes the report, one HTML file that needs no other; returns its path."""
        return write_text(path, self._html())

    def _repr_html_(self) -> str:
        # The frame keeps the styles of the report and those of the notebook apart.
        page = html.escape(self._html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:640px;border:0"></iframe>'

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return isinstance(other, _Report) and bool(self._timeless() == other._timeless())

    def __hash__(self) -> int:
        return hash(json.dumps(self._timeless(), sort_keys=True))

    def _timeless(self) -> Any:
        return _without_times(json.loads(self.to_json()))


class Result(_Report):
    """An identification.

    Attributes of the first estimator stand here; `by` returns those of another one.
    """

    def __init__(
        self, handle: _sprung.Identified, experiment: Experiment, index: int = 0
    ) -> None:
        self._handle = handle
        self._experiment = experiment
        self._index = index

    @cached_property
    def identification(self) -> dict[str, Any]:
        """The contents of ``identification.json``."""
        own: dict[str, Any] = json.loads(self.to_json())
        return own

    @property
    def _result(self) -> dict[str, Any]:
        own: dict[str, Any] = self.identification["results"][self._index]
        return own

    @property
    def experiment(self) -> Experiment:
        """The experiment."""
        return self._experiment

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return str(self.identification["robot"])

    @property
    def estimator(self) -> str:
        """Name of the estimator."""
        return str(self._result["estimator"])

    @property
    def estimators(self) -> list[str]:
        """Names of all estimators of the identification."""
        return [own["estimator"] for own in self.identification["results"]]

    def by(self, estimator: str) -> Result:
        """Returns the same identification, with the attributes of another estimator."""
        one_of("estimator", estimator, tuple(self.estimators))
        return Result(self._handle, self._experiment, self.estimators.index(estimator))

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters, by name."""
        return Parameters([Parameter.of(own) for own in self._result["parameters"]])

    @property
    def verdict(self) -> str:
        """``good``, ``doubtful`` or ``unusable``."""
        return str(self._result["verdict"])

    @property
    def sentence(self) -> str:
        """The verdict in a sentence, with the errors that it promises."""
        return str(self._result["decision"]["sentence"])

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the logs and the result, the most severe first."""
        all_of = findings(json.loads(self._handle.findings(self._index)))
        order = ["error", "serious", "warning", "info"]
        return sorted(all_of, key=lambda finding: order.index(finding.severity))

    @property
    def covariance_names(self) -> list[str]:
        """Names of the parameters of the covariance, one per row."""
        return list((self._result.get("covariance") or {"parameters": []})["parameters"])

    @cached_property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the errors of the determined parameters, in the order of `covariance_names`.

        Its diagonal has the squares of the standard errors.
        """
        rows = (self._result.get("covariance") or {"values": []})["values"]
        own = np.zeros((len(rows), len(rows)))
        for i, row in enumerate(rows):
            own[i, : i + 1] = row
            own[: i + 1, i] = row
        return own

    @property
    def refinement(self) -> dict[str, Any] | None:
        """Figures of the refinement; ``None`` if the estimator has none."""
        own: dict[str, Any] | None = self._result.get("refinement")
        return own

    @property
    def promise(self) -> list[dict[str, Any]]:
        """Errors that the result promises for a new experiment of the same kind, by joint."""
        return list(self._result["promise"])

    @property
    def rigid_joints(self) -> list[dict[str, Any]]:
        """Joints whose spring the logs do not determine, each with a lower bound of its stiffness."""
        return list(self.identification.get("rigid_joints", []))

    @property
    def residual_rms(self) -> dict[str, float]:
        """Root mean square residual of each row, N·m (N)."""
        return dict(self._result["residual_rms"])

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
    def trace(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Every parameter over time, by estimator and name; ``t`` has the time, s."""
        return _sets(self._handle.trace())

    @cached_property
    def fit(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Filtered right-hand sides over time, measured and by estimator; ``t`` has the time, s."""
        return _sets(self._handle.fit())

    def to_json(self) -> str:
        """Returns the text of ``identification.json``."""
        return self._handle.json()

    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung identify``: identification, parameters, trace, fit, report.

        Each file is written whole or not at all; ``identification.json`` comes last.
        """
        folder = Path(folder)
        texts = {
            "parameters.csv": self._handle.parameters_csv(),
            "trace.csv": self._handle.trace_csv(),
            "fit.csv": self._handle.fit_csv(),
            "report.html": self._html(),
            "identification.json": self.to_json(),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
        return folder

    def export(
        self,
        format: str,
        folder: str | os.PathLike[str] | None = None,
        *,
        rigid: bool = False,
        control: Control | None = None,
    ) -> dict[str, str]:
        """Returns the identified robot for simulators and controllers, and writes it to a folder.

        The values are those of the estimator of this result (`by`).

        Args:
            format: ``urdf``, ``mjcf``, ``sdf``, ``json``, ``c`` or ``rust``.
            folder: folder for the files; nothing is written if absent.
            rigid: whether to write rigid joints with armature instead of springs.
            control: a designed controller, which code in ``c`` or ``rust`` then contains.

        Returns:
            texts by file name.
        """
        one_of("format", format, _FORMATS)
        run: _sprung.Run = {"threads": 0, "progress": None}
        session = self._experiment._session
        forms = (rigid, None if control is None else control.to_json())
        own = self._handle, self._index
        texts = dict(session.export(own, format, forms, "identification.json", run))
        if folder is not None:
            for name, text in texts.items():
                write_text(Path(folder) / name, text)
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
        run: _sprung.Run = {"threads": 0, "progress": None}
        session, draws = self._experiment._session, (n, seed)
        drawn = session.sample(self._handle, self._index, draws, accept_unusable, run)
        return Samples._of(drawn, self, seed)

    def _html(self) -> str:
        return self._handle.report(None)

    def __reduce__(self) -> tuple[Any, ...]:
        own = self._handle
        parts = (own.json(), own.trace_csv(), own.fit_csv(), own.text)
        return _result, (parts, self._experiment, self._index)

    def __repr__(self) -> str:
        lines = "\n".join(f"  {parameter}" for parameter in self.parameters.values())
        return f"{self.sentence or self.verdict}\n{lines}"


def _result(parts: tuple[str, str, str, str], experiment: Experiment, index: int) -> Result:
    return Result(_sprung.Identified.of_parts(*parts), experiment, index)


class _Pickled:
    """JSON and report of a result that came out of a pickle."""

    def __init__(self, json_text: str, page: str) -> None:
        self._json = json_text
        self._page = page

    def json(self) -> str:
        return self._json

    def report(self) -> str:
        return self._page


class Check(_Report):
    """A check of a log."""

    def __init__(self, handle: _sprung.Checked | _Pickled) -> None:
        self._handle = handle

    @cached_property
    def contents(self) -> dict[str, Any]:
        """The contents of ``check.json``."""
        own: dict[str, Any] = json.loads(self.to_json())
        return own

    @cached_property
    def findings(self) -> list[Finding]:
        """Findings about the log, with remedies."""
        return findings(self.contents["findings"])

    @property
    def refused(self) -> bool:
        """Whether `Experiment.identify` refuses the log."""
        return bool(self.contents["refused"])

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
    return Check(_Pickled(json_text, page))


class Validation(_Report):
    """Prediction errors on other logs beside the promised ones."""

    def __init__(self, handle: _sprung.Validated | _Pickled, sentence: str | None = None) -> None:
        self._handle = handle
        self._sentence = sentence

    @cached_property
    def contents(self) -> dict[str, Any]:
        """The contents of ``validation.json``."""
        own: dict[str, Any] = json.loads(self.to_json())
        return own

    @property
    def runs(self) -> list[dict[str, Any]]:
        """The runs, with the errors of each parameter set."""
        return list(self.contents["runs"])

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        if self._sentence is None and isinstance(self._handle, _sprung.Validated):
            self._sentence = self._handle.sentence()
        return self._sentence or ""

    @cached_property
    def signals(self) -> dict[str, dict[str, NDArray[np.float64]]]:
        """Measured and simulated signals by ``run/parameters``; empty after a pickle."""
        if isinstance(self._handle, _sprung.Validated):
            return _sets(self._handle.signals())
        return {}

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
    return Validation(_Pickled(json_text, page), sentence)


class Comparison(_Report):
    """Several identifications side by side."""

    def __init__(self, json_text: str, page: str, conclusion: list[str]) -> None:
        self._json = json_text
        self._page = page
        self.conclusion = conclusion

    @cached_property
    def contents(self) -> dict[str, Any]:
        """The contents of ``comparison.json``."""
        own: dict[str, Any] = json.loads(self._json)
        return own

    def to_json(self) -> str:
        """Returns the text of ``comparison.json``."""
        return self._json

    def _html(self) -> str:
        return self._page

    def __reduce__(self) -> tuple[Any, ...]:
        return Comparison, (self._json, self._page, self.conclusion)

    def __repr__(self) -> str:
        return "\n".join(self.conclusion)


def compare(results: Sequence[Result], labels: Sequence[str] | None = None) -> Comparison:
    """Compares identifications of one robot with the first one: estimators, settings, runs.

    Four or more results of different logs are tested for drift, in the order of the dates of the logs if all have
    one: ``contents["drift"]``, and sentences in ``conclusion``.

    Args:
        results: two or more identifications.
        labels: a name for each; ``result 1``, ``result 2`` if absent.

    Raises:
        ExperimentError: if they are of different robots, or share no parameters.
    """
    names = list(labels or (f"result {k}" for k in range(1, len(results) + 1)))
    if len(names) != len(results):
        raise InputError(
            f"{len(names)} labels for {len(results)} results", "labels", "give one for each"
        )
    given = [(name, own.to_json()) for name, own in zip(names, results, strict=True)]
    return Comparison(*_sprung.compare(given))


def load(path: str | os.PathLike[str], experiment: Experiment) -> Result:
    """Reads an identification that the command line or `Result.save` wrote.

    Args:
        path: ``identification.json``, a folder of results, or the folder of an experiment.
        experiment: the experiment of the robot.
    """
    handle, _ = _sprung.read_results(os.path.abspath(path), experiment.text)
    return Result(handle, experiment)


def _sets(
    given: list[tuple[str, Any, list[tuple[str, Any]]]],
) -> dict[str, dict[str, NDArray[np.float64]]]:
    return {label: {"t": time, **dict(values)} for label, time, values in given}


def _without_times(value: Any) -> Any:
    """Returns JSON without computing times, which differ between equal runs."""
    if isinstance(value, dict):
        return {name: _without_times(own) for name, own in value.items() if name != "elapsed_s"}
    if isinstance(value, list):
        return [_without_times(own) for own in value]
    return value
