//! Checks the windows of velocity estimators.

use super::fault::{Fault, fault};

pub(super) fn check_window(window: [usize; 2], path: &[&str]) -> Result<(), Fault> {
    let limit = sprung_core::velocity::LONGEST_WINDOW;
    match window.iter().find(|&&p| p >= limit) {
        Some(p) => Err(fault(
            path,
            format!(
                "a velocity window of {p} is too long; the longest is {}",
                limit - 1
            ),
        )),
        None => Ok(()),
    }
}
