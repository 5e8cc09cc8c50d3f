"""The page of the interface and the types of parts of results, from signatures and docstrings."""

from __future__ import annotations

import inspect
import re
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cached_property
from typing import Any

import sprung
from sprung import _results
from sprung._report import Field

#: Headings and their modules.
SECTIONS = {
    "Experiments": ["_experiment"],
    "Results": ["_result", "_parameters", "_samples", "_mujoco"],
    "Plots": ["_plots"],
    "Model": ["_model"],
    "Checks, validations and comparisons": ["_check", "_validation", "_watch", "_comparison"],
    "Designed experiments": ["_excitation"],
    "Designed controllers": ["_control"],
    "Servos": ["_servo"],
    "Findings, errors and names": ["_errors", "_named"],
}
HEAD = """# Python interface

Every public name of the module `sprung` with the names of its members. `help(sprung.Result)` shows their meaning, types,
units and examples; an editor shows the same. [Python](../how-to/python.md) shows how to work with them,
[Fleets](../how-to/fleet.md) the module `sprung.fleet`.

All numbers are in SI units: rad, N·m, kg·m²; m and N for prismatic joints. All results have `report(path)`, which writes
a report as one HTML file, and `to_json()`, which returns the text of the file that the command line writes.
"""


@dataclass(frozen=True)
class Member:
    """A member of a class, as a row of the page."""

    name: str
    shown: str
    type: str
    meaning: str


def members(item: object) -> list[Member]:
    """Returns the public members of a class in their order: attributes, properties, methods."""
    if not inspect.isclass(item) or item.__module__ == "sprung._sprung":
        return []
    described = _attributes(item.__doc__ or "")
    described |= {name: value.__doc__ or "" for name, value in vars(item).items() if isinstance(value, Field)}
    types = {field.name: str(field.type) for field in fields(item)} if is_dataclass(item) else {}
    types |= {name: str(hint) for name, hint in inspect.get_annotations(item).items()}
    rows = [
        Member(name, f"`{name}`", types.get(name, ""), meaning)
        for name, meaning in described.items()
        if not name.startswith("_")
    ]
    rows += [
        Member(name, f"`{name}`", hint, "")
        for name, hint in types.items()
        if not name.startswith("_")
        and name not in described
        and not issubclass(item, (dict, tuple))
    ]
    for name, value in vars(item).items():
        if name.startswith("_"):
            continue
        if isinstance(value, property | cached_property):
            function: Any = value.fget if isinstance(value, property) else value.func
            hint = str(inspect.get_annotations(function).get("return", ""))
            rows.append(Member(name, f"`{name}`", hint, _first(function.__doc__)))
        elif isinstance(value, classmethod | staticmethod) or inspect.isfunction(value):
            function = value if inspect.isfunction(value) else value.__func__
            hint = str(inspect.get_annotations(function).get("return", ""))
            rows.append(Member(name, f"`{name}()`", hint, _first(function.__doc__)))
    return rows


def page() -> str:
    """Returns the page."""
    headings = _headings()
    parts = [HEAD]
    for heading in SECTIONS:
        inside = [name for name, own in headings.items() if own == heading]
        if inside:
            parts.append(f"\n## {heading}\n\n| name | meaning and members |\n|---|---|\n")
            parts += [_row(name) for name in sorted(inside, key=_place)]
    return "".join(parts)


def _headings() -> dict[str, str]:
    """Returns the heading of each name: that of its module, or for a part of results that of the first class with it."""
    headings = {
        name: heading
        for heading, modules in SECTIONS.items()
        for name in sprung.__all__
        if getattr(getattr(sprung, name), "__module__", "") in {f"sprung.{module}" for module in modules}
    }
    for name in [*headings]:
        _add_parts(name, headings[name], headings)
    return headings


def _add_parts(name: str, heading: str, headings: dict[str, str]) -> None:
    for member in members(getattr(sprung, name)):
        for part in sorted(set(re.findall(r"\w+", member.type)) & set(_results.__all__)):
            # Findings belong to errors, whoever has them.
            if part not in headings:
                headings[part] = "Findings, errors and names" if part == "Finding" else heading
                _add_parts(part, headings[part], headings)


def stub() -> str:
    """Returns the types of parts of results, for type checkers and editors."""
    lines = [
        '"""Parts of results. `SPRUNG_WRITE_DOCS=1 pytest tests/test_interface.py` writes this file."""',
        "",
        "from dataclasses import dataclass",
        "",
        "from sprung._named import Named",
        "",
        f"__all__ = {sorted(_results.__all__)!r}".replace("'", '"'),
    ]
    for name in sorted(_results.__all__):
        cls = getattr(_results, name)
        text = (cls.__doc__ or "").rstrip().replace("\n", "\n    ").replace("\n    \n", "\n\n")
        lines += ["", "@dataclass(frozen=True)", f"class {name}:", f'    """{text}', '    """', ""]
        for field in fields(cls):
            is_needed = field.default is MISSING and field.default_factory is MISSING
            lines.append(f"    {field.name}: {field.type}" + ("" if is_needed else " = ..."))
    return "\n".join([*lines, ""])


def _place(name: str) -> tuple[int, str]:
    # The name of the section's subject comes first.
    order = ["Experiment", "Result", "Model", "Excitation", "Control", "Servo", "SprungError", "Check", "Validation", "Watch"]
    return (order.index(name) if name in order else len(order), name)


def _row(name: str) -> str:
    item = getattr(sprung, name)
    call = "" if inspect.isclass(item) and name not in ("Experiment", "Servo") else _signature(item)
    shared = ("report", "to_json")
    shown = ", ".join(row.shown for row in members(item) if row.name not in shared)
    meaning = f"{_sentence(item.__doc__)}{' ' if shown else ''}{shown}".replace("``", "`").replace("|", "\\|")
    return f"| `{name}{call}` | {meaning} |\n"


def _signature(function: object) -> str:
    """Returns the names of the arguments and their defaults."""
    words = []
    star = False
    for parameter in inspect.signature(function).parameters.values():  # type: ignore[arg-type]
        if parameter.name in ("self", "cls"):
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not star:
            words.append("*")
            star = True
        word = f"*{parameter.name}" if parameter.kind is parameter.VAR_POSITIONAL else parameter.name
        star = star or parameter.kind is parameter.VAR_POSITIONAL
        if parameter.default is not parameter.empty:
            word += f"={parameter.default!r}"
        words.append(word)
    return f"({', '.join(words)})"


def _sentence(docstring: str | None) -> str:
    """Returns the first sentence."""
    return re.split(r"(?<=\.)\s", _first(docstring))[0]


def _first(docstring: str | None) -> str:
    text = inspect.cleandoc(docstring or "").split("\n\n")[0]
    return text.replace("\n", " ").replace("|", "\\|")


def _attributes(docstring: str) -> dict[str, str]:
    """Returns the entries of the section `Attributes`."""
    text = inspect.cleandoc(docstring)
    match = re.search(r"^Attributes:\n((?:    .*\n?|\n)+)", text, flags=re.MULTILINE)
    found: dict[str, str] = {}
    if match is None:
        return found
    for entry in re.split(r"\n(?=    \S)", match[1].split("\n\n")[0].rstrip()):
        names, _, meaning = entry.strip().partition(": ")
        for name in names.split(", "):
            found[name] = re.sub(r"\s+", " ", meaning).replace("|", "\\|")
    return found
