//! Columns in memory, read block by block like those of a file.

use super::array_shape::no_topics;
use super::table::{Opened, Readings, Request, Table};
use crate::arrays::{Array, Arrays};
use crate::columns::names::Names;
use crate::error::{LogError, Place};

/// The wanted columns and the position of the reader.
pub(super) struct MemoryTable {
    columns: Vec<Array>,
    rows: usize,
    /// The first row of the last block.
    first: usize,
    /// The row after the last block.
    next: usize,
}

impl MemoryTable {
    pub(super) fn new(columns: Vec<Array>, rows: usize) -> Self {
        Self {
            columns,
            rows,
            first: 0,
            next: 0,
        }
    }
}

/// Finds the wanted columns.
///
/// # Errors
///
/// [`LogError`] if a wanted column is missing, or a topic is requested.
pub(crate) fn open(request: &Request<'_>, arrays: &Arrays) -> Result<Opened, LogError> {
    no_topics(request)?;
    let names = Names {
        file: request.file,
        all: arrays.names(),
        given: true,
    };
    let mut columns = Vec::new();
    let mut found = Vec::new();
    for pick in request.picks {
        let place = names.find(pick)?;
        found.push(arrays.names()[place].clone());
        columns.extend(arrays.array(place).cloned());
    }
    Ok(Opened {
        table: Box::new(MemoryTable::new(columns, arrays.len())),
        names: found,
        time_unit: None,
        all: arrays.names().to_vec(),
        has_names: true,
        units: Vec::new(),
    })
}

impl Table for MemoryTable {
    fn read(&mut self, limit: usize, out: &mut [Readings]) -> Result<usize, LogError> {
        self.first = self.next;
        self.next = self.rows.min(self.first.saturating_add(limit));
        let rows = self.first..self.next;
        for (column, out) in self.columns.iter().zip(out) {
            match column {
                Array::Float(numbers) => {
                    let numbers = (**numbers).as_ref().get(rows.clone());
                    numbers.into_iter().flatten().for_each(|x| out.push(*x));
                }
                Array::Integer(numbers) => {
                    let numbers = (**numbers).as_ref().get(rows.clone());
                    (numbers.into_iter().flatten()).for_each(|x| out.push_integer(*x));
                }
                Array::Column(column) => column.rows(rows.clone()).for_each(|x| out.push(x)),
            }
        }
        Ok(rows.len())
    }

    fn place(&self, i: usize) -> Place {
        Place::Row((self.first + i + 1) as u64)
    }
}
