"""Between-robot and within-robot scatter of one parameter: random effects with two levels.

The estimate of log k of robot i is ``y_ik = m + b_i + w_ik + e_ik``. The robot differs from the mean by
``b_i ~ N(0, between²)``, the log from its robot by ``w_ik ~ N(0, within²)``, and the estimate from the
parameter during the log by ``e_ik ~ N(0, standard_error²)``, where the standard error is that of the
identification. Restricted maximum likelihood gives both scatters; DerSimonian and Laird's moments check them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special

Floats: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.intp]

CONFIDENCE = 0.95
"""Probability of all intervals."""


@dataclass(frozen=True)
class Estimates:
    """Estimates of one parameter, sorted by robot. All values are in the unit of the parameter.

    Use :meth:`of` to make them: it sorts and checks.
    """

    robot: Integers
    """[n] number of the robot, from 0, ascending."""
    value: Floats
    """[n]"""
    standard_error: Floats
    """[n] of the identification."""

    @classmethod
    def of(cls, robot: ArrayLike, value: ArrayLike, standard_error: ArrayLike) -> Estimates:
        """Sorts and checks estimates.

        - robot: [n] names or numbers; they are numbered in ascending order.
        - value, standard_error: [n] in the unit of the parameter; not negative errors, finite.

        Raises ValueError if lengths differ, a value is not finite or a standard error is negative.

        >>> Estimates.of(["b", "a"], [2.0, 1.0], [0.1, 0.1]).value.tolist()
        [1.0, 2.0]
        """
        names = np.asarray(robot)
        values = np.asarray(value, dtype=np.float64)
        errors = np.asarray(standard_error, dtype=np.float64)
        if not names.shape == values.shape == errors.shape or values.ndim != 1:
            shapes = f"{names.shape}, {values.shape} and {errors.shape}"
            raise ValueError(f"robot, value and standard_error need one common length; they have {shapes}")
        if values.size == 0:
            raise ValueError("there is no estimate")
        if not (np.isfinite(values).all() and np.isfinite(errors).all() and (errors >= 0).all()):
            raise ValueError("values and standard errors need to be finite, standard errors not negative")
        numbers = np.unique(names, return_inverse=True)[1].astype(np.intp)
        order = np.argsort(numbers, kind="stable")
        return cls(numbers[order], values[order], errors[order])

    @property
    def robots(self) -> int:
        """The number of robots."""
        return int(self.robot[-1]) + 1

    def sums(self, terms: Floats) -> Floats:
        """Sums [n] terms of each robot: [robots]."""
        return np.bincount(self.robot, weights=terms, minlength=self.robots).astype(np.float64)


@dataclass(frozen=True)
class Scatter:
    """Mean and scatter of a parameter in a population, in the unit of the parameter."""

    robots: int
    logs: int
    mean: float
    mean_standard_error: float
    """With the factor of Knapp and Hartung, for t with robots - 1 degrees of freedom."""
    mean_ci95: tuple[float, float]
    between: float
    """Standard deviation between robots; NaN with one robot."""
    between_ci95: tuple[float, float]
    """Profile likelihood."""
    within: float
    """Standard deviation between the logs of one robot, without the standard errors; NaN if no robot has two."""
    within_ci95: tuple[float, float]
    between_dl: float
    """Between robots by the moments of DerSimonian and Laird."""
    within_dl: float
    expected: float
    """Root mean square of the standard errors of the identifications."""


@dataclass(frozen=True)
class RobotMeans:
    """The weighted mean of the logs of each robot: [robots] each, in the unit of the parameter."""

    value: Floats
    variance: Floats
    """Of the mean about the robot's parameter, from scatter within robots and standard errors."""
    logs: Integers


