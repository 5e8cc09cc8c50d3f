//! Curves and clouds over time, velocity or length, in panels one below another.

use serde::Deserialize;

use super::svg::{Anchor, Axis, Drawing, MARGIN, WIDTH};

/// One panel.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(super) struct Panel {
    /// Quantity and unit of the vertical axis.
    pub(super) title: String,
    /// Quantity and unit of the horizontal axis; empty if the panel below has the same.
    #[serde(default)]
    pub(super) below: String,
    #[serde(default = "normal")]
    pub(super) height: f64,
    #[serde(default)]
    pub(super) logarithmic: bool,
    pub(super) curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(super) struct Curve {
    /// Which name of the legend it has.
    pub(super) series: usize,
    #[serde(default)]
    pub(super) style: Style,
    pub(super) x: Vec<f64>,
    /// Absent where the curve has a gap.
    pub(super) y: Vec<Option<f64>>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Style {
    #[default]
    Line,
    Points,
    /// A line with a mark at each point.
    Marks,
}

fn normal() -> f64 {
    110.0
}

impl Panel {
    /// Draws the panel below what the drawing has.
    pub(super) fn draw(&self, drawing: &mut Drawing) {
        let pairs = || (self.curves.iter()).flat_map(Curve::points);
        let xs: Vec<f64> = pairs().map(|point| point[0]).collect();
        let ys: Vec<f64> = pairs().map(|point| point[1]).collect();
        let [horizontal, vertical] =
            [&xs, &ys].map(|values| Axis::around(values, self.logarithmic));
        let [left, right] = [MARGIN + 52.0, WIDTH - MARGIN - 12.0];
        drawing.height += 22.0;
        drawing.text([MARGIN, drawing.height], Anchor::Start, "", &self.title);
        let top = drawing.height + 13.0;
        let bottom = top + self.height;
        let place = |[x, y]: [f64; 2]| {
            [
                left + (right - left) * horizontal.place(x),
                bottom - (bottom - top) * vertical.place(y),
            ]
        };
        for (value, text) in vertical.ticks(4.0) {
            let [_, y] = place([horizontal.from, value]);
            drawing.line([left, y], [right, y], " class=\"g\"");
            drawing.text([left - 5.0, y + 4.5], Anchor::End, " class=\"a\"", &text);
        }
        if !self.below.is_empty() {
            for (value, text) in horizontal.ticks(6.0) {
                let [x, _] = place([value, vertical.from]);
                drawing.line([x, bottom], [x, bottom + 4.0], " class=\"g\"");
                drawing.text([x, bottom + 17.0], Anchor::Middle, " class=\"a\"", &text);
            }
        }
        for curve in &self.curves {
            let points: Vec<[f64; 2]> = curve.points().map(place).collect();
            match curve.style {
                Style::Points => drawing.cloud(&points, curve.series),
                // A prediction lies on the measured curve.
                Style::Line => {
                    let width = if curve.series == 0 { 4.0 } else { 1.7 };
                    drawing.curve(&points, curve.series, width);
                }
                Style::Marks => {
                    drawing.curve(&points, curve.series, 1.6);
                    for point in points {
                        drawing.mark(point, curve.series);
                    }
                }
            }
        }
        drawing.height = bottom;
        if !self.below.is_empty() {
            drawing.height = bottom + 35.0;
            let middle = [f64::midpoint(left, right), drawing.height];
            drawing.text(middle, Anchor::Middle, " class=\"a\"", &self.below);
        }
    }
}

impl Curve {
    fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let pairs = self.x.iter().zip(&self.y);
        pairs.filter_map(|(x, y)| y.map(|y| [*x, y]))
    }
}
