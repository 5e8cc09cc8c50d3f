"""Plots: drawn once, with alternative texts, on given axes, and with the numbers of the report."""

from __future__ import annotations

import base64
import html
import json
import pickle
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import sprung
from sprung import _sprung

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

from matplotlib import pyplot  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402

Numbers = NDArray[np.float64]
KINDS = ["friction", "spring", "residual", "spectrum"]
JOINTS = ["joint1", "joint2"]


@pytest.fixture(autouse=True)
def no_figures_stay_open() -> Any:
    yield
    pyplot.close("all")


def line(axes: Axes, label: str) -> tuple[Numbers, Numbers]:
    """Returns the points of the only curve with this label."""
    (curve,) = [curve for curve in axes.get_lines() if curve.get_label() == label]
    return np.asarray(curve.get_xdata(), dtype=float), np.asarray(curve.get_ydata(), dtype=float)


def curves(result: sprung.Result, label: str) -> dict[str, Numbers]:
    """Returns the columns of ``fit.csv`` of one source."""
    (source,) = [source for source in result._handle.fit() if source[0] == label]
    return {"t": source[1], **dict(source[2])}


def altered(
    result: sprung.Result, change: Any, fit: str | None = None
) -> sprung.Result:
    """Returns the result with another ``identification.json``, and other curves if they are given."""
    contents = json.loads(result.to_json())
    change(contents)
    original = result._handle
    fit = original.fit_csv() if fit is None else fit
    handle = _sprung.Identified.of_parts(
        json.dumps(contents), original.trace_csv(), fit, original.text
    )
    return sprung.Result(handle, result.experiment)


# One axes for each panel.


def test_plots_take_axes_and_return_them(result: sprung.Result) -> None:
    for kind in [*KINDS, "parameters"]:
        names = [] if kind == "parameters" else ["joint1"]
        _, axes = pyplot.subplots()
        assert getattr(result.plot, kind)(*names, ax=axes) is axes
        assert axes.get_lines() and axes.get_xlabel()
        assert isinstance(getattr(result.plot, kind)(*names), Axes)
    # Torques and deflections of two joints; each parameter.
    for kind, count in [("fit", 4), ("trace", len(result.parameters))]:
        figure, grid = pyplot.subplots(count, 1)
        found = getattr(result.plot, kind)(ax=grid)
        assert list(found) == list(grid) == figure.axes
        assert all(axes.get_lines() for axes in found)
        assert len(getattr(result.plot, kind)()) == count
    _, axes = pyplot.subplots()
    (found,) = result.plot.trace("joint1.stiffness", ax=axes)
    assert found is axes


def test_wrong_axes_are_refused(result: sprung.Result) -> None:
    _, two = pyplot.subplots(2, 1)
    with pytest.raises(sprung.InputError, match="2 axes for 4 panels"):
        result.plot.fit(ax=two)
    with pytest.raises(sprung.InputError, match="give 1"):
        result.plot.friction("joint1", ax=two)
    figure: Any = pyplot.figure()
    with pytest.raises(sprung.InputError, match="give Axes"):
        result.plot.parameters(ax=figure)


def test_a_refused_plot_opens_no_figure(result: sprung.Result) -> None:
    with pytest.raises(sprung.InputError):
        result.plot.friction("elbow")
    assert pyplot.get_fignums() == []


def test_unknown_names_have_the_nearest_one(result: sprung.Result) -> None:
    for kind in KINDS:
        with pytest.raises(sprung.InputError, match="nearest name is 'joint2'") as error:
            getattr(result.plot, kind)("jont2")
        assert error.value.code == "joint" and "joint1, joint2" in str(error.value)
    number: Any = 2
    with pytest.raises(sprung.InputError, match="no joint 2"):
        result.plot.friction(number)
    with pytest.raises(sprung.InputError, match="nearest name is 'joint1.stiffness'"):
        result.plot.trace("joint1.stifness")


# Numbers.


def test_the_curves_of_a_joint_are_those_of_the_report(result: sprung.Result) -> None:
    scripts = re.findall(r"<script[^>]*>(\{.*?\})</script>", result._html(), re.DOTALL)
    (data,) = [content for content in map(json.loads, scripts) if "figures" in content]
    figures = {figure["id"]: figure for figure in data["figures"]}
    for joint in JOINTS:
        for kind in KINDS:
            (panel,) = figures[f"{kind}-{joint}"]["panels"]
            axes = getattr(result.plot, kind)(joint)
            for series in panel["series"]:
                if series["style"] == "reference":
                    continue
                values = np.frombuffer(base64.b64decode(data["curves"][series["curve"]]), "<f4")
                seen = np.isfinite(values)
                x, y = line(axes, series["name"])
                # The page rounds to 32 bits.
                np.testing.assert_allclose(y, values[seen], rtol=1e-6, atol=1e-9)
                np.testing.assert_allclose(
                    x, np.array(data["axes"][panel["axis"]])[seen], rtol=1e-5, atol=1e-7
                )
            assert axes.get_ylabel() == panel["y_label"]


