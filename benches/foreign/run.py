"""Identifies the logs of `generate.py` with sprung, and compares its results with the truth.

    python run.py --out FOLDER [--binary SPRUNG] [--arms ur5,panda] [--seeds 1-3] [--sharpness 50,100,200]
                  [--records held,mean,late] [--rates 1000,500,250] [--effects none,ripple,load,error,heat]
                  [--estimator least-squares|prediction-error|both] [--set KEY=VALUE]... [--declared]
                  [--held-out] [--jobs N] [--strict]

The script generates the logs that FOLDER lacks, and keeps them. Each identification runs with one thread and replaces
`sprung-out` in the folder of its log. A table has, for each kind of parameter, record and rate,

- number: 95 % intervals; none: parameters without an interval
- inside: share of the intervals that contain the truth
- error: median error relative to the truth
- width: median ratio of half the interval to that of the Cramér-Rao bound (`bound.py`), without one-sided intervals

A second table has verdicts, findings and processor time of each record and rate. Findings of CLAIMS, laws of `unknowns`
and changes that sprung applies name effects. An effect is there if the robot has it. The lag of the torque is there if it is not zero, and `sharpness` if
it is not 100. Without an effect, each requirement has a line with the measured number; with --strict the exit code is 1 if
one of them is missed. --declared gives the true lag and sharpness to sprung.

--held-out validates each result on the second log of the robot and counts wrong verdicts: *good* is wrong if a held-out
error exceeds 1.5 times the promise, or if fewer than 80 % of the intervals contain the truth. A result is truly good if no
held-out error exceeds 1.1 times the promise and at least 90 % of the intervals contain the truth. Needs the packages of
`generate.py`.
"""

import argparse
import json
import os
import re
import subprocess
import sys
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

sys.dont_write_bytecode = True

import numpy as np  # noqa: E402

sys.path.append(str(Path(__file__).resolve().parents[1]))
from figure import note  # noqa: E402
from generate import RATES, RECORDS, add_robots, folder_of, make, names  # noqa: E402
from simulate import DRIVE  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
PREDICTION, LEAST = "prediction-error", "least-squares"
ESTIMATORS = {LEAST: [LEAST], PREDICTION: [PREDICTION], "both": [PREDICTION, LEAST]}
VERDICTS = ("good", "doubtful", "unusable", "failed")
SEVERITIES = ("serious", "warning", "info")
QUANTILE = 1.96
# Fewer intervals cannot show that too many of them contain the truth.
MANY_INTERVALS = 500
SOME_INTERVALS = 20
# Kinds of changes that sprung applies, by the effects that they name. Laws have their own words.
APPLIED = {"timing": "lag", "sharpness": "sharpness"}
LEAST_COVERAGE = 0.85
# Limits of wrong verdicts: held-out error over its promise, and coverage.
WRONG, TRULY_GOOD = (1.5, 0.8), (1.1, 0.9)

# Effects that findings name by their codes. Laws are named by their own words.
CLAIMS = {
    "late-channel": "lag", "delayed-channel": "lag", "torque-saturates": "saturation",
    "eccentric-encoder": "eccentricity", "presliding": "presliding",
    "torque-ripple": "ripple", "transmission-error": "error", "friction-drifts": "heat",
}
# Notes of these codes name effects, too.
NAMES = {"late-channel", "torque-saturates", "eccentric-encoder", "law-by-likelihood", "torque-ripple",
         "transmission-error", "friction-drifts"}


@dataclass
class Row:
    """A parameter: its kind, whether its interval contains the truth, relative error, and width."""

    kind: str
    inside: bool | None
    error: float | None
    width: float | None


