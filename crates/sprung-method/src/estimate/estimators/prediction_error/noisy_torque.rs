//! Bias of the normal equations by noise of the logged torque.
//!
//! The filter assumes that the logged torque is the acting torque plus noise. This noise enters the innovations and, by
//! apparent accelerations and velocities, their derivatives. So the gradient is not zero at the true parameters, and
//! the information contains products of noise. Without a correction, inertias are too large by the ratio of the noise's
//! variance to the variance of the accelerating torque. Coulomb friction of a light rotor is biased in its transition,
//! where the velocity follows the noise within a sampling period. The filter's information gives the expectations of
//! gradient and information by this noise; they are subtracted. White noise of a link and noise while friction reverses
//! are acting torques, so they cause no such bias.
//!
//! # Source
//!
//! The attenuation by errors in variables and its correction; Fuller, Measurement Error Models,
//! sections 1.1 and 3.1.

use super::dynamics::{Dynamics, Pulse};
use super::filter::{NormalEquations, SegmentRun};
use super::levels::Levels;
use super::likelihood::{information_ahead, noise_behind};
use super::matrix::{multiply, transpose};
use super::problem::Problem;
use super::solve::largest_relative_eigenvalue;
use super::vector::{add, scale, widen};
use crate::estimate::estimators::prediction_error::state_layout::state_count;

/// Number of samples per sample whose gradient and information by noise in the period after the sample are computed,
/// and whose gradient by noise before the sample. All vary slowly; the information varies slower, so every second of
/// these samples suffices for it.
const GRADIENT_STRIDE: usize = 2;

/// Samples between those whose state is kept.
const STATE_STRIDE: usize = 8;

/// Maximum fraction of the information, in any direction, that is subtracted.
pub(super) const MAX_NOISE_SHARE: f64 = 0.95;

/// Expected gradient and information by noise of the logged torque.
#[derive(Clone, Debug)]
pub(super) struct NoiseBias {
    /// Of half the cost, \[values\].
    pub(super) gradient: Vec<f64>,
    /// \[values × values\]; only the lower triangle is filled.
    pub(super) information: Vec<f64>,
}

impl NoiseBias {
    pub(super) fn zero(values: usize) -> Self {
        Self {
            gradient: vec![0.0; values],
            information: vec![0.0; values * values],
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        add(&mut self.gradient, 1.0, &other.gradient);
        add(&mut self.information, 1.0, &other.information);
    }

    /// Returns the factor that limits the information to a fraction of that of normal equations, so
    /// that the difference stays positive definite.
    pub(super) fn limit(&self, normal: &NormalEquations) -> f64 {
        let values = self.gradient.len();
        let whole = normal.first(values).information;
        match largest_relative_eigenvalue(&self.information, &whole, values) {
            Some(share) if share > MAX_NOISE_SHARE => MAX_NOISE_SHARE / share,
            Some(_) => 1.0,
            None => 0.0,
        }
    }

    /// Multiplies the information by a factor.
    pub(super) fn scale_information(&mut self, factor: f64) {
        scale(&mut self.information, factor);
    }

    /// Subtracts the bias from normal equations whose first unknowns are those of the bias.
    pub(super) fn correct(&self, normal: &mut NormalEquations) {
        let values = self.gradient.len();
        add(&mut normal.gradient, -1.0, &self.gradient);
        for (i, row) in self.information.chunks(values.max(1)).enumerate() {
            add(
                &mut normal.information[i * normal.count..],
                -1.0,
                &row[..=i],
            );
        }
    }

    /// Returns the expected decrease of the cost by the noise when the unknowns move, `2 g_n · Δz +
    /// Δz · A_n Δz`.
    pub(super) fn cost(&self, by: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (i, row) in self.information.chunks(by.len().max(1)).enumerate() {
            let off: f64 = row[..i].iter().zip(by).map(|(a, d)| a * d).sum();
            sum += by[i] * (2.0 * (self.gradient[i] + off) + row[i] * by[i]);
        }
        sum
    }
}

/// Computes the bias of the normal equations at some unknowns and levels.
pub(super) struct NoiseSource<'a> {
    problem: &'a Problem<'a>,
    levels: &'a Levels,
    /// With the parameters of the unknowns.
    dynamics: Dynamics,
}

