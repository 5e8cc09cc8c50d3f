//! Columns of the regressor of the paper's arm that are not zero.

/// Columns of theta in each row: two link rows, then two motor rows.
pub(crate) const ROW_COLUMNS: [&[usize]; 4] = [
    &[0, 1, 2, 5, 9, 11],
    &[1, 2, 6, 10, 12],
    &[3, 7, 9, 13],
    &[4, 8, 10, 14],
];
