"""Fleets of robots: identify many logs on any number of workers; populations, outliers and drift.

>>> import sprung.fleet                                                     # doctest: +SKIP
>>> sprung.fleet.identify("manifest.csv", out="results")                    # doctest: +SKIP
>>> sprung.fleet.report("results").save("fleet.html")                       # doctest: +SKIP
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

try:
    from .dataset import Dataset
    from .errors import DatasetError, FleetError, ManifestError
    from .run import Summary, identify
except ImportError as error:
    raise ImportError(f"{error}; sprung.fleet needs more packages: pip install 'sprung[fleet]'") from error

if TYPE_CHECKING:
    from .page import Report, report
    from .population import Analysis, Rows, analyse

__all__ = [
    "Analysis",
    "Dataset",
    "DatasetError",
    "FleetError",
    "ManifestError",
    "Report",
    "Rows",
    "Summary",
    "analyse",
    "identify",
    "report",
]


def __getattr__(name: str) -> Any:
    # Workers do not need SciPy, which takes long to import.
    if name in ("Analysis", "Rows", "analyse"):
        from . import population

        return getattr(population, name)
    if name in ("Report", "report"):
        from . import page

        return getattr(page, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
