//! Direct light through panes of glass: as exact as without them.

use crate::rooms::*;
use azulejo_radiosity::{Estimate, PointNormal};
use azulejo_scene::{Light, LightKind, Material, Rgb, Scene, fresnel};
use azulejo_trace::lambert::point_to_polygon;
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

const TINT: Rgb = Rgb::new(0.9, 0.6, 0.3);

/// A black floor.
fn floor() -> Scene {
    let mut scene = Scene::default();
    let corner = dvec3(-4.0, -4.0, 0.0);
    let black = surface(0.0, 0.0, 0.0);
    add_sheet(&mut scene, corner, 8.0 * DVec3::X, 8.0 * DVec3::Y, black);
    scene
}

/// A tinted pane over all that the points see of the lights.
fn add_pane(scene: &mut Scene, z: f64) {
    let mut pane = Material::pane("pane", 1.5);
    pane.dielectric.as_mut().unwrap().transmittance = TINT;
    let corner = dvec3(-20.0, -20.0, z);
    add_sheet(scene, corner, 40.0 * DVec3::X, 40.0 * DVec3::Y, pane);
}

/// What a clear pane z = const passes in a unit direction.
fn passed(direction: DVec3) -> f64 {
    let down = dvec3(direction.x, direction.y, -direction.z.abs());
    1.0 - fresnel::pane(down, DVec3::Z, 1.5).reflectance
}

fn grid() -> Vec<PointNormal> {
    let place = |k: u32| 0.6 * f64::from(k) - 1.6;
    (0..36)
        .map(|k| at(place(k % 6), place(k / 6), 0.0, DVec3::Z))
        .collect()
}

/// All estimates lie where they should, with errors below `most` of the truth.
#[track_caller]
fn check(found: &[Estimate], truths: &[Rgb], most: f64) {
    for (e, truth) in found.iter().zip(truths) {
        for k in 0..3 {
            let off = (e.value[k] - truth[k]).abs();
            assert!(off < 4.0 * e.error[k] + 1e-5 * truth[k], "{e:?}, {truth:?}");
            assert!(e.error[k] <= most * truth[k], "{e:?}, {truth:?}");
        }
    }
}

#[test]
fn point_lights_through_panes_are_exact() {
    let mut scene = floor();
    let position = dvec3(0.3, -0.2, 2.0);
    let intensity = Rgb::grey(7.0);
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point {
            position,
            intensity,
        },
    });
    add_pane(&mut scene, 1.0);
    add_pane(&mut scene, 0.5);
    let truth = |p: &PointNormal| {
        let d = position - p.position;
        let free = 7.0 * d.z / d.length().powi(3);
        TINT * TINT * (free * passed(d.normalize()).powi(2))
    };
    let truths: Vec<Rgb> = grid().iter().map(truth).collect();
    check(&irradiance(&scene, &grid(), &rays(16)), &truths, 0.0);
}

/// No path through glass finds the sun: its disc is too small.
#[test]
fn the_sun_through_a_pane_has_hardly_any_error() {
    for half_angle in [0.0, 0.0047] {
        let mut scene = floor();
        let direction = dvec3(0.6, 0.0, -0.8);
        scene.lights.push(Light {
            name: "sun".into(),
            kind: LightKind::Directional {
                direction,
                irradiance: Rgb::grey(3.0),
                half_angle,
            },
        });
        add_pane(&mut scene, 0.5);
        let truths = [TINT * (2.4 * passed(direction)); 36];
        let found = irradiance(&scene, &grid(), &rays(64));
        // Over the disc the glass passes not quite the same everywhere.
        let most = if half_angle > 0.0 { 2e-4 } else { 0.0 };
        check(&found, &truths, most);
    }
}

/// A lamp above a pane: ∫ L cos cos′/r² over it, weighted by what the pane passes.
#[test]
fn lamps_through_panes_are_known_nearly_without_noise() {
    let mut scene = floor();
    let (corner, side) = (dvec3(-0.5, -0.5, 2.0), 1.0);
    // Seen from below: its front is turned down.
    let lamp = surface(0.0, 0.0, PI * 5.0);
    add_sheet(&mut scene, corner, side * DVec3::Y, side * DVec3::X, lamp);
    add_pane(&mut scene, 1.0);
    let steps = 200;
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    let truth = |p: &PointNormal| {
        let cells = (0..steps * steps).map(|k| {
            let y = corner + dvec3(place(k % steps), place(k / steps), 0.0);
            let d = y - p.position;
            let kernel = d.z * d.z / d.length_squared().powi(2);
            kernel * passed(d.normalize())
        });
        TINT * (5.0 * cells.sum::<f64>() / f64::from(steps * steps))
    };
    let truths: Vec<Rgb> = grid().iter().map(truth).collect();
    let polygon =
        [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, y)| corner + dvec3(x, y, 0.0));
    let p = &grid()[0];
    let free = 5.0 * PI * point_to_polygon(p.position, p.normal, &polygon);
    let share = truths[0].r / (free * TINT.r);
    assert!((0.8..0.93).contains(&share), "{share}");
    let found = irradiance(&scene, &grid(), &rays(1024));
    check(&found, &truths, 3e-3);
}
