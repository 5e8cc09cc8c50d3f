//! A document model that is independent of any output format.

use serde::Serialize;

/// A complete report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Document {
    /// The heading of the report.
    pub title: String,
    /// One line below the heading, which may be empty.
    pub subtitle: String,
    /// The program and version that wrote the report.
    pub generator: String,
    /// The overall judgement, if there is one.
    pub verdict: Option<Badge>,
    /// The sections in reading order.
    pub sections: Vec<Section>,
}

/// A short judgement in a word or two.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Badge {
    /// How good the news is.
    pub tone: Tone,
    /// The words to show.
    pub text: String,
}

/// How good or bad a piece of information is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// All is well.
    Good,
    /// Usable, but with a reservation.
    Doubtful,
    /// Not usable.
    Bad,
    /// Neither good nor bad.
    #[default]
    Neutral,
}

/// A part of the report with its own heading.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Section {
    /// The anchor of the section, unique in the document.
    pub id: String,
    /// The heading of the section.
    pub heading: String,
    /// One or two opening sentences, which may be empty.
    pub lead: String,
    /// The content in reading order.
    pub blocks: Vec<Block>,
}

/// One piece of content.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Block {
    /// Running text.
    Paragraph(String),
    /// Names with their values.
    KeyValues(Vec<(String, String)>),
    /// A table.
    Table(Table),
    /// A figure of one or more panels.
    Figure(Figure),
    /// Values with their intervals, side by side.
    Intervals(Intervals),
    /// Sizes on a common scale.
    Bars(Bars),
    /// Remarks of a check, each with its remedy.
    Findings(Vec<Finding>),
    /// Text to be shown as typed.
    Code(String),
}

/// A table with a caption.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Table {
    /// What the table shows, which may be empty.
    pub caption: String,
    /// The columns from left to right.
    pub columns: Vec<Column>,
    /// The rows from top to bottom.
    pub rows: Vec<Row>,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Column {
    /// The heading of the column.
    pub heading: String,
    /// Whether the cells are numbers, which align at the decimal point.
    pub numeric: bool,
}

/// A row of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Row {
    /// The formatted cells, one for each column.
    pub cells: Vec<String>,
    /// How good the news in this row is.
    pub tone: Tone,
}

/// A remark of a check.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Finding {
    /// How much the remark matters.
    pub severity: Tone,
    /// A stable short name to look up.
    pub code: String,
    /// The remark in a few words.
    pub title: String,
    /// The explanation.
    pub text: String,
    /// What to do about it, which may be empty.
    pub remedy: String,
}

/// Values with their intervals: one row per quantity on a scale of its own,
/// one colour per origin.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Intervals {
    /// What is shown.
    pub caption: String,
    /// Where the values come from, one name per mark of a row.
    pub names: Vec<String>,
    /// The rows from top to bottom.
    pub rows: Vec<IntervalRow>,
}

/// One quantity of several origins.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct IntervalRow {
    /// Name of the quantity.
    pub label: String,
    /// What half the width of the row stands for.
    pub scale: String,
    /// One mark per origin, if it has a value.
    pub marks: Vec<Option<Mark>>,
}

/// A value in its interval; -1 is the left end of a row, 1 its right end.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Mark {
    /// The value.
    pub at: f64,
    /// The ends of its interval.
    pub interval: Option<[f64; 2]>,
}

/// Sizes of several kinds as bars, a group for each thing that has them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Bars {
    /// What is shown.
    pub caption: String,
    /// The kinds of size, one per bar of a row.
    pub names: Vec<String>,
    /// Places on the scale, from 0 to 1, and what stands there.
    pub ticks: Vec<(f64, String)>,
    /// The rows from top to bottom.
    pub rows: Vec<BarRow>,
}

/// The sizes of one thing.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct BarRow {
    /// Name of the thing.
    pub label: String,
    /// One bar per kind, if it has that size.
    pub bars: Vec<Option<Bar>>,
    /// How good the news in this row is.
    pub tone: Tone,
}

/// A size.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Bar {
    /// Length; 1 is the whole width.
    pub length: f64,
    /// The size in figures.
    pub text: String,
}

/// A figure whose panels share the horizontal axis, the cursor and the zoom.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Figure {
    /// The anchor of the figure, unique in the document.
    pub id: String,
    /// What the figure shows.
    pub caption: String,
    /// The quantity and unit of the horizontal axis.
    pub x_label: String,
    /// How the panels are arranged.
    pub layout: Layout,
    /// The panels in reading order.
    pub panels: Vec<Panel>,
}

/// The arrangement of the panels of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// One panel above the other, each over the full width.
    #[default]
    Stack,
    /// Small panels next to each other.
    Grid,
}

/// One coordinate system of a figure.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Panel {
    /// The quantity and unit of the vertical axis.
    pub y_label: String,
    /// The finite and never falling horizontal coordinates of the points.
    pub x: Vec<f64>,
    /// The curves, the first one lowest.
    pub series: Vec<Series>,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// The vertical coordinates, where `None` leaves a gap.
    pub values: Vec<Option<f64>>,
    /// The role of the curve, which decides its colour and dashes.
    pub style: Style,
}

/// The role of a curve in its panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// What was measured.
    #[default]
    Measured,
    /// The first model.
    First,
    /// The second model.
    Second,
    /// The third model.
    Third,
    /// A difference between model and measurement.
    Error,
    /// A known or nominal value to compare with.
    Reference,
}
