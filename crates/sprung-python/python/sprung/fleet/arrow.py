"""pyarrow without types inside: stubs for it exist only from others, and for other versions."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sprung._columns import ArrowTable as ArrowTable

if TYPE_CHECKING:
    import pyarrow

pa: Any = import_module("pyarrow")
pc: Any = import_module("pyarrow.compute")
pq: Any = import_module("pyarrow.parquet")
csv: Any = import_module("pyarrow.csv")


def texts(table: pyarrow.Table, name: str) -> list[str]:
    """Returns a column of texts without empty cells."""
    column: Any = table[name]
    values: list[str] = column.to_pylist()
    return values


def arrow_table(table: ArrowTable) -> pyarrow.Table:
    """Returns any table as one of pyarrow, without a copy where that is possible."""
    # A DataFrame of pandas has the stream since 2.2.
    found: pyarrow.Table = pa.table(table) if hasattr(table, "__arrow_c_stream__") else pa.Table.from_pandas(table)
    return found
