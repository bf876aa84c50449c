//! Light by way of mirrors, plane and curved, single and many, against closed forms.

use crate::rooms::*;
use azulejo_factors::rays::RayEstimator;
use azulejo_factors::row::{Columns, Entries, side};
use azulejo_radiosity::{FirstPass, PatchSize, Patches, PointNormal};
use azulejo_scene::{Material, Object, Primitive, Scene, Shape};
use azulejo_trace::lambert::{clip_to_window, mirror_polygon, point_to_polygon};
use azulejo_trace::{Gatherer, Surfaces, Tracer};
use glam::{DVec3, dvec3};

/// Light without diffuse reflection.
fn direct(most: u32) -> FirstPass {
    FirstPass {
        bounces: Some(0),
        ..rays(most)
    }
}

const BLACK: fn() -> Material = || surface(0.0, 0.0, 0.0);

/// Radiosities of the unit cube, one unknown per side, in the order of its materials; `None` for
/// sides without one.
#[track_caller]
fn check_cube(scene: &Scene, truth: [Option<f64>; 6]) {
    let faces = [0, 1, 2, 3, 4, 5].map(|material| cube_face(material) as usize);
    for ((material, b), truth) in radiosities(scene, &faces, 2048)
        .into_iter()
        .enumerate()
        .zip(truth)
    {
        if let Some(truth) = truth {
            check(&format!("B of side {material}"), b, truth, 2e-3, 3e-4);
        }
    }
}

/// Exact factors, six equations: ρ .5 .7 .3 .3 .6 .6, M = 1 on the floor.
#[test]
fn cube_without_mirrors() {
    let rho = [0.5, 0.7, 0.3, 0.3, 0.6, 0.6];
    let scene = cube(std::array::from_fn(|k| {
        surface(rho[k], 0.0, f64::from(k == 0))
    }));
    let truth = [
        1.089212259953,
        0.243230864772,
        0.112171253574,
        0.112171253574,
        0.212310068136,
        0.212310068136,
    ];
    check_cube(&scene, truth.map(Some));
}

/// The same with a mirror of 0.9 as the wall x = 0: five equations, exact factors by images.
#[test]
fn cube_with_a_mirror_wall() {
    let rho = [0.5, 0.7, 0.0, 0.3, 0.6, 0.6];
    let mirror = |k| if k == 2 { 0.9 } else { 0.0 };
    let scene = cube(std::array::from_fn(|k| {
        surface(rho[k], mirror(k), f64::from(k == 0))
    }));
    let truth = [
        Some(1.126177557827),
        Some(0.330986588078),
        None,
        Some(0.1403257871934),
        Some(0.2713020253403),
        Some(0.2713020253403),
    ];
    check_cube(&scene, truth);
}

/// Extended form factor between the whole faces of two patches, by rays alone.
fn factor(scene: &Scene, from: usize, to: usize, rays: u32) -> (f64, f64) {
    let tracer = Tracer::new(scene);
    let patches = Patches::new(scene, PatchSize::Edge(0.0));
    let gatherer = Gatherer::new(Surfaces::new(scene, &tracer));
    let estimator = RayEstimator::new(&gatherer, &patches, rays, 3, Columns::All);
    let row = estimator.row(side(from as u32, true));
    let of = |entries: &Entries| {
        let hits = entries.iter().filter(|e| e.side == side(to as u32, true));
        hits.map(|e| e.weight.r).sum::<f64>()
    };
    spread(&row.entries.iter().map(of).collect::<Vec<f64>>())
}

/// A floor and a lamp of M = 1 over it, and the irradiance of the floor: once by the rays of its
/// row, once as direct light, by formula, image and rays.
#[track_caller]
fn check_lit(what: &str, scene: &Scene, floor: usize, lamp: usize, truth: f64) {
    check(
        &format!("{what}: X"),
        factor(scene, floor, lamp, 1 << 16),
        truth,
        1e-3,
        1e-5,
    );
    let fine = FirstPass {
        size: PatchSize::Edge(0.1),
        bounces: Some(1),
        ..rays(1 << 10)
    };
    let solved = Matrix::solve(scene, &fine);
    let floor = solved.patches.patches_of_face(azulejo_factors::FaceId {
        object: 0,
        face: floor as u32,
    });
    let count = floor.len();
    let h = solved.irradiance(floor, true);
    check(
        &format!("{what}: H over {count} patches"),
        h,
        truth,
        4e-3 * truth,
        1e-5,
    );
}

