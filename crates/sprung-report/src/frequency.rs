//! Composes the section about frequency responses.

use super::document::{
    Block, Column, Figure, Fold, Intervals, Layout, Panel, Row, Section, Series, Style, Table, Tone,
};
use super::intervals::{self, Ranged};
use super::numbers::{or_dash, significant};
use super::plots::measured_series;
use super::section::folded;
use crate::estimate::{
    Feature, FrequencyResponse, Identification, JointResponse, NORMAL_95, ResponseCurves, Unseen,
};

/// Code of the finding about frequencies.
const DISAGREES: &str = "resonance-disagrees";

/// Returns the section; `None` without frequency responses.
pub(super) fn frequency(identification: &Identification) -> Option<Section> {
    let response = identification.frequency_response.as_ref()?;
    let samples = match response.periods {
        Some(periods) => format!("{periods} periods of the motion, averaged"),
        None => "the motion without repetition".to_owned(),
    };
    let disagrees = (identification.results.first()).is_some_and(|result| {
        result
            .warnings
            .iter()
            .any(|warning| warning.code == DISAGREES)
    });
    let mut blocks = vec![
        Block::Paragraph(format!(
            "The response by the log comes from {} s of the log: {samples}. It uses neither the \
             parameters nor the equations of the model. The model is linearised about the poses of the \
             log, and the nearest viscous friction along the log replaces its friction. Dry friction \
             raises a resonance of small motions, so the two agree within some percent only if dry \
             friction is a small part of the torque.",
            significant(response.duration_s, 4)
        )),
        Block::Table(features(response)),
    ];
    blocks.extend(compared(response).map(Block::Intervals));
    blocks.extend(figure(response).map(Block::Figure));
    Some(folded(
        if disagrees { Fold::Open } else { Fold::Detail },
        "frequency",
        "Frequency response",
        "The response from the torque of a motor to the positions of its joint, by the log alone and \
         by the identified model. Where they agree, two independent methods see the same vibrations.",
        blocks,
    ))
}

fn all(response: &FrequencyResponse) -> impl Iterator<Item = (&JointResponse, &Feature)> {
    (response.joints.iter())
        .flat_map(|joint| joint.features.iter().map(move |feature| (joint, feature)))
}

/// Returns the table of resonances and antiresonances.
fn features(response: &FrequencyResponse) -> Table {
    let column = |heading: &str, numeric: bool| Column {
        heading: heading.to_owned(),
        numeric,
    };
    let hz = |value: Option<f64>| or_dash(value, 4);
    let error = |value: Option<f64>| or_dash(value, 2);
    Table {
        caption: "Natural frequencies with standard errors (s.e.): resonances with free motors, \
                  antiresonances while all motors stand still. Overdamped vibrations are absent."
            .to_owned(),
        columns: vec![
            column("joint", false),
            column("vibration", false),
            column("log [Hz]", true),
            column("s.e.", true),
            column("model [Hz]", true),
            column("s.e.", true),
            column("damping, log", true),
            column("damping, model", true),
            column("not by the log, because", false),
        ],
        rows: all(response)
            .map(|(joint, feature)| Row {
                cells: vec![
                    joint.joint.clone(),
                    feature.kind.word().to_owned(),
                    hz(feature.log_hz),
                    error(feature.log_standard_error_hz),
                    hz(Some(feature.model_hz)),
                    error(Some(feature.model_standard_error_hz)),
                    error(feature.log_damping),
                    error(Some(feature.model_damping)),
                    feature.unseen.map_or("", Unseen::words).to_owned(),
                ],
                tone: Tone::Neutral,
            })
            .collect(),
        headings: Vec::new(),
    }
}

/// Returns the frequencies with their intervals; `None` if the log shows none.
fn compared(response: &FrequencyResponse) -> Option<Intervals> {
    let ranged = |hz: f64, error: f64| -> Ranged {
        (hz, Some([hz - NORMAL_95 * error, hz + NORMAL_95 * error]))
    };
    let rows: Vec<_> = all(response)
        .filter_map(|(joint, feature)| {
            let log = ranged(feature.log_hz?, feature.log_standard_error_hz?);
            let model = ranged(feature.model_hz, feature.model_standard_error_hz);
            let label = format!("{} {}", joint.joint, feature.kind.word());
            Some(intervals::of_parameter(
                (&label, "Hz"),
                feature.model_hz,
                &[Some(log), Some(model)],
            ))
        })
        .collect();
    (!rows.is_empty()).then(|| Intervals {
        caption: "Natural frequencies with 95 % intervals. Each row has its own scale.".to_owned(),
        names: vec!["log".to_owned(), "model".to_owned()],
        ticks: Vec::new(),
        rows,
        folded: false,
    })
}

/// Returns the figure of the curves; `None` if the log determines none.
fn figure(response: &FrequencyResponse) -> Option<Figure> {
    let panels: Vec<Panel> = (response.joints.iter())
        .filter(|joint| !joint.frequency_hz.is_empty())
        .flat_map(|joint| {
            [("motor", &joint.motor), ("link", &joint.link)]
                .map(|(side, curves)| panel(joint, side, curves))
        })
        .collect();
    (!panels.is_empty()).then(|| Figure {
        id: "responses".to_owned(),
        caption: "Magnitude of the responses in decibels (0 dB: 1 rad/(N·m), or 1 m/N), with the \
                  standard error of that by the log. Gaps mark frequencies at which the log does not \
                  determine the response."
            .to_owned(),
        x_label: "frequency [Hz]".to_owned(),
        layout: Layout::Stack,
        panels,
    })
}

fn panel(joint: &JointResponse, side: &str, curves: &ResponseCurves) -> Panel {
    let decibels = |magnitude: f64| 20.0 * magnitude.log10();
    let log = |sigmas: f64| -> Vec<Option<f64>> {
        (curves.log_magnitude.iter().zip(&curves.log_relative_error))
            .map(|(magnitude, error)| {
                let factor = 1.0 + sigmas * (*error)?;
                (factor > 0.0).then_some(decibels((*magnitude)? * factor))
            })
            .collect()
    };
    let bound = |name: &str, sigmas: f64| Series {
        name: name.to_owned(),
        values: log(sigmas),
        style: Style::Reference,
        clipped: true,
    };
    let model = Series {
        name: "model".to_owned(),
        values: (curves.model_magnitude.iter())
            .map(|magnitude| Some(decibels(*magnitude)))
            .collect(),
        style: Style::First,
        clipped: false,
    };
    Panel {
        y_label: format!("{} {side} position per torque [dB]", joint.joint),
        x: joint.frequency_hz.clone(),
        series: vec![
            bound("log + 1 s.e.", 1.0),
            bound("log − 1 s.e.", -1.0),
            model,
            measured_series(&log(0.0)),
        ],
        ..Panel::default()
    }
}
