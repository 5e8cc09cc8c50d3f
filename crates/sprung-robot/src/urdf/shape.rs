//! The shape of a link that moves: an ellipsoid about the geometry of all links that are fixed to it.

use std::io;

use sprung_core::spatial::Vector;

use crate::ellipsoid::{Ellipsoid, outermost};

use super::error::UrdfError;
use super::geometry::{Form, Geometry};
use super::mesh::corners;
use super::no_shape::{LARGEST_MESH, NoShape};
use super::robot::Urdf;
use super::tree::{Seat, choose, seats};

/// Largest length of a geometry over the largest distance of joints; longer ones have another unit.
const LONGEST: f64 = 20.0;

/// Distance of joints that all robots are taken to have, m: the axes of a wrist may meet in one point.
const LEAST_DISTANCE: f64 = 0.25;

/// Returns the bytes of a mesh by its name in the file, at most one more than [`LARGEST_MESH`].
pub(crate) type OpenMesh<'a> = &'a mut dyn FnMut(&str) -> io::Result<Vec<u8>>;

/// The shape of a link in its joint's frame, at position zero of all other joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// The smallest ellipsoid about the geometry.
    pub hull: Ellipsoid,
    /// Largest distance of the geometry from the origin of the joint, m.
    pub reach: f64,
}

impl Urdf {
    /// Returns the shapes of the links that the named joints move.
    ///
    /// # Errors
    ///
    /// The errors of [`tree`](Self::tree).
    pub(crate) fn shapes(
        &self,
        moving: &[&str],
        open: OpenMesh<'_>,
    ) -> Result<Vec<Result<Shape, NoShape>>, UrdfError> {
        let chosen = choose(self, moving)?;
        let (joint_seats, link_seats) = seats(self, &chosen);
        let longest = LONGEST * distance(chosen.iter().map(|(at, _)| &joint_seats[*at]));
        let mut points: Vec<Result<Vec<Vector>, NoShape>> = vec![Ok(Vec::new()); chosen.len()];
        for (link, seat) in self.links.iter().zip(link_seats) {
            let Some(carrier) = seat.carrier else {
                continue;
            };
            for element in &link.geometry {
                let Ok(all) = &mut points[carrier] else { break };
                match of_geometry(&link.name, element, longest, open) {
                    Ok((geometry, corners)) => {
                        let placement = seat.placement.then(&geometry.placement);
                        all.extend(corners.iter().map(|point| placement.point(point)));
                    }
                    Err(fault) => points[carrier] = Err(fault),
                }
            }
        }
        let shapes = points.into_iter().zip(&chosen).map(|(points, (at, _))| {
            let link = || self.links[self.joints[*at].child].name.clone();
            let points = outermost(&points?);
            let hull = Ellipsoid::about(&points).ok_or_else(|| NoShape::Absent { link: link() })?;
            let reach = (points.iter())
                .map(|point| point.iter().map(|x| x * x).sum::<f64>().sqrt())
                .fold(0.0, f64::max);
            if reach > longest {
                let (link, distance) = (link(), reach);
                return Err(NoShape::Far { link, distance });
            }
            Ok(Shape { hull, reach })
        });
        Ok(shapes.collect())
    }
}

/// Returns the largest distance of a joint from the one that carries it, m.
fn distance<'a>(joints: impl Iterator<Item = &'a Seat>) -> f64 {
    let carried = joints.filter(|seat| seat.carrier.is_some());
    carried
        .map(|seat| {
            seat.placement
                .origin
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
                .sqrt()
        })
        .fold(LEAST_DISTANCE, f64::max)
}

/// Returns a geometry and its outermost points in its own frame.
fn of_geometry<'a>(
    link: &str,
    geometry: &'a Result<Geometry, UrdfError>,
    longest: f64,
    open: OpenMesh<'_>,
) -> Result<(&'a Geometry, Vec<Vector>), NoShape> {
    let geometry = geometry
        .as_ref()
        .map_err(|error| NoShape::Element(error.clone()))?;
    let (points, what, scale) = match &geometry.form {
        Form::Mesh { file, scale } => {
            let corners = outermost(&of_mesh(link, file, open)?);
            let points = corners
                .iter()
                .map(|corner| std::array::from_fn(|i| scale[i] * corner[i]));
            (
                points.collect(),
                format!("mesh {file}"),
                Some(scale.map(|by| 0.001 * by)),
            )
        }
        form @ (Form::Box(_)
        | Form::Cylinder { .. }
        | Form::Capsule { .. }
        | Form::Sphere { .. }) => (form.points(), format!("<{}>", form.tag()), None),
    };
    let length = (0..3)
        .map(|axis| {
            let along = |fold: fn(f64, f64) -> f64, start| {
                points
                    .iter()
                    .map(|point: &Vector| point[axis])
                    .fold(start, fold)
            };
            along(f64::max, f64::NEG_INFINITY) - along(f64::min, f64::INFINITY)
        })
        .fold(0.0, f64::max);
    if length > longest {
        let link = link.to_owned();
        return Err(NoShape::Unit {
            link,
            what,
            length,
            scale,
        });
    }
    Ok((geometry, points))
}

