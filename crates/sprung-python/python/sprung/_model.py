"""The identified robot as functions of its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sprung._errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from sprung import _sprung

    Numbers = NDArray[np.float64]


class Torques(NamedTuple):
    """Torques on the links and of the motors, each with the shape of the motion, N·m (N)."""

    link: Numbers
    motor: Numbers


class Accelerations(NamedTuple):
    """Accelerations of links and motors, each with the shape of the motion, rad/s² (m/s²)."""

    ddq: Numbers
    ddphi: Numbers


@dataclass(frozen=True)
class Motion:
    """A simulated motion.

    Attributes:
        t: times, s, shape (samples,).
        q, dq: positions and velocities of the links, rad, rad/s, shape (samples, joints).
        phi, dphi: positions and velocities of the motors after the gear, of the same shape.
    """

    t: Numbers
    q: Numbers
    dq: Numbers
    phi: Numbers
    dphi: Numbers


class Model:
    """The identified robot: torques, masses and accelerations of a motion.

    All functions take one state of shape (joints,) or many of shape (samples, joints), in SI units:
    rad, N·m; m, N for prismatic joints. ``phi`` is the position of the motor after the gear; where it
    is absent, the springs are not stretched: ``phi = q``. The motor of a rigid joint moves with its
    link, whatever ``phi`` is.

    Example:
        The torque of a motion is the regressor times the parameters.

        >>> import numpy as np
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> model = result.model
        >>> motion = [0.1, 0.2], [1.0, -1.0], [5.0, 0.0]
        >>> torques = np.hstack(model.predict(*motion))
        >>> theta = np.array(list(model.parameters.values()))
        >>> bool(np.allclose(model.regressor(*motion) @ theta, torques))
        True
        >>> bool(np.all(np.linalg.eigvalsh(model.mass_matrix([0.1, 0.2])) > 0.0))
        True
        >>> model.predict(*motion).motor.shape
        (2,)
        >>> accelerations = model.forward_dynamics([0.0, 0.0], [0.0, 0.0], [1.0, 0.0])
        >>> bool(accelerations.ddphi[0] > 0.0)
        True
        >>> simulated = model.simulate([[3.0, 0.0]] * 100, 0.001, q=[0.0, 0.0])
        >>> simulated.q.shape, bool(simulated.phi[-1, 0] > 0.0)
        ((101, 2), True)
    """

    def __init__(self, result: Any, index: int) -> None:
        self._result = result
        self._index = index
        session = result._experiment._session
        self._dynamics: _sprung.Dynamics = session.dynamics(result._handle, index)

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters, by name, in the order of the columns of the regressor."""
        return dict(self._dynamics.parameters)

    @property
    def rows(self) -> list[str]:
        """Names of the rows of regressor and mass matrix: links, then motors of flexible joints."""
        return self._dynamics.rows

    def gravity(self, q: ArrayLike) -> Numbers:
        """Returns the torques that hold the links against gravity, shape of q, N·m."""
        one, (positions,) = self._states(q=q)
        return self._shaped(one, self._dynamics.gravity(positions))

    def coriolis_torques(self, q: ArrayLike, dq: ArrayLike) -> Numbers:
        """Returns the Coriolis and centrifugal torques ``C(q, dq) dq`` of the links, shape of q, N·m."""
        one, state = self._states(q=q, dq=dq)
        return self._shaped(one, self._dynamics.coriolis_torques(*state))

    def mass_matrix(self, q: ArrayLike) -> Numbers:
        """Returns the mass matrix of links and rotors.

        Returns:
            shape (rows, rows), or (samples, rows, rows); kg·m².
        """
        one, (positions,) = self._states(q=q)
        rows = len(self.rows)
        found = self._dynamics.mass_matrix(positions).reshape(-1, rows, rows)
        return self._shaped(one, found)

    def friction(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        phi: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
    ) -> Torques:
        """Returns the friction torques against the motion of links and motors, N·m."""
        one, motion = self._motion(q, dq, phi, dphi)
        return Torques(*self._halves(one, self._dynamics.friction(motion)))

    def spring(
        self,
        q: ArrayLike,
        phi: ArrayLike,
        dq: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
    ) -> Numbers:
        """Returns the torques of the springs on the links, N·m; zero at rigid joints."""
        q = np.asarray(q, dtype=float)
        zeros = np.zeros_like(q)
        one, motion = self._motion(
            q, zeros if dq is None else dq, phi, zeros if dphi is None else dphi
        )
        return self._shaped(one, self._dynamics.spring(motion))

    def predict(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike,
        phi: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
        ddphi: ArrayLike | None = None,
    ) -> Torques:
        """Predicts the torques of a motion: on the links from outside, and of the motors, N·m.

        Args:
            q, dq, ddq: positions, velocities and accelerations of the links.
            phi, dphi, ddphi: those of the motors after the gear; those of the links if absent.

        Source: eq. (1) of the paper.
        """
        one, motion = self._motion(q, dq, phi, dphi, ddq, ddq if ddphi is None else ddphi)
        return Torques(*self._halves(one, self._dynamics.predict(motion)))

    def regressor(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        ddq: ArrayLike,
        phi: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
        ddphi: ArrayLike | None = None,
    ) -> Numbers:
        """Returns the matrix whose product with the parameters is the torque on each row.

        Returns:
            shape (rows, parameters), or (samples, rows, parameters).

        Source: eqs. (1), (5) and (6) of the paper.
        """
        one, motion = self._motion(q, dq, phi, dphi, ddq, ddq if ddphi is None else ddphi)
        rows, parameters = len(self.rows), len(self._dynamics.parameters)
        found = self._dynamics.regressor(motion).reshape(-1, rows, parameters)
        return self._shaped(one, found)

    def forward_dynamics(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        tau: ArrayLike,
        phi: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
        tau_link: ArrayLike | None = None,
    ) -> Accelerations:
        """Returns the accelerations that motor torques, and torques on the links, cause.

        Args:
            tau: motor torques after the gear, N·m.
            tau_link: torques on the links from outside, N·m; zero if absent.

        Returns:
            NaN where the mass matrix is not positive definite.
        """
        if tau_link is None:
            tau_link = np.zeros_like(np.asarray(tau, dtype=float))
        one, motion = self._motion(q, dq, phi, dphi, tau, tau_link)
        return Accelerations(*self._halves(one, self._dynamics.forward_dynamics(motion)))

    def simulate(
        self,
        tau: ArrayLike,
        period_s: float,
        *,
        q: ArrayLike,
        dq: ArrayLike | None = None,
        phi: ArrayLike | None = None,
        dphi: ArrayLike | None = None,
    ) -> Motion:
        """Simulates a motion; torques are constant over each period.

        Args:
            tau: motor torques of each period, shape (periods, joints), N·m.
            period_s: period, s.
            q, dq, phi, dphi: state at the beginning; at rest and with free springs if absent.

        Returns:
            states at the beginning of each period, and the last one.

        Raises:
            InputError: if the motion grows without bound.
        """
        torques = np.asarray(tau, dtype=float)
        n = self._dynamics.joints
        if torques.ndim != 2 or torques.shape[1] != n:
            raise InputError(
                f"tau has the shape {torques.shape}", "shape", f"give (periods, {n})"
            )
        if not (np.isfinite(period_s) and period_s > 0):
            raise InputError(f"period_s = {period_s}", "period", "give a positive number")
        start = [self._one(name, value) for name, value in [("q", q), ("dq", dq)]]
        start.append(start[0] if phi is None else self._one("phi", phi))
        start.append(start[1] if dphi is None else self._one("dphi", dphi))
        found = self._dynamics.simulate(start, np.ascontiguousarray(torques), float(period_s))
        t = np.arange(found.shape[1], dtype=np.float64) * np.float64(period_s)
        return Motion(t, found[0], found[1], found[2], found[3])

    def _one(self, name: str, value: ArrayLike | None) -> list[float]:
        n = self._dynamics.joints
        array = np.zeros(n) if value is None else np.asarray(value, dtype=float)
        if array.shape != (n,):
            raise InputError(f"{name} has the shape {array.shape}", "shape", f"give ({n},)")
        return [float(x) for x in array]

    def _motion(
        self,
        q: ArrayLike,
        dq: ArrayLike,
        phi: ArrayLike | None,
        dphi: ArrayLike | None,
        *more: ArrayLike,
    ) -> tuple[bool, list[Numbers]]:
        given: dict[str, ArrayLike] = {
            "q": q,
            "dq": dq,
            "phi": q if phi is None else phi,
            "dphi": dq if dphi is None else dphi,
        }
        given |= {f"argument {place}": value for place, value in enumerate(more, 5)}
        return self._states(**given)

    def _states(self, **given: ArrayLike) -> tuple[bool, list[Numbers]]:
        """Returns whether one state is given, and matrices of equal shape."""
        n = self._dynamics.joints
        arrays = {}
        for name, value in given.items():
            try:
                arrays[name] = np.asarray(value, dtype=float)
            except (TypeError, ValueError) as error:
                raise InputError(
                    f"{name} holds no numbers", "dtype", "give an array of floats"
                ) from error
        first = next(iter(arrays.values()))
        for name, array in arrays.items():
            if array.shape != first.shape or array.ndim not in (1, 2) or array.shape[-1] != n:
                raise InputError(
                    f"{name} has the shape {array.shape}",
                    "shape",
                    f"give ({n},) or (samples, {n}) for all arguments",
                )
        matrices = [np.ascontiguousarray(np.atleast_2d(array)) for array in arrays.values()]
        return first.ndim == 1, matrices

    def _halves(self, one: bool, found: Numbers) -> tuple[Numbers, Numbers]:
        n = self._dynamics.joints
        return self._shaped(one, found[:, :n]), self._shaped(one, found[:, n:])

    def _shaped(self, one: bool, found: Numbers) -> Numbers:
        return found[0] if one else found

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._dynamics.parameters == other._dynamics.parameters

    def __hash__(self) -> int:
        return hash(tuple(self._dynamics.parameters))

    def __reduce__(self) -> tuple[Any, ...]:
        return Model, (self._result, self._index)

    def __repr__(self) -> str:
        return f"<sprung.Model of {self._result.robot!r}: {len(self.parameters)} parameters>"
