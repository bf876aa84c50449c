//! Environments and suns, against closed forms.

use crate::rooms::*;
use azulejo_radiosity::{Estimate, PointNormal};
use azulejo_scene::sky::Sky;
use azulejo_scene::{
    Environment, Image, Light, LightKind, Material, Projection, Rgb, Scene, Texture, Up,
    environment,
};
use glam::{DVec3, dvec3};
use std::f64::consts::{PI, TAU};

/// Adds an upright picture whose pixels are those of `radiance` of the direction of their centres.
fn surround(scene: &mut Scene, size: (u32, u32), radiance: impl Fn(DVec3) -> Rgb) {
    let (width, height) = size;
    let pixel = |k: u32| {
        let (u, v) = (
            (f64::from(k % width) + 0.5) / f64::from(width),
            (f64::from(k / width) + 0.5) / f64::from(height),
        );
        radiance(direction(u, v)).to_f32()
    };
    let image = Image {
        width,
        height,
        pixels: (0..width * height).map(pixel).collect(),
        alpha: None,
    };
    scene.textures.push(Texture {
        path: "sky.hdr".into(),
        image: Some(image),
        ..Texture::default()
    });
    let sky = Environment::picture(0, Projection::Equirectangular, Up::Z);
    scene.lights.push(Light {
        name: "sky".into(),
        kind: LightKind::Environment(sky),
    });
}

/// The direction at a place of an upright picture.
fn direction(u: f64, v: f64) -> DVec3 {
    let (azimuth, zenith) = (TAU * (u - 0.5), PI * v);
    let across = zenith.sin();
    dvec3(
        across * azimuth.cos(),
        -across * azimuth.sin(),
        zenith.cos(),
    )
}

/// ∫ L cos over the directions above the ground for which `is_open`, by 64 × 64 points per pixel.
fn on_ground(scene: &Scene, is_open: impl Fn(DVec3) -> bool) -> Rgb {
    let image = scene.textures[0].image.as_ref().unwrap();
    let (columns, rows) = (64 * image.width, 64 * image.height);
    let mut sum = Rgb::BLACK;
    for row in 0..rows / 2 {
        let v = (f64::from(row) + 0.5) / f64::from(rows);
        let band = [row, row + 1].map(|r| PI * f64::from(r) / f64::from(rows));
        let width = TAU / f64::from(columns);
        let cell = environment::solid_angle_of_band(band[0], band[1], width);
        for column in 0..columns {
            let u = (f64::from(column) + 0.5) / f64::from(columns);
            let d = direction(u, v);
            if is_open(d) {
                let pixel = image.pixel(column / 64, row / 64);
                sum += Rgb::from(pixel.map(f64::from)) * (d.z * cell);
            }
        }
    }
    sum
}

fn floor() -> Scene {
    let mut scene = Scene::default();
    scene.units.up = Up::Z;
    let corner = dvec3(-4.0, -4.0, 0.0);
    let white = surface(0.5, 0.0, 0.0);
    add_sheet(&mut scene, corner, 8.0 * DVec3::X, 8.0 * DVec3::Y, white);
    scene
}

/// A sky with a bright spot, and a ground that must not be seen.
fn spotted(d: DVec3) -> Rgb {
    let spot = d.distance(dvec3(0.5, 0.5, 0.7).normalize()) < 0.2;
    let sky = Rgb::new(0.5, 0.7, 1.0) * (1.0 + d.x.abs());
    match (d.z > 0.0, spot) {
        (true, true) => Rgb::new(200.0, 180.0, 150.0),
        (true, false) => sky,
        (false, _) => Rgb::grey(2.0),
    }
}

