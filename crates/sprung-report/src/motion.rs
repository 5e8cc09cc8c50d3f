//! Composes the curves of a designed motion and the moving arm.

use sprung_method::excite::{
    Excited, LimitUsed, Limited, MotionResult, Skeleton as Places, Trajectory,
};

use super::document::{Block, Figure, Layout, Line, Panel, Section, Series, Skeleton, Style};
use super::intervals::round_up;
use super::numbers::{short, significant};
use super::section::section;

/// Most points of a curve, and most frames of the arm: the page stays small.
const MOST_POINTS: usize = 1000;
const MOST_FRAMES: usize = 300;

/// Largest deflection that rounding gives a joint without a spring, rad (m).
const NO_DEFLECTION: f64 = 1e-12;

/// Squares of the floor over the size of the arm.
const SQUARES: f64 = 8.0;

/// Times of curves of all joints, and further curves.
struct Motion<'a> {
    joints: &'a [String],
    turns: &'a [bool],
    limits: &'a [LimitUsed],
    shown: Vec<usize>,
    time: Vec<f64>,
    marks: Vec<Line>,
}

impl<'a> Motion<'a> {
    fn new(samples: &'a Trajectory, limits: &'a [LimitUsed], time: &[f64]) -> Self {
        let shown = evenly(time.len(), MOST_POINTS);
        Self {
            joints: &samples.joints,
            turns: &samples.turns,
            limits,
            time: shown.iter().map(|&i| time[i]).collect(),
            shown,
            marks: Vec::new(),
        }
    }

    /// Returns the curves of a trajectory, with a mark at the end of its approach.
    fn of(samples: &'a Trajectory, limits: &'a [LimitUsed], duration: f64) -> Self {
        let begins = samples.time_s.last().map_or(0.0, |last| last - duration);
        let mark = Line {
            at: begins,
            text: String::new(),
        };
        let has_approach = begins > 1e-3 * duration;
        Self {
            marks: has_approach.then_some(mark).into_iter().collect(),
            ..Self::new(samples, limits, &samples.time_s)
        }
    }

    fn figure(&self, id: &str, caption: &str, what: Limited, values: &[Vec<f64>]) -> Figure {
        let panels = (self.joints.iter().zip(values).enumerate())
            .filter(|(_, (_, values))| values.len() > self.shown.last().copied().unwrap_or(0))
            .map(|(joint, (name, values))| {
                let values: Vec<f64> = self.shown.iter().map(|&i| values[i]).collect();
                self.panel(what, (name, self.turns.get(joint) == Some(&false)), &values)
            });
        let approach = if self.marks.is_empty() {
            ""
        } else {
            " The motion begins at the dashed line, after the approach."
        };
        Figure::over_time(id, format!("{caption}{approach}"), Layout::Grid, panels)
    }

    fn panel(&self, what: Limited, (joint, slides): (&str, bool), values: &[f64]) -> Panel {
        let limit = (self.limits.iter())
            .find(|limit| limit.joint.as_deref() == Some(joint) && limit.quantity == what.word());
        let unit = if slides {
            what.unit().replace("N·m", "N").replace("rad", "m")
        } else {
            what.unit().to_owned()
        };
        let line = |name: &str, at: Option<f64>| {
            let at = at.filter(|at| is_near(*at, values));
            Series::new(name, Style::Reference, vec![at; values.len()])
        };
        let of_motion = values.iter().copied().map(Some).collect();
        Panel {
            y_label: format!("{joint} {} [{unit}]", what.word()),
            note: limit.map_or_else(String::new, |limit| {
                format!("{} % of limit", significant(limit.used_percent, 2))
            }),
            x: self.time.clone(),
            series: vec![
                line("lowest allowed", limit.and_then(|limit| limit.lowest)),
                line("highest allowed", limit.and_then(|limit| limit.highest)),
                Series::new(what.word(), Style::First, of_motion),
            ],
            errors: None,
            marks: self.marks.clone(),
        }
    }
}

/// Returns whether a third of the panel remains for the values above a line.
fn is_near(at: f64, values: &[f64]) -> bool {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let width = high - low;
    (low - width..=high + width).contains(&at)
}

/// Returns at most `most` indices of a list, evenly from the first to the last.
fn evenly(length: usize, most: usize) -> Vec<usize> {
    let count = length.min(most);
    (0..count)
        .map(|i| i * (length - 1) / (count - 1).max(1))
        .collect()
}

/// Returns the length and the frequencies of a motion, as text.
pub(super) fn length_and_band(motion: &MotionResult) -> String {
    let hz = |multiple: usize| short(motion.base_frequency_hz * multiple as f64, 3);
    let band = match (motion.harmonics.first(), motion.harmonics.last()) {
        (Some(first), Some(last)) if first != last => {
            format!(", {} to {} Hz", hz(*first), hz(*last))
        }
        (Some(only), _) => format!(", {} Hz", hz(*only)),
        _ => String::new(),
    };
    format!("{} s{band}", short(motion.duration_s, 4))
}

