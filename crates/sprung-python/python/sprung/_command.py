"""The command ``sprung`` of the wheel."""

from __future__ import annotations

import signal
import sys

from sprung._sprung import run_command


def main() -> None:
    """Runs the command line with the words of ``sys.argv`` and exits with its code."""
    # Ctrl-C ends the command at once, as it ends the program without Python.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    sys.exit(run_command(["sprung", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
