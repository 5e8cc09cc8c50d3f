//! Tables of an `SQLite` database, read row by row.

use std::io::{Error, ErrorKind, Read, Result as IoResult, Seek, SeekFrom};

use crate::log::input::Input;

/// A value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Null,
    Integer(i64),
    Float,
    Text(String),
    Blob(Vec<u8>),
}

impl Value {
    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }
}

/// A row with its number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) id: i64,
    pub(super) values: Vec<Value>,
}

/// A table: where it begins, and names of its columns.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TableInfo {
    pub(super) name: String,
    pub(super) root: u32,
    pub(super) columns: Vec<String>,
}

/// A database.
pub(super) struct Database {
    input: Box<dyn Input>,
    page_size: u64,
    usable: u64,
    pages: u64,
}

/// Pages above one another that are believed.
const MAX_TREE_DEPTH: usize = 32;

fn damaged(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, what)
}

fn number(bytes: &[u8], at: usize, size: usize) -> IoResult<u64> {
    let end = at.checked_add(size);
    let part = end.and_then(|end| bytes.get(at..end));
    let part = part.ok_or_else(|| damaged("a page points beyond itself"))?;
    Ok(part
        .iter()
        .fold(0, |value, byte| value << 8 | u64::from(*byte)))
}

/// Reads a number of variable length; returns where it ends.
fn variable(bytes: &[u8], mut at: usize) -> IoResult<(u64, usize)> {
    let mut value = 0_u64;
    for k in 0..9 {
        let byte = *bytes.get(at).ok_or_else(|| damaged("a row is cut off"))?;
        at += 1;
        if k == 8 {
            return Ok((value << 8 | u64::from(byte), at));
        }
        value = value << 7 | u64::from(byte & 0x7f);
        if byte < 0x80 {
            break;
        }
    }
    Ok((value, at))
}

impl Database {
    pub(super) fn new(mut input: Box<dyn Input>) -> IoResult<Self> {
        let mut head = [0; 100];
        input.read_exact(&mut head)?;
        let page_size = match number(&head, 16, 2)? {
            1 => 65_536,
            size => size,
        };
        if !page_size.is_power_of_two() || page_size < 512 {
            return Err(damaged("its page size is absurd"));
        }
        if head[56..60] != [0, 0, 0, 1] && head[56..60] != [0; 4] {
            return Err(damaged("its text is not UTF-8"));
        }
        let length = input.seek(SeekFrom::End(0))?;
        let whole = number(&head, 28, 4)?;
        if whole > length / page_size {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(Self {
            input,
            page_size,
            usable: page_size - u64::from(head[20]).min(page_size - 480),
            pages: length / page_size,
        })
    }

    fn page(&mut self, number: u32) -> IoResult<Vec<u8>> {
        if number == 0 || u64::from(number) > self.pages {
            return Err(damaged("a page is missing"));
        }
        let start = (u64::from(number) - 1) * self.page_size;
        self.input.seek(SeekFrom::Start(start))?;
        let mut page = vec![0; self.page_size as usize];
        self.input.read_exact(&mut page)?;
        Ok(page)
    }

    /// Lists the tables.
    pub(super) fn tables(&mut self) -> IoResult<Vec<TableInfo>> {
        let mut scan = Scan::new(1);
        let mut all = Vec::new();
        while let Some(row) = scan.next(self)? {
            let [kind, name, _, Value::Integer(root), sql] = &row.values[..] else {
                continue;
            };
            if kind.text() == Some("table")
                && let (Some(name), Some(sql)) = (name.text(), sql.text())
            {
                all.push(TableInfo {
                    name: name.to_owned(),
                    root: u32::try_from(*root).map_err(|_| damaged("a table has no place"))?,
                    columns: columns_of(sql),
                });
            }
        }
        Ok(all)
    }

    /// Reads a row's payload from its leaf and the pages that it spills onto.
    ///
    /// - `length`: of the payload, no more than the file's.
    fn payload(&mut self, page: &[u8], at: usize, length: u64) -> IoResult<Vec<u8>> {
        let most = self.usable - 35;
        let local = if length <= most {
            length
        } else {
            let least = (self.usable - 12) * 32 / 255 - 23;
            let fit = least + (length - least) % (self.usable - 4);
            if fit <= most { fit } else { least }
        };
        let end = at + local as usize;
        let part = page.get(at..end);
        let mut payload = part.ok_or_else(|| damaged("a row is cut off"))?.to_vec();
        if local == length {
            return Ok(payload);
        }
        let mut next = number(page, end, 4)? as u32;
        while (payload.len() as u64) < length {
            let page = self.page(next)?;
            next = number(&page, 0, 4)? as u32;
            let left = (length - payload.len() as u64).min(self.usable - 4) as usize;
            payload.extend_from_slice(&page[4..4 + left]);
        }
        Ok(payload)
    }
}

/// Names of the columns in a statement that creates a table.
fn columns_of(sql: &str) -> Vec<String> {
    let inner = sql.split_once('(').map_or("", |(_, inner)| inner);
    (inner.split(','))
        .filter_map(|part| part.split_whitespace().next())
        .map(|name| name.trim_matches(['"', '`', '[', ']']).to_owned())
        .collect()
}

/// A walk through the rows of a table, in the order of their numbers.
pub(super) struct Scan {
    root: u32,
    // Pages from the root to a leaf: where they begin, and their next cell.
    path: Vec<(Vec<u8>, usize, usize)>,
    started: bool,
    // Pages that were entered, and bytes of rows: no more than there are.
    visited: u64,
    taken: u64,
}

impl Scan {
    pub(super) fn new(root: u32) -> Self {
        Self {
            root,
            path: Vec::new(),
            started: false,
            visited: 0,
            taken: 0,
        }
    }

