//! Numbers in a message in CDR, the encoding of ROS 2.
//!
//! Only the wanted numbers are decoded; other fields are skipped.

use super::definition::{Base, Count, Definition};
use super::number::{Number, Reading};
use super::table::NAMES;

/// One step of the path from a message to a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Field(String),
    Index(usize),
    /// The element with this name; a list in the same message names the elements.
    Named(String),
}

/// The number at the end of a path, `None` if the message has no such element.
pub(super) type Found = Option<Reading>;

/// The index of a path, and those of its steps that lead from the current message to the number.
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

/// Decodes the numbers at the end of some paths; returns the names of the message's elements.
///
/// - `found`: receives the numbers, [paths].
///
/// # Errors
///
/// The end of a sentence that begins with the number of the message.
pub(super) fn decode(
    definition: &Definition,
    data: &[u8],
    paths: &[Vec<Step>],
    found: &mut [Found],
) -> Result<Vec<String>, String> {
    found.fill(None);
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
    "ends in the middle: it is damaged, or the bag contains the definition of another type"
        .to_owned()
}

impl Decoder<'_> {
    fn message(&mut self, kind: usize, ways: &[Way<'_>]) -> Result<(), String> {
        let definition = self.definition;
        let fields = &definition.types[kind];
        if fields.is_empty() {
            // CDR stores a message without fields as one byte.
            return self.skip(1, 1);
        }
        let arrives = ways.iter().find(|(_, way)| way.is_empty());
        if let (Some((place, _)), true) = (arrives, definition.is_time(kind)) {
            let seconds = self.number(Number::I32)?;
            let rest = self.number(Number::U32)?;
            if let (Reading::Integer(seconds), Reading::Integer(rest)) = (seconds, rest) {
                self.found[*place] = Some(Reading::Integer(seconds * 1_000_000_000 + rest));
            }
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
                Count::Any => self.length()?,
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
        let last = wanted
            .iter()
            .map(|(index, _)| index.saturating_add(1))
            .max()
            .unwrap_or(0);
        for i in 0..count {
            if i >= last
                && let Base::Number(number) = base
            {
                let size = number.size();
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
                let count = self.length()?;
                self.skip(2, count.checked_mul(2).ok_or_else(cut)?)
            }
            Base::Message(kind) => self.message(kind, ways),
            Base::Number(number) => {
                let found = Some(self.number(number)?);
                for (place, way) in ways {
                    if way.is_empty() {
                        self.found[*place] = found;
                    }
                }
                Ok(())
            }
        }
    }

    /// Skips padding up to a multiple of `align`, then skips `bytes`.
    fn skip(&mut self, align: usize, bytes: usize) -> Result<(), String> {
        if bytes == 0 {
            return Ok(());
        }
        let start = self.at.next_multiple_of(align.min(self.widest));
        let end = start
            .checked_add(bytes)
            .filter(|end| *end <= self.data.len());
        self.at = end.ok_or_else(cut)?;
        Ok(())
    }

    fn number(&mut self, number: Number) -> Result<Reading, String> {
        let size = number.size();
        self.skip(size, size)?;
        let bytes = &self.data[self.at - size..self.at];
        Ok(number.read(bytes, self.big_endian))
    }

    /// Reads the length of a sequence or a text.
    fn length(&mut self) -> Result<usize, String> {
        match self.number(Number::U32)? {
            Reading::Integer(length) => usize::try_from(length).map_err(|_| cut()),
            Reading::Float(_) => Err(cut()),
        }
    }

    /// Reads a text; its stored length includes the terminating zero.
    fn text(&mut self) -> Result<String, String> {
        let length = self.length()?;
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
            let mut found = [None];
            decode(&definition, &data, &paths(&[field("b")]), &mut found).unwrap();
            assert_eq!(found, [Some(Reading::Float(1.5))]);
            let last = paths(&[field("c"), Step::Index(1)]);
            decode(&definition, &data, &last, &mut found).unwrap();
            assert_eq!(found, [Some(Reading::Integer(-2))]);
            // Every truncated message is refused.
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
