"""Records from the JSON that the library returns."""

from __future__ import annotations

import dataclasses
import functools
import types
from collections.abc import Hashable, Mapping
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from sprung._finding import Finding, findings
from sprung._named import Named

R = TypeVar("R")


def record(cls: type[R], given: Mapping[str, Any]) -> R:
    """Returns a dataclass with the values of its fields, which JSON has under the same names.

    Fields that JSON leaves out keep their defaults.
    """
    dataclass: Any = cls
    values = {name: _value(hint, given[name]) for name, hint in _hints(dataclass) if name in given}
    return cls(**values)


@functools.cache
def _hints(cls: Hashable) -> list[tuple[str, Any]]:
    dataclass: Any = cls
    hints = get_type_hints(dataclass)
    return [(field.name, hints[field.name]) for field in dataclasses.fields(dataclass)]


def _value(hint: Any, given: Any) -> Any:
    """Returns a value of the type that a field names."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        (inner,) = (argument for argument in arguments if argument is not types.NoneType)
        return None if given is None else _value(inner, given)
    if hint is Finding:
        return findings([given])[0]
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return record(hint, given)
    if origin is list:
        return [_value(arguments[0], item) for item in given]
    if origin is tuple:
        return tuple(
            _value(argument, value) for argument, value in zip(arguments, given, strict=True)
        )
    if origin is Named:
        return Named({name: _value(arguments[0], value) for name, value in given.items()})
    return given
