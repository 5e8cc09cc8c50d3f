//! The contents of `watch.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::finding::Finding;

/// What happened on a running robot; format 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Watch {
    /// Version of the file format; 1.
    pub format: u32,
    /// Program and version that wrote the file.
    pub generator: String,
    /// Name of the robot.
    pub robot: String,
    /// Origin of the parameters.
    pub parameters: String,
    /// Whether the verdict of the parameters is *unusable*, and they were accepted nevertheless.
    #[serde(default)]
    pub accepted_unusable: bool,
    /// False alarms that the thresholds promise, in one hour of all joints together, 1/h.
    pub false_alarms_per_h: f64,
    /// Sampling period of the healthy logs, s.
    pub period_s: f64,
    /// Bandwidth of the torques from outside, rad/s.
    pub bandwidth_rad_per_s: f64,
    /// Cut-off of the three filters of all signals before, rad/s: the healthy logs show the smallest sudden torques with it.
    pub cutoff_rad_per_s: f64,
    /// Logs of the healthy robot from which the thresholds were learned.
    pub learned_from: Vec<String>,
    /// Duration of these logs, s.
    pub learned_s: f64,
    /// One entry per joint, base first.
    pub joints: Vec<WatchedJoint>,
    /// One entry per log that was watched.
    pub logs: Vec<WatchedLog>,
    /// What happened, in the order of time.
    pub events: Vec<WatchEvent>,
}

impl Watch {
    /// Returns what was watched, in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let promise = format!(
            "thresholds of {} false alarms per hour, learned from {:.0} s of healthy motion",
            self.false_alarms_per_h, self.learned_s
        );
        let open = self
            .joints
            .iter()
            .filter(|joint| joint.threshold_sigma.is_none());
        let open: Vec<&str> = open.map(|joint| joint.joint.as_str()).collect();
        let unknown = if open.is_empty() {
            String::new()
        } else {
            let joints = open.join(", ");
            format!(
                " Contacts of {joints} are not seen: the healthy logs are too short for a threshold."
            )
        };
        if self.logs.is_empty() {
            return format!("No log was watched; {promise}.{unknown}");
        }
        let seconds: f64 = (self.logs.iter())
            .map(|log| log.duration_s - log.blind_s)
            .sum();
        let contacts = (self.events.iter())
            .filter(|event| event.torque_nm.is_some())
            .count();
        let others = self.events.len() - contacts;
        format!(
            "{seconds:.0} s watched, contacts: {contacts}, other events: {others}; {promise}.{unknown}"
        )
    }
}

/// The thresholds of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WatchedJoint {
    /// Name of the joint.
    pub joint: String,
    /// Share of the residual of the motor's equation in the torque from outside: 0 for link encoders alone, 1 for the sum of both
    /// equations, which does not need the spring.
    pub motor_share: f64,
    /// Coefficients of the variance of the torque from outside, (N·m)²: of one, and of the squares of velocity (rad/s), torque
    /// (N·m), acceleration (rad/s²) and nearness of a reversal (0 to 1).
    pub variance: Vec<f64>,
    /// Deviation of the torque from outside by another zero of an encoder, until the joint has moved in both directions and the
    /// zero is known, N·m (N).
    #[serde(default)]
    pub zero_nm: f64,
    /// Threshold in standard deviations; absent if the healthy logs are too short to know it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold_sigma: Option<f64>,
    /// Threshold in the typical state of the healthy logs, N·m (N); absent if it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub typical_threshold_nm: Option<f64>,
}

/// A log that was watched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WatchedLog {
    /// Name of the log.
    pub log: String,
    /// Duration, s.
    pub duration_s: f64,
    /// Time without thresholds, because the filters settled or a channel showed nothing, s.
    pub blind_s: f64,
}

/// Something that happened on a running robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WatchEvent {
    /// Name of the log.
    pub log: String,
    /// First time at which it was seen, s, on the time axis of the log.
    pub begins_s: f64,
    /// Last time at which it was seen, s.
    pub ends_s: f64,
    /// Name of the joint; absent if it is of several joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Largest torque from outside with its sign, N·m (N); absent for what is no contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_nm: Option<f64>,
    /// Threshold at that time, N·m (N); absent for what is no contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold_nm: Option<f64>,
    /// What happened.
    pub finding: Finding,
}
