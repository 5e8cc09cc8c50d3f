//! Composes the section about laws by hold-out.

use super::document::{Block, Fold, Row, Section, Table, Tone};
use super::numbers::significant;
use super::section::{folded, section};
use super::tables::{number, text};
use crate::estimate::{
    Applied, EstimateResult, Identification, LawRung, LawsByHoldOut, ModelDependence,
};

/// Composes the section; `None` if there are neither laws by cross-validation nor friction parameters beside others.
pub(super) fn laws(identification: &Identification) -> Option<Section> {
    let ladder = (identification.laws.as_ref()).filter(|laws| !laws.rungs.is_empty());
    let mut blocks: Vec<Block> = ladder.map(of_ladder).into_iter().flatten().collect();
    blocks.extend((identification.results.iter()).filter_map(of_residual_laws));
    (!blocks.is_empty()).then(|| {
        folded(
            Fold::Detail,
            "laws",
            "Laws by hold-out",
            "Would another friction law predict the log better? Eighths of the beginning of the first log are left out in turn and predicted by a fit of \
             the other eighths. A law counts if it decreases the residual of these predictions by at \
             least 1 % and by more than 3 times the scatter of the decrease over the eighths, and if its torque is at least 1 % \
             of the joint's. It is added from 5 % on. laws = \"declared\" adds none.",
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
fn of_residual_laws(result: &EstimateResult) -> Option<Block> {
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
        .map_or(&[][..], |found| &found.residual_levels);
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

/// Composes the table of the ladder and the reason for its end.
fn of_ladder(laws: &LawsByHoldOut) -> Vec<Block> {
    let percent = |share: f64| significant(100.0 * share, 3);
    let row = |rung: &LawRung| {
        let velocity = rung.stribeck_velocity.map_or_else(String::new, |velocity| {
            let error = rung
                .stribeck_velocity_error
                .map_or_else(String::new, |error| format!(" ± {}", significant(error, 2)));
            format!(" of {}{error} rad/s (m/s)", significant(velocity, 3))
        });
        Row {
            cells: vec![
                rung.joint.clone(),
                rung.words() + &velocity,
                format!("{} ± {}", percent(rung.gain), percent(rung.gain_scatter)),
                percent(rung.held_out),
                match (rung.made, rung.earlier) {
                    (true, true) => "added by an earlier result",
                    (true, false) => "added",
                    (false, _) => "not added",
                }
                .to_owned(),
                match &rung.not_told_apart_from[..] {
                    [] => "–".to_owned(),
                    others => others.join(", "),
                },
            ],
            tone: if rung.made {
                Tone::Neutral
            } else {
                Tone::Doubtful
            },
        }
    };
    let table = Table {
        caption: format!(
            "Laws by hold-out, each on top of the laws before it. With the laws of the experiment \
             file, {} % of the filtered torque is missed.",
            percent(laws.held_out)
        ),
        columns: vec![
            text("Joint"),
            text("Law"),
            number("gain in its rows %"),
            number("torque missed %"),
            text(""),
            text("explains the same"),
        ],
        rows: laws.rungs.iter().map(row).collect(),
        ..Table::default()
    };
    vec![
        Block::Table(table),
        Block::Paragraph(laws.ended.clone() + "."),
    ]
}
