"""Compares designs of `sprung excite` with motions that are best by the objectives of FloBaRoID and RAPTOR.

    python benches/excite/peers.py FOLDER [--seconds 60] [--seeds 3] [--only raptor]

The robot is the arm of `cargo bench -p sprung --bench excite -- seven-joints`: kinematics and limits of a Franka Panda. FOLDER
keeps the packages, the motions and their judgements. The variables SPRUNG and EXCITE name binaries that are there already.

Objectives, columns of the regressor, numbers of harmonics and waves are those of the peers' sources:

- RAPTOR (roahmlab/RAPTOR, 6128c03, KinovaRegressorExample.cpp): log of the condition number of the links' columns, three
  harmonics, 128 samples, Ipopt from a random motion.
- FloBaRoID (kjyv/FloBaRoID, 9fa9f89, kuka_lwr4.yaml of 952244d): condition number of the columns of links, offsets and viscous
  friction, and a penalty on torques that stay below 10 % of their limits; four harmonics; a swarm, then a local search.
- FloBaRoID of 2026 (0133a1d, kuka_lwr4.yaml of 06dcd2a): regularised determinant of the columns of links and friction, balance
  and size of torques, part of the ranges; up to six harmonics; global, then Ipopt.

Each objective is also minimised with the ten harmonics of sprung's design. The open choices of the peers:

- Ipopt is the local search of all, with limits at each sample, and gradients from singular vectors and differences of the
  regressor. It restarts until its processor time is over; the best motion within the limits counts.
- Limits are those of sprung, with all torques of the motor. The search uses 98 % of them, as sprung's own does.
- Motions fill the 10 s and begin and end at rest. So the lowest frequency of FloBaRoID is fixed, too: within its bounds only
  one period of 10 s ends at rest after 10 s.

sprung judges all motions, its own too, by `sprung excite --reference`: limits between samples, and standard errors of all
parameters. The table has the condition number of the peer's own columns, that of the links in sprung's information, and the
geometric mean of standard errors over those of sprung's design, of all parameters and of those of links. Above one, sprung's
are smaller.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

# More threads make these small matrices slower.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ["numpy==2.4.6", "scipy==1.17.1", "pin==4.1.0", "ipyopt==0.12.10"]
DURATION_S = 10.0
TEN = 10
# Part of each limit that a search uses, and the violation up to which a motion keeps it.
PART, FEASIBLE = 0.98, 1e-5
# Slope of Coulomb friction at zero velocity, s/rad: of the arm, and of the regressor of FloBaRoID.
SHARPNESS, SLOPE = 100.0, 50.0
DIFFERENCE = 1e-7
SWARM, ITERATIONS = 12, 40
# Samples of FloBaRoID in 10 s: the weights of its objective depend on them.
ITS_SAMPLES = 2000


@dataclass(frozen=True)
class Peer:
    """An objective with its motions: amplitudes are divided by the `order`-th power of their frequencies."""

    name: str
    objective: str
    friction: tuple
    harmonics: int
    samples: int
    order: int
    has_swarm: bool


OWN = [
    Peer("RAPTOR", "log_condition", (), 3, 128, 2, False),
    Peer("FloBaRoID", "condition", ("offset", "viscous"), 4, 200, 1, True),
    Peer("FloBaRoID of 2026", "determinant", ("offset", "viscous", "coulomb"), 6, 200, 1, True),
]
# More harmonics need more samples, so that limits hold between them.
PEERS = [peer for original in OWN for peer in (original, replace(original, harmonics=TEN, samples=200))]


class Arm:
    """The arm in Pinocchio, with its limits and drives."""

    def __init__(self, folder):
        self.folder = folder
        model = self.model = pin.buildModelFromUrdf(str(folder / "arm.urdf"))
        self.data, self.n = model.createData(), model.nv
        joints = tomllib.loads((folder / "experiment.toml").read_text())["robot"]["joint"]
        of_all = lambda table, key: np.array([joint[table][key] for joint in joints])
        self.rotor, self.viscous, self.coulomb = (
            of_all("nominal", key) for key in ("rotor_inertia", "motor_viscous", "motor_coulomb"))
        # Jerks need no limit: by Bernstein's inequality they stay below 6.3/s times accelerations, and the limit is 500/s.
        self.middle = 0.5 * (model.upperPositionLimit + model.lowerPositionLimit)
        self.ranges = 0.5 * (model.upperPositionLimit - model.lowerPositionLimit)
        accelerations = of_all("limits", "acceleration_rad_per_s2")
        self.limits = np.array([self.ranges, model.velocityLimit, accelerations, model.effortLimit])
        self.base = slice(None)
        self.base = self.base_columns()

    def base_columns(self):
        """Returns the independent columns of random regressors, by QR with pivoting."""
        q, v, a = np.random.default_rng(0).uniform(-1, 1, (3, 500, self.n)) * self.limits[:3, None, :]
        rows = self.regressor(self.middle + q, v, a)
        _, r, order = scipy.linalg.qr(rows.reshape(-1, rows.shape[2]), mode="economic", pivoting=True)
        size = np.abs(np.diag(r))
        return np.sort(order[: np.count_nonzero(size > 1e-8 * size[0])])

    def regressor(self, *states):
        """Returns the links' columns of each sample, [samples, joints, columns]."""
        compute = pin.computeJointTorqueRegressor
        return np.array([compute(self.model, self.data, *state)[:, self.base] for state in zip(*states)])

    def differences(self, function, states):
        """Yields order, joint and derivative of a function by positions, velocities and accelerations of each joint."""
        here = function(*states)
        for order in range(3):
            for joint in range(self.n):
                moved = [values.copy() for values in states]
                moved[order][:, joint] += DIFFERENCE
                yield order, joint, (function(*moved) - here) / DIFFERENCE

    def torques(self, q, v, a):
        """Returns the torques of the motors, [samples, joints]."""
        links = np.array([pin.rnea(self.model, self.data, *state) for state in zip(q, v, a)])
        return links + self.rotor * a + self.viscous * v + self.coulomb * np.tanh(SHARPNESS * v)

    def torque_slopes(self, states):
        """Returns the derivatives of the torques by positions, velocities and accelerations, [3, samples, joints, joints]."""
        slopes = np.empty((3, *states[0].shape, self.n))
        for order, joint, slope in self.differences(self.torques, states):
            slopes[order, :, :, joint] = slope
        return slopes


