"""Progress, Ctrl-C and the lock of the interpreter."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

Log = dict[str, NDArray[np.float64]]


def test_progress_is_heard_and_stops_the_run(log: Log) -> None:
    experiment = sprung.Experiment.demo()
    heard: list[tuple[str, int, int | None]] = []

    def progress(phase: str, done: int, total: int | None) -> bool:
        heard.append((phase, done, total))
        return phase != "refining"

    with pytest.raises(sprung.Stopped):
        experiment.identify(log, progress=progress)
    assert heard[-1][0] == "refining"


def test_an_error_of_the_callback_ends_the_run(log: Log) -> None:
    def progress(phase: str, done: int, total: int | None) -> None:
        raise ZeroDivisionError(phase)

    with pytest.raises(ZeroDivisionError):
        sprung.Experiment.demo().identify(log, progress=progress)


def test_a_bar_of_tqdm(log: Log, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    sprung.Experiment.demo().identify(log, progress=True)
    assert "refining" in capsys.readouterr().err


def test_other_threads_run_meanwhile(log: Log) -> None:
    experiment = sprung.Experiment.demo()
    count = 0
    done = threading.Event()

    def other() -> None:
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    thread = threading.Thread(target=other)
    thread.start()
    experiment.identify(log)
    done.set()
    thread.join()
    assert count > 20


SCRIPT = """
    import os, sys, sprung
    experiment = sprung.Experiment.demo()
    log = experiment.simulate()
    said = []
    def progress(phase, done, total):
        if phase == "refining" and not said:
            said.append(phase)
            print("refining", flush=True)
    try:
        experiment.identify([log] * 6, progress=progress)
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        sys.exit(7)
"""


def test_ctrl_c_stops_at_once(tmp_path: Path) -> None:
    """The time is a bound of the interface: a user waits for it."""
    process = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(SCRIPT)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "refining\n"
    os.kill(process.pid, signal.SIGINT)
    assert process.stdout.readline() == "interrupted\n"
    process.wait(timeout=30)
    assert list(tmp_path.iterdir()) == []
