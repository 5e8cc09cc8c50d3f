"""Common to all results: JSON with typed fields, a report that notebooks show, pickles."""

from __future__ import annotations

import dataclasses
import functools
import html
import json
import os
import sys
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, get_args, overload

from sprung._files import write_text
from sprung._record import meaning, value

if TYPE_CHECKING:
    from typing_extensions import Never, Self

T = TypeVar("T")


class Field(Generic[T]):
    """A value of the JSON of a result, with the type of its annotation and the meaning that the library describes.

    Args:
        path: keys of the JSON; the name of the attribute if absent.
    """

    def __init__(self, path: str = "") -> None:
        self._path = path

    def __set_name__(self, owner: type[Report], name: str) -> None:
        self._name = name
        self._path = self._path or name
        self._owner = owner
        self.__doc__ = meaning(owner._type, self._path)

    @overload
    def __get__(self, result: None, owner: type) -> Self: ...

    @overload
    def __get__(self, result: Report, owner: type) -> T: ...

    def __get__(self, result: Report | None, owner: type) -> Self | T:
        if result is None:
            return self
        if self._name not in vars(result):
            found = functools.reduce(result._at, self._path.split("."), result._contents)
            vars(result)[self._name] = value(self._hint(), found)
        known: T = vars(result)[self._name]
        return known

    def __set__(self, result: Report, given: Never) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {self._name!r}")

    def _hint(self) -> Any:
        """Returns the type of the value; its names are those of the module of the class."""
        annotation = self._owner.__annotations__[self._name]
        (hint,) = get_args(eval(annotation, vars(sys.modules[self._owner.__module__])))
        return hint


class Kept:
    """What a pickle keeps of a result of the library, in its place."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values

    def __getattr__(self, name: str) -> Any:
        if name not in vars(self).get("_values", {}):
            raise AttributeError(name)
        return lambda: self._values[name]


class Report:
    """The base of all results: JSON and a report."""

    #: The type of the library that describes the JSON.
    _type: ClassVar[str]
    #: Functions of the handle whose values a pickle keeps.
    _kept: ClassVar[tuple[str, ...]] = ("json", "report")
    #: The element of lists within the JSON.
    _index = 0

    def __init__(self, handle: Any) -> None:
        self._handle = handle

    def to_json(self) -> str:
        """Returns the text of the file that the command line writes."""
        text: str = self._handle.json()
        return text

    def _html(self) -> str:
        page: str = self._handle.report()
        return page

    @cached_property
    def _contents(self) -> dict[str, Any]:
        contents: dict[str, Any] = json.loads(self.to_json())
        return contents

    def _at(self, contents: Any, key: str) -> Any:
        """Returns a value of the JSON; ``None`` if it is absent."""
        if isinstance(contents, list):
            contents = contents[self._index]
        return None if contents is None else contents.get(key)

    def report(self, path: str | os.PathLike[str]) -> Path:
        """Writes the report, one HTML file that needs no other; returns its path."""
        return write_text(path, self._html())

    def _repr_html_(self) -> str:
        # The frame keeps the styles of the report and those of the notebook apart.
        page = html.escape(self._html(), quote=True)
        return f'<iframe srcdoc="{page}" style="width:100%;height:640px;border:0"></iframe>'

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return isinstance(other, Report) and bool(self._timeless() == other._timeless())

    def __hash__(self) -> int:
        return hash(json.dumps(self._timeless(), sort_keys=True))

    def _timeless(self) -> object:
        return _without_times(self._contents)

    def __reduce__(self) -> tuple[Any, ...]:
        return _of_kept, (type(self), {name: getattr(self._handle, name)() for name in self._kept})


def _of_kept(cls: type[Report], values: dict[str, Any]) -> Report:
    return cls(Kept(values))


def _without_times(value: Any) -> Any:
    """Returns JSON without computing times, which differ between equal runs."""
    if isinstance(value, dict):
        return {name: _without_times(entry) for name, entry in value.items() if name != "elapsed_s"}
    if isinstance(value, list):
        return [_without_times(item) for item in value]
    return value
