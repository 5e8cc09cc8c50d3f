//! A motion by a search, with the motions beside it.

use std::f64::consts::TAU;

use sprung_base::finding::GENERATOR;
use sprung_base::progress::Listener;
use sprung_core::parameters::JointParameter;
use sprung_method::excite::{
    EXCITATION_FORMAT, Excitation, Excited, Frequencies, Information, MotionResult, Plan,
    SearchResult, Task, Trajectory, more, plan,
};
use sprung_robot::Excite;

use super::task::Setup;
use crate::session::error::SessionError;
use crate::session::load::Session;

/// Length of the motion for validation, part of that of the motion. So its frequencies are others.
const HOLD_OUT: f64 = 0.8;

/// Steps of the searches for the motions beside it, part of those of the motion.
const BESIDE_STEPS: usize = 5;

/// Multiples of the lowest frequency in a slow motion: the fewest that begin and end at rest with two free waves.
const SLOW_HARMONICS: usize = 3;

/// A motion beside the designed one.
struct Beside {
    motion: MotionResult,
    trajectory: Trajectory,
    information: Information,
}

impl Session {
    /// Searches a motion.
    pub(super) fn optimal(
        &self,
        is_warm_up: bool,
        setup: &Setup,
        task: &Task<'_>,
        progress: &mut dyn Listener,
    ) -> Result<Excited, SessionError> {
        setup.require_limits()?;
        let frequencies = Frequencies::of(task);
        let found = plan(task, &frequencies, &setup.runs, progress);
        let found = found.map_err(|refusal| setup.refused(&refusal))?;
        let approach = setup.approach(&found.designed.series)?;
        let mut assumed = setup.assumed.clone();
        let series = &found.designed.series;
        let bought = self.bought(setup, (&frequencies, series), &mut assumed, progress)?;
        let full = match task.known {
            Some(known) => bought.with(known),
            None => bought,
        };

        let hold_out = Excite {
            duration_s: HOLD_OUT * frequencies.duration(),
            base_frequency_hz: Some(frequencies.rate / TAU / HOLD_OUT),
            seed: task.settings.seed.wrapping_add(0x0007_0100),
            ..task.settings.clone()
        };
        let hold_out = self.beside(setup, task, &hold_out, progress)?;
        let slow = match task.settings.slow_sweep_s {
            Some(duration_s) => {
                let slow_settings = Excite {
                    duration_s,
                    base_frequency_hz: Some(1.0 / duration_s),
                    harmonics: Some(SLOW_HARMONICS),
                    resonances: false,
                    ..task.settings.clone()
                };
                let friction = setup.friction();
                let beside = Task {
                    known: Some(&full),
                    chosen: &friction,
                    ..task.clone()
                };
                Some(self.beside(setup, &beside, &slow_settings, progress)?)
            }
            None => None,
        };

        let promised = setup.promised(task, (&frequencies, series), &full);
        let mut others = vec![("this motion and the validation one", &hold_out.information)];
        if let Some(slow) = &slow {
            others.push(("this motion and the slow one", &slow.information));
        }
        let more = more(setup.robot(), &setup.bounds, &full, &others);
        let trajectory = setup.samples(series, &frequencies, approach.as_ref());
        let (slow_motion, slow) = slow.map(|slow| (slow.motion, slow.trajectory)).unzip();
        let excitation = Excitation {
            format: EXCITATION_FORMAT,
            generator: GENERATOR.to_owned(),
            robot: setup.experiment.robot.name.clone(),
            method: "optimal".to_owned(),
            objective: task.settings.objective.word().to_owned(),
            is_warm_up,
            is_certified: true,
            motion: setup.motion(series, &frequencies, approach.as_ref()),
            hold_out: Some(hold_out.motion),
            slow: slow_motion,
            limits: setup.limits(&found.certificate.certified, &found.certificate.simulated),
            promise: promised,
            links_condition_number: setup.links_condition_number(&full),
            more,
            assumed,
            search: SearchResult {
                seed: task.settings.seed,
                steps: task.settings.steps,
                objectives: found.designed.of_starts.clone(),
                objective: found.designed.objective,
            },
        };
        Ok(Excited {
            skeleton: setup.skeleton(&found),
            excitation,
            simulation: found.certificate.simulation,
            trajectory,
            hold_out: Some(hold_out.trajectory),
            slow,
        })
    }

    /// Searches a motion beside the designed one.
    fn beside(
        &self,
        setup: &Setup,
        task: &Task<'_>,
        settings: &Excite,
        progress: &mut dyn Listener,
    ) -> Result<Beside, SessionError> {
        let settings = Excite {
            steps: (settings.steps / BESIDE_STEPS).max(1),
            starts: 1,
            ..settings.clone()
        };
        let task = Task {
            settings: &settings,
            ..task.clone()
        };
        let frequencies = Frequencies::of(&task);
        let found: Plan = plan(&task, &frequencies, &setup.runs, progress)
            .map_err(|refusal| setup.refused(&refusal))?;
        let series = &found.designed.series;
        let approach = setup.approach(series)?;
        Ok(Beside {
            motion: setup.motion(series, &frequencies, approach.as_ref()),
            information: self.bought(setup, (&frequencies, series), &mut Vec::new(), progress)?,
            trajectory: setup.samples(series, &frequencies, approach.as_ref()),
        })
    }
}

impl Setup {
    /// Returns the places of the friction parameters among the free ones.
    fn friction(&self) -> Vec<usize> {
        let is_friction = |parameter: &sprung_model::Parameter| {
            matches!(parameter.joint, Some((JointParameter::Friction(..), _)))
        };
        (self.free().enumerate())
            .filter(|(_, parameter)| is_friction(parameter))
            .map(|(place, _)| place)
            .collect()
    }
}
