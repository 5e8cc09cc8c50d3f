"""The physics of the foreign logs: a serial arm with springs, compiled by Numba. Nothing of sprung is used.

    python simulate.py

The command compares the dynamics with those of Pinocchio at random states, and Runge-Kutta steps of 0.1 ms with steps of
0.05 ms. Pinocchio reads the links from the URDF.
"""

import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("NUMBA_CACHE_DIR", os.path.join(tempfile.gettempdir(), "foreign-numba"))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402
from numba import njit  # noqa: E402

GRAVITY, STEP_S, PERIOD_S = 9.81, 1e-4, 1e-3
# Deflection at which the hysteresis of a spring slides.
SLIDING_RAD = 3e-4
DRIVE = ("stiffness", "rotor_inertia", "link_viscous", "link_coulomb", "motor_viscous", "motor_coulomb")

# Nominal drives after the gear, centre of the motion, and gains of the controller; SI units.
ARMS = {
    "ur5": dict(
        urdf="ur_description/urdf/ur5_robot.urdf",
        joints=["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint",
                "wrist_3_joint"],
        centre=[0.2, -1.2, 1.0, -0.8, 0.6, 0.3], gear=101,
        stiffness=[25e3, 25e3, 15e3, 4e3, 4e3, 3e3], rotor_inertia=[2.8, 2.8, 1.6, 0.25, 0.25, 0.2],
        link_viscous=[1.5, 1.5, 1.0, 0.3, 0.3, 0.2], link_coulomb=[1.0, 1.2, 0.8, 0.3, 0.3, 0.2],
        motor_viscous=[18, 18, 12, 3, 3, 2.5], motor_coulomb=[9, 10, 7, 2.0, 2.0, 1.8],
        kp=[6e3, 6e3, 4e3, 8e2, 8e2, 6e2], kd=[180, 180, 110, 20, 20, 16]),
    "panda": dict(
        urdf="panda_description/urdf/panda.urdf",
        joints=[f"panda_joint{k}" for k in range(1, 8)],
        centre=[0.1, -0.4, 0.2, -1.7, 0.3, 1.6, 0.5], gear=100,
        stiffness=[14e3, 14e3, 10e3, 10e3, 5e3, 4e3, 3e3], rotor_inertia=[0.9, 0.9, 0.6, 0.6, 0.25, 0.2, 0.15],
        link_viscous=[0.8, 0.8, 0.6, 0.6, 0.2, 0.2, 0.1], link_coulomb=[0.5, 0.6, 0.4, 0.4, 0.15, 0.15, 0.1],
        motor_viscous=[6, 6, 5, 5, 2, 2, 1.5], motor_coulomb=[2.5, 2.5, 2, 2, 1.0, 1.0, 0.8],
        kp=[3e3, 3e3, 2e3, 2e3, 5e2, 4e2, 3e2], kd=[90, 90, 60, 60, 16, 13, 10]),
}


@dataclass
class Robot:
    """A random robot.

    Each parameter of a drive is the nominal one times exp(0.3 normal). The bodies are those of the URDF with mass and
    inertia times exp(0.15 normal) and the centre of mass moved by 5 mm.
    """

    arm: str
    seed: int
    sharpness: float

    def __post_init__(self):
        self.of = ARMS[self.arm]
        self.urdf = urdf_of(self.of["urdf"])
        self.joints, self.centre = self.of["joints"], np.array(self.of["centre"])
        full = pin.buildModelFromUrdf(str(self.urdf))
        locked = [full.getJointId(name) for name in list(full.names)[1:] if name not in self.joints]
        self.model = pin.buildReducedModel(full, locked, pin.neutral(full))
        self.n = self.model.nv
        bodies = np.random.default_rng(self.seed + 55555)
        for k in range(1, self.n + 1):
            body, scale = self.model.inertias[k], float(np.exp(0.15 * bodies.normal()))
            lever = body.lever + 0.005 * bodies.normal(size=3)
            self.model.inertias[k] = pin.Inertia(body.mass * scale, lever, body.inertia * scale)
        random = np.random.default_rng(self.seed)
        self.drive = {key: np.array(self.of[key], float) * np.exp(0.3 * random.normal(size=self.n)) for key in DRIVE}
        self.phase = random.uniform(0, 2 * np.pi, self.n)
        # Half widths of the plays of the gears, rad.
        self.play = np.zeros(self.n)
        # Hysteresis of the springs: stiffness of a part that slides, over the stiffness.
        self.sliding = np.zeros(self.n)

    def chain(self):
        """Rotations a + b sin q + c cos q, origins, axes, masses, centres of mass and inertias about them."""
        turns, bodies = [], []
        for k in range(1, self.n + 1):
            place, body = self.model.jointPlacements[k], self.model.inertias[k]
            axis = np.eye(3)["XYZ".index(self.model.joints[k].shortname()[-1])]
            parts = np.outer(axis, axis), pin.skew(axis), -pin.skew(axis) @ pin.skew(axis)
            turns.append((*(place.rotation @ part for part in parts), place.translation, axis))
            bodies.append((body.mass, body.lever, body.inertia))
        return tuple(np.array(part) for part in (*zip(*turns), *zip(*bodies)))


