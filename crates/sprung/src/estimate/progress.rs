//! How far an identification is.

/// A stage of an identification, and how far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Samples of the logs that were read so far; each log is read once for this.
    Samples(u64),
    /// A run of the refinement's filter begins; one takes as long as the part of the
    /// logs that is refined, times the parameters. Runs count from 1 again when a
    /// delay that is to be estimated has moved.
    FilterRun {
        /// Number of the run, from 1 on.
        run: usize,
        /// Runs after which the search gives up.
        most: usize,
    },
}
