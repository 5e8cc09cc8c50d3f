//! High-pass filter of the rows of joints whose deflection comes from a gyroscope.

use sprung_core::parameters::JointParameter;

use super::Model;

impl Model {
    /// Returns whether the deflection of a joint comes from a gyroscope.
    #[must_use]
    pub(crate) fn has_gyroscope(&self, joint: usize) -> bool {
        let own = self.fixed.high_pass.as_ref();
        own.is_some_and(|own| own.joints[joint])
    }

    /// Returns the corner of the high-pass filter of a row, rad/s, and the places of the row's entries that
    /// have passed it already: that of the deflection. `None` for a row without filter.
    #[must_use]
    pub(crate) fn high_pass(&self, row: usize) -> Option<(f64, Vec<usize>)> {
        let own = self.fixed.high_pass.as_ref()?;
        let joint = self.joint_of(row);
        let is_of_deflection = |column: &usize| {
            self.parameters()[*column].joint == Some((JointParameter::Stiffness, joint))
        };
        let columns = self.row_columns(row).iter().enumerate();
        own.joints[joint].then(|| {
            let places = columns.filter(|(_, column)| is_of_deflection(column));
            (own.corner, places.map(|(place, _)| place).collect())
        })
    }
}