def urdf_of(path):
    """Returns a URDF of the package example-robot-data."""
    for folder in map(Path, sys.path):
        found = folder / "cmeel.prefix/share/example-robot-data/robots" / path
        if found.exists():
            return found
    sys.exit(f"{path} is not installed: pip install example-robot-data==6.0.0")


@njit(cache=True, inline="always")
def cross(a, b, out):
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def equations(chain, q, dq, bias, mass):
    """Writes the torques without acceleration and the lower half of the mass matrix.

    All vectors are in the frame of the base, all moments about its origin.
    """
    a, b, c, origin, axis, masses, lever, inertia = chain
    n = len(q)
    turn, old = np.eye(3), np.empty((3, 3))
    place, omega, alpha, acceleration = np.zeros(3), np.zeros(3), np.zeros(3), np.array([0.0, 0.0, GRAVITY])
    z, v = np.empty((n, 3)), np.empty((n, 3))
    force, moment, first, second = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    r, u, w, d, centre, spun = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
    for k in range(n):
        old[:] = turn
        sine, cosine = np.sin(q[k]), np.cos(q[k])
        for i in range(3):
            r[i] = old[i, 0] * origin[k, 0] + old[i, 1] * origin[k, 1] + old[i, 2] * origin[k, 2]
            for j in range(3):
                turn[i, j] = 0.0
                for l in range(3):
                    turn[i, j] += old[i, l] * (a[k, l, j] + b[k, l, j] * sine + c[k, l, j] * cosine)
        cross(omega, r, u)
        cross(omega, u, w)
        cross(alpha, r, u)
        for i in range(3):
            acceleration[i] += u[i] + w[i]
            place[i] += r[i]
            z[k, i] = turn[i, 0] * axis[k, 0] + turn[i, 1] * axis[k, 1] + turn[i, 2] * axis[k, 2]
            d[i] = z[k, i] * dq[k]
        cross(place, z[k], v[k])
        cross(omega, d, u)
        for i in range(3):
            alpha[i] += u[i]
            omega[i] += d[i]
            d[i] = turn[i, 0] * lever[k, 0] + turn[i, 1] * lever[k, 1] + turn[i, 2] * lever[k, 2]
            centre[i] = place[i] + d[i]
            for j in range(3):
                spun[i, j] = 0.0
                for l in range(3):
                    spun[i, j] += turn[i, l] * inertia[k, l, j]
        for i in range(3):
            for j in range(3):
                second[k, i, j] = spun[i, 0] * turn[j, 0] + spun[i, 1] * turn[j, 1] + spun[i, 2] * turn[j, 2]
        cross(omega, d, u)
        cross(omega, u, w)
        cross(alpha, d, u)
        for i in range(3):
            first[k, i] = masses[k] * centre[i]
            force[k, i] = masses[k] * (acceleration[i] + u[i] + w[i])
            r[i] = second[k, i, 0] * omega[0] + second[k, i, 1] * omega[1] + second[k, i, 2] * omega[2]
            w[i] = second[k, i, 0] * alpha[0] + second[k, i, 1] * alpha[1] + second[k, i, 2] * alpha[2]
        cross(omega, r, u)
        cross(centre, force[k], moment[k])
        square = centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2
        for i in range(3):
            moment[k, i] += u[i] + w[i]
            second[k, i, i] += masses[k] * square
            for j in range(3):
                second[k, i, j] -= masses[k] * centre[i] * centre[j]
    total = 0.0
    for k in range(n - 1, -1, -1):
        total += masses[k]
        if k + 1 < n:
            for i in range(3):
                force[k, i] += force[k + 1, i]
                moment[k, i] += moment[k + 1, i]
                first[k, i] += first[k + 1, i]
                for j in range(3):
                    second[k, i, j] += second[k + 1, i, j]
        # Momentum of the links from k on, if joint k alone turns.
        cross(z[k], first[k], u)
        cross(first[k], v[k], w)
        bias[k] = 0.0
        for i in range(3):
            bias[k] += z[k, i] * moment[k, i] + v[k, i] * force[k, i]
            u[i] += total * v[k, i]
            w[i] += second[k, i, 0] * z[k, 0] + second[k, i, 1] * z[k, 1] + second[k, i, 2] * z[k, 2]
        for j in range(k + 1):
            mass[k, j] = 0.0
            for i in range(3):
                mass[k, j] += z[j, i] * w[i] + v[j, i] * u[i]