def peaks(values):
    """Returns the largest magnitude of each joint, and its derivative by the values."""
    at = np.argmax(np.abs(values), axis=0), np.arange(values.shape[1])
    slope = np.zeros_like(values)
    slope[at] = np.sign(values[at])
    return np.abs(values[at]), slope


def log_condition(problem, y, torque, q):
    """The objective of RAPTOR: returns the value, and its derivatives by regressor, torques and positions."""
    u, s, vt = np.linalg.svd(y.reshape(-1, y.shape[2]), full_matrices=False)
    slope = np.outer(u[:, 0], vt[0]) / s[0] - np.outer(u[:, -1], vt[-1]) / s[-1]
    return np.log(s[0] / s[-1]), slope.reshape(y.shape), 0 * torque, 0 * q


def condition(problem, y, torque, q):
    """The objective of FloBaRoID."""
    log, slope, _, flat = log_condition(problem, y, torque, q)
    most, by_torque = peaks(torque)
    missing = np.maximum(0.1 * problem.arm.limits[3] - most, 0)
    return np.exp(log) + missing.sum(), np.exp(log) * slope, -by_torque * (missing > 0), flat


def determinant(problem, y, torque, q):
    """The objective of FloBaRoID of 2026."""
    arm, flat = problem.arm, y.reshape(-1, y.shape[2])
    repeated = ITS_SAMPLES / len(y)
    values, vectors = np.linalg.eigh(repeated * flat.T @ flat)
    inverse = 1 / (values + 1e-4 * values[-1])
    log = np.log(inverse).sum()
    # The first motion of a search sets the weight.
    problem.weight = weight = problem.weight or 10 / max(abs(log), 1)
    each = inverse + 1e-4 * inverse.sum() * (values == values[-1])
    by_y = -2 * weight * repeated * flat @ (vectors * each) @ vectors.T
    most, by_torque = peaks(torque)
    used = most / arm.limits[3]
    mean, spread = used.mean(), used.std()
    by_used = 10 / arm.n * ((used - mean) / (spread * mean) - spread / mean**2 - (mean < 0.25) / 0.25)
    joints, high, low = np.arange(arm.n), np.argmax(q, axis=0), np.argmin(q, axis=0)
    by_q = np.zeros_like(q)
    by_q[high, joints] -= 5 / arm.ranges / arm.n
    by_q[low, joints] += 5 / arm.ranges / arm.n
    value = weight * log + 10 * spread / mean + 10 * max(0, 1 - mean / 0.25) + 10 + (q * by_q).sum()
    return value, by_y.reshape(y.shape), by_torque * by_used / arm.limits[3], by_q


