//! Finds half width and centre of the play of a spring by an outer search, because the regression is not linear in them.

use sprung_core::chain::JointKind;
use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use super::stribeck::{Deflection, deflection, solved};
use crate::finding::{Finding, Severity};
use crate::log::LogBlock;
use crate::model::Model;
use crate::regression::{Reading, Triangle};

/// Half width of hardly any play, and half widths in the first scan, over the standard deviation of the deflection.
const HARDLY: f64 = 1e-9;
const SHARES: [f64; 7] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64];

/// Part of the squared residuals that the best play of the scan may leave.
const PROMISING: f64 = 0.9;

/// Steps of the search for half width and centre, and the places about the best one that a step tries.
const STEPS: usize = 9;
const NEIGHBOURS: [[f64; 2]; 8] = [
    [-0.5, -0.5],
    [-0.5, 0.0],
    [-0.5, 0.5],
    [0.0, -0.5],
    [0.0, 0.5],
    [0.5, -0.5],
    [0.5, 0.0],
    [0.5, 0.5],
];

/// The play of a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Play {
    /// Half of its width, rad (m).
    pub(crate) half_width: f64,
    /// Standard error of the half width, rad (m).
    pub(crate) standard_error: f64,
    /// Deflection in its middle, rad (m).
    pub(crate) centre: f64,
}

/// The search for the play of one spring.
#[derive(Clone, Copy)]
struct Search {
    joint: usize,
    deflection: Deflection,
    /// Half width and centre, rad (m).
    place: [f64; 2],
    /// Distance of the places that are tried, rad (m).
    reach: f64,
    /// Sum of squared residuals, and the same without play.
    least: f64,
    without: f64,
    /// Least half width of the first scan that explains the log clearly worse than no play, rad (m).
    excluded: f64,
}

/// Returns the plays of springs that explain the beginning of a log best. A joint is absent if no play does much better than none, or
/// two encoders do not show its deflection.
#[must_use]
pub(crate) fn find_plays(
    reading: &Reading,
    excerpt: &Excerpt,
    joints: &[usize],
) -> Vec<(usize, Play)> {
    let found = sought(reading, excerpt, joints);
    let play = |(joint, found): (usize, Result<Play, f64>)| Some((joint, found.ok()?));
    found.into_iter().filter_map(play).collect()
}

/// Returns the best play of each joint, or the least half width that the log excludes, rad (m).
///
/// The rows of different joints do not affect each other, so all joints are searched at once.
fn sought(
    reading: &Reading,
    excerpt: &Excerpt,
    joints: &[usize],
) -> Vec<(usize, Result<Play, f64>)> {
    let search = |&joint: &usize| {
        let deflection = deflection(reading, excerpt, joint)?;
        Some(Search {
            joint,
            deflection,
            place: [HARDLY * deflection.rms, deflection.mean],
            reach: 0.0,
            least: f64::INFINITY,
            without: f64::INFINITY,
            excluded: f64::INFINITY,
        })
    };
    let mut all: Vec<Search> = joints.iter().filter_map(search).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let Some(smoothed) = excerpt.smoothed(reading) else {
        return Vec::new();
    };
    let model = reading.model();
    let costs = |all: &[Search], place: &dyn Fn(&Search) -> [f64; 2]| -> Vec<f64> {
        let mut changed = model.clone();
        for one in all {
            changed.set_play(one.joint, place(one));
        }
        let reading = reading.with_model(changed.clone());
        let whole = smoothed.reduce(&reading).and_then(|system| system.whole());
        let whole = whole.as_deref().unwrap_or_default();
        let of_joint = |one: &Search| unexplained(&changed, whole, one.joint);
        (all.iter())
            .map(|one| of_joint(one).unwrap_or(f64::INFINITY))
            .collect()
    };
    centre(&mut all, &costs);
    let samples = independent(reading, excerpt);
    let without = costs(&all, &|one| one.place);
    for (one, without) in all.iter_mut().zip(without) {
        one.without = without;
    }
    scan(&mut all, samples, &costs);
    let (mut all, hidden): (Vec<Search>, Vec<Search>) =
        (all.into_iter()).partition(|one| one.least < PROMISING * one.without);
    for _ in 0..STEPS * usize::from(!all.is_empty()) {
        narrow(&mut all, &costs);
    }
    let errors = standard_errors(&all, samples, &costs);
    let play = |(one, standard_error): (&Search, f64)| {
        let [half_width, centre] = one.place;
        let play = Play {
            half_width,
            standard_error,
            centre,
        };
        (one.joint, Ok(play))
    };
    let hidden = hidden.iter().map(|one| (one.joint, Err(one.excluded)));
    all.iter().zip(errors).map(play).chain(hidden).collect()
}

/// Costs of all joints, each with the play at its place.
type Costs<'c> = dyn Fn(&[Search], &dyn Fn(&Search) -> [f64; 2]) -> Vec<f64> + 'c;

/// Moves each centre to the deflection without torque of a spring with hardly any play, by parabolas through the cost.
fn centre(all: &mut [Search], costs: &Costs<'_>) {
    for share in [1.0, 0.1] {
        let [before, here, after] = [-share, 0.0, share].map(|by| {
            costs(all, &|one| {
                let [half_width, centre] = one.place;
                [half_width, centre + by * one.deflection.rms]
            })
        });
        for (at, one) in all.iter_mut().enumerate() {
            let step = share * one.deflection.rms;
            let curvature = before[at] + after[at] - 2.0 * here[at];
            if curvature > 0.0 {
                let vertex = 0.5 * step * (before[at] - after[at]) / curvature;
                one.place[1] += vertex.clamp(-3.0 * step, 3.0 * step);
            }
        }
    }
}

