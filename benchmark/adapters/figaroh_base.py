"""FIGAROH has no springs: a flexible robot is taken as rigid and moved by its motors, so friction of motor and link is one.

Weighted least squares as in its TX40 example, reconstruction near nominal bodies; offsets only where a joint is rigid.
"""
import sys
from pathlib import Path

import numpy as np
from figaroh.data import TrajectoryData
from figaroh.identification import BaseIdentification, identification_tools
from figaroh.tools.load_robot import load_robot

sys.path.insert(0, str(Path(__file__).parents[1]))
from model import BODY
from tool import Log, save

log, out = Log(Path(sys.argv[1])), Path(sys.argv[2])
n, t, names = log.n, np.arange(len(log.t)) * log.dt, [f"joint{i + 1}" for i in range(log.n)]
kinds, units = zip(*(("joint_force", "N") if slides else ("joint_torque", "N·m") for slides in log.chain.slides))
mechanics = {"actuator_inertias": log.task.get("nominal_drives", {}).get("rotor_inertia", [0.0] * n)}
problem = {"model_components": {"friction": True, "actuator_inertia": True, "joint_offset": any(log.rigid)}}
signals = {"sampling_frequency": 1 / log.dt, "cutoff_frequency": log.task.get("cutoff_hz", 20.0), "filter_order": 4}
config = {"mechanics": mechanics, "problem": problem, "signal_processing": signals, "reconstruction": {"enabled": True}}

class Identification(BaseIdentification):
    def load_param(self, config, setting_type="identification"):
        active = {"active_joints": names, "act_idxq": list(range(n)), "act_idxv": list(range(n))}
        self.identif_config = identification_tools.unified_to_legacy_identif_config(self.robot, config) | active
    def load_trajectory_data(self, data_source=None):       # the clock is that of the samples: the Panda's stamps jitter
        return TrajectoryData(t, names, log.p, log.tau, kinds, units, clock="assumed", mask=(t > 0.3) & (t < t[-1] - 0.3))
robot = load_robot(str(Path(sys.argv[1]) / "robot.urdf"))
robot.model.gravity.linear = np.array(log.task["gravity"], float)
fit = Identification(robot, config)
fit.initialize()
fit.solve(plotting=False, wls=True)
value = {k.lower(): v for k, v in (fit.standard_parameter | fit.result["reconstruction"]["theta_r_dict"]).items()}
error = {k.lower(): s / 100 * abs(value.get(k.lower(), np.nan)) for k, s in zip(fit.params_base, fit.result["wls_std_deviations"])}
drives, errors = ([[x.get(f"{k}_{j}", np.nan) for j in names] for k in ("", "ia", "fv", "fs", "", "")] for x in (value, error))
offsets = {f"{j}.motor_offset": value[f"off_{j}"] for j in names if any(log.rigid)}
save(out, "FIGAROH", drives, errors, [[value[f"{k}_{j}"] for k in BODY] for j in names], offsets)
