"""Every public name has an example that runs, and stands once on the page of the interface."""

from __future__ import annotations

import inspect
import os
import re
from pathlib import Path

import pytest

import sprung
from interface import members, page, stub

NAMES = [name for name in sprung.__all__ if name != "__version__"]
PAGE = Path(__file__).parents[3] / "docs" / "reference" / "python.md"
STUB = Path(__file__).parents[1] / "python" / "sprung" / "_results.pyi"


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
            by_this = {name}
            _shown_by(getattr(sprung, name), lines, by_this)
            shown |= by_this
    assert [name for name in NAMES if name not in shown] == []


def _compare(file: Path, text: str) -> None:
    """Compares a file with its text; with SPRUNG_WRITE_DOCS it writes the file."""
    if os.environ.get("SPRUNG_WRITE_DOCS"):
        file.write_text(text, encoding="utf-8")
    assert file.read_text(encoding="utf-8") == text, (
        f"{file.name} is older than the descriptions: run this test with SPRUNG_WRITE_DOCS=1"
    )


def test_the_types_of_parts_are_those_of_the_library() -> None:
    _compare(STUB, stub())


def test_the_page_shows_each_name_once() -> None:
    text = page()
    _compare(PAGE, text)
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
