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
fn light(own: &Seen) -> impl Iterator<Item = Point> {
    (own.stability.vibrations.iter())
        .filter(|pole| pole.damping < LIGHT)
        .map(|pole| [pole.hz, pole.damping])
}

/// Returns all vibrations over poses and robots: of each spring with motors free and held, then those of the loop.
pub(super) fn vibrations(model: &Model, all: &[Seen], poses: usize) -> Vec<Vibration> {
    let mut found = Vec::new();
    for (motors, index) in [(Motors::Free, 0), (Motors::Held, 1)] {
        for (joint, name) in model.joints().iter().enumerate() {
            let points: Vec<_> = (all.iter())
                .map(|own| (own, own.springs[index][joint]))
                .collect();
            found.extend(over(motors, name.clone(), &points, poses));
        }
    }
    let most = all.iter().map(|own| light(own).count()).max().unwrap_or(0);
    for k in 0..most {
        let points: Vec<_> = all.iter().map(|own| (own, light(own).nth(k))).collect();
        let name = format!("vibration {}", k + 1);
        found.extend(over(Motors::Controlled, name, &points, poses));
    }
    found
}

/// Returns the region of each of the lowest light vibrations of the loop, at most `most`; empty without any.
pub(super) fn regions(all: &[Seen], most: usize) -> Vec<Vec<shaper::Mode>> {
    (0..most)
        .map(|k| {
            let points = all.iter().filter_map(|own| light(own).nth(k));
            points
                .filter_map(|[hz, damping]| shaper::Mode::from_hz(hz, damping.max(0.0)).ok())
                .collect()
        })
        .take_while(|region: &Vec<_>| !region.is_empty())
        .collect()
}

/// Returns a vibration over poses and robots; `None` if no robot has it.
fn over(
    motors: Motors,
    name: String,
    points: &[(&Seen, Option<Point>)],
    poses: usize,
) -> Option<Vibration> {
    let identified: Vec<Point> = (points.iter())
        .filter(|(own, _)| own.robot == 0)
        .filter_map(|(_, point)| *point)
        .collect();
    let every: Vec<Point> = points.iter().filter_map(|(_, point)| *point).collect();
    let middle = |which: usize, all: &[Point]| {
        let mut all: Vec<f64> = all.iter().map(|own| own[which]).collect();
        quantile(&mut all, 0.5)
    };
    let mode = |value: [f64; 2], all: &[Point]| {
        let ends = |which: usize| {
            let mut all: Vec<f64> = all.iter().map(|own| own[which]).collect();
            [0.5 * (1.0 - HELD), 0.5 * (1.0 + HELD)].map(|part| quantile(&mut all, part))
        };
        Mode {
            hz: value[0],
            hz_95: ends(0),
            damping: value[1],
            damping_95: ends(1),
        }
    };
    if identified.is_empty() {
        return None;
    }
    let of_pose = |pose: usize| {
        let here = points.iter().filter(|(own, _)| own.pose == pose);
        let all: Vec<Point> = here.clone().filter_map(|(_, point)| *point).collect();
        let mut own = here.filter(|(own, _)| own.robot == 0);
        own.find_map(|(_, point)| *point).map(|value| mode(value, &all))
    };
    Some(Vibration {
        motors,
        name,
        all: mode([middle(0, &identified), middle(1, &identified)], &every),
        poses: (0..poses).map(of_pose).collect(),
    })
}

/// Returns the value below which a part of the values lies, between the two nearest; 0 without values.
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
