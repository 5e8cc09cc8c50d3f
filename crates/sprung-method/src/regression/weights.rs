//! Weights of samples, from the noise that passes through the Coulomb transition.

use sprung_core::drives::State;
use sprung_core::friction::{Conditions, Law, Shape};
use sprung_core::parameters::{JointParameter, Side};

use crate::model::Model;
use crate::preprocess::SignalBlock;

/// Time for which a side must stand still before its samples count as samples at rest, s. A reversal
/// passes the Coulomb transition in less time.
const REST_S: f64 = 0.25;

/// Largest argument of `tanh(beta v)` at rest, and the same in standard deviations of the velocity
/// noise.
const REST_ARGUMENT: f64 = 0.3;
const REST_SIGMAS: f64 = 3.0;

/// Variance of a torque of any value between both bounds, relative to the squared bound.
const VARIANCE_WITHIN_BOUNDS: f64 = 1.0 / 3.0;

/// Above this argument `sech²` is below 2e-17, so it counts as zero.
const SATURATED_ARGUMENT: f64 = 20.0;

const AT_REST: Conditions = Conditions {
    velocity: 0.0,
    deflection: 0.0,
    presliding: Some([0.0; _]),
};

/// Standard deviations of the velocity noise, rad/s (m/s), each \[n\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VelocityNoise {
    /// Of the links.
    pub link: Vec<f64>,
    /// Of the motors, before a coupling is undone.
    pub motor: Vec<f64>,
}

/// Friction in one row that changes sign with one velocity.
#[derive(Clone, Debug)]
struct Transition {
    row: usize,
    side: Side,
    joint: usize,
    // Standard deviation of the velocity noise times β, dimensionless.
    noise: f64,
    shape: Shape,
    // Friction laws and their magnitudes |gain · parameter|, N·m (N).
    laws: Vec<(Law, f64)>,
}

impl Transition {
    /// Returns the variance that the velocity noise causes in the friction, (N·m)² (N²).
    fn variance(&self, at: &Conditions) -> f64 {
        if self.is_past(at.velocity) {
            return 0.0;
        }
        let x = self.shape.sharpness * at.velocity;
        // sech², by one exponential.
        let decay = libm::exp(-2.0 * x.abs());
        let slope = 4.0 * decay / (1.0 + decay).powi(2);
        let heights = (self.laws.iter())
            .map(|(law, size)| size * law.jump(at, &self.shape).unwrap_or_default());
        (self.noise * slope * heights.sum::<f64>()).powi(2)
    }

    /// Returns whether a velocity is too large for the transition.
    fn is_past(&self, velocity: f64) -> bool {
        (self.shape.sharpness * velocity).abs() > SATURATED_ARGUMENT
    }

    /// Returns whether a velocity is below the resolution of the sensor or of the law.
    fn stands(&self, velocity: f64) -> bool {
        let argument = (self.shape.sharpness * velocity).abs();
        argument <= REST_ARGUMENT.max(REST_SIGMAS * self.noise)
    }

    /// Returns the largest friction at rest, N·m (N).
    fn bound(&self) -> f64 {
        let towards = |velocity: f64| -> f64 {
            let at = Conditions {
                velocity,
                ..AT_REST
            };
            (self.laws.iter())
                .map(|(law, size)| size * law.jump(&at, &self.shape).unwrap_or_default())
                .sum()
        };
        towards(f64::MIN_POSITIVE).max(towards(-f64::MIN_POSITIVE))
    }
}

/// Samples for which each transition has stood still, the present one included.
#[derive(Clone, Debug, Default)]
pub(super) struct Standing(Vec<u64>);

/// Weights that are small for samples in the Coulomb transition, for each row.
///
/// Noise n of a velocity changes the Coulomb friction by `f_c β sech²(β v) n`. This is large during
/// a reversal and zero in sliding. With the scale `s0` of the row's residual the weight is
///
/// `s0 / √(s0² + f[(f_c β σ_v sech²(β v))²])`,
///
/// where `f[.]` is the filter of the regression. After 0.25 s of rest the friction has any value between `-f_c` and
/// `f_c`, so `f_c²/3` is added to the variance. Weights are at most 1, so they do not amplify any row. Weights from the
/// residuals of the stacked rows would amplify them until the rows without a right-hand side vanish.
#[derive(Clone, Debug)]
pub struct TransitionWeights {
    transitions: Vec<Transition>,
    // Variance of each row's residual in sliding, (N·m)²; infinite until it is known.
    slip: Vec<f64>,
}

