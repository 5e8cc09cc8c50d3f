//! Simulates the logs of a servo.

use std::collections::BTreeMap;
use std::io::Write;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sprung_core::servo::{Load, Servo, ServoParameter, ServoParameters, ServoState};

use super::bench::Bench;
use super::window::P;
use crate::description::{Quantity, Simulate};
use crate::log::{Channels, SampleWriter};
use crate::progress::{Listener, Phase};
use crate::simulate::{Disturbance, Encoder, RecordError, Trajectory};

/// Step of the integration, s.
const STEP_S: f64 = 1e-4;

/// A servo that is ready to be simulated with one of its loads.
pub struct ServoTwin<'a> {
    /// Drive law, known loads and unknown parameters.
    pub bench: &'a Bench,
    /// Load on the servo.
    pub load: Load,
    /// Parameters of the servo.
    pub values: [f64; P],
    /// Settings of the simulation.
    pub settings: &'a Simulate,
    /// Target positions over time.
    pub target: Trajectory,
    /// Columns of the log.
    pub channels: &'a Channels,
    /// Seed of encoder and disturbance.
    pub seed: u64,
}

/// Returns the parameters of a servo from values by name.
///
/// # Errors
///
/// The names that are missing.
pub fn truth(bench: &Bench, values: &BTreeMap<String, f64>) -> Result<[f64; P], Vec<String>> {
    let mut missing = Vec::new();
    let mut found = [0.0; P];
    for (found, parameter) in found.iter_mut().zip(ServoParameter::ALL) {
        let (name, _) = bench.name(parameter);
        let name = format!("{}.{name}", bench.joint);
        *found = match (values.get(&name), bench.known(parameter)) {
            (Some(value), _) if parameter == ServoParameter::LogStribeckVelocity => value.ln(),
            (Some(value), _) => *value,
            (None, Some(known)) => known,
            (None, None) => {
                missing.push(name);
                0.0
            }
        };
    }
    if missing.is_empty() {
        Ok(found)
    } else {
        Err(missing)
    }
}

/// Returns the parameters of a servo by name.
#[must_use]
pub fn named(bench: &Bench, values: &[f64; P]) -> BTreeMap<String, f64> {
    (ServoParameter::ALL.into_iter().zip(values))
        .map(|(parameter, value)| {
            let (name, _) = bench.name(parameter);
            let value = if parameter == ServoParameter::LogStribeckVelocity {
                value.exp()
            } else {
                *value
            };
            (format!("{}.{name}", bench.joint), value)
        })
        .collect()
}

/// Returns whether the drive is on at a time, s.
fn is_on(settings: &Simulate, time: f64) -> bool {
    let mut off = settings.drive_off_s.iter();
    !off.any(|[from, to]| (*from..*to).contains(&time))
}

/// Runs the servo from rest and writes its log. Returns the number of samples.
///
/// # Errors
///
/// [`RecordError`] if the log cannot be written or the listener stops the run.
pub fn record_servo(
    twin: &ServoTwin<'_>,
    write: impl Write,
    progress: &mut dyn Listener,
) -> Result<u64, RecordError> {
    let settings = twin.settings;
    let mut rng = ChaCha8Rng::seed_from_u64(twin.seed);
    let mut desired = [[0.0; 5]];
    twin.target.at(0.0, &mut desired);
    let counts = settings.motor_encoder_counts_per_turn.first().copied();
    let turn = std::f64::consts::TAU;
    let encoder = Encoder::new(counts.unwrap_or(0), turn, desired[0][0], &mut rng);
    let level = settings
        .torque_disturbance_nm
        .first()
        .copied()
        .unwrap_or(0.0);
    let mut disturbance = Disturbance::new(level, STEP_S, &mut rng);
    let servo = Servo::new(ServoParameters(twin.values), twin.load);
    let mut state = ServoState {
        position: desired[0][0],
        velocity: 0.0,
    };
    let steps = (settings.period_s / STEP_S).round().max(1.0);
    let step = settings.period_s / steps;
    let hold = (twin.bench.loop_period).map_or(1, |period| (period / step).round().max(1.0) as u64);
    let samples = (settings.duration_s / settings.period_s).round().max(1.0) as u64;
    let mut writer = SampleWriter::new(write, twin.channels)?;
    let (mut command, mut done) = (0.0, 0);
    for k in 0..samples {
        let time = k as f64 * settings.period_s;
        twin.target.at(time, &mut desired);
        let [target, ..] = desired[0];
        let on = is_on(settings, time);
        let position = encoder.read(state.position);
        writer.write(time, |quantity| match quantity {
            Quantity::MotorTarget => target,
            Quantity::DriveOn => f64::from(u8::from(on)),
            Quantity::LinkPosition
            | Quantity::LinkDeflection
            | Quantity::MotorPosition
            | Quantity::MotorTorque
            | Quantity::JointTorque
            | Quantity::Inertial(..)
            | Quantity::Covariate(_) => position,
        })?;
        for _ in 0..steps as u64 {
            if done % hold == 0 {
                let read = encoder.read(state.position);
                command = twin.bench.law.command(target, read, state.velocity);
            }
            done += 1;
            let torque = disturbance.next(&mut rng);
            state = servo.step(state, on.then_some(command), torque, step);
        }
        if (k + 1).is_multiple_of(1024) {
            progress.tell(Phase::Simulating, k + 1, Some(samples))?;
        }
    }
    writer.finish()?;
    Ok(samples)
}
