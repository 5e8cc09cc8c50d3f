"""Notes figures for the documentation; `cargo xtask figures` reads them."""

import json
import os

# Scatter between runs, as a part of the value: numbers without a clock repeat, times do not.
SCATTER = 0.02
SCATTER_OF_TIMES = 0.25


def note(name, text, value, unit, *, better="lower", scatter=None, peer=None, peer_value=None):
    """Appends a figure to the file that SPRUNG_FIGURES names; does nothing without this variable.

    text: the case, in Markdown, or empty for a figure that is compared with the last run but not shown;
    better: "lower", "higher" or "none"; peer: another program with its value.
    """
    path = os.environ.get("SPRUNG_FIGURES")
    if not path:
        return
    if scatter is None:
        scatter = SCATTER_OF_TIMES if unit in ("s", "ms", "µs") else SCATTER
    line = {"name": name, "text": text, "value": rounded(value), "unit": unit, "better": better, "scatter": scatter}
    if peer is not None:
        line |= {"peer": peer, "peer_value": rounded(peer_value)}
    with open(path, "a", encoding="utf-8") as file:
        file.write(json.dumps(line, ensure_ascii=False) + "\n")


def rounded(value):
    """Returns a number with four digits."""
    return float(f"{value:.3e}")
