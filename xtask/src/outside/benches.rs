//! The benchmarks of cargo: each runs to its end.

use crate::binaries::build;
use crate::install::hdf5;
use crate::run::Outcome;
use crate::steps::cargo;
use crate::test::features;

/// Builds the benchmarks as the tests are built, and runs each as a test: once and with little work.
pub(super) fn check() -> Option<()> {
    let benches = build(cargo(), &["--workspace", "--bench", "*", features(hdf5())])?;
    let outcome = Outcome::of(&benches);
    outcome.failed.is_empty().then_some(())
}
