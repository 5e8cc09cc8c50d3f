"""Values by name, whose ``KeyError`` gives the nearest name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from typing import ClassVar, TypeVar

T = TypeVar("T")


class Named(Mapping[str, T]):
    """Things by name, in their order.

    Raises:
        KeyError: if there is no such name; the message has the nearest one.

    Example:
        >>> import sprung
        >>> experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
        >>> result = experiment.identify(experiment.simulate())
        >>> result.residual_rms["joint1.motor"]
        Traceback (most recent call last):
        KeyError: "there is no row 'joint1.motor'; the nearest name is 'joint1.motor_nm'; ..."
    """

    _kind: ClassVar[str] = "name"

    def __init__(self, given: Mapping[str, T], kind: str | None = None) -> None:
        self._all = dict(given)
        self._word = kind or self._kind

    def __getitem__(self, name: str) -> T:
        try:
            return self._all[name]
        except (KeyError, TypeError):
            raise unknown(self._word, name, self._all) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Named):
            return self._all == other._all
        return self._all == other if isinstance(other, Mapping) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(self._all))

    def __repr__(self) -> str:
        return repr(self._all)


def unknown(kind: str, name: object, known: Mapping[str, object]) -> KeyError:
    """Returns the error about a name that there is not."""
    names = list(known)
    rest = f"the {kind}s are {', '.join(names)}" if names else "there is none"
    return KeyError(f"there is no {kind} {name!r}{nearest(name, names)}; {rest}")


def nearest(name: object, known: Iterable[str]) -> str:
    """Returns the nearest name as a part of a message; nothing if none is near."""
    near = difflib.get_close_matches(str(name), list(known), 1)
    return f"; the nearest name is {near[0]!r}" if near else ""
