"""Times programs."""

import os
import re
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent

# Units of the times that a benchmark prints, in seconds.
UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}


@dataclass
class Run:
    """A process that has ended: elapsed and processor time in s, peak memory in MiB."""

    seconds: float
    processor: float
    mebibytes: float
    output: str

    def __str__(self):
        return (f"{self.seconds:8.2f} s, {self.processor:8.2f} s of processor time, "
                f"{self.mebibytes:6.0f} MiB")


def once(command, accepted):
    begin = time.perf_counter()
    with subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True) as process:
        output = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    seconds = time.perf_counter() - begin
    if process.returncode not in accepted:
        raise SystemExit(f"exit code {process.returncode}: {' '.join(map(str, command))}")
    return Run(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, output)


def measure(command, runs=3, accepted=(0, 1)):
    """Runs a command several times and returns the least of each figure.

    Exit code 1 of sprung means a result that cannot be used, not a failed run.
    """
    all_runs = [once(command, accepted) for _ in range(runs)]
    return Run(*(min(getattr(run, name) for run in all_runs)
                 for name in ("seconds", "processor", "mebibytes")), all_runs[-1].output)


def bench(name, benchmark, argument):
    """Returns the fastest run of a benchmark of sprung with an argument, in seconds."""
    command = ["cargo", "bench", "--quiet", "-p", "sprung", "--bench", name, "--", benchmark]
    text = subprocess.run(command, cwd=HERE, check=True, capture_output=True, text=True).stdout
    inside = here = False
    for line in text.splitlines():
        words = re.sub("^[^a-z0-9]*", "", line).split()
        if not words:
            continue
        # The benchmark may print its own text between a name and its times.
        if here:
            return seconds(words[0], words[1])
        inside |= words[0] == benchmark
        if inside and words[0] == argument:
            if re.fullmatch("[0-9.]+", words[1]):
                return seconds(words[1], words[2])
            here = True
    raise SystemExit(f"cargo bench printed no time of {benchmark} {argument}")


def seconds(number, unit):
    return float(number) * UNITS[unit]
