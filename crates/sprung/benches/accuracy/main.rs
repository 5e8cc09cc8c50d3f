//! Measures the accuracy of the estimators on logs with known parameters.
//!
//! `cargo bench -p sprung --bench accuracy` prints the tables. Arguments after `--` change their
//! extent:
//!
//! - `--seeds 10`, `--first 0`: number of logs per case, and the first seed.
//! - `--cases clean,motor,link,other,mujoco`: cases to run. There are also
//!   `robots` (random parameters), `starts` (searches from nominal values) and `laws` (laws by
//!   hold-out).
//! - `--counts 16384,4096`: resolutions of the encoders.
//! - `--methods prediction,linear`: only methods whose names contain one of these words.
//! - `--lengths 10,60,300,3600`: instead of the tables, coverage, width of the intervals and
//!   verdicts of least squares for logs of these lengths, s; from 300 s on, three seeds.
//! - `--parameters`: adds a row for each parameter.
//! - `--cross-checks`: adds rows for the cross-checks of the linear stage.
//! - `--mujoco FOLDER`: folder with the logs of `benches/peers/two_joints_mujoco.py`.
#![expect(clippy::print_stdout, reason = "a benchmark says what it measured")]

mod figures;
#[path = "../../tests/twin/in_memory.rs"]
mod in_memory;
mod laws;
mod lengths;
mod logs;
mod other;
mod robots;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use figures::{Runs, median};
use in_memory::with_source;
use logs::{Demo, Other};
use rayon::prelude::*;
use robots::Search;
use sprung_base::finding::Severity;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{
    EstimateResult, KnownNoise, KnownTruth, identify, information_bound,
};
use sprung_model::Model;
use sprung_robot::{Cutoff, DiscretizationName, Estimator, Experiment, Simulate, Weights};

/// Names of the cases, and disturbances of motors and of links, N·m rms.
const CASES: [(&str, [f64; 2], [f64; 2]); 3] = [
    ("clean", [0.0, 0.0], [0.0, 0.0]),
    ("motor", [0.05, 0.01], [0.0, 0.0]),
    ("link", [0.0, 0.0], [0.01, 0.01]),
];

struct Arguments {
    seeds: std::ops::Range<u64>,
    cases: Vec<String>,
    counts: Vec<u32>,
    methods: Vec<String>,
    lengths: Vec<f64>,
    parameters: bool,
    cross_checks: bool,
    mujoco: PathBuf,
}

impl Arguments {
    /// Reads the command line.
    ///
    /// # Panics
    ///
    /// If an argument is unknown or has no valid value.
    fn new() -> Self {
        let (mut first, mut seeds) = (0, 10);
        let mut found = Self {
            seeds: 0..0,
            cases: ["clean", "motor", "link", "other", "mujoco"]
                .map(str::to_owned)
                .to_vec(),
            counts: vec![16384, 4096],
            methods: Vec::new(),
            lengths: Vec::new(),
            parameters: false,
            cross_checks: false,
            mujoco: PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/mujoco")),
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().expect("an argument lacks its value");
            match word.as_str() {
                // Cargo adds this argument.
                "--bench" => {}
                "--parameters" => found.parameters = true,
                "--cross-checks" => found.cross_checks = true,
                "--seeds" => seeds = value().parse().expect("--seeds is a number"),
                "--first" => first = value().parse().expect("--first is a number"),
                "--cases" => found.cases = value().split(',').map(str::to_owned).collect(),
                "--methods" => found.methods = value().split(',').map(str::to_owned).collect(),
                "--lengths" => {
                    let lengths = value();
                    let lengths = lengths.split(',').map(str::parse);
                    found.lengths = lengths
                        .collect::<Result<_, _>>()
                        .expect("--lengths are numbers");
                }
                "--counts" => {
                    let counts = value();
                    let counts = counts.split(',').map(str::parse);
                    found.counts = counts
                        .collect::<Result<_, _>>()
                        .expect("--counts are numbers");
                }
                "--mujoco" => found.mujoco = PathBuf::from(value()),
                other => panic!("no argument {other}"),
            }
        }
        found.seeds = first..first + seeds;
        found
    }

    /// Returns the selected methods.
    fn chosen<'m>(&self, mut all: Vec<(&'m str, Experiment)>) -> Vec<(&'m str, Experiment)> {
        let wanted = |name: &str| self.methods.iter().any(|word| name.contains(word));
        all.retain(|(name, _)| self.methods.is_empty() || wanted(name));
        all
    }

    fn wants(&self, case: &str) -> bool {
        self.cases.iter().any(|wanted| wanted == case)
    }
}

