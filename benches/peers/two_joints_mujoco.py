"""Simulates logs of the demo's arm with MuJoCo, in closed loop and with encoders.

    python two_joints_mujoco.py FOLDER [LOGS]

The simulation differs from the equations that sprung fits. Coulomb friction is MuJoCo's
dry friction, a constraint that holds a joint at rest and has no transition velocity.
Springs are tendons, links are bodies with masses, and the integrator is implicit. The
rotors turn about fixed axes. Controller, reference, encoders and noise are those of the
demo.
"""

import pathlib
import sys

import mujoco
import numpy as np

# Values of the demo's truth.toml.
LINK1, COUPLING, LINK2 = 0.207184, 0.017580, 0.013163
ROTOR = [0.216776, 0.006842]
LINK_VISCOUS, MOTOR_VISCOUS = [0.037675, 0.002959], [8.435283, 0.135564]
STIFFNESS = [9.358730, 4.212811]
LINK_COULOMB, MOTOR_COULOMB = [0.015771, 0.005018], [1.360210, 0.162529]

PERIOD, SAMPLES, SUBSTEPS = 1e-3, 10_000, 20
KP, KD = np.array([50.0, 5.0]), np.array([0.05, 0.01])
WINDOW = 5
AMPLITUDE = np.radians(3.0)
# Frequency in Hz and phase in degrees of each joint's sines.
SINES = np.array([
    [[1.0, 0.0], [0.5, 30.0], [0.2, 45.0]],
    [[0.2, 0.0], [1.0, 36.0], [0.5, 90.0]],
])
COUNTS = 16384
TORQUE_NOISE = np.array([0.02, 0.005])

# Bodies that give the three parameters of the links. Length and masses are arbitrary.
LENGTH, MASS2, MASS1 = 0.343, 0.5, 1.0
CENTRE2 = COUPLING / (MASS2 * LENGTH)
ABOUT2 = LINK2 - MASS2 * CENTRE2**2
ABOUT1 = LINK1 - LINK2 - MASS2 * LENGTH**2
assert ABOUT1 > 0 and ABOUT2 > 0


def mjcf():
    # The friction is as stiff as the step allows, because joints creep with MuJoCo's default.
    step = PERIOD / SUBSTEPS
    dry = f'solreffriction="{2 * step:.17g} 1" solimpfriction="0.99 0.9999 0.001"'

    def joint(name, viscous, coulomb):
        return (f'<joint name="{name}" axis="0 0 1" damping="{viscous}" '
                f'frictionloss="{coulomb}" {dry}/>')

    def inertial(mass, centre, about_z):
        return (f'<inertial mass="{mass}" pos="{centre:.17g} 0 0" '
                f'diaginertia="{about_z:.17g} {about_z:.17g} {about_z:.17g}"/>')

    links = (f'<body>{joint("q0", LINK_VISCOUS[0], LINK_COULOMB[0])}'
             f'{inertial(MASS1, 0.0, ABOUT1)}'
             f'<body pos="{LENGTH} 0 0">{joint("q1", LINK_VISCOUS[1], LINK_COULOMB[1])}'
             f'{inertial(MASS2, CENTRE2, ABOUT2)}</body></body>')
    rotors, springs = "", ""
    for i in range(2):
        rotors += (f'<body>{joint(f"phi{i}", MOTOR_VISCOUS[i], MOTOR_COULOMB[i])}'
                   f'{inertial(1.0, 0.0, ROTOR[i])}</body>')
        springs += (f'<fixed stiffness="{STIFFNESS[i]}" springlength="0">'
                    f'<joint joint="phi{i}" coef="1"/><joint joint="q{i}" coef="-1"/></fixed>')
    return (f'<mujoco><option integrator="implicit" timestep="{step:.17g}" gravity="0 0 0" '
            f'iterations="200" tolerance="1e-14">'
            f'<flag contact="disable"/></option><compiler angle="radian"/>'
            f'<worldbody>{links}{rotors}</worldbody><tendon>{springs}</tendon></mujoco>')


def reference(t):
    angle = 2 * np.pi * SINES[:, :, 0] * t + np.radians(SINES[:, :, 1])
    speed = AMPLITUDE * 2 * np.pi * SINES[:, :, 0] * np.cos(angle)
    return (AMPLITUDE * np.sin(angle)).sum(axis=1), speed.sum(axis=1)


def simulate(model, seed):
    random = np.random.default_rng(seed)
    data = mujoco.MjData(model)
    step = 2 * np.pi / COUNTS
    phase = random.random(4)
    weights = np.repeat([1.0, -1.0], WINDOW) / (WINDOW * WINDOW * PERIOD)
    past = None
    rows = np.empty((SAMPLES, 7))
    for k in range(SAMPLES):
        counted = step * np.floor(data.qpos / step + phase)
        phi = counted[2:]
        if past is None:
            past = np.repeat(phi[None], 2 * WINDOW, axis=0)
        past[1:] = past[:-1].copy()
        past[0] = phi
        wanted, speed = reference(k * PERIOD)
        tau = KP * (wanted - phi) + KD * (speed - weights @ past)
        rows[k] = np.concatenate([[k * PERIOD], counted, tau + TORQUE_NOISE * random.normal(size=2)])
        data.qfrc_applied[2:] = tau
        mujoco.mj_step(model, data, SUBSTEPS)
    return rows


def main():
    folder = pathlib.Path(sys.argv[1])
    logs = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    folder.mkdir(parents=True, exist_ok=True)
    model = mujoco.MjModel.from_xml_string(mjcf())
    for seed in range(logs):
        np.savetxt(folder / f"{seed:03}.csv", simulate(model, seed), fmt="%.10g", delimiter=",",
                   header="t_s,q1_rad,q2_rad,phi1_rad,phi2_rad,tau1_nm,tau2_nm", comments="")
    print(f"{logs} logs in {folder}")


if __name__ == "__main__":
    main()
