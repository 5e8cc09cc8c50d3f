"""Tasks of real machines: `real.py OUT LOGS` writes a folder for each whose files are below the folder LOGS.

The folder of the benchmark does not hold these logs. Of a missing or changed file this prints name, source, licence and SHA-256.
"""
import hashlib
import json
import sys
from pathlib import Path

import numpy as np
from scipy.io import loadmat
from scipy.signal import butter, filtfilt

from simulate import urdf
from tasks import TASKS, joint


def dh(rows, classic=False):
    """Joints from Denavit-Hartenberg rows (a m, alpha deg, d m, theta deg), modified or classic."""
    out, before = [], (0, 0, 0, 0)
    for row in rows:
        a, alpha, d, _ = (before if classic else row)
        tilt, before = np.radians(alpha), row
        origin = (a, 0, d) if classic else (a, -np.sin(tilt) * d, np.cos(tilt) * d)
        out.append(joint(origin, (tilt, 0, 0)))
        spin = np.radians(row[3])                           # Rx(tilt) Rz(spin) as roll, pitch, yaw
        turned = np.array(out[-1]["rotation"]) @ [[np.cos(spin), -np.sin(spin), 0], [np.sin(spin), np.cos(spin), 0], [0, 0, 1]]
        out[-1] = joint(origin, (np.arctan2(turned[2, 1], turned[2, 2]), -np.arcsin(turned[2, 0]), np.arctan2(turned[1, 0], turned[0, 0])))
    return out


def emps(files):
    def log(mat):
        x = loadmat(mat)
        return x["t"].ravel(), None, x["qm"].reshape(-1, 1), (x["gtau"].ravel() * x["vir"].ravel()).reshape(-1, 1)
    slide = joint((0, 0, 0), (0, 0, 0), prismatic=True, rigid=True)
    return [slide], [0, -9.81, 0], 1000, 60, 2000.0, *map(log, files)


def panda(files):
    def log(csv):
        x = np.loadtxt(csv, delimiter=",", skiprows=1)
        _, first = np.unique(x[:, 0], return_index=True)
        return x[first, 0], None, x[first, 1:8], x[first, 15:22]
    rows = [(0, 0, 0.333, 0), (0, -90, 0, 0), (0, 90, 0.316, 0), (0.0825, 90, 0, 0), (-0.0825, -90, 0.384, 0), (0, 90, 0, 0), (0.088, 90, 0, 0)]
    return [j | {"rigid": True} for j in dh(rows)], [0, 0, -9.81], 1000, 5, 100.0, *map(log, files)


def kr300(files):
    gear = np.array([256.857142857, 267.428571429, 252.333333333, 221.0, 239.619047619, 154.323134328])
    def log(mat):
        x = loadmat(mat, squeeze_me=True, struct_as_record=False)["rec"]
        rows = lambda name: np.atleast_2d(getattr(x, name)).T
        return np.ravel(x.time_cont), np.radians(rows("act_pos_se_deg"))[:, :3], np.radians(rows("act_pos_mot_deg")), rows("act_torque_abs_nm") * gear
    rows = [(0.35, 90, -0.675, 0), (1.15, 0, -0.189, -90), (0.041, -90, 0.189, 180), (0, 90, -1, 0), (0, -90, 0, 0), (0, 180, -0.24, 0)]
    return [j | {"rigid": i > 2} for i, j in enumerate(dh(rows, True))], [0, 0, 9.81], 250, 8, 100.0, *map(log, files)


def write(folder, name, joints, gravity, rate, cutoff, sharpness, train, test):
    n = len(joints)
    links = 0 if train[1] is None else train[1].shape[1]
    head = ["t", *(f"q{i}" for i in range(1, links + 1)), *(f"{kind}{i}" for kind in ("phi", "tau") for i in range(1, n + 1))]
    (folder / "hidden").mkdir(parents=True, exist_ok=True)
    for file, log, used in (("train", train, len(head)), ("test", test, len(head) - n)):
        table = np.c_[tuple(x for x in log if x is not None)]
        np.savetxt(folder / f"{file}.csv", table[:, :used], "%.9g", ",", header=",".join(head[:used]), comments="")
    t, q, p, tau = test
    low = lambda x: filtfilt(*butter(2, 2 * cutoff / rate), x, axis=0)
    q = p if q is None else np.c_[q, p[:, links:]]
    d = lambda x: np.gradient(x, 1 / rate, axis=0)
    q, p, tau = low(q), low(p), low(tau)
    cut = slice(rate // 2, -(rate // 2))
    s = dict(q=q, dq=d(q), ddq=d(d(q)), p=p, dp=d(p), ddp=d(d(p)), tau=tau)
    np.savez_compressed(folder / "hidden" / "test.npz", **{key: x[cut] for key, x in s.items()})
    bodies = np.tile([1.0, 0, 0, 0, 0.1, 0, 0.1, 0, 0, 0.1], (n, 1))
    (folder / "robot.urdf").write_text(urdf(dict(joints=joints, bodies=bodies, rated=[1e4] * n)))
    public = dict(name=name, columns=head, joints=joints, gravity=gravity, rate_hz=rate, cutoff_hz=cutoff, sharpness_s_per_rad=sharpness)
    (folder / "task.json").write_text(json.dumps(public, indent=1))


def main(out, logs):
    for name, task in TASKS.items():
        if task["kind"] != "real":
            continue
        found, lacking = [], []
        for file, digest in task["files"].items():
            paths = [p for p in logs.rglob(file) if hashlib.sha256(p.read_bytes()).hexdigest() == digest] if logs.is_dir() else []
            found += paths[:1]
            lacking += [] if paths else [f"{file} (SHA-256 {digest})"]
        if lacking:
            print(f"skipped {name}: not below {logs}: {', '.join(lacking)}\n  source: {task['source']}\n  licence: {task['licence']}")
        else:
            write(out / name, name, *globals()[name](found))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
