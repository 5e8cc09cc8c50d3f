"""The report of a fleet: one HTML file that needs no other."""

from __future__ import annotations

import datetime
import html
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import figures
from .dataset import Dataset
from .errors import DatasetError
from .estimates import Counts, Source, count, estimates
from .population import RATE, Analysis, Moved, Population, analyse_parameters, check_rate

MOST_ROWS = 200
"""Rows of a table of outliers or changes."""
MOST_FIGURES = 12
"""Figures of changes over time."""


@dataclass(frozen=True)
class Report:
    """The analysis of a dataset, and its page.

    >>> import tempfile
    >>> from sprung import fleet
    >>> report = fleet.Report(fleet.Analysis([], rate=0.05), "<!doctype html>")
    >>> report.save(f"{tempfile.mkdtemp()}/fleet.html").name
    'fleet.html'
    """

    analysis: Analysis
    html: str

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the page into a file and returns its path. Raises OSError if it cannot be written."""
        target = Path(path)
        target.write_text(self.html, encoding="utf-8")
        return target

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.html)}" width="100%" height="640"></iframe>'


def report(
    dataset: Dataset | str | os.PathLike[str],
    *,
    estimator: str | None = None,
    covariates: Sequence[str] | None = None,
    rate: float = RATE,
) -> Report:
    """Analyses a dataset: population of each parameter, outlier robots, drift over time, failures.

    - dataset: a dataset, or its folder or URL.
    - estimator: the estimator whose values count; the first one of the dataset if it is not given.
    - covariates: numeric columns of the manifest whose effects are explained first; all of them if not given.
    - rate: rate of false discoveries among the robots that are named.

    The parts of a folder are read one after the other, several times if necessary: memory holds the estimates of some
    parameters, and what the analysis tells about each robot. A `Dataset` is in memory already.

    With one robot there is no population: its scatter, its changes over time and its failures are reported.

    Raises DatasetError if the dataset cannot be read or has no such estimator or covariate, ValueError for a rate
    that is not between 0 and 1.

    >>> import tempfile
    >>> from sprung import fleet
    >>> folder = tempfile.mkdtemp()
    >>> settings = {"identify.estimator": "least-squares"}
    >>> todo = fleet.missing_logs(fleet.demo(folder, robots=2, logs=1), out=f"{folder}/results", overrides=settings)
    >>> rows = [fleet.identify_batch(todo, overrides=settings)]
    >>> summary = fleet.write_rows(rows, todo, out=f"{folder}/results")
    >>> report = fleet.report(f"{folder}/results")
    >>> [population.parameter for population in report.analysis.populations][:2]
    ['joint1.link_coulomb', 'joint1.link_viscous']
    """
    check_rate(rate)
    source = Source(dataset if isinstance(dataset, Dataset) else str(dataset))
    counts = count(source)
    used = _estimator(source.url, counts, estimator)
    names = _covariates(source.url, counts, covariates)
    analysis = analyse_parameters(estimates(source, counts, used, names), rate)
    return Report(analysis, _Page(source.url, counts, used, analysis).html())


def _estimator(url: str, counts: Counts, estimator: str | None) -> str:
    known = counts.estimators
    used = estimator if estimator is not None else (known[0] if known else "")
    if used not in known:
        raise DatasetError(
            f"the dataset {url} has no parameters of single logs by {used or 'any estimator'}; "
            f"it has those of {', '.join(known) or 'none'}",
            code="dataset-estimator",
            place=url,
            remedy='run sprung.fleet.identify with the level "log" and look at the failures',
        )
    return used


def _covariates(url: str, counts: Counts, covariates: Sequence[str] | None) -> list[str]:
    names = counts.covariates if covariates is None else list(covariates)
    unknown = [name for name in names if name not in counts.covariates]
    if unknown:
        raise DatasetError(
            f"the dataset {url} has no column {', '.join(unknown)}; "
            f"the manifest had {', '.join(counts.covariates) or 'no numeric column'}",
            code="dataset-covariate",
            place=url,
            remedy="add the column to the manifest",
        )
    return names


class _Page:
    def __init__(self, url: str, counts: Counts, estimator: str, analysis: Analysis) -> None:
        self.url = url
        self.counts = counts
        self.estimator = estimator
        self.analysis = analysis
        self.outliers = analysis.outliers()
        self.moved = analysis.moved()

    def html(self) -> str:
        body = "".join(
            [
                self._head(),
                self._outliers(),
                self._changes(),
                self._populations(),
                self._effects(),
                self._failures(),
                self._methods(),
            ]
        )
        title = f"Fleet: {_text(self.url.rstrip('/').rsplit('/', 1)[-1])}"
        return _DOCUMENT.replace("%TITLE%", title).replace("%STYLE%", _STYLE).replace("%BODY%", body)

    def _head(self) -> str:
        named = len({robot.robot for _, robot in self.outliers})
        moved = len({one.robot for _, one in self.moved})
        cells = [
            (f"{self.counts.robots}", "robots"),
            (f"{self.counts.logs}", "logs"),
            (f"{named}", "outlier robots"),
            (f"{moved}", "robots that changed"),
            (f"{self.counts.failed}", "failures"),
        ]
        figures_ = "".join(f"<div><b>{number}</b><span>{label}</span></div>" for number, label in cells)
        return (
            f"<header><h1>Fleet report</h1><p class='soft'>{_text(self.url)} · {_text(self.estimator)} · "
            f"rate of false discoveries {100 * self.analysis.rate:g} %</p><div class='cells'>{figures_}</div></header>"
        )

    def _outliers(self) -> str:
        lead = "Robots whose parameter does not belong to the population of the central robots."
        if self.counts.robots == 1:
            lead = (
                "The dataset has one robot. Whether it is an outlier, and the scatter between robots, need others of its kind: "
                "8 robots, better 20. The scatter of its logs, its changes over time and its failures are below."
            )
            return _section("outliers", "Outlier robots", lead, "")
        if all(population.central is None for population in self.analysis.populations):
            return _section("outliers", "Outlier robots", "There are too few robots for this test.", "")
        rows = []
        for population, robot in self.outliers[:MOST_ROWS]:
            central = population.central
            scale = abs(central.mean) if central is not None and central.mean != 0 else float("nan")
            rows.append(
                [
                    _text(robot.robot),
                    _text(population.parameter),
                    f"{_number(robot.value)} {_text(population.unit)}",
                    _percent(robot.deviation / scale),
                    _probability(robot.adjusted_p_value),
                    str(robot.logs),
                ]
            )
        head = ["robot", "parameter", "value", "from the population", "adjusted p", "logs"]
        return _section("outliers", "Outlier robots", lead, _table(head, rows, "No robot is an outlier.", len(self.outliers)))

    def _changes(self) -> str:
        lead = "Parameters of single robots that changed over time, at the mean covariates."
        if not any(population.tested_for_drift for population in self.analysis.populations):
            lead = "No robot has enough logs at known times: the manifest needs a column time, and each robot four logs."
            return _section("changes", "Changes over time", lead, "")
        rows = []
        for population, moved in self.moved[:MOST_ROWS]:
            drift = moved.drift
            low, high = drift.change_ci95
            step = drift.shape == "step"
            between = f"{_date(drift.time_ci95_s[0])} to {_date(drift.time_ci95_s[1])}" if step else "gradual"
            rows.append(
                [
                    _text(moved.robot),
                    _text(population.parameter),
                    f"{_number(drift.change)} {_text(population.unit)}",
                    f"{_number(low)} to {_number(high)}",
                    _percent(drift.change / abs(drift.before)) if drift.before else "",
                    between,
                    _probability(moved.adjusted_p_value),
                ]
            )
        head = ["robot", "parameter", "change", "95 % interval", "of the value", "time of the step, 95 %", "adjusted p"]
        table = _table(head, rows, "No robot changed.", len(self.moved))
        return _section("changes", "Changes over time", lead, table + self._series(self.moved[:MOST_FIGURES]))

    def _series(self, moved: Iterable[tuple[Population, Moved]]) -> str:
        plots = []
        for population, one in moved:
            caption = f"{one.robot}, {population.parameter} in {population.unit}"
            plots.append(f"<figure>{figures.series(one)}<figcaption>{_text(caption)}</figcaption></figure>")
        return f"<div class='figures'>{''.join(plots)}</div>" if plots else ""

    def _populations(self) -> str:
        lead = (
            "Standard deviations in percent of the mean, with 95 % intervals. "
            "Each point is the mean of a robot; the band is the central 95 % of the population."
        )
        rows = []
        for population in self.analysis.populations:
            scatter = population.scatter
            scale = abs(scatter.mean) or float("nan")
            named = {robot.robot for other, robot in self.outliers if other is population}
            rows.append(
                [
                    f"{_text(population.parameter)}<br><span class='soft'>{_text(population.unit)}</span>",
                    f"{_number(scatter.mean)}<br><span class='soft'>{_interval(scatter.mean_ci95, 1)}</span>",
                    f"{_percent(scatter.between / scale, False)}"
                    f"<br><span class='soft'>{_interval(scatter.between_ci95, 100 / scale)}</span>",
                    _percent(population.central.between / scale, False) if population.central else "",
                    _percent(scatter.between_dl / scale, False),
                    f"{_percent(scatter.within / scale, False)}"
                    f"<br><span class='soft'>{_interval(scatter.within_ci95, 100 / scale)}</span>",
                    _percent(scatter.expected / scale, False),
                    figures.strip(population, named),
                ]
            )
        head = [
            "parameter",
            "mean",
            "between robots",
            "central robots",
            "by moments",
            "within robots",
            "standard errors",
            "robots",
        ]
        return _section("population", "Population", lead, _table(head, rows, "No parameter has a value.", len(rows)))

    def _effects(self) -> str:
        rows = []
        for population in self.analysis.populations:
            for name, effect in population.covariates.items():
                if effect.robots == 0:
                    continue
                scale = abs(population.scatter.mean) or float("nan")
                rows.append(
                    [
                        _text(population.parameter),
                        _text(name),
                        f"{_number(effect.slope)} {_text(population.unit)}",
                        _interval(effect.ci95, 1),
                        _percent(effect.slope / scale),
                        _probability(effect.p_value),
                        str(effect.robots),
                    ]
                )
        if not rows:
            return ""
        lead = "Change of a parameter per unit of a covariate, from the differences between the logs of each robot."
        head = ["parameter", "covariate", "change per unit", "95 % interval", "of the mean", "p", "robots"]
        return _section("covariates", "Covariates", lead, _table(head, rows, "", len(rows)))

    def _failures(self) -> str:
        if self.counts.failures == 0:
            return _section("failures", "Failures", "All logs were identified.", "")
        lead = ", ".join(f"{number} of {_text(code)}" for code, number in self.counts.failure_codes) + "."
        cells = [
            [_text(cell or "") for cell in (one.robot, one.log, one.code, one.text, one.remedy)]
            for one in self.counts.first_failures
        ]
        head = ["robot", "log", "code", "message", "what to do"]
        return _section("failures", "Failures", lead, _table(head, cells, "", self.counts.failures))

    def _methods(self) -> str:
        text = (
            "<p>Scatter: random effects of robots and logs by restricted maximum likelihood; by moments: "
            "DerSimonian and Laird. Outliers: Student's t about a normal distribution truncated to the central robots. "
            "Changes: largest step and line over time, with the scatter of each robot moderated by the fleet. "
            "Adjusted p: Benjamini and Hochberg over all robots and parameters. "
            "A parameter whose error depends on another one may change with it.</p>"
        )
        return _section("methods", "Methods", "", text)


def _section(name: str, title: str, lead: str, content: str) -> str:
    paragraph = f"<p class='soft'>{lead}</p>" if lead else ""
    return f"<section id='{name}'><h2>{title}</h2>{paragraph}{content}</section>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], empty: str, of: int) -> str:
    if not rows:
        return f"<p>{empty}</p>"
    top = "".join(f"<th>{cell}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    more = f"<p class='soft'>The first {len(rows)} of {of}.</p>" if of > len(rows) else ""
    return f"<div class='wide'><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>{more}"


def _text(text: str) -> str:
    return html.escape(str(text))


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4g}".replace("-", "−")


def _percent(value: float, signed: bool = True) -> str:
    if np.isnan(value):
        return "–"
    return (f"{100 * value:+.3g} %" if signed else f"{100 * value:.3g} %").replace("-", "−")


def _interval(interval: tuple[float, float], scale: float) -> str:
    if not all(np.isfinite(interval)):
        return ""
    return f"{_number(interval[0] * scale)} to {_number(interval[1] * scale)}"


def _probability(value: float) -> str:
    return "below 10⁻⁶" if value < 1e-6 else f"{value:.2g}"


def _date(time_s: float) -> str:
    return datetime.datetime.fromtimestamp(time_s, datetime.timezone.utc).strftime("%Y-%m-%d %H:%M")


_DOCUMENT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>%TITLE%</title><style>%STYLE%</style></head><body><main>%BODY%</main></body></html>
"""
_STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1c2024; --soft: #59616a; --rule: #d5dae0; --tint: #f5f7f9;
  --point: #0077bb; --named: #cc3311; --band: #0077bb22; --change: #cc331122; }
