#!/usr/bin/env python3
"""Compares the identifications of two builds of sprung, number by number.

    benches/same_results.py OLD NEW [--logs FOLDER] [--estimator NAME] [EXAMPLE ...]

OLD and NEW are two binaries `sprung`. Both identify each example, and the script compares every
number of the two `identification.json` (of a servo, the two `servo.json`). A number of a parameter may
differ by a fraction of that parameter's standard error, and any other number by a fraction of itself.
The fraction is 1e-6 for least squares and LSFF, and 1e-2 for the refinement, whose search stops at 0.02
standard errors. Words, names and codes must be equal. Times are not compared.

OLD simulates most examples: `paper` (the demo), `seven`, and those of CASES, each of which is an example with
one more feature. The other examples use measured logs, which are not part of the project; FOLDER contains
them under the names that their README gives. Without --estimator, the script runs least squares and the
refinement, or the estimators that CASES names. The exit code is 1 if a difference is larger than allowed.
"""

import argparse
import csv
import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "examples"

# Folder of each example, and its log and other files, relative to the folder of logs.
MEASURED = {
    "emps": ("emps", ["emps/emps_estimation.csv"]),
    "quanser": ("quanser-2dsfl", ["quanser_2dsfl/quanser_2dsfl_psf.csv"]),
    "neura": ("neura-lara8", ["neura_lara8/orig/jogging_joint_mass.csv"]),
    "tx40": ("staubli-tx40", ["staubli_tx40/staubli_tx40_1kHz.csv", "staubli_tx40/tx40.urdf"]),
}
SIMULATED = ("paper", "seven")

DEMO_LINKS = 'link_position_rad  = ["q1_rad", "q2_rad"]'
DEMO_TORQUES = 'motor_torque_nm    = ["tau1_nm", "tau2_nm"]'
DEMO_LOG = 'file = "identification.csv"'
SEVEN_LINKS = next(line for line in (EXAMPLES / "seven-joint-twin" / "experiment.toml").read_text().splitlines()
                   if line.startswith("link_position_rad"))


class Case:
    """A robot that OLD simulates and both builds identify.

    - base: "demo", or the folder of an example
    - replaced: pairs of texts, replaced in the experiment file before the logs are simulated
    - logs: for each log, the overrides of its simulation
    - truth: values of the truth of all logs; loaded: those of the logs whose names start with "loaded"
    - told: pairs of texts, replaced in the experiment file before it is identified
    - late: samples by which the last columns of each log are late, by column
    - estimators: the estimators that run; None for a servo, which has one
    """

    def __init__(self, base, replaced=(), logs=None, truth=None, loaded=None, told=(), late=None,
                 estimators=("least-squares",)):
        self.base = base
        self.replaced = replaced
        self.logs = logs or {"identification.csv": []}
        self.truth = truth or {}
        self.loaded = loaded or {}
        self.told = told
        self.late = late or {}
        self.estimators = estimators


BOTH = ("least-squares", "prediction-error")
COVARIATE = 'friction_covariates = {{ temperature = [{}], reference_c = 35.0 }}\ntorque_constant_nm_per_a = {}'
SHORT = "simulate.duration_s=6.0"

