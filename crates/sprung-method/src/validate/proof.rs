//! Proof of a promise: prediction errors on a log compared with the promised ones.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::estimate::{JointPrediction, percent};

/// A promise is kept if no error exceeds this multiple of the promised error. Errors on parts of one
/// log differ by less, because they share its motion.
pub(crate) const PROMISE_TOLERANCE: f64 = 1.5;

/// Smallest promised error, relative to the torque or deflection: the accuracy of the filtered
/// regression.
const SMALLEST_PROMISE: f64 = 0.005;

/// Prediction errors of a joint on a log, filtered by the filter pair, and the promised errors; root
/// mean squares.
///
/// If the log has larger torques (deflections) than the logs of the identification, the promised
/// error grows in proportion. Promised errors are absent without an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "JointErrors")]
pub struct JointProof {
    /// Name of the joint.
    pub joint: String,
    /// Motor torque, N·m (N).
    pub torque_nm: f64,
    /// Error of the motor torque, N·m (N).
    pub torque_error_nm: f64,
    /// Promised error of the motor torque, N·m (N).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_promised_nm: Option<f64>,
    /// Error of the motor torque over its promised error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_ratio: Option<f64>,
    /// Deflection of the spring, rad (m); absent without a spring of positive stiffness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_rad: Option<f64>,
    /// Error of the deflection, rad (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_error_rad: Option<f64>,
    /// Promised error of the deflection, rad (m).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_promised_rad: Option<f64>,
    /// Error of the deflection over its promised error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deflection_ratio: Option<f64>,
}

impl JointProof {
    /// Compares the errors on a log with the promised errors.
    pub(super) fn new(measured: &JointPrediction, promised: Option<&JointPrediction>) -> Self {
        let torque = promised.map(|promised| {
            scaled(
                measured.torque_nm,
                promised.torque_nm,
                promised.torque_error_nm,
            )
        });
        let deflection = promised.and_then(|promised| {
            Some(scaled(
                measured.deflection_rad?,
                promised.deflection_rad?,
                promised.deflection_error_rad?,
            ))
        });
        Self {
            joint: measured.joint.clone(),
            torque_nm: measured.torque_nm,
            torque_error_nm: measured.torque_error_nm,
            torque_promised_nm: torque,
            torque_ratio: ratio(Some(measured.torque_error_nm), torque),
            deflection_rad: measured.deflection_rad,
            deflection_error_rad: measured.deflection_error_rad,
            deflection_promised_rad: deflection,
            deflection_ratio: ratio(measured.deflection_error_rad, deflection),
        }
    }

    /// Returns the torque and, for a joint with a spring, the deflection.
    pub fn quantities(&self) -> impl Iterator<Item = QuantityProof<'_>> {
        let torque = QuantityProof {
            joint: &self.joint,
            name: "torque",
            value: self.torque_nm,
            error: self.torque_error_nm,
            promised: self.torque_promised_nm,
            ratio: self.torque_ratio,
        };
        let deflection =
            (self.deflection_rad.zip(self.deflection_error_rad)).map(|(value, error)| {
                QuantityProof {
                    joint: &self.joint,
                    name: "deflection",
                    value,
                    error,
                    promised: self.deflection_promised_rad,
                    ratio: self.deflection_ratio,
                }
            });
        std::iter::once(torque).chain(deflection)
    }
}

/// Error of one quantity of a joint beside the promised error, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityProof<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// `torque` or `deflection`.
    pub name: &'static str,
    /// The quantity, root mean square.
    pub value: f64,
    /// Its error.
    pub error: f64,
    /// Its promised error.
    pub promised: Option<f64>,
    /// Error over promised error.
    pub ratio: Option<f64>,
}

