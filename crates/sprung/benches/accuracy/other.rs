//! The case of a plant with laws that the model lacks, fitted without these laws, with them, and with the laws that
//! cross-validation adds.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{EstimateResult, identify};
use sprung_method::unknowns::UnknownResult;
use sprung_model::Model;
use sprung_robot::{Estimator, Experiment, Laws, SpringTerm};

use crate::figures::{Runs, median};
use crate::in_memory::with_source;
use crate::laws::with_found_laws;
use crate::logs::{Demo, Other, with_its_laws};
use crate::{Arguments, Trial, findings, header, methods, row, truth};

/// The laws of the plant that the model lacks.
const LAWS: [(&str, &str, &str); 2] = [
    ("Stribeck friction", "motor_friction", "stribeck"),
    ("cubic spring", "spring", "cubic"),
];

/// Results on one log.
struct OnLog {
    trial: Trial,
    /// Laws by hold-out of each method.
    unknowns: Vec<Vec<UnknownResult>>,
}

/// Runs the case, and prints its tables.
pub(crate) fn other_plant(demo: &Demo, arguments: &Arguments) {
    let other = Other::new(demo);
    let ways = arguments.chosen(ways(demo));
    let seeds = arguments.seeds.clone().into_par_iter();
    let logs: Vec<OnLog> = seeds
        .map(|seed| {
            let settings = demo.settings(seed);
            let log = other.log(&settings);
            let found: Vec<_> = ways.iter().map(|(_, way)| identified(way, &log)).collect();
            let (results, unknowns) = found.into_iter().unzip();
            OnLog {
                trial: Trial {
                    results,
                    bound: other.bound(&settings, &log),
                },
                unknowns,
            }
        })
        .collect();
    println!(
        "\ncubic springs (20 % at most), Stribeck friction, torque 1 ms late, 16384 counts, {} logs; \
         bound with the true laws, with unknown Stribeck velocities and delays",
        logs.len()
    );
    header();
    for (index, (name, way)) in ways.iter().enumerate() {
        let has_laws = knows_laws(way);
        let runs = Runs {
            truth: if has_laws { other.truth() } else { truth(demo) },
            results: (logs.iter().map(|log| &log.trial.results[index])).collect(),
            cross_check: None,
            bounds: (logs.iter())
                .map(|log| log.trial.bound.as_deref().filter(|_| has_laws))
                .collect(),
        };
        row("other laws", name, &runs, arguments.parameters);
    }
    for (index, (name, _)) in ways.iter().enumerate() {
        named(name, logs.iter().map(|log| &log.unknowns[index][..]));
        let results = || logs.iter().map(|log| &log.trial.results[index]);
        delays(name, results());
        velocities(name, results());
    }
    let trials: Vec<Trial> = logs.into_iter().map(|log| log.trial).collect();
    findings(&trials, &ways);
}

fn ways(demo: &Demo) -> Vec<(&'static str, Experiment)> {
    let mut declared = demo.experiment.clone();
    declared.identify.laws = Laws::Declared;
    let mut ways = methods(&declared);
    let mut richer = with_its_laws();
    richer.identify.laws = Laws::Declared;
    richer.identify.estimator = vec![Estimator::PredictionError];
    ways.push(("pred. error with its laws", richer));
    for (name, estimator) in [
        ("linear, laws = auto", Estimator::LeastSquares),
        ("pred. error, laws = auto", Estimator::PredictionError),
    ] {
        ways.push((name, with_found_laws(&demo.experiment, estimator)));
    }
    ways
}

/// Returns whether the model has the plant's laws or may get them.
fn knows_laws(way: &Experiment) -> bool {
    let mut joints = way.robot.joint.iter();
    way.identify.laws == Laws::Auto
        || joints.any(|joint| joint.spring_terms().contains(&SpringTerm::Cubic))
}

fn identified(way: &Experiment, log: &[u8]) -> (EstimateResult, Vec<UnknownResult>) {
    let model = Model::new(way).expect("the experiment has a model");
    with_source(log, |source| {
        let found = identify(way, &model, &mut [source], &mut Unheard);
        let mut found = found.expect("the log is right").identification;
        (found.results.remove(0), found.unknowns)
    })
}

/// Prints the number of logs in which cross-validation adds each law to both joints, and the counts
/// of other laws.
fn named<'l>(name: &str, found: impl Iterator<Item = &'l [UnknownResult]>) {
    let mut counts = [0; LAWS.len()];
    let mut others: BTreeMap<String, usize> = BTreeMap::new();
    let mut logs = 0;
    for unknowns in found {
        logs += 1;
        let made = || {
            let used = unknowns.iter();
            used.filter_map(|unknown| Some((&unknown.place, unknown.used_law()?)))
        };
        for (count, (_, of, law)) in counts.iter_mut().zip(LAWS) {
            let joints = made().filter(|(_, added)| added.of == of && added.law == law);
            *count += usize::from(joints.count() == 2);
        }
        let is_known =
            |of: &str, law: &str| LAWS.iter().any(|known| (known.1, known.2) == (of, law));
        for (joint, law) in made().filter(|(_, law)| !is_known(&law.of, &law.law)) {
            *others
                .entry(format!("{joint} {}", law.words()))
                .or_default() += 1;
        }
    }
    if counts.iter().sum::<usize>() + others.len() == 0 {
        return;
    }
    let words: Vec<String> = (LAWS.iter().zip(counts))
        .map(|((law, ..), count)| format!("{law} {count}"))
        .collect();
    println!(
        "    {name}, laws named in both joints, of {logs} logs: {}; other laws: {others:?}",
        words.join(", ")
    );
}

/// Prints the number of results with a delay of all torques, and the median delay.
fn delays<'r>(name: &str, results: impl Iterator<Item = &'r EstimateResult>) {
    let found = results.filter_map(|result| result.refined()?.torques_delay_s);
    let found: Vec<f64> = found.map(|(delay, _)| delay).collect();
    if !found.is_empty() {
        let count = found.len();
        let delay = 1e3 * median(found);
        println!("    {name}, delay of all torques: {delay:.3} ms in the median of {count} logs");
    }
}

/// Prints the range of the Stribeck velocities of each joint.
fn velocities<'r>(name: &str, results: impl Iterator<Item = &'r EstimateResult>) {
    let mut ranges: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for (joint, velocity) in results.flat_map(|result| result.stribeck_velocity.iter()) {
        let (least, most) = ranges
            .entry(joint.to_owned())
            .or_insert((f64::INFINITY, 0.0));
        (*least, *most) = (least.min(velocity), most.max(velocity));
    }
    for (joint, (least, most)) in ranges {
        println!("    {name}, Stribeck velocity of {joint}: {least:.4} to {most:.4} rad/s");
    }
}
