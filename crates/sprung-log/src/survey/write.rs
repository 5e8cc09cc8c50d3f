//! Lines of `[log]` for families of columns.

use std::fmt;

use sprung_core::chain::JointKind;

use super::families::{Family, Place};
use super::read::{Column, Source, Survey};
use crate::description::{ChosenLine, JointOfStart, quoted};
use crate::formats::table::ElementPlace;

/// How the readings of a quantity are converted.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Conversion {
    /// Unit of each joint of the log.
    pub(super) units: Vec<&'static str>,
    /// Counts per turn of each joint, if the unit is counts; `None` is to be filled in.
    pub(super) counts: Vec<Option<f64>>,
    /// Sign of each joint.
    pub(super) signs: Vec<f64>,
}

/// A number with few digits, without trailing zeros.
pub(super) struct Short(pub(super) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(6) as i32;
        if self.0 == 0.0 || !self.0.is_finite() {
            return write!(f, "{}", self.0);
        }
        let scale = 10f64.powi(digits - 1 - self.0.abs().log10().floor() as i32);
        let rounded = (self.0 * scale).round() / scale;
        let size = rounded.abs();
        if (1e-4..1e9).contains(&size) {
            write!(f, "{rounded}")
        } else {
            write!(f, "{rounded:e}")
        }
    }
}

/// Returns a number as TOML, which distinguishes floats from integers by their point.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value}");
    if text.contains(['.', 'e']) {
        text
    } else {
        format!("{text}.0")
    }
}

/// Returns the name of a column of a table as TOML: its number if the name is not unique.
pub(super) fn name_of(survey: &Survey, column: &Column) -> String {
    let same = |other: &&Column| other.name == column.name;
    let is_in = |source: &&Source| {
        source
            .columns
            .iter()
            .any(|other| std::ptr::eq(other, column))
    };
    let source = survey.sources.iter().find(is_in);
    let columns = source.into_iter().flat_map(|source| &source.columns);
    let is_unique = columns.filter(same).count() == 1 && !survey.others.contains(&column.name);
    if survey.has_names && is_unique {
        quoted(&column.name)
    } else {
        column.number.to_string()
    }
}

/// Returns values as TOML: one if all are equal, otherwise a list.
fn one_or_list(values: &[String]) -> String {
    match values {
        [first, rest @ ..] if rest.iter().all(|value| value == first) => first.clone(),
        _ => format!("[{}]", values.join(", ")),
    }
}

/// Key of a quantity with the unit in its name.
fn key_in_unit(stem: &str, unit: &str) -> Option<&'static str> {
    Some(match (stem, unit) {
        ("link_position", "rad") => "link_position_rad",
        ("link_position", "deg") => "link_position_deg",
        ("link_position", "m") => "link_position_m",
        ("link_deflection", "rad") => "link_deflection_rad",
        ("link_deflection", "deg") => "link_deflection_deg",
        ("motor_position", "rad") => "motor_position_rad",
        ("motor_position", "deg") => "motor_position_deg",
        ("motor_position", "m") => "motor_position_m",
        ("motor_torque", "N·m") => "motor_torque_nm",
        ("motor_torque", "N") => "motor_force_n",
        ("joint_torque", "N·m") => "joint_torque_nm",
        ("joint_torque", "N") => "joint_force_n",
        ("motor_current", "A") => "motor_current_a",
        ("drive_voltage", "V") => "drive_voltage_v",
        _ => return None,
    })
}

/// Returns the lines for the columns of a quantity.
///
/// - `stem`: its key without unit; `joints`: indices of the joints.
pub(super) fn lines(
    survey: &Survey,
    (stem, family): (&str, &Family),
    (robot, joints): (&[JointOfStart], &[usize]),
    conversion: &Conversion,
    why: &str,
) -> Vec<ChosenLine> {
    let places: Vec<Place> = joints
        .iter()
        .filter_map(|&joint| family.of[joint])
        .collect();
    let is_bag = |place: &Place| survey.sources[place.0].topic.is_some();
    let file = |place: &Place| survey.sources[place.0].file.as_ref();
    let in_key = |unit: &str| key_in_unit(stem, unit);
    let plain = conversion.units.iter().all(|unit| in_key(unit).is_some())
        && conversion.signs.iter().all(|sign| *sign > 0.0);
    let is_in_log = |place: &Place| !is_bag(place) && file(place).is_none();
    if plain && places.iter().all(is_in_log) {
        return by_unit(survey, &places, conversion, &in_key, why);
    }
    let value = if places.iter().any(is_bag) {
        in_topic(survey, &places, (robot, joints), conversion)
    } else if places.iter().any(|place| file(place) != file(&places[0])) {
        None
    } else {
        let names: Vec<String> = places.iter().map(|place| name_at(survey, *place)).collect();
        together(
            &format!(
                "{}column = {}",
                in_file(survey, places.first()),
                as_list(&names)
            ),
            &(0..places.len()).collect::<Vec<_>>(),
            conversion,
        )
    };
    let value = value.unwrap_or_else(|| {
        let each =
            (0..places.len()).map(|k| alone(survey, places[k], k, (robot, joints), conversion));
        format!("[{}]", each.collect::<Vec<_>>().join(", "))
    });
    vec![ChosenLine::new(stem, value, why)]
}

/// Returns the keys of a column in another file of the recording; nothing for the log itself.
fn in_file(survey: &Survey, place: Option<&Place>) -> String {
    match place.and_then(|place| survey.sources[place.0].file.as_ref()) {
        None => String::new(),
        Some((file, time)) => format!("file = {}, time = {time}, ", quoted(file)),
    }
}

fn as_list(values: &[String]) -> String {
    match values {
        [one] => one.clone(),
        _ => format!("[{}]", values.join(", ")),
    }
}

