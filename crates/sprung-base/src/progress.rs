//! Progress of a run, and the caller's answer to it.

/// Phase of a run, with the unit of its progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Phase {
    /// Reads the logs once; counted in samples.
    Reading,
    /// Chooses cut-off, delays, Stribeck velocities and weights for the estimation; counted in
    /// choices.
    Preparing,
    /// Estimates Stribeck velocities by maximum likelihood; counted in runs of the filter.
    FindingVelocities,
    /// Maximises the likelihood; counted in runs of the filter. The count restarts at 1 when an
    /// estimated delay has changed.
    Refining,
    /// Fits the simulated loop of a servo to the log; counted in simulations.
    FittingLoop,
    /// Tests the results: cross-checks and suspected faults; counted in tests.
    Examining,
    /// Simulates a digital twin; counted in samples.
    Simulating,
    /// Compares parameters with logs; counted in samples.
    Validating,
    /// Watches logs of a running robot; counted in samples.
    Watching,
    /// Compares results with each other; counted in results.
    Comparing,
    /// Designs an experiment; counted in steps of the search.
    Designing,
}

impl Phase {
    /// Returns the name of the phase for people.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Reading => "reading",
            Self::Preparing => "preparing",
            Self::FindingVelocities => "finding velocities",
            Self::Refining => "refining",
            Self::FittingLoop => "fitting the simulated loop",
            Self::Examining => "examining",
            Self::Simulating => "simulating",
            Self::Validating => "validating",
            Self::Watching => "watching",
            Self::Comparing => "comparing",
            Self::Designing => "designing",
        }
    }
}

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Current phase.
    pub phase: Phase,
    /// Work done in this phase, in the unit given at [`Phase`].
    pub done: u64,
    /// Total work of this phase, or its upper bound; `None` if it is unknown.
    pub total: Option<u64>,
    /// Expected duration of the phase, s. Only a report before a long phase contains it.
    pub expected_s: Option<f64>,
}

/// Answer of a listener.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The run continues.
    GoOn,
    /// The run ends with the error [`Stopped`] of its stage and returns no result.
    Stop,
}

/// The listener stopped the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped on request before the end")]
pub struct Stopped;

/// Receives the progress of a run, and may stop the run.
///
/// Every closure from [`Progress`] to [`Answer`] implements this trait. A run calls it before every
/// block of samples, every filter run of the refinement and every simulation.
pub trait Listener: Send {
    /// Receives the progress of the run, and answers whether the run continues.
    fn hear(&mut self, progress: Progress) -> Answer;

    /// Reports the progress of the run to the listener.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if the answer is [`Answer::Stop`].
    fn tell(&mut self, phase: Phase, done: u64, total: Option<u64>) -> Result<(), Stopped> {
        ask(
            self,
            Progress {
                phase,
                done,
                total,
                expected_s: None,
            },
        )
    }

    /// Reports the expected duration of a phase before it begins.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if the answer is [`Answer::Stop`].
    fn tell_expected(&mut self, phase: Phase, seconds: f64) -> Result<(), Stopped> {
        ask(
            self,
            Progress {
                phase,
                done: 0,
                total: None,
                expected_s: Some(seconds),
            },
        )
    }
}

fn ask(listener: &mut (impl Listener + ?Sized), progress: Progress) -> Result<(), Stopped> {
    match listener.hear(progress) {
        Answer::GoOn => Ok(()),
        Answer::Stop => Err(Stopped),
    }
}

impl<F: FnMut(Progress) -> Answer + Send> Listener for F {
    fn hear(&mut self, progress: Progress) -> Answer {
        self(progress)
    }
}

/// A listener that never stops the run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unheard;

impl Listener for Unheard {
    fn hear(&mut self, _: Progress) -> Answer {
        Answer::GoOn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listener_hears_and_stops() {
        let mut heard = Vec::new();
        let mut listener = |progress: Progress| {
            heard.push(progress.done);
            if progress.done < 2 {
                Answer::GoOn
            } else {
                Answer::Stop
            }
        };
        let listener: &mut dyn Listener = &mut listener;
        assert_eq!(listener.tell(Phase::Reading, 1, None), Ok(()));
        assert_eq!(listener.tell(Phase::Reading, 2, Some(2)), Err(Stopped));
        assert_eq!(heard, [1, 2]);
        assert_eq!(Unheard.tell(Phase::Comparing, 1, None), Ok(()));
        let mut expected = None;
        let mut listener = |progress: Progress| {
            expected = progress.expected_s;
            Answer::Stop
        };
        assert_eq!(listener.tell_expected(Phase::Refining, 90.0), Err(Stopped));
        assert_eq!(expected, Some(90.0));
    }
}
