"""Compares the vibrations of an identified robot with the true ones, in poses that were not among those of the design.

    python poses.py SPRUNG EXPERIMENT

EXPERIMENT: folder of an identified twin with truth.toml and a [controller]. The script prints the largest error of a natural
frequency with motors free and held, in the order of the frequencies, and the largest residual of the true vibrations
of the linear loop with the shaper of the declared loop. It also designs the default controller, and notes its errors.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from figure import note  # noqa: E402

# The design has the first 20 poses of the sequence; the others are new.
DESIGNED, NEW = 20, 20


def tracking(program, folder, out):
    """Notes the errors of the links with the default design."""
    subprocess.run([program, "control", folder, "--quiet", "--out", out], check=True)
    proof = json.loads((out / "control.json").read_text())["proof"]
    for row in proof["tracking"]:
        for robot, error in row["designed_rad"].items():
            whose = "identified robot" if robot == "identified" else f"worst of {proof['robots'] - 1} robots"
            note(f"tracking {robot}, {row['joint']}", f"`{row['joint']}`, simulation, {whose}", error, "rad",
                 peer="PD of the paper", peer_value=row["declared_rad"])


def design(program, folder, out, poses, *more):
    settings = ["control.feedback=declared", "control.simulations=1", f"control.poses={poses}"]
    flags = [word for setting in settings for word in ("--set", setting)]
    subprocess.run([program, "control", folder, "--quiet", "--out", out, *flags, *more], check=True)
    return json.loads((out / "control.json").read_text())


def residual(shaper, hz, damping):
    """The residual vibration with the sampled shaper, as a part of that without it."""
    period, rate = shaper["period_s"], 2 * math.pi * hz
    turn, end = rate * math.sqrt(1 - damping**2), shaper["impulses"][-1]["time_s"]
    cos = sin = 0.0
    for impulse in shaper["impulses"]:
        samples, part = divmod(impulse["time_s"] / period, 1.0)
        for k, weight in ((samples, 1 - part), (samples + 1, part)):
            size = impulse["amplitude"] * weight * math.exp(-damping * rate * (end - k * period))
            cos, sin = cos + size * math.cos(turn * k * period), sin + size * math.sin(turn * k * period)
    return math.hypot(cos, sin)


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name)
        tracking(program, folder, out)
        shaper = design(program, folder, out, DESIGNED).get("shaper")
        found = design(program, folder, out, DESIGNED + NEW)
        true = design(program, folder, out, DESIGNED + NEW, "--parameters", folder / "truth.toml")
    error = left = 0.0
    for pose in range(DESIGNED, DESIGNED + NEW):
        for motors in ("free", "held"):
            frequencies, known = (
                sorted(v["poses"][pose]["hz"] for v in of["vibrations"] if v["motors"] == motors and v["poses"][pose])
                for of in (found, true)
            )
            if len(frequencies) == len(known):
                error = max([error, *(abs(a / b - 1) for a, b in zip(frequencies, known))])
        if shaper:
            loop = [v["poses"][pose] for v in true["vibrations"] if v["motors"] == "controlled"]
            for mode in filter(None, loop[: len(shaper["modes"])]):
                left = max(left, residual(shaper, mode["hz"], mode["damping"]))
    print(f"largest error of a frequency in {NEW} new poses: {100 * error:.2f} %")
    note("frequency", f"largest error of a frequency in {NEW} other poses", 100 * error, "%")
    if shaper:
        note("shaper", "largest vibration that the shaper leaves there, linear loop", 100 * left, "%")
    print(f"largest vibration that the shaper leaves there: {100 * left:.1f} %" if shaper else "no shaper")


main()
