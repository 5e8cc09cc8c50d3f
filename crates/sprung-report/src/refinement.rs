//! Composes the section about a prediction-error refinement.

use super::document::{Bar, BarRow, Bars, Block, Fold, Intervals, Section, Table, Tone};
use super::intervals;
use super::numbers::{dash_if_none, percent, significant};
use super::refined_delays::{as_exact, delay_intervals, delay_table};
use super::rows::rows;
use super::section::folded;
use super::tables::row_name;
use crate::estimate::{
    EstimateResult, Identification, LogInfo, NORMAL_95, Refinement, RowDisturbance,
};
use crate::model::short;

/// Range of decades of the torque that the bars always show.
const MIN_SHOWN_DECADES: (i32, i32) = (-4, -1);

/// Tolerance, in decades, for a level at its bound that rounding puts beyond it.
const DECADE_TOLERANCE: f64 = 1e-9;

/// Composes the section for the first refined result.
pub(super) fn refinement(identification: &Identification) -> Option<Section> {
    let (result, refinement) = (identification.results.iter())
        .find_map(|result| Some((result, result.refinement.as_ref()?)))?;
    let mut blocks = Vec::new();
    if !refinement.used {
        blocks.push(Block::Paragraph(format!(
            "The refinement is not used, so the values of {} do not depend on the figures below. The \
             figures may show the reason: levels at a bound and late columns indicate effects that \
             the model lacks.",
            result.estimator
        )));
    }
    blocks.extend(rungs(refinement).map(Block::Table));
    blocks.extend(unused_values(result, refinement).map(Block::Table));
    blocks.push(Block::KeyValues(search(refinement)));
    blocks.push(Block::Bars(levels(&refinement.disturbances)));
    blocks.extend(logs(identification, result, refinement).map(Block::Intervals));
    blocks.extend(delay_intervals(&refinement.delays).map(Block::Intervals));
    blocks.extend(delay_table(&refinement.delays).map(Block::Table));
    blocks.extend(offsets(refinement).map(Block::Table));
    blocks.extend(pairs(refinement));
    Some(folded(
        Fold::Detail,
        "refinement",
        "Noise, disturbances, delays",
        "Besides the parameters, the refinement estimates noise, disturbances and delays by maximum \
         likelihood of the measured positions. The filter attributes unexplained motion to white \
         noise of the torques and to slow random disturbances of motors and links. Their levels are \
         estimated from the log, and the intervals of the parameters depend on these levels.",
        blocks,
    ))
}

/// Returns the rungs that were tried; `None` if the first one is used.
fn rungs(refinement: &Refinement) -> Option<Table> {
    let is_first = refinement.used && refinement.rungs.len() < 2;
    (!is_first).then_some(())?;
    let cell = |share: Option<f64>| dash_if_none(share.map(|share| percent(share, 3)));
    rows(&refinement.rungs)
        .text("Rung", |rung| &rung.name)
        .number("Refinement", |rung| {
            cell(rung.held_out_residual.map(|held| held.refined))
        })
        .number("Least squares", |rung| {
            cell(rung.held_out_residual.map(|held| held.linear))
        })
        .text("Outcome", |rung| &rung.outcome)
        .toned(|rung| if rung.used { Tone::Good } else { Tone::Neutral })
        .table_if_any(
            "Refinements that allow less and less slow disturbance: any level (free), at most \
             10 and 3 times the white noise (cap10, cap3), none (flat). The residuals are \
             those of the filtered torque in blocks of the log that the estimates had not used.",
        )
}

/// Returns the refined values if they are not used.
fn unused_values(result: &EstimateResult, refinement: &Refinement) -> Option<Table> {
    (!refinement.used && !refinement.values.is_empty()).then_some(())?;
    let values = result.parameters.iter().zip(&refinement.values);
    let known = values.filter_map(|(parameter, value)| Some((parameter, (*value)?)));
    let table = rows(known)
        .text("Parameter", |(parameter, _)| &parameter.name)
        .number("Value", |(_, (value, error))| {
            as_exact(value, NORMAL_95 * error)
        })
        .number("± 95 %", |(_, (_, error))| {
            significant(NORMAL_95 * error, 2)
        })
        .text("Unit", |(parameter, _)| &parameter.unit);
    Some(table.table(format!(
        "Values of the refinement that is not used (rung {}).",
        refinement.rung
    )))
}

