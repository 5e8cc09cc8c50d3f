//! Tests of the design of controllers.

mod designs;
mod stability;

use std::collections::BTreeMap;

use crate::demo;
use crate::description::{Controller, no_files, read};
use crate::model::Model;

const PERIOD: f64 = 1e-3;

/// Returns the demo's arm with its true values and without Coulomb friction, and its controller.
fn arm() -> (Model, Vec<f64>, Controller) {
    let experiment = read("demo", demo::EXPERIMENT, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let mut values: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    for (name, value) in &mut values {
        if name.contains("coulomb") {
            *value = 0.0;
        }
    }
    let theta = model.theta(&values).unwrap();
    (model, theta, experiment.controller.unwrap())
}
