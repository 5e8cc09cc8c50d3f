//! Designs a controller for an identified robot.

mod path;
mod written;

pub use written::controller_toml;

use sprung_base::progress::Listener;
use sprung_core::chain::JointKind;
use sprung_method::control::{
    ControlRefusal, ControlTask, Controlled, design_control, workspace_poses,
};
use sprung_method::estimate::EstimateResult;
use sprung_method::excite::Bounds;
use sprung_model::{Model, Theta};
use sprung_robot::{Experiment, Feedback, Reference, Task as Verb};

use super::control_error::ControlError;
use super::error::SessionError;
use super::excite::{assumed_twin, completed};
use super::export::values_of;
use super::load::Session;
use super::parameters::Parameters;
use super::sample::SampleRequest;

/// Range of the position of a joint without limits, about zero: half of it, rad and m.
const TURN: f64 = std::f64::consts::PI;
const SLIDE: f64 = 0.5;

/// Period without any other, s.
const PERIOD: f64 = 1e-3;

/// Windows of the velocity estimator without a controller.
const WINDOW: [usize; 2] = [4, 4];

/// Relative difference below which periods are equal.
const SAME_PERIOD: f64 = 1e-3;

impl Session {
    /// Designs a controller for an identified robot, and proves it on robots from the posterior.
    ///
    /// - `parameters`: an identification, or values by name, which then have no uncertainty.
    /// - `accept_unusable`: whether a result whose verdict is *unusable* counts.
    ///
    /// # Errors
    ///
    /// [`SessionError::Control`] if the settings do not fit the robot or no controller keeps margins and limits;
    /// [`SessionError`] if a value or a file is faulty.
    pub fn control(
        &self,
        parameters: &Parameters,
        accept_unusable: bool,
        progress: &mut dyn Listener,
    ) -> Result<Controlled, SessionError> {
        if let Some(joint) = self.servo_joint() {
            return Err(ControlError::Servo { joint }.into());
        }
        self.allow(Verb::Simulate)?;
        let (experiment, model) = self.described_by(parameters)?;
        let mut setup = Setup::new(self, experiment, &model, parameters, accept_unusable)?;
        let poses = setup.poses(self)?;
        let reference = setup.reference();
        let declared = setup.experiment.controller.clone();
        let assumed = std::mem::take(&mut setup.assumed);
        let task = ControlTask {
            model: &setup.model,
            theta: &setup.theta,
            draws: &setup.draws,
            settings: &setup.experiment.control,
            declared: declared.as_ref(),
            period: setup.period,
            window: setup.window,
            poses: &poses,
            ranges: &setup.ranges,
            torque_limits: &setup.torque_limits,
            twin: &setup.twin,
            reference: reference.as_ref(),
        };
        let robot = &setup.experiment.robot.name;
        let verdict = setup.verdict.clone();
        design_control(&task, robot, verdict, assumed, progress).map_err(|error| match error {
            ControlRefusal::Stopped(stopped) => SessionError::Stopped(stopped),
            other => ControlError::from(other).into(),
        })
    }
}

/// Input of a design from the experiment and its identification.
struct Setup {
    experiment: Experiment,
    model: Model,
    theta: Theta,
    draws: Vec<Theta>,
    verdict: Option<String>,
    period: f64,
    window: [usize; 2],
    ranges: Vec<[f64; 2]>,
    torque_limits: Vec<f64>,
    twin: sprung_robot::Simulate,
    assumed: Vec<String>,
}

impl Setup {
    fn new(
        session: &Session,
        experiment: Experiment,
        model: &Model,
        parameters: &Parameters,
        accept_unusable: bool,
    ) -> Result<Self, SessionError> {
        let settings = &experiment.control;
        let mut assumed = Vec::new();
        let n = model.joint_count();
        if settings.feedback == Feedback::LinkDamping
            && (0..n).all(|joint| !model.is_flexible(joint))
        {
            return Err(ControlError::Rigid.into());
        }
        if settings.feedback == Feedback::Declared && experiment.controller.is_none() {
            return Err(ControlError::NoController.into());
        }
        let result = (parameters.identification.as_ref())
            .and_then(|identification| identification.results.first());
        let period = period(&experiment, parameters)?;
        let Robots {
            model,
            mut theta,
            mut draws,
        } = values(
            session,
            &experiment,
            model,
            (parameters, result),
            accept_unusable,
            &mut assumed,
        )?;
        if let Some(payload) = &settings.payload {
            if model.tree().is_none() {
                return Err(ControlError::Payload {
                    why: "kinematics = \"planar-2r\" has no single bodies".to_owned(),
                }
                .into());
            }
            model
                .link_of_payload(payload)
                .map_err(|error| ControlError::Payload {
                    why: error.to_string(),
                })?;
            let change = model
                .change_by_payload(payload)
                .ok_or_else(|| ControlError::Payload {
                    why: "its mass or its centre of mass is missing".to_owned(),
                })?;
            for theta in std::iter::once(&mut theta).chain(&mut draws) {
                for (value, change) in theta.iter_mut().zip(&change) {
                    *value += change;
                }
            }
        }
        let declared = experiment
            .controller
            .as_ref()
            .map(|controller| controller.velocity_window);
        let window = settings.velocity_window.or(declared).unwrap_or(WINDOW);
        let ranges = ranges(&experiment, &model, &mut assumed);
        let twin = match experiment.simulate.clone() {
            Some(simulate) => simulate,
            None => assumed_twin(&experiment, &mut assumed)?,
        };
        let bounds = Bounds::new(&experiment);
        // The controller reads encoders; the noise of logged torques does not count.
        let twin = completed(twin, &experiment, &model, &bounds, &mut Vec::new());
        Ok(Self {
            verdict: result.map(|result| result.verdict.word().to_owned()),
            model,
            theta,
            draws,
            period,
            window,
            ranges,
            torque_limits: (0..n)
                .map(|joint| {
                    experiment
                        .robot
                        .limits(joint)
                        .torque_nm
                        .unwrap_or(f64::INFINITY)
                })
                .collect(),
            twin,
            assumed,
            experiment,
        })
    }

