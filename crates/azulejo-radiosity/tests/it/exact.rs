//! Exact shapes in the first pass: prisms, text, set operations.

use crate::rooms::*;
use azulejo_factors::{FormFactorOptions, faceted, form_factors};
use azulejo_radiosity::{FirstPass, PatchSize, Patches, PointNormal, SolveError, probe, solve};
use azulejo_scene::{
    Contour, Csg, Curve, Exact, Figure, FillRule, Material, Mesh, Object, Operation, Primitive,
    PrimitiveKind, Prism, Scene, Shape, Solid, TriangleTree,
};
use azulejo_trace::{Progress, Tracer};
use glam::{DAffine3, DMat3, DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A circle of four cubic curves.
fn circle(centre: DVec2, radius: f64) -> Contour {
    let arc = |k: u32| {
        let turn = DVec2::from_angle(f64::from(k) * PI / 2.0);
        let at = |x, y| centre + radius * turn.rotate(dvec2(x, y));
        Curve::Cubic {
            start: at(1.0, 0.0),
            control1: at(1.0, 0.552_284_75),
            control2: at(0.552_284_75, 1.0),
        }
    };
    Contour {
        curves: (0..4).map(arc).collect(),
    }
}

/// The letter o, 1 wide and high.
fn letter_o() -> Figure {
    let centre = DVec2::splat(0.5);
    Figure {
        contours: vec![circle(centre, 0.5), circle(centre, 0.3)],
        rule: FillRule::EvenOdd,
    }
}

fn unit_square() -> Figure {
    Figure::polygon([(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from))
}

fn prism(figure: Figure, low: DVec3, size: DVec3, material: u32) -> Solid {
    Solid::Prism(Prism {
        figure: Arc::new(figure),
        world_from_figure: placed(low, size),
        material,
        bevel: None,
    })
}

fn placed(low: DVec3, size: DVec3) -> DAffine3 {
    DAffine3::from_mat3_translation(DMat3::from_diagonal(size), low)
}

fn cuboid(low: DVec3, size: DVec3, material: u32) -> Primitive {
    Primitive::new(PrimitiveKind::Cuboid, placed(low, size), material)
}

fn add_exact(scene: &mut Scene, solids: Vec<Solid>) -> usize {
    let shape = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new("exact", shape));
    scene.objects.len() - 1
}

/// A box with a spherical dent.
fn dented(low: DVec3, size: f64, material: u32) -> Solid {
    let dent = Primitive::sphere(low + DVec3::splat(size), 0.6 * size, material);
    Solid::Csg(Box::new(Csg {
        operation: Operation::Difference,
        left: vec![Solid::Primitive(cuboid(low, DVec3::splat(size), material))],
        right: vec![Solid::Primitive(dent)],
    }))
}

fn solved(scene: &mut Scene, pass: &FirstPass) -> azulejo_radiosity::Report {
    scene.validate().unwrap();
    let light = solve(scene, &Tracer::new(scene), pass, &Progress::new()).unwrap();
    scene.set_irradiance(light.irradiance);
    scene.validate().unwrap();
    assert!(scene.is_solved());
    light.report
}

fn skin(scene: &Scene, object: usize) -> &Mesh {
    match &scene.objects[object].shape {
        Shape::Exact(exact) => exact.proxy.as_ref().expect("solved"),
        _ => panic!("object {object} is not exact"),
    }
}

/// The irradiance of a mesh at a point, on the side that has it.
fn read(mesh: &Mesh, position: DVec3, normal: DVec3) -> f64 {
    let tree = TriangleTree::new(mesh);
    let near = [normal, -normal].map(|n| tree.nearest(position, n).unwrap());
    let on = near[usize::from(near[1].distance < near[0].distance)];
    let triangle = tree.triangle(on.index);
    let ring = mesh.faces.get(triangle.face as usize);
    let [a, b, c] = triangle
        .corners
        .map(|k| mesh.irradiance[ring[k as usize] as usize].mean());
    a + on.u * (b - a) + on.v * (c - a)
}

/// In a room of radiance 1 every point of a solid of radiance 1 receives π, also in dents and
/// holes.
#[test]
fn furnaces_light_exact_shapes_evenly() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 0.5 * PI)));
    let grey = scene.add_material(surface(0.6, 0.0, 0.4 * PI));
    let size = DVec3::splat(0.3);
    let letter = add_exact(
        &mut scene,
        vec![prism(letter_o(), dvec3(0.15, 0.5, 0.4), size, grey)],
    );
    let dent = add_exact(&mut scene, vec![dented(dvec3(0.6, 0.2, 0.2), 0.25, grey)]);
    let pass = FirstPass {
        size: PatchSize::Edge(0.12),
        ..rays(512)
    };
    let report = solved(&mut scene, &pass);
    assert!(report.balance.error() < 1e-3, "{:?}", report.balance);
    for object in [letter, dent] {
        let skin = skin(&scene, object);
        let all = || skin.irradiance.iter().map(|e| e.mean() / PI);
        let mean = all().sum::<f64>() / skin.irradiance.len() as f64;
        let worst = all().map(|e| (e - 1.0).abs()).fold(0.0, f64::max);
        eprintln!("E / π: mean {mean:.5}, worst {worst:.3} off");
        assert!((mean - 1.0).abs() < 5e-3, "mean {mean}");
        assert!(worst < 0.1, "worst {worst}");
    }
}

