//! Records a simulated experiment as a log.

use std::io::Write;

use super::closed_loop::{Diverged, LoopError};
use super::sensors::InertialSensorsOfTwin;
use super::twin::{Twin, TwinSetup};
use crate::log::{Channels, LogWriter};
use crate::progress::{Listener, Phase, Stopped};

/// Errors of recording a twin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The loop cannot be built.
    #[error(transparent)]
    Loop(#[from] LoopError),
    /// The loop runs away.
    #[error("{0}; check the controller's gains against the parameters of the twin")]
    Diverged(#[from] Diverged),
    /// A channel of the log has a delay, but the twin's sensors have no delays.
    #[error(
        "[log] gives \"{column}\" a delay, but the twin records without delays; remove the column from \
         delay_s"
    )]
    Delayed {
        /// Name of the column.
        column: String,
    },
    /// The log has other torques than the twin, which records the torque that acts until the next sample.
    #[error(
        "[log] gives {words}, but the twin records the torque that acts until its next sample, {period} s later; remove \
         torque and controller_period_s"
    )]
    OtherTorques {
        /// Lines of the description.
        words: String,
        /// Period of the twin's log, s.
        period: f64,
    },
    /// The log cannot be written.
    #[error("cannot write the log: {0}")]
    Write(#[from] std::io::Error),
    /// The caller stopped the simulation.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Samples between two progress calls: about ten milliseconds of work.
const SAMPLES_PER_PROGRESS_CALL: u64 = 1024;

/// Runs a twin and writes its log in the columns and units of `channels`.
///
/// - `progress`: receives the number of samples written so far.
///
/// Returns the number of samples.
///
/// # Errors
///
/// [`RecordError`] if the loop cannot run or the log cannot be written.
pub fn record(
    setup: &TwinSetup<'_>,
    channels: &Channels,
    write: impl Write,
    progress: &mut dyn Listener,
) -> Result<u64, RecordError> {
    if let Some(channel) = channels.all.iter().find(|c| c.delay.is_some()) {
        return Err(RecordError::Delayed {
            column: channel.column.clone(),
        });
    }
    let period = setup.settings.period_s;
    if let Some(hold) = channels.torque_hold
        && hold.delay(period) > 0.0
    {
        return Err(RecordError::OtherTorques {
            words: hold.words(),
            period,
        });
    }
    let mut twin = Twin::new(setup)?;
    let sensors = channels.inertial.as_ref();
    let mut sensors = sensors.map(|sensors| InertialSensorsOfTwin::new(sensors, setup.settings));
    let mut log = LogWriter::new(write, channels)?;
    let samples = (setup.settings.duration_s / period).round().max(1.0) as u64;
    for k in 1..=samples {
        let sample = twin.sample()?;
        let [q, dq, ddq] = &sample.motion;
        let readings =
            (sensors.as_mut()).map_or_else(Vec::new, |sensors| sensors.read([q, dq, ddq]));
        log.write(
            sample.time,
            [&sample.q, &sample.phi],
            [&sample.tau, &sample.spring],
            &readings,
            &sample.covariates,
        )?;
        if k.is_multiple_of(SAMPLES_PER_PROGRESS_CALL) {
            progress.tell(Phase::Simulating, k, Some(samples))?;
        }
    }
    log.finish()?;
    Ok(samples)
}
