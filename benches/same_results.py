#!/usr/bin/env python3
"""Compares the identifications of two builds of sprung, number by number.

    benches/same_results.py OLD NEW [--logs FOLDER] [--estimator NAME] [EXAMPLE ...]

OLD and NEW are two binaries `sprung`. Both identify each example, and the script compares every
number of the two `identification.json`. A number of a parameter may differ by a fraction of that
parameter's standard error, and any other number by a fraction of itself. The fraction is 1e-6 for
least squares and LSFF, and 1e-2 for the refinement, whose search stops at 0.02 standard errors.
Words, names and codes must be equal. Times are not compared. Instrumental variables are not compared
if only one build computed them.

OLD simulates the examples `paper` and `seven`. The other examples use measured logs, which are not
part of the project; FOLDER contains them under the names that their README gives. Without
--estimator, the script runs least squares and the refinement. The exit code is 1 if a difference is
larger than allowed.
"""

import argparse
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

LEAST_SQUARES = 1e-6
REFINEMENT = 1e-2
LEFT_OUT = {"elapsed_s", "generator"}
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def run(*words):
    """Runs a command. Exit code 1 is accepted, because it means an unusable result."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode > 1:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stderr}")


def prepared(name, old, logs, work):
    """Makes a folder with the experiment file and the log of an example."""
    folder = work / name
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


def identified(binary, folder, estimator):
    """Identifies an example and returns its identification.json."""
    out = folder / "found"
    run(binary, "identify", folder, "--quiet", "--out", out,
        "--set", f'identify.estimator=["{estimator}"]')
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
            if path.endswith(("cross_checks", "warnings")):
                a, b = without_instruments(a, b)
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
            own = self.errors.get(key, scale)
            if own is None and key in ("delay_s", "offset_rad"):
                own = a.get("standard_error_s") or a.get("standard_error_rad")
            if key in ("torque_rms_nm", "torque_share", "torque_over_residual", "nominal"):
                own = None
            self.value(f"{path}.{key}", a[key], b[key], own)


def without_instruments(a, b):
    """Removes entries about instrumental variables that only one of the two builds has."""

    def names(entries):
        return {entry.get("method") or entry.get("code") for entry in entries}

    only_one = {"instrumental-variables", "no-instruments"} & (names(a) ^ names(b))

    def kept(entries):
        return [entry for entry in entries if not names([entry]) & only_one]

    return kept(a), kept(b)


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("--logs", type=Path, help="folder of the measured logs")
    parser.add_argument("--estimator", action="append", help="run this estimator only")
    parser.add_argument("examples", nargs="*", help=", ".join([*SIMULATED, *MEASURED]))
    args = parser.parse_intermixed_args()
    old, new = args.old.resolve(), args.new.resolve()
    examples = args.examples or [*SIMULATED, *(MEASURED if args.logs else [])]
    estimators = args.estimator or ["least-squares", "prediction-error"]
    failed = False
    print(f"{'example':<10} {'estimator':<18} {'numbers':>7} {'largest':>9}  relative to the allowed difference, at")
    with tempfile.TemporaryDirectory() as work:
        for name in examples:
            if name not in SIMULATED and name not in MEASURED:
                sys.exit(f"there is no example {name!r}")
            if name in MEASURED and args.logs is None:
                sys.exit(f"{name} needs --logs FOLDER")
            folder = prepared(name, old, args.logs, Path(work))
            for estimator in estimators:
                before = identified(old, folder, estimator)
                after = identified(new, folder, estimator)
                result = before["results"][0]
                errors = {p["name"]: p["standard_error"] for p in result["parameters"]
                          if p.get("standard_error")}
                refined = (result.get("refinement") or {}).get("used")
                allowed = REFINEMENT if estimator == "prediction-error" else LEAST_SQUARES
                comparison = Comparison(errors, allowed)
                comparison.value("", before, after)
                part, path = comparison.worst
                note = "" if refined is None else f" (refinement {'used' if refined else 'not used'})"
                print(f"{name:<10} {estimator:<18} {comparison.numbers:>7} {part:>9.2g}  {path}{note}",
                      flush=True)
                for line in comparison.apart[:20]:
                    print(f"    {line}")
                if len(comparison.apart) > 20:
                    print(f"    and {len(comparison.apart) - 20} more")
                failed |= bool(comparison.apart)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
