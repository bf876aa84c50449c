//! Lights without area, the surroundings, glass and many lamps, against closed forms.

use crate::rooms::*;
use azulejo_radiosity::{Estimate, FirstPass, PatchSize, PointNormal, solve};
use azulejo_scene::{Light, LightKind, Material, Mesh, Object, Primitive, Rgb, Scene, Shape};
use azulejo_trace::lambert::point_to_polygon;
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// A floor of reflectance 0.5 over −4..4, under one light.
fn lit_floor(kind: LightKind) -> Scene {
    let mut scene = Scene::default();
    scene.lights.push(Light {
        name: String::new(),
        kind,
    });
    add_sheet(
        &mut scene,
        dvec3(-4.0, -4.0, 0.0),
        8.0 * DVec3::X,
        8.0 * DVec3::Y,
        surface(0.5, 0.0, 0.0),
    );
    scene
}

fn grid() -> Vec<PointNormal> {
    (0..36)
        .map(|k| {
            at(
                f64::from(k % 6) - 2.4,
                f64::from(k / 6) - 2.6,
                0.0,
                DVec3::Z,
            )
        })
        .collect()
}

/// Asserts that every point has exactly the irradiance `truth`, with an error of zero.
#[track_caller]
fn check_exact(scene: &Scene, truth: impl Fn(DVec3) -> f64) {
    for (e, p) in irradiance(scene, &grid(), &rays(16)).iter().zip(&grid()) {
        let truth = truth(p.position);
        let off = (e.value.mean() - truth).abs();
        assert!(
            off < 1e-12 * truth.max(1.0),
            "{:?}: {} instead of {truth}",
            p.position,
            e.value.mean()
        );
        assert_eq!(e.error, Rgb::BLACK);
    }
}

fn point_light() -> LightKind {
    LightKind::Point {
        position: dvec3(0.3, -0.2, 2.0),
        intensity: Rgb::grey(7.0),
    }
}

/// E = I cos θ / r².
fn from_place(place: DVec3, p: DVec3) -> f64 {
    let d = place - p;
    7.0 * d.z / d.length().powi(3)
}

#[test]
fn point_light_is_exact() {
    check_exact(&lit_floor(point_light()), |p| {
        from_place(dvec3(0.3, -0.2, 2.0), p)
    });
}

