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

from sprung._check import Check, CheckedColumn, CheckedLog
from sprung._comparison import (
    Combined,
    CombinedParameter,
    ComparedResult,
    Comparison,
    DriftOfParameter,
    DriftOverTime,
    compare,
)
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
from sprung._identification import (
    AddedLaw,
    Applied,
    CompetingUnknown,
    Delay,
    Disturbance,
    EncoderOffset,
    HeldOutResidual,
    LogUsed,
    Payload,
    PayloadParameter,
    PromisedErrors,
    RefinedDelay,
    Refinement,
    RigidJoint,
    StandardParameter,
    Unknown,
)
from sprung._model import Accelerations, Model, Motion, Torques
from sprung._mujoco import MujocoArrays
from sprung._named import Named
from sprung._parameters import Parameter, ParameterRow, Parameters
from sprung._result import Result, load
from sprung._samples import Bodies, SampledValues, Samples
from sprung._servo import Servo, ServoCheck, ServoErrors, ServoLog, ServoResult
from sprung._sprung import GENERATOR
from sprung._validation import JointErrors, LoopErrors, ValidatedSet, Validation, ValidationRun

__version__ = GENERATOR.removeprefix("sprung ")

__all__ = [
    "Accelerations",
    "AddedLaw",
    "Applied",
    "Bodies",
    "Check",
    "CheckedColumn",
    "CheckedLog",
    "Combined",
    "CombinedParameter",
    "ComparedResult",
    "Comparison",
    "CompetingUnknown",
    "Control",
    "Delay",
    "Disturbance",
    "DriftOfParameter",
    "DriftOverTime",
    "EncoderOffset",
    "Evidence",
    "Excitation",
    "Experiment",
    "ExperimentError",
    "FileError",
    "Finding",
    "HeldOutResidual",
    "InputError",
    "JointErrors",
    "LimitUsed",
    "LogError",
    "LogUsed",
    "LoopErrors",
    "LoopMargins",
    "Mode",
    "Model",
    "More",
    "Motion",
    "Moves",
    "MujocoArrays",
    "Named",
    "Parameter",
    "ParameterRow",
    "Parameters",
    "Payload",
    "PayloadParameter",
    "Promised",
    "PromisedErrors",
    "RefinedDelay",
    "Refinement",
    "Result",
    "RigidJoint",
    "SampledValues",
    "Samples",
    "Servo",
    "ServoCheck",
    "ServoErrors",
    "ServoLog",
    "ServoResult",
    "ShapedMode",
    "Shaper",
    "SprungError",
    "SprungWarning",
    "StandardParameter",
    "Stopped",
    "Torques",
    "Tracking",
    "Trajectory",
    "Unknown",
    "ValidatedSet",
    "Validation",
    "ValidationRun",
    "Vibration",
    "WithDraws",
    "__version__",
    "compare",
    "load",
]
