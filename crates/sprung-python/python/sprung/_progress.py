"""Settings and progress of a run."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeAlias

from sprung._errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sprung import _sprung

#: Receives the phase, the work done, and the total where it is known; ``False`` stops the run.
Callback: TypeAlias = Callable[[str, int, "int | None"], "bool | None"]
#: A callback; ``True`` for a bar of tqdm; ``None`` for a bar in notebooks only; ``False`` for none.
Progress: TypeAlias = "Callback | bool | None"


@contextmanager
def running(verb: str, threads: int = 0, progress: Progress = False) -> Iterator[_sprung.Run]:
    """Yields the settings of a run, with its callback.

    Args:
        threads: number of threads; 0 for one per processor.
    """
    if not 0 <= threads <= 256:
        raise InputError(f"threads = {threads}", "threads", "give 0 to 256")
    if callable(progress):
        yield {"threads": threads, "progress": progress}
        return
    wanted = progress is True or (progress is None and _in_notebook())
    bar = _bar(verb, required=progress is True) if wanted else None
    if bar is None:
        yield {"threads": threads, "progress": None}
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
        yield {"threads": threads, "progress": callback}
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
