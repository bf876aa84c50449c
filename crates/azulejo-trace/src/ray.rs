//! What goes into a [`Tracer`](crate::Tracer) and what comes out.

use glam::DVec3;

/// A ray in the kernel's own coordinates, `f32`; [`Tracer::kernel_ray`](crate::Tracer::kernel_ray)
/// makes one.
///
/// Points `origin + t direction` for `t_min <= t < t_max`; `t` is the same as along the world's
/// ray. A ray with a number that is not finite (but `t_max`, which may be infinite), or with a
/// direction shorter than 1e-25, hits nothing; so does an empty range.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelRay {
    /// Where `t` is zero.
    pub origin: [f32; 3],
    /// The nearest parameter that counts; less than 0 is taken for 0.
    pub t_min: f32,
    /// Any length; `t` is in units of it.
    pub direction: [f32; 3],
    /// The first parameter that counts no more.
    pub t_max: f32,
}

/// What a [`KernelRay`] met first.
///
/// Of several items at exactly the same `t` it is the one with the smallest number, so the answer
/// does not depend on the order of traversal.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelHit {
    /// Parameter along the ray, to `f32` rounding; meaningless for a miss.
    pub t: f32,
    /// What was met ([`Tracer::item`](crate::Tracer::item) says more), or [`KernelHit::MISS`].
    pub item: u32,
    /// Barycentric weight of the triangle's corner 1, or `u` of the primitive's part; what
    /// [`Tracer::resolve`](crate::Tracer::resolve) wants to know again of an exact shape.
    pub u: f32,
    /// Barycentric weight of the triangle's corner 2, or `v` of the primitive's part; for an exact
    /// shape as `u`.
    pub v: f32,
}

impl KernelHit {
    /// The item of a ray that met nothing.
    pub const MISS: u32 = u32::MAX;

    /// A ray that met nothing.
    pub const NOTHING: KernelHit = KernelHit {
        t: f32::INFINITY,
        item: KernelHit::MISS,
        u: 0.0,
        v: 0.0,
    };

    /// Whether something was met.
    pub fn is_hit(&self) -> bool {
        self.item != KernelHit::MISS
    }
}

/// What an item number of a [`KernelHit`] means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Index of the object in its scene: the instance's scene if there is an instance.
    pub object: u32,
    /// Face of the mesh, part of the primitive, or place of the leaf among an exact shape's
    /// [`leaves`](azulejo_scene::Exact::leaves).
    pub face: u32,
    /// Which of the face's triangles, in the order of
    /// [`Mesh::triangulate`](azulejo_scene::Mesh::triangulate); 0 for all other shapes.
    pub triangle: u32,
    /// Whether the object is an exact primitive.
    pub is_primitive: bool,
    /// Index of the instance, if the item belongs to one.
    pub instance: Option<u32>,
}

/// The surface that a ray met, in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Parameter along the ray.
    pub t: f64,
    /// Index of the object in its scene: the instance's scene if there is an instance.
    pub object: u32,
    /// Face of the mesh, part of the primitive, or place of the leaf among an exact shape's
    /// [`leaves`](azulejo_scene::Exact::leaves).
    pub face: u32,
    /// Which of the face's triangles, in the order of
    /// [`Mesh::triangulate`](azulejo_scene::Mesh::triangulate). On a prism 0 is the figure's
    /// plane, 1 the parallel one, and the figure's curves count from 2; on a mesh that is a leaf,
    /// its triangles count over all faces. 0 for a primitive.
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
    /// The item's number, as in [`KernelHit`].
    pub item: u32,
    /// Index of the instance, if the item belongs to one.
    pub instance: Option<u32>,
}
