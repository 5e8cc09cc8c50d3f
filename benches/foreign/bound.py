"""Cramér-Rao bound of a log of a flexible-joint arm, from the true motion.

The equations of the robot, linearised along the true motion, are a linear system with known matrices:

    x(k+1) = F x(k) + G θ + B w(k),   y(k) = C x(k) + v(k),   x = [q, φ, q̇, φ̇]

- θ: base parameters of the links (of Pinocchio's regressor), drives, and preloads of the springs
- w: noise of the logged torques, held for a period of the log
- v: errors of the encoders; their variance is a twelfth of a squared count

A Kalman filter predicts x. With the sensitivity S = ∂x/∂θ of its prediction and the covariance R of its innovations,
the information about θ is the sum of (C S)ᵀ R⁻¹ (C S) over the samples. The state at the start is unknown. An
estimator reaches the bound if it knows the lag of the torque, the sharpness of the friction, the levels of both noises,
and the torque between logged samples up to w.
"""

import numpy as np
import pinocchio as pin
from simulate import DRIVE, PERIOD_S

CHUNK = 500
# Random states that span the base parameters, and the relative singular value below which there is none.
STATES, RANK = 200, 1e-9
# Standard deviations of positions and velocities before the first sample, rad and rad/s: much above those after it.
START = (1e-2, 1.0)


def base_of(model):
    """Returns an orthonormal basis [10n × base] of what torques show of the bodies."""
    data, random = model.createData(), np.random.default_rng(0)
    draw = lambda: random.uniform(-2, 2, (3, model.nv))
    rows = [pin.computeJointTorqueRegressor(model, data, *draw()).copy() for _ in range(STATES)]
    _, sizes, vectors = np.linalg.svd(np.vstack(rows), full_matrices=False)
    return vectors[sizes > RANK * sizes[0]].T


def derivatives(robot, data, base, state, torque):
    """Returns the derivatives of ẋ by x, and by θ and w."""
    n, model = robot.n, robot.model
    q, phi, dq, dphi = state.reshape(4, n)
    stiffness, rotor, link_viscous, link_coulomb, motor_viscous, motor_coulomb = robot.drive.values()
    deflection, of_link, of_motor = phi - q, np.tanh(robot.sharpness * dq), np.tanh(robot.sharpness * dphi)
    spring = stiffness * deflection
    pin.computeABADerivatives(model, data, q, dq, spring - link_viscous * dq - link_coulomb * of_link)
    by_q, by_dq, inverse, ddq = data.ddq_dq.copy(), data.ddq_dv.copy(), data.Minv.copy(), data.ddq.copy()
    inverse = np.triu(inverse) + np.triu(inverse, 1).T
    ddphi = (torque - spring - motor_viscous * dphi - motor_coulomb * of_motor) / rotor
    regressor = pin.computeJointTorqueRegressor(model, data, q, dq, ddq)
    by_x, eye, link, motor = np.zeros((4 * n, 4 * n)), np.eye(n), slice(2 * n, 3 * n), slice(3 * n, 4 * n)
    by_x[:2 * n, 2 * n:] = np.eye(2 * n)
    by_x[link, :n], by_x[link, n:2 * n] = by_q - inverse * stiffness, inverse * stiffness
    by_x[link, link] = by_dq - inverse * (link_viscous + link_coulomb * robot.sharpness * (1 - of_link**2))
    by_x[motor, :n], by_x[motor, n:2 * n] = eye * (stiffness / rotor), -eye * (stiffness / rotor)
    by_x[motor, motor] = -eye * ((motor_viscous + motor_coulomb * robot.sharpness * (1 - of_motor**2)) / rotor)
    # In the order of DRIVE, then the preload; the last columns are those of w.
    on_links = [deflection, 0 * q, -dq, -of_link, 0 * q, 0 * q, 0 * q + 1, 0 * q]
    on_motors = [-deflection, -ddphi, 0 * q, 0 * q, -dphi, -of_motor, 0 * q - 1, 0 * q + 1]
    by_theta = np.zeros((4 * n, base.shape[1] + 8 * n))
    by_theta[link, :base.shape[1]] = -inverse @ (regressor @ base)
    by_theta[link, base.shape[1]:] = np.hstack([inverse * slope for slope in on_links])
    by_theta[motor, base.shape[1]:] = np.hstack([eye * (slope / rotor) for slope in on_motors])
    return by_x, by_theta


