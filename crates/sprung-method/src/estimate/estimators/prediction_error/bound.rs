//! Cramér-Rao bound of the parameters for a log with known noise.

use std::collections::BTreeMap;

use super::dynamics::Dynamics;
use super::effects::{Filtered, TorquesTiming, of_delays};
use super::filter::{Keep, run};
use super::levels::Levels;
use super::measurements::{Extent, build, max_samples, read};
use super::problem::add_prior;
use super::solve;
use super::unknowns::Unknowns;
use crate::description::{Delay, Experiment, Simulate};
use crate::estimate::errors::IdentifyError;
use crate::log::{Channels, LogError, LogSource};
use crate::model::Model;
use crate::prepare::{PrepareError, as_given, excerpt};
use crate::regression::PassError;
use crate::simulate::Disturbance;

/// The true values of a robot and its log.
#[derive(Clone, Copy, Debug)]
pub struct KnownTruth<'a> {
    /// Parameters, \[p\], SI units.
    pub theta: &'a [f64],
    /// Noise and disturbances.
    pub noise: &'a KnownNoise,
    /// Delays of columns, s; zero for other columns.
    pub delays: &'a BTreeMap<String, f64>,
}

/// Known noise of a log and known disturbances of its robot: standard deviations in N·m (N), \[n\].
#[derive(Clone, Debug, PartialEq)]
pub struct KnownNoise {
    /// White noise of the logged torque.
    pub torque: Vec<f64>,
    /// Disturbance of the motor.
    pub motor: Vec<f64>,
    /// Disturbance of the link.
    pub link: Vec<f64>,
    /// Corner frequency of the spectrum of both disturbances, Hz.
    pub corner: f64,
}

impl From<&Simulate> for KnownNoise {
    fn from(settings: &Simulate) -> Self {
        Self {
            torque: settings.torque_noise_nm.clone(),
            motor: settings.torque_disturbance_nm.clone(),
            link: settings.link_torque_disturbance_nm.clone(),
            corner: Disturbance::CORNER_HZ,
        }
    }
}

/// Smallest covariance of unbiased estimates: the bound of Cramér and Rao.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Indices of the free parameters.
    pub free: Vec<usize>,
    /// Their covariance, \[free × free\], row by row, SI units.
    pub covariance: Vec<f64>,
    parameters: usize,
}

impl Bound {
    /// Returns the smallest standard deviation of each parameter, \[p\]; zero for fixed parameters.
    #[must_use]
    pub fn standard_errors(&self) -> Vec<f64> {
        let count = self.free.len();
        let mut all = vec![0.0; self.parameters];
        for (place, &index) in self.free.iter().enumerate() {
            all[index] = self.covariance[place * (count + 1)].sqrt();
        }
        all
    }
}

/// Returns the Cramér-Rao bound of the parameters. Returns `None` if the log is too short or does not determine all parameters.
///
/// The bound is that of Gaussian measurements: the inverse of the information of the filter's
/// innovations at the true parameters and the true noise. Encoders count as measurements at the
/// edges of their counts. The counts between the edges contain further information, so an estimate
/// from coarse encoders may have a smaller error than the bound.
///
/// Unknown are also the delays to be estimated and the Stribeck velocities that the description does not give.
///
/// - `model`: contains the true Stribeck velocities.
/// - `sources`: logs of the same robot, which count together.
///
/// # Errors
///
/// [`IdentifyError`] if the description or a log is faulty.
///
/// # Source
///
/// Ljung, System Identification, chapter 7.
pub fn information_bound(
    experiment: &Experiment,
    model: &Model,
    truth: KnownTruth<'_>,
    sources: &mut [LogSource<'_>],
) -> Result<Option<Bound>, IdentifyError> {
    let KnownTruth { theta, noise, .. } = truth;
    let log = experiment.log.as_ref().ok_or(PrepareError::NoLog)?;
    let channels = Channels::new(&experiment.robot, log)?;
    let failed = |error: LogError| IdentifyError::Pass(PassError::from(error));
    let first = sources.first_mut().ok_or(PrepareError::NoLog)?;
    let excerpt = excerpt(&channels, first).map_err(failed)?;
    let settings = &experiment.identify;
    let (reading, _) = as_given(model, settings, &channels, &excerpt);
    let delays = channels.all.iter();
    let delays = delays.map(|channel| truth.delays.get(&channel.column).copied());
    let delays: Vec<f64> = delays.map(Option::unwrap_or_default).collect();
    let reading = reading.with_delays(&delays);
    let open: Vec<usize> = (0..channels.all.len())
        .filter(|&i| channels.all[i].delay == Some(Delay::Estimate))
        .collect();
    let limit = max_samples(model.coordinates());
    let (raw, left_out) = read(&channels, sources, Extent::Beginning(limit)).map_err(failed)?;
    let Some(measurements) = build(&reading, &excerpt, &raw, left_out)? else {
        return Ok(None);
    };
    let parameters = model.parameters().iter().enumerate();
    let free: Vec<usize> = parameters
        .filter(|(_, parameter)| parameter.fixed.is_none())
        .map(|(index, _)| index)
        .collect();
    let effects = of_delays(
        &Filtered::of_channels(model, &channels, &measurements),
        (&open, TorquesTiming::Given),
    );
    let unknowns =
        Unknowns::new(model, &channels, &measurements, theta, free).with_effects(effects);
    let z = unknowns.point(theta);
    let dynamics = Dynamics::new(model, theta);
    let levels = levels(model, noise, measurements.sensors.len());
    let keep = Keep::default();
    let at = (z.as_slice(), &levels);
    let Some((run, _)) = run(&measurements, &dynamics, &unknowns, at, keep, |_, _| ()) else {
        return Ok(None);
    };
    let count = unknowns.values() + open.len();
    let mut normal = run.sums.normal.first(count);
    add_prior(&unknowns, &z, &mut normal);
    let Some(all) = solve::covariance(&normal.information, count) else {
        return Ok(None);
    };
    let places = 0..unknowns.free.len();
    let rows = places.clone();
    Ok(Some(Bound {
        covariance: rows
            .flat_map(|i| places.clone().map(move |j| i * count + j))
            .map(|at| all[at])
            .collect(),
        free: unknowns.free.clone(),
        parameters: theta.len(),
    }))
}

fn levels(model: &Model, noise: &KnownNoise, sensors: usize) -> Levels {
    let rows = 0..model.coordinates();
    let of_row = |list: &[f64], row: usize| list.get(model.joint_of(row)).copied().unwrap_or(0.0);
    Levels {
        sensor_noise: vec![0.0; sensors],
        reversal_noise: vec![0.0; model.coordinates()],
        torque_noise: (rows.clone())
            .map(|row| {
                if model.is_torque_row(row) {
                    of_row(&noise.torque, row)
                } else {
                    0.0
                }
            })
            .collect(),
        disturbance: rows
            .map(|row| {
                let moved = if model.is_torque_row(row) {
                    &noise.motor
                } else {
                    &noise.link
                };
                of_row(moved, row)
            })
            .collect(),
        corner: noise.corner,
    }
}