/// A room with a ceiling lamp and a box, in one of three representations.
fn box_in_room(shape: Shape) -> Scene {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 0.0)));
    let corner = dvec3(0.35, 0.35, 0.999);
    let edges = (dvec3(0.0, 0.3, 0.0), dvec3(0.3, 0.0, 0.0));
    add_sheet(
        &mut scene,
        corner,
        edges.0,
        edges.1,
        surface(0.0, 0.0, 20.0),
    );
    scene.add_material(surface(0.7, 0.0, 0.0));
    scene.objects.push(Object::new("box", shape));
    scene
}

#[test]
fn a_square_prism_is_lit_as_a_box() {
    let (low, size) = (dvec3(0.3, 0.2, 0.0), dvec3(0.3, 0.4, 0.5));
    let material = 7;
    let solid = prism(unit_square(), low, size, material);
    let primitive = cuboid(low, size, material);
    let exact = Exact::new(vec![solid]);
    let polygons = exact.tessellate(0.1);
    let pass = FirstPass {
        size: PatchSize::Edge(0.1),
        ..rays(1024)
    };
    let mut as_exact = box_in_room(Shape::Exact(exact));
    let mut as_mesh = box_in_room(Shape::Mesh(polygons));
    let mut as_primitive = box_in_room(Shape::Primitive(primitive.clone()));
    let reports = [&mut as_exact, &mut as_mesh, &mut as_primitive].map(|s| solved(s, &pass));
    let skin = skin(&as_exact, 2);
    let Shape::Mesh(mesh) = &as_mesh.objects[2].shape else {
        panic!("still a mesh")
    };
    assert_eq!(skin.irradiance.len(), mesh.irradiance.len());
    // The same polygons; the mesh's bottom is not reversed, so that only fronts are compared.
    for (k, (a, b)) in skin.irradiance.iter().zip(&mesh.irradiance).enumerate() {
        assert!((*a - *b).max_channel() < 1e-9, "{k}: {a:?} {b:?}");
    }
    let Shape::Primitive(lit) = &as_primitive.objects[2].shape else {
        panic!("still a primitive")
    };
    let light = lit.light.as_ref().unwrap();
    let mut worst: f64 = 0.0;
    for part in [0, 1, 2, 3, 5] {
        for k in 0..16 {
            let (u, v) = (0.2 + 0.2 * f64::from(k % 4), 0.2 + 0.2 * f64::from(k / 4));
            let at = primitive.point(part, u, v);
            let expected = light.at(part, u, v).mean();
            let found = read(skin, at.position, at.normal);
            worst = worst.max((found / expected - 1.0).abs());
        }
    }
    eprintln!("prism and box differ by at most {worst:.3}");
    assert!(worst < 0.08, "{worst}");
    assert!(reports.iter().all(|r| r.balance.error() < 1e-2));
}

