//! What a log does not say of itself: the search, then laws that are judged in earnest.

use super::confirmed_laws::presliding;
use super::searched::{Settled, applied, searched, told};
use super::spring_rivals::with_springs;
use crate::prepare::{PrepareError, Prepared};
use crate::progress::Listener;

/// Finds the unknowns of the first log and applies those that need no decision of the user: delays, the zero between two encoders,
/// and laws.
///
/// # Errors
///
/// As of [`prepare`](crate::prepare::prepare), but for those of reading.
pub(crate) fn settled(
    prepared: Prepared,
    progress: &mut dyn Listener,
) -> Result<Settled, PrepareError> {
    // Vibrations of springs that the model leaves out on purpose look like delays.
    let leaves_out_springs = prepared.reading().settings().springs_from_motor;
    if prepared.wrong_time_unit().is_some() || leaves_out_springs {
        return Ok(Settled::without(prepared));
    }
    let Some(alone) = searched(&prepared, progress)? else {
        return Ok(Settled::without(prepared));
    };
    let springs = with_springs(prepared, alone, progress)?;
    let alone = springs.found;
    let presliding = presliding(&alone.prepared, springs.columns.as_ref());
    let (laws, about) = told(&presliding, &alone.prepared);
    let with = |other: Prepared, progress: &mut dyn Listener| {
        applied(other, (&presliding, &laws), progress)
    };
    // Without this friction its shadows are found: delays, other laws.
    let again = if alone.unknowns.is_empty() || presliding.is_empty() {
        None
    } else {
        searched(&with(springs.base, progress)?, progress)?
    };
    let mut all = match again {
        Some(again) => again,
        None => Settled {
            prepared: with(alone.prepared, progress)?,
            ..alone
        },
    };
    all.unknowns.extend(laws.into_iter().chain(springs.laws));
    let findings = about.findings.into_iter().chain(springs.findings);
    all.about.findings.extend(findings);
    Ok(all)
}