def robot_means(estimates: Estimates, within: float) -> RobotMeans:
    """Returns the mean of each robot for a scatter within robots (NaN counts as zero)."""
    weight = 1.0 / variances(estimates, within)
    total = estimates.sums(weight)
    mean = estimates.sums(weight * estimates.value) / total
    logs = np.bincount(estimates.robot, minlength=estimates.robots).astype(np.intp)
    return RobotMeans(mean, 1.0 / total, logs)


def scatter(estimates: Estimates) -> Scatter:
    """Estimates mean and scatters by restricted maximum likelihood.

    # Source
    Patterson and Thompson, Biometrika 58 (1971), 545; profile intervals as in Viechtbauer, Statistics in
    Medicine 26 (2007), 37; Knapp and Hartung, Statistics in Medicine 22 (2003), 2693; DerSimonian and Laird,
    Controlled Clinical Trials 7 (1986), 177, applied to both levels.
    """
    likelihood = _Likelihood(estimates)
    between, within = likelihood.maximum()
    mean, error = likelihood.mean(between, within)
    robots = estimates.robots
    t = float(special.stdtrit(robots - 1, (1 + CONFIDENCE) / 2)) if robots > 1 else float("nan")
    between_dl, within_dl = moments(estimates)
    nan = float("nan")
    return Scatter(
        robots=robots,
        logs=int(estimates.value.size),
        mean=mean,
        mean_standard_error=error,
        mean_ci95=(mean - t * error, mean + t * error),
        between=between if likelihood.has_between else nan,
        between_ci95=likelihood.interval(0, (between, within)) if likelihood.has_between else (nan, nan),
        within=within if likelihood.has_within else nan,
        within_ci95=likelihood.interval(1, (between, within)) if likelihood.has_within else (nan, nan),
        between_dl=between_dl,
        within_dl=within_dl,
        expected=float(np.sqrt(np.mean(estimates.standard_error**2))),
    )


def moments(estimates: Estimates) -> tuple[float, float]:
    """Returns the scatters between and within robots by the moments of DerSimonian and Laird.

    NaN where the estimates do not determine one.
    """
    robots, logs = estimates.robots, estimates.value.size
    within = float("nan")
    if logs > robots:
        weight = 1.0 / variances(estimates, 0.0)
        total = estimates.sums(weight)
        mean = estimates.sums(weight * estimates.value) / total
        square = float(np.sum(weight * (estimates.value - mean[estimates.robot]) ** 2))
        slope = float(np.sum(total - estimates.sums(weight**2) / total))
        within = max(0.0, (square - (logs - robots)) / slope) ** 0.5
    if robots == 1:
        return float("nan"), within
    means = robot_means(estimates, within)
    weight = 1.0 / means.variance
    total_of_all = weight.sum()
    mean_of_all = np.sum(weight * means.value) / total_of_all
    square = float(np.sum(weight * (means.value - mean_of_all) ** 2))
    slope = float(total_of_all - np.sum(weight**2) / total_of_all)
    return max(0.0, (square - (robots - 1)) / slope) ** 0.5, within


def variances(estimates: Estimates, within: float) -> Floats:
    """Returns the variance [n] of each estimate about the parameter of its robot.

    - within: scatter within robots; NaN counts as zero.
    """
    variance = (0.0 if np.isnan(within) else within**2) + estimates.standard_error**2
    # Estimates without errors and without scatter would have infinite weights.
    floor = 1e-24 * max(float(np.mean(estimates.value**2)), np.finfo(float).tiny)
    return np.maximum(variance, floor)


