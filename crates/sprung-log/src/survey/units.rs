//! Units of positions, and the side of the gearbox on which they were taken.

use std::f64::consts::TAU;

use sprung_core::chain::JointKind;

use super::families::Family;
use super::figures::Figures;
use super::positions::size;
use super::read::Survey;
use super::slopes::Slope;
use super::write::{Conversion, Short, si};
use crate::description::JointOfStart;

/// Part by which a position may lie beyond the limits of its joint, rad.
const BEYOND_LIMITS: f64 = 0.2;

/// Largest range of a joint without limits, rad and m.
const WIDEST: f64 = 2.0 * TAU;
const LONGEST: f64 = 5.0;

/// Largest difference of a slope from 1 for positions in one unit, and from the slope by degrees
/// and turns; a gear ratio may have the same slope.
const MAX_DIFFERENCE_OF_SLOPES: f64 = 0.1;
const SAME_UNIT: f64 = 0.005;

/// Smallest slope of a position before the gearbox.
const MIN_GEAR: f64 = 1.5;

/// Standard errors, and part of the slope, within which a gear ratio lies; and the largest error of a slope that
/// separates multiples of 0.5.
const SIGMAS: f64 = 3.0;
const BIAS: f64 = 2e-4;
const MAX_ERROR: f64 = 0.1;

/// Gear ratios of usual harmonic drives.
const USUAL_GEARS: [f64; 11] = [
    30.0, 50.0, 51.0, 80.0, 81.0, 100.0, 101.0, 120.0, 121.0, 160.0, 161.0,
];

/// A gear ratio, and the reason for it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gear {
    pub(super) ratio: f64,
    /// The reason, without the last full stop.
    pub(super) why: String,
}

/// Unit and side of the positions of a family.
#[derive(Clone, Debug, Default)]
pub(super) struct Reading {
    pub(super) conversion: Conversion,
    /// Gear ratio of each joint, if the positions were taken before the gearbox; `None` within is to
    /// be filled in.
    pub(super) gears: Option<Vec<Option<Gear>>>,
    /// Reasons, as sentences without the last full stop.
    pub(super) why: String,
    /// Line to fill in, if the unit is not clear.
    pub(super) open: Option<String>,
}

/// The joints of a log and their figures in one family.
struct JointFigures<'a> {
    robot: &'a [JointOfStart],
    joints: &'a [usize],
    figures: Vec<Figures>,
}

impl<'a> JointFigures<'a> {
    fn of(
        survey: &Survey,
        family: &Family,
        (robot, joints): (&'a [JointOfStart], &'a [usize]),
    ) -> Self {
        let figures = |&joint: &usize| match family.of[joint] {
            Some((source, column)) => survey.sources[source].columns[column].figures,
            None => Figures::default(),
        };
        Self {
            robot,
            joints,
            figures: joints.iter().map(figures).collect(),
        }
    }

    fn joints(&self) -> impl Iterator<Item = (&JointOfStart, &Figures)> {
        let joints = self.joints.iter().map(|&joint| &self.robot[joint]);
        joints.zip(&self.figures)
    }

    /// Returns whether all positions are possible in units of this size.
    ///
    /// - `kind`: the kind of joints that are tested.
    fn fit(&self, kind: JointKind, size: f64) -> bool {
        self.joints()
            .filter(|(joint, _)| joint.kind == kind)
            .all(|(joint, figures)| {
                let (min, max) = (size * figures.min, size * figures.max);
                match joint.range {
                    Some((lower, upper)) => {
                        min > lower - BEYOND_LIMITS && max < upper + BEYOND_LIMITS
                    }
                    None if kind == JointKind::Revolute => size * figures.range() <= WIDEST,
                    None => size * figures.range() <= LONGEST,
                }
            })
    }

    /// Returns the units for each joint: one for the revolute and one for the prismatic joints.
    fn units(&self, turning: &'static str, sliding: &'static str) -> Conversion {
        let unit = |(joint, _): (&JointOfStart, &Figures)| match joint.kind {
            JointKind::Revolute => turning,
            JointKind::Prismatic => sliding,
        };
        Conversion {
            units: self.joints().map(unit).collect(),
            counts: vec![None; self.joints.len()],
            signs: vec![1.0; self.joints.len()],
        }
    }

    /// Returns the widest range of the readings, in words.
    fn widest(&self) -> String {
        let widest = (self.joints()).max_by(|(_, a), (_, b)| a.range().total_cmp(&b.range()));
        widest.map_or_else(String::new, |(joint, figures)| {
            format!(
                "{} reads {:.4} to {:.4}",
                joint.name,
                Short(figures.min),
                Short(figures.max)
            )
        })
    }

