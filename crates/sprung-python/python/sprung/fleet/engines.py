"""Where parts are computed: processes of this computer, or a Dask cluster."""

# mypy: disable-error-code="import-untyped, import-not-found, no-untyped-call, unused-ignore"

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from .errors import FleetError
from .manifest import Part
from .work import Done, Settings

RECONNECT_S = 120.0
"""How long a run waits for a scheduler that is restarted."""

Function = Callable[[Part, Settings], Done]
Outcome = Done | BaseException


class WorkerDied(Exception):
    """A worker ended while it computed a part."""


class Engine:
    """Computes parts, a bounded number at a time: those that are repeated, then new ones."""

    def __init__(self) -> None:
        self.parts: Iterator[Part] = iter(())
        self.repeated: list[Part] = []

    def run(self, function: Function, settings: Settings, parts: Iterator[Part]) -> Iterator[tuple[Part, Outcome]]:
        """Yields each part with what became of it, in the order of completion."""
        raise NotImplementedError

    def again(self, part: Part) -> None:
        """Puts a part before those that have not begun."""
        self.repeated.append(part)

    def next(self) -> Part | None:
        return self.repeated.pop() if self.repeated else next(self.parts, None)


class Processes(Engine):
    """Processes of this computer. A process that dies is replaced."""

    def __init__(self, workers: int | None, in_flight: int | None) -> None:
        super().__init__()
        self.workers = workers or os.cpu_count() or 1
        self.in_flight = in_flight or 2 * self.workers

    def run(self, function: Function, settings: Settings, parts: Iterator[Part]) -> Iterator[tuple[Part, Outcome]]:
        self.parts, self.repeated = parts, []
        pool = self._pool()
        active: dict[concurrent.futures.Future[Done], Part] = {}
        try:
            while True:
                while len(active) < self.in_flight and (part := self.next()) is not None:
                    try:
                        active[pool.submit(function, part, settings)] = part
                    except BrokenProcessPool:
                        self.again(part)
                        break
                if not active:
                    return
                ended, _ = concurrent.futures.wait(active, return_when=concurrent.futures.FIRST_COMPLETED)
                broken = False
                for future in ended:
                    part = active.pop(future)
                    outcome = _outcome(future)
                    broken = broken or isinstance(outcome, WorkerDied)
                    yield part, outcome
                if broken:
                    # All futures of a broken pool end; the process that died is unknown.
                    for future, part in active.items():
                        yield part, _outcome(future)
                    active.clear()
                    pool.shutdown(wait=False)
                    pool = self._pool()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)

    def _pool(self) -> concurrent.futures.ProcessPoolExecutor:
        # Forked processes would inherit the threads of the caller.
        context = multiprocessing.get_context("spawn")
        return concurrent.futures.ProcessPoolExecutor(self.workers, mp_context=context)


def _outcome(future: concurrent.futures.Future[Done]) -> Outcome:
    try:
        return future.result()
    except BrokenProcessPool as error:
        return WorkerDied(str(error))
    except Exception as error:
        return error


class Dask(Engine):
    """A cluster of Dask, by the client of the caller."""

    def __init__(self, client: Any, in_flight: int | None) -> None:
        super().__init__()
        self.client = client
        self.limit = in_flight
        self.submitted = 0

    def run(self, function: Function, settings: Settings, parts: Iterator[Part]) -> Iterator[tuple[Part, Outcome]]:
        import distributed

        self.parts, self.repeated = parts, []
        active: dict[Any, Part] = {}
        in_flight = self.limit or 4 * max(1, sum(self.client.nthreads().values()))
        try:
            while True:
                while len(active) < in_flight and (part := self.next()) is not None:
                    active[self._submit(function, part, settings)] = part
                if not active:
                    return
                try:
                    distributed.wait(list(active), timeout=5, return_when="FIRST_COMPLETED")
                except (distributed.TimeoutError, TimeoutError):
                    pass
                except (concurrent.futures.CancelledError, OSError):
                    # The scheduler has ended: its futures are examined below.
                    time.sleep(0.2)
                for future in [one for one in active if one.status != "pending"]:
                    part = active.pop(future)
                    if future.status in ("cancelled", "lost"):
                        self._reconnected()
                        self.again(part)
                        continue
                    yield part, self._outcome(future)
                if active and self.client.status not in ("running", "connecting"):
                    self._reconnected()
        finally:
            if active and self.client.status == "running":
                self.client.cancel(list(active))

    def _submit(self, function: Function, part: Part, settings: Settings) -> Any:
        self._reconnected()
        # A repeated part needs another key, because the scheduler remembers the outcome of the earlier one.
        self.submitted += 1
        key = f"sprung-{part.name}-{self.submitted}"
        return self.client.submit(function, part, settings, key=key, pure=False, retries=0)

    def _reconnected(self) -> None:
        """Waits until the client is connected. Raises FleetError after ``RECONNECT_S``."""
        end = time.monotonic() + RECONNECT_S
        while self.client.status != "running":
            if self.client.status == "closed" or time.monotonic() > end:
                raise FleetError(
                    "the connection with the Dask scheduler is lost",
                    code="scheduler-lost",
                    remedy="connect a new client and call identify again: it resumes with the missing logs",
                )
            time.sleep(0.1)

    def _outcome(self, future: Any) -> Outcome:
        import distributed

        try:
            result: Done = future.result()
            return result
        except distributed.scheduler.KilledWorker as error:
            return WorkerDied(str(error))
        except Exception as error:
            return error
        finally:
            future.release()
