"""Damages logs, and counts how often `sprung check` names the damage first, with a line that corrects it.

    python run.py --out FOLDER [--binary SPRUNG] [--foreign FOLDER] [--logs NAME,...] [--faults NAME,...] [--jobs N]
                  [--verbose] [--strict]

The logs are two of the demo, one of examples/seven-joint-twin, and two foreign ones (UR5 and Panda, simulated by
`benches/foreign/generate.py` into the folder --foreign). `ur5-rigid` and `twin-rigid` are the logs without their link
encoders; they take part if --logs names them. Each log gets eight faults:

- torque-scale: the torque of one joint in another unit (10, 100, 1000 times, or a fraction)
- gear-on-position, gear-on-torque: motor positions or torques of the motor's side, declared as those of the output
- sign-of-link, sign-of-motor: one encoder counts in the other direction
- degrees: all positions in degrees, declared as radians
- torques-exchanged, links-exchanged: the torques or the link positions of two joints in the wrong order

The first finding above a note is right if least squares with its line find the drives of the sound log within 10 %. Without
a line it is right if its remedy names the key of the fault (NAMED): without gear ratio in the file, as in demo-2,
torques alone do not determine the number.
A line makes it worse if it raises the mean logarithmic distance from the drives of the sound log, or raises the
unexplained part of the motor torques. Every line that a check prints is tried alone. With --strict the exit code is 1 if
less than 90 % of the first diagnoses are right or a line makes it worse. Needs NumPy.
"""

import argparse
import json
import re
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "benches"))
from figure import note  # noqa: E402

LOGS = ["demo-1", "demo-2", "twin", "ur5", "panda"]
FAULTS = ["torque-scale", "gear-on-position", "gear-on-torque", "sign-of-link", "sign-of-motor", "degrees",
          "torques-exchanged", "links-exchanged"]
GEAR, SAME, LEAST_RIGHT = 101, 1.1, 0.9
# Differences below these are negligible.
MORE_DISTANCE, MORE_UNEXPLAINED = 0.02, 0.01
NAMED = {"gear-on-torque": 'motor_torque_side = "motor"'}
DRIVE = ("stiffness", "rotor_inertia", "motor_viscous", "motor_coulomb")
QUANTITIES = ("link_position", "motor_position", "motor_torque", "motor_current")


@dataclass
class Log:
    """An experiment as a dictionary, and the columns of its log in radians and N·m."""

    experiment: dict
    columns: dict
    links: list
    motors: list
    torques: list
    gears: list

    @property
    def log(self):
        return self.experiment["log"]

    def copy(self):
        columns = {name: values.copy() for name, values in self.columns.items()}
        return Log(json.loads(json.dumps(self.experiment)), columns, self.links, self.motors, self.torques, self.gears)

    def scale(self, names, by):
        for name in names:
            self.columns[name] *= by

    def swap(self, one, two):
        self.columns[one], self.columns[two] = self.columns[two], self.columns[one]

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        table = np.column_stack(list(self.columns.values()))
        np.savetxt(folder / "log.csv", table, "%.9g", ",", header=",".join(self.columns), comments="")
        write_experiment(folder, self.experiment)


@dataclass
class Outcome:
    """The findings of a check about a damaged log, and the effect of its lines."""

    log: str
    fault: str
    first: str = ""
    right: bool = False
    worse: list = field(default_factory=list)
    said: list = field(default_factory=list)


def toml(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(key)} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def write_experiment(folder, experiment):
    lines = []
    for key, value in experiment.items():
        if isinstance(value, dict):
            lines += [f"[{key}]"] + [f"{json.dumps(name)} = {toml(of)}" for name, of in value.items()]
        else:
            lines.insert(0, f"{key} = {toml(value)}")
    (folder / "experiment.toml").write_text("\n".join(lines) + "\n")


def run(binary, *words):
    return subprocess.run([binary, *map(str, words)], capture_output=True, text=True)


def columns_of(keys, quantity):
    """Returns the columns of a quantity, and the factor of its readings to radians or N·m."""
    for key, value in keys.items():
        if key.startswith(quantity) and not key.endswith("_side"):
            channel = value if isinstance(value, dict) else {"column": value}
            counts = channel.get("counts_per_turn")
            return key, channel["column"], 2 * np.pi / counts if counts else 1.0
    return None, [], 1.0


