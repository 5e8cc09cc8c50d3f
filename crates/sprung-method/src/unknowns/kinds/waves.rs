//! Waves over the angle of a motor.

use super::catalogued::Catalogued;
use crate::log::Signal;
use crate::unknowns::unknown::{MotorSample, PHASES, Unknown};

/// A sine or cosine of the position of a motor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    /// Periods per turn of the joint.
    order: f64,
    is_cosine: bool,
}

impl Wave {
    /// Returns the mean over the period of a sample.
    pub(super) fn mean(self, sample: &MotorSample<'_>) -> f64 {
        let half = 0.5 * self.order * sample.velocity * sample.period;
        let sinc = if half.abs() > 1e-6 {
            half.sin() / half
        } else {
            1.0
        };
        let (sine, cosine) = (self.order * sample.position + half).sin_cos();
        sinc * if self.is_cosine { cosine } else { sine }
    }
}

/// Returns the unknowns of some periods per turn of the motors whose gears are known.
///
/// - `name`: first words of their ids; `of_wave`: the unknown with an id of a joint.
pub(super) fn of_motors(
    of: &Catalogued<'_>,
    (name, periods): (&str, &[u8]),
    of_wave: impl Fn(usize, String, Wave) -> Option<Unknown>,
) -> Vec<Unknown> {
    if of.experiment.robot.transmission_matrix.is_some() {
        return Vec::new();
    }
    let mut all = Vec::new();
    for (joint, described) in of.experiment.robot.joint.iter().enumerate() {
        let has_torque = of.channels.telling(Signal::Torque, joint).is_some();
        let is_told = has_torque && of.channels.turns[joint] && of.speeds[joint] > 0.0;
        let Some(ratio) = described.gear_ratio.filter(|_| is_told) else {
            continue;
        };
        for &per_turn in periods {
            let order = f64::from(per_turn) * ratio.abs();
            for (phase, is_cosine) in PHASES {
                let id = format!("{name} {} {per_turn} {phase}", of.names[joint]);
                all.extend(of_wave(joint, id, Wave { order, is_cosine }));
            }
        }
    }
    all
}

/// Returns the periods of a found wave in words: its id ends in their number.
pub(super) fn times(id: &str) -> String {
    match id.rsplit(' ').next() {
        Some("1") | None => "once per turn of the motor".to_owned(),
        Some(many) => format!("{many} times per turn of the motor"),
    }
}
