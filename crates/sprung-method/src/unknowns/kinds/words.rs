//! Words that the findings about all kinds share.

use crate::unknowns::found::Telling;

/// Returns what else may explain the log, as a sentence; empty if nothing does.
pub(super) fn or_else(of: &Telling<'_>) -> String {
    let rivals: Vec<&str> = of
        .found
        .competing
        .iter()
        .map(|rival| rival.id.as_str())
        .take(2)
        .collect();
    let rivals = match &rivals[..] {
        [] => String::new(),
        _ => format!(". The log does not tell it from: {}", rivals.join(", ")),
    };
    let mimic = (of.found.mimic.as_ref())
        .filter(|_| of.found.own < MIMICKED)
        .map_or_else(String::new, |name| {
            format!(". {name} has nearly the same effect, so both are estimated together")
        });
    format!("{rivals}{mimic}")
}

/// Part of an effect that no parameter mimics, below which the parameter is named.
const MIMICKED: f64 = 0.3;

/// Returns the gain in words.
pub(super) fn falls(of: &Telling<'_>) -> String {
    if let Some(moves) = of.moves {
        return format!("the likelihood of held-out parts of the log rises. {moves}");
    }
    let percent = 100.0 * of.found.gain;
    if percent < 0.5 {
        // It was asked for, or another delay hides it.
        return "the equations of the joints agree best".to_owned();
    }
    format!(
        "the error of the torques on held-out parts of the log falls by {percent:.0} % (squares)"
    )
}