CASES = {
    "sensors": Case(
        "seven-joint-twin",
        [(SEVEN_LINKS, SEVEN_LINKS + '\njoint_torque_nm = ["ts1", "ts2", "ts3", "ts4", "ts5", "ts6", "ts7"]')],
        {"identification.csv": [SHORT, "simulate.joint_torque_noise_nm=[0.087,0.087,0.087,0.087,0.012,0.012,0.012]"]},
    ),
    "springs": Case(
        "demo",
        [(DEMO_LINKS, 'joint_torque_nm = ["ts1", "ts2"]')],
        {"identification.csv": ["simulate.joint_torque_noise_nm=[0.002,0.0005]"]},
        estimators=BOTH,
    ),
    "gyroscopes": Case(
        "demo",
        [(DEMO_LINKS, 'gyroscope_rad_per_s.z = ["w1", "w2"]'),
         ('estimator = ["prediction-error", "least-squares", "lsff"]', 'estimator = "least-squares"')],
        {"identification.csv": ["simulate.duration_s=30.0", "simulate.gyroscope_noise_rad_per_s=[0.0022,0.0022]",
                                "simulate.gyroscope_bias_rad_per_s=[0.02,-0.03]"]},
    ),
    "servo": Case(
        "servo-pendulum", logs={"light.csv": None, "heavy.csv": None}, estimators=None),
    "payload": Case(
        "seven-joint-twin",
        logs={"empty.csv": [SHORT], "loaded.csv": [SHORT, "simulate.seed=2"],
              "loaded-known.csv": [SHORT, "simulate.seed=3"]},
        # 1.5 kg at (20, -30, 80) mm.
        loaded={"link7.m": 1.5, "link7.mx": 0.03, "link7.my": -0.045, "link7.mz": 0.12,
                "link7.ixx": 0.01095, "link7.iyy": 0.0102, "link7.izz": 0.00195,
                "link7.ixy": 0.0009, "link7.ixz": -0.0024, "link7.iyz": 0.0036},
        told=[('file = "identification.csv"',
               'file = ["empty.csv", { path = "loaded.csv", payload = { name = "tool" } },'
               ' { path = "loaded-known.csv", payload = { mass_kg = 1.5, com_m = [0.02, -0.03, 0.08] } }]')],
    ),
    "covariates": Case(
        "demo",
        [("torque_constant_nm_per_a = 0.119", COVARIATE.format('"motor_viscous", "motor_coulomb"', 0.119)),
         ("torque_constant_nm_per_a = 0.0234", COVARIATE.format('"motor_viscous"', 0.0234)),
         (DEMO_TORQUES, 'temperature_c = ["warm1", "warm2"]\n' + DEMO_TORQUES)],
        {"identification.csv": ["simulate.temperature_start_c=[25.0,28.0]", "simulate.temperature_end_c=[45.0,42.0]"]},
        truth={"joint1.motor_viscous_per_k": -0.12, "joint1.motor_coulomb_per_k": -0.015,
               "joint2.motor_viscous_per_k": -0.002},
        estimators=BOTH,
    ),
    "delays": Case(
        "demo",
        logs={"identification.csv": [SHORT]},
        told=[(DEMO_TORQUES, DEMO_TORQUES + '\ndelay_s = { q2_rad = -0.002, tau1_nm = 0.0028 }')],
        late={"q1_rad": 2, "phi1_rad": 2, "phi2_rad": 2, "tau1_nm": 5, "tau2_nm": 2},
        estimators=BOTH,
    ),
    "logs": Case(
        "demo",
        logs={"one.csv": [SHORT], "two.csv": ["simulate.duration_s=2.5", "simulate.seed=2"],
              "three.csv": ["simulate.duration_s=4.0", "simulate.seed=3"]},
        told=[(DEMO_LOG, 'file = ["one.csv", "two.csv", "three.csv"]')],
        estimators=("least-squares", "prediction-error", "lsff"),
    ),
    "laws": Case(
        "demo",
        [("coulomb_sharpness_s_per_rad = 100.0",
          'coulomb_sharpness_s_per_rad = 100.0\nstribeck_velocity_rad_per_s = 0.2\n'
          'motor_friction = ["viscous", "coulomb", "stribeck"]')],
        truth={"joint1.motor_stribeck": 0.8, "joint2.motor_stribeck": 0.1},
        told=[('stribeck_velocity_rad_per_s = 0.2\nmotor_friction = ["viscous", "coulomb", "stribeck"]', ""),
              ("[identify]\n", '[identify]\nlaws = "auto"\n')],
        late={"tau1_nm": 4, "tau2_nm": 4},
        estimators=BOTH,
    ),
}

