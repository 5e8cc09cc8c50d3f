//! Composes the drift of a robot: a table, and its parameters over time.

use super::document::{Block, Figure, Layout, Panel, Section, Series, Style, Table};
use super::numbers::{or_dash, significant, with_error};
use super::rows::rows;
use super::section::section;
use crate::compare::{ComparedValue, Comparison, Drift, ParameterDrift, SIGNIFICANCE};
use crate::model::short;

/// Most parameters of an estimator in the figure, the most certain changes first.
const PANELS: usize = 12;

/// Returns the section about drift; `None` if no estimator is tested.
pub(super) fn drift(comparison: &Comparison) -> Option<Section> {
    let each = || comparison.drift.iter().enumerate();
    let figures = each().map(|(at, drift)| Block::Figure(figure(comparison, at, drift)));
    let tables = each().map(|(_, drift)| Block::Table(table(drift)));
    (!comparison.drift.is_empty()).then(|| {
        section(
            "drift",
            "Drift",
            &format!(
                "A line through the results of one estimator over time. The standard error contains the scatter of \
                 the runs about the line. A parameter drifts if its probability without drift, adjusted for the \
                 number of parameters, is below {} %.",
                100.0 * SIGNIFICANCE
            ),
            figures.chain(tables).collect(),
        )
    })
}

fn table(drift: &Drift) -> Table {
    rows(&drift.parameters)
        .text("Parameter", |parameter| &parameter.name)
        .text("Unit", |parameter| &parameter.unit)
        .number("Runs", |parameter| parameter.results)
        .number("First", |parameter| significant(parameter.first, 5))
        .number("Change ± s.e.", |parameter| {
            with_error(parameter.change, 3, parameter.standard_error)
        })
        .number("%", |parameter| or_dash(parameter.change_percent, 3))
        .number("± %", |parameter| {
            or_dash(parameter.standard_error_percent, 2)
        })
        .number("per day", |parameter| or_dash(parameter.change_per_day, 3))
        .number("Scatter", |parameter| {
            significant(parameter.between_runs, 2)
        })
        .number("p, adjusted", |parameter| {
            significant(parameter.adjusted_probability, 2)
        })
        .marked(|parameter| parameter.drifts)
        .table(drift.conclusion())
}

/// - `at`: index of the drift in the comparison.
fn figure(comparison: &Comparison, at: usize, drift: &Drift) -> Figure {
    let mut shown: Vec<&ParameterDrift> = drift.parameters.iter().collect();
    shown.sort_by(|a, b| a.probability.total_cmp(&b.probability));
    shown.truncate(PANELS);
    let of_shown = if shown.len() < drift.parameters.len() {
        format!(
            "the {} most certain changes of {}",
            shown.len(),
            drift.parameters.len()
        )
    } else {
        "all parameters".to_owned()
    };
    Figure {
        id: format!("drift-{}", at + 1),
        caption: format!(
            "{}, {}: {of_shown}. Each value has its 95 % interval.",
            drift.estimator,
            drift.runs()
        ),
        x_label: if drift.from_date_s.is_some() {
            "days since the first log".to_owned()
        } else {
            "run".to_owned()
        },
        logarithmic: false,
        layout: Layout::Grid,
        panels: (shown.into_iter())
            .map(|parameter| panel(comparison, drift, parameter))
            .collect(),
    }
}

fn panel(comparison: &Comparison, drift: &Drift, parameter_drift: &ParameterDrift) -> Panel {
    let values: Vec<Option<&ComparedValue>> = {
        let same = |label: &String| {
            comparison
                .compared
                .iter()
                .position(|one| one.label == *label)
        };
        let parameter = (comparison.parameters.iter())
            .find(|one| one.name == parameter_drift.name && one.unit == parameter_drift.unit);
        (drift.results.iter())
            .map(|label| parameter?.values[same(label)?].as_ref())
            .collect()
    };
    let curve = |name: &str, style: Style, of: &dyn Fn(&ComparedValue) -> Option<f64>| {
        let values = values.iter().map(|value| of((*value)?));
        Series::new(name, style, values.collect())
    };
    let [from, to] = parameter_drift.span;
    let line = |time: &f64| {
        let inside = (from..=to).contains(time);
        inside.then(|| parameter_drift.first + parameter_drift.change * (time - from) / (to - from))
    };
    Panel {
        y_label: format!(
            "{} [{}]",
            short(&parameter_drift.name),
            parameter_drift.unit
        ),
        note: if parameter_drift.drifts {
            format!("drifts by {}", parameter_drift.in_words())
        } else {
            parameter_drift.in_words()
        },
        x: drift.times.clone(),
        series: vec![
            curve("lower end", Style::Reference, &|value| {
                value.ci95.map(|[low, _]| low)
            }),
            curve("upper end", Style::Reference, &|value| {
                value.ci95.map(|[_, high]| high)
            }),
            curve("value", Style::Measured, &|value| value.value),
            Series::new("line", Style::First, drift.times.iter().map(line).collect()),
        ],
        ..Panel::default()
    }
}
