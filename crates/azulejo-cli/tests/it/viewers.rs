//! A baked room in viewers of others, compared with what rays see.
//!
//! Needs Node.js, Chromium and the packages of the viewers, and is skipped where they are missing.

use crate::directional::write_plates;
use crate::support::{Folder, project};
use azulejo_render::{ReferencePass, reference_radiance};
use azulejo_scene::harmonics::harmonic_irradiance;
use azulejo_scene::math::Ray;
use azulejo_scene::{Camera, Rgb, Scene};
use azulejo_testing::Need;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::ffi::OsStr;
use std::fs;

/// Width and height of the compared pictures, pixels.
const SIZE: u32 = 512;

/// Places that are compared.
const POINTS: usize = 64;

/// Pixels around a place that must show the same flat surface.
const MARGIN: u32 = 5;

/// Paths of each place.
const PATHS: u32 = 65_536;

/// What places may be off, in the root mean square and in the mean. Texels have 8 bits and errors of their own, which
/// are larger than 1% in the dark.
const TOLERANCE: f64 = 0.01;
const BIAS: f64 = 0.003;

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
    // glTF is in metres.
    let metres = room.units.metres();
    folder.write("camera.json", described(&camera, metres).to_string());
    folder.write("points.json", json!(places).to_string());
    folder.ok("bake box.grf -o baked.glb --size 512 --error 1% --lightmap e.exr");
    let mut truth = None;
    for (script, options) in [
        // What is read from other formats has no specular share, so that the standard material shows the same.
        ("three.mjs", &["--material", "lambert"][..]),
        ("three.mjs", &["--material", "lambert", "--exr", "e.exr"]),
        ("babylon.mjs", &[]),
    ] {
        let Some(seen) = shown(&folder, script, options) else {
            return;
        };
        let truth = truth.get_or_insert_with(|| paths(&room, &tracer, &camera, &places));
        compare(
            &format!("{script} {}", options.join(" ")),
            &places,
            &seen,
            truth,
        );
    }
}

/// A normal map shows what a surface with that tilt has, within 5%, where the lightmap says where light comes from.
#[test]
fn relief_has_the_light_of_tilted_surfaces() {
    let packages = std::env::var("AZULEJO_VIEWERS").map_err(|e| format!("AZULEJO_VIEWERS: {e}"));
    if azulejo_testing::require(Need::Browser, packages).is_none() {
        return;
    }
    let folder = Folder::new();
    write_plates(&folder);
    let camera = json!({ "eye": [0.0, 2.0, 0.01], "target": [0.0, 0.0, 0.0], "up": [0.0, 0.0, -1.0],
                         "vertical_fov": 30.0, "width": 64, "height": 64 });
    folder.write("camera.json", camera.to_string());
    folder.write(
        "points.json",
        json!([[32, 32], [25, 25], [40, 40], [25, 40]]).to_string(),
    );
    for script in ["three.mjs", "babylon.mjs"] {
        let of = |model: &str| {
            folder.ok(&format!(
                "bake {model}.gltf -o baked.glb --size 64 --error 1% --sky 0.5 --directional"
            ));
            shown(&folder, script, &[])
        };
        let (Some(relief), Some(tilted), Some(flat)) = (of("relief"), of("tilted"), of("flat"))
        else {
            return;
        };
        for ((relief, tilted), flat) in relief.iter().zip(&tilted).zip(&flat) {
            for c in 0..3 {
                let off = relief[c] / tilted[c] - 1.0;
                assert!(off.abs() < 0.05, "{script}: {relief:?} {tilted:?}");
                assert!(flat[c] / tilted[c] > 1.1, "{script}: {flat:?} {tilted:?}");
            }
        }
    }
}