class Problem:
    """Motions at rest at both ends, their objective, and their limits at samples. A motion is [functions, joints], flat."""

    def __init__(self, arm, peer, seed):
        self.arm, self.peer, self.objective = arm, peer, globals()[peer.objective]
        self.random = np.random.default_rng(seed)
        self.angular = 2 * np.pi / DURATION_S * np.arange(1, peer.harmonics + 1)
        times = np.arange(peer.samples) * DURATION_S / peer.samples
        self.free = scipy.linalg.null_space(np.vstack([self.waves(np.zeros(1), order) for order in (1, 2)]))
        constants = [np.full((peer.samples, 1), float(order == 0)) for order in range(3)]
        self.basis = [
            np.hstack([constant, self.waves(times, order) @ self.free]) for order, constant in enumerate(constants)
        ]
        self.functions = self.basis[0].shape[1]
        self.size = self.functions * arm.n
        self.known, self.best, self.starts, self.weight = None, (np.inf, np.inf, None), 0, None

    def waves(self, times, order):
        """Returns a derivative of all sines and cosines, [times, 2 harmonics]."""
        phase = np.outer(times, self.angular) + 0.5 * np.pi * order
        return np.hstack([np.sin(phase), np.cos(phase)]) * np.tile(self.angular ** (order - self.peer.order), 2)

    def columns(self, q, v, a):
        """Returns the peer's columns of links and friction, [samples, joints, columns]."""
        known = {"offset": v**0, "viscous": v, "coulomb": np.tanh(SLOPE * v)}
        friction = [known[kind][:, :, None] * np.eye(self.arm.n) for kind in self.peer.friction]
        return np.concatenate([self.arm.regressor(q, v, a), *friction], axis=2)

    def at(self, x):
        """Returns states, columns, objective with derivatives, and used parts of limits of a motion."""
        if self.known is None or not np.array_equal(self.known[0], x):
            states = [basis @ x.reshape(self.functions, -1) for basis in self.basis]
            y, torque = self.columns(*states), self.arm.torques(*states)
            found = self.objective(self, y, torque, states[0])
            used = np.array([states[0] - self.arm.middle, *states[1:], torque]) / self.arm.limits[:, None, :]
            self.known = x.copy(), states, y, found, used
            excess = np.abs(used).max() - PART
            self.best = min(
                self.best, (excess if excess > FEASIBLE else 0.0, found[0], x.copy()), key=lambda motion: motion[:2]
            )
        return self.known[1:]

    def condition_number(self, x):
        """Returns the condition number of the peer's own columns."""
        return np.linalg.cond(np.vstack(self.at(x)[1]))

    def gradient(self, x, out):
        states, _, (_, by_y, by_torque, by_q), _ = self.at(x)
        slopes = np.array([by_q, 0 * by_q, 0 * by_q])
        for order, joint, slope in self.arm.differences(self.columns, states):
            slopes[order, :, joint] += np.einsum("sij,sij->s", slope, by_y)
        if by_torque.any():
            slopes += np.einsum("si,ksij->ksj", by_torque, self.arm.torque_slopes(states))
        out[()] = np.einsum("ksb,ksj->bj", np.array(self.basis), slopes).ravel()

    def limits(self, x, out):
        out[()] = self.at(x)[3].ravel()

    def limits_slope(self, x, out):
        basis, limits = np.array(self.basis), self.arm.limits
        states = basis[:, :, None, :] / limits[:3, None, :, None]
        torques = np.einsum("ksij,ksb->sibj", self.arm.torque_slopes(self.at(x)[0]), basis) / limits[3, :, None, None]
        out[()] = np.concatenate([states.ravel(), torques.ravel()])

    def places(self):
        """Returns rows and columns of the derivatives of the limits: a joint's own functions, and for torques all."""
        n, rows = self.arm.n, self.peer.samples * self.arm.n
        columns = np.tile(np.arange(n)[:, None] + n * np.arange(self.functions), (3 * self.peer.samples, 1)).ravel()
        lines = np.repeat(np.arange(3 * rows), self.functions)
        torques = np.repeat(3 * rows + np.arange(rows), self.size)
        return np.concatenate([lines, torques]), np.concatenate([columns, np.tile(np.arange(self.size), rows)])

    def shrunk(self, x):
        """Returns a motion with smaller amplitudes that keeps the limits of positions, velocities and accelerations."""
        x, arm = x.reshape(self.functions, -1).copy(), self.arm
        x[0] = arm.middle + np.clip(x[0] - arm.middle, -0.9 * arm.ranges, 0.9 * arm.ranges)
        for order, basis in enumerate(self.basis):
            room = PART * arm.limits[order] - (order == 0) * np.abs(x[0] - arm.middle)
            x[1:] *= np.minimum(1, room / np.maximum(np.abs(basis[:, 1:] @ x[1:]).max(axis=0), 1e-12))
        return x.ravel()

    def start(self, deadline):
        """Returns a random motion as RAPTOR does, or the best of a swarm as FloBaRoID does."""

        def random():
            centres = self.arm.middle + 0.5 * self.arm.ranges * self.random.uniform(-1, 1, self.arm.n)
            waves = self.free.T @ self.random.uniform(-0.5, 0.5, (2 * self.peer.harmonics, self.arm.n))
            return np.vstack([centres, waves]).ravel()

        if not self.peer.has_swarm:
            return random()

        def score(x):
            return self.at(x)[2][0] + 1e3 * max(np.abs(self.at(x)[3]).max() - PART, 0.0)

        at = np.array([self.shrunk(random()) for _ in range(SWARM)])
        speed, best, scores = 0 * at, at.copy(), np.array([score(x) for x in at])
        for k in np.tile(np.arange(SWARM), ITERATIONS):
            if time.process_time() > deadline:
                break
            pull = self.random.uniform(0, 1.5, (2, self.size))
            speed[k] = 0.7 * speed[k] + pull[0] * (best[k] - at[k]) + pull[1] * (best[np.argmin(scores)] - at[k])
            at[k] = self.shrunk(at[k] + speed[k])
            new = score(at[k])
            if new < scores[k]:
                best[k], scores[k] = at[k], new
        return best[np.argmin(scores)]

    def solve(self, seconds):
        """Returns the best motion of searches until the time is over."""
        deadline = time.process_time() + seconds
        free, rows = np.full(self.size, 1e20), np.full(4 * self.peer.samples * self.arm.n, PART)
        nothing = np.array([], dtype=int)
        search = ipyopt.Problem(
            self.size, -free, free, len(rows), -rows, rows, self.places(), (nothing, nothing),
            lambda x: self.at(x)[2][0], self.gradient, self.limits, self.limits_slope,
            intermediate_callback=lambda *_: time.process_time() < deadline,
            ipopt_options={"print_level": 0, "sb": "yes", "tol": 1e-6, "constr_viol_tol": FEASIBLE, "max_iter": 100000,
                           "mu_strategy": "adaptive", "hessian_approximation": "limited-memory"},
        )
        while time.process_time() < deadline:
            self.starts += 1
            search.solve(self.start(deadline))
        return self.best[2]

    def reference(self, x):
        """Returns a motion as the reference of a controller."""
        x = x.reshape(self.functions, -1)
        waves = (self.free @ x[1:]).reshape(2, self.peer.harmonics, -1) * self.angular[:, None] ** -self.peer.order
        size, phase = np.degrees(np.hypot(*waves)), np.degrees(np.arctan2(waves[1], waves[0]))
        sines = "".join(
            f'  {{ joint = "j{joint}", amplitude_deg = {size[h, joint]}, frequency_hz = {(h + 1) / DURATION_S}, '
            f"phase_deg = {phase[h, joint]} }},\n" for joint in range(self.arm.n) for h in range(self.peer.harmonics))
        return f"[controller.reference]\ncentre_deg = {np.degrees(x[0]).tolist()}\nsines = [\n{sines}]\n"


