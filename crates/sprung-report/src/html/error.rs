//! Errors of a report.

/// Error of writing a report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A curve and its panel differ in their number of points.
    #[error("series `{series}` of figure `{figure}` has {found} values instead of {expected}")]
    Length {
        /// The figure of the curve.
        figure: String,
        /// The name of the curve.
        series: String,
        /// The number of horizontal coordinates of the panel.
        expected: usize,
        /// The number of values of the curve.
        found: usize,
    },
    /// The horizontal coordinates of a panel are not finite or decrease.
    #[error("horizontal axis of figure `{figure}` is not finite or falls at point {index}")]
    Axis {
        /// The figure of the panel.
        figure: String,
        /// Index of the first faulty point.
        index: usize,
    },
    /// The figures could not be written as JSON.
    #[error("figure data cannot be written")]
    Data(#[from] serde_json::Error),
    /// The template of the page cannot be rendered.
    #[error("page template cannot be filled in")]
    Template(#[from] minijinja::Error),
}
