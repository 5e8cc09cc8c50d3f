//! Uncompressed sizes that the compressed buffers of Arrow files declare.

use std::io::{BufReader, Read, Seek, SeekFrom};

use super::damaged::damaged;
use crate::error::LogError;
use crate::input::{Input, Kind};

/// Largest accepted size of an uncompressed buffer, in bytes.
const MAX_BUFFER_BYTES: u64 = 1 << 30;

/// Marker before the length of a message.
const CONTINUATION: [u8; 4] = [0xff; 4];

/// Refuses files whose compressed buffers declare more than [`MAX_BUFFER_BYTES`], because the Arrow library
/// allocates the declared size before it decompresses a buffer.
///
/// Errors of the format are left to the library, which reports them when it reads the file.
pub(super) fn refuse_absurd(file: &str, kind: Kind, input: Box<dyn Input>) -> Result<(), LogError> {
    let mut read = BufReader::new(input);
    let begin = if kind == Kind::ArrowFile { 8 } else { 0 };
    let mut largest = 0;
    // The library reports a truncated or damaged file.
    let _ = claims(&mut read, begin, |claim| largest = largest.max(claim));
    if largest > MAX_BUFFER_BYTES {
        let claim = format_args!("a buffer claims to hold {largest} bytes");
        return Err(damaged(file, &claim));
    }
    Ok(())
}

/// Passes the declared size of each compressed buffer to `claimed`, in bytes.
///
/// - `begin`: position of the first message.
///
/// # Source
///
/// Arrow Columnar Format, "Encapsulated message format" and "Compression".
fn claims(
    read: &mut (impl Read + Seek),
    begin: u64,
    mut claimed: impl FnMut(u64),
) -> std::io::Result<()> {
    let mut place = begin;
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
        // Zeros may pad the first 64 bytes of a file.
        if length == 0 && place <= 64 {
            continue;
        }
        let mut head = Vec::new();
        read.by_ref().take(length).read_to_end(&mut head)?;
        let Ok(message) = arrow_ipc::root_as_message(&head) else {
            return Ok(());
        };
        place += length;
        let dictionary = message
            .header_as_dictionary_batch()
            .and_then(|dictionary| dictionary.data());
        let batch = message.header_as_record_batch().or(dictionary);
        let buffers = batch.filter(|batch| batch.compression().is_some());
        let buffers = buffers.and_then(|batch| batch.buffers());
        for buffer in buffers.iter().flatten().filter(|b| b.length() >= 8) {
            let offset = u64::try_from(buffer.offset()).unwrap_or(0);
            read.seek(SeekFrom::Start(place.saturating_add(offset)))?;
            let mut claim = [0; 8];
            read.read_exact(&mut claim)?;
            // A size of -1 marks a buffer that is not compressed.
            if let Ok(claim) = u64::try_from(i64::from_le_bytes(claim)) {
                claimed(claim);
            }
        }
        place = place.saturating_add(u64::try_from(message.bodyLength()).unwrap_or(u64::MAX));
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::sync::Arc;

    use arrow_array::{Array, Float64Array, RecordBatch};
    use arrow_ipc::CompressionType;
    use arrow_ipc::writer::{FileWriter, IpcWriteOptions, StreamWriter};

    use super::*;

    #[test]
    fn buffers_that_claim_too_much_are_refused() {
        let rest: Arc<dyn Array> = Arc::new(Float64Array::from(vec![0.0; 1000]));
        let batch = RecordBatch::try_from_iter([("t", rest)]).unwrap();
        let options = || {
            let plain = IpcWriteOptions::default();
            (plain.try_with_compression(Some(CompressionType::ZSTD))).unwrap()
        };
        let mut file = Vec::new();
        let mut writer =
            FileWriter::try_new_with_options(&mut file, &batch.schema(), options()).unwrap();
        writer.write(&batch).unwrap();
        writer.finish().unwrap();
        drop(writer);
        let mut stream = Vec::new();
        let mut writer =
            StreamWriter::try_new_with_options(&mut stream, &batch.schema(), options()).unwrap();
        writer.write(&batch).unwrap();
        drop(writer);
        for (kind, bytes) in [(Kind::ArrowFile, file), (Kind::ArrowStream, stream)] {
            let refuse =
                |bytes: &[u8]| refuse_absurd("run", kind, Box::new(Cursor::new(bytes.to_vec())));
            refuse(&bytes).unwrap();
            let claim = 8000_u64.to_le_bytes();
            let at = bytes.windows(8).rposition(|part| part == claim).unwrap();
            let mut absurd = bytes.clone();
            absurd[at..at + 8].copy_from_slice(&(1_u64 << 50).to_le_bytes());
            let error = refuse(&absurd).unwrap_err().to_string();
            assert!(
                error.contains("a buffer claims to hold 1125899906842624 bytes"),
                "{error}"
            );
        }
    }
}
