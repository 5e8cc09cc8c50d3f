"""Drift of one robot on the digital twin: ten runs in which the stiffness of joint 1 falls by 5 %, and ten without drift.

python benches/drift/run.py --binary target/release/sprung --out FOLDER [--sets 10] [--first 100] prints how often
`sprung compare` finds the drift, and the false alarms. Every run has its own seed, so sets are independent.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from figure import note  # noqa: E402

RUNS = 10
FALL = 0.05
DRIFTING = "joint1.stiffness"
STIFFNESS = 9.358730


def sprung(binary, *words):
    done = subprocess.run([binary, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr)


def identified(binary, demo, folder, fall, first_seed):
    """Identifies the runs of a set; returns their folders."""
    folders = []
    for k in range(RUNS):
        run = folder / f"run-{k}"
        run.mkdir(parents=True, exist_ok=True)
        truth = (demo / "truth.toml").read_text()
        stiffness = STIFFNESS * (1.0 - fall * k / (RUNS - 1))
        assert str(STIFFNESS) in truth
        (run / "truth.toml").write_text(truth.replace(str(STIFFNESS), f"{stiffness:.6f}"))
        (run / "experiment.toml").write_text((demo / "experiment.toml").read_text())
        sprung(binary, "simulate", run, "--set", f"simulate.seed={first_seed + k}", "--out", run / "twin", "-q")
        (run / "twin" / "identification.csv").rename(run / "identification.csv")
        least_squares = ["--set", "identify.estimator=least-squares"]
        sprung(binary, "identify", run, *least_squares, "--out", run / "sprung-out", "-q")
        folders.append(run)
    return folders


def drifting(binary, folders, out):
    """Returns the parameters that drift by a comparison, and the number of parameters that it tested."""
    sprung(binary, "compare", "--out", out, *folders)
    found = json.loads((out / "comparison.json").read_text())
    named = [
        name
        for finding in found["findings"]
        if finding["code"] == "parameter-drifts"
        for name in finding["parameters"]
    ]
    return named, len(found["drift"][0]["parameters"])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--sets", type=int, default=10)
    parser.add_argument("--first", type=int, default=100, help="seed of the first run")
    wanted = parser.parse_args()
    demo = wanted.out / "demo"
    sprung(wanted.binary, "demo", "--out", demo, "-q")
    found = alarms = tests = 0
    for number in range(wanted.sets):
        for fall in (FALL, 0.0):
            seed = wanted.first + RUNS * (2 * number + (fall > 0))
            folder = wanted.out / f"set-{number}-{'falls' if fall else 'stays'}"
            folders = identified(wanted.binary, demo, folder, fall, seed)
            named, count = drifting(wanted.binary, folders, folder / "compared")
            found += fall > 0 and DRIFTING in named
            wrong = [name for name in named if not (fall and name == DRIFTING)]
            alarms += len(wrong)
            tests += count - (fall > 0)
            print(f"set {number} {'falls' if fall else 'stays'}: {', '.join(named) or '-'}", flush=True)
    print(f"drift found in {found} of {wanted.sets} sets; {alarms} false alarms in {tests} tests")
    note("found", f"a fall of 5 % found in {wanted.sets} sets of ten logs", found, "", better="higher")
    note("alarms", f"false alarms in {tests} tests without drift", alarms, "")


if __name__ == "__main__":
    main()
