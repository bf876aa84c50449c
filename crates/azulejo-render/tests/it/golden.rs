//! A picture of everything, against the one that was looked at and accepted.
//!
//! Pictures are binary PPM: any viewer shows them, and reading one takes a few lines. To accept
//! a new one, look at what the failing test wrote and run it again with `AZULEJO_ACCEPT=1`.

use crate::gallery::gallery;
use azulejo_render::{SecondPass, Tone, render, tone_map};
use azulejo_trace::{Progress, Tracer};
use std::path::{Path, PathBuf};

const SIZE: u32 = 64;

/// How far a channel may be off, and how many channels may be off further: edges may fall on
/// the other side of a sample when rounding changes.
const TOLERANCE: u8 = 3;
const OUTLIERS: usize = 40;

#[test]
fn gallery_looks_as_accepted() {
    check("gallery");
}

fn check(name: &str) {
    let (scene, eye) = gallery(8);
    let options = SecondPass {
        size: (SIZE, SIZE),
        samples_per_pixel: 16,
        ..SecondPass::default()
    };
    let image = render(
        &scene,
        &Tracer::new(&scene),
        &eye,
        &options,
        &Progress::new(),
    )
    .expect("nobody cancels");
    let actual = tone_map(&image, 0.6, Tone::Filmic);
    let path = golden_folder().join(format!("{name}.ppm"));
    if std::env::var_os("AZULEJO_ACCEPT").is_some() {
        write_ppm(&path, &actual);
    }
    let expected = read_ppm(&path);
    let difference: Vec<u8> = actual
        .iter()
        .zip(&expected)
        .map(|(a, b)| a.abs_diff(*b))
        .collect();
    let off = difference.iter().filter(|&&d| d > TOLERANCE).count();
    if off > OUTLIERS {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let amplified: Vec<u8> = difference.iter().map(|d| d.saturating_mul(8)).collect();
        for (what, bytes) in [
            ("actual", &actual),
            ("expected", &expected),
            ("difference", &amplified),
        ] {
            write_ppm(&folder.join(format!("{name}-{what}.ppm")), bytes);
        }
        panic!(
            "{off} channels of {name} are off by more than {TOLERANCE}: see {}",
            folder.display()
        );
    }
}

fn golden_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

fn header() -> String {
    format!("P6\n{SIZE} {SIZE}\n255\n")
}

fn write_ppm(path: &Path, pixels: &[u8]) {
    let bytes = [header().as_bytes(), pixels].concat();
    std::fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

fn read_ppm(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let pixels = bytes
        .strip_prefix(header().as_bytes())
        .expect("a PPM that this test wrote");
    assert_eq!(
        pixels.len(),
        (SIZE * SIZE * 3) as usize,
        "{}",
        path.display()
    );
    pixels.to_vec()
}
