"""Tests of the folder, plain Python: `python test_benchmark.py` (half a minute)."""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import real
import simulate
import tasks
from model import Chain, inertias
from score import Refused, score

HERE = Path(__file__).parent
NAME = "two-hysteresis"


def made(folder):
    """A short task with all effects that the scorer knows."""
    task = tasks.twin("two", 2, 4, hysteresis=0.25, load_friction=0.05, backlash_rad=1e-4)
    simulate.HELD_OUT_SECONDS = 2
    t, states = simulate.run("two", [task])
    simulate.write(folder, NAME, task, t, states, 0)
    return folder / NAME


def test_regressor_and_mass_matrix_agree():
    for robot in tasks.ROBOTS.values():
        chain, bodies = Chain(robot["joints"], tasks.GRAVITY), np.array(robot["bodies"])
        q, dq, ddq = np.random.default_rng(0).normal(size=(3, 5, chain.n))
        mass, other = chain.dynamics(inertias(bodies), q, dq)
        torque = np.einsum("nij,nj->ni", mass, ddq) + other
        assert np.abs(torque - chain.regressor(q, dq, ddq) @ bodies.ravel()).max() < 1e-10
        power = np.einsum("ni,ni->n", dq, other - chain.dynamics(inertias(bodies), q, 0 * dq)[1])
        step = 1e-6
        kinetic = lambda q: 0.5 * np.einsum("ni,nij,nj->n", dq, chain.dynamics(inertias(bodies), q, dq)[0], dq)
        change = (kinetic(q + step * dq) - kinetic(q - step * dq)) / (2 * step)
        assert np.abs(power - change).max() < 1e-6 * np.abs(change).max()  # without torque the energy is constant


def test_truth_is_the_best_answer(folder):
    truth = json.loads((folder / "hidden/truth.json").read_text())
    best = score(folder, truth)
    assert best["torque_over_noise"] < 1e-9 and best["deflection_over_noise"] < 1e-9, best
    assert best["error_percent"] == 0 and best["coverage_percent"] == 100 and best["lacking"] == []
    for name, (value, _) in truth["parameters"].items():
        other = json.loads(json.dumps(truth))
        other["parameters"][name] = [1.01 * value, None]
        worse = score(folder, other)
        assert max(worse["torque_over_noise"], worse["deflection_over_noise"]) > 1e-4, name


def test_missing_and_foreign_names(folder):
    truth = json.loads((folder / "hidden/truth.json").read_text())
    part = json.loads(json.dumps(truth))
    del part["parameters"]["joint1.stiffness"]
    figures = score(folder, part)
    assert figures["lacking"] == ["joint1.stiffness"] and figures["torque_over_noise"] is None
    for change, words in [({"joint1.stifness": 1.0}, "did you mean 'joint1.stiffness'"), ({"joint1.stiffness": "soft"}, "finite number"),
                          ({"joint1.stiffness": float("nan")}, "finite number")]:
        try:
            score(folder, truth | {"parameters": truth["parameters"] | change})
        except Refused as why:
            assert words in str(why), why
        else:
            raise AssertionError(change)
    try:
        score(folder, {"parameters": truth["parameters"]})
    except Refused as why:
        assert "bodies" in str(why)


def test_absent_logs_are_named(folder):
    done = subprocess.run([sys.executable, HERE / "real.py", folder, folder / "no-logs"], capture_output=True, text=True, check=True)
    for name, task in tasks.TASKS.items():
        if task["kind"] == "real":
            assert f"skipped {name}" in done.stdout and task["source"] in done.stdout
            assert all(digest in done.stdout for digest in task["files"].values())


def test_adapters_are_short_and_run(folder):
    for file in (HERE / "adapters").glob("*.py"):
        lines = file.read_text().splitlines()
        assert len(lines) <= 40, f"{file}: {len(lines)} lines"
    out = folder / "ls.json"
    subprocess.run([sys.executable, HERE / "adapters/numpy_least_squares.py", folder, out], check=True)
    figures = score(folder, json.loads(out.read_text()))
    assert figures["error_percent"] < 30 and not figures["lacking"], figures


if __name__ == "__main__":
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with tempfile.TemporaryDirectory() as parent:
        place, count = made(Path(parent)), 0
        for name, test in list(globals().items()):
            if name.startswith("test_"):
                test(*([place] if test.__code__.co_argcount else []))
                count += 1
    print(f"{count} passed, 0 failed")
