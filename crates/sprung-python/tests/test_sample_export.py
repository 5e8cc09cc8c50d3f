"""Drawn robots as files, as arrays for MuJoCo, and as a dictionary."""

from __future__ import annotations

import json
import importlib
import pickle
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

EXAMPLES = Path(__file__).parents[3] / "examples"
LEAST_SQUARES = {"identify.estimator": "least-squares"}


def identified(source: Any, overrides: dict[str, Any] | None = None) -> sprung.Result:
    experiment = sprung.Experiment(source, LEAST_SQUARES | (overrides or {}))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return experiment.identify(experiment.simulate())


@pytest.fixture(scope="module")
def arm() -> sprung.Result:
    """A robot from a URDF."""
    return identified(EXAMPLES / "two-joint-arm" / "twin.toml")


@pytest.fixture(scope="module")
def seven() -> sprung.Result:
    """A robot from a table of Denavit and Hartenberg."""
    return identified(EXAMPLES / "seven-joint-twin", {"simulate.duration_s": 6.0})


@pytest.fixture(params=["result", "arm", "seven"])
def any_result(request: pytest.FixtureRequest) -> sprung.Result:
    result: sprung.Result = request.getfixturevalue(request.param)
    return result


def fields_of(model: Any) -> dict[str, NDArray[Any]]:
    """Returns all numbers of a compiled model by name."""
    found = {}
    groups = [("", model)] + [(f"{name}.", getattr(model, name)) for name in ("opt", "stat", "vis")]
    for prefix, group in groups:
        for name in dir(group):
            value = None if name.startswith("_") else getattr(group, name)
            if (
                isinstance(value, bool | int | float | np.ndarray)
                and np.asarray(value).dtype.kind in "biuf"
            ):
                found[prefix + name] = np.array(value)
    return found


