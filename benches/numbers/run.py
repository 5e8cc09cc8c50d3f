#!/usr/bin/env python3
"""Shows what each named number of a folder does: identifies with half and with twice its value.

    benches/numbers/run.py [FOLDER] [--logs FOLDER] [--work FOLDER] [--only TEXT] [--cases NAME,...]

FOLDER is a part of a crate, by default `crates/sprung-method/src/estimate`. The script copies the repository,
replaces each named number of the folder by one that an environment variable scales, and compiles the copy
once. It then identifies the cases of `../same_results.py` and those of CASES below once for each number that
the case uses and each factor ½ and 2. The measured examples join with --logs.

The table has, for each number and factor,

- moved: largest change of a parameter, a delay or an encoder offset, in its standard errors
- error: largest relative change of a standard error
- other: largest relative change of any further number of the result
- what: verdicts, findings and laws that came or went, and the cases in which an identification failed

and at the end the numbers that no case uses, those that only the compiler uses, and those that change nothing: no
value by more than 0.01 standard errors, no standard error by more than 1 %, no verdict, finding or law. --work keeps
the compiled copy and the finished cases, so that an interrupted run continues.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent))

import same_results as same  # noqa: E402
from copy_with_numbers import copied  # noqa: E402

FACTORS = (0.5, 2.0)
NOTHING = 0.01

BRIEF = "simulate.duration_s=2.5"

# Cases beside those of `same_results.py`: a short log of the demo, one without the friction that its robot has,
# and an arm that is mounted otherwise than described.
CASES = {
    "brief": same.Case("demo", logs={"identification.csv": [BRIEF]}),
    "lacking": same.Case(
        "demo",
        [("coulomb_sharpness_s_per_rad = 100.0",
          'coulomb_sharpness_s_per_rad = 100.0\nstribeck_velocity_rad_per_s = 0.2\n'
          'motor_friction = ["viscous", "coulomb", "stribeck"]')],
        logs={"identification.csv": [BRIEF]},
        truth={"joint1.motor_stribeck": 0.8, "joint2.motor_stribeck": 0.1},
        told=[('stribeck_velocity_rad_per_s = 0.2\nmotor_friction = ["viscous", "coulomb", "stribeck"]', "")],
        late={"tau1_nm": 4}),
    "tilted": same.Case(
        "seven-joint-twin", logs={"identification.csv": [same.SHORT]},
        told=[("[0.0, 0.0, -9.81]", "[2.54, 0.0, -9.476]")]),
}

# Case and estimator. Each takes a few seconds.
RUNS = [
    ("paper", "least-squares"),
    ("brief", "prediction-error"),
    ("lacking", "prediction-error"),
    ("tilted", "least-squares"),
    ("logs", "least-squares"),
    ("logs", "lsff"),
    ("laws", "least-squares"),
    ("covariates", "least-squares"),
    ("springs", "least-squares"),
    ("payload", "least-squares"),
    ("sensors", "least-squares"),
    ("emps", "least-squares"),
    ("emps", "prediction-error"),
    ("quanser", "least-squares"),
    ("neura", "least-squares"),
    ("tx40", "least-squares"),
]


def built(work, folder):
    """Compiles the copy. Returns the program, the numbers that it scales, and those that the compiler needs."""
    copy = work / "copy"
    copy.mkdir(exist_ok=True)
    numbers, fixed = copied(ROOT, copy, folder)
    target = work / "target"
    print(f"{len(numbers)} numbers; compiling", flush=True)
    done = subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "sprung-cli", "--target-dir", target],
                          cwd=copy, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit("\n".join(done.stderr.splitlines()[-60:]))
    return target / "release" / "sprung", numbers, fixed


class Change:
    """What a number did in one case."""

    def __init__(self, moved=0.0, error=0.0, other=0.0, what=()):
        self.moved = moved
        self.error = error
        self.other = other
        self.what = list(what)

    def joined(self, other, case):
        self.moved = max(self.moved, other.moved)
        self.error = max(self.error, other.error)
        self.other = max(self.other, other.other)
        self.what += [f"{case}: {text}" for text in other.what]

    def is_nothing(self):
        return self.moved <= NOTHING and self.error <= NOTHING and not self.what


class Split(same.Comparison):
    """A comparison that separates values, standard errors and further numbers."""

    def __init__(self, errors):
        super().__init__(errors, 1.0)
        self.change = Change()

    def number(self, path, a, b, scale):
        before = self.worst
        self.worst = (0.0, "")
        super().number(path, a, b, scale)
        part, where = self.worst
        self.worst = before
        if not where:
            return
        last = path.rsplit(".", 1)[-1]
        if last in ("standard_error", "standard_error_s", "standard_error_rad"):
            self.change.error = max(self.change.error, abs(a - b) / max(abs(a), abs(b)))
        elif ".parameters[" in path and last == "value" or last in ("delay_s", "offset_rad"):
            self.change.moved = max(self.change.moved, part)
        else:
            self.change.other = max(self.change.other, abs(a - b) / max(abs(a), abs(b)))


def words(result):
    """Returns the verdicts, findings and laws of a result."""
    codes = [finding["code"] for finding in result["findings"]]
    for one in result["results"]:
        codes += [finding["code"] for finding in one["warnings"]]
        codes.append(f"verdict {one['verdict']}")
        refined = one.get("refinement") or {}
        codes.append(f"used {refined.get('used')}")
    codes += [unknown["id"] for unknown in result.get("unknowns", [])]
    return sorted(codes)


def compared(before, after):
    """Returns what changed between two results."""
    comparison = Split(same.errors_of(before["results"][0]))
    comparison.value("", before, after)
    change = comparison.change
    old, new = words(before), words(after)
    change.what = [f"-{word}" for word in old if word not in new] + [f"+{word}" for word in new if word not in old]
    return change


def identified(binary, folder, estimator, name, factor):
    """Identifies a case with a scaled number. Returns its result, or a text if it failed."""
    env = dict(os.environ, RAYON_NUM_THREADS="1", SPRUNG_NUMBER=f"{name}={factor}")
    try:
        return same.identified(binary, folder, estimator, f"found-{name.replace('/', '-').replace(':', '-')}-{factor}", env)
    except (SystemExit, OSError, ValueError, IndexError) as fault:
        return str(fault).splitlines()[-1] if str(fault) else "failed"


def prepared(name, binary, logs, work):
    if name in CASES:
        return same.simulated(CASES[name], binary, work / name)
    return same.prepared(name, binary, logs, work)


def reference(binary, folder, estimator):
    """Identifies a case as it is. Returns its result, the numbers that it used, and its time in seconds."""
    used = folder / f"used-{estimator}"
    used.unlink(missing_ok=True)
    env = dict(os.environ, RAYON_NUM_THREADS="1", SPRUNG_NUMBERS_USED=str(used))
    begin = time.monotonic()
    result = same.identified(binary, folder, estimator, "reference", env)
    return result, set(used.read_text().split()), time.monotonic() - begin


def table(numbers, fixed, changes, used):
    """Prints what each number does."""
    print(f"\n{'number':<62} {'factor':>6} {'moved':>8} {'error':>8} {'other':>8}  what")
    still = []
    for name in numbers:
        if name not in used:
            continue
        number_changes = [changes[name, factor] for factor in FACTORS]
        if all(change.is_nothing() for change in number_changes):
            still.append(name)
        for factor, change in zip(FACTORS, number_changes):
            what = ", ".join(dict.fromkeys(change.what))
            print(f"{name:<62} {factor:>6} {change.moved:>8.2g} {change.error:>8.2g} {change.other:>8.2g}  {what[:160]}")
    for title, group in (("change nothing", still), ("no case uses", [name for name in numbers if name not in used]),
                         ("only the compiler uses", fixed)):
        print(f"\n{title}: {len(group)}")
        for name in group:
            print(f"    {name}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="crates/sprung-method/src/estimate")
    parser.add_argument("--logs", type=Path, help="folder of the measured logs")
    parser.add_argument("--work", type=Path, help="folder that keeps the compiled copy and finished cases")
    parser.add_argument("--only", default="", help="numbers whose names contain this text")
    parser.add_argument("--cases", help="names of the cases, separated by commas")
    args = parser.parse_args()
    work = args.work or Path(tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    try:
        measure(args, work.resolve())
    finally:
        if args.work is None:
            shutil.rmtree(work)


def measure(args, work):
    binary, numbers, fixed = built(work, args.folder)
    numbers = [name for name in numbers if args.only in name]
    finished = work / "finished.jsonl"
    known = (
        {tuple(key): values for key, values in map(json.loads, finished.read_text().splitlines())}
        if finished.exists()
        else {}
    )
    changes = {(name, factor): Change() for name in numbers for factor in FACTORS}
    all_used = set()
    folders = Path(tempfile.mkdtemp(dir=work))
    with finished.open("a") as log:
        for case, estimator in RUNS:
            if args.cases and case not in args.cases.split(",") or case in same.MEASURED and args.logs is None:
                continue
            folder = folders / case
            if not folder.exists():
                prepared(case, binary, args.logs, folders)
            before, used, seconds = reference(binary, folder, estimator)
            all_used |= used
            jobs = [(name, factor) for name in numbers if name in used for factor in FACTORS]

            def one(job):
                key = (case, estimator, *job)
                if key not in known:
                    after = identified(binary, folder, estimator, *job)
                    change = Change(what=[f"!{after}"]) if isinstance(after, str) else compared(before, after)
                    known[key] = vars(change)
                    log.write(json.dumps([key, known[key]]) + "\n")
                    log.flush()
                return job, Change(**known[key])

            begin = time.monotonic()
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                for job, change in pool.map(one, jobs):
                    changes[job].joined(change, f"{case} {estimator}")
            print(f"{case:<10} {estimator:<18} {len(jobs):>4} runs of {seconds:.1f} s, {time.monotonic() - begin:.0f} s",
                  flush=True)
    shutil.rmtree(folders)
    table(numbers, fixed, changes, all_used)


if __name__ == "__main__":
    main()
