//! The laws that cross-validation adds to the demo's model, on logs with known laws.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sprung_base::progress::Unheard;
use sprung_method::estimate::{LawsByHoldOut, identify};
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
    let found: Vec<Option<LawsByHoldOut>> = (logs.par_iter())
        .map(|log| {
            with_source(log, |source| {
                let found = identify(&experiment, &model, &mut [source], &mut Unheard);
                found.expect("the log is right").identification.laws
            })
        })
        .collect();
    println!("\nlaws by hold-out, {what}, {} logs", logs.len());
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (log, laws) in found.iter().enumerate() {
        let Some(laws) = laws else {
            println!("    {log:4}: too short");
            continue;
        };
        let mut words = vec![format!("{:.2} %", 100.0 * laws.held_out)];
        for rung in &laws.rungs {
            let name = format!("{} {}", rung.joint, rung.words());
            words.push(format!(
                "{name} (gain {:.1} ± {:.1} %, {:.2} %{}{})",
                100.0 * rung.gain,
                100.0 * rung.gain_scatter,
                100.0 * rung.held_out,
                if rung.made { "" } else { ", not made" },
                match &rung.not_told_apart_from[..] {
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