/// Composes the section about the motion: positions, velocities and accelerations of the reference,
/// deflections and motor torques of the simulation.
pub(super) fn section_of(excited: &Excited) -> Section {
    let excitation = &excited.excitation;
    let samples = &excited.trajectory;
    let reference = Motion::of(samples, &excitation.limits, excitation.motion.duration_s);
    let simulation = &excited.simulation;
    let simulated = Motion::new(samples, &excitation.limits, &simulation.time_s);
    let pairs = simulation.motor.iter().zip(&simulation.link);
    let deflections: Vec<Vec<f64>> = pairs
        .map(|(motor, link)| motor.iter().zip(link).map(|(a, b)| a - b).collect())
        // A joint without a spring has no panel.
        .map(|values: Vec<f64>| {
            let is_flexible = values.iter().any(|value| value.abs() > NO_DEFLECTION);
            if is_flexible { values } else { Vec::new() }
        })
        .collect();
    let figures = [
        reference.figure(
            "position",
            "Positions of the reference.",
            Limited::Position,
            &samples.position,
        ),
        reference.figure(
            "velocity",
            "Velocities of the reference.",
            Limited::Velocity,
            &samples.velocity,
        ),
        reference.figure(
            "acceleration",
            "Accelerations of the reference.",
            Limited::Acceleration,
            &samples.acceleration,
        ),
        simulated.figure(
            "deflection",
            "Deflections in the simulation without the approach: motor minus link.",
            Limited::Deflection,
            &deflections,
        ),
        simulated.figure(
            "torque",
            "Motor torques in the simulation without the approach.",
            Limited::Torque,
            &simulation.torque,
        ),
    ];
    let drawn = figures
        .into_iter()
        .filter(|figure| !figure.panels.is_empty());
    section(
        "motion",
        "The motion",
        "Dotted lines are limits; a limit far outside of a panel has no line. The number beside \
         each name is the used part of the limit.",
        drawn.map(Block::Figure).collect(),
    )
}

/// Composes the section about the motion for validation; `None` without one.
pub(super) fn hold_out(excited: &Excited) -> Option<Section> {
    let section = beside(
        excited,
        excited.hold_out.as_ref()?,
        excited.excitation.hold_out.as_ref()?,
        ["hold-out", "The validation motion"],
        "keeps the same limits and has other frequencies. Its log shows whether the identified parameters predict a \
         motion that they have not seen",
    );
    Some(section)
}

/// Composes the section about the slow motion; `None` without one.
pub(super) fn slow(excited: &Excited) -> Option<Section> {
    let section = beside(
        excited,
        excited.slow.as_ref()?,
        excited.excitation.slow.as_ref()?,
        ["slow", "The slow motion"],
        "keeps the same limits and is slow. Its log separates the friction at low velocity from that at high velocity; \
         sprung identify takes it beside the first log",
    );
    Some(section)
}

/// Composes the section about a motion beside the designed one.
fn beside(
    excited: &Excited,
    samples: &Trajectory,
    motion: &MotionResult,
    [id, title]: [&str; 2],
    what: &str,
) -> Section {
    let drawn = Motion::of(samples, &excited.excitation.limits, motion.duration_s);
    let mut figure = drawn.figure(
        &format!("{id}-position"),
        &format!("Positions of {}.", title.to_lowercase()),
        Limited::Position,
        &samples.position,
    );
    for panel in &mut figure.panels {
        // The used parts of the limits are those of the other motion.
        panel.note.clear();
    }
    let intro = format!("This motion ({}) {what}.", length_and_band(motion));
    section(id, title, &intro, vec![Block::Figure(figure)])
}

/// Composes the section with the moving arm; `None` without places.
pub(super) fn arm(excited: &Excited) -> Option<Section> {
    let places = excited.skeleton.as_ref()?;
    let drawing = skeleton(places, &excited.excitation.limits)?;
    Some(section(
        "arm",
        "The arm moving",
        "The simulated motion. Before the robot runs it, look for places where links, tool or \
         cables meet each other or an obstacle: the design does not know them.",
        vec![Block::Skeleton(drawing)],
    ))
}

fn skeleton(places: &Places, limits: &[LimitUsed]) -> Option<Skeleton> {
    let count = places.parents.len();
    let frames: Vec<(f64, &Vec<[f64; 3]>)> = (places.time_s.iter().copied())
        .zip(&places.points)
        .filter(|(_, points)| points.len() == count)
        .collect();
    let shown: Vec<(f64, &Vec<[f64; 3]>)> = evenly(frames.len(), MOST_FRAMES)
        .into_iter()
        .map(|i| frames[i])
        .collect();
    let all = || frames.iter().flat_map(|(_, points)| points.iter());
    let reach = all().map(|[x, y, _]| x.hypot(*y)).fold(0.0, f64::max);
    let lowest = all().map(|point| point[2]).fold(0.0, f64::min);
    let highest = all().map(|point| point[2]).fold(0.0, f64::max);
    let tool = || frames.iter().filter_map(|(_, points)| points.last());
    let low = tool().map(|point| point[2]).fold(f64::INFINITY, f64::min);
    let high = tool()
        .map(|point| point[2])
        .fold(f64::NEG_INFINITY, f64::max);
    let far = tool().map(|[x, y, _]| x.hypot(*y)).fold(0.0, f64::max);
    let size = reach.max(highest - lowest);
    if !(low.is_finite() && high.is_finite() && size.is_finite() && size > 0.0) {
        return None;
    }
    let limit = (limits.iter())
        .filter(|limit| limit.quantity == Limited::Height.word())
        .find_map(|limit| limit.lowest);
    // A floor far below the arm would leave little room for the arm.
    let floor = limit.filter(|floor| *floor > lowest - size && *floor < highest);
    let grid = round_up(size / SQUARES);
    Some(Skeleton {
        caption: format!(
            "Links, joints, and the tool with its path. The first view is from the side; drag it to \
             turn it. The second is from above. The squares lie at the {} and have sides of {} m. \
             The tool is {} to {} m above the base, and at most {} m beside its axis.",
            if floor.is_some() {
                "lowest allowed height"
            } else {
                "height of the base"
            },
            short(grid, 1),
            significant(low, 3),
            significant(high, 3),
            significant(far, 3)
        ),
        floor: floor.unwrap_or(0.0),
        grid,
        parents: places.parents.clone(),
        time: shown.iter().map(|(time, _)| *time).collect(),
        points: shown.iter().map(|(_, points)| (*points).clone()).collect(),
    })
}
