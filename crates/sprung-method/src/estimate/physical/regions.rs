//! Findings about the places of masses.

use crate::description::{NoShape, Tree};
use crate::finding::{Finding, Severity};
use crate::model::Region;

/// Number of reasons that a text names.
const NAMED: usize = 3;

/// Reports links whose geometry cannot be used, and nominal bodies outside the geometry.
///
/// - `outside`: links with such nominal bodies.
pub(super) fn about_regions(tree: &Tree, outside: &[String]) -> Vec<Finding> {
    let (mut units, mut others) = (Vec::new(), Vec::new());
    for (link, fault) in (0..)
        .zip(&tree.shapes)
        .filter_map(|(at, shape)| Some((at, shape.as_ref().err()?)))
    {
        if fault.is_of_another_unit() {
            units.push((link, fault));
        } else if *fault != NoShape::Table {
            others.push((link, fault));
        }
    }
    [
        instead(tree, "geometry-unit", &units),
        instead(tree, "links-without-geometry", &others),
        nominal_outside(outside),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Returns the finding that another region replaces the geometry of links.
fn instead(tree: &Tree, code: &str, faults: &[(usize, &NoShape)]) -> Option<Finding> {
    if faults.is_empty() {
        return None;
    }
    let regions = Region::all(tree);
    let of = |bounded: bool| -> Vec<&str> {
        let links = faults
            .iter()
            .filter(|(link, _)| regions[*link].is_some() == bounded);
        links.map(|(link, _)| tree.links[*link].as_str()).collect()
    };
    let (balls, none) = (of(true), of(false));
    let mut parts = Vec::new();
    if !balls.is_empty() {
        parts.push(format!(
            "the mass of {} lies in a ball about the joints",
            balls.join(", ")
        ));
    }
    if !none.is_empty() {
        parts.push(format!(
            "the place of the mass of {} has no limit, because it may carry a tool",
            none.join(", ")
        ));
    }
    let no_geometry = tree
        .shapes
        .iter()
        .all(|shape| matches!(shape, Err(NoShape::Absent { .. })));
    let reasons = if no_geometry {
        "the URDF has no <collision> or <visual>".to_owned()
    } else {
        let mut named: Vec<String> = faults
            .iter()
            .take(NAMED)
            .map(|(_, fault)| fault.to_string())
            .collect();
        if faults.len() > NAMED {
            named.push(format!("{} other links", faults.len() - NAMED));
        }
        named.join("; ")
    };
    let mut remedies: Vec<String> = faults.iter().map(|(_, fault)| fault.remedy()).collect();
    remedies.dedup();
    remedies.truncate(NAMED);
    Some(Finding::new(
        Severity::Info,
        code,
        format!("{reasons}. Without geometry {}", parts.join(", and ")),
        &remedies.join("; "),
    ))
}

fn nominal_outside(links: &[String]) -> Option<Finding> {
    if links.is_empty() {
        return None;
    }
    Some(Finding::new(
        Severity::Info,
        "nominal-body-outside",
        format!(
            "the mass of the nominal body of {} lies outside the geometry of the link, so one of them is wrong. The place \
             of this mass has no limit",
            links.join(", ")
        ),
        "compare <inertial> and <collision> in the URDF: frames, units, and the scale of meshes",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{NamedFiles, read};
    use std::io;
    use std::path::Path;

    const EXPERIMENT: &str = r#"
        format = 1
        [robot]
        urdf = "arm.urdf"
        [[robot.joint]]
        name = "shoulder"
        [[robot.joint]]
        name = "elbow"
    "#;

    /// A URDF with one broken mesh.
    struct Files(String);

    impl NamedFiles for Files {
        fn text(&mut self, _: &Path) -> io::Result<String> {
            Ok(self.0.clone())
        }

        fn bytes(&mut self, path: &Path, _: u64) -> io::Result<Vec<u8>> {
            match path.to_str() {
                Some("broken.stl") => Ok(vec![0; 84]),
                _ => Err(io::ErrorKind::NotFound.into()),
            }
        }
    }

    fn findings(upper: &str, fore: &str, outside: &[&str]) -> Vec<Finding> {
        let form = |shape: &str| match shape {
            "" => String::new(),
            shape => format!("<collision><geometry>{shape}</geometry></collision>"),
        };
        let urdf = format!(
            "<robot name='arm'><link name='base'/><link name='upper'>{}</link><link name='fore'>{}</link>
             <joint name='shoulder' type='continuous'><parent link='base'/><child link='upper'/></joint>
             <joint name='elbow' type='continuous'><parent link='upper'/><child link='fore'/>
             <origin xyz='0.4 0 0'/></joint></robot>",
            form(upper),
            form(fore)
        );
        let experiment = read("arm.toml", EXPERIMENT, &[], &mut Files(urdf)).unwrap();
        let outside: Vec<String> = outside.iter().map(|link| (*link).to_owned()).collect();
        about_regions(&experiment.robot.tree.unwrap(), &outside)
    }

    #[test]
    fn links_without_geometry_are_named_with_reason_and_remedy() {
        let sphere = "<sphere radius='0.1'/>";
        assert!(findings(sphere, sphere, &[]).is_empty());
        let found = findings(
            "<mesh filename='broken.stl'/>",
            "<mesh filename='absent.stl'/>",
            &[],
        );
        let [found] = &found[..] else {
            panic!("{found:?}")
        };
        assert_eq!(
            (found.code.as_str(), found.severity),
            ("links-without-geometry", Severity::Info)
        );
        for fragment in [
            "broken.stl of upper is broken",
            "absent.stl of fore cannot",
            "mass of upper lies in a ball",
            "mass of fore has no limit",
        ] {
            assert!(found.text.contains(fragment), "{}", found.text);
        }
        assert!(
            found.remedy.contains("export the mesh again"),
            "{}",
            found.remedy
        );
        let found = findings("", "", &[]);
        assert!(
            found[0].text.starts_with("the URDF has no <collision>"),
            "{}",
            found[0].text
        );
    }

    #[test]
    fn wrong_units_and_nominal_bodies_outside_have_findings_of_their_own() {
        let found = findings(
            "<box size='400 50 50'/>",
            "<sphere radius='0.1'/>",
            &["fore"],
        );
        let codes: Vec<&str> = found.iter().map(|finding| finding.code.as_str()).collect();
        assert_eq!(codes, ["geometry-unit", "nominal-body-outside"]);
        assert!(found[0].text.contains("400 m long") && found[0].remedy.contains("in metres"));
        assert!(found[1].text.contains("fore"));
    }
}