#[test]
fn spot_light_is_exact() {
    let (position, inner, outer) = (dvec3(0.3, -0.2, 2.0), 0.3, 0.7);
    let kind = LightKind::Spot {
        position,
        direction: -DVec3::Z,
        intensity: Rgb::grey(7.0),
        inner,
        outer,
    };
    check_exact(&lit_floor(kind), |p| {
        let cos = 2.0 / position.distance(p);
        let x = ((cos - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
        from_place(position, p) * (3.0 - 2.0 * x) * x * x
    });
}

#[test]
fn directional_light_is_exact() {
    let kind = LightKind::Directional {
        direction: dvec3(0.6, 0.0, -0.8),
        irradiance: Rgb::grey(3.0),
        half_angle: 0.0,
    };
    check_exact(&lit_floor(kind), |_| 2.4);
}

/// A black plate at z = 1 over −1..1 casts a sharp shadow, twice as large, off the axis.
#[test]
fn shadows_are_sharp() {
    let mut scene = lit_floor(point_light());
    add_sheet(
        &mut scene,
        dvec3(-1.0, -1.0, 1.0),
        2.0 * DVec3::X,
        2.0 * DVec3::Y,
        surface(0.0, 0.0, 0.0),
    );
    let place = dvec3(0.3, -0.2, 2.0);
    check_exact(&scene, |p| {
        let at = 0.5 * (p + place);
        if at.x.abs() < 1.0 && at.y.abs() < 1.0 {
            0.0
        } else {
            from_place(place, p)
        }
    });
}

/// A wall x = 3 that mirrors 0.8 between y = −1 and 1 shows the light at x = 5.7.
#[test]
fn lights_are_seen_in_mirrors() {
    let mut scene = lit_floor(point_light());
    add_sheet(
        &mut scene,
        dvec3(3.0, -1.0, 0.0),
        3.0 * DVec3::Z,
        2.0 * DVec3::Y,
        surface(0.0, 0.8, 0.0),
    );
    check_exact(&scene, |p| {
        let image = dvec3(5.7, -0.2, 2.0);
        let at = p + (image - p) * ((3.0 - p.x) / (image.x - p.x));
        let mirrored = if at.y.abs() < 1.0 && at.z < 3.0 {
            0.8 * from_place(image, p)
        } else {
            0.0
        };
        from_place(dvec3(0.3, -0.2, 2.0), p) + mirrored
    });
}

fn sky() -> LightKind {
    LightKind::Ambient {
        radiance: Rgb::WHITE,
    }
}

#[test]
fn open_floor_under_the_sky() {
    for e in irradiance(&lit_floor(sky()), &grid(), &rays(64)) {
        assert!((e.value.mean() / PI - 1.0).abs() < 1e-6, "{e:?}");
    }
}

/// A point of a wall sees half of the sky except what the floor hides beyond the horizon.
#[test]
fn a_wall_under_the_sky() {
    let mut scene = lit_floor(sky());
    scene.materials[0] = surface(0.0, 0.0, 0.0);
    add_sheet(
        &mut scene,
        dvec3(0.0, -1.0, 0.0),
        2.0 * DVec3::Y,
        2.0 * DVec3::Z,
        surface(0.5, 0.0, 0.0),
    );
    let floor = [
        dvec3(-4.0, -4.0, 0.0),
        dvec3(4.0, -4.0, 0.0),
        dvec3(4.0, 4.0, 0.0),
        dvec3(-4.0, 4.0, 0.0),
    ];
    for z in [0.1, 0.5, 1.5] {
        let p = at(0.0, 0.2, z, DVec3::X);
        let truth = PI * (1.0 - point_to_polygon(p.position, p.normal, &floor));
        let e = irradiance(&scene, &[p], &rays(1 << 14))[0];
        check(
            &format!("wall at height {z}"),
            grey(&e),
            truth,
            2e-3 * truth,
            1e-6,
        );
    }
}

/// A room of side 6 whose ceiling lamp, 1.2 wide, consists of `n` × `n` faces; optionally with a
/// table between it and the floor.
fn lamp_room(n: u32, table: bool) -> Scene {
    let mut scene = Scene::default();
    let size = 6.0;
    add_sheet(
        &mut scene,
        DVec3::ZERO,
        size * DVec3::X,
        size * DVec3::Y,
        surface(0.5, 0.0, 0.0),
    );
    for (corner, edge1, edge2) in [
        (DVec3::ZERO, DVec3::Y, DVec3::Z),
        (DVec3::ZERO, DVec3::Z, DVec3::X),
        (dvec3(size, 0.0, 0.0), DVec3::Z, DVec3::Y),
        (dvec3(0.0, size, 0.0), DVec3::X, DVec3::Z),
        (dvec3(0.0, 0.0, size), DVec3::Y, DVec3::X),
    ] {
        add_sheet(
            &mut scene,
            corner,
            size * edge1,
            size * edge2,
            surface(0.0, 0.0, 0.0),
        );
    }
    let lamp = surface(0.0, 0.0, 1.0);
    add_tiles(
        &mut scene,
        dvec3(2.4, 2.4, LAMP_HEIGHT),
        1.2 * DVec3::Y,
        1.2 * DVec3::X,
        n,
        lamp,
    );
    if table {
        add_sheet(
            &mut scene,
            dvec3(2.0, 2.5, 2.0),
            DVec3::X,
            DVec3::Y,
            surface(0.0, 0.0, 0.0),
        );
    }
    scene
}

const LAMP_HEIGHT: f64 = 5.9;

/// The same with pieces of the lamp that differ a little, so that they are not one again.
fn crowded_room(n: u32, table: bool) -> Scene {
    let mut scene = lamp_room(n, table);
    let lamp = scene.materials.iter().position(Material::is_emitter);
    let lamp = lamp.expect("a lamp");
    let mut other = scene.materials[lamp].clone();
    other.emission *= 1.0 + 1e-9;
    let other = scene.add_material(other);
    let is_lamp = |mesh: &&mut Mesh| mesh.face_materials.contains(&(lamp as u32));
    let meshes = scene.objects.iter_mut().filter_map(|o| match &mut o.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    });
    for mesh in meshes.filter(is_lamp) {
        for (k, material) in (0..).zip(&mut mesh.face_materials) {
            if (k / n + k % n) % 2 == 1 {
                *material = other;
            }
        }
    }
    scene
}

/// On the floor, and close to the lamp: on its level, facing its edge, 0.007 below it.
fn beside_lamp() -> Vec<PointNormal> {
    let mut points: Vec<PointNormal> = (0..8)
        .map(|k| at(0.3 + 0.7 * f64::from(k), 3.1, 0.0, DVec3::Z))
        .collect();
    for k in 0..6 {
        let below = LAMP_HEIGHT - 0.007;
        let x = 2.4 + 0.2 * f64::from(k);
        points.push(at(2.393, x, below, DVec3::X));
        points.push(at(x, 2.41, below, DVec3::Y));
        points.push(at(x, 2.9, below, dvec3(0.6, 0.0, 0.8)));
    }
    points
}

/// Root mean square of the relative errors of points against the lamp in one piece.
#[track_caller]
fn check_crowd(n: u32, table: bool, most: u32, within: f64) {
    let truth = irradiance(
        &lamp_room(1, table),
        &beside_lamp(),
        &FirstPass {
            bounces: Some(0),
            ..rays(1 << 12)
        },
    );
    let pass = FirstPass {
        bounces: Some(0),
        ..rays(most)
    };
    let found = irradiance(&crowded_room(n, table), &beside_lamp(), &pass);
    let (mut square, mut z, mut mean) = (0.0, 0.0f64, 0.0);
    for (t, e) in truth.iter().zip(&found) {
        let (t, (value, error)) = (t.value.mean(), grey(e));
        let relative = (value - t) / t.max(1e-3);
        square += relative * relative;
        mean += relative;
        z = z.max((value - t).abs() / (error + 1e-3 * t + 1e-5));
    }
    let (rms, mean) = (
        (square / found.len() as f64).sqrt(),
        mean / found.len() as f64,
    );
    eprintln!(
        "{} lamps, table {table}: rms {rms:.2e}, mean {mean:+.2e}, worst {z:.1} SE",
        n * n
    );
    assert!(
        rms < within && mean.abs() < 0.5 * within,
        "rms {rms}, mean {mean}"
    );
    assert!(z < 8.0, "{z} standard errors off");
}

/// Few lamps by formula, many by sampling, a multitude by rays: the light is the same.
#[test]
fn many_lamps() {
    for table in [false, true] {
        check_crowd(3, table, 256, 1e-2);
        check_crowd(12, table, 256, 3e-2);
        check_crowd(33, table, 1 << 12, 8e-2);
    }
}

/// Tiles that emit alike are one lamp, to the last digits.
#[test]
fn a_lamp_in_pieces_is_one_lamp() {
    let pass = FirstPass {
        bounces: Some(0),
        ..rays(256)
    };
    let [whole, pieces] = [1, 9].map(|n| irradiance(&lamp_room(n, false), &beside_lamp(), &pass));
    for (a, b) in whole.iter().zip(&pieces) {
        assert!(
            (a.value.mean() - b.value.mean()).abs() < 1e-9,
            "{a:?} {b:?}"
        );
    }
}

/// The light of a single lamp is not sampled, however near the point.
#[test]
fn a_near_lamp_is_exact() {
    let lamp = [
        dvec3(2.4, 2.4, LAMP_HEIGHT),
        dvec3(2.4, 3.6, LAMP_HEIGHT),
        dvec3(3.6, 3.6, LAMP_HEIGHT),
        dvec3(3.6, 2.4, LAMP_HEIGHT),
    ];
    let pass = FirstPass {
        bounces: Some(0),
        ..rays(64)
    };
    for (e, p) in irradiance(&lamp_room(1, false), &beside_lamp(), &pass)
        .iter()
        .zip(&beside_lamp())
    {
        let truth = point_to_polygon(p.position, p.normal, &lamp);
        assert!(
            (e.value.mean() - truth).abs() < 1e-12,
            "{p:?}: {e:?}, truth {truth}"
        );
    }
}

/// Light of a lamp through a plane-parallel glass body of index 1.5, in black surroundings.
fn mean_through(scene: &Scene, points: &[PointNormal]) -> (f64, f64) {
    let pass = FirstPass {
        bounces: Some(0),
        ..rays(1 << 12)
    };
    let found: Vec<Estimate> = irradiance(scene, points, &pass);
    let n = found.len() as f64;
    let error = found
        .iter()
        .map(|e| e.error.mean().powi(2))
        .sum::<f64>()
        .sqrt()
        / n;
    (found.iter().map(|e| e.value.mean()).sum::<f64>() / n, error)
}

fn add_pane(scene: &mut Scene, z: f64) {
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let map = glam::DAffine3::from_scale_rotation_translation(
        dvec3(400.0, 400.0, 0.1),
        glam::DQuat::IDENTITY,
        dvec3(-200.0, -200.0, z),
    );
    let pane = Primitive::new(azulejo_scene::PrimitiveKind::Cuboid, map, glass);
    scene
        .objects
        .push(Object::new("pane", Shape::Primitive(pane)));
}

/// Share of diffuse light that a pane of n = 1.5 passes: ∫ 2μ (1 − R)/(1 + R) dμ with R(μ) the
/// mean of both polarizations. That paths carry no polarization costs 0.8%: with it, the share
/// would be 0.8509383009.
const PANE: f64 = 0.8445559401246554;

/// Under a sky of one radiance and over a black ground, a point receives what the pane passes.
#[test]
fn a_pane_passes_its_share() {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        dvec3(-200.0, -200.0, 0.0),
        400.0 * DVec3::X,
        400.0 * DVec3::Y,
        surface(0.0, 0.0, 0.0),
    );
    add_pane(&mut scene, 0.1);
    let kind = sky();
    scene.lights.push(Light {
        name: "sky".into(),
        kind,
    });
    let points: Vec<PointNormal> = (0..4)
        .map(|k| at(0.1 * f64::from(k), 0.0, 0.0, DVec3::Z))
        .collect();
    check(
        "pane",
        mean_through(&scene, &points),
        PANE * PI,
        3e-3 * PI,
        1e-4,
    );
}

