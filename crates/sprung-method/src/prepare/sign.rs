//! Signs of columns, from the torque equation of each joint.

use super::estimated_columns::FoundSign;
use super::excerpt::Excerpt;
use super::row::{OfRow, RowFit, fit_rows, independent};
use crate::description::Delay;
use crate::log::{Channels, Quantity};
use crate::regression::Reading;

/// Log-likelihood ratio at which a sign counts as determined: a thousand to one.
const MIN_LOG_LIKELIHOOD_RATIO: f64 = 6.9;

/// Limit of the signs that are tried together; each sign doubles the work.
const MAX_SIGNS_TOGETHER: usize = 10;

/// Residuals below this fraction of the torque count as equal.
const MIN_RESIDUAL_SHARE: f64 = 1e-4;

/// Delays that are tried with each choice of signs, in steps of so many seconds, and samples in a step.
const DELAY_STEP_S: f64 = 0.01;
const SAMPLES_PER_DELAY_STEP: f64 = 2.5;
const EARLIEST_STEPS: i32 = -5;
const LATEST_STEPS: i32 = 50;

/// Finds all open signs; the error names the sign that the log does not determine, and a remedy.
pub(super) fn signs(
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
) -> Result<Vec<FoundSign>, String> {
    let channels = reading.channels();
    let joints = reading.model().joint_count();
    let open = |joint: usize| {
        let is_open = move |&i: &usize| channels.all[i].joint == joint && channels.all[i].open_sign;
        (0..channels.all.len()).filter(is_open)
    };
    for joint in 0..joints {
        let all = channels.all.iter().filter(|c| c.joint == joint).count();
        if all > 0 && open(joint).count() == all {
            let name = &reading.model().joints()[joint];
            return Err(format!(
                "the signs of all columns of {name} are to be estimated, but reversing all of them fits \
                 equally well; choose the positive direction: give one of them as 1 or -1 in sign"
            ));
        }
    }
    // The rows of rigid joints and coupled transmissions contain positions of other joints.
    let together = channels.position_mix.is_some()
        || channels.torque_mix.is_some()
        || (0..joints).any(|joint| !reading.model().is_flexible(joint) && open(joint).count() > 0);
    let groups: Vec<Vec<usize>> = if together {
        vec![(0..joints).collect()]
    } else {
        (0..joints).map(|joint| vec![joint]).collect()
    };
    let mut found = Vec::new();
    for rows in groups {
        let wanted: Vec<usize> = rows.iter().flat_map(|&joint| open(joint)).collect();
        if wanted.len() > MAX_SIGNS_TOGETHER {
            return Err(format!(
                "{} signs of joints that move each other are to be estimated, at most {MAX_SIGNS_TOGETHER} can be; \
                 give the others as 1 or -1 in sign",
                wanted.len()
            ));
        }
        if !wanted.is_empty() {
            found.extend(decide(reading, excerpt, file, &rows, &wanted)?);
        }
    }
    Ok(found)
}

/// Fits of some joints' rows with one choice of signs.
struct Trial {
    turned: Vec<bool>,
    /// Logarithm of the likelihood without its constant.
    score: f64,
    fits: Vec<RowFit>,
}

fn decide(
    reading: &Reading,
    excerpt: &Excerpt,
    file: &str,
    rows: &[usize],
    wanted: &[usize],
) -> Result<Vec<FoundSign>, String> {
    let number = independent(excerpt, reading);
    let trials: Vec<Trial> = (0..1_usize << wanted.len())
        .filter_map(|bits| {
            let turned: Vec<bool> = (0..wanted.len()).map(|k| bits >> k & 1 == 1).collect();
            let mut tried = excerpt.clone();
            for (&channel, _) in wanted.iter().zip(&turned).filter(|(_, turned)| **turned) {
                tried = tried.scaled(channel, -1.0);
            }
            let fits = fit_rows(&tried, &with_open_delays(&tried, reading, rows), rows)?;
            let score = fits.iter().map(|fit| score(fit, reading, number)).sum();
            Some(Trial {
                turned,
                score,
                fits,
            })
        })
        .filter(|trial| trial.score.is_finite())
        .collect();
    let best = trials.iter().max_by(|a, b| a.score.total_cmp(&b.score));
    let column = |k: usize| &reading.channels().all[wanted[k]].column;
    let Some(best) = best else {
        return Err(format!(
            "the sign of \"{}\" cannot be determined from {file}: its joint does not move, or the log is \
             too short for the filters; give it as 1 or -1 in sign",
            column(0)
        ));
    };
    (0..wanted.len())
        .map(|k| {
            let other = (trials.iter())
                .filter(|trial| trial.turned[k] != best.turned[k])
                .max_by(|a, b| a.score.total_cmp(&b.score));
            let ahead = other.map_or(0.0, |other| best.score - other.score);
            let joint = reading.channels().all[wanted[k]].joint;
            let place = rows.iter().position(|&row| row == joint).unwrap_or(0);
            if ahead < MIN_LOG_LIKELIHOOD_RATIO {
                return Err(format!(
                    "the sign of \"{}\" cannot be determined from {file}: the equation of {} fits about \
                     equally well with the other sign (log-likelihood +{ahead:.1}, {MIN_LOG_LIKELIHOOD_RATIO} is needed); \
                     give it as 1 or -1 in sign, or log a motion with more accelerations and reversals",
                    column(k),
                    reading.model().joints()[joint]
                ));
            }
            Ok(FoundSign {
                column: column(k).clone(),
                value: if best.turned[k] { -1.0 } else { 1.0 },
                log_likelihood: ahead,
                because: evidence(
                    reading,
                    excerpt,
                    joint,
                    [&best.fits[place], other.map_or(&best.fits[place], |o| &o.fits[place])],
                ),
            })
        })
        .collect()
}

