//! Tests of the design of controllers.

mod designs;
mod stability;

use std::collections::BTreeMap;

use crate::demo;
use crate::description::{Controller, no_files, read};
use crate::model::Model;

const PERIOD: f64 = 1e-3;

/// The demo's arm with its true values and without Coulomb friction, and its controller.
struct Arm {
    model: Model,
    theta: Vec<f64>,
    controller: Controller,
}

fn arm() -> Arm {
    let experiment = read("demo", demo::EXPERIMENT, &[], &mut no_files).unwrap();
    let model = Model::new(&experiment).unwrap();
    let mut values: BTreeMap<String, f64> = toml::from_str(demo::TRUTH).unwrap();
    for (name, value) in &mut values {
        if name.contains("coulomb") {
            *value = 0.0;
        }
    }
    let theta = model.theta(&values).unwrap();
    Arm {
        model,
        theta,
        controller: experiment.controller.unwrap(),
    }
}
