"""The share of the torque that a result predicts on other logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

Log = dict[str, NDArray[np.float64]]


def write(path: Path, log: Log) -> Path:
    table = np.column_stack(list(log.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(log), comments="")
    return path


def test_the_score_is_the_explained_share_of_the_torque(
    experiment: sprung.Experiment, result: sprung.Result
) -> None:
    other = experiment.simulate(seed=5)
    (run,) = result.validate(other).runs
    shares = [1 - share**2 for share in run.sets[0].torque_relative_residual.values()]
    assert result.score(other) == pytest.approx(np.mean(shares), rel=1e-9)
    assert 0.98 < result.score(other) < 1.0
    # A noisier torque is predicted worse.
    noisy = dict(other)
    noisy["tau1_nm"] = other["tau1_nm"] + np.random.default_rng(0).normal(0, 20.0, len(other["t_s"]))
    assert result.score(noisy) < result.score(other) - 0.001


def test_files_and_several_logs_are_scored(
    experiment: sprung.Experiment, result: sprung.Result, tmp_path: Path
) -> None:
    logs = [experiment.simulate(seed=seed) for seed in (5, 6, 7)]
    paths = [write(tmp_path / f"{place}.csv", log) for place, log in enumerate(logs)]
    each = [result.score(path) for path in paths]
    assert each == pytest.approx([result.score(log) for log in logs], abs=1e-12)
    assert result.score(paths) == pytest.approx(np.mean(each), rel=1e-12)
    assert [run.log for run in result.validate(paths).runs] == [str(path) for path in paths]


def test_each_estimator_has_its_score(experiment: sprung.Experiment) -> None:
    both = sprung.Experiment.demo({"identify.estimator": ["least-squares", "lsff"]})
    result = both.identify(both.simulate())
    other = both.simulate(seed=5)
    assert result.score(other) > result.by("lsff").score(other) + 0.01


def test_a_log_of_other_columns_is_refused(
    experiment: sprung.Experiment, result: sprung.Result, tmp_path: Path
) -> None:
    other = experiment.simulate(seed=5)
    lacking = {name: values for name, values in other.items() if name != "phi1_rad"}
    with pytest.raises(sprung.LogError, match='no column "phi1_rad"; did you mean "phi2_rad"'):
        result.score(lacking)
    with pytest.raises(sprung.LogError, match=r'b\.csv has no column "phi1_rad"'):
        result.score(write(tmp_path / "b.csv", lacking))
    with pytest.raises(sprung.LogError, match='no column "t_s"'):
        result.score({"seconds": other["t_s"], "angle": other["q1_rad"]})
    with pytest.raises(sprung.FileError, match="nothing.csv"):
        result.score(tmp_path / "nothing.csv")
    with pytest.raises(sprung.InputError, match="the list of logs is empty"):
        result.score([])


def test_a_model_that_lacks_values_has_no_score(experiment: sprung.Experiment) -> None:
    log = experiment.simulate()
    still = {name: values for name, values in log.items()}
    for name in ("q2_rad", "phi2_rad"):
        still[name] = values = log[name].copy()
        values[:] = values[0] + 1e-4 * np.sin(np.arange(len(values)) / 7.0)
    result = experiment.identify(still)
    assert [name for name, parameter in result.parameters.items() if parameter.value is None]
    with pytest.raises(sprung.InputError, match="least-squares predicts no torque"):
        result.score(log)
