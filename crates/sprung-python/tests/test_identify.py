"""Identification: the same bits from every kind of log, and from the command line."""

from __future__ import annotations

import json
import subprocess
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung
from sprung._report import _without_times

Log = dict[str, NDArray[np.float64]]
LEAST_SQUARES = ["identify.estimator=least-squares"]


def bits(result: sprung.Result) -> list[tuple[str, float | None, float | None]]:
    return [
        (parameter.name, parameter.value, parameter.standard_error)
        for parameter in result.parameters.values()
    ]


def test_the_demo_is_identified(experiment: sprung.Experiment, result: sprung.Result) -> None:
    truth = experiment.truth()
    assert set(result.parameters) == set(truth)
    for name, value in truth.items():
        parameter = result.parameters[name]
        assert parameter.value is not None and parameter.standard_error is not None
        assert abs(parameter.value - value) < 5.0 * parameter.standard_error, parameter
    assert result.verdict in {"good", "doubtful"}
    assert result.estimator == "least-squares"
    assert result.refinement is None


def test_all_kinds_of_logs_give_the_same_bits(
    experiment: sprung.Experiment, log: Log, quantities: Log, result: sprung.Result, tmp_path: Path
) -> None:
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    pyarrow = pytest.importorskip("pyarrow")
    csv = tmp_path / "log.csv"
    frame = pandas.DataFrame(log)
    frame.to_csv(csv, index=False, float_format="%.17g")
    table = pyarrow.table(log)
    several = pyarrow.concat_tables([table.slice(0, 4321), table.slice(4321)])
    fortran = {name: np.asfortranarray(array) for name, array in quantities.items()}
    logs: dict[str, Any] = {
        "quantities": quantities,
        "fortran": fortran,
        "pandas": frame.assign(other="text"),
        "polars": polars.DataFrame(log),
        "arrow": table,
        "chunks": several,
        "path": csv,
        "paths": [str(csv)],
        "strided": {name: np.repeat(array, 2)[::2] for name, array in log.items()},
    }
    for kind, one in logs.items():
        assert bits(experiment.identify(one)) == bits(result), kind


def test_no_array_is_copied(experiment: sprung.Experiment, quantities: Log) -> None:
    # So many samples that whatever else Python allocates is far smaller than one column.
    copies = 100
    long = {name: np.concatenate([array] * copies) for name, array in quantities.items()}
    long["t"] = np.arange(len(long["t"])) * quantities["t"][1]
    tracemalloc.start()
    try:
        experiment.identify(long)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 0.5 * long["t"].nbytes, peak


def test_threads_do_not_change_bits(
    experiment: sprung.Experiment, log: Log, result: sprung.Result
) -> None:
    assert bits(experiment.identify(log, threads=1)) == bits(result)


