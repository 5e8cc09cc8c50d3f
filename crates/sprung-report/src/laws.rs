//! Composes the sections about applied changes and about friction beside further laws.

use super::document::{Block, Fold, Row, Section, Table, Tone};
use super::numbers::significant;
use super::section::{folded, section};
use super::tables::{number, text};
use crate::estimate::{Applied, EstimateResult, Identification, ModelDependence};

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
    let row = |change: &Applied| Row {
        cells: vec![
            change.what.clone(),
            change.held_out.map_or_else(
                || "–".to_owned(),
                |[without, with]| format!("{:.2} → {:.2}", 100.0 * without, 100.0 * with),
            ),
            change.forbidden_by.clone(),
        ],
        tone: Tone::Neutral,
    };
    let table = Table {
        columns: vec![
            text("Change"),
            text("held-out error of the torque %"),
            text("forbidden by"),
        ],
        rows: identification.applied.iter().map(row).collect(),
        ..Table::default()
    };
    (!identification.applied.is_empty()).then(|| {
        section(
            "applied",
            "Applied",
            "Changes beyond the experiment file that the log asked for. All estimators use them.",
            vec![Block::Table(table)],
        )
    })
}

/// Composes the table of friction parameters beside laws that simulators lack; `None` if a result has none.
fn of_further_laws(result: &EstimateResult) -> Option<Block> {
    let row = |dependence: &ModelDependence| Row {
        cells: vec![
            dependence.name.clone(),
            dependence.unit.clone(),
            significant(dependence.raw, 4),
            significant(dependence.projected, 4),
            significant(dependence.difference, 2),
        ],
        tone: Tone::Neutral,
    };
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
    (!result.dependence.is_empty()).then(|| {
        Block::Table(Table {
            caption: format!(
                "Viscous and Coulomb friction beside further laws, {}. The raw values hold only together with \
                 these laws. The projected values are those of the model without them \
                 that fit the same friction along the motion. The difference is the dependence on the \
                 model.{prior}",
                result.estimator
            ),
            columns: vec![
                text("Parameter"),
                text("unit"),
                number("raw"),
                number("projected"),
                number("difference"),
            ],
            rows: result.dependence.iter().map(row).collect(),
            ..Table::default()
        })
    })
}