/// Takes the best of some half widths.
///
/// - `samples`: that are independent. A half width is excluded if the squares rise by four of their standard deviations.
fn scan(all: &mut [Search], samples: f64, costs: &Costs<'_>) {
    for share in SHARES {
        let of_share = |one: &Search| [share * one.deflection.rms, one.place[1]];
        let found = costs(all, &of_share);
        for (one, cost) in all.iter_mut().zip(found) {
            if cost < one.least {
                (one.place, one.least) = (of_share(one), cost);
                one.reach = one.place[0];
            }
            if cost > (1.0 + 16.0 / samples) * one.without {
                one.excluded = one.excluded.min(of_share(one)[0]);
            }
        }
    }
}

/// Tries the places about each best one, and halves the reach where none is better.
fn narrow(all: &mut [Search], costs: &Costs<'_>) {
    let mut is_better = vec![false; all.len()];
    for [wider, higher] in NEIGHBOURS {
        let neighbour = |one: &Search| {
            let [half_width, centre] = one.place;
            let wide = half_width + wider * one.reach;
            [wide.max(0.1 * half_width), centre + higher * one.reach]
        };
        let found = costs(all, &neighbour);
        for ((one, cost), is_better) in all.iter_mut().zip(found).zip(&mut is_better) {
            if cost < one.least {
                (one.place, one.least) = (neighbour(one), cost);
                *is_better = true;
            }
        }
    }
    for (one, is_better) in all.iter_mut().zip(is_better) {
        if !is_better {
            one.reach *= 0.5;
        }
    }
}

/// Returns the sum of squared residuals of motor and link without the preload: a spring has no torque in the middle of its play. The
/// row of the link is solved with the stiffness of the motor's, because it has no right-hand side.
fn unexplained(model: &Model, whole: &[Triangle], joint: usize) -> Option<f64> {
    let preload = model.index(JointParameter::Preload, joint);
    let stiffness = model.index(JointParameter::Stiffness, joint)?;
    let solved_with = |row: usize, of_spring: Option<f64>| {
        let columns = model.row_columns(row);
        let known = |column: &usize| match *column {
            column if Some(column) == preload => Some(0.0),
            column if column == stiffness => of_spring,
            _ => None,
        };
        let known: Vec<Option<f64>> = columns.iter().map(known).collect();
        let free: Vec<usize> = (columns.iter().copied().zip(&known))
            .filter_map(|(column, known)| known.is_none().then_some(column))
            .collect();
        let (x, squares) = solved(&whole.get(row)?.with_known(&known))?;
        let at = free.iter().position(|column| *column == stiffness);
        Some((at.map(|at| x[at]), squares))
    };
    let (of_spring, of_motor) = solved_with(model.torque_row(joint), None)?;
    let (_, of_link) = solved_with(joint, of_spring)?;
    Some(of_motor + of_link)
}

/// Returns the model with the plays that the description leaves open, and findings about those that the log does not show.
pub(crate) fn with_plays(reading: &Reading, excerpt: &Excerpt) -> (Model, Vec<Finding>) {
    let mut model = reading.model().clone();
    let mut findings = Vec::new();
    for (joint, found) in sought(reading, excerpt, reading.model().open_play()) {
        match found {
            Ok(play) => model.set_play(joint, [play.half_width, play.centre]),
            Err(excluded) => findings.push(not_shown(&model, joint, excluded)),
        }
    }
    (model, findings)
}

fn not_shown(model: &Model, joint: usize, excluded: f64) -> Finding {
    let unit = match model.kind(joint) {
        JointKind::Revolute => "rad",
        JointKind::Prismatic => "m",
    };
    let bound = if excluded.is_finite() {
        format!("a half width of {excluded:.1e} {unit} or more would explain it clearly worse")
    } else {
        "the log excludes no half width that was tried".to_owned()
    };
    Finding::new(
        Severity::Info,
        "play-not-shown",
        format!(
            "{}: no play of the spring explains the log better than none, so none is used; {bound}",
            model.joints()[joint]
        ),
        "leave \"play\" out of spring, or record a motion in which the torque of the spring changes its sign",
    )
}

/// Returns the number of independent samples of the rows of a joint.
fn independent(reading: &Reading, excerpt: &Excerpt) -> f64 {
    let samples: usize = excerpt.blocks().iter().map(LogBlock::len).sum();
    let duration = samples as f64 * excerpt.period();
    (4.0 * reading.position_cutoff_hz() * duration).max(1.0)
}

/// Returns the standard errors of the half widths by the curvature of the cost.
fn standard_errors(all: &[Search], samples: f64, costs: &Costs<'_>) -> Vec<f64> {
    if all.is_empty() {
        return Vec::new();
    }
    let [narrower, wider] = [0.9, 1.1].map(|share| {
        costs(all, &|one| {
            let [half_width, centre] = one.place;
            [share * half_width, centre]
        })
    });
    let error = |(at, one): (usize, &Search)| {
        let [half_width, _] = one.place;
        let step = 0.1 * half_width;
        let curvature = (narrower[at] + wider[at] - 2.0 * one.least) / (2.0 * step * step);
        if curvature > 0.0 {
            (one.least / samples / curvature).sqrt()
        } else {
            half_width
        }
    };
    all.iter().enumerate().map(error).collect()
}