@dataclass
class Case:
    """A log, and the results of sprung by estimator."""

    arm: str
    seed: int
    sharpness: int
    effect: str
    record: str
    rate: int
    there: set = field(default_factory=set)
    verdicts: dict = field(default_factory=dict)
    rows: dict = field(default_factory=dict)
    codes: dict = field(default_factory=dict)
    named: dict = field(default_factory=dict)
    over_promise: dict = field(default_factory=dict)
    seconds: float = 0.0
    fault: str = ""

    @property
    def robot(self):
        return self.arm, self.seed, self.sharpness, self.effect

    @property
    def log(self):
        return f"{self.record}-{self.rate}"

    def read(self, result, truth):
        """Reads identification.json."""
        there = {self.effect: self.effect != "none", "lag": abs(truth["lag_s"]) > 1e-9, "sharpness": self.sharpness != 100}
        self.there = {name for name, holds in there.items() if holds}
        unknowns = result.get("unknowns", [])
        warned = any(
            finding["code"] == "laws-missing" and finding["severity"] != "info" for finding in result["findings"]
        )
        found = [unknown["law"] for unknown in unknowns if unknown.get("law") and (unknown["status"] != "found" or warned)]
        laws = {law_of(law) for law in found}
        laws |= {"lag" for unknown in unknowns if unknown["kind"] == "timing"}
        laws |= {APPLIED[change["kind"]] for change in result.get("applied", []) if change["kind"] in APPLIED}
        for estimate in result["results"]:
            name, findings = estimate["estimator"], result["findings"] + estimate["warnings"]
            self.verdicts[name] = estimate["verdict"]
            self.codes[name] = {(finding["severity"], finding["code"]) for finding in findings}
            self.named[name] = laws.union(*map(claimed, findings))
            found = {parameter["name"]: parameter for parameter in estimate["parameters"]}
            self.rows[name] = [compared(key, found.get(key, {}), truth) for key in truth["parameters"]]

    def wrong(self, estimator):
        """Returns the effects named that are not there."""
        return self.named.get(estimator, set()) - self.there

    def verdict(self, estimator):
        return self.verdicts.get(estimator, "failed")

    def inside(self, estimator):
        """Returns the number of intervals that contain the truth, and that of all intervals."""
        known = [row.inside for row in self.rows.get(estimator, []) if row.inside is not None]
        return sum(known), len(known)


    def within(self, estimator, limits):
        """Returns whether held-out errors and coverage are within limits."""
        most, least = limits
        inside, number = self.inside(estimator)
        return self.over_promise.get(estimator, np.inf) <= most and inside >= least * number > 0


def law_of(rung):
    """Returns the effect that a law by hold-out names."""
    return rung["law"] or rung["of"]


def claimed(finding):
    """Returns the effects that a finding names."""
    if finding["severity"] == "info" and finding["code"] not in NAMES:
        return set()
    column = (finding.get("evidence") or {}).get("column") or "tau"
    effects = {CLAIMS[finding["code"]]} if finding["code"] in CLAIMS else set()
    if "lag" in effects and not column.startswith("tau"):
        effects = {"delay of a position"}
    if finding["code"] == "law-by-likelihood":
        effects |= set(re.findall(r'asks for \w+ "([\w-]+)"', finding["text"]))
    return effects


def compared(name, found, truth):
    """Compares a parameter with the truth."""
    kind, true, bound = name.rsplit(".", 1)[1], truth["parameters"][name], truth["bound"]
    value, ends = found.get("value"), found.get("ci95")
    error = None if value is None else abs(value / true - 1)
    if ends is None:
        return Row(kind, None, error, None)
    half = None if bound is None or found.get("one_sided") else (ends[1] - ends[0]) / 2
    return Row(kind, ends[0] <= true <= ends[1], error, half and half / QUANTILE / bound[name])


def settings_of(case, truth, args):
    """Returns the values of --set."""
    settings = [f"identify.estimator={json.dumps(ESTIMATORS[args.estimator])}", *args.set]
    if args.declared:
        joints = dict.fromkeys(name.split(".")[0] for name in truth["parameters"])
        settings += [f"robot.joint.{joint}.coulomb_sharpness_s_per_rad={case.sharpness}" for joint in joints]
        lags = ", ".join(f"tau{k} = {truth['lag_s']}" for k in range(1, len(joints) + 1))
        settings.append(f"log.delay_s={{{lags}}}")
    return settings


def identify(case, args):
    """Identifies the log of a case."""
    folder = folder_of(args.out, *case.robot) / case.log
    truth = json.loads((folder / "truth.json").read_text())
    command = [args.binary, "identify", folder, "--quiet", "--no-progress", "--threads", 1]
    command += [word for setting in settings_of(case, truth, args) for word in ("--set", setting)]
    with subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True) as process:
        text = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    case.seconds = used.ru_utime + used.ru_stime
    # Exit code 1: the verdict is unusable.
    if process.returncode in (0, 1):
        case.read(json.loads((folder / "sprung-out/identification.json").read_text()), truth)
        if args.held_out:
            validate(case, folder, args)
    else:
        case.fault = next(iter(text.splitlines()), f"exit code {process.returncode}")
    return case


