//! How far a run is, and whether it is to go on.

/// What a run is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Phase {
    /// The logs are read once; counted in samples.
    Reading,
    /// What an estimate begins with is chosen: cut-off, delays, Stribeck velocities, weights;
    /// counted in choices.
    Preparing,
    /// The likelihood is asked for delays; counted in runs of the filter.
    FindingDelays,
    /// The refinement searches; counted in runs of the filter. Runs count from 1 again where a
    /// delay that is to be estimated has moved.
    Refining,
    /// The simulated loop is fitted to the log (output error); counted in simulations.
    FittingLoop,
    /// What is found is looked at again: cross-checks and suspicions; counted in looks.
    Examining,
    /// A digital twin runs; counted in samples.
    Simulating,
    /// Parameters are compared with logs; counted in samples.
    Validating,
    /// Results are compared with each other; counted in results.
    Comparing,
}

impl Phase {
    /// Returns what the run is doing, in words.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Reading => "reading",
            Self::Preparing => "preparing",
            Self::FindingDelays => "finding delays",
            Self::Refining => "refining",
            Self::FittingLoop => "fitting the simulated loop",
            Self::Examining => "examining",
            Self::Simulating => "simulating",
            Self::Validating => "validating",
            Self::Comparing => "comparing",
        }
    }
}

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// What it is doing.
    pub phase: Phase,
    /// How much of that is done; [`Phase`] says what is counted.
    pub done: u64,
    /// How much there is to do, or the most that there may be, where it is known.
    pub total: Option<u64>,
}

/// What a listener answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The run goes on.
    GoOn,
    /// The run ends with the error [`Stopped`] of its stage and leaves no result.
    Stop,
}

/// A run was stopped by who listens to its progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end, as was asked for; earlier results are as they were")]
pub struct Stopped;

/// Hears how far a run is, and may stop it.
///
/// Every closure from [`Progress`] to [`Answer`] is one. A run asks before every block of samples,
/// every run of the refinement's filter and every simulation.
pub trait Listener: Send {
    /// Hears how far the run is, and answers whether it goes on.
    fn hear(&mut self, progress: Progress) -> Answer;

    /// Tells how far the run is.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if the answer is [`Answer::Stop`].
    fn tell(&mut self, phase: Phase, done: u64, total: Option<u64>) -> Result<(), Stopped> {
        match self.hear(Progress { phase, done, total }) {
            Answer::GoOn => Ok(()),
            Answer::Stop => Err(Stopped),
        }
    }
}

impl<F: FnMut(Progress) -> Answer + Send> Listener for F {
    fn hear(&mut self, progress: Progress) -> Answer {
        self(progress)
    }
}

/// Nobody listens: the run goes on to its end.
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
    }
}