def sound(folder, name, gears, rigid=False):
    """Reads an experiment with its log, and brings readings to radians."""
    experiment = tomllib.loads((folder / "experiment.toml").read_text())
    keys, robot = experiment["log"], experiment["robot"]
    path = folder / keys["file"]
    with open(path) as file:
        heads = file.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    log = {"file": "log.csv", "time_s": keys["time_s"]}
    columns, names = {keys["time_s"]: table[:, heads.index(keys["time_s"])]}, {}
    for quantity in QUANTITIES[:3]:
        _, column_names, factor = columns_of(keys, quantity)
        names[quantity] = column_names
        if rigid and quantity == "link_position":
            continue
        if quantity == "motor_position" and "side" in str(keys.get("motor_position", "")):
            log["motor_position_side"] = "motor"
        log[quantity + ("_nm" if quantity == "motor_torque" else "_rad")] = column_names
        for column in column_names:
            columns[column] = factor * table[:, heads.index(column)]
    robot["name"] = name
    if "urdf" in robot:
        robot["urdf"] = str((folder / robot["urdf"]).resolve())
    robot.setdefault("joint", [{"name": f"joint{k + 1}"} for k in range(len(names["motor_torque"]))])
    for joint, gear in zip(robot["joint"], gears or []):
        joint.setdefault("gear_ratio", gear)
    if rigid:
        for joint in robot["joint"]:
            joint["transmission"] = "rigid"
            joint.pop("nominal", None)
    known = [joint.get("gear_ratio", GEAR) for joint in robot["joint"]]
    identify = {"estimator": ["least-squares"], "on_check_error": "go-on"}
    kept = {"format": 1, "robot": robot, "log": log, "identify": identify}
    links = [] if rigid else names["link_position"]
    return Log(kept, columns, links, names["motor_position"], names["motor_torque"], known)


def make(args, name):
    """Returns a sound log."""
    base, rigid = args.out / "sound", name.endswith("-rigid")
    kind = name.removesuffix("-rigid")
    folder = base / kind
    if kind.startswith("demo"):
        seed = int(kind.split("-")[1])
        if not (folder / "experiment.toml").exists():
            run(args.binary, "demo", "--out", folder, "--seed", seed, "-q").check_returncode()
        # The file of the second demo has no gear ratios.
        return sound(folder, name, [GEAR] * 2 if seed == 1 else None)
    if kind == "twin":
        if not (folder / "experiment.toml").exists():
            example = ROOT / "examples/seven-joint-twin"
            folder.mkdir(parents=True, exist_ok=True)
            for file in ("experiment.toml", "truth.toml"):
                (folder / file).write_text((example / file).read_text())
            run(args.binary, "simulate", folder / "experiment.toml", "-q").check_returncode()
        return sound(folder, name, [GEAR, GEAR, GEAR, 51, 51, 51, 51], rigid)
    return sound(args.foreign / f"{kind}-s1-k100" / "mean-500", name, None, rigid)


def damaged(log, fault, number):
    """Returns a log with a fault. `number` selects the joint and the size."""
    log = log.copy()
    count = len(log.motors)
    one, two = number % count, (number + 1) % count
    if fault == "torque-scale":
        log.scale([log.torques[one]], [100.0, 1000.0, 10.0, 0.01, 0.001, 0.1, 100.0][number % 7])
    elif fault == "gear-on-position":
        if log.log.pop("motor_position_side", None) is None:
            for name, gear in zip(log.motors, log.gears):
                log.scale([name], gear)
    elif fault == "gear-on-torque":
        for name, gear in zip(log.torques, log.gears):
            log.scale([name], 1 / gear)
    elif fault == "sign-of-link":
        log.scale([log.links[one]], -1.0)
    elif fault == "sign-of-motor":
        log.scale([log.motors[one]], -1.0)
    elif fault == "degrees":
        log.scale(log.links + log.motors, 180 / np.pi)
    elif fault == "torques-exchanged":
        log.swap(log.torques[one], log.torques[two])
    elif fault == "links-exchanged":
        log.swap(log.links[one], log.links[two])
    return log


def mended(experiment, setting):
    """Returns the experiment with a line of a finding, or None if the line cannot be written unchanged."""
    experiment = json.loads(json.dumps(experiment))
    table, line = re.match(r"(\[+[\w.]+\]+) (.*)", setting).groups()
    beside = re.search(r"#.*with (\w+ = \S+) in \[log\]", line)
    try:
        keys = tomllib.loads(re.sub(r"; (?=\w+ = )", "\n", line))
        further = tomllib.loads(beside.group(1)) if beside else {}
    except tomllib.TOMLDecodeError:
        return None
    if table == "[[robot.joint]]":
        for joint in experiment["robot"]["joint"]:
            joint.update(keys)
        experiment["log"].update(further)
        return experiment
    target = experiment.setdefault(table.strip("[]"), {})
    for key, value in keys.items():
        quantity = next((name for name in QUANTITIES if key.startswith(name)), None)
        if table == "[log]" and quantity and not key.endswith("_side"):
            of = "motor_torque" if quantity == "motor_current" else quantity
            for name in [name for name in target if name.startswith(of) and not name.endswith("_side")]:
                del target[name]
        if isinstance(value, dict) and key in ("sign", "gain", "delay_s"):
            target[key] = target.get(key, {}) | value
        else:
            target[key] = value
    return experiment


def identified(args, folder):
    """Returns the drives by least squares, and the unexplained parts of the motor torques; None if there are none."""
    done = run(args.binary, "identify", folder, "-q", "--no-progress", "--threads", 1)
    if done.returncode not in (0, 1):
        return None
    result = json.loads((folder / "sprung-out/identification.json").read_text())["results"][0]
    drives = {
        parameter["name"]: parameter["value"] for parameter in result["parameters"] if parameter["name"].endswith(DRIVE)
    }
    figures = json.loads(run(args.binary, "check", folder, "--json", "--threads", 1).stdout)["joints"]
    return drives, [1 - joint["explained_percent"] / 100 for joint in figures]