def inertias(moments: NDArray[np.float64], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns inertia matrices from principal moments and quaternions, which are not unique."""
    w, vector = axes[..., 0], axes[..., 1:]
    skew = np.cross(np.eye(3), vector[..., None, :]).swapaxes(-1, -2)
    turn = np.eye(3) + 2.0 * w[..., None, None] * skew + 2.0 * skew @ skew
    matrices: NDArray[np.float64] = (turn * moments[..., None, :]) @ turn.swapaxes(-1, -2)
    return matrices


@pytest.mark.parametrize("rigid", [False, True])
def test_arrays_are_those_of_the_models_that_mujoco_compiles(
    any_result: sprung.Result, rigid: bool, tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    samples = any_result.sample(20, seed=4)
    arrays, paths = samples.to_mujoco(rigid=rigid), samples.export("mjcf", tmp_path, rigid=rigid)
    base = mujoco.MjModel.from_xml_string(any_result.export("mjcf", rigid=rigid)["robot.xml"])
    for kind, names in (("BODY", arrays.bodies), ("JOINT", arrays.joints), ("TENDON", arrays.tendons)):
        kind = getattr(mujoco.mjtObj, f"mjOBJ_{kind}")
        assert names == [mujoco.mj_id2name(base, kind, at) for at in range(len(names))]
    assert (base.nbody, base.nv, base.ntendon) == (
        len(arrays.bodies), len(arrays.joints), len(arrays.tendons)
    )
    fields, derived, of_base = arrays.fields(), arrays.derived(base), fields_of(base)
    changed = set()
    for robot, path in enumerate(paths):
        compiled = fields_of(mujoco.MjModel.from_xml_path(str(path)))
        assert compiled.keys() == of_base.keys()
        changed |= {
            name for name, value in compiled.items() if not np.array_equal(value, of_base[name])
        }
        for name, array in fields.items():
            if name != "body_iquat":
                assert np.allclose(array[robot], compiled[name], rtol=1e-9, atol=1e-15), name
        of_arrays = inertias(fields["body_inertia"][robot], fields["body_iquat"][robot])
        of_file = inertias(compiled["body_inertia"], compiled["body_iquat"])
        assert np.allclose(of_arrays, of_file, rtol=0.0, atol=1e-9 * np.abs(of_file).max())
        for name, array in derived.items():
            assert np.allclose(array[robot], compiled[name], rtol=1e-6, atol=1e-9), name
    known = {*fields, *derived, "body_sameframe"}
    assert {name for name in changed - known if not name.startswith("stat.")} == set()
    assert {"body_mass", "body_ipos", "body_inertia", "dof_damping"} <= changed


def test_a_model_with_the_values_of_a_robot_moves_as_its_file(
    seven: sprung.Result, tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    samples = seven.sample(3)
    arrays = samples.to_mujoco()
    model = mujoco.MjModel.from_xml_string(seven.export("mjcf")["robot.xml"])
    for robot, path in enumerate(samples.export("mjcf", tmp_path)):
        arrays.apply(model, robot)
        data = mujoco.MjData(model)
        mujoco.mj_setConst(model, data)
        other = mujoco.MjModel.from_xml_path(str(path))
        ends = []
        for mj_model in (model, other):
            data = mujoco.MjData(mj_model)
            data.ctrl[:] = 5.0
            for _ in range(50):
                mujoco.mj_step(mj_model, data)
            ends.append(data.qpos.copy())
        assert np.abs(ends[0]).max() > 0.01
        assert np.allclose(ends[0], ends[1], rtol=0.0, atol=1e-9)


def test_arrays_refuse_the_models_of_other_robots(
    result: sprung.Result, arm: sprung.Result
) -> None:
    mujoco = pytest.importorskip("mujoco")
    arrays = arm.sample(2).to_mujoco()
    rigid = mujoco.MjModel.from_xml_string(arm.export("mjcf", rigid=True)["robot.xml"])
    with pytest.raises(sprung.InputError, match="with the same rigid"):
        arrays.apply(rigid, 0)
    with pytest.raises(sprung.InputError, match="body_mass has the shape None"):
        arrays.apply(object(), 0)
    with pytest.raises(IndexError, match="there are 2"):
        arrays.apply(rigid, 2)


def test_arrays_need_no_mujoco(arm: sprung.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str, package: str | None = None) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    arrays = arm.sample(2).to_mujoco()
    assert arrays.body_mass.shape == (2, 5) and len(arrays) == 2
    with pytest.raises(sprung.InputError, match="pip install mujoco"):
        arrays.derived(object())
    assert pickle.loads(pickle.dumps(arrays)) == arrays
    assert repr(arrays) == "<sprung.MujocoArrays of 2 robots with 5 bodies>"


@pytest.mark.parametrize("format", ["mjcf", "urdf", "sdf", "json"])
def test_files_are_those_of_the_export_with_other_values(
    any_result: sprung.Result, format: str, tmp_path: Path
) -> None:
    samples = any_result.sample(3, seed=9)
    paths = samples.export(format, tmp_path / "new" / "folder")
    (estimate,) = any_result.export(format).values()
    end = {"mjcf": "xml"}.get(format, format)
    assert [path.name for path in paths] == [f"robot-000{k}.{end}" for k in range(3)]
    assert sorted(paths[0].parent.iterdir()) == paths
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert len({*texts, estimate}) == 4
    for robot, text in enumerate(texts):
        if format == "json":
            assert f'"robot": {robot}' in text and '"seed": 9' in text
            continue
        draw = f"draw: robot {robot} of 3 from the posterior, counted from 0, seed 9; not the estimate"
        assert draw in text and "draw:" not in estimate and " ± " not in text
        shapes = [
            [(element.tag, sorted(element.attrib)) for element in ET.fromstring(xml).iter()]
            for xml in (text, estimate)
        ]
        assert shapes[0] == shapes[1]
    # A part of the robots, and another folder, give the same files.
    assert samples.export(format, tmp_path / "again")[2].read_bytes() == paths[2].read_bytes()


def test_files_hold_the_values_of_their_robot(arm: sprung.Result, tmp_path: Path) -> None:
    samples = arm.sample(5)
    assert samples.bodies is not None
    for robot, path in enumerate(samples.export("mjcf", tmp_path)):
        root = ET.parse(path).getroot()
        springs = [float(element.attrib["stiffness"]) for element in root.iter("fixed")]
        names = [f"{joint}.stiffness" for joint in ("shoulder", "elbow")]
        assert springs == [samples[robot][name] for name in names]
        masses = [float(element.attrib["mass"]) for element in root.iter("inertial")][:2]
        assert masses == samples.bodies.mass_kg[robot].tolist()


def test_friction_without_laws_that_mujoco_lacks(log: dict[str, NDArray[np.float64]]) -> None:
    laws = {"robot.joint.0.motor_friction": ["viscous", "coulomb", "quadratic"]}
    experiment = sprung.Experiment.demo({**LEAST_SQUARES, **laws})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = experiment.identify(log)
    samples = result.sample(300)
    arrays, values = samples.to_mujoco(), samples.to_dict()
    joint = arrays.joints.index("joint1_motor")
    dependence = json.loads(result.to_json())["results"][0]["dependence"]
    assert [item["name"] for item in dependence] == ["joint1.motor_viscous", "joint1.motor_coulomb"]
    for item, field in zip(dependence, (arrays.dof_damping, arrays.dof_frictionloss), strict=True):
        ((law, weight),) = item["weights"].items()
        of_estimate = item["raw"] + weight * (result.parameters[law].value or 0.0)
        assert of_estimate == pytest.approx(item["projected"], rel=1e-12)
        raw = values[item["name"]]
        assert np.allclose(field[:, joint], raw + weight * values[law], rtol=1e-12)
        # The log determines the sum of the laws better than each of them.
        assert field[:, joint].std() < 0.8 * raw.std()
        assert abs(field[:, joint].mean() - item["projected"]) < 0.2 * field[:, joint].std()


def test_names_of_many_files_sort(result: sprung.Result, tmp_path: Path) -> None:
    paths = result.sample(300).export("mjcf", tmp_path)
    assert [paths[0].name, paths[-1].name] == ["robot-0000.xml", "robot-0299.xml"]
    assert sorted(paths) == paths == sorted(tmp_path.iterdir())


def test_wrong_exports_are_refused(result: sprung.Result, tmp_path: Path) -> None:
    samples = result.sample(2)
    for format in ("c", "xml"):
        with pytest.raises(sprung.InputError, match="give one of mjcf, urdf, sdf, json") as caught:
            samples.export(format, tmp_path)
        assert caught.value.code == "format"
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(sprung.FileError, match="robot-0000.xml"):
        samples.export("mjcf", tmp_path / "file")


def test_a_dictionary_of_arrays(
    result: sprung.Result, arm: sprung.Result, seven: sprung.Result
) -> None:
    for identification in (result, arm, seven):
        samples = identification.sample(30)
        found = samples.to_dict()
        assert {*samples.parameters, *samples.constants} <= found.keys()
        for name, array in found.items():
            assert array.dtype == np.float64 and array.shape[0] == 30, name
            assert array.flags.writeable and array.flags.c_contiguous, name
        for at, name in enumerate(samples.parameters):
            assert np.array_equal(found[name], samples.theta[:, at])
        assert ("mass_kg" in found) == (samples.bodies is not None)
        for joint in identification.experiment.joints:
            assert found[f"{joint}.rotor_inertia"].shape == (30,)
    assert found["inertia_kgm2"].shape == (30, 7, 3, 3)
    assert found["centre_of_mass_m"].shape == (30, 7, 3)


def test_a_drawn_robot_can_be_simulated(
    experiment: sprung.Experiment, result: sprung.Result
) -> None:
    samples = result.sample(2)
    short = sprung.Experiment.demo(LEAST_SQUARES | {"simulate.duration_s": 1.0})
    logs = [short.simulate("prediction", result=robot, seed=3) for robot in (result, *samples)]
    assert len({log["q1_rad"].tobytes() for log in logs}) == 3
    again = short.simulate("prediction", result=dict(samples[1]), seed=3)
    assert all(np.array_equal(again[name], logs[2][name]) for name in again)
    with pytest.raises(sprung.ExperimentError):
        short.simulate(result={"joint1.stiffness": 3.0})
    with pytest.raises(sprung.InputError):
        short.simulate(result={"joint1.stiffness": "3"})  # type: ignore[dict-item]


def test_each_estimator_has_its_own_files() -> None:
    names = ["least-squares", "prediction-error"]
    experiment = sprung.Experiment.demo({"identify.estimator": names})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        both = experiment.identify(experiment.simulate())
        alone = sprung.Experiment.demo(LEAST_SQUARES)
        alone_result = alone.identify(alone.simulate())
    first, second = (both.by(name) for name in names)
    assert both.export("mjcf") == first.export("mjcf") == alone_result.export("mjcf")
    for format in ("mjcf", "urdf", "json", "c", "rust"):
        texts = [tuple(result.export(format).values()) for result in (first, second)]
        assert texts[0] != texts[1]
    stiffness = ET.fromstring(second.export("mjcf")["robot.xml"]).iter("fixed")
    value = second.parameters["joint1.stiffness"].value
    assert float(next(stiffness).attrib["stiffness"]) == value
    assert "estimator: prediction-error" in second.export("mjcf")["robot.xml"]
    logs = [experiment.simulate("prediction", result=result, seed=1) for result in (first, second)]
    assert not np.array_equal(logs[0]["q1_rad"], logs[1]["q1_rad"])
