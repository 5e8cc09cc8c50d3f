//! Drawings in SVG that are readable on a telephone and on a wide page, light and dark.

use std::fmt::Write as _;

/// Width in units of the drawing; a page shows it with [`SHOWN`] pixels, or with its own width if that is smaller.
pub(super) const WIDTH: f64 = 480.0;
const SHOWN: f64 = 500.0;

/// Free space at the sides.
pub(super) const MARGIN: f64 = 14.0;

/// Mean width of a letter relative to the size of its font.
const LETTER: f64 = 0.6;

const STYLE: &str = "svg{color:#1f2328;background:#fff;--g:#d1d9e0;--m:#59636e;--b:#fff;--s0:#0b62b8;--s1:#c2410c;\
    --s2:#1a7f37;--s3:#8250df;--s4:#6e7781}\
    @media(prefers-color-scheme:dark){svg{color:#e6edf3;background:#0d1117;--g:#30363d;--m:#9198a1;--b:#0d1117;\
    --s0:#6cb6ff;--s1:#ff9a57;--s2:#57d364;--s3:#c297ff;--s4:#8b949e}}\
    text{font-family:system-ui,-apple-system,'Segoe UI',Helvetica,Arial,'DejaVu Sans',sans-serif;font-size:14.5px;\
    fill:currentColor}\
    .t{font-weight:600;font-size:15.5px}.a{font-size:13.5px;fill:var(--m)}.f{font-size:11.5px;fill:var(--m)}\
    .g{stroke:var(--g);fill:none}.r{stroke:currentColor;stroke-dasharray:4 3;fill:none}";

/// A drawing that grows downwards.
#[derive(Default)]
pub(super) struct Drawing {
    body: String,
    pub(super) height: f64,
}

/// Where a text ends.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Drawing {
    /// Adds a line of text with a class of the style, or with the colour of a series.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], anchor: Anchor, look: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            self.body,
            "<text x=\"{}\" y=\"{}\"{anchor}{look}>{text}</text>",
            short(x),
            short(y)
        );
    }

    /// Adds lines of text that fit the width, and grows by them.
    pub(super) fn paragraph(&mut self, class: &str, size: f64, text: &str) {
        for line in wrapped(text, size) {
            self.height += size * 1.35;
            self.text(
                [MARGIN, self.height],
                Anchor::Start,
                &format!(" class=\"{class}\""),
                &line,
            );
        }
    }

    /// Adds a straight line with a class of the style.
    pub(super) fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], look: &str) {
        let [x1, y1, x2, y2] = [x1, y1, x2, y2].map(short);
        let _ = writeln!(self.body, "<path{look} d=\"M{x1} {y1}L{x2} {y2}\"/>");
    }

    /// Adds a curve through points in the colour of a series.
    pub(super) fn curve(&mut self, points: &[[f64; 2]], series: usize, width: f64) {
        let path: Vec<String> = (points.iter())
            .map(|[x, y]| format!("{} {}", short(*x), short(*y)))
            .collect();
        let pale = if width > 3.0 {
            " stroke-opacity=\".5\""
        } else {
            ""
        };
        let _ = writeln!(
            self.body,
            "<path fill=\"none\" stroke=\"var(--s{series})\" stroke-width=\"{width}\"{pale} stroke-linejoin=\"round\" d=\"M{}\"/>",
            path.join("L")
        );
    }

    /// Adds small points in the colour of a series.
    pub(super) fn cloud(&mut self, points: &[[f64; 2]], series: usize) {
        let path: Vec<String> = (points.iter())
            .map(|[x, y]| format!("M{} {}h0", short(*x), short(*y)))
            .collect();
        let _ = writeln!(
            self.body,
            "<path stroke=\"var(--s{series})\" stroke-width=\"2.6\" stroke-linecap=\"round\" stroke-opacity=\".6\" d=\"{}\"/>",
            path.concat()
        );
    }

    /// Adds the mark of a series.
    pub(super) fn mark(&mut self, [x, y]: [f64; 2], series: usize) {
        let path = match series {
            0 => "m-6 0a6 6 0 1 0 12 0a6 6 0 1 0 -12 0z",
            1 => "m-5.3 -5.3h10.6v10.6h-10.6z",
            2 => "m0 -7.4l7.4 7.4l-7.4 7.4l-7.4 -7.4z",
            3 => "m0 -7l6.8 11.8h-13.6z",
            _ => "m0 6.6l6.6 -11.4h-13.2z",
        };
        let _ = writeln!(
            self.body,
            "<path fill=\"var(--s{series})\" stroke=\"var(--b)\" d=\"M{} {}{path}\"/>",
            short(x),
            short(y)
        );
    }

    /// Adds marks and names of series, in as many lines as they need.
    pub(super) fn legend(&mut self, names: &[&str]) {
        self.height += 20.0;
        let mut x = MARGIN;
        for (k, name) in names.iter().enumerate() {
            let width = 16.0 + width_of(name, 14.5) + 14.0;
            if x > MARGIN && x + width > WIDTH {
                x = MARGIN;
                self.height += 20.0;
            }
            self.mark([x + 7.0, self.height - 5.0], k);
            self.text([x + 18.0, self.height], Anchor::Start, "", name);
            x += width;
        }
    }

    /// Returns the file, with its title for readers that do not see it.
    pub(super) fn finish(mut self, title: &str) -> String {
        self.height += 12.0;
        let (height, shown) = (self.height, self.height * SHOWN / WIDTH);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{SHOWN}\" height=\"{}\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\">\n\
             <title>{}</title>\n<style>{STYLE}</style>\n{}</svg>\n",
            short(shown),
            short(height),
            title.replace('&', "&amp;").replace('<', "&lt;"),
            self.body
        )
    }
}

