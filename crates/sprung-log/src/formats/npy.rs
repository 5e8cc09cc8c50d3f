//! The header of a NumPy array, `.npy`, alone or as a member of `.npz`.
//!
//! The header is a Python literal: a dictionary with the type of an element (`descr`), the order of the
//! sides (`fortran_order`) and their lengths (`shape`).

use std::io::Read;

use super::number::Number;
use crate::input_limits::COLUMNS;

/// A column of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NpyColumn {
    /// The index as Python writes it, `[:,0]`, or the name of a field; empty for a vector.
    pub(super) name: String,
    pub(super) number: Number,
    pub(super) big_endian: bool,
    /// Bytes before its number in a row, or before its first number in the array if `is_contiguous`.
    pub(super) at: u64,
    /// Whether its numbers follow one another, without those of other columns between them.
    pub(super) is_contiguous: bool,
    /// Size of the unit in s, for times.
    pub(super) time_unit: Option<f64>,
}

/// Contents of the header of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Npy {
    /// Bytes of the header; the numbers follow it.
    pub(super) header_bytes: u64,
    pub(super) rows: u64,
    /// Bytes of a row.
    pub(super) row_bytes: u64,
    pub(super) columns: Vec<NpyColumn>,
    /// Whether it is a single number: a setting, not a column.
    pub(super) scalar: bool,
}

impl Npy {
    /// Returns the bytes of header and numbers, if they are not absurdly many.
    pub(super) fn bytes(&self) -> Option<u64> {
        self.rows
            .checked_mul(self.row_bytes)?
            .checked_add(self.header_bytes)
    }
}

/// Longest header that is read; it bounds the memory that a damaged length can request.
const MAX_HEADER_BYTES: u32 = 1 << 22;

const DAMAGED: &str = "has a damaged header; copy or write it again";

/// Reads the header of an array.
///
/// # Errors
///
/// The fault of the array, as the predicate of a sentence whose subject is its name.
pub(super) fn header(read: &mut dyn Read) -> Result<Npy, String> {
    let mut fixed = [0_u8; 8];
    let cut = |_| "ends within its header: it was cut off; copy or write it again".to_owned();
    read.read_exact(&mut fixed).map_err(cut)?;
    if &fixed[..6] != b"\x93NUMPY" {
        return Err("is not a NumPy array".to_owned());
    }
    // Versions 2 and 3 differ in the encoding of the text only.
    let (length, before) = match fixed[6] {
        1 => {
            let mut length = [0_u8; 2];
            read.read_exact(&mut length).map_err(cut)?;
            (u32::from(u16::from_le_bytes(length)), 10)
        }
        2 | 3 => {
            let mut length = [0_u8; 4];
            read.read_exact(&mut length).map_err(cut)?;
            (u32::from_le_bytes(length), 12)
        }
        _ => return Err(DAMAGED.to_owned()),
    };
    if length > MAX_HEADER_BYTES {
        return Err(DAMAGED.to_owned());
    }
    let mut text = vec![0_u8; length as usize];
    read.read_exact(&mut text).map_err(cut)?;
    let text = String::from_utf8_lossy(&text).into_owned();
    let mut parser = Parser { rest: &text };
    let value = parser.value(0).ok_or(DAMAGED)?;
    let Value::Dict(entries) = value else {
        return Err(DAMAGED.to_owned());
    };
    let entry = |key: &str| {
        entries
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value)
    };
    let (Some(descr), Some(Value::Word(fortran)), Some(Value::List(shape))) =
        (entry("descr"), entry("fortran_order"), entry("shape"))
    else {
        return Err(DAMAGED.to_owned());
    };
    let shape: Option<Vec<u64>> = shape.iter().map(Value::number).collect();
    let shape = shape.ok_or(DAMAGED)?;
    sized(&shape)?;
    layout(descr, fortran == "True", &shape, before + u64::from(length))
}

/// Most numbers of an array; products of fewer do not overflow.
const MAX_ARRAY_NUMBERS: u64 = 1 << 48;

/// Longest record of a structured array; one record is held in memory at least.
const MAX_RECORD_BYTES: u64 = 1 << 24;

/// Refuses a shape with more than [`MAX_ARRAY_NUMBERS`] numbers.
///
/// Sides of 0 count as 1, so that the product of any part of the shape does not overflow either.
fn sized(shape: &[u64]) -> Result<(), String> {
    let mut sides = shape.iter().map(|n| *n.max(&1));
    let total = sides.try_fold(1_u64, u64::checked_mul);
    match total {
        Some(total) if total <= MAX_ARRAY_NUMBERS => Ok(()),
        _ => Err("has a damaged header: its shape is absurd; copy or write it again".to_owned()),
    }
}

