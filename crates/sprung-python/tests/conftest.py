"""Fixtures: the demo's experiment, its log and its result by least squares."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

LEAST_SQUARES = {"identify.estimator": "least-squares"}


@pytest.fixture(scope="session")
def experiment() -> sprung.Experiment:
    return sprung.Experiment.demo(LEAST_SQUARES)


@pytest.fixture(scope="session")
def log(experiment: sprung.Experiment) -> dict[str, NDArray[np.float64]]:
    return experiment.simulate()


@pytest.fixture(scope="session")
def quantities(log: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """The same log as matrices by quantity."""

    def both(name: str, unit: str) -> NDArray[np.float64]:
        return np.column_stack([log[f"{name}1_{unit}"], log[f"{name}2_{unit}"]])

    return {
        "t": log["t_s"],
        "q": both("q", "rad"),
        "phi": both("phi", "rad"),
        "tau": both("tau", "nm"),
    }


@pytest.fixture(scope="session")
def result(
    experiment: sprung.Experiment, log: dict[str, NDArray[np.float64]]
) -> sprung.Result:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return experiment.identify(log)