/// A thin pane treats both surfaces for either polarization: the exact share passes, and the rest
/// is reflected.
#[test]
fn a_thin_pane_passes_its_exact_share() {
    const THIN: f64 = 0.850938300896;
    for (exitance, truth) in [(0.0, THIN * PI), (1.0, 1.0 - THIN)] {
        let mut scene = Scene::default();
        let (corner, x, y) = (
            dvec3(-200.0, -200.0, 0.0),
            400.0 * DVec3::X,
            400.0 * DVec3::Y,
        );
        add_sheet(&mut scene, corner, x, y, surface(0.0, 0.0, exitance));
        add_sheet(
            &mut scene,
            corner + 0.1 * DVec3::Z,
            x,
            y,
            Material::pane("pane", 1.5),
        );
        if exitance == 0.0 {
            let (name, kind) = ("sky".into(), sky());
            scene.lights.push(Light { name, kind });
        }
        let points: Vec<PointNormal> = (0..4)
            .map(|k| at(0.1 * f64::from(k), 0.0, 0.0, DVec3::Z))
            .collect();
        let found = mean_through(&scene, &points);
        check("thin pane", found, truth, 3e-3 * truth.max(1.0), 1e-3);
    }
}

/// A pane reflects what it does not transmit. The lamp is the floor itself.
#[test]
fn a_pane_mirrors_the_rest() {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        dvec3(-200.0, -200.0, 0.0),
        400.0 * DVec3::X,
        400.0 * DVec3::Y,
        surface(0.0, 0.0, 1.0),
    );
    add_pane(&mut scene, 0.1);
    let points: Vec<PointNormal> = (0..4)
        .map(|k| at(0.1 * f64::from(k), 0.0, 0.0, DVec3::Z))
        .collect();
    check(
        "pane mirrors",
        mean_through(&scene, &points),
        1.0 - PANE,
        3e-3,
        1e-3,
    );
}

