"""Axes and figures of matplotlib with an alternative text, for readers who do not see them."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from sprung._errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Axes of one or more panels, as pyplot.subplots returns them.
Panels: TypeAlias = "Axes | Sequence[Axes] | NDArray[np.object_]"

# Width of a figure, in.
_WIDTH = 8.0


def _notebook_html(figure: Figure) -> str | None:
    """Returns the image that a notebook shows, with the texts of its axes; ``None`` outside of notebooks."""
    inherited = Figure._repr_html_(figure)
    image = _notebook_image(figure) if inherited is None else None
    if image is None:
        return inherited
    data, size = image
    text = html.escape(alt_text(figure.axes), quote=True)
    if data.lstrip().startswith("<"):
        return f'<div role="img" aria-label="{text}">{data}</div>'
    sizes = "".join(f' {name}="{size[name]}"' for name in ("width", "height") if name in size)
    return f'<img alt="{text}"{sizes} src="data:image/png;base64,{data}">'


def _notebook_image(figure: Figure) -> tuple[str, dict[str, Any]] | None:
    """Returns the PNG in Base64 or the SVG of a figure in the settings of the notebook, and its size."""
    try:
        from IPython import get_ipython
    except ImportError:
        return None
    shell = get_ipython()
    if shell is None:
        return None
    for kind in ("image/png", "image/svg+xml"):
        found = shell.display_formatter.formatters[kind](figure)
        data, size = found if isinstance(found, tuple) else (found, {})
        if data is not None:
            return (data if isinstance(data, str) else b64encode(data).decode()), size
    return None


def panels(count: int, ax: Panels | None, height: float) -> NDArray[np.object_]:
    """Returns axes to draw on: the given ones, or those of a new figure of pyplot, one below the other.

    Args:
        count: number of panels.
        height: height of a new figure, in.
    """
    if ax is None:
        from matplotlib import pyplot

        _, made = pyplot.subplots(
            count,
            1,
            sharex=True,
            squeeze=False,
            figsize=(_WIDTH, height),
            layout="constrained",
        )
        column: NDArray[np.object_] = made[:, 0]
        return column
    given = np.ravel(np.asarray(ax, dtype=object))
    for axis in given:
        if not isinstance(axis, Axes):
            raise InputError(f"ax is {axis!r}", "ax", "give Axes of matplotlib")
    if len(given) != count:
        raise InputError(
            f"ax has {len(given)} axes for {count} panels",
            "ax",
            f"give {count}, for example those of pyplot.subplots({count}, 1)",
        )
    return given


def panel(ax: Axes | None, height: float) -> Axes:
    """Returns axes to draw on: the given ones, or those of a new figure."""
    (axes,) = panels(1, ax, height)
    assert isinstance(axes, Axes)
    return axes


def describe(axes: Axes, text: str) -> None:
    """Gives axes an alternative text; a second plot on the same axes adds its own."""
    before = _text_of(axes)
    setattr(axes, "_sprung_alt_text", f"{before} {text}" if before else text)
    figure = axes.get_figure()
    if isinstance(figure, SubFigure):
        figure = figure.figure
    if type(figure) is Figure:
        # JupyterLab and nbconvert show a PNG without alternative text, whatever its metadata are; they prefer HTML.
        setattr(figure, "_repr_html_", partial(_notebook_html, figure))


def alt_text(axes: Panels) -> str:
    """Returns the alternative texts of axes, one in a line."""
    texts = [_text_of(axis) for axis in np.ravel(np.asarray(axes, dtype=object))]
    return "\n".join(text for text in texts if text)


def _text_of(axes: Axes) -> str:
    return str(getattr(axes, "_sprung_alt_text", ""))
