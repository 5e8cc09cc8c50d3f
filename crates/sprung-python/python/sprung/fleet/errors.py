"""Exceptions of fleets. A log that fails is a row of the dataset, not an exception."""

from __future__ import annotations

from sprung._errors import SprungError


class FleetError(SprungError):
    """A run over a fleet cannot start or cannot be completed.

    ``code`` is a stable name, ``place`` the file, column or row, ``remedy`` what to do.
    """


class ManifestError(FleetError):
    """The manifest cannot be read, or its rows contradict each other."""


class DatasetError(FleetError):
    """The dataset cannot be read or written."""