/// Unit cube, floor to ceiling, facing mirrors as walls x = 0 and x = 1, the others black.
#[test]
fn corridors_of_facing_mirrors() {
    for (mirror, truth) in [
        (0.5, 0.294595182671),
        (0.9, 0.3873533),
        (1.0, 2f64.sqrt() - 1.0),
    ] {
        let wall = || surface(0.0, mirror, 0.0);
        let scene = cube([
            surface(0.5, 0.0, 0.0),
            surface(0.0, 0.0, 1.0),
            wall(),
            wall(),
            BLACK(),
            BLACK(),
        ]);
        let (floor, lamp) = (cube_face(0) as usize, cube_face(1) as usize);
        check_lit(&format!("corridor {mirror}"), &scene, floor, lamp, truth);
    }
}

/// A unit floor at z = 0, a unit lamp over it, and a mirror sheet.
fn with_sheet(floor_and_lamp: [[DVec3; 4]; 2], mirror: [DVec3; 3], reflectance: f64) -> Scene {
    let mut scene = Scene::default();
    let mut mesh = azulejo_scene::Mesh {
        positions: floor_and_lamp.concat(),
        ..Default::default()
    };
    let materials = [surface(0.5, 0.0, 0.0), surface(0.0, 0.0, 1.0)].map(|m| scene.add_material(m));
    mesh.push_face(&[0, 1, 2, 3], materials[0]);
    mesh.push_face(&[4, 5, 6, 7], materials[1]);
    scene
        .objects
        .push(Object::new("floor and lamp", Shape::Mesh(mesh)));
    add_sheet(
        &mut scene,
        mirror[0],
        mirror[1],
        mirror[2],
        surface(0.0, reflectance, 0.0),
    );
    scene
}

fn square(x: f64, y: f64, z: f64, up: bool) -> [DVec3; 4] {
    let (a, b) = (dvec3(x + 1.0, y, z), dvec3(x, y + 1.0, z));
    let (o, c) = (dvec3(x, y, z), dvec3(x + 1.0, y + 1.0, z));
    if up { [o, a, c, b] } else { [o, b, c, a] }
}

/// Mirror of 0.8 over 0.2 < y < 0.7, 0.3 < z < 0.8 of the wall x = −0.2.
fn window_scene() -> Scene {
    let mirror = [dvec3(-0.2, 0.2, 0.3), 0.5 * DVec3::Y, 0.5 * DVec3::Z];
    with_sheet(
        [square(0.0, 0.0, 0.0, true), square(0.0, 0.0, 1.0, false)],
        mirror,
        0.8,
    )
}

/// Coplanar squares that see each other only through a ceiling mirror of 0.9.
fn corner_scene() -> Scene {
    let mirror = [dvec3(0.0, 0.0, 1.0), 3.0 * DVec3::X, DVec3::Y];
    with_sheet(
        [square(0.0, 0.0, 0.0, true), square(1.5, 0.0, 0.0, true)],
        mirror,
        0.9,
    )
}

#[test]
fn a_mirror_shows_a_part_of_the_lamp() {
    check_lit("window", &window_scene(), 0, 1, 0.22076122);
}

#[test]
fn all_light_by_one_mirror() {
    check_lit("corner", &corner_scene(), 0, 1, 0.0293360871);
}

fn floor_points() -> Vec<PointNormal> {
    (0..12)
        .map(|k| {
            at(
                0.05 + 0.08 * f64::from(k),
                0.9 - 0.07 * f64::from(k),
                0.0,
                DVec3::Z,
            )
        })
        .collect()
}

/// Irradiance of a point from the lamp of [`with_sheet`] and from its image in the mirror.
fn closed_form(scene: &Scene, point: &PointNormal) -> f64 {
    let face = |object: usize, face: usize| match &scene.objects[object].shape {
        Shape::Mesh(mesh) => mesh.face_positions(face),
        _ => Vec::new(),
    };
    let (lamp, mirror) = (face(0, 1), face(1, 0));
    let normal = (mirror[1] - mirror[0])
        .cross(mirror[2] - mirror[0])
        .normalize();
    let image = mirror_polygon(&lamp, mirror[0], normal);
    let seen = clip_to_window(&image, point.position, &mirror);
    let reflectance = scene.materials[2].mirror.mean();
    point_to_polygon(point.position, point.normal, &lamp)
        + reflectance * point_to_polygon(point.position, point.normal, &seen)
}

