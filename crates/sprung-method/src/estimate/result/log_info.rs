//! Figures of one log.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::{Experiment, Side, Window};

/// Figures of one log: timing, faulty samples, delays, signs and gains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "LogUsed")]
pub struct LogInfo {
    /// File name as the experiment gives it.
    pub file: String,
    /// Window of the file; absent for the whole file.
    #[serde(default, skip_serializing_if = "Window::is_whole")]
    pub window: Window,
    /// Number of samples.
    pub samples: u64,
    /// Sampling period, s.
    pub period_s: f64,
    /// Time between the first and the last sample, s.
    pub duration_s: f64,
    /// Time of the first sample since 1970, s; `None` if the times of the log are not dates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date_s: Option<f64>,
    /// Digits that logs with the same samples share; empty in results of earlier versions.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub digest: String,
    /// Largest deviation of a time step from the period, percent.
    pub jitter_percent: f64,
    /// Root mean square of these deviations, percent.
    #[serde(default)]
    pub jitter_rms_percent: f64,
    /// Kind of the sampling times: `even`, `on-cycle` or `as-stamped`.
    #[serde(default)]
    pub sampling: String,
    /// Cycle at whose multiples the samples were taken, s; `None` if there is no cycle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_s: Option<f64>,
    /// Number of samples in the file, or in its window.
    #[serde(default)]
    pub recorded: u64,
    /// Number of used samples that were interpolated.
    #[serde(default)]
    pub interpolated: u64,
    /// Number of missing samples. More than three missing samples in a row count as a gap instead.
    #[serde(default)]
    pub dropped: u64,
    /// Number of samples left out because they repeat the time of the previous sample.
    #[serde(default)]
    pub repeated: u64,
    /// Number of samples left out because a column has no value.
    #[serde(default)]
    pub without_value: u64,
    /// Number of samples that repeat all values of the previous sample although a joint moves.
    #[serde(default)]
    pub frozen: u64,
    /// Number of gaps. The filters restart after each gap.
    #[serde(default)]
    pub gaps: u64,
    /// Delays that were compensated, by column.
    #[serde(default)]
    pub delay_s: BTreeMap<String, DelayUsed>,
    /// Common delay of all motor torques that the refinement found, against torques that are held until the next sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torques_delay_s: Option<DelayUsed>,
    /// Signs that were estimated, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sign: BTreeMap<String, SignUsed>,
    /// Gains that were estimated, by column.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub gain: BTreeMap<String, GainUsed>,
    /// Side of the gearbox of the torque constants, if the motion determined it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_constant_side: Option<Side>,
}

/// A sign that was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignUsed {
    /// 1 or -1.
    pub value: f64,
    /// Logarithm of the likelihood with this sign minus that with the opposite sign.
    pub log_likelihood: f64,
}

/// A gain that was estimated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GainUsed {
    /// Factor by which the column was multiplied.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

impl LogInfo {
    /// Returns its file with its window, for messages.
    #[must_use]
    pub fn name(&self) -> String {
        self.window.of(&self.file)
    }

    /// Writes the estimated signs and gains and the side of the torque constants into a description that leaves them
    /// open.
    pub fn settle(&self, experiment: &mut Experiment) {
        if let Some(log) = &mut experiment.log {
            log.settle(&self.signs(), &self.gains());
        }
        if let Some(side) = self.torque_constant_side {
            experiment.robot.settle_torque_side(side);
        }
    }

    /// Returns the signs that were estimated, by column.
    #[must_use]
    pub fn signs(&self) -> BTreeMap<String, f64> {
        let signs = self.sign.iter();
        signs
            .map(|(name, sign)| (name.clone(), sign.value))
            .collect()
    }

    /// Returns the gains that were estimated, by column.
    #[must_use]
    pub fn gains(&self) -> BTreeMap<String, f64> {
        let gains = self.gain.iter();
        gains
            .map(|(name, gain)| (name.clone(), gain.value))
            .collect()
    }
}

/// A delay that was compensated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Delay")]
pub struct DelayUsed {
    /// Value, s.
    pub value: f64,
    /// Standard error, s, if it was estimated.
    pub standard_error: Option<f64>,
}
