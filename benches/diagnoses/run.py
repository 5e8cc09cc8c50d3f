"""Damages logs in 40 ways, and counts how often sprung names the damage first, with a line that corrects it.

    python run.py --out FOLDER [--binary SPRUNG] [--foreign FOLDER] [--logs NAME,...] [--kinds NAME,...]
                  [--seeds N,...] [--jobs N] [--verbose] [--strict]

The logs are the demo, examples/seven-joint-twin, and a UR5 that `benches/foreign/generate.py` simulates into the
folder --foreign. `demo-2`, whose file has no gear ratios, and `panda` take part if --logs names them. The seed draws
joint, size (half to double), sign and time of each damage.

A damage that moves no value by four standard errors needs no word. Otherwise it is named if the first finding above a
note has a code of its kind (KINDS) and names a damaged column or its joint. Without such a finding it is named if an
unknown of the right kind is applied to a damaged column. It is mended if least squares then find the drives of the
sound log within 10 %, or four standard errors; the line of the first finding, if there is one, is added before. A
finding without a line is right if it names the damage.

A user who adds every line that a check prints, one after the other, must not end with values that are farther from
those of the sound log. A result is falsely good if its verdict is good, before or after these lines, and a value is
more than four standard errors from that of the sound log. With --strict the exit code is 1 if less than 90 % of the
damages are right, a result is falsely good, or lines make it worse. Needs NumPy and SciPy.
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
from scipy.interpolate import CubicSpline

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "benches"))
from figure import note  # noqa: E402

LOGS = ["demo-1", "twin", "ur5"]
GEAR, SAME, ERRORS, LEAST_RIGHT = 101, 1.1, 4.0, 0.9
# Differences of distances below this are negligible.
MORE_DISTANCE = 0.02
# These parameters judge a remedy; links of the demo are combinations that depend on them.
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

    @property
    def time(self):
        return next(iter(self.columns.values()))

    def delay(self, names, seconds):
        for name in names:
            late = np.clip(self.time - seconds, self.time[0], None)
            self.columns[name] = CubicSpline(self.time, self.columns[name])(late)

    def add(self, name, values):
        self.columns[name] = self.columns[name] + values

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        table = np.column_stack(list(self.columns.values()))
        np.savetxt(folder / "log.csv", table, "%.9g", ",", header=",".join(self.columns), comments="")
        write_experiment(folder, self.experiment)


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


def sound(folder, name, gears):
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
    known = [joint.get("gear_ratio", GEAR) for joint in robot["joint"]]
    identify = {"estimator": ["least-squares"], "on_check_error": "go-on"}
    kept = {"format": 1, "robot": robot, "log": log, "identify": identify}
    return Log(kept, columns, *(names[quantity] for quantity in QUANTITIES[:3]), known)


def make(args, name):
    """Returns a sound log."""
    folder = args.out / "sound" / name
    if name.startswith("demo"):
        seed = int(name.split("-")[1])
        if not (folder / "experiment.toml").exists():
            run(args.binary, "demo", "--out", folder, "--seed", seed, "-q").check_returncode()
        # The file of the second demo has no gear ratios.
        return sound(folder, name, [GEAR] * 2 if seed == 1 else None)
    if name == "twin":
        if not (folder / "experiment.toml").exists():
            example = ROOT / "examples/seven-joint-twin"
            folder.mkdir(parents=True, exist_ok=True)
            for file in ("experiment.toml", "truth.toml"):
                (folder / file).write_text((example / file).read_text())
            run(args.binary, "simulate", folder / "experiment.toml", "-q").check_returncode()
        return sound(folder, name, [GEAR, GEAR, GEAR, 51, 51, 51, 51])
    return sound(args.foreign / f"{name}-s1-k100" / "mean-500", name, None)


@dataclass
class Outcome:
    """What sprung said of a damaged log, and what its lines did."""

    log: str
    kind: str
    first: str = ""
    named: bool = False
    right: bool = False
    worse: bool = False
    falsely_good: bool = False
    said: list = field(default_factory=list)


@dataclass
class Draw:
    """What a seed draws for a log."""

    log: Log
    rng: np.random.Generator

    def __post_init__(self):
        count = len(self.log.motors)
        self.joint = int(self.rng.integers(count))
        self.other = (self.joint + 1 + int(self.rng.integers(count - 1))) % count
        self.size = 2 ** self.rng.uniform(-1, 1)
        self.signed = self.size * self.rng.choice([-1, 1])
        time = self.log.time
        self.part = (time - time[0]) / (time[-1] - time[0])
        self.after = (self.part > self.rng.uniform(0.25, 0.75)).astype(float)

    def column(self, quantity, joint=None):
        """Returns the column of a quantity ("links", "motors", "torques") of the drawn joint."""
        return getattr(self.log, quantity)[self.joint if joint is None else joint]

    def rms(self, name):
        return np.std(self.log.columns[name])


def delayed(*of):
    """Returns a damage: columns are late. `of`: quantity, its joint ("joint", "other" or "all"), and s."""

    def damage(draw):
        names = []
        for quantity, joint, seconds in of:
            chosen = getattr(draw.log, quantity) if joint == "all" else [draw.column(quantity, getattr(draw, joint))]
            draw.log.delay(chosen, seconds * draw.size)
            names += chosen
        return names

    return damage


def changed(quantity, change):
    """Returns a damage of one column. `change`: gives its values from the draw and the values before."""

    def damage(draw):
        name = draw.column(quantity)
        draw.log.columns[name] = change(draw, draw.log.columns[name])
        return [name]

    return damage


def added(quantity, size, shape):
    """Returns a damage: something is added. `size`: rad, or a part of the torque's standard deviation."""

    def damage(draw):
        name = draw.column(quantity)
        scale = draw.rms(name) if quantity == "torques" else 1.0
        draw.log.add(name, size * scale * shape(draw, draw.log.columns[name]))
        return [name]

    return damage


