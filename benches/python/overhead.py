"""Measures what a call from Python costs beside the work of the library.

usage: overhead.py

Prints the time of identify beyond the time inside the library, and the memory of identify beside the
arrays of a log of a million samples.
"""

import pathlib
import resource
import statistics
import sys
import time
import warnings

import numpy as np

import sprung

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from figure import note  # noqa: E402

LEAST_SQUARES = {"identify.estimator": "least-squares"}
CALLS = 20
SAMPLES = 1_000_000


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def quantities(log: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Returns the log as matrices of one array, stored row by row."""
    units = {"q": "rad", "phi": "rad", "tau": "nm"}
    matrices = {
        name: np.column_stack([log[f"{name}{joint}_{unit}"] for joint in (1, 2)])
        for name, unit in units.items()
    }
    return {"t": log["t_s"], **matrices}


def overhead() -> None:
    experiment = sprung.Experiment.demo(LEAST_SQUARES)
    log = quantities(experiment.simulate())
    beyond = []
    for _ in range(CALLS):
        begin = time.perf_counter()
        result = experiment.identify(log)
        beyond.append(1e3 * (time.perf_counter() - begin - result._handle.seconds))
    print(f"identify from NumPy, 10 000 samples: {statistics.median(beyond):.2f} ms beyond the library "
          f"({min(beyond):.2f} to {max(beyond):.2f} ms in {CALLS} calls)")
    note("call", "`Experiment.identify` of arrays of 10 000 samples, beside the work of the library", statistics.median(beyond), "ms")


def memory() -> None:
    """Identifies a long log made of copies of a short one, after the short one warmed up."""
    experiment = sprung.Experiment.demo(LEAST_SQUARES)
    short = quantities(experiment.simulate())
    experiment.identify(short)
    copies = SAMPLES // len(short["t"])
    period = short["t"][1]
    log = {name: np.tile(array, (copies, 1)) for name, array in short.items() if name != "t"}
    log["t"] = np.arange(SAMPLES) * period
    size = sum(array.nbytes for array in log.values()) / 2**20
    before = peak_mb()
    experiment.identify(log)
    beside = max(0.0, peak_mb() - before)
    print(f"identify from NumPy, {SAMPLES} samples: arrays {size:.0f} MiB, {beside:.0f} MiB beside them: "
          f"{1 + beside / size:.2f} times the arrays")
    note("memory", f"`Experiment.identify` of {SAMPLES} samples, memory beside arrays of {size:.0f} MiB", beside, "MiB", scatter=0.5)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    overhead()
    memory()
