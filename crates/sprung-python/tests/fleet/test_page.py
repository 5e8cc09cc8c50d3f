"""The report of a fleet whose truth is known, in a real browser too."""

from __future__ import annotations

import datetime
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sprung import fleet
from sprung.fleet import dataset
from sprung.fleet.manifest import Task

ROBOTS, LOGS = 40, 8
START = datetime.datetime(2026, 1, 1, tzinfo=datetime.timezone.utc)
SOFT, STIFF_THEN_SOFT = "robot07", "robot11 <b>&"


def drawn(folder: Path) -> Path:
    """A dataset: one robot is 5 % softer, one becomes so after 100 days, friction falls with temperature."""
    random = np.random.default_rng(1)
    out = folder / "drawn"
    dataset.prepare(str(out), {"overrides": []})
    rows = []
    for number in range(ROBOTS):
        robot = STIFF_THEN_SOFT if number == 11 else f"robot{number:02}"
        deviation = 0.005 * random.standard_normal(2)
        for log in range(LOGS):
            time = START + datetime.timedelta(days=30.0 * log)
            temperature_c = float(random.uniform(10, 40))
            task = Task(f"{number}-{log}", "log", robot, "e", (f"{log}.csv",), time, (("temperature_c", temperature_c),))
            soft = robot == SOFT or (robot == STIFF_THEN_SOFT and log >= 4)
            values = (1 + deviation + 0.005 * random.standard_normal(2)) * [10 * (0.95 if soft else 1), 0.5]
            values[1] -= 0.002 * (temperature_c - 25)
            names = (("joint1.stiffness", "N·m/rad", 0.035), ("joint1.motor_viscous", "N·m·s/rad", 0.00175))
            parameters = [
                {"name": name, "unit": unit, "value": value, "standard_error": error, "identifiable": True}
                for (name, unit, error), value in zip(names, values.tolist(), strict=True)
            ]
            result = {"estimator": "least-squares", "verdict": "good", "parameters": parameters}
            rows += dataset.rows_of(task, json.dumps({"log": {"samples": 1}, "results": [result]}))
    lost = Task("lost", "log", "robot39", "e", ("lost.csv",), START, (("temperature_c", 20.0),))
    rows.append(dataset.failure_row(lost, "file-missing", "lost.csv does not <exist>", None, "correct the path"))
    dataset.write_part(str(out), "part-drawn", dataset.table_of(rows, ["temperature_c"]))
    return out


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> fleet.Report:
    return fleet.report(drawn(tmp_path_factory.mktemp("drawn")))


def test_the_truth_is_named(made: fleet.Report) -> None:
    outliers = {(robot.robot, population.parameter) for population, robot in made.analysis.outliers()}
    assert (SOFT, "joint1.stiffness") in outliers and len(outliers) <= 3
    moved = {(one.robot, population.parameter): one for population, one in made.analysis.moved()}
    assert list(moved) == [(STIFF_THEN_SOFT, "joint1.stiffness")]
    (one,) = moved.values()
    low, high = (datetime.timedelta(seconds=time - START.timestamp()).days for time in one.drift.time_ci95_s)
    assert low <= 100 <= high
    effect = made.analysis.populations[0].covariates["temperature_c"]
    assert effect.ci95[0] <= -0.002 <= effect.ci95[1]


def test_the_page_needs_no_other_file_and_escapes_names(made: fleet.Report) -> None:
    assert "http" not in made.html and "src=" not in made.html and "<script" not in made.html
    assert "robot11 &lt;b&gt;&amp;" in made.html and "robot11 <b>" not in made.html
    assert "does not &lt;exist&gt;" in made.html and "nan" not in made.html.lower().replace("nanny", "")


def test_a_browser_shows_it(made: fleet.Report, tmp_path: Path) -> None:
    browser = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    if browser is None:
        pytest.skip("no Chromium on this machine; `cargo xtask browser` installs it on Debian")
    page = made.save(tmp_path / "fleet.html")
    picture = tmp_path / "fleet.png"
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--enable-logging=stderr"]
    profile = f"--user-data-dir={tmp_path / 'profile'}"
    size = "--window-size=1200,1600"
    done = subprocess.run(
        [browser, *options, profile, size, f"--screenshot={picture}", page.as_uri()], capture_output=True, text=True
    )
    assert picture.stat().st_size > 20_000 and "CONSOLE" not in done.stderr
    dom = subprocess.run([browser, *options, profile, "--dump-dom", page.as_uri()], capture_output=True, text=True).stdout
    # Two populations and one change over time.
    assert dom.count("<svg") == 3 and dom.count('class="named"') >= 1


def test_wrong_requests_are_refused(tmp_path: Path, made: fleet.Report) -> None:
    out = drawn(tmp_path)
    with pytest.raises(fleet.DatasetError, match="lsff; it has those of least-squares"):
        fleet.report(out, estimator="lsff")
    with pytest.raises(fleet.DatasetError, match="no column wear; the manifest had temperature_c"):
        fleet.report(out, covariates=["wear"])
    with pytest.raises(ValueError, match="between 0 and 1"):
        fleet.report(out, rate=5.0)
    with pytest.raises(fleet.DatasetError, match="no dataset"):
        fleet.report(tmp_path / "nothing")
    with pytest.raises(OSError):
        made.save(tmp_path / "no" / "folder" / "fleet.html")


def test_a_small_fleet_has_a_report(tmp_path: Path) -> None:
    out = tmp_path / "small"
    task = Task("a", "log", "a", "e", ("a.csv",), None, ())
    parameter = {"name": "p", "unit": "1", "value": 1.0, "standard_error": 0.1, "identifiable": True}
    unknown = {"name": "q", "unit": "1", "value": None, "standard_error": None, "identifiable": False}
    result = {"estimator": "least-squares", "parameters": [parameter, unknown]}
    dataset.prepare(str(out), {"overrides": []})
    rows = dataset.rows_of(task, json.dumps({"results": [result]}))
    dataset.write_part(str(out), "part-a", dataset.table_of(rows, []))
    page = fleet.report(out).html
    assert "The dataset has one robot." in page and "needs a column time" in page
