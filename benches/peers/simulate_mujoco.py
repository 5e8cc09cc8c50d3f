"""Simulates the closed loop of the arm with seven flexible joints by MuJoCo's
Runge-Kutta method of order 4.

    python simulate_mujoco.py LOG.csv [SUBSTEPS]

LOG.csv is a log that sprung simulated without sensors. The controller is linear in the
measured signals. So its torque is the logged torque plus the feedback of the difference
from the log. This form needs no feedforward and leaves the loop unchanged. As in
sprung's equations, the rotors are separate bodies that turn about fixed axes. A fixed
tendon between rotor and link is the spring. MuJoCo has no friction law with a tanh of
the velocity, so a compiled callback adds this friction at every stage.
"""

import sys
import time

import mujoco
import numpy as np
from numba import carray, cfunc, types
from numba.core import cgutils
from numba.extending import intrinsic

import seven_joints as arm


def words(*numbers):
    return " ".join(f"{x:.17g}" for x in np.ravel(numbers))


def quaternion(rotation):
    out = np.zeros(4)
    mujoco.mju_mat2Quat(out, rotation.ravel())
    return out


def inertial(parameters):
    """Returns mass, centre of mass, principal moments of inertia and their axes."""
    m, (xx, xy, yy, xz, yz, zz) = parameters[0], parameters[4:]
    centre = parameters[1:4] / m
    about_origin = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    about_centre = about_origin - m * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    moments, axes = np.linalg.eigh(about_centre)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return m, centre, moments, quaternion(axes)


def mjcf(step):
    stiffness, rotor = arm.joints("stiffness"), arm.joints("rotor_inertia")
    links, rotors, springs = "", "", ""
    for i in reversed(range(arm.N)):
        rotation, position = arm.frame(arm.DH[i])
        damping = arm.joints("link_viscous")[i]
        m, centre, _, _ = inertial(arm.link(i))
        links = (f'<body pos="{words(position)}" quat="{words(quaternion(rotation))}">'
                 f'<joint name="q{i}" axis="0 0 1" damping="{damping:.17g}"/>'
                 f'<inertial mass="{m:.17g}" pos="{words(centre)}" diaginertia="1 1 1"/>'
                 f'{links}</body>')
    for i in range(arm.N):
        damping = arm.joints("motor_viscous")[i]
        rotors += (f'<body><joint name="phi{i}" axis="0 0 1" damping="{damping:.17g}"/>'
                   f'<inertial mass="1" pos="0 0 0" diaginertia="{words([rotor[i]] * 3)}"/></body>')
        springs += (f'<fixed stiffness="{stiffness[i]:.17g}" springlength="0">'
                    f'<joint joint="phi{i}" coef="1"/><joint joint="q{i}" coef="-1"/></fixed>')
    return (f'<mujoco><option integrator="RK4" timestep="{step:.17g}" '
            f'gravity="{words(arm.GRAVITY)}"><flag contact="disable"/></option>'
            f'<compiler angle="radian"/><worldbody>{links}{rotors}</worldbody>'
            f'<tendon>{springs}</tendon></mujoco>')


@intrinsic
def pointer(context, address):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


def friction(data):
    """Adds the Coulomb friction to the passive torques of this data."""
    velocity, torque = data.qvel.ctypes.data, data.qfrc_passive.ctypes.data
    coulomb = tuple(np.concatenate([arm.joints("link_coulomb"), arm.joints("motor_coulomb")]))
    beta, count = arm.BETA, len(coulomb)

    @cfunc(types.void(types.voidptr, types.voidptr))
    def callback(_model, _data):
        v = carray(pointer(velocity), (count,), np.float64)
        f = carray(pointer(torque), (count,), np.float64)
        for i in range(count):
            f[i] -= coulomb[i] * np.tanh(beta * v[i])

    return callback


def simulate(q, phi, tau, period, substeps):
    model = mujoco.MjModel.from_xml_string(mjcf(period / substeps))
    # The inertias are not in the MJCF, because its compiler refuses link 5, whose largest
    # principal moment exceeds the sum of the other two.
    for i in range(arm.N):
        _, _, model.body_inertia[1 + i], model.body_iquat[1 + i] = inertial(arm.link(i))
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    data.qpos[:] = np.concatenate([q[0], phi[0]])
    callback = friction(data)
    mujoco.set_mjcb_passive(callback.ctypes)
    states = np.empty((len(tau), 2 * arm.N))
    # Differences of the motor positions from the log: for this sample and earlier ones.
    w = arm.WINDOW
    past = np.zeros((2 * w, arm.N))
    weights = np.repeat([1.0, -1.0], w) / (w * w * period)
    start = time.perf_counter()
    for k, logged in enumerate(tau):
        states[k] = data.qpos
        past[1:] = past[:-1]
        past[0] = phi[k] - data.qpos[arm.N:]
        lag = arm.POSITION_GAIN * past[0] + arm.VELOCITY_GAIN * (weights @ past)
        data.qfrc_applied[arm.N:] = logged + lag
        mujoco.mj_step(model, data, substeps)
    seconds = time.perf_counter() - start
    mujoco.set_mjcb_passive(None)
    return seconds, states


def main():
    t, q, phi, tau = arm.read(sys.argv[1])
    substeps = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    period = (t[-1] - t[0]) / (len(t) - 1)
    seconds, states = min((simulate(q, phi, tau, period, substeps) for _ in range(3)),
                          key=lambda run: run[0])
    _, fine = simulate(q, phi, tau, period, 8 * substeps)
    print(f"seconds {seconds:.3f} for {len(t) * period:.1f} s at a step of "
          f"{1e3 * period / substeps:.3g} ms")
    print(f"position error {abs(states - fine).max():.1e} rad")
    print(f"difference from the log {abs(fine - np.hstack([q, phi])).max():.1e} rad")


if __name__ == "__main__":
    main()
