//! Findings about the sampling of a log.

use super::cycle::JITTER_LIMIT;
use super::timing::{Count, Evidence, Sampling, Timing};
use crate::columns::channel::Channel;
use crate::columns::channels::Channels;
use crate::columns::origin::TimeOrigin;
use crate::description::{ColumnName, Delay};
use crate::error::Place;
use crate::finding::{Finding, Severity};

/// Fraction of the samples above which a count is a warning.
const WARNING_PART: f64 = 0.01;

/// Usual range of sampling rates of robots, Hz, and the range beyond which a rate is impossible.
const USUAL_RATES_HZ: std::ops::RangeInclusive<f64> = 10.0..=5e4;
const POSSIBLE_RATES_HZ: std::ops::RangeInclusive<f64> = 2.0..=5e5;

/// Rate, Hz, that is preferred if several units give a usual rate.
const LIKELIEST_RATE_HZ: f64 = 1e3;

/// Extent of a window beyond its log, in periods, that a finding reports: a log of 60 s ends one
/// period before 60 s.
const MAX_BEYOND_PERIODS: f64 = 1.5;

/// Units of time: name and size in s.
const TIME_UNITS: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];

/// Returns findings about the sampling of a log.
///
/// - `file`: name for messages.
///
/// Gaps give no finding here, because their cost depends on the filters.
#[must_use]
pub fn check_timing(file: &str, channels: &Channels, timing: &Timing) -> Vec<Finding> {
    let mut findings = Vec::new();
    findings.extend(time_unit(file, channels, timing.period));
    findings.extend(uneven(file, channels, timing));
    findings.extend(beyond(file, timing));
    findings.extend(counted(
        file,
        "dropped-samples",
        &timing.dropped,
        timing,
        format!(
            "{file} lacks {}, at most three in a row{}; sprung interpolated them",
            samples(&timing.dropped),
            first(&timing.dropped)
        ),
        "check that the recorder is fast enough; a few missing samples need no action",
    ));
    findings.extend(counted(
        file,
        "repeated-samples",
        &timing.repeated,
        timing,
        format!(
            "{file} contains {} twice, with the same time and the same values{}; sprung ignored the \
             repetitions",
            samples(&timing.repeated),
            first(&timing.repeated)
        ),
        "check that the recorder writes each sample once; the log needs no change",
    ));
    findings.extend(counted(
        file,
        "samples-without-value",
        &timing.lacking,
        timing,
        format!(
            "in {file} {} no value in some column{}; sprung left them out, as nan = \"gap\" asks",
            match timing.lacking.count {
                1 => "1 sample has".to_owned(),
                count => format!("{count} of {} samples have", count + timing.recorded),
            },
            first(&timing.lacking)
        ),
        "check why the recorder writes no value; a few such samples need no action",
    ));
    findings.extend(counted(
        file,
        "frozen-samples",
        &timing.frozen,
        timing,
        format!(
            "in {file} {} all values of the preceding sample although a joint moves{}: the \
             recorder was faster than its source, or missed an update",
            match timing.frozen.count {
                1 => "1 sample repeats".to_owned(),
                count => format!("{count} samples repeat"),
            },
            first(&timing.frozen)
        ),
        "record at the rate of the controller, or remove these samples: sprung interpolates missing \
         samples",
    ));
    findings.extend(timing.beyond.cut.map(|place| cut_off(file, place, timing)));
    findings
}

/// Returns the finding about a recording that ends in the middle of a row.
fn cut_off(file: &str, place: Place, timing: &Timing) -> Finding {
    Finding::new(
        Severity::Warning,
        "log-cut-off",
        format!(
            "{file} ends in the middle of {place}: the recorder lost power, or the file was not copied completely; \
             sprung read the {} samples before it",
            timing.recorded
        ),
        "compare the length with that of the file on the recorder; if this is all, the log needs no change",
    )
    .seen(file, "", timing.recorded as f64, "samples")
}

/// Code of the finding that the time has another unit.
pub const TIME_UNIT: &str = "time-unit";

