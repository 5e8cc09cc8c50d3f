"""Identifies the demo's robot with FIGAROH, which takes its joints as rigid.

Positions of the motors replace those of the joints. FIGAROH gives the friction of each joint; inertias of links and
rotors come as sums, and springs are not in its model.
"""

import logging
import tempfile
from pathlib import Path

import numpy as np
from scipy.signal import butter, filtfilt

URDF = """<robot name="demo"><link name="base"/>
<link name="link1"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="link2"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
<inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="joint1" type="revolute"><parent link="base"/><child link="link1"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="10" velocity="10"/></joint>
<joint name="joint2" type="revolute"><parent link="link1"/><child link="link2"/><origin xyz="0.343 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="10" velocity="10"/></joint></robot>"""
SETTINGS = {
    "is_joint_torques": True, "is_external_wrench": False, "force_torque": None, "external_wrench_offsets": False,
    "has_friction": True, "has_actuator_inertia": True, "has_joint_offset": False, "has_coupled_wrist": False,
    "act_idxv": [0, 1], "act_idxq": [0, 1], "act_Jid": [1, 2], "fv": [0, 0], "fs": [0, 0], "Ia": [0, 0], "offset": [0, 0],
}
CUTOFF_HZ = 10.0
EVERY = 10


def identify(log):
    """Returns the parameters that it has in common with the demo's robot, by name."""
    logging.disable(logging.CRITICAL)
    from figaroh.tools.qrdecomposition import get_baseParams
    from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced, get_index_eliminate
    from figaroh.tools.robot import Robot
    from figaroh.identification.identification_tools import add_standard_additional_parameters, get_standard_parameters

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "demo.urdf"
        path.write_text(URDF)
        robot = Robot(str(path), folder)
    period = log["t_s"][1]
    b, a = butter(2, 2 * CUTOFF_HZ * period)
    q = filtfilt(b, a, np.column_stack([log["phi1_rad"], log["phi2_rad"]]), axis=0)
    tau = filtfilt(b, a, np.column_stack([log["tau1_nm"], log["tau2_nm"]]), axis=0)
    dq = np.gradient(q, period, axis=0)
    ddq = np.gradient(dq, period, axis=0)
    chosen = slice(200, -200, EVERY)
    regressor = build_regressor_basic(robot, q[chosen], dq[chosen], ddq[chosen], SETTINGS)
    standard = get_standard_parameters(robot.model, SETTINGS)
    standard = dict(standard) | add_standard_additional_parameters(robot.model, SETTINGS)
    eliminated, left = get_index_eliminate(regressor, standard, 1e-6)
    reduced = build_regressor_reduced(regressor, eliminated)
    base, names, *_ = get_baseParams(reduced, left, standard)
    theta = np.linalg.lstsq(base, tau[chosen].T.ravel(), rcond=None)[0]
    found = dict(zip(names, theta))
    ours = {"fv": "motor_viscous", "fs": "motor_coulomb"}
    return {
        f"joint{joint}.{parameter}": found[f"{short}_joint{joint}"]
        for short, parameter in ours.items()
        for joint in (1, 2)
    }
