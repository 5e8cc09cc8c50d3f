"""The arm of examples/seven-joint-twin, for the programs that are compared with sprung."""

import tomllib
from pathlib import Path

import numpy as np

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "seven-joint-twin"
BETA = 100.0  # slope of tanh, s/rad
LINK = ["m", "mx", "my", "mz", "ixx", "ixy", "iyy", "ixz", "iyz", "izz"]

_experiment = tomllib.loads((EXAMPLE / "experiment.toml").read_text())
_robot = _experiment["robot"]
_truth = tomllib.loads((EXAMPLE / "truth.toml").read_text())
DH = _robot["dh_modified"]
N = len(DH)
GRAVITY = np.array(_robot["gravity_m_per_s2"])
# Controller: gains for the motors' positions and velocities, and the window in samples.
# The velocity is the difference between the means of the window's two halves.
_gain = np.array(_experiment["controller"]["gain"])
POSITION_GAIN = np.diag(_gain[:, N : 2 * N])
VELOCITY_GAIN = np.diag(_gain[:, 3 * N :])
WINDOW = _experiment["controller"]["velocity_window"][0]


def frame(row):
    """Returns rotation and position of a joint's frame in its parent's frame, at angle zero."""
    alpha = np.radians(row.get("alpha_deg", 0.0))
    c, s = np.cos(alpha), np.sin(alpha)
    d = row.get("d_m", 0.0)
    rotation = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return rotation, np.array([row.get("a_m", 0.0), -s * d, c * d])


def link(i):
    """Returns the true dynamic parameters of a link about its frame."""
    return np.array([_truth[f"link{i + 1}.{name}"] for name in LINK])


def joints(name):
    """Returns a true parameter for every joint."""
    return np.array([_truth[f"joint{i + 1}.{name}"] for i in range(N)])


def pinocchio_model():
    import pinocchio as pin

    model = pin.Model()
    model.gravity.linear = GRAVITY
    parent = 0
    for i, row in enumerate(DH):
        placement = pin.SE3(*frame(row))
        parent = model.addJoint(parent, pin.JointModelRZ(), placement, f"joint{i + 1}")
        inertia = pin.Inertia.FromDynamicParameters(link(i))
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    return model


def read(path):
    """Returns time, link positions, motor positions and motor torques of a log."""
    with open(path) as file:
        names = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    groups = [[names.index(f"{name}{i + 1}_{unit}") for i in range(N)]
              for name, unit in [("q", "rad"), ("phi", "rad"), ("tau", "nm")]]
    return table[:, names.index("t_s")], *(table[:, columns] for columns in groups)
