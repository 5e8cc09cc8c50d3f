//! Writes the data of all figures as JSON that is safe inside a `script` element.
//!
//! The values of a curve are 32-bit floats in Base64: 5.3 characters instead of about ten, and seven
//! digits. Equal curves and equal axes are stored once, and a constant curve is one value.

use std::collections::HashMap;

use serde::Serialize;

use super::super::document::{
    Block, Document, Figure, Layout, Line, Panel, Series, Skeleton, Style,
};
use super::base64;
use super::error::ReportError;

// A long log at a high rate needs more digits for its times than for its values.
const AXIS_DIGITS: usize = 12;

/// Significant digits of the largest coordinate of an arm.
const PLACE_DIGITS: i32 = 4;

#[derive(Default, Serialize)]
struct Data<'a> {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    skeletons: Vec<SkeletonData<'a>>,
    axes: Vec<Vec<f64>>,
    curves: Vec<String>,
    figures: Vec<FigureData<'a>>,
}

/// Places are multiples of a unit, because whole numbers are short.
#[derive(Serialize)]
struct SkeletonData<'a> {
    unit: f64,
    floor: f64,
    grid: f64,
    parents: &'a [Option<usize>],
    time: Vec<f64>,
    points: Vec<Vec<i32>>,
}

#[derive(Serialize)]
struct FigureData<'a> {
    id: &'a str,
    x_label: &'a str,
    logarithmic: bool,
    layout: Layout,
    panels: Vec<PanelData<'a>>,
}

#[derive(Serialize)]
struct PanelData<'a> {
    y_label: &'a str,
    note: &'a str,
    axis: usize,
    errors: Option<&'a str>,
    marks: &'a [Line],
    series: Vec<SeriesData<'a>>,
}

#[derive(Serialize)]
struct SeriesData<'a> {
    name: &'a str,
    style: Style,
    clipped: bool,
    curve: usize,
}

/// Axes and curves that are stored already.
#[derive(Default)]
struct Stored<'a> {
    axes: Vec<&'a [f64]>,
    curves: HashMap<String, usize>,
}

impl<'a> Stored<'a> {
    fn axis(&mut self, axis: &'a [f64]) -> usize {
        let known = self.axes.iter().position(|known| *known == axis);
        known.unwrap_or_else(|| {
            self.axes.push(axis);
            self.axes.len() - 1
        })
    }

    fn curve(&mut self, series: &Series) -> usize {
        let values: Vec<f32> = series.values.iter().map(|value| float(*value)).collect();
        let is_constant = values
            .windows(2)
            .all(|two| two[0].to_bits() == two[1].to_bits());
        let stored = if is_constant { 1 } else { values.len() };
        let bytes = (values.iter().take(stored)).flat_map(|value| value.to_le_bytes());
        let next = self.curves.len();
        let text = base64::encode(&bytes.collect::<Vec<u8>>());
        *self.curves.entry(text).or_insert(next)
    }
}

/// Writes the figures of a document in reading order.
pub(super) fn to_json(document: &Document) -> Result<String, ReportError> {
    let mut stored = Stored::default();
    let mut figures = Vec::new();
    let mut skeletons = Vec::new();
    for block in document.sections.iter().flat_map(|section| &section.blocks) {
        if let Block::Figure(figure) = block {
            figures.push(figure_data(figure, &mut stored)?);
        } else if let Block::Skeleton(skeleton) = block {
            skeletons.push(skeleton_data(skeleton));
        }
    }
    let axis = |axis: &&[f64]| axis.iter().map(|&x| round(x, AXIS_DIGITS)).collect();
    let mut curves: Vec<(String, usize)> = stored.curves.into_iter().collect();
    curves.sort_by_key(|(_, index)| *index);
    let data = Data {
        skeletons,
        axes: stored.axes.iter().map(axis).collect(),
        curves: curves.into_iter().map(|(text, _)| text).collect(),
        figures,
    };
    Ok(escape(&serde_json::to_string(&data)?))
}

