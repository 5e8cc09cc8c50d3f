"""Progress of a run."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Receives the phase, the work done, and the total where it is known; ``False`` stops the run.
Callback: TypeAlias = Callable[[str, int, "int | None"], "bool | None"]
#: A callback; ``True`` for a bar of tqdm; ``None`` for a bar in notebooks only; ``False`` for none.
Progress: TypeAlias = "Callback | bool | None"


@contextmanager
def heard(progress: Progress, verb: str) -> Iterator[Callback | None]:
    """Yields the callback of a run."""
    if callable(progress):
        yield progress
        return
    if progress is False or (progress is None and not _in_notebook()):
        yield None
        return
    bar = _bar(verb, required=progress is True)
    if bar is None:
        yield None
        return
    phase = ""

    def callback(word: str, done: int, total: int | None) -> None:
        nonlocal phase
        if word != phase:
            phase = word
            bar.reset(total=total)
            bar.set_description(word)
        bar.total = total
        bar.n = done
        bar.refresh()

    try:
        yield callback
    finally:
        bar.close()


def _bar(verb: str, *, required: bool) -> Any:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if required:
            raise
        return None
    return tqdm(desc=verb, leave=False)


def _in_notebook() -> bool:
    ipython: Any = sys.modules.get("IPython")
    return ipython is not None and type(ipython.get_ipython()).__name__ == "ZMQInteractiveShell"