/// Contacts: the floor below a letter that stands on it is dark up to its outline.
#[test]
fn floors_are_cut_along_letters() {
    let letter = prism(letter_o(), dvec3(0.2, 0.2, 0.0), dvec3(0.6, 0.6, 0.2), 7);
    let mut scene = box_in_room(Shape::Exact(Exact::new(vec![letter])));
    let pass = FirstPass {
        size: PatchSize::Edge(0.05),
        ..rays(256)
    };
    solved(&mut scene, &pass);
    let Shape::Mesh(room) = &scene.objects[0].shape else {
        panic!("still a mesh")
    };
    let floor = |x: f64, y: f64| read(room, dvec3(x, y, 0.0), DVec3::Z);
    // The ring is between 0.18 and 0.3 from the middle.
    for (radius, lit) in [
        (0.0, true),
        (0.15, true),
        (0.2, false),
        (0.28, false),
        (0.33, true),
    ] {
        for turn in 0..8 {
            let p = DVec2::splat(0.5) + radius * DVec2::from_angle(f64::from(turn));
            let e = floor(p.x, p.y);
            assert!(
                if lit { e > 0.15 } else { e < 0.02 },
                "{radius}, {turn}: {e}"
            );
        }
    }
}

/// Emitting, mirroring and transparent shapes act as their proxy polygons.
#[test]
fn lamps_mirrors_and_glass_may_be_exact() {
    let glass = Material::dielectric("glass", 1.5);
    let check = |material: Material, expected: f64, within: f64| {
        let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 0.5 * PI)));
        let m = scene.add_material(material);
        let size = DVec3::splat(0.3);
        add_exact(
            &mut scene,
            vec![prism(letter_o(), dvec3(0.3, 0.3, 0.3), size, m)],
        );
        let report = solved(
            &mut scene,
            &FirstPass {
                size: PatchSize::Edge(0.2),
                ..rays(256)
            },
        );
        let room = mesh_of(&mut scene, 0);
        let mean: f64 = room.irradiance.iter().map(|e| e.mean()).sum::<f64>();
        let mean = mean / room.irradiance.len() as f64;
        eprintln!("room E {mean:.4}, balance {:.1e}", report.balance.error());
        assert!((mean / expected - 1.0).abs() < within, "{mean}");
    };
    // A room of radiance 1 stays one with a mirror, with clear glass and with a grey body in it.
    check(surface(0.0, 1.0, 0.0), PI, 5e-3);
    check(glass, PI, 1e-2);
    check(surface(0.3, 0.0, 0.7 * PI), PI, 5e-3);
}

#[test]
fn a_line_of_text_stays_in_proportion() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let grey = scene.add_material(surface(0.5, 0.0, 0.0));
    let figure = Arc::new(letter_o());
    let letter = |k: u32| {
        let low = dvec3(0.05 + 0.05 * f64::from(k), 0.5, 0.4);
        Solid::Prism(Prism {
            figure: Arc::clone(&figure),
            world_from_figure: placed(low, dvec3(0.04, 0.04, 0.02)),
            material: grey,
            bevel: None,
        })
    };
    let line = add_exact(&mut scene, (0..18).map(letter).collect());
    let without = Patches::new(&scene, PatchSize::Squares(1500)).len();
    let divided = faceted(&scene, PatchSize::Squares(1500));
    let with = Patches::new(&divided, PatchSize::Squares(1500)).len();
    eprintln!("{without} patches without the text, {with} with it");
    assert!(with - without < 18 * 100 && with - without > 18 * 20);
    let pass = FirstPass {
        keep_mesh: true,
        ..rays(32)
    };
    solved(&mut scene, &pass);
    assert_eq!(mesh_of(&mut scene, 0).positions.len(), 8, "kept as given");
    assert!(skin(&scene, line).irradiance.len() > 500);
}