def scaled(quantities, factor, every=False):
    """Returns a damage: columns have other units or signs. `factor`: of the joint's place."""

    def damage(draw):
        joints = range(len(draw.log.motors)) if every else [draw.joint]
        names = []
        for quantity in quantities:
            for joint in joints:
                name = draw.column(quantity, joint)
                draw.log.scale([name], factor(draw, joint))
                names.append(name)
        return names

    return damage


def exchanged(*quantities):
    """Returns a damage: columns of two joints are exchanged."""

    def damage(draw):
        names = []
        for quantity in quantities:
            pair = [draw.column(quantity), draw.column(quantity, draw.other)]
            draw.log.swap(*pair)
            names += pair
        return names

    return damage


def link_for_motor(draw):
    pair = [draw.column("links"), draw.column("motors")]
    draw.log.swap(*pair)
    return pair


def slow_clock(draw):
    name = next(iter(draw.log.columns))
    draw.log.columns[name] = draw.log.columns[name] / 1.25
    return [name]


def on_motor_side(draw):
    """Motor positions before the gearbox, declared as behind it; or the opposite, where the file says before."""
    if draw.log.log.pop("motor_position_side", None) is None:
        for name, gear in zip(draw.log.motors, draw.log.gears):
            draw.log.scale([name], gear)
    return draw.log.motors


def saturated(draw, values):
    limit = 0.7 * abs(values).max()
    return np.clip(values, -limit, limit)


def stuck(draw, values):
    first = int(np.argmax(draw.after))
    time = draw.log.time
    held = (time >= time[first]) & (time < time[first] + 0.4)
    return np.where(held, values[first], values)


