"""Identifies the logs of real machines, and notes verdicts and predicted errors of each.

    python run.py --data FOLDER [--binary SPRUNG]

FOLDER has the public logs that the pages of the examples name, one folder for each machine: `emps`, `quanser_2dsfl`,
`neura_lara8`, `staubli_tx40`, `franka_panda`. A machine without a log is left out, with its name.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benches"))

from figure import note  # noqa: E402

EXAMPLES = ROOT / "examples"
ESTIMATORS = ("least-squares", "prediction-error")
VERDICTS = ("unusable", "doubtful", "good")

# Experiment, log and other files of each machine, relative to the folder of the logs.
MACHINES = {
    "emps": (EXAMPLES / "emps", {"log.file": "emps/emps_estimation.csv"}),
    "staubli-tx40": (EXAMPLES / "staubli-tx40",
                     {"log.file": "staubli_tx40/staubli_tx40_1kHz.csv", "robot.urdf": "staubli_tx40/tx40.urdf"}),
    "quanser-2dsfl": (EXAMPLES / "quanser-2dsfl", {"log.file": "quanser_2dsfl/quanser_2dsfl_psf.csv"}),
    "neura-lara8": (EXAMPLES / "neura-lara8", {"log.file": "neura_lara8/orig/jogging_joint_mass.csv"}),
    "franka-panda": (Path("franka_panda/experiment.toml"), {}),
}

# Published values: parameter, value. The pages of the examples name the sources.
PUBLISHED = {"emps": {"link1.m + carriage.rotor_inertia": 95.1089}}


def identified(binary, data, machine, estimator):
    """Returns the first result, or None if sprung refuses the log."""
    experiment, files = MACHINES[machine]
    with tempfile.TemporaryDirectory() as out:
        command = [binary, "identify", data / experiment, "--quiet", "--out", out,
                   "--set", f'identify.estimator=["{estimator}"]']
        for key, file in files.items():
            command += ["--set", f"{key}={data / file}"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        if done.returncode not in (0, 1):
            print(done.stderr.strip(), file=sys.stderr)
            return None
        return json.loads((Path(out) / "identification.json").read_text())["results"][0]


def errors(result):
    """Returns the promised errors of the motor torques, in percent of their root mean squares."""
    promise = result["promise"] or []
    return [100 * joint["torque_error_nm"] / joint["torque_nm"] for joint in promise]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    args = parser.parse_args()
    data = args.data.resolve()
    failed = []
    for machine, (experiment, files) in MACHINES.items():
        absent = [name for name in [experiment, *files.values()] if not (data / name).exists()]
        if absent:
            print(f"SKIPPED {machine}: {', '.join(map(str, absent))} is absent in {data}")
            continue
        for estimator in ESTIMATORS:
            result = identified(args.binary.resolve(), data, machine, estimator)
            if result is None:
                failed.append(f"{machine}, {estimator}")
                continue
            percent = errors(result)
            case = f"{machine}, {estimator}"
            print(f"{case:32} {result['verdict']:10} torques {min(percent, default=0):.1f} to {max(percent, default=0):.1f} %")
            link = f"[{machine}](../../examples/{machine})" if experiment.is_absolute() else machine
            if percent:
                note(f"{machine}/{estimator}/torque", f"{link}, {estimator}, *{result['verdict']}*: largest predicted error "
                     "of a motor torque", max(percent), "%")
            # Compared with the last run; the table shows it beside the errors.
            note(f"{machine}/{estimator}/verdict", "", VERDICTS.index(result["verdict"]), "", better="higher")
            values = {parameter["name"]: parameter["value"] for parameter in result["parameters"]}
            for name, published in PUBLISHED.get(machine, {}).items():
                if values.get(name) is not None:
                    note(f"{machine}/{estimator}/{name}", f"{link}, {estimator}: distance of `{name}` from its published value",
                         100 * abs(values[name] / published - 1), "%")
    if failed:
        sys.exit(f"refused: {'; '.join(failed)}")


if __name__ == "__main__":
    main()