impl TransitionWeights {
    /// Returns weights that are all 1, for unknown friction: every law with a Coulomb transition
    /// has parameter 1, and all rows have infinite scale.
    ///
    /// - `noise`: of the filtered velocities.
    #[must_use]
    pub fn unknown(model: &Model, noise: &VelocityNoise) -> Self {
        let ones = vec![1.0; model.parameters().len()];
        Self::unweighted(model, noise, &ones)
    }

    /// Returns weights that are all 1 because all rows have infinite scale. The variance that
    /// transitions add is still computed, with the friction of `theta`, \[p\].
    #[must_use]
    pub fn unweighted(model: &Model, noise: &VelocityNoise, theta: &[f64]) -> Self {
        Self::new(model, noise, theta, &vec![f64::INFINITY; model.rows()])
    }

    /// Returns the weights for the friction of `theta`, \[p\].
    ///
    /// - `slip`: scale of each row's residual in sliding, \[rows\], N·m (N); a row with scale zero
    ///   has weight 1.
    #[must_use]
    pub fn new(model: &Model, noise: &VelocityNoise, theta: &[f64], slip: &[f64]) -> Self {
        let mut transitions: Vec<Transition> = Vec::new();
        for term in model.robot().terms {
            let JointParameter::Friction(side, law) = term.what else {
                continue;
            };
            let shape = *model.shape(term.joint);
            if law.jump(&AT_REST, &shape).is_none() {
                continue;
            }
            let size = (term.gain * theta[term.column]).abs();
            let same =
                |t: &&mut Transition| (t.row, t.side, t.joint) == (term.row, side, term.joint);
            if let Some(known) = transitions.iter_mut().find(same) {
                known.laws.push((law, size));
                continue;
            }
            let deviation = match side {
                Side::Link => noise.link[term.joint],
                Side::Motor => noise.motor[term.joint],
            };
            transitions.push(Transition {
                row: term.row,
                side,
                joint: term.joint,
                noise: shape.sharpness * deviation,
                shape,
                laws: vec![(law, size)],
            });
        }
        Self {
            transitions,
            slip: slip.iter().map(|scale| scale * scale).collect(),
        }
    }

    /// Returns the weights for a velocity noise that is `factor` times as large.
    #[must_use]
    pub fn with_noise(mut self, factor: f64) -> Self {
        for transition in &mut self.transitions {
            transition.noise *= factor;
        }
        self
    }

    /// Writes the variance that transitions add to each row of a sample, before filtering,
    /// \[rows\], (N·m)².
    pub(super) fn variances(&self, model: &Model, state: &State<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let robot = model.robot();
        for transition in &self.transitions {
            let joint = transition.joint;
            let velocity = match transition.side {
                Side::Link => state.dq[joint],
                Side::Motor => robot.motor_velocity(state, joint),
            };
            if !transition.is_past(velocity) {
                let at = robot.drive(state, joint).conditions(transition.side);
                out[transition.row] += transition.variance(&at);
            }
        }
    }

    /// Returns the largest friction of each row at each sample at rest, N·m (N), zero for samples in
    /// motion, \[samples × rows\]; empty if no sample is at rest.
    ///
    /// At rest the friction has any value between plus and minus this bound; the law, zero at zero velocity, does not
    /// describe it.
    pub(super) fn bounds_at_rest(
        &self,
        model: &Model,
        signals: &SignalBlock,
        period: f64,
        standing: &mut Standing,
    ) -> Vec<f64> {
        let needed = (REST_S / period) as u64;
        let (rows, n) = (model.rows(), signals.q.len());
        let robot = model.robot();
        standing.0.resize(self.transitions.len(), 0);
        let mut bounds = Vec::new();
        for (transition, standing) in self.transitions.iter().zip(&mut standing.0) {
            let joint = transition.joint;
            let moving: Vec<(f64, &[f64])> = match transition.side {
                Side::Link => vec![(1.0, &signals.dq[joint])],
                Side::Motor => (0..n)
                    .map(|i| (robot.ratio(joint, i), &*signals.dphi[i]))
                    .filter(|(ratio, _)| *ratio != 0.0)
                    .collect(),
            };
            for k in 0..signals.len() {
                let velocity = moving.iter().map(|(ratio, column)| ratio * column[k]).sum();
                *standing = if transition.stands(velocity) {
                    *standing + 1
                } else {
                    0
                };
                if *standing > needed {
                    bounds.resize(signals.len() * rows, 0.0);
                    bounds[k * rows + transition.row] += transition.bound();
                }
            }
        }
        bounds
    }

    /// Returns the variance of a row's friction at rest, (N·m)², from its bound.
    pub(super) fn variance_at_rest(bound: f64) -> f64 {
        VARIANCE_WITHIN_BOUNDS * bound * bound
    }

