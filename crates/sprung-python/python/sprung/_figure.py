"""Figures of matplotlib with an alternative text, for readers who do not see them."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sprung._errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

# Axes of several panels, as pyplot.subplots returns them.
Panels: TypeAlias = "Axes | Sequence[Axes] | NDArray[np.object_]"

# Width of a figure, in.
_WIDTH = 8.0


class DescribedFigure(Figure):
    """A figure whose image in a notebook has an alternative text."""

    @property
    def alt_text(self) -> str:
        """The texts of all axes, one in a line."""
        return alt_text(self.axes)

    def _repr_html_(self) -> str | None:
        # JupyterLab and nbconvert show a PNG without alternative text, whatever its metadata are.
        image = _notebook_image(self)
        if image is None:
            return None
        data, size = image
        text = html.escape(self.alt_text, quote=True)
        if data.lstrip().startswith("<"):
            return f'<div role="img" aria-label="{text}">{data}</div>'
        sizes = "".join(f' {name}="{size[name]}"' for name in ("width", "height") if name in size)
        return f'<img alt="{text}"{sizes} src="data:image/png;base64,{data}">'

    def __repr__(self) -> str:
        # VS Code takes the text beside an image for its alternative text.
        return self.alt_text or super().__repr__()


def _notebook_image(figure: Figure) -> tuple[str, dict[str, Any]] | None:
    """Returns the PNG in Base64 or the SVG that the notebook shows, with its size; ``None`` outside of notebooks."""
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
            FigureClass=DescribedFigure,
            figsize=(_WIDTH, height),
            layout="constrained",
        )
        column: NDArray[np.object_] = made[:, 0]
        return column
    given = np.ravel(np.asarray(ax, dtype=object))
    for own in given:
        if not isinstance(own, Axes):
            raise InputError(f"ax is {own!r}", "ax", "give Axes of matplotlib")
    if len(given) != count:
        raise InputError(
            f"ax has {len(given)} axes for {count} panels",
            "ax",
            f"give {count}, for example those of pyplot.subplots({count}, 1)",
        )
    return given


def panel(ax: Axes | None, height: float) -> Axes:
    """Returns axes to draw on: the given ones, or those of a new figure."""
    (own,) = panels(1, ax, height)
    assert isinstance(own, Axes)
    return own


def describe(axes: Axes, text: str) -> None:
    """Gives axes an alternative text; a second plot on the same axes adds its own."""
    before = _text_of(axes)
    setattr(axes, "_sprung_alt_text", f"{before} {text}" if before else text)


def alt_text(axes: Panels) -> str:
    """Returns the alternative texts of axes, one in a line."""
    texts = [_text_of(own) for own in np.ravel(np.asarray(axes, dtype=object))]
    return "\n".join(text for text in texts if text)


def _text_of(axes: Axes) -> str:
    return str(getattr(axes, "_sprung_alt_text", ""))
