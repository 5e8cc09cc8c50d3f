//! Input of a design from the experiment, and assumptions about values that the experiment does not
//! give.

use std::collections::BTreeMap;

use sprung_core::chain::JointKind;
use sprung_method::control::stability;
use sprung_method::estimate::KnownNoise;
use sprung_method::excite::{
    Approach, Bounds, Errors, Frequencies, Information, Kinematics, Limited, Loop, Promised,
    Refused, Series, Task, Trajectory, add_cures, missing_limit, promise,
};
use sprung_method::simulate::Disturbance;
use sprung_model::{Model, ModelError, Parameter, Theta};
use sprung_robot::{ControllerKind, Experiment, Reference, Simulate};

use super::assumed::{
    COUNTS, assumed_controller, assumed_log, assumed_twin, completed, with_assumed_drives,
};
use super::files::samples;
use crate::session::error::SessionError;
use crate::session::excite_error::ExciteError;
use crate::session::parameters::Parameters;

/// Parts of the limits that a first motion of an unknown robot uses; gravity needs its torque in a small motion, too.
const WARM_UP: f64 = 0.3;
const WARM_UP_POSITION: f64 = 0.5;
const WARM_UP_TORQUE: f64 = 0.6;

/// Difference from the identified robot over that of a draw.
const FARTHER: f64 = 2.0;

/// The experiment of a design, complete.
pub(super) struct Setup {
    /// The experiment with log, twin and controller.
    pub(super) experiment: Experiment,
    pub(super) model: Model,
    pub(super) theta: Vec<f64>,
    /// Other robots that the log of the identification allows; empty without an identification.
    robots: Vec<Theta>,
    pub(super) bounds: Bounds,
    pub(super) errors: Errors,
    pub(super) runs: Loop,
    /// Whether a PD controller of the motors closes the loop.
    pub(super) is_pd: bool,
    pub(super) kinematics: Option<Kinematics>,
    pub(super) assumed: Vec<String>,
}

impl Setup {
    pub(super) fn new(
        experiment: Experiment,
        model: Model,
        parameters: Option<&Parameters>,
        robots: Vec<Theta>,
        is_warm_up: bool,
    ) -> Result<Self, SessionError> {
        let mut assumed = Vec::new();
        let (model, theta) = values(model, parameters, is_warm_up, &mut assumed)?;
        (model.check_inertias(&theta))
            .and_then(|()| model.check_stiffness(&theta))
            .map_err(|error| ExciteError::Impossible(error.to_string()))?;
        let bounds = bounds(&experiment, is_warm_up, &mut assumed);
        let kinematics = kinematics(&experiment)?;
        let mut experiment = experiment;
        let declared = experiment.controller.clone();
        let is_pd = (declared.as_ref()).is_some_and(|declared| declared.kind == ControllerKind::Pd);
        let controller = match declared {
            Some(declared) => declared,
            None => assumed_controller(&model, &theta, &mut assumed),
        };
        let period = experiment.excite.period_s;
        if is_pd
            && let Some(stability) = stability(
                &model,
                &theta,
                &controller,
                &vec![0.0; model.joint_count()],
                period,
            )
            && let Some(rate) = stability.growth_per_s
        {
            return Err(ExciteError::Unstable {
                time_s: 1.0 / rate,
                runs_away: false,
            }
            .into());
        }
        let twin = match experiment.simulate.take() {
            Some(simulate) => simulate,
            None => assumed_twin(&experiment, &mut assumed)?,
        };
        let twin = completed(twin, &experiment, &model, &bounds, &mut assumed);
        let errors = errors(&twin, &model);
        let runs = Loop {
            controller: controller.clone(),
            period,
        };
        if experiment.log.is_none() {
            experiment.log = Some(assumed_log(&model, &mut assumed)?);
        }
        experiment.controller = Some(controller);
        experiment.simulate = Some(twin);
        let robots: Vec<Theta> = (robots.into_iter())
            .map(|robot| farther(&model, &theta, robot))
            .collect();
        if !robots.is_empty() {
            assumed.push(format!(
                "the motion keeps its limits also for {} robots that can exist and differ from the identified one by about two \
                 standard errors",
                robots.len()
            ));
        }
        assumed.push(
            "collisions of links with each other and with obstacles were not looked at".to_owned(),
        );
        Ok(Self {
            experiment,
            model,
            theta,
            robots,
            bounds,
            errors,
            runs,
            is_pd,
            kinematics,
            assumed,
        })
    }

