//! Shapes: meshes, shared meshes, primitives and solids.

use crate::math::Aabb;
use crate::{CoordinateRounding, Exact, Mesh, MeshInstance, PlacedMesh, Primitive};

/// The geometry of one object.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all objects are meshes, and a scene has far fewer objects than polygons"
)]
pub enum Shape {
    /// Polygons.
    Mesh(Mesh),
    /// Polygons that other objects may share.
    Instance(MeshInstance),
    /// A sphere, cylinder, cone, box or parallelogram, not tessellated.
    Primitive(Primitive),
    /// Prisms, patches and constructive solid geometry.
    Exact(Exact),
}

impl Shape {
    /// The mesh in the world, of its own or shared; `None` for other shapes.
    pub fn placed_mesh(&self) -> Option<PlacedMesh<'_>> {
        match self {
            Shape::Mesh(mesh) => Some(PlacedMesh {
                mesh,
                irradiance: &mesh.irradiance,
                irradiance_error: &mesh.irradiance_error,
                back: mesh.back.as_deref(),
                world_from_mesh: None,
            }),
            Shape::Instance(instance) => {
                let light = instance.light.as_deref();
                Some(PlacedMesh {
                    mesh: &instance.mesh,
                    irradiance: light.map_or(&[], |l| &l.irradiance),
                    irradiance_error: light.map_or(&[], |l| &l.error),
                    back: light.and_then(|l| l.back.as_deref()),
                    world_from_mesh: Some(&instance.world_from_mesh),
                })
            }
            Shape::Primitive(_) | Shape::Exact(_) => None,
        }
    }

    /// The mesh, of its own or shared, without its place: faces, materials, colours and texture
    /// coordinates; `None` for other shapes.
    pub fn mesh(&self) -> Option<&Mesh> {
        match self {
            Shape::Mesh(mesh) => Some(mesh),
            Shape::Instance(instance) => Some(&instance.mesh),
            Shape::Primitive(_) | Shape::Exact(_) => None,
        }
    }

    /// How exactly world positions are known. Those of exact shapes are numbers of double precision.
    pub fn coordinate_rounding(&self) -> CoordinateRounding {
        match self {
            Shape::Mesh(mesh) => mesh.coordinate_rounding(),
            Shape::Instance(instance) => instance.coordinate_rounding(),
            Shape::Primitive(_) | Shape::Exact(_) => CoordinateRounding::default(),
        }
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Aabb {
        match self {
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Instance(instance) => instance.bounds(),
            Shape::Primitive(primitive) => primitive.bounds(),
            Shape::Exact(exact) => exact.bounds(),
        }
    }
}
