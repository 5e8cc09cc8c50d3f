//! Faults of logs, and their injection.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use sprung_robot::{Cutoff, Experiment};

use super::twin::{Demo, Table};

/// A log with a fault. A wrong setting is a fault too.
pub(crate) struct Fault {
    pub(crate) table: Table,
    position_cutoff_hz: Option<f64>,
}

impl Fault {
    pub(crate) fn none(table: Table) -> Self {
        Self {
            table,
            position_cutoff_hz: None,
        }
    }

    /// Returns the experiment of the log.
    pub(crate) fn experiment(&self, demo: &Experiment) -> Experiment {
        let mut experiment = demo.clone();
        if let Some(cutoff) = self.position_cutoff_hz {
            experiment.identify.position_cutoff_hz = Cutoff::Fixed(cutoff);
        }
        experiment
    }
}

/// A kind of fault.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    /// Sizes from small to large. For a fault without size: the columns concerned.
    pub(crate) sizes: [f64; 5],
    pub(crate) unit: &'static str,
    /// Codes of the findings that identify the fault.
    pub(crate) codes: &'static [&'static str],
    damage: fn(&mut Table, f64, &mut ChaCha8Rng),
}

const Q: usize = 0;
const PHI: usize = 2;
const TAU: usize = 4;

const NO_SIZE: [f64; 5] = [1.0, 2.0, 3.0, 1.0, 2.0];

impl Kind {
    pub(crate) fn inject(&self, demo: &Demo, size: f64, seed: u64) -> Fault {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let table = match self.name {
            "coarse encoders" => demo.with_counts(seed, size as u32),
            "small motion" => demo.table(seed, size),
            _ => demo.table(seed, 1.0),
        };
        let mut fault = Fault::none(table);
        if self.name == "position filter too slow" {
            fault.position_cutoff_hz = Some(size);
        }
        (self.damage)(&mut fault.table, size, &mut rng);
        fault
    }
}

/// Returns a random joint.
fn joint(rng: &mut ChaCha8Rng) -> usize {
    usize::from(rng.random::<bool>())
}

/// Returns a random sample that is not near the ends.
fn sample(table: &Table, rng: &mut ChaCha8Rng) -> usize {
    let part: f64 = rng.random_range(0.1..0.8);
    (part * table.time.len() as f64) as usize
}

/// Returns the joints concerned by a fault without size: the first, the second or both.
fn which(size: f64) -> Vec<usize> {
    match size as usize {
        1 => vec![0],
        2 => vec![1],
        _ => vec![0, 1],
    }
}

fn scale(table: &mut Table, first: usize, joints: &[usize], by: f64) {
    for joint in joints {
        table.columns[first + joint]
            .iter_mut()
            .for_each(|value| *value *= by);
    }
}

fn hold(table: &mut Table, column: usize, size: f64, rng: &mut ChaCha8Rng) {
    let from = sample(table, rng);
    let value = table.columns[column][from];
    table.columns[column][from..from + size as usize].fill(value);
}

fn spike(table: &mut Table, column: usize, size: f64, rng: &mut ChaCha8Rng) {
    let at = sample(table, rng);
    let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
    table.columns[column][at] += sign * size;
}

fn delay(table: &mut Table, first: usize, size: f64, rng: &mut ChaCha8Rng) {
    *table = table.delayed(first + joint(rng), size as usize);
}

fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / n)
        .sqrt()
}

fn noise(table: &mut Table, column: usize, size: f64, rng: &mut ChaCha8Rng) {
    for value in &mut table.columns[column] {
        *value += size * rng.sample::<f64, _>(StandardNormal);
    }
}