LEAST_SQUARES = 1e-6
REFINEMENT = 1e-2
LEFT_OUT = {"elapsed_s", "generator"}
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def run(*words, env=None):
    """Runs a command. Exit code 1 is accepted, because it means an unusable result."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=env)
    if done.returncode > 1:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stderr}")


def replaced(text, pairs):
    """Replaces texts, each of which must occur."""
    for old, new in pairs:
        if old not in text:
            sys.exit(f"the experiment file no longer contains {old!r}; change CASES")
        text = text.replace(old, new)
    return text


def with_values(truth, values, add):
    """Replaces values of a file of parameters, or adds them. `add` adds to the value of the file."""
    for name, value in values.items():
        line = re.search(f'^"{re.escape(name)}" *= *(.*)$', truth, re.MULTILINE)
        if line:
            value += float(line[1]) if add else 0.0
            truth = truth.replace(line[0], f'"{name}" = {value!r}')
        else:
            truth += f'\n"{name}" = {value!r}\n'
    return truth


def made_late(path, late):
    """Delays columns of a log by a number of samples."""
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    for name, samples in late.items():
        column = head.index(name)
        values = [row[column] for row in rows]
        for row, value in zip(rows, values[:1] * samples + values):
            row[column] = value
    with path.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([head, *rows])


def simulated(case, old, folder):
    """Makes a folder with the experiment file and the logs of a case."""
    if case.base == "demo":
        run(old, "demo", "--quiet", "--out", folder)
    else:
        shutil.copytree(EXAMPLES / case.base, folder)
    shutil.rmtree(folder / "sprung-out", ignore_errors=True)
    experiment, parameters = folder / "experiment.toml", folder / "truth.toml"
    text = replaced(experiment.read_text(), case.replaced)
    experiment.write_text(text)
    simulated_here = folder / "simulated"
    truth = with_values(parameters.read_text(), case.truth, add=False)
    if None in case.logs.values():
        # A servo simulates all its logs at once.
        parameters.write_text(truth)
        run(old, "simulate", folder, "--quiet")
    else:
        for log, sets in case.logs.items():
            with_load = with_values(truth, case.loaded, add=True) if log.startswith("loaded") else truth
            parameters.write_text(with_load)
            overrides = [word for one in [f'log.file="{log}"', *sets] for word in ("--set", one)]
            run(old, "simulate", folder, "--quiet", "--out", simulated_here, *overrides)
            (simulated_here / log).replace(folder / log)
            made_late(folder / log, case.late)
    experiment.write_text(replaced(text, case.told))
    return folder


def prepared(name, old, logs, work):
    """Makes a folder with the experiment file and the log of an example."""
    folder = work / name
    if name in CASES:
        return simulated(CASES[name], old, folder)
    if name == "paper":
        run(old, "demo", "--quiet", "--out", folder)
    elif name == "seven":
        shutil.copytree(EXAMPLES / "seven-joint-twin", folder)
        run(old, "simulate", folder, "--quiet", "--out", folder / "log")
        shutil.copy(folder / "log" / "identification.csv", folder)
        text = (folder / "experiment.toml").read_text()
        if "\nfile = " not in text:
            text = text.replace("\n[log]\n", '\n[log]\nfile = "identification.csv"\n')
        (folder / "experiment.toml").write_text(text)
    else:
        example, files = MEASURED[name]
        folder.mkdir()
        shutil.copy(EXAMPLES / example / "experiment.toml", folder)
        for file in files:
            shutil.copy(logs / file, folder)
    return folder


def identified(binary, folder, estimator, out="found", env=None):
    """Identifies an example and returns its identification.json, or servo.json if it is a servo."""
    out = folder / out
    if estimator is None:
        run(binary, "identify", folder, "--quiet", "--out", out, env=env)
        result = json.loads((out / "servo.json").read_text())
    else:
        run(binary, "identify", folder, "--quiet", "--out", out,
            "--set", f'identify.estimator=["{estimator}"]', env=env)
        result = json.loads((out / "identification.json").read_text())
    shutil.rmtree(out)
    return result


class Comparison:
    """Differences of two results, relative to the allowed difference."""

    def __init__(self, errors, allowed):
        self.errors = errors
        self.allowed = allowed
        self.numbers = 0
        self.worst = (0.0, "")
        self.apart = []

    def number(self, path, a, b, scale):
        self.numbers += 1
        if a == b or (math.isnan(a) and math.isnan(b)):
            return
        part = abs(a - b) / (scale * self.allowed) if scale > 0 else math.inf
        if part > self.worst[0]:
            self.worst = (part, path)
        if not part <= 1:
            self.apart.append(f"{path}: {a!r} became {b!r}")

    def text(self, path, a, b):
        """Compares words exactly and the rounded numbers between them within 2 %."""
        if NUMBER.sub("#", a) != NUMBER.sub("#", b):
            self.apart.append(f"{path}: {a!r} became {b!r}")
            return
        for x, y in zip(NUMBER.findall(a), NUMBER.findall(b)):
            if abs(float(x) - float(y)) > 0.02 * max(abs(float(x)), abs(float(y))):
                self.apart.append(f"{path}: {a!r} became {b!r}")
                return

    def value(self, path, a, b, scale=None):
        if isinstance(a, dict) and isinstance(b, dict):
            self.table(path, a, b, scale)
        elif isinstance(a, list) and isinstance(b, list):
            if len(a) != len(b):
                self.apart.append(f"{path}: {len(a)} entries became {len(b)}")
            for k, (x, y) in enumerate(zip(a, b)):
                self.value(f"{path}[{k}]", x, y, scale)
        elif isinstance(a, str) and isinstance(b, str):
            self.text(path, a, b)
        elif is_number(a) and is_number(b):
            self.number(path, a, b, scale or max(abs(a), abs(b)))
        elif a != b:
            self.apart.append(f"{path}: {a!r} became {b!r}")

    def table(self, path, a, b, scale):
        scale = self.errors.get(a.get("name"), scale)
        for key in sorted(a.keys() | b.keys()):
            if key in LEFT_OUT:
                continue
            if key not in a or key not in b:
                self.apart.append(f"{path}.{key}: only in one of the two")
                continue
            key_scale = self.errors.get(key, scale)
            if key_scale is None and key in ("delay_s", "offset_rad"):
                key_scale = a.get("standard_error_s") or a.get("standard_error_rad")
            if key in ("torque_rms_nm", "torque_share", "torque_over_residual", "nominal"):
                key_scale = None
            self.value(f"{path}.{key}", a[key], b[key], key_scale)


def errors_of(result):
    """Returns the standard errors of a result, by parameter."""
    return {p["name"]: p["standard_error"] for p in result["parameters"] if p.get("standard_error")}


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--logs", type=Path, help="folder of the measured logs")
    parser.add_argument("--estimator", action="append", help="run this estimator only")
    parser.add_argument("examples", nargs="*", help=", ".join([*SIMULATED, *CASES, *MEASURED]))
    args = parser.parse_intermixed_args()
    old, new = args.old.resolve(), args.new.resolve()
    examples = args.examples or [*SIMULATED, *CASES, *(MEASURED if args.logs else [])]
    failed = False
    print(f"{'example':<10} {'estimator':<18} {'numbers':>7} {'largest':>9}  relative to the allowed difference, at")
    with tempfile.TemporaryDirectory() as work:
        for name in examples:
            if name not in SIMULATED and name not in CASES and name not in MEASURED:
                sys.exit(f"there is no example {name!r}")
            if name in MEASURED and args.logs is None:
                sys.exit(f"{name} needs --logs FOLDER")
            folder = prepared(name, old, args.logs, Path(work))
            estimators = CASES[name].estimators if name in CASES else BOTH
            for estimator in [None] if estimators is None else args.estimator or estimators:
                before = identified(old, folder, estimator)
                after = identified(new, folder, estimator)
                result = before if estimator is None else before["results"][0]
                errors = errors_of(result)
                refined = (result.get("refinement") or {}).get("used")
                allowed = REFINEMENT if estimator == "prediction-error" else LEAST_SQUARES
                comparison = Comparison(errors, allowed)
                comparison.value("", before, after)
                part, path = comparison.worst
                method = estimator or "servo"
                note = "" if refined is None else f" (refinement {'used' if refined else 'not used'})"
                print(f"{name:<10} {method:<18} {comparison.numbers:>7} {part:>9.2g}  {path}{note}",
                      flush=True)
                for line in comparison.apart[:20]:
                    print(f"    {line}")
                if len(comparison.apart) > 20:
                    print(f"    and {len(comparison.apart) - 20} more")
                failed |= bool(comparison.apart)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
