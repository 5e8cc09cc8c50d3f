"""A position servo: check, identify and simulate, and what does not work with it."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import sprung

EXAMPLE = Path(__file__).parents[3] / "examples" / "servo-pendulum"
SHORT = {"simulate.duration_s": 16.0}


@pytest.fixture(scope="module")
def servo() -> sprung.Servo:
    return sprung.Servo(EXAMPLE, SHORT)


@pytest.fixture(scope="module")
def logs(servo: sprung.Servo) -> list[dict[str, np.ndarray]]:
    return servo.simulate()


@pytest.fixture(scope="module")
def result(servo: sprung.Servo, logs: list[dict[str, np.ndarray]]) -> sprung.ServoResult:
    return servo.identify(logs)


def test_a_twin_is_simulated_and_identified(
    servo: sprung.Servo, logs: list[dict[str, np.ndarray]], result: sprung.ServoResult
) -> None:
    assert len(logs) == 2
    assert set(logs[0]) >= {"t_s", "target_rad", "position_rad", "drive_on"}
    assert logs[0]["t_s"].shape == (3200,)
    truth = servo.truth()
    armature = result.parameters["servo.armature"]
    assert armature.value is not None and armature.standard_error is not None
    assert abs(armature.value - truth["servo.armature"]) < 4 * armature.standard_error
    assert abs(armature.value / truth["servo.armature"] - 1) < 0.1
    assert result.joint == "servo" and result.scale == "known-load" and result.usable
    assert result.position_errors.position_rms_over_noise < 1.5


def test_another_seed_gives_another_log_and_the_result_another_twin(
    servo: sprung.Servo, logs: list[dict[str, np.ndarray]], result: sprung.ServoResult
) -> None:
    other = servo.simulate(seed=7)
    assert not np.array_equal(other[0]["position_rad"], logs[0]["position_rad"])
    identified = servo.simulate(result=result)
    difference = identified[0]["position_rad"] - logs[0]["position_rad"]
    assert 0 < np.sqrt(np.mean(difference**2)) < 0.05


def test_the_check_tells_the_smallest_errors(
    servo: sprung.Servo, logs: list[dict[str, np.ndarray]]
) -> None:
    least = servo.check(logs).least_errors["servo.armature"]
    assert least is not None and 0 < least < 0.01


def test_a_result_is_saved_and_survives_a_pickle(
    result: sprung.ServoResult, tmp_path: Path
) -> None:
    folder = result.save(tmp_path / "out")
    files = {file.name for file in folder.iterdir()}
    assert files == {"servo.json", "parameters.csv", "report.html"}
    again = pickle.loads(pickle.dumps(result))
    assert again == result
    assert again.parameters["servo.armature"] == result.parameters["servo.armature"]


def test_what_does_not_work_names_the_servo_and_a_call_of_python(
    servo: sprung.Servo, logs: list[dict[str, np.ndarray]]
) -> None:
    experiment = servo.experiment
    for call in (experiment.identify, experiment.check):
        with pytest.raises(sprung.ExperimentError, match="servo is a position servo") as caught:
            call()
        assert "sprung.Servo." in str(caught.value.remedy) and "Session" not in str(caught.value)
    with pytest.raises(sprung.ExperimentError, match="2 files with payloads"):
        servo.identify(logs[0])
    with pytest.raises(sprung.ExperimentError, match="no position servo"):
        sprung.Servo(sprung.Experiment.demo())
