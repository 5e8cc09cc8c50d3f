"""Designed experiments: motions, limits, promises and reports."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sprung._arrays import WithArrays
from sprung._files import remove, write_all
from sprung._report import Field, Report
from sprung._results import LimitUsed, More, Promised

Numbers: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory(WithArrays):
    """Samples of a motion at the period of the controller: approach, rest, motion.

    Attributes:
        joints: names of the joints.
        time_s: times, s, shape (samples,).
        position_rad: positions, rad (m), shape (samples, joints).
        velocity_rad_per_s: velocities, rad/s (m/s), of the same shape.
        acceleration_rad_per_s2: accelerations, rad/s² (m/s²), of the same shape.
    """

    joints: list[str]
    time_s: Numbers
    position_rad: Numbers
    velocity_rad_per_s: Numbers
    acceleration_rad_per_s2: Numbers

    def __repr__(self) -> str:
        seconds = float(self.time_s[-1]) if len(self.time_s) else 0.0
        names = ", ".join(self.joints)
        return f"<sprung.Trajectory of {names}: {len(self.time_s)} samples, {seconds:.6g} s>"


class Excitation(Report):
    """A designed experiment.

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

    _type = "Excitation"
    _kept = ("json", "report", "trajectory", "hold_out", "slow", "files")

    robot: Field[str] = Field()
    method: Field[str] = Field()
    warm_up: Field[bool] = Field("is_warm_up")
    certified: Field[bool] = Field("is_certified")
    duration_s: Field[float] = Field("motion.duration_s")
    approach_s: Field[float] = Field("motion.approach_s")
    base_frequency_hz: Field[float] = Field("motion.base_frequency_hz")
    harmonics: Field[list[int]] = Field("motion.harmonics")
    limits: Field[list[LimitUsed]] = Field()
    more: Field[list[More]] = Field()
    assumed: Field[list[str]] = Field()
    _promise: Field[list[Promised]] = Field("promise")

    @cached_property
    def trajectory(self) -> Trajectory:
        """Samples of the motion."""
        return Trajectory(*self._handle.trajectory())

    @cached_property
    def hold_out(self) -> Trajectory | None:
        """Samples of a motion for validation; ``None`` without a search."""
        samples = self._handle.hold_out()
        return None if samples is None else Trajectory(*samples)

    @cached_property
    def slow(self) -> Trajectory | None:
        """Samples of a slow motion for friction; ``None`` without ``slow_sweep_s`` of ``[excite]``."""
        samples = self._handle.slow()
        return None if samples is None else Trajectory(*samples)

    @cached_property
    def promise(self) -> list[Promised]:
        """Standard errors that the motion buys, in the order of the model; infinite where nothing determines one."""
        return [
            replace(one, relative_percent=math.inf) if math.isinf(one.standard_error) and one.value else one
            for one in self._promise
        ]

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the motion does not determine."""
        return [parameter.name for parameter in self.promise if not parameter.determined]

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung excite``: trajectories, reference, report, excitation.

        Each file is written whole or not at all; ``excitation.json`` comes last. Without a motion for
        validation or a slow one, ``hold-out.csv`` or ``slow.csv`` of an earlier design is removed.
        """
        write_all(folder, dict(self._handle.files()))
        for name, motion in (("hold-out.csv", self.hold_out), ("slow.csv", self.slow)):
            if motion is None:
                remove(Path(folder) / name)
        return write_all(folder, {"report.html": self._html(), "excitation.json": self.to_json()})

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Excitation):
            return NotImplemented
        return super().__eq__(other) and self.trajectory == other.trajectory

    __hash__ = Report.__hash__

    def __repr__(self) -> str:
        highest = max(self.harmonics, default=1) * self.base_frequency_hz
        kept = "every limit holds" if self.certified else "limits are broken"
        lines = "".join(f"\n  {parameter}" for parameter in self.promise)
        return (
            f"{self.robot}: {self.duration_s:.4g} s, {self.base_frequency_hz:.3g} to "
            f"{highest:.3g} Hz, {kept}{lines}"
        )
