"""Robots that are outliers in a population, with a controlled rate of false discoveries.

A few defective robots widen the scatter of all and hide themselves. The mean and the scatter of the test are
therefore those of the central robots: a normal distribution that is truncated at ``WINDOW`` standard deviations.
The test uses Student's t, because mean and scatter are estimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special, stats

from .statistics import Floats, RobotMeans

WINDOW = 2.5
"""Half width of the central part, in standard deviations. A wider one is more precise with few defective robots."""
FEWEST_ROBOTS = 8
"""With fewer robots the central part does not give a scatter, and no robot is tested."""
FEW = 12
"""Which robots are inside the window is uncertain with few robots; n / (n + FEW) of the degrees of freedom then keeps
the p-values true (simulated populations of 10 to 200 robots)."""


@dataclass(frozen=True)
class Central:
    """The distribution of the central robots, in the unit of the parameter."""

    mean: float
    mean_standard_error: float
    between: float
    """Standard deviation between robots."""
    robots: int
    """Robots inside the window."""


@dataclass(frozen=True)
class Tests:
    """The test of each robot: [robots] each."""

    central: Central
    deviation: Floats
    """Mean of the robot minus that of the central robots, in the unit of the parameter."""
    standard_error: Floats
    """Expected standard deviation of this deviation."""
    p_value: Floats
    """Two-sided."""


def central(means: RobotMeans) -> Central | None:
    """Fits a truncated normal distribution to the central robots.

    Returns None with fewer than ``FEWEST_ROBOTS`` robots.

    # Source
    Efron, Large-Scale Inference (2010), section 6.3: the empirical null by maximum likelihood.
    """
    if means.value.size < FEWEST_ROBOTS:
        return None
    mean = float(np.median(means.value))
    width = 1.4826 * float(np.median(np.abs(means.value - mean)))
    between = max(width**2 - float(np.median(means.variance)), 0.0) ** 0.5
    # The window may grow but not shrink: a chain of ever smaller windows would end far below the true scatter.
    window = between
    for _ in range(10):
        mean, between = _truncated(means, mean, window)
        if between <= window * (1.0 + 1e-3):
            break
        window = between
    sigma = np.sqrt(between**2 + means.variance)
    inside = np.abs(means.value - mean) <= WINDOW * sigma
    second, _ = _window_moments()
    information = float(np.sum(second / sigma[inside] ** 2))
    return Central(mean, information**-0.5, between, int(inside.sum()))


def test(means: RobotMeans) -> Tests | None:
    """Tests whether each robot belongs to the central ones; None with fewer than ``FEWEST_ROBOTS`` robots."""
    found = central(means)
    if found is None:
        return None
    sigma = np.sqrt(found.between**2 + means.variance)
    inside = np.abs(means.value - found.mean) <= WINDOW * sigma
    # Fisher information of the variance between robots, from the truncated distribution.
    _, spread = _window_moments()
    information = float(np.sum(spread / (4.0 * sigma[inside] ** 4)))
    robots = means.value.size
    freedom = 2.0 * sigma**4 * information * robots / (robots + FEW)
    error = np.sqrt(sigma**2 + found.mean_standard_error**2)
    deviation = means.value - found.mean
    p_value = 2.0 * stats.t.sf(np.abs(deviation) / error, np.maximum(freedom, 1.0))
    return Tests(found, deviation, error, np.asarray(p_value, dtype=np.float64))


def adjust(p_values: Sequence[Floats]) -> list[Floats]:
    """Adjusts the p-values of all parameters together by Benjamini and Hochberg.

    A robot is named at a rate of false discoveries q where its adjusted p-value is at most q.

    >>> [float(round(p, 3)) for p in adjust([np.array([0.01]), np.array([0.5])])[0]]
    [0.02]
    """
    if not p_values:
        return []
    together = np.concatenate(p_values)
    known = np.isfinite(together)
    adjusted = np.full(together.shape, np.nan)
    if known.any():
        adjusted[known] = stats.false_discovery_control(together[known])
    ends = np.cumsum([values.size for values in p_values])[:-1]
    return [np.asarray(part, dtype=np.float64) for part in np.split(adjusted, ends)]


def _window_moments() -> tuple[float, float]:
    """Returns E[z²] and Var[z²] of a standard normal variable truncated at ±``WINDOW``."""
    density = float(np.exp(-(WINDOW**2) / 2) / np.sqrt(2 * np.pi))
    inside = float(special.ndtr(WINDOW) - special.ndtr(-WINDOW))
    second = 1.0 - 2 * WINDOW * density / inside
    fourth = 3.0 * second - 2 * WINDOW**3 * density / inside
    return second, fourth - second**2


def _truncated(means: RobotMeans, mean: float, between: float) -> tuple[float, float]:
    """Maximises the likelihood of the robots inside the window about an earlier mean and scatter."""
    width = np.sqrt(between**2 + means.variance)
    inside = np.abs(means.value - mean) <= WINDOW * width
    if int(inside.sum()) < 3:
        return mean, between
    value, variance, half = means.value[inside], means.variance[inside], WINDOW * width[inside]
    scale = float(np.median(width))

    def cost(x: Floats) -> float:
        centre = mean + float(x[0]) * scale
        sigma = np.sqrt((float(x[1]) * scale) ** 2 + variance)
        high = special.ndtr((mean + half - centre) / sigma)
        low = special.ndtr((mean - half - centre) / sigma)
        mass = np.maximum(high - low, 1e-300)
        # The last term restricts the likelihood: it accounts for the estimated mean (Cox and Reid 1987).
        restricted = 0.5 * np.log(np.sum(1.0 / sigma**2))
        return float(np.sum(0.5 * ((value - centre) / sigma) ** 2 + np.log(sigma) + np.log(mass)) + restricted)

    # Nearly uniform values in the window would have any scatter: the bound keeps it near the median's.
    found = optimize.minimize(
        cost,
        np.array([0.0, between / scale]),
        method="L-BFGS-B",
        bounds=[(-1.0, 1.0), (0.0, 1.5)],
    )
    return mean + float(found.x[0]) * scale, float(found.x[1]) * scale
