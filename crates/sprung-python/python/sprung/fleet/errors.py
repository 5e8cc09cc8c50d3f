"""Exceptions of fleets. A log that fails is a row of the dataset, not an exception."""

from __future__ import annotations


class FleetError(Exception):
    """A run over a fleet cannot start or cannot be completed.

    ``code`` is a stable name, ``place`` the file, column or row, ``remedy`` what to do.
    """

    def __init__(self, text: str, *, code: str, remedy: str, place: str | None = None) -> None:
        super().__init__(text)
        self.code = code
        self.remedy = remedy
        self.place = place

    def __str__(self) -> str:
        return f"{super().__str__()}; {self.remedy}"

    def __reduce__(self) -> tuple[object, ...]:
        return _make, (type(self), self.args[0], self.code, self.remedy, self.place)


class ManifestError(FleetError):
    """The manifest cannot be read, or its rows contradict each other."""


class DatasetError(FleetError):
    """The dataset cannot be read or written."""


def _make(kind: type[FleetError], text: str, code: str, remedy: str, place: str | None) -> FleetError:
    return kind(text, code=code, remedy=remedy, place=place)
