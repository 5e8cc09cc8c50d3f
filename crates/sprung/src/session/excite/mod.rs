//! Designs experiments: from limits and values to a certified motion and the standard errors that it promises.

mod bound;
mod described;
mod files;
mod kept;
mod task;

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use sprung_base::finding::GENERATOR;
use sprung_base::progress::{Answer, Listener, Phase, Progress};
use sprung_log::LogSource;
use sprung_method::estimate::{KnownTruth, information_bound};
use sprung_method::excite::{
    Approach, Bounds, EXCITATION_FORMAT, Excitation, Excited, Frequencies, Information, Limited,
    Plan, Refused, SearchResult, Series, Task, add_cures, certify, missing_limit, more, plan,
    promise, random, value_of,
};
use sprung_model::Model;
use sprung_robot::Task as Verb;

use super::error::SessionError;
use super::excite_error::ExciteError;
use super::load::Session;
use super::parameters::Parameters;
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

/// What is asked of a design beside the experiment.
#[derive(Clone, Debug, Default)]
pub struct ExciteRequest {
    /// What makes the motion.
    pub method: ExciteMethod,
    /// Whether the robot is unknown, and a first small motion is wanted.
    pub is_warm_up: bool,
    /// A recorded log, beside which the new motion counts.
    pub from_log: Option<PathBuf>,
}

/// Length of the motion for validation, part of that of the motion. So its frequencies are others.
const HOLD_OUT: f64 = 0.8;

/// Steps of the search for the motion for validation, part of those of the motion.
const HOLD_OUT_STEPS: usize = 5;

/// Part of velocities and accelerations by which interpolated points of a message may differ from the motion.
const INTERPOLATED: f64 = 2e-3;

