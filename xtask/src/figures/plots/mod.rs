//! Figures as drawings: dot plots of the file of figures, and curves of the gallery.

mod catalogue;
mod curves;
mod dots;
mod svg;

use std::collections::BTreeMap;
use std::fs;

use serde::Deserialize;

use super::file::{Figure, Figures, Measured};
use crate::steps::said;
use crate::{files, root};
use catalogue::{CHARTS, Cells, Chart, LENGTHS};
use curves::{Curve, Panel, Style};
use dots::{Dot, Dots, Row};
use svg::Drawing;

/// Curves of the gallery, relative to the root of the repository.
pub(super) const CURVES: &str = "benches/gallery.json";

/// A 95 % interval, in standard errors to each side.
const WIDE: f64 = 1.96;

/// A drawing of the gallery: panels, and values with their intervals.
#[derive(Deserialize)]
struct Shown {
    title: String,
    series: Vec<String>,
    panels: Vec<Panel>,
    #[serde(default)]
    quantity: String,
    #[serde(default)]
    values: Vec<Estimate>,
    /// How it was made.
    note: String,
}

/// An estimate with its interval, and the text beside it.
#[derive(Deserialize)]
struct Estimate {
    name: String,
    value: f64,
    interval: [f64; 2],
    text: String,
}

/// Writes all drawings; returns `None`, and prints why, if a figure or a file is absent.
pub(super) fn write(figures: &Figures) -> Option<()> {
    for (file, drawing) in said("drawings", all(figures))? {
        let path = root().join(&file);
        if fs::read_to_string(&path).ok().as_ref() != Some(&drawing) {
            files::write(&path, &drawing)?;
        }
    }
    Some(())
}

/// Returns the table of a chart, or what is absent.
pub(super) fn table(name: &str, figures: &Figures) -> Result<String, String> {
    let chart = (CHARTS.iter())
        .find(|chart| chart.file.rsplit('/').next() == Some(name))
        .ok_or_else(|| format!("there is no chart {name}"))?;
    let (series, rows) = chart.rows(figures)?;
    let head: Vec<String> = series.iter().map(|name| format!(" {name} |")).collect();
    let lines: Vec<String> = (rows.iter())
        .map(|(name, dots)| {
            let cell = |dot: &Option<Dot>| {
                dot.as_ref()
                    .map_or_else(String::new, |dot| dot.text.clone())
            };
            let cells: Vec<String> = dots.iter().map(|dot| format!(" {} |", cell(dot))).collect();
            format!("| {name} |{}", cells.concat())
        })
        .collect();
    Ok(format!(
        "\n\n| |{}\n|---|{}\n{}\n\n{}\n",
        head.concat(),
        "---|".repeat(series.len()),
        lines.join("\n"),
        part(figures, chart.part)?.measured(chart.part)
    ))
}

/// Returns the path and the text of each drawing, or what is absent.
fn all(figures: &Figures) -> Result<Vec<(String, String)>, String> {
    let mut files = Vec::new();
    for chart in CHARTS.iter().filter(|chart| chart.file.contains('/')) {
        files.push((format!("{}.svg", chart.file), chart.drawing(figures)?));
    }
    files.push((
        "docs/reference/figures/lengths.svg".to_owned(),
        lengths(figures)?,
    ));
    let text =
        fs::read_to_string(root().join(CURVES)).map_err(|error| format!("{CURVES}: {error}"))?;
    let shown: BTreeMap<String, Shown> =
        serde_json::from_str(&text).map_err(|error| format!("{CURVES}: {error}"))?;
    for (name, shown) in &shown {
        files.push((format!("docs/gallery/{name}.svg"), shown.drawing()));
    }
    Ok(files)
}

