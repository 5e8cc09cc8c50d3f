# mypy: disable-error-code="import-untyped"
"""Files of any fsspec URL: paths, atomic writing, local copies."""

from __future__ import annotations

import os
import time
import uuid
from pathlib import Path
from typing import Any

import fsspec

ATTEMPTS = 3
"""How often a file is fetched before it counts as unreachable."""
PAUSE_S = 0.5
"""Pause before the second attempt; it doubles."""
# Protocols whose files grow while they are written. All others put an object at once.
_RENAMED = frozenset({"file", "local", "sftp", "ssh", "smb", "hdfs", "webhdfs", "ftp", "arrow_hdfs"})
_UNFINISHED = ".part"


def is_local(url: str) -> bool:
    """Whether a URL is a path of this computer."""
    return "://" not in url or url.startswith(("file://", "local://"))


def local_path(url: str) -> str:
    """The path of a local URL."""
    return url.split("://", 1)[-1]


def resolve(url: str, base: str) -> str:
    """Joins a relative path with the folder `base`, a path or a URL; others are returned as they are."""
    if "://" in url:
        return url
    if is_local(base):
        return str(Path(local_path(base)).absolute() / url)
    return url if url.startswith("/") else f"{base.rstrip('/')}/{url}"


def parent(url: str) -> str:
    """The folder of a path or URL."""
    if is_local(url):
        return str(Path(local_path(url)).absolute().parent)
    return url.rsplit("/", 1)[0]


def filesystem(url: str) -> tuple[Any, str]:
    """Returns the fsspec file system of a URL, and the path in it.

    Raises ImportError if the package of the protocol is not installed, ValueError for an unknown protocol.
    """
    if is_local(url):
        return fsspec.filesystem("file"), str(Path(local_path(url)).absolute())
    system, path = fsspec.core.url_to_fs(url)
    return system, str(path)


def read(url: str) -> bytes:
    """Reads a whole file. Raises OSError, and what the file system raises for an unreachable server."""
    files, path = filesystem(url)
    return bytes(files.cat_file(path))


def write(url: str, content: bytes) -> None:
    """Writes a file so that readers see the earlier one or the whole new one.

    Raises OSError if the disk is full or the folder cannot be written; no part of the file is left then.
    """
    files, path = filesystem(url)
    protocols = {files.protocol} if isinstance(files.protocol, str) else set(files.protocol)
    if not protocols & _RENAMED:
        files.pipe_file(path, content)
        return
    folder, _, name = path.rpartition("/")
    temporary = f"{folder}/.{name}.{uuid.uuid4().hex}{_UNFINISHED}"
    try:
        if protocols & {"file", "local"}:
            os.makedirs(folder, exist_ok=True)
            with open(temporary, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        else:
            files.makedirs(folder, exist_ok=True)
            files.pipe_file(temporary, content)
            files.mv(temporary, path)
    except BaseException:
        if files.exists(temporary):
            files.rm_file(temporary)
        raise


def remove_unfinished(folder: str) -> None:
    """Removes what writers left in a folder that were killed while they wrote."""
    files, path = filesystem(folder)
    for entry in files.ls(path, detail=False):
        name = str(entry).rsplit("/", 1)[-1]
        if name.startswith(".") and name.endswith(_UNFINISHED):
            files.rm_file(entry)


def remove(url: str) -> None:
    """Removes a file if it exists."""
    files, path = filesystem(url)
    if files.exists(path):
        files.rm_file(path)


def fetch(url: str, folder: Path, number: int = 0) -> Path:
    """Returns a local path of a file: its own, or a copy in a folder.

    Raises FileNotFoundError, or ConnectionError after ``ATTEMPTS`` attempts at an unreachable server.
    """
    if is_local(url):
        local = Path(local_path(url))
        if not local.exists():
            raise FileNotFoundError(f"{url} does not exist")
        return local
    files, path = filesystem(url)
    copy = folder / str(number) / path.rsplit("/", 1)[-1]
    copy.parent.mkdir(parents=True, exist_ok=True)
    for attempt in range(1, ATTEMPTS + 1):
        try:
            files.get_file(path, str(copy))
            return copy
        except FileNotFoundError as error:
            raise FileNotFoundError(f"{url} does not exist") from error
        except Exception as error:
            if isinstance(error, OSError) and is_full(error):
                raise
            if attempt == ATTEMPTS:
                raise ConnectionError(f"{url} cannot be reached: {error}") from error
            time.sleep(PAUSE_S * 2 ** (attempt - 1))
    raise AssertionError("the last attempt returns or raises")


def is_full(error: OSError) -> bool:
    """Whether an error is that of a full disk or an exhausted quota."""
    import errno

    return error.errno in (errno.ENOSPC, errno.EDQUOT)
