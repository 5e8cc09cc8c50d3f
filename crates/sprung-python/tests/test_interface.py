"""Every public name has an example that runs, and stands once on the page of the interface."""

from __future__ import annotations

import inspect
import os
import re
from pathlib import Path

import pytest

import sprung
from interface import members, page

NAMES = [name for name in sprung.__all__ if name != "__version__"]
PAGE = Path(__file__).parents[3] / "docs" / "reference" / "python.md"


def _example(item: object) -> str:
    """Returns the lines of examples in the docstrings of a class and its members, or of a function."""
    texts = [item.__doc__ or ""]
    if inspect.isclass(item):
        texts += [
            getattr(item, name).__doc__ or "" for name in vars(item) if not name.startswith("_")
        ]
    return "\n".join(line for text in texts for line in text.splitlines() if ">>> " in line or "... " in line)


def _shown_by(item: object, lines: str, shown: set[str]) -> None:
    """Adds the types of the members that an example reads."""
    for member in members(item):
        if re.search(rf"\.{member.name}\b", lines):
            types = (set(re.findall(r"\w+", member.type)) & set(sprung.__all__)) - shown
            shown |= types
            for name in types:
                _shown_by(getattr(sprung, name), lines, shown)


def test_every_public_name_has_an_example() -> None:
    shown: set[str] = set()
    for name in NAMES:
        lines = _example(getattr(sprung, name))
        if lines:
            shown.add(name)
            _shown_by(getattr(sprung, name), lines, shown)
    assert [name for name in NAMES if name not in shown] == []


def test_the_page_shows_each_name_once() -> None:
    text = page()
    if os.environ.get("SPRUNG_WRITE_DOCS"):
        PAGE.write_text(text, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == text, (
        "docs/reference/python.md is older than the docstrings: run this test with SPRUNG_WRITE_DOCS=1"
    )
    rows = re.findall(r"^\| `(\w+)", text, flags=re.MULTILINE)
    assert sorted(rows) == sorted(set(rows))
    assert set(rows) == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_member_says_what_it_is(name: str) -> None:
    item = getattr(sprung, name)
    assert item.__doc__ and item.__doc__.strip()
    for member in members(item):
        assert member.meaning, f"{name}.{member.name} has no description"
        assert "Any" not in re.findall(r"\w+", member.type), f"{name}.{member.name}: {member.type}"
