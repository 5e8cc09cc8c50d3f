"""Identifies the dynamic parameters of flexible-joint robots from measured logs.

>>> import sprung
>>> experiment = sprung.Experiment.demo(overrides={"identify.estimator": "least-squares"})
>>> log = experiment.simulate()                 # columns of a log, as NumPy arrays
>>> result = experiment.identify(log)
>>> stiffness = result.parameters["joint1.stiffness"]
>>> abs(stiffness.value - 9.3587) < 0.1         # N·m/rad
True

All numbers are in SI units: rad, N·m, kg·m²; m and N for prismatic joints.
"""

from sprung._control import (
    Control,
    LoopMargins,
    Mode,
    Moves,
    ShapedMode,
    Shaper,
    Tracking,
    Vibration,
    WithDraws,
)
from sprung._errors import (
    ExperimentError,
    FileError,
    InputError,
    LogError,
    SprungError,
    SprungWarning,
    Stopped,
)
from sprung._excitation import Excitation, LimitUsed, More, Promised, Trajectory
from sprung._experiment import Experiment
from sprung._finding import Evidence, Finding
from sprung._model import Model, Motion
from sprung._mujoco import MujocoArrays
from sprung._parameters import Parameter, Parameters
from sprung._result import Check, Comparison, Result, Validation, compare, load
from sprung._samples import Bodies, SampledValues, Samples
from sprung._servo import Servo, ServoCheck, ServoResult
from sprung._sprung import GENERATOR, Choices, LogFactors

__version__ = GENERATOR.removeprefix("sprung ")

__all__ = [
    "Bodies",
    "Check",
    "Choices",
    "Comparison",
    "Control",
    "Evidence",
    "Excitation",
    "Experiment",
    "ExperimentError",
    "FileError",
    "Finding",
    "InputError",
    "LimitUsed",
    "LogError",
    "LogFactors",
    "LoopMargins",
    "Mode",
    "Model",
    "More",
    "Motion",
    "Moves",
    "MujocoArrays",
    "Parameter",
    "Parameters",
    "Promised",
    "Result",
    "SampledValues",
    "Samples",
    "Servo",
    "ServoCheck",
    "ServoResult",
    "ShapedMode",
    "Shaper",
    "SprungError",
    "SprungWarning",
    "Stopped",
    "Tracking",
    "Trajectory",
    "Validation",
    "Vibration",
    "WithDraws",
    "__version__",
    "compare",
    "load",
]
