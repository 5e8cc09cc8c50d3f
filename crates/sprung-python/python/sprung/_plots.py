"""Plots by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sprung._errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sprung._result import Result


class Plots:
    """Plots of an identification; each returns a figure of matplotlib."""

    def __init__(self, result: Result) -> None:
        self._result = result

    def fit(self) -> Figure:
        """Plots measured and predicted filtered torques over time, one axis per row, N·m (N)."""
        sets = self._result.fit_curves
        names = [name for name in next(iter(sets.values()), {}) if name != "t"]
        figure, axes = _figure(len(names))
        for axis, name in zip(axes, names, strict=True):
            for label, own in sets.items():
                axis.plot(own["t"], own[name], label=label, linewidth=1.0)
            axis.set_ylabel(name)
        axes[0].legend(loc="upper right")
        axes[-1].set_xlabel("time, s")
        return figure

    def trace(self, *names: str) -> Figure:
        """Plots estimates over time with growing parts of the log; all parameters if none is named."""
        sets = self._result.trace
        known = [name for name in next(iter(sets.values()), {}) if name != "t"]
        chosen = [self._column(name, known) for name in names] or known
        figure, axes = _figure(len(chosen))
        for axis, name in zip(axes, chosen, strict=True):
            for label, own in sets.items():
                axis.plot(own["t"], own[name], label=label, linewidth=1.0)
            axis.set_ylabel(name)
        axes[0].legend(loc="upper right")
        axes[-1].set_xlabel("time, s")
        return figure

    def parameters(self) -> Figure:
        """Plots the relative 95 % intervals of all determined parameters, %."""
        rows = [
            (own.name, own.value, own.ci95)
            for own in self._result.parameters.values()
            if own.value and own.ci95
        ]
        figure, (axis,) = _figure(1, height=0.6 + 0.28 * len(rows))
        places = np.arange(len(rows))
        for place, (_, value, ci95) in zip(places, rows, strict=True):
            half = 50.0 * (ci95[1] - ci95[0]) / abs(value)
            axis.errorbar(0.0, place, xerr=half, fmt="o", capsize=3, color="tab:blue")
        axis.set_yticks(places, [f"{name} = {value:.4g}" for name, value, _ in rows])
        axis.invert_yaxis()
        axis.set_xlabel("95 % interval, % of the value")
        axis.grid(axis="x", alpha=0.3)
        return figure

    @staticmethod
    def _column(name: str, known: list[str]) -> str:
        if name in known:
            return name
        # The columns of the file end in their units.
        found = [own for own in known if own.startswith(f"{name}_") or own.startswith(f"{name} ")]
        if len(found) == 1:
            return found[0]
        raise InputError(f"there is no trace of {name!r}", "parameter", f"give {', '.join(known)}")


def _figure(count: int, height: float | None = None) -> tuple[Figure, list[Axes]]:
    from matplotlib import pyplot

    size = (8.0, height if height is not None else 0.8 + 1.7 * max(count, 1))
    figure, axes = pyplot.subplots(
        max(count, 1), 1, sharex=True, figsize=size, squeeze=False, layout="constrained"
    )
    all_axes: list[Any] = list(axes[:, 0])
    return figure, all_axes
