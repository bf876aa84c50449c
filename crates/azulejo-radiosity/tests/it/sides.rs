//! Which side's irradiance surfaces store.

use crate::rooms::*;
use azulejo_radiosity::{FirstPass, Method, PatchSize, StoredSides, solve};
use azulejo_scene::synthetic::{CornellVariant, cornell_box};
use azulejo_scene::{Light, LightKind, Mesh, ObjectIrradiance, Rgb, Scene, Sidedness};
use azulejo_trace::{Progress, Tracer};
use glam::{DVec3, dvec3};

/// A bulb of this intensity.
fn add_bulb(scene: &mut Scene, position: DVec3, intensity: f64) {
    let kind = LightKind::Point {
        position,
        intensity: Rgb::grey(intensity),
    };
    let name = String::new();
    scene.lights.push(Light { name, kind });
}

/// Irradiance by a bulb of intensity 1 over a floor.
fn under(bulb: DVec3, p: DVec3) -> f64 {
    let d = bulb - p;
    d.z.abs() / d.length().powi(3)
}

const ABOVE: DVec3 = DVec3::new(0.5, 0.5, 1.0);
const BELOW: DVec3 = DVec3::new(0.5, 0.5, -1.0);

/// A grey sheet that faces up, between a bulb above it and another below.
fn sheet(above: f64, below: f64, sidedness: Sidedness) -> Scene {
    let mut scene = Scene::default();
    let mut grey = surface(0.5, 0.0, 0.0);
    grey.sidedness = sidedness;
    add_tiles(&mut scene, DVec3::ZERO, DVec3::X, DVec3::Y, 2, grey);
    // Far away, but backs have light in the solution only where rays from fronts reach them.
    let away = dvec3(5.0, 5.0, -3.0);
    add_sheet(&mut scene, away, DVec3::X, DVec3::Y, surface(0.5, 0.0, 0.0));
    for (position, intensity) in [(ABOVE, above), (BELOW, below)] {
        add_bulb(&mut scene, position, intensity);
    }
    scene
}

fn solved(mut scene: Scene, sides: StoredSides) -> Scene {
    let pass = FirstPass {
        size: PatchSize::Edge(0.25),
        sides,
        ..rays(64)
    };
    let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
    scene.set_irradiance(light.irradiance);
    scene.validate().unwrap();
    scene
}

/// The irradiance of a horizontal mesh, and that of its back if it is stored, is that of the bulb
/// on that side.
#[track_caller]
fn check_bulbs(mesh: &Mesh, is_up: bool, (above, below): (f64, f64), has_back: bool) {
    for face in 0..mesh.faces.len() {
        assert_eq!(mesh.face_area_vector(face).z > 0.0, is_up, "face {face}");
        assert_eq!(mesh.has_back(face), has_back, "face {face}");
    }
    for (v, &p) in mesh.positions.iter().enumerate() {
        let (up, down) = (above * under(ABOVE, p), below * under(BELOW, p));
        let (front, back) = if is_up { (up, down) } else { (down, up) };
        // Vertices are gathered a thousandth of a patch inside.
        let near = |e: Rgb, truth: f64| (e.mean() - truth).abs() <= 3e-3 * truth;
        assert!(near(mesh.irradiance[v], front), "front at {p}");
        let stored = mesh.back.as_ref().and_then(|b| b.irradiance[v]);
        assert_eq!(stored.is_some(), has_back);
        assert!(stored.is_none_or(|e| near(e, back)), "back at {p}");
    }
}

#[test]
fn a_sheet_keeps_its_front_though_its_back_is_brighter() {
    for sidedness in [Sidedness::Unsaid, Sidedness::One] {
        let mut scene = solved(sheet(1.0, 50.0, sidedness), StoredSides::BySurface);
        check_bulbs(mesh_of(&mut scene, 0), true, (1.0, 50.0), false);
    }
    let mut scene = solved(sheet(1.0, 50.0, Sidedness::Two), StoredSides::Front);
    check_bulbs(mesh_of(&mut scene, 0), true, (1.0, 50.0), false);
}

