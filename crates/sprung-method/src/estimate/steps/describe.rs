//! The last step: judges the estimates and assembles the identification.

use super::basis::{Basis, Estimates};
use super::curves::{fit_curves, over_time, trace_of};
use super::identified::Identified;
use super::one_result::result_of;
use super::springs_of_motors::springs_of_motors;
use crate::description::Estimator;
use crate::estimate::errors::IdentifyError;
use crate::estimate::estimators::Found;
use crate::estimate::estimators::least_squares::cutoff_choice;
use crate::estimate::estimators::prediction_error::Timing;
use crate::estimate::judge::{
    after_estimation, applied, decide, judge, tilt_is_possible, tilted, unpredicted,
    with_held_out_delay,
};
use crate::estimate::refined_unknowns::{refined_unknowns, with_curves};
use crate::estimate::result::{
    CutoffChoice, DelayUsed, EstimateResult, GENERATOR, IDENTIFICATION_FORMAT, Identification,
    RigidJoint, SensedSpring, SettingsUsed,
};
use crate::estimate::springs::{Sensed, Undetermined, finding};
use crate::finding::{Finding, Severity};
use crate::frequency::SpringFromMotor;
use crate::prepare::PrepareError;
use crate::progress::{Listener, Phase};
use crate::regression::Reading;
use crate::unknowns::UnknownResult;

/// Judges the estimates, examines doubtful results again, and assembles the identification.
///
/// # Errors
///
/// [`IdentifyError`] if the caller stops the run.
pub(in crate::estimate) fn describe(
    basis: &Basis<'_>,
    estimates: Estimates,
    sensed: Sensed,
    progress: &mut dyn Listener,
) -> Result<Identified, IdentifyError> {
    let model = basis.ready.prepared.reading().model();
    let undetermined =
        (basis.springs).with_refined(basis.ready.prepared.reading(), &estimates.robot);
    let mut results: Vec<EstimateResult> = (estimates.robot.iter())
        .map(|(estimator, found)| judged((basis, &undetermined), *estimator, found))
        .collect();
    progress.tell(Phase::Examining, 1, Some(2))?;
    let mut rigid_joints = basis.ready.rigid.clone();
    rigid_joints.extend(undetermined.described(model));
    let mut findings = basis.findings.to_vec();
    findings.extend(sensed.finding(basis.ready.prepared.experiment()));
    rigid_joints.extend(sensed.open);
    findings.extend(finding(model, &rigid_joints));
    findings.extend(basis.sums.findings(model));
    findings.extend(look_again(basis, &results));
    after_estimation(&mut findings);
    let (springs, about_springs) = springs_of_motors(basis);
    findings.extend(about_springs);
    // Findings about payloads do not concern the parameters of the robot.
    for result in &mut results {
        decide(result, &findings);
    }
    let about_payloads = estimates
        .payloads
        .iter()
        .flat_map(|(_, about_payload)| about_payload);
    findings.extend(about_payloads.cloned());
    progress.tell(Phase::Examining, 2, Some(2))?;
    let judged = Judged {
        results,
        findings,
        springs,
        sensed: sensed.springs,
        rigid_joints,
    };
    assemble(basis, estimates, judged)
}

/// Returns the result of least squares as it is before a refinement, without the examinations that
/// follow an estimation.
///
/// # Errors
///
/// [`IdentifyError`] if there is no log.
pub(in crate::estimate) fn before_refinement(
    basis: &Basis<'_>,
) -> Result<Identified, IdentifyError> {
    let found = basis.least_squares();
    let model = basis.ready.prepared.reading().model();
    let mut result = judged((basis, basis.springs), Estimator::LeastSquares, &found);
    let mut rigid_joints = basis.ready.rigid.clone();
    rigid_joints.extend(basis.springs.described(model));
    let mut findings = basis.findings.to_vec();
    findings.extend(finding(model, &rigid_joints));
    findings.push(Finding::new(
        Severity::Info,
        "refinement-pending",
        "these are the values of least squares, written before the refinement. The refinement has \
         not ended, or it was stopped"
            .to_owned(),
        "let sprung identify end, or set estimator = \"least-squares\"",
    ));
    decide(&mut result, &findings);
    let estimates = Estimates {
        robot: vec![(Estimator::LeastSquares, found)],
        payloads: Vec::new(),
    };
    let judged = Judged {
        results: vec![result],
        findings,
        springs: Vec::new(),
        sensed: Vec::new(),
        rigid_joints,
    };
    assemble(basis, estimates, judged)
}

/// Judged results of all estimators.
struct Judged {
    /// One per estimate.
    results: Vec<EstimateResult>,
    /// Findings about the logs and payloads.
    findings: Vec<Finding>,
    springs: Vec<SpringFromMotor>,
    sensed: Vec<SensedSpring>,
    /// Joints whose spring the logs do not determine.
    rigid_joints: Vec<RigidJoint>,
}

