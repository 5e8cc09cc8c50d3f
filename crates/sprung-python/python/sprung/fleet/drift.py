"""Drift of one robot over time: a step with its time, or a trend; and the effect of covariates in the whole fleet.

The test of a robot needs the scatter between its logs. A few logs give a poor estimate of it, and it differs between
robots. Each robot's variance is therefore moderated by those of the fleet (Smyth 2004).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats

from .statistics import CONFIDENCE, Estimates, Floats, variances

FEWEST_LOGS = 4
"""With fewer logs a robot is not tested for drift."""
FEWEST_SERIES = 8
"""With fewer robots the scatter of a robot is its own."""
QUANTILES = ((0.15, 0.85), (0.5, 0.95))
"""Pairs of quantiles of the variances whose ratios give their scatter: of the centre, and of the upper tail."""
MOST_FREEDOM = 1e4
"""With more degrees of freedom the prior is exact."""
LEAST_FREEDOM = 0.5
"""With fewer the prior tells nothing."""


@dataclass(frozen=True)
class Series:
    """Estimates of one parameter of one robot over time, sorted by time.

    - time_s: [n] in s.
    - value: [n] in the unit of the parameter.
    - variance: [n] expected variance of each value: scatter within robots and standard error.
    """

    time_s: Floats
    value: Floats
    variance: Floats


@dataclass(frozen=True)
class Prior:
    """The prior of the factor between observed and expected variance of a robot: inverse chi-square."""

    factor: float
    freedom: float
    """Degrees of freedom; infinite if all robots scatter alike."""


@dataclass(frozen=True)
class Drift:
    """The change of one parameter of one robot, in the unit of the parameter and in s."""

    shape: str
    """``step`` or ``trend``: the likelier one."""
    p_value: float
    """Upper bound over both shapes and all times of a step."""
    change: float
    """Value after minus before the step; for a trend, the last minus the first value of the line."""
    change_ci95: tuple[float, float]
    before: float
    """Mean before the step; for a trend, the value of the line at the first log."""
    time_s: float
    """The middle of the two logs about the likeliest step."""
    time_ci95_s: tuple[float, float]
    """The step lies between these times of logs."""
    slope_per_s: float
    """Of a line through all logs."""


@dataclass(frozen=True)
class CovariateEffect:
    """The change of a parameter per unit of a covariate within robots, common to the fleet."""

    slope: float
    standard_error: float
    """Between robots: robots may have slopes of their own."""
    ci95: tuple[float, float]
    p_value: float
    robots: int
    """Robots whose covariate changes between logs."""


def covariate_effects(
    estimates: Estimates, within: float, covariates: Floats
) -> tuple[list[CovariateEffect], Floats]:
    """Estimates the effect of covariates from differences between the logs of each robot.

    - within: standard deviation within robots, in the unit of the parameter.
    - covariates: [n × c] in the order of the estimates.

    Returns one effect a covariate, and the values [n] at the mean covariates of the fleet. A covariate that does not
    change within at least two robots has the slope NaN, and the values do not depend on it.

    # Source
    Liang and Zeger, Biometrika 73 (1986), 13: variance by clusters.
    """
    if covariates.shape[0] != estimates.value.size or covariates.ndim != 2:
        raise ValueError(f"covariates need {estimates.value.size} rows; their shape is {covariates.shape}")
    weight = 1.0 / variances(estimates, within)
    total = estimates.sums(weight)

    def centred(column: Floats) -> Floats:
        mean = estimates.sums(weight * column) / total
        return np.asarray(column - mean[estimates.robot], dtype=np.float64)

    columns = np.stack([centred(column) for column in covariates.T], axis=1) if covariates.size else covariates
    spread = np.sqrt(np.mean(columns**2, axis=0))
    size = np.maximum(np.abs(covariates).max(axis=0, initial=0.0), 1e-300)
    changing = [
        np.unique(estimates.robot[np.abs(columns[:, c]) > 1e-9 * size[c]]).size for c in range(columns.shape[1])
    ]
    used = np.array([c for c, robots in enumerate(changing) if robots >= 2], dtype=np.intp)
    nan = float("nan")
    nothing = CovariateEffect(nan, nan, (nan, nan), nan, 0)
    effects = [nothing] * columns.shape[1]
    if used.size == 0:
        return effects, estimates.value
    scaled = columns[:, used] / spread[used]
    information = (weight[:, None] * scaled).T @ scaled
    inverse = np.linalg.pinv(information)
    residual = centred(estimates.value)
    slopes = inverse @ (scaled.T @ (weight * residual))
    residual = residual - scaled @ slopes
    scores = np.stack([estimates.sums(weight * residual * column) for column in scaled.T], axis=1)
    clusters = max(changing)
    covariance = inverse @ (scores.T @ scores) @ inverse * (clusters / (clusters - 1))
    values = estimates.value.copy()
    for position, column in enumerate(used):
        slope = float(slopes[position] / spread[column])
        error = float(np.sqrt(covariance[position, position]) / spread[column])
        freedom = changing[column] - 1
        t = float(special.stdtrit(freedom, (1 + CONFIDENCE) / 2))
        p = float(2 * stats.t.sf(abs(slope) / error, freedom)) if error > 0 else float("nan")
        interval = (slope - t * error, slope + t * error)
        effects[column] = CovariateEffect(slope, error, interval, p, changing[column])
        values -= slope * (covariates[:, column] - covariates[:, column].mean())
    return effects, values


def prior(series: Sequence[Series]) -> Prior:
    """Estimates how the variances of robots scatter about the expected ones.

    Differences of neighbouring logs give the variance of each robot: a step or a trend hardly changes them.

    # Source
    Smyth, Statistical Applications in Genetics and Molecular Biology 3 (2004): the variances have a scaled F
    distribution. Its quantiles replace the moments, so that a few robots that drift have little effect.
    """
    factors, freedoms = [], []
    for one in series:
        n = one.value.size
        square = float(np.mean(np.diff(one.value) ** 2 / (one.variance[1:] + one.variance[:-1]))) if n > 1 else 0.0
        if n >= FEWEST_LOGS and square > 0:
            factors.append(square)
            # Neighbouring differences share a log, which widens the scatter of their mean square.
            freedoms.append(2.0 * (n - 1) ** 2 / (3.0 * n - 4.0))
    if len(factors) < FEWEST_SERIES:
        return Prior(1.0, 0.0)
    median_freedom = float(np.median(freedoms))
    # The smaller number of degrees of freedom is the safer one: the upper tail may be wider than the centre indicates.
    freedom = min(_prior_freedom(np.array(factors), median_freedom, ends) for ends in QUANTILES)
    middle = float(np.median(factors)) / float(
        stats.f.ppf(0.5, median_freedom, min(freedom, MOST_FREEDOM))
    )
    return Prior(middle, freedom)


def _prior_freedom(factors: Floats, freedom: float, ends: tuple[float, float]) -> float:
    """Returns the degrees of freedom of the prior with which F has the ratio of two quantiles of the factors."""

    def width(prior_freedom: float) -> float:
        low, high = (float(stats.f.ppf(end, freedom, prior_freedom)) for end in ends)
        return float(np.log(high / low))

    low, high = np.quantile(factors, ends)
    seen = float(np.log(high / low))
    if seen <= width(MOST_FREEDOM):
        return float("inf")
    if seen >= width(LEAST_FREEDOM):
        return LEAST_FREEDOM
    return float(optimize.brentq(lambda x: width(x) - seen, LEAST_FREEDOM, MOST_FREEDOM))


def drift(series: Series, moderation: Prior) -> Drift | None:
    """Tests whether the parameter of a robot changed; None with fewer than ``FEWEST_LOGS`` logs at different times.

    A step compares the means before and after each log, a trend the values with a line over time. The p-value is a
    bound: Bonferroni over both shapes, and Worsley's improvement of it over the times of the step.

    # Source
    Worsley, Biometrika 69 (1982), 297, for the bound; posterior of the change point for a flat prior as in Smith,
    Biometrika 62 (1975), 407.
    """
    time, value, variance = series.time_s, series.value, series.variance
    n = value.size
    if n < FEWEST_LOGS or time[0] == time[-1] or (moderation.freedom == 0 and n < FEWEST_LOGS + 2):
        return None
    weight = 1.0 / variance
    splits = np.flatnonzero(np.diff(time) > 0) + 1
    steps = _steps(value, weight, splits)
    freedom = moderation.freedom + n - 2
    line = _line(time, value, weight)

    def scale(residual: Floats) -> Floats:
        if np.isinf(moderation.freedom):
            return np.full_like(residual, moderation.factor)
        return np.asarray((moderation.freedom * moderation.factor + residual) / freedom)

    t_steps = steps.change / np.sqrt(steps.variance * scale(steps.residual))
    t_line = line.slope / np.sqrt(line.variance * scale(np.array([line.residual]))[0])
    p_step = _bound(t_steps, freedom, weight, splits)
    p_line = float(2 * stats.t.sf(abs(t_line), freedom))
    best = int(np.argmax(np.abs(t_steps)))
    is_step = bool(steps.residual[best] <= line.residual)
    half = float(special.stdtrit(min(freedom, 1e9), (1 + CONFIDENCE) / 2))
    low, high = _when(steps, moderation, freedom, time, splits)
    duration = float(time[-1] - time[0])
    change = float(steps.change[best]) if is_step else line.slope * duration
    variance_of_change = (
        steps.variance[best] * scale(steps.residual)[best]
        if is_step
        else line.variance * scale(np.array([line.residual]))[0] * duration**2
    )
    error = half * float(np.sqrt(variance_of_change))
    split = splits[best]
    return Drift(
        shape="step" if is_step else "trend",
        p_value=min(1.0, 2.0 * min(p_step, p_line)),
        change=change,
        change_ci95=(change - error, change + error),
        before=float(steps.before[best]) if is_step else line.start,
        time_s=float((time[split - 1] + time[split]) / 2),
        time_ci95_s=(low, high),
        slope_per_s=line.slope,
    )


@dataclass(frozen=True)
class _Steps:
    """For each possible step: [splits]."""

    before: Floats
    change: Floats
    variance: Floats
    residual: Floats


def _steps(value: Floats, weight: Floats, splits: NDArray[np.intp]) -> _Steps:
    centred = value - np.average(value, weights=weight)
    total, sums = np.cumsum(weight), np.cumsum(weight * centred)
    first, second = total[splits - 1], total[-1] - total[splits - 1]
    before, after = sums[splits - 1] / first, (sums[-1] - sums[splits - 1]) / second
    square = float(np.sum(weight * centred**2))
    residual = np.maximum(square - first * before**2 - second * after**2, 0.0)
    return _Steps(before + value.mean() - centred.mean(), after - before, 1 / first + 1 / second, residual)


@dataclass(frozen=True)
class _Line:
    start: float
    slope: float
    variance: float
    residual: float


def _line(time: Floats, value: Floats, weight: Floats) -> _Line:
    middle, mean = np.average(time, weights=weight), np.average(value, weights=weight)
    square = float(np.sum(weight * (time - middle) ** 2))
    slope = float(np.sum(weight * (time - middle) * (value - mean))) / square
    residual = float(np.sum(weight * (value - mean - slope * (time - middle)) ** 2))
    return _Line(float(mean + slope * (time[0] - middle)), slope, 1.0 / square, residual)


def _bound(t: Floats, freedom: float, weight: Floats, splits: NDArray[np.intp]) -> float:
    """Returns a bound of the probability that the largest |t| over all steps is as large as seen."""
    largest = float(np.max(np.abs(t)))
    one = float(2 * stats.t.sf(largest, freedom))
    if one == 0.0:
        return 0.0
    z = -float(special.ndtri(one / 2))
    first = np.cumsum(weight)[splits - 1]
    rest = weight.sum() - first
    correlation = np.sqrt(first[:-1] * rest[1:] / (first[1:] * rest[:-1]))
    # P(X > z, Y > z) of two normal variables, by Owen's function; twice for both signs.
    both = special.ndtr(-z) - 2 * special.owens_t(z, np.sqrt((1 - correlation) / (1 + correlation)))
    return min(1.0, max(one, splits.size * one - 2 * float(np.sum(np.maximum(both, 0.0)))))


def _when(
    steps: _Steps, moderation: Prior, freedom: float, time: Floats, splits: NDArray[np.intp]
) -> tuple[float, float]:
    """Returns the times of the logs about the 95 % most probable steps."""
    if np.isinf(moderation.freedom):
        fit = -steps.residual / (2 * moderation.factor)
    else:
        known = moderation.freedom * moderation.factor
        fit = -(freedom / 2) * np.log(np.maximum(known + steps.residual, 1e-300))
    # The integral over both means; and the share of time between two logs is the prior of a step there.
    logarithm = fit + 0.5 * np.log(steps.variance) + np.log(time[splits] - time[splits - 1])
    probability = np.exp(logarithm - logarithm.max())
    probability /= probability.sum()
    order = np.argsort(-probability, kind="stable")
    count = int(np.searchsorted(np.cumsum(probability[order]), CONFIDENCE)) + 1
    chosen = splits[order[:count]]
    return float(time[chosen.min() - 1]), float(time[chosen.max()])