@pytest.mark.parametrize("joint", [0, 1])
def test_the_friction_is_that_of_the_model(result: sprung.Result, joint: int) -> None:
    axes = result.plot.friction(JOINTS[joint])
    speed, friction = line(axes, result.estimator)
    # Between reversals of the motor the filters do not mix both directions.
    fast = np.abs(speed) > 0.6 * np.abs(speed).max()
    assert fast.sum() > 3
    dphi = np.zeros((int(fast.sum()), 2))
    dphi[:, joint] = speed[fast]
    zeros = np.zeros_like(dphi)
    expected = result.model.friction(zeros, zeros, zeros, dphi).motor[:, joint]
    error = np.abs(friction[fast] / expected - 1.0)
    # The curve has medians over neighbouring points.
    assert np.median(error) < 0.01 and error.max() < 0.05, error


@pytest.mark.parametrize("joint", JOINTS)
def test_the_slope_of_the_spring_is_the_stiffness(result: sprung.Result, joint: str) -> None:
    deflection, torque = line(result.plot.spring(joint), result.estimator)
    stiffness = result.parameters[f"{joint}.stiffness"].value
    assert stiffness is not None
    slope, offset = np.polyfit(deflection, torque, 1)
    assert abs(slope / stiffness - 1.0) < 1e-6 and abs(offset) < 1e-6 * np.abs(torque).max()


@pytest.mark.parametrize("joint", JOINTS)
def test_residual_and_spectrum_have_the_same_power(result: sprung.Result, joint: str) -> None:
    time, residual = line(result.plot.residual(joint), result.estimator)
    measured, fitted = curves(result, "measured"), curves(result, result.estimator)
    np.testing.assert_array_equal(time, measured["t"])
    np.testing.assert_array_equal(
        residual, measured[f"{joint}.motor_nm"] - fitted[f"{joint}.motor_nm"]
    )
    # Theorem of Parseval; windows overlap, so it holds for the mean.
    frequency, decibels = line(result.plot.spectrum(joint), result.estimator)
    power = np.sum(10.0 ** (decibels / 10.0)) * (frequency[1] - frequency[0])
    assert abs(power / np.var(residual) - 1.0) < 0.15
    assert frequency[-1] <= 0.5 / (time[1] - time[0]) + 1e-9


def test_each_estimator_has_its_own_residual() -> None:
    experiment = sprung.Experiment.demo({"identify.estimator": ["least-squares", "lsff"]})
    both = experiment.identify(experiment.simulate(), progress=False)
    lsff = both.by("lsff")
    _, residual = line(lsff.plot.residual("joint1"), "lsff")
    measured, fitted = curves(both, "measured"), curves(both, "lsff")
    np.testing.assert_array_equal(residual, measured["joint1.motor_nm"] - fitted["joint1.motor_nm"])
    for kind in ["friction", "spring"]:
        with pytest.raises(sprung.InputError, match=r"result.by\('least-squares'\).plot"):
            getattr(lsff.plot, kind)("joint1")


# Joints and results without a plot.


@pytest.fixture(scope="module")
def rigid(log: dict[str, Numbers]) -> sprung.Result:
    """The same log by a model whose second joint is rigid."""
    overrides: dict[str, Any] = {
        "identify.estimator": "least-squares",
        "robot.joint.1.transmission": "rigid",
        "log.link_position_rad": ["q1_rad"],
    }
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sprung.Experiment.demo(overrides).identify(log, progress=False)


def test_a_rigid_joint_has_no_spring(rigid: sprung.Result) -> None:
    assert "joint2.stiffness" not in rigid.parameters
    with pytest.raises(sprung.InputError, match="joint2 is rigid"):
        rigid.plot.spring("joint2")
    rigid.plot.spring("joint1")
    rigid.plot.friction("joint2")


def test_a_result_without_curves_is_named(result: sprung.Result) -> None:
    bare = altered(result, lambda contents: None, fit="source,time_s\n")
    for kind in KINDS:
        with pytest.raises(sprung.InputError, match="no curves"):
            getattr(bare.plot, kind)("joint1")
    with pytest.raises(sprung.InputError, match="fit.csv"):
        bare.plot.fit()


# Intervals.


