"""Runs over a fleet: rows, resuming, workers that die, and input that is wrong."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import fleets
import pandas as pd
import pytest

from sprung import fleet
from sprung.fleet import dataset, files
from sprung.fleet.arrow import pa, pq


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", fleets.environment()["PYTHONPATH"])


def run(manifest: Any, out: Any, **more: Any) -> fleet.Summary:
    settings: dict[str, Any] = {"workers": 2, "logs_per_part": 2, "progress": False, "identify_one": fleets.identification}
    return fleet.identify(manifest, out=out, **(settings | more))


def test_the_same_numbers_as_one_identification(tmp_path: Path) -> None:
    from sprung import Experiment

    manifest = fleets.simulated(tmp_path / "logs", robots=2, logs=2)
    out = tmp_path / "out"
    summary = fleet.identify(
        manifest, out=out, overrides=fleets.OVERRIDES, levels=["log", "robot"], workers=2, progress=False
    )
    assert (summary.tasks, summary.failed, summary.resumed) == (6, 0, 0)
    rows = fleet.Dataset.read(str(out)).rows("parameter").to_pandas()
    folder = tmp_path / "logs" / "robot1"
    experiment = Experiment(folder / "experiment.toml", overrides=fleets.OVERRIDES)
    for level, logs in (("log", "log0.parquet"), ("robot", ["log0.parquet", "log1.parquet"])):
        paths = [str(folder / log) for log in ([logs] if isinstance(logs, str) else logs)]
        expected = json.loads(experiment.identify(paths[0] if level == "log" else paths).to_json())["results"][0]
        chosen = rows[(rows.robot == "robot1") & (rows.level == level)]
        if level == "log":
            chosen = chosen[chosen.log == paths[0]]
        found = dict(zip(chosen.parameter, chosen.value, strict=True))
        assert found == {parameter["name"]: parameter["value"] for parameter in expected["parameters"]}
    assert set(rows.unit[rows.parameter == "joint1.stiffness"]) == {"N·m/rad"}


def test_a_bad_log_fails_its_robot_and_leaves_the_others(tmp_path: Path) -> None:
    manifest = fleets.simulated(tmp_path / "logs", robots=2, logs=2)
    bad = tmp_path / "logs" / "robot0" / "log1.parquet"
    bad.write_bytes(b"torn")
    out = tmp_path / "out"
    settings: dict[str, Any] = {"overrides": fleets.OVERRIDES, "levels": ["robot"], "workers": 2, "progress": False}
    assert fleet.identify(manifest, out=out, **settings).failed == 1
    table = fleet.Dataset.read(str(out))
    (failure,) = table.rows("failure").to_pylist()
    assert "log1.parquet" in failure["text"] and failure["level"] == "robot" and failure["robot"] == "robot0"
    assert set(table.rows("parameter")["robot"].to_pylist()) == {"robot1"}
    again = tmp_path / "again"
    fleet.identify(manifest, out=again, **(settings | {"workers": 1}))
    assert fleets.contents(out) == fleets.contents(again)


def test_rows_are_read_by_pandas_and_duckdb(tmp_path: Path) -> None:
    import duckdb

    out = tmp_path / "out"
    run(fleets.manifest(tmp_path), out)
    table = pd.read_parquet(out)
    assert sorted(table.kind.unique()) == ["finding", "parameter"]
    assert table[table.kind == "parameter"].robot.value_counts().to_dict() == dict.fromkeys(
        ["000", "001", "002", "003"], 3
    )
    query = f"SELECT robot, avg(value) FROM '{out}/*.parquet' WHERE kind = 'parameter' GROUP BY robot ORDER BY robot"
    found = duckdb.sql(query)
    assert found is not None and found.fetchall() == [("000", 1.0), ("001", 4.0), ("002", 7.0), ("003", 10.0)]
    assert set(table.temperature_c) == {20.0, 21.0, 22.0}
    assert str(table.time.min()) == "2026-01-01 00:00:00+00:00"


def test_a_log_that_fails_is_a_row_and_is_repeated_on_request(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    missing = tmp_path / "log-4.csv"
    missing.unlink()
    summary = run(manifest, tmp_path / "out", identify_one=fleets.reads)
    assert summary.failed == 1
    (failure,) = fleet.Dataset.read(str(tmp_path / "out")).rows("failure").to_pylist()
    assert failure["code"] == "file-missing" and failure["robot"] == "001" and failure["log"] == str(missing)
    assert "does not exist" in failure["text"] and "manifest" in failure["remedy"]

    missing.write_text("4\n")
    assert run(manifest, tmp_path / "out", identify_one=fleets.reads).resumed == 12
    summary = run(manifest, tmp_path / "out", identify_one=fleets.reads, retry_failures=True)
    assert (summary.resumed, summary.failed) == (11, 0)
    found = fleet.Dataset.read(str(tmp_path / "out"))
    assert found.rows("failure").num_rows == 0 and found.rows("parameter").num_rows == 12


def test_a_missing_experiment_fails_its_logs_only(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    manifest.write_text(manifest.read_text().replace("001,experiment.toml", "001,other.toml"))
    assert run(manifest, tmp_path / "out", identify_one=fleets.reads).failed == 3


def test_a_run_resumes_and_gives_the_same_bytes(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    run(manifest, tmp_path / "whole")
    run(manifest, tmp_path / "resumed")
    whole = fleets.contents(tmp_path / "whole")
    parts = [name for name in whole if name.endswith(".parquet")]
    for name in parts[::2]:
        (tmp_path / "resumed" / name).unlink()
    summary = run(manifest, tmp_path / "resumed")
    assert 0 < summary.resumed < 12
    assert fleets.contents(tmp_path / "resumed") == whole
    assert run(manifest, tmp_path / "resumed").bytes == 0


def test_what_a_killed_writer_left_is_removed(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    run(manifest, tmp_path / "out")
    whole = fleets.contents(tmp_path / "out")
    (tmp_path / "out" / f".{next(iter(whole))}.0123456789abcdef.part").write_bytes(b"PAR1 torn")
    run(manifest, tmp_path / "out")
    assert fleets.contents(tmp_path / "out") == whole


def test_new_logs_are_added_and_a_changed_experiment_replaces_its_rows(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path, robots=2)
    run(manifest, tmp_path / "out")
    fleets.manifest(tmp_path, robots=3)
    assert run(manifest, tmp_path / "out").resumed == 6
    (tmp_path / "experiment.toml").write_text("format = 1  # changed\n")
    assert run(manifest, tmp_path / "out").resumed == 0
    assert fleet.Dataset.read(str(tmp_path / "out")).rows("parameter").num_rows == 9


def test_a_process_that_dies_is_replaced(tmp_path: Path) -> None:
    manifest = fleets.manifest(tmp_path)
    run(manifest, tmp_path / "whole")
    summary = run(manifest, tmp_path / "out", identify_one=fleets.dies_once)
    assert summary.repeated > 0 and summary.failed == 0
    assert fleets.contents(tmp_path / "out") == fleets.contents(tmp_path / "whole")


def test_a_log_that_always_kills_its_worker_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sprung.fleet.run.DEATHS", 2)
    manifest = fleets.manifest(tmp_path, robots=2)
    summary = run(manifest, tmp_path / "out", identify_one=fleets.dies, workers=1, in_flight=1)
    (failure,) = fleet.Dataset.read(summary.out).rows("failure").to_pylist()
    assert failure["code"] == "worker-died" and failure["log"].endswith("log-3.csv")
    assert fleet.Dataset.read(summary.out).rows("parameter").num_rows == 5


def test_progress_is_told(tmp_path: Path) -> None:
    heard: list[tuple[int, int]] = []
    run(fleets.manifest(tmp_path), tmp_path / "out", progress=lambda done, total: heard.append((done, total)))
    assert heard[-1] == (12, 12) and len(heard) == 6 and heard == sorted(heard)


def test_the_engine_has_few_parts_at_a_time(tmp_path: Path) -> None:
    from sprung.fleet.engines import Processes
    from sprung.fleet.manifest import Manifest
    from sprung.fleet.work import Settings, run_part

    manifest = Manifest.read(fleets.manifest(tmp_path, robots=20))
    taken = 0

    def parts() -> Any:
        nonlocal taken
        for one in manifest.parts((), ["log"], 1):
            taken += 1
            yield one

    most = 0
    engine = Processes(workers=2, in_flight=3)
    settings = Settings(str(tmp_path / "out"), (), manifest.covariates, fleets.identification)
    for finished, _ in enumerate(engine.run(run_part, settings, parts())):
        most = max(most, taken - finished)
    assert taken == 60 and most <= 3


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("robot,experiment", "arm,experiment", "manifest-columns", "no column robot"),
        ("001,experiment.toml,log-3.csv", "001,experiment.toml,", "manifest-value", "column log .* is empty in row 4"),
        ("001,experiment.toml,log-3.csv", "001,experiment.toml,log-4.csv", "manifest-duplicates", "robot 001, log log-4"),
        ("2026-01-01", "yesterday", "manifest-value", "column time .* no time"),
        ("temperature_c", "value", "manifest-columns", "column value"),
    ],
)
def test_wrong_manifests_are_refused(tmp_path: Path, old: str, new: str, code: str, words: str) -> None:
    path = fleets.manifest(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(fleet.FleetError, match=words) as caught:
        run(path, tmp_path / "out")
    assert caught.value.code == code and caught.value.remedy
    assert not (tmp_path / "out").exists()


def test_manifests_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    with pytest.raises(fleet.ManifestError, match=r"nothing.csv cannot be read"):
        run(tmp_path / "nothing.csv", tmp_path / "out")
    with pytest.raises(fleet.ManifestError, match="cannot be read"):
        run("http://127.0.0.1:9/manifest.csv", tmp_path / "out")
    with pytest.raises(fleet.ManifestError, match="cannot be read"):
        run("nosuch://bucket/manifest.csv", tmp_path / "out")
    (tmp_path / "empty.csv").write_text("robot,experiment,log\n")
    with pytest.raises(fleet.ManifestError, match="no rows"):
        run(tmp_path / "empty.csv", tmp_path / "out")
    (tmp_path / "torn.csv").write_bytes(b"PAR1 torn")
    with pytest.raises(fleet.ManifestError, match="neither Parquet nor CSV"):
        run(tmp_path / "torn.csv", tmp_path / "out")


def test_manifests_are_tables_too(tmp_path: Path) -> None:
    path = fleets.manifest(tmp_path)
    table = pd.read_csv(path, dtype={"robot": str})
    for column in ("experiment", "log"):
        table[column] = [str(tmp_path / name) for name in table[column]]
    run(path, tmp_path / "csv")
    run(table, tmp_path / "pandas")
    run(pa.Table.from_pandas(table), tmp_path / "arrow")
    assert fleets.contents(tmp_path / "csv") == fleets.contents(tmp_path / "pandas") == fleets.contents(tmp_path / "arrow")


def test_an_unreachable_log_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "PAUSE_S", 0.0)
    manifest = fleets.manifest(tmp_path)
    manifest.write_text(manifest.read_text().replace("log-3.csv", "http://127.0.0.1:9/log-3.csv"))
    summary = run(manifest, tmp_path / "out")
    (failure,) = fleet.Dataset.read(summary.out).rows("failure").to_pylist()
    assert failure["code"] == "file-unreachable" and "127.0.0.1:9" in failure["text"] and failure["remedy"]


def test_a_newer_dataset_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    run(fleets.manifest(tmp_path), out)
    about = json.loads((out / dataset.ABOUT).read_text())
    (out / dataset.ABOUT).write_text(json.dumps(about | {"format": 2}))
    for call in (lambda: run(tmp_path / "manifest.csv", out), lambda: fleet.Dataset.read(str(out))):
        with pytest.raises(fleet.DatasetError, match="format 2.*upgrade") as caught:
            call()
        assert caught.value.code == "dataset-newer"
    (out / dataset.ABOUT).write_text(json.dumps(about))
    part = next(out.glob("*.parquet"))
    table = pq.read_table(part)
    pq.write_table(table.replace_schema_metadata({"sprung_fleet_format": "2"}), part)
    with pytest.raises(fleet.DatasetError, match="format 2"):
        fleet.Dataset.read(str(out))


def test_other_settings_and_foreign_files_are_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    manifest = fleets.manifest(tmp_path)
    run(manifest, out)
    with pytest.raises(fleet.DatasetError, match="another folder"):
        run(manifest, out, overrides=["identify.estimator=least-squares"])
    pq.write_table(pa.table({"a": [1]}), out / "foreign.parquet")
    with pytest.raises(fleet.DatasetError, match="foreign.parquet is not a part"):
        run(manifest, out)
    (out / "foreign.parquet").write_bytes(b"torn")
    with pytest.raises(fleet.DatasetError, match="remove this file"):
        run(manifest, out)
    with pytest.raises(fleet.DatasetError, match="no dataset"):
        fleet.Dataset.read(str(tmp_path / "nowhere"))


@pytest.mark.parametrize("wrong", [{"levels": ["arm"]}, {"workers": 0}, {"logs_per_part": 0}, {"overrides": "a=b"}])
def test_wrong_arguments_are_refused(tmp_path: Path, wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError):
        run(fleets.manifest(tmp_path), tmp_path / "out", **wrong)


def test_a_full_disk_loses_nothing(tmp_path: Path) -> None:
    """A file system of 64 KiB, and space that comes later."""
    out = tmp_path / "out"
    out.mkdir()
    if os.geteuid() != 0 or os.system(f"mount -t tmpfs -o size=64k tmpfs {out} 2>/dev/null") != 0:
        pytest.skip("no right to mount a small file system")
    try:
        manifest = fleets.manifest(tmp_path, robots=8)
        with pytest.raises(fleet.FleetError, match="No space left.*resumes") as caught:
            run(manifest, out, logs_per_part=1)
        assert caught.value.code == "parts-missing"
        written = pd.read_parquet(out)
        assert 0 < len(written) < 48
        assert not [path for path in out.iterdir() if path.name.endswith(".part")]
        assert os.system(f"mount -o remount,size=4m {out}") == 0
        assert run(manifest, out, logs_per_part=1).resumed > 0
        run(manifest, tmp_path / "whole", logs_per_part=1)
        assert fleets.contents(out) == fleets.contents(tmp_path / "whole")
    finally:
        os.system(f"umount {out}")


def test_a_full_disk_of_one_worker_is_worked_around(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first writing fails, as on a worker whose disk is full; another worker writes the part."""
    from sprung.fleet import run as runs

    class InThisProcess:
        def __init__(self) -> None:
            self.repeated: list[Any] = []

        def again(self, part: Any) -> None:
            self.repeated.append(part)

        def run(self, function: Any, settings: Any, parts: Any) -> Any:
            for part in parts:
                with pytest.MonkeyPatch.context() as patch:
                    patch.setattr(files, "write", fleets.full_disk)
                    try:
                        yield part, function(part, settings)
                    except OSError as error:
                        yield part, error
            while self.repeated:
                part = self.repeated.pop()
                yield part, function(part, settings)

    manifest = fleets.manifest(tmp_path)
    run(manifest, tmp_path / "whole")
    monkeypatch.setattr(runs, "Processes", lambda *_: InThisProcess())
    summary = run(manifest, tmp_path / "out")
    assert summary.repeated == 6
    assert fleets.contents(tmp_path / "out") == fleets.contents(tmp_path / "whole")


def test_memory_file_systems_hold_datasets(tmp_path: Path) -> None:
    """Any fsspec URL: here one that only this process sees, read and written by it."""
    from sprung.fleet.manifest import Manifest
    from sprung.fleet.work import Settings, run_part

    manifest = Manifest.read(fleets.manifest(tmp_path))
    settings = Settings("memory://fleet/out", (), manifest.covariates, fleets.identification)
    dataset.prepare(settings.out, {"overrides": []})
    for part in manifest.parts((), ["log"], 5):
        run_part(part, settings)
    assert fleet.Dataset.read(settings.out).rows("parameter").num_rows == 12
    files.filesystem(settings.out)[0].rm("/fleet", recursive=True)
