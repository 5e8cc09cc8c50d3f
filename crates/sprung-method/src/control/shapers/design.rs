//! From the regions of modes to a shaper.

use rayon::prelude::*;
use sprung_core::shaper::{LONGEST_DELAY, Mode};

use super::centre::{Candidate, best};
use super::combine::{Evaluated, Problem};
use super::region::Region;
use super::result::{ModeShaper, ShapedImpulse, ShaperDesign};

/// Most modes of one shaper.
const MOST_MODES: usize = 4;

/// Numbers of impulses for one mode.
pub(super) const IMPULSES: [usize; 4] = [2, 3, 4, 5];

/// Settings of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaperSettings {
    /// Allowed residual vibration, as a part of that without shaper, in (0, 1).
    pub level: f64,
    /// Part of each region that must keep the level, in (0, 1]. At 1 all points count.
    pub part: f64,
    /// Sampling period of the filter, s, positive.
    pub period: f64,
}

impl ShaperSettings {
    /// Returns the settings for a residual of 5 % at all points.
    ///
    /// - `period`: sampling period of the filter, s.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            level: 0.05,
            part: 1.0,
            period,
        }
    }
}

/// Why there is no design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShaperDesignError {
    /// There is no mode, or there are too many.
    #[error("a shaper is for 1 to {limit} modes, not for {found}")]
    Modes {
        /// Number of modes.
        found: usize,
        /// Largest number.
        limit: usize,
    },
    /// The region of a mode has no point.
    #[error("the region of mode {} has no point", mode + 1)]
    EmptyRegion {
        /// Index of the mode.
        mode: usize,
    },
    /// A setting is outside its range.
    #[error("the {name} of the shaper is {value}; it must be {range}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// All sequences are too long for the filter.
    #[error(
        "the shaper would be longer than {limit} samples; the modes are too slow for the sampling period"
    )]
    TooLong {
        /// Longest delay of the filter, samples.
        limit: usize,
    },
}

/// Designs the shortest shaper whose residual vibration keeps a level over the regions of all modes.
///
/// - `regions`: possible values of each mode, such as draws from the estimate at several poses; one to four modes.
///
/// For each mode and number of impulses, the centre of the sequence minimises the largest residual over the region, and
/// so does the level of its humps. Of all combinations of one sequence per mode the shortest that keeps the level is
/// chosen. All residuals are those of the sampled sequence. If no combination keeps the level, the design is the one
/// with the least residual, and [`ShaperDesign::reached`] is false.
///
/// # Errors
///
/// [`ShaperDesignError`] if a setting is outside its range, a region is empty, the number of modes is not 1 to 4, or the
/// modes are too slow for the sampling period.
///
/// # Source
///
/// singer1990 for the residual and the convolution for several modes, singhose1994 and singhose1997 for the
/// extra-insensitive sequences.
pub fn design_shaper(
    regions: &[Vec<Mode>],
    settings: &ShaperSettings,
) -> Result<ShaperDesign, ShaperDesignError> {
    check(regions, settings)?;
    let regions: Vec<Region> = (regions.iter())
        .map(|points| Region {
            points: points.clone(),
            part: settings.part,
        })
        .collect();
    let candidates: Vec<Vec<Candidate>> = (regions.iter())
        .map(|region| {
            (IMPULSES.into_par_iter())
                .filter_map(|impulses| best(impulses, region, settings.level, settings.period))
                .collect()
        })
        .collect();
    let problem = Problem {
        regions: &regions,
        candidates: &candidates,
        level: settings.level,
        period: settings.period,
    };
    let chosen = problem.choose().ok_or(ShaperDesignError::TooLong {
        limit: LONGEST_DELAY,
    })?;
    Ok(described(&chosen, &candidates, settings))
}

fn check(regions: &[Vec<Mode>], settings: &ShaperSettings) -> Result<(), ShaperDesignError> {
    let ShaperSettings {
        level,
        part,
        period,
    } = *settings;
    for (name, value, range, kept) in [
        (
            "level",
            level,
            "between 0 and 1",
            level > 0.0 && level < 1.0,
        ),
        (
            "part",
            part,
            "above 0 and at most 1",
            part > 0.0 && part <= 1.0,
        ),
        (
            "sampling period",
            period,
            "positive and finite",
            period > 0.0 && period.is_finite(),
        ),
    ] {
        if !kept {
            return Err(ShaperDesignError::Setting { name, value, range });
        }
    }
    if !(1..=MOST_MODES).contains(&regions.len()) {
        return Err(ShaperDesignError::Modes {
            found: regions.len(),
            limit: MOST_MODES,
        });
    }
    match regions.iter().position(Vec::is_empty) {
        Some(mode) => Err(ShaperDesignError::EmptyRegion { mode }),
        None => Ok(()),
    }
}

fn described(
    chosen: &Evaluated,
    candidates: &[Vec<Candidate>],
    settings: &ShaperSettings,
) -> ShaperDesign {
    let modes = (candidates.iter().zip(&chosen.members).zip(&chosen.modes))
        .map(|((candidates, member), residuals)| {
            let candidate = &candidates[*member];
            ModeShaper {
                impulses: candidate.sequence.len(),
                centre_hz: candidate.centre.hz(),
                damping: candidate.centre.damping(),
                hump_percent: candidate.hump.map(|hump| 100.0 * hump),
                largest_percent: 100.0 * residuals.largest,
                median_percent: 100.0 * residuals.median,
            }
        })
        .collect();
    let impulse = |impulse: &sprung_core::shaper::Impulse| ShapedImpulse {
        time_s: impulse.time,
        amplitude: impulse.amplitude,
    };
    ShaperDesign {
        reached: chosen.all.largest <= settings.level,
        level_percent: 100.0 * settings.level,
        period_s: settings.period,
        modes,
        impulses: chosen.sequence.iter().map(impulse).collect(),
        delay_s: chosen.delay,
        largest_percent: 100.0 * chosen.all.largest,
        median_percent: 100.0 * chosen.all.median,
    }
}