def spike(draw, values):
    values = values.copy()
    values[len(values) // 3] += 0.05
    return values


def unit(draw, joint):
    return [100.0, 1000.0, 10.0, 0.01, 0.001, 0.1, 100.0][joint % 7]


DEGREES = 180 / np.pi
LATE = (("late-channel", "delayed-channel"), ("delay", "timing"))
# Damage, codes of findings that name it, or their beginnings, and kinds of unknowns that do if nothing is above a note.
KINDS = {
    "delay-link": (delayed(("links", "joint", 5e-3)), *LATE),
    "delay-motor": (delayed(("motors", "joint", 5e-3)), *LATE),
    "delay-torque": (delayed(("torques", "joint", 5e-3)), *LATE),
    "delay-all-torques": (delayed(("torques", "all", 3e-3)), *LATE),
    "delay-all-links": (delayed(("links", "all", 3e-3)), *LATE),
    "delay-two": (delayed(("links", "joint", 5e-3), ("torques", "other", 4e-3)), *LATE),
    "delay-three": (delayed(("links", "joint", 5e-3), ("torques", "joint", 3e-3), ("links", "other", 4e-3)), *LATE),
    "offset-link": (added("links", 2e-3, lambda d, v: d.signed), ("encoder-offset",), ("offset",)),
    "offset-torque": (added("torques", 0.1, lambda d, v: d.signed), (), ("offset", "law")),
    "gain-link": (changed("links", lambda d, v: v * (1 + 0.02 * d.signed)), ("channel-gain",), ("gain",)),
    "gain-motor": (changed("motors", lambda d, v: v * (1 + 0.02 * d.signed)), ("channel-gain",), ("gain",)),
    "gain-torque": (
        changed("torques", lambda d, v: v * (1 + 0.3 * d.signed)),
        ("channel-gain", "torque-scale"),
        ("gain",),
    ),
    "lost-link": (added("links", 5e-3, lambda d, v: d.signed * d.after), ("position-jumps",), ()),
    "lost-motor": (added("motors", 5e-3, lambda d, v: d.signed * d.after), ("position-jumps",), ()),
    "drift-link": (added("links", 5e-3, lambda d, v: d.signed * d.part), ("position-drifts",), ()),
    "drift-motor": (added("motors", 5e-3, lambda d, v: d.signed * d.part), ("position-drifts",), ()),
    "drift-torque": (added("torques", 0.2, lambda d, v: d.signed * d.part), ("position-drifts",), ("drift",)),
    "saturated": (changed("torques", saturated), ("torque-saturate",), ()),
    "eccentric-link": (added("links", 2e-3, lambda d, v: d.size * np.sin(v + 1)), ("eccentric-encoder",), ("offset",)),
    "eccentric-motor": (
        added("motors", 2e-3, lambda d, v: d.size * np.sin(v + 1)),
        ("eccentric-encoder",),
        ("offset",),
    ),
    "slow-clock": (slow_clock, ("time-scale",), ()),
    "sign-link": (scaled(["links"], lambda d, j: -1.0), ("opposite-signs",), ()),
    "sign-motor": (scaled(["motors"], lambda d, j: -1.0), ("opposite-signs",), ()),
    "sign-torque": (scaled(["torques"], lambda d, j: -1.0), ("reversed-torque",), ()),
    "sign-joint": (scaled(["links", "motors"], lambda d, j: -1.0), ("reversed-torque", "reversed-joint"), ()),
    "exchanged-torques": (exchanged("torques"), ("swapped-joints",), ()),
    "exchanged-links": (exchanged("links"), ("swapped-joints",), ()),
    "exchanged-motors": (exchanged("motors"), ("swapped-joints",), ()),
    "exchanged-joints": (exchanged("links", "motors", "torques"), ("swapped-joints",), ()),
    "link-for-motor": (link_for_motor, ("exchanged-columns",), ()),
    "unit-torque": (scaled(["torques"], unit), ("torque-scale",), ()),
    "degrees-link": (scaled(["links"], lambda d, j: DEGREES), ("units-disagree",), ()),
    "degrees-all": (scaled(["links", "motors"], lambda d, j: DEGREES, every=True), ("looks-like-degrees",), ()),
    "gear-motor": (on_motor_side, ("units-disagree", "motor-side-positions", "slope-not-one"), ()),
    "gear-torques": (scaled(["torques"], lambda d, j: 1 / d.log.gears[j], every=True), ("torque-scale",), ()),
    "stuck-link": (changed("links", stuck), ("stuck-samples", "frozen-samples"), ()),
    "hum": (added("torques", 0.05, lambda d, v: np.sin(100 * np.pi * d.log.time)), (), ()),
    "spike-link": (changed("links", spike), ("spikes",), ()),
    "noise-link": (added("links", 1e-4, lambda d, v: d.size * d.rng.standard_normal(len(v))), ("noisy-signal",), ()),
    "none": (lambda draw: [], (), ()),
}


def damaged(log, kind, seed):
    """Returns a log with a damage, and what says where it is: the damaged columns and their joints."""
    log = log.copy()
    rng = np.random.default_rng([seed, *kind.encode(), *log.experiment["robot"]["name"].encode()])
    draw = Draw(log, rng)
    names = list(dict.fromkeys(KINDS[kind][0](draw)))
    joints = [joint["name"] for joint in log.experiment["robot"]["joint"]]
    columns = zip(joints, log.links, log.motors, log.torques)
    return log, names + [joint for joint, *of in columns if set(of) & set(names)]


def with_line(experiment, setting):
    """Returns the experiment with a line of a finding, or None if the line cannot be written unchanged."""
    experiment = json.loads(json.dumps(experiment))
    table, line = re.match(r"(\[+[\w.]+\]+) (.*)", setting, re.DOTALL).groups()
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
    """Returns the verdict of least squares, and values with standard errors; None if they are refused."""
    done = run(args.binary, "identify", folder, "-q", "--no-progress", "--threads", 1)
    if done.returncode not in (0, 1):
        return None
    result = json.loads((folder / "sprung-out/identification.json").read_text())["results"][0]
    values = {
        parameter["name"]: (parameter["value"], parameter.get("standard_error") or 0.0)
        for parameter in result["parameters"]
        if parameter["value"] is not None
    }
    return result["verdict"], values


def distance(found, truth):
    """Returns the mean distance of the drives' logarithms; a value of another sign counts as far away."""
    if found is None:
        return np.inf
    logarithms = []
    for name, (true, _) in truth[1].items():
        if is_drive(name) and true:
            ratio = found[1].get(name, (0.0, 0.0))[0] / true
            logarithms.append(min(abs(np.log(ratio)), 7.0) if ratio > 0 else 7.0)
    return float(np.mean(logarithms))


def worst(found, truth, wanted=str, same=1.0):
    """Returns the largest error of a value in standard errors, after its name; errors below a factor do not count."""
    errors = [("", 0.0)]
    for name, (true, of_true) in truth[1].items():
        value, of_value = found[1].get(name, (0.0, 0.0))
        # The preload of a spring contains the zeros of the encoders.
        is_same = value * true > 0 and 1 / same < value / true < same
        if wanted(name) and not name.endswith("spring_preload") and not is_same:
            errors.append((name, abs(value - true) / max(np.hypot(of_value, of_true), 1e-9 * abs(true))))
    return max(errors, key=lambda error: error[1])


def is_drive(name):
    return name.endswith(DRIVE)


def is_near(found, truth):
    return found is not None and worst(found, truth, is_drive, SAME)[1] < ERRORS


def loud_of(report):
    """Returns the findings above a note."""
    return [finding for finding in report["findings"] if finding["severity"] != "info"]


def is_named(report, kind, places):
    """Returns the first finding above a note, and whether it, or an applied unknown, names the damage."""
    _, codes, unknowns = KINDS[kind]
    loud = loud_of(report)
    if loud:
        first = loud[0]
        said = " ".join(str(first.get(part)) for part in ("text", "remedy", "setting"))
        # A clock has no joint.
        is_place = kind == "slow-clock" or any(re.search(rf"\b{re.escape(place)}\b", said) for place in places)
        return first, first["code"].startswith(codes) and is_place
    used = [one for one in report["unknowns"] if one["status"] in ("applied", "estimated")]
    is_all = kind.startswith("delay-all")
    is_here = lambda one: is_all or any(place in one["id"] for place in places)  # noqa: E731
    return None, any(one["kind"] in unknowns and is_here(one) for one in used)


def judge(args, name, kind, seed, base, truth):
    """Checks a damaged log, follows the lines of its findings, and compares the values."""
    folder = args.out / "damaged" / f"{name}-{kind}-{seed}"
    log, places = damaged(base, kind, seed)
    log.write(folder)
    outcome = Outcome(name, kind)
    done = run(args.binary, "check", folder, "--json", "--threads", 1)
    try:
        report = json.loads(done.stdout)
    except json.JSONDecodeError:
        outcome.said.append(done.stderr.strip()[:300])
        return outcome
    first, outcome.named = is_named(report, kind, places)
    outcome.first = first["code"] if first else ""
    lines = {}
    for finding in loud_of(report):
        line = finding.get("setting")
        outcome.said.append(f"{finding['severity']} {finding['code']}: {finding['text'][:160]} | {line}")
        if line:
            lines[line] = True
    before, experiment = identified(args, folder), log.experiment
    steps = {"as it is": before}
    for line in lines:
        more = with_line(experiment, line)
        if more is None:
            outcome.said.append(f"    cannot be written: {line}")
            continue
        experiment = more
        write_experiment(folder, experiment)
        steps[line] = identified(args, folder)
    write_experiment(folder, log.experiment)
    for line, found in steps.items():
        if found is None:
            outcome.said.append(f"    {line[:60]}: refused")
            continue
        # Both positions of a joint in the other direction, with its torque, are another convention.
        parameter, errors = worst(found, truth, is_drive if kind == "sign-joint" else str)
        outcome.falsely_good |= bool(found[0] == "good" and errors > ERRORS)
        far = f"distance {distance(found, truth):.3f}, {parameter} {errors:.1f} errors off"
        outcome.said.append(f"    {line[:60]}: {found[0]}, {far}")
    if first and first.get("setting"):
        mended = is_near(steps.get(first["setting"]), truth)
    else:
        # A finding without a line is right if it names the damage.
        mended = first is not None or is_near(before, truth)
    is_harmless = first is None and before is not None and worst(before, truth)[1] < ERRORS
    outcome.right = outcome.named and mended or is_harmless
    last = list(steps.values())[-1]
    outcome.worse = last is not None and bool(distance(last, truth) > distance(before, truth) + MORE_DISTANCE)
    return outcome


def words(text):
    return [word.strip() for word in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of the logs")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    parser.add_argument("--foreign", type=Path, default=Path("/tmp/foreign"), help="folder of the foreign logs")
    parser.add_argument("--logs", type=words, default=LOGS)
    parser.add_argument("--kinds", type=words, default=list(KINDS))
    parser.add_argument("--seeds", type=words, default=["1"])
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="prints the findings")
    parser.add_argument("--strict", action="store_true", help="exit code 1 if a requirement is missed")
    args = parser.parse_args()
    tasks = []
    for name in args.logs:
        base = make(args, name)
        folder = args.out / "damaged" / f"{name}-sound"
        base.write(folder)
        truth = identified(args, folder)
        # Without gravity no log tells the scale of its time.
        kinds = [kind for kind in args.kinds if kind != "slow-clock" or "urdf" in base.experiment["robot"]]
        tasks += [(name, kind, int(seed), base, truth) for seed in args.seeds for kind in kinds]
    outcomes = []
    with ThreadPoolExecutor(args.jobs) as pool:
        for outcome in pool.map(lambda task: judge(args, *task), tasks):
            outcomes.append(outcome)
            faults = ["worse"] * outcome.worse + ["FALSELY GOOD"] * outcome.falsely_good
            word = "right" if outcome.right else "named, not mended" if outcome.named else "WRONG"
            print(f"{outcome.log:8}{outcome.kind:18}{', '.join([word, *faults])}  {outcome.first}", flush=True)
            if args.verbose or not outcome.right or faults:
                print("\n".join("      " + line for line in outcome.said), flush=True)
    print(f"\n{'kind':18}{'logs':>6}{'right':>7}{'worse':>7}{'falsely good':>14}")
    count = lambda group, what: sum(getattr(one, what) for one in group)  # noqa: E731
    for kind in [*args.kinds, "all"]:
        group = [one for one in outcomes if kind in (one.kind, "all")]
        if not group:
            continue
        right, worse, false = (count(group, what) for what in ("right", "worse", "falsely_good"))
        print(f"{kind:18}{len(group):6}{right:7}{worse:7}{false:14}")
        text = kind.replace("-", " ")
        note(kind, f"{text}, {len(group)} logs: right", right, "", better="higher")
        note(f"{kind}, worse", f"{text}: lines make it worse", worse, "")
        note(f"{kind}, falsely good", f"{text}: *good*, and a value is more than four standard errors off", false, "")
    all_right = count(outcomes, "right") >= LEAST_RIGHT * len(outcomes)
    sys.exit(args.strict and not (all_right and count(outcomes, "worse") + count(outcomes, "falsely_good") == 0))


if __name__ == "__main__":
    main()