fn search(refinement: &Refinement) -> Vec<(String, String)> {
    let end = if refinement.converged {
        "converged"
    } else {
        "did not converge"
    };
    let mut search = vec![
        (
            "Search",
            format!("{end} after {} runs of the filter", refinement.runs),
        ),
        (
            "Used",
            format!(
                "{} samples, {} s, {} measurements of positions (for a counter: its edges)",
                refinement.samples,
                significant(refinement.duration_s, 4),
                refinement.measurements
            ),
        ),
        (
            "Corner of the disturbances",
            format!("{} Hz", significant(refinement.disturbance_corner_hz, 2)),
        ),
        (
            "Minus log-likelihood, without its constant",
            significant(refinement.minus_log_likelihood, 6),
        ),
    ];
    if let Some(held_out) = refinement.held_out_residual {
        search.push((
            "Residual of the filtered torque in blocks of the log, with parameters from the other \
             blocks",
            format!(
                "{}, least squares {}",
                percent(held_out.refined, 2),
                percent(held_out.linear, 2)
            ),
        ));
    }
    let owned = |(key, value): (&str, String)| (key.to_owned(), value);
    search.into_iter().map(owned).collect()
}

/// Returns bars of each row's noise and disturbance relative to the torque, on a logarithmic scale.
fn levels(rows: &[RowDisturbance]) -> Bars {
    let parts = |row: &RowDisturbance| {
        [row.torque_noise_nm, row.disturbance_nm]
            .map(|level| Some(level / row.torque_nm).filter(|x| *x > 0.0 && x.is_finite()))
    };
    let decades = rows.iter().flat_map(parts).flatten().map(f64::log10);
    let (first, last) = decades.fold(MIN_SHOWN_DECADES, |(low, high), decade| {
        (
            low.min((decade + DECADE_TOLERANCE).floor() as i32),
            high.max((decade - DECADE_TOLERANCE).ceil() as i32),
        )
    });
    let place = |part: f64| (part.log10() - f64::from(first)) / f64::from(last - first);
    let row = |row: &RowDisturbance| {
        let levels = [row.torque_noise_nm, row.disturbance_nm];
        let bar = |(part, level): (Option<f64>, f64)| {
            let part = part?;
            Some(Bar {
                length: place(part),
                text: format!(
                    "{}, {} {}",
                    percent(part, 2),
                    significant(level, 2),
                    unit(&row.row)
                ),
            })
        };
        let name = row_name(&row.row);
        BarRow {
            label: if row.at_bound {
                format!("{name} (at its bound)")
            } else {
                name.to_owned()
            },
            bars: parts(row).into_iter().zip(levels).map(bar).collect(),
            tone: if row.at_bound {
                Tone::Bad
            } else {
                Tone::Neutral
            },
        }
    };
    Bars {
        caption: "Standard deviations as parts of the standard deviation of the joint's motor \
                  torque, on a logarithmic scale. A level at its bound is too large for a \
                  disturbance: the model lacks an effect in this row."
            .to_owned(),
        names: vec![
            "white noise of the torque".to_owned(),
            "disturbance".to_owned(),
        ],
        ticks: (first..=last)
            .map(|decade| {
                let part = 10_f64.powi(decade);
                (place(part), percent(part, 1))
            })
            .collect(),
        rows: rows.iter().map(row).collect(),
    }
}

fn unit(row: &str) -> &'static str {
    if row.ends_with("_nm") { "N·m" } else { "N" }
}

/// Returns the estimates from each log alone, around the estimate from all logs; `None` for a
/// single log.
fn logs(
    identification: &Identification,
    result: &EstimateResult,
    refinement: &Refinement,
) -> Option<Intervals> {
    let each = &refinement.each_log;
    (each.len() > 1).then_some(())?;
    let files: Vec<String> = identification.logs().map(LogInfo::name).collect();
    let mut names = vec!["all logs".to_owned()];
    if files.len() == each.len() {
        names.extend(files);
    } else {
        // Logs that are too short or lie after the refined part are missing here, so file names do
        // not apply.
        names.extend((1..=each.len()).map(|i| format!("refined log {i}")));
    }
    let rows = (result.parameters.iter().enumerate()).filter_map(|(i, parameter)| {
        let alone = each.iter().map(|log| *log.get(i)?).collect();
        intervals::around(parameter, alone)
    });
    Some(Intervals {
        caption:
            "Estimates from each log alone, with 95 % intervals, relative to the estimate from all \
             logs. The number at the right is half the width of the row. Intervals that do not \
             overlap indicate an effect that the model lacks, or another robot."
                .to_owned(),
        names,
        rows: rows.collect(),
        ..Intervals::default()
    })
}