/// Returns a finding if the sampling rate is unusual but would be usual with another unit of time.
/// The finding is an error if the rate is impossible.
///
/// - `file`: name for messages.
/// - `period`: T as the log is read, s.
#[must_use]
pub fn time_unit(file: &str, channels: &Channels, period: f64) -> Option<Finding> {
    let rate = 1.0 / period;
    if USUAL_RATES_HZ.contains(&rate) || !(rate.is_finite() && rate > 0.0) {
        return None;
    }
    let off = |rate: f64| (rate / LIKELIEST_RATE_HZ).ln().abs();
    let (unit, size, likely) = (TIME_UNITS.iter())
        .map(|&(unit, size)| (unit, size, rate * channels.time.factor / size))
        .filter(|(_, _, rate)| USUAL_RATES_HZ.contains(rate))
        .min_by(|a, b| off(a.2).total_cmp(&off(b.2)))?;
    let (what, line) = match (&channels.time.origin, &channels.time.stream) {
        // Times of messages have a fixed unit.
        (TimeOrigin::Messages, _) => return None,
        (TimeOrigin::Period(_), _) => (
            "period_s".to_owned(),
            format!("period_s = {}", rounded(period * size)),
        ),
        (TimeOrigin::Column(column), None) => {
            let line = match column {
                ColumnName::Name(name) => format!("time_{unit} = {name:?}"),
                ColumnName::Number(number) => format!("time_{unit} = {number}"),
            };
            (format!("\"{column}\""), line)
        }
        (TimeOrigin::Column(column), Some(_)) => {
            (format!("\"{column}\""), format!("time.unit = \"{unit}\""))
        }
    };
    let severity = if POSSIBLE_RATES_HZ.contains(&rate) {
        Severity::Warning
    } else {
        Severity::Error
    };
    let finding = Finding::new(
        severity,
        TIME_UNIT,
        format!(
            "{file}: {what}, as declared, gives {} samples per second, which is unusual for a robot; \
             in {unit} it would give {}",
            rounded(rate),
            rounded(likely)
        ),
        "replace the present key of the time by a key with the right unit",
    );
    let column = match &channels.time.origin {
        TimeOrigin::Column(column) => column.to_string(),
        TimeOrigin::Period(_) | TimeOrigin::Messages => String::new(),
    };
    Some((finding.seen(file, &column, rate, "Hz")).mended_by("[log]", &line))
}

/// Returns a finding if the window of a log extends beyond the log.
fn beyond(file: &str, timing: &Timing) -> Option<Finding> {
    let beyond = timing.beyond;
    let far = |time: f64| time > MAX_BEYOND_PERIODS * timing.period;
    let mut parts = Vec::new();
    if far(beyond.before) {
        parts.push(format!(
            "begins {} s before the first sample",
            rounded(beyond.before)
        ));
    }
    if far(beyond.after) {
        parts.push(format!(
            "ends {} s after the last sample",
            rounded(beyond.after)
        ));
    }
    if beyond.samples_after > 0 {
        parts.push(format!(
            "ends {} samples after the last one",
            beyond.samples_after
        ));
    }
    (!parts.is_empty()).then(|| {
        Finding::new(
            Severity::Info,
            "window-beyond-log",
            format!(
                "the window of {file} {}; sprung read the {} samples that exist",
                parts.join(" and "),
                timing.recorded
            ),
            "check the window, if the log should be longer",
        )
        .seen(file, "", beyond.before.max(beyond.after), "s")
    })
}

fn samples(count: &Count) -> String {
    match count.count {
        1 => "1 sample".to_owned(),
        count => format!("{count} samples"),
    }
}

fn first(count: &Count) -> String {
    count
        .first
        .map_or_else(String::new, |place| format!(", first at {place}"))
}

/// Returns a finding if the count is not zero; a warning if the count is high.
fn counted(
    file: &str,
    code: &str,
    count: &Count,
    timing: &Timing,
    message: String,
    remedy: &str,
) -> Option<Finding> {
    let many = count.count as f64 > WARNING_PART * timing.recorded as f64;
    let severity = if many {
        Severity::Warning
    } else {
        Severity::Info
    };
    (count.count > 0).then(|| {
        let finding = Finding::new(severity, code, message, remedy);
        finding.seen(file, "", count.count as f64, "samples")
    })
}

