//! Joins the files of one recording: positions in one file, torques in another.

use std::path::Path;

use super::read::{Column, Source, Survey};
use super::times::clock;
use super::words::{Meaning, Sort, tokens};
use super::write::name_of;

/// Part of the longer of two recordings during which both run, if they are one.
const MIN_SHARED: f64 = 0.5;

impl Survey {
    /// Adds another file of the same recording and returns true; returns false if it is not of the same recording.
    ///
    /// The files are tables with clocks that run at the same times. Their columns differ in their names, or have the same
    /// names and the files say in their own what they hold: `positions.csv` and `torques.csv`.
    ///
    /// - `path`: the file for the experiment.
    pub fn join(&mut self, other: &Self, path: &str) -> bool {
        let ([first, ..], [another]) = (&self.sources[..], &other.sources[..]) else {
            return false;
        };
        let (Some((time, _)), Some((of_other, _))) = (clock(first), clock(another)) else {
            return false;
        };
        let labels =
            [(&self.file, first), (&other.file, another)].map(|(file, source)| label(file, source));
        let by_file = match &labels {
            [Some((of_first, _)), Some((of_other, _))] => {
                let said =
                    |source: &Source| Some(Meaning::of(&tokens(source.label.as_ref()?), &[]));
                let joined = self.sources[1..].iter().filter_map(said);
                joined
                    .chain([of_first.clone()])
                    .all(|known| known != *of_other)
            }
            _ => false,
        };
        let is_known = |column: &Column| {
            (self.sources.iter().flat_map(|source| &source.columns))
                .any(|known| known.name == column.name && known.values == column.values)
        };
        let is_new = |column: &&Column| column.number != of_other.number && !is_known(column);
        let added: Vec<Column> = another.columns.iter().filter(is_new).cloned().collect();
        let names = self.all_names();
        let is_other = by_file || !added.iter().any(|column| names.contains(&column.name));
        let lacks = other.lacks_of(self).is_some();
        if added.is_empty() || !is_other || !(by_file || lacks) || !runs_with(time, of_other) {
            return false;
        }
        let begin = time.values.first().copied().unwrap_or_default();
        let times = |column: &Column| column.values.iter().map(|time| time - begin).collect();
        let [of_first, label] = labels.map(|label| label.filter(|_| by_file).map(|(_, stem)| stem));
        let source = Source {
            times: times(of_other),
            file: Some((path.to_owned(), name_of(other, of_other))),
            label,
            columns: added,
            ..another.clone()
        };
        self.joined.push(format!(
            "{} is another part of the same recording, joined by \"{}\"",
            other.file, of_other.name
        ));
        let times = times(time);
        self.sources[0].times = times;
        self.sources[0].label = of_first;
        self.sources.push(source);
        self.others.extend_from_slice(&other.others);
        self.counters.extend_from_slice(&other.counters);
        self.has_names &= other.has_names;
        true
    }

    /// Returns whether the name of the file and no column says a quantity.
    #[must_use]
    pub fn says_in_its_name(&self) -> bool {
        let first = self.sources.first();
        first.is_some_and(|source| label(&self.file, source).is_some())
    }

    /// Returns sentences about the files that were joined, without their ends.
    #[must_use]
    pub fn joined(&self) -> &[String] {
        &self.joined
    }
}

/// Returns whether two clocks run at the same times.
fn runs_with(one: &Column, two: &Column) -> bool {
    let (one, two) = (&one.figures, &two.figures);
    let both = one.max.min(two.max) - one.min.max(two.min);
    both > MIN_SHARED * (one.max - one.min).max(two.max - two.min)
}

/// Returns the meaning of the name of a file, and this name; `None` if its columns say quantities, or it says none.
fn label(file: &str, source: &Source) -> Option<(Meaning, String)> {
    let stem = Path::new(file).file_stem()?.to_str()?;
    let of_file = Meaning::of(&tokens(stem), &[]);
    let says_nothing = |column: &Column| matches!(column.meaning().sort, None | Some(Sort::Time));
    (source.columns.iter().all(says_nothing)).then(|| (of_file, stem.to_owned()))
}
