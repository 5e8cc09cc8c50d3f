"""Texts of parts of results, for `str`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sprung import _results as results


def _applied(change: results.Applied) -> str:
    gain = ""
    if change.held_out is not None:
        without, beside = (100.0 * error for error in change.held_out)
        gain = f"; held-out error {without:.2f} → {beside:.2f} %"
    return f"{change.what}{gain} (forbidden by {change.forbidden_by})"


def _finding(finding: results.Finding) -> str:
    return f"{finding.severity}: {finding.code}: {finding.text}; {finding.remedy}"


def _limit(limit: results.LimitUsed) -> str:
    joint = "" if limit.joint is None else f" of {limit.joint}"
    return f"{limit.quantity}{joint}: {limit.used_percent:.3g} % at {limit.time_s:.6g} s"


def _loop(loop: results.LoopMargins) -> str:
    gain = "any gain" if loop.gain_margin_db is None else f"{loop.gain_margin_db} dB"
    return f"{loop.joint}: gain margin {gain}, phase margin {loop.phase_margin_deg}°"


def _mode(mode: results.Mode | results.Vibration) -> str:
    low, high = mode.hz_95
    return f"{mode.hz:.4g} Hz ({low:.4g} to {high:.4g}), damping {mode.damping:.2g}"


def _more(more: results.More) -> str:
    return f"{more.what}: standard errors times {more.factor:.3g}"


def _moves(moves: results.Moves) -> str:
    return f"moves of {moves.duration_s:.3g} s leave vibrations of {moves.shaped_rad} rad"


def _promised(promise: results.Promised) -> str:
    text = f"{promise.name} = {promise.value:.6g} ± {promise.standard_error:.2g} {promise.unit}".rstrip()
    if promise.determined:
        return text
    return f"{text}, not determined" + (f": {promise.cure}" if promise.cure else "")


def _shaped(mode: results.ShapedMode) -> str:
    return f"{mode.impulses} impulses at {mode.centre_hz:.3g} Hz"


def _standard(parameter: results.StandardParameter) -> str:
    error = "" if parameter.standard_error is None else f" ± {parameter.standard_error:.2g}"
    return f"{parameter.name} = {parameter.value:.6g}{error} {parameter.unit}, by {parameter.decided}"


def _tracking(tracking: results.Tracking) -> str:
    return f"{tracking.joint} follows the reference within {tracking.designed_rad} rad rms"


def _unknown(unknown: results.Unknown) -> str:
    unit = f" {unknown.unit}" if unknown.unit else ""
    size = f"{unknown.value:.4g} ± {unknown.standard_error:.2g}{unit}"
    return f"{unknown.id}: {size} ({unknown.status}), error falls by {100.0 * unknown.effect:.0f} %"


def _vibration(vibration: results.Vibration) -> str:
    return f"{vibration.name}, motors {vibration.motors}: {_mode(vibration)}"


def _with_draws(figure: results.WithDraws) -> str:
    return f"{figure.identified:.3g} (worst robot {figure.worst:.3g})"


#: By the names of the classes.
TEXTS: Mapping[str, Callable[[Any], str]] = {
    "Applied": _applied,
    "Finding": _finding,
    "LimitUsed": _limit,
    "LoopMargins": _loop,
    "Mode": _mode,
    "More": _more,
    "Moves": _moves,
    "Promised": _promised,
    "ShapedMode": _shaped,
    "StandardParameter": _standard,
    "Tracking": _tracking,
    "Unknown": _unknown,
    "Vibration": _vibration,
    "WithDraws": _with_draws,
}
