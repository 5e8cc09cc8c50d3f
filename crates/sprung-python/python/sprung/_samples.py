"""Robots drawn from the posterior of an identification."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, SupportsIndex

import numpy as np

from sprung._named import Named

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung import _sprung

    Numbers = NDArray[np.float64]


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

    def __hash__(self) -> int:
        return hash(frozenset(self._all.items()))

    def __repr__(self) -> str:
        return f"SampledValues({self._all!r})"


@dataclass(frozen=True, eq=False, repr=False)
class Bodies:
    """Bodies of the links of drawn robots, each in the frame of its link.

    Attributes:
        mass_kg: masses, kg, shape (robots, links).
        centre_of_mass_m: centres of mass, m, shape (robots, links, 3).
        inertia_kgm2: moments of inertia about the centres of mass, kg·m², shape (robots, links, 3, 3).
    """

    mass_kg: Numbers
    centre_of_mass_m: Numbers
    inertia_kgm2: Numbers

    def _parts(self) -> tuple[Numbers, Numbers, Numbers]:
        return self.mass_kg, self.centre_of_mass_m, self.inertia_kgm2

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Bodies):
            return NotImplemented
        both = zip(self._parts(), other._parts(), strict=True)
        return all(np.array_equal(a, b) for a, b in both)

    def __hash__(self) -> int:
        return hash(self.mass_kg.tobytes())

    def __repr__(self) -> str:
        robots, links = self.mass_kg.shape
        return f"<sprung.Bodies of {robots} robots with {links} links>"


@dataclass(frozen=True, eq=False, repr=False)
class Samples(Sequence[SampledValues]):
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

    @classmethod
    def _of(cls, drawn: _sprung.Drawn) -> Samples:
        bodies = drawn.bodies()
        return cls(
            parameters=drawn.parameters,
            theta=_fixed(drawn.theta()),
            standard_parameters=drawn.standard_parameters,
            standard=_fixed(drawn.standard()),
            links=drawn.links,
            bodies=None if bodies is None else Bodies(*(_fixed(own) for own in bodies)),
            undetermined=drawn.undetermined,
            undetermined_standard=drawn.undetermined_standard,
            constants=drawn.constants,
            effective=drawn.effective,
        )

    def __len__(self) -> int:
        return len(self.theta)

    def __getitem__(self, index: SupportsIndex) -> SampledValues:  # type: ignore[override]
        count, place = len(self), operator.index(index)
        if not -count <= place < count:
            raise IndexError(f"there is no robot {place}; there are {count}")
        own = zip(self.parameters, self.theta[place].tolist(), strict=True)
        return SampledValues(self.constants | dict(own))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Samples):
            return NotImplemented
        arrays = ((self.theta, other.theta), (self.standard, other.standard))
        return self._rest() == other._rest() and all(np.array_equal(a, b) for a, b in arrays)

    def __hash__(self) -> int:
        return hash(self.theta.tobytes())

    def _rest(self) -> tuple[object, ...]:
        names = (self.parameters, self.standard_parameters, self.links)
        lacking = (self.undetermined, self.undetermined_standard)
        return names, lacking, self.bodies, self.constants, self.effective

    def __repr__(self) -> str:
        return f"<sprung.Samples: {len(self)} robots with {len(self.parameters)} parameters>"


def _fixed(own: Numbers) -> Numbers:
    own.flags.writeable = False
    return own
