//! Why no controller can be designed.

use sprung_method::control::ControlRefusal;

/// Why no controller can be designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// The robot is a position servo.
    #[error(
        "{joint} is a position servo, which takes no torques; sprung control designs controllers of torques"
    )]
    Servo {
        /// Name of the joint.
        joint: String,
    },
    /// The feedback needs springs.
    #[error(
        "the robot has no spring, and feedback = \"link-damping\" of [control] damps links on springs; \"state-feedback\" and \
         \"pd\" work for rigid joints"
    )]
    Rigid,
    /// The experiment declares no controller.
    #[error(
        "feedback = \"declared\" of [control] examines the loop of [controller], which the experiment lacks; add it, or let \
         sprung design \"state-feedback\" or \"pd\""
    )]
    NoController,
    /// The log was sampled more slowly.
    #[error(
        "period_s = {period_s} of [control] is shorter than the {log_s} s of the log, which says nothing about the robot above \
         {highest_hz:.4} Hz; give at least the period of the log, or identify from a faster one"
    )]
    Period {
        /// Requested period, s.
        period_s: f64,
        /// Period of the log, s.
        log_s: f64,
        /// Half the sampling rate of the log, Hz.
        highest_hz: f64,
    },
    /// The file of a path is not one.
    #[error(
        "{file}: {why}; give a CSV file with a header of the names of all joints and link positions in rad (m), within their \
         limits"
    )]
    Path {
        /// The file.
        file: String,
        /// What is wrong.
        why: String,
    },
    /// The robot cannot carry the payload.
    #[error(
        "the robot cannot carry the payload of [control]: {why}; describe the robot with urdf, dh_modified or dh_classic, and give one \
         of its links"
    )]
    Payload {
        /// What is wrong.
        why: String,
    },
    /// A file is no design.
    #[error(
        "{file} is not the control.json of a design: {why}; give the file that sprung control writes"
    )]
    NoDesign {
        /// The file.
        file: String,
        /// What is wrong with it.
        why: String,
    },
    /// The design is for another robot.
    #[error(
        "the controller was designed for {found}, and the experiment describes {expected}; design one for this robot"
    )]
    OtherRobot {
        /// Robot of the design.
        found: String,
        /// Robot of the experiment.
        expected: String,
    },
    /// The format has no controller.
    #[error("--control belongs to --format c and --format rust; {format} files have no controller")]
    NoCode {
        /// Name of the format.
        format: &'static str,
    },
    /// The shaper has no taps.
    #[error("the shaper of the design does not fit its period: {0}; design it again")]
    Shaper(String),
    /// The design has a payload.
    #[error(
        "the controller was designed for a payload, which the model in the code does not carry; design it without payload for \
         code"
    )]
    PayloadInCode,
    /// Values are missing.
    #[error("{0}; give --parameters FILE with an identification")]
    Values(String),
    /// No controller satisfies the requirements.
    #[error(transparent)]
    Refused(#[from] ControlRefusal),
}
