"""Tasks of a manifest that a dataset lacks: every engine computes only these."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from . import dataset
from .manifest import Part, Task, part

Known = Mapping[str, tuple[tuple[str, str, str], bool]]
"""The tasks of a dataset by their key, from `dataset.done`."""


def missing(known: Known, parts: Iterable[Part], retry_failures: bool) -> list[Part]:
    """Returns parts without the tasks that the dataset has.

    - retry_failures: whether tasks that failed earlier count as missing.
    """

    def is_missing(task: Task) -> bool:
        return task.key not in known or (retry_failures and known[task.key][1])

    left = ([task for task in one.tasks if is_missing(task)] for one in parts)
    return [part(tasks) for tasks in left if tasks]


def remove_replaced(out: str, known: Known, identities: Sequence[tuple[str, str, str]]) -> None:
    """Removes the rows of a dataset that new ones replace: failures, and results of an experiment that changed.

    - identities: those of all tasks that are computed now.
    """
    new = frozenset(identities)
    replaced = {key for key, (identity, _) in known.items() if identity in new}
    if replaced:
        dataset.remove(out, replaced.__contains__)
