"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from sprung._errors import FileError


def write_text(path: str | os.PathLike[str], text: str) -> Path:
    """Writes a text under a temporary name and renames it.

    Raises:
        FileError: if the file cannot be written; an earlier file stays as it was.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
                file.write(text)
            os.chmod(temporary, 0o644)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise FileError(
            f"cannot write {path}: {error.strerror}",
            "file",
            "give another path, or make room",
            str(path),
        ) from error
    return path


def write_all(folder: str | os.PathLike[str], texts: Mapping[str, str]) -> Path:
    """Writes texts by the names of their files, in their order; returns the folder."""
    for name, text in texts.items():
        write_text(Path(folder) / name, text)
    return Path(folder)


def remove(path: str | os.PathLike[str]) -> None:
    """Removes a file if it exists.

    Raises:
        FileError: if the file cannot be removed.
    """
    path = Path(path)
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(
            f"cannot remove {path}: {error.strerror}", "file", "give another path", str(path)
        ) from error