/// Finds the columns of an array.
///
/// - `descr`: the type of an element, or the fields of a structured array.
/// - `fortran`: whether the first side varies fastest.
/// - `header_bytes`: bytes before the numbers.
fn layout(descr: &Value, fortran: bool, shape: &[u64], header_bytes: u64) -> Result<Npy, String> {
    let scalar = shape.iter().product::<u64>() == 1;
    // Sides of length 1 are dropped. Samples run along the longer side of a matrix.
    let long: Vec<u64> = shape.iter().copied().filter(|n| *n != 1).collect();
    let (rows, width, lying) = match long[..] {
        [] => (1, None, false),
        [rows] => (rows, None, false),
        [width, rows] if rows > width => (rows, Some(width), true),
        [rows, width] => (rows, Some(width), false),
        _ => return Err(too_deep(shape, &long)),
    };
    let inner: Vec<u64> = width.into_iter().collect();
    let mut columns = Vec::new();
    let row_bytes = match descr {
        Value::Text(kind) => {
            let kind = Kind::of(kind)?;
            let size = kind.number.size() as u64;
            let is_contiguous = fortran != lying && width.is_some();
            for (name, place) in places(&inner)? {
                let name = match (name.is_empty(), lying) {
                    (true, _) => name,
                    (_, true) => format!("[{name},:]"),
                    (_, false) => format!("[:,{name}]"),
                };
                let at = if is_contiguous { place * rows } else { place } * size;
                columns.push(kind.column(name, at, is_contiguous));
            }
            size * width.unwrap_or(1)
        }
        Value::List(fields) if inner.is_empty() => fields_of(fields, &mut columns)?,
        _ => return Err("is an array of records with more than one dimension".to_owned()),
    };
    Ok(Npy {
        header_bytes,
        rows,
        row_bytes,
        columns,
        scalar,
    })
}

/// Returns the message for an array of more than two dimensions.
///
/// - `long`: its sides that are longer than one.
fn too_deep(shape: &[u64], long: &[u64]) -> String {
    let sides: Vec<String> = shape.iter().map(u64::to_string).collect();
    // The header does not contain the time axis; usually it is the first.
    let rows = long.first().copied().unwrap_or(0);
    format!(
        "has the shape ({}), and a log has two dimensions; reshape it to samples × columns, as \
         a.reshape({rows}, -1) does where the first side is time",
        sides.join(", ")
    )
}

/// Appends the columns of a structured array, and returns the bytes of a record.
///
/// Fields without numbers (text, padding) take space and give no column.
fn fields_of(fields: &[Value], columns: &mut Vec<NpyColumn>) -> Result<u64, String> {
    let mut at = 0;
    for field in fields {
        let Value::List(parts) = field else {
            return Err(DAMAGED.to_owned());
        };
        let (name, kind, shape) = match &parts[..] {
            [Value::Text(name), Value::Text(kind)] => (name, kind, Vec::new()),
            [Value::Text(name), Value::Text(kind), Value::List(shape)] => {
                let shape: Option<Vec<u64>> = shape.iter().map(Value::number).collect();
                let shape = shape.ok_or(DAMAGED)?;
                sized(&shape)?;
                (name, kind, shape)
            }
            _ => return Err("has records within records; make them flat".to_owned()),
        };
        let count: u64 = shape.iter().product();
        let number = Kind::of(kind);
        let size = match &number {
            Ok(kind) => kind.number.size() as u64,
            Err(_) => size_of(kind).ok_or_else(|| format!("has a field of type \"{kind}\""))?,
        };
        let end = (size.checked_mul(count)).map(|size| at + size);
        let end = end.filter(|end| *end <= MAX_RECORD_BYTES);
        let end = end
            .ok_or("has a damaged header: its records are absurdly long; copy or write it again")?;
        let Ok(kind) = number else {
            at = end;
            continue;
        };
        for (inner, place) in places(&shape)? {
            let name = if inner.is_empty() {
                name.clone()
            } else {
                format!("{name}[:,{inner}]")
            };
            columns.push(kind.column(name, at + place * size, false));
        }
        at = end;
    }
    Ok(at)
}

