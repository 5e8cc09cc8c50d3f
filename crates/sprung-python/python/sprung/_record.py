"""Classes of results from the schema of their JSON, and their values from JSON.

The types of the library describe the fields of results: names, types, units and meaning. The schema has these
descriptions; `_results.pyi` shows them to type checkers and editors.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import re
import textwrap
import types
from collections.abc import Callable, Hashable, Mapping
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from sprung import _sprung
from sprung._arrays import fixed
from sprung._named import Named

R = TypeVar("R")

Schema = dict[str, Any]

#: Schemas of the types of results, by name.
_SCHEMAS: dict[str, Schema] = json.loads(_sprung.RESULTS)

_SCALARS = {"string": "str", "number": "float", "integer": "int", "boolean": "bool"}
_WIDTH = 110


def classes(
    chosen: Mapping[str, Mapping[str, str]], texts: Mapping[str, Callable[[Any], str]], module: str
) -> dict[str, type]:
    """Returns frozen dataclasses for types of results, and for the types of their fields, in the order of names.

    Args:
        chosen: the types, each with the new names of fields by their paths in the JSON.
        texts: functions that describe a value for `str`, by the name of the type.
        module: the module that has the classes.
    """
    made: dict[str, type] = {}
    wanted = list(chosen)
    while wanted:
        name = wanted.pop()
        if name in made or _SCHEMAS[name].get("type") != "object":
            continue
        paths = _paths(name, chosen.get(name, {}))
        namespace: dict[str, Any] = {"__doc__": _docstring(name, paths)}
        if name in texts:
            namespace["__str__"] = texts[name]
        fields = _fields(name, paths)
        made[name] = dataclasses.make_dataclass(name, fields, frozen=True, namespace=namespace)
        made[name].__module__ = module
        wanted += [word for _, hint, _ in fields for word in re.findall(r"\w+", hint) if word in _SCHEMAS]
    return dict(sorted(made.items()))


def meaning(type_name: str, path: str = "") -> str:
    """Returns the meaning of a type of results, or of one of its fields."""
    schema = _field(type_name, path) if path else _SCHEMAS[type_name]
    text = re.sub(r"\s+", " ", schema.get("description", "")).strip()
    # Code in Markdown becomes code in docstrings.
    return re.sub(r"`([^`]+)`", r"``\1``", re.sub(r"\\([\[\]])", r"\1", text))


def _field(type_name: str, path: str) -> Schema:
    """Returns the schema of a field, whose path leads through types and lists of types."""
    first, *further = path.split(".")
    field: Schema = _SCHEMAS[type_name]["properties"][first]
    for key in further:
        inner = field.get("items") or (field["anyOf"][0] if "anyOf" in field else field)
        field = _SCHEMAS[_referred(inner)]["properties"][key]
    return field


def _referred(schema: Schema) -> str:
    return str(schema["$ref"]).rsplit("/", 1)[-1]


def _paths(type_name: str, renamed: Mapping[str, str]) -> dict[str, str]:
    """Returns paths in the JSON by the names of fields; the parts of a type replace it."""
    schema = _SCHEMAS[type_name]
    paths: dict[str, str] = {}
    # Properties are sorted by name, but the list of those that are never absent has the order of the library.
    for key in [*schema.get("required", []), *sorted({*schema["properties"]} - {*schema.get("required", [])})]:
        parts = [path for path in renamed if path.split(".")[0] == key] or [key]
        paths |= {renamed.get(path, path): path for path in parts}
    return paths


def _docstring(type_name: str, paths: Mapping[str, str]) -> str:
    """Returns the meaning of a type and of its fields."""
    lines = [*textwrap.wrap(meaning(type_name), _WIDTH), "", "Attributes:"]
    for name, path in paths.items():
        text = f"{name}: {meaning(type_name, path)}"
        lines += textwrap.wrap(text, _WIDTH, initial_indent=" " * 4, subsequent_indent=" " * 8)
    return "\n".join([*lines, ""])


def _fields(type_name: str, paths: Mapping[str, str]) -> list[tuple[str, str, Any]]:
    """Returns names, types and defaults of the fields; those that JSON may leave out come last."""
    needed, optional = [], []
    for name, path in paths.items():
        schema = _field(type_name, path)
        hint = _hint(schema)
        required = path.split(".")[0] in _SCHEMAS[type_name].get("required", [])
        may_lack = "default" in schema or not required
        if may_lack and hint in _SCHEMAS:
            hint += " | None"
        place = {} if name == path else {"path": path}
        if hint.endswith("| None"):
            optional.append((name, hint, dataclasses.field(default=None, metadata=place)))
        elif may_lack:
            optional.append((name, hint, dataclasses.field(**_empty(hint), metadata=place)))
        else:
            needed.append((name, hint, dataclasses.field(metadata=place)))
    return [*needed, *optional]


def _empty(hint: str) -> dict[str, Any]:
    """Returns the default of a field that JSON leaves out."""
    scalars: dict[str, Any] = {"str": "", "float": 0.0, "int": 0, "bool": False}
    if hint in scalars:
        return {"default": scalars[hint]}
    kinds: dict[str, Callable[[], Any]] = {"list": list, "tuple": tuple, "Named": lambda: Named({})}
    return {"default_factory": kinds[hint.split("[")[0]]}


def _hint(schema: Schema) -> str:
    """Returns the type of a field in Python."""
    if "$ref" in schema:
        name = _referred(schema)
        return name if _SCHEMAS[name].get("type") == "object" else "str"
    if "anyOf" in schema:
        return f"{_hint(schema['anyOf'][0])} | None"
    kind = schema["type"]
    if isinstance(kind, list):
        return f"{_hint({**schema, 'type': kind[0]})} | None"
    if kind == "object":
        return f"Named[{_hint(schema['additionalProperties'])}]"
    if kind != "array":
        return _SCALARS[kind]
    if "prefixItems" in schema:
        return f"tuple[{', '.join(_hint(item) for item in schema['prefixItems'])}]"
    item = _hint(schema["items"])
    if schema.get("uniqueItems"):
        return f"tuple[{item}, ...]"
    return f"tuple[{item}, {item}]" if schema.get("maxItems") == 2 else f"list[{item}]"


def record(cls: type[R], given: Mapping[str, Any]) -> R:
    """Returns a dataclass with the values of its fields, which JSON has under the same names or under their paths.

    Fields that JSON leaves out keep their defaults.
    """
    dataclass: Any = cls
    values = {}
    for field, hint in _hints(dataclass):
        first, *further = field.metadata.get("path", field.name).split(".")
        if first in given:
            values[field.name] = value(hint, functools.reduce(lambda at, key: at[key], further, given[first]))
    return cls(**values)


@functools.cache
def _hints(cls: Hashable) -> list[tuple[dataclasses.Field[Any], Any]]:
    dataclass: Any = cls
    hints = get_type_hints(dataclass)
    return [(field, hints[field.name]) for field in dataclasses.fields(dataclass)]


def value(hint: Any, given: Any) -> Any:
    """Returns a value of JSON with a type; an empty one for a list that JSON leaves out.

    JSON has no infinite numbers: ``null`` stands for them.
    """
    origin, arguments = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        (inner,) = (argument for argument in arguments if argument is not types.NoneType)
        return None if given is None else value(inner, given)
    if hint is float and given is None:
        return math.inf
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return record(hint, given)
    if origin is list:
        return [value(arguments[0], item) for item in given or ()]
    if origin is tuple and arguments[-1] is Ellipsis:
        return tuple(value(arguments[0], item) for item in given or ())
    if origin is tuple:
        return tuple(value(argument, item) for argument, item in zip(arguments, given, strict=True))
    if origin is np.ndarray:
        return _array(given)
    if isinstance(origin, type) and issubclass(origin, Named):
        return Named({name: value(arguments[0], item) for name, item in (given or {}).items()})
    return given


def _array(given: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Returns numbers as an array that cannot be written; fields of records become columns."""
    rows = [list(row.values()) if isinstance(row, dict) else row for row in given]
    array = np.array(rows, dtype=np.float64)
    array[np.isnan(array)] = np.inf
    return fixed(array)
