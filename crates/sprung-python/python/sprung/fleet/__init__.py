"""Fleets of robots: identify many logs on any number of workers; populations, outliers and drift.

>>> import tempfile
>>> from sprung import fleet
>>> folder = tempfile.mkdtemp()
>>> manifest = fleet.demo(folder, robots=2, logs=1)
>>> settings = {"identify.estimator": "least-squares"}
>>> summary = fleet.identify(manifest, out=f"{folder}/results", overrides=settings, workers=1, progress=False)
>>> summary.tasks, summary.failed
(2, 0)
>>> page = fleet.report(f"{folder}/results").save(f"{folder}/fleet.html")
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

try:
    from .batches import identify_batch, missing_logs, write_rows
    from .dataset import Dataset, schema
    from .errors import DatasetError, FleetError, ManifestError
    from .run import Summary, identify
    from .simulated import demo
    from .watching import watch
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
    "demo",
    "identify",
    "identify_batch",
    "missing_logs",
    "report",
    "schema",
    "watch",
    "write_rows",
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