/// A solid glass body reflects 0.0917779594 of diffuse light on its surface; a slab with a black
/// end absorbs the rest.
#[test]
fn thick_glass_mirrors_its_share() {
    let mut scene = Scene::default();
    add_sheet(
        &mut scene,
        dvec3(-200.0, -200.0, 0.0),
        400.0 * DVec3::X,
        400.0 * DVec3::Y,
        surface(0.0, 0.0, 1.0),
    );
    let glass = Material::dielectric("glass", 1.5);
    add_sheet(
        &mut scene,
        dvec3(-200.0, -200.0, 0.1),
        400.0 * DVec3::Y,
        400.0 * DVec3::X,
        glass,
    );
    add_sheet(
        &mut scene,
        dvec3(-200.0, -200.0, 0.2),
        400.0 * DVec3::Y,
        400.0 * DVec3::X,
        surface(0.0, 0.0, 0.0),
    );
    let points: Vec<PointNormal> = (0..4)
        .map(|k| at(0.1 * f64::from(k), 0.0, 0.0, DVec3::Z))
        .collect();
    check(
        "thick glass",
        mean_through(&scene, &points),
        0.0917779593424,
        2e-3,
        1e-3,
    );
}

/// Glass that absorbs nothing changes nothing in a furnace.
#[test]
fn a_glass_ball_in_a_furnace() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 1.0)));
    let glass = scene.add_material(Material::dielectric("glass", 1.5));
    let ball = Primitive::sphere(dvec3(0.5, 0.4, 0.55), 0.3, glass);
    scene
        .objects
        .push(Object::new("ball", Shape::Primitive(ball)));
    let solved = Matrix::solve(
        &scene,
        &FirstPass {
            size: PatchSize::Count(150),
            ..rays(1024)
        },
    );
    let walls = solved.patches.patches_of(0);
    let b: Vec<f64> = walls.map(|p| solved.radiosity(p, true).0).collect();
    let (mean, _) = spread(&b);
    let rms = (b.iter().map(|b| (b - 2.0).powi(2)).sum::<f64>() / b.len() as f64).sqrt();
    eprintln!("glass ball in a furnace: mean B {mean}, rms {rms:.1e}");
    assert!(
        (mean - 2.0).abs() < 5e-3 && rms < 3e-2,
        "mean {mean}, rms {rms}"
    );
}