impl Chart {
    fn drawing(&self, figures: &Figures) -> Result<String, String> {
        let (series, rows) = self.rows(figures)?;
        let mut drawing = Drawing::default();
        drawing.paragraph("t", 15.5, self.title);
        let dots = Dots {
            quantity: self.quantity,
            is_logarithmic: self.is_logarithmic,
            series,
            rows,
            reference: self.reference,
        };
        dots.draw(&mut drawing);
        drawing.paragraph("f", 11.5, &origin(self.part, part(figures, self.part)?));
        Ok(drawing.finish(self.title))
    }

    /// Returns the names of the series, and the rows.
    fn rows(&self, figures: &Figures) -> Result<(Vec<&'static str>, Vec<Row>), String> {
        let part = part(figures, self.part)?;
        let get = |name: &str| part.figures.iter().find(|figure| figure.name == name);
        let needed =
            |name: &str| get(name).ok_or_else(|| format!("no figure {}/{name}", self.part));
        let mut rows = Vec::new();
        for row in self.rows {
            let (label, key) = named(row);
            let dots = match self.cells {
                Cells::Grid(pattern, series) => {
                    let of = |series: &&'static str| {
                        let name = pattern
                            .replace("{row}", key)
                            .replace("{series}", named(series).1);
                        let end = |word: &str| Some(get(&format!("{name}, {word}"))?.value);
                        get(&name).map(|figure| Dot {
                            interval: end("least").zip(end("most")).map(<[f64; 2]>::from),
                            ..dot(figure)
                        })
                    };
                    series.iter().map(of).collect()
                }
                Cells::Peers(_) => peers(needed(key)?),
                Cells::Intervals => vec![Some(with_interval(needed(key)?, false))],
                Cells::OffPublished => vec![Some(with_interval(needed(key)?, true))],
            };
            // Some figures do not exist in each condition.
            if dots.iter().any(Option::is_some) {
                rows.push((label.to_owned(), dots));
            }
        }
        let series = match self.cells {
            Cells::Grid(_, series) => series.iter().map(|series| named(series).0).collect(),
            Cells::Peers(other) => vec!["sprung", other],
            Cells::Intervals | Cells::OffPublished => vec![""],
        };
        // A series without a dot has no place in the legend.
        let mut used =
            (0..series.len()).filter(|k| rows.iter().any(|(_, dots): &Row| dots[*k].is_some()));
        let count = used.next_back().map_or(0, |last| last + 1);
        for (_, dots) in &mut rows {
            dots.truncate(count);
        }
        Ok((series.into_iter().take(count).collect(), rows))
    }
}

impl Shown {
    fn drawing(&self) -> String {
        let mut drawing = Drawing::default();
        drawing.paragraph("t", 15.5, &self.title);
        let names: Vec<&str> = self.series.iter().map(String::as_str).collect();
        drawing.legend(&names);
        for panel in &self.panels {
            panel.draw(&mut drawing);
        }
        if !self.values.is_empty() {
            let row = |value: &Estimate| {
                let dot = Dot {
                    value: value.value,
                    text: value.text.clone(),
                    interval: Some(value.interval),
                };
                (value.name.clone(), vec![Some(dot)])
            };
            drawing.height += 8.0;
            let dots = Dots {
                quantity: &self.quantity,
                is_logarithmic: false,
                series: vec![""],
                rows: self.values.iter().map(row).collect(),
                reference: None,
            };
            dots.draw(&mut drawing);
        }
        drawing.paragraph("f", 11.5, &self.note);
        drawing.finish(&self.title)
    }
}

