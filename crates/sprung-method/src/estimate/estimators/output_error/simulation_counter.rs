//! Progress of simulations that run in parallel.

use std::sync::Mutex;

use crate::progress::{Listener, Phase, Stopped};

/// Counts simulations of all threads and reports them to the listener.
pub(super) struct SimulationCounter<'a>(Mutex<State<'a>>);

struct State<'a> {
    listener: &'a mut dyn Listener,
    simulations: u64,
    outcome: Result<(), Stopped>,
}

impl<'a> SimulationCounter<'a> {
    /// Returns a counter before the first simulation.
    pub(super) fn new(listener: &'a mut dyn Listener) -> Self {
        Self(Mutex::new(State {
            listener,
            simulations: 0,
            outcome: Ok(()),
        }))
    }

    /// Reports the start of a simulation.
    ///
    /// # Errors
    ///
    /// [`Stopped`] after the listener has requested a stop.
    pub(super) fn start_simulation(&self) -> Result<(), Stopped> {
        // The lock is poisoned if the listener panicked.
        let mut state = self.0.lock().map_err(|_| Stopped)?;
        state.outcome?;
        state.simulations += 1;
        let simulations = state.simulations;
        state.outcome = state.listener.tell(Phase::FittingLoop, simulations, None);
        state.outcome
    }

    /// Returns an error if the listener has requested a stop.
    ///
    /// # Errors
    ///
    /// [`Stopped`] in this case.
    pub(super) fn outcome(&self) -> Result<(), Stopped> {
        self.0.lock().map_err(|_| Stopped)?.outcome
    }
}
