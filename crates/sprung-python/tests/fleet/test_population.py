"""Outliers and drift on simulated fleets with known truth; benches/fleet/statistics.py is the long version."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sprung.fleet.drift import Prior, Series, covariate_effects, drift, prior
from sprung.fleet.outliers import adjust, central
from sprung.fleet.population import Rows, analyse
from sprung.fleet.statistics import Estimates, robot_means

DAY_S = 86400.0
SOFT = "robot003"


def fleet(
    seed: int,
    robots: int = 60,
    logs: int = 8,
    soft: int = 0,
    step_at_day: float | None = None,
    per_kelvin: float = 0.0,
) -> Rows:
    """Stiffness and inertia of a fleet with a scatter of 0.7 % in all.

    The first robots from number 3 on have 5 % less stiffness, from a day on if it is given.
    """
    random = np.random.default_rng(seed)
    robot = np.repeat(np.arange(robots), logs)
    count = robots * logs
    time_s = np.sort(random.uniform(0, 365 * DAY_S, (robots, logs)), axis=1).ravel()
    temperature_c = random.uniform(10, 40, count)
    values, errors = [], []
    for parameter in range(2):
        error = 0.0035 * np.exp(0.3 * random.standard_normal(count))
        value = 1 + 0.005 * random.standard_normal(robots)[robot] + 0.0035 * random.standard_normal(count)
        value += error * random.standard_normal(count) + per_kelvin * (temperature_c - 25)
        if parameter == 0:
            after = True if step_at_day is None else time_s > step_at_day * DAY_S
            value = np.where((robot >= 3) & (robot < 3 + soft) & after, value - 0.05, value)
        values.append(value)
        errors.append(error)
    names = np.array([f"robot{number:03}" for number in robot], dtype=object)
    return Rows(
        robot=np.tile(names, 2),
        parameter=np.repeat(np.array(["joint1.stiffness", "joint1.rotor_inertia"], dtype=object), count),
        unit=np.repeat(np.array(["N·m/rad", "kg·m²"], dtype=object), count),
        value=np.concatenate(values),
        standard_error=np.concatenate(errors),
        time_s=np.tile(time_s, 2),
        covariates={"temperature_c": np.tile(temperature_c, 2)},
    )


def test_a_soft_robot_is_found_and_few_others() -> None:
    false, found = [], 0
    for seed in range(15):
        named = analyse(fleet(seed, soft=1)).outliers()
        right = [1 for population, robot in named if (robot.robot, population.parameter) == (SOFT, "joint1.stiffness")]
        found += len(right)
        false.append((len(named) - len(right)) / max(len(named), 1))
    assert found == 15
    assert np.mean(false) < 0.15


def test_a_fifth_of_the_robots_does_not_hide_itself() -> None:
    named = analyse(fleet(1, soft=12)).outliers()
    assert {robot.robot for _, robot in named} >= {f"robot{number:03}" for number in range(3, 15)}
    assert len(named) <= 14


def test_errors_that_all_robots_share_hide_no_robot() -> None:
    """Twenty robots with one motion: their standard errors are thirty times their scatter."""
    found, false = 0, 0
    for seed in range(20):
        rows = fleet(seed, robots=20, logs=1, soft=1)
        random = np.random.default_rng(1000 + seed)
        bias = np.repeat(0.2 * random.standard_normal(2), 20)
        error = np.hypot(rows.standard_error, 0.2)
        analysis = analyse(replace(rows, value=rows.value + bias, standard_error=error))
        named = [robot.robot for _, robot in analysis.outliers()]
        found += SOFT in named
        false += len(named) > named.count(SOFT)
        for population in analysis.populations:
            assert population.central is not None
            assert population.central.between == 0.0 and population.central.own_part < 0.01
    assert found >= 18 and false <= 4


def test_a_fleet_without_changes_names_hardly_any_robot() -> None:
    analyses = [analyse(fleet(seed)) for seed in range(15)]
    assert sum(bool(one.outliers()) for one in analyses) <= 3
    assert sum(bool(one.moved()) for one in analyses) <= 3


def test_few_robots_are_not_tested() -> None:
    analysis = analyse(fleet(1, robots=7, soft=1))
    assert analysis.outliers() == []
    assert all(np.isnan(robot.adjusted_p_value) for robot in analysis.populations[0].robots)
    assert central(robot_means(Estimates.of(range(7), [1.0] * 7, [0.1] * 7), 0.0)) is None


def test_a_step_is_found_with_its_time_and_its_parameter() -> None:
    found, inside = 0, 0
    for seed in range(10):
        moved = analyse(fleet(seed, soft=1, step_at_day=180.0)).moved()
        for population, one in moved:
            if one.robot == SOFT:
                assert population.parameter == "joint1.stiffness"
                found += 1
                inside += one.drift.time_ci95_s[0] <= 180 * DAY_S <= one.drift.time_ci95_s[1]
                assert one.drift.change == pytest.approx(-0.05, abs=0.025)
    assert found >= 9
    assert inside >= found - 2


def test_a_trend_is_told_from_a_step() -> None:
    random = np.random.default_rng(1)
    time_s = np.arange(40.0)
    noise = 0.01 * random.standard_normal(40)
    known = Prior(1.0, float("inf"))
    variance = np.full(40, 1e-4)
    slow = drift(Series(time_s, 1 + 0.1 * time_s / 40 + noise, variance), known)
    sudden = drift(Series(time_s, 1 + 0.1 * (time_s > 25) + noise, variance), known)
    assert slow is not None and slow.shape == "trend" and slow.slope_per_s == pytest.approx(0.0025, rel=0.2)
    assert sudden is not None and sudden.shape == "step"
    assert sudden.time_ci95_s[0] <= 25.5 <= sudden.time_ci95_s[1] and sudden.time_s == 25.5


@pytest.mark.parametrize("moderation", [Prior(1.0, float("inf")), Prior(1.0, 0.0), Prior(0.8, 6.0)])
def test_p_values_of_drift_bound_the_false_alarms(moderation: Prior) -> None:
    random = np.random.default_rng(2)
    logs, alarms, repetitions = 12, 0, 1500
    for _ in range(repetitions):
        factor = 1.0
        if moderation.freedom == 6.0:
            factor = 0.8 * 6.0 / random.chisquare(6.0)
        value = factor**0.5 * random.standard_normal(logs)
        found = drift(Series(np.arange(float(logs)), value, np.ones(logs)), moderation)
        assert found is not None
        alarms += found.p_value <= 0.05
    assert 0.02 * repetitions < alarms < 0.06 * repetitions


def test_the_prior_finds_unequal_scatters() -> None:
    random = np.random.default_rng(3)
    series = []
    for _ in range(400):
        value = (8.0 / random.chisquare(8.0)) ** 0.5 * random.standard_normal(20)
        series.append(Series(np.arange(20.0), value, np.ones(20)))
    assert 4.0 < prior(series).freedom < 16.0
    equal = [Series(np.arange(20.0), random.standard_normal(20), np.ones(20)) for _ in range(400)]
    assert prior(equal).freedom > 40.0 and prior(equal).factor == pytest.approx(1.0, rel=0.1)


def test_temperature_is_explained_and_hides_nothing() -> None:
    analysis = analyse(fleet(4, soft=1, per_kelvin=0.002))
    effect = analysis.populations[1].covariates["temperature_c"]
    assert effect.ci95[0] <= 0.002 <= effect.ci95[1] and effect.p_value < 1e-20
    assert SOFT in {robot.robot for _, robot in analysis.outliers()}
    assert analysis.populations[1].scatter.within == pytest.approx(0.0035, rel=0.3)


def test_a_constant_covariate_has_no_effect() -> None:
    estimates = Estimates.of([0, 0, 1, 1], [1.0, 1.1, 2.0, 2.2], [0.1] * 4)
    effects, values = covariate_effects(estimates, 0.0, np.array([[20.0], [20.0], [30.0], [30.0]]))
    assert np.isnan(effects[0].slope) and effects[0].robots == 0
    assert np.array_equal(values, estimates.value)


def test_adjusted_p_values_of_all_parameters_together() -> None:
    first, second = adjust([np.array([0.01, np.nan]), np.array([0.02, 0.9])])
    assert first[0] == pytest.approx(0.03) and np.isnan(first[1])
    assert second.tolist() == pytest.approx([0.03, 0.9])
    assert adjust([]) == []


def test_rows_of_any_order_give_the_same_result() -> None:
    rows = fleet(5, soft=1, step_at_day=100.0)
    order = np.random.default_rng(6).permutation(rows.value.size)
    shuffled = Rows(
        robot=rows.robot[order],
        parameter=rows.parameter[order],
        unit=rows.unit[order],
        value=rows.value[order],
        standard_error=rows.standard_error[order],
        time_s=rows.time_s[order],
        covariates={name: column[order] for name, column in rows.covariates.items()},
    )
    expected, found = analyse(rows), analyse(shuffled)
    assert [robot.robot for _, robot in found.moved()] == [robot.robot for _, robot in expected.moved()]
    for a, b in zip(expected.populations, found.populations, strict=True):
        assert b.scatter.mean == pytest.approx(a.scatter.mean, rel=1e-12)


def test_bad_input_is_refused() -> None:
    rows = fleet(1, robots=8, logs=2)
    with pytest.raises(ValueError, match="between 0 and 1"):
        analyse(rows, rate=0.0)
    with pytest.raises(ValueError, match="joint1.stiffness has the units"):
        unit = rows.unit.copy()
        unit[0] = "N/m"
        analyse(replace(rows, unit=unit))
    with pytest.raises(ValueError, match="column time_s"):
        analyse(replace(rows, time_s=rows.time_s[1:]))
