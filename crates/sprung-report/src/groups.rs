//! Groups parameters by their joints.

use crate::estimate::Identification;
use crate::named::Named;

/// The joints of a robot and the links that they move, base first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Joints {
    joints: Vec<String>,
    links: Vec<String>,
}

impl Joints {
    /// Finds the joints in the rows of the residuals: those of the joints come first.
    pub(super) fn of_rows(rows: &Named) -> Self {
        let mut joints: Vec<String> = Vec::new();
        for (row, _) in rows.iter() {
            let joint = row.rsplit_once('.').map_or(row, |(joint, _)| joint);
            if !joints.iter().any(|known| known == joint) {
                joints.push(joint.to_owned());
            }
        }
        Self::of_names(joints)
    }

    /// Returns the joints of these names, base first, with numbered links.
    pub(super) fn of_names(joints: Vec<String>) -> Self {
        let links = (1..=joints.len()).map(|i| format!("link{i}")).collect();
        Self { joints, links }
    }

    /// Finds the joints of an identification. A tree names its links in the standard parameters.
    pub(super) fn of(identification: &Identification) -> Self {
        let Some(result) = identification.results.first() else {
            return Self::default();
        };
        let mut found = Self::of_rows(&result.residual_rms);
        let mut links: Vec<String> = Vec::new();
        for parameter in &result.standard_parameters {
            let Some((link, _)) = parameter.name.rsplit_once('.') else {
                continue;
            };
            let is_known = |names: &[String]| names.iter().any(|known| known == link);
            if !is_known(&links) && !is_known(&found.joints) {
                links.push(link.to_owned());
            }
        }
        if links.len() == found.joints.len() {
            found.links = links;
        }
        found
    }

    /// Returns the names of the joints, base first.
    pub(super) fn names(&self) -> &[String] {
        &self.joints
    }

    /// Returns the joint of a parameter, or of the first of combined ones. A link belongs to the
    /// joint that moves it; another name is a separate group.
    pub(super) fn group<'a>(&'a self, parameter: &'a str) -> &'a str {
        let of = |names: &[String]| {
            names
                .iter()
                .position(|name| rest(parameter, name).is_some())
        };
        match of(&self.joints).or_else(|| of(&self.links)) {
            Some(joint) => &self.joints[joint],
            None => parameter
                .split_once('.')
                .map_or(parameter, |(group, _)| group),
        }
    }

    /// Sorts items by the joints of their parameters, base first; items of one joint keep their
    /// order.
    pub(super) fn sorted<T>(
        &self,
        items: impl IntoIterator<Item = T>,
        name: impl Fn(&T) -> &str,
    ) -> Vec<T> {
        let place = |item: &T| {
            let group = self.group(name(item));
            let known = self.joints.iter().position(|joint| joint == group);
            known.unwrap_or(self.joints.len())
        };
        let mut items: Vec<T> = items.into_iter().collect();
        items.sort_by_key(place);
        items
    }

    /// Returns the headings above parameters that are sorted by their groups, each with the index of the first one of its group.
    pub(super) fn headings<'a>(
        &self,
        sorted: impl Iterator<Item = &'a str>,
    ) -> Vec<(usize, String)> {
        let mut headings: Vec<(usize, String)> = Vec::new();
        for (i, name) in sorted.enumerate() {
            let group = self.group(name);
            if headings.last().is_none_or(|(_, last)| last != group) {
                headings.push((i, group.to_owned()));
            }
        }
        headings
    }

    /// Returns the name of a parameter within its group: without the joint, but with the link.
    pub(super) fn within<'a>(&self, parameter: &'a str) -> &'a str {
        let mut parts = self
            .joints
            .iter()
            .filter_map(|joint| rest(parameter, joint));
        parts.next().unwrap_or(parameter)
    }
}

/// Returns the part of a parameter's name after that of its joint or link, which may contain dots.
fn rest<'a>(parameter: &'a str, owner: &str) -> Option<&'a str> {
    parameter.strip_prefix(owner)?.strip_prefix('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_stand_beside_the_joints_that_move_them() {
        let rows = [
            "ba.se.link_nm",
            "tip.link_nm",
            "ba.se.motor_nm",
            "tip.motor_nm",
        ];
        let rows: Named = rows.iter().map(|row| ((*row).to_owned(), 0.0)).collect();
        let joints = Joints::of_rows(&rows);
        let names = [
            "link2.izz + 0.1*link3.m",
            "tip.stiffness",
            "other.mass",
            "link1.m",
            "ba.se.stiffness",
        ];
        assert_eq!(
            joints.sorted(names, |name| name),
            [names[3], names[4], names[0], names[1], names[2]]
        );
        assert_eq!(joints.group(names[0]), "tip");
        assert_eq!(joints.group("other.mass"), "other");
        assert_eq!(joints.within("tip.stiffness"), "stiffness");
        assert_eq!(joints.within("ba.se.stiffness"), "stiffness");
        assert_eq!(joints.within("link1.m"), "link1.m");
    }
}
