"""Designed controllers: margins, vibrations, shapers, files and code."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import sprung

# Few robots and poses: these tests are about the interface.
SHORT = ["control.draws=20", "control.simulations=2", "control.poses=4"]


@pytest.fixture(scope="module")
def arm() -> sprung.Experiment:
    return sprung.Experiment.demo(SHORT)


@pytest.fixture(scope="module")
def designed(arm: sprung.Experiment, result: sprung.Result) -> sprung.Control:
    return arm.control(result)


@pytest.fixture(scope="module")
def shaped(result: sprung.Result) -> sprung.Control:
    """The demo's own controller, which feeds no torques forward, and a shaper for it."""
    return sprung.Experiment.demo([*SHORT, "control.feedback=declared"]).control(result)


def test_a_controller_has_gains_and_bandwidths(
    designed: sprung.Control, result: sprung.Result
) -> None:
    assert designed.feedback == "state-feedback" and designed.feedforward
    assert designed.verdict == result.verdict and designed.joints == ["joint1", "joint2"]
    assert designed.period_s == pytest.approx(1e-3) and designed.velocity_window == (4, 4)
    assert designed.gain.shape == (2, 8) and designed.gain.dtype == np.float64
    assert np.isfinite(designed.gain).all() and designed.gain.all()
    assert designed.bandwidth_hz is not None and designed.largest_bandwidth_hz is not None
    assert (0.0 < designed.bandwidth_hz).all()
    assert (designed.bandwidth_hz <= designed.largest_bandwidth_hz).all() and designed.limited_by
    # The demo gives no limits.
    assert np.isposinf(designed.torque_limits_nm).all() and designed.torque_limits_nm.shape == (2,)
    assert designed.torque_percent is None and not designed.payload
    assert designed.assumed and all(designed.assumed)


def test_margins_hold_for_all_robots(designed: sprung.Control) -> None:
    assert [loop.joint for loop in designed.loops] == designed.joints
    assert designed.draws == 20 and designed.poses_rad.shape == (4, 2)
    for loop in designed.loops:
        assert loop.gain_margin_db is not None
        assert 6.0 <= loop.gain_margin_db.worst <= loop.gain_margin_db.identified
        assert 40.0 <= loop.phase_margin_deg.worst <= loop.phase_margin_deg.identified
        assert loop.crossover_hz >= 0.0
    assert 0.0 < designed.least_damping.worst <= designed.least_damping.identified


def test_vibrations_have_intervals_and_poses(designed: sprung.Control) -> None:
    held = [vibration for vibration in designed.vibrations if vibration.motors == "held"]
    assert [vibration.name for vibration in held] == ["joint1", "joint2"]
    for vibration in designed.vibrations:
        assert vibration.hz_95[0] <= vibration.hz <= vibration.hz_95[1]
        assert vibration.damping_95[0] <= vibration.damping <= vibration.damping_95[1]
        assert len(vibration.poses) == 4 and any(vibration.poses)
        there = [one.hz for one in vibration.poses if one is not None]
        assert vibration.hz == pytest.approx(np.median(there))


def test_simulations_prove_the_controller(designed: sprung.Control) -> None:
    # The identified robot is one more.
    assert designed.simulations == 3 and designed.shaper is None
    assert [error.joint for error in designed.tracking] == designed.joints
    for error in designed.tracking:
        assert error.declared_rad is not None
        assert 0.0 < error.designed_rad.identified <= error.designed_rad.worst < error.declared_rad
    assert designed.moves.duration_s > 0.0 and len(designed.moves.way_rad) == 2
    assert designed.moves.unshaped_rad == designed.moves.shaped_rad


