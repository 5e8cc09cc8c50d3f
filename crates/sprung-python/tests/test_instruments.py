"""Every instrument of `[log]` works in memory by the name of its key, as by columns of a file."""

from __future__ import annotations

import copy
import tomllib
import warnings
from typing import Any

import numpy as np
import pytest

import sprung

BOTH = ("joint1", "joint2")
SENSORS: dict[str, tuple[dict[str, list[str]], dict[str, Any]]] = {
    "joint torque sensors": ({"joint_torque_nm": ["s1", "s2"]}, {}),
    "deflections": ({"link_deflection_rad": ["d1", "d2"], "link_position_rad": []}, {}),
    "currents": (
        {"motor_current_a": ["i1", "i2"], "motor_torque_nm": []},
        {"robot": {"torque_constant_nm_per_a": 0.5}},
    ),
    "gyroscopes": ({"gyroscope_rad_per_s.z": ["g1", "g2"], "link_position_rad": []}, {}),
    "degrees": ({"motor_position_deg": ["p1", "p2"], "motor_position_rad": []}, {}),
    "temperatures": (
        {"temperature_c": ["c1", "c2"]},
        {
            "robot": {"friction_covariates": {"temperature": ["motor_viscous"], "reference_c": 35.0}},
            "simulate": {"temperature_start_c": [25.0, 28.0], "temperature_end_c": [45.0, 42.0]},
        },
    ),
}


def _experiment(log: dict[str, list[str]], more: dict[str, Any]) -> dict[str, Any]:
    """Returns the demo with other columns in its log, as tables."""
    tables: dict[str, Any] = tomllib.loads(sprung.Experiment.demo().text)
    tables["identify"]["estimator"] = "least-squares"
    tables["simulate"].pop("parameters")
    tables.pop("validate", None)
    for joint in tables["robot"]["joint"]:
        joint.update(copy.deepcopy(more.get("robot", {})))
    tables["simulate"].update(more.get("simulate", {}))
    for key, columns in log.items():
        sensor, _, axis = key.partition(".")
        tables["log"][sensor] = {axis: columns} if axis else columns
    tables["log"] = {key: value for key, value in tables["log"].items() if value != []}
    return tables


def _by_key(log: dict[str, Any]) -> dict[str, Any]:
    """Returns the columns of a log by the names of their keys; the axes of a sensor have dotted names."""
    flat: dict[str, Any] = {}
    for key, columns in log.items():
        axes = {f"{key}.{axis}": names for axis, names in columns.items()} if isinstance(columns, dict) else {key: columns}
        flat |= axes
    return flat


@pytest.mark.parametrize("name", list(SENSORS))
def test_keys_of_the_log_are_names_in_memory(name: str) -> None:
    tables = _experiment(*SENSORS[name])
    by_column = sprung.Experiment(tables)
    log = by_column.simulate()
    quantities = {
        key: (
            log[names]
            if isinstance(names, str)
            else np.column_stack([log[column] for column in names])
        )
        for key, names in _by_key(
            {key: value for key, value in tables["log"].items() if key not in ("delay_s", "file")}
        ).items()
    }
    by_key = sprung.Experiment({key: value for key, value in tables.items() if key != "log"})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected, found = by_column.identify(log), by_key.identify(quantities)
    assert found.parameters.values_by_name() == expected.parameters.values_by_name()
    assert len(found.parameters.values_by_name()) > 8


def test_a_payload_belongs_to_the_log_in_its_place() -> None:
    tables = _experiment({}, {})
    body = {"mass_kg": 0.5, "com_m": [0.1, 0.0, 0.0]}
    tables["robot"] = {
        "name": "arm",
        "dh_modified": [{}, {"a_m": 0.3}],
        "joint": [{"name": name} for name in BOTH],
    }
    tables["log"]["file"] = ["empty.csv", {"path": "loaded.csv", "payload": body}]
    experiment = sprung.Experiment(tables)
    log = sprung.Experiment.demo().simulate()
    with pytest.raises(sprung.ExperimentError, match="1 logs are given, and .* names 2 files with payloads"):
        experiment.identify(log)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        loaded = experiment.identify([log, log])
        tables["log"]["file"] = ["empty.csv", "second.csv"]
        empty = sprung.Experiment(tables).identify([log, log])
    moved = "joint1.rotor_inertia", "joint2.stiffness"
    assert loaded.parameters != empty.parameters, moved
