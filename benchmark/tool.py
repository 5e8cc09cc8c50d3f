"""What an adapter in Python needs: `Log(folder)` reads a task, `save` writes the file of parameters."""
import json

import numpy as np

from model import Chain
from tasks import DRIVES


class Log:
    """A training log: t [N], and q, p (motor), tau [N, n]; a rigid joint has p = q."""

    def __init__(self, folder):
        self.task = json.loads((folder / "task.json").read_text())
        self.chain, self.sharpness = Chain(self.task["joints"], self.task["gravity"]), self.task["sharpness_s_per_rad"]
        self.n, joints = self.chain.n, self.task["joints"]
        table = np.loadtxt(folder / "train.csv", delimiter=",", skiprows=1)
        log = dict(zip(self.task["columns"], table.T))
        self.t, self.rigid = log["t"], [bool(joint.get("rigid")) for joint in joints]
        column = lambda kind: np.stack([log[f"{kind}{i}"] for i in range(1, self.n + 1)], 1)
        self.p, self.tau = column("phi"), column("tau")
        self.q = np.stack([log.get(f"q{i + 1}", self.p[:, i]) for i in range(self.n)], 1)
        self.dt = float(np.median(np.diff(self.t)))


def links(log, stiffness, low):
    """Bodies [n, 10], viscous and Coulomb friction of the links by least squares, where the springs are known."""
    n, q = log.n, low(log.q)
    dq, a = np.gradient(q, log.dt, axis=0), np.zeros((len(q), n, 12 * n))
    a[..., : 10 * n] = log.chain.regressor(q, dq, np.gradient(dq, log.dt, axis=0))
    for i in range(n):
        a[:, i, 10 * n + i], a[:, i, 11 * n + i] = dq[:, i], np.tanh(log.sharpness * dq[:, i])
    b = stiffness * (low(log.p) - q)
    theta = np.linalg.lstsq(low(a)[300:-300].reshape(-1, 12 * n), b[300:-300].ravel(), rcond=1e-7)[0]
    return theta[: 10 * n].reshape(n, 10), theta[10 * n : 11 * n], theta[11 * n :]


def save(out, tool, drives, errors, bodies, more=None):
    """`drives` and `errors` [6, n] in the order of `DRIVES` (NaN: not identified), `bodies` [n, 10], `more` other values."""
    values = {f"joint{i + 1}.{key}": [drives[k][i], errors[k][i]] for k, key in enumerate(DRIVES) for i in range(len(bodies))}
    values = {name: [v, e if np.isfinite(e) else None] for name, (v, e) in values.items() if np.isfinite(v)}
    named = {f"link{i + 1}": np.asarray(b, float).tolist() for i, b in enumerate(bodies)}
    out.write_text(json.dumps({"tool": tool, "parameters": values | (more or {}), "bodies": named}))