/// All estimates lie where their errors say, and these are below `most` of the truth.
#[track_caller]
fn check(found: &[Estimate], truth: Rgb, most: f64) {
    let mut worse = 0;
    for e in found {
        let (off, error) = ((e.value - truth).map(f64::abs), e.error);
        worse += usize::from(off.g > 2.0 * error.g + 1e-9);
        assert!(off.g < 4.0 * error.g + 1e-9, "{e:?}, {truth:?}");
        assert!(error.g < most * truth.g, "{e:?}, {truth:?}");
    }
    assert!(worse * 6 < found.len(), "{worse} of {}", found.len());
}

fn grid() -> Vec<PointNormal> {
    let place = |k: u32| f64::from(k) - 2.6;
    (0..36)
        .map(|k| at(place(k % 6), place(k / 6), 0.0, DVec3::Z))
        .collect()
}

#[test]
fn an_open_floor_receives_the_sky_above() {
    let mut scene = floor();
    surround(&mut scene, (32, 16), spotted);
    let truth = on_ground(&scene, |_| true);
    let found = irradiance(&scene, &grid(), &rays(1024));
    check(&found, truth, 0.03);
}

/// A wall y = 1 over x in −3..3, 2 high.
fn add_wall(scene: &mut Scene, material: Material) {
    let corner = dvec3(-3.0, 1.0, 0.0);
    add_sheet(scene, corner, 6.0 * DVec3::X, 2.0 * DVec3::Z, material);
}

/// Whether a ray from the origin meets the wall.
fn meets_wall(d: DVec3) -> bool {
    d.y > 0.0 && (d.x / d.y).abs() < 3.0 && (0.0..2.0).contains(&(d.z / d.y))
}

fn at_origin() -> [PointNormal; 1] {
    [at(0.0, 0.0, 0.0, DVec3::Z)]
}

#[test]
fn a_wall_hides_a_part_of_it() {
    let mut scene = floor();
    add_wall(&mut scene, surface(0.0, 0.0, 0.0));
    surround(&mut scene, (32, 16), spotted);
    let truth = on_ground(&scene, |d| !meets_wall(d));
    // The spread of four estimates alone says what a lone point's error is.
    check(&irradiance(&scene, &at_origin(), &rays(4096)), truth, 0.04);
}

/// A mirror shows the sky behind the point.
#[test]
fn mirrors_show_the_sky() {
    let mut scene = floor();
    add_wall(&mut scene, surface(0.0, 1.0, 0.0));
    let smooth = |d: DVec3| Rgb::new(0.5, 0.7, 1.0) * if d.z > 0.0 { 1.0 + d.y } else { 2.0 };
    surround(&mut scene, (32, 16), smooth);
    let mirrored = |d: DVec3| meets_wall(dvec3(d.x, -d.y, d.z));
    let truth = on_ground(&scene, |d| !meets_wall(d)) + on_ground(&scene, mirrored);
    check(&irradiance(&scene, &at_origin(), &rays(4096)), truth, 0.03);
}

fn sun(half_angle: f64) -> LightKind {
    LightKind::Directional {
        direction: dvec3(0.6, 0.0, -0.8),
        irradiance: Rgb::grey(3.0),
        half_angle,
    }
}

fn add_sun(scene: &mut Scene, half_angle: f64) {
    scene.lights.push(Light {
        name: "sun".into(),
        kind: sun(half_angle),
    });
}

/// Nothing stands between: E = 3 · 0.8, without error.
#[test]
fn a_disc_gives_what_a_point_gives() {
    let mut scene = floor();
    add_sun(&mut scene, 0.1);
    for e in irradiance(&scene, &grid(), &rays(16)) {
        assert!((e.value.g - 2.4).abs() < 1e-12, "{e:?}");
        assert!(e.error.g < 1e-12, "{e:?}");
    }
}

