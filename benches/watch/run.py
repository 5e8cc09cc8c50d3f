"""A watched robot: contacts, wear and healthy hours of digital twins with two and seven joints.

python benches/watch/run.py --binary target/release/sprung --out FOLDER [--seeds 3] [--minutes 10] [--robots two seven]

For each seed and robot the healthy log is identified by least squares. Then sprung watches

- healthy motion for some minutes: false alarms, beside the promised ones at 1, 0.1 and 0.01 per second and one per hour,
- contacts of a tenth of the largest motor torque of a joint, by chance: how many are seen, on which joint, after which time,
- a stiffness that is 5 % lower and friction of a motor that is 10 % larger, of a joint by chance: what is named.
"""

import argparse
import json
import random
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 30.0
LEAST_SQUARES = 'identify.estimator=["least-squares"]'


def sprung(binary, *words):
    done = subprocess.run([binary, *map(str, words)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(done.stderr)
    return done


def settings(of):
    return [word for key, value in of.items() for word in ("--set", f"{key}={json.dumps(value)}")]


class Robot:
    """A twin with its identification."""

    def __init__(self, binary, source, folder, seed):
        self.binary, self.folder = binary, folder
        folder.mkdir(parents=True, exist_ok=True)
        for file in ("experiment.toml", "truth.toml"):
            (folder / file).write_text((source / file).read_text())
        self.truth = tomllib.loads((folder / "truth.toml").read_text())
        self.joints = [joint["name"] for joint in self.experiment()["robot"]["joint"]]
        self.log = self.simulate("healthy", seed, SECONDS)
        sprung(binary, "identify", folder, "-q", "--set", LEAST_SQUARES, *self.own())

    def experiment(self):
        return tomllib.loads((self.folder / "experiment.toml").read_text())

    def own(self):
        return settings({"log.file": "healthy.csv"})

    def simulate(self, name, seed, seconds, more=None, truth=None):
        values = {"log.file": f"{name}.csv", "simulate.seed": seed, "simulate.duration_s": seconds}
        if truth is not None:
            lines = (f'"{key}" = {value!r}' for key, value in truth.items())
            (self.folder / "worn.toml").write_text("\n".join(lines))
            values["simulate.parameters"] = "worn.toml"
        log = self.folder / f"{name}.csv"
        log.unlink(missing_ok=True)
        words = settings(values | (more or {}))
        sprung(self.binary, "simulate", self.folder, "-q", "--out", self.folder, *words)
        return log

    def watch(self, log, per_hour=1.0):
        words = ["--log", log, "--false-alarms-per-h", per_hour, "-q", "--set", LEAST_SQUARES]
        sprung(self.binary, "watch", self.folder, "--accept-unusable", *words, *self.own())
        return json.loads((self.folder / "sprung-out" / "watch.json").read_text())

    def largest_torques(self):
        """Largest motor torques of the healthy log."""
        names = self.experiment()["log"]["motor_torque_nm"]
        lines = self.log.read_text().splitlines()
        header = lines[0].split(",")
        places = [header.index(name) for name in names]
        rows = [line.split(",") for line in lines[1:]]
        return [max(abs(float(row[at])) for row in rows) for at in places]


def healthy(robot, seed, minutes):
    log = robot.simulate("quiet", 1000 + seed, 60.0 * minutes)
    rates = {}
    for rate in (1.0, 0.1, 0.01, 1.0 / 3600.0):
        watch = robot.watch(log, 3600.0 * rate)
        contacts = sum("torque_nm" in event for event in watch["events"])
        rates[rate] = (contacts, 60.0 * minutes * rate)
        others = [event["finding"]["code"] for event in watch["events"] if "torque_nm" not in event]
    log.unlink()
    return rates, others


def contacts(robot, seed):
    chance = random.Random(seed)
    largest = robot.largest_torques()
    found = []
    for joint, most in enumerate(largest):
        times = [[begin, begin + 0.3] for begin in (5.0 + chance.random(), 12.0 + chance.random(), 20.0 + chance.random())]
        torque = [0.0] * len(largest)
        torque[joint] = chance.choice((-0.1, 0.1)) * most
        more = {"simulate.contact_torque_nm": torque, "simulate.contact_s": times}
        watch = robot.watch(robot.simulate("touched", 2000 + 10 * seed + joint, SECONDS, more))
        for begin, _ in times:
            after = [
                (event["begins_s"] - begin, event["joint"])
                for event in watch["events"]
                if "torque_nm" in event and -0.01 < event["begins_s"] - begin < 0.3
            ]
            found.append((min(after) if after else None, robot.joints[joint], robot.joints[joint] in [of for _, of in after]))
    return found


def wear(robot, seed):
    chance = random.Random(seed)
    results = []
    for kind, code in (("stiffness", "stiffness-changed"), ("motor", "friction-changed")):
        joint = chance.choice(robot.joints)
        truth = dict(robot.truth)
        for key in truth:
            if kind == "stiffness" and key == f"{joint}.stiffness":
                truth[key] *= 0.95
            if kind == "motor" and key in (f"{joint}.motor_viscous", f"{joint}.motor_coulomb"):
                truth[key] *= 1.1
        watch = robot.watch(robot.simulate("worn", 3000 + seed, SECONDS, truth=truth))
        events = [(e["finding"]["code"], e.get("joint"), round(e["begins_s"], 1)) for e in watch["events"]]
        named = any(of == code and where in (joint, None) and begin < 16.5 for of, where, begin in events)
        results.append((kind, joint, named, [event for event in events if event[0] != code or event[1] not in (joint, None)]))
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--robots", nargs="+", default=["two", "seven"])
    given = parser.parse_args()
    demo = given.out / "demo"
    if not demo.exists():
        sprung(given.binary, "demo", "--out", demo, "-q")
    sources = {"two": demo, "seven": ROOT / "examples" / "seven-joint-twin"}
    for name in given.robots:
        alarms, seen, worn = {}, [], []
        for seed in range(given.seeds):
            robot = Robot(given.binary, sources[name], given.out / f"{name}-{seed}", 100 + seed)
            rates, others = healthy(robot, seed, given.minutes)
            for rate, (count, promised) in rates.items():
                before = alarms.get(rate, (0, 0.0))
                alarms[rate] = (before[0] + count, before[1] + promised)
            seen += contacts(robot, seed)
            worn += wear(robot, seed)
            print(f"{name} {seed}: {rates}, other events in healthy motion: {others}", flush=True)
        print(f"{name}: false alarms, promised ones:", {f"{rate:.4f}/s": of for rate, of in alarms.items()})
        times = sorted(after[0] for after, *_ in seen if after)
        prompt = sum(time <= 0.05 for time in times)
        right = sum(hit for *_, hit in seen)
        print(f"{name}: {len(times)} of {len(seen)} contacts seen, {prompt} within 50 ms, {right} on the right joint")
        for kind, joint, named, others in worn:
            print(f"{name}: {kind} of {joint}: {'named' if named else 'not named'}, beside it {others}")


if __name__ == "__main__":
    main()