/// Returns a reading with coarse delays of the channels that the description leaves open: each choice of signs is tried with its best
/// delays.
fn with_open_delays(excerpt: &Excerpt, reading: &Reading, rows: &[usize]) -> Reading {
    let all = reading.channels().all.iter().enumerate();
    let open = all.filter(|(_, channel)| {
        channel.delay == Some(Delay::Estimate) && rows.contains(&channel.joint)
    });
    let few = excerpt.thinned_for(reading, DELAY_STEP_S / SAMPLES_PER_DELAY_STEP);
    let left = |reading: &Reading| {
        let fits = fit_rows(&few, reading, rows)?;
        let score = |fit: &RowFit| score(fit, reading, independent(&few, reading));
        Some(fits.iter().map(score).sum::<f64>())
    };
    open.fold(reading.clone(), |reading, (channel, _)| {
        let tried = (EARLIEST_STEPS..=LATEST_STEPS).filter_map(|steps| {
            let mut delays = reading.delays().to_vec();
            delays[channel] = f64::from(steps) * DELAY_STEP_S;
            let late = reading.with_delays(&delays);
            // With a long delay a short log can have too few samples.
            Some((left(&late)?, late))
        });
        let best = tried.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or(reading, |(_, late)| late)
    })
}

/// Logarithm of the likelihood of a row's residual, plus that of the probability that its physical
/// parameters are positive.
fn score(fit: &RowFit, reading: &Reading, independent: f64) -> f64 {
    let positive: f64 = physical(fit, reading, independent)
        .map(|of| log_positive(of.value / of.error))
        .sum();
    positive - independent * fit.relative_residual().max(MIN_RESIDUAL_SHARE).ln()
}

/// Parameters that are positive in every robot.
fn physical(fit: &RowFit, reading: &Reading, independent: f64) -> impl Iterator<Item = OfRow> {
    let all = fit.of_joints(reading.model(), independent);
    all.into_iter()
        .filter(|of| of.kind.is_vital() || of.kind.is_friction())
}

/// Logarithm of the probability that a quantity is positive whose estimate is `z` standard errors.
fn log_positive(z: f64) -> f64 {
    if z < -5.0 {
        // Asymptotic tail of the normal distribution.
        -0.5 * z * z - (-z).ln() - 0.919
    } else {
        (0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)).ln()
    }
}

/// Describes the evidence for a sign: negative parameters, residuals, and the correlation of both
/// positions.
fn evidence(reading: &Reading, excerpt: &Excerpt, joint: usize, fits: [&RowFit; 2]) -> String {
    let number = independent(excerpt, reading);
    let [with, other] = fits.map(|fit| {
        let negative: Vec<&str> = physical(fit, reading, number)
            .filter(|of| of.value < 0.0)
            .map(|of| of.kind.name())
            .collect();
        let signs = if negative.is_empty() {
            "no parameter is negative".to_owned()
        } else {
            format!("{} would be negative", negative.join(", "))
        };
        format!(
            "{signs} and {:.1} % of the torque",
            100.0 * fit.relative_residual()
        )
    });
    let name = &reading.model().joints()[joint];
    let both = correlation(reading.channels(), excerpt, joint).map_or_else(String::new, |r| {
        format!(" (correlation of the recorded positions {r:+.3})")
    });
    format!("in the equation of {name} {with} is unexplained, with the other sign {other}{both}")
}

/// Correlation of the recorded link and motor positions.
fn correlation(channels: &Channels, excerpt: &Excerpt, joint: usize) -> Option<f64> {
    let link = channels.index(Quantity::LinkPosition, joint)?;
    let motor = channels.index(Quantity::MotorPosition, joint)?;
    let mean = |channel| excerpt.channel(channel).sum::<f64>() / excerpt.samples().max(1) as f64;
    let (of_link, of_motor) = (mean(link), mean(motor));
    let (mut both, mut one, mut two) = (0.0, 0.0, 0.0);
    for (a, b) in excerpt.channel(link).zip(excerpt.channel(motor)) {
        let (a, b) = (a - of_link, b - of_motor);
        both += a * b;
        one += a * a;
        two += b * b;
    }
    let correlation = both / (one * two).sqrt();
    correlation.is_finite().then_some(correlation)
}
