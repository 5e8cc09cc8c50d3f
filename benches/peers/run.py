"""Compares sprung with NumPy, Numba, Pinocchio and MuJoCo.

    benches/peers/run.sh [FOLDER] [--without PART,PART]

It builds sprung and installs the other programs into FOLDER, which also keeps the logs; the default
is a temporary folder. A program that cannot be installed is skipped. The log of an hour takes 1.5 GB
on disk.

Parts: numpy, numba, pinocchio, seven, hour (of seven), mujoco, refinement, check. `cargo xtask figures speed` runs it for
the documentation. The exit code is 1 if equal settings give other parameters.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from measure import HERE, bench, measure

sys.path.insert(0, str(HERE.parent))
from figure import note  # noqa: E402

ROOT = HERE.parents[1]
SEVEN = ROOT / "examples" / "seven-joint-twin"
PARTS = ["numpy", "numba", "pinocchio", "seven", "hour", "mujoco", "refinement", "check"]

# Largest relative difference of the parameters of the NumPy script.
SAME_PARAMETERS = 1e-9

# The settings of the NumPy script and of the script with Pinocchio. The latter differentiates twice
# instead of filtering the regression, so its parameters differ.
OF_NUMPY = ["--set", 'identify.laws="declared"', "--set", 'identify.weights="none"', "--set", 'identify.constraints="none"', "--set", "identify.position_cutoff_hz=10"]
OF_PINOCCHIO = ["--set", 'identify.laws="declared"', "--set", 'identify.weights="none"', "--set", 'identify.constraints="none"', "--set", "identify.position_cutoff_hz=40"]
LEAST_SQUARES = ["--set", 'identify.estimator=["least-squares"]']
REFINED = ["--set", 'identify.estimator=["prediction-error"]']


class Comparison:
    """Programs, folder and results of a comparison."""

    def __init__(self, folder, without):
        self.folder, self.without = folder, without
        self.failures = []
        self.sprung = build()
        self.python = folder / "venv" / "bin" / "python"
        self.install()

    def install(self):
        """Installs the other programs; those that cannot be installed are left out."""
        if not self.python.exists():
            subprocess.run([sys.executable, "-m", "venv", self.folder / "venv"], check=True)
        pip = [self.python, "-m", "pip", "install", "--quiet", "-r"]
        subprocess.run([*pip, HERE / "requirements.txt"], check=True)
        for peer in ("pinocchio", "mujoco"):
            if self.has(peer) and subprocess.run([*pip, HERE / f"requirements-{peer}.txt"]).returncode:
                print(f"{peer} cannot be installed: its comparisons are skipped")
                self.without.add(peer)

    def has(self, part):
        return part not in self.without

    def processor(self, name, text, run, peer=None, theirs=None):
        """Notes the processor time of a run, beside that of another program."""
        note(name, text, run.processor, "s", peer=peer, peer_value=theirs)

    def memory(self, name, text, run, peer=None, theirs=None):
        """Notes the peak memory of a run, beside that of another program."""
        note(f"{name}, memory", f"{text}: memory", run.mebibytes, "MiB", scatter=0.1, peer=peer, peer_value=theirs)

    def threads(self, name, one, two):
        """Notes how many times faster two threads are than one."""
        note(f"{name}, two threads", "", one.seconds / two.seconds, "times",
             better="higher", scatter=0.15)

    def simulate(self, experiment, name, duration=None):
        """Returns a log of a twin; a log that is there already is used."""
        log = self.folder / name / "identification.csv"
        if not log.exists():
            length = [] if duration is None else ["--set", f"simulate.duration_s={duration}"]
            self.run("simulate", experiment, *length, "--out", log.parent)
        return log

    def run(self, verb, experiment, *options, runs=1):
        return measure([self.sprung, verb, experiment, "--quiet", *options], runs)

    def identify(self, experiment, log, *options, runs=3, threads=1):
        """Times an identification; its results are in the folder `found`."""
        return self.run("identify", experiment, "--set", f"log.file={log}", "--threads", str(threads),
                        "--out", self.folder / "found", *options, runs=runs)

    def script(self, name, *arguments, runs=1):
        return measure([self.python, HERE / name, *arguments], runs, accepted=(0,))

    def value(self, output, name, word=1):
        """Returns a word of the line of a script's output that begins with a name."""
        lines = [line.split() for line in output.splitlines() if line.startswith(name)]
        return float(lines[0][word].rstrip(","))


def build():
    """Builds sprung and returns its path; SPRUNG names another binary."""
    if "SPRUNG" in os.environ:
        return Path(os.environ["SPRUNG"]).resolve()
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", "sprung-cli"], cwd=ROOT, check=True)
    target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
    return Path(target) / "release" / "sprung"


def say(what, run):
    print(f"{what:<58} {run}", flush=True)


