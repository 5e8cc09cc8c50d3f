//! The filter's derivatives compared with differences, on a short log of the demo's robot.

use super::dynamics::{Dynamics, Steps, Tangent};
use super::filter::{FilterRun, Keep, replay, run};
use super::level_search::score;
use super::levels::{Disturbances, Level, Levels, Unknown, UnknownLevels};
use super::likelihood::{LevelLikelihood, Searched};
use super::measurements::{Measurement, Measurements, Noise, Segment, Sensor};
use super::reversals::Reversals;
use super::unknowns::Unknowns;
use crate::demo;
use crate::description::{self, no_files};
use crate::log::Channels;
use crate::model::{Model, Theta};

pub(super) struct Case {
    pub(super) model: Model,
    channels: Channels,
    pub(super) measurements: Measurements,
    pub(super) theta: Theta,
    pub(super) levels: Levels,
}

impl Case {
    /// Two segments of a driven motion, with small errors in the measured positions.
    pub(super) fn new() -> Self {
        Self::of(demo::EXPERIMENT, "")
    }

    /// The same motion with Stribeck friction of unknown velocities in the motors, and with unknown sharpness.
    fn with_stribeck_friction() -> Self {
        let laws = "motor_friction = [\"viscous\", \"coulomb\", \"stribeck\"]\n";
        let mut text = demo::EXPERIMENT.replace("coulomb_sharpness_s_per_rad", "#");
        for name in ["name = \"joint1\"\n", "name = \"joint2\"\n"] {
            text = text.replace(name, &format!("{name}{laws}"));
        }
        Self::of(
            &text,
            "\"joint1.motor_stribeck\" = 0.2\n\"joint2.motor_stribeck\" = 0.05\n",
        )
    }

    fn of(text: &str, more: &str) -> Self {
        let experiment = description::read("experiment.toml", text, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let log = experiment.log.as_ref().unwrap();
        let channels = Channels::new(&experiment.robot, log).unwrap();
        let truth = toml::from_str(&format!("{}\n{more}", demo::TRUTH)).unwrap();
        let theta = model.theta(&truth).unwrap();
        let mut dynamics = Dynamics::new(&model, &theta);
        let sensors = (0..4)
            .map(|row| Sensor {
                spring: None,
                channel: row,
                coordinates: vec![(row, 1.0)],
                offset: 0.0,
                noise: Noise::Counts(1e-3),
                scale: 0.1,
            })
            .collect();
        let period = 1e-3;
        let mut segments = Vec::new();
        for part in 0..2 {
            let mut x = vec![0.0, 0.1, 0.02, 0.1, 0.3, 0.0, 0.1, -0.1];
            let start = x.clone();
            let (mut torque, mut taken, mut first) = (Vec::new(), Vec::new(), vec![0]);
            for k in 0..300 {
                let t = f64::from(k) * period + f64::from(part);
                let tau = [0.0, 0.0, 3.0 * (9.0 * t).sin(), 0.2 * (14.0 * t).cos()];
                for row in 0..4 {
                    if (k + row) % 3 == 0 {
                        let (k, row) = (k as usize, row as usize);
                        taken.push(Measurement {
                            sensor: row,
                            value: x[row] + Self::error(k, row),
                            variance: 1e-8,
                            age: 0.0,
                        });
                    }
                }
                first.push(taken.len());
                torque.extend(tau);
                let steps = dynamics.steps(&x, &tau, period);
                dynamics.advance(&mut x, &tau, period, steps.count);
            }
            segments.push(Segment {
                burn_in: 0,
                span: [0.0, 1.0],
                log: 0,
                period,
                torque_rate: vec![0.0; torque.len()],
                moving: std::sync::Arc::from([]),
                excess: Vec::new(),
                elements: Vec::new(),
                carried: None,
                torque,
                measurements: taken,
                first,
                start,
                start_deviation: vec![1e-3, 1e-3, 1e-3, 1e-3, 0.1, 0.1, 0.1, 0.1],
                speeds: Vec::new(),
            });
        }
        let reversals = Reversals::new(&model, &[0.0; 2]);
        Self {
            model,
            channels,
            measurements: Measurements {
                sensors,
                segments: segments.into(),
                torque_scale: vec![2.0, 0.2, 2.0, 0.2],
                fast_noise: vec![0.0; 4],
                reversals,
                left_out: false,
            },
            theta,
            levels: Levels {
                torque_noise: vec![0.0, 0.001, 0.02, 0.005],
                reversal_noise: vec![0.003, 0.002, 0.05, 0.04],
                disturbance: vec![0.004, 0.002, 0.03, 0.01],
                corner: 2.0,
                sensor_noise: vec![0.0, 3e-5, 1e-5, 2e-5],
            },
        }
    }

    /// Returns the error of a measurement, rad.
    pub(super) fn error(sample: usize, sensor: usize) -> f64 {
        1e-4 * (((7 * sample + 3 * sensor) % 5) as f64 - 2.0)
    }

    pub(super) fn unknowns(&self) -> Unknowns {
        let free = (0..self.theta.len()).collect();
        Unknowns::new(
            &self.model,
            &self.channels,
            &self.measurements,
            &self.theta,
            free,
        )
    }
}

fn agree(found: f64, expected: f64, scale: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() < tolerance * scale.max(expected.abs()),
        "{what}: {found} against {expected}"
    );
}