/// Letters have more faces than the count; the floor below them is divided all the same. As one
/// patch with four vertices it would show a tenth of its light.
#[test]
fn letters_leave_patches_for_the_floor() {
    let mut scene = Scene::default();
    let grey = scene.add_material(surface(0.5, 0.0, 0.0));
    let glow = scene.add_material(surface(0.0, 0.0, 10.0));
    let square = |size: f64, z: f64, down: bool, material: u32| {
        let mut corners = [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)];
        if down {
            corners.reverse();
        }
        let mut mesh = Mesh {
            positions: corners
                .map(|(x, y)| size * dvec3(x, y, 0.0) + z * DVec3::Z)
                .to_vec(),
            ..Mesh::default()
        };
        mesh.push_face(&[0, 1, 2, 3], material);
        Object::new("", Shape::Mesh(mesh))
    };
    scene.objects.push(square(6.0, 0.0, false, grey));
    scene.objects.push(square(0.5, 2.0, true, glow));
    let figure = Arc::new(letter_o());
    let letter = |k: u32| {
        let low = dvec3(f64::from(k % 10) - 5.0, f64::from(k / 10) - 5.0, 3.0);
        Solid::Prism(Prism {
            figure: Arc::clone(&figure),
            world_from_figure: placed(low, dvec3(0.2, 0.2, 0.1)),
            material: grey,
            bevel: None,
        })
    };
    add_exact(&mut scene, (0..100).map(letter).collect());
    let pass = FirstPass {
        size: PatchSize::Count(500),
        ..rays(32)
    };
    let tracer = Tracer::new(&scene);
    let below = PointNormal {
        position: DVec3::ZERO,
        normal: DVec3::Z,
    };
    let found = probe(&scene, &tracer, &[below], &pass, &Progress::new()).unwrap();
    let expected = found.estimates[0].value.mean();
    solved(&mut scene, &pass);
    let floor = mesh_of(&mut scene, 0);
    let most = floor.irradiance.iter().map(|e| e.mean());
    let most = most.fold(0.0, f64::max);
    eprintln!("brightest vertex {most:.3}, below the lamp {expected:.3}");
    assert!(floor.faces.len() > 200, "{} patches", floor.faces.len());
    assert!((most / expected - 1.0).abs() < 0.15, "{most} {expected}");
}

#[test]
fn other_functions_take_exact_shapes_too() {
    let low = dvec3(0.3, 0.3, 0.3);
    let solids = vec![prism(letter_o(), low, DVec3::splat(0.4), 7)];
    let scene = box_in_room(Shape::Exact(Exact::new(solids)));
    let tracer = Tracer::new(&scene);
    let size = PatchSize::Edge(0.2);
    let options = FormFactorOptions {
        size,
        rays: 256,
        ..FormFactorOptions::default()
    };
    let factors = form_factors(&scene, &tracer, &options, &Progress::new()).unwrap();
    let divided = faceted(&scene, size);
    assert_eq!(factors.len(), Patches::new(&divided, size).len());
    assert!(factors.is_closed);
    // Inside the ring, where the polygons' chords deviate by up to the chord error.
    let pass = FirstPass { size, ..rays(256) };
    let inner = |turn: u32| {
        let out = DVec2::from_angle(0.1 + f64::from(turn));
        let at = 0.5 * DVec2::ONE + 0.12 * (1.0 - 1e-9) * out;
        PointNormal {
            position: at.extend(0.5),
            normal: (-out).extend(0.0),
        }
    };
    let points: Vec<PointNormal> = (0..6).map(inner).collect();
    let found = probe(&scene, &tracer, &points, &pass, &Progress::new()).unwrap();
    let values: Vec<f64> = found.estimates.iter().map(|e| e.value.mean()).collect();
    eprintln!("in the ring: {values:.3?}");
    assert!(values.iter().all(|&e| e > 0.1), "{values:?}");
}

#[test]
fn text_without_ink_has_no_surface() {
    let mut scene = Scene::default();
    let glow = scene.add_material(surface(0.0, 0.0, 1.0));
    let blank = prism(Figure::default(), DVec3::ZERO, DVec3::ONE, glow);
    add_exact(&mut scene, vec![blank]);
    let tracer = Tracer::new(&scene);
    let nothing = solve(&scene, &tracer, &rays(16), &Progress::new());
    assert!(matches!(
        nothing,
        Err(SolveError::NoLight | SolveError::NoSurface)
    ));
}