fn uneven(file: &str, channels: &Channels, timing: &Timing) -> Option<Finding> {
    let (evidence, sampling) = (timing.evidence?, timing.sampling?);
    // Even sampling with small jitter needs no finding: the stamps merely have few digits.
    if sampling == Sampling::Even && timing.jitter.largest <= JITTER_LIMIT {
        return None;
    }
    let steps = format!(
        "{file}: steps between time stamps differ from the period of {:.4} ms by up to {:.0} % ({:.1} % \
         RMS)",
        1e3 * timing.period,
        100.0 * timing.jitter.largest,
        100.0 * timing.jitter.rms
    );
    let outcome = format!(
        "{} of {} samples were interpolated",
        timing.interpolated, timing.recorded
    );
    let seen = |finding: Finding| finding.seen(file, "", 100.0 * timing.jitter.largest, "%");
    if !evidence.decisive {
        return Some(seen(Finding::new(
            Severity::Warning,
            "uneven-sampling",
            format!(
                "{steps}, and the positions do not show whether samples were taken at these times; \
                 sprung treats them as {}. {outcome}{}",
                match sampling {
                    Sampling::AsStamped => "taken when stamped",
                    Sampling::Even | Sampling::OnCycle(_) => "evenly spaced",
                },
                if has_one_reference(channels) {
                    ". delay_s opens all channels of a joint but one, so their delays contain the errors of these times"
                } else {
                    ""
                }
            ),
            "set in [log] sampling = \"as-stamped\", or \"even\" if stamps are rounded or late",
        )));
    }
    let (how, line) = match sampling {
        Sampling::AsStamped => (
            "were taken when stamped".to_owned(),
            "sampling = \"as-stamped\"".to_owned(),
        ),
        Sampling::Even => (
            "are even, and stamps are late".to_owned(),
            "sampling = \"even\"".to_owned(),
        ),
        Sampling::OnCycle(cycle) => (
            format!(
                "were taken on a cycle of {:.4} ms, and stamps are late",
                1e3 * cycle
            ),
            format!("period_s = {} beside the time", rounded(cycle)),
        ),
    };
    Some(seen(Finding::new(
        Severity::Info,
        "uneven-sampling",
        format!(
            "{steps}. Samples {how}: {}. {outcome}",
            evidence_text(channels, &evidence)
        ),
        &format!("no action is needed; {line} in [log] would declare it"),
    )))
}

/// Returns whether a description opens the delays of all channels of a joint but one, and of at least two.
fn has_one_reference(channels: &Channels) -> bool {
    (0..channels.turns.len()).any(|joint| {
        let is_open = |channel: &Channel| channel.delay == Some(Delay::Estimate);
        let are_open: Vec<bool> = (channels.all.iter())
            .filter(|channel| channel.joint == joint)
            .map(is_open)
            .collect();
        are_open.len() > 2 && are_open.iter().filter(|open| !**open).count() == 1
    })
}

/// Returns a text about the evidence.
fn evidence_text(channels: &Channels, evidence: &Evidence) -> String {
    let channel = channels.all.get(evidence.channel);
    let unit = channel.map_or("rad", |channel| {
        channel.quantity.unit(channels.turns[channel.joint])
    });
    let (cycle, on_cycle) = evidence.on_cycle;
    format!(
        "at {} uneven steps, the RMS distance of \"{}\" from the cubic through its neighbours is \
         {:.1e} {unit} for the stamped times, {:.1e} for even times and {on_cycle:.1e} for multiples \
         of {:.4} ms",
        evidence.samples,
        channel.map_or("", |channel| &channel.column),
        evidence.stamped,
        evidence.even,
        1e3 * cycle
    )
}

