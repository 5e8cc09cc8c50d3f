"""Random effects against closed forms, an independent computation and known truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, stats

from sprung.fleet.statistics import Estimates, moments, robot_means, scatter


def drawn(robots: int, logs: int, between: float, within: float, error: float, seed: int) -> Estimates:
    """Estimates of a parameter whose mean is 1."""
    random = np.random.default_rng(seed)
    robot = np.repeat(np.arange(robots), logs)
    errors = error * np.exp(0.5 * random.standard_normal(robots * logs))
    value = 1.0 + between * random.standard_normal(robots)[robot]
    value += within * random.standard_normal(robots * logs) + errors * random.standard_normal(robots * logs)
    return Estimates.of(robot, value, errors)


def test_balanced_data_gives_the_analysis_of_variance() -> None:
    robots, logs = 40, 6
    estimates = drawn(robots, logs, 0.5, 0.3, 0.0, seed=1)
    table = estimates.value.reshape(robots, logs)
    inside = table.var(axis=1, ddof=1).mean()
    between = table.mean(axis=1).var(ddof=1) - inside / logs

    found = scatter(estimates)

    assert found.within == pytest.approx(inside**0.5, rel=1e-5)
    assert found.between == pytest.approx(between**0.5, rel=1e-5)
    assert found.mean == pytest.approx(table.mean(), rel=1e-12)
    assert found.mean_standard_error == pytest.approx(stats.sem(table.mean(axis=1)), rel=1e-6)
    assert found.between_dl == pytest.approx(found.between, rel=0.02)


def test_the_likelihood_is_that_of_the_whole_covariance_matrix() -> None:
    estimates = drawn(12, 4, 0.2, 0.1, 0.1, seed=2)
    ones = np.ones((estimates.value.size, 1))
    same = estimates.robot[:, None] == estimates.robot[None, :]

    def cost(scatters: np.ndarray) -> float:
        covariance = scatters[0] ** 2 * same + np.diag(scatters[1] ** 2 + estimates.standard_error**2)
        inverse = np.linalg.inv(covariance)
        information = ones.T @ inverse @ ones
        residual = estimates.value - (np.linalg.solve(information, ones.T @ inverse) @ estimates.value)[0]
        return float(
            np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(information)[1] + residual @ inverse @ residual
        )

    best = optimize.minimize(cost, [0.2, 0.1], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
    found = scatter(estimates)

    assert found.between == pytest.approx(abs(best.x[0]), rel=1e-4)
    assert found.within == pytest.approx(abs(best.x[1]), rel=1e-4)


def test_intervals_contain_the_truth_as_often_as_they_say() -> None:
    inside = {"mean": 0, "between": 0, "within": 0}
    repetitions = 80
    for seed in range(repetitions):
        found = scatter(drawn(30, 5, 0.5, 0.3, 0.2, seed))
        inside["mean"] += found.mean_ci95[0] <= 1.0 <= found.mean_ci95[1]
        inside["between"] += found.between_ci95[0] <= 0.5 <= found.between_ci95[1]
        inside["within"] += found.within_ci95[0] <= 0.3 <= found.within_ci95[1]
    for name, count in inside.items():
        assert stats.binomtest(count, repetitions, 0.95).pvalue > 0.001, (name, count)


def test_restricted_likelihood_and_moments_find_known_scatters() -> None:
    estimates = drawn(400, 10, 0.5, 0.3, 0.2, seed=4)
    found = scatter(estimates)
    for value in (found.between, found.between_dl):
        assert value == pytest.approx(0.5, rel=0.1)
    for value in (found.within, found.within_dl):
        assert value == pytest.approx(0.3, rel=0.1)


def test_one_log_each_gives_one_scatter_and_one_robot_the_other() -> None:
    single = scatter(drawn(100, 1, 0.5, 0.0, 0.1, seed=5))
    assert np.isnan(single.within) and single.between == pytest.approx(0.5, rel=0.25)
    alone = scatter(drawn(1, 100, 0.0, 0.3, 0.1, seed=6))
    assert np.isnan(alone.between) and alone.within == pytest.approx(0.3, rel=0.25)
    assert np.isnan(moments(drawn(1, 100, 0.0, 0.3, 0.1, seed=6))[0])


def test_no_scatter_is_zero_and_not_an_error() -> None:
    found = scatter(Estimates.of(["a", "a", "b", "b"], [1.0] * 4, [0.1] * 4))
    assert found.between == pytest.approx(0.0, abs=1e-6) and found.within == pytest.approx(0.0, abs=1e-6)
    exact = scatter(Estimates.of(["a", "a", "b", "b"], [1.0, 1.0, 2.0, 2.0], [0.0] * 4))
    assert exact.between == pytest.approx(0.5**0.5, rel=1e-3)


def test_means_of_robots_weight_by_errors() -> None:
    means = robot_means(Estimates.of([0, 0, 1], [1.0, 2.0, 5.0], [0.1, 0.2, 0.1]), within=0.0)
    assert means.value.tolist() == pytest.approx([1.2, 5.0])
    assert means.variance.tolist() == pytest.approx([0.008, 0.01])


@pytest.mark.parametrize(
    ("robot", "value", "error", "message"),
    [
        (["a"], [1.0, 2.0], [0.1, 0.1], "one common length"),
        ([], [], [], "no estimate"),
        (["a"], [float("nan")], [0.1], "finite"),
        (["a"], [1.0], [-0.1], "not negative"),
    ],
)
def test_bad_input_is_refused(robot: list[str], value: list[float], error: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Estimates.of(robot, value, error)