/// Light sources of the file that are not surfaces are included in the energy balance.
#[test]
fn light_without_area_is_in_the_balance() {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 0.0)));
    let kind = LightKind::Point {
        position: DVec3::splat(0.5),
        intensity: Rgb::WHITE,
    };
    scene.lights.push(Light {
        name: "bulb".into(),
        kind,
    });
    let pass = FirstPass {
        size: PatchSize::Count(600),
        ..rays(256)
    };
    let report = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new())
        .unwrap()
        .report;
    let emitted = report.balance.emitted.mean();
    eprintln!(
        "bulb: {emitted} of {} W, balance {:.1e}",
        4.0 * PI,
        report.balance.error()
    );
    assert!(
        (emitted / (4.0 * PI) - 1.0).abs() < 5e-3,
        "{emitted} W of 4π"
    );
    assert!(report.balance.error() < 1e-3, "{:?}", report.balance);
}

/// A two-sided emitting plate lights floor and ceiling alike, in either orientation; each by the
/// polygon's formula.
#[test]
fn a_plate_may_emit_from_both_sides() {
    for turned in [false, true] {
        let mut scene = Scene::default();
        let (a, b) = if turned {
            (DVec3::Y, DVec3::X)
        } else {
            (DVec3::X, DVec3::Y)
        };
        let lamp = Material {
            emits_back: true,
            ..Material::emitter("lamp", Rgb::grey(2.0))
        };
        let corner = dvec3(-0.5, -0.5, 0.0);
        add_sheet(&mut scene, corner, a, b, lamp);
        let points = [at(0.2, 0.1, -1.0, DVec3::Z), at(0.2, 0.1, 1.0, -DVec3::Z)];
        let square = [
            corner,
            corner + DVec3::X,
            corner + DVec3::X + DVec3::Y,
            corner + DVec3::Y,
        ];
        let mut from_below = square;
        from_below.reverse();
        let truth = 2.0 * PI * point_to_polygon(points[0].position, DVec3::Z, &from_below).abs();
        for found in irradiance(&scene, &points, &rays(64)) {
            let off = (found.value.mean() - truth).abs();
            assert!(
                off < 1e-9 + 4.0 * found.error.mean(),
                "{} for {truth}",
                found.value.mean()
            );
        }
    }
}
