//! A document model that is independent of any output format.

use serde::Serialize;

/// A complete report.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Document {
    /// The heading of the report.
    pub title: String,
    /// The line below the heading; may be empty.
    pub subtitle: String,
    /// The program and version that wrote the report.
    pub generator: String,
    /// The overall verdict, if there is one.
    pub verdict: Option<Badge>,
    /// The verdict in words, above the first section; may be empty.
    pub summary: String,
    /// The reason for the verdict in a sentence; may be empty.
    pub reason: String,
    /// Names of values that are not to be used alone.
    pub avoid: Vec<String>,
    /// What the reader should do; may be empty.
    pub what_to_do: String,
    /// The sections in reading order.
    pub sections: Vec<Section>,
}

/// A verdict of one or two words.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Badge {
    /// Tone of the verdict.
    pub tone: Tone,
    /// Text of the verdict.
    pub text: String,
}

impl Badge {
    pub(crate) fn new(tone: Tone, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { tone, text }
    }
}

/// Rating of a piece of information, shown as a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// Good.
    Good,
    /// Usable, but with a reservation.
    Doubtful,
    /// Not usable.
    Bad,
    /// Without rating.
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
    /// One or two opening sentences, which a folded section shows too; may be empty.
    pub lead: String,
    /// Whether the section is folded.
    pub fold: Fold,
    /// The content in reading order.
    pub blocks: Vec<Block>,
}

/// Whether a section shows its content before the reader opens it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fold {
    /// The content is always shown.
    #[default]
    Open,
    /// The content is folded on the screen and shown on paper.
    Screen,
    /// The content is folded, and absent on paper unless the reader opened the section.
    Detail,
}

/// A piece of content.
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
    /// Values with their intervals, for comparison.
    Intervals(Intervals),
    /// Bars on a common scale.
    Bars(Bars),
    /// Findings, each with its remedy.
    Findings(Vec<Finding>),
    /// Text shown as it was typed.
    Code(String),
    /// A fixed drawing beside the blocks that follow.
    Drawing(Drawing),
    /// An arm that moves.
    Skeleton(Skeleton),
}

#[cfg(test)]
impl Block {
    pub(crate) fn table(&self) -> Option<&Table> {
        if let Self::Table(table) = self {
            Some(table)
        } else {
            None
        }
    }

    pub(crate) fn figure(&self) -> Option<&Figure> {
        if let Self::Figure(figure) = self {
            Some(figure)
        } else {
            None
        }
    }

    pub(crate) fn intervals(&self) -> Option<&Intervals> {
        if let Self::Intervals(intervals) = self {
            Some(intervals)
        } else {
            None
        }
    }
}

/// An arm that moves: points, and lines between them. The base is the origin.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Skeleton {
    /// Description of the motion.
    pub caption: String,
    /// Height of the floor, m.
    pub floor: f64,
    /// Sides of the squares of the floor, m.
    pub grid: f64,
    /// Index of the point that carries each point; `None` for one on the base. The tool is the last
    /// point.
    pub parents: Vec<Option<usize>>,
    /// Time of each frame, s.
    pub time: Vec<f64>,
    /// Places of all points in each frame, m; the z axis points up.
    pub points: Vec<Vec<[f64; 3]>>,
}

/// A drawing of the program itself.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Drawing {
    /// The drawing as an `svg` element. It becomes markup, so it contains no text of a user.
    pub svg: &'static str,
    /// Description of the drawing.
    pub caption: String,
}

/// A table with a caption.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Table {
    /// Description of the table; may be empty.
    pub caption: String,
    /// The columns from left to right.
    pub columns: Vec<Column>,
    /// The rows from top to bottom.
    pub rows: Vec<Row>,
    /// Headings above rows, each with the index of the row that follows it, in ascending order.
    pub headings: Vec<(usize, String)>,
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
    /// Rating of the row.
    pub tone: Tone,
}

/// A finding.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Finding {
    /// Rating of the finding.
    pub severity: Tone,
    /// Stable short name for reference.
    pub code: String,
    /// The finding in a few words.
    pub title: String,
    /// The explanation.
    pub text: String,
    /// Remedy; may be empty.
    pub remedy: String,
    /// Meaning of this kind of finding: its likely cause, as a sentence; may be empty. A page shows
    /// cause and condition once, under the first of its findings that have them.
    pub cause: String,
    /// The observation that leads to it, as a sentence; may be empty.
    pub condition: String,
    /// When it may be ignored, as a sentence; may be empty.
    pub ignore: String,
}