@njit(cache=True)
def solve(mass, x):
    """Solves mass · out = x in place by Cholesky's method."""
    n = len(x)
    for i in range(n):
        for j in range(i + 1):
            value = mass[i, j]
            for l in range(j):
                value -= mass[i, l] * mass[j, l]
            mass[i, j] = np.sqrt(value) if i == j else value / mass[j, j]
    for i in range(n):
        for l in range(i):
            x[i] -= mass[i, l] * x[l]
        x[i] /= mass[i, i]
    for i in range(n - 1, -1, -1):
        for l in range(i + 1, n):
            x[i] -= mass[l, i] * x[l]
        x[i] /= mass[i, i]


@njit(cache=True)
def rates(chain, drive, effects, warm, x, tau, outside, out, bias, mass):
    """Writes the time derivative of x = [q, phi, dq, dphi] with a torque from outside on each link."""
    stiffness, rotor, link_viscous, link_coulomb, motor_viscous, motor_coulomb, phase, play, sliding, memory, numbers = drive
    sharpness, gear = numbers
    ripple, load, error, _ = effects
    n = len(tau)
    q, phi, dq, dphi = x[:n], x[n:2 * n], x[2 * n:3 * n], x[3 * n:]
    equations(chain, q, dq, bias, mass)
    for k in range(n):
        deflection = phi[k] + error * np.sin(2 * gear * phi[k] + phase[k]) - q[k]
        spring = stiffness[k] * (deflection - min(max(deflection, -play[k]), play[k]))
        spring += sliding[k] * stiffness[k] * SLIDING_RAD * memory[k]
        out[k], out[n + k] = dq[k], dphi[k]
        out[2 * n + k] = spring - link_viscous[k] * dq[k] - link_coulomb[k] * np.tanh(sharpness * dq[k]) - bias[k]
        out[2 * n + k] += outside[k]
        coulomb = motor_coulomb[k] + load * abs(spring)
        friction = warm * motor_viscous[k] * dphi[k] + coulomb * np.tanh(sharpness * dphi[k])
        acting = tau[k] + ripple * motor_coulomb[k] * np.sin(6 * gear * phi[k] + phase[k])
        out[3 * n + k] = (acting - spring - friction) / rotor[k]
    solve(mass, out[2 * n:3 * n])


@njit(cache=True)
def ahead(x, h, rate, out):
    for i in range(len(x)):
        out[i] = x[i] + h * rate[i]


