//! Objects as polygons, for formats without exact shapes.

use azulejo_scene::{Exact, Mesh, Object, Primitive, Rgb, Scene, Shape, SurfaceGrid, SurfaceLight};
use std::borrow::Cow;

/// Chord error of tessellated exact shapes, relative to the size of a solid.
const CHORD_ERROR: f64 = 1e-3;

/// The polygons of an object: its own, or the tessellation of an exact shape, whose
/// irradiance is left out.
pub(crate) fn mesh_of(object: &Object) -> Cow<'_, Mesh> {
    match &object.shape {
        Shape::Mesh(mesh) => Cow::Borrowed(mesh),
        Shape::Instance(instance) => Cow::Owned(instance.to_mesh()),
        Shape::Primitive(primitive) => Cow::Owned(primitive.tessellate(&grids(primitive))),
        Shape::Exact(exact) => {
            let sizes = exact.solids.iter().map(|s| s.bounds().diagonal());
            // The size of a letter, not of its whole line.
            let largest = sizes.fold(0.0, f64::max);
            Cow::Owned(exact.tessellate(CHORD_ERROR * largest))
        }
    }
}

/// The polygons of an object with its irradiance, solved exact primitives included.
///
/// If the irradiance grid is coarser than the tessellation requires, each of its cells is
/// divided evenly: the solved values stay at their points, with bilinear interpolation between.
pub(crate) fn lit_mesh_of(object: &Object) -> Cow<'_, Mesh> {
    if let Shape::Exact(Exact {
        proxy: Some(proxy), ..
    }) = &object.shape
    {
        return Cow::Borrowed(proxy);
    }
    let (Shape::Primitive(primitive), Some(light)) = (&object.shape, light_of(object)) else {
        return mesh_of(object);
    };
    let divided = |n: u32, least: u32| n.max(1) * least.div_ceil(n.max(1));
    let grids: Vec<SurfaceGrid> = std::iter::zip(grids(primitive), &light.grids)
        .map(|(shape, light)| SurfaceGrid {
            nu: divided(light.nu, shape.nu),
            nv: divided(light.nv, shape.nv),
        })
        .collect();
    let mut mesh = primitive.tessellate(&grids);
    mesh.irradiance = sampled(light, &grids);
    if !light.error.is_empty() {
        let error = SurfaceLight {
            irradiance: light.error.clone(),
            ..light.clone()
        };
        mesh.irradiance_error = sampled(&error, &grids);
    }
    Cow::Owned(mesh)
}

/// Replaces exact shapes by their polygons, with the irradiance, and divides all polygons into triangles.
pub fn divide_into_triangles(scene: &mut Scene) {
    for object in &mut scene.objects {
        if matches!(object.shape, Shape::Primitive(_) | Shape::Exact(_)) {
            object.shape = Shape::Mesh(lit_mesh_of(object).into_owned());
        }
    }
    scene.divide_into_triangles();
}

/// Counts of objects that are exact primitives, and of those that are other exact shapes: prisms,
/// patches, and results of set operations.
pub(crate) fn exact_counts(scene: &Scene) -> [usize; 2] {
    let count = |is: fn(&Shape) -> bool| scene.objects.iter().filter(|o| is(&o.shape)).count();
    [
        count(|s| matches!(s, Shape::Primitive(_))),
        count(|s| matches!(s, Shape::Exact(_))),
    ]
}

fn grids(primitive: &Primitive) -> Vec<SurfaceGrid> {
    let chord_error = CHORD_ERROR * primitive.bounds().diagonal();
    primitive.grids(chord_error, f64::INFINITY)
}

/// The irradiance of a solved exact primitive that has a grid for each of its parts.
fn light_of(object: &Object) -> Option<&SurfaceLight> {
    let Shape::Primitive(primitive) = &object.shape else {
        return None;
    };
    let light = primitive.light.as_ref()?;
    (light.grids.len() == primitive.kind.parts()).then_some(light)
}

/// Irradiance at the vertices of `grids`, in the order of [`Primitive::tessellate`].
fn sampled(light: &SurfaceLight, grids: &[SurfaceGrid]) -> Vec<Rgb> {
    let mut values = Vec::with_capacity(grids.iter().map(SurfaceGrid::vertices).sum());
    for (part, grid) in grids.iter().enumerate() {
        let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
        for j in 0..=grid.nv {
            let v = share(j, grid.nv);
            values.extend((0..=grid.nu).map(|i| light.at(part, share(i, grid.nu), v)));
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};

    /// A square of one material whose irradiance increases along u, known at its four corners.
    fn lit_square() -> Object {
        let mut square = Primitive::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y, 0);
        let corners = [1.0, 3.0, 1.0, 3.0].map(Rgb::grey).to_vec();
        square.light = Some(Box::new(SurfaceLight {
            grids: vec![SurfaceGrid { nu: 1, nv: 1 }],
            error: corners.iter().map(|&c| 0.5 * c).collect(),
            irradiance: corners,
        }));
        Object::new("square", Shape::Primitive(square))
    }

    #[test]
    fn irradiance_is_kept() {
        let square = lit_square();
        let mesh = lit_mesh_of(&square);
        assert_eq!(mesh.irradiance, [1.0, 3.0, 1.0, 3.0].map(Rgb::grey));
        assert_eq!(mesh.irradiance_error, [0.5, 1.5, 0.5, 1.5].map(Rgb::grey));
        assert!(mesh_of(&square).irradiance.is_empty());
    }

    #[test]
    fn coarse_light_is_spread_over_a_fine_shape() {
        let mut sphere = Primitive::sphere(DVec3::ZERO, 2.0, 0);
        let grid = SurfaceGrid { nu: 3, nv: 2 };
        sphere.light = Some(Box::new(SurfaceLight {
            grids: vec![grid],
            irradiance: (0..grid.vertices()).map(|i| Rgb::grey(i as f64)).collect(),
            error: Vec::new(),
        }));
        sphere.world_from_object *= DAffine3::from_rotation_x(1.0);
        let object = Object::new("sphere", Shape::Primitive(sphere));
        let mesh = lit_mesh_of(&object);
        assert_eq!(mesh.irradiance.len(), mesh.positions.len());
        assert!(mesh.faces.len() > 100 && mesh.irradiance_error.is_empty());
        let most = mesh.irradiance.iter().map(|e| e.r).fold(0.0, f64::max);
        assert_eq!(most, (grid.vertices() - 1) as f64);
    }
}
