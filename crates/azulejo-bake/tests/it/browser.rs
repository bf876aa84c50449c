//! The page in a browser, compared with what rays see.
//!
//! Needs Node.js and Chromium, and is skipped where they are missing.

use crate::room::{Room, lamp_light};
use crate::swatches;
use azulejo_bake::web_page::{self, PageModel};
use azulejo_scene::Up;
use glam::DVec3;
use serde_json::{Value, json};
use std::path::Path;

/// Pixels of the compared picture.
const SIZE: u32 = 400;

/// Radiance, irradiance and standard error at more than 64 places are within 1% of those of rays; the
/// controls work; nothing is asked of the network.
#[test]
fn pixels_are_what_rays_see() {
    let room = Room::cornell();
    check("room", &room.page(1024, lamp_light), &expectation(&room));
}

/// Pictures, masks, blending, unlit and vertex colours, backs, and emission, with either axis up.
#[test]
fn materials_are_what_they_say() {
    for up in [Up::Y, Up::Z] {
        let (model, expected) = swatches::swatches(up);
        check(&format!("swatches-{up:?}"), &model, &expected);
    }
}

/// Compares the page of a model with what is expected of it.
fn check(name: &str, model: &PageModel, expected: &Value) {
    let folder = std::env::temp_dir().join(format!("azulejo-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let paths = (folder.join("page.html"), folder.join("expected.json"));
    let mut bytes = Vec::new();
    web_page::write(model, &mut bytes).unwrap();
    std::fs::write(&paths.0, bytes).unwrap();
    std::fs::write(&paths.1, expected.to_string()).unwrap();
    run(&paths.0, &paths.1);
    std::fs::remove_dir_all(folder).unwrap();
}

fn run(page: &Path, expected: &Path) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/check.mjs");
    let arguments = [page.as_os_str(), expected.as_os_str()];
    let Some(output) = azulejo_testing::browser_script(&script, &arguments) else {
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{errors}");
}

/// What the first camera sees in the middles of pixels on a grid, away from edges.
fn expectation(room: &Room) -> Value {
    let camera = &room.scene.cameras[0];
    let mut points = Vec::new();
    for k in 0..24 * 24 {
        let [x, y] = [k % 24, k / 24].map(|i| f64::from(i * 16 + 14) + 0.5);
        let size = f64::from(SIZE);
        let ray = camera.ray(x / size, y / size, 1.0);
        let Some((face, distance)) = room.hit(&ray) else {
            continue;
        };
        // A pixel is a few units wide, and light has a kink where it falls flat.
        let place = ray.at(distance);
        let cosine = (DVec3::new(278.0, 480.0, 279.5) - place)
            .normalize()
            .dot(face.normal);
        if face.margin(place) < 4.0 || cosine.abs() < 0.02 {
            continue;
        }
        let (light, error) = lamp_light(room, place, face.normal);
        let luminance = |c: [f32; 3]| azulejo_scene::Rgb::from(c.map(f64::from)).luminance();
        points.push(json!({
            "x": x,
            "y": y,
            "radiance": room.radiance(&ray, lamp_light),
            "light": light,
            "error": luminance(error),
        }));
    }
    assert!(points.len() >= 64);
    json!({ "camera": 0, "width": SIZE, "height": SIZE, "operates": true, "points": points })
}
