//! Points where tests kill the program while it writes results.

/// Kills the program if `SPRUNG_HALT` is the number of this point: 1 for the first that a run reaches.
///
/// The point is printed for the test. `abort` drops no value, like `SIGKILL`.
#[cfg(debug_assertions)]
pub(crate) fn at(point: &str) {
    use std::io::Write;
    use std::sync::atomic::{AtomicUsize, Ordering};

    static REACHED: AtomicUsize = AtomicUsize::new(0);
    let Some(wanted) = std::env::var_os("SPRUNG_HALT") else {
        return;
    };
    let reached = 1 + REACHED.fetch_add(1, Ordering::Relaxed);
    if wanted.to_str().and_then(|wanted| wanted.parse().ok()) == Some(reached) {
        let _ = writeln!(std::io::stderr(), "halted at {point}");
        std::process::abort();
    }
}

/// Has no effect in programs for users.
#[cfg(not(debug_assertions))]
pub(crate) fn at(_point: &str) {}
