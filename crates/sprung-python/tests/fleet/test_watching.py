"""Watching the robots of a fleet."""

from pathlib import Path

import pyarrow as pa
from pyarrow import csv

from sprung import Experiment, fleet

SETTINGS = {"identify.estimator": "least-squares"}


def test_a_touched_robot_and_a_lost_log_are_rows(tmp_path: Path) -> None:
    manifest = fleet.demo(tmp_path, robots=2, logs=2)
    touch = {"simulate.contact_torque_nm": [0.6, 0.0], "simulate.contact_s": [[5.0, 5.5]]}
    touched = Experiment(tmp_path / "robot1" / "experiment.toml", overrides=touch).simulate(seed=9)
    csv.write_csv(pa.table({name: pa.array(values) for name, values in touched.items()}), tmp_path / "robot1" / "log1.csv")
    (event,) = fleet.watch(manifest, overrides=SETTINGS, workers=1).to_pylist()
    assert (event["robot"], event["code"], event["joint"]) == ("robot1", "contact", "joint1")
    assert event["log"].endswith("robot1/log1.csv") and 5.0 < event["begins_s"] < 5.1
    (tmp_path / "robot0" / "log0.csv").unlink()
    found = fleet.watch(manifest, overrides=SETTINGS, workers=2)
    codes = dict(zip(found["robot"].to_pylist(), found["code"].to_pylist(), strict=True))
    assert codes["robot1"] == "contact" and codes["robot0"] not in (None, "contact")
