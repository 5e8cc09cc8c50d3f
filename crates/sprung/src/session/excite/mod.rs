//! Designs experiments: from limits and values to a certified motion and the standard errors that it promises.

mod assumed;
mod bound;
mod described;
mod designed;
mod files;
mod judged;
mod kept;
mod task;

use std::f64::consts::TAU;
use std::path::PathBuf;

use sprung_base::progress::{Answer, Listener, Phase, Progress};
use sprung_method::estimate::Samples;
use sprung_method::excite::{Excited, Frequencies, MotionResult, Refused, Series, random};
use sprung_robot::Task as Verb;

use super::error::SessionError;
use super::excite_error::ExciteError;
use super::load::Session;
use super::parameters::Parameters;
use super::sample::SampleRequest;
pub(super) use assumed::{assumed_twin, completed};
use judged::paper_reference;
use task::Setup;

/// What makes the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExciteMethod {
    /// The search.
    #[default]
    Optimal,
    /// The reference of the paper, Eq. (29), without a search.
    Paper,
    /// A random series, as large as the limits allow, without a search.
    Random,
}

/// Options of a design beside the experiment.
#[derive(Clone, Debug, Default)]
pub struct ExciteRequest {
    /// What makes the motion.
    pub method: ExciteMethod,
    /// Whether the robot is unknown, so that a first small motion is requested.
    pub is_warm_up: bool,
    /// A recorded log, beside which the new motion counts.
    pub from_log: Option<PathBuf>,
    /// A file whose `[controller.reference]` is the motion, instead of that of the method; no search.
    pub reference: Option<PathBuf>,
}

/// Part of velocities and accelerations by which interpolated points of a message may differ from the motion.
const INTERPOLATED: f64 = 2e-3;

/// A listener that may stop only the search.
struct UntilDesigned<'a>(&'a mut dyn Listener);

impl Listener for UntilDesigned<'_> {
    fn hear(&mut self, progress: Progress) -> Answer {
        let answer = self.0.hear(progress);
        if progress.phase == Phase::Designing {
            answer
        } else {
            Answer::GoOn
        }
    }
}

impl Session {
    /// Designs an experiment: a motion within the limits of the robot that determines its parameters best, and the
    /// standard errors that it promises.
    ///
    /// - `parameters`: values of the robot; the nominal values if absent.
    /// - `progress`: a stop ends the search, and the best motion so far is returned.
    ///
    /// # Errors
    ///
    /// [`SessionError::Excite`] if no motion keeps the limits or the values are not those of a robot;
    /// [`SessionError`] if a log or a value is faulty.
    pub fn excite(
        &self,
        request: &ExciteRequest,
        parameters: Option<&Parameters>,
        progress: &mut dyn Listener,
    ) -> Result<Excited, SessionError> {
        if let Some(joint) = self.servo_joint() {
            return Err(ExciteError::Servo { joint }.into());
        }
        self.allow(Verb::Simulate)?;
        let progress = &mut UntilDesigned(progress);
        let (experiment, model) = match parameters {
            Some(parameters) => self.described_by(parameters)?,
            None => (self.experiment().clone(), self.model().clone()),
        };
        let (robots, without) = match parameters.map(|found| self.possible(found)) {
            None | Some(Err(SessionError::NoPosterior)) => (Vec::new(), None),
            Some(Ok(samples)) => (samples.theta, None),
            Some(Err(error)) => (Vec::new(), Some(error)),
        };
        let mut setup = Setup::new(experiment, model, parameters, robots, request.is_warm_up)?;
        setup.assumed.extend(without.map(|error| {
            format!("the motion keeps its limits for the identified values only, because {error}")
        }));
        let known = match &request.from_log {
            Some(file) => Some(self.information_of_log(&setup, file)?),
            None => None,
        };
        let chosen = setup.chosen()?;
        let task = setup.task(known.as_ref(), &chosen);
        if let Some(file) = &request.reference {
            let series = self.given_reference(&setup, file)?;
            return self.judged("reference", &setup, &task, &series, progress);
        }
        match request.method {
            ExciteMethod::Optimal => self.optimal(request.is_warm_up, &setup, &task, progress),
            ExciteMethod::Paper => {
                let series = paper_reference(setup.model.joint_count());
                self.judged("paper", &setup, &task, &series, progress)
            }
            ExciteMethod::Random => {
                setup.require_limits()?;
                let frequencies = Frequencies::of(&task);
                let part = 1.0 - task.settings.margin;
                let series = random(&task, &frequencies, part, task.settings.seed)
                    .map_err(|pose| setup.refused(&Refused::Pose(pose)))?;
                self.judged("random", &setup, &task, &series, progress)
            }
        }
    }

    /// Draws robots for which a motion with identified values must keep its limits, too.
    fn possible(&self, parameters: &Parameters) -> Result<Samples, SessionError> {
        let settings = &self.experiment().excite;
        let request = SampleRequest {
            count: settings.draws,
            seed: settings.seed,
            set: 0,
            accept_unusable: true,
        };
        self.sample(parameters, &request)
    }
}

/// Returns the texts of the files of a design, with their names: `trajectory.csv`, `trajectory.yaml`, `reference.toml`,
/// `hold-out.csv` if there is a motion for validation, `slow.csv` if there is a slow one.
#[must_use]
pub fn excitation_files(session: &Session, excited: &Excited) -> Vec<(&'static str, String)> {
    let trajectory = &excited.trajectory;
    let step = files::spacing(trajectory, INTERPOLATED);
    let motion = &excited.excitation.motion;
    let series = series_of(motion);
    let reference = files::toml(&series, session.model(), motion.duration_s);
    let mut all = vec![
        ("trajectory.csv", files::csv(trajectory)),
        ("trajectory.yaml", files::yaml(trajectory, step)),
        ("reference.toml", reference),
    ];
    for (name, trajectory) in [
        ("hold-out.csv", &excited.hold_out),
        ("slow.csv", &excited.slow),
    ] {
        if let Some(trajectory) = trajectory {
            all.push((name, files::csv(trajectory)));
        }
    }
    all
}

fn series_of(motion: &MotionResult) -> Series {
    Series {
        rate: TAU * motion.base_frequency_hz,
        harmonics: motion.harmonics.clone(),
        joints: (motion.joints.iter())
            .map(|joint| {
                let pairs = joint.sine_rad.iter().zip(&joint.cosine_rad);
                let pairs = pairs.flat_map(|(sine, cosine)| [*sine, *cosine]);
                std::iter::once(joint.centre_rad).chain(pairs).collect()
            })
            .collect(),
    }
}
