//! Progress of simulations that run side by side.

use std::sync::Mutex;

use crate::progress::{Listener, Phase, Stopped};

/// Tells of each simulation, whichever thread it runs in.
pub(super) struct Told<'a>(Mutex<State<'a>>);

struct State<'a> {
    listener: &'a mut dyn Listener,
    simulations: u64,
    outcome: Result<(), Stopped>,
}

impl<'a> Told<'a> {
    /// Returns one that has told nothing.
    pub(super) fn new(listener: &'a mut dyn Listener) -> Self {
        Self(Mutex::new(State {
            listener,
            simulations: 0,
            outcome: Ok(()),
        }))
    }

    /// Tells that a simulation begins.
    ///
    /// # Errors
    ///
    /// [`Stopped`] from the first answer on that says so.
    pub(super) fn begins(&self) -> Result<(), Stopped> {
        // The lock is lost where the listener panicked.
        let mut state = self.0.lock().map_err(|_| Stopped)?;
        state.outcome?;
        state.simulations += 1;
        let simulations = state.simulations;
        state.outcome = state.listener.tell(Phase::FittingLoop, simulations, None);
        state.outcome
    }

    /// Returns whether the caller stopped it.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if so.
    pub(super) fn outcome(&self) -> Result<(), Stopped> {
        self.0.lock().map_err(|_| Stopped)?.outcome
    }
}
