"""Identifies the arm with seven flexible joints with packages of PyPI: accelerations by
differences, Pinocchio's regressor for each sample, and one dense least-squares problem.

    python identify_pinocchio.py LOG.csv
"""

import resource
import sys
import time

import numpy as np
import pinocchio as pin
from scipy.linalg import qr
from scipy.signal import butter, sosfiltfilt

import seven_joints as arm

CUTOFF_HZ = 40.0
ORDER = 4
HOUR = 3_600_000


def mebibytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def base_columns(model, data):
    """Returns linearly independent columns of the rigid regressor."""
    rng = np.random.default_rng(1)
    draws = rng.uniform(-2.0, 2.0, (200, 3, arm.N))
    rows = np.vstack([pin.computeJointTorqueRegressor(model, data, *draw) for draw in draws])
    _, r, order = qr(rows, mode="economic", pivoting=True)
    size = abs(np.diag(r))
    return np.sort(order[size > 1e-9 * size[0]])


def main():
    before = mebibytes()
    start = time.perf_counter()
    t, q, phi, tau = arm.read(sys.argv[1])
    read = time.perf_counter()
    period = (t[-1] - t[0]) / (len(t) - 1)
    sos = butter(ORDER, CUTOFF_HZ, output="sos", fs=1.0 / period)
    q, phi, tau = (sosfiltfilt(sos, x, axis=0) for x in (q, phi, tau))
    dq, dphi = (np.gradient(x, period, axis=0) for x in (q, phi))
    ddq, ddphi = (np.gradient(x, period, axis=0) for x in (dq, dphi))
    n, samples = arm.N, len(t)

    model = arm.pinocchio_model()
    data = model.createData()
    base = base_columns(model, data)
    links = len(base)
    # Columns: links, then stiffness, preload, link friction, motor friction and rotors.
    a = np.zeros((2 * n, samples, links + 7 * n))
    b = np.zeros((2 * n, samples))
    b[n:] = tau.T
    for k in range(samples):
        y = pin.computeJointTorqueRegressor(model, data, q[k], dq[k], ddq[k])
        a[:n, k, :links] = y[:, base]
    for i in range(n):
        link, motor, column = a[i], a[n + i], links + 7 * i
        link[:, column] = q[:, i] - phi[:, i]
        link[:, column + 1] = 1.0
        link[:, column + 2] = dq[:, i]
        link[:, column + 3] = np.tanh(arm.BETA * dq[:, i])
        motor[:, column] = phi[:, i] - q[:, i]
        motor[:, column + 1] = -1.0
        motor[:, column + 4] = dphi[:, i]
        motor[:, column + 5] = np.tanh(arm.BETA * dphi[:, i])
        motor[:, column + 6] = ddphi[:, i]
    a, b = a.reshape(-1, a.shape[2]), b.reshape(-1)
    norms = np.linalg.norm(a, axis=0)
    a /= norms
    theta = np.linalg.lstsq(a, b, rcond=None)[0] / norms
    seconds = time.perf_counter() - start
    peak = mebibytes()
    stiffness = theta[links::7]
    for i in range(n):
        print(f"joint{i + 1}.stiffness {stiffness[i]:.8g}")
    print(f"parameters {len(theta)}, of which links {links}")
    print(f"seconds {seconds:.2f}, of which reading {read - start:.2f}")
    print(f"MiB {peak:.0f}, of which before the log {before:.0f}")
    hour = HOUR / samples
    print(f"an hour, extrapolated: seconds {hour * seconds:.0f}, "
          f"GiB {(before + hour * (peak - before)) / 1024:.0f}")


if __name__ == "__main__":
    main()
