//! Findings about a refinement.

use super::channel_updates::ChannelUpdate;
use super::missing_laws::MissingLaw;
use super::refined::Refined;
use super::unknowns::Effect;
use crate::estimate::statistics::between_parts;
use crate::estimate::statistics::kind_of_change;
use crate::estimate::statistics::upper_tail;
use crate::estimate::statistics::{CERTAIN_SIGMAS, FALSE_ALARM_PROBABILITY, SMALL_SHARE};
use crate::finding::{Finding, Severity};
use crate::log::Channels;
use crate::model::{Model, short};
use crate::numbers::{in_ms, in_percent};
use crate::regression::Reading;

/// Maximum number of listed pairs of parameters, and minimum correlation of a listed pair.
const MAX_LISTED_PAIRS: usize = 5;

/// Least correlation of a listed pair.
const LISTED_CORRELATION: f64 = 0.5;

/// Correlation above which the log determines only a combination of two parameters.
const KNOWN_TOGETHER_CORRELATION: f64 = 0.98;

/// A significant delay is reported if it exceeds this fraction of a sample. A smaller delay is harmless.
const MIN_DELAY_SAMPLES: f64 = 0.1;

/// A delay is a warning if it exceeds this fraction of a sample, too. Effects of half a sample may come
/// from the order in which a controller reads and writes.
const LONG_DELAY_SAMPLES: f64 = 0.5;

/// Share above which the disturbance is a warning.
const LARGE_DISTURBANCE_SHARE: f64 = 0.15;

/// Probability of a false alarm below which the saturations of all torques together are reported.
const SATURATION_FALSE_ALARM_PROBABILITY: f64 = 1e-4;

/// Reports the laws that the likelihood asks for, one per joint: the most significant one.
pub(super) fn laws_by_likelihood(
    model: &Model,
    refined: &Refined,
    missing: &[MissingLaw],
) -> Vec<Finding> {
    let of_joint = |joint: usize| {
        let own = missing.iter().filter(|law| law.tested.joint == joint);
        own.filter(|law| law.significance() > CERTAIN_SIGMAS)
            .max_by(|a, b| a.significance().total_cmp(&b.significance()))
    };
    let each = (0..model.joint_count())
        .filter_map(of_joint)
        .filter_map(|law| {
            let joint = &model.joints()[law.tested.joint];
            let (index, moved) = largest_move(refined, &law.moves)?;
            let name = &model.parameters()[index].name;
            let (of, word) = (law.tested.of, law.tested.law);
            let finding = Finding::new(
            if moved > CERTAIN_SIGMAS {
                Severity::Warning
            } else {
                Severity::Info
            },
            "law-by-likelihood",
            format!(
                "{joint}: the likelihood asks for {of} \"{word}\", which the model lacks ({:.1} \
                 standard errors from zero). With it {} would move by {moved:.1} of its standard \
                 errors",
                law.significance(),
                short(name)
            ),
            "set laws = \"auto\", or add the law to the joint; the parameters of this joint \
             contain the effect",
        )
        .about([name.clone()])
        .mended_by("[identify]", "laws = \"auto\"");
            Some(finding)
        });
    each.collect()
}