/// By formula, the light of a lamp in a plane mirror has no error except that of visibility.
#[test]
fn images_are_exact_at_points() {
    for (what, scene) in [("window", window_scene()), ("corner", corner_scene())] {
        let points = floor_points();
        for (e, p) in irradiance(&scene, &points, &direct(64)).iter().zip(&points) {
            check(what, grey(e), closed_form(&scene, p), 1e-6, 1e-6);
        }
    }
}

/// Three hundred small mirrors off the line of sight: too many for images, so rays find the lamp.
/// It must count exactly once.
#[test]
fn rays_and_images_agree() {
    for (what, mut scene) in [("window", window_scene()), ("corner", corner_scene())] {
        add_tiles(
            &mut scene,
            dvec3(0.0, 0.0, -3.0),
            0.2 * DVec3::X,
            0.2 * DVec3::Y,
            18,
            surface(0.0, 0.5, 0.0),
        );
        let points = floor_points();
        for (e, p) in irradiance(&scene, &points, &direct(1 << 14))
            .iter()
            .zip(&points)
        {
            check(what, grey(e), closed_form(&scene, p), 6e-3, 1e-4);
        }
    }
}

/// A mirror in two flat halves, one tilted imperceptibly, gives the same light.
#[test]
fn a_mirror_in_pieces_is_one_mirror() {
    let whole = window_scene();
    let mut halves = window_scene();
    let mesh = mesh_of(&mut halves, 1);
    let material = mesh.face_materials[0];
    let (low, high) = (
        0.5 * (mesh.positions[0] + mesh.positions[3]),
        0.5 * (mesh.positions[1] + mesh.positions[2]),
    );
    let corners = mesh.positions.clone();
    *mesh = azulejo_scene::Mesh::default();
    mesh.positions = vec![corners[0], corners[1], corners[2], corners[3], low, high];
    mesh.positions[2].x += 1e-9;
    mesh.push_face(&[0, 1, 5, 4], material);
    mesh.push_face(&[4, 5, 2, 3], material);
    let points = floor_points();
    for (e, p) in irradiance(&halves, &points, &direct(64))
        .iter()
        .zip(&points)
    {
        check("halves", grey(e), closed_form(&whole, p), 1e-6, 1e-6);
    }
}

/// Plates between perfect mirrors are infinite plates: M = 1, 0 and ρ = 0.2, 0.6 make
/// B₁ = M₁/(1 − ρ₁ρ₂) and B₂ = ρ₂B₁.
#[test]
fn infinite_plates() {
    let wall = || surface(0.0, 1.0, 0.0);
    let scene = cube([
        surface(0.2, 0.0, 1.0),
        surface(0.6, 0.0, 0.0),
        wall(),
        wall(),
        wall(),
        wall(),
    ]);
    let truth = [
        Some(1.136363636364),
        Some(0.681818181818),
        None,
        None,
        None,
        None,
    ];
    check_cube(&scene, truth);
}

/// Equilateral prism between perfect mirrors, so infinite; M₁ = 1, ρ .4 .6, third side a mirror
/// of 0.8. Form factors by crossed strings.
#[test]
fn infinite_prism_with_a_mirror_side() {
    let mut scene = Scene::default();
    let (a, b, c) = (DVec3::ZERO, DVec3::X, dvec3(0.5, 0.75f64.sqrt(), 0.0));
    let sides = [
        (a, b, surface(0.4, 0.0, 1.0)),
        (b, c, surface(0.6, 0.0, 0.0)),
        (c, a, surface(0.0, 0.8, 0.0)),
    ];
    for (from, to, material) in sides {
        add_sheet(&mut scene, from, DVec3::Z, to - from, material);
    }
    for (z, corners) in [(0.0, [0, 1, 2]), (1.0, [0, 2, 1])] {
        let material = scene.add_material(surface(0.0, 1.0, 0.0));
        let positions = [a, b, c].map(|p| p + z * DVec3::Z).to_vec();
        let mut mesh = azulejo_scene::Mesh {
            positions,
            ..Default::default()
        };
        mesh.push_face(&corners, material);
        scene.objects.push(Object::new("cap", Shape::Mesh(mesh)));
    }
    let patches = Patches::new(&scene, PatchSize::Edge(0.0));
    let inward = |k: usize| {
        patches
            .normal(k)
            .dot(dvec3(0.5, 0.28, 0.5) - patches.centre(k))
            > 0.0
    };
    assert!(inward(0) && inward(1), "sides look inward");
    let found = radiosities(&scene, &[0, 1], 2048);
    check("prism: B1", found[0], 1.2564316145226, 2e-3, 3e-4);
    check("prism: B2", found[1], 0.6387514131703, 2e-3, 3e-4);
}