def test_intervals_are_relative_to_their_values(result: sprung.Result) -> None:
    axes = result.plot.parameters()
    names = [label.get_text().split(" = ")[0] for label in axes.get_yticklabels()]
    assert names == list(result.parameters)
    limit = 100.0 * _sprung.relative_scale(result._handle, 0)
    assert axes.get_xlim() == pytest.approx((-1.08 * limit, 1.08 * limit))
    for place, (name, parameter) in enumerate(result.parameters.items()):
        assert parameter.ci95 is not None and parameter.value is not None
        ends = sorted(100.0 * (end / parameter.value - 1.0) for end in parameter.ci95)
        np.testing.assert_allclose(bar(axes, place), np.clip(ends, -limit, limit), err_msg=name)


def bar(axes: Axes, place: int) -> Numbers:
    """Returns the ends of the bar in a row."""
    points = [
        (np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())) for curve in axes.get_lines()
    ]
    (ends,) = [x for x, y in points if len(x) == 2 and y[0] == y[1] == place and x[0] != x[1]]
    return np.asarray(ends, dtype=float)


def arrows(axes: Axes) -> list[tuple[float, str]]:
    """Returns place and direction of each arrow."""
    return [
        (float(np.asarray(marker.get_ydata())[0]), str(marker.get_marker()))
        for marker in axes.get_lines()
        if marker.get_marker() in ("<", ">")
    ]


def test_a_parameter_near_zero_does_not_stretch_the_axis(result: sprung.Result) -> None:
    def shrink(contents: dict[str, Any]) -> None:
        parameters = contents["results"][0]["parameters"]
        parameters[0] |= {"value": 1e-7, "ci95": [-0.02, 0.02]}
        parameters[1] |= {"value": 0.0, "ci95": [-0.5, 0.5]}
        parameters[2] |= {"value": 2.0, "ci95": [0.0, 9.0]}

    before = result.plot.parameters()
    assert before.get_xlim()[1] <= 108.0
    axes = altered(result, shrink).plot.parameters()
    assert axes.get_xlim()[1] <= 108.0
    found = arrows(axes)
    assert {(0.0, "<"), (0.0, ">"), (1.0, "<"), (1.0, ">"), (2.0, ">")} <= set(found)
    texts = [text.get_text() for text in axes.texts]
    unit = next(iter(result.parameters.values())).unit
    assert texts[0] == f"± 0.020 {unit}" and texts[1].startswith("± 0.50 ") and texts[2] == "± 225 %"
    assert_all_inside(axes)


def assert_all_inside(axes: Axes) -> None:
    low, high = axes.get_xlim()
    for curve in axes.get_lines():
        x = np.asarray(curve.get_xdata(), dtype=float)
        assert np.all((low <= x) & (x <= high))


def test_values_at_their_bound_have_arrows(rigid: sprung.Result) -> None:
    axes = rigid.plot.parameters()
    assert_all_inside(axes)
    texts = [text.get_text() for text in axes.texts]
    shown = [parameter for parameter in rigid.parameters.values() if parameter.ci95]
    at_bound = [place for place, parameter in enumerate(shown) if parameter.one_sided]
    assert at_bound
    # An interval that ends within the axes needs no arrow.
    assert any((place, ">") in arrows(axes) for place in at_bound)
    for place in at_bound:
        assert (place, "<") not in arrows(axes)
        assert texts[place].startswith("< ")


def test_an_estimator_without_intervals_is_named(result: sprung.Result) -> None:
    def no_intervals(contents: dict[str, Any]) -> None:
        for parameter in contents["results"][0]["parameters"]:
            parameter["ci95"] = None

    with pytest.raises(sprung.InputError, match="least-squares has no intervals"):
        altered(result, no_intervals).plot.parameters()


# Texts for readers who do not see the picture.


def test_every_plot_has_an_alternative_text(result: sprung.Result) -> None:
    plot = result.plot
    for kind in KINDS:
        text = plot.alt_text(getattr(plot, kind)("joint2"))
        assert "joint2" in text and re.search(r"-?\d", text) and not re.search(r"\bnan\b", text), text
    text = plot.alt_text(plot.parameters())
    for name, parameter in result.parameters.items():
        assert f"{name} = {parameter.value:.4g}" in text
    axes = plot.fit()
    assert len(plot.alt_text(axes).splitlines()) == len(axes)
    (panel,) = plot.trace("joint1.stiffness")
    ((_, _, traces),) = result._handle.trace()
    last = dict(traces)["joint1.stiffness"][-1]
    assert f"{last:.4g} N·m/rad" in plot.alt_text(panel)