fn of_mesh(link: &str, file: &str, open: OpenMesh<'_>) -> Result<Vec<Vector>, NoShape> {
    let (link, file) = (link.to_owned(), file.to_owned());
    if !file.to_lowercase().ends_with(".stl") {
        return Err(NoShape::Format { link, file });
    }
    let bytes = match open(&file) {
        Ok(bytes) => bytes,
        Err(error) => {
            let reason = error.to_string();
            return Err(NoShape::Unreadable { link, file, reason });
        }
    };
    if bytes.len() as u64 > LARGEST_MESH {
        return Err(NoShape::TooLarge { link, file });
    }
    corners(bytes).map_err(|reason| NoShape::Broken { link, file, reason })
}

#[cfg(test)]
mod tests {
    use super::super::mesh::tests::{ascii, binary};
    use super::*;

    /// Two joints, 0.4 m apart; the hand is fixed to the second link, turned by a quarter about z.
    fn arm(upper: &str, fore: &str, hand: &str) -> Urdf {
        let text = format!(
            "<robot name='arm'><link name='base'/><link name='upper'>{upper}</link><link name='fore'>{fore}</link>
             <link name='hand'>{hand}</link>
             <joint name='shoulder' type='continuous'><parent link='base'/><child link='upper'/></joint>
             <joint name='elbow' type='continuous'><parent link='upper'/><child link='fore'/>
             <origin xyz='0.4 0 0'/></joint>
             <joint name='flange' type='fixed'><parent link='fore'/><child link='hand'/>
             <origin xyz='0.3 0 0' rpy='0 0 1.5707963267948966'/></joint></robot>"
        );
        Urdf::parse("arm.urdf", &text).unwrap()
    }

    fn form(tag: &str, origin: &str, form: &str) -> String {
        format!("<{tag}><origin {origin}/><geometry>{form}</geometry></{tag}>")
    }

    fn shapes(arm: &Urdf, file: &[u8]) -> Vec<Result<Shape, NoShape>> {
        let mut open = |_: &str| Ok(file.to_owned());
        arm.shapes(&["shoulder", "elbow"], &mut open).unwrap()
    }

    #[track_caller]
    fn assert_hull(found: &Result<Shape, NoShape>, centre: Vector, half: Vector) {
        let hull = found.as_ref().unwrap().hull;
        for axis in 0..3 {
            assert!((hull.centre[axis] - centre[axis]).abs() < 1e-3, "{hull:?}");
            let semi_axis = hull.shape[axis][axis].sqrt();
            assert!(
                (semi_axis - half[axis]).abs() < 0.01 * half[axis],
                "{semi_axis}"
            );
        }
    }

