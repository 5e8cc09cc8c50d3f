//! Fits tables and sentences to the width of the terminal.

use comfy_table::{CellAlignment, Table, presets};
use terminal_size::{Width, terminal_size_of};

/// Narrowest terminal, in characters, for which output is arranged.
const MIN_WIDTH: usize = 20;

/// Stream to which text goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    Stdout,
    Stderr,
}

impl Stream {
    /// Returns the number of characters in a line: `COLUMNS`, or the width of the terminal. A file or a pipe has none.
    pub(super) fn width(self) -> Option<usize> {
        let given = std::env::var("COLUMNS").ok();
        let given = given.and_then(|columns| columns.parse::<usize>().ok());
        let width = given.or_else(|| {
            let size = match self {
                Self::Stdout => terminal_size_of(std::io::stdout()),
                Self::Stderr => terminal_size_of(std::io::stderr()),
            };
            size.map(|(Width(width), _)| usize::from(width))
        });
        width
            .filter(|width| *width > 0)
            .map(|width| width.max(MIN_WIDTH))
    }
}

/// Widths of the first column, in characters, that are tried if a table does not fit.
const FOLDED: [usize; 3] = [32, 24, 18];

/// A table of text.
///
/// If it is wider than the terminal, it becomes several tables, each with the first columns and some groups of the
/// others. If a group does not fit either, optional columns are left out. If that does not help, the first column is folded, and at last each row becomes a
/// list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
    // Number of columns with text, which are aligned to the left.
    left: usize,
    // Number of first columns that all parts repeat.
    keys: usize,
    // Number of columns in a group; the columns after the keys form groups of this size.
    group: usize,
    // Columns that may be left out, the first of them first.
    optional: Vec<usize>,
}

impl Grid {
    /// - `left`: number of columns with text.
    pub(crate) fn new(header: impl IntoIterator<Item = impl Into<String>>, left: usize) -> Self {
        Self {
            header: header.into_iter().map(Into::into).collect(),
            left,
            keys: 1,
            group: 1,
            ..Self::default()
        }
    }

    /// Sets the division of the table: the first `keys` columns are in all parts, the others stay together in groups.
    pub(crate) fn divided(self, keys: usize, group: usize) -> Self {
        Self {
            keys,
            group,
            ..self
        }
    }

    /// Sets the columns that may be left out, the least important first.
    pub(crate) fn without(self, optional: &[usize]) -> Self {
        Self {
            optional: optional.to_vec(),
            ..self
        }
    }

    pub(crate) fn add_row(&mut self, row: impl IntoIterator<Item = String>) {
        self.rows.push(row.into_iter().collect());
    }

    /// Returns the text of the table for lines of at most `width` characters.
    pub(super) fn text(&self, width: Option<usize>) -> String {
        let all: Vec<usize> = (0..self.header.len()).collect();
        let Some(width) = width.filter(|width| self.width_of(&all) > *width) else {
            return self.part(&all);
        };
        let folded = FOLDED.map(|limit| self.folded(limit));
        (std::iter::once(self).chain(&folded))
            .find_map(|grid| grid.tables(&all, width))
            .unwrap_or_else(|| self.list(width))
    }

    /// Returns tables of all groups that fit, without optional columns if they do not fit with them.
    fn tables(&self, all: &[usize], width: usize) -> Option<String> {
        for left_out in 0..=self.optional.len() {
            let columns: Vec<usize> = (all.iter().copied())
                .filter(|column| !self.optional[..left_out].contains(column))
                .collect();
            if let Some(parts) = self.parts(&columns, width) {
                let tables: Vec<String> = parts.iter().map(|part| self.part(part)).collect();
                return Some(tables.join("\n\n"));
            }
        }
        None
    }

    /// Returns the table with the texts of the first column on several lines of at most `limit` characters.
    fn folded(&self, limit: usize) -> Self {
        let rows = self.rows.iter().flat_map(|row| {
            let first = wrapped(row.first().map_or("", String::as_str), Some(limit));
            let lines: Vec<String> = first.lines().map(str::to_owned).collect();
            let row = move |(k, line): (usize, String)| {
                let rest = row.iter().skip(1);
                let rest = rest.map(|cell| if k == 0 { cell.clone() } else { String::new() });
                std::iter::once(line).chain(rest).collect()
            };
            lines
                .into_iter()
                .enumerate()
                .map(row)
                .collect::<Vec<Vec<String>>>()
        });
        Self {
            rows: rows.collect(),
            ..self.clone()
        }
    }

    /// Divides columns into parts that fit; returns `None` if a group does not fit.
    fn parts(&self, columns: &[usize], width: usize) -> Option<Vec<Vec<usize>>> {
        let group_of = |column: usize| (column - self.keys) / self.group;
        let (keys, others): (Vec<usize>, Vec<usize>) =
            columns.iter().partition(|column| **column < self.keys);
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for group in others.chunk_by(|a, b| group_of(*a) == group_of(*b)) {
            let longer = parts.last().map(|part| [part, group].concat());
            match longer.filter(|part| self.width_of(part) <= width) {
                Some(part) => *parts.last_mut()? = part,
                None => parts.push([&keys, group].concat()),
            }
        }
        if others.is_empty() {
            parts.push(keys);
        }
        let fit = parts.iter().all(|part| self.width_of(part) <= width);
        (fit && !parts.is_empty()).then_some(parts)
    }