#[test]
fn a_ramp_moves_the_robot_as_many_short_held_torques() {
    let case = Case::new();
    let x = [0.1, 0.4, 0.12, 0.43, 0.5, -0.3, 0.4, 0.2];
    let (torque, ramp, period) = ([0.01, -0.02, 1.0, 0.1], [0.0, 0.0, 300.0, -40.0], 4e-3);
    let mut dynamics = Dynamics::new(&case.model, &case.theta);
    let moved = |dynamics: &mut Dynamics, ramp: &[f64]| {
        dynamics.set_ramp(ramp.iter().copied());
        let mut x = x.to_vec();
        dynamics.advance(&mut x, &torque, period, 40);
        x
    };
    let [ramped, held] = [&ramp[..], &[]].map(|ramp| moved(&mut dynamics, ramp));
    dynamics.set_ramp(std::iter::empty());
    let (parts, mut stairs) = (400_u32, x.to_vec());
    for part in 0..parts {
        let away = period * ((f64::from(part) + 0.5) / f64::from(parts) - 0.5);
        let now: Vec<f64> = torque
            .iter()
            .zip(ramp)
            .map(|(tau, ramp)| tau + ramp * away)
            .collect();
        dynamics.advance(&mut stairs, &now, period / f64::from(parts), 1);
    }
    for i in 0..stairs.len() {
        // The error of stairs falls with the square of their number: 1/400² of the effect.
        let effect = (stairs[i] - held[i]).abs();
        agree(
            ramped[i],
            stairs[i],
            1e-12 + effect,
            1e-4,
            &format!("state {i}"),
        );
    }
    assert!((stairs[2] - held[2]).abs() > 1e-6, "{stairs:?} {held:?}");
}

#[test]
fn tangent_is_the_limit_of_differences() {
    let case = Case::new();
    let rows = 4;
    let mut dynamics = Dynamics::new(&case.model, &case.theta);
    let mut tangent = Tangent::new(rows, 15, (0..15).map(Some).collect(), Vec::new());
    // One motor is slow, so that its Coulomb friction is not saturated.
    let x = [0.1, 0.4, 0.12, 0.43, 0.5, -0.3, 0.4, 0.004];
    let torque = [0.01, -0.02, 1.0, 0.1];
    // Each step is linearised in its middle, so the steps are short.
    let period = 1e-3;
    let steps = Steps {
        count: 300,
        is_smooth: false,
    };
    // The fastest rate is that of the slow motor's friction. A linearisation in the middle of a step has an error of
    // (rate · step)² in every time constant.
    let of = |name: &str| case.theta[case.model.index_of(name).unwrap()];
    let rate = 100.0 * of("joint2.motor_coulomb") / of("joint2.rotor_inertia");
    let second_order = rate * period * (rate * period / steps.count as f64).powi(2);
    let mut moved = x.to_vec();
    dynamics.advance_tangent(&mut moved, &torque, period, steps, &mut tangent);
    for column in 0..3 * rows + 15 {
        let mut at = |by: f64| {
            let (mut x, mut torque, mut theta) = (x.to_vec(), torque, case.theta.clone());
            let mut by = by;
            if column < 2 * rows {
                x[column] += by;
            } else if column < 3 * rows {
                torque[column - 2 * rows] += by;
            } else {
                by *= theta[column - 3 * rows];
                theta[column - 3 * rows] += by;
            }
            dynamics.set(&theta, None);
            dynamics.advance(&mut x, &torque, period, steps.count);
            (x, by)
        };
        let ((after, up), (before, down)) = (at(1e-5), at(-1e-5));
        for i in 0..2 * rows {
            let difference = (after[i] - before[i]) / (up - down);
            let found = match column.checked_sub(3 * rows) {
                Some(parameter) => tangent.sensitivity[i * 15 + parameter],
                None => tangent.transition[i * 3 * rows + column],
            };
            agree(
                found,
                difference,
                1e-3,
                second_order,
                &format!("column {column} of state {i}"),
            );
        }
    }
}

