//! Rendering of exact shapes: irradiance read from their proxy meshes, and their emission.

use crate::{assert_close, camera, polygon, radiance_along};
use azulejo_render::{FinalGather, ReferencePass, SecondPass, reference_radiance, render};
use azulejo_scene::math::Ray;
use azulejo_scene::{
    Contour, Csg, Curve, Exact, Figure, FillRule, Material, Mesh, Object, Operation, Primitive,
    Prism, Rgb, Scene, Shape, Solid,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DMat3, DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A ring with a corner at each quarter: curves, creases and a hole.
fn ring() -> Figure {
    let petals = |radius: f64| {
        let arc = |k: u32| {
            let turn = DVec2::from_angle(f64::from(k) * PI / 2.0);
            let at = |x, y| radius * turn.rotate(dvec2(x, y));
            Curve::Cubic {
                start: at(1.0, 0.0),
                control1: at(1.0, 0.8),
                control2: at(0.8, 1.0),
            }
        };
        Contour {
            curves: (0..4).map(arc).collect(),
        }
    };
    Figure {
        contours: vec![petals(1.0), petals(0.5)],
        rule: FillRule::EvenOdd,
    }
}

fn prism(figure: Figure, map: DAffine3) -> Solid {
    Solid::Prism(Prism {
        figure: Arc::new(figure),
        world_from_figure: map,
        material: 0,
        bevel: None,
    })
}

/// A cylinder-like prism with a ball bitten out of it.
fn bitten() -> Solid {
    let ball = Primitive::sphere(dvec3(0.8, 0.0, 1.0), 0.6, 0);
    Solid::Csg(Box::new(Csg {
        operation: Operation::Difference,
        left: vec![prism(ring(), DAffine3::IDENTITY)],
        right: vec![Solid::Primitive(ball)],
    }))
}

/// A scene of solids whose proxy mesh carries `irradiance` of position and normal.
fn lit(solids: Vec<Solid>, irradiance: impl Fn(DVec3) -> Rgb) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::diffuse("white", Rgb::grey(0.8)));
    let mut exact = Exact::new(solids);
    let mut proxy = exact.tessellate(0.02);
    proxy.irradiance = proxy.positions.iter().map(|&p| irradiance(p)).collect();
    exact.proxy = Some(Box::new(proxy));
    scene
        .objects
        .push(Object::new("exact", Shape::Exact(exact)));
    scene
}

/// The same scene with the proxy mesh as the shape.
fn as_mesh(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        if let Shape::Exact(exact) = &object.shape {
            object.shape = Shape::Mesh(Mesh::clone(exact.proxy.as_ref().unwrap()));
        }
    }
    scene
}

fn pixels(scene: &Scene) -> Vec<Rgb> {
    scene.validate().expect("the test's scene is valid");
    let eye = camera(dvec3(2.0, 2.5, 5.0), DVec3::ZERO, 40.0);
    let options = SecondPass {
        size: (80, 60),
        samples_per_pixel: 4,
        ..SecondPass::default()
    };
    let tracer = Tracer::new(scene);
    let image = render(scene, &tracer, &eye, &options, &Progress::new()).expect("not cancelled");
    let pixels = image.pixels.iter();
    pixels.map(|p| Rgb::from(p.map(f64::from))).collect()
}

/// Share of pixels that differ by more than `within` between a shape and its proxy mesh.
fn differ(scene: &Scene, within: f64) -> f64 {
    let (exact, polygons) = (pixels(scene), pixels(&as_mesh(scene)));
    assert!(exact.iter().filter(|p| !p.is_black()).count() > exact.len() / 12);
    let off = exact.iter().zip(&polygons).filter(|(a, b)| {
        let d = **a - **b;
        (0..3).any(|k| d[k].abs() > within)
    });
    off.count() as f64 / exact.len() as f64
}

#[test]
fn images_of_prisms_are_those_of_their_polygons() {
    let light = |p: DVec3| Rgb::new(2.0 + p.x, 2.0 + p.y, 2.0 + p.z);
    let square = Figure::polygon([(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(DVec2::from));
    let oblique = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::Y, dvec3(0.3, 0.2, 1.0)));
    // Flat shapes agree but for the rounding of hits; curved ones but for outlines and creases.
    let flat = differ(&lit(vec![prism(square, oblique)], light), 1e-3);
    let curved = differ(&lit(vec![prism(ring(), oblique)], light), 2e-2);
    let cut = differ(&lit(vec![bitten()], light), 2e-2);
    assert!(
        flat < 1e-3 && curved < 2e-2 && cut < 2e-2,
        "{flat} {curved} {cut}"
    );
}

