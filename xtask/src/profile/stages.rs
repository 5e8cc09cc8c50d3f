//! Stages of sprung, and the share of the samples of a profile in each.

/// A stage: functions with everything that they call.
pub(super) struct Stage {
    name: &'static str,
    // Source file, or the folder of several.
    file: &'static str,
    // Part of the functions' names; empty for all functions of the file.
    function: &'static str,
}

const fn stage(name: &'static str, file: &'static str, function: &'static str) -> Stage {
    Stage {
        name,
        file,
        function,
    }
}

/// All stages in the order of a run. Stages call others, so their shares overlap.
const STAGES: &[Stage] = &[
    stage("read experiment", "sprung-robot/src/read.rs", ""),
    stage("read log", "sprung-log/src/reader.rs", ""),
    stage("filter positions", "preprocess/smooth.rs", ""),
    stage("form regressor", "regression/batch.rs", ""),
    stage("filter and weigh rows", "regression/reduction.rs", "take"),
    stage("factor rows (QR)", "regression/triangle.rs", ""),
    stage("weights", "prepare/weights.rs", ""),
    stage("sweep of cut-offs", "prepare/sweep.rs", ""),
    stage("unknowns", "unknowns/settle.rs", ""),
    stage("pass", "regression/pass.rs", "read_through"),
    stage("check", "check/examine.rs", ""),
    stage("fit", "estimate/steps/fit.rs", ""),
    stage("cross-checks", "least_squares/cross_checks.rs", ""),
    stage("hold-out", "fit/hold_out.rs", ""),
    stage("likely delays", "prediction_error/estimated_delays.rs", ""),
    stage("measurements", "prediction_error/measurements/", ""),
    stage("filter runs", "prediction_error/filter/run.rs", ""),
    stage("replay", "prediction_error/filter/replay.rs", ""),
    stage("dynamics", "prediction_error/dynamics/", ""),
    stage("noise bias", "prediction_error/noisy_torque.rs", ""),
    stage("level search", "prediction_error/level_search.rs", ""),
    stage("likelihood, forward", "likelihood/forward.rs", ""),
    stage("likelihood, backward", "likelihood/backward.rs", ""),
    stage("score tests", "prediction_error/missing_laws.rs", ""),
    stage("refinement hold-out", "prediction_error/hold_out.rs", ""),
    stage("refinement covariance", "prediction_error/finish.rs", ""),
    stage("results and report", "sprung-cli/src/results.rs", ""),
];

/// Below this share a stage is left out.
const SHOWN_SHARE: f64 = 0.005;

/// A function at an address of a program, and the source file that it is from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Function {
    pub(super) name: String,
    pub(super) file: String,
}

impl Stage {
    fn contains(&self, function: &Function) -> bool {
        function.file.contains(self.file) && function.name.contains(self.function)
    }
}

/// Returns the names of the stages with the shares of samples in them, and at the end the share of
/// the samples whose callers are not known.
///
/// - `samples`: the functions of each call stack; a known stack ends in `main`.
pub(super) fn shares(samples: &[Vec<&Function>]) -> Vec<(&'static str, f64)> {
    let count = samples.len().max(1) as f64;
    let share = |is_in: &dyn Fn(&[&Function]) -> bool| {
        samples.iter().filter(|sample| is_in(sample)).count() as f64 / count
    };
    let of_stage = |stage: &Stage| share(&|sample| sample.iter().any(|f| stage.contains(f)));
    let mut shares: Vec<_> = (STAGES.iter())
        .map(|stage| (stage.name, of_stage(stage)))
        .collect();
    let is_ours = |function: &&Function| function.file.contains("/crates/sprung");
    let unknown = share(&|sample| !sample.iter().any(is_ours));
    shares.push(("caller unknown", unknown));
    shares.retain(|(_, share)| *share >= SHOWN_SHARE);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_counts_once_in_each_stage_that_it_is_in() {
        let of = |name: &str, file: &str| Function {
            name: name.to_owned(),
            file: format!("/w/crates/sprung-method/src/{file}"),
        };
        let push = of("push", "preprocess/smooth.rs");
        let again = of("differentiate", "preprocess/smooth.rs");
        let pass = of(
            "sprung::regression::pass::read_through",
            "regression/pass.rs",
        );
        let other = of("reduce_blocks", "regression/pass.rs");
        let foreign = Function {
            name: "gemm".to_owned(),
            file: "??".to_owned(),
        };
        let samples = [
            vec![&again, &push, &pass],
            vec![&push, &other],
            vec![&foreign],
            vec![&other],
        ];
        let found = shares(&samples);
        let expected = [
            ("filter positions", 0.5),
            ("pass", 0.25),
            ("caller unknown", 0.25),
        ];
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert_eq!(found.0, expected.0);
            assert!((found.1 - expected.1).abs() < 1e-12);
        }
    }
}