fn name_at(survey: &Survey, (source, column): Place) -> String {
    name_of(survey, &survey.sources[source].columns[column])
}

/// Returns a line for each unit that the key can have in its name.
fn by_unit(
    survey: &Survey,
    places: &[Place],
    conversion: &Conversion,
    in_key: &dyn Fn(&str) -> Option<&'static str>,
    why: &str,
) -> Vec<ChosenLine> {
    let mut units: Vec<&str> = conversion.units.clone();
    units.dedup();
    units.sort_unstable();
    units.dedup();
    let mut all = Vec::new();
    for unit in units {
        let names: Vec<String> = (places.iter().zip(&conversion.units))
            .filter(|(_, other)| **other == unit)
            .map(|(place, _)| name_at(survey, *place))
            .collect();
        let why = if all.is_empty() { why } else { "" };
        let key = in_key(unit).unwrap_or_default();
        all.push(ChosenLine::new(key, format!("[{}]", names.join(", ")), why));
    }
    all
}

/// Returns the table of one entry for all joints; `None` if their units differ.
///
/// - `of`: the joints among those of the conversion.
fn together(source: &str, of: &[usize], conversion: &Conversion) -> Option<String> {
    let unit = conversion.units[*of.first()?];
    if of.iter().any(|&k| conversion.units[k] != unit) {
        return None;
    }
    let mut parts = vec![source.to_owned(), format!("unit = \"{unit}\"")];
    if unit == "counts" {
        let counts: Vec<String> = of.iter().map(|&k| counts(conversion, k)).collect();
        parts.push(format!("counts_per_turn = {}", one_or_list(&counts)));
    }
    if of.iter().any(|&k| conversion.signs[k] < 0.0) {
        let signs: Vec<String> = of
            .iter()
            .map(|&k| conversion.signs[k].to_string())
            .collect();
        parts.push(format!("sign = {}", one_or_list(&signs)));
    }
    Some(format!("{{ {} }}", parts.join(", ")))
}

fn counts(conversion: &Conversion, k: usize) -> String {
    match conversion.counts.get(k).copied().flatten() {
        Some(counts) => number(counts),
        None => format!("\"{}\"", crate::description::FILL_IN),
    }
}

/// Returns the table of a topic that holds all joints; `None` if several topics do, or units differ.
fn in_topic(
    survey: &Survey,
    places: &[Place],
    (robot, joints): (&[JointOfStart], &[usize]),
    conversion: &Conversion,
) -> Option<String> {
    let (source, _) = *places.first()?;
    let topic = survey.sources[source].topic.as_ref()?;
    let column = |place: &Place| &survey.sources[place.0].columns[place.1];
    let field = &column(&places[0]).name;
    if places.iter().any(|place| place.0 != source) {
        return None;
    }
    let mut parts = vec![format!("topic = {}", quoted(topic))];
    let named = |place: &Place| match &column(place).place {
        ElementPlace::Named(name) => Some(name.clone()),
        ElementPlace::Alone | ElementPlace::Index(_) => None,
    };
    match places.iter().map(named).collect::<Option<Vec<String>>>() {
        Some(names) if places.iter().all(|place| column(place).name == *field) => {
            parts.push(format!("field = {}", quoted(field)));
            if names
                .iter()
                .zip(joints)
                .any(|(name, &joint)| *name != robot[joint].name)
            {
                let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
                parts.push(format!("joint_names = [{}]", names.join(", ")));
            }
        }
        _ => {
            let fields: Vec<String> = (places.iter())
                .map(|place| quoted(&column(place).label()))
                .collect();
            parts.push(format!("field = {}", as_list(&fields)));
        }
    }
    together(
        &parts.join(", "),
        &(0..places.len()).collect::<Vec<_>>(),
        conversion,
    )
}

/// Returns the table of the entry of one joint.
fn alone(
    survey: &Survey,
    place: Place,
    k: usize,
    (robot, joints): (&[JointOfStart], &[usize]),
    conversion: &Conversion,
) -> String {
    let source = match &survey.sources[place.0].topic {
        None => {
            let file = in_file(survey, Some(&place));
            format!("{file}column = {}", name_at(survey, place))
        }
        Some(topic) => {
            let column = &survey.sources[place.0].columns[place.1];
            let topic = format!("topic = {}", quoted(topic));
            match &column.place {
                ElementPlace::Named(name) if *name != robot[joints[k]].name => format!(
                    "{topic}, field = {}, joint_names = [{}]",
                    quoted(&column.name),
                    quoted(name)
                ),
                ElementPlace::Named(_) => format!("{topic}, field = {}", quoted(&column.name)),
                ElementPlace::Alone | ElementPlace::Index(_) => {
                    format!("{topic}, field = {}", quoted(&column.label()))
                }
            }
        }
    };
    together(&source, &[k], conversion).unwrap_or_default()
}

/// Returns the SI unit of a position, or of a torque.
pub(super) fn si(kind: JointKind, is_position: bool) -> &'static str {
    match (kind, is_position) {
        (JointKind::Revolute, true) => "rad",
        (JointKind::Prismatic, true) => "m",
        (JointKind::Revolute, false) => "N·m",
        (JointKind::Prismatic, false) => "N",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        let short = |x: f64| format!("{:.4}", Short(x));
        assert_eq!(short(1000.0), "1000");
        assert_eq!(short(101.4836), "101.5");
        assert_eq!(short(0.012_345_6), "0.01235");
        assert_eq!(short(-3.0), "-3");
        assert_eq!(short(0.0), "0");
        assert_eq!(number(100.0), "100.0");
        assert_eq!(number(0.5), "0.5");
    }
}
