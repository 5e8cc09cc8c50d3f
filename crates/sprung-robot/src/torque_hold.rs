//! The time for which a logged motor torque acts.

use schemars::JsonSchema;
use serde::Deserialize;

use super::known_words::choose;
use crate::numbers::in_ms;

/// Largest relative distance of two periods from a multiple of each other: time stamps give that of a log.
const SAME_RATIO: f64 = 0.01;

/// Meaning of a logged motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(try_from = "String")]
#[schemars(extend("enum" = ["held", "mean", "instantaneous"]))]
pub enum TorqueReading {
    /// It acts from its time stamp on, for one period of the controller.
    Held,
    /// The mean over one period of the controller, in the middle of which is the time stamp.
    Mean,
    /// The torque at the time stamp.
    Instantaneous,
}

impl TryFrom<String> for TorqueReading {
    type Error = String;

    fn try_from(word: String) -> Result<Self, String> {
        let index = choose("torque", &word, &["held", "mean", "instantaneous"])?;
        Ok([Self::Held, Self::Mean, Self::Instantaneous][index])
    }
}

/// What a description says about the time for which logged motor torques act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueHold {
    /// Meaning of the logged torques.
    pub reading: TorqueReading,
    /// Period of the controller, s, if it is given.
    pub controller_period: Option<f64>,
}

impl TorqueHold {
    /// Returns its lines of the description.
    #[must_use]
    pub fn words(&self) -> String {
        let reading = match self.reading {
            TorqueReading::Held => "torque = \"held\"",
            TorqueReading::Mean => "torque = \"mean\"",
            TorqueReading::Instantaneous => "torque = \"instantaneous\"",
        };
        match self.controller_period {
            Some(period) => format!("{reading}, controller_period_s = {period}"),
            None => reading.to_owned(),
        }
    }

    /// Returns the time for which a torque stays the same within a period of the log, s.
    ///
    /// - `period`: of the log, s.
    #[must_use]
    pub fn hold(&self, period: f64) -> f64 {
        let unsaid = match self.reading {
            TorqueReading::Held => period,
            TorqueReading::Mean | TorqueReading::Instantaneous => 0.0,
        };
        self.controller_period.unwrap_or(unsaid).min(period)
    }

    /// Returns the time for which torques are held, in periods of the log, by their delay, where a description says nothing. A torque
    /// acts, on average, half of the controller's period after its stamp, or before it if the log has the previous one.
    ///
    /// ```text
    /// h = |T − 2 d|, at most T
    /// ```
    ///
    /// - `delay`: d/T.
    #[must_use]
    pub fn hold_by_delay(delay: f64) -> f64 {
        (1.0 - 2.0 * delay).abs().min(1.0)
    }

    /// Returns whether the log lacks torques, because the controller has several periods in one of the log.
    ///
    /// - `period`: of the log, s.
    #[must_use]
    pub fn lacks_torques(&self, period: f64) -> bool {
        self.hold(period) < (1.0 - SAME_RATIO) * period
    }

    /// Returns the delay of the logged torques relative to torques that are held from their time stamp to the next one,
    /// s.
    ///
    /// ```text
    /// held  (T − h)/2        mean, instantaneous  T/2        h: hold
    /// ```
    ///
    /// - `period`: of the log, T, s.
    #[must_use]
    pub fn delay(&self, period: f64) -> f64 {
        match self.reading {
            TorqueReading::Held => 0.5 * (period - self.hold(period)),
            TorqueReading::Mean | TorqueReading::Instantaneous => 0.5 * period,
        }
    }

    /// Returns the reason why a period of the controller does not fit that of a log, and the remedy; `None` if it does.
    ///
    /// - `period`: of the log, s.
    #[must_use]
    pub fn conflict(&self, period: f64) -> Option<String> {
        let controller_period = self.controller_period?;
        let ratio = (period / controller_period).max(controller_period / period);
        if (ratio / ratio.round() - 1.0).abs() < SAME_RATIO {
            return None;
        }
        Some(format!(
            "controller_period_s is {:.4} ms, which is no multiple and no fraction 1/n of the period of the log, {:.4} ms; \
             correct controller_period_s in [log], or remove it together with torque: sprung then finds the timing of the \
             torques",
            in_ms(controller_period),
            in_ms(period)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 4e-3;

    fn hold(reading: TorqueReading, controller_period: Option<f64>) -> TorqueHold {
        TorqueHold {
            reading,
            controller_period,
        }
    }

    #[test]
    fn a_torque_acts_after_its_stamp_for_half_of_its_hold() {
        for (reading, controller, acts) in [
            (TorqueReading::Held, None, 2e-3),
            (TorqueReading::Held, Some(4e-3), 2e-3),
            (TorqueReading::Held, Some(1e-3), 0.5e-3),
            // The log has each torque twice.
            (TorqueReading::Held, Some(8e-3), 2e-3),
            (TorqueReading::Mean, Some(1e-3), 0.0),
            (TorqueReading::Mean, None, 0.0),
            (TorqueReading::Instantaneous, None, 0.0),
        ] {
            let delay = hold(reading, controller).delay(PERIOD);
            assert!(
                (0.5 * PERIOD - delay - acts).abs() < 1e-15,
                "{reading:?} {controller:?}: {delay}"
            );
        }
    }

    #[test]
    fn periods_that_are_no_multiples_are_refused() {
        let conflict = |controller| hold(TorqueReading::Held, Some(controller)).conflict(PERIOD);
        for controller in [1e-3, 2e-3, 4.01e-3, 8e-3] {
            assert!(conflict(controller).is_none(), "{controller}");
        }
        for controller in [1.5e-3, 3e-3, 6e-3] {
            let message = conflict(controller).unwrap();
            assert!(message.contains("4.0000 ms"), "{message}");
        }
    }
}
