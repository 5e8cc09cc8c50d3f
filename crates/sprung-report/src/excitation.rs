//! Composes the report of a designed experiment: what its motion promises, its limits, its curves.

use sprung_method::excite::{Excitation, Excited, LimitUsed, Limited, Promised};

use super::document::{
    Badge, Block, Document, Fold, IntervalRow, Intervals, Mark, Row, Section, Table, Tone,
};
use super::groups::Joints;
use super::motion;
use super::numbers::{or_dash, short, significant};
use super::section::{folded, section};
use super::tables::{number, text};
use super::verdict::as_sentence;

/// Largest and smallest power of ten of the scale of standard errors, percent.
const MOST_DECADES: [i32; 2] = [-3, 3];

/// Composes the report of a designed experiment.
///
/// - `command`: the command that made the report; `experiment`: the text of the experiment file.
#[must_use]
pub fn compose_excitation(excited: &Excited, command: &str, experiment: &str) -> Document {
    let excitation = &excited.excitation;
    let mut sections = vec![
        promise(excitation),
        limits(&excitation.limits),
        motion::section_of(excited),
    ];
    sections.extend(motion::arm(excited));
    sections.extend(motion::hold_out(excited));
    sections.push(settings(excitation, command, experiment));
    Document {
        title: excitation.robot.clone(),
        subtitle: subtitle(excitation),
        generator: excitation.generator.clone(),
        verdict: Some(badge(excitation)),
        summary: summary(&excitation.promise),
        reason: reason(excitation),
        what_to_do: what_to_do(excitation),
        sections,
        ..Document::default()
    }
}