    /// Returns the poses of the path, or those of the workspace.
    fn poses(&self, session: &Session) -> Result<Vec<Vec<f64>>, SessionError> {
        let settings = &self.experiment.control;
        match &settings.path {
            None => Ok(workspace_poses(&self.ranges, settings.poses)),
            Some(file) => {
                let limits: Vec<Option<[f64; 2]>> = (0..self.model.joint_count())
                    .map(|joint| self.experiment.robot.limits(joint).position_rad)
                    .collect();
                session.path(file, self.model.joints(), &limits, settings.poses)
            }
        }
    }

    /// Returns the reference on which the loop is simulated: that of the last validation run with a controller, or that
    /// of the experiment's controller.
    fn reference(&self) -> Option<Reference> {
        let runs = self.experiment.validate.iter().rev();
        let runs = runs.filter_map(|run| run.controller.as_ref());
        let mut all = runs.chain(&self.experiment.controller);
        all.find(|settings| !settings.reference.sines.is_empty())
            .map(|settings| settings.reference.clone())
    }
}

/// Returns the period of the controller: that of `[control]`, that of `[log]` unless it is shorter than the period of the log, or
/// the period of the log.
fn period(experiment: &Experiment, parameters: &Parameters) -> Result<f64, SessionError> {
    let log =
        (parameters.identification.as_ref()).map(|identification| identification.log.period_s);
    let twin = experiment
        .simulate
        .as_ref()
        .map(|settings| settings.period_s);
    let asked = experiment.control.period_s;
    if let (Some(period_s), Some(log_s)) = (asked, log)
        && period_s < log_s * (1.0 - SAME_PERIOD)
    {
        return Err(ControlError::Period {
            period_s,
            log_s,
            highest_hz: 0.5 / log_s,
        }
        .into());
    }
    // Between the samples of the log nothing is known of the robot.
    let shortest = log.map_or(0.0, |log_s| log_s * (1.0 - SAME_PERIOD));
    let of_log = (experiment.log.as_ref()).and_then(|log| log.controller_period_s);
    let of_controller = of_log.filter(|period_s| *period_s >= shortest);
    Ok((asked.or(of_controller).or(log).or(twin)).unwrap_or(PERIOD))
}

/// The model with the laws of an identification, its values, and robots from its posterior.
struct Robots {
    model: Model,
    theta: Theta,
    draws: Vec<Theta>,
}

fn values(
    session: &Session,
    experiment: &Experiment,
    model: &Model,
    (parameters, result): (&Parameters, Option<&EstimateResult>),
    accept_unusable: bool,
    assumed: &mut Vec<String>,
) -> Result<Robots, SessionError> {
    let settings = &experiment.control;
    let Some(result) = result else {
        let given = parameters.sets.first().map(|set| set.values.clone());
        let values = given.unwrap_or_default();
        let theta = model
            .theta(&values)
            .map_err(|error| ControlError::Values(error.to_string()))?;
        check(model, &theta)?;
        assumed.push(
            "the values come from no identification, so they count as exact: no margin covers their errors".to_owned(),
        );
        return Ok(Robots {
            model: model.shaped(&values),
            theta,
            draws: Vec::new(),
        });
    };
    let request = SampleRequest {
        count: settings.draws,
        seed: settings.seed,
        set: 0,
        accept_unusable,
    };
    let samples = session.sample(parameters, &request)?;
    let values = values_of(result);
    let theta = model.theta(&values)?;
    check(model, &theta)?;
    if !samples.undetermined.is_empty() {
        assumed.push(format!(
            "the log does not determine {}; robots of the posterior have nominal values there, with their relative error",
            samples.undetermined.join(", ")
        ));
    }
    Ok(Robots {
        model: model.shaped(&values),
        theta,
        draws: samples.theta,
    })
}

fn check(model: &Model, theta: &Theta) -> Result<(), SessionError> {
    (model.check_inertias(theta))
        .and_then(|()| model.check_stiffness(theta))
        .map_err(|error| ControlError::Values(error.to_string()).into())
}

/// Returns the range of the position of each joint.
fn ranges(experiment: &Experiment, model: &Model, assumed: &mut Vec<String>) -> Vec<[f64; 2]> {
    let mut free = Vec::new();
    let all = (0..model.joint_count()).map(|joint| {
        let half = match model.kind(joint) {
            JointKind::Revolute => TURN,
            JointKind::Prismatic => SLIDE,
        };
        experiment
            .robot
            .limits(joint)
            .position_rad
            .unwrap_or_else(|| {
                free.push(model.joints()[joint].clone());
                [-half, half]
            })
    });
    let all = all.collect();
    if !free.is_empty() {
        assumed.push(format!(
            "{} may be in every position, because position_rad of limits is absent",
            free.join(", ")
        ));
    }
    all
}