impl QuantityProof<'_> {
    /// Returns whether the error exceeds the promise.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.ratio.is_some_and(|ratio| ratio > PROMISE_TOLERANCE)
    }

    /// Returns the quantity with its joint, as in `the torque error of joint2`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("the {} error of {}", self.name, self.joint)
    }

    /// Returns the measured and the promised error in percent of the quantity, in words.
    #[must_use]
    pub fn errors(&self) -> String {
        let share = |error: f64| percent(error / self.value);
        match self.promised {
            Some(promised) => format!("{} instead of {}", share(self.error), share(promised)),
            None => share(self.error),
        }
    }
}

/// Returns whether a promise is kept; `None` if nothing was promised.
pub(super) fn is_kept(proofs: &[JointProof]) -> Option<bool> {
    let promised = || {
        let all = proofs.iter().flat_map(JointProof::quantities);
        all.filter(|quantity| quantity.ratio.is_some())
    };
    promised().next()?;
    Some(!promised().any(|quantity| quantity.is_broken()))
}

/// Returns the quantity with the largest ratio of error to promised error; `None` if nothing was
/// promised.
#[must_use]
pub(crate) fn worst(proofs: &[JointProof]) -> Option<QuantityProof<'_>> {
    (proofs.iter().flat_map(JointProof::quantities))
        .filter(|quantity| quantity.ratio.is_some())
        .max_by(|a, b| (a.ratio.unwrap_or(0.0)).total_cmp(&b.ratio.unwrap_or(0.0)))
}

/// Returns the promised error on a log with another size of the quantity.
///
/// - `value`: the quantity on this log; `before`: on the logs of the promise; `error`: promised there.
fn scaled(value: f64, before: f64, error: f64) -> f64 {
    let growth = if before > 0.0 { value / before } else { 1.0 };
    (error * growth.max(1.0)).max(SMALLEST_PROMISE * value)
}

fn ratio(error: Option<f64>, promised: Option<f64>) -> Option<f64> {
    let ratio = error? / promised.filter(|promised| *promised > 0.0)?;
    Some(ratio).filter(|ratio| ratio.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(torque: f64, torque_error: f64, deflection_error: Option<f64>) -> JointPrediction {
        JointPrediction {
            joint: "joint1".to_owned(),
            torque_nm: torque,
            torque_error_nm: torque_error,
            deflection_rad: deflection_error.map(|_| 0.1),
            deflection_error_rad: deflection_error,
        }
    }

    #[test]
    fn a_promise_grows_with_the_motion_but_does_not_shrink() {
        let promised = errors(1.0, 0.1, Some(0.01));
        let ratio = |measured: &JointPrediction| {
            let proof = JointProof::new(measured, Some(&promised));
            (proof.torque_ratio.unwrap(), proof.deflection_ratio)
        };
        let (torque, deflection) = ratio(&errors(3.0, 0.3, Some(0.02)));
        assert!((torque - 1.0).abs() < 1e-12 && (deflection.unwrap() - 2.0).abs() < 1e-12);
        let (torque, deflection) = ratio(&errors(0.1, 0.2, None));
        assert!((torque - 2.0).abs() < 1e-12 && deflection.is_none());
        // The filtered regression is not more accurate than this.
        let exact = JointProof::new(&errors(1.0, 0.004, None), Some(&errors(1.0, 1e-9, None)));
        assert!((exact.torque_ratio.unwrap() - 0.8).abs() < 1e-12);
    }

    #[test]
    fn one_broken_quantity_breaks_the_promise() {
        let promised = errors(1.0, 0.1, Some(0.01));
        let kept = JointProof::new(&errors(1.0, 0.14, Some(0.01)), Some(&promised));
        assert_eq!(is_kept(std::slice::from_ref(&kept)), Some(true));
        let broken = JointProof::new(&errors(1.0, 0.1, Some(0.03)), Some(&promised));
        let both = [kept, broken];
        assert_eq!(is_kept(&both), Some(false));
        let worst = worst(&both).unwrap();
        assert_eq!(worst.name(), "the deflection error of joint1");
        assert_eq!(worst.errors(), "30 % instead of 10 %");
        let none = JointProof::new(&errors(1.0, 0.1, Some(0.03)), None);
        assert_eq!(is_kept(&[none]), None);
    }
}
