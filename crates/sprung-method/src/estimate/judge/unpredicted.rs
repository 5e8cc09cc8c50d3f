//! Joints whose torque or deflection a result does not predict.

use super::promise::percent;
use crate::estimate::result::{EstimateResult, JointPrediction};
use crate::finding::{Finding, Severity};
use crate::log::{Channels, Signal};
use crate::prepare::{Excerpt, noise};

/// Promised error of a torque or a deflection, relative to it, above which a result does not predict it.
const NOT_PREDICTED: f64 = 0.5;

/// A joint hardly moves if its position deviates from its mean by less than this multiple of the noise of its encoder.
const HARDLY: f64 = 100.0;

/// A deflection is significant if it exceeds this multiple of the noise of both encoders.
const SEEN: f64 = 3.0;

/// A joint is stiff if its deflection is less than this part of its motion: a robot of such joints is useful without springs.
const STIFF: f64 = 0.01;

/// Reports joints with a promised error above half of the torque or the deflection: serious, except for joints that
/// hardly move and for deflections of stiff joints whose springs the log does not show.
pub(in crate::estimate) fn unpredicted(
    result: &EstimateResult,
    joints: &[String],
    channels: &Channels,
    excerpt: &Excerpt,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    let large = |prediction: &JointPrediction| {
        let torque = prediction.torque_error_nm / prediction.torque_nm;
        let deflection = prediction
            .deflection_error_rad
            .zip(prediction.deflection_rad);
        let deflection = deflection.map_or(0.0, |(error, deflection)| error / deflection);
        [torque, deflection].map(|error| Some(error).filter(|error| *error > NOT_PREDICTED))
    };
    for promise in &result.promise {
        let Some(joint) = joints.iter().position(|name| *name == promise.joint) else {
            continue;
        };
        let motion = Motion {
            channels,
            excerpt,
            joint,
        };
        let [torque, deflection] = large(promise);
        let deflection =
            deflection.filter(|_| motion.shows(promise.deflection_rad.unwrap_or_default()));
        let errors: Vec<String> = [("torque", torque), ("deflection", deflection)]
            .into_iter()
            .filter_map(|(what, error)| Some(format!("{} of its {what}", percent(error?))))
            .collect();
        if errors.is_empty() {
            continue;
        }
        let errors = errors.join(" and ");
        let is_open = torque.is_none()
            && has_open_spring(result, &promise.joint)
            && motion.is_stiff(promise.deflection_rad.unwrap_or_default());
        findings.push(if is_open {
            Finding::new(
                Severity::Warning,
                "spring-not-shown",
                format!(
                    "{}: the log does not show the spring, for the interval of its stiffness contains zero. The promised error is {errors}; \
                     torques are predicted",
                    promise.joint
                ),
                "do not use the stiffness of this joint; a motion with larger accelerations shows more of it",
            )
        } else if motion.is_small() {
            Finding::new(
                Severity::Warning,
                "hardly-moves",
                format!(
                    "{}: the joint hardly moves in the log, and the promised error is {errors}. The verdict is about the \
                     other joints",
                    promise.joint
                ),
                "do not use the parameters of this joint; record a log in which it moves",
            )
        } else {
            Finding::new(
                Severity::Serious,
                "not-predicted",
                format!(
                    "{}: the promised error for a new experiment is {errors}, so the model does not predict this joint",
                    promise.joint
                ),
                "look at the fit over time, and at the findings about the log: a column, a delay or a law is wrong",
            )
        });
    }
    findings
}

/// Returns whether the interval of the stiffness of a joint contains zero.
fn has_open_spring(result: &EstimateResult, joint: &str) -> bool {
    let is_stiffness = |name: &str| name.strip_prefix(joint) == Some(".stiffness");
    let mut parameters = result.parameters.iter();
    parameters.any(|parameter| is_stiffness(&parameter.name) && parameter.one_sided)
}

/// Motion of a joint in the beginning of the first log.
struct Motion<'a> {
    channels: &'a Channels,
    excerpt: &'a Excerpt,
    joint: usize,
}

impl Motion<'_> {
    fn noise(&self, signal: Signal) -> Option<f64> {
        let channel = self.channels.telling(signal, self.joint)?;
        noise(self.excerpt, channel).map(|(deviation, _)| deviation)
    }

    fn is_small(&self) -> bool {
        let of = |signal: Signal| {
            let channel = self.channels.telling(signal, self.joint)?;
            Some(self.excerpt.deviation(channel) < HARDLY * self.noise(signal)?)
        };
        [Signal::Motor, Signal::Link]
            .into_iter()
            .find_map(of)
            .unwrap_or(false)
    }

    /// Returns whether a deflection, rad (m), is small beside the motion.
    fn is_stiff(&self, deflection: f64) -> bool {
        let motor = self.channels.telling(Signal::Motor, self.joint);
        motor.is_some_and(|channel| deflection < STIFF * self.excerpt.deviation(channel))
    }

    /// Returns whether the encoders show a deflection, rad (m).
    fn shows(&self, deflection: f64) -> bool {
        let both = [Signal::Motor, Signal::Link].map(|signal| self.noise(signal).unwrap_or(0.0));
        deflection > SEEN * both[0].hypot(both[1])
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::demo;
    use crate::description::{no_files, read};
    use crate::log::LogBlock;

    /// Returns the codes for a joint that moves by 1 rad and deflects by a part of it.
    ///
    /// - `torque_error`: promised, relative to the torque.
    fn codes(deflection: f64, one_sided: bool, torque_error: f64) -> Vec<String> {
        let experiment = read("experiment.toml", demo::EXPERIMENT, &[], &mut no_files).unwrap();
        let log = experiment.log.as_ref().unwrap();
        let channels = Channels::new(&experiment.robot, log).unwrap();
        let mut block = LogBlock::new(channels.all.len());
        block.time = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        for (column, channel) in block.values.iter_mut().zip(&channels.all) {
            let size = match channel.quantity.signal() {
                Signal::Link => 1.0 - deflection,
                _ => 1.0,
            };
            column.extend(block.time.iter().map(|time| size * (6.0 * time).sin()));
        }
        let mut excerpt = Excerpt::new(1e-3, 2);
        excerpt.push(&block);
        let result: EstimateResult = serde_json::from_value(json!({
            "estimator": "least-squares", "verdict": "good", "rank": 0, "condition_number": null,
            "condition_number_scaled": null, "residual_rms": {}, "relative_residual": {},
            "warnings": [], "elapsed_s": 0.0,
            "promise": [{
                "joint": "joint1", "torque_nm": 10.0, "torque_error_nm": 10.0 * torque_error,
                "deflection_rad": deflection, "deflection_error_rad": 0.9 * deflection,
            }],
            "parameters": [{
                "name": "joint1.stiffness", "symbol": "", "unit": "N·m/rad", "value": 1e4,
                "standard_error": 5e3, "ci95": [0.0, 2e4], "one_sided": one_sided, "nominal": null,
                "identifiable": true,
            }],
        }))
        .unwrap();
        let findings = unpredicted(&result, &["joint1".to_owned()], &channels, &excerpt);
        findings.into_iter().map(|finding| finding.code).collect()
    }

    #[test]
    fn only_a_stiff_spring_of_open_stiffness_whose_torque_is_predicted_is_not_shown() {
        assert_eq!(codes(0.002, true, 0.1), ["spring-not-shown"]);
        assert_eq!(codes(0.002, true, 0.8), ["not-predicted"]);
        assert_eq!(codes(0.002, false, 0.1), ["not-predicted"]);
        assert_eq!(codes(0.05, true, 0.1), ["not-predicted"]);
    }
}