#[test]
fn a_sheet_seen_from_both_sides_stores_both() {
    let mut said = solved(sheet(1.0, 50.0, Sidedness::Two), StoredSides::BySurface);
    check_bulbs(mesh_of(&mut said, 0), true, (1.0, 50.0), true);
    let mut split = solved(sheet(1.0, 50.0, Sidedness::Unsaid), StoredSides::Split);
    check_bulbs(mesh_of(&mut split, 0), true, (1.0, 50.0), true);
}

#[test]
fn a_black_front_is_turned_over_unless_backs_are_culled() {
    let mut scene = solved(sheet(0.0, 1.0, Sidedness::Unsaid), StoredSides::BySurface);
    check_bulbs(mesh_of(&mut scene, 0), false, (0.0, 1.0), false);
    let mut scene = solved(sheet(0.0, 1.0, Sidedness::One), StoredSides::BySurface);
    check_bulbs(mesh_of(&mut scene, 0), true, (0.0, 1.0), false);
}

#[test]
fn the_brighter_side_is_clearly_brighter() {
    let grey = |above, below| {
        let mut scene = sheet(above, below, Sidedness::Unsaid);
        // A floor below the bulbs, from which rays reach the back.
        let corner = dvec3(-4.0, -4.0, -6.0);
        let floor = surface(0.1, 0.0, 0.0);
        add_sheet(&mut scene, corner, 9.0 * DVec3::X, 9.0 * DVec3::Y, floor);
        let mut scene = solved(scene, StoredSides::Brighter);
        mesh_of(&mut scene, 0).face_area_vector(0).z > 0.0
    };
    assert!(grey(1.0, 1.1), "a tenth is no reason");
    assert!(!grey(1.0, 2.0), "twice as bright is");
}

/// A box with its lamp inside whose faces point outwards.
fn inside_out(sidedness: Sidedness) -> Scene {
    let mut scene = cube([0; 6].map(|_| surface(0.5, 0.0, 0.0)));
    scene
        .materials
        .iter_mut()
        .for_each(|m| m.sidedness = sidedness);
    mesh_of(&mut scene, 0).flip();
    add_bulb(&mut scene, DVec3::splat(0.5), 1.0);
    scene
}

#[test]
fn a_room_inside_out_is_lit_inside() {
    for sidedness in [Sidedness::Unsaid, Sidedness::Two] {
        let mut scene = solved(inside_out(sidedness), StoredSides::BySurface);
        let mesh = mesh_of(&mut scene, 0);
        for face in 0..mesh.faces.len() {
            let inward = DVec3::splat(0.5) - mesh.face_positions(face)[0];
            assert!(mesh.face_area_vector(face).dot(inward) > 0.0);
        }
        assert!(mesh.irradiance.iter().all(|e| e.mean() > 0.5));
        // Outside there is no light, so it is not stored.
        assert!(mesh.back.is_none());
    }
}

#[test]
fn the_inside_of_a_closed_body_is_not_stored() {
    let mut scene = inside_out(Sidedness::Two);
    scene.lights.clear();
    add_bulb(&mut scene, dvec3(0.5, 0.5, 3.0), 1.0);
    let given = mesh_of(&mut scene, 0).area();
    let mut scene = solved(scene, StoredSides::BySurface);
    let mesh = mesh_of(&mut scene, 0);
    assert!(mesh.back.is_none());
    assert!((mesh.area() - given).abs() < 1e-9);
}

/// Every other tile of a wall is wound the other way.
fn chequered() -> Scene {
    let mut scene = sheet(1.0, 50.0, Sidedness::Unsaid);
    mesh_of(&mut scene, 0).turn_faces(|f| f % 2 == 1);
    scene
}

