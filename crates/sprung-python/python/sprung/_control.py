"""Designed controllers: gains, margins, vibrations, input shapers and their proof."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from sprung._arrays import WithArrays
from sprung._files import write_all
from sprung._report import Field, Report
from sprung._results import LoopMargins, Moves, ShapedMode, Tracking, Vibration, WithDraws

Numbers: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Shaper(WithArrays):
    """An input shaper: impulses with which the command is convolved.

    Attributes:
        impulses: times, s, and parts of the command, in columns, shape (impulses, 2); the parts have the
            sum 1.
        delay_s: time of the last impulse, s.
        largest_percent: largest vibration that it leaves over all robots and poses, % of that without it.
        median_percent: median of the same, %; that of the mode with the largest median.
        level_percent: allowed vibration, %.
        reached: whether ``largest_percent`` is at most ``level_percent``.
        modes: its parts for single vibrations.
    """

    impulses: Numbers
    delay_s: float
    largest_percent: float
    median_percent: float
    level_percent: float
    reached: bool
    modes: list[ShapedMode]

    def __str__(self) -> str:
        modes = " and ".join(str(mode) for mode in self.modes)
        return f"{modes}, delay {self.delay_s:.3g} s, leaves at most {self.largest_percent:.2g} %"


class Control(Report):
    """A designed controller, and what is known about it.

    Arrays have the joints along the first axis, the poses that of `poses_rad`.

    Example:
        >>> import sprung
        >>> settings = {"control.draws": 5, "control.simulations": 1, "control.shaper_modes": 1}
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"} | settings)
        >>> control = experiment.control(experiment.identify(experiment.simulate()))
        >>> control.gain.shape, control.feedback
        ((2, 8), 'state-feedback')
        >>> control.loops[0].gain_margin_db.worst >= 6.0, control.least_damping.worst > 0.0
        (True, True)
        >>> control.vibrations[0].motors, len(control.vibrations[0].poses) == len(control.poses_rad)
        ('free', True)
        >>> control.shaper.largest_percent < 10.0, control.shaper.modes[0].centre_hz > 0.0
        (True, True)
        >>> [tracking.joint for tracking in control.tracking], control.moves.limit_cycles
        (['joint1', 'joint2'], 0)
    """

    _type = "ControlDesign"
    _kept = ("json", "report", "toml")

    robot: Field[str] = Field()
    joints: Field[list[str]] = Field()
    verdict: Field[str | None] = Field()
    feedback: Field[str] = Field("controller.feedback")
    period_s: Field[float] = Field("controller.period_s")
    gain: Field[Numbers] = Field("controller.gain")
    velocity_window: Field[tuple[int, int]] = Field("controller.velocity_window")
    feedforward: Field[bool] = Field("controller.has_feedforward")
    friction_compensation_speed_rad_per_s: Field[float | None] = Field(
        "controller.friction_compensation_speed_rad_per_s"
    )
    torque_limits_nm: Field[Numbers] = Field("controller.torque_limits_nm")
    bandwidth_hz: Field[Numbers | None] = Field("bandwidth.used_hz")
    largest_bandwidth_hz: Field[Numbers | None] = Field("bandwidth.largest_hz")
    limited_by: Field[str | None] = Field("bandwidth.limited_by")
    loops: Field[list[LoopMargins]] = Field()
    least_damping: Field[WithDraws] = Field()
    poses_rad: Field[Numbers] = Field("poses")
    draws: Field[int] = Field()
    vibrations: Field[list[Vibration]] = Field()
    shaper: Field[Shaper | None] = Field()
    simulations: Field[int] = Field("proof.robots")
    tracking: Field[list[Tracking]] = Field("proof.tracking")
    moves: Field[Moves] = Field("proof.moves")
    torque_percent: Field[float | None] = Field("proof.torque_percent")
    payload: Field[bool] = Field("has_payload")
    assumed: Field[list[str]] = Field()

    def to_toml(self) -> str:
        """Returns the text of ``controller.toml``, the ``[controller]`` of an experiment file."""
        text: str = self._handle.toml()
        return text

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung control``: controller, report, control.

        Each file is written whole or not at all; ``control.json`` comes last.
        """
        texts = {
            "controller.toml": self.to_toml(),
            "control.html": self._html(),
            "control.json": self.to_json(),
        }
        return write_all(folder, texts)

    def __repr__(self) -> str:
        said = [f"{self.robot}: {self.feedback} every {1e3 * self.period_s:.4g} ms"]
        said += [f"  {item}" for item in (*self.loops, *self.vibrations)]
        said += [] if self.shaper is None else [f"  input shaper: {self.shaper}"]
        said += [f"  {item}" for item in (*self.tracking, self.moves)]
        return "\n".join(said)
