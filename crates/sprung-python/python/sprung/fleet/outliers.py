"""Robots that are outliers in a population, with a controlled rate of false discoveries.

A few defective robots widen the scatter of all and mask each other. The mean and the scatter of the test are
therefore those of the central robots: a normal distribution that is truncated at ``WINDOW`` standard deviations.
The test uses Student's t, because mean and scatter are estimated.

Robots with one motion, one sensor and one model share a part of their errors. Their standard errors contain it, but it
does not make them differ: the central robots then scatter less than their standard errors. The independent part of
the variance of each robot is also estimated from their scatter.
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
    own_part: float
    """Part of the variance of the estimates that each robot has on its own; below 1 only where the central robots
    scatter less than their standard errors, and then ``between`` is 0."""
    robots: int
    """Robots inside the window."""

    def sigma(self, variance: Floats) -> Floats:
        """The standard deviation of robots whose estimates have a variance: [robots] each."""
        return np.sqrt(self.between**2 + self.own_part * variance)


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
    scale = _Scale(means.variance, width)
    spread = scale.of(width)
    # The window may grow but not shrink: a chain of ever smaller windows would end far below the true scatter.
    window = spread
    for _ in range(10):
        mean, spread = _truncated(means, scale, mean, window)
        if spread <= window + 1e-3 * (1.0 + abs(window)):
            break
        window = spread
    sigma = scale.sigma(spread)
    inside = np.abs(means.value - mean) <= WINDOW * sigma
    second, _ = _window_moments()
    information = float(np.sum(second / sigma[inside] ** 2))
    between, own_part = scale.parts(spread)
    return Central(mean, information**-0.5, between, own_part, int(inside.sum()))


def test(means: RobotMeans) -> Tests | None:
    """Tests whether each robot belongs to the central ones; None with fewer than ``FEWEST_ROBOTS`` robots."""
    found = central(means)
    if found is None:
        return None
    sigma = found.sigma(means.variance)
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


LEAST_OWN_PART = 1e-6
"""Least part of the variance that is a robot's own: the roundings of a motion differ even if all else is shared."""


class _Scale:
    """One number for the scatter of robots: positive for scatter beyond their standard errors, in their unit; negative
    where they scatter less, the logarithm of the part of their standard errors that remains."""

    def __init__(self, variance: Floats, width: float) -> None:
        self.variance = variance
        self.typical = float(np.median(variance))
        self.unit = max(self.typical**0.5, width, np.finfo(float).tiny)
        self.least = 0.5 * float(np.log(LEAST_OWN_PART)) if self.typical > 0.0 else 0.0

    def of(self, width: float) -> float:
        """The number for the standard deviation of a typical robot."""
        if width**2 >= self.typical:
            return float((width**2 - self.typical) ** 0.5 / self.unit)
        return float(max(np.log(max(width, np.finfo(float).tiny)) - 0.5 * np.log(self.typical), self.least))

    def parts(self, spread: float) -> tuple[float, float]:
        """The standard deviation between robots, and the part of the variance that is their own."""
        return max(spread, 0.0) * self.unit, float(np.exp(2.0 * min(spread, 0.0)))

    def sigma(self, spread: float) -> Floats:
        between, own_part = self.parts(spread)
        return np.sqrt(between**2 + own_part * self.variance)


def _truncated(means: RobotMeans, scale: _Scale, mean: float, spread: float) -> tuple[float, float]:
    """Maximises the likelihood of the robots inside the window about an earlier mean and scatter."""
    width = scale.sigma(spread)
    inside = np.abs(means.value - mean) <= WINDOW * width
    if int(inside.sum()) < 3:
        return mean, spread
    value, half = means.value[inside], WINDOW * width[inside]
    unit = float(np.median(width))

    def cost(x: Floats) -> float:
        centre = mean + float(x[0]) * unit
        sigma = scale.sigma(float(x[1]))[inside]
        high = special.ndtr((mean + half - centre) / sigma)
        low = special.ndtr((mean - half - centre) / sigma)
        mass = np.maximum(high - low, 1e-300)
        # The last term restricts the likelihood: it accounts for the estimated mean (Cox and Reid 1987).
        restricted = 0.5 * np.log(np.sum(1.0 / sigma**2))
        return float(np.sum(0.5 * ((value - centre) / sigma) ** 2 + np.log(sigma) + np.log(mass)) + restricted)

    # Nearly uniform values in the window would have any scatter: the bound keeps it near the median's.
    widest = 1.5 * unit
    bound = widest / scale.unit if widest**2 >= scale.typical else scale.of(widest)
    found = optimize.minimize(
        cost,
        np.array([0.0, spread]),
        method="L-BFGS-B",
        bounds=[(-1.0, 1.0), (scale.least, max(bound, spread))],
    )
    return mean + float(found.x[0]) * unit, float(found.x[1])
