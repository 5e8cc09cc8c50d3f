"""The report reads its dataset parameter by parameter, and its page is that of all rows in memory."""

from __future__ import annotations

import datetime
import json
from pathlib import Path

import numpy as np
import pytest

from sprung import fleet
from sprung.fleet import dataset, estimates
from sprung.fleet.arrow import pa, pc, pq
from sprung.fleet.manifest import Task

START = datetime.datetime(2026, 1, 1, tzinfo=datetime.timezone.utc)
PARAMETERS = ("joint1.stiffness", "joint1.motor_viscous", "joint2.stiffness")


def drawn(out: Path, robots: int, logs: int, failures: int = 0) -> Path:
    """A dataset of many parts, with two estimators and logs in no order. A covariate came with the second half."""
    random = np.random.default_rng(2)
    dataset.prepare(str(out), {"overrides": []})
    tasks = []
    for number in range(robots * logs):
        robot, log = divmod(number, logs)
        time = START + datetime.timedelta(days=log)
        covariates = (("temperature_c", float(random.uniform(10, 40))),) if robot >= robots // 2 else ()
        tasks.append(Task(f"{number}", "log", f"robot{robot}", "e", (f"{log}.csv",), time, covariates))
    for position, number in enumerate(random.permutation(len(tasks))):
        rows = dataset.rows_of(tasks[number], identification(random))
        names = [name for name, _ in tasks[number].covariates]
        dataset.write_part(str(out), f"part-{position:04}", dataset.table_of(rows, names))
    for number in random.permutation(failures):
        lost = Task(f"lost{number}", "log", f"robot{number:04}", "e", (f"{number}.csv",), START, ())
        code = "file-missing" if number % 3 else "worker-died"
        row = dataset.failure_row(lost, code, f"{number} is lost", None, "look")
        dataset.write_part(str(out), f"part-lost{number:04}", dataset.table_of([row], []))
    return out


def identification(random: np.random.Generator) -> str:
    results = []
    for estimator in ("least-squares", "prediction-error"):
        parameters = [
            {"name": name, "unit": "1", "value": 1 + 0.01 * random.standard_normal(), "standard_error": 0.01}
            | {"identifiable": bool(random.random() > 0.1)}
            for name in PARAMETERS
        ]
        results.append({"estimator": estimator, "parameters": parameters})
    return json.dumps({"log": {"samples": 1}, "results": results})


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return drawn(tmp_path_factory.mktemp("estimates") / "out", robots=12, logs=6, failures=250)


def test_the_analysis_is_that_of_all_rows_at_once(made: Path) -> None:
    table = fleet.Dataset.read(made).rows("parameter").to_pandas()
    table = table[(table.estimator == "least-squares") & table.identifiable.astype(bool)]
    expected = fleet.analyse(
        fleet.Rows(
            robot=table.robot.to_numpy(object),
            parameter=table.parameter.to_numpy(object),
            unit=table.unit.to_numpy(object),
            value=table.value.to_numpy(float),
            standard_error=table.standard_error.to_numpy(float),
            time_s=table.time.dt.tz_localize(None).to_numpy("datetime64[us]").astype(np.int64) * 1e-6,
            covariates={"temperature_c": table.temperature_c.to_numpy(float)},
        )
    )
    found = fleet.report(made).analysis
    assert [one.parameter for one in found.populations] == sorted(PARAMETERS)
    for one, other in zip(found.populations, expected.populations, strict=True):
        assert one.scatter == other.scatter and one.robots == other.robots and one.central == other.central
        assert one.tested_for_drift == other.tested_for_drift > 0
        assert [(moved.robot, moved.drift) for moved in one.drifts] == [
            (moved.robot, moved.drift) for moved in other.drifts
        ]


@pytest.mark.parametrize("estimator", [None, "prediction-error"])
def test_the_page_does_not_depend_on_what_memory_holds(
    made: Path, monkeypatch: pytest.MonkeyPatch, estimator: str | None
) -> None:
    expected = fleet.report(fleet.Dataset.read(made), estimator=estimator).html
    assert fleet.report(made, estimator=estimator).html == expected
    monkeypatch.setattr(estimates, "ESTIMATES_AT_A_TIME", 1)
    monkeypatch.setattr(estimates, "TABLES_AT_A_TIME", 3)
    assert fleet.report(made, estimator=estimator).html == expected


