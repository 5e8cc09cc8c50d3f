//! The state of the filter: coordinates, velocities, and one slow disturbance of each row.

/// States of a row: its coordinate, its velocity and its disturbance.
const STATES_PER_ROW: usize = 3;

/// Returns the number of states.
pub(super) fn state_count(rows: usize) -> usize {
    STATES_PER_ROW * rows
}

/// Returns how many states are coordinates and velocities.
pub(super) fn moving_states(states: usize) -> usize {
    2 * states / STATES_PER_ROW
}

/// Returns the number of entries of a transition: moving states by all states.
pub(super) fn transition_size(rows: usize) -> usize {
    2 * rows * state_count(rows)
}
