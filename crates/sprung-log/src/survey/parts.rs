//! Reads parts of a long table: a beginning, an end, and parts evenly between them.
//!
//! A joint may move only late in a log. Many formats give their number of rows only at the end, so one pass thins out
//! the blocks that it has read: memory is bounded, and the parts stay evenly spread. Of the rows that are left out only
//! the range remains, so a short motion between the parts is found too.

use std::ops::Range;

use crate::error::LogError;
use crate::formats::table::{Readings, Table};

/// Most rows of a block.
pub(super) const PART_ROWS: usize = 10_000;

/// Most samples of all columns.
const MAX_CELLS: usize = 1 << 22;

/// Most blocks that are evenly spread. The last two blocks are kept as well.
const SPREAD: usize = 4;

/// Parts of a table.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// The parts one after the other, [columns].
    pub(super) columns: Vec<Readings>,
    /// Samples before which rows are left out.
    pub(super) joins: Vec<usize>,
    /// Smallest and largest of the samples that are left out, relative to the origin of the readings, [columns].
    pub(super) left_out: Vec<(f64, f64)>,
}

impl Parts {
    fn empty(columns: usize) -> Self {
        Self {
            columns: vec![Readings::default(); columns],
            joins: Vec::new(),
            left_out: vec![(f64::INFINITY, f64::NEG_INFINITY); columns],
        }
    }
}

/// Returns the number of rows of a block with a number of columns.
pub(super) fn part_rows(columns: usize) -> usize {
    PART_ROWS.min(MAX_CELLS / ((SPREAD + 2) * columns.max(1)))
}

/// Returns the ranges of `count` samples between joins.
pub(super) fn parts_between(joins: &[usize], count: usize) -> Vec<Range<usize>> {
    let inner = joins.iter().copied().filter(|join| *join < count);
    let starts = std::iter::once(0).chain(inner.clone());
    let ends = inner.chain(std::iter::once(count));
    starts.zip(ends).map(|(start, end)| start..end).collect()
}

/// Reads the first rows.
pub(super) fn head(table: &mut dyn Table, columns: usize, rows: usize) -> Result<Parts, LogError> {
    let mut found = Parts::empty(columns);
    block(table, rows, &mut found.columns)?;
    Ok(found)
}

/// Reads a beginning, an end, and parts between them.
///
/// - `rows`: rows of a block.
///
/// # Errors
///
/// [`LogError`] if the first block cannot be read. Damage after it ends the reading: the check of the log names it.
pub(super) fn parts(table: &mut dyn Table, columns: usize, rows: usize) -> Result<Parts, LogError> {
    let mut found = Parts::empty(columns);
    let out = &mut found.columns;
    // Number in the file and rows of the blocks in `out`.
    let mut blocks: Vec<(usize, usize)> = Vec::new();
    let mut stride = 1;
    for number in 0.. {
        let kept: usize = blocks.iter().map(|(_, rows)| rows).sum();
        let count = match block(table, rows, out) {
            Ok(count) => count,
            Err(error) if number == 0 => return Err(error),
            Err(_) => {
                // A row may be incomplete.
                for column in out.iter_mut() {
                    column.values.truncate(kept);
                }
                break;
            }
        };
        if count == 0 {
            break;
        }
        blocks.push((number, count));
        let spread =
            |stride: usize| move |(number, _): &&(usize, usize)| number.is_multiple_of(stride);
        while blocks.iter().filter(spread(stride)).count() > SPREAD {
            stride *= 2;
        }
        let goes =
            |(index, _): &(usize, usize)| !index.is_multiple_of(stride) && index + 1 < number;
        while let Some(k) = blocks.iter().position(goes) {
            let start: usize = blocks[..k].iter().map(|(_, rows)| rows).sum();
            let (_, rows) = blocks.remove(k);
            for (column, (min, max)) in out.iter_mut().zip(&mut found.left_out) {
                for value in column.values.drain(start..start + rows) {
                    (*min, *max) = (min.min(value), max.max(value));
                }
            }
        }
    }
    let mut start = 0;
    for (k, (number, rows)) in blocks.iter().enumerate() {
        if k > 0 && blocks[k - 1].0 + 1 != *number {
            found.joins.push(start);
        }
        start += rows;
    }
    Ok(found)
}

/// Appends up to `rows` rows; returns their number.
fn block(table: &mut dyn Table, rows: usize, out: &mut [Readings]) -> Result<usize, LogError> {
    let mut done = 0;
    while done < rows {
        match table.read(rows - done, out)? {
            0 => break,
            count => done += count,
        }
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Place;

    /// A table that counts its rows, and fails at one of them.
    struct Counting {
        next: usize,
        end: usize,
        damaged: usize,
    }

    impl Table for Counting {
        fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
            let to = self.end.min(self.next + limit.min(7));
            for row in self.next..to {
                if row == self.damaged {
                    out[0].push(0.0);
                    return Err(LogError::format("log", " is damaged"));
                }
                for column in out.iter_mut() {
                    column.push(row as f64);
                }
            }
            let count = to - self.next;
            self.next = to;
            Ok(count)
        }

        fn place(&self, _: usize) -> Place {
            Place::Row(0)
        }
    }

    /// First and last row of each part.
    fn read(end: usize, damaged: usize) -> Vec<(f64, f64)> {
        let mut table = Counting {
            next: 0,
            end,
            damaged,
        };
        let found = parts(&mut table, 2, 10).unwrap();
        assert_eq!(found.columns[0].values, found.columns[1].values);
        let values = &found.columns[0].values;
        assert!(values.len() <= 60);
        let ranges = parts_between(&found.joins, values.len());
        let outside = |row: usize| {
            !ranges
                .iter()
                .any(|range| (values[range.start]..=values[range.end - 1]).contains(&(row as f64)))
        };
        let left_out: Vec<f64> = (0..end.min(damaged) / 10 * 10)
            .filter(|row| outside(*row))
            .map(|row| row as f64)
            .collect();
        let least = left_out.first().copied().unwrap_or(f64::INFINITY);
        let most = left_out.last().copied().unwrap_or(f64::NEG_INFINITY);
        assert_eq!(found.left_out, [(least, most); 2]);
        for range in &ranges {
            let segment = &values[range.clone()];
            assert!(
                segment
                    .windows(2)
                    .all(|pair| (pair[1] - pair[0] - 1.0).abs() < 1e-9)
            );
        }
        (ranges.iter())
            .map(|range| (values[range.start], values[range.end - 1]))
            .collect()
    }

    #[test]
    fn a_long_table_shows_its_beginning_its_end_and_parts_between() {
        let never = usize::MAX;
        assert_eq!(read(25, never), [(0.0, 24.0)]);
        assert_eq!(read(40, never), [(0.0, 39.0)]);
        assert_eq!(
            read(1003, never),
            [
                (0.0, 9.0),
                (320.0, 329.0),
                (640.0, 649.0),
                (960.0, 969.0),
                (990.0, 1002.0)
            ]
        );
        for end in 1..400 {
            let parts = read(end, never);
            assert_eq!(
                (parts[0].0, parts[parts.len() - 1].1),
                (0.0, (end - 1) as f64)
            );
        }
    }

    #[test]
    fn damage_behind_the_first_block_ends_the_reading() {
        assert_eq!(read(100, 33), [(0.0, 29.0)]);
        let mut table = Counting {
            next: 0,
            end: 100,
            damaged: 3,
        };
        assert!(parts(&mut table, 2, 10).is_err());
    }
}