def test_the_command_line_gives_the_same_bits(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    command = [sys.executable, "-m", "sprung"]
    subprocess.run([*command, "demo", "--out", str(folder), "-q"], check=True)
    of_command = json.loads((folder / "sprung-out" / "identification.json").read_text())
    result = sprung.Experiment(folder).identify()
    assert _without_times(json.loads(result.to_json())) == _without_times(of_command)
    assert result.estimators[0] == "prediction-error"
    assert result.refinement is not None and result.refinement.used
    assert sprung.load(folder, result.experiment) == result


def test_several_logs_are_one_experiment(experiment: sprung.Experiment, log: Log) -> None:
    other = experiment.simulate(seed=5)
    both = experiment.identify([log, other])
    assert len(both.logs) == 2
    one = experiment.identify(log).parameters["joint1.stiffness"].standard_error
    two = both.parameters["joint1.stiffness"].standard_error
    assert one is not None and two is not None and two < one


def test_laws_of_earlier_results(
    experiment: sprung.Experiment, result: sprung.Result, log: Log
) -> None:
    with_offset = log | {"tau1_nm": log["tau1_nm"] + 2.0}
    earlier = experiment.identify(with_offset)
    new_parameters = set(earlier.parameters) - set(result.parameters)
    assert new_parameters, "the offset of the torque is a law that the log asks for"
    again = experiment.identify(log, laws_from=[result, earlier])
    assert list(again.parameters) == list(earlier.parameters)
    given = [unknown.status for unknown in again.unknowns if unknown.law is not None]
    assert given == ["given"] * len(new_parameters)
    other = sprung.Experiment.demo({"robot.name": "other"})
    with pytest.raises(sprung.SprungError, match='its robot is "'):
        other.identify(log, laws_from=[result])


def test_covariance_has_the_standard_errors(result: sprung.Result) -> None:
    covariance = result.covariance
    assert np.allclose(covariance, covariance.T, rtol=0, atol=0)
    assert np.linalg.eigvalsh(covariance / np.sqrt(np.outer(*[np.diag(covariance)] * 2))).min() > 0
    for name, variance in zip(result.covariance_names, np.diag(covariance), strict=True):
        error = result.parameters[name].standard_error
        assert error is not None
        assert abs(np.sqrt(variance) / error - 1.0) < 1e-9


def test_check_validate_and_compare(
    experiment: sprung.Experiment, log: Log, result: sprung.Result
) -> None:
    check = experiment.check(log)
    assert not check.refused
    assert all(finding.severity in {"info", "warning"} for finding in check.findings)
    assert check.unknowns == []
    other = experiment.simulate(seed=3)
    validation = result.validate(other)
    assert [run.name for run in validation.runs] == ["direct"]
    assert not validation.runs[0].same_log
    assert result.logs[0].file.startswith("arrays ")
    assert result.validate([log, other]).runs[0].same_log
    assert validation.runs[0].sets[0].promise_kept
    comparison = sprung.compare([result, experiment.identify(other)], ["a", "b"])
    assert [entry.label for entry in comparison.compared] == ["a", "b"]
    assert comparison.conclusion


def test_a_late_channel_is_found_and_used(experiment: sprung.Experiment, log: Log) -> None:
    torque = log["tau2_nm"]
    late = {**log, "tau2_nm": np.concatenate([np.full(20, torque[0]), torque[:-20]])}
    for unknowns in (experiment.check(late).unknowns, experiment.identify(late).unknowns):
        (unknown,) = unknowns
        assert (unknown.kind, unknown.place, unknown.status) == ("delay", "tau2_nm", "applied")
        assert unknown.value == pytest.approx(0.02, abs=2e-3)


def test_tables(result: sprung.Result) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    frame = result.parameters.to_pandas()
    stiffness = result.parameters["joint1.stiffness"]
    assert frame.loc["joint1.stiffness", "value"] == stiffness.value
    assert stiffness.ci95 is not None
    assert frame.loc["joint1.stiffness", "ci95_low"] == stiffness.ci95[0]
    table = result.parameters.to_arrow()
    assert table.column("name").to_pylist() == list(result.parameters)


def test_report_and_files(result: sprung.Result, tmp_path: Path) -> None:
    path = result.report(tmp_path / "report.html")
    page = path.read_text()
    assert page.startswith("<!DOCTYPE html>") and "joint1.stiffness" in page
    assert result._repr_html_().startswith("<iframe srcdoc=")
    folder = result.save(tmp_path / "out")
    assert (folder / "identification.json").read_text() == result.to_json()
    names = {path.name for path in folder.iterdir()}
    assert names == {
        "identification.json", "parameters.csv", "trace.csv", "fit.csv", "report.html",
    }
    with pytest.raises(sprung.FileError) as error:
        result.report("/proc/none/report.html")
    assert error.value.remedy


def test_export(result: sprung.Result, tmp_path: Path) -> None:
    texts = result.export("urdf", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(texts)
    assert any("<robot" in text for text in texts.values())
    with pytest.raises(sprung.InputError, match="not known"):
        result.export("docx")
