//! The time of a jump: it must be met to the sample.

use super::evidence::PARTS;
use super::kinds::lost_counts;
use super::rows::{Row, Rows, Wanted};
use super::search::Search;
use super::state::State;
use super::unknown::Unknown;
use crate::model::Model;
use crate::prepare::{Excerpt, Smoothed};

/// Parts of the span between neighbouring times of a search for a jump, and times on each side.
const KNOTS_OF_TIME: f64 = 12.0;
const TIMES: i32 = 6;

/// The regression of a round, of which one column is formed again.
pub(super) struct Formed<'r> {
    pub(super) model: &'r Model,
    pub(super) corrected: &'r Excerpt,
    pub(super) smoothed: &'r Smoothed,
    pub(super) theta: &'r [f64],
    /// Usual sizes of all unknowns.
    pub(super) scales: &'r [f64],
    /// Weights of the rows, and number of neighbouring samples that say the same.
    pub(super) weights: &'r [f64],
    pub(super) repeats: f64,
}

impl Search<'_> {
    /// Moves the time of a jump to where it explains most, between the neighbouring knots.
    /// Returns the rows with its column at this time.
    pub(super) fn meet_the_time(
        &mut self,
        unknown: usize,
        state: &State,
        of: &Formed<'_>,
        rows: &[Row],
    ) -> Option<Vec<Row>> {
        let [channel] = *self.unknowns[unknown].channels() else {
            return None;
        };
        let id = self.unknowns[unknown].id.clone();
        let mut best = self.unknowns[unknown].begins()?;
        let knot = self.span[1] / KNOTS_OF_TIME;
        let all_rows: Vec<usize> = (0..self.rows.len()).collect();
        let all: Vec<usize> = (0..PARTS).collect();
        for (reach, is_sharp) in [(knot, false), (knot / 6.0, false), (knot / 36.0, true)] {
            let mut least = f64::INFINITY;
            let centre = best;
            for k in -TIMES..=TIMES {
                let at = centre + reach * f64::from(k) / f64::from(TIMES);
                self.unknowns[unknown] = Unknown {
                    id: id.clone(),
                    ..lost_counts::at(&self.catalogued, channel, at, is_sharp)?
                };
                let merged = self.formed_again(unknown, of, rows)?;
                let weights = Some(of.weights.to_vec());
                let evidence = self.evidence(&merged, (state, of.scales), weights, of.repeats);
                let mut columns: Vec<usize> = (0..self.free.len()).collect();
                columns.extend(
                    state
                        .chosen
                        .iter()
                        .chain([&unknown])
                        .map(|other| self.free.len() + other),
                );
                let left = evidence.held_out(&columns, None).sum(&all_rows, &all);
                if left < least {
                    (least, best) = (left, at);
                }
            }
        }
        self.unknowns[unknown] = Unknown {
            id,
            ..lost_counts::at(&self.catalogued, channel, best, true)?
        };
        self.formed_again(unknown, of, rows)
    }

    /// Returns rows with the present column of one unknown.
    fn formed_again(&self, unknown: usize, of: &Formed<'_>, rows: &[Row]) -> Option<Vec<Row>> {
        let direction = self.pass(&[unknown], (of.corrected, self.zero()?), false)?;
        let former = Rows {
            wanted: Wanted::These(&[]),
            ..self.former(of.model, of.smoothed.period())
        };
        let formed = former.form(of.smoothed.segments(), of.theta, &self.unknowns, &direction)?;
        Some(with_column(rows, &formed, self.free.len() + unknown))
    }
}

/// Returns rows with one column from others.
fn with_column(rows: &[Row], formed: &[Row], column: usize) -> Vec<Row> {
    (rows.iter().zip(formed))
        .map(|(row, new)| {
            let place = row.columns.iter().position(|c| *c == column);
            let from = new.columns.iter().position(|c| *c == column);
            let mut values = row.values.clone();
            if let (Some(place), Some(from)) = (place, from) {
                for i in 0..values.nrows() {
                    values[(i, place)] = new.values[(i, from)];
                }
            }
            Row {
                joint: row.joint,
                columns: row.columns.clone(),
                values,
                reliable: row.reliable.clone(),
            }
        })
        .collect()
}
