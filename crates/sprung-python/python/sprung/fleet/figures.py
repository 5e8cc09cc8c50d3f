"""Figures of the report: inline SVG, drawn from numbers."""

from __future__ import annotations

import datetime
import html

import numpy as np

from .population import Moved, Population

_WIDTH, _HEIGHT = 360, 170
_LEFT, _RIGHT, _TOP, _BOTTOM = 56, 8, 8, 22
_STRIP_WIDTH, _STRIP_HEIGHT = 240, 34
_MOST_POINTS = 400


def strip(population: Population, named: set[str]) -> str:
    """The means of all robots on a line, outliers in another colour, the central 95 % as a band."""
    values = np.array([robot.value for robot in population.robots])
    low, high = float(values.min()), float(values.max())
    band = ""
    if population.central is not None:
        half = 1.96 * population.central.between
        low = min(low, population.central.mean - half)
        high = max(high, population.central.mean + half)
    span = (high - low) or abs(high) or 1.0

    def x(value: float) -> float:
        return 4 + (_STRIP_WIDTH - 8) * (value - low) / span

    if population.central is not None:
        left, right = (x(population.central.mean + sign * half) for sign in (-1, 1))
        band = f'<rect class="band" x="{left:.1f}" y="2" width="{right - left:.1f}" height="18"/>'
    # Thousands of robots: outliers, and the quantiles of the others.
    robots = sorted(population.robots, key=lambda robot: robot.value)
    plain = [robot for robot in robots if robot.robot not in named]
    if len(plain) > _MOST_POINTS:
        plain = [plain[int(k)] for k in np.linspace(0, len(plain) - 1, _MOST_POINTS)]
    points = []
    for number, robot in enumerate(plain):
        points.append(f'<circle class="point" fill-opacity="0.5" cx="{x(robot.value):.1f}" cy="{7 + number % 3 * 4}" r="2"/>')
    for robot in robots:
        if robot.robot in named:
            title = f"<title>{html.escape(robot.robot)}</title>"
            points.append(f'<circle class="named" cx="{x(robot.value):.1f}" cy="11" r="3.5">{title}</circle>')
    labels = (
        f'<text x="4" y="32">{low:.4g}</text>'
        f'<text x="{_STRIP_WIDTH - 4}" y="32" text-anchor="end">{high:.4g}</text>'
    )
    box = f'viewBox="0 0 {_STRIP_WIDTH} {_STRIP_HEIGHT}" width="{_STRIP_WIDTH}" height="{_STRIP_HEIGHT}"'
    return f'<svg {box} role="img" aria-label="means of the robots">{band}{"".join(points)}{labels}</svg>'


def series(moved: Moved) -> str:
    """The estimates of one robot over time with their errors, and the step with its interval, or the line."""
    estimates, drift = moved.series, moved.drift
    half = 1.96 * np.sqrt(estimates.variance)
    low, high = float((estimates.value - half).min()), float((estimates.value + half).max())
    start, end = float(estimates.time_s[0]), float(estimates.time_s[-1])

    def x(time: float) -> float:
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * (time - start) / (end - start)

    def y(value: float) -> float:
        return _TOP + (_HEIGHT - _TOP - _BOTTOM) * (high - value) / ((high - low) or 1.0)

    bottom = _HEIGHT - _BOTTOM
    marks = [f'<line class="axis" x1="{_LEFT}" x2="{_WIDTH - _RIGHT}" y1="{bottom}" y2="{bottom}"/>']
    if drift.shape == "step":
        left, right = x(drift.time_ci95_s[0]), x(drift.time_ci95_s[1])
        marks.append(
            f'<rect class="change" x="{left:.1f}" y="{_TOP}" width="{right - left:.1f}" height="{bottom - _TOP}"/>'
        )
        levels = [(start, drift.time_s, drift.before), (drift.time_s, end, drift.before + drift.change)]
        for first, last, level in levels:
            marks.append(_line("mean", x(first), y(level), x(last), y(level)))
    else:
        marks.append(_line("mean", x(start), y(drift.before), x(end), y(drift.before + drift.change)))
    for time, value, error in zip(estimates.time_s, estimates.value, half, strict=True):
        marks.append(_line("error", x(time), y(value - error), x(time), y(value + error)))
        marks.append(f'<circle class="point" cx="{x(time):.1f}" cy="{y(value):.1f}" r="3"/>')
    for value in (low, high):
        marks.append(f'<text x="{_LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:.4g}</text>')
    for time, anchor in ((start, "start"), (end, "end")):
        marks.append(f'<text x="{x(time):.1f}" y="{_HEIGHT - 6}" text-anchor="{anchor}">{_day(time)}</text>')
    box = f'viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}"'
    return f'<svg {box} role="img" aria-label="estimates over time">{"".join(marks)}</svg>'


def _line(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line class="{kind}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _day(time_s: float) -> str:
    return datetime.datetime.fromtimestamp(time_s, datetime.timezone.utc).strftime("%Y-%m-%d")
