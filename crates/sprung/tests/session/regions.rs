//! The geometry of a URDF, and the places of masses.

use sprung_base::progress::Unheard;
use sprung_method::estimate::Identification;

use crate::support::recorded;
use crate::what_works::{ARM, Files, session};

/// The arm by a URDF without bodies.
fn urdf(link1: &str, link2: &str) -> String {
    format!(
        "<robot name='arm'><link name='base'/><link name='link1'>{link1}</link><link name='link2'>{link2}</link>
         <joint name='joint1' type='continuous'><parent link='base'/><child link='link1'/><axis xyz='0 0 1'/></joint>
         <joint name='joint2' type='continuous'><parent link='link1'/><child link='link2'/>
         <origin xyz='0.343 0 0'/><axis xyz='0 0 1'/></joint></robot>"
    )
}

/// Six corners of a cube of 40 mm about the joint, in ASCII.
const STL: &str = "solid link
facet normal 0 0 0
outer loop
vertex -20 -20 -20
vertex 20 20 -20
vertex 20 -20 20
endloop
endfacet
facet normal 0 0 0
outer loop
vertex -20 20 20
vertex 20 -20 -20
vertex 20 20 20
endloop
endfacet
endsolid link
";

/// A log of the arm.
fn log() -> Vec<u8> {
    recorded(&session(&Files::new(), ARM, &[]).unwrap())
}

fn identified(log: &[u8], urdf: &str, constraints: &str) -> Identification {
    let (head, rest) = ARM.split_once("dh_modified").unwrap();
    let (_, rest) = rest.split_once("[[robot.joint]]").unwrap();
    let text = format!("{head}urdf = \"arm/robot/arm.urdf\"\n[[robot.joint]]{rest}");
    let files = Files::from([
        ("0.csv".to_owned(), log.to_vec()),
        ("arm/robot/arm.urdf".to_owned(), urdf.as_bytes().to_vec()),
        ("arm/meshes/link1.stl".to_owned(), STL.as_bytes().to_vec()),
    ]);
    let overrides = [format!("identify.constraints=\"{constraints}\"")];
    let session = session(&files, &text, &overrides).unwrap();
    session.identify(&mut Unheard).unwrap().identification
}

#[test]
fn geometry_moves_bodies_only_where_the_log_does_not_decide() {
    let log = log();
    let mesh = "<collision><geometry><mesh filename='package://arm/meshes/link1.stl' scale='0.001 0.001 0.001'/></geometry></collision>";
    let boxed =
        "<visual><origin xyz='0.1 0 0'/><geometry><box size='0.3 0.06 0.06'/></geometry></visual>";
    let with = identified(&log, &urdf(mesh, boxed), "possible");
    let without = identified(&log, &urdf("", ""), "possible");
    let worst = (with.results[0].parameters.iter())
        .zip(&without.results[0].parameters)
        .map(|(a, b)| {
            let moved = (a.value.unwrap() - b.value.unwrap()).abs();
            moved / a.standard_error.unwrap()
        })
        .fold(0.0, f64::max);
    println!("largest change of a determined value: {worst:.4} standard errors");
    assert!(worst < 0.01, "{worst}");
    let body = |found: &Identification, name: &str| {
        let mut standard_parameters = found.results[0].standard_parameters.iter();
        standard_parameters
            .find(|parameter| parameter.name == name)
            .unwrap()
            .value
    };
    // The log determines izz of the first link plus 0.343² m of the second.
    let radius = |found| (body(found, "link1.izz") / body(found, "link1.m")).sqrt();
    let radii = [radius(&with), radius(&without)];
    println!("radii of gyration of the first link: {radii:.3?} m");
    assert!(radii[0] < 0.06 && radii[1] > 0.1, "{radii:?}");
    let told = |found: &Identification| {
        let mut all = found.results[0].warnings.iter();
        all.any(|finding| finding.code == "links-without-geometry")
    };
    assert!(!told(&with) && told(&without));
    assert!(!told(&identified(&log, &urdf("", ""), "none")));
}

#[test]
fn a_nominal_body_outside_its_geometry_is_named() {
    let log = log();
    let link = |x: f64| {
        let inertia = "<inertia ixx='0.002' ixy='0' ixz='0' iyy='0.004' iyz='0' izz='0.004'/>";
        format!(
            "<inertial><origin xyz='{x} 0 0'/><mass value='0.5'/>{inertia}</inertial>
             <collision><origin xyz='0.1 0 0'/><geometry><box size='0.3 0.06 0.06'/></geometry></collision>"
        )
    };
    for (x, expected) in [(0.12, None), (-0.3, Some("link1"))] {
        let found = identified(&log, &urdf(&link(x), &link(0.12)), "possible");
        let mut all = found.results[0].warnings.iter();
        let finding = all.find(|finding| finding.code == "nominal-body-outside");
        assert_eq!(finding.is_some(), expected.is_some(), "{x}: {finding:?}");
        if let (Some(finding), Some(link)) = (finding, expected) {
            assert!(
                finding.text.contains(link) && !finding.text.contains("link2"),
                "{}",
                finding.text
            );
        }
    }
}
