"""Identifies the examples of real machines with other settings, and notes values for the pages of the examples.

    python run.py --data FOLDER [--binary SPRUNG]

FOLDER has the public logs that the pages name, one folder for each machine. A machine without logs is left out, with
its name.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benches"))

from figure import note  # noqa: E402

DECLARED = {"identify.laws": "declared"}
REFINED = DECLARED | {"identify.estimator": ["prediction-error"]}


@dataclass
class Machine:
    """An example, its files below the folder of the logs, and its published values with their words."""

    files: dict
    published: dict
    # For each case: its words, its settings, and the parameters to note.
    cases: dict
    # Names and files of other logs that `sprung validate` predicts.
    others: tuple = ()


def varied(kind, keys, unit, values, chosen):
    """Returns a case for each value of a setting, or of a setting of each joint."""
    return {f"varied {kind} {value}": (f"{kind} {value} {unit}", DECLARED | dict.fromkeys(keys, value), chosen)
            for value in values}


def sharpness(*joints):
    """Returns the keys of β in the friction law tanh(β v)."""
    return [f"robot.joint.{joint}.coulomb_sharpness_s_per_rad" for joint in joints]


CUT_OFF, FILTER = ["identify.position_cutoff_hz"], ["identify.filter_cutoff_rad_per_s"]
MASS, VISCOUS = "link1.m + carriage.rotor_inertia", "carriage.motor_viscous"
EMPS = {
    MASS: ("mass of carriage and rotor", 95.1089),
    VISCOUS: ("viscous friction", 203.5034),
    "carriage.motor_coulomb": ("Coulomb friction", 20.3935),
    "carriage.motor_offset": ("offset of the force", -3.1648),
}
PULSES = {"log.file": "emps/emps_validation_pulses.csv"}
TX40 = {
    **{f"joint_{i}.motor_viscous": (f"viscous friction of motor {i}", value)
       for i, value in enumerate((8.05, 5.53, 1.97, 1.11, 1.244, 0.616), 1)},
    **{f"joint_{i}.motor_coulomb": (f"Coulomb friction of motor {i}", value)
       for i, value in enumerate((7.14, 8.26, 6.34, 2.48, 3.03, 1.95), 1)},
    **{f"joint_{i}.rotor_inertia": (f"rotor inertia of joint {i}", value)
       for i, value in enumerate((0.0988, 0.0313, 0.0468, 0.0105), 3)},
}
TX40_VISCOUS = ["joint_1.motor_viscous", "joint_2.motor_viscous"]
STIFFNESS = ["stage1.stiffness"]
DELAYS = ("log.delay_s.defl1", "log.delay_s.defl2")
LARA8 = ["joint2.stiffness"]

MACHINES = {
    "emps": Machine(
        {"log.file": "emps/emps_estimation.csv"}, EMPS,
        {
            "declared": ("", DECLARED, list(EMPS)),
            "pulses": ("", DECLARED | PULSES, list(EMPS)),
            "refined": ("", REFINED, list(EMPS)),
            **varied("β =", sharpness("carriage"), "s/m", (100, 300, 1000, 5000, 20000), [VISCOUS]),
            **varied("cut-off", CUT_OFF, "Hz", (20, 40, 200), [VISCOUS]),
            **varied("λ =", FILTER, "rad/s", (30, 300), [VISCOUS]),
            "varied weights": ("no weights", DECLARED | {"identify.weights": "none"}, [VISCOUS]),
        },
        (("pulses", "emps/emps_validation_pulses.csv"),),
    ),
    "staubli-tx40": Machine(
        {"log.file": "staubli_tx40/staubli_tx40_1kHz.csv", "robot.urdf": "staubli_tx40/tx40.urdf"}, TX40,
        {
            "declared": ("", DECLARED, list(TX40)),
            **varied("β =", sharpness(*(f"joint_{i}" for i in range(1, 7))), "s/rad", (20, 500, 5000), TX40_VISCOUS),
            **varied("cut-off", CUT_OFF, "Hz", (20, 100), TX40_VISCOUS),
            **varied("λ =", FILTER, "rad/s", (10, 100), TX40_VISCOUS),
            "varied weights": ("no weights", DECLARED | {"identify.weights": "none"}, TX40_VISCOUS),
        },
    ),
    "quanser-2dsfl": Machine(
        {"log.file": "quanser_2dsfl/quanser_2dsfl_psf.csv"}, {"stage1.stiffness": ("stiffness of stage 1", 39.96)},
        {
            "declared": ("strain gauges 0.15 s late", DECLARED, STIFFNESS),
            "ignored": ("delay ignored, without constraints",
                        DECLARED | {"identify.constraints": "none"} | dict.fromkeys(DELAYS, 0), STIFFNESS),
            "estimated": ("delays estimated", DECLARED | dict.fromkeys(DELAYS, "estimate"), STIFFNESS),
            "refined": ("prediction error", REFINED, STIFFNESS),
            **varied("β =", sharpness("stage1", "stage2"), "s/rad", (50, 100, 500), STIFFNESS),
        },
        (("other controller", "quanser_2dsfl/quanser_2dsfl_ctu_lqr.csv"),),
    ),
    "neura-lara8": Machine(
        {"log.file": "neura_lara8/orig/jogging_joint_mass.csv"}, {"joint2.stiffness": ("stiffness", None)},
        {
            "declared": ("all rows", DECLARED, LARA8),
            "refined": ("prediction error", REFINED, LARA8),
            **varied("cut-off", CUT_OFF, "Hz", (3, 5, 10), LARA8),
            **varied("rotor inertia", ['robot.fixed."joint2.rotor_inertia"'], "kg·m²", (1, 6), LARA8),
        },
    ),
}


def toml(value):
    """Returns a value as `--set` reads it."""
    return str(value) if isinstance(value, (int, float)) else json.dumps(value)


def run(binary, command, example, settings, out):
    """Runs a command of sprung into a folder; exits with its message if it refuses."""
    words = [binary, command, example, "--quiet", "--out", out]
    for key, value in settings.items():
        words += ["--set", f"{key}={toml(value)}"]
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{' '.join(map(str, words))}\n{done.stderr.strip()}")


def absolute(settings, data):
    """Returns settings whose files lie in the folder of the logs."""
    files = ("log.file", "robot.urdf")
    return {key: str(data / value) if key in files else value for key, value in settings.items()}


def note_values(prefix, words, parameters, chosen, published):
    """Notes parameters with their standard errors."""
    for parameter in parameters:
        if parameter["name"] not in chosen or parameter["value"] is None:
            continue
        what, peer = published[parameter["name"]]
        text = f"{words}{what} (standard error {shown(parameter['standard_error'])})"
        peers = {} if peer is None else {"peer": "published", "peer_value": peer}
        note(f"{prefix}/{parameter['name']}", text, parameter["value"], parameter["unit"], better="none", **peers)


def shown(value):
    """Returns a number with two digits."""
    return f"{float(f'{value:.2g}'):g}"


def unexplained(rows):
    """Returns the largest part of a joint's filtered motor torque that is not explained, in percent."""
    return 100 * max(rows.values())


