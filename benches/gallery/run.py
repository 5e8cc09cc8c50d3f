"""Identifies the logs of real machines for the gallery, and stores its curves and figures.

    python run.py --data FOLDER --binary SPRUNG --curves benches/gallery.json

FOLDER has the public logs that the pages of the examples name, one folder for each machine. A machine without logs is left
out, with its name, and keeps its stored curves. Needs a C compiler: the torque on a new log is that of the exported C code.
"""

import argparse
import csv
import ctypes
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.signal import butter, filtfilt

sys.dont_write_bytecode = True
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benches"))

from figure import note  # noqa: E402

EXAMPLES = ROOT / "examples"
SERIES = ["measured", "predicted by sprung"]
LEAST_SQUARES = {"identify.estimator": ["least-squares"]}
POINTS = 180    # as many as a drawing shows


def toml(value):
    """Returns a value as `--set` reads it."""
    return str(value) if isinstance(value, (int, float)) else json.dumps(value)


class Run:
    """An experiment with settings, and a folder for its results."""

    def __init__(self, binary, experiment, settings, out):
        self.binary, self.experiment, self.settings, self.out = binary, experiment, settings, Path(out)

    def call(self, command, *words):
        """Runs a command of sprung; exits with its message if it refuses."""
        sets = [word for key, value in self.settings.items() for word in ("--set", f"{key}={toml(value)}")]
        line = [self.binary, command, self.experiment, "--quiet", "--out", self.out, *sets, *words]
        done = subprocess.run(list(map(str, line)), capture_output=True, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"{' '.join(map(str, line))}\n{done.stderr.strip()}")

    def identified(self):
        self.call("identify")
        self.all = json.loads((self.out / "identification.json").read_text())
        return self.all["results"][0]

    def validated(self, name):
        """Returns the errors of each joint on another log, measured and promised, in percent of its torque."""
        words = ("--parameters", self.out / "identification.json")
        self.call("validate", *words)
        tests = json.loads((self.out / "validation.json").read_text())["runs"]
        return next(test for test in tests if test["name"] == name)["sets"][0]["predictions"]

    def curves(self):
        """Returns the columns of `fit.csv`, measured and of the first estimator."""
        with open(self.out / "fit.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        first = self.all["results"][0]["estimator"]
        return [{key: np.array([float(row[key] or "nan") for row in rows if row["source"] == source])
                 for key in rows[0] if key != "source"} for source in ("measured", first)]

    def dynamics(self):
        """Returns a function: the motor torques of a motion of rigid joints, by the exported C code."""
        folder = self.out / "c"
        words = ["--parameters", self.out / "identification.json", "--format", "c"]
        Run(self.binary, self.experiment, self.settings, folder).call("export", *words)
        library = folder / "robot.so"
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", library, folder / "robot.c", "-lm"], check=True)
        name = re.search(r"void (\w+_inverse_dynamics)\(", (folder / "robot.h").read_text())[1]
        function = getattr(ctypes.CDLL(str(library)), name)

        def torques(q, dq, ddq):
            links, motors = np.zeros_like(q), np.zeros_like(q)
            pointer = ctypes.POINTER(ctypes.c_double)
            for k in range(len(q)):
                rows = [q[k], dq[k], ddq[k], q[k], dq[k], ddq[k], links[k], motors[k]]
                function(*(row.ctypes.data_as(pointer) for row in rows))
            return motors
        return torques


def predicted(torques, t, q, tau, cutoff):
    """Returns time, measured and predicted torque of a log, both below a cut-off in Hz."""
    rate = 1 / np.median(np.diff(t))
    even = np.arange(t[0], t[-1], 1 / rate)
    low = lambda x: filtfilt(*butter(2, 2 * cutoff / rate), x, axis=0)
    column = lambda x: np.column_stack([np.interp(even, t, one) for one in x.T])
    q, tau = low(column(q)), low(column(tau))
    d = lambda x: np.ascontiguousarray(np.gradient(x, 1 / rate, axis=0))
    cut = slice(int(rate / 2), -int(rate / 2))
    return even[cut] - t[0], tau[cut], torques(np.ascontiguousarray(q), d(q), d(d(q)))[cut]


def rounded(values, digits=4):
    return [None if not np.isfinite(v) else float(f"{v:.{digits}g}") for v in values]


def line(series, x, y, style="line", points=POINTS):
    """Returns a curve of at most so many points."""
    step = max(1, -(-len(x) // points))
    return {"series": series, "style": style, "x": rounded(x[::step]), "y": rounded(y[::step])}


def panel(title, curves, below="", height=100):
    return {"title": title, "below": below, "height": height, "curves": curves}


def value(name, parameter, text, relative=False):
    """Returns a value with its 95 % interval."""
    middle, half = parameter["value"], 1.96 * parameter["standard_error"]
    scale = 100 / abs(middle) if relative else 1
    shift = middle if relative else 0
    ends = [float(f"{scale * (middle + side * half - shift):.4g}") for side in (-1, 1)]
    return {"name": name, "value": float(f"{scale * (middle - shift):.4g}"), "interval": ends, "text": text}


def find(result, name):
    return next(p for p in result["parameters"] if p["name"] == name)


def note_result(name, result, proofs=()):
    """Notes verdict and errors of a machine; a table of the gallery shows them."""
    note(f"{name}/verdict", "", ("unusable", "doubtful", "good").index(result["verdict"]), "", better="higher")
    for what, errors in (("promised", held_out(result["promise"] or [])), ("held out", held_out(proofs))):
        for kind, pick in (("best", min), ("worst", max)):
            if errors:
                text = f"{NAMES[name]}, *{result['verdict']}*: {what}, {kind} joint"
                note(f"{name}/{what}/{kind}", text, pick(errors.values()), "%")


def held_out(proofs):
    """Returns the torque error of each joint in percent of its torque."""
    return {p["joint"]: 100 * p["torque_error_nm"] / p["torque_nm"] for p in proofs}


def friction(fit, joint, series=0, unit="nm", speed="rad_per_s"):
    """Returns the cloud and the model of a motor's friction against its velocity."""
    x = fit[f"{joint}.friction_velocity_{speed}"]
    order = np.argsort(x)
    clouds = [line(0, x[order], fit[f"{joint}.friction_measured_{unit}"][order], "points", 400)]
    return clouds + [line(1, x[order], fit[f"{joint}.friction_{unit}"][order], "points", 250)]


def both(fits, column):
    measured, fitted = fits
    return [line(k, fit["time_s"] - measured["time_s"][0], fit[column]) for k, fit in enumerate((measured, fitted))]


def emps(binary, data, out):
    logs = [data / "emps" / f"emps_{name}.csv" for name in ("estimation", "validation_pulses")]
    settings = {"log.file": str(logs[0]), "validate.pulses.log.file": str(logs[1])} | LEAST_SQUARES
    run = Run(binary, EXAMPLES / "emps", settings, out)
    result = run.identified()
    proofs = run.validated("pulses")
    note_result("emps", result, proofs)
    x = np.genfromtxt(logs[1], delimiter=",", names=True)
    t, measured, model = predicted(run.dynamics(), x["t"], x["q"][:, None], x["force"][:, None], 60)
    error = off(measured, model)[0]
    t, measured, model = (values[(4 < t) & (t < 12)] for values in (t, measured, model))
    shown = {"link1.m + carriage.rotor_inertia": "mass; published 95.1", "carriage.motor_coulomb": "Coulomb friction; published 20.4",
             "carriage.motor_viscous_positive": "viscous friction forwards; published 204",
             "carriage.motor_viscous_negative": "viscous friction backwards; published 204"}
    best = [(words, find(result, name)) for name, words in shown.items()]
    return {
        "title": "EMPS: force of a log not used to fit",
        "series": SERIES,
        "panels": [panel(f"force, N; error {error:.1f} %",
                         [line(0, t, measured[:, 0], points=320), line(1, t, model[:, 0], points=320)], "time, s", 150)],
        "quantity": "95 % interval, % of the value",
        "values": [value(words, p, f"{p['value']:.3g} {p['unit']}", True) for words, p in best],
    }


def off(measured, model):
    """Returns the error of each column, in percent of its root mean square."""
    return 100 * np.sqrt(np.mean((measured - model) ** 2, axis=0) / np.mean(measured**2, axis=0))


def panda_log(path):
    """Returns time, positions and torques without repeated samples."""
    x = np.loadtxt(path, delimiter=",", skiprows=1)
    _, first = np.unique(x[:, 0], return_index=True)
    return x[first, 0], x[first, 1:8], x[first, 15:22]


def panda(binary, data, out):
    run = Run(binary, data / "franka_panda", LEAST_SQUARES, out)
    result = run.identified()
    proofs = run.validated("second half")
    note_result("panda", result, proofs)
    t, measured, model = predicted(run.dynamics(), *panda_log(data / "franka_panda/panda_b.csv"), 5)
    own = off(measured, model)
    for (joint, error), drawn in zip(held_out(proofs).items(), own):
        print(f"panda {joint}: {error:.1f} % held out, {drawn:.1f} % of the curves")
    best = sorted(result["parameters"], key=lambda p: -p["torque_rms_nm"])[:3]
    names = [re.split(r" [-+] ", p["name"], maxsplit=1)[0] for p in best]
    return {
        "title": "Franka Panda: torque of a log not used to fit",
        "series": SERIES,
        "panels": [panel(f"joint {k + 1}, N·m; error {own[k]:.1f} %",
                         [line(0, t, measured[:, k]), line(1, t, model[:, k])], "time, s" if k == 6 else "", 56)
                   for k in (0, 3, 6)],
        "quantity": "three largest parameters: 95 % interval, % of the value",
        "values": [value(f"{name} …", p, f"{p['value']:.4g} {p['unit']}", True) for name, p in zip(names, best)],
    }


def kr300(binary, data, out):
    run = Run(binary, data / "kuka_kr300", LEAST_SQUARES, out)
    result = run.identified()
    proofs = run.validated("B")
    note_result("kr300", result, proofs)
    kept = sum(p["torque_ratio"] <= 1.5 for p in proofs)
    note("kr300/kept", "", kept, "", better="higher")
    delay = next(iter(run.all["log"]["delay_s"].values()))
    note("kr300/delay", "", 1000 * delay["value"], "ms", better="none")
    bounds = {k: find(result, f"a{k}.stiffness")["ci95"][1] / 1e6 for k in (1, 2, 3)}
    for k, bound in bounds.items():
        note(f"kr300/a{k}.stiffness", "", bound, "MN·m/rad", better="none")
    fits = run.curves()
    return {
        "title": "KUKA KR300: torque of the fitted log, and springs",
        "series": SERIES,
        "panels": [panel(f"axis {k}, kN·m", [c | {"y": [y and y / 1000 for y in c["y"]]} for c in both(fits, f"a{k}.motor_nm")],
                         "time, s" if k == 3 else "", 80) for k in (1, 2, 3)],
        "quantity": "95 % intervals of the stiffness, MN·m/rad, beside that of KUKA's feedforward",
        "values": [value(f"axis {k}", {"value": bounds[k] / 2, "standard_error": bounds[k] / 2 / 1.96},
                         f"< {bounds[k]:.1f}; KUKA {maker}") for k, maker in ((2, 7.52), (3, 4.10))],
    }


def tx40(binary, data, out):
    folder = data / "staubli_tx40"
    files = {"log.file": str(folder / "staubli_tx40_1kHz.csv"), "robot.urdf": str(folder / "tx40.urdf")}
    run = Run(binary, EXAMPLES / "staubli-tx40", files | LEAST_SQUARES, out)
    note_result("tx40", run.identified())
    fits = run.curves()
    return {
        "title": "Stäubli TX40: torque of the fitted log, and friction",
        "series": SERIES,
        "panels": [panel(f"joint {k}, N·m", both(fits, f"joint_{k}.motor_nm"), "time, s" if k == 6 else "", 84) for k in (1, 2, 6)]
        + [panel("friction of joint 1, N·m", friction(fits[1], "joint_1"), "velocity, rad/s", 120)],
    }


def quanser(binary, data, out):
    logs = [data / "quanser_2dsfl" / f"quanser_2dsfl_{name}.csv" for name in ("psf", "ctu_lqr")]
    settings = {"log.file": str(logs[0]), 'validate."other controller".log.file': str(logs[1])} | LEAST_SQUARES
    run = Run(binary, EXAMPLES / "quanser-2dsfl", settings, out)
    result = run.identified()
    note_result("quanser", result, run.validated("other controller"))
    fits = run.curves()
    return {
        "title": "Quanser flexible link: torque of the fitted log",
        "series": SERIES,
        "panels": [panel(f"stage {k}, N·m", both(fits, f"stage{k}.motor_nm"), "time, s" if k == 2 else "") for k in (1, 2)],
    }


def lara8(binary, data, out):
    log = {"log.file": str(data / "neura_lara8/orig/jogging_joint_mass.csv")}
    run = Run(binary, EXAMPLES / "neura-lara8", log | {"identify.estimator": ["prediction-error"]}, out)
    note_result("lara8", run.identified())
    fits = run.curves()
    x, fit = fits[1]["joint2.deflection_rad"] * 1e3, fits[1]
    order = np.argsort(x)
    spring = [line(k, x[order], fit[f"joint2.{name}_nm"][order], "points", 250) for k, name in enumerate(("spring_measured", "spring"))]
    return {
        "title": "NEURA LARA 8, joint 2: torque and spring of the fitted log",
        "series": SERIES,
        "panels": [panel("torque, N·m", both(fits, "joint2.motor_nm"), "time, s"),
                   panel("torque of the spring, N·m", spring, "deflection, mrad", 130)],
    }


NAMES = {"emps": "EMPS", "panda": "Franka Panda", "kr300": "KUKA KR300", "tx40": "Stäubli TX40", "quanser": "Quanser",
         "lara8": "NEURA LARA 8"}
MACHINES = {"emps": emps, "panda": panda, "kr300": kr300, "tx40": tx40, "quanser": quanser, "lara8": lara8}
FOLDERS = {"panda": "franka_panda", "kr300": "kuka_kr300", "tx40": "staubli_tx40", "quanser": "quanser_2dsfl", "lara8": "neura_lara8"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--binary", type=Path, required=True)
    parser.add_argument("--curves", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=list(MACHINES))
    args = parser.parse_args()
    data, binary = args.data.resolve(), args.binary.resolve()
    version = subprocess.run([binary, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    curves = json.loads(args.curves.read_text()) if args.curves.exists() else {}
    for name in args.only:
        if not (data / FOLDERS.get(name, name)).is_dir():
            print(f"SKIPPED {name}: {FOLDERS.get(name, name)} is absent in {data}")
            continue
        with tempfile.TemporaryDirectory() as out:
            curves[name] = MACHINES[name](binary, data, out) | {"note": f"cargo xtask gallery, {version}"}
        print(f"{name}: done")
    lines = [f"{json.dumps(name)}: {json.dumps(one, ensure_ascii=False)}" for name, one in sorted(curves.items())]
    args.curves.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
