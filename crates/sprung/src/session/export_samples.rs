//! Exports robots that were drawn from the posterior of an identification.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::error::SessionError;
use super::export::{ExportRequest, Exporter};
use super::load::Session;
use super::parameters::Parameters;
use sprung_export::{DrawOrigin, Exported, MujocoFields, MujocoNames, Origin, ValueOrigin, mujoco};
use sprung_method::estimate::{EstimateResult, Samples};

/// Some of the robots that [`Session::sample`] drew.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledRobots {
    /// Values of each of these robots by name: parameters, inertial parameters of single links, and constants of friction
    /// laws.
    pub values: Vec<BTreeMap<String, f64>>,
    /// Number of the first of these robots among all, from 0.
    pub first: usize,
    /// Number of all robots.
    pub count: usize,
    /// Their random seed.
    pub seed: u64,
}

impl SampledRobots {
    /// Returns some of the robots; `range` may end after the last one.
    #[must_use]
    pub fn of(samples: &Samples, seed: u64, range: Range<usize>) -> Self {
        let all = |robot: usize| {
            let mut values = samples.values(robot)?;
            let standard = samples.standard.get(robot)?.iter().copied();
            values.extend(samples.standard_parameters.iter().cloned().zip(standard));
            Some(values)
        };
        Self {
            first: range.start,
            values: range.map_while(all).collect(),
            count: samples.theta.len(),
            seed,
        }
    }
}

impl Session {
    /// Exports drawn robots, each as [`Session::export`] exports the estimate. Each file names its draw.
    ///
    /// - `parameters`: those of the identification from which the robots were drawn; `request` names the same result.
    ///
    /// # Errors
    ///
    /// [`SessionError`] as of [`Session::export`], and [`SessionError::NoPosterior`] if the parameters come from no
    /// identification.
    pub fn export_samples(
        &self,
        parameters: &Parameters,
        request: &ExportRequest<'_>,
        robots: &SampledRobots,
    ) -> Result<Vec<Exported>, SessionError> {
        let exporter = Exporter::new(self, parameters, request)?;
        let result = exporter.result.ok_or(SessionError::NoPosterior)?;
        (robots.values.par_iter().enumerate())
            .map(|(at, raw)| {
                let values = completed(&exporter, result, raw);
                let origin = Origin {
                    draw: Some(DrawOrigin {
                        robot: robots.first + at,
                        count: robots.count,
                        seed: robots.seed,
                    }),
                    values: origins(result, raw, &values),
                    ..exporter.origin().clone()
                };
                exporter.export(&values, origin)
            })
            .collect()
    }

    /// Returns the fields of the models that MuJoCo compiles from the MJCF of drawn robots, and their names.
    ///
    /// # Errors
    ///
    /// [`SessionError`] as of [`Session::export_samples`].
    pub fn mujoco_of_samples(
        &self,
        parameters: &Parameters,
        request: &ExportRequest<'_>,
        robots: &SampledRobots,
    ) -> Result<(MujocoNames, Vec<MujocoFields>), SessionError> {
        let exporter = Exporter::new(self, parameters, request)?;
        let result = exporter.result.ok_or(SessionError::NoPosterior)?;
        let all: Vec<(MujocoNames, MujocoFields)> = (robots.values.par_iter())
            .map(|raw| {
                let values = completed(&exporter, result, raw);
                exporter.with(&values, exporter.origin().clone(), mujoco)
            })
            .collect::<Result<_, _>>()?;
        let names = all.first().map(|(names, _)| names.clone());
        let fields = all.into_iter().map(|(_, fields)| fields).collect();
        Ok((names.unwrap_or_default(), fields))
    }
}

/// Returns the values as the format needs them.
///
/// Friction beside laws that the format lacks is projected as that of the estimate, with the laws of this robot. Only the
/// sum of all laws takes energy in every robot, so a projection may be negative, and becomes zero.
fn completed(
    exporter: &Exporter<'_>,
    result: &EstimateResult,
    raw: &BTreeMap<String, f64>,
) -> BTreeMap<String, f64> {
    exporter.completed(result, raw.clone(), |moved| {
        let beside_laws = raw.get(&moved.name).copied().unwrap_or(moved.raw);
        let projected = moved.projected_with(beside_laws, |name| raw.get(name).copied());
        projected.max(0.0)
    })
}

/// Returns the values of a robot; a draw has no standard errors.
fn origins(
    result: &EstimateResult,
    raw: &BTreeMap<String, f64>,
    values: &BTreeMap<String, f64>,
) -> Vec<ValueOrigin> {
    let parameters = (result.parameters.iter()).map(|parameter| (&parameter.name, &parameter.unit));
    let standard = (result.standard_parameters.iter())
        .filter(|parameter| result.parameter(&parameter.name).is_none())
        .map(|parameter| (&parameter.name, &parameter.unit));
    let origin = |(name, unit): (&String, &String)| {
        let value = *values.get(name)?;
        let beside_laws = raw.get(name).copied();
        Some(ValueOrigin {
            name: name.clone(),
            unit: unit.clone(),
            value,
            beside_laws: beside_laws.filter(|other| other.to_bits() != value.to_bits()),
            standard_error: None,
        })
    };
    parameters.chain(standard).filter_map(origin).collect()
}