impl<'a> NoiseSource<'a> {
    pub(super) fn new(problem: &'a Problem<'a>, (z, levels): (&[f64], &'a Levels)) -> Self {
        let theta = problem.unknowns.theta(z);
        let mut dynamics = Dynamics::new(problem.model, &theta);
        dynamics.set(&theta, problem.unknowns.scales(z));
        Self {
            problem,
            levels,
            dynamics,
        }
    }

    /// Returns the bias by all samples of a segment.
    ///
    /// - `run`: of the segment, with the linearization, at the unknowns and levels.
    pub(super) fn bias(&self, segment: usize, run: &SegmentRun) -> NoiseBias {
        let mut sum = NoiseBias::zero(self.problem.unknowns.values());
        self.visit(segment, run, |_, bias| sum.add(bias));
        sum
    }

    /// Visits the bias that the samples of a segment add, the last sample first. Every second sample
    /// counts for two, and the information of every fourth one for four; that of others is empty.
    ///
    /// ```text
    /// g_n = −Σ_k (Σ_p σ_p² F_τpᵀ N_k F_τ T_p + Σ_r D_r(F_τrᵀ N_k F M_k))
    /// A_n = Σ_k Σ_p σ_p² T_pᵀ F_τᵀ N_k F_τ T_p
    /// ```
    ///
    /// Here `T_p` is the change of the parameters' torques by a torque on row p that acts for a period, \[rows ×
    /// values\], `D_r(x)` the change of those on row r by a deviation x of the state, \[values\], `F_τ` the transition
    /// by the torques, `N_k` the information of the later measurements about the state, and `M_k` the covariance of the
    /// state by earlier noise. The sum is the derivative of `½ Σ_k tr(N_k M_k)` with the gains held. `A_n` leaves out
    /// the motion after the period of the noise, so it is somewhat too large.
    pub(super) fn visit(
        &self,
        segment: usize,
        run: &SegmentRun,
        mut visit: impl FnMut(usize, &NoiseBias),
    ) {
        let (problem, mut dynamics) = (self.problem, self.dynamics.clone());
        let rows = dynamics.rows();
        let moving = 2 * rows;
        let logged_noise = problem.logged_noise(self.levels);
        let noisy: Vec<usize> = (0..rows).filter(|&row| logged_noise[row] > 0.0).collect();
        let values = problem.unknowns.values();
        let places = problem.unknowns.places(0);
        if noisy.is_empty() {
            return;
        }
        let linearization = &run.linearization;
        let measurements = problem.measurements;
        let period = measurements.segments[segment].period;
        let mut about = AboutTorques::new(rows);
        let mut changes: Vec<(usize, usize, usize, f64)> = Vec::new();
        let mut bias = NoiseBias::zero(values);
        let mut spread = vec![0.0; moving];
        let (segment, sensors) = (&measurements.segments[segment], &measurements.sensors);
        dynamics.carry(segment.carried.as_deref());
        let noise = (logged_noise.as_slice(), STATE_STRIDE);
        let behind = noise_behind(sensors, segment, run, self.levels, noise);
        let decay = self.levels.decay(period).factor;
        information_ahead(
            sensors,
            segment,
            run,
            self.levels,
            |sample, information, transition| {
                if !sample.is_multiple_of(GRADIENT_STRIDE) {
                    return;
                }
                about.write(information, transition);
                let size = 9 * rows * rows;
                let covariance = &behind[sample / STATE_STRIDE * size..][..size];
                write_spread(covariance, transition, &logged_noise, &mut spread);
                let pulse = Pulse {
                    state: &linearization.middles[sample * moving..(sample + 1) * moving],
                    transition,
                    period,
                    spread: &spread,
                };
                changes.clear();
                dynamics.set_known(segment.known(sample));
                dynamics.visit_pulse_torques(pulse, &noisy, |pushed, row, column, torque| {
                    if let Some(place) = places[column] {
                        changes.push((pushed, row, place, torque));
                    }
                });
                bias.gradient.fill(0.0);
                bias.information.clear();
                for &(pushed, row, place, torque) in &changes {
                    let variance = logged_noise[pushed].powi(2) * GRADIENT_STRIDE as f64;
                    bias.gradient[place] -= variance * torque * about.entries[pushed * rows + row];
                }
                if sample.is_multiple_of(STATE_STRIDE) {
                    let begin = about.correlated_states(transition, decay, covariance);
                    dynamics.visit_deviation_torques(pulse, begin, |_, column, torque| {
                        if let Some(place) = places[column] {
                            bias.gradient[place] -= STATE_STRIDE as f64 * torque;
                        }
                    });
                }
                if sample.is_multiple_of(2 * GRADIENT_STRIDE) {
                    bias.information.resize(values * values, 0.0);
                    for group in changes.chunk_by(|a, b| a.0 == b.0) {
                        let variance =
                            logged_noise[group[0].0].powi(2) * (2 * GRADIENT_STRIDE) as f64;
                        for &(_, row, place, torque) in group {
                            let about = &about.entries[row * rows..][..rows];
                            let entries = &mut bias.information[place * values..][..=place];
                            for &(_, other, at, change) in group {
                                if at <= place {
                                    entries[at] += variance * torque * change * about[other];
                                }
                            }
                        }
                    }
                }
                visit(sample, &bias);
            },
        );
    }
}

/// Writes the standard deviations of positions and velocities of a period by noise of the logged torque, \[2 rows\].
///
/// - `covariance`: of the state by earlier noise, \[3 rows × 3 rows\]; `transition`: F, \[2 rows × 3 rows\];
///   `noise`: of the torque in the period, N·m (N), \[rows\].
fn write_spread(covariance: &[f32], transition: &[f64], noise: &[f64], spread: &mut [f64]) {
    let states = state_count(noise.len());
    for (state, spread) in spread.iter_mut().enumerate() {
        let before = f64::from(covariance[state * (states + 1)]);
        let by_torque = &transition[state * states + 2 * noise.len()..][..noise.len()];
        // Half of the change over the period.
        let within: f64 = (by_torque.iter().zip(noise))
            .map(|(by, noise)| (0.5 * by * noise).powi(2))
            .sum();
        *spread = (before.max(0.0) + within).sqrt();
    }
}

/// Information of later measurements about the torques of a period, with its work memory.
struct AboutTorques {
    rows: usize,
    /// `F_τᵀ N F_τ`, \[rows × rows\].
    entries: Vec<f64>,
    /// `F_τ`, \[2 rows × rows\], and its transpose.
    by_torque: Vec<f64>,
    transposed: Vec<f64>,
    /// `F_τᵀ N`, \[rows × 3 rows\], and its first columns, \[rows × 2 rows\].
    product: Vec<f64>,
    moving: Vec<f64>,
    /// `F_τᵀ N F` over the whole state, and its product with M, \[rows × 3 rows\].
    back: Vec<f64>,
    covariance: Vec<f64>,
    correlated: Vec<f64>,
}

impl AboutTorques {
    fn new(rows: usize) -> Self {
        let zeros = |columns: usize| vec![0.0; rows * columns];
        Self {
            rows,
            entries: zeros(rows),
            by_torque: zeros(2 * rows),
            transposed: zeros(2 * rows),
            product: zeros(state_count(rows)),
            moving: zeros(2 * rows),
            back: zeros(state_count(rows)),
            covariance: Vec::new(),
            correlated: zeros(state_count(rows)),
        }
    }

