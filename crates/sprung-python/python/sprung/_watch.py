"""What happened on a running robot."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from sprung._curves import curves
from sprung._named import Named
from sprung._report import Field, Report
from sprung._results import WatchedJoint, WatchedLog, WatchEvent

if TYPE_CHECKING:
    from sprung._curves import Curves


class Watch(Report):
    """Contacts, changes of the robot, and sensors that show nothing.

    Example:
        >>> import sprung
        >>> settings = {"identify.estimator": "least-squares"}
        >>> experiment = sprung.Experiment.demo(settings)
        >>> healthy = experiment.simulate()
        >>> touch = {"simulate.contact_torque_nm": [0.6, 0.0], "simulate.contact_s": [[5.0, 5.5]]}
        >>> touched = sprung.Experiment.demo(settings | touch).simulate(seed=7)
        >>> watch = experiment.identify(healthy).watch(touched, healthy=healthy)
        >>> (contact,) = watch.events
        >>> contact.finding.code, contact.joint, 5.0 < contact.begins_s < 5.1
        ('contact', 'joint1', True)
        >>> watch.joints[0].joint, watch.joints[0].threshold_sigma > 3.0
        ('joint1', True)
        >>> watch.logs[0].blind_s < 1.0
        True
        >>> print(watch)
        10 s watched, contacts: 1, other events: 0; thresholds of 1 false alarms per hour, ...
    """

    _type = "Watch"
    _kept = ("json", "report", "sentence", "torques")

    robot: Field[str] = Field()
    false_alarms_per_h: Field[float] = Field()
    bandwidth_rad_per_s: Field[float] = Field()
    learned_s: Field[float] = Field()
    joints: Field[list[WatchedJoint]] = Field()
    logs: Field[list[WatchedLog]] = Field()
    events: Field[list[WatchEvent]] = Field()

    @property
    def sentence(self) -> str:
        """What was watched, in a sentence."""
        sentence: str = self._handle.sentence()
        return sentence

    @cached_property
    def torques(self) -> Named[Curves]:
        """Torques from outside and their thresholds, N·m (N)."""
        return curves(self._handle.torques(), "curve")

    def __str__(self) -> str:
        return self.sentence
