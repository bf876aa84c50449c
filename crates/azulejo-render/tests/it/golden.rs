//! Small pictures, against those that were looked at and accepted.
//!
//! The accepted ones are `tests/golden/*.png`. A picture that differs is written beside the
//! accepted one and their difference into cargo's target directory, and the failing test names
//! the files. After looking at them, `AZULEJO_GOLDEN=renew cargo test -p azulejo-render golden`
//! accepts the new pictures.

mod scenes;

use crate::gallery::gallery;
use azulejo_formats::picture::png;
use azulejo_render::{FinalGather, SecondPass, Tone, render, srgb_from_linear, tone_map};
use azulejo_scene::{Camera, Scene};
use azulejo_trace::{Progress, Tracer};
use std::path::Path;

const SIZE: u32 = 64;

/// By how much a channel may differ, and how many channels of the 12,288 may differ by more:
/// rounding may move an edge to the other side of a sample.
const TOLERANCE: u8 = 3;
const OUTLIERS: usize = 40;

/// Light from the vertices, as the first pass leaves it.
const VERTICES: SecondPass = SecondPass {
    size: (SIZE, SIZE),
    samples_per_pixel: 16,
    gather: FinalGather::Unknown,
    seed: 0,
    evenness: 0.5,
    max_depth: 1000,
    clamp: None,
    contrast: None,
};

/// Direct light by formula and shadow rays, the rest by final gathers.
const GATHER: SecondPass = SecondPass {
    samples_per_pixel: 9,
    gather: FinalGather::Everywhere(4),
    ..VERTICES
};

#[test]
fn golden_gallery() {
    check("gallery", gallery(8), &VERTICES, 0.6);
}

#[test]
fn golden_textures() {
    check("textures", scenes::textures(), &GATHER, 1.0);
}

#[test]
fn golden_normals() {
    check("normals", scenes::normals(), &GATHER, 1.0);
}

#[test]
fn golden_glass() {
    check("glass", scenes::glass(), &GATHER, 1.0);
}

#[test]
fn golden_mirror() {
    check("mirror", scenes::mirror(), &GATHER, 1.0);
}

#[test]
fn golden_gloss() {
    check("gloss", scenes::gloss(), &GATHER, 1.0);
}

#[test]
fn golden_text() {
    check("text", scenes::text(), &GATHER, 1.0);
}

#[test]
fn golden_csg() {
    check("csg", scenes::csg(), &GATHER, 1.0);
}

#[test]
fn golden_fog() {
    check("fog", scenes::fog(), &GATHER, 1.0);
}

/// Renders a scene and compares, or renews the accepted picture.
fn check(name: &str, (scene, camera): (Scene, Camera), options: &SecondPass, exposure: f64) {
    scene.validate().expect("the test's scene is valid");
    let tracer = Tracer::new(&scene);
    let image = render(&scene, &tracer, &camera, options, &Progress::new());
    let actual = tone_map(&image.expect("not cancelled"), exposure, Tone::Filmic);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.png"));
    if renews() {
        return write(&path, &actual);
    }
    let expected = read(&path);
    if let Err(message) = compare(&actual, &expected) {
        let written = write_all(name, &actual, &expected);
        panic!(
            "{name}: {message}. See {written}; AZULEJO_GOLDEN=renew accepts the picture for {}",
            path.display()
        );
    }
}

/// Whether accepted pictures are to be replaced.
fn renews() -> bool {
    match std::env::var("AZULEJO_GOLDEN").as_deref() {
        Err(_) | Ok("") => false,
        Ok("renew") => true,
        Ok(other) => panic!("AZULEJO_GOLDEN is `{other}`; the only value that it takes is `renew`"),
    }
}

/// The number of outliers and the largest difference, if they are too many.
fn compare(actual: &[u8], expected: &[u8]) -> Result<(), String> {
    assert_eq!(actual.len(), expected.len(), "the pictures differ in size");
    let differences = || std::iter::zip(actual, expected).map(|(a, b)| a.abs_diff(*b));
    let outliers = differences().filter(|&d| d > TOLERANCE).count();
    if outliers <= OUTLIERS {
        return Ok(());
    }
    let largest = differences().max().unwrap_or(0);
    Err(format!(
        "{outliers} channels differ by more than {TOLERANCE} of 255, the largest by {largest}; \
         {OUTLIERS} are allowed"
    ))
}

/// Writes the actual and the expected picture and their difference, eight times as strong; returns
/// where they are.
fn write_all(name: &str, actual: &[u8], expected: &[u8]) -> String {
    let amplified = |(a, b): (&u8, &u8)| a.abs_diff(*b).saturating_mul(8);
    let difference: Vec<u8> = std::iter::zip(actual, expected).map(amplified).collect();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let files = [
        ("expected", expected),
        ("actual", actual),
        ("difference", &difference),
    ];
    let paths = files.map(|(what, pixels)| {
        let path = folder.join(format!("golden-{name}-{what}.png"));
        write(&path, pixels);
        path.display().to_string()
    });
    paths.join(", ")
}

fn write(path: &Path, pixels: &[u8]) {
    let mut bytes = Vec::new();
    png::write(SIZE, SIZE, pixels, &mut bytes).expect("memory takes everything");
    std::fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

/// The bytes of an accepted picture, three per pixel.
fn read(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path)
        .unwrap_or_else(|e| panic!("{}: {e}; AZULEJO_GOLDEN=renew makes it", path.display()));
    let image = png::read(&bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert_eq!(
        (image.width, image.height),
        (SIZE, SIZE),
        "{}",
        path.display()
    );
    let byte = |x: f32| (255.0 * srgb_from_linear(f64::from(x))).round() as u8;
    image.pixels.iter().flat_map(|p| p.map(byte)).collect()
}

#[test]
fn golden_pictures_come_back_from_their_files() {
    let pixels: Vec<u8> = (0..SIZE * SIZE * 3).map(|k| (k % 256) as u8).collect();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden-round-trip.png");
    write(&path, &pixels);
    assert_eq!(read(&path), pixels);
}

#[test]
fn golden_differences_are_counted() {
    let zeros = [0; 300];
    let with = |count: usize, value: u8| -> Vec<u8> {
        (0..300)
            .map(|k| if k < count { value } else { 0 })
            .collect()
    };
    assert_eq!(compare(&with(300, TOLERANCE), &zeros), Ok(()));
    assert_eq!(compare(&with(OUTLIERS, 200), &zeros), Ok(()));
    let message = compare(&with(OUTLIERS + 1, 200), &zeros).unwrap_err();
    assert!(message.starts_with("41 channels"), "{message}");
    assert!(message.contains("largest by 200"), "{message}");
}