/// Returns the refined parameter that moves most: index in theta and move in standard errors.
pub(super) fn largest_move(refined: &Refined, moves: &[f64]) -> Option<(usize, f64)> {
    (refined.free.iter().zip(moves))
        .map(|(&index, own)| (index, own.abs() / refined.standard_error[index]))
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the findings about a refinement.
pub(super) fn about(reading: &Reading, period: f64, refined: &Refined) -> Vec<Finding> {
    let model = reading.model();
    let mut findings = Vec::new();
    if refined.left_out {
        findings.push(Finding::new(
            Severity::Info,
            "refined-on-part",
            format!(
                "the refinement used {:.1} s ({} samples) in pieces that are spread evenly over the \
                 logs; more samples need more memory and time",
                refined.duration, refined.samples
            ),
            "set identify.refinement_memory_mib higher, or cut the logs to their exciting parts",
        ));
    }
    findings.extend(late(reading.channels(), period, refined));
    findings.extend(saturating(reading.channels(), refined));
    findings.extend(eccentric(reading.channels(), refined));
    findings.extend(together(model, refined));
    findings.extend(disagree(model, refined));
    let unexplained: Vec<String> = (refined.levels.iter().enumerate())
        .filter(|(_, level)| level.disturbance > SMALL_SHARE * level.torque)
        .map(|(row, level)| {
            let part = in_percent(level.disturbance / level.torque);
            // The row's name ends in the unit.
            format!(
                "{} {:.3} ({part:.0} %)",
                model.row_name(row),
                level.disturbance
            )
        })
        .collect();
    if !unexplained.is_empty() {
        let is_large = (refined.levels.iter())
            .any(|level| level.disturbance > LARGE_DISTURBANCE_SHARE * level.torque);
        findings.push(Finding::new(
            if is_large {
                Severity::Warning
            } else {
                Severity::Info
            },
            "unexplained-torque",
            format!(
                "the model leaves slow torques unexplained; their standard deviations, and the \
                 same relative to the motor torque: {}. The intervals assume random disturbances, \
                 but an effect that repeats with the motion, for example a missing friction law, \
                 may be part of them",
                unexplained.join(", ")
            ),
            "look at the fit over time; try further friction laws, and a second experiment with \
             another motion",
        ));
    }
    findings
}

/// Reports late channels: for each joint the channel with the most significant delay.
fn late(channels: &Channels, period: f64, refined: &Refined) -> Vec<Finding> {
    let delays = &refined.delays;
    let joints = channels.instruments.joint_count();
    let mut findings = Vec::new();
    for delay in delays.iter().filter(|d| d.estimated) {
        findings.push(Finding::new(
            Severity::Info,
            "delay-refined",
            format!(
                "\"{}\" was recorded {:.5} s late, by likelihood (standard error {:.5} s)",
                channels.all[delay.channel].column,
                delay.value(),
                delay.standard_error
            ),
            "give the delay as a number to keep it fixed",
        ));
    }
    for joint in 0..joints {
        let own = |d: &&ChannelUpdate| channels.all[d.channel].joint == joint;
        if delays.iter().filter(own).any(|d| d.estimated) {
            continue;
        }
        let best = delays
            .iter()
            .filter(own)
            .filter(|d| {
                d.significance() > CERTAIN_SIGMAS && d.correction.abs() > MIN_DELAY_SAMPLES * period
            })
            .max_by(|a, b| a.significance().total_cmp(&b.significance()));
        let Some(delay) = best else { continue };
        let column = &channels.all[delay.channel].column;
        let total = delay.value();
        let moved = largest_move(refined, &delay.moves).map_or(0.0, |(_, moved)| moved);
        let is_long = delay.correction.abs() > LONG_DELAY_SAMPLES * period;
        findings.push(Finding::new(
            if is_long && moved > CERTAIN_SIGMAS {
                Severity::Warning
            } else {
                Severity::Info
            },
            "late-channel",
            format!(
                "by likelihood, \"{column}\" was recorded {} instead of {} (standard error {:.5} \
                 s, log-likelihood +{:.0}). With this delay parameters would move by up to \
                 {moved:.1} of their standard errors",
                when(total),
                when(delay.assumed),
                delay.standard_error,
                0.5 * delay.significance().powi(2)
            ),
            &format!("set delay_s = {{ \"{column}\" = \"estimate\" }} in [log]"),
        )
        // The hold-out that follows completes the name of the log.
        .seen("", column, total, "s"));
    }
    findings
}

/// Reports torques whose scale depends on their size.
fn saturating(channels: &Channels, refined: &Refined) -> Vec<Finding> {
    let significant =
        (refined.saturations.iter()).filter(|own| own.significance() > CERTAIN_SIGMAS);
    let each = significant.filter_map(|own| {
        let (_, moved) = largest_move(refined, &own.moves)?;
        let column = &channels.all[own.channel].column;
        let (percent, error) = (in_percent(own.value()), in_percent(own.standard_error));
        let finding = Finding::new(
            if moved > CERTAIN_SIGMAS {
                Severity::Warning
            } else {
                Severity::Info
            },
            "torque-saturates",
            format!(
                "by likelihood, the acting torque grows {} than \"{column}\": at the standard \
                 deviation of the torque the difference is {:.2} % (standard error {error:.2} %), \
                 and it grows with the third power of the torque. With it parameters would move by \
                 up to {moved:.1} of their standard errors",
                if percent > 0.0 { "less" } else { "more" },
                percent.abs(),
            ),
            "measure the torque constant at several currents, or record a motion with smaller \
             torques",
        );
        Some(finding.seen("", column, own.value(), ""))
    });
    let findings: Vec<Finding> = each.collect();
    if (findings.iter()).any(|finding| finding.severity > Severity::Info) {
        return findings;
    }
    (findings.into_iter())
        .chain(all_saturating(channels, refined))
        .collect()
}

/// Reports torques that saturate together, although none of them does so clearly. One motion often shows
/// the saturation of each torque only as another scale of this torque.
fn all_saturating(channels: &Channels, refined: &Refined) -> Option<Finding> {
    let known: Vec<&ChannelUpdate> = (refined.saturations.iter())
        .filter(|own| own.significance().is_finite())
        .collect();
    let squares = known.iter().map(|own| own.significance().powi(2)).sum();
    if known.is_empty() || upper_tail(squares, known.len()) >= SATURATION_FALSE_ALARM_PROBABILITY {
        return None;
    }
    let each: Vec<String> = (known.iter())
        .map(|own| {
            format!(
                "\"{}\" {:.2} ± {:.2} %",
                channels.all[own.channel].column,
                in_percent(own.value()),
                in_percent(own.standard_error)
            )
        })
        .collect();
    Some(Finding::new(
        Severity::Warning,
        "torque-saturates",
        format!(
            "by likelihood, the acting torques do not grow in proportion to the logged ones. They are \
             smaller at the standard deviation of each torque by {}, and the difference grows with the \
             third power of the torque. A log without saturation shows this with a probability below \
             {SATURATION_FALSE_ALARM_PROBABILITY:e}",
            each.join(", ")
        ),
        "measure the torque constants at several currents, or record a motion with smaller torques",
    ))
}

/// Reports link encoders whose readings deviate with the period of one turn.
fn eccentric(channels: &Channels, refined: &Refined) -> Vec<Finding> {
    let clear = |own: &&ChannelUpdate| own.significance() > CERTAIN_SIGMAS;
    let of_encoder = |pair: &[ChannelUpdate]| {
        let own = (pair.iter().filter(clear))
            .max_by(|a, b| a.significance().total_cmp(&b.significance()))?;
        let (_, moved) = largest_move(refined, &own.moves)?;
        let column = &channels.all[own.channel].column;
        let shape = match own.effect {
            Effect::Eccentricity {
                is_cosine: true, ..
            } => "cos",
            Effect::SensorDelay(_)
            | Effect::TorqueDelay(_)
            | Effect::TorquesDelay
            | Effect::Saturation { .. }
            | Effect::Eccentricity { .. } => "sin",
        };
        let finding = Finding::new(
            if moved > CERTAIN_SIGMAS {
                Severity::Warning
            } else {
                Severity::Info
            },
            "eccentric-encoder",
            format!(
                "by likelihood, \"{column}\" deviates from the angle of the link by {:.3} mrad · {shape} q \
                 (standard error {:.3} mrad), as an encoder does whose disc is not centred. With it \
                 parameters would move by up to {moved:.1} of their standard errors",
                in_ms(own.value()),
                in_ms(own.standard_error),
            ),
            "calibrate the encoder over a turn and correct its readings, or use two reading heads",
        );
        Some(finding.seen("", column, own.value(), "rad"))
    };
    (refined.eccentricities.chunks(2).filter_map(of_encoder)).collect()
}

/// Returns the delay in words.
fn when(delay: f64) -> String {
    match delay {
        d if d > 0.0 => format!("{d:.5} s late"),
        d if d < 0.0 => format!("{:.5} s early", -d),
        _ => "on time".to_owned(),
    }
}

/// Reports pairs of parameters of which the log determines only a combination.
fn together(model: &Model, refined: &Refined) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (a, b, correlation) in correlations(refined) {
        if correlation.abs() < KNOWN_TOGETHER_CORRELATION {
            continue;
        }
        let (first, second) = (&model.parameters()[a], &model.parameters()[b]);
        let (known, sign) = if correlation < 0.0 {
            ("sum", '+')
        } else {
            ("difference", '-')
        };
        let (own, other) = (refined.standard_error[a], refined.standard_error[b]);
        let both = (2.0 * own * own * (1.0 - correlation.abs())).sqrt();
        findings.push(
            Finding::new(
                Severity::Info,
                "known-together",
                format!(
                    "the log determines only a {known} of {a} and {b} well (correlation \
                     {correlation:.3}): the standard error of {a} {sign} {:.3} times {b} is {both:.2e} \
                     {}, that of {a} alone {own:.2e}",
                    own / other,
                    first.unit,
                    a = first.short(),
                    b = second.short(),
                ),
                "use both together, or record a motion that excites them separately",
            )
            .about([first.name.clone(), second.name.clone()]),
        );
    }
    findings
}