    fn has_limits(&self) -> bool {
        self.joints().any(|(joint, _)| joint.range.is_some())
    }
}

/// Returns the unit of positions by their names or their values.
///
/// - `is_motor`: whether the names are those of motors, perhaps before a gearbox.
pub(super) fn absolute(
    survey: &Survey,
    family: &Family,
    of: (&[JointOfStart], &[usize]),
    is_motor: bool,
) -> Reading {
    let joint_figures = JointFigures::of(survey, family, of);
    let reading = |conversion: Conversion, why: String| Reading {
        conversion,
        why,
        ..Reading::default()
    };
    if let Some(unit) = family.meaning.unit {
        let mut named = reading(
            in_unit(&joint_figures, unit),
            format!("In {unit} by their names"),
        );
        if unit == "counts" {
            named.open = Some(counts_open());
        } else if !(joint_figures.fit(JointKind::Revolute, size(Some(unit)))
            && joint_figures.fit(JointKind::Prismatic, size(Some(unit))))
            && (is_motor || joint_figures.has_limits())
        {
            named.gears = Some(vec![None; joint_figures.joints.len()]);
            named.why = format!(
                "In {unit} by their names; {}, which is beyond the limits of the joint, so they are taken \
                 before the gearbox",
                joint_figures.widest()
            );
        }
        return named;
    }
    let sliding = if joint_figures.fit(JointKind::Prismatic, 1.0) {
        "m"
    } else {
        "mm"
    };
    let limits = if joint_figures.has_limits() {
        "within the limits of the joints"
    } else {
        "a plausible range"
    };
    if joint_figures.fit(JointKind::Revolute, 1.0) {
        let why = format!(
            "In rad by their values: {}, {limits}",
            joint_figures.widest()
        );
        return reading(joint_figures.units("rad", sliding), why);
    }
    let counts = joint_figures.figures.iter().all(Figures::are_counts);
    if counts {
        return Reading {
            open: Some(counts_open()),
            ..reading(
                joint_figures.units("counts", sliding),
                format!(
                    "Counts of encoders by their values, integers: {}",
                    joint_figures.widest()
                ),
            )
        };
    }
    let beyond = joint_figures.widest();
    if joint_figures.fit(JointKind::Revolute, TAU / 360.0)
        && joint_figures.has_limits()
        && !is_motor
    {
        let why = format!(
            "In degrees by their values: {beyond}, which is beyond the limits of the joint in rad and \
             {limits} in degrees"
        );
        return reading(joint_figures.units("deg", sliding), why);
    }
    Reading {
        open: Some(format!(
            "FILL IN the unit, \"rad\", \"deg\", \"turns\" or \"counts\", and if they were taken before the \
             gearbox side = \"motor\" with gear_ratio of each joint: {beyond}"
        )),
        ..reading(joint_figures.units("rad", sliding), String::new())
    }
}

fn counts_open() -> String {
    "FILL IN the counts per turn of the encoders, after quadrature".to_owned()
}

fn in_unit(joint_figures: &JointFigures<'_>, unit: &'static str) -> Conversion {
    match unit {
        "m" | "mm" | "um" => joint_figures.units("rad", unit),
        _ => joint_figures.units(unit, "m"),
    }
}