/// Values with their intervals: one row per quantity, one colour per source. Without ticks each row
/// has its own scale.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Intervals {
    /// Description of the values.
    pub caption: String,
    /// Sources of the values, one name per mark of a row.
    pub names: Vec<String>,
    /// Positions on the common scale of all rows, from -1 to 1, with their labels.
    pub ticks: Vec<(f64, String)>,
    /// The rows from top to bottom.
    pub rows: Vec<IntervalRow>,
    /// Whether the rows of each group are folded.
    pub folded: bool,
}

/// One quantity from several sources.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct IntervalRow {
    /// Heading that the row shares with its neighbours, for example a joint; may be empty.
    pub group: String,
    /// Name of the quantity.
    pub label: String,
    /// Text at the right: the value that half the width of the row represents, or the size of the
    /// interval on a common scale.
    pub scale: String,
    /// One mark per source; `None` if the source has no value.
    pub marks: Vec<Option<Mark>>,
    /// Rating of the row.
    pub tone: Tone,
}

/// A value and its interval; -1 is the left end of a row and 1 is its right end. Arrows mark what
/// lies outside.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Mark {
    /// The value.
    pub at: f64,
    /// The ends of its interval.
    pub interval: Option<[f64; 2]>,
}

/// Bars of several kinds, one group per item.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Bars {
    /// Description of the bars.
    pub caption: String,
    /// Kinds of bars, one per bar of a row.
    pub names: Vec<String>,
    /// Positions on the scale, from 0 to 1, with their labels.
    pub ticks: Vec<(f64, String)>,
    /// The rows from top to bottom.
    pub rows: Vec<BarRow>,
}

/// The bars of one item.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct BarRow {
    /// Name of the item.
    pub label: String,
    /// One bar per kind; `None` if the item has no value of this kind.
    pub bars: Vec<Option<Bar>>,
    /// Rating of the row.
    pub tone: Tone,
}

/// A bar.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Bar {
    /// Length; 1 is the full width.
    pub length: f64,
    /// Value of the bar as text.
    pub text: String,
}

/// A figure whose panels share the horizontal axis, the cursor and the zoom.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Figure {
    /// The anchor of the figure, unique in the document.
    pub id: String,
    /// Description of the figure.
    pub caption: String,
    /// The quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Whether the horizontal axis is logarithmic; its coordinates then are positive.
    pub logarithmic: bool,
    /// How the panels are arranged.
    pub layout: Layout,
    /// The panels in reading order.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// Returns a figure over time.
    pub(crate) fn over_time(
        id: impl Into<String>,
        caption: impl Into<String>,
        layout: Layout,
        panels: impl IntoIterator<Item = Panel>,
    ) -> Self {
        Self {
            id: id.into(),
            caption: caption.into(),
            x_label: "time [s]".to_owned(),
            logarithmic: false,
            layout,
            panels: panels.into_iter().collect(),
        }
    }
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
    /// Low panels next to each other, for an overview.
    Overview,
    /// One panel over half the width; two such figures are next to each other.
    Half,
}

/// One coordinate system of a figure.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Panel {
    /// The quantity and unit of the vertical axis.
    pub y_label: String,
    /// A short result beside the label; may be empty.
    pub note: String,
    /// Horizontal coordinates of the points: finite and not decreasing.
    pub x: Vec<f64>,
    /// The curves; later ones are drawn on top.
    pub series: Vec<Series>,
    /// Label of a second coordinate system below, which shows the differences of the first curve
    /// from the others; `None` without one.
    pub errors: Option<String>,
    /// Vertical lines.
    pub marks: Vec<Line>,
}

/// A vertical line in a panel.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Line {
    /// Horizontal coordinate.
    pub at: f64,
    /// The words beside it.
    pub text: String,
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// The vertical coordinates; `None` is a gap.
    pub values: Vec<Option<f64>>,
    /// The role of the curve, which decides its colour and dashes.
    pub style: Style,
    /// Whether the scale of the panel ignores the curve. Marks at the edge show where it lies
    /// outside.
    pub clipped: bool,
}

impl Series {
    /// Returns a curve that decides on the scale of its panel.
    pub(crate) fn new(name: impl Into<String>, style: Style, values: Vec<Option<f64>>) -> Self {
        Self {
            name: name.into(),
            values,
            style,
            clipped: false,
        }
    }
}

/// The role of a curve in its panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// A measured signal.
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
    /// Measured points without a line.
    Cloud,
}