    /// - `information`: N, \[3 rows × 3 rows\]; `transition`: F, \[2 rows × 3 rows\].
    fn write(&mut self, information: &[f64], transition: &[f64]) {
        let (rows, moving, states) = (self.rows, 2 * self.rows, state_count(self.rows));
        for (target, row) in (self.by_torque.chunks_mut(rows)).zip(transition.chunks(states)) {
            target.copy_from_slice(&row[moving..]);
        }
        transpose(&self.by_torque, rows, &mut self.transposed);
        multiply(&self.transposed, information, states, &mut self.product);
        for (target, row) in (self.moving.chunks_mut(moving)).zip(self.product.chunks(states)) {
            target.copy_from_slice(&row[..moving]);
        }
        multiply(&self.moving, &self.by_torque, rows, &mut self.entries);
    }

    /// Returns, for each row, the covariance of the state at the beginning of the period with the
    /// expected effect of a torque of the row, `F_τᵀ N F M`, \[rows × 3 rows\].
    ///
    /// - `transition`, `decay`: F and a; `covariance`: M, \[3 rows × 3 rows\].
    fn correlated_states(&mut self, transition: &[f64], decay: f64, covariance: &[f32]) -> &[f64] {
        let (moving, states) = (2 * self.rows, state_count(self.rows));
        widen(&mut self.covariance, covariance);
        multiply(&self.moving, transition, states, &mut self.back);
        for (back, product) in (self.back.chunks_mut(states)).zip(self.product.chunks(states)) {
            add(&mut back[moving..], decay, &product[moving..]);
        }
        multiply(&self.back, &self.covariance, states, &mut self.correlated);
        &self.correlated
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::estimate::estimators::prediction_error::filter::{Keep, run};
    use crate::estimate::estimators::prediction_error::levels::Disturbances;
    use crate::estimate::estimators::prediction_error::solve::covariance;
    use crate::estimate::estimators::prediction_error::tests::{Case, search_of};

    const NOISE: f64 = 0.03;
    const PAIRS: u64 = 40;

    /// The motion of the other tests, with noise on the logged torque.
    ///
    /// - `deviation`: of the measurements by which the filter weighs them, rad. Their errors are zero.
    fn noisy(noise: f64, seed: u64, deviation: f64) -> Case {
        let mut case = Case::new();
        let mut state = seed;
        // Four uniform numbers: nearly normal, with the variance 1.
        let mut random = || {
            let one = |_| {
                state = (state.wrapping_mul(6_364_136_223_846_793_005))
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            (0..4).map(one).sum::<f64>() * 3_f64.sqrt()
        };
        for segment in Arc::make_mut(&mut case.measurements.segments) {
            for k in 0..segment.samples() {
                for index in segment.first[k]..segment.first[k + 1] {
                    let measurement = &mut segment.measurements[index];
                    measurement.value -= Case::error(k, measurement.sensor);
                    measurement.variance = deviation * deviation;
                }
            }
            for torque in segment.torque.chunks_mut(4) {
                torque[2] += noise * random();
                torque[3] += 0.1 * noise * random();
            }
        }
        case.levels.torque_noise = vec![1e-6, 1e-6, NOISE, 0.1 * NOISE];
        case.levels.reversal_noise.fill(0.0);
        case.levels.disturbance.fill(1e-9);
        case.levels.sensor_noise.fill(0.0);
        case.measurements.fast_noise = vec![0.0, 0.0, NOISE, 0.1 * NOISE];
        case
    }

    /// Returns the normal equations of a case and their expected bias.
    fn normal_equations(case: &Case) -> (NormalEquations, NoiseBias) {
        let unknowns = case.unknowns();
        let z = unknowns.point(&case.theta);
        let dynamics = Dynamics::new(&case.model, &case.theta);
        let keep = Keep {
            linearization: true,
            ..Keep::default()
        };
        let (measurements, levels) = (&case.measurements, &case.levels);
        let problem = Problem {
            model: &case.model,
            measurements,
            unknowns: &unknowns,
            levels: &search_of(case, Disturbances::Free).1,
            noisy_rows: &[2, 3],
            guard: None,
            robots: None,
        };
        let at = (z.as_slice(), levels);
        let noise = NoiseSource::new(&problem, at);
        let (ran, biases) = run(
            measurements,
            &dynamics,
            &unknowns,
            at,
            keep,
            |index, of_segment| noise.bias(index, of_segment),
        )
        .unwrap();
        let mut bias = NoiseBias::zero(unknowns.values());
        for addend in &biases {
            bias.add(addend);
        }
        (ran.sums.normal, bias)
    }

    /// Gradient and information by noise: found and expected, in units of the information without it.
    struct ByNoise {
        gradient: [f64; 2],
        information: [f64; 2],
    }

    /// Returns the mean contributions of the noise to some parameters. Pairs of opposite noise cancel terms that are
    /// linear in the noise.
    fn by_noise(names: &[&str], deviation: f64) -> Vec<ByNoise> {
        let exact = normal_equations(&noisy(0.0, 0, deviation)).0;
        let case = noisy(0.0, 0, deviation);
        let places = case.unknowns().places(0);
        let of = |noise: f64| -> Vec<(NormalEquations, NoiseBias)> {
            (1..=PAIRS)
                .map(|seed| normal_equations(&noisy(noise, seed, deviation)))
                .collect()
        };
        let all = [of(NOISE), of(-NOISE)].concat();
        let mean = |each: &dyn Fn(&(NormalEquations, NoiseBias)) -> f64| {
            all.iter().map(each).sum::<f64>() / all.len() as f64
        };
        (names.iter())
            .map(|name| {
                let column = (case.model.parameters().iter()).position(|p| p.name == *name);
                let place = places[column.unwrap()].unwrap();
                let diagonal = |matrix: &[f64], count: usize| matrix[place * (count + 1)];
                let whole = diagonal(&exact.information, exact.count);
                ByNoise {
                    gradient: [
                        mean(&|(normal, _)| normal.gradient[place] - exact.gradient[place]),
                        mean(&|(_, bias)| bias.gradient[place]),
                    ]
                    .map(|sum| sum / whole.sqrt()),
                    information: [
                        mean(&|(normal, _)| diagonal(&normal.information, normal.count) - whole),
                        mean(&|(_, bias)| diagonal(&bias.information, bias.gradient.len())),
                    ]
                    .map(|sum| sum / whole),
                }
            })
            .collect()
    }

    #[test]
    fn noise_adds_the_expected_information_and_gradient() {
        let names = [
            "joint1.rotor_inertia",
            "joint2.rotor_inertia",
            "joint1.motor_viscous",
        ];
        // Fine positions correct the state within a sample, coarser ones within many.
        for deviation in [1e-6, 1e-5] {
            for (name, by_noise) in names.iter().zip(by_noise(&names, deviation)) {
                let [found, expected] = by_noise.gradient;
                let ratio = expected / found;
                // Without the state behind the period the ratios would be 1.3 to 1.6 for the inertias and below 0.15
                // for the friction. Half of the least difference tells both cases apart.
                assert!(
                    (ratio - 1.0).abs() < 0.15,
                    "{name}, {deviation}: {expected} expected, {found} found"
                );
                if name.ends_with("inertia") {
                    let [found, expected] = by_noise.information;
                    let ratio = expected / found;
                    // The formula leaves out the motion behind the period, so it takes away too much information: at
                    // most twice, or a standard error would be √2 too large.
                    assert!(
                        (1.0..2.0).contains(&ratio),
                        "{name}, {deviation}: {expected} expected, {found} found"
                    );
                }
            }
        }
    }

    #[test]
    fn corrected_information_stays_positive() {
        let (mut normal, mut bias) = normal_equations(&noisy(NOISE, 1, 1e-6));
        assert!(bias.limit(&normal) >= 1.0);
        bias.scale_information(1e6);
        bias.scale_information(bias.limit(&normal));
        let before = normal.first(bias.gradient.len()).information;
        bias.correct(&mut normal);
        let after = normal.first(bias.gradient.len()).information;
        let left = largest_relative_eigenvalue(&after, &before, bias.gradient.len()).unwrap();
        assert!(left < 1.0 + 1e-9, "{left}");
        assert!(covariance(&after, bias.gradient.len()).is_some());
    }
}