fn offsets(refinement: &Refinement) -> Option<Table> {
    let slides = |joint: &str| {
        let of = |row: &RowDisturbance| {
            row.row
                .strip_prefix(joint)
                .is_some_and(|r| r.starts_with('.'))
        };
        (refinement.disturbances.iter()).any(|row| of(row) && unit(&row.row) == "N")
    };
    rows(&refinement.encoder_offsets)
        .text("Joint", |offset| &offset.joint)
        .text("Column", |offset| &offset.column)
        .number("Offset", |offset| significant(1e3 * offset.offset_rad, 3))
        .number("± s.e.", |offset| {
            significant(1e3 * offset.standard_error_rad, 2)
        })
        .text("Unit", |offset| {
            if slides(&offset.joint) { "mm" } else { "mrad" }
        })
        .table_if_any(
            "Constant error of each column: the offset of its zero, or of the edges of its counter.",
        )
}

/// Returns the parameters whose errors are most strongly correlated, as text.
fn pairs(refinement: &Refinement) -> Vec<Block> {
    if refinement.correlations.is_empty() {
        return vec![Block::Paragraph(
            "No two parameters have strongly correlated errors.".to_owned(),
        )];
    }
    let words = |(first, second, correlation): &(String, String, f64)| {
        let (known, way) = if *correlation < 0.0 {
            ("sum", "if one is too large, the other is too small")
        } else {
            ("difference", "both are too large or too small together")
        };
        (
            format!("{} and {}", short(first), short(second)),
            format!(
                "correlation {correlation:+.3}: {way}; their {known}, each in units of its standard \
                 error, is known {} times as accurately as with independent errors",
                significant(
                    (1.0 - correlation.abs()).max(f64::EPSILON).sqrt().recip(),
                    2
                )
            ),
        )
    };
    vec![
        Block::Paragraph("Parameters with the most strongly correlated errors:".to_owned()),
        Block::KeyValues(refinement.correlations.iter().map(words).collect()),
    ]
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Returns an identification with two logs, a row at its bound, a late column and a column
    /// without information about its delay.
    fn identification(codes: &[&str]) -> Identification {
        let log = |file: &str| {
            json!({"file": file, "samples": 10, "period_s": 0.1, "duration_s": 0.9,
                   "jitter_percent": 0.0})
        };
        let level = |row: &str, drift: f64, at_bound: bool| {
            json!({"row": row, "torque_noise_nm": 0.0, "disturbance_nm": drift, "torque_nm": 2.0,
                   "at_bound": at_bound})
        };
        let warning = |code: &&str| json!({"code": code, "severity": "warning", "parameters": [], "text": "", "remedy": ""});
        let warnings: Vec<_> = codes.iter().map(warning).collect();
        let value = json!({
            "format": 1, "generator": "", "robot": "", "findings": [],
            "log": log("first.csv"), "further_logs": [log("second.csv")],
            "settings": {"filter_cutoff_rad_per_s": 30.0, "discretization": "matched",
                         "position_cutoff_hz": 10.0, "position_filter_order": 2},
            "results": [{
                "estimator": "prediction-error", "verdict": "doubtful", "rank": 2,
                "parameters": [
                    {"name": "a.stiffness", "symbol": "theta1", "unit": "N·m/rad", "value": 10.0,
                     "standard_error": 0.1, "ci95": [9.8, 10.2], "identifiable": true},
                    {"name": "a.rotor_inertia", "symbol": "theta2", "unit": "kg·m²",
                     "identifiable": false}],
                "residual_rms": {}, "relative_residual": {}, "warnings": warnings, "elapsed_s": 0.1,
                "refinement": {
                    "used": !codes.contains(&"refinement-failed"),
                    "converged": true, "runs": 7, "samples": 20, "duration_s": 1.8,
                    "measurements": 40, "minus_log_likelihood": -3.0, "disturbance_corner_hz": 1.5,
                    "disturbances": [level("a.link_nm", 0.002, false), level("a.motor_nm", 0.2, true)],
                    "encoder_offsets": [],
                    "delays": [
                        {"column": "q", "delay_s": 5e-4, "standard_error_s": 1e-5, "used_s": 1e-4},
                        {"column": "tau", "delay_s": 0.0, "used_s": 0.0}],
                    "correlations": [["a.stiffness", "a.rotor_inertia", -0.75]],
                    "each_log": [[[10.0, 1.0], null], [[11.0, 0.5], null]]
                }
            }]
        });
        serde_json::from_value(value).unwrap()
    }

    fn blocks(codes: &[&str]) -> Vec<Block> {
        refinement(&identification(codes)).unwrap().blocks
    }

    #[test]
    fn a_row_at_its_bound_is_marked() {
        let blocks = blocks(&[]);
        let Some(Block::Bars(bars)) = blocks.iter().find(|b| matches!(b, Block::Bars(_))) else {
            panic!("no bars")
        };
        let [link, motor] = &bars.rows[..] else {
            panic!("two rows")
        };
        assert_eq!((link.tone, motor.tone), (Tone::Neutral, Tone::Bad));
        assert_eq!(motor.label, "a.motor (at its bound)");
        assert!((link.bars[1].as_ref().unwrap().length - 1.0 / 3.0).abs() < 1e-12);
        assert!((motor.bars[1].as_ref().unwrap().length - 1.0).abs() < 1e-12);
        assert_eq!(link.bars[0], None);
    }

    #[test]
    fn single_logs_are_shown_around_the_common_estimate() {
        let blocks = blocks(&[]);
        let mut shown = blocks.iter().filter_map(Block::intervals);
        let (logs, delays) = (shown.next().unwrap(), shown.next().unwrap());
        assert_eq!(logs.names, ["all logs", "first.csv", "second.csv"]);
        // The other parameter has no value in any log.
        assert_eq!(logs.rows.len(), 1);
        let at = |i: usize| logs.rows[0].marks[i].unwrap().at;
        assert!(at(0).abs() < 1e-12 && at(1).abs() < 1e-12);
        assert!((at(2) - 1.0 / (1.0 + 0.5 * NORMAL_95)).abs() < 1e-9);
        // The delay exceeds the used value, and its interval excludes the used value.
        assert_eq!(delays.rows.len(), 1);
        let mark = delays.rows[0].marks[0].unwrap();
        assert!(mark.interval.unwrap()[0] > 0.0);
    }

    #[test]
    fn significant_delays_are_marked() {
        let blocks = blocks(&[]);
        let table = blocks.iter().find_map(Block::table).unwrap();
        assert_eq!(
            table.rows[0].cells,
            ["q", "100.0", "500 ± 20", "+40.0", "800.0"]
        );
        assert_eq!(table.rows[0].tone, Tone::Doubtful);
        assert_eq!(table.rows[1].cells[2], "not determined");
    }

    #[test]
    fn rungs_and_unused_values_have_tables() {
        let mut found = identification(&["refinement-failed"]);
        let tables = |found: &Identification| {
            let blocks = refinement(found).unwrap().blocks;
            let tables = blocks.iter().filter_map(Block::table).cloned();
            tables.collect::<Vec<_>>()
        };
        let before = tables(&found).len();
        let refinement = found.results[0].refinement.as_mut().unwrap();
        refinement.rung = "flat".to_owned();
        refinement.values = vec![Some((11.0, 0.5)), None];
        refinement.rungs = vec![crate::estimate::RungResult {
            name: "flat".to_owned(),
            used: false,
            held_out_residual: None,
            outcome: "the filter does not follow the log".to_owned(),
        }];
        let tables = tables(&found);
        assert_eq!(tables.len(), before + 2);
        assert_eq!(tables[0].rows[0].cells[1], "–");
        assert_eq!(tables[1].rows.len(), 1);
        assert_eq!(
            tables[1].rows[0].cells[..3],
            ["a.stiffness", "11.00", "0.98"]
        );
    }

    #[test]
    fn an_unused_refinement_is_explained() {
        let first = |codes: &[&str]| matches!(blocks(codes)[0], Block::Paragraph(_));
        assert!(first(&["refinement-failed"]));
        assert!(!first(&["late-channel"]));
    }
}
