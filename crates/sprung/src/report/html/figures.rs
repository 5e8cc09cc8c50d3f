//! Writes the data of all figures as JSON that is safe inside a `script` element.

use serde::Serialize;

use super::super::document::{Block, Document, Figure, Layout, Panel, Style};
use super::error::ReportError;

const VALUE_DIGITS: usize = 7;
// A long log at a high rate needs more digits for its times than for its values.
const AXIS_DIGITS: usize = 12;

#[derive(Serialize)]
struct FigureData<'a> {
    caption: &'a str,
    x_label: &'a str,
    layout: Layout,
    axes: Vec<Vec<f64>>,
    panels: Vec<PanelData<'a>>,
}

#[derive(Serialize)]
struct PanelData<'a> {
    y_label: &'a str,
    axis: usize,
    series: Vec<SeriesData<'a>>,
}

#[derive(Serialize)]
struct SeriesData<'a> {
    name: &'a str,
    style: Style,
    values: Vec<Option<f64>>,
}

/// Writes the figures of a document in reading order.
pub(super) fn to_json(document: &Document) -> Result<String, ReportError> {
    let figures = document
        .sections
        .iter()
        .flat_map(|section| &section.blocks)
        .filter_map(|block| match block {
            Block::Figure(figure) => Some(figure_data(figure)),
            _ => None,
        })
        .collect::<Result<Vec<_>, _>>()?;
    Ok(escape(&serde_json::to_string(&figures)?))
}

fn figure_data(figure: &Figure) -> Result<FigureData<'_>, ReportError> {
    let mut axes: Vec<&[f64]> = Vec::new();
    let mut panels = Vec::with_capacity(figure.panels.len());
    for panel in &figure.panels {
        check(figure, panel)?;
        // Most panels share one axis, so equal axes are stored once.
        let axis = axes.iter().position(|known| *known == panel.x);
        let axis = axis.unwrap_or_else(|| {
            axes.push(&panel.x);
            axes.len() - 1
        });
        panels.push(panel_data(panel, axis));
    }
    let axes = axes
        .into_iter()
        .map(|axis| axis.iter().map(|&x| round(x, AXIS_DIGITS)).collect())
        .collect();
    Ok(FigureData {
        caption: &figure.caption,
        x_label: &figure.x_label,
        layout: figure.layout,
        axes,
        panels,
    })
}

fn panel_data(panel: &Panel, axis: usize) -> PanelData<'_> {
    let series = panel.series.iter().map(|series| SeriesData {
        name: &series.name,
        style: series.style,
        values: series
            .values
            .iter()
            .map(|value| value.filter(|v| v.is_finite()))
            .map(|value| value.map(|v| round(v, VALUE_DIGITS)))
            .collect(),
    });
    PanelData {
        y_label: &panel.y_label,
        axis,
        series: series.collect(),
    }
}

fn check(figure: &Figure, panel: &Panel) -> Result<(), ReportError> {
    for series in &panel.series {
        if series.values.len() != panel.x.len() {
            return Err(ReportError::Length {
                figure: figure.id.clone(),
                series: series.name.clone(),
                expected: panel.x.len(),
                found: series.values.len(),
            });
        }
    }
    let mut last = f64::NEG_INFINITY;
    for (index, &x) in panel.x.iter().enumerate() {
        if !x.is_finite() || x < last {
            return Err(ReportError::Axis {
                figure: figure.id.clone(),
                index,
            });
        }
        last = x;
    }
    Ok(())
}

fn round(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

// These characters occur only inside strings, where the escape sequences are equivalent.
fn escape(json: &str) -> String {
    let mut safe = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' => safe.push_str("\\u003c"),
            '>' => safe.push_str("\\u003e"),
            '&' => safe.push_str("\\u0026"),
            '\u{2028}' => safe.push_str("\\u2028"),
            '\u{2029}' => safe.push_str("\\u2029"),
            _ => safe.push(c),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::document::{Section, Series};

    fn document(panels: Vec<Panel>) -> Document {
        let figure = Figure {
            id: "f".into(),
            panels,
            ..Figure::default()
        };
        let section = Section {
            blocks: vec![Block::Figure(figure)],
            ..Section::default()
        };
        Document {
            sections: vec![section],
            ..Document::default()
        }
    }

    fn panel(x: &[f64], values: &[Option<f64>]) -> Panel {
        let series = Series {
            name: "tau </script> & \u{2028}".into(),
            values: values.to_vec(),
            style: Style::First,
        };
        Panel {
            y_label: "torque (N·m)".into(),
            x: x.to_vec(),
            series: vec![series],
        }
    }

    #[test]
    fn text_cannot_leave_the_script_element_and_survives() {
        let json = to_json(&document(vec![panel(&[0.0], &[None])])).unwrap();
        assert!(!json.contains(['<', '>', '&', '\u{2028}']));
        let parsed: serde_json::Value = serde_json::from_str(&json).unwrap();
        let name = &parsed[0]["panels"][0]["series"][0]["name"];
        assert_eq!(name, "tau </script> & \u{2028}");
    }

    #[test]
    fn values_that_are_no_numbers_become_null() {
        let values = [Some(f64::NAN), Some(f64::INFINITY), None, Some(1.5)];
        let json = to_json(&document(vec![panel(&[0.0, 1.0, 2.0, 3.0], &values)])).unwrap();
        assert!(json.contains("[null,null,null,1.5]"), "{json}");
    }

    #[test]
    fn values_are_rounded_and_a_common_axis_is_stored_once() {
        let one = panel(&[0.1 + 0.2], &[Some(-123.456_789_01)]);
        let json = to_json(&document(vec![one.clone(), one])).unwrap();
        assert!(json.contains("\"axes\":[[0.3]]"), "{json}");
        assert!(json.contains("[-123.4568]"), "{json}");
    }

    #[test]
    fn a_series_of_another_length_is_refused() {
        let error = to_json(&document(vec![panel(&[0.0, 1.0], &[None])])).unwrap_err();
        assert!(matches!(
            error,
            ReportError::Length { expected: 2, found: 1, ref figure, .. } if figure == "f"
        ));
    }

    #[test]
    fn a_falling_or_undefined_axis_is_refused() {
        for x in [[1.0, 0.0], [0.0, f64::NAN]] {
            let error = to_json(&document(vec![panel(&x, &[None, None])])).unwrap_err();
            assert!(matches!(error, ReportError::Axis { index: 1, .. }));
        }
    }
}
