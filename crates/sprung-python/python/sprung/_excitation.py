"""Designed experiments: motions, limits, promises and reports."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sprung._files import remove, write_text
from sprung._report import Pickled, Report

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung import _sprung
    from sprung._sprung import Samples

    _Motions = tuple[Samples, Samples | None, Samples | None]

_HOLD_OUT = "hold-out.csv"
_SLOW = "slow.csv"


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Samples of a motion at the period of the controller: approach, rest, motion.

    Attributes:
        joints: names of the joints.
        time_s: times, s, shape (samples,).
        position_rad: positions, rad (m), shape (samples, joints).
        velocity_rad_per_s: velocities, rad/s (m/s), of the same shape.
        acceleration_rad_per_s2: accelerations, rad/s² (m/s²), of the same shape.
    """

    joints: list[str]
    time_s: NDArray[np.float64]
    position_rad: NDArray[np.float64]
    velocity_rad_per_s: NDArray[np.float64]
    acceleration_rad_per_s2: NDArray[np.float64]

    def _parts(self) -> Samples:
        motion = (self.position_rad, self.velocity_rad_per_s, self.acceleration_rad_per_s2)
        return self.joints, self.time_s, *motion

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trajectory):
            return NotImplemented
        both = zip(self._parts()[1:], other._parts()[1:], strict=True)
        return self.joints == other.joints and all(np.array_equal(a, b) for a, b in both)

    def __hash__(self) -> int:
        return hash((*self.joints, len(self.time_s)))

    def __repr__(self) -> str:
        seconds = float(self.time_s[-1]) if len(self.time_s) else 0.0
        names = ", ".join(self.joints)
        return f"<sprung.Trajectory of {names}: {len(self.time_s)} samples, {seconds:.6g} s>"


@dataclass(frozen=True)
class Promised:
    """The standard error that a motion buys for one parameter.

    Attributes:
        name: for example ``joint1.stiffness``.
        unit: unit of the numbers, for example ``N·m/rad``.
        value: value for which the experiment was designed.
        standard_error: standard error, the bound of Cramér and Rao; infinite if nothing determines
            the parameter.
        relative_percent: standard error relative to the value, %; ``None`` for a value of zero.
        determined: whether the motion determines the parameter.
        cure: the change that determines it, if this motion does not.
    """

    name: str
    unit: str
    value: float
    standard_error: float
    relative_percent: float | None = None
    determined: bool = True
    cure: str | None = None

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Promised:
        """Returns a promise from its JSON, which has no infinite numbers."""
        relative = None if given["value"] == 0.0 else _number(given["relative_percent"])
        return cls(
            name=given["name"],
            unit=given["unit"],
            value=given["value"],
            standard_error=_number(given["standard_error"]),
            relative_percent=relative,
            determined=given["is_determined"],
            cure=given["cure"],
        )

    def __str__(self) -> str:
        text = f"{self.name} = {self.value:.6g} ± {self.standard_error:.2g} {self.unit}".rstrip()
        if self.determined:
            return text
        return f"{text}, not determined" + (f": {self.cure}" if self.cure else "")


@dataclass(frozen=True)
class LimitUsed:
    """How near a motion comes to one limit.

    Attributes:
        joint: the joint; ``None`` for the tool.
        quantity: the limited quantity, for example ``torque``.
        unit: unit of the limits.
        lowest, highest: allowed values; ``None`` without one.
        used_percent: largest part of the limit that the motion uses, %.
        time_s: time of its largest value, s.
        shown: ``between samples`` or ``simulated``.
    """

    joint: str | None
    quantity: str
    unit: str
    lowest: float | None
    highest: float | None
    used_percent: float
    time_s: float
    shown: str

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> LimitUsed:
        """Returns a limit from its JSON."""
        return cls(**{**given, "used_percent": _number(given["used_percent"])})

    def __str__(self) -> str:
        joint = "" if self.joint is None else f" of {self.joint}"
        return f"{self.quantity}{joint}: {self.used_percent:.3g} % at {self.time_s:.6g} s"


@dataclass(frozen=True)
class More:
    """What more experiments would buy.

    Attributes:
        what: the experiments.
        factor: standard errors relative to those of the promise, geometric mean.
        undetermined: number of parameters that stay undetermined.
    """

    what: str
    factor: float
    undetermined: int

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> More:
        """Returns more experiments from their JSON."""
        return cls(given["what"], _number(given["factor"]), given["undetermined"])

    def __str__(self) -> str:
        return f"{self.what}: standard errors times {self.factor:.3g}"


