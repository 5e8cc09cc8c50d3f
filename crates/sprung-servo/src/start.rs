//! First values of the parameters, by linear least squares.
//!
//! Velocities and accelerations come from smoothed positions. The torque that the known load needs is
//! a sum of terms that are linear in the torque per command, the armature, viscous friction, Coulomb
//! friction and the friction under load. The errors of the velocities bias the result, which is only
//! a start.

use sprung_core::servo::ServoParameter;

use super::bench::Bench;
use super::matrix::damped;
use super::record::Record;
use super::result::Scale;
use super::window::P;

/// Samples slower than this part of the root mean square velocity are left out, because friction
/// reverses there.
const SLOW: f64 = 0.2;

/// Samples over which the velocity is differenced, on each side.
const SIDE: usize = 3;

/// Number of linear terms.
const TERMS: usize = 5;

/// Returns first values of the parameters, or `None` if the motion does not determine them.
pub(super) fn start(bench: &Bench, records: &[Record]) -> Option<[f64; P]> {
    let back_emf = bench.known(ServoParameter::BackEmf).unwrap_or(0.0);
    let known_scale = bench.known(ServoParameter::TorquePerCommand);
    let mut matrix = [0.0; TERMS * TERMS];
    let mut right = [0.0; TERMS];
    for record in records {
        let slow = SLOW * record.rms_velocity();
        for k in SIDE..record.position.len().saturating_sub(SIDE) {
            let (mut row, mut needed) = terms(bench, record, back_emf, k);
            if row[2].abs() < slow {
                continue;
            }
            if let Some(scale) = known_scale {
                needed -= scale * row[0];
                row[0] = 0.0;
            }
            for i in 0..TERMS {
                right[i] += row[i] * needed;
                for j in 0..TERMS {
                    matrix[i * TERMS + j] += row[i] * row[j];
                }
            }
        }
    }
    // Terms without effect keep the value zero.
    for i in 0..TERMS {
        if matrix[i * TERMS + i] <= 0.0 {
            matrix[i * TERMS + i] = 1.0;
        }
    }
    let found = damped(&matrix, &right, 1e-9)?;
    let scale = known_scale.unwrap_or(found[0]);
    if scale <= 0.0 {
        return None;
    }
    Some(values(bench, records, scale, &found))
}

/// Returns the linear terms of a sample, and the torque that its load needs, N·m.
fn terms(bench: &Bench, record: &Record, back_emf: f64, k: usize) -> ([f64; TERMS], f64) {
    let [position, velocity] = record.smooth[k];
    let ahead = record.smooth[k + SIDE][1] - record.smooth[k - SIDE][1];
    let acceleration = ahead / (2.0 * SIDE as f64 * record.period);
    let (sin, cos) = position.sin_cos();
    let external = record.load.sine * sin + record.load.cosine * cos;
    let command = if record.on[k] {
        bench.law.command(record.target[k], position, velocity) - back_emf * velocity
    } else {
        0.0
    };
    let row = [
        command,
        -acceleration,
        -velocity,
        -velocity.signum(),
        -external.abs() * velocity.signum(),
    ];
    (row, record.load.inertia * acceleration - external)
}

/// Distributes the linear terms to the parameters.
fn values(bench: &Bench, records: &[Record], scale: f64, found: &[f64]) -> [f64; P] {
    use ServoParameter as Q;
    // Sizes of torque and inertia that the motion suggests, as bounds from below.
    let command = (records.iter())
        .flat_map(|record| {
            (record.target.iter().zip(&record.smooth)).map(|(target, [position, velocity])| {
                bench.law.command(*target, *position, *velocity)
            })
        })
        .fold(0.0_f64, |largest, command| largest.max(command.abs()));
    let torque = scale * command;
    let speed = (records.iter().map(Record::rms_velocity))
        .fold(0.0, f64::max)
        .max(1e-3);
    let inertia = (records.iter().map(|record| record.load.inertia)).fold(0.0, f64::max);
    let least_inertia = if inertia > 0.0 {
        1e-3 * inertia
    } else {
        1e-6 * torque / speed
    };
    let friction = found[3].max(0.01 * torque);
    let viscous = found[2].max(0.01 * torque / speed);
    let load = found[4].clamp(0.02, 0.5);
    let mut values = [0.0; P];
    let mut set = |parameter: Q, value: f64| {
        values[parameter as usize] = bench.known(parameter).unwrap_or(value);
    };
    set(Q::TorquePerCommand, scale);
    let of_back_emf = bench.known(Q::BackEmf).is_none() && bench.scale != Scale::None;
    let viscous = if of_back_emf { 0.5 * viscous } else { viscous };
    set(Q::BackEmf, viscous / scale);
    set(Q::Armature, found[1].max(least_inertia));
    set(Q::Viscous, viscous);
    set(Q::Coulomb, friction);
    set(Q::Stribeck, 0.5 * friction);
    set(Q::LoadMotor, 0.5 * load);
    set(Q::LoadExternal, 0.5 * load);
    set(Q::LoadMotorStribeck, 0.25 * load);
    set(Q::LoadExternalStribeck, 0.25 * load);
    set(Q::LogStribeckVelocity, (0.2 * speed).ln());
    set(Q::StribeckExponent, 1.35);
    values
}