/// Irradiance is not interpolated across a crease: an illuminated cap beside a dark side.
#[test]
fn creases_keep_their_light_apart() {
    let mut scene = lit(vec![prism(ring(), DAffine3::IDENTITY)], |_| Rgb::BLACK);
    let Shape::Exact(exact) = &mut scene.objects[0].shape else {
        panic!("exact")
    };
    // A proxy mesh as the first pass makes it: no vertex belongs to both a cap and a side.
    let proxy = exact.proxy.as_mut().unwrap();
    let (faces, materials) = (proxy.faces.clone(), proxy.face_materials.clone());
    let mut split = Mesh::default();
    for (face, ring) in faces.iter().enumerate() {
        let normal = proxy.face_area_vector(face).normalize();
        let first = split.positions.len() as u32;
        split.positions.extend(proxy.face_positions(face));
        let e = if normal.z > 0.9 { 1.0 } else { 0.0 };
        split.irradiance.extend(ring.iter().map(|_| Rgb::grey(e)));
        let corners: Vec<u32> = (first..split.positions.len() as u32).collect();
        split.push_face(&corners, materials[face]);
    }
    **proxy = split;
    let edge = |inside: f64| {
        let out = DVec2::from_angle(0.5);
        let rim = (0..200)
            .map(|k| 1.3 - 0.002 * f64::from(k))
            .find(|&r| ring().contains(r * out));
        ((rim.unwrap() - inside) * out).extend(1.0)
    };
    let from_above = (dvec3(0.0, 0.0, 9.0), edge(0.004));
    let side = edge(0.0) - dvec3(0.0, 0.0, 0.01);
    let from_beside = (side + dvec3(4.0, 2.2, 0.0), side);
    let seen = radiance_along(&scene, &[from_above, from_beside], &SecondPass::default());
    assert_close(seen[0], Rgb::grey(0.8 / PI), 1e-6);
    assert_close(seen[1], Rgb::BLACK, 1e-6);
}

/// A shape without irradiance reflects nothing, but still emits.
#[test]
fn unsolved_shapes_are_dark() {
    let mut scene = lit(vec![prism(ring(), DAffine3::IDENTITY)], |_| Rgb::WHITE);
    let Shape::Exact(exact) = &mut scene.objects[0].shape else {
        panic!("exact")
    };
    exact.proxy = None;
    let ray = [(dvec3(0.0, 0.8, 9.0), dvec3(0.0, 0.8, 0.0))];
    assert_eq!(
        radiance_along(&scene, &ray, &SecondPass::default()),
        [Rgb::BLACK]
    );
    scene.materials[0].emission = Rgb::grey(2.0);
    assert_eq!(
        radiance_along(&scene, &ray, &SecondPass::default()),
        [Rgb::grey(2.0)]
    );
}

