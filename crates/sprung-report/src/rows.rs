//! Builds tables column by column.

use std::fmt::Display;

use super::document::{Column, Row, Table, Tone};

/// A table under construction, with one row for each item.
pub(super) struct Rows<T> {
    items: Vec<T>,
    table: Table,
}

/// Begins a table with one row for each item.
pub(super) fn rows<T: Copy>(items: impl IntoIterator<Item = T>) -> Rows<T> {
    let items: Vec<T> = items.into_iter().collect();
    let table = Table {
        rows: vec![Row::default(); items.len()],
        ..Table::default()
    };
    Rows { items, table }
}

impl<T: Copy> Rows<T> {
    /// Adds a column of texts.
    pub(super) fn text<D: Display>(
        self,
        heading: impl Into<String>,
        cell: impl Fn(T) -> D,
    ) -> Self {
        self.column(heading.into(), false, cell)
    }

    /// Adds a column of numbers, which align at the decimal point.
    pub(super) fn number<D: Display>(
        self,
        heading: impl Into<String>,
        cell: impl Fn(T) -> D,
    ) -> Self {
        self.column(heading.into(), true, cell)
    }

    fn column<D: Display>(mut self, heading: String, numeric: bool, cell: impl Fn(T) -> D) -> Self {
        self.table.columns.push(Column { heading, numeric });
        for (row, item) in self.table.rows.iter_mut().zip(&self.items) {
            row.cells.push(cell(*item).to_string());
        }
        self
    }

    /// Rates the rows.
    pub(super) fn toned(mut self, tone: impl Fn(T) -> Tone) -> Self {
        for (row, item) in self.table.rows.iter_mut().zip(&self.items) {
            row.tone = tone(*item);
        }
        self
    }

    /// Rates some rows as doubtful.
    pub(super) fn marked(self, is_marked: impl Fn(T) -> bool) -> Self {
        self.toned(|item| {
            if is_marked(item) {
                Tone::Doubtful
            } else {
                Tone::Neutral
            }
        })
    }

    /// Returns the table.
    pub(super) fn table(self, caption: impl Into<String>) -> Table {
        Table {
            caption: caption.into(),
            ..self.table
        }
    }

    /// Returns the table; `None` if it has no row.
    pub(super) fn table_if_any(self, caption: impl Into<String>) -> Option<Table> {
        (!self.items.is_empty()).then(|| self.table(caption))
    }
}