/// A listener that may stop the search, and nothing after it.
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
        if let Some(joint) = (self.experiment().robot.joint.iter()).find(|own| own.servo.is_some())
        {
            return Err(ExciteError::Servo {
                joint: joint.name.clone(),
            }
            .into());
        }
        self.allow(Verb::Simulate)?;
        let progress = &mut UntilDesigned(progress);
        let (experiment, model) = match parameters {
            Some(own) => self.described_by(own)?,
            None => (self.experiment().clone(), self.model().clone()),
        };
        let setup = Setup::new(experiment, model, parameters, request.is_warm_up)?;
        let known = match &request.from_log {
            Some(file) => Some(self.information_of_log(&setup, file)?),
            None => None,
        };
        let chosen = setup.chosen()?;
        let task = setup.task(known.as_ref(), &chosen);
        match request.method {
            ExciteMethod::Optimal => self.optimal(request, &setup, &task, known.as_ref(), progress),
            ExciteMethod::Paper => {
                let series = paper_reference(setup.model.joint_count());
                let frequencies = Frequencies {
                    rate: series.rate,
                    harmonics: series.harmonics.clone(),
                    periods: (task.settings.duration_s * series.rate / TAU + 1e-9)
                        .floor()
                        .max(1.0) as usize,
                };
                self.judged("paper", &setup, &task, (&frequencies, &series), progress)
            }
            ExciteMethod::Random => {
                setup.require_limits()?;
                let frequencies = Frequencies::of(&task);
                let part = 1.0 - task.settings.margin;
                let series = random(&task, &frequencies, part, task.settings.seed);
                let refused = |own| setup.refused(&own);
                let series = series.map_err(|own| refused(Refused::Pose(own)))?;
                self.judged("random", &setup, &task, (&frequencies, &series), progress)
            }
        }
    }

    fn optimal(
        &self,
        request: &ExciteRequest,
        setup: &Setup,
        task: &Task<'_>,
        known: Option<&Information>,
        progress: &mut dyn Listener,
    ) -> Result<Excited, SessionError> {
        setup.require_limits()?;
        let frequencies = Frequencies::of(task);
        let refused = |own| setup.refused(&own);
        let found = plan(task, &frequencies, &setup.runs, progress).map_err(refused)?;
        let approach = setup.approach(&found.designed.series)?;

        let mut own = setup.experiment.excite.clone();
        own.duration_s = HOLD_OUT * frequencies.duration();
        own.base_frequency_hz = Some(frequencies.rate / TAU / HOLD_OUT);
        own.steps = (own.steps / HOLD_OUT_STEPS).max(1);
        own.starts = 1;
        own.seed = own.seed.wrapping_add(0x0007_0100);
        let other = Task {
            settings: &own,
            ..task.clone()
        };
        let others = Frequencies::of(&other);
        let second = plan(&other, &others, &setup.runs, progress).map_err(refused)?;
        let way = setup.approach(&second.designed.series)?;

        let motion = |plan: &Plan, frequencies: &Frequencies| {
            setup.with_motion(
                plan.designed.series.reference(&setup.model),
                frequencies.duration(),
            )
        };
        let full = bound::full(self, setup, motion(&found, &frequencies), progress)?;
        let full = known.map_or_else(|| full.clone(), |known| full.with(known));
        let beside = bound::full(self, setup, motion(&second, &others), progress)?;
        let mut promised = promise(setup.robot(), &setup.bounds, &full);
        add_cures(
            &mut promised,
            task,
            (&frequencies, &found.designed.series),
            &setup.experiment,
            &setup.named(),
        );
        let more = more(setup.robot(), &setup.bounds, &full, Some(&beside));

        let period = setup.runs.period;
        let samples = |plan: &Plan, frequencies: &Frequencies, approach: Option<&Approach>| {
            let series = &plan.designed.series;
            files::samples(
                &setup.model,
                series,
                frequencies.duration(),
                approach,
                period,
            )
        };
        let trajectory = samples(&found, &frequencies, approach.as_ref());
        let hold_out = samples(&second, &others, way.as_ref());
        let excitation = Excitation {
            format: EXCITATION_FORMAT,
            generator: GENERATOR.to_owned(),
            robot: setup.experiment.robot.name.clone(),
            method: "optimal".to_owned(),
            objective: task.settings.objective.word().to_owned(),
            is_warm_up: request.is_warm_up,
            is_certified: true,
            motion: setup.motion(&found.designed.series, &frequencies, approach.as_ref()),
            hold_out: Some(setup.motion(&second.designed.series, &others, way.as_ref())),
            limits: setup.limits(&found.certified, &found.simulated),
            promise: promised,
            links_condition_number: setup.links_condition_number(&full),
            more,
            assumed: setup.assumed.clone(),
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
            simulation: found.simulation,
            trajectory,
            hold_out: Some(hold_out),
        })
    }

    /// Judges a motion that no search made.
    fn judged(
        &self,
        method: &str,
        setup: &Setup,
        task: &Task<'_>,
        (frequencies, series): (&Frequencies, &Series),
        progress: &mut dyn Listener,
    ) -> Result<Excited, SessionError> {
        // Limits that are far wider show how much of them the motion uses.
        const WIDER: f64 = 1e6;
        let wide = Bounds {
            floor: None,
            ..task.bounds.narrowed(&[WIDER; Limited::ALL.len()])
        };
        let wider = Task {
            bounds: &wide,
            ..task.clone()
        };
        let judged = certify(&wider, frequencies, &setup.runs, series);
        let (mut certified, mut simulated, simulation) =
            judged.map_err(|broken| setup.refused(&Refused::Motion(broken)))?;
        for own in certified.iter_mut().chain(&mut simulated) {
            own.part *= WIDER;
        }
        let is_certified = certify(task, frequencies, &setup.runs, series).is_ok();
        let reference = series.reference(&setup.model);
        let experiment = setup.with_motion(reference, frequencies.duration());
        let full = bound::full(self, setup, experiment, progress)?;
        let mut promised = promise(setup.robot(), &setup.bounds, &full);
        add_cures(
            &mut promised,
            task,
            (frequencies, series),
            &setup.experiment,
            &setup.named(),
        );
        let objective = value_of(task, frequencies, series);
        let (model, period) = (&setup.model, setup.runs.period);
        let excitation = Excitation {
            format: EXCITATION_FORMAT,
            generator: GENERATOR.to_owned(),
            robot: setup.experiment.robot.name.clone(),
            method: method.to_owned(),
            objective: task.settings.objective.word().to_owned(),
            is_warm_up: false,
            is_certified,
            motion: setup.motion(series, frequencies, None),
            hold_out: None,
            limits: setup.limits(&certified, &simulated),
            more: more(setup.robot(), &setup.bounds, &full, None),
            promise: promised,
            links_condition_number: setup.links_condition_number(&full),
            assumed: setup.assumed.clone(),
            search: SearchResult {
                seed: task.settings.seed,
                steps: 0,
                objectives: Vec::new(),
                objective: objective.unwrap_or(f64::INFINITY),
            },
        };
        Ok(Excited {
            excitation,
            simulation,
            trajectory: files::samples(model, series, frequencies.duration(), None, period),
            hold_out: None,
            skeleton: None,
        })
    }

    /// Returns the information of a recorded log at the values of the design.
    fn information_of_log(&self, setup: &Setup, file: &Path) -> Result<Information, SessionError> {
        let mut experiment = setup.experiment.clone();
        if let Some(log) = &mut experiment.log {
            log.file = Some(vec![file.to_owned().into()]);
        }
        let delays = std::collections::BTreeMap::new();
        let noise = setup.noise();
        let truth = KnownTruth {
            theta: &setup.theta,
            noise: &noise,
            delays: &delays,
        };
        let name = file.display().to_string();
        let mut open = |_: Option<&Path>| self.files.open(file);
        let source = LogSource::files(&name, &mut open);
        let bound = information_bound(&experiment, &setup.model, truth, source)?;
        let bound = bound.ok_or(SessionError::NoBound)?;
        Information::of_bound(&bound).ok_or(SessionError::NoBound)
    }
}

