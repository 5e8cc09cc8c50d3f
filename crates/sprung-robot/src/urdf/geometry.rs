//! The geometry of a link in the file: boxes, cylinders, spheres, capsules and meshes.

use sprung_core::spatial::Vector;

use crate::ellipsoid::directions;

use super::body::Placement;
use super::error::UrdfError;
use super::xml::Element;

/// Points of a circle. The smallest ellipsoid of a regular polygon is that of its circle.
const CIRCLE: usize = 24;

/// A form of a link, in the frame of the link.
#[derive(Clone, Debug)]
pub(super) struct Geometry {
    pub(super) placement: Placement,
    pub(super) form: Form,
}

/// A form in its own frame; lengths in m.
#[derive(Clone, Debug)]
pub(super) enum Form {
    /// Lengths of the sides.
    Box(Vector),
    /// Along z.
    Cylinder {
        radius: f64,
        length: f64,
    },
    /// Along z, with a half sphere at both ends of its length.
    Capsule {
        radius: f64,
        length: f64,
    },
    Sphere {
        radius: f64,
    },
    Mesh {
        file: String,
        scale: Vector,
    },
}

impl Form {
    /// Returns the tag of the form.
    pub(super) fn tag(&self) -> &'static str {
        match self {
            Self::Box(_) => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Capsule { .. } => "capsule",
            Self::Sphere { .. } => "sphere",
            Self::Mesh { .. } => "mesh",
        }
    }

    /// Returns points whose smallest ellipsoid is that of the form; none for a mesh.
    pub(super) fn points(&self) -> Vec<Vector> {
        match self {
            Self::Box(sides) => (0..8)
                .map(|k| {
                    std::array::from_fn(|i| sides[i] * if k >> i & 1 == 1 { 0.5 } else { -0.5 })
                })
                .collect(),
            Self::Cylinder { radius, length } => (0..2 * CIRCLE)
                .map(|k| {
                    let angle = std::f64::consts::TAU * (k / 2) as f64 / CIRCLE as f64;
                    let side = if k % 2 == 0 { 0.5 } else { -0.5 };
                    [radius * angle.cos(), radius * angle.sin(), side * length]
                })
                .collect(),
            Self::Capsule { radius, length } => directions()
                .map(|way| way.map(|x| radius * x))
                .flat_map(|[x, y, z]| [[x, y, z + 0.5 * length], [x, y, z - 0.5 * length]])
                .collect(),
            Self::Sphere { radius } => directions().map(|way| way.map(|x| radius * x)).collect(),
            Self::Mesh { .. } => Vec::new(),
        }
    }
}

/// Returns the `<origin>` of an element; the identity if it is absent.
pub(super) fn placement(element: &Element<'_, '_>) -> Result<Placement, UrdfError> {
    let Some(origin) = element.child("origin")? else {
        return Ok(Placement::IDENTITY);
    };
    Ok(Placement::new(
        origin.triple("xyz")?.unwrap_or_default(),
        origin.triple("rpy")?.unwrap_or_default(),
    ))
}

/// Returns the geometries of the `<collision>` elements of a link, or those of its `<visual>` elements if it has none.
/// An error concerns the shape alone.
pub(super) fn geometries(link: &Element<'_, '_>) -> Vec<Result<Geometry, UrdfError>> {
    let of = |tag: &str| -> Vec<_> {
        let all = link.children(tag).map(|mut element| {
            element.called = format!("a <{tag}> of {}", link.called);
            geometry(&element)
        });
        all.collect()
    };
    let collision = of("collision");
    if collision.is_empty() {
        of("visual")
    } else {
        collision
    }
}

fn geometry(element: &Element<'_, '_>) -> Result<Geometry, UrdfError> {
    let placement = placement(element)?;
    let geometry = element.needed_child(
        "geometry",
        "<geometry><box size=\"0.1 0.1 0.4\"/></geometry>",
    )?;
    let form = if let Some(mesh) = geometry.child("mesh")? {
        Form::Mesh {
            file: mesh.needed("filename")?.trim().to_owned(),
            scale: mesh.triple("scale")?.unwrap_or([1.0; 3]),
        }
    } else if let Some(cylinder) = geometry.child("cylinder")? {
        let (radius, length) = (cylinder.number("radius")?, cylinder.number("length")?);
        Form::Cylinder { radius, length }
    } else if let Some(sphere) = geometry.child("sphere")? {
        let radius = sphere.number("radius")?;
        Form::Sphere { radius }
    } else if let Some(capsule) = geometry.child("capsule")? {
        let (radius, length) = (capsule.number("radius")?, capsule.number("length")?);
        Form::Capsule { radius, length }
    } else {
        let cuboid = geometry.needed_child("box", "<box size=\"0.1 0.1 0.4\"/>")?;
        cuboid.needed("size")?;
        Form::Box(cuboid.triple("size")?.unwrap_or_default())
    };
    Ok(Geometry { placement, form })
}
