//! Opens a file in the format that its first bytes show.

use std::io::Read;
use std::sync::Arc;

#[cfg(feature = "arrow")]
use super::arrow;
#[cfg(feature = "db3")]
use super::db3;
#[cfg(feature = "mat73")]
use super::mat73;
#[cfg(feature = "mcap")]
use super::mcap;
use super::recording::{UpToCut, Watch};
use super::table::{Opened, Reopen, Request};
use super::{arrays, csv, json, matlab};
use crate::error::LogError;
use crate::input::{Beginning, Kind, kind_of, peek};

/// Opens a file in the format that its first bytes show.
///
/// # Errors
///
/// [`LogError`] if the format is not supported, the file is damaged or a column is missing.
pub(crate) fn open(request: &Request<'_>, reopen: Reopen<'_>) -> Result<Opened, LogError> {
    let file = request.file;
    let Beginning {
        start,
        is_whole,
        again: read,
    } = peek(file, "its beginning", reopen()?)?;
    match kind_of(&start) {
        Kind::Gzip => {
            let inner = flate2::read::MultiGzDecoder::new(read);
            compressed(request, "gzip", inner)
        }
        Kind::Zstd => {
            let inner = zstd::stream::read::Decoder::new(read)
                .map_err(|error| LogError::read(file, "the zstd stream", error))?;
            compressed(request, "zstd", inner)
        }
        Kind::Text | Kind::Empty => {
            let text = ("its text", Arc::default());
            csv::open(request, text, (&start, is_whole), Box::new(read))
        }
        Kind::Json => json::open(request, read),
        Kind::Npy => arrays::open_npy(request, reopen),
        Kind::Zip => arrays::open_npz(request, reopen),
        #[cfg(feature = "arrow")]
        kind @ (Kind::Parquet | Kind::ArrowFile | Kind::ArrowStream) => {
            arrow::open(request, kind, reopen)
        }
        #[cfg(feature = "mcap")]
        Kind::Mcap => mcap::open(request, Box::new(read)),
        #[cfg(feature = "db3")]
        Kind::Sqlite => db3::open(request, reopen()?),
        Kind::Mat5 => matlab::open(request, reopen),
        #[cfg(feature = "mat73")]
        Kind::Mat73 => mat73::open(request, reopen),
        #[cfg(not(feature = "mat73"))]
        Kind::Mat73 => Err(LogError::format(
            file,
            " is a MATLAB file of version 7.3 (HDF5), which this build of sprung does not read; save it \
             with save(…, \"-v7\"), or install sprung with it: cargo install --path crates/sprung-cli \
             --features mat73",
        )),
        Kind::Other(what) => Err(LogError::format(file, format!(" {what}"))),
        #[cfg(not(all(feature = "arrow", feature = "db3", feature = "mcap")))]
        kind => Err(LogError::format(
            file,
            format!(
                " is {}, which this build of sprung does not read; build it with its default features",
                kind.name()
            ),
        )),
    }
}

/// Opens the text in a compressed file.
fn compressed<R: Read + Send + 'static>(
    request: &Request<'_>,
    method: &str,
    inner: R,
) -> Result<Opened, LogError> {
    let what = format!("its {method} stream");
    let watch = Arc::<Watch>::default();
    let inner = UpToCut::new(inner, Arc::clone(&watch));
    let Beginning {
        start,
        is_whole,
        again: read,
    } = peek(request.file, &what, inner)?;
    match kind_of(&start) {
        Kind::Text | Kind::Empty => {
            csv::open(request, (&what, watch), (&start, is_whole), Box::new(read))
        }
        Kind::Json => json::open(request, read),
        kind => Err(LogError::format(
            request.file,
            format!(
                " is {} compressed with {method}; decompress it, because its parts are not read in order",
                kind.name()
            ),
        )),
    }
}
