"""Experiments, results and models pickle, copy and compare."""

from __future__ import annotations

import copy
import dataclasses
import json
import multiprocessing
import pickle
from pathlib import Path

import numpy as np
import pytest

import sprung


def test_results_and_models_pickle_and_copy(
    experiment: sprung.Experiment, result: sprung.Result
) -> None:
    for item in (experiment, result, result.model, result.parameters):
        for other in (pickle.loads(pickle.dumps(item)), copy.deepcopy(item)):
            assert other == item and hash(other) == hash(item)
    back = pickle.loads(pickle.dumps(result))
    assert back.to_json() == result.to_json()
    assert back.report.__self__._html() == result._html()
    assert list(back.trace) == list(result.trace)


def test_checks_and_validations_pickle(
    experiment: sprung.Experiment, result: sprung.Result, log: dict[str, np.ndarray]
) -> None:
    check = experiment.check(log)
    back = pickle.loads(pickle.dumps(check))
    assert back == check and back._html() == check._html()
    validation = result.validate(log)
    back = pickle.loads(pickle.dumps(validation))
    assert back == validation and back.sentence == validation.sentence
    assert list(back.signals) == list(validation.signals)


def test_parts_have_all_fields_of_the_files(result: sprung.Result) -> None:
    contents = json.loads(result.to_json())
    (first,) = contents["results"]
    parts = ((result.logs[0], contents["log"]), (result.promise[0], first["promise"][0]))
    for part, given in parts:
        assert set(given) <= {field.name for field in dataclasses.fields(part)}
    assert result.logs[0].recorded == contents["log"]["recorded"] > 0


def test_errors_pickle(experiment: sprung.Experiment) -> None:
    with pytest.raises(sprung.ExperimentError) as caught:
        sprung.Experiment.demo(["identify.estimator=magic"])
    back = pickle.loads(pickle.dumps(caught.value))
    assert str(back) == str(caught.value) and back.code == caught.value.code


def test_results_differ(experiment: sprung.Experiment, result: sprung.Result) -> None:
    assert experiment.identify(experiment.simulate(seed=9)) != result
    assert sprung.Experiment.demo() != experiment


def _in_a_child(seed: int) -> float:
    experiment = sprung.Experiment.demo({"identify.estimator": "least-squares"})
    value = experiment.identify(experiment.simulate(seed=seed)).parameters["joint1.stiffness"].value
    assert value is not None
    return value


def test_forked_processes_identify(result: sprung.Result) -> None:
    """The parent has run before the fork, so its threads are gone in the child."""
    with multiprocessing.get_context("fork").Pool(2) as pool:
        values = pool.map_async(_in_a_child, [1, 1]).get(timeout=60)
    assert values == [_in_a_child(1)] * 2


def test_an_experiment_from_a_dict_and_a_text(tmp_path: Path, experiment: sprung.Experiment) -> None:
    table = {
        "format": 1,
        "robot": {
            "name": "one",
            "kinematics": "planar-2r",
            "nominal": {"link2.inertia": np.float64(0.3)},
            "joint": [{"name": "a"}, {"name": "b"}],
        },
    }
    from_dict = sprung.Experiment(table)
    assert from_dict.joints == ["a", "b"] and "a.stiffness" in from_dict.parameter_units
    path = from_dict.save(tmp_path / "experiment.toml")
    assert sprung.Experiment(path).parameter_units == from_dict.parameter_units
    again = sprung.Experiment.from_text(from_dict.text, {"robot.name": "two"})
    assert again.robot == "two"