impl Setup {
    fn task<'a>(&'a self, known: Option<&'a Information>, chosen: &'a [usize]) -> Task<'a> {
        Task {
            model: &self.model,
            theta: &self.theta,
            settings: &self.experiment.excite,
            bounds: &self.bounds,
            errors: &self.errors,
            controller: Some(&self.runs.controller).filter(|_| self.is_pd),
            kinematics: self.kinematics.as_ref(),
            known,
            chosen,
        }
    }

    /// Returns the places of the parameters that count among the free ones.
    fn chosen(&self) -> Result<Vec<usize>, ExciteError> {
        let free: Vec<&str> = (self.model.parameters().iter())
            .filter(|own| own.fixed.is_none())
            .map(|own| own.name.as_str())
            .collect();
        let place = |name: &String| {
            free.iter().position(|own| own == name).ok_or_else(|| {
                let known = self.model.parameters().iter().find(|own| own.name == *name);
                let why = match known {
                    Some(_) => format!("{name} has a fixed value, so nothing is to be determined"),
                    None => format!(
                        "the equations have no parameter \"{name}\": no motion determines it alone, or the name is wrong"
                    ),
                };
                ExciteError::NotDetermined { why, known: free.join(", ") }
            })
        };
        self.experiment
            .excite
            .parameters
            .iter()
            .map(place)
            .collect()
    }

    /// Checks that the limits end the motion of every joint.
    fn require_limits(&self) -> Result<(), ExciteError> {
        match missing_limit(&self.bounds, self.is_pd) {
            Some((joint, missing)) => {
                Err(ExciteError::no_limit(&self.model.joints()[joint], &missing))
            }
            None => Ok(()),
        }
    }

    fn refused(&self, refused: &Refused) -> ExciteError {
        let duration = self.experiment.excite.duration_s;
        ExciteError::refused(refused, &self.model, &self.bounds, duration)
    }

    fn robot(&self) -> (&Model, &[f64]) {
        (&self.model, &self.theta)
    }

    fn links_condition_number(&self, information: &Information) -> Option<f64> {
        let free = self
            .model
            .parameters()
            .iter()
            .filter(|own| own.fixed.is_none());
        let places: Vec<usize> = (free.enumerate())
            .filter(|(_, own)| own.joint.is_none())
            .map(|(place, _)| place)
            .collect();
        (!places.is_empty()).then(|| information.condition_number(&places))
    }

    fn approach(&self, series: &Series) -> Result<Option<Approach>, ExciteError> {
        let from = &self.experiment.excite.start_rad;
        if from.is_empty() {
            return Ok(None);
        }
        Approach::new(
            from,
            series,
            self.robot(),
            &self.bounds,
            self.kinematics.as_ref(),
        )
        .map_err(|broken| ExciteError::approach(&broken, &self.model, &self.bounds))
    }
}

/// Returns the reference of the paper: for joints in turn those of its first and of its second joint.
///
/// # Source
///
/// Eq. (29).
fn paper_reference(joints: usize) -> Series {
    // Multiples of 0.1 Hz, amplitude 3°; phases of both joints, degrees.
    let harmonics = vec![2, 5, 10];
    let phases = [[45.0, 30.0, 0.0], [0.0, 90.0, 36.0]];
    let amplitude = 3.0_f64.to_radians();
    Series {
        rate: TAU * 0.1,
        joints: (0..joints)
            .map(|joint| {
                let waves = phases[joint % 2].map(|phase: f64| {
                    let (sin, cos) = phase.to_radians().sin_cos();
                    [amplitude * cos, amplitude * sin]
                });
                std::iter::once(0.0)
                    .chain(waves.into_iter().flatten())
                    .collect()
            })
            .collect(),
        harmonics,
    }
}

/// Returns the texts of the files of a design, with their names: `trajectory.csv`, `trajectory.yaml`, `reference.toml`, and
/// `hold-out.csv` if there is a motion for validation.
#[must_use]
pub fn excitation_files(session: &Session, excited: &Excited) -> Vec<(&'static str, String)> {
    let own = &excited.trajectory;
    let step = files::spacing(own, INTERPOLATED);
    let motion = &excited.excitation.motion;
    let series = Series {
        rate: TAU * motion.base_frequency_hz,
        harmonics: motion.harmonics.clone(),
        joints: (motion.joints.iter())
            .map(|joint| {
                let pairs = joint.sine_rad.iter().zip(&joint.cosine_rad);
                let pairs = pairs.flat_map(|(sine, cosine)| [*sine, *cosine]);
                std::iter::once(joint.centre_rad).chain(pairs).collect()
            })
            .collect(),
    };
    let reference = files::toml(&series, session.model(), motion.duration_s);
    let mut all = vec![
        ("trajectory.csv", files::csv(own)),
        ("trajectory.yaml", files::yaml(own, step)),
        ("reference.toml", reference),
    ];
    if let Some(own) = &excited.hold_out {
        all.push(("hold-out.csv", files::csv(own)));
    }
    all
}
