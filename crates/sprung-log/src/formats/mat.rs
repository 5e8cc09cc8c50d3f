//! MATLAB files of versions 5 to 7: where their arrays are, also those within structures.
//!
//! A file is a list of variables, each an element with a tag (type, length) and possibly compressed. A
//! variable is an array whose parts are elements again: flags, dimensions, name, and numbers or fields.

use std::io::{Error, ErrorKind, Read, Result as IoResult, Seek, SeekFrom};

use super::array_shape::Sides;
use super::number::Number;
use super::strips::skip;
use crate::columns::names::Refused;

/// An array of numbers in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MatArray {
    /// The name as MATLAB writes it: `t`, `data.q`, `s(2).values`.
    pub(super) name: String,
    pub(super) sides: Sides,
    pub(super) number: Number,
    /// Bytes before the variable's contents in the file.
    pub(super) variable: u64,
    pub(super) compressed: bool,
    /// Bytes before the numbers in the variable's contents, after decompression.
    pub(super) at: u64,
}

/// What a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Contents {
    pub(super) arrays: Vec<MatArray>,
    /// Variables and fields that are not read, with the reason.
    pub(super) refused: Vec<Refused>,
    pub(super) big_endian: bool,
}

const HEADER_BYTES: u64 = 128;

/// Types of elements: an array, and a compressed one.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Deepest structure within structures; it bounds the recursion.
const MAX_NESTING: usize = 16;

/// Longest name of a field; MATLAB's have at most 63 bytes.
const MAX_NAME_BYTES: usize = 256;

/// Most elements of a structure array times its fields; it bounds the time and the memory of a scan.
const MAX_STRUCTURE_ELEMENTS: u64 = 1 << 20;

/// Finds the arrays of a file.
///
/// # Errors
///
/// `InvalidData` if the file contradicts itself, `UnexpectedEof` if it was cut off.
pub(super) fn contents(read: &mut (impl Read + Seek + ?Sized)) -> IoResult<Contents> {
    let mut header = [0; HEADER_BYTES as usize];
    read.read_exact(&mut header)?;
    let mut contents = Contents {
        big_endian: &header[126..128] == b"MI",
        ..Contents::default()
    };
    let mut at = HEADER_BYTES;
    loop {
        read.seek(SeekFrom::Start(at))?;
        let mut tag = [0; 8];
        if !begins(read, &mut tag)? {
            return Ok(contents);
        }
        let kind = word(&tag[..4], contents.big_endian);
        let length = u64::from(word(&tag[4..], contents.big_endian));
        let mut scan = Scan {
            contents: &mut contents,
            variable: at + 8,
            compressed: kind == COMPRESSED,
        };
        match kind {
            COMPRESSED => {
                let packed = (&mut *read).take(length);
                let mut inner = Counted::new(flate2::read::ZlibDecoder::new(packed));
                scan.compressed_variable(&mut inner)?;
            }
            MATRIX => {
                let mut inner = Counted::new((&mut *read).take(length));
                scan.matrix(&mut inner, "", length, 0)?;
            }
            _ => return Err(damaged("an element of unknown type")),
        }
        at = at
            .checked_add(8 + length)
            .ok_or_else(|| damaged("an absurd length"))?;
    }
}

/// Fills `bytes`; returns false if the file ends before the first of them.
fn begins(read: &mut (impl Read + ?Sized), bytes: &mut [u8]) -> IoResult<bool> {
    let mut filled = 0;
    while filled < bytes.len() {
        match read.read(&mut bytes[filled..])? {
            0 if filled == 0 => return Ok(false),
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            count => filled += count,
        }
    }
    Ok(true)
}

fn damaged(what: &str) -> Error {
    Error::new(ErrorKind::InvalidData, what)
}

fn word(bytes: &[u8], big_endian: bool) -> u32 {
    let four = [bytes[0], bytes[1], bytes[2], bytes[3]];
    if big_endian {
        u32::from_be_bytes(four)
    } else {
        u32::from_le_bytes(four)
    }
}

/// A reader that counts the bytes that were read.
struct Counted<R> {
    inner: R,
    at: u64,
}

impl<R: Read> Counted<R> {
    fn new(inner: R) -> Self {
        Self { inner, at: 0 }
    }

    fn skip(&mut self, bytes: u64) -> IoResult<()> {
        skip(&mut self.inner, bytes)?;
        self.at += bytes;
        Ok(())
    }

