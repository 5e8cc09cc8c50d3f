//! Verdict on a case, and the evidence of another log.

use std::path::{Path, PathBuf};

use sprung::session::{Parameters, Session};
use sprung_base::finding::Severity;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{EstimateResult, Identification, IdentifyError, identify};
use sprung_method::validate::{ChosenFor, JointProof, Validated, validate};
use sprung_model::Model;
use sprung_robot::Estimator;

use crate::case::Case;
use crate::in_memory::with_source;
use crate::kind::Kind;

/// A *good* verdict is wrong if the held-out error is more than this multiple of the promised error, or
/// if fewer than this part of the intervals contain the truth.
const MAX_OVER_PROMISE: f64 = 1.5;
const MIN_COVERAGE: f64 = 0.8;

/// A case is truly good if the held-out error is at most this multiple of that of the true robot, and if at least this part of the intervals contain the truth.
const MAX_OVER_TRUTH: f64 = 1.1;
const TRUE_COVERAGE: f64 = 0.9;

/// Number of the log that is predicted.
const HELD_OUT: u64 = 1000;

/// Outcome of a case with one estimator.
pub(crate) struct Outcome {
    pub(crate) kind: Kind,
    pub(crate) estimator: &'static str,
    seed: u64,
    joints: usize,
    fault: String,
    /// `good`, `doubtful`, `unusable` or `refused`.
    pub(crate) verdict: &'static str,
    /// Codes of the findings above a note.
    pub(crate) codes: Vec<String>,
    /// Part of the intervals that contain the truth; zero if there is no truth.
    coverage: f64,
    /// Largest held-out error of a torque or deflection over its promise; infinite without a promise.
    over_promise: f64,
    /// Held-out error of the torques over that of the true robot, root mean square over the joints.
    over_truth: f64,
    /// Errors of each parameter in its standard errors, one per log.
    errors: Vec<(String, Vec<f64>)>,
}

impl Outcome {
    /// Returns whether *good* is the wrong verdict.
    pub(crate) fn is_wrong_if_good(&self) -> bool {
        self.over_promise > MAX_OVER_PROMISE || self.coverage < MIN_COVERAGE
    }

    /// Returns whether *good* is the only right verdict.
    pub(crate) fn is_truly_good(&self) -> bool {
        self.over_truth <= MAX_OVER_TRUTH && self.coverage >= TRUE_COVERAGE
    }

    /// Returns a line per parameter: its errors in standard errors, one per log.
    pub(crate) fn parameters(&self) -> Vec<String> {
        let line = |(name, errors): &(String, Vec<f64>)| {
            let each: Vec<String> = errors.iter().map(|error| format!("{error:.1}")).collect();
            format!("    {name}: {}", each.join(" "))
        };
        self.errors.iter().map(line).collect()
    }

    /// Returns the outcome as a line.
    pub(crate) fn line(&self) -> String {
        format!(
            "{} {} {} joints, {}, {}: {}, coverage {:.0} %, over promise {:.2}, over truth {:.2}; {}",
            self.kind.name(),
            self.seed,
            self.joints,
            self.fault,
            self.estimator,
            self.verdict,
            100.0 * self.coverage,
            self.over_promise,
            self.over_truth,
            self.codes.join(" ")
        )
    }
}

/// Returns the outcome of a case with each estimator.
///
/// - `keep`: folder for the identifications.
pub(crate) fn outcomes(case: &Case, estimators: &[Estimator], keep: Option<&Path>) -> Vec<Outcome> {
    let mut experiment = case.experiment.clone();
    experiment.identify.estimator = estimators.to_vec();
    let identified: Vec<Result<Identification, Vec<String>>> = (0..case.logs())
        .map(|number| {
            let log = case.log(number).ok_or_else(Vec::new)?;
            let found = with_source(&log, |source| {
                identify(&experiment, &case.model, &mut [source], &mut Unheard)
            });
            found
                .map(|found| found.identification)
                .map_err(|error| refusal(&error))
        })
        .collect();
    let blank = |estimator: &Estimator| Outcome {
        kind: case.kind,
        estimator: estimator.name(),
        seed: case.seed,
        joints: case.joints,
        fault: format!("{:?}", case.fault),
        verdict: "refused",
        codes: Vec::new(),
        coverage: 0.0,
        over_promise: f64::INFINITY,
        over_truth: f64::INFINITY,
        errors: Vec::new(),
    };
    let first = match &identified[0] {
        Ok(first) => first,
        Err(codes) => {
            let refused = estimators.iter().map(|estimator| Outcome {
                codes: codes.clone(),
                ..blank(estimator)
            });
            return refused.collect();
        }
    };
    if let Some(folder) = keep {
        let name = format!("{}-{}", case.kind.name().replace(' ', "-"), case.seed);
        let write = |end: &str, text: serde_json::Result<String>| {
            let text = text.expect("values are JSON");
            let path = folder.join(format!("{name}{end}.json"));
            std::fs::write(path, text).expect("the folder takes files");
        };
        write("", serde_json::to_string(first));
        write("-truth", serde_json::to_string(&case.truth));
    }
    let held_out = held_out(case, first);
    (estimators.iter().enumerate())
        .map(|(index, estimator)| {
            let result = &first.results[index];
            let mut outcome = blank(estimator);
            outcome.verdict = result.verdict.word();
            outcome.codes = (first.findings.iter().chain(&result.warnings))
                .filter(|finding| finding.severity > Severity::Info)
                .map(|finding| finding.code.clone())
                .collect();
            let all = identified
                .iter()
                .flatten()
                .map(|found| &found.results[index]);
            outcome.coverage = coverage(case, all.clone());
            outcome.errors = errors(case, all);
            if let Some((promise, truth)) = held_out.as_ref().and_then(|all| all.get(index)) {
                outcome.over_promise = *promise;
                outcome.over_truth = *truth;
            }
            outcome
        })
        .collect()
}

