//! Numbers within a message in CDR, the encoding of ROS 2.

use super::definition::{Base, Count, Definition, NAMES, Scalar};

/// A step on the way to a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Field(String),
    Index(usize),
    /// The element that a list of names beside it gives this name.
    Named(String),
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    Nothing,
    Float(f64),
    Integer(i64),
}

/// A place for a number, and what is left of the way to it.
type Way<'a> = (usize, &'a [Step]);

struct Decoder<'a> {
    definition: &'a Definition,
    data: &'a [u8],
    at: usize,
    big_endian: bool,
    widest: usize,
    found: &'a mut [Found],
    names: Vec<String>,
}

/// Reads the numbers at the end of some paths; returns the names that the
/// message gives its elements.
///
/// - `found`: one place for each path.
pub(super) fn decode(
    definition: &Definition,
    data: &[u8],
    paths: &[Vec<Step>],
    found: &mut [Found],
) -> Result<Vec<String>, String> {
    found.fill(Found::Nothing);
    let (big_endian, widest) = match data {
        [0, 0, _, _, ..] => (true, 8),
        [0, 1, _, _, ..] => (false, 8),
        [0, 6, _, _, ..] => (true, 4),
        [0, 7, _, _, ..] => (false, 4),
        [_, _, _, _, ..] => return Err("is not in plain CDR".to_owned()),
        _ => return Err("is too short to be a message".to_owned()),
    };
    let mut decoder = Decoder {
        definition,
        data: &data[4..],
        at: 0,
        big_endian,
        widest,
        found,
        names: Vec::new(),
    };
    let ways: Vec<Way<'_>> = paths.iter().map(|path| &path[..]).enumerate().collect();
    decoder.message(0, &ways)?;
    Ok(decoder.names)
}

fn cut() -> String {
    "ends in the middle: it is damaged, or its definition is another's".to_owned()
}