/// A half plane hides the part of the disc beyond its edge: a segment of a circle.
#[test]
fn penumbrae_are_those_of_a_disc() {
    let (half_angle, height): (f64, f64) = (0.05, 2.0);
    let mut scene = floor();
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional {
            direction: -DVec3::Z,
            irradiance: Rgb::grey(3.0),
            half_angle,
        },
    });
    let corner = dvec3(0.0, -1e3, height);
    let black = surface(0.0, 0.0, 0.0);
    add_sheet(&mut scene, corner, 1e3 * DVec3::X, 2e3 * DVec3::Y, black);
    // Where the edge is seen at the sine s to the zenith, a disc of radius sin h is cut at s.
    for share in [-0.8, -0.3, 0.0, 0.5, 0.9] {
        let s = share * half_angle.sin();
        let x = -height * (s / (1.0 - s * s).sqrt());
        let segment = (share.acos() - share * (1.0 - share * share).sqrt()) / PI;
        let truth = 3.0 * (1.0 - segment);
        let points = [at(x, 0.0, 0.0, DVec3::Z), at(x, 1.0, 0.0, DVec3::Z)];
        for e in irradiance(&scene, &points, &rays(4096)) {
            let off = (e.value.g - truth).abs();
            assert!(off < 3.0 * e.error.g + 0.01, "{share}: {e:?}, {truth}");
            assert!(e.error.g < 0.03, "{share}: {e:?}, {truth}");
        }
    }
}

/// A disc whose lower half is below the horizon of a wall, and one in a mirror.
#[test]
fn discs_at_the_horizon_and_in_mirrors() {
    let mut scene = floor();
    add_sun(&mut scene, 0.05);
    // The wall's normal is at right angles to the sun: half of the disc of mean cosine
    // 4 sin h / 3π each side.
    let normal = dvec3(0.8, 0.0, 0.6);
    let grazing = [PointNormal {
        position: dvec3(0.0, 0.0, 1.0),
        normal,
    }];
    let half = 3.0 * 0.5 * 4.0 * 0.05f64.sin() / (3.0 * PI);
    let floor_alone = irradiance(&scene, &grazing, &rays(16384))[0];
    // The floor, in the sun, reflects half of 2.4 into the wall, to which its view factor is
    // little less than (1 − 0.6) / 2 where it ends: by the sky that is not there.
    assert!(floor_alone.value.g > half, "{floor_alone:?}, {half}");
    let mut dark = floor();
    dark.materials[0].diffuse = Rgb::BLACK;
    add_sun(&mut dark, 0.05);
    let e = irradiance(&dark, &grazing, &rays(16384))[0];
    assert!(
        (e.value.g - half).abs() < 3.0 * e.error.g + 0.01 * half,
        "{e:?}, {half}"
    );
    // A mirror x = 3, 0.8 bright, that is not in its own light: the sun comes from −x.
    let mirror = surface(0.0, 0.8, 0.0);
    let corner = dvec3(3.0, -10.0, 0.0);
    add_sheet(&mut scene, corner, 3.0 * DVec3::Z, 20.0 * DVec3::Y, mirror);
    // It reflects onto the floor up to where its upper edge does: 3 · 0.6/0.8 before it.
    for (x, truth) in [(2.0, 2.4 * 1.8), (1.2, 2.4 * 1.8), (-1.0, 2.4)] {
        let e = irradiance(&scene, &[at(x, 0.0, 0.0, DVec3::Z)], &rays(1024))[0];
        assert!(
            (e.value.g - truth).abs() < 0.005 * truth,
            "{x}: {e:?}, {truth}"
        );
    }
}

/// Light that is the same from everywhere takes no choice of directions, so that what sees nothing else has no noise.
#[test]
fn an_even_sky_and_ground_have_no_noise() {
    let mut scene = floor();
    let even = Sky {
        ground: 1.5,
        ..Sky::uniform(1.5)
    };
    scene.lights.push(Light {
        name: "sky".into(),
        kind: LightKind::Environment(Environment::sky(even, Up::Z, 0.0)),
    });
    for found in irradiance(&scene, &grid(), &rays(64)) {
        assert!((found.value.g - 1.5 * PI).abs() < 1e-6, "{found:?}");
        assert!(found.error.g < 1e-6, "{found:?}");
    }
}