/// Returns the unit of positions by their slopes over others of known unit.
///
/// - `slopes`: slope of the readings over the others in SI units, of each joint.
pub(super) fn by_slope(
    survey: &Survey,
    family: &Family,
    (robot, joints): (&[JointOfStart], &[usize]),
    slopes: &[Option<Slope>],
) -> Option<Reading> {
    let joint_figures = JointFigures::of(survey, family, (robot, joints));
    let slopes: Vec<Slope> = joints
        .iter()
        .map(|&joint| slopes[joint])
        .collect::<Option<_>>()?;
    let signs: Vec<f64> = slopes.iter().map(|slope| slope.value.signum()).collect();
    let all = |is: &dyn Fn(f64) -> bool, unit: f64| {
        slopes.iter().all(|slope| is(slope.value.abs() * unit))
    };
    let one = |ratio: f64| (ratio - 1.0).abs() < SAME_UNIT;
    let same = |ratio: f64| (ratio - 1.0).abs() < MAX_DIFFERENCE_OF_SLOPES;
    let geared = |ratio: f64| ratio > MIN_GEAR;
    let mut reading = Reading::default();
    let shown = || -> String {
        let words: Vec<String> = (joints.iter().zip(&slopes))
            .map(|(&joint, slope)| format!("{} {:.5}", robot[joint].name, Short(slope.value.abs())))
            .collect();
        words.join(", ")
    };
    let named = family.meaning.unit;
    let counts = named == Some("counts")
        || (named.is_none()
            && joint_figures.figures.iter().all(Figures::are_counts)
            && all(&geared, 1.0));
    if counts {
        let found: Vec<CountsPerTurn> = slopes.iter().map(CountsPerTurn::of).collect();
        reading.conversion = joint_figures.units("counts", "m");
        reading.conversion.counts = found.iter().map(|found| found.value).collect();
        let words: Vec<String> = (joints.iter().zip(&found))
            .map(|(&joint, found)| format!("{} {}", robot[joint].name, found.why))
            .collect();
        let words = words.join(", ");
        if found.iter().any(|found| found.value.is_none()) {
            reading.open = Some(format!(
                "FILL IN the counts per turn: by the slope over the other position they are impossible. {words}"
            ));
        } else {
            reading.why = format!(
                "Counts; counts per turn of the joint by the slope over the other position, so they contain the \
                 gear ratio: {words}"
            );
        }
    } else if let Some(unit) = named {
        reading.conversion = in_unit(&joint_figures, unit);
        reading.why = format!("In {unit} by their names");
        if all(&geared, size(named)) {
            reading.gears = Some(gears(&slopes, size(named)));
        }
    } else if all(&same, 1.0) {
        reading.conversion = joint_figures.units("rad", "m");
        reading.why = String::from("In the unit of the other position: the two have a slope of 1");
    } else if all(&one, size(Some("deg"))) {
        reading.conversion = joint_figures.units("deg", "m");
        reading.why = format!(
            "In degrees by their slope over the other position: {}",
            shown()
        );
    } else if all(&one, TAU) {
        reading.conversion = joint_figures.units("turns", "m");
        reading.why = format!(
            "In turns by their slope over the other position: {}",
            shown()
        );
    } else if all(&geared, 1.0) {
        reading.conversion = joint_figures.units("rad", "m");
        reading.gears = Some(gears(&slopes, 1.0));
    } else {
        return None;
    }
    if reading.gears.is_some() {
        reading.why = format!(
            "{}{}before the gearbox by their slope over the other position: {}",
            reading.why,
            if reading.why.is_empty() {
                "In rad, "
            } else {
                ", "
            },
            shown()
        );
    }
    if signs.iter().any(|sign| *sign < 0.0) {
        reading
            .why
            .push_str(". The sign is -1 where they count against the other position");
    }
    reading.conversion.signs = signs;
    Some(reading)
}

/// Counts per turn of usual encoders, after quadrature.
const USUAL_ENCODERS: [f64; 21] = [
    360.0,
    400.0,
    1000.0,
    1024.0,
    2000.0,
    2048.0,
    3600.0,
    4000.0,
    4096.0,
    5000.0,
    8000.0,
    8192.0,
    10_000.0,
    16_384.0,
    20_000.0,
    32_768.0,
    65_536.0,
    131_072.0,
    262_144.0,
    524_288.0,
    1_048_576.0,
];

/// Counts per turn of a joint, and the reason; without value if they are those of an encoder only with another unit of
/// the other position.
#[derive(Clone, Debug, PartialEq)]
struct CountsPerTurn {
    value: Option<f64>,
    why: String,
}

impl CountsPerTurn {
    fn of(slope: &Slope) -> Self {
        let value = slope.value.abs() * TAU;
        let error = SIGMAS * slope.error * TAU + BIAS * value;
        if let Some((counts, product)) = encoder(value, error) {
            return Self {
                value: Some(counts),
                why: format!("{product} = {counts}"),
            };
        }
        let in_degrees = 360.0 / TAU;
        for (factor, named, held) in [
            (in_degrees, "deg", "rad"),
            (in_degrees.recip(), "rad", "deg"),
        ] {
            if let Some((_, product)) = encoder(value / factor, error / factor) {
                return Self {
                    value: None,
                    why: format!(
                        "{:.7}, which is {:.3} times {product}: the name of the other position says {named}, and its \
                         values are in {held}",
                        Short(value),
                        Short(factor)
                    ),
                };
            }
        }
        Self {
            value: Some(rounded(value)),
            why: format!("{:.7}, of no usual encoder and gear", Short(value)),
        }
    }
}

/// Returns the only product of the counts of a usual encoder and a usual gear ratio in the interval of a number, and
/// the product in words.
fn encoder(value: f64, error: f64) -> Option<(f64, String)> {
    // Of several products with one value the first is named.
    let gears = [1.0, 100.0].into_iter().chain(USUAL_GEARS);
    let products =
        gears.flat_map(|gear| USUAL_ENCODERS.map(|encoder| (encoder * gear, encoder, gear)));
    let mut within = products.filter(|(product, ..)| (value - product).abs() <= error);
    let (product, encoder, gear) = within.next()?;
    // The same product of another encoder is the same number.
    let is_same = |(other, ..): (f64, f64, f64)| (other - product).abs() < 0.5;
    within
        .all(is_same)
        .then(|| (product, format!("{encoder} × {gear}")))
}

