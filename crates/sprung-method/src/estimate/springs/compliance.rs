//! The compliance of a spring, and the corresponding stiffness.

use crate::estimate::result::{RigidByHoldOut, RigidJoint};
use crate::estimate::statistics::{CERTAIN_SIGMAS, NORMAL_95};
use crate::fit::ColumnFit;

/// Squared correlation below which its noise is that of the deflection, which does not bias a compliance.
const LEAST_CORRELATION: f64 = 0.5;

/// Relative error of a compliance by positions that are smoothed, and torques that are not.
const SMOOTHED: f64 = 1e-4;

/// The compliance of a joint by a log, rad/(N·m) (m/N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compliance {
    pub(super) value: f64,
    pub(super) standard_error: f64,
    /// Half width of an interval over that of a normal error.
    widening: f64,
}

impl From<ColumnFit> for Compliance {
    fn from(fit: ColumnFit) -> Self {
        Self {
            value: fit.value,
            standard_error: fit.standard_error,
            widening: fit.few_segments,
        }
    }
}

impl Compliance {
    /// Returns the compliance of a joint whose stiffness is linearised about `about`, as the link rows are without link
    /// encoder; `None` without a standard error.
    ///
    /// - `stiffness`: estimate and standard error, N·m/rad (N/m).
    pub(super) fn linearised(about: f64, stiffness: (f64, f64)) -> Option<Self> {
        let (value, standard_error) = stiffness;
        Self::with_error(
            (2.0 - value / about) / about,
            standard_error / about.powi(2),
        )
    }

    /// Returns the compliance of an estimated stiffness; `None` without a standard error.
    ///
    /// - `stiffness`: estimate and standard error, N·m/rad (N/m).
    pub(super) fn of_stiffness((value, standard_error): (f64, f64)) -> Option<Self> {
        Self::with_error(value.recip(), standard_error / value.powi(2))
    }

    fn with_error(value: f64, standard_error: f64) -> Option<Self> {
        let is_known = value.is_finite() && standard_error.is_finite() && standard_error > 0.0;
        is_known.then_some(Self {
            value,
            standard_error,
            widening: 1.0,
        })
    }

    /// Returns the compliance by a torque whose noise makes the estimate smaller.
    ///
    /// - `reliability`: share of the variance of the torque that is no noise.
    pub(super) fn by_noisy_torque(self, reliability: f64) -> Self {
        Self {
            value: self.value / reliability,
            standard_error: self.standard_error / reliability,
            ..self
        }
    }

    /// Returns the compliance of which it is not known whether noise of the torque makes the estimate smaller or noise of the
    /// deflection the squared correlation: the middle of both limits, with the error of an even distribution between them.
    ///
    /// - `correlation`: squared correlation of deflection and torque.
    pub(super) fn between(self, correlation: f64) -> Self {
        let largest = self.value / correlation.clamp(LEAST_CORRELATION, 1.0);
        let width = (largest - self.value).abs();
        Self {
            value: f64::midpoint(self.value, largest),
            standard_error: (self.standard_error)
                .hypot(width / 12.0_f64.sqrt())
                .hypot(SMOOTHED * largest),
            ..self
        }
    }

    /// Returns whether the log leaves the spring open. A compliance far below zero means a wrong sign or a delay.
    pub(super) fn is_open(&self) -> bool {
        let sigmas = self.value / self.standard_error;
        (-CERTAIN_SIGMAS..NORMAL_95 * self.widening).contains(&sigmas)
    }

    /// Returns the stiffness and its standard error, N·m/rad (N/m).
    pub(super) fn stiffness(&self) -> (f64, f64) {
        (self.value.recip(), self.standard_error / self.value.powi(2))
    }

    /// Returns the 95 % interval of the stiffness of a spring that is not open, N·m/rad (N/m).
    pub(super) fn interval(&self) -> [f64; 2] {
        let half = NORMAL_95 * self.widening * self.standard_error;
        [self.value + half, self.value - half].map(f64::recip)
    }

    /// Returns the joint for the results.
    ///
    /// - `hold_out`: the comparison by which the joint became rigid, if it did.
    pub(super) fn described(&self, joint: &str, hold_out: Option<RigidByHoldOut>) -> RigidJoint {
        RigidJoint {
            joint: joint.to_owned(),
            stiffness_above_nm_per_rad: self.stiffness_above(),
            compliance_rad_per_nm: self.value,
            compliance_standard_error_rad_per_nm: self.standard_error,
            hold_out,
        }
    }

    /// Returns the lower bound of the stiffness at 95 %, N·m/rad (N/m).
    ///
    /// Only springs that look stiff have a bound. With 1.645 standard errors a tenth of the bounds of springs near the
    /// limit is above the truth, with 1.96 less than a twentieth.
    ///
    /// A compliance cannot be negative. Below zero the bound is that of a parabola of the likelihood that ends at zero.
    pub(super) fn stiffness_above(&self) -> f64 {
        let width = NORMAL_95 * self.widening * self.standard_error;
        let largest = if self.value >= 0.0 {
            self.value + width
        } else {
            self.value + self.value.hypot(width)
        };
        largest.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(value: f64, standard_error: f64) -> Compliance {
        Compliance::with_error(value, standard_error).unwrap()
    }

    #[test]
    fn the_bound_is_finite_and_steady_through_zero() {
        assert!((of(1e-6, 1e-6).stiffness_above() - 1e6 / 2.96).abs() < 10.0);
        let (above, below) = (of(1e-15, 1e-6), of(-1e-15, 1e-6));
        assert!((above.stiffness_above() / below.stiffness_above() - 1.0).abs() < 1e-6);
        // 1/(sqrt(1 + 1.96²) - 1)
        assert!((of(-1e-6, 1e-6).stiffness_above() * 1e-6 - 0.8331).abs() < 1e-3);
    }

    #[test]
    fn a_spring_is_open_within_its_interval_and_a_wrong_sign_is_not() {
        for (sigmas, open) in [(2.1, false), (1.9, true), (-3.0, true), (-6.0, false)] {
            assert_eq!(of(1e-6 * sigmas, 1e-6).is_open(), open, "{sigmas}");
        }
        assert!(Compliance::with_error(1e-6, f64::NAN).is_none());
    }

    #[test]
    fn a_linearised_stiffness_is_exact_in_the_compliance() {
        // q = φ − c τ: a change of K from 1e5 to infinity moves the linearised K to 2e5.
        let stiff = Compliance::linearised(1e5, (2e5, 1e4)).unwrap();
        assert!(stiff.value.abs() < 1e-15 && (stiff.standard_error - 1e-6).abs() < 1e-12);
        let same = Compliance::of_stiffness((1e5, 1e4)).unwrap();
        assert!((same.value - 1e-5).abs() < 1e-15 && (same.standard_error - 1e-6).abs() < 1e-12);
    }
}
