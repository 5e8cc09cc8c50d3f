//! The unknowns of a system: all parameters except those with a known value.

use crate::model::Model;
use crate::regression::{SystemPart, Triangle};

/// Splits the parameters of a model into unknowns and known values.
pub(crate) struct Free {
    /// Index in theta of each unknown.
    pub(crate) unknowns: Vec<usize>,
    /// Value of each parameter with a known value, \[p\].
    pub(super) known: Vec<Option<f64>>,
    /// Unknowns in each row, as indices into `unknowns`.
    pub(crate) columns: Vec<Vec<usize>>,
    /// Parameters in each row, as indices into theta.
    touched: Vec<Vec<usize>>,
}

impl Free {
    pub(crate) fn new(model: &Model) -> Self {
        let known: Vec<Option<f64>> = (0..model.parameters().len())
            .map(|i| model.known(i))
            .collect();
        let unknowns: Vec<usize> = (0..known.len()).filter(|&i| known[i].is_none()).collect();
        let place = |column: &usize| unknowns.binary_search(column).ok();
        let touched: Vec<Vec<usize>> = (0..model.rows())
            .map(|row| model.row_columns(row).to_vec())
            .collect();
        Self {
            columns: (touched.iter())
                .map(|columns| columns.iter().filter_map(place).collect())
                .collect(),
            touched,
            unknowns,
            known,
        }
    }

    /// Moves the columns of known parameters to the right-hand side.
    pub(crate) fn factors(&self, factors: Vec<Triangle>) -> Vec<Triangle> {
        if self.unknowns.len() == self.known.len() {
            return factors;
        }
        let known = |columns: &Vec<usize>| -> Vec<Option<f64>> {
            columns.iter().map(|&c| self.known[c]).collect()
        };
        (factors.iter().zip(&self.touched))
            .map(|(factor, columns)| factor.with_known(&known(columns)))
            .collect()
    }

    pub(super) fn parts<'a>(&'a self, factors: &'a [Triangle]) -> Vec<SystemPart<'a>> {
        (self.columns.iter().zip(factors))
            .map(|(columns, factor)| SystemPart { columns, factor })
            .collect()
    }

    /// Returns the values of all parameters, \[p\], from the values of the unknowns and of the known
    /// parameters.
    pub(crate) fn whole<T: Copy>(&self, of_unknowns: &[T], of_known: impl Fn(f64) -> T) -> Vec<T> {
        let mut next = of_unknowns.iter();
        (self.known.iter())
            .filter_map(|known| match known {
                Some(value) => Some(of_known(*value)),
                None => next.next().copied(),
            })
            .collect()
    }
}