def built(variable, *words):
    """Returns the binary that a variable names, or builds it."""
    if variable in os.environ:
        return Path(os.environ[variable]).resolve()
    done = subprocess.run(["cargo", *words, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return [found for line in done.stdout.splitlines() if (found := json.loads(line).get("executable"))][-1]


def ratio(found, design, is_counted=lambda name: True):
    """Returns the geometric mean of the standard errors over those of the design; an error without a value is infinite."""
    pairs = [(a["standard_error"] or np.inf, b["standard_error"])
             for a, b in zip(found["promise"], design["promise"], strict=True) if is_counted(a["name"])]
    return float(np.exp(np.mean([np.log(a / b) for a, b in pairs])))


def kept(found):
    """Returns whether limits hold, or the limit with the largest violation."""
    worst = max(found["limits"], key=lambda limit: limit["used_percent"])
    return "hold" if found["is_certified"] else f"{worst['quantity']} of {worst['joint']}: {worst['used_percent']:.1f} %"


def compared(peer, seeds, seconds, arm, excite, design):
    """Prints a line for each seed of a peer, and their mean."""
    ratios, passes = [], 0
    for seed in range(1, seeds + 1):
        problem, out = Problem(arm, peer, seed), arm.folder.parent / f"{peer.objective}-{peer.harmonics}-{seed}"
        x = problem.solve(seconds)
        out.mkdir(exist_ok=True)
        (out / "motion.toml").write_text(problem.reference(x))
        found = excite("--reference", out / "motion.toml", out=out)
        ratios.append(ratio(found, design))
        of_links = ratio(found, design, lambda name: not name.startswith("j"))
        passes += not found["is_certified"]
        numbers = f"{problem.condition_number(x):10.1f}{found['links_condition_number']:7.1f}{ratios[-1]:8.2f}{of_links:9.2f}"
        print(f"{peer.name:18}{peer.harmonics:10}{seed:5}{problem.starts:7}{numbers}  {kept(found)}", flush=True)
    print(f"{peer.name}, {peer.harmonics} harmonics: standard errors {np.exp(np.mean(np.log(ratios))):.2f} times those of sprung, "
          f"{min(ratios):.2f} times at best; {passes} of {seeds} pass a limit\n", flush=True)


def main(folder, seconds, seeds, only):
    sprung = built("SPRUNG", "build", "--release", "-p", "sprung-cli")
    bench = built("EXCITE", "bench", "--no-run", "-p", "sprung", "--bench", "excite")
    subprocess.run([bench, "--bench", "seven-joints", "--write", folder / "arm"], check=True)
    arm = Arm(folder / "arm")

    def excite(*words, out):
        subprocess.run([sprung, "excite", arm.folder, *words, "--out", out, "--quiet"], check=True)
        return json.loads((out / "excitation.json").read_text())

    begin = os.times().children_user
    excite("--set", "excite.steps=400", out=folder / "sprung")
    took = os.times().children_user - begin
    design = excite("--reference", folder / "sprung" / "reference.toml", out=folder / "judged")
    print(f"sprung's design: {took:.0f} s of processor time, condition number of the links "
          f"{design['links_condition_number']:.1f}, limits {kept(design)}\nthe others: {seconds:.0f} s of processor time each, "
          f"Ipopt with MUMPS (ipyopt), {len(arm.base)} columns of links\n")
    print("objective          harmonics seed starts condition  links  errors of links  limits")
    for peer in PEERS:
        if only.lower() in peer.name.lower():
            compared(peer, seeds, seconds, arm, excite, design)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0, help="processor time of each search")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", default="", help="a part of the name of a peer")
    given = parser.parse_args()
    folder = given.folder.resolve()
    python = folder / "venv" / "bin" / "python"
    if Path(sys.prefix) != python.parents[1]:
        subprocess.run([sys.executable, "-m", "venv", python.parents[1]], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        sys.exit(subprocess.run([python, *sys.argv]).returncode)
    import ipyopt
    import numpy as np
    import pinocchio as pin
    import scipy.linalg

    main(folder, given.seconds, given.seeds, given.only)
