//! Squares of the residuals in a window, beside those of the healthy robot.

use super::learn::{Monitor, Robot};
use super::residual::Now;
use sprung_core::parameters::JointParameter;

/// Mean squared residual over that of the healthy robot from which a window is searched.
const UNUSUAL: f64 = 1.4;

/// Mean squared residual over that of the healthy robot that a healthy window may have by chance.
const BY_CHANCE: f64 = 1.2;

/// Part of the excess of the mean squared residuals that changes must explain.
const EXPLAINED: f64 = 0.7;

/// Change of a stiffness from which a window is searched, over the stiffness.
const OTHER_STIFFNESS: f64 = 0.025;

/// The same in standard errors of the stiffness at the identification.
const OTHER_ERRORS: f64 = 3.0;

/// The same in standard errors of the change in the window.
const SIGNIFICANT: f64 = 4.0;

/// Instants of a window that are as good as one independent instant.
const CORRELATED: f64 = 3.0;

impl Robot<'_> {
    /// Returns the torque of a spring without its preload, N·m (N).
    fn spring(&self, joint: usize, now: &Now) -> Option<f64> {
        let stiffness = self.model.index(JointParameter::Stiffness, joint)?;
        Some(self.theta[stiffness] * (now.phi[joint] - now.q[joint]))
    }

    /// Returns the change of a stiffness over the stiffness that its error at the identification leaves open.
    fn least_change(&self, joint: usize) -> f64 {
        let stiffness = self.model.index(JointParameter::Stiffness, joint);
        let of_errors = stiffness.zip(self.covariance).map(|(at, covariance)| {
            let parameter = &self.model.parameters()[at].name;
            let variance = covariance.of_sum(|name| (name == parameter).then_some(1.0));
            OTHER_ERRORS * variance.sqrt() / self.theta[at].abs()
        });
        OTHER_STIFFNESS.max(of_errors.unwrap_or_default())
    }
}

/// Mean squares of the residuals of both equations of each joint about their means, over those of the healthy robot. A constant
/// residual is another zero of an incremental encoder.
#[derive(Clone)]
pub(super) struct Squares {
    /// Sums of the inverse variances, and of the residuals and their squares times these.
    sums: Vec<[[f64; 3]; 2]>,
    /// The same of the torque of each spring, of its square and of its product with the residual of the link.
    springs: Vec<[f64; 3]>,
    count: f64,
}

impl Squares {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            sums: vec![[[0.0; 3]; 2]; joints],
            springs: vec![[0.0; 3]; joints],
            count: 0.0,
        }
    }

    pub(super) fn see(&mut self, (robot, monitor): (&Robot<'_>, &Monitor), now: &Now) {
        for (joint, of) in monitor.joints.iter().enumerate() {
            let rows = of.rows(robot.model, joint, now);
            for (sums, row) in self.sums[joint].iter_mut().zip(rows) {
                let Some((residual, variance)) = row else {
                    continue;
                };
                let weight = variance.recip();
                sums[0] += weight;
                sums[1] += weight * residual;
                sums[2] += weight * residual * residual;
            }
            if let ([Some((residual, variance)), _], Some(torque)) =
                (rows, robot.spring(joint, now))
            {
                let sums = &mut self.springs[joint];
                sums[0] += torque / variance;
                sums[1] += torque * torque / variance;
                sums[2] += torque * residual / variance;
            }
        }
        self.count += 1.0;
    }

    /// Begins again, and returns what was seen.
    pub(super) fn replaced(&mut self) -> Self {
        let joints = self.sums.len();
        std::mem::replace(self, Self::new(joints))
    }

    /// Returns the mean squares of the equations of a joint.
    fn of(&self, joint: usize) -> [f64; 2] {
        let count = self.count.max(1.0);
        self.sums[joint].map(|[weights, sum, squares]| {
            let about_mean = squares - sum * sum / weights.max(f64::MIN_POSITIVE);
            about_mean.max(0.0) / count
        })
    }

    /// Returns the largest mean square of a joint, or of all.
    pub(super) fn largest(&self, joint: Option<usize>) -> f64 {
        let all = (0..self.sums.len()).filter(|of| joint.is_none_or(|joint| joint == *of));
        all.flat_map(|of| self.of(of)).fold(0.0, f64::max)
    }

    /// Returns the largest mean square over that of a window without explanation.
    fn over(&self, other: Option<&Self>) -> f64 {
        let joints = (0..self.sums.len()).flat_map(|joint| {
            let known = other.map_or([1.0; 2], |other| other.of(joint).map(|x| x.max(1.0)));
            let own = self.of(joint);
            [own[0] / known[0], own[1] / known[1]]
        });
        joints.fold(0.0, f64::max)
    }

    /// Returns the change of the stiffness of a joint that explains most of the residual of its link, over the stiffness; zero if it
    /// explains less than chance may.
    fn stiffness(&self, joint: usize) -> f64 {
        let [weights, residuals, squares] = self.sums[joint][0];
        let [torques, of_torques, products] = self.springs[joint];
        if weights <= 0.0 {
            return 0.0;
        }
        let spread = of_torques - torques * torques / weights;
        let product = products - torques * residuals / weights;
        let about_mean = squares - residuals * residuals / weights;
        let change = product / spread;
        let left = about_mean - change * product;
        let independent = self.count / CORRELATED;
        if change * product * independent > SIGNIFICANT * SIGNIFICANT * left {
            change.abs()
        } else {
            0.0
        }
    }

    /// Returns whether a window has larger residuals than the healthy robot, or another stiffness.
    ///
    /// - `other`: a window that no change explained; this one must then differ more.
    pub(super) fn is_unusual(&self, robot: &Robot<'_>, other: Option<&Self>) -> bool {
        let mut joints = 0..self.sums.len();
        let is_other = |joint: usize| {
            let known = other.map_or(0.0, |other| UNUSUAL * other.stiffness(joint));
            self.stiffness(joint) > robot.least_change(joint).max(known)
        };
        self.over(other) >= UNUSUAL || joints.any(is_other)
    }

    /// Returns whether changes that leave other squares explain these.
    pub(super) fn is_explained_by(&self, robot: &Robot<'_>, after: &Self) -> bool {
        let mut joints = 0..self.sums.len();
        after.excess() <= (1.0 - EXPLAINED) * self.excess()
            && !joints.any(|joint| after.stiffness(joint) > robot.least_change(joint))
    }

    /// Returns the sum of the mean squares beyond those by chance.
    fn excess(&self) -> f64 {
        let all = (0..self.sums.len()).flat_map(|joint| self.of(joint));
        all.map(|square| (square - BY_CHANCE).max(0.0)).sum()
    }
}
