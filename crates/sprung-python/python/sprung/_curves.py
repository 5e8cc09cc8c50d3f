"""Curves over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

from sprung._named import Named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sprung import _sprung

    #: Arrays by the names of columns; ``t`` has the time, s.
    Curves: TypeAlias = Named[NDArray[np.float64]]


def curves(given: Sequence[_sprung.Set], kind: str) -> Named[Curves]:
    """Returns curves by the names of their origins.

    Args:
        given: label, times and columns of each set.
        kind: the word for a label.
    """
    return Named(
        {label: Named({"t": time, **dict(values)}, "curve") for label, time, values in given}, kind
    )