fn figure_data<'a>(
    figure: &'a Figure,
    stored: &mut Stored<'a>,
) -> Result<FigureData<'a>, ReportError> {
    let mut panels = Vec::with_capacity(figure.panels.len());
    for panel in &figure.panels {
        check(figure, panel)?;
        panels.push(PanelData {
            y_label: &panel.y_label,
            note: &panel.note,
            axis: stored.axis(&panel.x),
            errors: panel.errors.as_deref(),
            marks: &panel.marks,
            series: (panel.series.iter())
                .map(|series| SeriesData {
                    name: &series.name,
                    style: series.style,
                    clipped: series.clipped,
                    curve: stored.curve(series),
                })
                .collect(),
        });
    }
    Ok(FigureData {
        id: &figure.id,
        x_label: &figure.x_label,
        logarithmic: figure.logarithmic,
        layout: figure.layout,
        panels,
    })
}

fn skeleton_data(skeleton: &Skeleton) -> SkeletonData<'_> {
    let coordinates = || skeleton.points.iter().flatten().flatten();
    let largest = coordinates().fold(0.0, |most: f64, x| most.max(x.abs()));
    let power = largest.log10().floor().max(-9.0) as i32 + 1 - PLACE_DIGITS;
    let unit = round(10_f64.powi(power), 1);
    let frame = |points: &Vec<[f64; 3]>| {
        let coordinates = points.iter().flatten();
        coordinates.map(|x| (x / unit).round() as i32).collect()
    };
    SkeletonData {
        unit,
        floor: round(skeleton.floor, 6),
        grid: skeleton.grid,
        parents: &skeleton.parents,
        time: skeleton.time.iter().map(|&t| round(t, 6)).collect(),
        points: skeleton.points.iter().map(frame).collect(),
    }
}

/// Returns a value as the page stores it; a gap is not a number.
fn float(value: Option<f64>) -> f32 {
    let value = value.map_or(f32::NAN, |value| value as f32);
    if value.is_finite() { value } else { f32::NAN }
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
    use crate::document::Section;

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
        let name = "tau </script> & \u{2028}";
        let series = Series::new(name, Style::First, values.to_vec());
        Panel {
            y_label: "torque (N·m)".into(),
            x: x.to_vec(),
            series: vec![series],
            ..Panel::default()
        }
    }

    fn decoded(json: &str, curve: usize) -> Vec<Option<f32>> {
        let data: serde_json::Value = serde_json::from_str(json).unwrap();
        let bytes = base64::decode(data["curves"][curve].as_str().unwrap());
        let floats = bytes.chunks_exact(4);
        floats
            .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
            .map(|value| Some(value).filter(|value| !value.is_nan()))
            .collect()
    }

    #[test]
    fn text_cannot_leave_the_script_element_and_survives() {
        let json = to_json(&document(vec![panel(&[0.0], &[None])])).unwrap();
        assert!(!json.contains(['<', '>', '&', '\u{2028}']));
        let parsed: serde_json::Value = serde_json::from_str(&json).unwrap();
        let name = &parsed["figures"][0]["panels"][0]["series"][0]["name"];
        assert_eq!(name, "tau </script> & \u{2028}");
    }

    #[test]
    fn values_that_are_no_numbers_become_gaps() {
        let values = [
            Some(f64::NAN),
            Some(f64::INFINITY),
            None,
            Some(1e300),
            Some(1.5),
        ];
        let axis = [0.0, 1.0, 2.0, 3.0, 4.0];
        let json = to_json(&document(vec![panel(&axis, &values)])).unwrap();
        assert_eq!(decoded(&json, 0), [None, None, None, None, Some(1.5)]);
    }

    #[test]
    fn a_value_keeps_seven_digits_and_equal_curves_are_stored_once() {
        let one = panel(&[0.1 + 0.2], &[Some(-123.456_789_01)]);
        let other = panel(&[0.1 + 0.2], &[Some(2.0)]);
        let json = to_json(&document(vec![one.clone(), other, one])).unwrap();
        assert!(json.contains("\"axes\":[[0.3]]"), "{json}");
        let value = f64::from(decoded(&json, 0)[0].unwrap());
        assert!((value / -123.456_789_01 - 1.0).abs() < 1e-7);
        let data: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(data["curves"].as_array().unwrap().len(), 2);
        assert_eq!(data["figures"][0]["panels"][2]["series"][0]["curve"], 0);
    }

    #[test]
    fn a_constant_curve_is_one_value() {
        let axis = [0.0, 1.0, 2.0];
        let constant = panel(&axis, &[Some(0.5); 3]);
        let json = to_json(&document(vec![constant, panel(&axis, &[None; 3])])).unwrap();
        assert_eq!(decoded(&json, 0), [Some(0.5)]);
        assert_eq!(decoded(&json, 1), [None]);
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
