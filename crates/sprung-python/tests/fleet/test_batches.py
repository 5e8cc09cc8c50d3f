"""The function that other engines map over logs: the same rows and files as Dask, only for missing logs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import fleets
import pytest

from sprung import fleet
from sprung.fleet.arrow import pa


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", fleets.environment()["PYTHONPATH"])


def whole(manifest: Path, out: Path, identify_one: Any = fleets.identification) -> dict[str, bytes]:
    """The files that `identify` writes."""
    fleet.identify(manifest, out=out, workers=1, logs_per_part=5, progress=False, identify_one=identify_one)
    return fleets.contents(out)


def missing(manifest: Path, out: Path, **more: Any) -> Any:
    return fleet.missing_logs(manifest, out=out, logs_per_part=5, **more)


def identified(todo: Any, rows: int, identify_one: Any = fleets.identification) -> list[Any]:
    """What an engine computes whose batches have a number of rows."""
    return [fleet.identify_batch(batch, identify_one=identify_one) for batch in todo.to_batches(max_chunksize=rows)]


@pytest.mark.parametrize("rows", [1, 2, 5, 100])
def test_the_files_are_those_of_identify(tmp_path: Path, rows: int) -> None:
    manifest = fleets.manifest(tmp_path)
    (tmp_path / "log-4.csv").unlink()
    todo = missing(manifest, tmp_path / "out")
    summary = fleet.write_rows(identified(todo, rows, fleets.reads), todo, out=tmp_path / "out")
    assert (summary.tasks, summary.failed) == (12, 1)
    assert fleets.contents(tmp_path / "out") == whole(manifest, tmp_path / "whole", fleets.reads)


def test_real_logs_give_the_rows_of_identify(tmp_path: Path) -> None:
    manifest = fleets.simulated(tmp_path / "logs", robots=2, logs=2)
    todo = fleet.missing_logs(manifest, out=tmp_path / "out", overrides=fleets.OVERRIDES)
    rows = fleet.identify_batch(todo, overrides=fleets.OVERRIDES)
    assert rows.schema == fleet.schema() and rows.filter(pa.compute.equal(rows["kind"], "parameter")).num_rows == 60
    fleet.write_rows([rows], todo, out=tmp_path / "out")
    fleet.identify(manifest, out=tmp_path / "whole", overrides=fleets.OVERRIDES, workers=1, progress=False)
    assert fleets.contents(tmp_path / "out") == fleets.contents(tmp_path / "whole")


def test_batches_in_another_order_cut_anywhere_and_with_large_texts_give_the_same_files(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    todo = missing(manifest, tmp_path / "out")
    rows = pa.concat_tables(identified(todo, 1)[::-1])
    large = [pa.field(one.name, pa.large_string() if one.type == pa.string() else one.type) for one in rows.schema]
    cut = [rows.cast(pa.schema(large)).slice(start, 3) for start in range(0, rows.num_rows, 3)]
    fleet.write_rows(cut, todo, out=tmp_path / "out")
    assert fleets.contents(tmp_path / "out") == whole(manifest, tmp_path / "whole")


def test_a_second_run_identifies_new_logs_only(tmp_path: Path) -> None:
    """Both ways see the same dataset: each identifies what the other has left."""
    manifest = fleets.manifest(tmp_path, robots=2)

    def by_identify() -> None:
        fleet.identify(manifest, out=tmp_path / "out", workers=1, progress=False, identify_one=fleets.counts_calls)

    def by_batches() -> None:
        todo = missing(manifest, tmp_path / "out")
        fleet.write_rows(identified(todo, 2, fleets.counts_calls), todo, out=tmp_path / "out")

    by_identify()
    assert fleets.calls(tmp_path) == [f"log-{number}.csv" for number in range(6)]
    by_identify()
    by_batches()
    assert fleets.calls(tmp_path) == []
    fleets.manifest(tmp_path, robots=3)
    by_batches()
    assert fleets.calls(tmp_path) == ["log-6.csv", "log-7.csv", "log-8.csv"]
    fleets.manifest(tmp_path, robots=4)
    by_identify()
    assert fleets.calls(tmp_path) == ["log-10.csv", "log-11.csv", "log-9.csv"]
    assert fleet.Dataset.read(tmp_path / "out").rows("parameter").num_rows == 12


def test_failures_and_changed_experiments_are_replaced(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path, robots=2)
    (tmp_path / "log-4.csv").unlink()
    out = tmp_path / "out"
    todo = missing(manifest, out)
    assert fleet.write_rows(identified(todo, 2, fleets.reads), todo, out=out).failed == 1
    (tmp_path / "log-4.csv").write_text("4\n")
    assert missing(manifest, out).num_rows == 0
    todo = missing(manifest, out, retry_failures=True)
    assert [Path(log).name for log in todo["log"].to_pylist()] == ["log-4.csv"]
    assert fleet.write_rows(identified(todo, 2, fleets.reads), todo, out=out).failed == 0
    (tmp_path / "experiment.toml").write_text("format = 1  # changed\n")
    todo = missing(manifest, out)
    assert todo.num_rows == 6
    fleet.write_rows(identified(todo, 2), todo, out=out)
    rows = fleet.Dataset.read(out)
    assert rows.rows("failure").num_rows == 0 and rows.rows("parameter").num_rows == 6


def test_missing_rows_are_named_and_the_others_are_written(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    todo = missing(manifest, tmp_path / "out")
    rows = identified(todo, 1)
    with pytest.raises(fleet.FleetError, match="1 of 12 logs have no rows") as caught:
        fleet.write_rows(rows[:3] + rows[4:], todo, out=tmp_path / "out")
    assert caught.value.code == "rows-missing" and caught.value.remedy
    # The part of the lost log has five.
    todo = missing(manifest, tmp_path / "out")
    assert todo.num_rows == 5
    fleet.write_rows(identified(todo, 5), todo, out=tmp_path / "out")
    assert fleets.contents(tmp_path / "out") == whole(manifest, tmp_path / "whole")


def test_an_experiment_that_only_one_side_can_read_keeps_its_task(tmp_path: Path) -> None:
    """The caller cannot see the disk of the workers, or a worker loses its own."""
    manifest = fleets.manifest(tmp_path)
    path = tmp_path / "experiment.toml"
    for name, before in (("caller", False), ("worker", True)):
        if not before:
            path.unlink()
        todo = missing(manifest, tmp_path / name)
        if before:
            path.unlink()
        else:
            path.write_text("format = 1\n")
        summary = fleet.write_rows(identified(todo, 4), todo, out=tmp_path / name)
        assert summary.tasks == 12
        path.write_text("format = 1\n")


def test_wrong_rows_are_refused(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path, robots=1)
    out = tmp_path / "out"
    todo = missing(manifest, out, overrides=["a=1"])
    rows = pa.concat_tables(identified(todo, 3))
    with pytest.raises(fleet.FleetError, match="the same overrides as missing_logs") as caught:
        fleet.write_rows([rows], todo, out=out)
    assert caught.value.code == "rows-unknown" and "log-0.csv" in str(caught.value)
    right = fleet.identify_batch(todo, overrides=["a=1"], identify_one=fleets.identification)
    order = right.sort_by([("kind", "ascending")])
    with pytest.raises(fleet.FleetError, match="do not sort or shuffle") as caught:
        fleet.write_rows([order], todo, out=out)
    assert caught.value.code == "rows-scattered"
    with pytest.raises(fleet.FleetError, match="come twice"):
        fleet.write_rows([right, right], todo, out=out)
    with pytest.raises(fleet.DatasetError, match="no column remedy") as refused:
        fleet.write_rows([right.drop_columns(["remedy"])], todo, out=out)
    assert refused.value.code == "rows-columns"
    with pytest.raises(fleet.FleetError, match="todo has no column part, task"):
        fleet.write_rows([right], todo.drop_columns(["part", "task"]), out=out)
    with pytest.raises(fleet.DatasetError, match="has no dataset"):
        fleet.write_rows([right], todo, out=tmp_path / "nothing")


def test_wrong_batches_and_manifests_are_refused(tmp_path: Path) -> None:
    path = fleets.manifest(tmp_path)
    with pytest.raises(fleet.ManifestError, match="the manifest of the batch has no column log"):
        fleet.identify_batch(pa.table({"robot": ["a"], "experiment": ["e"]}))
    with pytest.raises(fleet.DatasetError, match="column value"):
        fleet.missing_logs(pa.table({"robot": ["a"], "experiment": ["e"], "log": ["l"], "value": [1.0]}), out=tmp_path)
    with pytest.raises(fleet.ManifestError, match="covariate part"):
        fleet.missing_logs(pa.table({"robot": ["a"], "experiment": ["e"], "log": ["l"], "part": [1]}), out=tmp_path)
    with pytest.raises(ValueError, match="logs_per_part is 0"):
        fleet.missing_logs(path, out=tmp_path / "out", logs_per_part=0)
    path.write_text("")
    with pytest.raises(fleet.ManifestError, match="no rows") as caught:
        fleet.missing_logs(path, out=tmp_path / "out")
    assert caught.value.code == "manifest-empty" and not (tmp_path / "out").exists()


def test_an_empty_batch_has_the_columns_of_the_others(tmp_path: Path) -> None:
    todo = missing(fleets.manifest(tmp_path), tmp_path / "out")
    rows = fleet.identify_batch(todo.slice(0, 0), identify_one=fleets.identification)
    assert rows.num_rows == 0 and rows.schema == fleet.schema(["temperature_c"])


def test_rows_of_a_manifest_are_identified_without_a_dataset(tmp_path: Path) -> None:
    """A failure is a row, and the folder of the caller counts for relative paths."""
    table = pa.table({"robot": [1], "experiment": [str(tmp_path)], "log": [str(tmp_path / "lost.csv")]})
    (row,) = fleet.identify_batch(table).to_pylist()
    assert row["kind"] == "failure" and row["code"] == "file-missing" and row["robot"] == "1" and row["time"] is None