fn subtitle(excitation: &Excitation) -> String {
    let kind = match (excitation.method.as_str(), excitation.is_warm_up) {
        (_, true) => "Designed first motion",
        ("paper", false) => "Reference of the paper",
        _ => "Designed experiment",
    };
    let joints = excitation.motion.joints.len();
    format!(
        "{kind}: {}, {joints} joint{}",
        motion::length_and_band(&excitation.motion),
        plural(joints)
    )
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

fn badge(excitation: &Excitation) -> Badge {
    let (tone, text) = if excitation.is_certified {
        (Tone::Good, "Every limit holds, between samples too")
    } else {
        (Tone::Bad, "Not certified")
    };
    Badge {
        tone,
        text: text.to_owned(),
    }
}

/// Returns what the motion promises, in a sentence.
fn summary(promise: &[Promised]) -> String {
    let determined = promise.iter().filter(|own| own.is_determined).count();
    let open = promise.len() - determined;
    let undetermined = format!(
        "{} parameter{} undetermined.",
        if open == 0 {
            "no".to_owned()
        } else {
            open.to_string()
        },
        if open > 1 { "s stay" } else { " stays" }
    );
    match median(promise) {
        Some(percent) => format!(
            "The motion promises a median relative standard error of {} % over {determined} \
             determined parameter{}; {undetermined}",
            significant(percent, 2),
            plural(determined)
        ),
        None => as_sentence(&undetermined),
    }
}

/// Returns the median of the relative standard errors of determined parameters, percent.
fn median(promise: &[Promised]) -> Option<f64> {
    let determined = promise.iter().filter(|own| own.is_determined);
    let mut all: Vec<f64> = determined.filter_map(|own| own.relative_percent).collect();
    all.sort_by(f64::total_cmp);
    let upper = all.get(all.len() / 2)?;
    let lower = all.get(all.len().saturating_sub(1) / 2)?;
    Some(0.5 * (lower + upper))
}

fn reason(excitation: &Excitation) -> String {
    if !excitation.is_certified {
        return largest(&excitation.limits).map_or_else(String::new, |own| {
            format!(
                "The motion uses {} % of the limit of the {} of {}.",
                significant(own.used_percent, 3),
                own.quantity,
                owner(own)
            )
        });
    }
    if excitation.is_warm_up {
        "The parameters of the robot are unknown, so the first motion is small.".to_owned()
    } else {
        String::new()
    }
}

fn what_to_do(excitation: &Excitation) -> String {
    if !excitation.is_certified {
        "Do not run this motion. Widen the limits if the robot allows it, or design a motion within \
         them."
    } else if excitation.is_warm_up {
        "Run this motion, run sprung identify on its log, and design the next motion with the \
         identified parameters."
    } else if excitation.hold_out.is_some() {
        "Run this motion and the validation motion. Run sprung identify on the first log and sprung \
         validate on the second."
    } else {
        "Run this motion, and run sprung identify on its log."
    }
    .to_owned()
}

fn largest(limits: &[LimitUsed]) -> Option<&LimitUsed> {
    limits
        .iter()
        .max_by(|a, b| a.used_percent.total_cmp(&b.used_percent))
}

fn owner(limit: &LimitUsed) -> &str {
    limit.joint.as_deref().unwrap_or("the tool")
}

/// Composes the section about standard errors.
fn promise(excitation: &Excitation) -> Section {
    let names = excitation.motion.joints.iter().map(|own| own.joint.clone());
    let joints = Joints::of_names(names.collect());
    let sorted = joints.sorted(&excitation.promise, |own| &own.name);
    let mut blocks: Vec<Block> = errors(&joints, &sorted)
        .into_iter()
        .map(Block::Intervals)
        .collect();
    if excitation.undetermined().next().is_some() {
        blocks.push(Block::Table(undetermined(excitation)));
    }
    if !excitation.more.is_empty() {
        blocks.push(Block::Table(more(excitation)));
    }
    blocks.push(Block::Table(parameters(&joints, &sorted)));
    section(
        "promise",
        "What it promises",
        "A log of this motion gives these standard errors (bound of Cramér and Rao), if the robot \
         has the values of the design and the assumptions at the end of this page hold. A 95 % \
         interval is twice as wide to each side.",
        blocks,
    )
}

/// Returns the relative standard errors on one logarithmic scale; `None` without any.
fn errors(joints: &Joints, promise: &[&Promised]) -> Option<Intervals> {
    let power = |own: &Promised| {
        let percent = own.relative_percent.filter(|percent| *percent > 0.0)?;
        Some(percent.log10()).filter(|power| power.is_finite())
    };
    let powers = || promise.iter().filter_map(|own| power(own));
    let smallest = powers().min_by(f64::total_cmp)?;
    let greatest = powers().max_by(f64::total_cmp)?;
    let [least, most] = MOST_DECADES;
    let mut low = (smallest.floor() as i32).clamp(least, most - 2);
    let high = (greatest.ceil() as i32).clamp(low + 2, most);
    // The line in the middle of the rows stands at a power of ten, too.
    if (high - low) % 2 == 1 {
        low -= 1;
    }
    let width = f64::from(high - low);
    let place = |power: f64| 2.0 * (power - f64::from(low)) / width - 1.0;
    let tick = |power: i32| {
        let percent = short(10_f64.powi(power), 1);
        (place(f64::from(power)), format!("{percent} %"))
    };
    let row = |own: &&Promised| IntervalRow {
        group: joints.group(&own.name).to_owned(),
        label: joints.within(&own.name).to_owned(),
        scale: relative(own),
        marks: vec![power(own).map(|power| Mark {
            at: place(power),
            interval: Some([-1.0, place(power)]),
        })],
        tone: tone(own),
    };
    Some(Intervals {
        caption:
            "Relative standard errors on a logarithmic scale; arrows mark those outside of it. \
                  Coloured rows are undetermined parameters."
                .to_owned(),
        names: vec!["relative standard error".to_owned()],
        ticks: [low, i32::midpoint(low, high), high].map(tick).to_vec(),
        rows: promise.iter().map(row).collect(),
        folded: false,
    })
}

fn relative(own: &Promised) -> String {
    let finite = own.relative_percent.filter(|percent| percent.is_finite());
    match finite {
        Some(percent) => format!("{} %", significant(percent, 2)),
        None if own.standard_error.is_finite() => {
            format!("{} {}", significant(own.standard_error, 2), own.unit)
        }
        None => "–".to_owned(),
    }
}

fn tone(own: &Promised) -> Tone {
    if own.is_determined {
        Tone::Neutral
    } else {
        Tone::Doubtful
    }
}

fn undetermined(excitation: &Excitation) -> Table {
    let row = |own: &Promised| Row {
        cells: vec![
            own.name.clone(),
            relative(own),
            (own.cure.as_deref()).map_or_else(|| "–".to_owned(), as_sentence),
        ],
        tone: tone(own),
    };
    Table {
        caption: "Parameters that the motion does not determine, and the change that determines \
                  each of them best."
            .to_owned(),
        columns: vec![text("Parameter"), text("relative s.e."), text("what to do")],
        rows: excitation.undetermined().map(row).collect(),
        ..Table::default()
    }
}

fn more(excitation: &Excitation) -> Table {
    let rows = excitation.more.iter().map(|own| Row {
        cells: vec![
            own.what.clone(),
            significant(own.factor, 3),
            own.undetermined.to_string(),
        ],
        tone: Tone::Neutral,
    });
    Table {
        caption: "What more experiments buy: their standard errors over those of this motion \
                  (geometric mean), and the number of parameters that stay undetermined."
            .to_owned(),
        columns: vec![
            text("Experiments"),
            number("standard errors ×"),
            number("undetermined"),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

fn parameters(joints: &Joints, promise: &[&Promised]) -> Table {
    let mut headings: Vec<(usize, String)> = Vec::new();
    for (i, own) in promise.iter().enumerate() {
        let group = joints.group(&own.name);
        if headings.last().is_none_or(|(_, last)| last != group) {
            headings.push((i, group.to_owned()));
        }
    }
    let row = |own: &&Promised| Row {
        cells: vec![
            own.name.clone(),
            own.unit.clone(),
            significant(own.value, 4),
            finite_or_dash(Some(own.standard_error), 2),
            finite_or_dash(own.relative_percent, 2),
        ],
        tone: tone(own),
    };
    Table {
        caption: "Parameters, with the values for which the motion was designed.".to_owned(),
        columns: vec![
            text("Parameter"),
            text("Unit"),
            number("value"),
            number("standard error"),
            number("standard error [%]"),
        ],
        rows: promise.iter().map(row).collect(),
        headings,
    }
}

fn finite_or_dash(value: Option<f64>, digits: usize) -> String {
    or_dash(value.filter(|value| value.is_finite()), digits)
}

/// Composes the section about limits, the most used one first.
fn limits(limits: &[LimitUsed]) -> Section {
    let mut sorted: Vec<&LimitUsed> = limits.iter().collect();
    sorted.sort_by(|a, b| b.used_percent.total_cmp(&a.used_percent));
    let row = |own: &&LimitUsed| Row {
        cells: vec![
            own.joint.clone().unwrap_or_else(|| "tool".to_owned()),
            own.quantity.clone(),
            own.unit.clone(),
            finite_or_dash(own.lowest, 4),
            finite_or_dash(own.highest, 4),
            significant(own.used_percent, 3),
            significant(own.time_s, 4),
            own.shown.clone(),
        ],
        tone: if own.used_percent > 100.0 {
            Tone::Bad
        } else {
            Tone::Neutral
        },
    };
    let table = Table {
        columns: vec![
            text("Joint"),
            text("quantity"),
            text("unit"),
            number("lowest"),
            number("highest"),
            number("used [%]"),
            number("at [s]"),
            text("shown"),
        ],
        rows: sorted.iter().map(row).collect(),
        ..Table::default()
    };
    let height = if limits
        .iter()
        .any(|own| own.quantity == Limited::Height.word())
    {
        " A height uses 0 % from one metre above the floor, and 100 % at the floor."
    } else {
        ""
    };
    section(
        "limits",
        "Limits",
        &format!(
            "\"Between samples\": a bound of the motion proves the limit at every time. \
             \"Simulated\": the simulated loop keeps the limit at every period of the controller. \
             Times count from the beginning of the motion, after an approach.{height}"
        ),
        if limits.is_empty() {
            vec![Block::Paragraph("The experiment has no limits.".to_owned())]
        } else {
            vec![Block::Table(table)]
        },
    )
}

fn settings(excitation: &Excitation, command: &str, experiment: &str) -> Section {
    let assumed = excitation.assumed.iter();
    let mut blocks: Vec<Block> = assumed
        .map(|sentence| Block::Paragraph(as_sentence(sentence)))
        .collect();
    blocks.push(Block::KeyValues(search(excitation)));
    blocks.extend([command, experiment].map(|text| Block::Code(text.to_owned())));
    folded(
        Fold::Screen,
        "settings",
        "Assumptions and settings",
        "The assumptions of the design, its search, the command that made this report, and the \
         experiment file.",
        blocks,
    )
}

fn search(excitation: &Excitation) -> Vec<(String, String)> {
    let search = &excitation.search;
    let objectives = search.objectives.iter();
    let objectives: Vec<String> = objectives.map(|own| significant(*own, 4)).collect();
    let motion = &excitation.motion;
    let mut pairs = vec![
        ("Method", excitation.method.clone()),
        ("Objective", excitation.objective.clone()),
        (
            "Objective of the motion (logarithm of standard errors)",
            finite_or_dash(Some(search.objective), 4),
        ),
        ("Objectives of all searches", objectives.join(", ")),
        ("Largest number of steps", search.steps.to_string()),
        ("Seed", search.seed.to_string()),
        (
            "Lowest frequency",
            format!("{} Hz", short(motion.base_frequency_hz, 4)),
        ),
        ("Number of frequencies", motion.harmonics.len().to_string()),
        ("Number of periods", motion.periods.to_string()),
    ];
    pairs.retain(|(_, value)| !value.is_empty());
    pairs
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}
