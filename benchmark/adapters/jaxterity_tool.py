"""Jaxterity fits friction only, to a rigid robot with nominal bodies and rotors, moved by its motors: what is fitted to torques.

Its other recipes take logs of free motion or of one moving joint. MuJoCo 4 renamed what Jaxterity 1.0.0 calls: first lines.
"""
import json
import os
import sys
from pathlib import Path

os.environ["JAX_ENABLE_X64"] = "1"
import mujoco
import numpy as np
from scipy.signal import butter, filtfilt

if not hasattr(mujoco.MjData, "qM"):
    full, mujoco.MjData.qM = mujoco.mj_fullM, property(lambda data: data)
    mujoco.mj_fullM = lambda model, out, data: full(model, data, out)
from jaxterity.calibrate import refit_drift_parameters
from jaxterity.data.schema import JointTelemetry
from jaxterity.robot.urdf import from_urdf
from jaxterity.twin import DriftParameter, Twin

sys.path.insert(0, str(Path(__file__).parents[1]))
from tool import Log

log, out, every, samples = Log(Path(sys.argv[1])), Path(sys.argv[2]), 10, 400
if "nominal_drives" not in log.task:
    sys.exit("Jaxterity needs nominal bodies and rotors; this task has none")
keys = {"armature": "rotor_inertia", "damping": "motor_viscous", "friction": "motor_coulomb"}
nominal = {f"joint{i + 1}.{a}": log.task["nominal_drives"][b][i] for i in range(log.n) for a, b in keys.items()}
robot, names = from_urdf(Path(sys.argv[1]) / "robot.urdf").with_parameters(nominal), tuple(f"joint{i + 1}" for i in range(log.n))
low = lambda x: filtfilt(*butter(2, 2 * log.dt * 20.0), x, axis=0)
q, tau, middle = low(log.p), low(log.tau), len(log.t) // 2
part = slice(middle - every * samples // 2, middle + every * samples // 2, every)
log_of = dict(time=log.t[part], q=q[part], qd=np.gradient(q, log.dt, axis=0)[part], tau=tau[part])
twin = Twin(robot, serial="1", C_th=np.ones(log.n), R_th=np.ones(log.n), k_pwr=np.zeros(log.n), servo_names=names)
bounds = tuple(DriftParameter(f"robot.{k}", 0.0, 4 * v, "", "") for k, v in nominal.items() if "armature" not in k)
fit = refit_drift_parameters(twin, JointTelemetry(sample_rate_hz=1 / log.dt / every, joint_names=names, **log_of), bounds)
values = {f"{k.split('.')[1]}.{keys[k.split('.')[2]]}": float(v) for k, v in fit.sysid_result.fitted.items()}
out.write_text(json.dumps({"tool": "Jaxterity", "parameters": values, "bodies": {}}))
