"""Common to all results: JSON, and a report that notebooks show."""

from __future__ import annotations

import html
import json
import os
from functools import cached_property
from pathlib import Path
from typing import Any

from sprung._files import write_text


class Report:
    """The base of all results: JSON and a report."""

    def _html(self) -> str:
        raise NotImplementedError

    def to_json(self) -> str:
        """Returns the text of the file that the command line writes."""
        raise NotImplementedError

    @cached_property
    def _contents(self) -> dict[str, Any]:
        contents: dict[str, Any] = json.loads(self.to_json())
        return contents

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


class Pickled:
    """JSON and report of a result that came out of a pickle."""

    def __init__(self, json_text: str, page: str) -> None:
        self._json = json_text
        self._page = page

    def json(self) -> str:
        """Returns the text of the file."""
        return self._json

    def report(self) -> str:
        """Returns the report."""
        return self._page


def _without_times(value: Any) -> Any:
    """Returns JSON without computing times, which differ between equal runs."""
    if isinstance(value, dict):
        return {name: _without_times(entry) for name, entry in value.items() if name != "elapsed_s"}
    if isinstance(value, list):
        return [_without_times(item) for item in value]
    return value