def test_memory_holds_the_estimates_of_few_parameters(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    held: list[int] = []
    whole = estimates._Collected.table

    def table(self: estimates._Collected) -> object:
        found = whole(self)
        held.append(found.num_rows)
        return found

    monkeypatch.setattr(estimates._Collected, "table", table)
    monkeypatch.setattr(estimates, "ESTIMATES_AT_A_TIME", 140)
    fleet.report(made)
    # Three parameters of 72 logs, of which one in ten is not identifiable: two of them fit.
    assert len(held) == 2 and max(held) <= 140 and sum(held) > 180


def test_the_first_failures_are_shown_and_all_are_counted(made: Path) -> None:
    page = fleet.report(made).html
    assert "166 of file-missing, 84 of worker-died." in page and "The first 200 of 250." in page
    assert "199 is lost" in page and "200 is lost" not in page
    assert "<b>250</b><span>failures</span>" in page
    # 250 robots whose logs failed, and twelve others.
    assert "<b>262</b><span>robots</span>" in page and "<b>322</b><span>logs</span>" in page


@pytest.mark.parametrize("logs", [1, 2, 12])
def test_one_robot_has_a_report_that_says_what_cannot_be_told(tmp_path: Path, logs: int) -> None:
    made = fleet.report(drawn(tmp_path / "out", robots=1, logs=logs))
    assert made.analysis.outliers() == []
    assert "The dataset has one robot." in made.html and "nan" not in made.html
    for population in made.analysis.populations:
        assert population.scatter.robots == 1 and np.isnan(population.scatter.between)
        assert np.isnan(population.scatter.within) == (population.scatter.logs == 1)
        assert (population.tested_for_drift == 1) == (logs == 12)
    assert "The dataset has one robot." not in fleet.report(drawn(tmp_path / "two", robots=2, logs=1)).html


def part_of(out: Path) -> Path:
    return next(out.glob("*.parquet"))


@pytest.mark.parametrize(("version", "code"), [("2", "dataset-newer"), ("-1", "dataset-format")])
def test_parts_of_another_format_are_refused(tmp_path: Path, version: str, code: str) -> None:
    out = drawn(tmp_path / "out", robots=2, logs=2)
    part = part_of(out)
    pq.write_table(pq.read_table(part).replace_schema_metadata({"sprung_fleet_format": version}), part)
    for call in (lambda: fleet.report(out), lambda: fleet.Dataset.read(out), lambda: dataset.done(str(out))):
        with pytest.raises(fleet.DatasetError, match=f"{part.name} has format {version}, .* knows format 1 only") as caught:
            call()
        assert caught.value.code == code and caught.value.remedy and caught.value.place == str(part)


def test_parts_with_other_columns_are_refused(tmp_path: Path) -> None:
    out = drawn(tmp_path / "out", robots=2, logs=2)
    part = part_of(out)
    table = pq.read_table(part)
    texts = pc.cast(table["value"], pa.string())
    wrong = {
        "no column verdict, no column code": table.drop_columns(["code", "verdict"]),
        "value of type string instead of double": table.set_column(table.column_names.index("value"), "value", texts),
        "operator of type string instead of double": table.append_column("operator", table["robot"]),
    }
    for words, wrong_table in wrong.items():
        pq.write_table(wrong_table, part)
        with pytest.raises(fleet.DatasetError, match=f"{part.name} has other columns .*{words}") as caught:
            fleet.report(out)
        assert caught.value.code == "dataset-columns" and "remove this file" in str(caught.value.remedy)
    pq.write_table(table.append_column("operation_h", pc.multiply(table["value"], 1.0)), part)
    assert "operation_h" in fleet.Dataset.read(out).covariates


def test_a_dataset_without_estimates_is_refused(tmp_path: Path) -> None:
    out = drawn(tmp_path / "out", robots=1, logs=0, failures=3)
    with pytest.raises(fleet.DatasetError, match="no parameters of single logs by any estimator; it has those of none"):
        fleet.report(out)