impl Decoder<'_> {
    fn message(&mut self, kind: usize, ways: &[Way<'_>]) -> Result<(), String> {
        let definition = self.definition;
        let fields = &definition.types[kind];
        if fields.is_empty() {
            // An empty message is a byte.
            return self.skip(1, 1);
        }
        let arrives = ways.iter().find(|(_, way)| way.is_empty());
        if let (Some((place, _)), true) = (arrives, definition.is_time(kind)) {
            let (seconds, rest) = (self.bits(4)? as i32, self.bits(4)? as u32);
            self.found[*place] =
                Found::Integer(i64::from(seconds) * 1_000_000_000 + i64::from(rest));
            return Ok(());
        }
        for field in fields {
            let inner: Vec<Way<'_>> = (ways.iter())
                .filter_map(|(place, way)| match way.split_first() {
                    Some((Step::Field(name), rest)) if *name == field.name => Some((*place, rest)),
                    _ => None,
                })
                .collect();
            let count = match field.count {
                Count::One => {
                    self.value(field.base, &inner)?;
                    continue;
                }
                Count::Fixed(count) => count,
                Count::Any => self.bits(4)? as usize,
            };
            if count > self.data.len() - self.at {
                return Err(cut());
            }
            if field.base == Base::Text && NAMES.contains(&field.name.as_str()) {
                self.names = (0..count).map(|_| self.text()).collect::<Result<_, _>>()?;
            } else {
                self.list(field.base, count, &inner)?;
            }
        }
        Ok(())
    }

    fn list(&mut self, base: Base, count: usize, ways: &[Way<'_>]) -> Result<(), String> {
        let wanted: Vec<(usize, Way<'_>)> = (ways.iter())
            .filter_map(|(place, way)| {
                let (step, rest) = way.split_first()?;
                let index = match step {
                    Step::Index(index) => *index,
                    Step::Named(name) => self.names.iter().position(|known| known == name)?,
                    Step::Field(_) => return None,
                };
                Some((index, (*place, rest)))
            })
            .collect();
        let last = wanted.iter().map(|(index, _)| index + 1).max().unwrap_or(0);
        for i in 0..count {
            if i >= last && let Base::Scalar(scalar) = base {
                let size = scalar.size();
                return self.skip(size, size.checked_mul(count - i).ok_or_else(cut)?);
            }
            let here: Vec<Way<'_>> = (wanted.iter())
                .filter(|(index, _)| *index == i)
                .map(|(_, way)| *way)
                .collect();
            self.value(base, &here)?;
        }
        Ok(())
    }

    fn value(&mut self, base: Base, ways: &[Way<'_>]) -> Result<(), String> {
        match base {
            Base::Text => self.text().map(drop),
            Base::WideText => {
                let count = self.bits(4)? as usize;
                self.skip(2, count.checked_mul(2).ok_or_else(cut)?)
            }
            Base::Message(kind) => self.message(kind, ways),
            Base::Scalar(scalar) => {
                let found = self.scalar(scalar)?;
                for (place, way) in ways {
                    if way.is_empty() {
                        self.found[*place] = found;
                    }
                }
                Ok(())
            }
        }
    }

    fn scalar(&mut self, scalar: Scalar) -> Result<Found, String> {
        let bits = self.bits(scalar.size())?;
        Ok(match scalar {
            Scalar::F64 => Found::Float(f64::from_bits(bits)),
            Scalar::F32 => Found::Float(f64::from(f32::from_bits(bits as u32))),
            Scalar::I8 => Found::Integer(i64::from(bits as i8)),
            Scalar::I16 => Found::Integer(i64::from(bits as i16)),
            Scalar::I32 => Found::Integer(i64::from(bits as i32)),
            Scalar::I64 => Found::Integer(bits as i64),
            Scalar::U8 | Scalar::U16 | Scalar::U32 => Found::Integer(bits as i64),
            Scalar::U64 => i64::try_from(bits).map_or(Found::Float(bits as f64), Found::Integer),
        })
    }

    /// Steps to the next multiple of a size, and over some bytes.
    fn skip(&mut self, align: usize, bytes: usize) -> Result<(), String> {
        if bytes == 0 {
            return Ok(());
        }
        let start = self.at.next_multiple_of(align.min(self.widest));
        let end = start.checked_add(bytes).filter(|end| *end <= self.data.len());
        self.at = end.ok_or_else(cut)?;
        Ok(())
    }

    fn bits(&mut self, size: usize) -> Result<u64, String> {
        self.skip(size, size)?;
        let bytes = &self.data[self.at - size..self.at];
        let push = |bits: u64, byte: &u8| bits << 8 | u64::from(*byte);
        Ok(if self.big_endian {
            bytes.iter().fold(0, push)
        } else {
            bytes.iter().rev().fold(0, push)
        })
    }

    /// Reads text; its length counts the zero at its end.
    fn text(&mut self) -> Result<String, String> {
        let length = self.bits(4)? as usize;
        self.skip(1, length)?;
        let bytes = &self.data[self.at - length..self.at];
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(path: &[Step]) -> Vec<Vec<Step>> {
        vec![path.to_vec()]
    }

    #[test]
    fn both_byte_orders_and_their_padding() {
        let definition = Definition::parse("a/msg/B", "uint8 a\nfloat64 b\nint16[] c\n").unwrap();
        let little = [
            &[0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0][..],
            &1.5_f64.to_le_bytes(),
            &[2, 0, 0, 0, 5, 0, 0xfe, 0xff],
        ]
        .concat();
        let big = [
            &[0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0][..],
            &1.5_f64.to_be_bytes(),
            &[0, 0, 0, 2, 0, 5, 0xff, 0xfe],
        ]
        .concat();
        let field = |name: &str| Step::Field(name.to_owned());
        for data in [little, big] {
            let mut found = [Found::Nothing];
            decode(&definition, &data, &paths(&[field("b")]), &mut found).unwrap();
            assert_eq!(found, [Found::Float(1.5)]);
            let last = paths(&[field("c"), Step::Index(1)]);
            decode(&definition, &data, &last, &mut found).unwrap();
            assert_eq!(found, [Found::Integer(-2)]);
            // Every message that is cut off is refused.
            for length in 0..data.len() {
                assert!(decode(&definition, &data[..length], &last, &mut found).is_err());
            }
        }
    }

    #[test]
    fn absurd_lengths_are_refused() {
        let definition = Definition::parse("a/msg/B", "string[] name\nfloat64[] b\n").unwrap();
        let data = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
        assert!(decode(&definition, &data, &[], &mut []).is_err());
        let data = [0, 1, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 0xff, 0x7f];
        assert!(decode(&definition, &data, &[], &mut []).is_err());
    }
}
