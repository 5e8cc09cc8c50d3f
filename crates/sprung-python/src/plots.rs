//! Figures of the report as arrays, for plots in Python.

use numpy::{PyArray1, ToPyArray};
use pyo3::prelude::*;
use sprung::report::{Figure, JointFigures, Style};

use crate::results::Identified;

/// A figure of one panel: caption, labels of both axes, abscissas, curves with their style and NaN at gaps.
type Drawn<'py> = (
    String,
    (String, String),
    Bound<'py, PyArray1<f64>>,
    Vec<(String, &'static str, Bound<'py, PyArray1<f64>>)>,
);

/// The four figures of a joint by one estimate: friction, spring, residual, spectrum; `None` for one that there is not.
#[pyfunction]
pub(crate) fn joint_figures<'py>(
    py: Python<'py>,
    identified: PyRef<'py, Identified>,
    set: usize,
    joint: &str,
) -> [Option<Drawn<'py>>; 4] {
    let found = identified.found();
    let Some(result) = found.identification.results.get(set) else {
        return [None, None, None, None];
    };
    let figures = JointFigures::of(result, &found.fit, joint);
    [
        figures.friction,
        figures.spring,
        figures.residual,
        figures.spectrum,
    ]
    .map(|figure| figure.and_then(|figure| drawn(py, figure)))
}

/// Half the width of the scale of relative intervals: 0.05 stands for 5 %.
#[pyfunction]
pub(crate) fn relative_scale(identified: PyRef<'_, Identified>, set: usize) -> f64 {
    let results = &identified.found().identification.results;
    results.get(set).map_or(1.0, sprung::report::relative_scale)
}

fn drawn(py: Python<'_>, figure: Figure) -> Option<Drawn<'_>> {
    let panel = figure.panels.into_iter().next()?;
    let series = (panel.series.into_iter())
        .map(|series| {
            let values: Vec<f64> = (series.values.iter())
                .map(|value| value.unwrap_or(f64::NAN))
                .collect();
            (series.name, word(series.style), values.to_pyarray(py))
        })
        .collect();
    Some((
        figure.caption,
        (figure.x_label, panel.y_label),
        panel.x.to_pyarray(py),
        series,
    ))
}

fn word(style: Style) -> &'static str {
    match style {
        Style::Measured => "measured",
        Style::First => "first",
        Style::Second => "second",
        Style::Third => "third",
        Style::Error => "error",
        Style::Reference => "reference",
        Style::Cloud => "cloud",
    }
}