@media (prefers-color-scheme: dark) { :root { --paper: #14171a; --ink: #e3e7eb; --soft: #a0a9b2; --rule: #353c43;
  --tint: #1d2125; --point: #4fb3f6; --named: #ff7a5c; --band: #4fb3f633; --change: #ff7a5c33; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, -apple-system, "Segoe UI",
  Roboto, Arial, sans-serif; font-variant-numeric: tabular-nums; }
main { max-width: 80rem; margin: 0 auto; padding: 1.5rem 1.25rem 3rem; }
header { border-bottom: 2px solid var(--ink); padding-bottom: 1rem; }
h1 { font-size: 1.75rem; margin: 0; line-height: 1.2; }
h2 { font-size: 1.25rem; margin: 2.5rem 0 0.5rem; padding-bottom: 0.3rem; border-bottom: 1px solid var(--rule); }
p { margin: 0.4rem 0; max-width: 60rem; overflow-wrap: anywhere; }
.soft { color: var(--soft); font-size: 0.875rem; }
.cells { display: flex; flex-wrap: wrap; gap: 0.75rem; margin-top: 0.75rem; }
.cells div { background: var(--tint); padding: 0.5rem 1rem; min-width: 8rem; }
.cells b { display: block; font-size: 1.5rem; line-height: 1.2; }
.cells span { color: var(--soft); font-size: 0.875rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem; }
th, td { text-align: left; padding: 0.35rem 0.9rem 0.35rem 0; border-bottom: 1px solid var(--rule); vertical-align: top; }
th { font-weight: 600; color: var(--soft); }
svg { display: block; max-width: 100%; height: auto; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(22rem, 1fr)); gap: 1rem; margin-top: 1rem; }
figure { margin: 0; }
figcaption { font-size: 0.85rem; color: var(--soft); }
.point { fill: var(--point); } .named { fill: var(--named); } .band { fill: var(--band); } .change { fill: var(--change); }
.axis { stroke: var(--rule); } .error { stroke: var(--point); } .mean { stroke: var(--named); stroke-width: 2; }
svg text { fill: var(--soft); font-size: 11px; }
"""
