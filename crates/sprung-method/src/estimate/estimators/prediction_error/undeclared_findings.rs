//! Findings about unknowns that only the likelihood shows.

use super::refined::Refined;
use super::undeclared::Undeclared;
use crate::estimate::statistics::CERTAIN_SIGMAS;
use crate::finding::{Finding, Severity};
use crate::model::short;
use crate::prepare::Excerpt;
use crate::regression::Reading;
use crate::unknowns::{Found, Kind, UnknownResult, by_likelihood};

/// Returns the relevant unknowns with their findings, in the order of their gains.
pub(super) fn about_undeclared(
    (reading, excerpt): (&Reading, &Excerpt),
    refined: &Refined,
    undeclared: &[Undeclared],
) -> Vec<(UnknownResult, Finding)> {
    let is_relevant =
        |one: &&Undeclared| one.significance() > CERTAIN_SIGMAS && one.matters(refined);
    let about = |one: &Undeclared| {
        let (index, moved) = one.largest_move(refined)?;
        let name = &reading.model().parameters()[index].name;
        let moves = format!(
            "With it {} would move by {moved:.1} of its standard errors",
            short(name)
        );
        let severity = if moved > CERTAIN_SIGMAS {
            Severity::Warning
        } else {
            Severity::Info
        };
        let found = Found {
            value: assumed(one, reading) + one.found.value,
            ..one.found.clone()
        };
        let (unknown, finding) = by_likelihood(&found, (reading, excerpt), &moves);
        let mut finding = finding?.about([name.clone()]);
        finding.severity = severity;
        Some((unknown, finding))
    };
    undeclared
        .iter()
        .filter(is_relevant)
        .filter_map(about)
        .collect()
}

/// Returns the delay that the refinement has used, s; zero for what is no delay.
fn assumed(undeclared: &Undeclared, reading: &Reading) -> f64 {
    let channels = reading.channels();
    let is_delay = matches!(undeclared.found.kind, Kind::Delay | Kind::Timing);
    let mut of_place = (reading.delays().iter().enumerate())
        .filter(|(channel, _)| is_delay && undeclared.found.place.contains(*channel, channels));
    of_place.next().map_or(0.0, |(_, delay)| *delay)
}