    fn enter(&mut self, base: &mut Database, number: u32) -> IoResult<()> {
        self.visited += 1;
        if self.path.len() >= MAX_TREE_DEPTH || self.visited > base.pages {
            return Err(damaged("its pages go round in circles"));
        }
        let page = base.page(number)?;
        // The first page begins behind the head of the file.
        let start = if number == 1 { 100 } else { 0 };
        self.path.push((page, start, 0));
        Ok(())
    }

    pub(super) fn next(&mut self, base: &mut Database) -> IoResult<Option<Row>> {
        if !std::mem::replace(&mut self.started, true) {
            self.enter(base, self.root)?;
        }
        while let Some((page, start, cell)) = self.path.last_mut() {
            let (start, k) = (*start, *cell);
            let kind = number(page, start, 1)?;
            let count = number(page, start + 3, 2)? as usize;
            *cell += 1;
            match kind {
                0x05 if k < count => {
                    let at = number(page, start + 12 + 2 * k, 2)? as usize;
                    let child = number(page, at, 4)? as u32;
                    self.enter(base, child)?;
                }
                0x05 if k == count => {
                    let child = number(page, start + 8, 4)? as u32;
                    self.enter(base, child)?;
                }
                0x0d if k < count => {
                    let at = number(page, start + 8 + 2 * k, 2)? as usize;
                    let (length, at) = variable(page, at)?;
                    let (id, at) = variable(page, at)?;
                    self.taken = self.taken.saturating_add(length);
                    if self.taken > base.pages * base.page_size {
                        return Err(damaged("its rows are longer than the file"));
                    }
                    let page = page.clone();
                    let payload = base.payload(&page, at, length)?;
                    return Ok(Some(Row {
                        id: id as i64,
                        values: values(&payload)?,
                    }));
                }
                0x05 | 0x0d => {
                    self.path.pop();
                }
                _ => return Err(damaged("a page is not that of a table")),
            }
        }
        Ok(None)
    }
}

fn values(payload: &[u8]) -> IoResult<Vec<Value>> {
    let (head, mut at) = variable(payload, 0)?;
    let mut body = usize::try_from(head).map_err(|_| damaged("a row is cut off"))?;
    let mut all = Vec::new();
    while (at as u64) < head {
        let (kind, next) = variable(payload, at)?;
        at = next;
        let size = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind,
            5 => 6,
            6 | 7 => 8,
            10 | 11 => return Err(damaged("a value is of unknown type")),
            _ => (kind - 12) / 2,
        };
        let size = usize::try_from(size).map_err(|_| damaged("a row is cut off"))?;
        let end = body.checked_add(size).filter(|end| *end <= payload.len());
        let end = end.ok_or_else(|| damaged("a row is cut off"))?;
        let bytes = &payload[body..end];
        body = end;
        all.push(match kind {
            0 => Value::Null,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            7 => Value::Float,
            1..=6 => {
                let bits = number(bytes, 0, size)?;
                let unused = 64 - 8 * size as u32;
                Value::Integer(((bits << unused) as i64) >> unused)
            }
            _ if kind % 2 == 0 => Value::Blob(bytes.to_vec()),
            _ => Value::Text(String::from_utf8_lossy(bytes).into_owned()),
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_variable_length() {
        assert_eq!(variable(&[0x7f], 0).unwrap(), (127, 1));
        assert_eq!(variable(&[0x81, 0x00], 0).unwrap(), (128, 2));
        assert_eq!(variable(&[0xff; 9], 0).unwrap(), (u64::MAX, 9));
        assert!(variable(&[0x81], 0).is_err());
    }

    #[test]
    fn values_of_a_row() {
        // Types: null, one byte, two bytes, 1, text of 2, blob of 1.
        let payload = [7, 0, 1, 2, 9, 17, 14, 0xff, 0x01, 0x00, b'h', b'i', 0x2a];
        let expected = [
            Value::Null,
            Value::Integer(-1),
            Value::Integer(256),
            Value::Integer(1),
            Value::Text("hi".to_owned()),
            Value::Blob(vec![0x2a]),
        ];
        assert_eq!(values(&payload).unwrap(), expected);
        assert!(values(&payload[..12]).is_err());
    }

    #[test]
    fn rows_that_share_their_bytes_end() {
        let mut file = vec![0; 1024];
        file[16..18].copy_from_slice(&512_u16.to_be_bytes());
        file[31] = 2;
        // A leaf with 180 rows, all of them 30 bytes at 472.
        file[100] = 0x0d;
        file[104] = 180;
        for k in 0..180 {
            file[108 + 2 * k..110 + 2 * k].copy_from_slice(&470_u16.to_be_bytes());
        }
        file[470..473].copy_from_slice(&[30, 1, 1]);
        let mut base = Database::new(Box::new(std::io::Cursor::new(file))).unwrap();
        let error = base.tables().unwrap_err();
        assert_eq!(error.to_string(), "its rows are longer than the file");
    }
}