def test_a_second_plot_on_the_same_axes_adds_its_text(result: sprung.Result) -> None:
    axes = result.plot.friction("joint1")
    result.plot.friction("joint2", ax=axes)
    text = result.plot.alt_text(axes)
    assert "joint1" in text and "joint2" in text
    _, empty = pyplot.subplots()
    assert result.plot.alt_text(empty) == ""


def test_figures_pickle_with_their_texts(result: sprung.Result) -> None:
    axes = result.plot.friction("joint1")
    again = pickle.loads(pickle.dumps(axes.get_figure()))
    assert result.plot.alt_text(again.axes) == result.plot.alt_text(axes) != ""
    assert again._repr_html_() is None


# Notebooks.

CELLS = {
    "axes": 'result.plot.friction("joint2")',
    "semicolon": 'result.plot.friction("joint2");',
    "assigned": "axes = result.plot.fit()",
    "several": 'result.plot.trace("joint1.stiffness", "joint2.stiffness")',
    "two": 'result.plot.spring("joint1")\nresult.plot.spring("joint2");',
    "given": 'figure, ax = pyplot.subplots()\nresult.plot.residual("joint1", ax=ax);',
    "subfigure": 'ax = pyplot.figure().subfigures(1, 2)[0].subplots()\nresult.plot.residual("joint1", ax=ax);',
    "retina": '%config InlineBackend.figure_format = "retina"\nresult.plot.spectrum("joint1");',
    "svg": '%config InlineBackend.figure_format = "svg"\nresult.plot.spectrum("joint1");',
}
# Pictures of each cell.
COUNTS = {name: 2 if name == "two" else 1 for name in CELLS}


@pytest.fixture(scope="module")
def notebook(result: sprung.Result, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """An executed notebook with one cell of each kind, and their outputs by its name."""
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    nbformat = pytest.importorskip("nbformat")
    folder: Path = tmp_path_factory.mktemp("notebook")
    (folder / "result.pickle").write_bytes(pickle.dumps(result))
    start = (
        "import pickle\nfrom pathlib import Path\nfrom matplotlib import pyplot\n"
        'result = pickle.loads(Path("result.pickle").read_bytes())'
    )
    cells = [nbformat.v4.new_code_cell(text) for text in [start, *CELLS.values()]]
    book = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(
        book, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    ).execute()
    return book, dict(zip(CELLS, (cell["outputs"] for cell in book.cells[1:]), strict=True))


def pictures(outputs: list[Any]) -> list[Any]:
    kinds = {"image/png", "image/svg+xml"}
    return [output for output in outputs if kinds & set(output.get("data", {}))]


def size_of_png(text: str) -> tuple[int, int]:
    """Returns width and height in pixels of a PNG in Base64."""
    data = base64.b64decode(text)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    return width, height


@pytest.mark.parametrize("name", CELLS)
def test_a_notebook_shows_each_figure_once(notebook: Any, name: str) -> None:
    outputs = notebook[1][name]
    shown = pictures(outputs)
    assert len(shown) == COUNTS[name], [output.get("data", {}).keys() for output in outputs]
    others = [output for output in outputs if output not in shown]
    # The value of the last line is a text, and a semicolon hides it.
    if name in ("axes", "several"):
        (output,) = others
        assert output["output_type"] == "execute_result" and set(output["data"]) == {"text/plain"}
    else:
        assert others == []


@pytest.mark.parametrize("name", CELLS)
def test_images_of_a_notebook_have_an_alternative_text(notebook: Any, name: str) -> None:
    for picture in pictures(notebook[1][name]):
        page = picture["data"]["text/html"]
        (text,) = re.findall(r'(?:<img alt|role="img" aria-label)="([^"]+)"', page)
        assert "joint" in html.unescape(text)
        if name == "svg":
            assert "<svg" in page
        else:
            (png,) = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
            # Two drawings of one figure differ by fractions of a pixel.
            both = [size_of_png(png), size_of_png(picture["data"]["image/png"])]
            assert np.ptp(both, axis=0).max() <= 2 and np.min(both) > 100
        assert ("width=" in page.split("src=")[0]) == (name == "retina") or name == "svg"


def test_a_page_of_nbconvert_has_the_alternative_texts(notebook: Any) -> None:
    nbconvert = pytest.importorskip("nbconvert")
    page, _ = nbconvert.HTMLExporter().from_notebook_node(notebook[0])
    texts = re.findall(r'<img[^>]*\balt="([^"]*)"', page)
    # The cell with SVG has no such tag.
    assert len(texts) == sum(COUNTS.values()) - 1
    assert all("joint" in text for text in texts), texts
    assert page.count('aria-label="Spectrum of the residual of joint1.') == 1
