//! Whether changes of the robot or of its log explain a broken promise.

use super::proof::{JointProof, PROMISE_TOLERANCE, QuantityProof};
use crate::check::UNEXPLAINED;
use crate::description::Experiment;
use crate::estimate::{JointPrediction, predictions};
use crate::model::{Model, Theta};
use crate::prepare::Excerpt;
use crate::regression::Reading;
use crate::unknowns::{Asked, FoundChange, changes};

/// Changes explain a broken promise if they remove at least this share of the squared errors beyond the promise.
const EXPLAINED_SHARE: f64 = 0.8;

/// Largest error after the changes, over the promised one. They may also amplify noise: a larger inertia amplifies that of
/// accelerations.
const RESTORED: f64 = 2.0;

/// A cause lowers the product of the squared errors by at least this factor: small effects of the motion add up to less.
const LEAST_FACTOR: f64 = 2.0;

/// Parts of the errors of a joint that stay with changes, on the beginning of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Left {
    torque: f64,
    deflection: f64,
}

impl Left {
    /// - `before`, `after`: errors of the joint.
    fn new(before: &JointPrediction, after: &JointPrediction) -> Self {
        let deflection = before
            .deflection_error_rad
            .zip(after.deflection_error_rad)
            .map_or(1.0, |(before, after)| after / before);
        Self {
            torque: after.torque_error_nm / before.torque_error_nm,
            deflection,
        }
    }

    pub(super) fn of(&self, quantity: &QuantityProof<'_>) -> f64 {
        match quantity.name {
            "torque" => self.torque,
            _ => self.deflection,
        }
    }
}

/// The beginning of a log, in which changes are sought.
pub(super) struct Beginning<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) reading: &'a Reading,
    pub(super) excerpt: &'a Excerpt,
    /// Change of theta by the payload of the log, \[p\].
    pub(super) carried: Option<&'a Theta>,
    pub(super) file: &'a str,
}

impl Beginning<'_> {
    /// Returns the fewest changes that explain a broken promise, and what stays of the errors with them, by joint.
    pub(super) fn changes(
        &self,
        (model, theta): (&Model, &Theta),
        proofs: &[JointProof],
    ) -> Option<(Vec<FoundChange>, Vec<Left>)> {
        let mut theta = theta.clone();
        for (value, by) in theta.iter_mut().zip(self.carried.into_iter().flatten()) {
            *value += by;
        }
        let reading = self.reading.with_model(model.clone()).with_springs(&theta);
        let errors = |excerpt: &Excerpt, model: &Model, theta: &Theta| {
            let system = excerpt.reduce(&reading.with_model(model.clone()))?;
            Some(predictions(model, &system, theta))
        };
        let before = errors(self.excerpt, model, &theta)?;
        let explained = |excerpt: &Excerpt, (loosened, theta): (&Model, &Theta)| {
            let model = model.clone().with_plays_of(loosened);
            let after = errors(excerpt, &model, theta)?;
            let joints = before.iter().zip(&after);
            let left: Vec<Left> = joints
                .map(|(before, after)| Left::new(before, after))
                .collect();
            is_explained(&left, proofs).then_some(left)
        };
        let known: Vec<(usize, f64)> = theta.iter().copied().enumerate().collect();
        let known = reading.with_model(reading.model().with_fixed(&known));
        changes(
            self.experiment,
            &known,
            (self.excerpt, self.file),
            Asked {
                least_factor: LEAST_FACTOR,
                are_zeros_free: false,
            },
            explained,
        )
    }
}

/// Returns whether changes restore the promise.
///
/// - `left`: by joint.
fn is_explained(left: &[Left], proofs: &[JointProof]) -> bool {
    let quantities = || {
        let joints = proofs.iter().zip(left);
        joints.flat_map(|(proof, left)| {
            let quantities = proof.quantities();
            quantities.map(move |quantity| (over_promise(&quantity), left.of(&quantity)))
        })
    };
    let beyond = |ratio: f64| (ratio * ratio - 1.0).max(0.0);
    let before: f64 = quantities().map(|(ratio, _)| beyond(ratio)).sum();
    let after: f64 = quantities().map(|(ratio, left)| beyond(ratio * left)).sum();
    quantities().all(|(ratio, left)| ratio * left <= RESTORED)
        && after <= (1.0 - EXPLAINED_SHARE) * before
}

/// Returns an error over the promised one; without a promise over that at which a prediction is poor.
pub(super) fn over_promise(quantity: &QuantityProof<'_>) -> f64 {
    let poor = UNEXPLAINED / PROMISE_TOLERANCE * quantity.value;
    let promised = quantity.promised.unwrap_or(poor);
    quantity.error / promised.max(f64::MIN_POSITIVE)
}
