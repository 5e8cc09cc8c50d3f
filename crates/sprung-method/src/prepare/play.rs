//! Finds half width and centre of the play of a spring by an outer search, because the regression is not linear in them.

use sprung_core::parameters::JointParameter;

use super::excerpt::Excerpt;
use super::stribeck::{Deflection, deflection, solved};
use crate::log::LogBlock;
use crate::model::Model;
use crate::regression::{Reading, Triangle};

/// Half width of hardly any play, and half widths in the first scan, over the standard deviation of the deflection.
const HARDLY: f64 = 1e-9;
const SHARES: [f64; 7] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64];

/// Part of the squared residuals that the best play of the scan may leave.
const PROMISING: f64 = 0.9;

/// Steps of the search for half width and centre, and the places about the best one that a step tries.
const STEPS: usize = 14;
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

impl Play {
    /// Returns half width and centre.
    pub(crate) fn values(&self) -> [f64; 2] {
        [self.half_width, self.centre]
    }
}

/// Returns the play of a joint's spring that explains the beginning of a log best; `None` if none does better than a spring without
/// play, or two encoders do not show the deflection.
///
#[must_use]
pub(crate) fn find_play(reading: &Reading, excerpt: &Excerpt, joint: usize) -> Option<Play> {
    let deflection = deflection(reading, excerpt, joint)?;
    let model = reading.model();
    let cost = |half_width: f64, centre: f64| -> f64 {
        let mut changed = model.clone();
        changed.set_play(joint, [half_width, centre]);
        let reading = reading.with_model(changed.clone());
        let whole = excerpt.reduce(&reading).and_then(|system| system.whole());
        (whole.as_deref())
            .and_then(|whole| unexplained(&changed, whole, joint))
            .unwrap_or(f64::INFINITY)
    };
    let hardly = HARDLY * deflection.rms;
    let mut centre = unloaded(&deflection, |centre| cost(hardly, centre));
    let without = cost(hardly, centre);
    let widths = SHARES.map(|share| share * deflection.rms);
    let costs = widths.map(|width| (width, cost(width, centre)));
    let (mut width, mut least) =
        (costs.into_iter()).min_by(|one, other| one.1.total_cmp(&other.1))?;
    if least > PROMISING * without {
        return None;
    }
    let mut reach = width;
    for _ in 0..STEPS {
        let neighbours = NEIGHBOURS.map(|[wider, higher]| {
            let place = (width + wider * reach, centre + higher * reach);
            let is_play = place.0 > 0.1 * width;
            (
                place,
                if is_play {
                    cost(place.0, place.1)
                } else {
                    f64::INFINITY
                },
            )
        });
        let best = neighbours
            .into_iter()
            .min_by(|one, other| one.1.total_cmp(&other.1));
        match best {
            Some((place, squares)) if squares < least => {
                ((width, centre), least) = (place, squares);
            }
            Some(_) | None => reach *= 0.5,
        }
    }
    Some(Play {
        half_width: width,
        standard_error: standard_error((width, least), independent(reading, excerpt), |at| {
            cost(at, centre)
        }),
        centre,
    })
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

/// Returns the model with the plays that the description leaves open.
pub(crate) fn with_plays(reading: &Reading, excerpt: &Excerpt) -> Model {
    let mut model = reading.model().clone();
    for &joint in reading.model().open_play() {
        if let Some(play) = find_play(reading, excerpt, joint) {
            model.set_play(joint, play.values());
        }
    }
    model
}

/// Returns the deflection without torque of a spring with hardly any play, by parabolas through the cost, rad (m).
fn unloaded(deflection: &Deflection, cost: impl Fn(f64) -> f64) -> f64 {
    let mut centre = deflection.mean;
    for step in [deflection.rms, 0.1 * deflection.rms] {
        let [before, here, after] = [-step, 0.0, step].map(|by| cost(centre + by));
        let curvature = before + after - 2.0 * here;
        if curvature > 0.0 {
            centre += (0.5 * step * (before - after) / curvature).clamp(-3.0 * step, 3.0 * step);
        }
    }
    centre
}

/// Returns the number of independent samples of the rows of a joint.
fn independent(reading: &Reading, excerpt: &Excerpt) -> f64 {
    let samples: usize = excerpt.blocks().iter().map(LogBlock::len).sum();
    let duration = samples as f64 * excerpt.period();
    (4.0 * reading.position_cutoff_hz() * duration).max(1.0)
}

/// Returns the standard error of a place by the curvature of the cost there.
fn standard_error((at, least): (f64, f64), samples: f64, cost: impl Fn(f64) -> f64) -> f64 {
    let step = 0.1 * at;
    let curvature = (cost(at + step) + cost(at - step) - 2.0 * least) / (2.0 * step * step);
    if curvature > 0.0 {
        (least / samples / curvature).sqrt()
    } else {
        at
    }
}
