//! Payloads of a twin with six joints: the first six of the example with seven.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_core::spatial::BODY_NAMES;
use sprung_log::{Input, LogSource};
use sprung_method::estimate::{PayloadResult, identify};
use sprung_model::Model;
use sprung_robot::{self as description, Payload, no_files};
use sprung_testing::Figure;
use toml::{Table, Value};

use crate::{EXPERIMENT, TRUTH, Twin};

const DURATION_S: f64 = 30.0;
const NOISE_NM: f64 = 1.0;
const MASSES_KG: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];

/// Centre of mass, m, and inertia about it of a block of 1 kg, kg·m²: xx, xy, xz, yy, yz, zz.
const CENTRE: [f64; 3] = [0.02, -0.03, 0.08];
const INERTIA: [f64; 6] = [0.0022, 0.0001, -0.0002, 0.0018, 0.0001, 0.0015];

/// Prints the errors and intervals of payloads.
pub(crate) fn payloads(seeds: u32) {
    println!(
        "\nTwin with six joints, torque noise {NOISE_NM} N·m, logs of {DURATION_S} s at 1 kHz without and with \
         payload, least squares, {seeds} pairs per row.\n"
    );
    println!(
        "| payload | mass, largest error | centre of mass, largest error | intervals that hold |"
    );
    println!("|---|---|---|---|");
    let (mut held, mut all) = (0, 0);
    for mass in MASSES_KG {
        let truth = body(mass);
        let found: Vec<PayloadResult> = (1..=seeds)
            .into_par_iter()
            .map(|seed| found(mass, seed))
            .collect();
        let of_mass = found
            .iter()
            .map(|result| (result.parameters[0].value.unwrap_or(f64::NAN) / mass - 1.0).abs());
        let of_centre = found.iter().map(|result| {
            let squares = result
                .centre_of_mass_m
                .iter()
                .zip(CENTRE)
                .map(|(a, b)| (a.map_or(f64::NAN, |entry| entry.0) - b).powi(2));
            squares.sum::<f64>().sqrt()
        });
        let holds = found.iter().map(|result| {
            let pairs = result.parameters.iter().zip(truth);
            pairs
                .filter(|(parameter, truth)| {
                    parameter
                        .ci95
                        .is_some_and(|ci| ci[0] <= *truth && *truth <= ci[1])
                })
                .count()
        });
        let held_here = holds.sum::<usize>();
        held += held_here;
        all += found.len() * truth.len();
        let mass_percent = 100.0 * of_mass.fold(0.0, f64::max);
        let centre_mm = 1e3 * of_centre.fold(0.0, f64::max);
        let inside = 100.0 * held_here as f64 / (found.len() * truth.len()) as f64;
        println!("| {mass} kg | {mass_percent:.2} % | {centre_mm:.1} mm | {inside:.0} % |");
        for (what, value, unit) in [
            ("largest error of the mass", mass_percent, "%"),
            ("largest error of the centre of mass", centre_mm, "mm"),
        ] {
            let name = format!("payload, {mass} kg, {what}");
            Figure::lower(&name, &format!("{mass} kg: {what}"), value, unit).note();
        }
    }
    let inside = 100.0 * f64::from(held as u32) / all as f64;
    println!("\nAll intervals: {inside:.1} % hold.");
    let text = "95 % intervals that contain the truth";
    Figure::neutral("payload, inside", text, inside, "%").note();
}

/// Inertial parameters of a payload about the origin of the joint.
fn body(mass: f64) -> [f64; 10] {
    let payload = Payload {
        mass_kg: Some(mass),
        com_m: Some(CENTRE),
        inertia_kg_m2: Some(INERTIA.map(|value| mass * value)),
        ..Payload::default()
    };
    payload.known().expect("the payload is known")
}

/// Identifies a payload from a log without and a log with it.
fn found(mass: f64, seed: u32) -> PayloadResult {
    let text = six_joints(EXPERIMENT);
    let experiment = description::read("arm", &text, &[], &mut no_files)
        .expect("the example without its last joint is an experiment");
    let model = Model::new(&experiment).expect("it is a robot");
    let truth: BTreeMap<String, f64> = toml::from_str(TRUTH).expect("the example has true values");
    let twin = |values| {
        let twin = Twin {
            experiment: &experiment,
            model: &model,
            values,
        };
        move |seed| twin.log((NOISE_NM, seed), DURATION_S)
    };
    let mut loaded = truth.clone();
    for (name, value) in BODY_NAMES.iter().zip(body(mass)) {
        *loaded.entry(format!("link6.{name}")).or_default() += value;
    }
    let without = twin(&truth)(2 * seed);
    let with = twin(&loaded)(2 * seed + 1);
    let (mut without, mut with) = (opener(without), opener(with));
    let mut logs = [
        LogSource::files("without", &mut without),
        LogSource::files("with", &mut with).carrying(Some(Payload::default())),
    ];
    let found = identify(&experiment, &model, &mut logs, &mut Unheard)
        .expect("the twin's logs can be identified");
    let mut payloads = found.identification.payloads.into_iter();
    payloads.next().expect("the logs determine the payload")
}

fn opener(log: Vec<u8>) -> impl FnMut(Option<&Path>) -> std::io::Result<Box<dyn Input>> + Send {
    move |_: Option<&Path>| Ok(Box::new(std::io::Cursor::new(log.clone())) as Box<dyn Input>)
}

/// Returns the text of the example without its last joint.
fn six_joints(text: &str) -> String {
    let mut table: Table = text.parse().expect("the example is TOML");
    shorten(&mut table);
    table.to_string()
}

/// Leaves out the last of seven numbers or tables, and values of the last joint.
fn shorten(table: &mut Table) {
    table.retain(|key, _| !key.starts_with("link7") && !key.starts_with("joint7"));
    for (_, value) in table.iter_mut() {
        shorten_value(value);
    }
}

fn shorten_value(value: &mut Value) {
    match value {
        Value::Table(table) => shorten(table),
        Value::Array(array) => {
            array.retain(|entry| entry.get("joint").and_then(Value::as_str) != Some("joint7"));
            match array.len() {
                7 => array.truncate(6),
                28 => {
                    let all = std::mem::take(array).into_iter().enumerate();
                    array.extend(all.filter(|(i, _)| i % 7 < 6).map(|(_, entry)| entry));
                }
                _ => {}
            }
            array.iter_mut().for_each(shorten_value);
        }
        _ => {}
    }
}