class _Likelihood:
    """The restricted likelihood of both scatters. The search uses scatters relative to the scatter of all values."""

    def __init__(self, estimates: Estimates) -> None:
        self.estimates = estimates
        self.has_between = estimates.robots > 1
        self.has_within = estimates.value.size > estimates.robots
        spread = float(np.std(estimates.value))
        self.scale = spread if spread > 0 else max(float(np.max(estimates.standard_error)), 1e-12)

    def cost(self, between: float, within: float) -> float:
        """Minus twice the restricted log-likelihood, without its constant."""
        estimates = self.estimates
        weight = 1.0 / variances(estimates, within)
        total = estimates.sums(weight)
        means = estimates.sums(weight * estimates.value) / total
        inside = weight * (estimates.value - means[estimates.robot]) ** 2
        precision = total / (1.0 + between**2 * total)
        mean = np.sum(precision * means) / precision.sum()
        return float(
            -np.sum(np.log(weight))
            + np.sum(np.log1p(between**2 * total))
            + inside.sum()
            + np.sum(precision * (means - mean) ** 2)
            + np.log(precision.sum())
        )

    def mean(self, between: float, within: float) -> tuple[float, float]:
        """Returns the mean and its standard error by Knapp and Hartung (NaN with one robot)."""
        means = robot_means(self.estimates, within)
        precision = 1.0 / (between**2 + means.variance)
        mean = float(np.sum(precision * means.value) / precision.sum())
        if not self.has_between:
            return mean, float(np.sqrt(1.0 / precision.sum()))
        square = np.sum(precision * (means.value - mean) ** 2) / (self.estimates.robots - 1)
        return mean, float(np.sqrt(square / precision.sum()))

    def maximum(self) -> tuple[float, float]:
        """Returns the scatters between and within robots; zero where they are not determined."""
        between, within = (0.0 if np.isnan(value) else value / self.scale for value in moments(self.estimates))
        found = [
            (self.cost(0.0, 0.0), 0.0, 0.0),
            self._along(lambda x: (x, 0.0), self.has_between),
            self._along(lambda x: (0.0, x), self.has_within),
        ]
        if self.has_between and self.has_within:
            best = optimize.minimize(
                self._relative,
                np.array([max(between, 0.1), max(within, 0.1)]),
                method="Nelder-Mead",
                options={"xatol": 1e-6, "fatol": 1e-8, "maxiter": 500},
            )
            between, within = np.abs(best.x) * self.scale
            found.append((float(best.fun), float(between), float(within)))
        return min(found)[1:]

    def _relative(self, scatters: Floats) -> float:
        return self.cost(abs(float(scatters[0])) * self.scale, abs(float(scatters[1])) * self.scale)

    def _along(self, point: Callable[[float], tuple[float, float]], free: bool) -> tuple[float, float, float]:
        """Minimises the cost along one scatter, with the other one zero."""
        if not free:
            return float("inf"), 0.0, 0.0
        found = optimize.minimize_scalar(
            lambda x: self.cost(*point(float(x))), bounds=(0.0, 4.0 * self.scale), method="bounded"
        )
        return float(found.fun), *point(float(found.x))

    def interval(self, which: int, found: tuple[float, float]) -> tuple[float, float]:
        """Returns the profile interval of one scatter (0 between, 1 within robots) about the maximum."""
        best = self.cost(*found)
        level = float(special.chdtri(1, 1 - CONFIDENCE))
        other_free = self.has_within if which == 0 else self.has_between
        bounds = (0.0, 2.0 * found[1 - which] + 0.2 * self.scale)

        def excess(scatter: float) -> float:
            def cost(other: float) -> float:
                return self.cost(scatter, other) if which == 0 else self.cost(other, scatter)

            if not other_free:
                return cost(0.0) - best - level
            inner = optimize.minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-3 * self.scale})
            return min(float(inner.fun), cost(0.0)) - best - level

        value = found[which]
        low = 0.0 if excess(0.0) <= 0 else optimize.brentq(excess, 0.0, value, rtol=1e-3, xtol=1e-4 * self.scale)
        high = max(value, self.scale * 1e-3)
        while excess(high) < 0:
            high *= 2.0
            if high > 1e6 * self.scale:
                return float(low), float("inf")
        return float(low), float(optimize.brentq(excess, value, high, rtol=1e-3, xtol=1e-4 * self.scale))
