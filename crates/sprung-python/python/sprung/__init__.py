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

from sprung._check import Check
from sprung._comparison import Comparison, compare
from sprung._control import Control, Shaper
from sprung._errors import (
    ExperimentError,
    FileError,
    InputError,
    LogError,
    SprungError,
    SprungWarning,
    Stopped,
)
from sprung._excitation import Excitation, Trajectory
from sprung._experiment import Experiment
from sprung._model import Accelerations, Model, Motion, Torques
from sprung._mujoco import MujocoArrays
from sprung._named import Named
from sprung._parameters import Parameter, ParameterRow, Parameters
from sprung._result import Result, load
from sprung._results import *
from sprung._results import __all__ as _parts
from sprung._samples import Bodies, SampledValues, Samples
from sprung._servo import Servo, ServoCheck, ServoResult
from sprung._sprung import GENERATOR
from sprung._validation import Validation
from sprung._watch import Watch

__version__ = GENERATOR.removeprefix("sprung ")

__all__ = [
    "Accelerations",
    "Bodies",
    "Check",
    "Comparison",
    "Control",
    "Excitation",
    "Experiment",
    "ExperimentError",
    "FileError",
    "InputError",
    "LogError",
    "Model",
    "Motion",
    "MujocoArrays",
    "Named",
    "Parameter",
    "ParameterRow",
    "Parameters",
    "Result",
    "SampledValues",
    "Samples",
    "Servo",
    "ServoCheck",
    "ServoResult",
    "Shaper",
    "SprungError",
    "SprungWarning",
    "Stopped",
    "Torques",
    "Trajectory",
    "Validation",
    "Watch",
    "__version__",
    "compare",
    "load",
    *_parts,
]