def measure(binary, data, name, machine):
    """Notes the values of all cases of a machine."""
    example = ROOT / "examples" / name
    for case, (words, settings, chosen) in machine.cases.items():
        with tempfile.TemporaryDirectory() as out:
            settings = absolute(machine.files | settings, data)
            run(binary, "identify", example, settings, out)
            result = json.loads((Path(out) / "identification.json").read_text())["results"][0]
            others = machine.others if case == "declared" else ()
            tests = {other: validated(binary, example, settings, data / file, other, out) for other, file in others}
        prefix, rest = f"{name}/{case}", unexplained(result["relative_residual"])
        print(f"{prefix}: {result['verdict']}, {rest:.1f} % unexplained")
        if words:
            words += f", {shown(rest)} % of the torque unexplained: "
        else:
            note(f"{prefix}/unexplained", f"*{result['verdict']}*: unexplained part of the filtered torque", rest, "%")
        note_values(prefix, words, result["parameters"], chosen, machine.published)
        for row in result["motor_rows"] if case == "declared" else []:
            note_values(f"{prefix}/motor row", "motor row alone: ", row["parameters"], chosen, machine.published)
        for other, rows in tests.items():
            for joint, rest in rows.items():
                note(f"{prefix}/{other}/{joint}", f"log *{other}*: unexplained part of the filtered torque of {joint}", 100 * rest, "%")


def validated(binary, example, settings, log, name, out):
    """Returns the unexplained part of the filtered torque of each joint in another log."""
    run(binary, "validate", example, settings | {f'validate."{name}".log.file': str(log)}, out)
    tests = json.loads((Path(out) / "validation.json").read_text())
    test = next(test for test in tests["runs"] if test["name"] == name)
    return test["sets"][0]["torque_relative_residual"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/sprung")
    args = parser.parse_args()
    data = args.data.resolve()
    for name, machine in MACHINES.items():
        absent = [file for file in machine.files.values() if not (data / file).exists()]
        if absent:
            print(f"SKIPPED {name}: {', '.join(absent)} is absent in {data}")
            continue
        measure(args.binary.resolve(), data, name, machine)


if __name__ == "__main__":
    main()
