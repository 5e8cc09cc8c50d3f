"""Drawn robots have the covariance of the result, and their motions contain that of the true robot."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

EXAMPLES = Path(__file__).parents[3] / "examples"
PREDICTION_ERROR = {"identify.estimator": "prediction-error"}

#: Resolution of the demo's link encoders, rad.
COUNT_RAD = 2.0 * np.pi / 16384


def spreads(
    result: sprung.Result, samples: sprung.Samples, names: list[str]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns the covariance of the robots and the stated one, both over the stated standard errors."""
    drawn = samples.theta[:, [samples.parameters.index(name) for name in names]]
    rows = [result.covariance_names.index(name) for name in names]
    stated = result.covariance[np.ix_(rows, rows)]
    scale = np.sqrt(np.outer(np.diag(stated), np.diag(stated)))
    return np.cov(drawn.T) / scale, stated / scale


def test_robots_have_the_covariance_of_the_result(result: sprung.Result) -> None:
    # No bound binds: every parameter with a bound at zero is more than four standard errors from it, and the mass
    # matrix of each of 10 000 normal draws is positive, since none of them is lost.
    parameters = result.parameters
    assert all(
        abs(one.value or 0.0) > 4.0 * (one.standard_error or 0.0) for one in parameters.values()
    )
    samples = result.sample(10_000, seed=1)
    assert samples.effective == 10_000.0
    found, stated = spreads(result, samples, result.covariance_names)
    assert np.abs(found - stated).max() < 0.1
    assert np.abs(np.diag(found) - 1.0).max() < 0.1


def test_seven_joints_have_the_covariance_of_the_result() -> None:
    experiment = sprung.Experiment(EXAMPLES / "seven-joint-twin")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = experiment.identify(experiment.simulate())
    samples = result.sample(6000, seed=1)
    assert samples.effective > 2000.0
    # Bounds of bodies bind, and cannot be told apart for combinations of inertial parameters: they may only take spread
    # away. Bounds of drives are zero, and bind within four standard errors only.
    found, stated = spreads(result, samples, result.covariance_names)
    assert (np.diag(found) < 1.15).all()
    drives = [
        name
        for name in result.covariance_names
        if name.rpartition(".")[0] in experiment.joints
        and (name.endswith("preload") or _is_far_from_zero(result.parameters[name]))
    ]
    assert len(drives) > 40
    found, stated = spreads(result, samples, drives)
    assert np.abs(np.diag(found) - 1.0).max() < 0.1
    assert np.abs(found - stated).max() < 0.1


def _is_far_from_zero(parameter: sprung.Parameter) -> bool:
    return abs(parameter.value or 0.0) > 4.0 * (parameter.standard_error or 0.0)


@pytest.mark.parametrize("seeds", [(1, 2)])
def test_motions_of_the_robots_contain_a_held_out_motion(seeds: tuple[int, ...]) -> None:
    """A reading of an encoder is uniform within its count, so a count is spread over all readings."""
    experiment = sprung.Experiment.demo(PREDICTION_ERROR)
    short = sprung.Experiment.demo(PREDICTION_ERROR | {"simulate.duration_s": 2.0})
    inside = []
    for seed in seeds:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = experiment.identify(experiment.simulate(seed=seed))
        robots = result.sample(100, seed)
        held_out = short.simulate("prediction", seed=1000 + seed)
        motions = [
            short.simulate("prediction", result=robot, seed=2000 + 100 * seed + number)
            for number, robot in enumerate(robots)
        ]
        random = np.random.default_rng(seed)
        for name in ("q1_rad", "q2_rad"):
            rows = np.array([held_out[name], *(motion[name] for motion in motions)])
            rows += COUNT_RAD * random.uniform(-0.5, 0.5, rows.shape)
            low, high = np.quantile(rows[1:], [0.025, 0.975], axis=0)
            inside.append(float(((rows[0] >= low) & (rows[0] <= high)).mean()))
    # Four shares: each motion is one deviation of few parameters.
    assert 0.85 < np.mean(inside) < 0.995, inside
