//! Composes the sections about applied changes and about friction beside further laws.

use super::document::{Block, Fold, Section};
use super::numbers::{dash_if_none, significant};
use super::rows::rows;
use super::section::{folded, section};
use crate::estimate::{EstimateResult, Identification};

/// Composes the section; `None` if no result has friction parameters beside laws that simulators lack.
pub(super) fn laws(identification: &Identification) -> Option<Section> {
    let blocks: Vec<Block> = (identification.results.iter())
        .filter_map(of_further_laws)
        .collect();
    (!blocks.is_empty()).then(|| {
        folded(
            Fold::Detail,
            "laws",
            "Friction beside further laws",
            "What do viscous and Coulomb friction mean beside laws that simulators lack?",
            blocks,
        )
    })
}

/// Composes the list of changes beyond the experiment file; `None` if there is none.
pub(super) fn applied(identification: &Identification) -> Option<Section> {
    let table = rows(&identification.applied)
        .text("Change", |change| &change.what)
        .text("held-out error of the torque %", |change| {
            let errors = change
                .held_out
                .map(|errors| errors.map(|error| 100.0 * error));
            dash_if_none(errors.map(|[without, with]| format!("{without:.2} → {with:.2}")))
        })
        .text("forbidden by", |change| &change.forbidden_by)
        .table_if_any("")?;
    Some(section(
        "applied",
        "Applied",
        "Changes beyond the experiment file that the log asked for. All estimators use them.",
        vec![Block::Table(table)],
    ))
}

/// Composes the table of friction parameters beside laws that simulators lack; `None` if a result has none.
fn of_further_laws(result: &EstimateResult) -> Option<Block> {
    let priors = result
        .refined()
        .map_or(&[][..], |found| &found.presliding_levels);
    let priors: Vec<String> = (priors.iter())
        .map(|prior| {
            let level = significant(prior.level_nm, 2);
            format!(
                "{level} N·m (N) on the {} side of {}",
                prior.side, prior.joint
            )
        })
        .collect();
    let prior = if priors.is_empty() {
        String::new()
    } else {
        format!(
            " Standard deviations of the prior by evidence: {}.",
            priors.join(", ")
        )
    };
    let table = rows(&result.dependence)
        .text("Parameter", |dependence| &dependence.name)
        .text("unit", |dependence| &dependence.unit)
        .number("raw", |dependence| significant(dependence.raw, 4))
        .number("projected", |dependence| significant(dependence.projected, 4))
        .number("difference", |dependence| significant(dependence.difference, 2))
        .table_if_any(format!(
            "Viscous and Coulomb friction beside further laws, {}. The raw values hold only together with \
             these laws. The projected values are those of the model without them \
             that fit the same friction along the motion. The difference is the dependence on the \
             model.{prior}",
            result.estimator
        ));
    table.map(Block::Table)
}
