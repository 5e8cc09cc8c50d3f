"""Exceptions of fleets. A log that fails is a row of the dataset, not an exception."""

from __future__ import annotations

from sprung._errors import SprungError


class FleetError(SprungError):
    """A run over a fleet cannot start or cannot be completed.

    ``code`` is a stable name, ``place`` the file, column or row, ``remedy`` what to do.

    >>> from sprung import fleet
    >>> try:
    ...     fleet.Dataset.read("nowhere")
    ... except fleet.FleetError as error:
    ...     print(f"{error.code}, {error.place}: {error.remedy}")
    dataset-missing, nowhere: give the folder that sprung.fleet.identify wrote
    """


class ManifestError(FleetError):
    """The manifest cannot be read, or its rows contradict each other.

    >>> import pyarrow
    >>> from sprung import fleet
    >>> try:
    ...     fleet.identify_batch(pyarrow.table({"robot": ["A-1"], "log": ["run.csv"]}))
    ... except fleet.ManifestError as error:
    ...     print(error.code)
    manifest-columns
    """


class DatasetError(FleetError):
    """The dataset cannot be read or written.

    >>> import pathlib, tempfile
    >>> from sprung import fleet
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> size = (folder / "part-of-another-program.parquet").write_bytes(b"torn")
    >>> try:
    ...     fleet.report(folder)
    ... except fleet.DatasetError as error:
    ...     print(error.code)
    dataset-damaged
    """