#[test]
fn gradient_is_that_of_the_replayed_cost() {
    compare_gradient(&Case::new());
}

#[test]
fn gradient_by_scales_of_friction_is_that_of_the_replayed_cost() {
    let case = Case::with_stribeck_friction();
    let unknowns = case.unknowns();
    let z = unknowns.point(&case.theta);
    let scales: Vec<_> = unknowns.scales(&z).collect();
    // Two Stribeck velocities, whose search starts at 0.1 rad/s, and two sharpnesses.
    assert_eq!(scales.len(), 4);
    assert!(scales[..2].iter().all(|of| (of.value - 0.1).abs() < 1e-12));
    assert!(scales[2..].iter().all(|of| (of.value - 100.0).abs() < 1e-9));
    compare_gradient(&case);
}

/// Compares the gradient of a run by every unknown with differences of the replayed cost.
fn compare_gradient(case: &Case) {
    let unknowns = case.unknowns();
    let parameters = case.theta.len();
    let dynamics = Dynamics::new(&case.model, &case.theta);
    let mut z = unknowns.point(&case.theta);
    for (i, z) in z.iter_mut().enumerate().take(parameters) {
        *z *= 1.0 + 0.01 * (i as f64).sin();
    }
    z[parameters] = 2e-4;
    let run = run(
        &case.measurements,
        &dynamics,
        &unknowns,
        (&z, &case.levels),
        Keep::default(),
        |_, _| (),
    );
    let (run, _) = run.unwrap();
    let cost = |z: &[f64]| {
        let found = replay(&case.measurements, &dynamics, &unknowns, z, &run);
        found.unwrap().0
    };
    agree(cost(&z), run.sums.cost, 1.0, 1e-9, "cost");
    for i in 0..z.len() {
        let is_offset = (parameters..parameters + unknowns.offsets.len()).contains(&i);
        let by = if is_offset { 1e-7 } else { 1e-5 * z[i].abs() };
        let at = |by: f64| {
            let mut there = z.clone();
            there[i] += by;
            cost(&there)
        };
        let difference = 0.5 * (at(by) - at(-by)) / (2.0 * by);
        let scale = run.sums.normal.information[i * (z.len() + 1)].sqrt();
        // The derivatives are those of steps linearised in their middles, which shows in the Coulomb friction of a
        // motor at reversals. A gradient that is wrong by a part of its standard deviation moves the estimate by this
        // part of its standard error; this one makes the error 1 % larger.
        let harmless = (1.01_f64.powi(2) - 1.0).sqrt();
        agree(
            run.sums.normal.gradient[i],
            difference,
            scale,
            harmless,
            &format!("unknown {i}"),
        );
    }
}

/// Returns a run of the filter and its unknown levels.
pub(super) fn search_of(case: &Case, disturbances: Disturbances) -> (FilterRun, UnknownLevels) {
    let unknowns = case.unknowns();
    let dynamics = Dynamics::new(&case.model, &case.theta);
    let z = unknowns.point(&case.theta);
    let keep = Keep {
        linearization: true,
        ..Keep::default()
    };
    let (measurements, levels) = (&case.measurements, &case.levels);
    let at = (z.as_slice(), levels);
    let run = run(measurements, &dynamics, &unknowns, at, keep, |_, _| ());
    let unknown = Unknown {
        torques: vec![false, true, true, true],
        reversals: vec![true; 4],
        disturbances,
        sensors: vec![false, true, true, true],
    };
    (run.unwrap().0, UnknownLevels::new(measurements, &unknown))
}