def validate(case, folder, args):
    """Predicts the second log of a case."""
    command = [args.binary, "validate", folder, "--quiet", "--no-progress", "--threads", 1]
    subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
    run = json.loads((folder / "sprung-out/validation.json").read_text())["runs"][0]
    for parameter_set in run["sets"]:
        ratios = [
            value for joint in parameter_set["predictions"] for key, value in joint.items() if key.endswith("_ratio")
        ]
        name = next(name for name in case.verdicts if name in parameter_set["parameters"])
        case.over_promise[name] = max((np.inf if ratio is None else ratio for ratio in ratios), default=np.inf)


def share(values):
    """Returns the share of true values in percent."""
    values = [bool(value) for value in values]
    return 100 * np.mean(values) if values else np.nan


def coverage(rows):
    return share(row.inside for row in rows if row.inside is not None)


def median(values):
    values = [value for value in values if value is not None]
    return np.median(values) if values else np.nan


def groups_of(cases, estimator):
    """Returns the rows of each kind and log."""
    groups = {}
    for kind in DRIVE:
        for case in cases:
            rows = groups.setdefault((kind, case.log), [])
            rows += [row for row in case.rows.get(estimator, []) if row.kind == kind]
    return groups


def parameters(groups):
    """Prints the table of the parameters."""
    print(f"{'parameters':16}{'log':12}{'number':>7}{'none':>6}{'inside, %':>11}{'error, %':>10}{'width':>8}")
    for (kind, log), rows in groups.items():
        number = sum(row.inside is not None for row in rows)
        error, width = 100 * median(row.error for row in rows), median(row.width for row in rows)
        print(f"{kind:16}{log:12}{number:7}{len(rows) - number:6}{coverage(rows):11.1f}{error:10.3f}{width:8.2f}")


def verdicts(cases, estimator):
    """Prints verdicts, times and findings of each log."""
    logs = defaultdict(list)
    for case in cases:
        logs[case.log].append(case)
    heads = "".join(f"{verdict + ', %':>13}" for verdict in VERDICTS)
    print(f"\n{'log':12}{'number':>7}{heads}{'processor, s':>14}")
    for log, log_cases in logs.items():
        shares = (share(case.verdict(estimator) == verdict for case in log_cases) for verdict in VERDICTS)
        seconds = np.mean([case.seconds for case in log_cases])
        print(f"{log:12}{len(log_cases):7}" + "".join(f"{part:13.0f}" for part in shares) + f"{seconds:14.1f}")
    for log, log_cases in logs.items():
        found = [pair for case in log_cases for pair in case.codes.get(estimator, ())]
        print(f"\n{log}")
        for severity in SEVERITIES:
            print(f"    {severity:10}{counted(code for level, code in found if level == severity)}")
        print(f"    {'named':10}{counted(name for case in log_cases for name in case.named.get(estimator, ()))}")
        print(f"    {'not there':10}{counted(name for case in log_cases for name in case.wrong(estimator))}")


def counted(words):
    return ", ".join(f"{word} {count}" for word, count in Counter(words).most_common()) or "-"


def outcome(cases, estimator):
    """Prints what became of logs with an effect."""
    good = [case.verdict(estimator) == "good" for case in cases]
    hits = [case.inside(estimator) for case in cases]
    covered = [inside >= LEAST_COVERAGE * number for inside, number in hits]
    figures = [
        ("the effect is named", [case.effect in case.named.get(estimator, ()) for case in cases]),
        ("another effect is blamed", [case.wrong(estimator) for case in cases]),
        ("not good", [not is_good for is_good in good]),
        (f"coverage at least {100 * LEAST_COVERAGE:.0f} %, or not good", [b or not a for a, b in zip(good, covered)]),
    ]
    print()
    for text, values in figures:
        print(f"{text:50}{sum(map(bool, values)):5} of {len(values)}")


