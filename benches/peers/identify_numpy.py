"""Identifies by least squares from a CSV log, vectorised in NumPy. It does the same
work as `sprung identify` with the estimator "least-squares".

    python identify_numpy.py LOG.csv
"""

import sys
import time

import numpy as np
import pandas as pd
from scipy.signal import butter, lfilter, lfiltic, sosfiltfilt

BETA = 100.0
CUTOFF = 30.0
POSITION_CUTOFF_HZ = 10.0
POSITION_ORDER = 2

COLUMNS = ["t_s", "q1_rad", "q2_rad", "phi1_rad", "phi2_rad", "tau1_nm", "tau2_nm"]


def smooth(positions, period):
    """Returns positions filtered without phase shift, and their central differences."""
    rate = 1.0 / period
    sos = butter(POSITION_ORDER, POSITION_CUTOFF_HZ, output="sos", fs=rate)
    padding = round(3 * rate / POSITION_CUTOFF_HZ)
    x = sosfiltfilt(sos, positions, axis=0, padtype="odd", padlen=padding)
    return x[1:-1], (x[2:] - x[:-2]) / (2 * period)


def rows(x, dx):
    """Yields for each row its columns of theta, the entries under d/dt, and the other entries."""
    q1, q2, p1, p2 = x.T
    dq1, dq2, dp1, dp2 = dx.T
    s, c = np.sin(q2), np.cos(q2)
    none = np.zeros_like(q1)
    friction = np.tanh(BETA * dx).T
    yield (
        [0, 1, 2, 5, 9, 11],
        [dq1, (2 * dq1 + dq2) * c, dq2, none, none, none],
        [none, none, none, dq1, q1 - p1, friction[0]],
    )
    yield (
        [1, 2, 6, 10, 12],
        [dq1 * c, dq1 + dq2, none, none, none],
        [dq1 * (dq1 + dq2) * s, none, dq2, q2 - p2, friction[1]],
    )
    yield [3, 7, 9, 13], [dp1, none, none, none], [none, dp1, p1 - q1, friction[2]]
    yield [4, 8, 10, 14], [dp2, none, none, none], [none, dp2, p2 - q2, friction[3]]


def start_at_rest(b, a, x):
    """Filters with the initial state that makes the first output zero."""
    state = lfiltic(b, a, [0.0], x[:1])
    return np.concatenate([[0.0], lfilter(b, a, x[1:], zi=state)[0]])


def solve(x, dx, tau, period):
    lt = CUTOFF * period
    pole = [1.0, (lt - 2) / (2 + lt)]
    low, rate = [lt / (2 + lt)] * 2, [2 * CUTOFF / (2 + lt), -2 * CUTOFF / (2 + lt)]
    held = [0.0, -np.expm1(-lt)], [1.0, -np.exp(-lt)]
    n = len(x)
    a, b = np.zeros((4 * n, 15)), np.zeros(4 * n)
    for row, (columns, momentum, rest) in enumerate(rows(x, dx)):
        part = slice(row * n, (row + 1) * n)
        for column, y_a, y_b in zip(columns, momentum, rest):
            a[part, column] = start_at_rest(rate, pole, y_a) + start_at_rest(low, pole, y_b)
        if row >= 2:
            b[part] = start_at_rest(*held, tau[:, row - 2])
    norms = np.linalg.norm(a, axis=0)
    a /= norms
    return np.linalg.lstsq(a, b, rcond=None)[0] / norms


def main():
    start = time.perf_counter()
    log = pd.read_csv(sys.argv[1], usecols=COLUMNS)[COLUMNS].to_numpy()
    read = time.perf_counter()
    period = (log[-1, 0] - log[0, 0]) / (len(log) - 1)
    x, dx = smooth(log[:, 1:5], period)
    theta = solve(x, dx, log[1:-1, 5:], period)
    end = time.perf_counter()
    for index, value in enumerate(theta):
        print(f"theta{index + 1} {value:.17g}")
    print(f"seconds {end - start:.4f} of which reading {read - start:.4f}")


if __name__ == "__main__":
    main()
