"""Scores a file of parameters: `score.py TASKS NAME PARAMETERS.json` prints a line of figures as JSON.

The file has `parameters`, for each name such as `joint1.stiffness` a value or [value, standard error or null], and `bodies`,
for each name such as `link1` ten numbers about the origin of the link (README.md). An effect that is absent is zero.
"""
import difflib
import json
import sys
from pathlib import Path

import numpy as np

from model import Chain
from tasks import DRIVES, EFFECTS, SHARES

OPTIONAL = [*EFFECTS, "motor_offset"]


class Refused(Exception):
    """A file that cannot be scored, with the reason."""


def checked(given, task):
    """Values and standard errors by name, and bodies [n, 10]; names that lack."""
    n = len(task["joints"])
    known = [f"joint{i}.{key}" for i in range(1, n + 1) for key in DRIVES + OPTIONAL]
    links = [f"link{i}" for i in range(1, n + 1)]
    if not isinstance(given, dict) or not isinstance(given.get("parameters"), dict) or not isinstance(given.get("bodies"), dict):
        raise Refused("the file needs the objects `parameters` and `bodies`")
    for name in [*given["parameters"], *given["bodies"]]:
        if name not in known + links:
            near = difflib.get_close_matches(name, known + links, 1)
            raise Refused(f"{name!r} is no name of this task" + (f"; did you mean {near[0]!r}?" if near else ""))
    values = {}
    for name, entry in given["parameters"].items():
        value, error = entry if isinstance(entry, list) and len(entry) == 2 else (entry, None)
        if not isinstance(value, (int, float)) or not np.isfinite(value):
            raise Refused(f"{name!r} has the value {value!r}; a finite number is needed")
        values[name] = (float(value), error)
    for name, entry in given["bodies"].items():
        if np.shape(entry) != (10,) or not np.isfinite(np.array(entry, float)).all():
            raise Refused(f"{name!r} needs ten finite numbers")
    rigid = [i for i, joint in enumerate(task["joints"], 1) if joint.get("rigid")]
    needed = [name for name in known if not name.endswith(tuple(OPTIONAL)) and not (
        any(name.startswith(f"joint{i}.") for i in rigid) and name.split(".")[1] in ("stiffness", "link_viscous", "link_coulomb"))]
    lacking = [name for name in needed if name not in values] + [name for name in links if name not in given["bodies"]]
    return values, np.array([given["bodies"].get(name, [0.0] * 10) for name in links], float), lacking


def column(values, key, n):
    return np.array([values.get(f"joint{i}.{key}", (0.0, None))[0] for i in range(1, n + 1)])


def predicted(task, values, bodies, s):
    """Motor torque along exact motions, and the deflections that the link side needs."""
    n, sharp = len(task["joints"]), task["sharpness_s_per_rad"]
    k, j, bm, cm, bl, cl = (column(values, key, n) for key in DRIVES)
    load, hysteresis, free = (column(values, key, n) for key in EFFECTS)
    y = Chain(task["joints"], task["gravity"]).regressor(s["q"], s["dq"], s["ddq"])
    link = y @ bodies.ravel() + bl * s["dq"] + cl * np.tanh(sharp * s["dq"])
    d, slip = s["p"] - s["q"], hysteresis * k * s["stops"]
    elastic = k * (d - np.clip(d, -free, free)) + slip
    torque = j * s["ddp"] + bm * s["dp"] + (cm + load * np.abs(elastic)) * np.tanh(sharp * s["dp"]) + elastic
    with np.errstate(divide="ignore", invalid="ignore"):
        return torque, (link - slip) / k + np.clip(d, -free, free)