def test_a_shaper_has_impulses(shaped: sprung.Control) -> None:
    shaper = shaped.shaper
    assert shaped.feedback == "declared" and not shaped.feedforward and shaper is not None
    assert shaper.impulses.shape == (len(shaper.impulses), 2) and len(shaper.impulses) >= 2
    assert shaper.impulses[0, 0] == 0.0 and shaper.impulses[-1, 0] == shaper.delay_s > 0.0
    assert shaper.impulses[:, 1].sum() == pytest.approx(1.0)
    assert shaper.reached and shaper.largest_percent <= shaper.level_percent == 5.0
    assert len(shaper.modes) == 2
    assert shaper.largest_percent == max(one.largest_percent for one in shaper.modes)
    assert shaped.moves.shaped_rad.worst < shaped.moves.unshaped_rad.worst
    back = pickle.loads(pickle.dumps(shaped)).shaper
    assert back == shaper and hash(back) == hash(shaper)
    assert "input shaper" in repr(shaped) and "shaper = [[0.0" in shaped.to_toml()


def test_an_experiment_takes_the_controller(
    designed: sprung.Control, result: sprung.Result
) -> None:
    """An experiment that declares the designed controller has the same margins."""
    text = sprung.Experiment.demo().text
    before, after = text.index("[controller]"), text.index("[controller.reference]")
    new_text = text[:before] + designed.to_toml() + text[after:]
    settings = [*SHORT, "control.feedback=declared", "control.shaper_modes=0"]
    declared = sprung.Experiment.from_text(new_text, settings).control(result)
    assert np.array_equal(declared.gain, designed.gain) and declared.loops == designed.loops
    assert declared.bandwidth_hz is None and declared.largest_bandwidth_hz is None
    assert declared.limited_by is None


def test_values_come_from_results_files_and_dicts(
    arm: sprung.Experiment, designed: sprung.Control, result: sprung.Result, tmp_path: Path
) -> None:
    result.save(tmp_path)
    file = tmp_path / "identification.json"
    for path in (file, str(file)):
        assert arm.control(path) == designed
    exact = arm.control(result.parameters.values_by_name())
    assert exact.draws == 0 and exact.verdict is None
    assert any("count as exact" in assumption for assumption in exact.assumed)
    robot = result.sample(3)[1]
    assert arm.control(robot).gain.tolist() != exact.gain.tolist()