/// Returns the methods, each with its experiment.
fn methods(experiment: &Experiment) -> Vec<(&'static str, Experiment)> {
    let with = |estimator, change: &dyn Fn(&mut Experiment)| {
        let mut experiment = experiment.clone();
        experiment.identify.estimator = vec![estimator];
        change(&mut experiment);
        experiment
    };
    let paper = |experiment: &mut Experiment| {
        let settings = &mut experiment.identify;
        settings.weights = Weights::None;
        settings.discretization = DiscretizationName::Paper;
        settings.position_cutoff_hz = Cutoff::Fixed(10.0);
    };
    vec![
        (
            "paper's least squares",
            with(Estimator::LeastSquares, &paper),
        ),
        ("linear stage", with(Estimator::LeastSquares, &|_| ())),
        (
            "prediction error",
            with(Estimator::PredictionError, &|_| ()),
        ),
    ]
}

fn result_of(experiment: &Experiment, log: &[u8]) -> EstimateResult {
    let model = Model::new(experiment).expect("the experiment has a model");
    with_source(log, |source| {
        let found = identify(experiment, &model, &mut [source], &mut Unheard);
        found
            .expect("the log is right")
            .identification
            .results
            .remove(0)
    })
}

/// The results of each method on one log, and the Cramér-Rao bound.
struct Trial {
    results: Vec<EstimateResult>,
    bound: Option<Vec<f64>>,
}

fn bound(demo: &Demo, settings: &Simulate, log: &[u8]) -> Option<Vec<f64>> {
    let noise = KnownNoise::from(settings);
    with_source(log, |source| {
        let truth = KnownTruth {
            theta: &demo.truth,
            noise: &noise,
            delays: &BTreeMap::new(),
        };
        let bound = information_bound(&demo.experiment, &demo.model, truth, &mut [source]);
        bound
            .expect("the log is right")
            .map(|bound| bound.standard_errors())
    })
}

/// Runs each method on a log of the demo's twin.
fn trial(demo: &Demo, settings: &Simulate, methods: &[(&str, Experiment)]) -> Trial {
    let log = demo.log(settings);
    Trial {
        bound: bound(demo, settings, &log),
        ..Trial::of(&log, methods)
    }
}

impl Trial {
    /// Runs each method on a log.
    fn of(log: &[u8], methods: &[(&str, Experiment)]) -> Self {
        let results = methods
            .iter()
            .map(|(_, experiment)| result_of(experiment, log));
        Self {
            results: results.collect(),
            bound: None,
        }
    }
}

fn header() {
    println!(
        "{:24} {:>9} {:>9} {:22} {:>9} {:>8} {:>8} {:>7} {:>7}",
        "", "median %", "worst %", "", "inside %", "rms/CRB", "largest", "failed", "s"
    );
}

/// Prints and notes the figures of one method; root mean squares are over the runs.
///
/// - `case`: the logs, for the documentation; nothing is noted if it is empty.
fn row(case: &str, name: &str, runs: &Runs<'_>, parameters: bool) {
    let all = runs.parameters();
    let worst = all.iter().max_by(|a, b| a.rms.total_cmp(&b.rms));
    let Some(worst) = worst else { return };
    let ratios: Vec<f64> = all.iter().filter_map(|p| Some(p.rms / p.bound?)).collect();
    let largest = ratios.iter().copied().fold(f64::NAN, f64::max);
    let ratio = median(ratios);
    let or_dash = |x: f64| {
        if x.is_nan() {
            "-".to_owned()
        } else {
            format!("{x:.2}")
        }
    };
    println!(
        "{name:24} {:9.3} {:9.2} {:22} {:>9} {:>8} {:>8} {:7} {:7.2}",
        100.0 * runs.median_error(),
        100.0 * worst.rms,
        worst.name,
        or_dash(100.0 * all.iter().map(|p| p.inside).sum::<f64>() / all.len() as f64),
        or_dash(ratio),
        or_dash(largest),
        runs.failed(),
        runs.seconds(),
    );
    if !case.is_empty() {
        runs.note(case, name, ratio);
    }
    if parameters {
        for p in all {
            let bound = p.bound.unwrap_or(f64::NAN);
            println!(
                "    {:22} mean {:9.3} % rms {:8.3} % standard error {:8.3} % bound {:8.3} % \
                 rms/bound {:>5} inside {:4.0} %",
                p.name,
                100.0 * p.mean,
                100.0 * p.rms,
                100.0 * p.standard_error,
                100.0 * bound,
                or_dash(p.rms / bound),
                100.0 * p.inside
            );
        }
    }
}

fn truth(demo: &Demo) -> Vec<(String, f64)> {
    let names = demo.model.parameters().iter().map(|p| p.name.clone());
    names.zip(demo.truth.iter().copied()).collect()
}

