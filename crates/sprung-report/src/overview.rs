//! Composes the first screen: measured and predicted motion and torque, and the intervals of all
//! parameters.

use super::contents::Contents;
use super::document::{Block, Figure, Layout, Panel, Section, Series, Style};
use super::intervals;
use super::plots::{is_deflection, is_torque, measured_series, quantity};
use super::section::section;
use crate::curves::{CurveSet, Curves};
use crate::validate::{Outcome, RunResult, Validation};

/// Measured and predicted curves of some columns.
struct Compared<'a> {
    columns: Vec<(usize, &'a str)>,
    measured: &'a CurveSet,
    predicted: &'a CurveSet,
    caption: String,
}

/// Composes the first screen; `None` without curves and without parameters.
pub(super) fn overview(contents: &Contents<'_>) -> Option<Section> {
    let shown = simulated(contents).or_else(|| fitted(contents));
    let forest = contents
        .identification
        .and_then(|identification| intervals::relative(identification, contents.truth));
    let mut blocks: Vec<Block> = (shown.as_ref())
        .map(|shown| Block::Figure(figure(shown)))
        .into_iter()
        .collect();
    blocks.extend(forest.map(Block::Intervals));
    (!blocks.is_empty()).then(|| section("at-a-glance", "At a glance", "", blocks))
}

/// Returns the simulated loop of the first parameter set on a log that the identification has not
/// used; `None` without such a simulation.
fn simulated<'a>(contents: &Contents<'a>) -> Option<Compared<'a>> {
    let (validation, curves) = contents.validation?;
    let run = run_of(validation)?;
    let set = run.sets.first()?;
    let measured = curves.set(&format!("{}/measured", run.name))?;
    let predicted = curves.set(&format!("{}/{}", run.name, set.parameters))?;
    let is_shown = |column: &str| {
        column.contains("link_position")
            || column.contains("motor_torque")
            || column.contains("motor_force")
    };
    Some(Compared {
        columns: of_interest(curves, is_shown),
        measured,
        predicted,
        caption: format!(
            "Validation \"{}\", {}: measured motion and torque, and those of the closed loop that \
             sprung simulates with the parameters of {}.",
            run.name, run.log, set.parameters
        ),
    })
}

fn run_of(validation: &Validation) -> Option<&RunResult> {
    let is_simulated =
        |run: &&RunResult| (run.sets.first()).is_some_and(|set| set.outcome == Outcome::Simulated);
    let runs = || validation.runs.iter().filter(is_simulated);
    runs().find(|run| !run.same_log)
}

/// Returns the filtered torques and deflections of the first estimator.
fn fitted<'a>(contents: &Contents<'a>) -> Option<Compared<'a>> {
    let identification = contents.identification?;
    let fit = contents.fit?;
    let result = identification.results.first()?;
    let is_shown = |column: &str| is_torque(column) || is_deflection(column);
    Some(Compared {
        columns: of_interest(fit, is_shown),
        measured: fit.set("measured")?,
        predicted: fit.set(&result.estimator)?,
        caption: format!(
            "{}: filtered motor torque and deflection of the springs, as measured and as {} \
             computes them from the measured motion.",
            identification.files(),
            result.estimator
        ),
    })
}

/// Returns the columns to show, joint by joint.
fn of_interest<'a>(curves: &'a Curves, is_shown: impl Fn(&str) -> bool) -> Vec<(usize, &'a str)> {
    let joint = |column: &'a str| column.rsplit_once('.').map_or(column, |(joint, _)| joint);
    let columns = curves.columns.iter().map(String::as_str).enumerate();
    let mut shown: Vec<(usize, &str)> = columns.filter(|(_, column)| is_shown(column)).collect();
    let joints: Vec<&str> = shown.iter().map(|(_, column)| joint(column)).collect();
    shown.sort_by_key(|(_, column)| joints.iter().position(|known| *known == joint(column)));
    shown
}