/// Returns the indices of an array as Python writes them, with their places in C order.
///
/// The index of an array without sides is empty.
fn places(shape: &[u64]) -> Result<Vec<(String, u64)>, String> {
    let count: u64 = shape.iter().product();
    if count > COLUMNS as u64 {
        return Err(format!(
            "has {count} columns, and a log has at most {COLUMNS}; is it transposed?"
        ));
    }
    if shape.is_empty() {
        return Ok(vec![(String::new(), 0)]);
    }
    let name = |place: u64| {
        let mut left = place;
        let mut indices: Vec<String> = (shape.iter().rev())
            .map(|n| {
                let index = left % n;
                left /= n;
                index.to_string()
            })
            .collect();
        indices.reverse();
        indices.join(",")
    };
    Ok((0..count).map(|place| (name(place), place)).collect())
}

/// A type of NumPy whose elements are numbers.
struct Kind {
    number: Number,
    big_endian: bool,
    time_unit: Option<f64>,
}

impl Kind {
    /// Reads a type as NumPy writes it: byte order, letter, bytes, and the unit of a time, `<M8[ns]`.
    fn of(text: &str) -> Result<Self, String> {
        let refused = || {
            Err(format!(
                "is of type \"{text}\", which is no column of numbers; write it as float64"
            ))
        };
        let (order, rest) = match text.chars().next() {
            Some(order @ ('<' | '>' | '|' | '=')) => (order, &text[1..]),
            _ => ('|', text),
        };
        let (kind, unit) = match rest.split_once('[') {
            Some((kind, unit)) => (kind, unit.trim_end_matches(']')),
            None => (rest, ""),
        };
        let number = match kind {
            "f8" => Number::F64,
            "f4" => Number::F32,
            "i1" => Number::I8,
            "i2" => Number::I16,
            "i4" => Number::I32,
            "i8" | "M8" | "m8" => Number::I64,
            "u1" | "b1" => Number::U8,
            "u2" => Number::U16,
            "u4" => Number::U32,
            "u8" => Number::U64,
            _ => return refused(),
        };
        let time_unit = match (kind, unit) {
            ("M8" | "m8", "s") => Some(1.0),
            ("M8" | "m8", "ms") => Some(1e-3),
            ("M8" | "m8", "us") => Some(1e-6),
            ("M8" | "m8", "ns") => Some(1e-9),
            ("M8" | "m8", _) => return refused(),
            _ => None,
        };
        Ok(Self {
            number,
            big_endian: order == '>',
            time_unit,
        })
    }

    fn column(&self, name: String, at: u64, is_contiguous: bool) -> NpyColumn {
        NpyColumn {
            name,
            number: self.number,
            big_endian: self.big_endian,
            at,
            is_contiguous,
            time_unit: self.time_unit,
        }
    }
}

/// Returns the size in bytes of a type that is no column of numbers, such as text or padding.
fn size_of(text: &str) -> Option<u64> {
    let rest = text.trim_start_matches(['<', '>', '|', '=']);
    let (kind, digits) = rest.split_at_checked(1)?;
    let count: u64 = digits.parse().ok()?;
    match kind {
        "U" => count.checked_mul(4),
        "S" | "V" | "f" | "c" | "i" | "u" => Some(count),
        _ => None,
    }
}

/// A Python literal; a word is a number, `True` or `False`, and a tuple is a list.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Text(String),
    Word(String),
    List(Vec<Value>),
    Dict(Vec<(String, Value)>),
}

impl Value {
    fn number(&self) -> Option<u64> {
        match self {
            Self::Word(word) => word.trim_end_matches('L').parse().ok(),
            _ => None,
        }
    }
}

/// A parser of the Python literals that NumPy writes.
struct Parser<'a> {
    rest: &'a str,
}

/// Deepest literal within literals; it bounds the recursion.
const MAX_NESTING: usize = 8;