    #[test]
    fn hulls_of_box_cylinder_and_sphere_are_those_of_formulas() {
        let root = 3_f64.sqrt();
        let collision = form("collision", "xyz='0.2 0 0'", "<box size='0.4 0.1 0.2'/>");
        // The collision counts; the visual would have another form.
        let upper = collision + &form("visual", "", "<sphere radius='1'/>");
        let fore = form(
            "visual",
            "xyz='0 0.1 0'",
            "<cylinder radius='0.05' length='0.3'/>",
        );
        let found = shapes(&arm(&upper, &fore, ""), &[]);
        assert_hull(
            &found[0],
            [0.2, 0.0, 0.0],
            [0.2, 0.05, 0.1].map(|half| half * root),
        );
        let across = 0.05 * 1.5_f64.sqrt();
        assert_hull(&found[1], [0.0, 0.1, 0.0], [across, across, 0.15 * root]);
        let upper = form("visual", "", "<sphere radius='0.1'/>");
        let found = shapes(
            &arm(
                &upper,
                &form("visual", "", "<capsule radius='0.1' length='0'/>"),
                "",
            ),
            &[],
        );
        assert_hull(&found[0], [0.0; 3], [0.1; 3]);
        assert_hull(&found[1], [0.0; 3], [0.1; 3]);
        assert!((found[0].as_ref().unwrap().reach - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_fixed_link_belongs_to_the_link_that_carries_it() {
        // Together they are a box from −0.1 to 0.5 m along x.
        let fore = form("collision", "", "<box size='0.2 0.1 0.1'/>");
        let hand = form("collision", "xyz='0 -0.1 0'", "<box size='0.1 0.2 0.1'/>");
        let found = shapes(&arm("", &fore, &hand), &[]);
        let half = [0.3, 0.05, 0.05].map(|half| half * 3_f64.sqrt());
        assert_hull(&found[1], [0.2, 0.0, 0.0], half);
        let absent = found[0].as_ref().unwrap_err().to_string();
        assert_eq!(absent, "upper has no <collision> or <visual>");
    }

    #[test]
    fn a_mesh_in_stl_equals_the_box() {
        let mesh = |scale: &str| {
            let mesh = format!("<mesh filename='meshes/upper.STL' {scale}/>");
            form(
                "visual",
                "xyz='0.2 0 0' rpy='0 0 1.5707963267948966'",
                &mesh,
            )
        };
        let (least, largest) = ([-0.05, -0.2, -0.1], [0.05, 0.2, 0.1]);
        let half = [0.2, 0.05, 0.1].map(|half| half * 3_f64.sqrt());
        for bytes in [ascii(least, largest), binary(least, largest)] {
            let found = shapes(&arm(&mesh(""), "", ""), &bytes);
            assert_hull(&found[0], [0.2, 0.0, 0.0], half);
        }
        let bytes = binary(least.map(|x| 1e3 * x), largest.map(|x| 1e3 * x));
        let found = shapes(&arm(&mesh("scale='0.001 0.001 0.001'"), "", ""), &bytes);
        assert_hull(&found[0], [0.2, 0.0, 0.0], half);
        let found = shapes(&arm(&mesh(""), "", ""), &bytes);
        let fault = found[0].as_ref().unwrap_err();
        assert_eq!(
            fault.to_string(),
            "the mesh meshes/upper.STL of upper is 400 m long: its unit is probably the millimetre"
        );
        let remedy = fault.remedy();
        assert!(remedy.contains("scale=\"0.001 0.001 0.001\""), "{remedy}");
        // The limit is 20 times the distance of the joints, 0.4 m.
        let found = shapes(
            &arm(&form("visual", "", "<box size='8.01 1 1'/>"), "", ""),
            &[],
        );
        assert!(
            found[0]
                .as_ref()
                .unwrap_err()
                .remedy()
                .contains("in metres")
        );
        let found = shapes(
            &arm(&form("visual", "", "<box size='7.99 1 1'/>"), "", ""),
            &[],
        );
        assert!(found[0].is_ok());
    }

    #[test]
    fn what_cannot_be_used_is_told_with_its_place() {
        let mesh = |file: &str| form("collision", "", &format!("<mesh filename='{file}'/>"));
        for (geometry, bytes, fault) in [
            (mesh("a.dae"), &[][..], "the mesh a.dae of upper is no STL"),
            (
                mesh("a.stl"),
                &[0; 90][..],
                "the mesh a.stl of upper is broken: it has no triangles",
            ),
            (form("visual", "", "<box/>"), &[], "line 1 of arm.urdf"),
            (
                form("visual", "", "<sphere radius='big'/>"),
                &[],
                "radius=\"big\"",
            ),
            (
                form("visual", "xyz='1e30 0 0'", "<sphere radius='1'/>"),
                &[],
                "the geometry of upper is 1",
            ),
            (
                form("visual", "xyz='a'", "<sphere radius='1'/>"),
                &[],
                "xyz=\"a\"",
            ),
            (form("visual", "", "<plane/>"), &[], "has no <box>"),
        ] {
            let found = shapes(&arm(&geometry, "", ""), bytes);
            let found = found[0].as_ref().unwrap_err().to_string();
            assert!(found.contains(fault), "{found}");
        }
        let mut absent = |_: &str| Err(io::ErrorKind::NotFound.into());
        let found = arm(&mesh("a.stl"), "", "").shapes(&["shoulder"], &mut absent);
        let found = found.unwrap()[0].as_ref().unwrap_err().to_string();
        assert!(
            found.starts_with("the mesh a.stl of upper cannot be read: "),
            "{found}"
        );
    }
}
