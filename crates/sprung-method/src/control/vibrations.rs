//! Vibrations over poses and robots, and their regions for a shaper.

use sprung_core::shaper;

use super::judge::{Point, Seen};
use super::result::{Mode, Motors, Vibration};
use crate::model::Model;

/// Damping ratio below which a vibration of the closed loop counts.
const LIGHT: f64 = 0.3;

/// Part of the robots that an interval holds.
const HELD: f64 = 0.95;

/// Returns the light vibrations of a loop, from the lowest frequency.
fn light(view: &Seen) -> impl Iterator<Item = Point> {
    (view.stability.vibrations.iter())
        .filter(|pole| pole.damping < LIGHT)
        .map(|pole| [pole.hz, pole.damping])
}

/// Returns all vibrations over poses and robots: of each spring with motors free and held, then those of the loop.
pub(super) fn vibrations(model: &Model, all: &[Seen], poses: usize) -> Vec<Vibration> {
    let mut found = Vec::new();
    for (motors, index) in [(Motors::Free, 0), (Motors::Held, 1)] {
        for (joint, name) in model.joints().iter().enumerate() {
            let points: Vec<_> = (all.iter())
                .map(|view| (view, view.springs[index][joint]))
                .collect();
            found.extend(over(motors, name.clone(), &points, poses));
        }
    }
    let most = all
        .iter()
        .map(|view| light(view).count())
        .max()
        .unwrap_or(0);
    for k in 0..most {
        let points: Vec<_> = all.iter().map(|view| (view, light(view).nth(k))).collect();
        let name = format!("vibration {}", k + 1);
        found.extend(over(Motors::Controlled, name, &points, poses));
    }
    found
}

/// Returns the region of each of the lowest light vibrations of the loop, at most `most`; empty without any.
///
/// While dry friction holds a motor, its link vibrates as with the motor held. The region with the nearest frequency then holds
/// these vibrations, too.
///
/// - `sticking`: whether dry friction holds the motor of each joint, \[n\].
pub(super) fn regions(all: &[Seen], most: usize, sticking: &[bool]) -> Vec<Vec<shaper::Mode>> {
    let mut regions: Vec<Vec<Point>> = (0..most)
        .map(|k| all.iter().filter_map(|view| light(view).nth(k)).collect())
        .take_while(|region: &Vec<_>| !region.is_empty())
        .collect();
    let middles: Vec<f64> = regions.iter().map(|region| middle_hz(region)).collect();
    for joint in (0..sticking.len()).filter(|&joint| sticking[joint]) {
        let held: Vec<Point> = all
            .iter()
            .filter_map(|view| view.springs[1][joint])
            .collect();
        let away = |k: &usize| (middles[*k] / middle_hz(&held)).ln().abs();
        let nearest = (0..regions.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
        if let Some(nearest) = nearest.filter(|_| !held.is_empty()) {
            regions[nearest].extend(held);
        }
    }
    let mode = |[hz, damping]: Point| shaper::Mode::from_hz(hz, damping.max(0.0)).ok();
    (regions.into_iter())
        .map(|region| region.into_iter().filter_map(mode).collect())
        .collect()
}

/// Returns the median frequency of a region, Hz.
fn middle_hz(region: &[Point]) -> f64 {
    let mut all: Vec<f64> = region.iter().map(|[hz, _]| *hz).collect();
    quantile(&mut all, 0.5)
}

/// Returns a vibration over poses and robots; `None` if no robot has it.
fn over(
    motors: Motors,
    name: String,
    points: &[(&Seen, Option<Point>)],
    poses: usize,
) -> Option<Vibration> {
    let identified: Vec<Point> = (points.iter())
        .filter(|(view, _)| view.robot == 0)
        .filter_map(|(_, point)| *point)
        .collect();
    let every: Vec<Point> = points.iter().filter_map(|(_, point)| *point).collect();
    let middle = |which: usize, all: &[Point]| {
        let mut all: Vec<f64> = all.iter().map(|point| point[which]).collect();
        quantile(&mut all, 0.5)
    };
    if identified.is_empty() {
        return None;
    }
    let at = |pose: usize| {
        let mut at_pose = points
            .iter()
            .filter(|(view, _)| view.robot == 0 && view.pose == pose);
        at_pose.find_map(|(_, point)| *point)
    };
    // Robots are drawn in few poses each, so all poses share the relative deviations from the identified robot.
    let deviations: Vec<Point> = (points.iter())
        .filter(|(view, _)| view.robot != 0)
        .filter_map(|(view, point)| {
            let ([hz, damping], [of, beside]) = ((*point)?, at(view.pose)?);
            Some([hz / of, damping / beside])
        })
        .collect();
    let ends = |which: usize, all: &[Point]| {
        let mut all: Vec<f64> = all.iter().map(|point| point[which]).collect();
        [0.5 * (1.0 - HELD), 0.5 * (1.0 + HELD)].map(|part| quantile(&mut all, part))
    };
    let of_pose = |pose: usize| {
        let [hz, damping] = at(pose)?;
        let scaled = |value: f64, which: usize| {
            if deviations.is_empty() {
                [value; 2]
            } else {
                ends(which, &deviations).map(|end| end * value)
            }
        };
        Some(Mode {
            hz,
            hz_95: scaled(hz, 0),
            damping,
            damping_95: scaled(damping, 1),
        })
    };
    Some(Vibration {
        motors,
        name,
        all: Mode {
            hz: middle(0, &identified),
            hz_95: ends(0, &every),
            damping: middle(1, &identified),
            damping_95: ends(1, &every),
        },
        poses: (0..poses).map(of_pose).collect(),
    })
}

/// Returns the percentile of a part of the values, between the two nearest; 0 without values.
pub(super) fn quantile(values: &mut [f64], part: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f64::total_cmp);
    let place = part * (values.len() - 1) as f64;
    let (low, rest) = (place.floor() as usize, place.fract());
    let high = (low + 1).min(values.len() - 1);
    values[low] + rest * (values[high] - values[low])
}
