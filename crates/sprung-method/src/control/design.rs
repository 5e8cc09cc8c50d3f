//! Design of a controller from identified values: margins, shaper and simulations.

use sprung_base::finding::GENERATOR;
use sprung_base::progress::{Listener, Phase};
use sprung_core::friction::Law;
use sprung_core::parameters::{JointParameter, Side};

use super::bandwidth::feedback;
use super::bode::loop_curves;
use super::judge::{Seen, drawn, identified, look};
use super::motions::Designed;
use super::pictures::{ControlPictures, PoleInPose};
use super::proof::prove;
use super::refusal::ControlRefusal;
use super::result::{
    CONTROL_FORMAT, ControlDesign, DesignedController, LoopMargins, Motors, WithDraws,
};
use super::shapers::{ShaperDesign, ShaperSettings, design_shaper};
use super::task::{ControlTask, whole_gain};
use super::vibrations::{regions, vibrations};
use crate::description::{Controller, ControllerKind};
use crate::simulate::Trajectory;

/// Largest residual vibration with a shaper, as a part of that without it.
const LARGEST_RESIDUAL: f64 = 0.05;

/// Velocity of friction compensation without a reference, rad/s (m/s), and with one as a part of the root mean square velocity of
/// its slowest joint that moves.
const COMPENSATION_SPEED: f64 = 0.02;
const COMPENSATION_SPEED_PART: f64 = 0.1;

/// Multiple of the highest frequency of a spring up to which poles are shown.
const SHOWN: f64 = 4.0;

/// Vibrations that a shaper removes without feedforward.
const MODES: usize = 2;

/// Samples of a reference from which its velocity is computed.
const SAMPLES: usize = 2000;

/// A designed controller with the curves of its report.
#[derive(Clone, Debug, PartialEq)]
pub struct Controlled {
    /// What is written to JSON.
    pub design: ControlDesign,
    /// Curves.
    pub pictures: ControlPictures,
}

/// Designs a controller, examines its loop over poses and robots of the posterior, and simulates it.
///
/// - `assumed`: sentences about the assumptions of the caller.
/// - `verdict`: word of the verdict on the values.
///
/// # Errors
///
/// [`ControlRefusal`] if the margins or the limits of the torques do not hold, the loop of a declared controller is unstable, no
/// shaper exists, no robot can have the values, or the listener stops the design.
pub fn design_control(
    task: &ControlTask<'_>,
    robot: &str,
    verdict: Option<String>,
    mut assumed: Vec<String>,
    progress: &mut dyn Listener,
) -> Result<Controlled, ControlRefusal> {
    progress.tell(Phase::Designing, 0, Some(3))?;
    let speed = compensation_speed(task);
    let (controller, bandwidth) =
        if let Some(declared) = task.declared.filter(|_| task.is_declared()) {
            (declared.clone(), None)
        } else {
            let found = feedback(task, speed)?;
            (found.controller, Some(found.bandwidth))
        };
    progress.tell(Phase::Designing, 1, Some(3))?;
    let cases = [identified(task), drawn(task)].concat();
    let seen = look(task, &controller, &cases);
    let growing = seen
        .iter()
        .find_map(|view| Some((view, view.stability.growth_per_s?)));
    if let Some((view, rate)) = growing {
        return Err(ControlRefusal::Unstable {
            pose_rad: task.poses[view.pose].clone(),
            time_s: 1.0 / rate,
        });
    }
    if seen.iter().all(|view| view.robot != 0) {
        return Err(ControlRefusal::Impossible);
    }
    progress.tell(Phase::Designing, 2, Some(3))?;
    let vibrations = vibrations(task.model, &seen, task.poses.len());
    let has_feedforward = controller.kind == ControllerKind::StateFeedback;
    let shaper = shaper(task, has_feedforward, &seen, &mut assumed)?;
    let impulses: Vec<[f64; 2]> = (shaper.iter())
        .flat_map(|shaper| {
            shaper
                .impulses
                .iter()
                .map(|impulse| [impulse.time_s, impulse.amplitude])
        })
        .collect();
    let lowest = vibrations
        .iter()
        .find(|vibration| vibration.motors == Motors::Controlled);
    let mut pictures = ControlPictures {
        loops: loop_curves(task, &controller),
        poles: poles(&seen),
        ..ControlPictures::default()
    };
    let designed = Designed {
        controller: &controller,
        shaper: &impulses,
        lowest_hz: lowest.map(|lowest| lowest.all.hz),
    };
    let proof = prove(task, designed, &mut pictures, progress)?;
    let design = ControlDesign {
        format: CONTROL_FORMAT,
        generator: GENERATOR.to_owned(),
        robot: robot.to_owned(),
        joints: task.model.joints().to_vec(),
        verdict,
        has_payload: task.settings.payload.is_some(),
        controller: written(task, &controller, impulses),
        bandwidth,
        loops: loops(task, &seen),
        least_damping: least(&seen, |view| view.stability.least_damping),
        poses: task.poses.to_vec(),
        draws: task.draws.len(),
        vibrations,
        shaper,
        proof,
        assumed,
    };
    Ok(Controlled { design, pictures })
}