/// Returns gear ratios by slopes.
fn gears(slopes: &[Slope], unit: f64) -> Vec<Option<Gear>> {
    (slopes.iter())
        .map(|slope| {
            let value = slope.value.abs() * unit;
            Some(gear(value, SIGMAS * slope.error * unit + BIAS * value))
        })
        .collect()
}

/// Returns the only usual gear ratio in the interval of a slope, else a multiple of 0.5 if the slope separates such
/// multiples, else the slope.
fn gear(value: f64, error: f64) -> Gear {
    let is_within = |ratio: &f64| (value - ratio).abs() <= error;
    let usual: Vec<f64> = USUAL_GEARS.into_iter().filter(is_within).collect();
    let near = (2.0 * value).round() / 2.0;
    let (ratio, what) = match usual[..] {
        [only] => (only, format!("{only} is the only usual gear ratio within")),
        _ if is_within(&near) && error < MAX_ERROR => {
            (near, format!("{near} is the only multiple of 0.5 within"))
        }
        [] => (
            rounded(value),
            "no usual gear ratio lies within, so the slope counts".to_owned(),
        ),
        [..] => {
            let all: Vec<String> = usual.iter().map(f64::to_string).collect();
            (
                rounded(value),
                format!("{} lie within, so the slope counts", all.join(" and ")),
            )
        }
    };
    Gear {
        ratio,
        why: format!(
            "By the slope of the motor position over the link position, {:.5} ± {:.1}: {what}; correct it by the \
             data sheet",
            Short(value),
            Short(error)
        ),
    }
}

fn rounded(value: f64) -> f64 {
    let scale = 10f64.powi(6 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// Returns the units of torques.
pub(super) fn of_torques(
    family: &Family,
    robot: &[JointOfStart],
    joints: &[usize],
    usual: Option<&'static str>,
) -> Conversion {
    let unit = |&joint: &usize| {
        let kind = robot[joint].kind;
        family.meaning.unit.or(usual).unwrap_or(si(kind, false))
    };
    Conversion {
        units: joints.iter().map(unit).collect(),
        counts: vec![None; joints.len()],
        signs: vec![1.0; joints.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_per_turn_are_those_of_an_encoder_and_a_gear_within_their_interval() {
        let degree = 360.0 / TAU;
        for (counts, error, value, said) in [
            (819_150.0, 20.0, Some(819_200.0), "8192 × 100 = 819200"),
            (16_384.5, 1.0, Some(16_384.0), "16384 × 1 = 16384"),
            (
                819_200.0 * degree,
                10.0,
                None,
                "57.3 times 8192 × 100: the name of the other position says deg",
            ),
            (
                819_200.0 / degree,
                1.0,
                None,
                "0.0175 times 8192 × 100: the name of the other position says rad",
            ),
            (
                777_777.0,
                10.0,
                Some(777_777.0),
                "777777, of no usual encoder and gear",
            ),
            // The interval holds several products.
            (819_200.0, 300_000.0, Some(819_200.0), "819200, of no usual"),
        ] {
            let slope = Slope {
                value: -counts / TAU,
                error: error / TAU,
            };
            let found = CountsPerTurn::of(&slope);
            assert!(found.why.contains(said), "{found:?}");
            let near = match (found.value, value) {
                (Some(found), Some(value)) => (found - value).abs() < 0.5,
                (found, value) => found == value,
            };
            assert!(near, "{found:?}");
        }
    }

    #[test]
    fn a_gear_ratio_is_the_only_usual_one_or_the_slope() {
        for (value, error, ratio, said) in [
            (
                100.4,
                0.5,
                100.0,
                "100.4 ± 0.5: 100 is the only usual gear ratio within",
            ),
            (120.9, 0.02, 120.9, "no usual gear ratio lies within"),
            (100.4, 0.7, 100.4, "100 and 101 lie within"),
            (
                120.51,
                0.03,
                120.5,
                "120.5 is the only multiple of 0.5 within",
            ),
            (51.0, 0.01, 51.0, "51 is the only usual gear ratio within"),
        ] {
            let found = gear(value, error);
            assert_eq!(found.ratio.to_bits(), f64::to_bits(ratio), "{found:?}");
            assert!(found.why.contains(said), "{found:?}");
        }
    }
}