/// Returns the codes of a refusal.
fn refusal(error: &IdentifyError) -> Vec<String> {
    match error {
        IdentifyError::Refused(refusal) => refusal
            .0
            .iter()
            .map(|finding| finding.code.clone())
            .collect(),
        other => vec![other.to_string()],
    }
}

/// Returns the true value of each parameter of a result; `None` for the description of another robot. A result with a
/// law of the robot that the user's model lacks has the values of the robot. A law that the robot lacks is zero.
fn truth(case: &Case, result: &EstimateResult) -> Option<Vec<f64>> {
    let of_user = case.truth.as_ref()?;
    let of = |model: &Model, values: &[f64], name: &str| {
        model.index_of(name).ok().map(|index| values[index])
    };
    let names = || {
        result
            .parameters
            .iter()
            .map(|parameter| parameter.name.as_str())
    };
    let of_robot = |name: &str| of(&case.plant, &case.of_robot, name);
    let of_model = |name: &str| of(&case.model, of_user, name);
    let is_richer = names().any(|name| of_model(name).is_none() && of_robot(name).is_some());
    let value = |name: &str| {
        let first = if is_richer { of_robot(name) } else { None };
        first.or_else(|| of_model(name)).unwrap_or(0.0)
    };
    Some(names().map(value).collect())
}

/// Returns the part of the intervals that contain the truth. A parameter without an interval counts as
/// missed.
fn coverage<'r>(case: &Case, results: impl Iterator<Item = &'r EstimateResult>) -> f64 {
    let (mut hit, mut all) = (0.0, 0.0);
    for result in results {
        let Some(truth) = truth(case, result) else {
            return 0.0;
        };
        for (parameter, truth) in result.parameters.iter().zip(&truth) {
            all += 1.0;
            let contains = |[low, high]: [f64; 2]| low <= *truth && *truth <= high;
            hit += f64::from(u8::from(parameter.ci95.is_some_and(contains)));
        }
    }
    hit / f64::max(all, 1.0)
}

/// Returns the errors of each parameter in its standard errors.
fn errors<'r>(
    case: &Case,
    results: impl Iterator<Item = &'r EstimateResult>,
) -> Vec<(String, Vec<f64>)> {
    let mut errors: Vec<(String, Vec<f64>)> = Vec::new();
    for result in results {
        let Some(truth) = truth(case, result) else {
            return Vec::new();
        };
        for (parameter, truth) in result.parameters.iter().zip(&truth) {
            let standard = parameter.standard_error.unwrap_or(f64::NAN);
            let value = parameter.value.unwrap_or(f64::NAN);
            let error = (value - truth) / standard;
            match errors.iter_mut().find(|(name, _)| *name == parameter.name) {
                Some((_, all)) => all.push(error),
                None => errors.push((parameter.name.clone(), vec![error])),
            }
        }
    }
    errors
}

/// Predicts another log. Returns the largest error over its promise for each result, and the error of
/// the torques over that of the true robot without the fault.
fn held_out(case: &Case, identified: &Identification) -> Option<Vec<(f64, f64)>> {
    let session = Session::read_in("experiment.toml", &case.text, &[], PathBuf::new()).ok()?;
    let parameters = Parameters::from(identified.clone());
    let found = with_source(&case.log(HELD_OUT)?, |source| {
        session.validate_with(&parameters, &mut [vec![source]], &mut Unheard)
    });
    let found = predictions(found.ok()?)?;
    let names = case.plant.parameters().iter().map(|p| p.name.clone());
    let mut robot = parameters.sets[0].clone();
    robot.values = names.zip(case.of_robot.iter().copied()).collect();
    let chosen = ChosenFor {
        position_cutoff_hz: Some(identified.settings.position_cutoff_hz),
        ..ChosenFor::default()
    };
    let truth = with_source(&case.explained_log(HELD_OUT)?, |source| {
        let sources = &mut [vec![source]];
        validate(
            &case.robot,
            &case.plant,
            &[robot],
            &chosen,
            sources,
            &mut Unheard,
        )
    });
    let truth = predictions(truth.ok()?)?;
    let truth = truth.first()?;
    let each = found.iter().take(parameters.sets.len());
    Some(
        each.map(|proofs| (over_promise(proofs), over_truth(proofs, truth)))
            .collect(),
    )
}

/// Returns the prediction errors of each parameter set on a log.
fn predictions(validated: Validated) -> Option<Vec<Vec<JointProof>>> {
    let run = validated.validation.runs.into_iter().next()?;
    Some(run.sets.into_iter().map(|set| set.predictions).collect())
}

fn over_promise(proofs: &[JointProof]) -> f64 {
    let ratios = proofs.iter().flat_map(JointProof::quantities);
    let worst = ratios.map(|quantity| quantity.ratio.unwrap_or(f64::INFINITY));
    if proofs.is_empty() {
        f64::INFINITY
    } else {
        worst.fold(0.0, f64::max)
    }
}

fn over_truth(proofs: &[JointProof], truth: &[JointProof]) -> f64 {
    if proofs.len() != truth.len() || proofs.is_empty() {
        return f64::INFINITY;
    }
    let ratios = proofs.iter().zip(truth);
    let squares: f64 = ratios
        .map(|(proof, truth)| (proof.torque_error_nm / truth.torque_error_nm).powi(2))
        .sum();
    (squares / proofs.len() as f64).sqrt()
}