def distance(found, truth):
    """Returns the mean distance of logarithms; a value of another sign counts as far away."""
    if found is None:
        return np.inf, np.inf
    logarithms = []
    for name, true in truth[0].items():
        ratio = (found[0].get(name) or 0.0) / true
        logarithms.append(min(abs(np.log(ratio)), 7.0) if ratio > 0 else 7.0)
    return float(np.mean(logarithms)), float(np.mean(found[1]))


def judge(args, name, fault, number, base, truth):
    """Checks a damaged log, and tries each line of its findings."""
    folder = args.out / "damaged" / f"{name}-{fault}"
    log = damaged(base, fault, number)
    log.write(folder)
    done = run(args.binary, "check", folder, "--json", "--threads", 1)
    outcome = Outcome(name, fault)
    try:
        report = json.loads(done.stdout)
    except json.JSONDecodeError:
        outcome.said.append(done.stderr.strip()[:300])
        return outcome
    before = distance(identified(args, folder), truth)
    lines = {}  # in their order, each once
    loud = [finding for finding in report["findings"] if finding["severity"] != "info"]
    if loud:
        outcome.first = loud[0]["code"]
        outcome.right = not loud[0].get("setting") and NAMED.get(fault, "\0") in loud[0]["remedy"]
    for finding in loud:
        setting = finding.get("setting")
        outcome.said.append(f"{finding['severity']} {finding['code']}: {finding['text'][:160]} | {setting}")
        if setting:
            lines[setting] = True
    for setting in lines:
        experiment = mended(log.experiment, setting)
        if experiment is None:
            outcome.said.append(f"    cannot be written: {setting}")
            continue
        write_experiment(folder, experiment)
        after = identified(args, folder)
        far, left = distance(after, truth)
        if np.isfinite(far) and (far > before[0] + MORE_DISTANCE or left > before[1] + MORE_UNEXPLAINED):
            outcome.worse.append(setting)
        values = [] if after is None else [after[0].get(parameter, 0.0) / true for parameter, true in truth[0].items()]
        near = bool(values) and all(1 / SAME < value < SAME for value in values)
        outcome.said.append(f"    {setting[:60]}: distance {before[0]:.3f} -> {far:.3f}, left {before[1]:.3g} -> {left:.3g}")
        if setting == loud[0].get("setting"):
            outcome.right = near
    write_experiment(folder, log.experiment)
    return outcome


def words(text):
    return [word.strip() for word in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of the logs")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    parser.add_argument("--foreign", type=Path, default=Path("/tmp/foreign"), help="folder of the foreign logs")
    parser.add_argument("--logs", type=words, default=LOGS)
    parser.add_argument("--faults", type=words, default=FAULTS)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="prints the findings")
    parser.add_argument("--strict", action="store_true", help="exit code 1 if a requirement is missed")
    args = parser.parse_args()
    tasks = []
    for place, name in enumerate(args.logs):
        base = make(args, name)
        folder = args.out / "damaged" / f"{name}-none"
        base.write(folder)
        truth = identified(args, folder)
        report = json.loads(run(args.binary, "check", folder, "--json", "--threads", 1).stdout)
        loud = [finding["code"] for finding in report["findings"] if finding["severity"] != "info"]
        print(f"{name:12} sound: {', '.join(loud) or 'no finding'}", flush=True)
        for k, fault in enumerate(args.faults):
            if fault in ("sign-of-link", "links-exchanged") and not base.links:
                continue
            tasks.append((name, fault, place + k, base, truth))
    outcomes = []
    with ThreadPoolExecutor(args.jobs) as pool:
        for outcome in pool.map(lambda task: judge(args, *task), tasks):
            outcomes.append(outcome)
            word = "right" if outcome.right else "WRONG"
            worse = f", {len(outcome.worse)} worse" if outcome.worse else ""
            print(f"{outcome.log:12}{outcome.fault:20}{word}{worse}  {outcome.first}", flush=True)
            if args.verbose or not outcome.right or outcome.worse:
                print("\n".join("      " + line for line in outcome.said), flush=True)
    print(f"\n{'fault':20}{'logs':>6}{'right':>7}{'worse':>7}")
    for fault in args.faults:
        group = [one for one in outcomes if one.fault == fault]
        print(f"{fault:20}{len(group):6}{sum(one.right for one in group):7}{sum(bool(one.worse) for one in group):7}")
        name = fault.replace("-", " ")
        note(fault, f"{name}, {len(group)} logs: right", sum(one.right for one in group), "", better="higher")
        note(f"{fault}, worse", f"{name}: lines that make it worse", sum(bool(one.worse) for one in group), "")
    right, worse = np.mean([outcome.right for outcome in outcomes]), sum(bool(outcome.worse) for outcome in outcomes)
    print(f"{'all':20}{len(outcomes):6}{sum(outcome.right for outcome in outcomes):7}{worse:7}")
    sys.exit(args.strict and (right < LEAST_RIGHT or worse > 0))


if __name__ == "__main__":
    main()