impl Parser<'_> {
    /// Skips white space, and `c` if it follows; returns whether it did.
    fn eat(&mut self, c: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(c) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    /// Reads a literal; returns `None` if the text is no literal.
    ///
    /// - `depth`: literals around it.
    fn value(&mut self, depth: usize) -> Option<Value> {
        if depth > MAX_NESTING {
            return None;
        }
        self.rest = self.rest.trim_start();
        if self.eat('{') {
            let mut entries = Vec::new();
            while !self.eat('}') {
                let Value::Text(key) = self.value(depth + 1)? else {
                    return None;
                };
                if !self.eat(':') {
                    return None;
                }
                entries.push((key, self.value(depth + 1)?));
                self.eat(',');
            }
            return Some(Value::Dict(entries));
        }
        for (open, close) in [('(', ')'), ('[', ']')] {
            if self.eat(open) {
                let mut all = Vec::new();
                while !self.eat(close) {
                    all.push(self.value(depth + 1)?);
                    self.eat(',');
                }
                return Some(Value::List(all));
            }
        }
        for quote in ['\'', '"'] {
            if self.eat(quote) {
                let (text, rest) = self.rest.split_once(quote)?;
                self.rest = rest;
                return Some(Value::Text(text.to_owned()));
            }
        }
        let end = self.rest.find(|c: char| !c.is_alphanumeric())?;
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        (!word.is_empty()).then(|| Value::Word(word.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Npy, String> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        header(&mut &bytes[..])
    }

    /// A column as the header describes it.
    #[derive(Debug, PartialEq)]
    struct Named<'n> {
        name: &'n str,
        at: u64,
        is_contiguous: bool,
    }

    fn named(name: &str, at: u64, is_contiguous: bool) -> Named<'_> {
        Named {
            name,
            at,
            is_contiguous,
        }
    }

    fn names(npy: &Npy) -> Vec<Named<'_>> {
        (npy.columns.iter())
            .map(|column| named(&column.name, column.at, column.is_contiguous))
            .collect()
    }

    #[test]
    fn matrices_have_columns_along_their_longer_side() {
        let tall = of("{'descr': '<f8', 'fortran_order': False, 'shape': (100, 2), }\n").unwrap();
        assert_eq!((tall.rows, tall.row_bytes), (100, 16));
        assert_eq!(
            names(&tall),
            [named("[:,0]", 0, false), named("[:,1]", 8, false)]
        );
        let fortran = of("{'descr': '<f4', 'fortran_order': True, 'shape': (100, 2)}\n").unwrap();
        assert_eq!(
            names(&fortran),
            [named("[:,0]", 0, true), named("[:,1]", 400, true)]
        );
        let lying = of("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 100)}\n").unwrap();
        assert_eq!(lying.rows, 100);
        assert_eq!(
            names(&lying),
            [named("[0,:]", 0, true), named("[1,:]", 800, true)]
        );
        let column = of("{'descr': '>i4', 'fortran_order': False, 'shape': (100, 1)}\n").unwrap();
        assert_eq!(names(&column), [named("", 0, false)]);
        assert!(column.columns[0].big_endian);
    }

    #[test]
    fn arrays_with_three_sides_are_refused() {
        for (order, shape) in [
            ("False", "(100, 7, 2)"),
            ("True", "(100, 7, 2)"),
            ("False", "(2, 3, 4, 5)"),
        ] {
            let told = of(&format!(
                "{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}}}\n"
            ));
            let told = told.unwrap_err();
            assert!(told.contains(&format!("has the shape {shape}")), "{told}");
            assert!(told.contains("reshape it to samples × columns"), "{told}");
        }
        // Sides of length 1 do not count.
        let flat = of("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 100, 2)}\n").unwrap();
        assert_eq!((flat.rows, flat.row_bytes), (100, 16));
        assert_eq!(
            names(&flat),
            [named("[:,0]", 0, false), named("[:,1]", 8, false)]
        );
    }

    #[test]
    fn records_have_fields_and_padding() {
        let text = "{'descr': [('t', '<f8'), ('name', '<U4'), ('q', '<f4', (2,)), ('', '|V4')], \
                    'fortran_order': False, 'shape': (10,)}\n";
        let npy = of(text).unwrap();
        assert_eq!(npy.row_bytes, 8 + 16 + 8 + 4);
        assert_eq!(
            names(&npy),
            [
                named("t", 0, false),
                named("q[:,0]", 24, false),
                named("q[:,1]", 28, false)
            ]
        );
    }

    #[test]
    fn damaged_headers_are_refused() {
        for text in [
            "",
            "{'descr': '<f8'",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 99999999999)}\n",
            "{'descr': '|O', 'fortran_order': False, 'shape': (10,)}\n",
            "((((((((((((((((((((",
            // Products of parts that overflow, and records larger than memory.
            "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 4294967296, 4294967296)}\n",
            "{'descr': [('a', '<f8', (4294967296, 4294967296))], 'fortran_order': False, 'shape': (2,)}\n",
            "{'descr': [('a', '<f8'), ('', '|V9999999999')], 'fortran_order': False, 'shape': (2,)}\n",
            "{'descr': [('a', '<U9223372036854775807')], 'fortran_order': False, 'shape': (2,)}\n",
        ] {
            assert!(of(text).is_err(), "{text}");
        }
    }
}
