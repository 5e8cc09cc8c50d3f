//! Composes the section about laws by hold-out.

use super::document::{Block, Row, Section, Table, Tone};
use super::numbers::significant;
use super::section::section;
use super::tables::{number, text};
use crate::estimate::{Identification, LawRung};

/// Composes the section; `None` if the log was too short or hold-out asks for no other law.
pub(super) fn laws(identification: &Identification) -> Option<Section> {
    let laws = identification.laws.as_ref()?;
    if laws.rungs.is_empty() {
        return None;
    }
    let percent = |share: f64| significant(100.0 * share, 3);
    let row = |rung: &LawRung| {
        let velocity = rung.stribeck_velocity.map_or_else(String::new, |velocity| {
            let error = rung
                .stribeck_velocity_error
                .map_or_else(String::new, |error| format!(" ± {}", significant(error, 2)));
            format!(" of {}{error} rad/s (m/s)", significant(velocity, 3))
        });
        let delay = rung.delay.as_ref().map_or_else(String::new, |delay| {
            format!(
                ": {} is recorded {} ± {} ms late",
                delay.column,
                significant(1e3 * delay.delay_s, 3),
                significant(1e3 * delay.standard_error_s, 2)
            )
        });
        Row {
            cells: vec![
                rung.joint.clone(),
                rung.words() + &velocity + &delay,
                if rung.gain == 0.0 {
                    "by likelihood".to_owned()
                } else {
                    format!("{} ± {}", percent(rung.gain), percent(rung.gain_scatter))
                },
                percent(rung.held_out),
                if rung.made { "added" } else { "not added" }.to_owned(),
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
    };
    Some(section(
        "laws",
        "Laws by hold-out",
        "Eighths of the beginning of the first log are left out in turn and predicted by a fit of the \
         other eighths. A law counts if it decreases the residual of these predictions by at least \
         1 % and by more than 3 times the scatter of the decrease over the eighths. laws = \"auto\" \
         adds such laws to the model.",
        vec![
            Block::Table(table),
            Block::Paragraph(laws.ended.clone() + "."),
        ],
    ))
}
