"""A watched arm of an independent simulator (`benches/foreign`), also with effects that the model lacks.

python benches/watch/misfits.py --binary target/release/sprung --out FOLDER [--arms ur5,panda] [--seeds 1-2]
    [--effects none,ripple,load,error,hysteresis]

Each robot is identified by least squares from its log `train` with default settings. Then sprung watches logs that the fit has not
seen: healthy motion for a minute; contacts of a tenth of the largest motor torque on each joint; and a stiffness that is 5 % lower,
friction of a motor that is 10 % larger and a play of 0.3 mrad, each of a joint by chance.

Needs what `benches/foreign` needs.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "foreign"))

import numpy as np  # noqa: E402
from generate import EFFECTS, experiment, lines_of, names, numbers  # noqa: E402
from simulate import ARMS, PERIOD_S, Robot, states_of  # noqa: E402

LEAST_SQUARES = ["--set", 'identify.estimator=["least-squares"]', "-q"]
HEALTHY_S, LOG_S, CONTACT_S = 60.0, 30.0, 0.3
SLIDING = 0.1  # of the stiffness
RATES = {1.0: "1/s", 0.1: "0.1/s", 1.0 / 3600.0: "1/h"}
CODES = {"stiffness": "stiffness-changed", "friction": "friction-changed", "play": "play-changed"}


class Watched:
    def __init__(self, given, arm, effect, seed):
        self.binary, self.effect, self.seed = given.binary, effect, seed
        self.robot = Robot(arm, seed, 100.0)
        self.effects = np.array([size * (name == effect) for name, size in EFFECTS.items()])
        self.robot.sliding[:] = SLIDING * (effect == "hysteresis")
        self.folder = given.out / f"{arm}-{effect}-{seed}"
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "experiment.toml").write_text(experiment(self.robot).split("[[validate]]")[0])
        torques = self.log("train", 0, 20.0, 0.45)
        self.largest = np.abs(torques).max(0)
        self.run("identify", self.folder)

    def run(self, *words):
        done = subprocess.run([self.binary, *map(str, words), *LEAST_SQUARES], capture_output=True, text=True)
        if done.returncode not in (0, 1, 3):
            raise SystemExit(done.stderr)

    def log(self, name, more, seconds, amplitude=0.4, outside=None):
        seed = self.seed + more
        states, torques = states_of(self.robot, self.effects, seed, amplitude, round(seconds / PERIOD_S), outside=outside)
        columns = [f"{stem}{k}" for stem in ("q", "phi", "tau") for k in range(1, self.robot.n + 1)]
        lines = dict(lines_of(self.robot, states, torques, seed))["held"]
        (self.folder / f"{name}.csv").write_text(",".join(["t", *columns]) + "\n" + "".join(lines))
        return torques

    def watch(self, name, rate=1.0 / 3600.0):
        log = self.folder / f"{name}.csv"
        self.run("watch", self.folder, "--accept-unusable", "--log", log, "--false-alarms-per-h", 3600.0 * rate)
        return json.loads((self.folder / "sprung-out" / "watch.json").read_text())["events"]

    def verdict(self):
        return json.loads((self.folder / "sprung-out" / "identification.json").read_text())["results"][0]["verdict"]

    def healthy(self):
        self.log("healthy", 100000, HEALTHY_S)
        counts = {}
        for rate, name in RATES.items():
            events = self.watch("healthy", rate)
            counts[name] = sum("torque_nm" in event for event in events)
            others = [(event["finding"]["code"], event.get("joint")) for event in events if "torque_nm" not in event]
        return counts, others

    def contacts(self):
        random = np.random.default_rng(self.seed)
        samples, hits = round(LOG_S / PERIOD_S), []
        for joint in range(self.robot.n):
            begins = np.array([5.0, 12.0, 20.0]) + random.random(3)
            outside = np.zeros((samples, self.robot.n))
            for begin in begins:
                part = slice(round(begin / PERIOD_S), round((begin + CONTACT_S) / PERIOD_S))
                outside[part, joint] = random.choice([-0.1, 0.1]) * self.largest[joint]
            self.log("touched", 200000 + joint, LOG_S, outside=outside)
            events = [event for event in self.watch("touched") if "torque_nm" in event]
            for begin in begins:
                near = [e for e in events if -0.01 < e["begins_s"] - begin < CONTACT_S]
                first = min((e["begins_s"] - begin for e in near), default=None)
                hits.append((joint, first, any(e["joint"] == self.robot.joints[joint] for e in near)))
        return hits

    def wear(self):
        random, results = np.random.default_rng(self.seed + 77), []
        for kind, code in CODES.items():
            joint, drive = int(random.integers(self.robot.n)), {key: of.copy() for key, of in self.robot.drive.items()}
            if kind == "stiffness":
                self.robot.drive["stiffness"][joint] *= 0.95
            elif kind == "friction":
                self.robot.drive["motor_viscous"][joint] *= 1.1
                self.robot.drive["motor_coulomb"][joint] *= 1.1
            else:
                self.robot.play[joint] = 3e-4
            self.log("worn", 300000, LOG_S)
            self.robot.drive, self.robot.play = drive, np.zeros(self.robot.n)
            name = self.robot.joints[joint]
            events = [(e["finding"]["code"], e.get("joint")) for e in self.watch("worn")]
            others = sorted({event for event in events if event != (code, name)})
            results.append((kind, name, (code, name) in events, others))
        return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--arms", type=names, default=list(ARMS))
    parser.add_argument("--seeds", type=numbers, default=[1, 2])
    parser.add_argument("--effects", type=names, default=["none", "ripple", "load", "error", "hysteresis"])
    given = parser.parse_args()
    for arm in given.arms:
        for effect in given.effects:
            for seed in given.seeds:
                watched = Watched(given, arm, effect, seed)
                counts, others = watched.healthy()
                print(f"{arm} {effect} {seed}: {watched.verdict()}; false alarms of {HEALTHY_S:.0f} s {counts}, beside them {others}", flush=True)
                hits = watched.contacts()
                prompt = sum(first is not None and first <= 0.05 for _, first, _ in hits)
                right = sum(right for *_, right in hits)
                late = [joint + 1 for joint, first, _ in hits if first is None or first > 0.05]
                print(f"  contacts: {len(hits)}, {prompt} within 50 ms, {right} on the right joint; later or not: joints {late}", flush=True)
                for kind, joint, named, events in watched.wear():
                    print(f"  {kind} of {joint}: {'named' if named else 'NOT named'}, beside it {events}", flush=True)


if __name__ == "__main__":
    main()
