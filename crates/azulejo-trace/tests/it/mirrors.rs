//! Flat mirrors in which lamps are seen.

use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::{GatherPoint, Gatherer, Surfaces, Tracer};
use glam::DVec3;

/// A lamp behind a mirror lights no point of its front, on whichever side of the plane rounding has moved it: half of
/// them had the light of its image.
#[test]
fn a_mirror_does_not_show_itself_what_is_behind_it() {
    let mut scene = Scene::default();
    let mirror = scene.add_material(Material::mirror("mirror", Rgb::grey(0.9)));
    let lamp = scene.add_material(Material::emitter("lamp", Rgb::grey(3.0)));
    for (height, material) in [(0.0, mirror), (-1.0, lamp)] {
        let corner = DVec3::new(-1.0, -1.0, height);
        let sheet = Primitive::parallelogram(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y, material);
        scene
            .objects
            .push(Object::new("sheet", Shape::Primitive(sheet)));
    }
    let tracer = Tracer::new(&scene);
    let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
    let point = |(key, height): (u32, f64)| GatherPoint {
        position: DVec3::new(0.1, 0.2, height),
        normal: DVec3::Z,
        key,
    };
    let points: Vec<GatherPoint> = (0..).zip([0.0, 1e-9, -1e-9]).map(point).collect();
    for light in gatherer.direct(&points, 16, 1) {
        assert_eq!(light.whole().mean(), Rgb::BLACK);
    }
}
