//! Logs whose numbers can be read, but belong to no robot or have another unit.
//!
//! The benchmark of faults injects the other faults of logs; `crates/sprung/tests/check` tests them.

use super::Faulty;
use crate::common::demo;

const TIME: usize = 0;
const Q1: usize = 1;
const PHI1: usize = 3;
const PHI2: usize = 4;
const TAU1: usize = 5;
const TAU2: usize = 6;

/// The demo's experiment with another log, and with least squares alone, because it is quick.
fn faulty(
    name: &str,
    says: &[&'static str],
    mut change: impl FnMut(usize, &mut Vec<f64>),
) -> Faulty {
    let text = std::fs::read_to_string(demo().join("identification.csv")).unwrap();
    let mut lines = text.lines();
    let mut log = format!("{}\n", lines.next().unwrap());
    for (row, line) in lines.enumerate() {
        let mut numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        change(row, &mut numbers);
        if !numbers.is_empty() {
            let cells: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            log.push_str(&cells.join(","));
            log.push('\n');
        }
    }
    let experiment = std::fs::read(demo().join("experiment.toml")).unwrap();
    Faulty {
        name: name.to_owned(),
        files: vec![
            ("experiment.toml".to_owned(), experiment),
            ("identification.csv".to_owned(), log.into_bytes()),
        ],
        code: 3,
        says: says.to_vec(),
    }
    .naming(
        "[\"prediction-error\", \"least-squares\", \"lsff\"]",
        "\"least-squares\"",
    )
}

/// Another value of one column.
fn column(name: &str, at: usize, says: &[&'static str], change: impl Fn(f64) -> f64) -> Faulty {
    faulty(name, says, |_, numbers| numbers[at] = change(numbers[at]))
}

pub(super) fn all() -> Vec<Faulty> {
    [units(), numbers(), samples()]
        .into_iter()
        .flatten()
        .collect()
}

#[rustfmt::skip]
fn units() -> Vec<Faulty> {
    vec![
        column("a motor in degrees", PHI1, &["units-disagree", "motor_position_deg"], f64::to_degrees),
        column("a motor before its gears", PHI1, &["units-disagree", "motor side of the gearbox"], |x| 101.0 * x),
        column("a motor that counts back", PHI2, &["opposite-signs"], |x| { -x }),
        column("a torque the wrong way round", TAU2, &["reversed-torque"], |x| -x),
        column("a torque in mN·m", TAU1, &["torque-scale"], |x| 1e3 * x).code(0),
        column("a time in ms", TIME, &["time-unit"], |t| 1e3 * t),
        faulty("columns of two encoders exchanged", &["exchanged-columns"], |_, numbers| { numbers.swap(Q1, PHI1); }),
    ]
}

#[rustfmt::skip]
fn numbers() -> Vec<Faulty> {
    vec![
        column("an encoder that is not connected", PHI2, &["constant-column"], |_| 0.0131),
        column("a torque of zero", TAU1, &["constant-column"], |_| 0.0),
        column("positions beyond reason", Q1, &["units-disagree"], |x| { 1e200 * x }),
        faulty(
            "a joint beyond reason",
            &["position-jumps"],
            |_, numbers| {
                numbers[Q1] *= 1e200;
                numbers[PHI1] *= 1e200;
            },
        )
        .code(0),
        column("positions near nothing", Q1, &["hardly-moves"], |x| { 1e-300 * x }).code(0),
        faulty(
            "a counter that starts anew",
            &["wraps-around"],
            |_, numbers| {
                // The position wraps between plus and minus half a hundredth of a turn.
                let wrap = 0.03;
                numbers[Q1] -= wrap * (numbers[Q1] / wrap).round();
            },
        ),
        faulty(
            "one sample like the largest float",
            &["spikes"],
            |row, numbers| {
                if row == 5000 {
                    numbers[TAU1] = f64::MAX;
                }
            },
        )
        .code(0),
        faulty("a robot that rests", &["unexcited-joint"], |_, numbers| { numbers[1..5].fill(0.25); }).code(1),
    ]
}

#[rustfmt::skip]
fn samples() -> Vec<Faulty> {
    vec![
        faulty("every second sample twice", &["repeated-samples"], {
            let mut last = Vec::new();
            move |row, numbers: &mut Vec<f64>| {
                if row % 50 == 49 {
                    numbers.clone_from(&last);
                }
                last.clone_from(numbers);
            }
        })
        .code(0),
        faulty("a second that is missing", &["gaps"], |row, numbers| {
            if (5000..6000).contains(&row) {
                numbers.clear();
            }
        })
        .code(0),
        faulty("two samples", &["unexcited-joint"], |row, numbers| { if row > 1 { numbers.clear(); } }).code(1),
        faulty("ten samples", &["constant-column", "too-short-to-examine"], |row, numbers| { if row > 9 { numbers.clear(); } }),
        faulty(
            "a last sample a million years later",
            &["gaps"],
            |row, numbers| {
                if row == 9999 {
                    numbers[TIME] = 3e13;
                }
            },
        )
        .code(0),
    ]
}
