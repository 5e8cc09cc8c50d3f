"""Designed experiments: motions within limits, their promises and files."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import sprung
from sprung._report import Kept

# A short search: these tests are about the interface.
SHORT = ["excite.steps=4", "excite.starts=1", "excite.duration_s=4"]
LIMITS = [
    "robot.joint_defaults.limits={torque_nm=5.0, deflection_rad=0.2}",
    "robot.joint.0.limits={torque_nm=4.8, deflection_rad=0.17}",
]


@pytest.fixture(scope="module")
def arm() -> sprung.Experiment:
    return sprung.Experiment.demo([*LIMITS, *SHORT])


@pytest.fixture(scope="module")
def designed(arm: sprung.Experiment) -> sprung.Excitation:
    return arm.excite()


def test_the_motion_rests_at_both_ends(designed: sprung.Excitation) -> None:
    assert designed.certified and designed.method == "optimal"
    assert designed.duration_s == 4.0 and designed.approach_s == 0.0
    assert designed.base_frequency_hz == pytest.approx(0.25)
    assert designed.harmonics and all(isinstance(harmonic, int) for harmonic in designed.harmonics)
    assert designed.hold_out is not None
    for trajectory in (designed.trajectory, designed.hold_out):
        count = len(trajectory.time_s)
        assert trajectory.joints == ["joint1", "joint2"]
        assert trajectory.time_s.shape == (count,) and trajectory.time_s.dtype == np.float64
        for motion in (
            trajectory.position_rad,
            trajectory.velocity_rad_per_s,
            trajectory.acceleration_rad_per_s2,
        ):
            assert motion.shape == (count, 2) and motion.dtype == np.float64
        for motion in (trajectory.velocity_rad_per_s, trajectory.acceleration_rad_per_s2):
            assert not motion[[0, -1]].any() and motion.any(axis=0).all()
        # The velocities are those of the positions.
        rate = (trajectory.position_rad[2:] - trajectory.position_rad[:-2]) / (
            trajectory.time_s[2] - trajectory.time_s[0]
        )
        most = np.abs(trajectory.velocity_rad_per_s).max()
        assert np.abs(rate - trajectory.velocity_rad_per_s[1:-1]).max() < 1e-3 * most
    assert designed.trajectory.time_s[-1] == pytest.approx(4.0)
    assert designed.hold_out != designed.trajectory


def test_the_promise_has_all_parameters(
    arm: sprung.Experiment, designed: sprung.Excitation
) -> None:
    assert {parameter.name: parameter.unit for parameter in designed.promise} == arm.parameter_units
    for parameter in designed.promise:
        assert parameter.standard_error > 0.0
        if parameter.value == 0.0:
            assert parameter.relative_percent is None
        else:
            expected = 100.0 * parameter.standard_error / abs(parameter.value)
            assert parameter.relative_percent == pytest.approx(expected)
        assert parameter.cure is None or not parameter.determined
    undetermined = [parameter.name for parameter in designed.promise if not parameter.determined]
    assert designed.undetermined == undetermined
    assert designed.assumed and all(assumption for assumption in designed.assumed)
    assert designed.more and all(extension.factor > 0.0 for extension in designed.more)


def test_limits_are_used_and_kept(designed: sprung.Excitation) -> None:
    used = [limit.used_percent for limit in designed.limits]
    assert used == sorted(used, reverse=True) and 0.0 < used[0] <= 100.0
    torque = {limit.joint: limit for limit in designed.limits if limit.quantity == "motor torque"}
    assert torque["joint1"].unit == "N·m"
    assert torque["joint1"].lowest == -4.8 and torque["joint1"].highest == 4.8
    assert torque["joint2"].highest == 5.0
    for limit in designed.limits:
        assert 0.0 <= limit.time_s <= designed.duration_s
        assert limit.shown in {"between samples", "simulated"}


def test_motions_without_a_search(arm: sprung.Experiment) -> None:
    for method in ("paper", "random"):
        design = arm.excite(method=method)
        assert design.method == method and design.hold_out is None
        assert list(arm.parameter_units) == [one.name for one in design.promise]
    paper = arm.excite(method="paper")
    assert paper.harmonics == [2, 5, 10] and paper.base_frequency_hz == pytest.approx(0.1)
    # The paper's reference does not depend on the limits.
    free = sprung.Experiment.demo(SHORT).excite(method="paper")
    assert free.certified and free.trajectory == paper.trajectory


def test_a_given_motion_is_judged(
    arm: sprung.Experiment, designed: sprung.Excitation, tmp_path: Path
) -> None:
    folder = designed.write(tmp_path / "design")
    judged = arm.excite(reference=folder / "reference.toml")
    assert judged.method == "reference" and judged.certified
    for one, other in zip(judged.promise, designed.promise, strict=True):
        assert one.standard_error == pytest.approx(other.standard_error)


def test_a_slow_motion_is_designed_beside_the_motion(
    designed: sprung.Excitation, tmp_path: Path
) -> None:
    assert designed.slow is None
    design = sprung.Experiment.demo([*LIMITS, *SHORT, "excite.slow_sweep_s=8"]).excite()
    assert design.slow is not None and design.slow.time_s[-1] == pytest.approx(8.0)
    folder = design.write(tmp_path)
    assert (folder / "slow.csv").exists()
    assert pickle.loads(pickle.dumps(design)) == design
    designed.write(tmp_path)
    assert not (folder / "slow.csv").exists()


def test_a_first_motion_is_smaller() -> None:
    limits = {"torque_nm": 5.0, "deflection_rad": 0.2, "velocity_rad_per_s": 1.0}
    short = {"excite.steps": 4, "excite.starts": 1, "excite.duration_s": 4}
    arm = sprung.Experiment.demo({"robot.joint_defaults.limits": limits, **short})
    first, usual = arm.excite(warm_up=True), arm.excite()
    assert first.warm_up and not usual.warm_up
    speeds = [np.abs(design.trajectory.velocity_rad_per_s).max() for design in (first, usual)]
    assert speeds[0] < 0.5 * speeds[1]


def test_values_come_from_results_files_and_dicts(
    arm: sprung.Experiment, result: sprung.Result, tmp_path: Path
) -> None:
    by_result = arm.excite(method="paper", parameters=result)
    values = {parameter.name: parameter.value for parameter in by_result.promise}
    assert values == result.parameters.values_by_name()
    by_dict = arm.excite(method="paper", parameters=values)
    assert by_dict.promise == by_result.promise
    result.save(tmp_path)
    file = tmp_path / "identification.json"
    for path in (file, str(file)):
        assert arm.excite(method="paper", parameters=path).promise == by_result.promise
    numpy = {name: np.float64(value) for name, value in values.items()}
    assert arm.excite(method="paper", parameters=numpy).promise == by_result.promise


def test_the_chosen_estimator_counts(arm: sprung.Experiment) -> None:
    both = sprung.Experiment.demo({"identify.estimator": ["prediction-error", "least-squares"]})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = both.identify(both.simulate(seed=5)).by("least-squares")
    designed = arm.excite(method="paper", parameters=result)
    assert {parameter.name: parameter.value for parameter in designed.promise} == {
        name: parameter.value for name, parameter in result.parameters.items()
    }


def test_a_recorded_log_counts(
    arm: sprung.Experiment, log: dict[str, np.ndarray], tmp_path: Path
) -> None:
    pandas = pytest.importorskip("pandas")
    path = tmp_path / "log.csv"
    pandas.DataFrame(log).to_csv(path, index=False, float_format="%.17g")
    without, beside = arm.excite(), arm.excite(from_log=path)
    errors = [[one.standard_error for one in design.promise] for design in (without, beside)]
    assert np.less(errors[1], errors[0]).all()
    with pytest.raises(sprung.SprungError):
        arm.excite(from_log=tmp_path / "none.csv")


def test_wrong_arguments_are_refused(arm: sprung.Experiment, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="optimal, paper") as caught:
        arm.excite(method="best")
    assert isinstance(caught.value, sprung.InputError) and caught.value.code == "method"
    with pytest.raises(sprung.ExperimentError, match="nonsense"):
        arm.excite(parameters={"nonsense": 1.0})
    with pytest.raises(sprung.InputError, match="of type str"):
        arm.excite(parameters={"joint1.stiffness": "9"})  # type: ignore[dict-item]
    with pytest.raises(sprung.InputError, match="of type list"):
        arm.excite(parameters=[1.0])  # type: ignore[arg-type]
    with pytest.raises(sprung.InputError, match="of type dict"):
        arm.excite(from_log={})  # type: ignore[arg-type]
    with pytest.raises(sprung.FileError):
        arm.excite(parameters=tmp_path / "none.json")


def test_missing_values_are_said_in_words_of_python() -> None:
    table = {
        "format": 1,
        "robot": {
            "name": "unknown",
            "kinematics": "planar-2r",
            "joint": [{"name": "a"}, {"name": "b"}],
            "joint_defaults": {"limits": {"torque_nm": 5.0, "deflection_rad": 0.2}},
        },
    }
    with pytest.raises(sprung.ExperimentError) as caught:
        sprung.Experiment(table, SHORT).excite()
    assert "warm_up=True" in str(caught.value) and "--" not in str(caught.value)


def test_a_callback_ends_the_search(designed: sprung.Excitation) -> None:
    long = sprung.Experiment.demo([*LIMITS, *SHORT, "excite.steps=100000"])
    heard: list[tuple[str, int, int | None]] = []

    def progress(phase: str, done: int, total: int | None) -> bool:
        heard.append((phase, done, total))
        return False

    stopped = long.excite(progress=progress)
    assert stopped.certified and heard and heard[0][0] == "designing"
    searched = [(done, total) for phase, done, total in heard if phase == "designing"]
    assert all(total is not None and done < total for done, total in searched)
    assert [parameter.name for parameter in stopped.promise] == [
        parameter.name for parameter in designed.promise
    ]


def test_threads_do_not_change_bits(arm: sprung.Experiment, designed: sprung.Excitation) -> None:
    assert arm.excite(threads=1) == designed


def test_the_command_line_writes_the_same_files(
    arm: sprung.Experiment, designed: sprung.Excitation, tmp_path: Path
) -> None:
    experiment = arm.save(tmp_path / "experiment.toml")
    sets = [word for one in [*LIMITS, *SHORT] for word in ("--set", one)]
    command = [sys.executable, "-m", "sprung", "excite", str(experiment), *sets, "-q"]
    subprocess.run([*command, "--out", str(tmp_path / "of-command")], check=True)
    folder = designed.write(tmp_path / "own")
    names = {path.name for path in folder.iterdir()}
    assert names == {
        "excitation.json", "trajectory.csv", "trajectory.yaml", "hold-out.csv", "reference.toml",
        "report.html",
    }
    # The reports name their commands.
    for name in names - {"report.html"}:
        assert (folder / name).read_bytes() == (tmp_path / "of-command" / name).read_bytes(), name


def test_files_hold_the_motion(
    arm: sprung.Experiment, designed: sprung.Excitation, tmp_path: Path
) -> None:
    folder = designed.write(tmp_path / "out")
    assert (folder / "excitation.json").read_text() == designed.to_json()
    table = np.genfromtxt(folder / "trajectory.csv", delimiter=",", names=True)
    assert np.array_equal(table["t_s"], designed.trajectory.time_s)
    assert np.array_equal(table["joint2_position_rad"], designed.trajectory.position_rad[:, 1])
    page = (folder / "report.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "sprung.Experiment.excite" in page
    assert designed.report(tmp_path / "report.html").read_text() == page
    assert designed._repr_html_().startswith("<iframe srcdoc=")
    # A design without a motion for validation leaves no old one behind.
    arm.excite(method="paper").write(folder)
    assert not (folder / "hold-out.csv").exists()
    with pytest.raises(sprung.FileError) as error:
        designed.write("/proc/none")
    assert error.value.remedy


def test_designs_are_frozen_pickle_copy_and_compare(
    arm: sprung.Experiment, designed: sprung.Excitation, tmp_path: Path
) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        designed.certified = False  # type: ignore[assignment]
    for back in (pickle.loads(pickle.dumps(designed)), copy.deepcopy(designed)):
        assert back == designed and hash(back) == hash(designed)
        assert back.promise == designed.promise and back.limits == designed.limits
        folder, other = (one.write(tmp_path / kind) for one, kind in ((back, "a"), (designed, "b")))
        for path in folder.iterdir():
            assert path.read_bytes() == (other / path.name).read_bytes()
    assert arm.excite(method="paper") != designed
    assert "joint1.stiffness" in repr(designed) and "every limit holds" in repr(designed)
    assert repr(designed.trajectory).endswith("4001 samples, 4 s>")


def test_infinite_errors_stay_numbers(designed: sprung.Excitation) -> None:
    contents = json.loads(designed.to_json())
    contents["promise"][0] |= {"standard_error": None, "relative_percent": None}
    promise = sprung.Excitation(Kept({"json": json.dumps(contents)})).promise[0]
    assert promise.standard_error == promise.relative_percent == math.inf
