//! Dot plots: rows with a mark for each series, on one axis.

use super::svg::{Anchor, Axis, Drawing, MARGIN, WIDTH, width_of};

/// Space between a row and the next one.
const ROW: f64 = 38.0;

/// A value with its text, and its interval if it has one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Dot {
    pub(super) value: f64,
    pub(super) text: String,
    pub(super) interval: Option<[f64; 2]>,
}

/// A row: its name, and the dot of each series.
pub(super) type Row = (String, Vec<Option<Dot>>);

/// What a dot plot shows.
pub(super) struct Dots<'a> {
    /// Quantity and unit under the axis.
    pub(super) quantity: &'a str,
    pub(super) is_logarithmic: bool,
    pub(super) series: Vec<&'a str>,
    pub(super) rows: Vec<Row>,
    /// A value with a dashed line, and its name.
    pub(super) reference: Option<(f64, &'a str)>,
}

impl Dots<'_> {
    /// Draws the plot below what the drawing has.
    pub(super) fn draw(&self, drawing: &mut Drawing) {
        if self.series.len() > 1 {
            drawing.legend(&self.series);
        }
        let axis = self.axis();
        let [left, right] = [MARGIN + 6.0, WIDTH - MARGIN - 6.0];
        let at = |value: f64| left + (right - left) * axis.place(value);
        let top = drawing.height + 10.0;
        let bottom = top + ROW * self.rows.len() as f64 + 4.0;
        for (value, text) in axis.ticks(6.0) {
            drawing.line([at(value), top], [at(value), bottom], " class=\"g\"");
            let anchor = match at(value) {
                x if x < left + 12.0 => Anchor::Start,
                x if x > right - 12.0 => Anchor::End,
                _ => Anchor::Middle,
            };
            let x = match anchor {
                Anchor::Start => MARGIN,
                Anchor::End => WIDTH - MARGIN,
                Anchor::Middle => at(value),
            };
            drawing.text([x, bottom + 16.0], anchor, " class=\"a\"", &text);
        }
        if let Some((value, _)) = self.reference {
            drawing.line([at(value), top], [at(value), bottom], " class=\"r\"");
        }
        for (k, (name, dots)) in self.rows.iter().enumerate() {
            let y = top + ROW * k as f64;
            self.draw_row(drawing, y, name, dots, &at);
        }
        drawing.height = bottom + 18.0;
        let reference = self
            .reference
            .map_or_else(String::new, |(_, name)| format!("; dashed: {name}"));
        let quantity = format!("{}{reference}", self.quantity);
        drawing.paragraph("a", 13.5, &quantity);
    }

    fn draw_row(
        &self,
        drawing: &mut Drawing,
        y: f64,
        name: &str,
        dots: &[Option<Dot>],
        at: &dyn Fn(f64) -> f64,
    ) {
        drawing.text([MARGIN, y + 15.0], Anchor::Start, "", name);
        let mut x = WIDTH - MARGIN;
        let shown = dots.iter().enumerate().rev();
        for (k, dot) in shown.filter_map(|(k, dot)| dot.as_ref().map(|dot| (k, dot))) {
            let look = if self.series.len() > 1 {
                format!(" style=\"fill:var(--s{k})\"")
            } else {
                String::new()
            };
            drawing.text([x, y + 15.0], Anchor::End, &look, &dot.text);
            x -= width_of(&dot.text, 14.5) + 12.0;
        }
        let track = y + 27.0;
        drawing.line([MARGIN, track], [WIDTH - MARGIN, track], " class=\"g\"");
        // The first series lies above the others.
        for (k, dot) in dots.iter().enumerate().rev() {
            let Some(dot) = dot else { continue };
            if let Some([low, high]) = dot.interval {
                let look = format!(" stroke=\"var(--s{k})\" stroke-width=\"3\"");
                drawing.line([at(low), track], [at(high), track], &look);
            }
            drawing.mark([at(dot.value), track], k);
        }
    }

    fn axis(&self) -> Axis {
        let dots = self.rows.iter().flat_map(|(_, dots)| dots.iter().flatten());
        let mut values: Vec<f64> = dots
            .flat_map(|dot| {
                [
                    Some(dot.value),
                    dot.interval.map(|i| i[0]),
                    dot.interval.map(|i| i[1]),
                ]
            })
            .flatten()
            .collect();
        values.extend(self.reference.map(|(value, _)| value));
        Axis::around(&values, self.is_logarithmic)
    }
}
