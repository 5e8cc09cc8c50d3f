//! Lines of `[log]` that name columns.

use super::context::CheckContext;
use crate::description::{Log, Quantity};
use crate::log::Channels;

impl CheckContext<'_> {
    /// Returns the lines that give the positions of some joints in another unit.
    ///
    /// - `unit`: `deg` or `rad`; the other joints keep the other of the two.
    pub(super) fn unit_lines(&self, joints: &[usize], unit: &str) -> String {
        let other = if unit == "deg" { "rad" } else { "deg" };
        let channels = self.reading.channels();
        let lines: Vec<String> = [
            Quantity::LinkPosition,
            Quantity::LinkDeflection,
            Quantity::MotorPosition,
        ]
        .into_iter()
        .filter_map(|quantity| {
            let columns = columns(channels, quantity);
            if !columns.iter().any(|(joint, _)| joints.contains(joint)) {
                return None;
            }
            let key = quantity.key();
            let turning: Vec<(usize, &str)> = (columns.iter().copied())
                .filter(|(joint, _)| channels.turns[*joint])
                .collect();
            if turning.iter().all(|(joint, _)| joints.contains(joint)) {
                return Some(format!("{key}_{unit} = {}", list(&turning)));
            }
            let tables: Vec<String> = (columns.iter())
                .map(|(joint, column)| {
                    let unit = match (joints.contains(joint), channels.turns[*joint]) {
                        (_, false) => "m",
                        (true, true) => unit,
                        (false, true) => other,
                    };
                    format!("{{ column = \"{column}\", unit = \"{unit}\" }}")
                })
                .collect();
            Some(format!("{key} = [{}]", tables.join(", ")))
        })
        .collect();
        lines.join("\n")
    }

    /// Returns the lines of the keys whose columns differ, with the columns of other channels.
    pub(super) fn column_lines(&self, channels: &Channels) -> String {
        let given = self.experiment.log.iter().flat_map(Log::given);
        let lines: Vec<String> = given
            .filter_map(|(key, _)| {
                let of_kind = |channels| {
                    let all = columns(channels, key.quantity);
                    let has_kind = |joint| {
                        let joint_kind = self.reading.model().kind(joint);
                        key.kind.is_none_or(|kind| kind == joint_kind)
                    };
                    let kept = all.into_iter().filter(|(joint, _)| has_kind(*joint));
                    kept.collect::<Vec<_>>()
                };
                let (now, before) = (of_kind(channels), of_kind(self.reading.channels()));
                (now != before).then(|| format!("{} = {}", key.name, list(&now)))
            })
            .collect();
        lines.join("\n")
    }

    /// Returns the key of `[log]` under which the columns of a quantity are named.
    pub(super) fn key(&self, quantity: Quantity) -> &'static str {
        let log = self.experiment.log.as_ref();
        log.and_then(|log| log.given().find(|(key, _)| key.quantity == quantity))
            .map_or(quantity.key(), |(key, _)| key.name)
    }

    /// Returns the list of the columns of a quantity, of revolute joints if there are any.
    pub(super) fn column_list(&self, quantity: Quantity) -> String {
        let channels = self.reading.channels();
        let mut columns = columns(channels, quantity);
        if columns.iter().any(|(joint, _)| channels.turns[*joint]) {
            columns.retain(|(joint, _)| channels.turns[*joint]);
        }
        list(&columns)
    }
}

/// Returns the joints that have a quantity, in order, with their columns.
fn columns(channels: &Channels, quantity: Quantity) -> Vec<(usize, &str)> {
    let mut all: Vec<(usize, &str)> = (channels.all.iter())
        .filter(|channel| channel.quantity == quantity)
        .map(|channel| (channel.joint, channel.column.as_str()))
        .collect();
    all.sort_unstable();
    all
}

fn list(columns: &[(usize, &str)]) -> String {
    let names: Vec<String> = (columns.iter())
        .map(|(_, column)| format!("\"{column}\""))
        .collect();
    format!("[{}]", names.join(", "))
}
