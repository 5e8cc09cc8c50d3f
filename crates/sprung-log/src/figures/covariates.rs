//! Findings about covariates of friction: those that hardly change, and those that change together.

use sprung_core::covariate::Covariate;

use super::summary::Summary;
use crate::columns::channels::Channels;
use crate::finding::{Finding, Severity};

/// A smaller range of a temperature, K, changes friction by few percent only, as about 1 to 2 % per
/// kelvin are usual in gears.
const MIN_TEMPERATURE_RANGE_K: f64 = 2.0;

/// Squared correlation above which one log does not separate two covariates: their standard errors are seven times
/// those of single covariates.
const MAX_SQUARED_CORRELATION: f64 = 0.98;

/// Returns findings about the covariates of a joint.
///
/// - `file`, `name`: of log and joint, for messages.
pub(super) fn covariates(
    (file, name): (&str, &str),
    channels: &Channels,
    summary: &Summary,
    joint: usize,
) -> Vec<Finding> {
    let of_joint = (channels.covariates.iter()).filter(|covariate| covariate.joint == joint);
    let covariates: Vec<(Covariate, Option<usize>)> = of_joint
        .map(|covariate| {
            (
                covariate.covariate,
                channels.of_covariate(covariate.covariate, joint),
            )
        })
        .collect();
    let mut findings = Vec::new();
    for &(covariate, channel) in &covariates {
        // One column may hold for several joints; the first of them reports it.
        if let Some(channel) = channel.filter(|&channel| channels.all[channel].joint == joint) {
            let column = &channels.all[channel].column;
            findings.extend(hardly_changes(
                (file, name),
                (covariate, column),
                summary,
                channel,
            ));
        }
    }
    for (i, &one) in covariates.iter().enumerate() {
        for &other in &covariates[..i] {
            let words = [words(other, channels), words(one, channels)];
            let Some(correlation) = correlation(summary, [other.1, one.1]) else {
                continue;
            };
            if correlation * correlation > MAX_SQUARED_CORRELATION {
                findings.push(together((file, name), &words, correlation));
            }
        }
    }
    findings
}

fn hardly_changes(
    (file, name): (&str, &str),
    (covariate, column): (Covariate, &str),
    summary: &Summary,
    channel: usize,
) -> Option<Finding> {
    let range = summary.extent(channel)?.range();
    let (least, remedy) = match covariate {
        Covariate::Temperature => (
            MIN_TEMPERATURE_RANGE_K,
            "record the joint cold and warm, or identify logs at different temperatures together",
        ),
        Covariate::Time
        | Covariate::Operation
        | Covariate::Age
        | Covariate::Cycles
        | Covariate::Other => (
            f64::MIN_POSITIVE,
            "identify several logs together, recorded at different values of the column",
        ),
    };
    let unit = covariate.unit_of_changes();
    (range < least).then(|| {
        Finding::new(
            Severity::Info,
            "covariate-hardly-changes",
            format!(
                "{name}: \"{column}\" changes by {range:.2} {unit} in {file}: this log alone cannot tell the \
                 change of friction with it"
            ),
            remedy,
        )
        .seen(file, column, range, unit)
    })
}

fn together((file, name): (&str, &str), words: &[String; 2], correlation: f64) -> Finding {
    let [one, other] = words;
    Finding::new(
        Severity::Info,
        "covariates-change-together",
        format!(
            "{name}: {one} and {other} change together in {file} (correlation {correlation:.3}): this log \
             alone cannot tell which of them changes friction"
        ),
        "add a log in which they change differently, such as one after a pause, or keep one of them in \
         friction_covariates",
    )
    .seen(file, "", correlation, "")
}

/// Returns the name of a covariate with its column.
fn words((covariate, channel): (Covariate, Option<usize>), channels: &Channels) -> String {
    let word = covariate.word();
    match channel {
        Some(channel) => format!("{word} (\"{}\")", channels.all[channel].column),
        None => word.to_owned(),
    }
}

/// Returns the correlation of two covariates over the parts of a log; `None` if one of them is constant.
///
/// - `channels`: their channels; `None` for the time.
fn correlation(summary: &Summary, channels: [Option<usize>; 2]) -> Option<f64> {
    let times = &summary
        .figures(channels.into_iter().flatten().next()?)?
        .overview()
        .time;
    let [x, y] = channels.map(|channel| match channel {
        None => Some(times.clone()),
        Some(channel) => {
            let parts = &summary.figures(channel)?.overview().between;
            Some(parts.iter().map(|[low, high]| 0.5 * (low + high)).collect())
        }
    });
    let [x, y] = [centred(&x?), centred(&y?)];
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = (product(&x, &x) * product(&y, &y)).sqrt();
    (scale > 0.0).then(|| product(&x, &y) / scale)
}

/// Returns values minus their mean.
fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|value| value - mean).collect()
}
