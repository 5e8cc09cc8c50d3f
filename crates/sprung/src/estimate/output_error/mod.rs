//! Output error: the closed loop is simulated with the controller of the file,
//! and the parameters are those whose motion is nearest to the measured one.
//!
//! Exact where controller and reference are known exactly and nothing else
//! drives the plant: simulation studies. The positions are compared with the
//! sensors' own noise for a scale, so the cost per sample says whether that is
//! so.

mod controller;
mod covariance;
mod findings;
mod levenberg;
mod record;
mod simulated;
mod told;

use crate::description::Controller;
use crate::estimate::found::{Criterion, Found, NORMAL_95, Numbers};
use crate::estimate::least_squares::Fitted;
use crate::estimate::result::SimulationFit;
use crate::finding::Severity;
use crate::named::Named;
use crate::prepare::Excerpt;
use crate::progress::{Listener, Stopped};
use crate::regression::Reading;
use crate::stopwatch::Stopwatch;

use crate::estimate::start::feasible;
use controller::compare_torques;
use covariance::standard_errors;
use levenberg::{Ending, minimise};
use record::Record;
use simulated::Loop;
use told::Told;

/// Fits the simulated closed loop to the beginning of a log.
///
/// - `excerpt`: the beginning of the log; what is in memory bounds the work:
///   the first samples up to its end or the first gap.
/// - `linear`: where the search starts, and what stands if it fails.
/// - `progress`: told of each simulation.
///
/// Memory is that of the derivatives: samples times positions times unknowns,
/// 18 MB for two joints, 80 MB for seven.
///
/// Minimises the squared errors of all positions over their noise. Unknowns are
/// the parameters that the log determines and an offset of each position, with
/// a prior of the sensor's resolution. Derivatives are forward differences.
///
/// # Source
///
/// Levenberg-Marquardt; standard errors: the larger of those of the
/// linearisation and of a sandwich over overlapping blocks, since quantisation
/// is no white noise.
///
/// # Errors
///
/// [`Stopped`] if who listens to the progress says so.
pub(super) fn output_error(
    reading: &Reading,
    controller: &Controller,
    excerpt: &Excerpt,
    linear: &Fitted,
    progress: &mut dyn Listener,
) -> Result<Found, Stopped> {
    let begun = Stopwatch::start();
    let told = Told::new(progress);
    let mut found = simulate_and_fit(reading, controller, excerpt, linear, &told);
    told.outcome()?;
    found.numbers.elapsed = begun.seconds();
    Ok(found)
}

fn simulate_and_fit(
    reading: &Reading,
    controller: &Controller,
    excerpt: &Excerpt,
    linear: &Fitted,
    told: &Told<'_>,
) -> Found {
    let model = reading.model();
    let mut failed = Found {
        // Simulated from beginning to end, it has no course over time.
        numbers: Numbers {
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
        // A fit to another loop only costs time.
        return failed;
    }

    let plant = Loop::new(model, controller, &record, start, &linear.identifiable);
    let problem = plant.problem(&linear.standard_error, told);
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