def two_joints(it, demo):
    """Least squares of the demo's log and of a log of 1 million samples, beside the NumPy script."""
    for name, log in (("10 s", demo.parent / "identification.csv"),
                      ("1000 s", it.simulate(demo, "long", 1000))):
        print(f"\nlog of {name}, two joints")
        usual = it.identify(demo, log, *LEAST_SQUARES)
        say("sprung, least squares with its default settings", usual)
        equal = [*LEAST_SQUARES, *OF_NUMPY]
        ours = it.identify(demo, log, *equal)
        say("sprung, settings of the NumPy script", ours)
        found = json.loads((it.folder / "found" / "identification.json").read_text())
        if name == "1000 s":
            both = it.identify(demo, log, *equal, threads=2)
            say("sprung, settings of the NumPy script, two threads", both)
            it.threads("1000 s", ours, both)
        theirs = it.script("identify_numpy.py", log, runs=3)
        say("NumPy script", theirs)
        print(theirs.output.splitlines()[-1], "in the process")
        parameters = [parameter["value"] for parameter in found["results"][0]["parameters"]]
        others = [float(line.split()[1]) for line in theirs.output.splitlines()
                  if line.startswith("theta")]
        far = max(abs(other / parameter - 1.0) for parameter, other in zip(parameters, others, strict=True))
        print(f"parameters differ by {far:.1e} with equal settings")
        if far > SAME_PARAMETERS:
            it.failures.append(f"{name}: parameters differ by {far:.1e}")
        text = f"`identify`, {name} of two joints at 1 kHz from CSV, whole process with report"
        it.processor(name, f"{text}, default settings", usual, "NumPy script", theirs.processor)
        it.processor(f"{name}, equal", "", ours, "NumPy script", theirs.processor)
        it.memory(name, text, ours, "NumPy script", theirs.mebibytes)


def loops(it, demo):
    """Simulations of the demo's closed loop, beside Numba."""
    print("\nclosed loop of two joints, 10 s")
    ours = bench("simulate", "closed_loop", "0.0000001")
    print(f"sprung {1e3 * ours:.1f} ms")
    say("sprung simulate, 1000 s with encoders, noise and CSV",
        it.run("simulate", demo, "--set", "simulate.duration_s=1000", "--out", it.folder / "again"))
    output = it.script("simulate_numba.py", "10").output
    print("Numba", "; ".join(output.splitlines()))
    note("simulated", "simulated 10 s experiment of two joints", 1e3 * ours, "ms", peer="Numba RK4 at 0.1 ms",
         peer_value=1e3 * it.value(output, "seconds"))


def regressor(it):
    """The regressor of seven joints, beside Pinocchio."""
    print("\nregressor of a sample, seven joints")
    ours = bench("regressor", "regressor_of_a_sample", "panda")
    output = it.script("regressor_pinocchio.py").output
    theirs = 1e-6 * it.value(output, "microseconds")
    print(f"sprung {1e6 * ours:.2f} µs, Pinocchio {1e6 * theirs:.2f} µs, about "
          f"{it.value(output, 'binding')} µs of them its Python binding")
    note("regressor", "regressor of seven joints, one sample", 1e6 * ours, "µs", peer="Pinocchio, its torque regressor alone",
         peer_value=1e6 * theirs)


def seven_joints(it):
    """Least squares of seven flexible joints, beside Pinocchio with NumPy."""
    print("\nleast squares of seven flexible joints")
    log = it.simulate(SEVEN, "seven")
    options = [*LEAST_SQUARES, *OF_PINOCCHIO]
    usual = it.identify(SEVEN, log, *LEAST_SQUARES)
    say("sprung, 15 s, default settings", usual)
    equal = it.identify(SEVEN, log, *options)
    say("sprung, 15 s, settings of the script", equal)
    extrapolated = None
    if it.has("pinocchio"):
        other = it.script("identify_pinocchio.py", log)
        say("Pinocchio and NumPy, 15 s, 40 Hz (twice differentiated)", other)
        extrapolated = other.output.splitlines()[-1]
        print(extrapolated)
        text = "`identify`, 15 s of seven joints"
        script = "script with Pinocchio and NumPy"
        it.processor("seven", f"{text}, default settings", usual, script, other.processor)
        it.processor("seven, equal", "", equal, script, other.processor)
        it.memory("seven", text, usual, script, other.mebibytes)
    if not it.has("hour"):
        return
    hour = it.simulate(SEVEN, "hour", 3600)
    equal = it.identify(SEVEN, hour, *options, runs=1)
    say("sprung, an hour, no weights, 40 Hz", equal)
    one, two = (it.identify(SEVEN, hour, *LEAST_SQUARES, runs=1, threads=threads) for threads in (1, 2))
    say("sprung, an hour, default settings, one thread", one)
    say("sprung, an hour, default settings, two threads", two)
    text = "`identify`, an hour of seven joints, 3.6 million samples"
    it.threads("hour", one, two)
    if extrapolated is not None:
        words = extrapolated.replace(",", "").split()
        of = {unit: float(words[words.index(unit) + 1]) for unit in ("seconds", "GiB")}
        script = "the same script, extrapolated from 15 s"
        it.processor("hour", f"{text}, default settings", one, script, of["seconds"])
        it.processor("hour, equal", "", equal, script, of["seconds"])
        it.memory("hour", text, one, script, 1024.0 * of["GiB"])


