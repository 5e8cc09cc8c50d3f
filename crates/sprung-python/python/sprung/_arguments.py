"""Arguments of calls: overrides, values and paths."""

from __future__ import annotations

import datetime
import json
import numbers
import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from sprung import _sprung
from sprung._columns import Columns
from sprung._errors import InputError
from sprung._result import Result
from sprung._samples import SampledValues

#: Tables, lists, texts, numbers and dates, as in an experiment file.
Table: TypeAlias = "Mapping[str, object]"
#: ``{"identify.estimator": "least-squares"}`` or ``["identify.estimator=least-squares"]``.
Overrides: TypeAlias = "Table | Sequence[str]"
#: A path, columns in memory, or several of one kind.
Log: TypeAlias = "str | os.PathLike[str] | Columns | Sequence[str | os.PathLike[str] | Columns]"
#: A result, values by the names of parameters, or a file of the command line.
Values: TypeAlias = "Result | Mapping[str, float] | str | os.PathLike[str]"


def session_of(origin: tuple[str, ...], overrides: list[str]) -> _sprung.Session:
    """Returns the session of a file, a text or the demo."""
    match origin:
        case ("file", path):
            return _sprung.Session.open(path, overrides)
        case ("text", name, text, folder):
            return _sprung.Session.read(name, text, overrides, folder)
        case (name,):
            return _sprung.Session.demo(name, overrides)
    raise InputError(f"{origin} is no origin", "experiment", "give a path or a dict")


def assignments(overrides: Overrides) -> list[str]:
    """Returns overrides as texts ``key.path=value``."""
    if isinstance(overrides, str):
        raise InputError(
            "overrides is a text", "overrides", "give a list of texts key.path=value, or a dict"
        )
    if not isinstance(overrides, Mapping):
        return [str(one) for one in overrides]
    return [f"{key}={_toml(value)}" for key, value in overrides.items()]


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        inner = ", ".join(f"{json.dumps(str(key))} = {_toml(item)}" for key, item in value.items())
        return f"{{ {inner} }}"
    if isinstance(value, list | tuple | np.ndarray):
        return f"[{', '.join(_toml(item) for item in value)}]"
    return json.dumps(value, default=plain, ensure_ascii=False)


def plain(value: Any) -> Any:
    """Returns numbers and texts of NumPy and paths as those of JSON."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, datetime.date):
        return value.isoformat()
    raise InputError(
        f"{value!r} is of type {type(value).__name__}",
        "experiment",
        "give tables, lists, texts and numbers",
    )


def values_of(given: Values, *, with_laws: bool = False) -> _sprung.Values:
    """Returns values of a robot for the extension module.

    Args:
        with_laws: whether a drawn robot has the laws that its identification found; a design takes its values as exact
            ones of the experiment.
    """
    if isinstance(given, Result):
        return given._handle, given._index
    if isinstance(given, SampledValues) and given._result is not None and with_laws:
        return given._result._handle, dict(given)
    remedy = "give a Result, numbers by the names of parameters, or the path of a file"
    if not isinstance(given, Mapping):
        return path_of("parameters", given, remedy)
    for name, value in given.items():
        if not isinstance(value, numbers.Real):
            kind = type(value).__name__
            raise InputError(f"the value of {name!r} is of type {kind}", "parameters", remedy)
    return {str(name): float(value) for name, value in given.items()}


def path_of(name: str, given: object, remedy: str) -> str:
    """Returns an absolute path."""
    if not isinstance(given, str | os.PathLike):
        raise InputError(f"{name} is of type {type(given).__name__}", name, remedy)
    return os.path.abspath(given)
