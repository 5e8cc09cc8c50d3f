//! Lengths that Arrow files declare.

use std::io::{BufReader, Read, Result as IoResult, Seek, SeekFrom};

use arrow_ipc::{Message, root_as_footer, root_as_message};

use super::damaged::damaged;
use crate::error::LogError;
use crate::input::{Input, Kind};
use crate::input_limits::RECORD_BYTES;

/// Largest accepted size of an uncompressed buffer, in bytes.
const MAX_BUFFER_BYTES: u64 = RECORD_BYTES as u64;

/// Marker before the length of a message.
const CONTINUATION: [u8; 4] = [0xff; 4];

/// Length of the footer's length and of the last marker of a file, in bytes.
const TAIL_BYTES: usize = 10;

/// Refuses files that declare more than they can hold, because the Arrow library allocates the declared length before
/// it reads: blocks beyond the end of the file, and compressed buffers of more than [`MAX_BUFFER_BYTES`].
///
/// Other errors of the format are left to the library, which reports them when it reads the file.
pub(super) fn refuse_absurd(file: &str, kind: Kind, input: Box<dyn Input>) -> Result<(), LogError> {
    let mut read = BufReader::new(input);
    let absurd = if kind == Kind::ArrowFile {
        in_file(&mut read)
    } else {
        in_stream(&mut read)
    };
    // The library reports a file that cannot be read.
    match absurd {
        Ok(Some(absurd)) => Err(damaged(file, &absurd)),
        Ok(None) | Err(_) => Ok(()),
    }
}

/// Returns the first absurd length in the blocks that the footer of a file lists.
///
/// # Source
///
/// Arrow Columnar Format, "IPC File Format".
fn in_file(read: &mut (impl Read + Seek)) -> IoResult<Option<String>> {
    let end = read.seek(SeekFrom::End(0))?;
    read.seek(SeekFrom::End(-(TAIL_BYTES as i64)))?;
    let mut word = [0; 4];
    read.read_exact(&mut word)?;
    let length = u64::from(u32::from_le_bytes(word));
    let Some(begin) = end.checked_sub(length + TAIL_BYTES as u64) else {
        let absurd = format!("the footer claims to have {length} of {end} bytes");
        return Ok(Some(absurd));
    };
    read.seek(SeekFrom::Start(begin))?;
    let mut bytes = Vec::new();
    read.by_ref().take(length).read_to_end(&mut bytes)?;
    let Ok(footer) = root_as_footer(&bytes) else {
        return Ok(None);
    };
    let dictionaries = footer.dictionaries().into_iter().flatten();
    for block in dictionaries.chain(footer.recordBatches().into_iter().flatten()) {
        let (offset, head, body) = (block.offset(), block.metaDataLength(), block.bodyLength());
        let extent = || {
            let at = u64::try_from(offset).ok()?;
            let body_at = at.checked_add(u64::try_from(head).ok()?)?;
            let block_end = body_at.checked_add(u64::try_from(body).ok()?)?;
            (block_end <= end).then_some((at, body_at))
        };
        let Some((at, body_at)) = extent() else {
            return Ok(Some(format!(
                "a block at byte {offset} claims to have {head} + {body} bytes, and the file has {end}"
            )));
        };
        read.seek(SeekFrom::Start(at))?;
        let mut bytes = Vec::new();
        (read.by_ref().take(body_at - at)).read_to_end(&mut bytes)?;
        let prefix = if bytes.starts_with(&CONTINUATION) {
            8
        } else {
            4
        };
        let message = bytes.get(prefix..).map(root_as_message);
        let Some(Ok(message)) = message else {
            return Ok(Some(format!("the block at byte {offset} has no message")));
        };
        let absurd = in_buffers(read, &message, body_at)?;
        if absurd.is_some() {
            return Ok(absurd);
        }
    }
    Ok(None)
}

/// Returns the first absurd length in the messages of a stream.
///
/// # Source
///
/// Arrow Columnar Format, "Encapsulated message format".
fn in_stream(read: &mut (impl Read + Seek)) -> IoResult<Option<String>> {
    let mut place = 0;
    loop {
        read.seek(SeekFrom::Start(place))?;
        let mut word = [0; 4];
        read.read_exact(&mut word)?;
        place += 4;
        if word == CONTINUATION {
            read.read_exact(&mut word)?;
            place += 4;
        }
        let length = u64::from(u32::from_le_bytes(word));
        let mut bytes = Vec::new();
        read.by_ref().take(length).read_to_end(&mut bytes)?;
        let Ok(message) = root_as_message(&bytes) else {
            return Ok(None);
        };
        place += length;
        let absurd = in_buffers(read, &message, place)?;
        if absurd.is_some() {
            return Ok(absurd);
        }
        place = place.saturating_add(u64::try_from(message.bodyLength()).unwrap_or(u64::MAX));
    }
}