def wrong_verdicts(cases, estimator):
    """Prints how many verdicts held-out data and the truth refute."""
    good = [case for case in cases if case.verdict(estimator) == "good"]
    wrong = sum(not case.within(estimator, WRONG) for case in good)
    truly = [case for case in cases if case.within(estimator, TRULY_GOOD)]
    missed = sum(case.verdict(estimator) != "good" for case in truly)
    print(f"\ngood {len(good)} of {len(cases)}, of these wrong {wrong}; truly good {len(truly)}, of these not good {missed}")
    note("wrong", f"{len(good)} *good* verdicts: refuted by held-out data or the truth", wrong, "")
    note("missed", f"{len(truly)} truly good results: not called *good*", missed, "")


def requirements(cases, groups, estimator):
    """Prints a line for each requirement. Returns whether all are met; one without logs is."""
    rows = [row for group in groups.values() for row in group]

    def stiffness_error(rate):
        rate_rows = [row for case in cases if case.rate == rate for row in case.rows.get(estimator, [])]
        return 100 * median(row.error for row in rate_rows if row.kind == "stiffness")

    large = {place: group for place, group in groups.items() if len(group) >= SOME_INTERVALS}
    each = [(coverage(group), f" ({kind}, {log})") for (kind, log), group in large.items()]
    least, where = min(each, default=(np.nan, ""))
    figures = [
        ("coverage in the mean 90–98 %", coverage(rows), 90, 98 if len(rows) >= MANY_INTERVALS else 100),
        ("no kind × record × rate below 85 %" + where, least, 100 * LEAST_COVERAGE, 100),
        ("median interval at most 1.5 × Cramér-Rao", median(row.width for row in rows), 0, 1.5),
        ("median stiffness error ≤ 0.15 % at 1000 Hz", stiffness_error(1000), 0, 0.15),
        ("median stiffness error ≤ 0.3 % at 250 Hz", stiffness_error(250), 0, 0.3),
        ("good in at least 80 %", share(case.verdict(estimator) == "good" for case in cases), 80, 100),
        ("an effect named that is not there in at most 5 %", share(case.wrong(estimator) for case in cases), 0, 5),
    ]
    print()
    for text, value, low, high in figures:
        if not np.isnan(value):
            note(text.removesuffix(where), text, value, "times" if "×" in text else "%", better="none")
        word = "no logs" if np.isnan(value) else "passed" if low <= value <= high else "missed"
        print(f"{text:66}{value:8.3g}  {word}")
    return all(np.isnan(value) or low <= value <= high for _, value, low, high in figures)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of the logs")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    add_robots(parser)
    parser.add_argument("--records", type=names, default=list(RECORDS))
    parser.add_argument("--rates", type=lambda text: list(map(int, names(text))), default=list(RATES))
    parser.add_argument("--estimator", choices=ESTIMATORS, default=PREDICTION)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="passed to sprung")
    parser.add_argument("--declared", action="store_true", help="gives the true lag and sharpness to sprung")
    parser.add_argument("--held-out", action="store_true", help="counts wrong verdicts on the second log")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--strict", action="store_true", help="exit code 1 if a requirement is missed")
    args = parser.parse_args()
    cases = [Case(arm, seed, sharpness, effect, record, rate) for effect in args.effects for arm in args.arms
             for sharpness in args.sharpness for seed in args.seeds for record in args.records for rate in args.rates]
    for robot in dict.fromkeys(case.robot for case in cases):
        make(args.out, *robot)
    with ThreadPoolExecutor(args.jobs) as pool:
        for case in pool.map(lambda case: identify(case, args), cases):
            found = (f"{verdict} {'{}/{}'.format(*case.inside(name))}" for name, verdict in case.verdicts.items())
            robot = folder_of("", *case.robot).name
            print(f"{robot:24}{case.log:12}{case.seconds:7.1f} s  {', '.join(found) or case.fault}", flush=True)
    met = True
    for estimator in ESTIMATORS[args.estimator]:
        for effect in args.effects:
            effect_cases = [case for case in cases if case.effect == effect]
            groups = groups_of(effect_cases, estimator)
            print(f"\n{estimator}, effect: {effect}\n")
            parameters(groups)
            verdicts(effect_cases, estimator)
            if args.held_out:
                wrong_verdicts(effect_cases, estimator)
            if effect == "none":
                met &= requirements(effect_cases, groups, estimator)
            else:
                outcome(effect_cases, estimator)
    sys.exit(args.strict and not met)


if __name__ == "__main__":
    main()