def transitions(robot, base, states, torques):
    """Yields F and [G, B] of each period of the controller.

    The exponential of the mean derivatives over the period is approximated by Padé's method.
    """
    data, eye = robot.model.createData(), np.eye(4 * robot.n)
    last = derivatives(robot, data, base, states[0], torques[0])
    for begin in range(1, len(states), CHUNK):
        part = slice(begin, begin + CHUNK)
        slopes = [last] + [derivatives(robot, data, base, *pair) for pair in zip(states[part], torques[part])]
        last = slopes[-1]
        by_x, by_theta = (np.array(each) for each in zip(*slopes))
        by_x, by_theta = (PERIOD_S / 2 * (each[1:] + each[:-1]) for each in (by_x, by_theta))
        solved = np.linalg.solve(eye - by_x / 2 + by_x @ by_x / 12, np.concatenate([by_x, by_theta], 2))
        yield from zip(eye + solved[:, :, :4 * robot.n], solved[:, :, 4 * robot.n:])


class Filter:
    """A Kalman filter that measures each `step`-th sample, and the information that it has gathered."""

    def __init__(self, robot, size, variances, noise, step):
        self.n, self.variances, self.noise, self.step, self.count = robot.n, variances, noise, step, 0
        self.covariance = np.diag(np.repeat(np.square(START), 2 * self.n))
        self.sensitivity = np.zeros((4 * self.n, size))
        self.information, self.rows = np.zeros((size, size)), []
        self.measure()

    def measure(self):
        seen = 2 * self.n
        root = np.linalg.cholesky(self.covariance[:seen, :seen] + np.diag(self.variances))
        white = np.linalg.inv(root)
        part, rows = white @ self.covariance[:seen], white @ self.sensitivity[:seen]
        self.rows.append(rows)
        self.covariance = self.covariance - part.T @ part
        self.sensitivity = self.sensitivity - part.T @ rows
        self.flow, self.inputs = np.eye(4 * self.n), np.zeros((4 * self.n, self.sensitivity.shape[1] + self.n))
        if len(self.rows) == CHUNK:
            self.gather()

    def gather(self):
        rows = np.reshape(self.rows, (-1, len(self.information)))
        self.information += rows.T @ rows
        self.rows = []

    def advance(self, flow, inputs):
        self.flow, self.inputs, self.count = flow @ self.flow, flow @ self.inputs + inputs, self.count + 1
        if self.count % self.step == 0:
            held = self.inputs[:, -self.n:] * self.noise
            self.covariance = self.flow @ self.covariance @ self.flow.T + held @ held.T
            self.covariance = (self.covariance + self.covariance.T) / 2
            self.sensitivity = self.flow @ self.sensitivity + self.inputs[:, :-self.n]
            self.measure()


def standard_errors(robot, states, torques, variances, noise, steps):
    """Returns the bound of each parameter of the drives, by name, for logs with each `steps`-th sample.

    - `variances`: those of the encoders' errors, [2n], rad²
    - `noise`: standard deviations of the logged torques, [n], N·m
    """
    base = base_of(robot.model)
    size, bodies = base.shape[1] + 7 * robot.n, base.shape[1]
    filters = [Filter(robot, size, variances, noise, step) for step in steps]
    for flow, inputs in transitions(robot, base, states, torques):
        for kalman_filter in filters:
            kalman_filter.advance(flow, inputs)
    names = [f"{joint}.{key}" for key in DRIVE for joint in robot.joints]
    found = []
    for kalman_filter in filters:
        kalman_filter.gather()
        scale = 1 / np.sqrt(np.diag(kalman_filter.information))
        inverse = np.linalg.inv(kalman_filter.information * np.outer(scale, scale))
        errors = scale * np.sqrt(np.diag(inverse))
        found.append(dict(zip(names, map(float, errors[bodies:]))))
    return found
