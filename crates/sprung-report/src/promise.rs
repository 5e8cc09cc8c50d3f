//! Composes the section about the standard errors that a designed motion promises.

use sprung_method::excite::{Excitation, Promised};

use super::document::{Block, IntervalRow, Intervals, Mark, Section, Table, Tone};
use super::groups::Joints;
use super::numbers::{dash_if_none, finite_or_dash, short, significant};
use super::rows::rows;
use super::section::section;
use super::verdict::as_sentence;

/// Smallest and largest power of ten of the scale of standard errors, percent. Above 100 % a
/// parameter is undetermined.
const MOST_DECADES: [i32; 2] = [-4, 2];

/// Composes the section about standard errors.
pub(super) fn section_of(excitation: &Excitation) -> Section {
    let names = excitation
        .motion
        .joints
        .iter()
        .map(|joint| joint.joint.clone());
    let joints = Joints::of_names(names.collect());
    let sorted = joints.sorted(&excitation.promise, |promised| &promised.name);
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
    let power = |promised: &Promised| {
        let percent = promised.relative_percent.filter(|percent| *percent > 0.0)?;
        Some(percent.log10()).filter(|power| power.is_finite())
    };
    let powers = || promise.iter().filter_map(|promised| power(promised));
    let smallest = powers().min_by(f64::total_cmp)?;
    let greatest = powers().max_by(f64::total_cmp)?;
    let [least, most] = MOST_DECADES;
    let mut low = (smallest.floor() as i32).clamp(least, most - 2);
    let high = (greatest.ceil() as i32).clamp(low + 2, most);
    // The line in the middle of the rows is at a power of ten, too.
    if (high - low) % 2 == 1 {
        low -= 1;
    }
    let width = f64::from(high - low);
    let place = |power: f64| 2.0 * (power - f64::from(low)) / width - 1.0;
    let tick = |power: i32| {
        let percent = short(10_f64.powi(power), 1);
        (place(f64::from(power)), format!("{percent} %"))
    };
    let row = |promised: &&Promised| IntervalRow {
        group: joints.group(&promised.name).to_owned(),
        label: joints.within(&promised.name).to_owned(),
        scale: relative(promised),
        marks: vec![power(promised).map(|power| Mark {
            at: place(power),
            interval: Some([-1.0, place(power)]),
        })],
        tone: tone(promised),
    };
    Some(Intervals {
        caption:
            "Relative standard errors on a logarithmic scale; arrows mark those outside of it. \
                  Coloured rows are undetermined parameters."
                .to_owned(),
        names: vec!["relative standard error".to_owned()],
        ticks: [low, i32::midpoint(low, high), high].map(tick).to_vec(),
        rows: promise.iter().map(row).collect(),
        ..Intervals::default()
    })
}

fn relative(promised: &Promised) -> String {
    let finite = promised
        .relative_percent
        .filter(|percent| percent.is_finite());
    match finite {
        Some(percent) => format!("{} %", significant(percent, 2)),
        None if promised.standard_error.is_finite() => {
            format!(
                "{} {}",
                significant(promised.standard_error, 2),
                promised.unit
            )
        }
        None => dash_if_none(None),
    }
}

fn tone(promised: &Promised) -> Tone {
    if promised.is_determined {
        Tone::Neutral
    } else {
        Tone::Doubtful
    }
}

fn undetermined(excitation: &Excitation) -> Table {
    rows(excitation.undetermined())
        .text("Parameter", |promised| &promised.name)
        .text("relative s.e.", relative)
        .text("what to do", |promised| {
            dash_if_none(promised.cure.as_deref().map(as_sentence))
        })
        .toned(tone)
        .table(
            "Parameters that the motion does not determine, and the change that determines \
             each of them best.",
        )
}

fn more(excitation: &Excitation) -> Table {
    rows(&excitation.more)
        .text("Experiments", |addition| &addition.what)
        .number("standard errors ×", |addition| {
            significant(addition.factor, 3)
        })
        .number("undetermined", |addition| addition.undetermined)
        .table(
            "What more experiments buy: their standard errors over those of this motion \
             (geometric mean), and the number of parameters that stay undetermined.",
        )
}

fn parameters(joints: &Joints, promise: &[&Promised]) -> Table {
    let table = rows(promise.iter().copied())
        .text("Parameter", |promised| &promised.name)
        .text("Unit", |promised| &promised.unit)
        .number("value", |promised| significant(promised.value, 4))
        .number("standard error", |promised| {
            finite_or_dash(Some(promised.standard_error), 2)
        })
        .number("standard error [%]", |promised| {
            finite_or_dash(promised.relative_percent, 2)
        })
        .toned(tone);
    Table {
        headings: joints.headings(promise.iter().map(|promised| promised.name.as_str())),
        ..table.table("Parameters, with the values for which the motion was designed.")
    }
}
