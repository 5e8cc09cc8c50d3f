"""Robots drawn from the posterior of an identification."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sprung

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def samples(result: sprung.Result) -> sprung.Samples:
    return result.sample(500, seed=3)


@pytest.fixture(scope="module")
def arm() -> sprung.Result:
    """A robot with single bodies, in its own units."""
    experiment = sprung.Experiment(
        EXAMPLES / "two-joint-arm" / "twin.toml", {"identify.estimator": "least-squares"}
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return experiment.identify(experiment.simulate())


def test_robots_have_the_errors_of_the_result(
    samples: sprung.Samples, result: sprung.Result
) -> None:
    assert samples.parameters == list(result.parameters) and len(samples) == 500
    assert samples.theta.shape == (500, len(samples.parameters))
    assert samples.theta.dtype == np.float64 and not samples.theta.flags.writeable
    assert 0.0 < samples.effective <= 500.0 and samples.undetermined == []
    for at, parameter in enumerate(result.parameters.values()):
        if parameter.standard_error is None or parameter.value is None or parameter.one_sided:
            continue
        drawn = samples.theta[:, at]
        assert abs(drawn.mean() - parameter.value) < 0.3 * parameter.standard_error
        assert drawn.std() == pytest.approx(parameter.standard_error, rel=0.2)


def test_the_seed_decides(samples: sprung.Samples, result: sprung.Result) -> None:
    assert result.sample(500, seed=3) == samples
    assert result.sample(500) != samples
    assert result.sample(500) == result.sample(500, seed=0) == result.sample(500, 0)
    assert result.sample(500).seed == 0 and samples.seed == 3


def test_robots_are_values_by_name(
    experiment: sprung.Experiment, samples: sprung.Samples
) -> None:
    robot = samples[7]
    assert list(robot) == samples.parameters and len(robot) == len(samples.parameters)
    assert list(robot.values()) == samples.theta[7].tolist()
    assert all(type(value) is float for value in robot.values())
    assert samples[-1] == samples[499] != robot and len(list(samples)) == 500
    designed = experiment.excite(method="paper", parameters=robot)
    assert {parameter.name: parameter.value for parameter in designed.promise} == robot
    with pytest.raises(IndexError, match="there are 500"):
        samples[500]
    with pytest.raises(KeyError, match="nearest name is 'joint1.stiffness'"):
        robot["joint1.stifness"]


def test_lookups_of_results_name_the_nearest_name(result: sprung.Result) -> None:
    with pytest.raises(KeyError, match="nearest name is 'joint2.stiffness'; the parameters are"):
        result.parameters["joint2.stifness"]


def test_bodies_of_single_links(arm: sprung.Result, samples: sprung.Samples) -> None:
    assert samples.bodies is None and samples.links == []
    assert samples.standard.shape == (500, 0) and samples.standard_parameters == []
    arm_samples = arm.sample(50)
    assert arm_samples.bodies is not None
    links = len(arm_samples.links)
    assert links == 2 and arm_samples.bodies.mass_kg.shape == (50, links)
    assert arm_samples.bodies.centre_of_mass_m.shape == (50, links, 3)
    assert arm_samples.bodies.inertia_kgm2.shape == (50, links, 3, 3)
    assert arm_samples.standard.shape == (50, len(arm_samples.standard_parameters))
    assert set(arm_samples.undetermined_standard) <= set(arm_samples.standard_parameters)
    # Each link has ten numbers, its mass and its first moments before the others.
    for link in range(links):
        mass = arm_samples.bodies.mass_kg[:, link]
        assert np.array_equal(arm_samples.standard[:, 10 * link], mass) and (mass > 0.0).all()
        moments = mass[:, None] * arm_samples.bodies.centre_of_mass_m[:, link]
        assert np.allclose(arm_samples.standard[:, 10 * link + 1 : 10 * link + 4], moments)
    # Bodies that can exist: principal moments are positive and fulfil the triangle inequality.
    inertia = arm_samples.bodies.inertia_kgm2
    assert np.array_equal(inertia, inertia.swapaxes(-1, -2))
    principal = np.linalg.eigvalsh(inertia)
    assert (principal > 0.0).all() and (principal[..., :2].sum(axis=-1) > principal[..., 2]).all()
    assert pickle.loads(pickle.dumps(arm_samples)) == arm_samples


def test_each_estimator_has_its_own_robots() -> None:
    names = ["prediction-error", "least-squares"]
    both = sprung.Experiment.demo({"identify.estimator": names})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = both.identify(both.simulate(seed=5))
    first, second = (result.by(name).sample(20) for name in names)
    assert first != second and first.parameters == second.parameters


def test_wrong_arguments_are_refused(result: sprung.Result) -> None:
    for count in (0, 100_001, 1_000_000_000):
        with pytest.raises(sprung.ExperimentError, match="draw 1 to 100000"):
            result.sample(count)
    wrong: list[Any] = [2.5, -1, 2**64, "10", None, 1e9, float("nan")]
    for value in wrong:
        with pytest.raises(sprung.InputError) as caught:
            result.sample(value)
        assert caught.value.code == "n" and caught.value.remedy
        with pytest.raises(sprung.InputError) as caught:
            result.sample(10, value)
        assert caught.value.code == "seed" and caught.value.remedy


def test_samples_are_frozen_pickle_copy_and_compare(samples: sprung.Samples) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        samples.effective = 1.0  # type: ignore[misc]
    for back in (pickle.loads(pickle.dumps(samples)), copy.deepcopy(samples)):
        assert back == samples and hash(back) == hash(samples)
        assert back[3] == samples[3] and hash(back[3]) == hash(samples[3])
    assert repr(samples) == "<sprung.Samples: 500 robots with 15 parameters>"
