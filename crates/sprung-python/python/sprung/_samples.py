"""Robots drawn from the posterior of an identification."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, SupportsIndex

import numpy as np

from sprung import _sprung
from sprung._arrays import WithArrays, fixed
from sprung._errors import one_of
from sprung._files import write_text
from sprung._mujoco import MujocoArrays
from sprung._named import Named
from sprung._progress import running

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung._result import Result

    Numbers = NDArray[np.float64]

#: Formats of files with one robot each, with the ends of their names.
_ENDS = {"mjcf": "xml", "urdf": "urdf", "sdf": "sdf", "json": "json"}

#: Robots whose values or files are in memory at the same time.
_PART = 256

#: Digits of the numbers in names of files, at least.
_DIGITS = 4


class SampledValues(Named[float]):
    """Values of one robot by the names of parameters, wherever values by name are taken.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> robot = experiment.identify(experiment.simulate()).sample(3)[0]
        >>> 9.0 < robot["joint1.stiffness"] < 10.0
        True
    """

    _kind = "parameter"

    def __init__(self, values: Mapping[str, float], result: Result | None = None) -> None:
        super().__init__(values)
        self._result = result

    def __hash__(self) -> int:
        return hash(frozenset(self._all.items()))

    def __repr__(self) -> str:
        return f"SampledValues({self._all!r})"


@dataclass(frozen=True, eq=False, repr=False)
class Bodies(WithArrays):
    """Bodies of the links of drawn robots, each in the frame of its link.

    Attributes:
        mass_kg: masses, kg, shape (robots, links).
        centre_of_mass_m: centres of mass, m, shape (robots, links, 3).
        inertia_kgm2: moments of inertia about the centres of mass, kg·m², shape (robots, links, 3, 3).
    """

    mass_kg: Numbers
    centre_of_mass_m: Numbers
    inertia_kgm2: Numbers

    def __repr__(self) -> str:
        robots, links = self.mass_kg.shape
        return f"<sprung.Bodies of {robots} robots with {links} links>"


@dataclass(frozen=True, eq=False, repr=False)
class Samples(WithArrays, Sequence[SampledValues]):
    """Robots that can exist, drawn from the posterior of an identification.

    ``len(samples)`` is their number, and ``samples[i]`` the values of one robot by name, with the
    constants of friction laws.

    Attributes:
        parameters: names of the parameters, given ones included.
        theta: their values in SI units, shape (robots, parameters).
        standard_parameters: names of the inertial parameters of single links, ten for each, then of the
            rotor inertias; empty for ``planar-2r``, whose parameters do not determine bodies.
        standard: their values, kg, kg·m, kg·m², shape (robots, standard parameters).
        links: names of the links; empty for ``planar-2r``.
        bodies: masses, centres of mass and inertias of the links; ``None`` for ``planar-2r``.
        undetermined: parameters that the log does not determine; their values come from nominal ones with
            their relative error.
        undetermined_standard: inertial parameters of single links whose values come from nominal or
            ordinary bodies, because the log removes at most a tenth of their variance.
        constants: constants of friction laws by name, equal in all robots.
        effective: number of independent robots that tell as much as all.
        seed: the random seed.

    Example:
        >>> import statistics
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> samples = result.sample(1000, seed=7)
        >>> samples.theta.shape
        (1000, 15)
        >>> stiffness = [robot["joint1.stiffness"] for robot in samples]
        >>> error = result.parameters["joint1.stiffness"].standard_error
        >>> 0.9 < statistics.stdev(stiffness) / error < 1.1
        True
        >>> samples.bodies is None                      # planar-2r determines no bodies
        True
    """

    parameters: list[str]
    theta: Numbers
    standard_parameters: list[str]
    standard: Numbers
    links: list[str]
    bodies: Bodies | None
    undetermined: list[str]
    undetermined_standard: list[str]
    constants: dict[str, float]
    effective: float
    seed: int
    _result: Result = field(compare=False)

    @classmethod
    def _of(cls, drawn: _sprung.Drawn, result: Result, seed: int) -> Samples:
        bodies = drawn.bodies()
        return cls(
            parameters=drawn.parameters,
            theta=fixed(drawn.theta()),
            standard_parameters=drawn.standard_parameters,
            standard=fixed(drawn.standard()),
            links=drawn.links,
            bodies=None if bodies is None else Bodies(*(fixed(array) for array in bodies)),
            undetermined=drawn.undetermined,
            undetermined_standard=drawn.undetermined_standard,
            constants=drawn.constants,
            effective=drawn.effective,
            seed=int(seed),
            _result=result,
        )

    def export(
        self, format: str, folder: str | os.PathLike[str], *, rigid: bool = False
    ) -> list[Path]:
        """Writes each robot to a file of its own, as `Result.export` writes the estimate.

        Each file is written whole or not at all. It names its draw and the seed in its head, and has no standard errors.

        Args:
            format: ``mjcf``, ``urdf``, ``sdf`` or ``json``.
            folder: folder for ``robot-0000.xml``, ``robot-0001.xml``, …; it is made if it does not exist.
            rigid: whether to write rigid joints with armature instead of springs.

        Returns:
            the paths, in the order of the robots.

        Raises:
            ExperimentError: if the format cannot hold the robot.
            FileError: if a file cannot be written; earlier ones are there.

        Example:
            >>> import tempfile
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> samples = experiment.identify(experiment.simulate()).sample(20)
            >>> with tempfile.TemporaryDirectory() as folder:
            ...     paths = samples.export("mjcf", folder)
            >>> paths[7].name
            'robot-0007.xml'
        """
        one_of("format", format, tuple(_ENDS))
        digits = max(_DIGITS, len(str(len(self) - 1)))
        result, paths = self._result, list[Path]()
        identified, session = (result._handle, result._index), result._experiment._session
        for first in range(0, len(self), _PART):
            robots, form = self._robots(first), (format, rigid)
            with running("exporting") as run:
                texts = _sprung.export_samples(
                    session, identified, robots, form, "identification.json", run
                )
            for robot, text in enumerate(texts, first):
                name = f"robot-{robot:0{digits}}.{_ENDS[format]}"
                paths.append(write_text(Path(folder) / name, text))
        return paths

    def to_mujoco(self, *, rigid: bool = False) -> MujocoArrays:
        """Returns the values of all robots as arrays by the fields of ``mujoco.MjModel``, for MuJoCo and MJX.

        Args:
            rigid: whether the joints are rigid with armature, as in ``result.export("mjcf", rigid=True)``.

        Raises:
            ExperimentError: if MJCF cannot hold the robot.

        Example:
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> samples = experiment.identify(experiment.simulate()).sample(100)
            >>> samples.to_mujoco().body_mass.shape     # the world, two links, two rotors
            (100, 5)
        """
        result = self._result
        identified, session = (result._handle, result._index), result._experiment._session
        parts = []
        for first in range(0, len(self), _PART):
            robots = self._robots(first)
            with running("exporting") as run:
                names, part = _sprung.mujoco_of_samples(session, identified, robots, rigid, run)
            parts.append(part)
        arrays = {name: fixed(np.concatenate([part[name] for part in parts])) for name in parts[0]}
        bodies, joints, tendons = names
        return MujocoArrays(bodies=bodies, joints=joints, tendons=tendons, **arrays)

    def to_dict(self) -> dict[str, Numbers]:
        """Returns the values of all robots as arrays by name, for environments in JAX or PyTorch.

        Every array has the robots along its first axis, is contiguous and may be written.

        Returns:
            each parameter, the inertia of each rotor and each constant of a friction law with the shape (robots,), and
            ``mass_kg`` (robots, links), ``centre_of_mass_m`` (robots, links, 3) and ``inertia_kgm2``
            (robots, links, 3, 3) of `bodies`, if there are some.

        Example:
            >>> import sprung
            >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
            >>> samples = experiment.identify(experiment.simulate()).sample(100)
            >>> arrays = samples.to_dict()
            >>> arrays["joint1.stiffness"].shape
            (100,)
        """
        arrays = {name: np.full(len(self), value) for name, value in self.constants.items()}
        for names, values in (
            (self.standard_parameters[10 * len(self.links) :], self.standard[:, 10 * len(self.links) :]),
            (self.parameters, self.theta),
        ):
            arrays |= {name: values[:, at].copy() for at, name in enumerate(names)}
        if self.bodies is not None:
            arrays["mass_kg"] = self.bodies.mass_kg.copy()
            arrays["centre_of_mass_m"] = self.bodies.centre_of_mass_m.copy()
            arrays["inertia_kgm2"] = self.bodies.inertia_kgm2.copy()
        return arrays

    def _robots(self, first: int) -> _sprung.Robots:
        """Returns robots from a number on for the extension module."""
        part = slice(first, first + _PART)
        return {
            "names": [*self.parameters, *self.standard_parameters],
            "values": np.hstack([self.theta[part], self.standard[part]]),
            "constants": self.constants,
            "draw": (first, len(self), self.seed),
        }

    def __len__(self) -> int:
        return len(self.theta)

    def __getitem__(self, index: SupportsIndex) -> SampledValues:  # type: ignore[override]
        count, place = len(self), operator.index(index)
        if not -count <= place < count:
            raise IndexError(f"there is no robot {place}; there are {count}")
        pairs = zip(self.parameters, self.theta[place].tolist(), strict=True)
        return SampledValues(self.constants | dict(pairs), self._result)

    def __repr__(self) -> str:
        return f"<sprung.Samples: {len(self)} robots with {len(self.parameters)} parameters>"