/// Returns a number rounded to four significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use sprung_testing::Messages;

    use super::*;
    use crate::clock::timing::Jitter;
    use crate::description::{no_files, read};
    use crate::error::Place;

    fn channels() -> Channels {
        let text = "format = 1\n[robot]\nname = \"one\"\ndh_modified = [{}]\n[[robot.joint]]\nname = \"j\"\n\
                    [log]\ntime_s = \"t\"\nlink_position_rad = [\"q\"]\nmotor_position_rad = [\"phi\"]\n\
                    motor_torque_nm = [\"tau\"]\n";
        let experiment = read("experiment.toml", text, &[], &mut no_files).unwrap();
        Channels::new(&experiment.robot, experiment.log.as_ref().unwrap()).unwrap()
    }

    fn evidence(decisive: bool) -> Evidence {
        Evidence {
            samples: 100,
            channel: 1,
            stamped: 4e-5,
            even: 7e-5,
            on_cycle: (1.999_996e-3, 1.5e-5),
            decisive,
        }
    }

    #[test]
    fn windows_beyond_the_log_are_reported() {
        let timing = |after: f64| Timing {
            period: 1e-3,
            recorded: 1000,
            beyond: crate::Beyond {
                after,
                ..crate::Beyond::default()
            },
            ..Timing::default()
        };
        let finding = beyond("run.csv (to 60 s)", &timing(59.0)).unwrap();
        assert_eq!(finding.code, "window-beyond-log");
        assert_eq!(beyond("run.csv (to 1 s)", &timing(1e-3)), None);
    }

    #[test]
    fn delays_of_all_channels_rest_on_uneven_stamps() {
        let timing = Timing {
            period: 2e-3,
            jitter: Jitter {
                largest: 0.4,
                ..Jitter::default()
            },
            sampling: Some(Sampling::AsStamped),
            evidence: Some(evidence(false)),
            ..Timing::default()
        };
        let words = "contain the errors of these times";
        let mut channels = channels();
        for (open, is_told) in [(0, false), (1, false), (2, true)] {
            for channel in channels.all.iter_mut().take(open) {
                channel.delay = Some(Delay::Estimate);
            }
            let finding = uneven("log.csv", &channels, &timing).unwrap();
            assert_eq!(finding.text.contains(words), is_told, "{}", finding.text);
        }
    }

    #[test]
    fn an_unusual_rate_suggests_another_unit() {
        let channels = channels();
        let told = |period| {
            let finding = time_unit("log.csv", &channels, period)?;
            Some((finding.severity, finding.setting?))
        };
        let line = |severity, line: &str| Some((severity, format!("[log] {line}")));
        // Sampling at 1 kHz with times in ms, µs and ns, and at 5 kHz with times in ms.
        assert_eq!(told(1.0), line(Severity::Error, "time_ms = \"t\""));
        assert_eq!(told(1e3), line(Severity::Error, "time_us = \"t\""));
        assert_eq!(told(1e6), line(Severity::Error, "time_ns = \"t\""));
        assert_eq!(told(0.2), line(Severity::Warning, "time_ms = \"t\""));
        for period in [0.1, 0.02, 1e-3, 2.5e-5, 0.0, f64::NAN] {
            assert_eq!(told(period), None, "{period}");
        }
        let mut channels = channels.clone();
        channels.time.factor = 1e-3;
        let finding = time_unit("log.csv", &channels, 1e-6).unwrap();
        assert_eq!(finding.setting.as_deref(), Some("[log] time_s = \"t\""));
        channels.time.origin = TimeOrigin::Period(5.0);
        channels.time.factor = 1.0;
        let finding = time_unit("log.csv", &channels, 5.0).unwrap();
        assert_eq!(finding.setting.as_deref(), Some("[log] period_s = 0.005"));
    }

    #[test]
    fn counts_give_findings_and_high_counts_warn() {
        let of = |count| Count {
            count,
            first: Some(Place::Line(7)),
        };
        let timing = Timing {
            recorded: 1000,
            sampling: Some(Sampling::Even),
            dropped: of(1),
            repeated: of(10),
            frozen: of(11),
            ..Timing::default()
        };
        let findings = check_timing("log.csv", &channels(), &timing);
        let told: Vec<(&str, Severity)> = (findings.iter())
            .map(|finding| (finding.code.as_str(), finding.severity))
            .collect();
        assert_eq!(
            told,
            [
                ("dropped-samples", Severity::Info),
                ("repeated-samples", Severity::Info),
                ("frozen-samples", Severity::Warning),
            ]
        );
        let quiet = Timing {
            recorded: 1000,
            sampling: Some(Sampling::Even),
            jitter: Jitter {
                largest: 0.09,
                ..Jitter::default()
            },
            evidence: Some(evidence(true)),
            ..Timing::default()
        };
        assert!(check_timing("log.csv", &channels(), &quiet).is_empty());
    }

    #[test]
    fn texts_of_findings_are_in_a_file() {
        let mut messages = Messages::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/messages/clock.txt"
        ));
        let mut note = |case: &str, finding: &Finding| {
            let remedy = &finding.remedy;
            messages.note(case, &format!("{}\n{remedy}", finding.text));
        };
        let channels = channels();
        let timing = |sampling, decisive| Timing {
            recorded: 1000,
            period: 4e-3,
            jitter: Jitter {
                largest: 0.9,
                ..Jitter::default()
            },
            sampling: Some(sampling),
            evidence: Some(evidence(decisive)),
            ..Timing::default()
        };
        let told = |timing: &Timing| check_timing("log.csv", &channels, timing).pop().unwrap();
        let cycle = Sampling::OnCycle(1.999_996e-3);
        note("on a cycle", &told(&timing(cycle, true)));
        note("even", &told(&timing(Sampling::Even, true)));
        note("as stamped", &told(&timing(Sampling::AsStamped, true)));
        let open = told(&timing(Sampling::AsStamped, false));
        assert_eq!(open.severity, Severity::Warning);
        note("not decided", &open);
        let mut short = Timing {
            recorded: 1000,
            sampling: Some(Sampling::Even),
            ..Timing::default()
        };
        short.beyond.after = 59.0;
        note(
            "a window beyond the log",
            &beyond("run.csv (to 60 s)", &short).unwrap(),
        );
        short.dropped.count = 1;
        short.dropped.first = Some(Place::Line(7));
        let findings = check_timing("log.csv", &channels, &short);
        let dropped = findings
            .iter()
            .find(|found| found.code == "dropped-samples");
        note("a dropped sample", dropped.unwrap());
        for period in [1.0, 1e3, 1e6, 0.2] {
            let finding = time_unit("log.csv", &channels, period).unwrap();
            note(&format!("a period of {period} s"), &finding);
        }
        messages.compare();
    }
}
