//! Checks of joint torque sensors by the motor rows.
//!
//! The motor row balances the motor torque with rotor, friction and spring torque, so it shows the gain of the sensor,
//! its offset and the torques of other joints in its reading. The columns of the sensors are added to the row, whose
//! right-hand side already contains the reading:
//!
//! ```text
//! tau = … + tau_m + a tau_m,i + Σ c_j tau_m,j        gain 1/(1 + a), cross-talk -c_j/(1 + a)
//! ```

use sprung_core::parameters::JointParameter;

use super::context::{CheckContext, SIGNIFICANT_SIGMAS};
use super::scale::{Explanation, POWERS_OF_TEN, explanations};
use super::trial::{Trial, is_likely};
use crate::finding::{Finding, Severity};
use crate::log::{Quantity, Signal, rounded};
use crate::numbers::Shown;
use crate::regression::{Probe, Reduction, SystemPart, solve};

/// Smallest errors that are findings: of a gain, of an offset relative to the root mean square of the
/// reading, and of a cross-talk relative to this root mean square.
const MIN_GAIN_ERROR: f64 = 0.05;
const MIN_OFFSET: f64 = 0.02;
const MIN_CROSS_TALK: f64 = 0.02;

/// Part of the squared residual that the sensors' columns must remove together. A missing friction law also changes a
/// gain, but hardly the residual.
const MIN_IMPROVEMENT: f64 = 0.15;

/// Factor between motor torque and sensor above which the sensor is not the cause, and largest
/// factor between it and an explanation. Friction and rotor make it inaccurate.
const FAR_SCALE: f64 = 5.0;
const SAME_SCALE: f64 = 2.5;

/// Factor below which the gain of a sensor is that of a unit.
const NEAR_UNIT: f64 = 1.1;

/// Smallest and largest ratio of a gearbox.
const GEARS: (f64, f64) = (10.0, 340.0);

/// The columns of sensors in the motor row of a joint.
struct SensorFit {
    joint: usize,
    /// 1 + a, and its standard error.
    inverse_gain: (f64, f64),
    /// Offset of the reading and its standard error, N·m (N).
    offset: Option<(f64, f64)>,
    /// Other joints, their `c_j`, its standard error, and the root mean square of their torques relative
    /// to that of the joint.
    others: Vec<(usize, f64, f64, f64)>,
    /// Root mean square of the reading, filtered, N·m (N).
    size: f64,
    /// Squared residual with the columns over that without.
    left: f64,
}

