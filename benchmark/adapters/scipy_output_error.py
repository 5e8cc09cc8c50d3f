"""Output error: SciPy fits simulated motor positions to the logged ones; least squares then give the links."""
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import butter, filtfilt

sys.path.insert(0, str(Path(__file__).parents[1]))
from tool import Log, links, save

log, out = Log(Path(sys.argv[1])), Path(sys.argv[2])
assert not any(log.rigid), "output error needs springs: a simulated rigid joint drifts"
n, h, sharp, every = log.n, log.dt, log.sharpness, 5
low = lambda x: filtfilt(*butter(2, 2 * h * 20.0), x, axis=0)
q, nominal = low(log.q), log.task["nominal_drives"]
start = np.log(np.array([nominal[k] for k in ("stiffness", "rotor_inertia", "motor_viscous", "motor_coulomb")]))

def motors(theta):
    """Motor positions [N, n, sets] for logarithms [4, n, sets] of the parameters; the links move as measured."""
    k, j, b, c = np.exp(theta)
    x, v, path = log.p[0][:, None] + 0 * k, 0 * k, []
    for now, then, tau in zip(q[:, :, None], np.r_[q[1:], q[-1:]][:, :, None], log.tau[:, :, None]):
        path.append(x)
        rate = lambda x, v, link: (tau - k * (x - link) - b * v - c * np.tanh(sharp * v)) / j
        a = rate(x, v, now)
        d = rate(x + h / 2 * v, v + h / 2 * a, (now + then) / 2)
        e = rate(x + h / 2 * v + h * h / 4 * a, v + h / 2 * d, (now + then) / 2)
        f = rate(x + h * v + h * h / 2 * d, v + h * e, then)
        x, v = x + h * v + h * h / 6 * (a + d + e), v + h / 6 * (a + 2 * d + 2 * e + f)
    return np.array(path[::every])
steps = 1e-4 * np.eye(4)[:, None]
block = lambda x: (motors(x.reshape(4, n, 1) + steps) - motors(x.reshape(4, n, 1))) / 1e-4
jacobian = lambda x: np.einsum("Nis,ij->Nisj", block(x), np.eye(n)).reshape(-1, 4 * n)
fit = least_squares(lambda x: (motors(x.reshape(4, n, 1))[..., 0] - log.p[::every]).ravel(), start.ravel(), jacobian, method="lm", max_nfev=25)
variance = 2 * fit.cost / len(fit.fun) * np.diag(np.linalg.pinv(fit.jac.T @ fit.jac))
motor = np.exp(fit.x).reshape(4, n)
bodies, viscous, coulomb = links(log, motor[0], low)
errors = np.r_[motor * np.sqrt(variance).reshape(4, n), np.full((2, n), np.nan)]
save(out, "SciPy output error", np.r_[motor, [viscous, coulomb]], errors, bodies)