fn print(
    case: &str,
    demo: &Demo,
    trials: &[Trial],
    methods: &[(&str, Experiment)],
    arguments: &Arguments,
) {
    for (index, (name, _)) in methods.iter().enumerate() {
        let mut runs = Runs {
            truth: truth(demo),
            results: trials.iter().map(|trial| &trial.results[index]).collect(),
            cross_check: None,
            bounds: trials.iter().map(|trial| trial.bound.as_deref()).collect(),
        };
        row(case, name, &runs, arguments.parameters);
        let first = runs.results.first().filter(|_| arguments.cross_checks);
        for check in first.iter().flat_map(|result| &result.cross_checks) {
            runs.cross_check = Some(&check.method);
            row(
                "",
                &format!("  {}", check.method),
                &runs,
                arguments.parameters,
            );
        }
    }
}

/// Prints the number of runs with each verdict, and with each finding above a note.
fn findings(trials: &[Trial], methods: &[(&str, Experiment)]) {
    for (index, (name, _)) in methods.iter().enumerate() {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for trial in trials {
            let result = &trial.results[index];
            *counts
                .entry(format!("verdict {:?}", result.verdict))
                .or_default() += 1;
            let mut codes: Vec<&str> = (result.warnings.iter())
                .filter(|finding| finding.severity > Severity::Info)
                .map(|finding| finding.code.as_str())
                .collect();
            codes.sort_unstable();
            codes.dedup();
            for code in codes {
                *counts.entry(code.to_owned()).or_default() += 1;
            }
        }
        let words: Vec<String> = counts
            .iter()
            .map(|(what, n)| format!("{what} {n}"))
            .collect();
        println!("    {name}, of {} runs: {}", trials.len(), words.join(", "));
    }
    refinements(trials, methods);
}

/// Prints the held-out residuals of the refinements, and why the first unused refinement was
/// rejected.
fn refinements(trials: &[Trial], methods: &[(&str, Experiment)]) {
    for (index, (name, _)) in methods.iter().enumerate() {
        let refined = trials.iter().filter_map(|trial| {
            let refinement = trial.results[index].refinement.as_ref()?;
            let held = refinement.held_out_residual.as_ref()?;
            Some(held.refined / held.linear)
        });
        let ratios: Vec<f64> = refined.collect();
        if !ratios.is_empty() {
            let (least, most) = (ratios.iter())
                .fold((f64::INFINITY, 0.0_f64), |(least, most), r| {
                    (least.min(*r), most.max(*r))
                });
            println!(
                "    {name}, residual of held-out torque over that of least squares: {least:.2} to {most:.2}"
            );
        }
        let failed = trials.iter().enumerate().find_map(|(log, trial)| {
            let mut warnings = trial.results[index].warnings.iter();
            let failed = warnings.find(|warning| warning.code == "refinement-failed")?;
            Some((log, failed))
        });
        if let Some((log, failed)) = failed {
            println!("    {name}, first failure, log {log}: {}", failed.text);
        }
    }
}

/// Runs the cases with the demo's twin, where estimation and simulation use the same model.
fn own_model(demo: &Demo, arguments: &Arguments) {
    let usual = arguments.chosen(methods(&demo.experiment));
    let mut exact = demo.experiment.clone();
    exact.identify.estimator = vec![Estimator::PredictionError];
    if let Some(log) = &mut exact.log {
        log.motor_torque_exact = true;
    }
    let exact = arguments.chosen(vec![("pred. error, torque exact", exact)]);
    for &counts in &arguments.counts {
        for (case, motor, link) in CASES.iter().filter(|case| arguments.wants(case.0)) {
            let settings = |seed| {
                let mut settings = demo.settings(seed);
                settings.link_encoder_counts_per_turn = vec![counts; 2];
                settings.motor_encoder_counts_per_turn = vec![counts; 2];
                settings.torque_disturbance_nm = motor.to_vec();
                settings.link_torque_disturbance_nm = link.to_vec();
                settings
            };
            let seeds = arguments.seeds.clone().into_par_iter();
            let trials: Vec<Trial> = seeds
                .clone()
                .map(|seed| trial(demo, &settings(seed), &usual))
                .collect();
            println!("\n{counts} counts, {case}, {} logs", trials.len());
            header();
            let case = format!("{case}, {counts} counts");
            print(&case, demo, &trials, &usual, arguments);
            refinements(&trials, &usual);
            if case.starts_with("clean") && !exact.is_empty() {
                let without_noise = |seed| {
                    let mut settings = settings(seed);
                    settings.torque_noise_nm.clear();
                    trial(demo, &settings, &exact)
                };
                let trials: Vec<Trial> = seeds.map(without_noise).collect();
                print(&case, demo, &trials, &exact, arguments);
            }
        }
    }
}

