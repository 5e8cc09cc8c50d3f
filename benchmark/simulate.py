"""Simulated tasks: `simulate.py OUT [TASK…]` writes a folder for each, with `hidden/` for the scorer.

Runge-Kutta steps of 0.5 ms; the controller reads the motor at 1 kHz and holds its torque for 1 ms. All logs of one kind of
robot are integrated together. Encoders have 2^19 counts per turn (links) and 2^13 per motor turn, gear 100; the logged
torque has noise of 0.3 % of the rated torque.
"""
import json
import sys
from pathlib import Path

import numpy as np

from model import Chain, inertias
from tasks import DRIVES, EFFECTS, GRAVITY, ROBOTS, SHARES, SHARPNESS, SLIPS, TASKS, TURN

STEP, SUBSTEPS, HELD_OUT_SECONDS = 5e-4, 2, 6
Q_COUNTS, PHI_COUNTS, NOISE = 2**19, 2**13 * 100, 0.003


def truth(task):
    """True drives [6, n], bodies [n, 10] and effects of a task: those of its kind of robot, changed at random."""
    robot, g = ROBOTS[task["robot"]], np.random.default_rng(task["seed"])
    n = len(robot["joints"])
    drives = np.array(robot["drives"]).T * np.exp(0.25 * g.normal(size=(6, n)))
    bodies = np.array(robot["bodies"]) * np.exp(0.15 * g.normal(size=(n, 1)))
    bodies[:, 1:4] *= 1 + 0.05 * g.normal(size=(n, 3))
    return drives, bodies, {key: task["effects"].get(key, 0.0) for key in EFFECTS}


def reference(robot, g, t):
    """Sines that fade in, position and velocity [samples, n]."""
    n = len(robot["start"])
    f = np.sort(np.exp(g.uniform(np.log(0.12), np.log(1.8), (n, 6))), 1)
    a = f**-0.8 * (0.6 + 0.8 * g.random((n, 6)))
    a *= 0.8 * np.array(robot["amplitude"])[:, None] / a.sum(1, keepdims=True)
    phase = g.uniform(0, TURN, (n, 6))
    s = np.clip(t / 1.0, 0, 1)
    s = s * s * (3 - 2 * s)
    x = robot["start"] + s[:, None] * (a * np.sin(TURN * f * t[:, None, None] + phase)).sum(2)
    return x, np.gradient(x, t, axis=0)


def spring(d, z, stiffness, effects):
    """Torque of springs with backlash and elements of hysteresis at `z`."""
    free = effects["backlash_rad"]
    return stiffness * (d - np.clip(d, -free, free)) + effects["hysteresis"] * stiffness * (z @ SHARES)


def run(name, tasks):
    """Integrates all logs of one kind of robot; returns exact states and torques, [samples, logs, ...]."""
    robot = ROBOTS[name]
    chain, logs = Chain(robot["joints"], GRAVITY), [(t, held) for t in tasks for held in (0, 1)]
    truths = [truth(t) for t, _ in logs]
    drives, inertia = np.array([x[0] for x in truths]), inertias([x[1] for x in truths])
    effects = {key: np.array([x[2][key] for x in truths])[:, None] for key in EFFECTS}
    k, j, bm, cm, bl, cl = drives.transpose(1, 0, 2)
    seconds = max(t["seconds"] for t in tasks)
    t = np.arange(round(seconds * 1000)) / 1000
    x = [reference(robot, np.random.default_rng(10 * task["seed"] + held), t) for task, held in logs]
    want, rate = (np.stack([y[i] for y in x], 1) for i in (0, 1))
    weight = np.stack([chain.dynamics(inertia[i], want[:, i], 0 * want[:, i])[1] for i in range(len(logs))], 1)

    def rates(q, dq, p, dp, z, tau):
        elastic = spring(p - q, z, k, effects)
        mass, other = chain.dynamics(inertia, q, dq)
        force = elastic - other - bl * dq - cl * np.tanh(SHARPNESS * dq)
        friction = bm * dp + (cm + effects["load_friction"] * np.abs(elastic)) * np.tanh(SHARPNESS * dp)
        return np.linalg.solve(mass, force[..., None])[..., 0], (tau - elastic - friction) / j

    def slid(z, change):
        return np.clip(z + change[..., None], -SLIPS, SLIPS)

    q, dq, dp = want[0].copy(), 0 * want[0], 0 * want[0]
    p, z, h = q + weight[0] / k, np.zeros((*q.shape, 4)), STEP
    out = []
    for i in range(len(t)):
        read = np.round(p * PHI_COUNTS / TURN) * TURN / PHI_COUNTS
        tau = np.array(robot["gain"]) * (want[i] + weight[0] / k - read) + np.array(robot["damping"]) * (rate[i] - dp) + weight[i]
        first = True
        for _ in range(SUBSTEPS):
            def at(hq, hdq, hp, hdp, d0=p - q, z0=z):
                return rates(hq, hdq, hp, hdp, slid(z0, hp - hq - d0), tau)
            a1, b1 = at(q, dq, p, dp)
            if first:
                out.append([q, dq, a1, p, dp, b1, tau])
                history = z
                first = False
            a2, b2 = at(q + h / 2 * dq, dq + h / 2 * a1, p + h / 2 * dp, dp + h / 2 * b1)
            a3, b3 = at(q + h / 2 * dq + h * h / 4 * a1, dq + h / 2 * a2, p + h / 2 * dp + h * h / 4 * b1, dp + h / 2 * b2)
            a4, b4 = at(q + h * dq + h * h / 2 * a2, dq + h * a3, p + h * dp + h * h / 2 * b2, dp + h * b3)
            d = p - q
            q, dq = q + h * dq + h * h / 6 * (a1 + a2 + a3), dq + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            p, dp = p + h * dp + h * h / 6 * (b1 + b2 + b3), dp + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
            z = slid(z, p - q - d)
        out[-1].append(history @ SHARES)
    return t, [np.array([row[i] for row in out]) for i in range(8)]


