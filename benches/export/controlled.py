"""Runs the exported code of a designed controller on the exported robot in MuJoCo.

    python controlled.py SPRUNG FOLDER

The demo's arm is identified, a controller is designed, and robot and code are exported. MuJoCo simulates the robot, whose dry
friction is a constraint and not the law of the model. The links follow the paper's second experiment, once with the paper's PD
and once with the designed controller; then again on a robot with effects that the model lacks: ripple of the torque, error of
the transmission, and friction that grows with the load. The script fails if the designed controller does not follow at least four times better, or
if the motors still move after the end.
"""

import ctypes
import json
import pathlib
import subprocess
import sys
import tomllib

import mujoco
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from figure import note  # noqa: E402

SUBSTEPS, SECONDS, SETTLES, HOLD = 10, 8.0, 1.0, 10.0
BETTER, RESTS_RAD = 4.0, 2e-4
# Effects that the model lacks: parts of the torque and of the load, and an error of the measured angle.
RIPPLE, LOAD_FRICTION, TRANSMISSION_RAD = 0.03, 0.05, 2e-4


def sprung(program, *args):
    subprocess.run([program, *map(str, args)], check=True, stdout=subprocess.DEVNULL)


def reference(experiment, joints, time):
    """Desired positions and their first four derivatives, [5, n]."""
    sines = experiment["validate"][-1]["controller"]["reference"]["sines"]
    all = np.zeros((5, len(joints)))
    for sine in sines:
        rate = 2 * np.pi * sine["frequency_hz"]
        amplitude = np.radians(sine["amplitude_deg"])
        angle = rate * time + np.radians(sine.get("phase_deg", 0.0))
        for order in range(5):
            wave = amplitude * rate**order * np.sin(angle + order * np.pi / 2)
            all[order, joints.index(sine["joint"])] += wave
    return all


class Code:
    """The compiled controller."""

    def __init__(self, folder, prefix, n):
        library = folder / "robot.so"
        flags = ["-std=c99", "-O2", "-fPIC", "-shared"]
        subprocess.run(["cc", *flags, folder / "robot.c", "-lm", "-o", library], check=True)
        code = ctypes.CDLL(str(library))
        self.start_, self.step_ = (getattr(code, f"{prefix}_control_{name}") for name in ("start", "step"))
        # Larger than any state of two joints.
        self.state = ctypes.create_string_buffer(1 << 20)
        self.n = n

    def start(self, desired, q, phi):
        array = lambda values: (ctypes.c_double * len(values))(*values)
        assert self.start_(self.state, array(q), array(phi), array(desired[0])) == 0

    def step(self, desired, q, phi):
        array = lambda values: (ctypes.c_double * len(values))(*values)
        torques = (ctypes.c_double * self.n)()
        assert self.step_(self.state, array(desired.ravel()), array(q), array(phi), torques) == 0
        return np.array(torques)


def follow(model, joints, experiment, period, torques, lacks):
    """Errors of the links, [samples, n], and the largest motion of a motor at the end of a hold."""
    data = mujoco.MjData(model)
    of = lambda names: [model.joint(name).qposadr[0] for name in names]
    turning = [f"{name}_motor" for name in joints]
    links, motors = of(joints), of(turning)
    rates = [model.joint(name).dofadr[0] for name in turning]
    stiffness = np.array([model.tendon_stiffness[model.tendon(f"{name}_spring").id] for name in joints])
    errors, last = [], []
    count, hold = int(SECONDS / period), int(HOLD / period)
    for k in range(count + hold):
        desired = reference(experiment, joints, min(k, count) * period)
        if k >= count:
            desired[1:] = 0.0
        q, phi = data.qpos[links].copy(), data.qpos[motors].copy()
        read = phi + lacks * TRANSMISSION_RAD * np.sin(100 * phi)
        data.ctrl[:] = torques(k, desired, q, read) * (1 + lacks * RIPPLE * np.sin(60 * phi))
        load = LOAD_FRICTION * stiffness * np.abs(phi - q)
        data.qfrc_applied[rates] = -lacks * load * np.tanh(data.qvel[rates] / 0.01)
        mujoco.mj_step(model, data, SUBSTEPS)
        if SETTLES / period <= k < count:
            errors.append(q - desired[0])
        if k >= count + hold // 2:
            last.append(phi)
    return np.array(errors), np.ptp(np.array(last), axis=0).max()


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    demo, out = folder / "controlled", folder / "controlled" / "sprung-out"
    sprung(program, "demo", "--quiet", "--out", demo)
    short = ["--set", "control.draws=20", "--set", "control.poses=5", "--set", "control.simulations=2"]
    sprung(program, "control", demo, *short, "--quiet")
    sprung(program, "export", demo, "--format", "mjcf", "--force", "--quiet")
    sprung(program, "export", demo, "--format", "c", "--control", out / "control.json", "--force", "--quiet")
    experiment = tomllib.loads((demo / "experiment.toml").read_text())
    design = json.loads((out / "control.json").read_text())
    joints, period = design["joints"], design["controller"]["period_s"]
    model = mujoco.MjModel.from_xml_path(str(out / "robot.xml"))
    model.opt.timestep = period / SUBSTEPS

    pd = experiment["controller"]
    kp, kd = (np.array(pd[key]) for key in ("kp_nm_per_rad", "kd_nms_per_rad"))
    past = []

    def declared(k, desired, q, phi):
        past.append(phi)
        rate = (past[-1] - past[max(0, len(past) - 6)]) / (5 * period)
        return kp * (desired[0] - phi) + kd * (desired[1] - rate)

    prefix = next(line.split()[1] for line in (out / "robot.h").read_text().splitlines()
                  if line.startswith("struct") and line.rstrip(" {").endswith("_control"))
    code = Code(out, prefix.removesuffix("_control"), len(joints))

    def designed(k, desired, q, phi):
        if k == 0:
            code.start(desired, q, phi)
        return code.step(desired, q, phi)

    rms = lambda errors: np.sqrt((errors**2).mean(axis=0))
    twin = [row["designed_rad"]["identified"] for row in design["proof"]["tracking"]]
    print("| robot | link | PD of the paper, rad rms | designed | ratio | designed, twin |")
    failed = False
    for lacks, robot in ((0.0, "as identified"), (1.0, "with effects that the model lacks")):
        past.clear()
        before, _ = follow(model, joints, experiment, period, declared, lacks)
        after, rest = follow(model, joints, experiment, period, designed, lacks)
        for name, pd_rms, code_rms, known in zip(joints, rms(before), rms(after), twin):
            note(f"MuJoCo {robot}, {name}", f"`{name}`, exported code in MuJoCo, robot {robot}", code_rms, "rad",
                 peer="PD of the paper", peer_value=pd_rms)
            print(f"| {robot} | {name} | {pd_rms:.2e} | {code_rms:.2e} | {pd_rms / code_rms:.0f} | {known:.2e} |")
        print(f"the motors move by {rest:.1e} rad in the last half of a hold of {HOLD} s")
        failed |= np.any(rms(before) < BETTER * rms(after)) or rest > RESTS_RAD
    if failed:
        sys.exit("the designed controller does not keep its limits in MuJoCo")


main()