/// Draws processor time and memory over the length of the log.
fn lengths(figures: &Figures) -> Result<String, String> {
    let speed = part(figures, "speed")?;
    let curve = |series: usize, memory: &str| -> Result<Curve, String> {
        let mut curve = Curve {
            series,
            style: Style::Marks,
            ..Curve::default()
        };
        for (seconds, name, is_other) in LENGTHS[series].1 {
            let name = format!("{name}{memory}");
            let figure = figures
                .get(&format!("speed/{name}"))
                .ok_or_else(|| format!("no figure speed/{name}"))?;
            let value = if *is_other {
                figure.peer_value
            } else {
                Some(figure.value)
            };
            curve.x.push(*seconds);
            curve.y.push(value);
        }
        Ok(curve)
    };
    let mut drawing = Drawing::default();
    let title = "Time and memory over the length of the log";
    drawing.paragraph("t", 15.5, title);
    let names: Vec<&str> = LENGTHS.iter().map(|(name, _)| *name).collect();
    drawing.legend(&names);
    for (title, below, memory) in [
        ("processor time, s", "", ""),
        ("memory, MiB", "length of the log at 1 kHz, s", ", memory"),
    ] {
        let curves = (0..LENGTHS.len()).map(|series| curve(series, memory));
        let panel = Panel {
            title: title.to_owned(),
            below: below.to_owned(),
            height: 150.0,
            logarithmic: true,
            curves: curves.collect::<Result<_, _>>()?,
        };
        panel.draw(&mut drawing);
    }
    drawing.paragraph(
        "f",
        11.5,
        "The hour of Pinocchio is extrapolated from 15 s.",
    );
    drawing.paragraph("f", 11.5, &origin("speed", speed));
    Ok(drawing.finish(title))
}

fn part<'a>(figures: &'a Figures, name: &str) -> Result<&'a Measured, String> {
    figures
        .0
        .get(name)
        .ok_or_else(|| format!("no figures {name}"))
}

/// Returns how a part was measured.
fn origin(name: &str, part: &Measured) -> String {
    format!("cargo xtask figures {name}, {}, {}", part.date, part.commit)
}

/// Returns the label and the key of `label | key`.
fn named(text: &'static str) -> (&'static str, &'static str) {
    text.split_once(" | ").unwrap_or((text, text))
}

/// Returns a figure as a dot, with the verdict if its text has one.
fn dot(figure: &Figure) -> Dot {
    let verdict = (figure.text.split_once(", *")).and_then(|(_, rest)| rest.split_once("*:"));
    Dot {
        value: figure.value,
        text: verdict.map_or_else(
            || figure.shown(),
            |(verdict, _)| format!("{} {verdict}", figure.shown()),
        ),
        interval: None,
    }
}

/// Returns a figure, and that of the other program, on one scale.
fn peers(figure: &Figure) -> Vec<Option<Dot>> {
    let scale = match figure.unit.as_str() {
        "ms" => 1e-3,
        "µs" => 1e-6,
        _ => 1.0,
    };
    let dot = |value: f64| Dot {
        value: value * scale,
        text: super::file::with_unit(value, &figure.unit),
        interval: None,
    };
    vec![Some(dot(figure.value)), figure.peer_value.map(dot)]
}

/// Returns a figure with its interval, or its distance from the published value in percent.
fn with_interval(figure: &Figure, is_off_published: bool) -> Dot {
    let behind = figure.text.split("standard error ").nth(1);
    let error: Option<f64> = behind.and_then(|rest| rest.split(')').next()?.parse().ok());
    let published = figure.peer_value.filter(|_| is_off_published);
    let place = |value: f64| published.map_or(value, |published| 100.0 * (value / published - 1.0));
    Dot {
        value: place(figure.value),
        text: figure.shown(),
        interval: error
            .map(|error| [-1.0, 1.0].map(|side| place(figure.value + side * WIDE * error))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::FILE;
    use super::*;

    #[test]
    fn drawings_are_those_of_the_figures() {
        let figures: Figures = files::json(&root().join(FILE)).unwrap();
        for (file, drawing) in all(&figures).unwrap() {
            let stored = fs::read_to_string(root().join(&file)).unwrap_or_default();
            assert!(stored == drawing, "{file} is stale: run cargo xtask docs");
            assert!(
                !drawing.contains("NaN") && !drawing.contains("inf"),
                "{file}"
            );
        }
    }
}
