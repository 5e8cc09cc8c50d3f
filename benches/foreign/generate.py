"""Logs of flexible-joint arms as other people's recorders write them. Nothing of sprung is used.

    python generate.py FOLDER [--arms ur5,panda] [--seeds 1-3] [--sharpness 50,100,200] [--effects none]

`simulate.py` simulates two motions of each robot, of 20 s: springs, rotors and friction on both sides, and a controller at
1 kHz that holds its torque between samples. All recorders write both motions:

    FOLDER/ARM-sSEED-kSHARPNESS[-EFFECT]/RECORD-RATE/{train.csv,test.csv,experiment.toml,truth.json}

- held: the torque that the controller commands at the sample; it acts for the next period of the controller
- mean: the mean of this torque and the one before
- late: the torque before
- 1000, 500, 250: the log has each, each second or each fourth sample; the torques between them are lost

Link encoders have 2^18 counts per turn, motor encoders 2^16 per turn of the motor. The noise of the torques is 2 % of the
nominal `motor_coulomb`. The experiment file declares what a user knows: the URDF, columns, counts and gear ratios. It
declares no delay and no sharpness of Coulomb friction, so sprung assumes 100 s/rad also where the robot has 50 or 200. An
effect is in the robot and not in the file:

- ripple: torque ripple of the motor, 6 % of its Coulomb friction, six per motor turn
- load: friction that grows with the torque of the spring, 4 % of it
- error: transmission error of the gear, 3e-5 rad, two per motor turn
- heat: viscous friction of the motor that falls by 15 % during the log; the truth is the value at its start

truth.json contains the parameters by their names in sprung, their Cramér-Rao standard errors at this rate (`bound.py`; null
with an effect), the sharpness, and the lag of the torque, which is the correct `delay_s`. sprung holds a logged torque for
a period T of the log, which delays it by T/2. The torque of the controller is delayed by 0.5 ms. Logged torques
therefore lag by T/2 − 0.5 ms (held), T/2 (mean) and T/2 + 0.5 ms (late).

Needs numpy==2.4.6, numba==0.68.1, pin==4.1.0 and example-robot-data==6.0.0. Existing logs are kept.
"""

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True

import numpy as np  # noqa: E402
from bound import standard_errors  # noqa: E402
from simulate import ARMS, DRIVE, PERIOD_S, Robot, states_of  # noqa: E402

SAMPLES = 20000
LINK_COUNTS, MOTOR_COUNTS, TORQUE_NOISE = 2**18, 2**16, 0.02
# Lag of each record beyond half a period of the log, s.
RECORDS = {"held": -0.5e-3, "mean": 0.0, "late": 0.5e-3}
RATES = (1000, 500, 250)
# What is added to the seed, and the amplitude, rad.
MOTIONS = {"train": (0, 0.45), "test": (100000, 0.40)}
EFFECTS = {"ripple": 0.06, "load": 0.04, "error": 3e-5, "heat": 0.15}


def folder_of(out, arm, seed, sharpness, effect):
    return Path(out) / (f"{arm}-s{seed}-k{sharpness:g}" + ("" if effect == "none" else f"-{effect}"))


def lag_of(record, rate):
    """Returns the lag of a logged torque against one that is held for a period of the log, s."""
    return 0.5 / rate + RECORDS[record]


def noise_of(robot):
    """Returns the standard deviations of the logged torques, N·m."""
    return TORQUE_NOISE * np.array(robot.of["motor_coulomb"])


def lines_of(robot, states, torques, seed):
    """Returns the lines of each record at 1 kHz."""
    n = robot.n
    old = np.vstack([torques[:1], torques[:-1]])
    noise = np.random.default_rng(seed + 7).normal(size=torques.shape) * noise_of(robot)
    turns = states[:, :2 * n] / (2 * np.pi) * np.repeat([LINK_COUNTS, MOTOR_COUNTS * robot.of["gear"]], n)
    counts = [",".join(map(str, row)) for row in np.round(turns).astype(int).tolist()]
    form = ",".join(["%.9g"] * n)
    for record, values in {"held": torques, "mean": (torques + old) / 2, "late": old}.items():
        rows = zip(counts, (values + noise).tolist())
        yield record, [f"{k * PERIOD_S:.9g},{readings},{form % tuple(row)}\n" for k, (readings, row) in enumerate(rows)]


