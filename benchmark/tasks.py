"""The twelve tasks: nine simulated robots and three real machines."""
import numpy as np
from model import body

TURN, GRAVITY = 2 * np.pi, [0, 0, -9.81]
DRIVES = ["stiffness", "rotor_inertia", "motor_viscous", "motor_coulomb", "link_viscous", "link_coulomb"]
EFFECTS = ["load_friction", "hysteresis", "backlash_rad"]
SHARPNESS = 100.0                                # of Coulomb friction, tanh(100 s/rad * velocity)
SLIPS = 1e-3 * np.array([0.05, 0.15, 0.4, 1.0])  # rad, where the elements of hysteresis slide
SHARES = np.array([0.4, 0.3, 0.2, 0.1])          # of the hysteresis, for each element


def rpy(roll, pitch, yaw):
    (a, b, c), (d, e, f) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return [[c * b, c * e * d - f * a, c * e * a + f * d], [f * b, f * e * d + c * a, f * e * a - c * d], [-e, b * d, b * a]]


def joint(origin, angles, axis=(0, 0, 1), **more):
    return {"origin": list(origin), "rpy": list(angles), "rotation": rpy(*angles), "axis": list(axis), **more}


def rod(mass, centre, radius):
    """A body with about the inertia of a rod from the joint to twice its centre."""
    c = np.asarray(centre, float)
    return body(mass, c, mass / 3 * (c @ c * np.eye(3) - np.outer(c, c)) + mass * radius**2 * np.eye(3))


H = np.pi / 2
ROBOTS = {
    "two": dict(
        joints=[joint((0, 0, 0.3), (0, 0, 0), (0, 1, 0)), joint((0.35, 0, 0), (0, 0, 0), (0, 1, 0))],
        bodies=[rod(4.0, (0.18, 0.01, 0), 0.06), rod(2.3, (0.15, -0.01, 0), 0.05)],
        drives=[[9e3, 0.45, 13, 6, 1.1, 0.9], [4e3, 0.2, 6, 2.6, 0.5, 0.4]],
        start=[-0.5, 0.6], amplitude=[0.6, 0.8], gain=[7e3, 3e3], damping=[120, 50], rated=[90, 50]),
    "three": dict(
        joints=[joint((0, 0, 0.1), (0, 0, 0)), joint((0, 0.05, 0.15), (0, 0, 0), (0, 1, 0)), joint((0.35, 0, 0), (0, 0, 0), (0, 1, 0))],
        bodies=[rod(4.6, (0, 0, 0.08), 0.08), rod(4.1, (0.19, 0.01, 0), 0.06), rod(2.35, (0.145, -0.005, 0), 0.05)],
        drives=[[8e3, 0.47, 14, 5.5, 0.9, 0.7], [9.3e3, 0.47, 13, 6.2, 1.1, 0.9], [3.9e3, 0.21, 6, 2.6, 0.5, 0.4]],
        start=[0.2, -0.5, 0.6], amplitude=[0.6, 0.5, 0.7], gain=[6e3, 7e3, 3e3], damping=[120, 120, 50], rated=[90, 90, 50]),
    "seven": dict(
        joints=[joint((0, 0, 0.333), (0, 0, 0)), joint((0, 0, 0), (-H, 0, 0)), joint((0, -0.316, 0), (H, 0, 0)),
                joint((0.0825, 0, 0), (H, 0, 0)), joint((-0.0825, 0.384, 0), (-H, 0, 0)), joint((0, 0, 0), (H, 0, 0)), joint((0.088, 0, 0), (H, 0, 0))],
        bodies=[rod(4.9, (0, -0.02, -0.1), 0.07), rod(2.6, (0, -0.07, 0.03), 0.07), rod(3.2, (0.03, 0.03, -0.07), 0.06), rod(3.5, (-0.05, 0.1, 0.03), 0.06),
                rod(1.8, (0, 0.05, -0.12), 0.06), rod(1.7, (0.06, -0.01, 0), 0.07), rod(1.2, (0.01, 0.01, 0.08), 0.09)],
        drives=[[14e3, 0.9, 6, 2.5, 0.8, 0.5], [14e3, 0.9, 6, 2.5, 0.8, 0.6], [10e3, 0.6, 5, 2, 0.6, 0.4], [10e3, 0.6, 5, 2, 0.6, 0.4],
                [5e3, 0.25, 2, 1, 0.2, 0.15], [4e3, 0.2, 2, 1, 0.2, 0.15], [3e3, 0.15, 1.5, 0.8, 0.1, 0.1]],
        start=[0.1, -0.4, 0.2, -1.7, 0.3, 1.6, 0.5], amplitude=[0.6] * 7, gain=[3e3, 3e3, 2e3, 2e3, 5e2, 4e2, 3e2],
        damping=[90, 90, 60, 60, 16, 13, 10], rated=[87, 87, 87, 87, 12, 12, 12]),
}


def twin(robot, seed, seconds, rate=1000, delay=None, **effects):
    """`delay`: s, by kind of column. Effects: load_friction, hysteresis (share of the stiffness), backlash_rad."""
    return dict(kind="twin", robot=robot, seed=seed, seconds=seconds, rate=rate, delay=delay or {}, effects=effects)


TASKS = {
    "two-held": twin("two", 1, 15),
    "two-hysteresis": twin("two", 2, 15, hysteresis=0.25),
    "two-backlash": twin("two", 3, 15, backlash_rad=1.5e-4),
    "two-late": twin("two", 4, 15, delay={"q": 2e-3}),
    "three-held": twin("three", 5, 15),
    "three-load": twin("three", 6, 15, load_friction=0.06),
    "three-500hz": twin("three", 7, 20, rate=500, delay={"tau": 1e-3}),
    "seven-held": twin("seven", 8, 10),
    "seven-load-late": twin("seven", 9, 10, load_friction=0.05, delay={"q": 1e-3}),
    "emps": dict(kind="real", files={"DATA_EMPS.mat": "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
                            "DATA_EMPS_PULSES.mat": "0eab75bb1f6b16228ee78791343a88bf9bfd9a51036ac9807d7b5fc11c0e1704"}, licence="not stated with the files; ask the authors",
                 source="https://www.nonlinearbenchmark.org (Janot, Gautier, Brunot: Data set and reference models of EMPS, 2019)"),
    "panda": dict(kind="real", files={"panda_a.csv": "4c86a3deb6a0f46558921b83fccab1ca3cc1c6a9976857394a5438756533287f",
                             "panda_b.csv": "4e284db306248ab0fb3cdec55d9b1d1bca23da8f807dd67e1dbf35681865aefe"}, licence="GPL-3.0",
                  source="https://github.com/marcocognetti/FrankaEmikaPandaDynModel, commit 24d85ce, trajectory 1, halves in SI units"),
    "kr300": dict(kind="real", files={"A.mat": "4c152c5b7f2c899731fdeebcf0d011cc103df72be19fac160caf47aa9b73ab75",
                             "B.mat": "edeb35f65c4ec4bb697e757fc1e4e9668551b6fe7b2c3dbbb526d040dd8d5ce7"}, licence="MIT",
                  source="https://github.com/JonasWeigand/Robot_Identification"),
}