def refinements(it, demo):
    """Refinements with the default settings; no other program does them."""
    print("\nrefinement")
    log = demo.parent / "identification.csv"
    two_joints = it.identify(demo, log, *REFINED)
    say("sprung, 10 s of two joints", two_joints)
    it.processor("refined, two joints", "refinement of 10 s of two joints", two_joints)
    it.memory("refined, two joints", "refinement of 10 s of two joints", two_joints)
    for name, duration in (("seven", None), ("seven-60", 60)):
        log = it.simulate(SEVEN, name, duration)
        one, two = (it.identify(SEVEN, log, *REFINED, runs=1, threads=threads) for threads in (1, 2))
        say(f"sprung, {duration or 15} s of seven joints, one thread", one)
        say(f"sprung, {duration or 15} s of seven joints, two threads", two)
        text = f"refinement of {duration or 15} s of seven joints"
        it.processor(f"refined, {duration or 15} s", text, one)
        it.memory(f"refined, {duration or 15} s", text, one)
        it.threads(f"refined, {duration or 15} s", one, two)


def checks(it):
    """A check of a log of seven joints."""
    print("\ncheck of 20 s of seven joints")
    log = it.simulate(SEVEN, "seven-20", 20)
    name, text = "sprung check", "`check` of 20 s of seven joints"
    run = it.run("check", SEVEN, "--set", f"log.file={log}", "--threads", "1", "--out", it.folder / "found")
    say(name, run)
    it.processor(name, text, run)
    it.memory(name, text, run)


def mujoco(it):
    """Simulations of seven joints."""
    print("\nMuJoCo: seven joints simulated for 10 s")
    exact = it.folder / "exact"
    exact.mkdir(exist_ok=True)
    unwanted = ("link_encoder_counts", "motor_encoder_counts", "torque_noise_nm", "motor_encoder_offset")
    lines = (SEVEN / "experiment.toml").read_text().splitlines()
    lines = ["duration_s = 10.0" if line.startswith("duration_s") else line for line in lines
             if not line.startswith(unwanted)]
    (exact / "experiment.toml").write_text("\n".join(lines))
    (exact / "truth.toml").write_text((SEVEN / "truth.toml").read_text())
    log = it.simulate(exact / "experiment.toml", "exact")
    ours = bench("simulate", "closed_loop_of_seven_joints", "0.0000001")
    print(f"sprung {ours:.3f} s")
    # Steps of 0.25 ms give about the accuracy of sprung at its tolerance.
    for substeps in (4, 10):
        output = it.script("simulate_mujoco.py", log, str(substeps)).output
        print("MuJoCo", "; ".join(output.splitlines()))
        if substeps == 4:
            theirs = it.value(output, "seconds")
            note("seven simulated", "seven joints simulated for 10 s", ours, "s",
                 peer="MuJoCo with RK4 at 0.25 ms", peer_value=theirs)


def compare(folder, without):
    it = Comparison(folder, without)
    demo = folder / "demo" / "experiment.toml"
    if not demo.exists():
        measure([it.sprung, "demo", "--quiet", "--out", demo.parent], runs=1)
    parts = [
        ("numpy", lambda: two_joints(it, demo)),
        ("numba", lambda: loops(it, demo)),
        ("pinocchio", lambda: regressor(it)),
        ("seven", lambda: seven_joints(it)),
        ("refinement", lambda: refinements(it, demo)),
        ("check", lambda: checks(it)),
        ("mujoco", lambda: mujoco(it)),
    ]
    for part, run in parts:
        if it.has(part):
            run()
    for failure in it.failures:
        print(f"FAILED: {failure}")
    return bool(it.failures)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    words.add_argument("folder", nargs="?", type=Path)
    words.add_argument("--without", default="", metavar="PART,PART")
    given = words.parse_args()
    without = {part for part in given.without.split(",") if part}
    if unknown := without - set(PARTS):
        words.error(f"no part {', '.join(sorted(unknown))}; the parts are {', '.join(PARTS)}")
    # The other programs use one thread. The output states the threads of sprung.
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    if given.folder is not None:
        given.folder.mkdir(parents=True, exist_ok=True)
        return compare(given.folder.resolve(), without)
    with tempfile.TemporaryDirectory() as folder:
        return compare(Path(folder), without)


if __name__ == "__main__":
    sys.exit(main())