def experiment(robot):
    text = f'format = 1\n[robot]\nname = "{robot.arm} {robot.seed}"\nurdf = "{robot.urdf}"\n'
    for name in robot.joints:
        text += f'[[robot.joint]]\nname = "{name}"\ntransmission = "flexible"\ngear_ratio = {robot.of["gear"]}\n'
    columns = lambda stem: json.dumps([f"{stem}{k}" for k in range(1, robot.n + 1)])
    encoder = lambda stem, counts: f'column = {columns(stem)}, unit = "counts", counts_per_turn = {counts}'
    return text + "\n".join([
        "[log]", 'file = "train.csv"', 'time_s = "t"',
        f'link_position = {{ {encoder("q", LINK_COUNTS)} }}',
        f'motor_position = {{ {encoder("phi", MOTOR_COUNTS)}, side = "motor" }}',
        f'motor_torque_nm = {columns("tau")}', "[[validate]]", 'name = "test"', 'log = { file = "test.csv" }', ""])


def bounds(robot, states, torques):
    """Returns the Cramér-Rao standard errors of the train log at each rate."""
    counts = np.repeat([LINK_COUNTS, MOTOR_COUNTS * robot.of["gear"]], robot.n)
    variances = (2 * np.pi / counts) ** 2 / 12
    return standard_errors(robot, states, torques, variances, noise_of(robot), [1000 // rate for rate in RATES])


def make(out, arm, seed, sharpness, effect="none"):
    """Writes all records of a robot. Returns the seconds that it took; `None` if the logs exist."""
    begin, final = time.perf_counter(), folder_of(out, arm, seed, sharpness, effect)
    if final.exists():
        return None
    robot = Robot(arm, seed, sharpness)
    effects = np.array([size * (name == effect) for name, size in EFFECTS.items()])
    folder = final.with_name(final.name + ".part")
    shutil.rmtree(folder, ignore_errors=True)
    columns = [f"{stem}{k}" for stem in ("q", "phi", "tau") for k in range(1, robot.n + 1)]
    header = ",".join(["t", *columns]) + "\n"
    found = [None] * len(RATES)
    for name, (more, amplitude) in MOTIONS.items():
        states, torques = states_of(robot, effects, seed + more, amplitude, SAMPLES)
        if name == "train" and effect == "none":
            found = bounds(robot, states, torques)
        for record, lines in lines_of(robot, states, torques, seed + more):
            for rate in RATES:
                log_folder = folder / f"{record}-{rate}"
                log_folder.mkdir(parents=True, exist_ok=True)
                (log_folder / f"{name}.csv").write_text(header + "".join(lines[::1000 // rate]))
    values = {f"{joint}.{key}": float(robot.drive[key][k]) for key in DRIVE for k, joint in enumerate(robot.joints)}
    for record in RECORDS:
        for rate, bound in zip(RATES, found):
            log_folder = folder / f"{record}-{rate}"
            (log_folder / "experiment.toml").write_text(experiment(robot))
            truth = {"parameters": values, "bound": bound, "sharpness": sharpness, "lag_s": lag_of(record, rate)}
            (log_folder / "truth.json").write_text(json.dumps(truth, indent=1))
    folder.rename(final)
    return time.perf_counter() - begin


def numbers(text):
    """Returns the numbers of `1-3,7`."""
    ends = [part.split("-") for part in text.split(",")]
    return [k for interval in ends for k in range(int(interval[0]), int(interval[-1]) + 1)]


def names(text):
    return text.split(",")


def add_robots(parser):
    parser.add_argument("--arms", type=names, default=list(ARMS))
    parser.add_argument("--seeds", type=numbers, default=[1, 2, 3], help="such as 1-3")
    parser.add_argument("--sharpness", type=numbers, default=[50, 100, 200], help="true sharpness, s/rad")
    parser.add_argument("--effects", type=names, default=["none"], help="none, " + ", ".join(EFFECTS))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    add_robots(parser)
    args = parser.parse_args()
    for arm in args.arms:
        for seed in args.seeds:
            for sharpness in args.sharpness:
                for effect in args.effects:
                    seconds = make(args.folder, arm, seed, sharpness, effect)
                    name = folder_of(args.folder, arm, seed, sharpness, effect).name
                    print(f"{name:24}" + ("kept" if seconds is None else f"{seconds:.1f} s"), flush=True)


if __name__ == "__main__":
    main()