    /// Returns the weight of a sample in a row.
    ///
    /// - `variance`: the variance that transitions add, filtered, (N·m)².
    pub(super) fn weight(&self, row: usize, variance: f64) -> f64 {
        let slip = self.slip[row];
        if slip > 0.0 && slip.is_finite() {
            (slip / (slip + variance.max(0.0))).sqrt()
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> Transition {
        Transition {
            row: 0,
            side: Side::Motor,
            joint: 0,
            noise: 0.3,
            shape: Shape {
                sharpness: 100.0,
                stribeck_velocity: 0.1,
                presliding_width: 0.5,
                hysteresis_width: 0.05,
                play: 0.0,
                play_centre: 0.0,
            },
            laws: vec![(Law::CoulombPositive, 2.0), (Law::CoulombNegative, 1.0)],
        }
    }

    fn at(velocity: f64) -> Conditions {
        Conditions {
            velocity,
            ..AT_REST
        }
    }

    #[test]
    fn variance_is_that_of_the_friction_under_small_noise() {
        let mut bent = plain();
        bent.laws.push((Law::Stribeck, 0.5));
        // At 0.02 rad/s the Stribeck term has fallen to exp(-0.04).
        let stribeck = 0.5 * (-0.04_f64).exp();
        for (transition, size) in [
            (plain(), [1.0_f64, 2.0]),
            (bent, [1.0 + stribeck, 2.0 + stribeck]),
        ] {
            for (velocity, size) in [(-0.02_f64, size[0]), (0.02, size[1])] {
                // Slope of tanh(100 v); the velocity noise is 0.003 rad/s.
                let h: f64 = 1e-6;
                let slope =
                    ((100.0 * (velocity + h)).tanh() - (100.0 * (velocity - h)).tanh()) / (2.0 * h);
                let expected: f64 = (size * slope * 0.003_f64).powi(2);
                let found = transition.variance(&at(velocity));
                // The third derivative of a tanh is at most four times its first, with the sharpness squared. The
                // variance has twice the error h² f‴ / 6 of the slope.
                let limit = 2.0 * 4.0 * (100.0 * h).powi(2) / 6.0;
                assert!((found / expected - 1.0).abs() < limit, "{found} {expected}");
            }
        }
        assert!(plain().variance(&at(1.0)) < f64::MIN_POSITIVE);
    }

    #[test]
    fn weights_are_at_most_one_and_rows_without_scale_have_weight_one() {
        let weights = TransitionWeights {
            transitions: vec![plain()],
            slip: vec![4.0, 0.0, f64::INFINITY],
        };
        assert!((weights.weight(0, 0.0) - 1.0).abs() < 1e-15);
        assert!((weights.weight(0, 12.0) - 0.5).abs() < 1e-15);
        // The filter can undershoot slightly below zero.
        assert!((weights.weight(0, -1.0) - 1.0).abs() < 1e-15);
        assert!((weights.weight(1, 12.0) - 1.0).abs() < 1e-15);
        assert!((weights.weight(2, 12.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn friction_is_bounded_after_a_quarter_of_a_second_of_rest() {
        let experiment = crate::description::read(
            "experiment.toml",
            crate::demo::EXPERIMENT,
            &[],
            &mut crate::description::no_files,
        )
        .unwrap();
        let model = Model::new(&experiment).unwrap();
        let weights = TransitionWeights {
            transitions: vec![Transition {
                row: 2,
                noise: 0.01,
                ..plain()
            }],
            slip: vec![1.0; 4],
        };
        let mut block = SignalBlock::new(2);
        for k in 0..1000 {
            for joint in 0..2 {
                block.dq[joint].push(0.0);
                block.q[joint].push(0.0);
                block.phi[joint].push(0.0);
                // The joint moves for 0.4 s, reverses, moves again and stands still from 0.5 s on.
                let speed = if k >= 500 || k == 200 { 0.0 } else { 0.2 };
                block.dphi[joint].push(speed);
                block.tau[joint].push(0.0);
            }
            block.time.push(f64::from(k) * 1e-3);
        }
        let mut standing = Standing::default();
        let bounds = weights.bounds_at_rest(&model, &block, 1e-3, &mut standing);
        let of_row: Vec<f64> = bounds.chunks(4).map(|rows| rows[2]).collect();
        assert!(of_row[..750].iter().all(|bound| bound.abs() < 1e-12));
        // The larger friction of both directions.
        let larger = of_row[750..]
            .iter()
            .all(|bound| (bound - 2.0).abs() < 1e-12);
        assert!(larger);
        assert!((TransitionWeights::variance_at_rest(3.0) - 3.0).abs() < 1e-12);
    }
}