/// Assembles the identification and its curves.
fn assemble(
    basis: &Basis<'_>,
    estimates: Estimates,
    judged: Judged,
) -> Result<Identified, IdentifyError> {
    let (prepared, read) = (&basis.ready.prepared, basis.read);
    let reading = prepared.reading();
    let model = reading.model();
    let robot = estimates.robot;
    let thetas = (robot.iter()).map(|(estimator, found)| (*estimator, &found.numbers.theta));
    let fit = fit_curves(model, thetas, judged.results.first(), &read.system);
    let by_likelihood: Vec<UnknownResult> = (robot.iter())
        .flat_map(|(_, found)| found.unknowns.iter().cloned())
        .collect();
    let traces = (robot.into_iter())
        .filter(|(_, found)| !found.numbers.points.is_empty())
        .map(|(estimator, found)| trace_of(model, estimator, found.numbers.points))
        .collect();
    let refined = judged.results.iter().find_map(EstimateResult::refined);
    let mut unknowns = refined_unknowns(&basis.ready.unknowns, refined);
    for one in by_likelihood {
        let same = |other: &UnknownResult| (&other.kind, &other.place) == (&one.kind, &one.place);
        if !basis.ready.unknowns.iter().any(same) {
            unknowns.push(one);
        }
    }
    let unknowns = with_curves(unknowns, judged.results.first());
    let retiming = match basis.timing {
        Timing::Found(retiming) => Some(retiming),
        Timing::Open => None,
    };
    let torques_delay_s = retiming
        .and_then(|retiming| retiming.torques_delay(refined))
        .map(|(value, standard_error)| DelayUsed {
            value,
            standard_error: Some(standard_error),
        });
    let mut infos = (read.infos.iter()).map(|info| {
        info.clone().with_choices(
            (prepared, &basis.ready.unknowns),
            (refined, torques_delay_s),
        )
    });
    let period = prepared.excerpt().period();
    let payloads = estimates.payloads.into_iter();
    Ok(Identified {
        trace: over_time(model, &read.system, traces),
        fit,
        identification: Identification {
            format: IDENTIFICATION_FORMAT,
            generator: GENERATOR.to_owned(),
            robot: prepared.experiment().robot.name.clone(),
            log: infos.next().ok_or(PrepareError::NoLog)?,
            further_logs: infos.collect(),
            settings: settings_used(reading, cutoff_choice(prepared)),
            applied: applied(
                model,
                &judged.findings,
                (retiming, refined),
                &unknowns,
                period,
            ),
            springs_from_motor: judged.springs,
            sensed_springs: judged.sensed,
            rigid_joints: judged.rigid_joints,
            unknowns,
            payloads: payloads.map(|(payload, _)| payload).collect(),
            findings: judged.findings,
            results: judged.results,
        },
    })
}

/// Returns the result of an estimator with all its findings.
fn judged(
    (basis, springs): (&Basis<'_>, &Undetermined),
    estimator: Estimator,
    found: &Found,
) -> EstimateResult {
    let (reading, linear) = (basis.ready.prepared.reading(), basis.linear);
    let (model, channels) = (reading.model(), reading.channels());
    let choice = (estimator, &reading.settings().physical);
    let mut result = result_of(model, choice, &found.numbers, linear, &basis.read.system);
    springs.complete(model, &mut result);
    basis.sums.complete(&mut result);
    let judged = judge(
        model,
        &result,
        linear,
        basis.ready.prepared.sweep(),
        channels,
    );
    result.warnings.extend(judged);
    let excerpt = basis.ready.prepared.excerpt();
    let not_predicted = unpredicted(&result, model.joints(), channels, excerpt);
    result.warnings.extend(not_predicted);
    let findings = found.findings.iter().cloned();
    result
        .warnings
        .extend(findings.map(|finding| with_held_out_delay(finding, &basis.ready.prepared)));
    (result.warnings).sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    springs.hide(model, &mut result);
    result
}

/// Examines the beginning of the first log again: tests whether gravity is tilted.
fn look_again(basis: &Basis<'_>, results: &[EstimateResult]) -> Option<Finding> {
    let prepared = &basis.ready.prepared;
    let (reading, excerpt) = (prepared.reading(), prepared.excerpt());
    if tilt_is_possible(prepared.experiment(), worst_residual(results)) {
        return tilted(prepared.experiment(), reading, excerpt);
    }
    None
}

/// Returns the largest relative residual of the torque rows of the first result.
fn worst_residual(results: &[EstimateResult]) -> f64 {
    let first = results.first().into_iter();
    first
        .flat_map(|result| result.relative_residual.iter())
        .fold(0.0, |worst, (_, share)| worst.max(share))
}

fn settings_used(reading: &Reading, choice: Option<CutoffChoice>) -> SettingsUsed {
    let settings = reading.settings();
    SettingsUsed {
        filter_cutoff_rad_per_s: reading.filter_cutoff(),
        discretization: settings.discretization.name().to_owned(),
        weights: settings.weights.name().to_owned(),
        constraints: settings.constraints.name().to_owned(),
        position_cutoff_hz: reading.position_cutoff_hz(),
        position_cutoff_choice: choice,
        position_filter_order: settings.position_filter_order,
    }
}