/// Concentric spheres, r 1 and 2, emissivities 0.8 and 0.4, only the inner one warm: the net flux
/// of the inner one is 1/(1/ε₁ + (A₁/A₂)(1/ε₂ − 1)) if the outer one is diffuse and
/// 1/(1/ε₁ + 1/ε₂ − 1) if it is a mirror.
#[test]
fn concentric_spheres() {
    for (what, outer, flux) in [
        ("diffuse shell", surface(0.6, 0.0, 0.0), 0.615384615385),
        ("mirror shell", surface(0.0, 0.6, 0.0), 0.363636363636),
    ] {
        let mut scene = Scene::default();
        for (radius, material) in [(1.0, surface(0.2, 0.0, 0.8)), (2.0, outer)] {
            let material = scene.add_material(material);
            let sphere = Primitive::sphere(DVec3::ZERO, radius, material);
            scene
                .objects
                .push(Object::new(what, Shape::Primitive(sphere)));
        }
        let solved = Matrix::solve(
            &scene,
            &FirstPass {
                size: PatchSize::Count(2000),
                ..rays(256)
            },
        );
        let (h, error) = solved.irradiance(solved.patches.patches_of(0), true);
        check(what, (0.8 - 0.8 * h, 0.8 * error), flux, 1e-2 * flux, 1e-4);
    }
}

/// A chain of two mirrors, a periscope: the lamp is seen in the second one in the first.
#[test]
fn light_by_two_mirrors() {
    let mut scene = Scene::default();
    let slope = dvec3(1.0, 0.0, 1.0);
    add_sheet(
        &mut scene,
        dvec3(-4.0, -4.0, 0.0),
        8.0 * DVec3::X,
        8.0 * DVec3::Y,
        surface(0.5, 0.0, 0.0),
    );
    // Over the floor, a mirror at 45° sends what goes up along +x; a second one sends it up.
    add_sheet(
        &mut scene,
        dvec3(-0.5, -0.5, 1.0),
        slope,
        DVec3::Y,
        surface(0.0, 0.9, 0.0),
    );
    add_sheet(
        &mut scene,
        dvec3(2.5, -0.5, 1.0),
        slope,
        DVec3::Y,
        surface(0.0, 0.8, 0.0),
    );
    add_sheet(
        &mut scene,
        dvec3(2.5, -0.5, 3.0),
        DVec3::Y,
        DVec3::X,
        surface(0.0, 0.0, 1.0),
    );
    let point = at(0.0, 0.0, 0.0, DVec3::Z);
    let sheet = |k: usize| match &scene.objects[k].shape {
        Shape::Mesh(mesh) => mesh.face_positions(0),
        _ => Vec::new(),
    };
    let [first, second, lamp] = [1, 2, 3].map(sheet);
    let normal = dvec3(1.0, 0.0, -1.0);
    let image = mirror_polygon(&lamp, second[0], normal);
    let window = clip_to_window(
        &mirror_polygon(&second, first[0], normal),
        point.position,
        &first,
    );
    let seen = clip_to_window(
        &mirror_polygon(&image, first[0], normal),
        point.position,
        &window,
    );
    let share = |polygon: &[DVec3]| point_to_polygon(point.position, point.normal, polygon);
    let chain = 0.72 * share(&seen);
    let single = 0.8 * share(&clip_to_window(&image, point.position, &second));
    assert!(chain > 1e-3, "the chain matters: {chain}");
    let truth = chain + single + share(&lamp);
    check(
        "two mirrors",
        grey(&irradiance(&scene, &[point], &direct(1 << 15))[0]),
        truth,
        1e-3,
        1e-4,
    );
}