/// Returns the first absurd length in the compressed buffers of a message.
///
/// - `body`: position of the body of the message, in bytes.
///
/// # Source
///
/// Arrow Columnar Format, "Compression".
fn in_buffers(
    read: &mut (impl Read + Seek),
    message: &Message<'_>,
    body: u64,
) -> IoResult<Option<String>> {
    let dictionary = message
        .header_as_dictionary_batch()
        .and_then(|dictionary| dictionary.data());
    let batch = message.header_as_record_batch().or(dictionary);
    let buffers = batch.filter(|batch| batch.compression().is_some());
    let buffers = buffers.and_then(|batch| batch.buffers());
    for buffer in buffers.iter().flatten().filter(|b| b.length() >= 8) {
        let offset = u64::try_from(buffer.offset()).unwrap_or(0);
        read.seek(SeekFrom::Start(body.saturating_add(offset)))?;
        let mut claim = [0; 8];
        read.read_exact(&mut claim)?;
        // A size of -1 marks a buffer that is not compressed.
        let claim = i64::from_le_bytes(claim);
        if u64::try_from(claim).is_ok_and(|claim| claim > MAX_BUFFER_BYTES) {
            return Ok(Some(format!("a buffer claims to hold {claim} bytes")));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::sync::Arc;

    use arrow_array::{Array, Float64Array, RecordBatch};
    use arrow_ipc::CompressionType;
    use arrow_ipc::writer::{FileWriter, IpcWriteOptions, StreamWriter};

    use super::*;

    const ROWS: usize = 1000;

    /// Returns an Arrow file and an Arrow stream with one compressed column.
    fn written() -> [(Kind, Vec<u8>); 2] {
        let rest: Arc<dyn Array> = Arc::new(Float64Array::from(vec![0.0; ROWS]));
        let batch = RecordBatch::try_from_iter([("t", rest)]).unwrap();
        let options = || {
            let plain = IpcWriteOptions::default();
            (plain.try_with_compression(Some(CompressionType::ZSTD))).unwrap()
        };
        let (mut file, mut stream) = (Vec::new(), Vec::new());
        let mut writer =
            FileWriter::try_new_with_options(&mut file, &batch.schema(), options()).unwrap();
        writer.write(&batch).unwrap();
        writer.finish().unwrap();
        drop(writer);
        let mut writer =
            StreamWriter::try_new_with_options(&mut stream, &batch.schema(), options()).unwrap();
        writer.write(&batch).unwrap();
        drop(writer);
        [(Kind::ArrowFile, file), (Kind::ArrowStream, stream)]
    }

    fn refuse(kind: Kind, bytes: &[u8]) -> Result<(), String> {
        let input = Box::new(Cursor::new(bytes.to_vec()));
        refuse_absurd("run", kind, input).map_err(|error| error.to_string())
    }

    /// Replaces the last occurrence of a number in `bytes`.
    fn replaced(bytes: &[u8], old: &[u8], new: &[u8]) -> Vec<u8> {
        let at = bytes.windows(old.len()).rposition(|part| part == old);
        let mut bytes = bytes.to_vec();
        bytes[at.unwrap()..][..new.len()].copy_from_slice(new);
        bytes
    }

    #[test]
    fn buffers_that_claim_too_much_are_refused() {
        for (kind, bytes) in written() {
            refuse(kind, &bytes).unwrap();
            let size = (8 * ROWS as u64).to_le_bytes();
            let absurd = replaced(&bytes, &size, &(1_u64 << 50).to_le_bytes());
            let error = refuse(kind, &absurd).unwrap_err();
            assert!(
                error.contains("a buffer claims to hold 1125899906842624 bytes"),
                "{error}"
            );
        }
    }

    #[test]
    fn blocks_beyond_the_end_of_a_file_are_refused() {
        let [(kind, bytes), _] = written();
        let tail = bytes.len() - TAIL_BYTES;
        let length = u32::from_le_bytes(bytes[tail..tail + 4].try_into().unwrap());
        let begin = tail - length as usize;
        let footer = root_as_footer(&bytes[begin..tail]).unwrap();
        let block = *footer.recordBatches().unwrap().get(0);
        let (offset, head, body) = (block.offset(), block.metaDataLength(), block.bodyLength());
        let end = bytes.len();
        let body_of = |body: i64| body.to_le_bytes();
        for wrong in [1 << 34, i64::MAX, -1] {
            let error = refuse(kind, &replaced(&bytes, &body_of(body), &body_of(wrong)));
            let claim = format!(
                "a block at byte {offset} claims to have {head} + {wrong} bytes, and the file has {end}"
            );
            assert!(error.as_ref().unwrap_err().contains(&claim), "{error:?}");
        }
        let mut long = bytes.clone();
        long[tail..tail + 4].copy_from_slice(&i32::MAX.to_le_bytes());
        let error = refuse(kind, &long).unwrap_err();
        let claim = format!("the footer claims to have {} of {end} bytes", i32::MAX);
        assert!(error.contains(&claim), "{error}");
        let place = [&offset.to_le_bytes()[..], &head.to_le_bytes()[..]].concat();
        let no_message = replaced(&bytes, &place, &0_i64.to_le_bytes());
        let error = refuse(kind, &no_message).unwrap_err();
        assert!(
            error.contains("the block at byte 0 has no message"),
            "{error}"
        );
    }
}