impl CheckContext<'_> {
    /// Adds findings about the torque sensors of moving joints, and returns the joints whose sensor is
    /// wrong.
    pub(super) fn torque_sensors(
        &self,
        moving: &[usize],
        findings: &mut Vec<Finding>,
    ) -> Vec<usize> {
        let channels = self.reading.channels();
        let joints: Vec<usize> = (moving.iter().copied())
            .filter(|&joint| channels.telling(Signal::Spring, joint).is_some())
            .collect();
        let mut wrong = Vec::new();
        let fits = self.sensor_fits(&joints).unwrap_or_default();
        if let Some(finding) = self.motor_torques_of_all(&fits) {
            findings.push(finding);
            return joints;
        }
        for fit in fits {
            let by_scale = self.sensor_scale(&fit);
            let of_gain = !by_scale.is_empty();
            let faults = if of_gain {
                by_scale
            } else {
                self.cross_talk(&fit)
            };
            if !faults.is_empty() {
                wrong.push(fit.joint);
            }
            findings.extend(faults);
            if !of_gain {
                findings.extend(self.sensor_offset(&fit));
            }
        }
        wrong
    }

    /// Fits the motor rows with the columns of all sensors; `None` if the excerpt is too short.
    fn sensor_fits(&self, joints: &[usize]) -> Option<Vec<SensorFit>> {
        if joints.is_empty() {
            return None;
        }
        let (model, reading) = (self.reading.model(), self.reading);
        let rows: Vec<usize> = joints
            .iter()
            .map(|&joint| model.torque_row(joint))
            .collect();
        // The own sensor first.
        let sensors = |joint: usize| {
            let others = joints.iter().copied().filter(move |other| *other != joint);
            std::iter::once(joint).chain(others)
        };
        let probes: Vec<Probe> = (joints.iter().zip(&rows))
            .flat_map(|(&joint, &row)| {
                sensors(joint).map(move |joint| Probe::SpringTorque { row, joint })
            })
            .collect();
        let signals = self.excerpt.smoothed(reading)?.thinned(reading);
        let empty = Reduction::with_probes(model, &rows, &probes).without_samples();
        let system = signals.reduce_by(empty, reading)?;
        let (whole, samples) = (system.whole()?, system.samples() as f64);
        (joints.iter().zip(&rows).zip(&whole))
            .map(|((&joint, &row), factor)| {
                let count = model.row_columns(row).len();
                let squares = |width: usize| {
                    let columns: Vec<usize> = (0..width).collect();
                    let known: Vec<Option<f64>> = (0..factor.unknowns())
                        .map(|column| (column >= width).then_some(0.0))
                        .collect();
                    let factor = factor.with_known(&known);
                    let part = SystemPart {
                        columns: &columns,
                        factor: &factor,
                    };
                    let solution = solve(&[part], width)?;
                    let residual = factor.residual(&solution.x);
                    let squares: f64 = residual.iter().map(|r| r * r).sum();
                    Some((solution, squares))
                };
                let (_, before) = squares(count)?;
                let (solution, after) = squares(count + joints.len())?;
                let error =
                    |at: usize| (after * solution.inverse[(at, at)] / self.independent).sqrt();
                let size = factor.column_norm(count);
                let offset = model
                    .index(JointParameter::TorqueOffset, joint)
                    .and_then(|index| {
                        let at = model.row_columns(row).iter().position(|&c| c == index)?;
                        Some((solution.x[at], error(at)))
                    });
                Some(SensorFit {
                    joint,
                    inverse_gain: (1.0 + solution.x[count], error(count)),
                    offset,
                    others: (sensors(joint).enumerate().skip(1))
                        .map(|(place, other)| {
                            let at = count + place;
                            let share = factor.column_norm(at) / size;
                            (other, solution.x[at], error(at), share)
                        })
                        .collect(),
                    size: size / samples.sqrt(),
                    left: after / before,
                })
            })
            .collect()
    }

    /// Findings: the gain of the sensor has the wrong sign or size.
    fn sensor_scale(&self, fit: &SensorFit) -> Vec<Finding> {
        let (inverse, error) = fit.inverse_gain;
        let column = self.column(&[Quantity::JointTorque], fit.joint);
        let motor = self.column(&[Quantity::MotorTorque], fit.joint);
        let name = self.name(fit.joint);
        let sure = (inverse - 1.0).abs() > SIGNIFICANT_SIGMAS * error
            && (inverse - 1.0).abs() > MIN_GAIN_ERROR
            && fit.left < 1.0 - MIN_IMPROVEMENT;
        if !sure || !inverse.is_finite() {
            return Vec::new();
        }
        let gain = inverse.recip();
        if inverse < -SIGNIFICANT_SIGMAS * error {
            return vec![
                Finding::new(
                    Severity::Error,
                    "joint-torque-sign",
                    format!(
                        "{name}: \"{column}\" has the wrong sign: the motor row explains \"{motor}\" with \
                         {inverse:.3} times this torque (standard error {error:.3}) instead of 1 times"
                    ),
                    "reverse the sign of the torque sensor: a positive torque turns the link in the \
                     direction of positive positions",
                )
                .seen(self.file, column, gain, "")
                .mended_by("[log]", &format!("sign = {{ \"{column}\" = -1 }}")),
            ];
        }
        if !self.is_sensor_wrong(fit)
            && let Some(finding) = self.motor_torque_of(fit)
        {
            return vec![finding];
        }
        let finding = Finding::new(
            Severity::Warning,
            "joint-torque-scale",
            format!(
                "{name}: by the motor row \"{column}\" reads {gain:.3} times the torque of the spring \
                 (standard error {:.3}), if the scale of \"{motor}\" is right",
                error * gain * gain
            ),
            "measure the gain of the torque sensor with a weight of known mass and give it, or correct the scale of the \
             motor torque, or leave the sensor out of the file",
        )
        .about(self.about_stiffness(fit.joint))
        .seen(self.file, column, gain, "");
        // The springs are known better than this estimate, so only a factor of units can be given.
        let is_near = |unit: &f64| (inverse / unit).ln().abs() < NEAR_UNIT.ln();
        vec![match POWERS_OF_TEN.into_iter().find(is_near) {
            Some(unit) => {
                finding.mended_by("[log]", &format!("gain = {{ \"{column}\" = {unit} }}"))
            }
            None => finding,
        }]
    }

    /// Returns whether the equations of all links ask for the torque of the sensor with the scale of the motor torque.
    fn is_sensor_wrong(&self, fit: &SensorFit) -> bool {
        let reading = self.reading;
        let joints: Vec<usize> = (0..reading.model().joint_count()).collect();
        let given = Trial {
            excerpt: self.excerpt.clone(),
            channels: reading.channels().clone(),
        };
        let scaled = given.with_sensor(fit.joint, fit.inverse_gain.0);
        match (given.left(reading, &joints), scaled.left(reading, &joints)) {
            (Some(before), Some(after)) => joints.len() > 1 && is_likely(&before, &after),
            (None, after) => after.is_some(),
            (Some(_), None) => false,
        }
    }

    /// Finding: all motor torques are wrong by the factors of one mistake, rather than all sensors.
    fn motor_torques_of_all(&self, fits: &[SensorFit]) -> Option<Finding> {
        let joints: Vec<usize> = fits.iter().map(|fit| fit.joint).collect();
        let first = fits.first()?;
        let is_far = |fit: &SensorFit| fit.inverse_gain.0.ln().abs() > FAR_SCALE.ln();
        if joints.len() != self.reading.model().joint_count() || !fits.iter().all(is_far) {
            return None;
        }
        let explanation = (explanations(self, &joints).into_iter()).find(|explanation| {
            (fits.iter().zip(&explanation.factors))
                .all(|(fit, factor)| (fit.inverse_gain.0 / factor).ln().abs() < SAME_SCALE.ln())
        })?;
        let factors: Vec<String> = (fits.iter())
            .map(|fit| format!("{} {}", self.name(fit.joint), rounded(fit.inverse_gain.0)))
            .collect();
        let column = self.column(&[Quantity::MotorTorque], first.joint);
        Some(
            Finding::new(
                Severity::Error,
                "torque-scale",
                format!(
                    "the motor torques do not match the joint torque sensors (motor torque over what the \
                     sensors ask for: {}). {}",
                    factors.join(", "),
                    explanation.cause
                ),
                &format!("set {} in {}", explanation.line, explanation.table),
            )
            .seen(self.file, column, first.inverse_gain.0, "")
            .mended_by(explanation.table, &explanation.line),
        )
    }

    /// Finding: the motor torque of a joint has another scale, by a factor that is impossible for a
    /// sensor.
    fn motor_torque_of(&self, fit: &SensorFit) -> Option<Finding> {
        let (inverse, _) = fit.inverse_gain;
        if inverse.ln().abs() < FAR_SCALE.ln() {
            return None;
        }
        let motor = self.column(&[Quantity::MotorTorque], fit.joint);
        let sensor = self.column(&[Quantity::JointTorque], fit.joint);
        let off = |explanation: &Explanation| (inverse / explanation.factors[0]).ln().abs();
        let explanation = (explanations(self, &[fit.joint]).into_iter())
            .filter(|explanation| off(explanation) < SAME_SCALE.ln())
            .min_by(|a, b| off(a).total_cmp(&off(b)));
        let is_gear = inverse < GEARS.0.recip() && inverse > GEARS.1.recip();
        let joint = self.experiment.robot.joint.get(fit.joint);
        let is_open = is_gear && joint.is_none_or(|joint| joint.gear_ratio.is_none());
        let gear = is_open.then(|| {
            format!(
                "The torques are probably those of the motors before a gearbox of about {}: set gear_ratio of \
                 the joint and motor_torque_side = \"motor\" in [log]",
                rounded(inverse.recip())
            )
        });
        let cause = match (&explanation, gear) {
            (Some(explanation), None) => explanation.cause.clone(),
            (None, Some(gear)) => gear,
            (Some(explanation), Some(gear)) => {
                format!("{gear}; or: {} ({})", explanation.cause, explanation.line)
            }
            (None, None) => return None,
        };
        let finding = Finding::new(
            Severity::Error,
            "torque-scale",
            format!(
                "{}: \"{motor}\" is {} times what \"{sensor}\" asks for, a factor that no torque sensor has. \
                 {cause}",
                self.name(fit.joint),
                rounded(inverse)
            ),
            "give the unit and the side of the motor torque; if it is right, give the torque sensor its gain",
        )
        .seen(self.file, motor, inverse, "");
        // Without the gear ratio two causes are possible, so no line is suggested.
        Some(match explanation.filter(|_| !is_open) {
            Some(explanation) => finding.mended_by(explanation.table, &explanation.line),
            None => finding,
        })
    }

    /// Findings: the reading contains torques of other joints.
    fn cross_talk(&self, fit: &SensorFit) -> Vec<Finding> {
        if fit.left > 1.0 - MIN_IMPROVEMENT {
            return Vec::new();
        }
        let column = self.column(&[Quantity::JointTorque], fit.joint);
        let worst = (fit.others.iter())
            .filter(|(_, value, error, share)| {
                value.abs() > SIGNIFICANT_SIGMAS * error && value.abs() * share > MIN_CROSS_TALK
            })
            .max_by(|a, b| (a.1 * a.3).abs().total_cmp(&(b.1 * b.3).abs()));
        let finding = worst.map(|&(other, value, error, _)| {
            let talk = -value / fit.inverse_gain.0;
            let of_other = self.column(&[Quantity::JointTorque], other);
            Finding::new(
                Severity::Warning,
                "joint-torque-crosstalk",
                format!(
                    "{}: by the motor row \"{column}\" contains {:.2} % of \"{of_other}\", the torque of {} \
                     (standard error {:.2} %)",
                    self.name(fit.joint),
                    100.0 * talk,
                    self.name(other),
                    100.0 * (error / fit.inverse_gain.0).abs()
                ),
                "calibrate the torque sensors together and correct the readings by the inverse of the \
                 matrix of their gains",
            )
            .about(self.about_stiffness(fit.joint))
            .seen(self.file, column, talk, "")
        });
        finding.into_iter().collect()
    }

    /// Finding: the sensor reads a torque without torque of the spring.
    fn sensor_offset(&self, fit: &SensorFit) -> Option<Finding> {
        let (offset, error) = fit.offset?;
        let is_clear = offset.abs() > SIGNIFICANT_SIGMAS * error;
        if !is_clear || offset.abs() < MIN_OFFSET * fit.size {
            return None;
        }
        let column = self.column(&[Quantity::JointTorque], fit.joint);
        let name = self.name(fit.joint);
        Some(
            Finding::new(
                Severity::Info,
                "joint-torque-offset",
                format!(
                    "{name}: by the motor row \"{column}\" reads {} N·m (N) without torque of the spring \
                     (standard error {} N·m)",
                    Shown((1e4 * offset).round() / 1e4),
                    Shown((1e4 * error).round() / 1e4)
                ),
                "nothing: sprung estimates the offset as a parameter of the joint; set the zero of the \
                 sensor if you use its readings elsewhere",
            )
            .seen(self.file, column, offset, "N·m"),
        )
    }
}