/// Returns a coordinate with one place.
fn short(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

/// Returns the approximate width of a text.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * LETTER
}

/// Returns a text in lines that fit the width.
fn wrapped(text: &str, size: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or("", String::as_str);
        let longer = format!("{last} {word}").trim_start().to_owned();
        if !last.is_empty() && width_of(&longer, size) > WIDTH - 2.0 * MARGIN {
            lines.push(word.to_owned());
        } else if let Some(line) = lines.last_mut() {
            *line = longer;
        }
    }
    lines
}

/// The axis of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) is_logarithmic: bool,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Axis {
    /// Returns an axis that contains all values.
    ///
    /// A logarithmic axis ends at powers of ten.
    pub(super) fn around(values: &[f64], is_logarithmic: bool) -> Self {
        let values = || values.iter().copied().filter(|value| value.is_finite());
        let [mut from, mut to] = [
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        ];
        if is_logarithmic {
            from = 10_f64.powf((from * 0.9).log10().floor());
            to = 10_f64.powf((to * 1.1).log10().ceil());
        } else {
            let room = 0.04 * (to - from).max(1e-9);
            (from, to) = (from - room, to + room);
        }
        Self {
            is_logarithmic,
            from,
            to,
        }
    }

    /// Returns where a value lies, 0 at the beginning and 1 at the end.
    pub(super) fn place(&self, value: f64) -> f64 {
        let share = if self.is_logarithmic {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        share.clamp(-0.01, 1.01)
    }

    /// Returns values with a line and their texts, at most about `count`.
    pub(super) fn ticks(&self, count: f64) -> Vec<(f64, String)> {
        if self.is_logarithmic {
            let [first, last] = [self.from, self.to].map(|end| end.log10().round() as i32);
            let step = (f64::from(last - first) / count).ceil().max(1.0) as usize;
            return (first..=last)
                .step_by(step)
                .map(|power| (10_f64.powi(power), plain(10_f64.powi(power))))
                .collect();
        }
        let raw = (self.to - self.from) / count;
        let decade = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * decade)
            .find(|step| *step >= raw)
            .unwrap_or(10.0 * decade);
        let first = (self.from / step).ceil() as i64;
        let last = (self.to / step).floor() as i64;
        (first..=last)
            .map(|k| k as f64 * step)
            .map(|value| (value, plain(value)))
            .collect()
    }
}

/// Returns a number without superfluous zeros, in groups of three digits.
fn plain(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if value >= 10_000.0 && !text.contains('.') {
        let split = text.len() - 3;
        return format!("{} {}", &text[..split], &text[split..]);
    }
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_contain_their_values_and_have_round_ticks() {
        let axis = Axis::around(&[0.03, 4.0, f64::NAN], true);
        assert!((axis.from - 0.01).abs() < 1e-12 && (axis.to - 10.0).abs() < 1e-9);
        let texts: Vec<String> = axis.ticks(6.0).into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["0.01", "0.1", "1", "10"]);
        assert!((axis.place(0.1) - 1.0 / 3.0).abs() < 1e-9);
        let axis = Axis::around(&[-31.0, 12.0], false);
        let texts: Vec<String> = axis.ticks(5.0).into_iter().map(|(_, text)| text).collect();
        assert_eq!(texts, ["-30", "-20", "-10", "0", "10"]);
    }

    #[test]
    fn long_texts_are_broken_and_signs_are_escaped() {
        let mut drawing = Drawing::default();
        drawing.paragraph("t", 15.5, &"word ".repeat(40));
        drawing.text([0.0, 0.0], Anchor::End, "", "a < b & c");
        let file = drawing.finish("x < y");
        assert!(file.matches("class=\"t\"").count() >= 3, "{file}");
        assert!(file.contains("a &lt; b &amp; c") && file.contains("<title>x &lt; y"));
        assert_eq!(plain(75000.0), "75 000");
    }
}