/// Returns the logs of MuJoCo, sorted; empty if there are none.
fn mujoco_files(arguments: &Arguments) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(&arguments.mujoco).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    files.sort();
    files
}

/// Runs the case of MuJoCo's logs, with dry friction as a constraint and springs as tendons.
fn mujoco(demo: &Demo, arguments: &Arguments) {
    let folder = arguments.mujoco.display();
    println!("\nMuJoCo, dry friction, tendons for springs, logs of {folder}");
    let files = mujoco_files(arguments);
    if files.is_empty() {
        println!(
            "skipped: no logs; pip install -r benches/peers/requirements-mujoco.txt and \
             python benches/peers/two_joints_mujoco.py {folder} make them"
        );
        return;
    }
    let ways = arguments.chosen(methods(&demo.experiment));
    let trials: Vec<Trial> = (files.par_iter())
        .map(|file| {
            let log = std::fs::read(file).expect("the log can be read");
            Trial::of(&log, &ways)
        })
        .collect();
    header();
    print("MuJoCo", demo, &trials, &ways, arguments);
    findings(&trials, &ways);
}

/// Prints the laws that cross-validation adds on logs of the twin, of the other plant and of
/// MuJoCo.
fn laws_by_hold_out(demo: &Demo, arguments: &Arguments) {
    for (case, motor, link) in CASES {
        let log = |seed| {
            let mut settings = demo.settings(seed);
            settings.torque_disturbance_nm = motor.to_vec();
            settings.link_torque_disturbance_nm = link.to_vec();
            demo.log(&settings)
        };
        let logs: Vec<Vec<u8>> = arguments.seeds.clone().map(log).collect();
        laws::print(case, &demo.experiment, &logs);
    }
    let other = Other::new(demo);
    let logs: Vec<Vec<u8>> = (arguments.seeds.clone())
        .map(|seed| other.log(&demo.settings(seed)))
        .collect();
    laws::print("the other plant", &demo.experiment, &logs);
    let logs: Vec<Vec<u8>> = (mujoco_files(arguments).iter())
        .map(|file| std::fs::read(file).expect("the log can be read"))
        .collect();
    laws::print("MuJoCo", &demo.experiment, &logs);
}

/// Prints the outcome of one search for each seed, on logs of 10 s.
fn searches(what: &str, arguments: &Arguments, search: impl Fn(u64, f64) -> Search + Sync) {
    println!("\n{what}");
    let seeds = arguments.seeds.clone().into_par_iter();
    let found: Vec<(u64, Search)> = seeds.map(|seed| (seed, search(seed, 10.0))).collect();
    for (seed, search) in &found {
        let (name, away) = search.worst();
        let failure = search.failure.as_deref().unwrap_or("converged");
        println!(
            "    {seed:4}: {:2} runs, {name} is {away:.2} standard errors away; {failure}",
            search.runs
        );
    }
    let all: Vec<f64> = (found.iter())
        .flat_map(|(_, search)| search.away.iter().map(|(_, away)| *away))
        .collect();
    println!(
        "{} of {} refinements failed; of {} parameters {} are more than 1 standard error away, {} more than 4",
        found
            .iter()
            .filter(|(_, search)| search.failure.is_some())
            .count(),
        found.len(),
        all.len(),
        all.iter().filter(|away| **away > 1.0).count(),
        all.iter().filter(|away| **away > 4.0).count(),
    );
}

fn main() {
    // `cargo test --all-targets` starts benchmarks too; tables are for `cargo bench`.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("cargo bench -p sprung --bench accuracy prints the tables");
        return;
    }
    let arguments = Arguments::new();
    let demo = Demo::new();
    if !arguments.lengths.is_empty() {
        lengths::lengths(&demo, &arguments);
        return;
    }
    let start = Instant::now();
    println!(
        "median: |relative error| over parameters and logs; worst: largest rms of a parameter;\n\
         inside: 95 % intervals that hold the truth; rms/CRB: median and largest over parameters,\n\
         against the Cramér-Rao bound; failed: refinements that stood back; s: median elapsed"
    );
    own_model(&demo, &arguments);
    if arguments.wants("robots") {
        searches(
            "random robots, distances from the truth",
            &arguments,
            robots::random,
        );
    }
    if arguments.wants("starts") {
        let what = "starts from nominal values, distances from the start by least squares";
        searches(what, &arguments, robots::from_nominal_values);
    }
    if arguments.wants("laws") {
        laws_by_hold_out(&demo, &arguments);
    }
    if arguments.wants("other") {
        other::other_plant(&demo, &arguments);
    }
    if arguments.wants("mujoco") {
        mujoco(&demo, &arguments);
    }
    println!("\n{:.0} s together", start.elapsed().as_secs_f64());
}
