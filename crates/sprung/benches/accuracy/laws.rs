//! The laws that cross-validation adds to the demo's model, on logs with known laws.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_method::estimate::identify;
use sprung_method::unknowns::UnknownResult;
use sprung_model::Model;
use sprung_robot::{Estimator, Experiment, Laws};

use crate::in_memory::with_source;

/// Returns the experiment with the laws that hold-out adds.
pub(crate) fn with_found_laws(experiment: &Experiment, estimator: Estimator) -> Experiment {
    let mut experiment = experiment.clone();
    experiment.identify.estimator = vec![estimator];
    experiment.identify.laws = Laws::Auto;
    experiment
}

/// Prints the laws that cross-validation adds to the model, log by log, and the counts of each law.
pub(crate) fn print(what: &str, experiment: &Experiment, logs: &[Vec<u8>]) {
    let experiment = with_found_laws(experiment, Estimator::LeastSquares);
    let model = Model::new(&experiment).expect("the experiment has a model");
    let found: Vec<Vec<UnknownResult>> = (logs.par_iter())
        .map(|log| {
            with_source(log, |source| {
                let found = identify(&experiment, &model, &mut [source], &mut Unheard);
                found.expect("the log is right").identification.unknowns
            })
        })
        .collect();
    println!("\nlaws by hold-out, {what}, {} logs", logs.len());
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (log, unknowns) in found.iter().enumerate() {
        let mut words = Vec::new();
        for unknown in unknowns {
            let Some(law) = &unknown.law else { continue };
            let name = format!("{} {}", unknown.place, law.words());
            let rivals: Vec<&str> = (unknown.competing.iter())
                .map(|rival| rival.id.as_str())
                .collect();
            words.push(format!(
                "{name} ({}, squares fall by {:.1} %{})",
                unknown.status.word(),
                100.0 * unknown.effect,
                match &rivals[..] {
                    [] => String::new(),
                    others => format!(", or {}", others.join(", ")),
                }
            ));
            *counts.entry(name).or_default() += 1;
        }
        println!("    {log:4}: {}", words.join("; "));
    }
    for (law, count) in counts {
        println!("    {law}: {count} of {}", logs.len());
    }
}
