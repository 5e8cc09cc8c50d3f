"""Parts of results, as the types of the library describe them; `_results.pyi` is made from the same description."""

from sprung._named import Named as Named
from sprung._record import classes
from sprung._texts import TEXTS

#: The types of the package, with new names of fields by their paths in the JSON; the types of their fields follow.
_CHOSEN: dict[str, dict[str, str]] = {
    "Applied": {},
    "CheckedLog": {},
    "Combined": {},
    "ComparedResult": {},
    "DriftOverTime": {},
    "Finding": {},
    "LimitUsed": {},
    "LogUsed": {},
    "LoopMargins": {"gain_db": "gain_margin_db", "phase_deg": "phase_margin_deg"},
    "Mode": {},
    "More": {},
    "Moves": {},
    "Payload": {},
    "Promised": {"is_determined": "determined"},
    "PromisedErrors": {},
    "Refinement": {},
    "RigidJoint": {},
    "SensedSpring": {},
    "ServoErrors": {},
    "ServoLog": {},
    "ShapedMode": {},
    "StandardParameter": {},
    "Tracking": {},
    "Unknown": {},
    "ValidationRun": {},
    "Vibration": {f"all.{name}": name for name in ("hz", "hz_95", "damping", "damping_95")},
    "WatchEvent": {},
    "WatchedJoint": {},
    "WatchedLog": {},
    "WithDraws": {},
}

_CLASSES = classes(_CHOSEN, TEXTS, __name__)
globals().update(_CLASSES)
__all__ = list(_CLASSES)