fn figure(shown: &Compared<'_>) -> Figure {
    let panels = shown.columns.iter().filter_map(|&(i, column)| {
        let truth = shown.measured.values.get(i)?;
        let values = shown.predicted.values.get(i)?;
        if shown.measured.time != shown.predicted.time {
            return None;
        }
        let (what, unit) = quantity(column);
        let what = what
            .replace("motor torque", "torque")
            .replace("motor force", "force");
        let difference = format!("difference [{unit}]");
        let note = match explained(truth, values) {
            Some(fraction) => in_words(fraction),
            None if values.iter().all(Option::is_none) => "no prediction".to_owned(),
            None => String::new(),
        };
        Some(Panel {
            y_label: format!("{what} [{unit}]"),
            note,
            x: shown.measured.time.clone(),
            series: vec![
                measured_series(truth),
                Series::new("predicted", Style::First, values.clone()),
            ],
            errors: Some(difference),
            ..Panel::default()
        })
    });
    let caption = format!(
        "{} The strip below shows their difference. Explained is 1 minus the mean square of the difference over the \
         variance of the measured curve.",
        shown.caption
    );
    Figure::over_time("measured-and-predicted", caption, Layout::Overview, panels)
}

/// Returns the fraction of a curve's variance that a prediction explains; `None` if the curve is
/// constant or the prediction ends early.
fn explained(measured: &[Option<f64>], predicted: &[Option<f64>]) -> Option<f64> {
    let pairs: Vec<(f64, f64)> = (measured.iter().zip(predicted))
        .filter_map(|(a, b)| Some(((*a)?, (*b)?)))
        .collect();
    // A simulation that runs away covers a part of the log only.
    (10 * pairs.len() >= 9 * measured.iter().flatten().count()).then_some(())?;
    let mean = pairs.iter().map(|(a, _)| a).sum::<f64>() / pairs.len() as f64;
    let variance: f64 = pairs.iter().map(|(a, _)| (a - mean).powi(2)).sum();
    let missed: f64 = pairs.iter().map(|(a, b)| (a - b).powi(2)).sum();
    let fraction = 1.0 - missed / variance;
    fraction.is_finite().then_some(fraction)
}

/// Returns an explained fraction in words: with two digits of the unexplained part, at most four
/// decimals.
fn in_words(fraction: f64) -> String {
    if fraction <= 0.0 {
        return "nothing explained".to_owned();
    }
    let missed = 100.0 * (1.0 - fraction);
    let decimals = match missed {
        missed if missed >= 9.95 => 0,
        missed if missed >= 0.995 => 1,
        missed if missed >= 0.0995 => 2,
        missed if missed >= 0.00995 => 3,
        _ => return "> 99.99 % explained".to_owned(),
    };
    format!("{:.decimals$} % explained", 100.0 * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_explained_fraction_is_that_of_the_variance() {
        let measured: Vec<Option<f64>> = [1.0, 2.0, 3.0, 4.0].map(Some).to_vec();
        let shifted: Vec<Option<f64>> = [1.5, 2.5, 3.5, 4.5].map(Some).to_vec();
        // The variance is 1.25, the mean square of the difference 0.25.
        assert!((explained(&measured, &shifted).unwrap() - 0.8).abs() < 1e-12);
        assert_eq!(explained(&measured, &[Some(1.0), None, None, None]), None);
        assert_eq!(explained(&[Some(1.0); 4], &shifted), None);
        let words = [0.8, 0.951, 0.9987, 0.99996, -1.0].map(in_words);
        let expected = [
            "80 % explained",
            "95.1 % explained",
            "99.87 % explained",
            "> 99.99 % explained",
            "nothing explained",
        ];
        assert_eq!(words, expected);
    }

    #[test]
    fn the_columns_of_a_joint_stand_together() {
        let columns = [
            "a.motor_nm",
            "b.motor_nm",
            "a.deflection_rad",
            "b.deflection_rad",
        ];
        let curves = Curves {
            columns: columns.map(str::to_owned).to_vec(),
            sets: Vec::new(),
        };
        let shown = of_interest(&curves, |_| true).into_iter();
        assert_eq!(shown.map(|(i, _)| i).collect::<Vec<_>>(), [0, 2, 1, 3]);
    }
}
