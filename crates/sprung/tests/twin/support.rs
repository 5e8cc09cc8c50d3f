//! The experiment of the demo with its true parameters.

use std::path::Path;

use sprung_base::demo;
use sprung_base::progress::Unheard;
use sprung_log::{Channels, Input, LogSource};
use sprung_method::estimate::fit;
use sprung_method::preprocess::SignalBlock;
use sprung_method::regression::Reduction;
use sprung_method::simulate::{ClosedLoop, TwinSetup, record};
use sprung_model::{Model, Theta};
use sprung_robot::{self as description, DiscretizationName, Experiment, Simulate, no_files};

pub(crate) struct Twin {
    pub(crate) experiment: Experiment,
    pub(crate) model: Model,
    pub(crate) truth: Theta,
}

impl Twin {
    pub(crate) fn new() -> Self {
        let experiment =
            description::read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let model = Model::new(&experiment).unwrap();
        let truth = model.theta(&toml::from_str(demo::TRUTH).unwrap()).unwrap();
        Self {
            experiment,
            model,
            truth,
        }
    }

    /// The loop at 1 kHz, from rest.
    pub(crate) fn closed_loop(&self) -> ClosedLoop {
        let controller = self.experiment.controller.as_ref().unwrap();
        ClosedLoop::new(&self.model, &self.truth, controller, 1e-3, None).unwrap()
    }

    /// Least squares on the exact states of 10 s of `plant`.
    pub(crate) fn fit_exact_states(
        &self,
        mut plant: ClosedLoop,
        discretization: DiscretizationName,
    ) -> Theta {
        let mut signals = SignalBlock::new(2);
        for _ in 0..=10_000 {
            let state = plant.state();
            signals.time.push(plant.time());
            let tau = step(&mut plant);
            for (columns, values) in [
                (&mut signals.q, state.q),
                (&mut signals.dq, state.dq),
                (&mut signals.phi, state.phi),
                (&mut signals.dphi, state.dphi),
                (&mut signals.tau, tau),
            ] {
                for (column, value) in columns.iter_mut().zip(values) {
                    column.push(value);
                }
            }
        }
        let mut reduction = Reduction::new(&self.model);
        reduction
            .push(&signals, 30.0, 1e-3, discretization)
            .unwrap();
        fit(&self.model, &reduction.finish(), 0.1).unwrap().theta
    }

    /// The log that an experiment with `settings` writes.
    pub(crate) fn log(&self, settings: &Simulate) -> Vec<u8> {
        let setup = TwinSetup {
            model: &self.model,
            theta: &self.truth,
            controller: self.experiment.controller.as_ref().unwrap(),
            settings,
        };
        let columns = self.experiment.log.as_ref().unwrap();
        let channels = Channels::new(&self.experiment.robot, columns).unwrap();
        let mut log = Vec::new();
        record(&setup, &channels, &mut log, &mut Unheard).unwrap();
        log
    }
}

/// Advances by one sample and returns its torque.
pub(crate) fn step(plant: &mut ClosedLoop) -> Vec<f64> {
    let state = plant.state();
    let tau = plant.command(plant.time(), &state.q, &state.phi);
    plant.advance(&tau).unwrap();
    tau
}

/// Runs `use_sources` on several logs in memory.
pub(crate) fn with_sources<T>(
    logs: &[&[u8]],
    use_sources: impl FnOnce(&mut [LogSource<'_>]) -> T,
) -> T {
    let mut openers: Vec<_> =
        (logs.iter())
            .map(|log| {
                let log = log.to_vec();
                move |_: Option<&Path>| {
                    Ok(Box::new(std::io::Cursor::new(log.clone())) as Box<dyn Input>)
                }
            })
            .collect();
    let mut sources: Vec<LogSource<'_>> = (openers.iter_mut().enumerate())
        .map(|(i, reader)| LogSource::files(format!("twin {i}"), reader))
        .collect();
    use_sources(&mut sources)
}
