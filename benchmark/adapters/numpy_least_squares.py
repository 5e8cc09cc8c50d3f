"""The paper's method: positions filtered with zero phase, all rows through one low-pass filter, least squares."""
import sys
from pathlib import Path

import numpy as np
from scipy.signal import butter, filtfilt, lfilter

sys.path.insert(0, str(Path(__file__).parents[1]))
from tool import Log, save

log, out = Log(Path(sys.argv[1])), Path(sys.argv[2])
n, dt = log.n, log.dt
smooth = lambda x: filtfilt(*butter(2, 2 * dt * log.task.get("cutoff_hz", 20.0)), x, axis=0)
pole = np.exp(-30.0 * dt)                                   # the paper's corner of 30 rad/s
low = lambda x: lfilter([1 - pole], [1, -pole], x, axis=0)
q, p, tau = smooth(log.q), smooth(log.p), smooth(log.tau)
rate = lambda x: np.gradient(x, dt, axis=0)
dq, dp = rate(q), rate(p)
sign = lambda v: np.tanh(log.sharpness * v)
rows = np.zeros((len(q), 2, n, 10 * n + 7 * n))             # rows of links, then of motors
link = log.chain.regressor(q, dq, rate(dq))
for i in range(n):
    c, motor = 10 * n + 7 * i, rows[:, 1, i]
    motor[:, c + 1 : c + 4] = np.stack([rate(dp)[:, i], dp[:, i], sign(dp[:, i])], 1)
    if log.rigid[i]:                                        # one row: the motor moves the link
        motor[:, : 10 * n], motor[:, c + 6] = link[:, i], 1
    else:
        rows[:, 0, i, : 10 * n], rows[:, 0, i, c], motor[:, c] = link[:, i], (q - p)[:, i], (p - q)[:, i]
        rows[:, 0, i, c + 4 : c + 6] = np.stack([dq[:, i], sign(dq[:, i])], 1)
cut = slice(int(0.3 / dt), -int(0.3 / dt))
a = low(rows)[cut].reshape(-1, 17 * n)
b = low(np.stack([0 * tau, tau], 1))[cut].ravel()
scale = np.maximum(np.linalg.norm(a, axis=0), 1e-9)
theta = np.linalg.lstsq(a / scale, b, rcond=1e-7)[0]
inverse = np.linalg.pinv((a / scale).T @ (a / scale), rcond=1e-12, hermitian=True)
error = np.sqrt(np.maximum(np.diag(inverse), 0) * np.mean((b - a / scale @ theta) ** 2)) / scale
theta = np.where(scale > 1e-9, theta / scale, np.nan)
drives, errors = (x[10 * n :].reshape(n, 7).T for x in (theta, error))
offsets = {f"joint{i + 1}.motor_offset": drives[6, i] for i in range(n) if log.rigid[i]}
save(out, "NumPy least squares", drives[:6], errors[:6], np.nan_to_num(theta[: 10 * n].reshape(n, 10)), offsets)