    /// Returns the values by name.
    pub(super) fn named(&self) -> BTreeMap<String, f64> {
        (self.model.parameters().iter().zip(&self.theta))
            .map(|(parameter, value)| (parameter.name.clone(), *value))
            .collect()
    }

    /// Returns the experiment whose twin makes a motion of some length.
    pub(super) fn with_motion(&self, reference: Reference, duration: f64) -> Experiment {
        let mut experiment = self.experiment.clone();
        if let Some(controller) = &mut experiment.controller {
            controller.reference = reference;
        }
        if let Some(twin) = &mut experiment.simulate {
            twin.duration_s = duration;
        }
        experiment
    }

    /// Returns the noise of the log and the disturbances.
    pub(super) fn noise(&self) -> KnownNoise {
        KnownNoise {
            torque: self.errors.torque.clone(),
            motor: self.errors.disturbances[1].clone(),
            link: self.errors.disturbances[0].clone(),
            corner: self.errors.corner,
        }
    }

    pub(super) fn task<'a>(
        &'a self,
        known: Option<&'a Information>,
        chosen: &'a [usize],
    ) -> Task<'a> {
        Task {
            model: &self.model,
            theta: &self.theta,
            robots: &self.robots,
            settings: &self.experiment.excite,
            bounds: &self.bounds,
            errors: &self.errors,
            controller: Some(&self.runs.controller).filter(|_| self.is_pd),
            kinematics: self.kinematics.as_ref(),
            known,
            chosen,
        }
    }

    /// Returns the parameters without a fixed value.
    pub(super) fn free(&self) -> impl Iterator<Item = &Parameter> {
        let parameters = self.model.parameters().iter();
        parameters.filter(|parameter| parameter.fixed.is_none())
    }

    /// Returns the standard errors that a motion promises, with the cures of undetermined parameters.
    ///
    /// - `full`: the information of the motion and of what is known beside it.
    pub(super) fn promised(
        &self,
        task: &Task<'_>,
        motion: (&Frequencies, &Series),
        full: &Information,
    ) -> Vec<Promised> {
        let mut promised = promise(self.robot(), &self.bounds, full);
        add_cures(&mut promised, task, motion, &self.experiment, &self.named());
        promised
    }

    /// Returns the samples of a motion at the period of the controller.
    pub(super) fn samples(
        &self,
        series: &Series,
        frequencies: &Frequencies,
        approach: Option<&Approach>,
    ) -> Trajectory {
        let duration = frequencies.duration();
        samples(&self.model, series, duration, approach, self.runs.period)
    }

    /// Returns the places of the parameters that count among the free ones.
    pub(super) fn chosen(&self) -> Result<Vec<usize>, ExciteError> {
        let free: Vec<&str> = self
            .free()
            .map(|parameter| parameter.name.as_str())
            .collect();
        let place = |name: &String| {
            free.iter().position(|other| other == name).ok_or_else(|| {
                let known = self.model.parameters().iter().find(|parameter| parameter.name == *name);
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
    pub(super) fn require_limits(&self) -> Result<(), ExciteError> {
        match missing_limit(&self.bounds, self.is_pd) {
            Some((joint, missing)) => {
                Err(ExciteError::no_limit(&self.model.joints()[joint], &missing))
            }
            None => Ok(()),
        }
    }

    pub(super) fn refused(&self, refused: &Refused) -> ExciteError {
        let duration = self.experiment.excite.duration_s;
        ExciteError::refused(refused, &self.model, &self.bounds, duration)
    }

    pub(super) fn robot(&self) -> (&Model, &[f64]) {
        (&self.model, &self.theta)
    }

    pub(super) fn links_condition_number(&self, information: &Information) -> Option<f64> {
        let places: Vec<usize> = (self.free().enumerate())
            .filter(|(_, parameter)| parameter.joint.is_none())
            .map(|(place, _)| place)
            .collect();
        (!places.is_empty()).then(|| information.condition_number(&places))
    }

    pub(super) fn approach(&self, series: &Series) -> Result<Option<Approach>, ExciteError> {
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

/// Returns the values of a design and the model with the friction laws of an identification.
fn values(
    model: Model,
    parameters: Option<&Parameters>,
    is_warm_up: bool,
    assumed: &mut Vec<String>,
) -> Result<(Model, Vec<f64>), SessionError> {
    if let Some(set) = parameters.and_then(|parameters| parameters.sets.first()) {
        let theta = model.theta(&set.values)?;
        return Ok((model.shaped(&set.values), theta));
    }
    match model.nominal() {
        Ok(theta) => Ok((model, theta)),
        Err(ModelError::Missing { .. }) if is_warm_up => {
            let theta = with_assumed_drives(&model, assumed)?;
            Ok((model, theta))
        }
        Err(ModelError::Missing { names }) => Err(ExciteError::Missing {
            names: names.join(", "),
        }
        .into()),
        Err(other) => Err(other.into()),
    }
}

/// Returns a robot that differs from the identified one twice as much as a draw, as a few draws differ by about one standard
/// error in the torques of a motion; the draw if such a robot cannot exist.
fn farther(model: &Model, theta: &[f64], draw: Theta) -> Theta {
    let twice: Theta = (draw.iter().zip(theta))
        .map(|(drawn, value)| value + FARTHER * (drawn - value))
        .collect();
    let is_possible = model.check_inertias(&twice).is_ok() && model.check_stiffness(&twice).is_ok();
    if is_possible { twice } else { draw }
}

/// Returns the limits; a first motion of an unknown robot uses a part of them.
fn bounds(experiment: &Experiment, is_warm_up: bool, assumed: &mut Vec<String>) -> Bounds {
    let bounds = Bounds::new(experiment);
    if !is_warm_up {
        return bounds;
    }
    assumed.push(format!(
        "the first motion uses {} % of the ranges of positions, {} % of the limits of torques and deflections, and {} % of those \
         of velocities, accelerations, jerks, rates of torques and the speed of the tool",
        100.0 * WARM_UP_POSITION,
        100.0 * WARM_UP_TORQUE,
        100.0 * WARM_UP
    ));
    let part = |what| match what {
        Limited::Position => WARM_UP_POSITION,
        Limited::Torque | Limited::Deflection => WARM_UP_TORQUE,
        Limited::Height => 1.0,
        Limited::Velocity
        | Limited::Acceleration
        | Limited::Jerk
        | Limited::TorqueRate
        | Limited::ToolSpeed => WARM_UP,
    };
    let parts = Limited::ALL.map(part);
    bounds.narrowed(&parts)
}

fn kinematics(experiment: &Experiment) -> Result<Option<Kinematics>, SessionError> {
    let settings = &experiment.excite;
    let tree = experiment.robot.tree.as_ref();
    let limited = [
        ("tool_speed_m_per_s", settings.tool_speed_m_per_s.is_some()),
        ("floor_m", settings.floor_m.is_some()),
    ];
    match (tree, limited.iter().find(|(_, is_limited)| *is_limited)) {
        (None, Some((key, _))) => Err(ExciteError::NoLengths { key }.into()),
        (None, None) => Ok(None),
        (Some(tree), _) => Ok(Some(Kinematics::new(
            tree,
            settings.tool_xyz_m,
            experiment.robot.gravity(),
        ))),
    }
}

/// Returns the errors that a design weights with.
fn errors(twin: &Simulate, model: &Model) -> Errors {
    let n = model.joint_count();
    let steps = |counts: &[u32]| -> Vec<f64> {
        (0..n)
            .map(|joint| {
                let turn = match model.kind(joint) {
                    JointKind::Revolute => std::f64::consts::TAU,
                    JointKind::Prismatic => 1.0,
                };
                turn / f64::from(counts.get(joint).copied().unwrap_or(COUNTS).max(1))
            })
            .collect()
    };
    let level = |list: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|joint| list.get(joint).copied().unwrap_or(0.0))
            .collect()
    };
    Errors {
        period: twin.period_s,
        steps: [
            steps(&twin.link_encoder_counts_per_turn),
            steps(&twin.motor_encoder_counts_per_turn),
        ],
        torque: level(&twin.torque_noise_nm),
        disturbances: [
            level(&twin.link_torque_disturbance_nm),
            level(&twin.torque_disturbance_nm),
        ],
        corner: Disturbance::CORNER_HZ,
    }
}
