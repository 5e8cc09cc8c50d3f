"""Simulates the demo's closed loop without sensors for 10 s by the Runge-Kutta method of
order 4 with a fixed step, compiled by Numba.

    python simulate_numba.py [SECONDS]
"""

import sys
import time

import numpy as np
from numba import njit

THETA = np.array([
    0.207184, 0.017580, 0.013163, 0.216776, 0.006842, 0.037675, 0.002959, 8.435283,
    0.135564, 9.358730, 4.212811, 0.015771, 0.005018, 1.360210, 0.162529,
])
BETA = 100.0
PERIOD = 1e-3
KP = np.array([50.0, 5.0])
KD = np.array([0.05, 0.01])
WINDOW = 5
AMPLITUDE = np.radians(3.0)
# Frequency in Hz and phase in degrees of each joint's sines.
SINES = np.array([
    [[1.0, 0.0], [0.5, 30.0], [0.2, 45.0]],
    [[0.2, 0.0], [1.0, 36.0], [0.5, 90.0]],
])


@njit
def rate(x, tau, out):
    """Writes the time derivative of the state x = [q, phi, dq, dphi] into out."""
    s, c = np.sin(x[1]), np.cos(x[1])
    f1 = THETA[9] * (x[2] - x[0]) - THETA[5] * x[4] - THETA[11] * np.tanh(BETA * x[4])
    f2 = THETA[10] * (x[3] - x[1]) - THETA[6] * x[5] - THETA[12] * np.tanh(BETA * x[5])
    f1 += THETA[1] * s * x[5] * (2 * x[4] + x[5])
    f2 -= THETA[1] * s * x[4] * x[4]
    m11 = THETA[0] + 2 * THETA[1] * c
    m12 = THETA[2] + THETA[1] * c
    m22 = THETA[2]
    det = m11 * m22 - m12 * m12
    for i in range(4):
        out[i] = x[4 + i]
    out[4] = (m22 * f1 - m12 * f2) / det
    out[5] = (m11 * f2 - m12 * f1) / det
    for i in range(2):
        spring = THETA[9 + i] * (x[2 + i] - x[i])
        friction = THETA[7 + i] * x[6 + i] + THETA[13 + i] * np.tanh(BETA * x[6 + i])
        out[6 + i] = (tau[i] - spring - friction) / THETA[3 + i]


@njit
def ahead(x, h, k, y):
    for i in range(8):
        y[i] = x[i] + h * k[i]


@njit
def simulate(samples, substeps):
    h = PERIOD / substeps
    x, y = np.zeros(8), np.empty(8)
    k1, k2, k3, k4 = np.empty(8), np.empty(8), np.empty(8), np.empty(8)
    tau, past = np.zeros(2), np.zeros((2, 2 * WINDOW))
    states = np.empty((samples, 8))
    for k in range(samples):
        states[k] = x
        t = k * PERIOD
        for i in range(2):
            for j in range(2 * WINDOW - 1, 0, -1):
                past[i, j] = past[i, j - 1]
            past[i, 0] = x[2 + i]
            velocity = past[i, :WINDOW].sum() - past[i, WINDOW:].sum()
            velocity /= WINDOW * WINDOW * PERIOD
            wanted, speed = 0.0, 0.0
            for j in range(3):
                w = 2 * np.pi * SINES[i, j, 0]
                angle = w * t + np.radians(SINES[i, j, 1])
                wanted += AMPLITUDE * np.sin(angle)
                speed += AMPLITUDE * w * np.cos(angle)
            tau[i] = KP[i] * (wanted - x[2 + i]) + KD[i] * (speed - velocity)
        for _ in range(substeps):
            rate(x, tau, k1)
            ahead(x, 0.5 * h, k1, y)
            rate(y, tau, k2)
            ahead(x, 0.5 * h, k2, y)
            rate(y, tau, k3)
            ahead(x, h, k3, y)
            rate(y, tau, k4)
            for i in range(8):
                x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
    return states


def main():
    samples = round(float(sys.argv[1] if len(sys.argv) > 1 else 10.0) / PERIOD)
    simulate(10, 10)  # compiles
    start = time.perf_counter()
    states = simulate(samples, 10)
    seconds = time.perf_counter() - start
    fine = simulate(samples, 40)
    print(f"seconds {seconds:.4f}")
    print(f"last state {states[-1]}")
    print(f"position error {abs(states - fine)[:, :4].max():.1e} rad")


if __name__ == "__main__":
    main()
