"""Dataclasses with arrays."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


class WithArrays:
    """The base of dataclasses with arrays: they are equal if all fields that are compared are."""

    def _compared(self) -> list[Any]:
        dataclass: Any = self
        fields = dataclasses.fields(dataclass)
        return [getattr(self, field.name) for field in fields if field.compare]

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other) or not isinstance(other, WithArrays):
            return NotImplemented
        both = zip(self._compared(), other._compared(), strict=True)
        return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in both)

    def __hash__(self) -> int:
        return hash(tuple(part.tobytes() for part in self._compared() if isinstance(part, np.ndarray)))


def fixed(array: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Returns an array that cannot be written any more."""
    array.flags.writeable = False
    return array