pub(crate) const KINDS: [Kind; 34] = [
    Kind {
        name: "gap",
        sizes: [2.0, 5.0, 20.0, 100.0, 500.0],
        unit: "ms",
        codes: &["gaps", "dropped-samples"],
        damage: |table, size, rng| {
            let from = sample(table, rng);
            let gap = from..from + size as usize;
            table.retain(|k| !gap.contains(&k));
        },
    },
    Kind {
        name: "dropped samples",
        sizes: [1.0, 3.0, 10.0, 30.0, 100.0],
        unit: "",
        codes: &["gaps", "dropped-samples"],
        damage: |table, size, rng| {
            let lost: Vec<usize> = (0..size as usize).map(|_| sample(table, rng)).collect();
            table.retain(|k| !lost.contains(&k));
        },
    },
    Kind {
        name: "repeated samples",
        sizes: [1.0, 3.0, 10.0, 30.0, 100.0],
        unit: "",
        codes: &["repeated-samples"],
        damage: |table, size, rng| {
            for _ in 0..size as usize {
                let at = sample(table, rng);
                for column in table.columns.iter_mut().chain([&mut table.time]) {
                    column.insert(at, column[at]);
                }
            }
        },
    },
    Kind {
        name: "stamps off",
        sizes: [0.03, 0.05, 0.1, 0.2, 0.4],
        unit: "periods",
        codes: &["jitter", "uneven-sampling"],
        damage: |table, size, rng| {
            let period = table.time[1] - table.time[0];
            for time in &mut table.time {
                *time += 0.5 * size * period * rng.random_range(-1.0..1.0);
            }
        },
    },
    Kind {
        // Times in milliseconds, microseconds and nanoseconds are read as seconds.
        name: "time in another unit",
        sizes: [1e3, 1e6, 1e9, 1e3, 1e6],
        unit: "times",
        codes: &["time-unit"],
        damage: |table, size, _| table.time.iter_mut().for_each(|time| *time *= size),
    },
    Kind {
        name: "torque stuck",
        sizes: [6.0, 10.0, 30.0, 100.0, 500.0],
        unit: "ms",
        codes: &["stuck-samples"],
        damage: |table, size, rng| {
            let column = TAU + joint(rng);
            hold(table, column, size, rng);
        },
    },
    Kind {
        name: "link position stuck",
        sizes: [50.0, 100.0, 150.0, 200.0, 300.0],
        unit: "ms",
        codes: &["stuck-samples"],
        damage: |table, size, rng| {
            let column = Q + joint(rng);
            hold(table, column, size, rng);
        },
    },
    Kind {
        name: "motor position stuck",
        sizes: [100.0, 150.0, 200.0, 300.0, 500.0],
        unit: "ms",
        codes: &["stuck-samples"],
        damage: |table, size, rng| {
            let column = PHI + joint(rng);
            hold(table, column, size, rng);
        },
    },
    Kind {
        name: "spike of a position",
        sizes: [0.005, 0.01, 0.02, 0.1, 1.0],
        unit: "rad",
        codes: &["spikes"],
        damage: |table, size, rng| {
            let column = Q + 2 * joint(rng) + joint(rng);
            spike(table, column, size, rng);
        },
    },
    Kind {
        name: "spike of a torque",
        sizes: [1.0, 2.0, 4.0, 8.0, 16.0],
        unit: "deviations",
        codes: &["spikes"],
        damage: |table, size, rng| {
            let column = TAU + joint(rng);
            let size = size * deviation(&table.columns[column]);
            spike(table, column, size, rng);
        },
    },
    Kind {
        name: "position jumps",
        sizes: [0.01, 0.02, 0.05, 0.1, 0.5],
        unit: "rad",
        // After a standstill, a jump resembles the end of a stall.
        codes: &["position-jumps", "stuck-samples"],
        damage: |table, size, rng| {
            let (column, from) = (Q + 2 * joint(rng) + joint(rng), sample(table, rng));
            table.columns[column][from..]
                .iter_mut()
                .for_each(|value| *value += size);
        },
    },
    Kind {
        name: "counter wraps around",
        sizes: [0.9, 0.7, 0.5, 0.3, 0.2],
        unit: "of the range",
        codes: &["wraps-around"],
        damage: |table, size, rng| {
            let column = Q + 2 * joint(rng) + joint(rng);
            let wrap = size * table.range(column);
            for value in &mut table.columns[column] {
                *value = value.rem_euclid(wrap);
            }
        },
    },
    Kind {
        name: "torque saturated",
        sizes: [0.95, 0.9, 0.8, 0.6, 0.4],
        unit: "of the peak",
        codes: &["torque-saturated"],
        damage: |table, size, rng| {
            let column = &mut table.columns[TAU + joint(rng)];
            let peak = column.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for value in column {
                *value = value.clamp(-size * peak, size * peak);
            }
        },
    },
    Kind {
        name: "constant column",
        sizes: [0.0, 0.01, 0.1, 1.0, 10.0],
        unit: "",
        codes: &["constant-column"],
        damage: |table, size, rng| {
            let column = Q + 2 * rng.random_range(0..3) + joint(rng);
            table.columns[column].fill(size);
        },
    },
    Kind {
        name: "link and motor exchanged",
        sizes: NO_SIZE,
        unit: "",
        codes: &["exchanged-columns"],
        damage: |table, size, _| {
            for joint in which(size) {
                table.columns.swap(Q + joint, PHI + joint);
            }
        },
    },
    Kind {
        name: "torques of joints swapped",
        sizes: [1.0; 5],
        unit: "",
        codes: &["swapped-joints"],
        damage: |table, _, _| table.columns.swap(TAU, TAU + 1),
    },
    Kind {
        name: "links of joints swapped",
        sizes: [1.0; 5],
        unit: "",
        codes: &["swapped-joints"],
        damage: |table, _, _| table.columns.swap(Q, Q + 1),
    },
    Kind {
        name: "sign of a link",
        sizes: NO_SIZE,
        unit: "",
        codes: &["opposite-signs"],
        damage: |table, size, _| scale(table, Q, &which(size), -1.0),
    },
    Kind {
        name: "sign of a motor",
        sizes: NO_SIZE,
        unit: "",
        codes: &["opposite-signs"],
        damage: |table, size, _| scale(table, PHI, &which(size), -1.0),
    },
    Kind {
        name: "sign of a torque",
        sizes: NO_SIZE,
        unit: "",
        codes: &["reversed-torque"],
        damage: |table, size, _| scale(table, TAU, &which(size), -1.0),
    },
    Kind {
        name: "degrees, links",
        sizes: NO_SIZE,
        unit: "",
        codes: &["units-disagree"],
        damage: |table, size, _| scale(table, Q, &which(size), 1_f64.to_degrees()),
    },
    Kind {
        name: "degrees, motors",
        sizes: NO_SIZE,
        unit: "",
        codes: &["units-disagree"],
        damage: |table, size, _| scale(table, PHI, &which(size), 1_f64.to_degrees()),
    },
    Kind {
        name: "degrees, both encoders",
        sizes: NO_SIZE,
        unit: "",
        codes: &["looks-like-degrees", "torque-scale"],
        damage: |table, size, _| {
            scale(table, Q, &which(size), 1_f64.to_degrees());
            scale(table, PHI, &which(size), 1_f64.to_degrees());
        },
    },
    Kind {
        name: "motor before the gearbox",
        sizes: [1.5, 3.0, 10.0, 50.0, 160.0],
        unit: ":1",
        codes: &["slope-not-one", "units-disagree"],
        damage: |table, size, rng| scale(table, PHI, &[joint(rng)], size),
    },
    Kind {
        name: "link late",
        sizes: [1.0, 2.0, 5.0, 10.0, 20.0],
        unit: "ms",
        codes: &["delayed-channel"],
        damage: |table, size, rng| delay(table, Q, size, rng),
    },
    Kind {
        name: "motor late",
        sizes: [1.0, 2.0, 5.0, 10.0, 20.0],
        unit: "ms",
        codes: &["delayed-channel"],
        damage: |table, size, rng| delay(table, PHI, size, rng),
    },
    Kind {
        name: "torque late",
        sizes: [1.0, 2.0, 5.0, 10.0, 20.0],
        unit: "ms",
        codes: &["delayed-channel"],
        damage: |table, size, rng| delay(table, TAU, size, rng),
    },
    Kind {
        name: "encoders offset",
        sizes: [0.005, 0.01, 0.02, 0.05, 0.1],
        unit: "rad",
        codes: &["encoder-offset"],
        damage: |table, size, rng| {
            let column = Q + joint(rng);
            table.columns[column]
                .iter_mut()
                .for_each(|value| *value += size);
        },
    },
    Kind {
        name: "small motion",
        sizes: [0.05, 0.03, 0.02, 0.01, 0.005],
        unit: "of the demo's",
        codes: &[
            "hardly-moves",
            "only-friction",
            "noisy-signal",
            "unexcited-joint",
        ],
        damage: |_, _, _| (),
    },
    Kind {
        name: "joint stands still",
        sizes: NO_SIZE,
        unit: "",
        codes: &["unexcited-joint"],
        damage: |table, size, _| {
            for joint in which(size) {
                for column in [Q, PHI] {
                    let first = table.columns[column + joint][0];
                    table.columns[column + joint].fill(first);
                }
            }
        },
    },
    Kind {
        name: "torque in another unit",
        sizes: [0.001, 0.05, 20.0, 100.0, 1000.0],
        unit: "times",
        codes: &["torque-scale"],
        damage: |table, size, rng| scale(table, TAU, &[joint(rng)], size),
    },
    Kind {
        name: "coarse encoders",
        sizes: [1024.0, 512.0, 256.0, 128.0, 64.0],
        unit: "counts",
        codes: &["noisy-signal", "hardly-moves"],
        damage: |_, _, _| (),
    },
    Kind {
        name: "noisy link",
        sizes: [0.02, 0.03, 0.05, 0.1, 0.2],
        unit: "rad",
        codes: &["noisy-signal"],
        damage: |table, size, rng| {
            let column = Q + joint(rng);
            noise(table, column, size, rng);
        },
    },
    Kind {
        name: "position filter too slow",
        sizes: [3.0, 2.5, 2.0, 1.5, 1.0],
        unit: "Hz",
        codes: &["position-cutoff-low"],
        damage: |_, _, _| (),
    },
];
