//! Why no experiment can be designed.

use sprung_core::chain::JointKind;
use sprung_method::excite::{Bounds, Broken, Limited, NoPose, Refused};
use sprung_model::Model;

/// Why no experiment can be designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExciteError {
    /// A joint has no limits.
    #[error(
        "{joint} has no limit of its {what}, so its motion has no end; add limits = {{ {keys} }} to its [[robot.joint]], \
         or to [robot.joint_defaults] for all joints"
    )]
    NoLimit {
        /// Name of the joint.
        joint: String,
        /// Quantities without limits.
        what: String,
        /// Keys with examples of values.
        keys: String,
    },
    /// No motion keeps a limit.
    #[error("{0}")]
    Refused(String),
    /// The closed loop runs away.
    #[error(
        "the closed loop with these values is unstable: a small motion grows {} within {time_s:.2} s; check the gains of \
         [controller], or bandwidth_hz of [excite] without one, and the nominal values",
        if *.runs_away { "without bound" } else { "by a factor of 2.7" }
    )]
    Unstable {
        /// Time, s.
        time_s: f64,
        /// Whether the simulated loop ran away within this time.
        runs_away: bool,
    },
    /// The values are not those of a robot that can exist.
    #[error(
        "no robot can have these values: {0}; correct the nominal values, or give --parameters FILE"
    )]
    Impossible(String),
    /// Values are missing.
    #[error(
        "these values have no nominal value: {names}; give them, --parameters FILE of an identification, or --warm-up for a \
         first small motion"
    )]
    Missing {
        /// Names of the parameters.
        names: String,
    },
    /// Masses are missing, which a first motion needs.
    #[error(
        "--warm-up needs the masses of the links, and {names} have no nominal value; give a URDF with masses, or nominal values"
    )]
    NoMasses {
        /// Names of the parameters.
        names: String,
    },
    /// A requested parameter does not exist, or no motion determines it.
    #[error("{why}; [excite] parameters takes names of these: {known}")]
    NotDetermined {
        /// The parameter, and why no motion determines it.
        why: String,
        /// Names of the parameters.
        known: String,
    },
    /// The tool has a limit, and the kinematics have no lengths.
    #[error(
        "{key} of [excite] needs the lengths of the links, and kinematics = \"planar-2r\" has none; describe the robot with urdf, dh_modified or dh_classic"
    )]
    NoLengths {
        /// The key.
        key: &'static str,
    },
    /// The motion does not determine a combination of parameters.
    #[error(
        "the motion that was found says nothing about some combination of parameters, so it has no standard errors; raise steps or \
         duration_s of [excite], or give known values in [robot.fixed]"
    )]
    NoBound,
    /// A file has no motion that can be judged.
    #[error(
        "{file} has no motion to judge: {why}; give reference.toml of sprung excite, or another file with sines in \
         [controller.reference]"
    )]
    NoReference {
        /// The file.
        file: String,
        /// What is wrong with it.
        why: String,
    },
    /// A file is no design.
    #[error(
        "{file} is not the excitation.json of a design of this robot: {why}; give the path of that file as promise of [excite], or leave it \
         out"
    )]
    NoDesign {
        /// The file.
        file: String,
        /// What is wrong with it.
        why: String,
    },
    /// The robot is a position servo.
    #[error(
        "{joint} is a position servo, whose log has no torque; sprung excite designs experiments with torques"
    )]
    Servo {
        /// Name of the joint.
        joint: String,
    },
}

impl ExciteError {
    /// Returns why no motion was found.
    pub(in crate::session) fn refused(
        refused: &Refused,
        model: &Model,
        bounds: &Bounds,
        duration: f64,
    ) -> Self {
        match refused {
            Refused::Motion(broken) if broken.runs_away => Self::Unstable {
                time_s: broken.time_s,
                runs_away: true,
            },
            Refused::Pose(pose) if !pose.place.is_finite() => Self::Unstable {
                time_s: duration,
                runs_away: true,
            },
            Refused::Pose(pose) => Self::Refused(of_pose(pose, model, bounds)),
            Refused::Motion(motion) => Self::Refused(of_motion(motion, model, bounds)),
        }
    }

