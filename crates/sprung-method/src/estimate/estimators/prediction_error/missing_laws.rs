//! Score tests: whether the likelihood asks for a law that the model lacks, and how far this law
//! would move the parameters.
//!
//! One further run of the filter takes the derivatives by the parameters of all tested laws, at zero.
//!
//! # Source
//!
//! Rao, Proc. Camb. Phil. Soc. 1948: the score test, also called the Lagrange multiplier test.

use super::finish::last_run;
use super::measurements::with_laws;
use super::problem::{Problem, add_prior};
use super::refine::{End, Refinery};
use super::rung::Rung;
use super::sandwich::{Influence, widening};
use super::solve::covariance;
use super::start_levels::Searches;
use super::unknowns::Unknowns;
use super::vector::dot;
use crate::estimate::laws::Tested;
use crate::model::Model;
use crate::regression::PassError;

/// A law is tested if at least this fraction of its information is its own, not that of other
/// unknowns.
const RELATIVE_INFORMATION: f64 = 1e-6;

/// A law that the model lacks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MissingLaw {
    pub(super) tested: Tested,
    /// Estimate of its parameter by one Gauss-Newton step, and its standard error.
    pub(super) value: f64,
    pub(super) standard_error: f64,
    /// Moves of the refined parameters with this law, \[free\].
    pub(super) moves: Vec<f64>,
}

impl MissingLaw {
    /// Returns the estimate in standard errors.
    pub(super) fn significance(&self) -> f64 {
        self.value.abs() / self.standard_error
    }
}

impl Refinery<'_> {
    /// Tests laws at the end of a rung.
    ///
    /// - `richer`: the model with all tested laws.
    ///
    /// Returns the laws whose tests are possible.
    ///
    /// # Errors
    ///
    /// [`PassError`] if the filter of positions does not fit a log.
    pub(super) fn missing_laws(
        &self,
        rung: Rung,
        end: &End,
        richer: &Model,
        tested: &[Tested],
    ) -> Result<Vec<MissingLaw>, PassError> {
        let own = self.reading.model();
        let reading = (self.reading.with_model(richer.clone())).with_delays(&end.delays);
        let Some(measurements) = self.measurements(&end.delays)? else {
            return Ok(Vec::new());
        };
        let measurements = with_laws(&measurements, richer, reading.channels());
        let place = |name: &str| richer.parameters().iter().position(|p| p.name == name);
        let mut theta = vec![0.0; richer.parameters().len()];
        for (parameter, value) in own.parameters().iter().zip(&end.refined.theta) {
            if let Some(at) = place(&parameter.name) {
                theta[at] = *value;
            }
        }
        let before = &end.refined.free;
        let known: Option<Vec<usize>> = (before.iter())
            .map(|&index| place(&own.parameters()[index].name))
            .collect();
        let Some(mut free) = known else {
            return Ok(Vec::new());
        };
        free.extend(tested.iter().map(|law| law.parameter));
        let channels = reading.channels();
        let unknowns = Unknowns::new(richer, channels, &measurements, &theta, free)
            .with_residual_levels(end.residual.clone())
            .with_bends_of(&end.scales());
        let mut z = end.z.clone();
        z.splice(before.len()..before.len(), vec![0.0; tested.len()]);
        if z.len() != unknowns.values() {
            return Ok(Vec::new());
        }
        let noise = self.start.torque_noise;
        let searches = Searches::new(richer, &measurements, noise, rung, &end.levels);
        let problem = Problem {
            model: richer,
            measurements: &measurements,
            unknowns: &unknowns,
            levels: &searches.shown,
            noisy_rows: &noise.rows(richer),
            guard: None,
            robots: None,
        };
        let Some((sums, _)) = last_run(&problem, &unknowns, (&z, &end.levels)) else {
            return Ok(Vec::new());
        };
        let mut normal = sums.normal.clone();
        add_prior(&unknowns, &z, &mut normal);
        let count = z.len() - tested.len();
        // The columns of the tested laws lie behind the parameters.
        let column = |at: usize| {
            if at < before.len() {
                at
            } else {
                at + tested.len()
            }
        };
        let entry = |i: usize, j: usize| normal.information[i.max(j) * normal.count + i.min(j)];
        let whole: Vec<f64> = (0..count * count)
            .map(|at| entry(column(at / count), column(at % count)))
            .collect();
        let Some(covariance) = covariance(&whole, count) else {
            return Ok(Vec::new());
        };
        let duration = measurements.duration();
        let found = (tested.iter().enumerate()).filter_map(|(i, law)| {
            let new = before.len() + i;
            let cross: Vec<f64> = (0..count).map(|at| entry(new, column(at))).collect();
            // Moves of the other unknowns for a unit of the law.
            let moves: Vec<f64> = (covariance.chunks(count))
                .map(|row| -dot(row, &cross))
                .collect();
            let information = entry(new, new) + dot(&moves, &cross);
            if information.is_nan() || information <= RELATIVE_INFORMATION * entry(new, new) {
                return None;
            }
            let mut row = vec![0.0; normal.count];
            row[new] = 1.0 / information;
            for (at, own) in moves.iter().enumerate() {
                row[column(at)] = own / information;
            }
            let influence = Influence {
                row,
                variance: 1.0 / information,
            };
            let widening = widening(&[&influence], &sums.gradients, duration);
            let value = -dot(&influence.row, &normal.gradient);
            Some(MissingLaw {
                tested: law.clone(),
                value,
                standard_error: widening[0] * influence.variance.sqrt(),
                moves: (moves.iter().take(before.len()))
                    .map(|own| own * value)
                    .collect(),
            })
        });
        Ok(found.collect())
    }
}
