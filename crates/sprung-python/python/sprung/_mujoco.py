"""Arrays of drawn robots for simulations in MuJoCo and MJX."""

from __future__ import annotations

import copy
import dataclasses
import importlib
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np

from sprung._arrays import WithArrays
from sprung._errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]

#: Fields that `mujoco.mj_setConst` computes from others and that differ between robots.
_DERIVED = (
    "body_subtreemass",
    "body_invweight0",
    "dof_invweight0",
    "dof_M0",
    "dof_length",
    "tendon_invweight0",
    "actuator_acc0",
)


@dataclass(frozen=True, eq=False, repr=False)
class MujocoArrays(WithArrays):
    """Values of drawn robots by the names of the fields of ``mujoco.MjModel``, the robots along the first axis.

    The indices are those of the model that MuJoCo compiles from ``result.export("mjcf")``. All other fields are equal in
    all robots, except those that MuJoCo computes from these (`derived`) and ``body_sameframe``, a shortcut of MuJoCo that
    `apply` takes back and MJX does not use. MuJoCo is not needed to make the arrays.

    Attributes:
        bodies: names of the bodies, the world first.
        joints: names of the joints, one for each degree of freedom.
        tendons: names of the tendons, which are the springs of the joints.
        body_mass: kg, shape (robots, bodies).
        body_ipos: centres of mass, m, shape (robots, bodies, 3).
        body_iquat: principal axes as quaternions w, x, y, z, shape (robots, bodies, 4).
        body_inertia: principal moments about the centres of mass, kg·m², shape (robots, bodies, 3).
        dof_armature: kg·m² (kg), shape (robots, joints); zero for joints with a spring, whose rotors are bodies.
        dof_damping: viscous friction, N·m·s/rad (N·s/m), shape (robots, joints).
        dof_frictionloss: Coulomb friction, N·m (N), shape (robots, joints).
        tendon_stiffness: N·m/rad (N/m), shape (robots, tendons).
        tendon_damping: N·m·s/rad (N·s/m), shape (robots, tendons).

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> samples = experiment.identify(experiment.simulate()).sample(100)
        >>> arrays = samples.to_mujoco()
        >>> arrays.joints
        ['joint1', 'joint2', 'joint1_motor', 'joint2_motor']
        >>> arrays.tendon_stiffness.shape
        (100, 2)

        With MJX, ``jax.vmap`` over these axes simulates all robots at once:

        >>> axes = {name: 0 for name in arrays.fields()}
        >>> # batch = mjx_model.replace(**arrays.fields())
        >>> # in_axes = jax.tree.map(lambda _: None, mjx_model).replace(**axes)
        >>> # jax.vmap(mjx.step, in_axes=(in_axes, 0))(batch, data)
    """

    bodies: list[str]
    joints: list[str]
    tendons: list[str]
    body_mass: Numbers
    body_ipos: Numbers
    body_iquat: Numbers
    body_inertia: Numbers
    dof_armature: Numbers
    dof_damping: Numbers
    dof_frictionloss: Numbers
    tendon_stiffness: Numbers
    tendon_damping: Numbers

    def __len__(self) -> int:
        return len(self.body_mass)

    def fields(self) -> dict[str, Numbers]:
        """Returns the arrays by the names of the fields, as ``mjx.Model.replace`` takes them."""
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return {name: array for name, array in values.items() if isinstance(array, np.ndarray)}

    def apply(self, model: object, robot: SupportsIndex) -> None:
        """Gives a ``mujoco.MjModel`` the values of one robot.

        Then call ``mujoco.mj_setConst(model, data)``, which computes the fields of `derived`.

        Args:
            model: the model that MuJoCo compiled from ``result.export("mjcf")``, with the same ``rigid``.
            robot: number of the robot, from 0.

        Raises:
            InputError: if the model is that of another robot.
            IndexError: if there is no such robot.
        """
        count, place = len(self), operator.index(robot)
        if not -count <= place < count:
            raise IndexError(f"there is no robot {place}; there are {count}")
        fields = self.fields()
        for name, array in fields.items():
            shape = getattr(getattr(model, name, None), "shape", None)
            if shape != array.shape[1:]:
                raise InputError(
                    f"model.{name} has the shape {shape}, and that of the robots is {array.shape[1:]}",
                    "model",
                    'give the model that MuJoCo compiles from result.export("mjcf"), with the same rigid',
                )
        for name, array in fields.items():
            getattr(model, name)[:] = array[place]
        self._unshorten(model, place)

    def _unshorten(self, model: Any, place: int) -> None:
        """Takes back shortcuts of the compiled model that hold for its own bodies only."""
        turned = (self.body_iquat[place] != (1.0, 0.0, 0.0, 0.0)).any(axis=1)
        moved = turned | (self.body_ipos[place] != 0.0).any(axis=1)
        if np.any(np.asarray(model.body_simple)[moved]):
            raise InputError(
                "the model has a body that MuJoCo takes as simple, and the robot has none",
                "model",
                "give the model that MuJoCo compiles from a file of Samples.export",
            )
        # Zero: the inertial frame is neither that of the body nor turned as it.
        model.body_sameframe[moved] = 0

    def derived(self, model: object) -> dict[str, Numbers]:
        """Returns the fields that MuJoCo computes from the others, by name, the robots along the first axis.

        They are subtree masses, inverse weights, which set the softness of constraints such as ``dof_frictionloss``,
        lengths of degrees of freedom and accelerations of actuators. The statistics ``model.stat`` scale tolerances of
        solvers and views only, and stay those of the model.

        Args:
            model: as for `apply`; it stays as it is.

        Raises:
            InputError: if the model is that of another robot, or the package ``mujoco`` is missing.
        """
        try:
            mujoco: Any = importlib.import_module("mujoco")
        except ImportError as error:
            raise InputError(
                "the package mujoco is not installed", "mujoco", "pip install mujoco"
            ) from error
        model_copy = copy.copy(model)
        data = mujoco.MjData(model_copy)
        rows: dict[str, list[Numbers]] = {
            name: [] for name in _DERIVED if hasattr(model_copy, name)
        }
        for robot in range(len(self)):
            self.apply(model_copy, robot)
            mujoco.mj_setConst(model_copy, data)
            for name, row in rows.items():
                row.append(np.array(getattr(model_copy, name), dtype=np.float64))
        return {name: np.array(row) for name, row in rows.items()}

    def __repr__(self) -> str:
        robots, bodies = self.body_mass.shape
        return f"<sprung.MujocoArrays of {robots} robots with {bodies} bodies>"