URDF = '<joint name="joint{i}" type="{k}"><parent link="link{b}"/><child link="link{i}"/><origin xyz="{o}" rpy="{r}"/><axis xyz="{a}"/><limit lower="-3" upper="3" effort="{e}" velocity="6"/></joint>'


def urdf(robot):
    """The robot with nominal bodies."""
    text = ['<?xml version="1.0"?>', '<robot name="twin"><link name="link0"/>']
    words = lambda x: " ".join(f"{v:.9g}" for v in x)
    for i, (joint, b) in enumerate(zip(robot["joints"], robot["bodies"]), 1):
        c = b[1:4] / b[0]
        about = np.array([[b[4], b[5], b[7]], [b[5], b[6], b[8]], [b[7], b[8], b[9]]]) - b[0] * (c @ c * np.eye(3) - np.outer(c, c))
        names = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
        values = " ".join(f'{key}="{about[place]:.9g}"' for key, place in names.items())
        text.append(f'<link name="link{i}"><inertial><origin xyz="{words(c)}"/><mass value="{b[0]:.9g}"/><inertia {values}/></inertial></link>')
        text.append(URDF.format(i=i, b=i - 1, o=words(joint["origin"]), r=words(joint["rpy"]), a=words(joint["axis"]), k="prismatic" if joint.get("prismatic") else "revolute", e=robot["rated"][i - 1]))
    return "\n".join(text) + "\n</robot>\n"


def columns(n):
    return ["t", *(f"{kind}{i}" for kind in ("q", "phi", "tau") for i in range(1, n + 1))]


def write(out, name, task, t, states, column):
    """Writes a task: what a tool gets, and in `hidden` what the scorer needs."""
    robot, (drives, bodies, effects) = ROBOTS[task["robot"]], truth(task)
    n, folder = len(robot["joints"]), out / name
    (folder / "hidden").mkdir(parents=True, exist_ok=True)
    (folder / "robot.urdf").write_text(urdf(robot))
    noise = NOISE * np.array(robot["rated"])
    for held, log in enumerate(("train", "test")):
        count = round(1000 * (HELD_OUT_SECONDS if held else task["seconds"]))
        q, dq, ddq, p, dp, ddp, tau, stops = (x[:count, column + held] for x in states)
        g = np.random.default_rng(task["seed"] + 1000 * held)
        late = lambda kind, x: np.stack([np.interp(t[:count] - task["delay"].get(kind, 0), t[:count], c) for c in x.T], 1)
        rounded = lambda x, counts: np.round(x * counts / TURN + g.random(n)) * TURN / counts
        step = 1000 // task["rate"]
        table = np.c_[t[:count], rounded(late("q", q), Q_COUNTS), rounded(p, PHI_COUNTS), late("tau", tau) + noise * g.normal(size=tau.shape)][::step]
        head = columns(n)[: 1 + 2 * n] if held else columns(n)
        np.savetxt(folder / f"{log}.csv", table[:, : len(head)], "%.9g", ",", header=",".join(head), comments="")
        np.savez_compressed(folder / "hidden" / f"{log}.npz", q=q, dq=dq, ddq=ddq, p=p, dp=dp, ddp=ddp, tau=tau, stops=stops)
    names = lambda rows, keys: {f"joint{i + 1}.{key}": [float(rows[k][i]), 0.0] for i in range(n) for k, key in enumerate(keys)}
    values = names(drives, DRIVES) | names([[effects[key]] * n for key in EFFECTS], EFFECTS)
    best = {"tool": "truth", "parameters": values, "bodies": {f"link{i + 1}": list(map(float, b)) for i, b in enumerate(bodies)}}
    (folder / "hidden" / "truth.json").write_text(json.dumps(best, indent=1))
    public = dict(name=name, columns=columns(n), joints=robot["joints"], gravity=GRAVITY, rate_hz=task["rate"], sharpness_s_per_rad=SHARPNESS,
                  nominal_bodies=[list(map(float, b)) for b in robot["bodies"]], nominal_drives=dict(zip(DRIVES, np.array(robot["drives"]).T.tolist())),
                  torque_noise_nm=noise.tolist(), position_noise_rad=[TURN / Q_COUNTS / 12**0.5, TURN / PHI_COUNTS / 12**0.5])
    (folder / "task.json").write_text(json.dumps(public, indent=1))


def main(out, only):
    for kind in ROBOTS:
        chosen = {k: v for k, v in TASKS.items() if v["kind"] == "twin" and v["robot"] == kind and (not only or k in only)}
        if chosen and not all((out / name / "task.json").exists() for name in chosen):
            t, states = run(kind, list(chosen.values()))
            for column, (name, task) in enumerate(chosen.items()):
                write(out, name, task, t, states, 2 * column)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
