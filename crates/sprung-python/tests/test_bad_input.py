"""Bad input gives an exception with code, place and remedy; nothing else is lost."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung

Log = dict[str, NDArray[np.float64]]


def refused(experiment: sprung.Experiment, log: Any) -> sprung.SprungError:
    with pytest.raises(sprung.SprungError) as caught:
        experiment.identify(log)
    error = caught.value
    assert error.remedy, error
    return error


def test_wrong_experiments_name_the_line() -> None:
    text = 'format = 1\n[robot]\nname = "a"\nkinematics = "planar-3r"\n'
    with pytest.raises(sprung.ExperimentError) as caught:
        sprung.Experiment.from_text(text, name="own.toml")
    assert caught.value.place == "line 4 of own.toml"
    with pytest.raises(sprung.FileError):
        sprung.Experiment("/none/experiment.toml")
    with pytest.raises(sprung.InputError):
        sprung.Experiment({"robot": object()})


def test_float32_is_converted_and_said(experiment: sprung.Experiment, log: Log) -> None:
    float32_log = {
        name: array if name == "t_s" else array.astype(np.float32) for name, array in log.items()
    }
    with pytest.warns(sprung.SprungWarning, match="float32 and was converted") as caught:
        result = experiment.identify(float32_log)
    assert {warning.filename for warning in caught} == {__file__}
    assert result.parameters["joint1.stiffness"].value is not None


def test_shapes(experiment: sprung.Experiment, quantities: Log) -> None:
    error = refused(experiment, quantities | {"q": quantities["q"][:, :1].repeat(3, axis=1)})
    assert "3 columns" in str(error) and "joint1, joint2" in str(error)
    error = refused(experiment, quantities | {"q": quantities["q"][:100]})
    assert "100" in str(error)
    error = refused(experiment, quantities | {"q": np.zeros((4, 2, 2))})
    assert error.code == "shape"
    error = refused(experiment, {"t": 1.0})
    assert error.code == "shape"


def test_types(experiment: sprung.Experiment, quantities: Log) -> None:
    error = refused(experiment, quantities | {"q": quantities["q"].astype(object)})
    assert "objects of type float" in str(error)
    error = refused(experiment, quantities | {"q": quantities["q"] * 1j})
    assert "complex128" in str(error)
    error = refused(experiment, quantities | {"torque": quantities["tau"]})
    assert '"torque"' in str(error)
    assert refused(experiment, 5).code == "log"
    assert refused(experiment, []).code == "log"
    assert refused(experiment, ["a.csv", quantities]).code == "log"


def test_missing_values(experiment: sprung.Experiment, quantities: Log) -> None:
    tau = quantities["tau"].copy()
    tau[77, 1] = np.nan
    error = refused(experiment, quantities | {"tau": tau})
    assert isinstance(error, sprung.LogError)
    assert error.place is not None and "78" in error.place and "tau.joint2" in error.place
    masked = np.ma.masked_array(quantities["tau"], mask=False)
    masked[77, 1] = np.ma.masked
    error = refused(experiment, quantities | {"tau": masked})
    assert error.place is not None and "78" in error.place


def test_times_with_a_zone(experiment: sprung.Experiment, log: Log) -> None:
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(log)
    stamps = pandas.to_datetime((log["t_s"] * 1e9).round().astype("int64"), utc=True)
    frame["t_ns"] = stamps.tz_convert("Europe/Berlin")
    demo = sprung.Experiment.demo(
        ["identify.estimator=least-squares"]
    )
    by_quantity = {
        "time_ns": frame["t_ns"].to_numpy(dtype="datetime64[ns]"),
        "q": frame[["q1_rad", "q2_rad"]].to_numpy(),
        "phi": frame[["phi1_rad", "phi2_rad"]].to_numpy(),
        "tau": frame[["tau1_nm", "tau2_nm"]].to_numpy(),
    }
    value = demo.identify(by_quantity).parameters["joint1.stiffness"].value
    expected = experiment.identify(log).parameters["joint1.stiffness"].value
    assert value == pytest.approx(expected, rel=1e-6)


def test_a_missing_column_is_named(experiment: sprung.Experiment, log: Log) -> None:
    partial_log = {name: array for name, array in log.items() if name != "tau2_nm"}
    error = refused(experiment, partial_log)
    assert "tau2_nm" in str(error)


def test_a_refused_log_has_findings(experiment: sprung.Experiment, log: Log) -> None:
    altered_log = log | {"tau1_nm": np.zeros_like(log["tau1_nm"])}
    error = refused(experiment, altered_log)
    assert isinstance(error, sprung.LogError) and error.findings
    assert error.code == error.findings[0].code


def test_warnings_have_findings(log: Log) -> None:
    # Positions of a tenth of the range hardly excite Coulomb friction and inertia.
    experiment = sprung.Experiment.demo({"identify.estimator": "lsff"})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = experiment.identify(log)
    said = [
        warning.message for warning in caught if isinstance(warning.message, sprung.SprungWarning)
    ]
    severe = [finding for finding in result.findings if finding.severity in {"warning", "serious"}]
    assert [message.finding for message in said] == severe
