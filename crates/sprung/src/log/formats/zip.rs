//! Members of a zip archive, each a stream of its own.

use std::io::{Error, ErrorKind, Read, Seek, SeekFrom};

use crate::log::error::LogError;
use crate::log::input::Input;

/// A member of an archive.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub(super) name: String,
    method: u16,
    compressed: u64,
    size: u64,
    crc: u32,
    /// Of its local header.
    at: u64,
}

const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// Longest list of members that is believed.
const MAX_DIRECTORY_BYTES: u64 = 1 << 26;

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    let four = bytes.get(at..at + 4)?.try_into().ok()?;
    Some(u64::from(u32::from_le_bytes(four)))
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?))
}

/// Lists the members of an archive.
pub(super) fn members(file: &str, read: &mut dyn Input) -> Result<Vec<Member>, LogError> {
    let failed = |error| LogError::read(file, "the list of its members", error);
    list(read).map_err(failed)?.ok_or_else(|| {
        LogError::format(
            file,
            " has no list of its members at its end: it was cut off; copy or write it again",
        )
    })
}

fn list(read: &mut dyn Input) -> std::io::Result<Option<Vec<Member>>> {
    // The end of the archive stands within the last 64 KiB, behind it a comment.
    let length = read.seek(SeekFrom::End(0))?;
    let tail = length.min((1 << 16) + 22 + 20);
    read.seek(SeekFrom::Start(length - tail))?;
    let mut end = vec![0; tail as usize];
    read.read_exact(&mut end)?;
    let Some(at) = end.windows(4).rposition(|four| four == b"PK\x05\x06") else {
        return Ok(None);
    };
    let entry = |at: usize| Some((word(&end, at + 12)?, word(&end, at + 16)?));
    let Some((mut size, mut start)) = entry(at) else {
        return Ok(None);
    };
    if start == 0xffff_ffff || size == 0xffff_ffff {
        let locator = at.checked_sub(20).and_then(|at| long(&end, at + 8));
        let Some(record) = locator else {
            return Ok(None);
        };
        read.seek(SeekFrom::Start(record))?;
        let mut bytes = [0; 56];
        read.read_exact(&mut bytes)?;
        size = long(&bytes, 40).unwrap_or_default();
        start = long(&bytes, 48).unwrap_or_default();
    }
    if size > MAX_DIRECTORY_BYTES || start > length {
        return Ok(None);
    }
    read.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; size as usize];
    read.read_exact(&mut bytes)?;
    let (mut all, mut rest) = (Vec::new(), &bytes[..]);
    while rest.starts_with(b"PK\x01\x02") {
        let Some((member, used)) = member(rest) else {
            return Ok(None);
        };
        all.push(member);
        rest = rest.get(used..).unwrap_or_default();
    }
    Ok(Some(all))
}

/// Reads an entry of the list; returns how long it is.
fn member(bytes: &[u8]) -> Option<(Member, usize)> {
    let (name, extra, comment) = (
        usize::from(half(bytes, 28)?),
        usize::from(half(bytes, 30)?),
        usize::from(half(bytes, 32)?),
    );
    let mut member = Member {
        name: String::from_utf8_lossy(bytes.get(46..46 + name)?).into_owned(),
        method: half(bytes, 10)?,
        crc: u32::try_from(word(bytes, 16)?).ok()?,
        compressed: word(bytes, 20)?,
        size: word(bytes, 24)?,
        at: word(bytes, 42)?,
    };
    // Large numbers stand in an extra field, in this order.
    let mut extras = bytes.get(46 + name..46 + name + extra)?;
    while extras.len() >= 4 {
        let length = usize::from(half(extras, 2)?);
        if half(extras, 0)? == 1 {
            let mut at = 4;
            for number in [&mut member.size, &mut member.compressed, &mut member.at] {
                if *number == 0xffff_ffff {
                    *number = long(extras, at)?;
                    at += 8;
                }
            }
        }
        extras = extras.get(4 + length..).unwrap_or_default();
    }
    Some((member, 46 + name + extra + comment))
}

impl Member {
    /// Returns a reader of its contents.
    pub(super) fn open(
        &self,
        file: &str,
        mut read: Box<dyn Input>,
    ) -> Result<Box<dyn Read + Send>, LogError> {
        let name = &self.name;
        let failed = |error| LogError::read(file, name, error);
        read.seek(SeekFrom::Start(self.at)).map_err(failed)?;
        let mut head = [0; 30];
        read.read_exact(&mut head).map_err(failed)?;
        let lengths = (head.starts_with(b"PK\x03\x04"))
            .then(|| Some((half(&head, 26)?, half(&head, 28)?)))
            .flatten();
        let Some((of_name, of_extra)) = lengths else {
            let error = Error::new(
                ErrorKind::InvalidData,
                "its header is not where it should be",
            );
            return Err(failed(error));
        };
        let skip = i64::from(of_name) + i64::from(of_extra);
        read.seek(SeekFrom::Current(skip)).map_err(failed)?;
        let packed = read.take(self.compressed);
        let inner: Box<dyn Read + Send> = match self.method {
            STORED => Box::new(packed),
            DEFLATED => Box::new(flate2::read::DeflateDecoder::new(packed)),
            other => {
                return Err(LogError::format(
                    file,
                    format!(
                        ": {name} is compressed with method {other}; write it with numpy.savez or \
                         numpy.savez_compressed"
                    ),
                ));
            }
        };
        Ok(Box::new(Checked {
            inner,
            sum: flate2::Crc::new(),
            left: self.size,
            expected: self.crc,
        }))
    }
}

/// Compares the checksum at the end.
struct Checked<R> {
    inner: R,
    sum: flate2::Crc,
    left: u64,
    expected: u32,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let room = out
            .len()
            .min(usize::try_from(self.left).unwrap_or(usize::MAX));
        if room == 0 {
            return Ok(0);
        }
        let count = self.inner.read(&mut out[..room])?;
        self.sum.update(&out[..count]);
        self.left -= count as u64;
        if self.left == 0 && self.sum.sum() != self.expected {
            return Err(Error::new(ErrorKind::InvalidData, "its checksum is wrong"));
        }
        Ok(count)
    }
}
