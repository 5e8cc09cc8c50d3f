"""Designed controllers: gains, margins, vibrations, input shapers and their proof."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sprung._files import write_text
from sprung._record import record
from sprung._report import Pickled, Report

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sprung import _sprung

    Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class WithDraws:
    """A figure at its worst pose.

    Attributes:
        identified: that of the identified robot.
        worst: the worst of all robots from the posterior.
    """

    identified: float
    worst: float

    def __str__(self) -> str:
        return f"{self.identified:.3g} (worst robot {self.worst:.3g})"


@dataclass(frozen=True)
class LoopMargins:
    """Margins of the loop of one motor, opened there while the others are closed.

    Attributes:
        joint: name of the joint.
        gain_margin_db: least factor by which the gain may change, dB; ``None`` if every gain keeps the loop
            stable.
        phase_margin_deg: least phase that may change, degrees.
        crossover_hz: frequency at which the open loop has the gain one, Hz; 0 if it has none.
    """

    joint: str
    gain_margin_db: WithDraws | None
    phase_margin_deg: WithDraws
    crossover_hz: float

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> LoopMargins:
        """Returns margins from their JSON."""
        gain = given["gain_db"]
        return cls(
            given["joint"],
            None if gain is None else record(WithDraws, gain),
            record(WithDraws, given["phase_deg"]),
            given["crossover_hz"],
        )

    def __str__(self) -> str:
        gain = "any gain" if self.gain_margin_db is None else f"{self.gain_margin_db} dB"
        return f"{self.joint}: gain margin {gain}, phase margin {self.phase_margin_deg}°"


@dataclass(frozen=True)
class Mode:
    """Natural frequency and damping ratio in one pose.

    Attributes:
        hz: natural frequency of the identified robot, Hz.
        hz_95: interval that holds 95 % of the robots, Hz.
        damping: damping ratio of the identified robot.
        damping_95: interval that holds 95 % of the robots.
    """

    hz: float
    hz_95: tuple[float, float]
    damping: float
    damping_95: tuple[float, float]

    def __str__(self) -> str:
        low, high = self.hz_95
        return f"{self.hz:.4g} Hz ({low:.4g} to {high:.4g}), damping {self.damping:.2g}"


@dataclass(frozen=True)
class Vibration:
    """A vibration over all poses and robots.

    Attributes:
        motors: ``free``, ``held`` or ``controlled``.
        name: joint whose spring has the largest part of its energy; of a closed loop its place from the
            lowest frequency.
        hz: natural frequency of the identified robot, median over poses, Hz.
        hz_95: interval that holds 95 % of robots and poses, Hz.
        damping: damping ratio of the identified robot, median over poses.
        damping_95: interval that holds 95 % of robots and poses.
        poses: the mode at each pose; ``None`` where the identified robot does not vibrate so.
    """

    motors: str
    name: str
    hz: float
    hz_95: tuple[float, float]
    damping: float
    damping_95: tuple[float, float]
    poses: list[Mode | None]

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Vibration:
        """Returns a vibration from its JSON."""
        mode = record(Mode, given["all"])
        poses = [None if one is None else record(Mode, one) for one in given["poses"]]
        figures = (mode.hz, mode.hz_95, mode.damping, mode.damping_95)
        return cls(given["motors"], given["name"], *figures, poses)

    def __str__(self) -> str:
        mode = Mode(self.hz, self.hz_95, self.damping, self.damping_95)
        return f"{self.name}, motors {self.motors}: {mode}"


@dataclass(frozen=True)
class ShapedMode:
    """The part of an input shaper for one vibration.

    Attributes:
        impulses: number of its impulses, 2 to 5.
        centre_hz: natural frequency for which it is designed, Hz.
        damping: damping ratio for which it is designed.
        largest_percent: largest vibration that the whole shaper leaves, % of that without it.
        median_percent: median over the region of the mode, %.
    """

    impulses: int
    centre_hz: float
    damping: float
    largest_percent: float
    median_percent: float

    def __str__(self) -> str:
        return f"{self.impulses} impulses at {self.centre_hz:.3g} Hz"


@dataclass(frozen=True, eq=False)
class Shaper:
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

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Shaper:
        """Returns a shaper from its JSON."""
        return cls(
            impulses=_array(
                [[impulse["time_s"], impulse["amplitude"]] for impulse in given["impulses"]]
            ),
            delay_s=given["delay_s"],
            largest_percent=given["largest_percent"],
            median_percent=given["median_percent"],
            level_percent=given["level_percent"],
            reached=given["reached"],
            modes=[record(ShapedMode, mode) for mode in given["modes"]],
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Shaper):
            return NotImplemented
        return np.array_equal(self.impulses, other.impulses) and self._rest() == other._rest()

    def __hash__(self) -> int:
        return hash(self.impulses.tobytes())

    def _rest(self) -> tuple[Any, ...]:
        residuals = (self.largest_percent, self.median_percent, self.level_percent)
        return self.delay_s, residuals, self.reached, self.modes

    def __str__(self) -> str:
        modes = " and ".join(str(mode) for mode in self.modes)
        return f"{modes}, delay {self.delay_s:.3g} s, leaves at most {self.largest_percent:.2g} %"


@dataclass(frozen=True)
class Tracking:
    """How well a link follows the reference of the experiment.

    Attributes:
        joint: name of the joint.
        declared_rad: root mean square error with ``[controller]`` on the identified robot, rad (m);
            ``None`` without one.
        designed_rad: that with the designed controller, rad (m).
    """

    joint: str
    declared_rad: float | None
    designed_rad: WithDraws

    def __str__(self) -> str:
        return f"{self.joint} follows the reference within {self.designed_rad} rad rms"


@dataclass(frozen=True)
class Moves:
    """Vibrations after moves from rest to rest: the largest deviation of a link from its end.

    Attributes:
        duration_s: length of a move, s.
        way_rad: way of each joint, rad (m).
        unshaped_rad: deviation without shaper, rad (m).
        shaped_rad: deviation with the shaper; the same if there is none.
        largest_percent: largest shaped deviation, % of the unshaped one of the same robot and pose; ``None``
            if moves without shaper leave less than 1 % of the way.
        limit_cycles: number of robots that go on moving long after the end.
    """

    duration_s: float
    way_rad: list[float]
    unshaped_rad: WithDraws
    shaped_rad: WithDraws
    largest_percent: float | None
    limit_cycles: int

    def __str__(self) -> str:
        return f"moves of {self.duration_s:.3g} s leave vibrations of {self.shaped_rad} rad"


@dataclass(frozen=True, eq=False, repr=False)
class Control(Report):
    """A designed controller, and what is known about it.

    Attributes:
        robot: name of the robot.
        joints: names of the joints.
        verdict: ``good``, ``doubtful`` or ``unusable``; ``None`` for values that come from no
            identification.
        feedback: ``state-feedback``, ``pd``, ``link-damping`` or ``declared``.
        period_s: period of the controller, s.
        gain: gains on the errors of link positions, motor positions, link velocities and motor velocities,
            N·m/rad and N·m·s/rad (N/m, N·s/m), shape (joints, 4 joints).
        velocity_window: windows of the velocity estimator, samples.
        feedforward: whether the torques of the model are fed forward.
        friction_compensation_speed_rad_per_s: velocity within which the compensation of friction changes
            its direction, rad/s (m/s); ``None`` without compensation.
        torque_limits_nm: largest torques, N·m (N), shape (joints,); infinite without limit.
        bandwidth_hz: bandwidths of the joints, Hz, shape (joints,); ``None`` for a declared controller.
        largest_bandwidth_hz: the largest in the same proportions that keep the margins at all poses.
        limited_by: what forbids more, in a sentence.
        loops: margins of each motor's loop.
        least_damping: least damping ratio of the vibrations of the loop.
        poses_rad: examined link positions, rad (m), shape (poses, joints).
        draws: number of robots from the posterior.
        vibrations: vibrations over poses and robots.
        shaper: the input shaper; ``None`` if none is needed or wanted.
        simulations: number of simulated robots, the identified one among them.
        tracking: errors on the reference of the experiment; empty without one.
        moves: vibrations after moves from rest to rest.
        torque_percent: largest torque of the simulations, % of its limit; ``None`` without limits.
        payload: whether the values include a payload.
        assumed: assumptions of the design and what it leaves out, one sentence each.

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

    robot: str
    joints: list[str]
    verdict: str | None
    feedback: str
    period_s: float
    gain: Numbers
    velocity_window: tuple[int, int]
    feedforward: bool
    friction_compensation_speed_rad_per_s: float | None
    torque_limits_nm: Numbers
    bandwidth_hz: Numbers | None
    largest_bandwidth_hz: Numbers | None
    limited_by: str | None
    loops: list[LoopMargins]
    least_damping: WithDraws
    poses_rad: Numbers
    draws: int
    vibrations: list[Vibration]
    shaper: Shaper | None
    simulations: int
    tracking: list[Tracking]
    moves: Moves
    torque_percent: float | None
    payload: bool
    assumed: list[str]
    _handle: _sprung.Designed | _PickledControl

    @classmethod
    def _of(cls, handle: _sprung.Designed | _PickledControl) -> Control:
        design = json.loads(handle.json())
        controller, proof = design["controller"], design["proof"]
        bandwidth = design.get("bandwidth")
        shaper = design.get("shaper")
        limits = [math.inf if one is None else one for one in controller["torque_limits_nm"]]
        first, second = controller["velocity_window"]
        return cls(
            robot=design["robot"],
            joints=design["joints"],
            verdict=design.get("verdict"),
            feedback=controller["feedback"],
            period_s=controller["period_s"],
            gain=_array(controller["gain"]),
            velocity_window=(first, second),
            feedforward=controller["has_feedforward"],
            friction_compensation_speed_rad_per_s=controller.get(
                "friction_compensation_speed_rad_per_s"
            ),
            torque_limits_nm=_array(limits),
            bandwidth_hz=bandwidth and _array(bandwidth["used_hz"]),
            largest_bandwidth_hz=bandwidth and _array(bandwidth["largest_hz"]),
            limited_by=bandwidth and bandwidth["limited_by"],
            loops=[LoopMargins.of(one) for one in design["loops"]],
            least_damping=record(WithDraws, design["least_damping"]),
            poses_rad=_array(design["poses"]),
            draws=design["draws"],
            vibrations=[Vibration.of(one) for one in design["vibrations"]],
            shaper=None if shaper is None else Shaper.of(shaper),
            simulations=proof["robots"],
            tracking=[record(Tracking, one) for one in proof["tracking"]],
            moves=record(Moves, proof["moves"]),
            torque_percent=proof["torque_percent"],
            payload=design["has_payload"],
            assumed=design["assumed"],
            _handle=handle,
        )

    def to_json(self) -> str:
        """Returns the text of ``control.json``."""
        return self._handle.json()

    def to_toml(self) -> str:
        """Returns the text of ``controller.toml``, the ``[controller]`` of an experiment file."""
        return self._handle.toml()

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the files of ``sprung control``: controller, report, control.

        Each file is written whole or not at all; ``control.json`` comes last.
        """
        folder = Path(folder)
        write_text(folder / "controller.toml", self.to_toml())
        write_text(folder / "control.html", self._html())
        write_text(folder / "control.json", self.to_json())
        return folder

    def _html(self) -> str:
        return self._handle.report()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Control):
            return NotImplemented
        return self.to_json() == other.to_json()

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        handle = self._handle
        return _control, (handle.json(), handle.toml(), handle.report())

    def __repr__(self) -> str:
        said = [f"{self.robot}: {self.feedback} every {1e3 * self.period_s:.4g} ms"]
        said += [f"  {item}" for item in (*self.loops, *self.vibrations)]
        said += [] if self.shaper is None else [f"  input shaper: {self.shaper}"]
        said += [f"  {item}" for item in (*self.tracking, self.moves)]
        return "\n".join(said)


class _PickledControl(Pickled):
    """JSON, report and parameter file of a design that came out of a pickle."""

    def __init__(self, json_text: str, toml: str, page: str) -> None:
        super().__init__(json_text, page)
        self._toml = toml

    def toml(self) -> str:
        return self._toml


def _control(json_text: str, toml: str, page: str) -> Control:
    return Control._of(_PickledControl(json_text, toml, page))


def _array(given: Sequence[float] | Sequence[Sequence[float]]) -> Numbers:
    array = np.array(given, dtype=np.float64)
    array.flags.writeable = False
    return array
