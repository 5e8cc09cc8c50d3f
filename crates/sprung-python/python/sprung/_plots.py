"""Plots by matplotlib, with the colours of the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sprung import _sprung
from sprung._errors import InputError
from sprung._named import Named, nearest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from sprung._figure import Panels
    from sprung._parameters import Parameter
    from sprung._curves import Curves
    from sprung._result import Result

    Numbers = NDArray[np.float64]
    Sets = Named[Curves]

# Colours of the report: report.css.
_MODELS = ("#cc3311", "#0077bb", "#008575")
_CLOUD, _REFERENCE, _MEASURED = "#8b95a0", "#7a828a", "#1c2024"

# Heights, in.
_JOINT_HEIGHT, _PANEL_HEIGHT, _ROW_HEIGHT = 3.6, 1.7, 0.28

# An interval above this multiple of its value is shown in the unit of the parameter.
_MAX_RELATIVE = 10.0

# Units in the names of columns.
_UNITS = {"nm": "N·m", "n": "N", "rad": "rad", "m": "m"}


class Plots:
    """Plots of an identification.

    Each function draws on the axes ``ax``, or on a new figure of pyplot if they are absent, and returns the axes. A
    notebook shows a new figure once, at the end of the cell; a script shows it by ``pyplot.show()``. The image has an
    alternative text, which `alt_text` returns for any axes.
    """

    def __init__(self, result: Result) -> None:
        self._result = result

    def friction(self, joint: str, *, ax: Axes | None = None) -> Axes:
        """Plots the friction of a motor against its velocity, N·m over rad/s (N over m/s).

        Grey points are what the measured torque leaves for the friction; the curve is the model, with its 95 % interval.

        Raises:
            InputError: if there is no such joint, or its friction has no viscous part.
        """
        return self._joint(joint, 0, ax)

    def spring(self, joint: str, *, ax: Axes | None = None) -> Axes:
        """Plots the torque of a spring against its deflection, N·m over rad (N over m).

        Grey points are what the measured torque leaves for the spring; a loop of the points is hysteresis.

        Raises:
            InputError: if there is no such joint, or it is rigid.
        """
        return self._joint(joint, 1, ax)

    def residual(self, joint: str, *, ax: Axes | None = None) -> Axes:
        """Plots measured minus predicted filtered torque of a motor over time, N·m (N) over s.

        Raises:
            InputError: if there is no such joint.
        """
        return self._joint(joint, 2, ax)

    def spectrum(self, joint: str, *, ax: Axes | None = None) -> Axes:
        """Plots the power density of the residual of a motor, dB of (N·m)²/Hz over Hz.

        Raises:
            InputError: if there is no such joint, or the log is too short.
        """
        return self._joint(joint, 3, ax)

    def fit(self, *, ax: Panels | None = None) -> NDArray[np.object_]:
        """Plots measured and predicted filtered torques and deflections over time, one panel for each, N·m, rad (N, m).

        Args:
            ax: axes, one per panel: torques of all motors, then deflections.

        Returns:
            axes, one per panel.
        """
        from sprung import _figure

        sets = self._filtered()
        names = [name for name in _columns(sets) if ".motor_" in name or ".deflection_" in name]
        axes = _over_time(sets, names, ax, first=0)
        for axis, name in zip(axes, names, strict=True):
            what, unit = _quantity(name)
            axis.set_ylabel(f"{what}\n[{unit}]")
            _figure.describe(axis, _differences(f"{what} [{unit}]", sets, name))
        return axes

    def trace(self, *names: str, ax: Panels | None = None) -> NDArray[np.object_]:
        """Plots estimates over time with growing parts of the log.

        The first estimates, of few samples, may lie outside of the axis.

        Args:
            names: parameters; all if none is given.
            ax: axes, one per parameter.

        Returns:
            axes, one per parameter.

        Raises:
            InputError: if there is no such parameter.
        """
        from sprung import _figure

        sets = self._traces()
        known = _columns(sets)
        chosen = [_column(name, known) for name in names] or known
        units = {parameter.name: parameter.unit for parameter in self._result.parameters.values()}
        axes = _over_time(sets, chosen, ax, first=1)
        for axis, name in zip(axes, chosen, strict=True):
            own_unit = units.get(name, "")
            axis.set_ylabel(name.replace(".", "\n", 1) + (f"\n[{own_unit}]" if own_unit else ""))
            _limit_to_second_half(axis, [curves[name] for curves in sets.values()])
            last = ", ".join(f"{label} {_last(curves[name]):.4g}" for label, curves in sets.items())
            _figure.describe(axis, f"Estimate of {name} over time. At the end: {last} {own_unit}.")
        return axes

    def parameters(self, *, ax: Axes | None = None) -> Axes:
        """Plots the 95 % intervals of all determined parameters relative to their values, %.

        The axis shows most intervals whole, and at most ±100 %. An arrow marks an interval that goes beyond it; the
        number at the right is half its width, in the unit of the parameter if the value is nearly zero.

        Raises:
            InputError: if the estimator has no intervals.
        """
        from sprung import _figure

        rows = [
            parameter
            for parameter in self._result.parameters.values()
            if parameter.value is not None and parameter.ci95
        ]
        if not rows:
            raise InputError(
                f"{self._result.estimator} has no intervals",
                "plot",
                f"plot those of one of {', '.join(self._result.estimators)}: result.by(name).plot",
            )
        limit = 100.0 * _sprung.relative_scale(self._result._handle, self._result._index)
        axes = _figure.panel(ax, 0.9 + _ROW_HEIGHT * len(rows))
        for place, parameter in enumerate(rows):
            _interval(axes, place, parameter, limit)
        axes.set_yticks(np.arange(len(rows)), [_value(parameter) for parameter in rows])
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(-1.08 * limit, 1.08 * limit)
        axes.set_xlabel("95 % interval [% of the value]")
        axes.axvline(0.0, color=_REFERENCE, linewidth=0.8, zorder=0)
        axes.grid(axis="x", alpha=0.3)
        listed = "; ".join(f"{_value(parameter)}, {_half_width(parameter)}" for parameter in rows)
        _figure.describe(axes, f"95 % intervals of {len(rows)} parameters: {listed}.")
        return axes

    @staticmethod
    def alt_text(axes: Panels) -> str:
        """Returns the text that describes plots to a reader who does not see them, one line per axes."""
        from sprung import _figure

        return _figure.alt_text(axes)

    def _filtered(self) -> Sets:
        return _with_curves(self._result.fit_curves, "fit.csv")

    def _traces(self) -> Sets:
        return _with_curves(self._result.trace, "trace.csv")

    def _joint(self, joint: str, place: int, ax: Axes | None) -> Axes:
        from sprung import _figure

        joints = self._result._experiment._session.joints
        if joint not in joints:
            raise InputError(
                f"there is no joint {joint!r}{nearest(joint, joints)}",
                "joint",
                f"give one of {', '.join(joints)}",
            )
        figures = _sprung.joint_figures(self._result._handle, self._result._index, joint)
        figure = figures[place]
        if figure is None:
            self._filtered()
            raise self._absent(joint, place)
        axes = _figure.panel(ax, _JOINT_HEIGHT)
        _draw(axes, figure, joint)
        return axes

    def _absent(self, joint: str, place: int) -> InputError:
        """Returns the error about a figure that a joint does not have."""
        first = self._result.estimators[0]
        if place < 2 and self._result._index > 0:
            return InputError(
                "only the first estimator has curves of frictions and springs",
                "estimator",
                f"plot those of {first}: result.by({first!r}).plot",
            )
        if place == 0:
            return InputError(
                f"the friction of {joint} has no viscous part, so it has no velocity to be drawn against",
                "joint",
                "plot the residual, or give the joint viscous friction",
            )
        if place == 1:
            bounds = {rigid.joint: rigid.stiffness_above_nm_per_rad for rigid in self._result.rigid_joints}
            bound = f"; its stiffness is above {bounds[joint]:.3g} N·m/rad" if joint in bounds else ""
            return InputError(
                f"{joint} is rigid in this result, so it has no spring{bound}", "joint", "plot its friction"
            )
        what = "residual of its motor" if place == 2 else "spectrum, because the log is too short"
        return InputError(f"{joint} has no {what}", "joint", "plot result.plot.fit()")


def _with_curves(sets: Sets, file: str) -> Sets:
    if not _columns(sets):
        raise InputError(
            "the result has no curves over time", "plot", f"identify, or load a folder that contains {file}"
        )
    return sets


def _columns(sets: Sets) -> list[str]:
    return [name for name in next(iter(sets.values()), {}) if name != "t"]


def _column(name: str, known: list[str]) -> str:
    if name in known:
        return name
    # The columns of the file end in their units.
    found = [
        column for column in known if column.startswith(f"{name}_") or column.startswith(f"{name} ")
    ]
    if len(found) == 1:
        return found[0]
    raise InputError(
        f"there is no trace of {name!r}{nearest(name, known)}", "parameter", f"give {', '.join(known)}"
    )


def _quantity(column: str) -> tuple[str, str]:
    """Returns the quantity of a column of the fit and its unit."""
    what, _, unit = column.rpartition("_")
    joint, _, kind = what.rpartition(".")
    words = {"motor": "motor force" if unit == "n" else "motor torque"}
    return f"{joint} {words.get(kind, kind)}", _UNITS.get(unit, unit)


def _over_time(sets: Sets, names: list[str], ax: Panels | None, first: int) -> NDArray[np.object_]:
    """Draws curves over time, one panel for each name.

    Args:
        first: place of the first curve: 0 for the measured one, which is below the models.
    """
    from sprung import _figure

    axes = _figure.panels(len(names), ax, 0.8 + _PANEL_HEIGHT * len(names))
    for axis, name in zip(axes, names, strict=True):
        for place, (label, curves) in enumerate(sets.items(), first):
            color = _MEASURED if place == 0 else _MODELS[(place - 1) % len(_MODELS)]
            style = "-" if place < 2 else ("--", "-.", ":")[(place - 2) % 3]
            width = 2.2 if place == 0 else 1.2
            axis.plot(curves["t"], curves[name], style, label=label, color=color, linewidth=width)
        axis.grid(alpha=0.3)
    lines = axes[0].get_lines()
    if len(lines) > 1:
        # Above the panel, where it covers no curve.
        axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(lines), frameon=False)
    axes[-1].set_xlabel("time [s]")
    return axes


def _limit_to_second_half(axes: Axes, curves: list[Numbers]) -> None:
    """Limits the axis to the second half of the curves, and as much again on both sides."""
    seen = np.concatenate([curve[len(curve) // 2 :] for curve in curves])
    seen = seen[np.isfinite(seen)]
    if not len(seen):
        return
    low, high = float(seen.min()), float(seen.max())
    margin = max(high - low, 0.05 * abs(high)) or 1.0
    bottom, top = axes.get_ylim()
    axes.set_ylim(max(bottom, low - margin), min(top, high + margin))


def _last(values: Numbers) -> float:
    known = values[np.isfinite(values)]
    return float(known[-1]) if len(known) else float("nan")


def _range(values: Numbers) -> str:
    known = values[np.isfinite(values)]
    return f"{known.min():.3g} to {known.max():.3g}" if len(known) else "none"


def _differences(what: str, sets: Sets, name: str) -> str:
    """Returns in words how far the models are from the measured curve."""
    (_, measured), *models = sets.items()
    parts = [f"{what} over time, {_range(measured['t'])} s: measured {_range(measured[name])}"]
    for label, curves in models:
        if len(curves["t"]) == len(measured["t"]):
            difference = np.abs(curves[name] - measured[name])
            difference = difference[np.isfinite(difference)]
            if len(difference):
                parts.append(f"largest difference of {label} {difference.max():.2g}")
    return "; ".join(parts) + "."


def _value(parameter: Parameter) -> str:
    return f"{parameter.name} = {parameter.value:.4g} {parameter.unit}".rstrip()


def _half_width(parameter: Parameter) -> str:
    """Returns half the width of an interval in words, as the report."""
    assert parameter.value is not None and parameter.ci95 is not None
    low, high = parameter.ci95
    if parameter.one_sided:
        return f"< {_two_digits(high)} {parameter.unit}".rstrip()
    half = 0.5 * (high - low)
    if half > _MAX_RELATIVE * abs(parameter.value):
        return f"± {_two_digits(half)} {parameter.unit}".rstrip()
    return f"± {_two_digits(100.0 * half / abs(parameter.value))} %"


def _two_digits(value: float) -> str:
    return f"{value:.0f}" if 10.0 <= abs(value) < 1e4 else f"{value:#.2g}"


def _interval(axes: Axes, place: int, parameter: Parameter, limit: float) -> None:
    """Draws the interval of a parameter in percent of its value, with arrows at the limit where it goes beyond."""
    assert parameter.value is not None and parameter.ci95 is not None
    if parameter.value:
        low, high = sorted(100.0 * (end / parameter.value - 1.0) for end in parameter.ci95)
    else:
        low, high = (np.inf * end if end else 0.0 for end in parameter.ci95)
    is_beyond = low < -limit or high > limit
    color = _MODELS[0]
    axes.plot([max(low, -limit), min(high, limit)], [place, place], "-", color=color, linewidth=1.5)
    axes.plot([0.0], [place], "o", color=color, markersize=5)
    for end, edge, arrow in ((low, -limit, "<"), (high, limit, ">")):
        if abs(end) > limit:
            axes.plot([edge], [place], arrow, color=color, markersize=7)
        else:
            axes.plot([end], [place], "|", color=color, markersize=7)
    axes.annotate(
        _half_width(parameter),
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(6, 0),
        textcoords="offset points",
        va="center",
        annotation_clip=False,
        fontweight="bold" if is_beyond else "normal",
    )


def _draw(axes: Axes, figure: _sprung.Figure, joint: str) -> None:
    """Draws a figure of the report: points, curves, and an interval between two curves."""
    from sprung import _figure

    caption, (x_label, y_label), x, series = figure
    bounds = [values for _, style, values in series if style == "reference"]
    has_points = any(style == "cloud" for _, style, _ in series)
    words = []
    for name, style, values in series:
        if style == "cloud":
            axes.plot(x, values, ".", label=name, color=_CLOUD, markersize=4)
        elif style == "first":
            # The curve in a cloud has values at a few places; gaps over time stay gaps.
            seen = np.isfinite(values) if has_points else slice(None)
            axes.plot(x[seen], values[seen], label=name, color=_MODELS[0], linewidth=1.5, zorder=3)
        if style != "reference":
            words.append(f"{name} {_range(values)}")
    if len(bounds) == 2:
        seen = np.isfinite(bounds[0]) & np.isfinite(bounds[1])
        low, high = (bound[seen] for bound in bounds)
        label = "95 % interval"
        axes.fill_between(
            x[seen], low, high, color=_MODELS[0], alpha=0.25, linewidth=0, label=label, zorder=2
        )
        words.append(f"{label} up to ± {_two_digits(0.5 * float(np.max(high - low)))}")
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.set_title(joint if has_points else f"{joint}, {series[0][0]}", loc="left", fontsize="medium")
    axes.grid(alpha=0.3)
    if has_points:
        axes.legend(loc="best", fontsize="small")
    text = f"{caption} Horizontal: {x_label}, {_range(x)}. Vertical: {y_label}: {', '.join(words)}."
    _figure.describe(axes, text)
