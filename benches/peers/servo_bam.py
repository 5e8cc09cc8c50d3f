"""Identifies the same servo from the same logs with sprung and with BAM's CMA-ES, side by side.

    python servo_bam.py SPRUNG FOLDER [TRIALS]

SPRUNG is the program. The logs are those of examples/servo-pendulum, simulated by sprung with
friction of the form m6. BAM (better-actuator-models) gets them in its own format: its simulator, its
bounds for a Dynamixel MX, its score (mean absolute error of the position) and its sampler (CMA-ES of
Optuna, which no longer restarts) are used as in `bam.fit`. TRIALS bounds its trials (its default is 100 000).
"""

import csv
import json
import pathlib
import resource
import shutil
import subprocess
import sys
import time
import tomllib

import numpy as np
import optuna
from bam import simulate
from bam.actuators import actuators
from bam.model import models

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from figure import note  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOGS = {"light.csv": 1.0, "heavy.csv": 3.0}
ARM_MASS, LENGTH, KP, SUPPLY = 0.1, 0.2, 32, 15.0
# Largest error of sprung for these parameters.
LIMIT = 0.05
LIMITED = ["armature", "viscous", "coulomb", "load_motor", "load_external"]
# Names of BAM, and values that follow from its parameters.
OF_BAM = {
    "torque_per_volt": lambda p: p["kt"] / p["R"],
    "back_emf": lambda p: p["kt"],
    "armature": lambda p: p["armature"],
    "viscous": lambda p: p["friction_viscous"],
    "coulomb": lambda p: p["friction_base"],
    "stribeck": lambda p: p["friction_stribeck"],
    "load_motor": lambda p: p["load_friction_motor"],
    "load_external": lambda p: p["load_friction_external"],
    "load_motor_stribeck": lambda p: p["load_friction_motor_stribeck"],
    "load_external_stribeck": lambda p: p["load_friction_external_stribeck"],
    "load_motor_quadratic": lambda p: p["load_friction_motor_quad"],
    "load_external_quadratic": lambda p: p["load_friction_external_quad"],
    "stribeck_velocity": lambda p: p["dtheta_stribeck"],
    "stribeck_exponent": lambda p: p["alpha"],
    "zero_offset": lambda p: p.get("q_offset", 0.0),
}


def of_children():
    """Returns the processor time of all programs that ended, in seconds."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def by_sprung(program, folder):
    """Simulates the logs and identifies the servo; returns values, errors and seconds of processor time."""
    example = folder / "servo-pendulum"
    shutil.rmtree(example, ignore_errors=True)
    shutil.copytree(ROOT / "examples/servo-pendulum", example)
    subprocess.run([program, "simulate", example, "--quiet"], check=True)
    begin = of_children()
    out = subprocess.run([program, "identify", example, "--json"], check=True, capture_output=True)
    seconds = of_children() - begin
    found = json.loads(out.stdout)
    name = lambda parameter: parameter["name"].split(".")[1]
    values = {name(p): (p["value"], p["standard_error"]) for p in found["parameters"]}
    with open(example / "truth.toml", "rb") as file:
        truth = {name.split(".")[1]: value for name, value in tomllib.load(file).items()}
    return example, truth, values, seconds


def log_of_bam(path, mass):
    """Returns a log in BAM's format."""
    with open(path, newline="") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    position = np.array([row["position_rad"] for row in rows])
    dt = rows[1]["t_s"] - rows[0]["t_s"]
    speed = np.gradient(position, dt)
    entries = [
        {
            "timestamp": row["t_s"],
            "position": row["position_rad"],
            "speed": float(v),
            "goal_position": row["target_rad"],
            "torque_enable": bool(row["drive_on"]),
        }
        for row, v in zip(rows, speed)
    ]
    return {"mass": mass, "arm_mass": ARM_MASS, "length": LENGTH, "kp": KP, "vin": SUPPLY,
            "dt": dt, "motor": "mx106", "entries": entries}


def batch(logs):
    """Joins logs of equal length, so that BAM simulates them together, as its own Logs.make_batch."""
    array = lambda key: np.array([log[key] for log in logs])
    joined = {key: array(key) for key in ["mass", "arm_mass", "length", "kp", "vin"]}
    joined["dt"] = logs[0]["dt"]
    keys = logs[0]["entries"][0].keys()
    joined["entries"] = [
        {key: np.array([entry[key] for entry in entries]) for key in keys}
        for entries in zip(*(log["entries"] for log in logs))
    ]
    return joined


def by_bam(logs, trials):
    """Runs CMA-ES as bam.fit does; returns the best parameters, their score and seconds of processor time."""
    joined = batch(logs)
    logged = np.array([entry["position"] for entry in joined["entries"]])

    def make():
        model = models["m6"]()
        model.set_actuator(actuators["mx106"]())
        return model

    def score(model):
        positions = simulate.Simulator(model).rollout_log(joined, simulate_control=True)[0]
        return float(np.mean(np.abs(np.array(positions) - logged)))

    def objective(trial):
        model = make()
        for name, parameter in model.get_parameters().items():
            if parameter.optimize:
                parameter.value = trial.suggest_float(name, parameter.min, parameter.max)
        return score(model)

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.CmaEsSampler(seed=1)
    begin = time.process_time()
    study = optuna.create_study(sampler=sampler)
    study.optimize(objective, n_trials=trials, n_jobs=1)
    return study.best_params, study.best_value, time.process_time() - begin


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    trials = int(sys.argv[3]) if len(sys.argv) > 3 else 100_000
    folder.mkdir(parents=True, exist_ok=True)
    example, truth, ours, seconds = by_sprung(program, folder)
    logs = [log_of_bam(example / name, mass) for name, mass in LOGS.items()]
    theirs, score, their_seconds = by_bam(logs, trials)
    print(f"{'parameter':26}{'truth':>10}{'sprung':>12}{'± s.e.':>10}{'error %':>9}{'BAM':>12}{'error %':>9}")
    percent = lambda value, true: 100 * (value / true - 1)
    for name, true in truth.items():
        value, error = ours[name]
        other = OF_BAM[name](theirs)
        print(f"{name:26}{true:10.4g}{value:12.5g}{error or 0:10.2g}{percent(value, true):9.1f}"
              f"{other:12.5g}{percent(other, true):9.1f}")
    print(f"processor time: sprung {seconds:.1f} s; BAM {their_seconds:.1f} s for {trials} trials, "
          f"mean absolute position error {1e3 * score:.2f} mrad")
    note("BAM time", f"processor time, beside {trials} trials of BAM's CMA-ES", seconds, "s", peer="BAM", peer_value=their_seconds)
    for name, true in truth.items():
        note(f"BAM {name}", f"`{name}`", abs(percent(ours[name][0], true)), "%",
             peer=f"BAM, {trials} trials", peer_value=abs(percent(OF_BAM[name](theirs), true)))
    beyond = [name for name in LIMITED if abs(ours[name][0] / truth[name] - 1) > LIMIT]
    if beyond:
        sys.exit(f"sprung is more than {100 * LIMIT:.0f} % off: {', '.join(beyond)}")


main()
