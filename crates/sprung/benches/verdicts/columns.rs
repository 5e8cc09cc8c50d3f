//! A log as columns of numbers.

use std::fmt::Write;

/// A log as columns: link positions, motor positions and motor torques.
pub(crate) struct Table {
    pub(crate) time: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Table {
    pub(crate) fn scale(&mut self, column: usize, by: f64) {
        self.columns[column]
            .iter_mut()
            .for_each(|value| *value *= by);
    }

    /// Moves columns later by a number of samples.
    pub(crate) fn shift(&mut self, columns: std::ops::Range<usize>, samples: usize) {
        let left = self.time.len() - samples;
        for (i, values) in self.columns.iter_mut().enumerate() {
            if columns.contains(&i) {
                values.truncate(left);
            } else {
                values.drain(..samples);
            }
        }
        self.time.truncate(left);
    }

    pub(crate) fn csv(&self, header: &str) -> Vec<u8> {
        let mut text = format!("{header}\n");
        for (k, time) in self.time.iter().enumerate() {
            write!(text, "{time}").expect("a string takes any text");
            for column in &self.columns {
                write!(text, ",{}", column[k]).expect("a string takes any text");
            }
            text.push('\n');
        }
        text.into_bytes()
    }
}