#[test]
fn a_wall_whose_faces_contradict_each_other_is_no_patchwork() {
    let mut both = solved(chequered(), StoredSides::BySurface);
    let mesh = mesh_of(&mut both, 0);
    assert!((0..mesh.faces.len()).all(|f| mesh.has_back(f)));
    for face in 0..mesh.faces.len() {
        let is_up = mesh.face_area_vector(face).z > 0.0;
        for &v in mesh.faces.get(face) {
            let p = mesh.positions[v as usize];
            let (up, down) = (under(ABOVE, p), 50.0 * under(BELOW, p));
            let truth = if is_up { up } else { down };
            let found = mesh.irradiance[v as usize].mean();
            assert!(
                (found / truth - 1.0).abs() < 3e-3,
                "{p}: {found}, not {truth}"
            );
        }
    }
    // One side for all: whichever it is, all faces are turned to it.
    let mut one = solved(chequered(), StoredSides::Brighter);
    let mesh = mesh_of(&mut one, 0);
    let is_up = mesh.face_area_vector(0).z > 0.0;
    check_bulbs(mesh, is_up, (1.0, 50.0), false);
}

/// A mesh that is kept stores one side per surface, with both asked for both.
#[test]
fn a_kept_mesh_is_turned_or_gets_both_sides() {
    let keep = |mut scene: Scene, sides| {
        let pass = FirstPass {
            keep_mesh: true,
            sides,
            ..rays(64)
        };
        let light = solve(&scene, &Tracer::new(&scene), &pass, &Progress::new()).unwrap();
        let turned = match &light.irradiance.objects[0] {
            ObjectIrradiance::Vertices { turned, .. } => turned.len(),
            _ => panic!("a kept mesh"),
        };
        scene.set_irradiance(light.irradiance);
        scene.validate().unwrap();
        (turned, mesh_of(&mut scene, 0).clone())
    };
    let unsaid = Sidedness::Unsaid;
    let (turned, mesh) = keep(sheet(0.0, 1.0, unsaid), StoredSides::BySurface);
    assert_eq!(turned, 4);
    check_bulbs(&mesh, false, (0.0, 1.0), false);
    let (turned, mesh) = keep(sheet(1.0, 50.0, Sidedness::Two), StoredSides::BySurface);
    assert_eq!(turned, 0);
    check_bulbs(&mesh, true, (1.0, 50.0), false);
    let (turned, mesh) = keep(sheet(1.0, 50.0, unsaid), StoredSides::Split);
    assert_eq!(turned, 0);
    check_bulbs(&mesh, true, (1.0, 50.0), true);
    // Where no face may be turned, the back is stored beside a front without light.
    let (turned, mesh) = keep(sheet(0.0, 1.0, unsaid), StoredSides::Unturned);
    assert_eq!(turned, 0);
    check_bulbs(&mesh, true, (0.0, 1.0), true);
    let (turned, mesh) = keep(sheet(1.0, 0.0, unsaid), StoredSides::Unturned);
    assert_eq!((turned, mesh.back), (0, None));
}

/// A budget is for all points that are gathered at: where both sides are stored, each gets half as many rays.
#[test]
fn a_budget_of_rays_counts_both_sides() {
    let scene = cornell_box(CornellVariant::Diffuse);
    let tracer = Tracer::new(&scene);
    let rays = |sides| {
        let pass = FirstPass {
            size: PatchSize::Edge(20.0),
            error: Some(0.5),
            ray_budget: Some(3e6),
            interpolate: false,
            sides,
            ..FirstPass::default()
        };
        let report = solve(&scene, &tracer, &pass, &Progress::new())
            .unwrap()
            .report;
        assert_eq!(report.method, Method::Paths, "{:?}", report.engine_used);
        (report.points, report.point_rays)
    };
    let (front, both) = (rays(StoredSides::Front), rays(StoredSides::Split));
    assert!(both.0 > 3 * front.0 / 2, "{front:?}, {both:?}");
    assert!(4 * both.1 < 3 * front.1, "{front:?}, {both:?}");
}
