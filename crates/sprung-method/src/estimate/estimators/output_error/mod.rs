//! Output error: simulates the closed loop with the described controller and estimates the
//! parameters with the motion nearest to the measured one.
//!
//! The method is exact if controller and reference are known exactly and no other torque acts on
//! the plant, as in simulation studies. Position errors are scaled by the noise of the sensors, so
//! the cost per sample shows whether these conditions hold.

mod controller;
mod covariance;
mod findings;
mod levenberg;
mod record;
mod simulated;
mod simulation_counter;

use crate::description::Controller;
use crate::estimate::estimators::estimator_result::{Criterion, Found, Numbers};
use crate::estimate::estimators::least_squares::Fitted;
use crate::estimate::result::SimulationFit;
use crate::estimate::statistics::NORMAL_95;
use crate::finding::Severity;
use crate::named::Named;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Stopped};
use crate::regression::Reading;
use crate::stopwatch::Stopwatch;

use crate::estimate::estimators::feasible::feasible;
use controller::compare_torques;
use covariance::standard_errors;
use levenberg::{Ending, minimise};
use record::Record;
use simulated::Loop;
use simulation_counter::SimulationCounter;

/// Fits the simulated closed loop to the beginning of a log.
///
/// - `excerpt`: the beginning of the log. The fit uses its samples up to the first gap.
/// - `linear`: the start of the search, and the result if the search fails.
/// - `progress`: is called before each simulation.
///
/// The derivatives determine the memory: samples times positions times unknowns, 18 MB for two
/// joints, 80 MB for seven.
///
/// Minimises the squared errors of all positions, scaled by their noise. The unknowns are the
/// parameters that the log determines and an offset of each position, with the sensor's resolution
/// as its prior. Derivatives are forward differences.
///
/// # Source
///
/// Levenberg-Marquardt. The standard errors are the larger of those of the linearisation and those
/// of a sandwich over overlapping blocks, because quantisation is not white noise.
///
/// # Errors
///
/// [`Stopped`] if the listener requests a stop.
pub(in crate::estimate) fn output_error(
    reading: &Reading,
    controller: &Controller,
    excerpt: &Excerpt,
    linear: &Fitted,
    progress: &mut dyn Listener,
) -> Result<Found, Stopped> {
    let begun = Stopwatch::start();
    let counter = SimulationCounter::new(progress);
    let mut found = simulate_and_fit(reading, controller, excerpt, linear, &counter);
    counter.outcome()?;
    found.numbers.elapsed = begun.seconds();
    Ok(found)
}

fn simulate_and_fit(
    reading: &Reading,
    controller: &Controller,
    excerpt: &Excerpt,
    linear: &Fitted,
    counter: &SimulationCounter<'_>,
) -> Found {
    let model = reading.model();
    let mut failed = Found {
        // The estimate uses the record as a whole, so it has no trace.
        numbers: Numbers {
            error_parts: Vec::new(),
            interval: NORMAL_95,
            criterion: Criterion::Loop(None),
            ..Numbers::of(linear)
        },
        findings: findings::standing(),
    };
    let Some(record) = Record::new(reading, excerpt) else {
        failed.findings.push(findings::no_record());
        return failed;
    };
    failed.findings.push(findings::samples(&record));
    let (start, changed) = match feasible(model, &linear.theta) {
        Ok(found) => found,
        Err(error) => {
            failed.findings.push(findings::no_start(&error.to_string()));
            return failed;
        }
    };
    failed
        .findings
        .extend(findings::start_changed(model, &changed));
    let torques = compare_torques(model, &start, controller, &record);
    let about_controller = findings::controller(model, &torques);
    let another = (about_controller.iter()).any(|finding| finding.severity == Severity::Serious);
    failed.findings.extend(about_controller);
    if another {
        // A fit to the loop of another controller would be useless.
        return failed;
    }

    let plant = Loop::new(model, controller, &record, start, &linear.identifiable);
    let problem = plant.problem(&linear.standard_error, counter);
    let Ok(found) = minimise(&problem) else {
        let why = "its simulated loop runs away, or is too stiff to be followed";
        failed.findings.push(findings::no_start(why));
        return failed;
    };
    let simulation = SimulationFit {
        samples: record.len() as u64,
        cost_per_sample: found.cost / found.residuals.len().max(1) as f64,
        iterations: found.iterations,
        position_rms_over_noise: plant.rms(&found.residuals),
        offset_rad: plant.offsets(&found.x),
        torque_mismatch: (model.joints().iter().zip(&torques))
            .filter_map(|(name, torque)| Some((name.clone(), torque.as_ref()?.relative)))
            .collect::<Named>(),
    };
    if found.ending != Ending::Converged {
        let last = plant.name(found.moved);
        let finding = findings::not_converged(found.ending, &last, &simulation);
        failed.findings.push(finding);
        failed.numbers.criterion = Criterion::Loop(Some(simulation));
        return failed;
    }
    let errors = standard_errors(&found, record.len());
    let mut findings = failed.findings;
    findings.extend(findings::cost(&simulation));
    Found {
        numbers: Numbers {
            theta: plant.theta(&found.x),
            identifiable: plant.spread(&errors, |error| error.is_some(), &linear.identifiable),
            errors: plant.spread(
                &errors,
                |error| error.unwrap_or(f64::INFINITY),
                &vec![0.0; linear.theta.len()],
            ),
            criterion: Criterion::Loop(Some(simulation)),
            ..failed.numbers
        },
        findings,
    }
}
