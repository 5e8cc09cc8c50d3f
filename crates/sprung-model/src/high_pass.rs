//! High-pass filter of the rows of joints whose instrument does not show constant deflections.

use sprung_core::parameters::JointParameter;

use super::Model;
use crate::description::RowFilter;

impl Model {
    /// Returns the joints whose acceleration is measured.
    #[must_use]
    pub fn joints_with_acceleration(&self) -> Vec<usize> {
        let instruments = self.fixed.instruments.iter().enumerate();
        instruments
            .filter(|(_, instrument)| instrument.gives_acceleration())
            .map(|(joint, _)| joint)
            .collect()
    }

    /// Returns the high-pass filter of a row, and the places of the row's entries that have passed it already: that
    /// of the deflection. `None` for a row without filter.
    #[must_use]
    pub fn high_pass(&self, row: usize) -> Option<(RowFilter, Vec<usize>)> {
        let joint = self.joint_of(row);
        let filter = self.fixed.instruments.row_filter(joint)?;
        let is_of_deflection = |column: &usize| {
            self.parameters()[*column].joint == Some((JointParameter::Stiffness, joint))
        };
        let columns = self.row_columns(row).iter().enumerate();
        let places = columns.filter(|(_, column)| is_of_deflection(column));
        Some((filter, places.map(|(place, _)| place).collect()))
    }
}