/// Returns logarithms of levels that differ from those of the run by powers of a factor.
fn away(case: &Case, search: &UnknownLevels, factor: f64) -> Vec<f64> {
    let logs = search.logarithms(&case.levels).into_iter().enumerate();
    logs.map(|(i, log)| log + f64::ln(factor) * ((i % 6) as f64 - 2.5))
        .collect()
}

#[test]
fn levels_have_the_gradient_of_the_likelihood() {
    let case = Case::new();
    let (run, search) = search_of(&case, Disturbances::Free);
    let searched = Searched::new(&case.measurements, 500);
    let likelihood = LevelLikelihood::new(&case.measurements, &run, &searched);
    for factor in [1.0, 1.3] {
        let logs = away(&case, &search, factor);
        let at = |i: usize, by: f64| {
            let mut logs = logs.clone();
            logs[i] += by;
            score(&likelihood, &search, &search.levels(&case.levels, &logs)).unwrap()
        };
        let here = at(0, 0.0);
        for (i, found) in here.gradient.iter().enumerate() {
            let step = 1e-4;
            let difference = (at(i, step).loss - at(i, -step).loss) / (2.0 * step);
            let scale = here.information[i * (here.gradient.len() + 1)].sqrt();
            // The loss is a sum over 600 samples.
            let rounding = 600.0 * f64::EPSILON * here.loss.abs().max(1.0) / step;
            agree(
                *found,
                difference,
                scale.max(1.0),
                rounding + step * step,
                &format!("level {i} at {factor}"),
            );
        }
    }
}

#[test]
fn information_is_what_the_found_part_of_the_gradient_changes_by() {
    // Let P⁻¹ be the covariance of the data y, W its derivative by the logarithm of level i, and V
    // that by level j. The found part is y' P W P y / 2. Its derivative is -y' P W P V P y plus the
    // change of W itself, which is 2 W if i = j. Doubled data separate the found part from the
    // expected part.
    let case = Case::new();
    let (run, search) = search_of(&case, Disturbances::Free);
    let searched = Searched::new(&case.measurements, 500);
    let twice = run.scaled(2.0);
    let logs = away(&case, &search, 1.1);
    let count = logs.len();
    let found = |j: usize, by: f64| -> Vec<f64> {
        let mut logs = logs.clone();
        logs[j] += by;
        let levels = search.levels(&case.levels, &logs);
        let gradient = |run| {
            let likelihood = LevelLikelihood::new(&case.measurements, run, &searched);
            likelihood.score(&search, &levels).unwrap().gradient
        };
        let (once, twice) = (gradient(&run), gradient(&twice));
        (once.iter().zip(&twice))
            .map(|(a, b)| (a - b) / 3.0)
            .collect()
    };
    let likelihood = LevelLikelihood::new(&case.measurements, &run, &searched);
    let score = likelihood.score(&search, &search.levels(&case.levels, &logs));
    let score = score.unwrap();
    let here = found(0, 0.0);
    for j in 0..count {
        let (after, before) = (found(j, 1e-4), found(j, -1e-4));
        for i in 0..count {
            // W also changes with the second level here, so the formula does not hold.
            let both = (search.all[i], search.all[j]);
            if let (Level::Corner, _) | (Level::Disturbance(_), Level::Corner) = both {
                continue;
            }
            let diagonal = if i == j { 2.0 * here[i] } else { 0.0 };
            let expected = 0.5 * (diagonal - (after[i] - before[i]) / 2e-4);
            let entry = score.information[i.max(j) * count + i.min(j)];
            let scale =
                (score.information[i * (count + 1)] * score.information[j * (count + 1)]).sqrt();
            // Sums over 600 samples in single precision.
            let limit = 600.0 * f64::from(f32::EPSILON);
            agree(entry, expected, scale.max(1.0), limit, &format!("{both:?}"));
        }
        if search.all[j] != Level::Corner {
            let found = score.expected[j] - score.gradient[j];
            agree(found, here[j], 1.0, 1e-9, "found part");
        }
    }
}
