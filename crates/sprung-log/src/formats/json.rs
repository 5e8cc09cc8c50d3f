//! JSON: a list of samples, lists of columns, or one sample a line.

use std::collections::HashMap;
use std::fmt;
use std::io::Read;

use serde::de::{DeserializeSeed, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::array_shape::{no_topics, same_rows};
use super::memory::MemoryTable;
use super::table::{Opened, Request};
use crate::arrays::Array;
use crate::columns::names::Names;
use crate::error::LogError;
use crate::input_limits::{COLUMNS, JSON_CELLS, TEXT_BYTES, size};

/// Opens a text in JSON.
///
/// Each list outside of other lists has rows. A number in a row belongs to the column of its path, such as `q[0]` or
/// `joint.position`.
pub(super) fn open(request: &Request<'_>, read: impl Read) -> Result<Opened, LogError> {
    let file = request.file;
    no_topics(request)?;
    let mut text = Vec::new();
    (read.take(TEXT_BYTES as u64 + 1).read_to_end(&mut text))
        .map_err(|error| LogError::read(file, "its text", error))?;
    if text.len() > TEXT_BYTES {
        let why = format!(
            " is JSON of more than {}; write it as CSV or Parquet: pandas.read_json(…).to_csv(…)",
            size(TEXT_BYTES)
        );
        return Err(LogError::format(file, why));
    }
    let found =
        columns(&text).map_err(|error| LogError::format(file, format!(" is JSON: {error}")))?;
    let all: Vec<String> = found.iter().map(|column| column.name.clone()).collect();
    if all.is_empty() {
        let why = " is JSON without lists of numbers or of samples; give a log";
        return Err(LogError::format(file, why));
    }
    let names = Names {
        file,
        all: &all,
        given: true,
    };
    let places = (request.picks.iter())
        .map(|pick| names.find(pick))
        .collect::<Result<Vec<usize>, LogError>>()?;
    let rows = same_rows(file, &places, |place| {
        (&all[place], found[place].values.len() as u64)
    })?;
    let columns = places
        .iter()
        .map(|&place| Array::float(found[place].values.clone()));
    Ok(Opened {
        table: Box::new(MemoryTable::new(columns.collect(), rows as usize)),
        names: places.iter().map(|&place| all[place].clone()).collect(),
        time_unit: None,
        all,
        has_names: true,
        units: Vec::new(),
    })
}

/// A column of a list.
struct Column {
    name: String,
    values: Vec<f64>,
    list: usize,
}

/// Columns of all lists.
#[derive(Default)]
struct Columns {
    all: Vec<Column>,
    places: HashMap<String, usize>,
    /// Number of rows of each list.
    rows: Vec<usize>,
}

impl Columns {
    /// Adds a number to the last row of the last list.
    fn push(&mut self, name: &str, value: f64) -> Result<(), String> {
        let (Some(list), Some(&row)) = (self.rows.len().checked_sub(1), self.rows.last()) else {
            return Ok(());
        };
        let place = *self.places.entry(name.to_owned()).or_insert(self.all.len());
        if place == self.all.len() {
            self.all.push(Column {
                name: name.to_owned(),
                values: Vec::new(),
                list,
            });
        }
        if self.all.len() > COLUMNS || self.all.len() * row > JSON_CELLS {
            return Err(format!(
                "more than {COLUMNS} columns or {JSON_CELLS} numbers; write it as CSV or Parquet"
            ));
        }
        let values = &mut self.all[place].values;
        values.resize(row - 1, f64::NAN);
        values.push(value);
        Ok(())
    }
}

fn columns(text: &[u8]) -> Result<Vec<Column>, serde_json::Error> {
    let mut first = serde_json::Deserializer::from_slice(text);
    IgnoredAny::deserialize(&mut first)?;
    let is_lines = first.end().is_err();
    let mut columns = Columns::default();
    let mut values = serde_json::Deserializer::from_slice(text);
    if is_lines {
        columns.rows.push(0);
    }
    while values.end().is_err() {
        if is_lines {
            columns.rows[0] += 1;
        }
        let part = Part {
            columns: &mut columns,
            path: "",
            in_row: is_lines,
        };
        part.deserialize(&mut values)?;
    }
    let Columns { mut all, rows, .. } = columns;
    for column in &mut all {
        column.values.resize(rows[column.list], f64::NAN);
    }
    Ok(all)
}

/// A value at a path.
struct Part<'a> {
    columns: &'a mut Columns,
    path: &'a str,
    in_row: bool,
}

impl Part<'_> {
    fn number<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        if self.in_row {
            self.columns.push(self.path, value).map_err(E::custom)?;
        }
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of samples or of columns")
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<(), E> {
        self.number(f64::from(u8::from(value)))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.number(value as f64)
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.number(value as f64)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        self.number(value)
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            let path = match self.path {
                "" => key,
                path => format!("{path}.{key}"),
            };
            map.next_value_seed(Part {
                columns: self.columns,
                path: &path,
                in_row: self.in_row,
            })?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        if !self.in_row {
            self.columns.rows.push(0);
        }
        for index in 0.. {
            let path = if self.in_row {
                format!("{}[{index}]", self.path)
            } else {
                self.path.to_owned()
            };
            if !self.in_row
                && let Some(rows) = self.columns.rows.last_mut()
            {
                *rows += 1;
            }
            let part = Part {
                columns: self.columns,
                path: &path,
                in_row: true,
            };
            if list.next_element_seed(part)?.is_none() {
                break;
            }
            if index > COLUMNS && self.in_row {
                return Err(A::Error::custom(format!(
                    "a list of more than {COLUMNS} numbers in a sample"
                )));
            }
        }
        if !self.in_row
            && let Some(rows) = self.columns.rows.last_mut()
        {
            *rows -= 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_columns_and_lines_are_tables() {
        for (text, expected) in [
            (
                "[{\"t\": 0, \"q\": [1, 2]}, {\"t\": 1, \"q\": [3, null], \"on\": true}]",
                "t: 0 1; q[0]: 1 3; q[1]: 2 NaN; on: NaN 1",
            ),
            (
                "{\"t\": [0, 1], \"j\": {\"q\": [2, 3]}}",
                "t: 0 1; j.q: 2 3",
            ),
            (
                "{\"t\": [0, 1], \"q\": [[2, 3], [4, 5]]}",
                "t: 0 1; q[0]: 2 4; q[1]: 3 5",
            ),
            (
                "{\"t\": 0, \"q\": 1}\n{\"t\": 1, \"q\": 2}\n",
                "t: 0 1; q: 1 2",
            ),
            (
                "{\"mass\": 1, \"entries\": [{\"t\": 0, \"name\": \"a\", \"p\": {\"x\": 2}}]}",
                "entries.t: 0; entries.p.x: 2",
            ),
        ] {
            let found: Vec<String> = (columns(text.as_bytes()).unwrap().into_iter())
                .map(|column| {
                    let values: Vec<String> = column.values.iter().map(f64::to_string).collect();
                    format!("{}: {}", column.name, values.join(" "))
                })
                .collect();
            assert_eq!(found.join("; "), expected);
        }
        assert!(columns(b"[{\"t\": 0}, {\"t\":").is_err());
    }
}