def test_the_chosen_estimator_counts(arm: sprung.Experiment) -> None:
    names = ["prediction-error", "least-squares"]
    both = sprung.Experiment.demo([*SHORT, f"identify.estimator={json.dumps(names)}"])
    log = both.simulate(seed=5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = both.identify(log)
        alone = sprung.Experiment.demo({"identify.estimator": names[1]}).identify(log)
    first, second = (arm.control(result.by(name)) for name in names)
    assert second.gain == pytest.approx(arm.control(alone).gain)
    assert first.gain.tolist() != second.gain.tolist()


def test_code_contains_the_controller(
    designed: sprung.Control, result: sprung.Result, tmp_path: Path
) -> None:
    for format in ("c", "rust"):
        without = result.export(format)
        texts = result.export(format, tmp_path / format, control=designed)
        assert {path.name for path in (tmp_path / format).iterdir()} == set(texts)
        assert set(texts) == set(without)
        assert "Controller: state-feedback" in "".join(texts.values())
        back = pickle.loads(pickle.dumps(designed))
        assert result.export(format, control=back) == texts
    with pytest.raises(sprung.ExperimentError, match="have no controller") as caught:
        result.export("urdf", control=designed)
    assert "--" not in str(caught.value)


def test_refusals_are_said_in_words_of_python(result: sprung.Result, tmp_path: Path) -> None:
    def refused(overrides: list[str], parameters: sprung.Result | dict[str, float]) -> str:
        with pytest.raises(sprung.ExperimentError) as caught:
            sprung.Experiment.demo([*SHORT, *overrides]).control(parameters)
        assert caught.value.remedy and "--" not in str(caught.value)
        return str(caught.value)

    assert "largest in these proportions" in refused(["control.bandwidth_hz=[300.0]"], result)
    assert "than the 0.001 s of the log" in refused(["control.period_s=1e-6"], result)
    assert "give a Result" in refused([], {"joint1.stiffness": 9.0})
    with pytest.raises(sprung.InputError, match="of type NoneType"):
        sprung.Experiment.demo(SHORT).control(None)  # type: ignore[arg-type]
    with pytest.raises(sprung.FileError):
        sprung.Experiment.demo(SHORT).control(tmp_path / "none.json")


def test_unusable_results_are_refused_until_they_are_accepted(
    arm: sprung.Experiment, designed: sprung.Control, result: sprung.Result, tmp_path: Path
) -> None:
    table = json.loads(result.to_json())
    table["results"][0]["verdict"] = "unusable"
    file = tmp_path / "identification.json"
    file.write_text(json.dumps(table))
    with pytest.raises(sprung.ExperimentError) as caught:
        arm.control(file)
    assert "accept_unusable=True" in str(caught.value)
    control = arm.control(file, accept_unusable=True)
    assert control.verdict == "unusable" and np.array_equal(control.gain, designed.gain)


def test_a_callback_stops_the_design(arm: sprung.Experiment, result: sprung.Result) -> None:
    long = sprung.Experiment.demo(["control.draws=2000", "control.poses=50"])
    heard: list[str] = []

    def progress(phase: str, done: int, total: int | None) -> bool:
        heard.append(phase)
        return False

    with pytest.raises(sprung.Stopped):
        long.control(result, progress=progress)
    assert heard[0] == "designing"


def test_threads_do_not_change_bits(
    arm: sprung.Experiment, designed: sprung.Control, result: sprung.Result
) -> None:
    assert arm.control(result, threads=1) == designed


def test_the_command_line_writes_the_same_files(
    arm: sprung.Experiment, designed: sprung.Control, result: sprung.Result, tmp_path: Path
) -> None:
    experiment = arm.save(tmp_path / "experiment.toml")
    result.save(tmp_path / "found")
    sets = [word for one in SHORT for word in ("--set", one)]
    found = ["--parameters", str(tmp_path / "found" / "identification.json")]
    command = [sys.executable, "-m", "sprung", "control", str(experiment), *sets, *found, "-q"]
    subprocess.run([*command, "--out", str(tmp_path / "of-command")], check=True)
    folder = designed.write(tmp_path / "own")
    names = {path.name for path in folder.iterdir()}
    assert names == {"control.json", "controller.toml", "control.html"}
    # The reports name their commands.
    for name in names - {"control.html"}:
        assert (folder / name).read_bytes() == (tmp_path / "of-command" / name).read_bytes(), name


def test_files_hold_the_controller(designed: sprung.Control, tmp_path: Path) -> None:
    folder = designed.write(tmp_path / "out")
    table = json.loads((folder / "control.json").read_text())
    assert table["controller"]["gain"] == designed.gain.tolist()
    assert (folder / "controller.toml").read_text() == designed.to_toml()
    page = (folder / "control.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "sprung.Experiment.control" in page
    assert designed.report(tmp_path / "report.html").read_text() == page
    assert designed._repr_html_().startswith("<iframe srcdoc=")
    with pytest.raises(sprung.FileError) as error:
        designed.write("/proc/none")
    assert error.value.remedy


def test_designs_are_frozen_pickle_copy_and_compare(
    designed: sprung.Control, shaped: sprung.Control
) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        designed.feedback = "pd"  # type: ignore[assignment]
    with pytest.raises(ValueError, match="read-only"):
        designed.gain[0, 0] = 1.0
    for back in (pickle.loads(pickle.dumps(designed)), copy.deepcopy(designed)):
        assert back == designed and hash(back) == hash(designed)
        assert back.vibrations == designed.vibrations and back._html() == designed._html()
    assert shaped != designed
    assert "joint1: gain margin" in repr(designed) and "motors held" in repr(designed)