/// Returns the pairs of parameters with the most strongly correlated errors: indices in theta and
/// correlation.
pub(super) fn correlations(refined: &Refined) -> Vec<(usize, usize, f64)> {
    let width = refined.free.len();
    let at = |i: usize, j: usize| refined.covariance[i * width + j];
    let mut pairs: Vec<(usize, usize, f64)> = (0..width)
        .flat_map(|i| (0..i).map(move |j| (j, i)))
        .map(|(i, j)| {
            let correlation = at(i, j) / (at(i, i) * at(j, j)).sqrt();
            (refined.free[i], refined.free[j], correlation)
        })
        .filter(|pair| pair.2.abs() > LISTED_CORRELATION)
        .collect();
    pairs.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
    pairs.truncate(MAX_LISTED_PAIRS);
    pairs
}

/// Reports the parameters on which several logs disagree.
fn disagree(model: &Model, refined: &Refined) -> Option<Finding> {
    if refined.logs.len() < 2 {
        return None;
    }
    let mut disagreeing = Vec::new();
    let mut names = Vec::new();
    let mut indices = Vec::new();
    for (place, &index) in refined.free.iter().enumerate() {
        let values: Vec<(f64, f64)> = refined.logs.iter().map(|log| log[place]).collect();
        let found = between_parts(&values);
        if found.is_some_and(|found| {
            found.probability < FALSE_ALARM_PROBABILITY / refined.free.len() as f64
        }) {
            let parameter = &model.parameters()[index];
            let each: Vec<String> = (values.iter())
                .map(|(x, e)| format!("{x:.4} ± {e:.4}"))
                .collect();
            disagreeing.push(format!("{} ({})", parameter.short(), each.join(", ")));
            names.push(parameter.name.clone());
            indices.push(index);
        }
    }
    (!disagreeing.is_empty()).then(|| {
        Finding::new(
            Severity::Warning,
            "logs-disagree",
            format!(
                "the logs disagree by more than their intervals allow about {}: one model with one \
                 set of parameters does not describe all of them.{}",
                disagreeing.join("; "),
                kind_of_change(model, &indices)
            ),
            "make sure that all logs are of one robot in one state; parameters that change with \
             the motion or with the controller's gains mean that the model lacks an effect",
        )
        .about(names)
    })
}