    fn take_bytes(&mut self, count: u64) -> IoResult<Vec<u8>> {
        let mut bytes = Vec::new();
        (&mut self.inner).take(count).read_to_end(&mut bytes)?;
        if bytes.len() as u64 != count {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        self.at += count;
        Ok(bytes)
    }
}

/// A scan through the parts of one variable.
struct Scan<'a> {
    contents: &'a mut Contents,
    variable: u64,
    compressed: bool,
}

/// The tag of an element: type and length in bytes. The tag itself contains up to 4 bytes of data.
struct Element {
    kind: u32,
    length: u64,
    short: Option<[u8; 4]>,
}

impl Element {
    /// Returns the bytes between the data and the next element, which begins at a multiple of 8 bytes.
    fn padding(&self) -> u64 {
        match self.short {
            Some(_) => 0,
            None => (8 - self.length % 8) % 8,
        }
    }
}

impl Scan<'_> {
    /// Reads a tag.
    fn element<R: Read>(&self, read: &mut Counted<R>) -> IoResult<Element> {
        let tag = read.take_bytes(8)?;
        let first = word(&tag[..4], self.contents.big_endian);
        let small = first >> 16;
        if small == 0 {
            return Ok(Element {
                kind: first,
                length: u64::from(word(&tag[4..], self.contents.big_endian)),
                short: None,
            });
        }
        if small > 4 {
            return Err(damaged("a short element that is too long"));
        }
        Ok(Element {
            kind: first & 0xffff,
            length: u64::from(small),
            short: Some([tag[4], tag[5], tag[6], tag[7]]),
        })
    }

    /// Reads an element with its data: flags, names, dimensions.
    fn bytes<R: Read>(&self, read: &mut Counted<R>) -> IoResult<Vec<u8>> {
        let element = self.element(read)?;
        if let Some(short) = element.short {
            return Ok(short[..element.length as usize].to_vec());
        }
        if element.length > 1 << 24 {
            return Err(damaged("an absurd length"));
        }
        let bytes = read.take_bytes(element.length)?;
        read.skip(element.padding())?;
        Ok(bytes)
    }

    fn compressed_variable<R: Read>(&mut self, read: &mut Counted<R>) -> IoResult<()> {
        let element = self.element(read)?;
        if element.kind != MATRIX {
            return Err(damaged("a variable of unknown type"));
        }
        self.matrix(read, "", element.length, 0)
    }

    /// Scans an array whose tag was read.
    ///
    /// - `path`: its name if it is a field, otherwise empty.
    /// - `length`: bytes of the array.
    /// - `depth`: structures around it.
    fn matrix<R: Read>(
        &mut self,
        read: &mut Counted<R>,
        path: &str,
        length: u64,
        depth: usize,
    ) -> IoResult<()> {
        let end = read.at + length;
        if length == 0 {
            return Ok(());
        }
        if depth > MAX_NESTING {
            return Err(damaged("more than 16 structures within each other"));
        }
        let flags = self.bytes(read)?;
        if flags.len() < 4 {
            return Err(damaged("an array without flags"));
        }
        let flags = word(&flags, self.contents.big_endian);
        let (class, complex) = (flags & 0xff, flags & 0x800 != 0);
        // Objects have no dimensions: their name follows the flags.
        if class == 17 {
            let name = String::from_utf8_lossy(&self.bytes(read)?).into_owned();
            let name = if path.is_empty() { &name } else { path };
            return self.refuse(
                read,
                end,
                depth,
                name,
                "is an object (a table, timeseries or datetime); save its arrays instead",
            );
        }
        let dimensions: Vec<u64> = (self.bytes(read)?.chunks_exact(4))
            .map(|four| u64::from(word(four, self.contents.big_endian)))
            .collect();
        let text = String::from_utf8_lossy(&self.bytes(read)?).into_owned();
        let name = if path.is_empty() {
            text
        } else {
            path.to_owned()
        };
        // Sides of 0 count as 1, so that the product of any part of the dimensions does not overflow either.
        let mut sides = dimensions.iter().map(|n| *n.max(&1));
        if sides.try_fold(1_u64, u64::checked_mul).is_none() {
            return Err(damaged("absurd dimensions"));
        }
        let count = dimensions.iter().product();
        match class {
            2 | 3 => {
                if class == 3 {
                    self.bytes(read)?;
                }
                self.structure(read, &name, count, depth)?;
                Self::rest(read, end, depth)
            }
            6..=15 if complex => self.refuse(read, end, depth, &name, "is complex"),
            6..=15 => {
                self.numbers(read, &name, &dimensions)?;
                Self::rest(read, end, depth)
            }
            1 => self.refuse(read, end, depth, &name, "is a cell array"),
            4 => self.refuse(read, end, depth, &name, "is text"),
            5 => self.refuse(read, end, depth, &name, "is sparse; save full(…) of it"),
            _ => self.refuse(read, end, depth, &name, "is of a type that is not read"),
        }
    }

    /// Skips the rest of an array, unless it is the requested variable, the last one to read.
    fn rest<R: Read>(read: &mut Counted<R>, end: u64, depth: usize) -> IoResult<()> {
        if depth == 0 {
            return Ok(());
        }
        let left = end.checked_sub(read.at);
        read.skip(left.ok_or_else(|| damaged("an array whose parts are longer than the array"))?)
    }

    /// Records why an array is not read, and skips its rest.
    fn refuse<R: Read>(
        &mut self,
        read: &mut Counted<R>,
        end: u64,
        depth: usize,
        name: &str,
        why: &str,
    ) -> IoResult<()> {
        if !name.is_empty() {
            self.contents.refused.push(Refused {
                name: name.to_owned(),
                why: why.to_owned(),
            });
        }
        Self::rest(read, end, depth)
    }

    /// Notes where the numbers of an array are.
    fn numbers<R: Read>(
        &mut self,
        read: &mut Counted<R>,
        name: &str,
        dimensions: &[u64],
    ) -> IoResult<()> {
        let element = self.element(read)?;
        let number = match element.kind {
            1 => Number::I8,
            2 => Number::U8,
            3 => Number::I16,
            4 => Number::U16,
            5 => Number::I32,
            6 => Number::U32,
            7 => Number::F32,
            9 => Number::F64,
            12 => Number::I64,
            13 => Number::U64,
            _ => return Err(damaged("numbers of unknown type")),
        };
        let count =
            (dimensions.iter()).try_fold(number.size() as u64, |size, n| size.checked_mul(*n));
        if count != Some(element.length) {
            return Err(damaged("an array of another size than its dimensions"));
        }
        match Sides::of(dimensions) {
            // A single number is a setting, not a channel.
            Ok(sides) if element.short.is_none() && sides.rows * sides.columns > 1 => {
                self.contents.arrays.push(MatArray {
                    name: name.to_owned(),
                    sides,
                    number,
                    variable: self.variable,
                    compressed: self.compressed,
                    at: read.at,
                });
            }
            Ok(_) => {}
            Err(why) => self.contents.refused.push(Refused {
                name: name.to_owned(),
                why,
            }),
        }
        Ok(())
    }

    /// Scans the fields of a structure array.
    ///
    /// - `count`: its elements.
    fn structure<R: Read>(
        &mut self,
        read: &mut Counted<R>,
        name: &str,
        count: u64,
        depth: usize,
    ) -> IoResult<()> {
        let length = self.bytes(read)?;
        if length.len() < 4 {
            return Err(damaged("a structure without fields"));
        }
        let length = word(&length, self.contents.big_endian) as usize;
        let names = self.bytes(read)?;
        if length == 0 {
            return if names.is_empty() {
                Ok(())
            } else {
                Err(damaged("fields without names"))
            };
        }
        let fields: Vec<String> = (names.chunks_exact(length))
            .map(|bytes| {
                let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(length);
                String::from_utf8_lossy(&bytes[..end]).into_owned()
            })
            .collect();
        if length > MAX_NAME_BYTES || name.len() > MAX_NESTING * MAX_NAME_BYTES {
            return Err(damaged("a name of absurd length"));
        }
        if count.saturating_mul(fields.len() as u64) > MAX_STRUCTURE_ELEMENTS {
            return Err(damaged("a structure with absurdly many elements"));
        }
        for i in 0..count {
            for field in &fields {
                let path = match count {
                    1 => format!("{name}.{field}"),
                    _ => format!("{name}({}).{field}", i + 1),
                };
                let element = self.element(read)?;
                if element.kind != MATRIX {
                    return Err(damaged("a field of unknown type"));
                }
                self.matrix(read, &path, element.length, depth + 1)?;
            }
        }
        Ok(())
    }
}
