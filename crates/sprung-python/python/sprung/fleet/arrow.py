"""pyarrow without types: stubs for it exist only from others, and for other versions."""

from __future__ import annotations

from importlib import import_module
from typing import Any

pa: Any = import_module("pyarrow")
pc: Any = import_module("pyarrow.compute")
pq: Any = import_module("pyarrow.parquet")
csv: Any = import_module("pyarrow.csv")