@njit(cache=True)
def simulate(chain, drive, effects, gains, reference, speed, outside, centre, substeps):
    """Returns states [samples × 4n] and torques [samples × n] under a controller that holds its torque."""
    kp, kd = gains
    samples, n = reference.shape
    bias, mass, zero = np.empty(n), np.empty((n, n)), np.zeros(n)
    x, y = np.zeros(4 * n), np.empty(4 * n)
    k1, k2, k3, k4 = np.empty(4 * n), np.empty(4 * n), np.empty(4 * n), np.empty(4 * n)
    states, torques, tau = np.empty((samples, 4 * n)), np.empty((samples, n)), np.empty(n)
    memory = drive[9]
    memory[:] = 0.0
    equations(chain, centre, zero, bias, mass)
    sag = bias / drive[0]
    x[:n], x[n:2 * n] = centre, centre + sag
    h = PERIOD_S / substeps
    for sample in range(samples):
        equations(chain, x[n:2 * n], zero, bias, mass)
        for k in range(n):
            error, rate = reference[sample, k] + sag[k] - x[n + k], speed[sample, k] - x[3 * n + k]
            tau[k] = kp[k] * error + kd[k] * rate + bias[k]
        states[sample], torques[sample] = x, tau
        for step in range(substeps):
            warm = 1 - effects[3] * (sample + step / substeps) / samples
            rates(chain, drive, effects, warm, x, tau, outside[sample], k1, bias, mass)
            ahead(x, 0.5 * h, k1, y)
            rates(chain, drive, effects, warm, y, tau, outside[sample], k2, bias, mass)
            ahead(x, 0.5 * h, k2, y)
            rates(chain, drive, effects, warm, y, tau, outside[sample], k3, bias, mass)
            ahead(x, h, k3, y)
            rates(chain, drive, effects, warm, y, tau, outside[sample], k4, bias, mass)
            for k in range(n):
                y[k] = x[n + k] - x[k]
            for i in range(4 * n):
                x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
            for k in range(n):
                memory[k] = min(max(memory[k] + (x[n + k] - x[k] - y[k]) / SLIDING_RAD, -1.0), 1.0)
    return states, torques


def motion(robot, seed, amplitude, t):
    """A reference of five sines a joint that begins at rest, and its velocity."""
    n, phases = robot.n, np.random.default_rng(seed).uniform(0, 2 * np.pi, (robot.n, 5))
    ratios = np.arange(1, 6) * np.array([1, 1.7, 2.3, 3.1, 4.4]) ** 0.8
    w = 2 * np.pi * 0.09 * (1 + 0.17 * np.arange(n)[:, None]) * ratios
    size = amplitude / 5 / np.array([0.5, 0.8, 1.2, 1.8, 2.6])
    t = t[:, None]
    begun, begin = 1 - np.exp(-(t / 0.5) ** 3), np.exp(-(t / 0.5) ** 3) * 3 * t * t / 0.125
    angle = w * t[..., None] + phases
    sines, speeds = (size * (np.sin(angle) - np.sin(phases))).sum(2), (size * w * np.cos(angle)).sum(2)
    return robot.centre + begun * sines, begin * sines + begun * speeds


def states_of(robot, effects, seed, amplitude, samples, substeps=round(PERIOD_S / STEP_S), outside=None):
    """Simulates one motion, with torques from outside on the links [samples × n] if there are any."""
    reference, speed = motion(robot, seed, amplitude, np.arange(samples) * PERIOD_S)
    of_joints = (robot.phase, robot.play, robot.sliding, np.zeros(robot.n))
    drive = (*robot.drive.values(), *of_joints, np.array([robot.sharpness, robot.of["gear"]], float))
    gains = np.array(robot.of["kp"], float), np.array(robot.of["kd"], float)
    outside = np.zeros((samples, robot.n)) if outside is None else outside
    return simulate(robot.chain(), drive, effects, gains, reference, speed, outside, robot.centre, substeps)


def main():
    none = np.zeros(4)
    for arm in ARMS:
        robot = Robot(arm, 1, 200.0)
        data, random, worst = robot.model.createData(), np.random.default_rng(1), 0.0
        bias, mass, n = np.empty(robot.n), np.zeros((robot.n, robot.n)), robot.n
        for _ in range(200):
            q, dq, tau = random.uniform(-3, 3, (3, n))
            equations(robot.chain(), q, dq, bias, mass)
            known, found = pin.aba(robot.model, data, q, dq, tau), tau - bias
            solve(mass, found)
            worst = max(worst, np.max(np.abs(found - known)) / np.max(np.abs(known)))
        states_of(robot, none, 1, 0.45, 10)
        begin = time.perf_counter()
        states, _ = states_of(robot, none, 1, 0.45, 20000)
        seconds = time.perf_counter() - begin
        fine, _ = states_of(robot, none, 1, 0.45, 20000, 20)
        step = np.max(np.abs(fine - states)[:, :2 * n])
        print(f"{arm:6} accelerations differ by {worst:.1e} from Pinocchio's; 20 s take {seconds:.1f} s; "
              f"half the step moves positions by {step:.1e} rad")


if __name__ == "__main__":
    main()