    /// Returns the width of a table with some of the columns.
    fn width_of(&self, columns: &[usize]) -> usize {
        let width = |column: &usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(*column));
            let longest = cells
                .chain(self.header.get(*column))
                .map(|cell| length(cell))
                .max();
            // A blank is on each side of a cell.
            2 + longest.unwrap_or(0)
        };
        columns.iter().map(width).sum()
    }

    fn part(&self, columns: &[usize]) -> String {
        let pick = |row: &Vec<String>| -> Vec<String> {
            (columns.iter())
                .map(|column| row.get(*column).cloned().unwrap_or_default())
                .collect()
        };
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        table.set_header(pick(&self.header));
        for (place, column) in columns.iter().enumerate() {
            if *column >= self.left
                && let Some(column) = table.column_mut(place)
            {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        for row in &self.rows {
            table.add_row(pick(row));
        }
        table.to_string()
    }

    /// Returns one list of names and values per row.
    fn list(&self, width: usize) -> String {
        let lists = self.rows.iter().map(|row| {
            let lines = (self.header.iter().zip(row))
                .enumerate()
                .filter(|(_, (_, cell))| !cell.is_empty())
                .map(|(i, (name, cell))| {
                    let line = if i == 0 {
                        cell.clone()
                    } else {
                        format!("  {name}: {cell}")
                    };
                    wrapped(&line, Some(width))
                });
            lines.collect::<Vec<_>>().join("\n")
        });
        lists.collect::<Vec<_>>().join("\n")
    }
}

/// Returns the number of characters, each of which takes one place.
fn length(text: &str) -> usize {
    text.chars().count()
}

/// Breaks lines between words; continued lines are indented by two more blanks than their first line.
pub(super) fn wrapped(text: &str, width: Option<usize>) -> String {
    let Some(width) = width else {
        return text.to_owned();
    };
    let lines = text.split('\n').map(|line| wrapped_line(line, width));
    lines.collect::<Vec<_>>().join("\n")
}

fn wrapped_line(line: &str, width: usize) -> String {
    if length(line) <= width {
        return line.to_owned();
    }
    let indent = line.len() - line.trim_start_matches(' ').len();
    let mut out = " ".repeat(indent);
    let (mut used, mut begun) = (indent, false);
    for word in line.split_whitespace() {
        let long = length(word);
        if begun && used + 1 + long > width {
            out.push('\n');
            out.push_str(&" ".repeat(indent + 2));
            used = indent + 2;
        } else if begun {
            out.push(' ');
            used += 1;
        }
        out.push_str(word);
        used += long;
        begun = true;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let header = ["parameter", "unit", "one", "± s.e.", "two", "± s.e."];
        let mut grid = Grid::new(header, 2).divided(2, 2).without(&[1]);
        grid.add_row(
            ["joint1.stiffness", "N·m/rad", "9.35", "0.01", "9.41", "0.3"].map(str::to_owned),
        );
        grid
    }

    fn widest(text: &str) -> usize {
        text.lines()
            .map(|line| length(line.trim_end()))
            .max()
            .unwrap()
    }

    #[test]
    fn tables_fit() {
        let whole = grid().text(None);
        assert_eq!(whole.lines().count(), 2);
        assert_eq!(grid().text(Some(200)), whole);
        // Two tables, one per estimator.
        let halves = grid().text(Some(50));
        assert!(widest(&halves) <= 50, "{halves}");
        assert_eq!(halves.matches("joint1.stiffness").count(), 2, "{halves}");
        assert!(
            halves.contains("N·m/rad") && halves.contains("\n\n"),
            "{halves}"
        );
        // The unit is left out.
        let narrow = grid().text(Some(36));
        assert!(
            widest(&narrow) <= 36 && !narrow.contains("N·m/rad"),
            "{narrow}"
        );
        // Long names are folded, and their values stay beside their first lines.
        let mut long = grid();
        long.rows[0][0] = "link1.mass + link2.mass + link3.mass".to_owned();
        let folded = long.text(Some(60));
        assert!(
            widest(&folded) <= 60 && folded.contains("link2.mass +"),
            "{folded}"
        );
        assert!(!folded.contains("unit:"), "{folded}");
        // A list has everything.
        let list = grid().text(Some(22));
        assert!(widest(&list) <= 22, "{list}");
        assert!(
            list.contains("joint1.stiffness\n  unit: N·m/rad\n  one: 9.35"),
            "{list}"
        );
    }

    #[test]
    fn words_stay_whole() {
        let text = "warning: a sentence of several words\n  remedy: another one, with a word";
        assert_eq!(wrapped(text, None), text);
        assert_eq!(wrapped(text, Some(100)), text);
        let narrow = wrapped(text, Some(20));
        assert!(widest(&narrow) <= 20, "{narrow}");
        let words = |text: &str| {
            text.split_whitespace()
                .map(str::to_owned)
                .collect::<Vec<_>>()
        };
        assert_eq!(words(&narrow), words(text));
        assert!(narrow.contains("\n  remedy: another\n    one,"), "{narrow}");
        // A long word is not broken.
        assert_eq!(
            wrapped("see /a/very/long/path/to/a/file", Some(20))
                .lines()
                .count(),
            2
        );
    }
}
