//! Polygons for displaying shapes: exact shapes are tessellated as finely as the view requires.

use crate::projection::Projection;
use azulejo::scene::math::Aabb;
use azulejo::scene::{Mesh, Primitive, Rgb, Shape, SurfaceGrid, SurfaceLight};
use std::borrow::Cow;

/// Accepted chord error in pixels.
const PIXELS: f64 = 0.4;
/// Range of the chord error relative to the size of an object.
const FINEST: f64 = 1.0 / 4096.0;
const COARSEST: f64 = 1.0 / 64.0;

/// Largest chord error of a shape that is not visible in the view, world units.
///
/// A power of two, so that a shape is tessellated again only when the camera comes twice as close.
/// `bounds` is the bounding box in world space.
pub fn chord_error(bounds: Aabb, view: &Projection) -> f64 {
    let size = bounds.diagonal();
    if !(size > 0.0 && size.is_finite()) {
        return 1.0;
    }
    // The nearest point of the bounding sphere.
    let centre = bounds.centre();
    let eye = view.ray(glam::DVec2::ZERO).origin;
    let toward = (eye - centre).normalize_or_zero();
    let nearest = centre + toward * (0.5 * size).min((eye - centre).length());
    let chord_error = (PIXELS * view.pixel_at(nearest)).clamp(FINEST * size, COARSEST * size);
    2f64.powi(chord_error.log2().floor() as i32)
}

/// The polygons that display a shape, in object space: a mesh as it is, an exact shape with a chord
/// error of at most `chord_error`, > 0.
///
/// With `lit` they carry the solved irradiance: on a grid no coarser than the solver's own for a
/// primitive, and on the solver's proxy mesh for other exact shapes.
pub fn display_mesh(shape: &Shape, chord_error: f64, lit: bool) -> Cow<'_, Mesh> {
    match shape {
        Shape::Mesh(mesh) => Cow::Borrowed(mesh),
        Shape::Instance(instance) => Cow::Owned(instance.to_mesh()),
        Shape::Primitive(primitive) => {
            Cow::Owned(tessellate_primitive(primitive, chord_error, lit))
        }
        Shape::Exact(exact) => match &exact.proxy {
            Some(skin) if lit => Cow::Borrowed(&**skin),
            _ => Cow::Owned(exact.tessellate(chord_error)),
        },
    }
}

fn tessellate_primitive(primitive: &Primitive, chord_error: f64, lit: bool) -> Mesh {
    if !(chord_error > 0.0 && chord_error.is_finite()) {
        return Mesh::default();
    }
    let mut grids = primitive.grids(chord_error, f64::INFINITY);
    let light = primitive.light.as_ref().filter(|_| lit);
    if let Some(light) = light {
        for (grid, own) in grids.iter_mut().zip(&light.grids) {
            // An integer multiple, so that every vertex with irradiance is also a vertex here.
            grid.nu = grid.nu.div_ceil(own.nu.max(1)) * own.nu.max(1);
            grid.nv = grid.nv.div_ceil(own.nv.max(1)) * own.nv.max(1);
        }
    }
    let mut mesh = primitive.tessellate(&grids);
    if let Some(light) = light {
        mesh.irradiance = irradiance(light, &grids);
        if light.error.len() == light.irradiance.len() {
            let errors = SurfaceLight {
                irradiance: light.error.clone(),
                ..(**light).clone()
            };
            mesh.irradiance_error = irradiance(&errors, &grids);
        }
    }
    mesh
}

/// The irradiance at the vertices of grids, in their order.
fn irradiance(light: &SurfaceLight, grids: &[SurfaceGrid]) -> Vec<Rgb> {
    let mut values = Vec::new();
    for (part, grid) in grids.iter().enumerate() {
        for j in 0..=grid.nv {
            for i in 0..=grid.nu {
                let share = |k: u32, n: u32| f64::from(k) / f64::from(n);
                values.push(light.at(part, share(i, grid.nu), share(j, grid.nv)));
            }
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::{Camera, PrimitiveKind};
    use glam::{DAffine3, DVec3};

    fn view(distance: f64) -> Projection {
        let camera = Camera {
            name: String::new(),
            eye: DVec3::new(0.0, 0.0, distance),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 0.7,
            size: None,
        };
        Projection::new(&camera, [800, 600])
    }

    fn ball() -> Shape {
        Shape::Primitive(Primitive::sphere(DVec3::ZERO, 1.0, 0))
    }

    #[test]
    fn what_is_near_has_finer_polygons() {
        let bounds = Aabb::around([DVec3::splat(-1.0), DVec3::ONE]);
        let faces = |distance| {
            let error = chord_error(bounds, &view(distance));
            display_mesh(&ball(), error, false).faces.len()
        };
        let (near, far) = (faces(4.0), faces(400.0));
        assert!(near > 4 * far && far >= 64, "{near} {far}");
        // Small steps do not change the tessellation.
        let levels: std::collections::BTreeSet<_> = (0..40)
            .map(|k| chord_error(bounds, &view(10.0 + 0.1 * f64::from(k))).to_bits())
            .collect();
        assert!(levels.len() <= 2, "{levels:?}");
    }

    #[test]
    fn boxes_without_size_and_eyes_inside_have_an_error_too() {
        assert_eq!(chord_error(Aabb::EMPTY, &view(1.0)), 1.0);
        let bounds = Aabb::around([DVec3::splat(-1.0), DVec3::ONE]);
        let inside = chord_error(bounds, &view(0.1));
        assert!(inside > 0.0 && inside < 1e-2, "{inside}");
    }

    #[test]
    fn light_of_a_primitive_comes_with_its_vertices() {
        let mut primitive = Primitive::new(PrimitiveKind::Square, DAffine3::IDENTITY, 0);
        primitive.light = Some(Box::new(SurfaceLight {
            grids: vec![SurfaceGrid { nu: 2, nv: 1 }],
            irradiance: [0.0, 1.0, 4.0, 0.0, 1.0, 4.0].map(Rgb::grey).to_vec(),
            error: Vec::new(),
        }));
        let shape = Shape::Primitive(primitive);
        let lit = display_mesh(&shape, 0.1, true);
        let at = |p: DVec3| {
            let place = lit.positions.iter().position(|&q| q == p);
            place.map(|k| lit.irradiance[k].r)
        };
        assert_eq!(at(DVec3::new(0.5, 0.0, 0.0)), Some(1.0));
        assert_eq!(at(DVec3::new(1.0, 1.0, 0.0)), Some(4.0));
        assert!(display_mesh(&shape, 0.1, false).irradiance.is_empty());
    }
}