@dataclass(frozen=True, eq=False, repr=False)
class Excitation(Report):
    """A designed experiment.

    Attributes:
        robot: name of the robot.
        method: ``optimal``, ``paper``, ``random`` or ``reference``.
        warm_up: whether it is a first small motion of an unknown robot.
        certified: whether all limits hold: those of the reference between samples, those of
            the simulated loop at every period of the controller.
        duration_s: length of the motion without approach, s.
        approach_s: length of the approach before it, s; 0 if the robot is there.
        base_frequency_hz: lowest frequency, Hz.
        harmonics: its multiples in the motion.
        trajectory: samples of the motion.
        hold_out: those of a motion for validation; ``None`` without a search.
        slow: those of a slow motion for friction; ``None`` without ``slow_sweep_s`` of ``[excite]``.
        promise: standard errors that the motion buys, in the order of the model.
        limits: used part of each limit, the largest first.
        more: standard errors that more experiments would buy.
        assumed: assumptions of the design, one sentence each.

    Example:
        >>> import sprung
        >>> design = sprung.Experiment.demo().excite(method="paper")
        >>> design.trajectory.position_rad.shape, design.duration_s
        ((10001, 2), 10.0)
        >>> design.promise[0].name, design.promise[0].standard_error < 1e-3
        ('link1.inertia_total', True)
        >>> (
        ...     design.undetermined,
        ...     all(limit.used_percent <= 100.0 for limit in design.limits),
        ...     design.more[0].factor < 1.0,
        ... )
        ([], True, True)
    """

    robot: str
    method: str
    warm_up: bool
    certified: bool
    duration_s: float
    approach_s: float
    base_frequency_hz: float
    harmonics: list[int]
    trajectory: Trajectory
    hold_out: Trajectory | None
    slow: Trajectory | None
    promise: list[Promised]
    limits: list[LimitUsed]
    more: list[More]
    assumed: list[str]
    _handle: _sprung.Excited | _PickledExcitation

    @classmethod
    def _of(cls, handle: _sprung.Excited | _PickledExcitation) -> Excitation:
        design = json.loads(handle.json())
        motion = design["motion"]
        return cls(
            robot=design["robot"],
            method=design["method"],
            warm_up=design["is_warm_up"],
            certified=design["is_certified"],
            duration_s=motion["duration_s"],
            approach_s=motion["approach_s"],
            base_frequency_hz=motion["base_frequency_hz"],
            harmonics=motion["harmonics"],
            trajectory=Trajectory(*handle.trajectory()),
            hold_out=_trajectory(handle.hold_out()),
            slow=_trajectory(handle.slow()),
            promise=[Promised.of(one) for one in design["promise"]],
            limits=[LimitUsed.of(one) for one in design["limits"]],
            more=[More.of(one) for one in design["more"]],
            assumed=design["assumed"],
            _handle=handle,
        )

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the motion does not determine."""
        return [parameter.name for parameter in self.promise if not parameter.determined]

    def to_json(self) -> str:
        """Returns the text of ``excitation.json``."""
        return self._handle.json()

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung excite``: trajectories, reference, report, excitation.

        Each file is written whole or not at all; ``excitation.json`` comes last. Without a motion for
        validation or a slow one, ``hold-out.csv`` or ``slow.csv`` of an earlier design is removed.
        """
        folder = Path(folder)
        for name, text in self._handle.files():
            write_text(folder / name, text)
        for name, motion in ((_HOLD_OUT, self.hold_out), (_SLOW, self.slow)):
            if motion is None:
                remove(folder / name)
        write_text(folder / "report.html", self._html())
        write_text(folder / "excitation.json", self.to_json())
        return folder

    def _html(self) -> str:
        return self._handle.report()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Excitation):
            return NotImplemented
        motions = self._motions() == other._motions()
        return motions and self.to_json() == other.to_json()

    def _motions(self) -> tuple[Trajectory | None, ...]:
        return self.trajectory, self.hold_out, self.slow

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        handle = self._handle
        motions = (handle.trajectory(), handle.hold_out(), handle.slow())
        return _excitation, (handle.json(), motions, handle.files(), handle.report())

    def __repr__(self) -> str:
        highest = max(self.harmonics, default=1) * self.base_frequency_hz
        kept = "every limit holds" if self.certified else "limits are broken"
        lines = "".join(f"\n  {parameter}" for parameter in self.promise)
        return (
            f"{self.robot}: {self.duration_s:.4g} s, {self.base_frequency_hz:.3g} to "
            f"{highest:.3g} Hz, {kept}{lines}"
        )


class _PickledExcitation(Pickled):
    """JSON, report, motions and files of a design that came out of a pickle."""

    def __init__(
        self, json_text: str, motions: _Motions, files: list[tuple[str, str]], page: str
    ) -> None:
        super().__init__(json_text, page)
        self._motions = motions
        self._files = files

    def trajectory(self) -> Samples:
        return self._motions[0]

    def hold_out(self) -> Samples | None:
        return self._motions[1]

    def slow(self) -> Samples | None:
        return self._motions[2]

    def files(self) -> list[tuple[str, str]]:
        return self._files


def _excitation(
    json_text: str, motions: _Motions, files: list[tuple[str, str]], page: str
) -> Excitation:
    return Excitation._of(_PickledExcitation(json_text, motions, files, page))


def _trajectory(samples: Samples | None) -> Trajectory | None:
    return None if samples is None else Trajectory(*samples)


def _number(given: float | None) -> float:
    return math.inf if given is None else given
