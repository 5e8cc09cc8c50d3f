"""Columns of a log in memory: NumPy, pandas, polars, Arrow."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from sprung import _sprung
from sprung._errors import InputError, SprungWarning, warn

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class ArrowTable(Protocol):
    """A table of Arrow, polars, DuckDB and others, by the PyCapsule interface of Arrow."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Returns its capsule."""
        ...


class DataFrame(Protocol):
    """A DataFrame of pandas."""

    @property
    def columns(self) -> Any:
        """Names of the columns."""
        ...

    @property
    def iloc(self) -> Any:
        """Rows by number."""
        ...


#: Columns by name; a DataFrame; or a table of Arrow.
Columns: TypeAlias = "Mapping[str, ArrayLike] | DataFrame | ArrowTable"
#: Named arrays in the form that the library takes.
Named: TypeAlias = list[tuple[str, Any]]


def given(log: Any, wanted: Sequence[str]) -> tuple[list[str] | None, list[Named] | None]:
    """Returns the paths of logs or their columns in memory; neither without a log."""
    if log is None:
        return None, None
    logs: list[Any] = list(log) if isinstance(log, list | tuple) else [log]
    if not logs:
        raise InputError("the list of logs is empty", "log", "give at least one log")
    paths = [os.path.abspath(one) for one in logs if isinstance(one, str | os.PathLike)]
    if paths and len(paths) < len(logs):
        raise InputError(
            "the list holds paths and columns", "log", "give logs of one kind in a call"
        )
    return (paths, None) if paths else (None, [named(one, wanted) for one in logs])


def named(log: Any, wanted: Sequence[str]) -> Named:
    """Returns the columns of a log as contiguous arrays, without copies where memory allows.

    Args:
        log: columns by name, a DataFrame, or a table of Arrow.
        wanted: columns that the experiment names; a table may have others.

    Raises:
        InputError: if a column holds no real numbers, or has a wrong shape.
    """
    if isinstance(log, Mapping):
        return [(str(name), _array(str(name), values)) for name, values in log.items()]
    if _is_pandas(log):
        # A column of numbers is given without a copy; others are refused with their name.
        return [(str(name), _array(str(name), log[name])) for name in _chosen(log.columns, wanted)]
    if hasattr(log, "__arrow_c_stream__"):
        return _of_arrow(log, wanted)
    raise InputError(
        f"a log is of type {type(log).__name__}",
        "log",
        "give a path, a dict of arrays, a DataFrame, or a table of Arrow",
    )


def _is_pandas(log: object) -> bool:
    return type(log).__module__.split(".")[0] == "pandas" and hasattr(log, "columns")


def _chosen(columns: Any, wanted: Sequence[str]) -> list[Any]:
    names = list(columns)
    if wanted and all(name in names for name in wanted):
        return [name for name in names if name in wanted]
    return names


def _of_arrow(log: Any, wanted: Sequence[str]) -> Named:
    read = _sprung.Columns.read(log, list(wanted))
    if wanted and not set(wanted) <= {*read.names, *read.others}:
        read = _sprung.Columns.read(log, [])
    for name in read.others:
        if not wanted or name in wanted:
            raise InputError(
                f'the column "{name}" of the table holds no real numbers',
                "dtype",
                "convert it to float64, or leave it out",
            )
    return list(zip(read.names, read.arrays, strict=True))


def _array(name: str, values: Any) -> Any:
    if isinstance(values, np.ma.MaskedArray):
        missing = np.ma.getmaskarray(values)
        values = np.where(missing, np.nan, values.data) if missing.any() else values.data
    if _is_series_with_missing(values):
        values = values.to_numpy(dtype=float, na_value=np.nan)
    array = np.asarray(values)
    if array.dtype.kind == "O":
        raise InputError(
            f'the column "{name}" holds objects of type {_kind(array)}',
            "dtype",
            "convert it to numbers, for example by astype(float)",
        )
    if array.dtype.kind == "M":
        # Stamps of a time zone are stored in UTC; only differences of times count.
        array = array.astype("datetime64[ns]").view(np.int64)
    elif array.dtype.kind == "m":
        array = array.astype("timedelta64[ns]").view(np.int64)
    if array.dtype.kind not in "fiub":
        raise InputError(
            f'the column "{name}" has the type {array.dtype}, which is no real number',
            "dtype",
            "give float64",
        )
    if array.ndim == 0 or array.ndim > 2:
        raise InputError(
            f'the array "{name}" has the shape {array.shape}',
            "shape",
            "give (samples,) or (samples, joints)",
        )
    return _contiguous(name, array)


def _contiguous(name: str, array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    if array.dtype.kind == "f" and array.dtype.itemsize < 8:
        warn(
            SprungWarning(
                f'the column "{name}" has the type {array.dtype} and was converted to float64; '
                f"its resolution is {np.finfo(array.dtype).eps:.1e} of its values"
            )
        )
    exact = array.dtype.kind in "iu" and array.ndim == 1
    kind = np.dtype(np.int64 if exact else np.float64)
    array = array.astype(kind, copy=False)
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    if array.ndim == 2 and array.flags.f_contiguous:
        return array
    return np.ascontiguousarray(array)


def _is_series_with_missing(values: Any) -> bool:
    kind = str(getattr(values, "dtype", ""))
    return kind in {"Float64", "Float32", "Int64", "Int32", "Int16", "Int8"} and hasattr(
        values, "to_numpy"
    )


def _kind(array: np.ndarray[Any, Any]) -> str:
    first = array.flat[0] if array.size else None
    return type(first).__name__
