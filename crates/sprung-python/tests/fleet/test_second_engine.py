"""Ray maps the function of `sprung.fleet` over logs, and the dataset is that of Dask."""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fleets
import pytest

from sprung import fleet

ray = pytest.importorskip("ray")
distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Ray with two processors, whose workers import the files of the tests."""
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    environment = {"env_vars": {"PYTHONPATH": fleets.environment()["PYTHONPATH"]}}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR", runtime_env=environment)
    ray.data.DataContext.get_current().enable_progress_bars = False
    yield ray
    ray.shutdown()


def run(manifest: Path, out: Path, blocks: int, **more: Any) -> fleet.Summary:
    """Identifies the missing logs with Ray, in a number of blocks."""
    overrides = more.get("overrides", ())
    todo = fleet.missing_logs(manifest, out=out, overrides=overrides, logs_per_part=3)
    identify = functools.partial(fleet.identify_batch, **more)
    logs = ray.data.from_arrow(todo, override_num_blocks=blocks)
    rows = logs.map_batches(identify, batch_format="pyarrow", batch_size=None)
    return fleet.write_rows(rows.iter_batches(batch_format="pyarrow", batch_size=None), todo, out=out)


def test_ray_writes_the_bytes_of_dask(tmp_path: Path, cluster: Any) -> None:
    manifest = fleets.simulated(tmp_path / "logs", robots=3, logs=2)
    (tmp_path / "logs" / "robot1" / "log0.parquet").write_bytes(b"torn")
    summary = run(manifest, tmp_path / "ray", 3, overrides=fleets.OVERRIDES)
    assert (summary.tasks, summary.failed) == (6, 1)
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    with (
        distributed.LocalCluster(**options, silence_logs=50) as dask_cluster,
        distributed.Client(dask_cluster) as client,
    ):
        fleet.identify(
            manifest, out=tmp_path / "dask", client=client, overrides=fleets.OVERRIDES, logs_per_part=3, progress=False
        )
    assert fleets.contents(tmp_path / "ray") == fleets.contents(tmp_path / "dask")


def test_ray_identifies_new_logs_only(tmp_path: Path, cluster: Any) -> None:
    manifest = fleets.manifest(tmp_path, robots=4)
    run(manifest, tmp_path / "out", 5, identify_one=fleets.counts_calls)
    assert len(fleets.calls(tmp_path)) == 12
    fleets.manifest(tmp_path, robots=5)
    run(manifest, tmp_path / "out", 2, identify_one=fleets.counts_calls)
    assert fleets.calls(tmp_path) == ["log-12.csv", "log-13.csv", "log-14.csv"]
    assert fleet.Dataset.read(tmp_path / "out").rows("parameter").num_rows == 15