/// A matt ball in a grid of probes has on each side what their harmonics say, in three.js.
#[test]
fn probes_light_a_ball_from_where_light_comes() {
    let packages = std::env::var("AZULEJO_VIEWERS").map_err(|e| format!("AZULEJO_VIEWERS: {e}"));
    if azulejo_testing::require(Need::Browser, packages).is_none() {
        return;
    }
    let folder = Folder::new();
    folder.write(
        "far.obj",
        "v 0 -9000 0\nv 1 -9000 0\nv 1 -9000 1\nf 1 3 2\n",
    );
    folder.ok(
        "probe far.obj --sky cie:12 --sun 140,35 --grid 3,2,4 --grid-box -1,-1,-1,1,1,1 --error 1% -o volume.json",
    );
    let volume: Value = serde_json::from_slice(&folder.read("volume.json")).unwrap();
    let numbers = volume["coefficients"].as_array().unwrap();
    let number = |k: usize| numbers[k].as_f64().unwrap();
    let coefficients: [Rgb; 9] =
        std::array::from_fn(|k| Rgb::from([0, 1, 2].map(|c| number(3 * k + c))));
    folder.write("points.json", "[[32, 32]]");
    for eye in [
        [3.0, 2.0, 1.0],
        [-2.0, 1.0, -3.0],
        [0.5, 3.0, 0.2],
        [-1.0, -2.0, 2.0],
    ] {
        let camera = json!({ "eye": eye, "target": [0.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0], "vertical_fov": 4.0,
                             "width": 65, "height": 65 });
        folder.write("camera.json", camera.to_string());
        let Some(seen) = shown_of(&folder, "probes.mjs", "volume.json", &[]) else {
            return;
        };
        let expected =
            harmonic_irradiance(&coefficients, DVec3::from(eye).normalize()) * (0.5 / PI);
        for c in 0..3 {
            // The light of all probes is the same but for their noise.
            let off = seen[0][c] / expected[c] - 1.0;
            assert!(
                off.abs() < 0.02,
                "from {eye:?}: {:?}, {expected:?}",
                seen[0]
            );
        }
    }
}

fn scene(folder: &Folder) -> Scene {
    let bytes = folder.read("box.grf");
    let files = azulejo_formats::Memory::new();
    azulejo_formats::read(&bytes, "box.grf", &files)
        .unwrap()
        .scene
}

fn scripts() -> std::path::PathBuf {
    project().join("crates/azulejo-bake/tests/viewers")
}

/// The camera for the scripts.
fn described(camera: &Camera, metres: f64) -> Value {
    json!({
        "eye": (metres * camera.eye).to_array(),
        "target": (metres * camera.target).to_array(),
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
        let placed = scene.objects[hit.object as usize].shape.placed_mesh()?;
        let material = placed.mesh.face_materials[hit.face as usize];
        let material = &scene.materials[material as usize];
        (!material.is_emitter()).then_some((hit.object, hit.normal))
    };
    let is_flat = |x: u32, y: u32| {
        let Some((object, normal)) = surface(x, y) else {
            return false;
        };
        let around = [
            (0, 1),
            (1, 0),
            (2, 1),
            (1, 2),
            (0, 0),
            (2, 0),
            (0, 2),
            (2, 2),
        ];
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
    shown_of(folder, script, "baked.glb", options)
}

fn shown_of(folder: &Folder, script: &str, model: &str, options: &[&str]) -> Option<Vec<[f64; 3]>> {
    let path = |name: &str| folder.path(name).into_os_string();
    let mut arguments = [model, "camera.json", "points.json"].map(path).to_vec();
    for option in options {
        arguments.push(match *option {
            "e.exr" => path(option),
            other => other.into(),
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
    let (mut square, mut sum, mut noise) = (0.0, 0.0, 0.0);
    let mut worst = (0.0, [0.0; 2]);
    for ((place, seen), (light, error)) in places.iter().zip(seen).zip(truth) {
        // Channels that are all but black have no per cent.
        let size = light.max_channel();
        for c in 0..3 {
            let off: f64 = (seen[c] - light[c]) / size;
            (square, sum) = (square + off * off, sum + off);
            noise += (error[c] / size).powi(2);
            if off.abs() > worst.0 {
                worst = (off.abs(), *place);
            }
        }
    }
    let count = 3.0 * seen.len() as f64;
    let [rms, noise] = [square, noise].map(|x: f64| (x / count).sqrt());
    let said = format!(
        "{name}: {} places, {:.2}% off (root mean square; noise of the paths {:.2}%), {:.2}% in the mean, at \
         most {:.2}% at {:?}",
        seen.len(),
        100.0 * rms,
        100.0 * noise,
        100.0 * sum / count,
        100.0 * worst.0,
        worst.1
    );
    assert!(rms < TOLERANCE && (sum / count).abs() < BIAS, "{said}");
}