def bounds(task, values, s):
    """Standard deviations that no unbiased tool can beat: it knows the motion exactly and only the torque has noise.

    The rows of a motor then are a linear regression of the torque; link rows have no noise, so friction of links is known
    relative to the stiffness. None if backlash makes the regression nonlinear.
    """
    n, out = len(task["joints"]), {}
    if column(values, "backlash_rad", n).any():
        return None
    keep = slice(None, None, round(1000 / task["rate_hz"]))
    load, hysteresis = column(values, "load_friction", n), column(values, "hysteresis", n)
    for i in range(n):
        v, d, stops = s["dp"][keep, i], s["p"][keep, i] - s["q"][keep, i], s["stops"][keep, i]
        sign, k = np.tanh(task["sharpness_s_per_rad"] * v), values[f"joint{i + 1}.stiffness"][0]
        columns = [d, s["ddp"][keep, i], v, sign]
        if load[i]:
            columns[0] = d + load[i] * np.sign(d) * d * sign
            columns.append(np.abs(k * d) * sign)
        if hysteresis[i]:
            columns.append(stops)
        a = np.stack(columns, 1)
        scale = np.linalg.norm(a, axis=0)
        error = task["torque_noise_nm"][i] * np.sqrt(np.diag(np.linalg.inv((a / scale).T @ (a / scale)))) / scale
        for key, sigma in zip(DRIVES, error):
            out[f"joint{i + 1}.{key}"] = sigma
        for key in DRIVES[4:]:
            name = f"joint{i + 1}.{key}"
            out[name] = abs(values[name][0]) * error[0] / k
    return out


def score_twin(folder, task, values, bodies, lacking):
    states = {log: dict(np.load(folder / "hidden" / f"{log}.npz")) for log in ("train", "test")}
    true = {name: (entry[0], None) for name, entry in json.loads((folder / "hidden/truth.json").read_text())["parameters"].items()}
    torque, deflection = predicted(task, values, bodies, states["test"])
    rms = lambda x: np.sqrt((x**2).mean(0))
    out = {"torque_over_noise": float((rms(torque - states["test"]["tau"]) / task["torque_noise_nm"]).mean())}
    noise = np.hypot(*task["position_noise_rad"])
    out["deflection_over_noise"] = float((rms(deflection - states["test"]["p"] + states["test"]["q"]) / noise).mean())
    if lacking:
        only_bodies = all(name.startswith("link") for name in lacking)
        out["torque_over_noise" if not only_bodies else "deflection_over_noise"] = None
        out["deflection_over_noise"] = None
    names = [name for name in true if name in values and name.split(".")[1] in DRIVES]
    errors = {name: abs(values[name][0] - true[name][0]) for name in names}
    limit = bounds(task, true, states["train"])
    median = lambda x: float(np.median(x)) if len(x) else None
    out["error_percent"] = median([100 * errors[name] / abs(true[name][0]) for name in names])
    out["error_over_bound"] = median([errors[name] / limit[name] for name in names]) if limit else None
    inside = [errors[name] <= 1.96 * values[name][1] + 1e-12 for name in names if values[name][1] is not None]
    out["coverage_percent"] = 100 * float(np.mean(inside)) if inside else None
    return out


def score_real(folder, task, values, bodies, lacking):
    s = dict(np.load(folder / "hidden" / "test.npz"))
    n, sharp = len(task["joints"]), task["sharpness_s_per_rad"]
    _, j, bm, cm, bl, cl = (column(values, key, n) for key in DRIVES)
    y = Chain(task["joints"], task["gravity"]).regressor(s["q"], s["dq"], s["ddq"])
    torque = y @ bodies.ravel() + bl * s["dq"] + cl * np.tanh(sharp * s["dq"])
    torque = torque + j * s["ddp"] + bm * s["dp"] + cm * np.tanh(sharp * s["dp"]) + column(values, "motor_offset", n)
    rms = lambda x: np.sqrt((x**2).mean(0))
    # The whole joint counts here, so a spring that the log does not determine does no harm.
    blind = [name for name in lacking if not name.endswith(("stiffness", "link_viscous", "link_coulomb"))]
    return {"torque_error_percent": 100 * float((rms(torque - s["tau"]) / rms(s["tau"] - s["tau"].mean(0))).mean()) if not blind else None}


def score(folder, given):
    """Figures of a file for the task in a folder; `lacking` names what the file does not give."""
    task = json.loads((folder / "task.json").read_text())
    values, bodies, lacking = checked(given, task)
    is_twin = (folder / "hidden/truth.json").exists()
    return {**(score_twin if is_twin else score_real)(folder, task, values, bodies, lacking), "lacking": lacking}


if __name__ == "__main__":
    try:
        tasks, name, file = sys.argv[1:]
        print(json.dumps(score(Path(tasks) / name, json.loads(Path(file).read_text()))))
    except (Refused, OSError, ValueError) as why:
        sys.exit(f"not scored: {why}")