/// Final gathers count the light of an exact lamp once, whatever other lamps there are.
#[test]
fn gathers_see_exact_lamps_once() {
    let irradiance = |shape: fn(DAffine3) -> Shape, others: &[Shape]| {
        let mut scene = Scene::default();
        scene.add_material(Material {
            emission: Rgb::grey(1.0),
            ..Material::diffuse("lamp", Rgb::BLACK)
        });
        scene.add_material(Material::diffuse("floor", Rgb::WHITE));
        let corners = [(-5., -5.), (5., -5.), (5., 5.), (-5., 5.)];
        let floor = polygon(&mut scene, &corners.map(|(x, y)| dvec3(x, y, 0.0)), 1);
        crate::mesh_of(&mut scene, floor).irradiance = vec![Rgb::BLACK; 4];
        let map = DAffine3::from_scale_rotation_translation(
            dvec3(2.0, 2.0, 0.1),
            glam::DQuat::IDENTITY,
            dvec3(-1.0, -1.0, 1.0),
        );
        let all = std::iter::once(shape(map)).chain(others.iter().cloned());
        scene.objects.extend(all.map(|s| Object::new("lamp", s)));
        let options = SecondPass {
            gather: FinalGather::Everywhere(4096),
            samples_per_pixel: 4,
            ..SecondPass::default()
        };
        let ray = (dvec3(3.0, 0.0, 0.5), dvec3(0.5, 0.2, 0.0));
        radiance_along(&scene, &[ray], &options)[0].g * PI
    };
    let exact = |map| {
        let square = Figure::polygon([(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from));
        Shape::Exact(Exact::new(vec![prism(square, map)]))
    };
    let boxed = |map| {
        let kind = azulejo_scene::PrimitiveKind::Cuboid;
        Shape::Primitive(Primitive::new(kind, map, 0))
    };
    let globe = Shape::Primitive(Primitive::sphere(dvec3(-3.0, 0.0, 2.0), 0.3, 0));
    let sheet = Primitive::parallelogram(dvec3(3.0, 3.0, 1.0), DVec3::Y, DVec3::X, 0);
    for others in [
        vec![],
        vec![globe.clone()],
        vec![Shape::Primitive(sheet), globe],
    ] {
        let (found, expected) = (irradiance(exact, &others), irradiance(boxed, &others));
        let off = (found / expected - 1.0).abs();
        assert!(
            off < 1e-2,
            "{found}, not {expected}, beside {} lamps",
            others.len()
        );
    }
}

/// A lamp in the form of a ring over a floor of that material. Within a set operation it is found by
/// chance alone, and its light is the same.
fn ring_lamp(floor: Material, is_sampled: bool) -> Scene {
    let mut scene = Scene::default();
    scene.add_material(Material::emitter("lamp", Rgb::new(20.0, 16.0, 10.0)));
    let floor = scene.add_material(floor);
    let (a, b) = (DVec3::X * 8.0, DVec3::Y * 8.0);
    let sheet = Primitive::parallelogram(dvec3(-4.0, -4.0, 0.0), a, b, floor);
    crate::primitive(&mut scene, sheet);
    let axes = DMat3::from_cols(
        dvec3(0.1, 0.0, 0.03),
        dvec3(0.02, 0.08, 0.0),
        dvec3(0.0, 0.03, 0.06),
    );
    let map = DAffine3::from_mat3_translation(axes, dvec3(0.24, 0.4, 0.8));
    let lamp = prism(ring(), map);
    let lamp = if is_sampled {
        lamp
    } else {
        let far = Primitive::sphere(dvec3(0.0, 0.0, -9.0), 0.1, 1);
        Solid::Csg(Box::new(Csg {
            operation: Operation::Union,
            left: vec![lamp],
            right: vec![Solid::Primitive(far)],
        }))
    };
    let shape = Shape::Exact(Exact::new(vec![lamp]));
    scene.objects.push(Object::new("lamp", shape));
    scene
}

/// Sampled as lamps, letters give the light that paths find by chance, with less noise.
#[test]
fn letters_are_sampled_as_lamps() {
    let gloss = "ggx_smith ax = 0.1 ay = 0.1 metal = gold";
    let gloss = azulejo_scene::brdf::Brdf::new(gloss.parse().unwrap()).unwrap();
    let floors = [
        (Material::diffuse("floor", Rgb::grey(0.7)), 20.0),
        (Material::with_brdf("floor", Arc::new(gloss)), 1.5),
    ];
    for (floor, gain) in floors {
        let way = dvec3(0.3, 0.4, -1.0).normalize();
        let ray = Ray::new(dvec3(0.0, 0.1, 0.0) - 3.0 * way, way);
        let options = ReferencePass {
            samples_per_pixel: 1 << 16,
            ..ReferencePass::default()
        };
        let [(by_lamp, own), (by_chance, other)] = [true, false].map(|is_sampled| {
            let scene = ring_lamp(floor.clone(), is_sampled);
            scene.validate().expect("the test's scene is valid");
            let tracer = Tracer::new(&scene);
            let progress = Progress::new();
            reference_radiance(&scene, &tracer, &[ray], &options, &progress).unwrap()[0]
        });
        for k in 0..3 {
            let margin = 4.0 * own[k].hypot(other[k]);
            assert!(
                margin < 0.2 * by_lamp[k] && margin > 0.0,
                "{own:?} {other:?}"
            );
            assert!(
                (by_lamp[k] - by_chance[k]).abs() < margin,
                "{by_lamp:?}, by chance {by_chance:?} within {margin}"
            );
        }
        let ratio = (other.mean() / own.mean()).powi(2);
        assert!(ratio > gain, "variance is only {ratio} times smaller");
    }
}