    /// Returns why the robot does not reach the start.
    pub(in crate::session) fn approach(broken: &Broken, model: &Model, bounds: &Bounds) -> Self {
        Self::Refused(format!(
            "the robot cannot come from start_rad to the motion: {}",
            of_motion(broken, model, bounds)
        ))
    }

    /// Returns the error of a joint without limits.
    pub(in crate::session) fn no_limit(joint: &str, missing: &[Limited]) -> Self {
        let words: Vec<&str> = missing.iter().map(|limit| limit.word()).collect();
        let key = |limit: &Limited| match limit {
            Limited::Position => "position_rad = [-1.0, 1.0]".to_owned(),
            other => format!("{} = 1.0", other.key()),
        };
        let keys: Vec<String> = missing.iter().map(key).collect();
        Self::NoLimit {
            joint: joint.to_owned(),
            what: words.join(" and of its "),
            keys: keys.join(", "),
        }
    }
}

/// Returns the unit of a limited quantity of a joint.
pub(in crate::session) fn unit(what: Limited, model: &Model, joint: usize) -> String {
    let unit = what.unit();
    match (model.kind(joint), what) {
        (JointKind::Revolute, _) | (_, Limited::ToolSpeed | Limited::Height) => unit.to_owned(),
        (JointKind::Prismatic, Limited::Torque | Limited::TorqueRate) => unit.replace("N·m", "N"),
        (JointKind::Prismatic, _) => unit.replace("rad", "m"),
    }
}

/// Factor of a torque at rest with which a motion begins to be possible.
const ROOM: f64 = 1.06;

fn of_pose(pose: &NoPose, model: &Model, bounds: &Bounds) -> String {
    let name = &model.joints()[pose.joint];
    match pose.what {
        Limited::Height => format!(
            "no pose keeps all links and the tool above floor_m = {:.4} m; the best pose found is {:.3} m too low at {name}: \
             lower floor_m by that",
            bounds.floor.unwrap_or_default(),
            pose.place.max(1.0) - 1.0
        ),
        what => {
            let limit = bounds.joints[pose.joint].of(what);
            let why = if pose.place < 1.0 {
                "leaves no room for a motion within"
            } else {
                "keeps"
            };
            format!(
                "no pose {why} the {} of {name} at rest: the best pose found needs {:.0} % of its limit {:.4} {}; raise the \
                 limit to {:.4} {}, or allow other positions",
                what.word(),
                100.0 * pose.place,
                limit.half,
                unit(what, model, pose.joint),
                limit.half * pose.place * ROOM,
                unit(what, model, pose.joint),
            )
        }
    }
}

fn of_motion(broken: &Broken, model: &Model, bounds: &Bounds) -> String {
    let name = &model.joints()[broken.joint];
    if broken.what == Limited::Height {
        return format!(
            "no motion that was tried keeps {name} above floor_m = {:.4} m: it is at {:.4} m after {:.3} s; lower floor_m to \
             {:.4} m",
            bounds.floor.unwrap_or_default(),
            broken.value,
            broken.time_s,
            broken.value - 0.001
        );
    }
    let limit = match broken.what {
        Limited::ToolSpeed => bounds.tool_speed,
        what => bounds.joints[broken.joint].of(what),
    };
    let unit = unit(broken.what, model, broken.joint);
    if broken.what == Limited::Position {
        let [low, high] = [limit.middle - limit.half, limit.middle + limit.half];
        return format!(
            "the position of {name} is {:.4} {unit} after {:.3} s, outside of position_rad = [{low:.4}, {high:.4}]; widen the \
             limits, or change the motion",
            broken.value, broken.time_s
        );
    }
    format!(
        "the {} of {name} reaches {:.4} {unit} after {:.3} s, and its limit is {:.4} {unit}, also in the smallest motion that \
         was tried; raise it to {:.4} {unit}",
        broken.what.word(),
        broken.value,
        broken.time_s,
        limit.half,
        limit.half * broken.part * 1.02
    )
}
