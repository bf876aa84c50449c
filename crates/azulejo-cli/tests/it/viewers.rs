//! A baked room in viewers of others, compared with what rays see.
//!
//! Needs Node.js, Chromium and the packages of the viewers, and is skipped where they are missing.

use crate::support::{Folder, project};
use azulejo_render::{ReferencePass, reference_radiance};
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Rgb, Scene};
use azulejo_testing::Need;
use azulejo_trace::{Progress, Tracer};
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::fs;

/// Width and height of the compared pictures, pixels.
const SIZE: u32 = 512;

/// Places that are compared.
const POINTS: usize = 64;

/// Pixels around a place that must show the same flat surface.
const MARGIN: u32 = 5;

/// Paths of each place.
const PATHS: u32 = 32_768;

/// What a place may be off, beside three standard errors of the paths.
const TOLERANCE: f64 = 0.01;

/// three.js and Babylon.js show the Cornell box that was baked as paths from the same camera see it.
#[test]
fn a_baked_room_is_shown_as_paths_see_it() {
    let packages = std::env::var("AZULEJO_VIEWERS").map_err(|e| format!("AZULEJO_VIEWERS: {e}"));
    if azulejo_testing::require(Need::Browser, packages).is_none() {
        return;
    }
    let folder = Folder::new();
    let text = fs::read(project().join("examples/cornell.grf")).unwrap();
    folder.write("box.grf", text);
    let room = scene(&folder);
    let camera = room.cameras[0].clone();
    let tracer = Tracer::new(&room);
    let places = places(&room, &tracer, &camera);
    folder.write("camera.json", described(&camera).to_string());
    folder.write("points.json", json!(places).to_string());
    folder.ok("bake box.grf -o baked.glb --size 1024 --error 0.5% --lightmap e.exr");
    let mut truth = None;
    for (script, options) in [
        ("three.mjs", &[][..]),
        ("three.mjs", &["--exr", "e.exr"]),
        ("babylon.mjs", &[]),
        ("babylon.mjs", &["--exr", "e.exr"]),
    ] {
        let Some(seen) = shown(&folder, script, options) else {
            return;
        };
        let truth = truth.get_or_insert_with(|| paths(&room, &tracer, &camera, &places));
        compare(&format!("{script} {}", options.join(" ")), &places, &seen, truth);
    }
}

fn scene(folder: &Folder) -> Scene {
    let bytes = folder.read("box.grf");
    let files = azulejo_formats::Memory::new();
    azulejo_formats::read(&bytes, "box.grf", &files).unwrap().scene
}

fn scripts() -> std::path::PathBuf {
    project().join("crates/azulejo-bake/tests/viewers")
}

/// The camera for the scripts.
fn described(camera: &Camera) -> Value {
    json!({
        "eye": camera.eye.to_array(),
        "target": camera.target.to_array(),
        "up": camera.up.to_array(),
        "vertical_fov": camera.vertical_fov.to_degrees(),
        "width": SIZE,
        "height": SIZE,
    })
}

fn ray(camera: &Camera, [x, y]: [f64; 2]) -> Ray {
    camera.ray(x / f64::from(SIZE), y / f64::from(SIZE), 1.0)
}

/// Middles of pixels all over the picture, away from edges and lamps.
fn places(scene: &Scene, tracer: &Tracer, camera: &Camera) -> Vec<[f64; 2]> {
    let surface = |x: u32, y: u32| {
        let hit = tracer.hit(&ray(camera, [x, y].map(|i| f64::from(i) + 0.5)))?;
        let material = &scene.materials[hit.material as usize];
        (!material.is_emitter()).then_some((hit.object, hit.normal))
    };
    let is_flat = |x: u32, y: u32| {
        let Some((object, normal)) = surface(x, y) else {
            return false;
        };
        let around = [(0, 1), (1, 0), (2, 1), (1, 2), (0, 0), (2, 0), (0, 2), (2, 2)];
        around.iter().all(|(i, j)| {
            let beside = surface(x + i * MARGIN - MARGIN, y + j * MARGIN - MARGIN);
            beside.is_some_and(|(o, n)| o == object && n.dot(normal) > 0.999)
        })
    };
    // A lattice without rows or columns (R2 of Roberts 2018).
    let inside = f64::from(SIZE - 2 * MARGIN - 1);
    let place = |k: u32| {
        let part = |step: f64| MARGIN + (inside * (0.5 + step * f64::from(k)).fract()) as u32;
        (part(0.754_877_666_246_692_8), part(0.569_840_290_998_053_3))
    };
    let found = (0..).map(place).filter(|&(x, y)| is_flat(x, y));
    let found: Vec<[f64; 2]> = found
        .take(POINTS)
        .map(|(x, y)| [f64::from(x) + 0.5, f64::from(y) + 0.5])
        .collect();
    assert_eq!(found.len(), POINTS);
    found
}

/// Radiance with its standard error.
fn paths(scene: &Scene, tracer: &Tracer, camera: &Camera, places: &[[f64; 2]]) -> Vec<(Rgb, Rgb)> {
    let rays: Vec<Ray> = places.iter().map(|&place| ray(camera, place)).collect();
    let options = ReferencePass {
        samples_per_pixel: PATHS,
        ..ReferencePass::default()
    };
    reference_radiance(scene, tracer, &rays, &options, &Progress::new()).unwrap()
}

/// What a viewer shows at the places; `None` if it is not installed.
fn shown(folder: &Folder, script: &str, options: &[&str]) -> Option<Vec<[f64; 3]>> {
    let path = |name: &str| folder.path(name).into_os_string();
    let mut arguments = ["baked.glb", "camera.json", "points.json"].map(path).to_vec();
    for option in options {
        arguments.push(if option.starts_with("--") {
            option.into()
        } else {
            path(option)
        });
    }
    let arguments: Vec<&OsStr> = arguments.iter().map(|a| a.as_os_str()).collect();
    let output = azulejo_testing::browser_script(&scripts().join(script), &arguments)?;
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{script}: {errors}");
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

fn compare(name: &str, places: &[[f64; 2]], seen: &[[f64; 3]], truth: &[(Rgb, Rgb)]) {
    assert_eq!(seen.len(), truth.len());
    let (mut square, mut worst, mut noise) = (0.0, 0.0f64, 0.0);
    for ((place, seen), (light, error)) in places.iter().zip(seen).zip(truth) {
        // Channels that are all but black have no per cent.
        let light_size = light.max_channel();
        for c in 0..3 {
            let off = (seen[c] - light[c]) / light_size;
            let sure = error[c] / light_size;
            assert!(
                off.abs() < TOLERANCE + 3.0 * sure,
                "{name} at {place:?}: {seen:?}, paths see {light:?} ± {error:?}"
            );
            square += off * off;
            noise += sure * sure;
            worst = worst.max(off.abs());
        }
    }
    let count = 3.0 * seen.len() as f64;
    let share = |x: f64| 100.0 * x;
    println!(
        "{name}: {} places, {:.2}% off (root mean square; noise of the paths {:.2}%), at most {:.2}%",
        seen.len(),
        share((square / count).sqrt()),
        share((noise / count).sqrt()),
        share(worst)
    );
}