/// Returns the velocity within which the compensation of friction changes its direction; `None` without compensation.
fn compensation_speed(task: &ControlTask<'_>) -> Option<f64> {
    let is_friction =
        |term: &sprung_core::drives::Term| matches!(term.what, JointParameter::Friction(..));
    if !task.model.robot().terms.iter().any(is_friction) {
        return None;
    }
    if let Some(speed) = task.settings.friction_compensation_speed_rad_per_s {
        return (speed > 0.0).then_some(speed);
    }
    let Some(reference) = task.reference else {
        return Some(COMPENSATION_SPEED);
    };
    let motion = Trajectory::new(reference, task.model);
    let n = task.model.joint_count();
    let (mut states, mut squares) = (vec![[0.0; 5]; n], vec![0.0; n]);
    for k in 0..SAMPLES {
        motion.at(
            task.twin.duration_s * k as f64 / SAMPLES as f64,
            &mut states,
        );
        for (sum, state) in squares.iter_mut().zip(&states) {
            *sum += state[1] * state[1] / SAMPLES as f64;
        }
    }
    let moving = squares.into_iter().filter(|square| *square > 0.0);
    let slowest = moving.map(f64::sqrt).fold(f64::INFINITY, f64::min);
    Some(if slowest.is_finite() {
        COMPENSATION_SPEED_PART * slowest
    } else {
        COMPENSATION_SPEED
    })
}

/// Designs the shaper for the light vibrations of the loop; `None` if there are none or none is wanted.
fn shaper(
    task: &ControlTask<'_>,
    has_feedforward: bool,
    seen: &[Seen],
    assumed: &mut Vec<String>,
) -> Result<Option<ShaperDesign>, ControlRefusal> {
    let other = if has_feedforward { 0 } else { MODES };
    let modes = task.settings.shaper_modes.unwrap_or(other);
    if modes == 0 {
        return Ok(None);
    }
    let sticking: Vec<bool> = (0..task.model.joint_count())
        .map(|joint| sticks(task, joint))
        .collect();
    let regions = regions(seen, modes, &sticking);
    if regions.is_empty() {
        assumed.push(
            "the loop damps its vibrations by 30 % or more in all poses, so no input shaper is needed".to_owned(),
        );
        return Ok(None);
    }
    let settings = ShaperSettings {
        level: LARGEST_RESIDUAL,
        part: 0.95,
        period: task.period,
    };
    let design = design_shaper(&regions, &settings)?;
    if !design.reached {
        assumed.push(format!(
            "no shaper leaves at most {:.0} % of the vibration in all poses; the shaper of the design leaves {:.1} %. A shaper for \
             the poses of one path leaves less: give path in [control]",
            100.0 * LARGEST_RESIDUAL,
            design.largest_percent
        ));
    }
    Ok(Some(design))
}

/// Deflection of a spring, rad (m), whose torque the dry friction of a sticking motor holds.
const STICKS: f64 = 0.05;

/// Returns whether dry friction holds the motor of a joint while its link vibrates.
fn sticks(task: &ControlTask<'_>, joint: usize) -> bool {
    let value = |kind| {
        task.model
            .index(kind, joint)
            .map_or(0.0, |index| task.theta[index])
    };
    let dry = value(JointParameter::Friction(Side::Motor, Law::Coulomb));
    dry > STICKS * value(JointParameter::Stiffness)
}

/// Returns the poles that vibrate, without those of the velocity estimators: up to some multiple of the springs' frequencies.
fn poles(seen: &[Seen]) -> Vec<PoleInPose> {
    let springs = seen
        .iter()
        .flat_map(|view| view.springs.iter().flatten().flatten());
    let highest = springs.map(|[hz, _]| SHOWN * hz).fold(0.0, f64::max);
    (seen.iter())
        .flat_map(|view| {
            let poles = view.stability.vibrations.iter();
            let shown = poles.filter(move |pole| highest <= 0.0 || pole.hz <= highest);
            shown.map(|pole| PoleInPose {
                hz: pole.hz,
                damping: pole.damping,
                is_identified: view.robot == 0,
            })
        })
        .collect()
}

fn least(seen: &[Seen], value: impl Fn(&Seen) -> f64) -> WithDraws {
    let over = |all: &mut dyn Iterator<Item = &Seen>| all.map(&value).fold(f64::INFINITY, f64::min);
    WithDraws {
        identified: over(&mut seen.iter().filter(|view| view.robot == 0)),
        worst: over(&mut seen.iter()),
    }
}

fn loops(task: &ControlTask<'_>, seen: &[Seen]) -> Vec<LoopMargins> {
    (task.model.joints().iter().enumerate())
        .map(|(joint, name)| {
            let gain = least(seen, |view| view.stability.margins[joint].gain_db);
            let crossover = seen.iter().find(|view| view.robot == 0);
            LoopMargins {
                joint: name.clone(),
                gain_db: gain.worst.is_finite().then_some(WithDraws {
                    // JSON has no number for an unbounded figure.
                    identified: if gain.identified.is_finite() {
                        gain.identified
                    } else {
                        gain.worst
                    },
                    ..gain
                }),
                phase_deg: least(seen, |view| view.stability.margins[joint].phase_deg),
                crossover_hz: crossover.map_or(0.0, |crossover| {
                    crossover.stability.margins[joint].crossover_hz
                }),
            }
        })
        .collect()
}

fn written(
    task: &ControlTask<'_>,
    controller: &Controller,
    shaper: Vec<[f64; 2]>,
) -> DesignedController {
    DesignedController {
        feedback: task.settings.feedback.word().to_owned(),
        period_s: task.period,
        velocity_window: controller.velocity_window,
        has_feedforward: controller.kind == ControllerKind::StateFeedback,
        friction_compensation_speed_rad_per_s: controller.friction_compensation_speed_rad_per_s,
        gain: whole_gain(controller, task.model.joint_count()),
        shaper,
        torque_limits_nm: (task.torque_limits.iter())
            .map(|limit| limit.is_finite().then_some(*limit))
            .collect(),
    }
}
