//! Hits of a [`Tracer`](crate::Tracer), in double precision.

use glam::DVec3;

/// The surface that an item number of a [`KernelHit`](crate::KernelHit) stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Index of the object in its scene.
    pub object: u32,
    /// Face of the mesh, part of the primitive, or index of the leaf among an exact shape's
    /// [`leaves`](azulejo_scene::Exact::leaves).
    pub face: u32,
    /// Index of the triangle of the face, in the order of
    /// [`Mesh::triangulate`](azulejo_scene::Mesh::triangulate); 0 for all other shapes.
    pub triangle: u32,
    /// Whether the object is an exact primitive.
    pub is_primitive: bool,
}

/// The surface that a ray hit, in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter along the ray.
    pub t: f64,
    /// Index of the object in its scene.
    pub object: u32,
    /// Face of the mesh, part of the primitive, or index of the leaf among an exact shape's
    /// [`leaves`](azulejo_scene::Exact::leaves).
    pub face: u32,
    /// Index of the triangle of the face, in the order of
    /// [`Mesh::triangulate`](azulejo_scene::Mesh::triangulate). On a prism 0 is the figure's plane,
    /// 1 the parallel one, and the figure's curves count from 2; on a mesh that is a leaf, its
    /// triangles count over all faces. 0 for a primitive.
    pub triangle: u32,
    /// Barycentric weight of the triangle's corner 1, or `u` of the primitive's part or the
    /// patch. On a prism's side, the parameter of the curve; on its planes, the figure's x.
    pub u: f64,
    /// Barycentric weight of the triangle's corner 2, or `v` of the primitive's part or the
    /// patch. On a prism's side, the height over the figure's plane, 0..=1; on its planes, the
    /// figure's y.
    pub v: f64,
    /// World position, on the surface to `f64` rounding.
    pub position: DVec3,
    /// Unit geometric normal of the front.
    pub normal: DVec3,
    /// Whether the ray arrives at the front.
    pub entering: bool,
    /// The item's number, as in [`KernelHit`](crate::KernelHit).
    pub item: u32,
}

/// A surface point in the world, in double precision.
pub(crate) struct ResolvedPoint {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// The part of an exact shape's leaf, the triangle of a face; 0 for a primitive.
    pub part: u32,
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
}
