//! Writes `EXT_lights_image_based`: all that shines from infinitely far away as one light.
//!
//! The specification demands coefficients of irradiance, and a cube map whose levels are blurred for
//! roughnesses evenly from 0 to 1, the smallest of about 16 pixels.

use super::cube_map::{CubeMap, MOST_RGBD};
use super::image_based::MARK;
use super::json_parts::named;
use super::pack::Pack;
use crate::picture::png;
use crate::picture::srgb::srgb_bytes;
use azulejo_scene::harmonics::Y00;
use azulejo_scene::{Environment, Image, Light, LightKind, Rgb, Scene, Up};
use glam::DVec3;
use serde_json::{Map, Value, json};
use std::f64::consts::PI;
use std::io;

/// Rows and columns of the sharpest faces.
pub(super) const SHARPEST: u32 = 128;

/// Of the level for roughness 1, from which the blurred levels are made, too.
const ROUGHEST: u32 = 16;

/// Most directions along the side of a pixel.
const MOST_SAMPLES: u32 = 16;

/// The extension for the light from infinitely far away, with pictures in `images`; `None` if there is
/// none.
///
/// # Errors
/// Those of encoding the pictures.
pub(super) fn write(
    scene: &Scene,
    pack: &mut Pack,
    images: &mut Vec<Value>,
) -> io::Result<Option<Value>> {
    let around: Vec<&Light> = scene.lights.iter().filter(|l| is_around(&l.kind)).collect();
    let Some(first) = around.first() else {
        return Ok(None);
    };
    let mut light = named(&first.name);
    let is_ambient = |light: &&Light| matches!(light.kind, LightKind::Ambient { .. });
    let is_bright = if around.iter().all(is_ambient) {
        uniform(&around, &mut light, pack, images)?
    } else {
        surroundings(scene, &around, &mut light, pack, images)?
    };
    Ok(is_bright.then(|| json!({ "lights": [light] })))
}

/// Whether a light shines from all around.
pub(super) fn is_around(kind: &LightKind) -> bool {
    matches!(kind, LightKind::Ambient { .. } | LightKind::Environment(_))
}

/// Writes ambient light, whose cube map has faces of 2 × 2 pixels, since some viewers refuse a single one; `false` if it is black.
fn uniform(
    around: &[&Light],
    light: &mut Map<String, Value>,
    pack: &mut Pack,
    images: &mut Vec<Value>,
) -> io::Result<bool> {
    let radiance: Rgb = around.iter().map(|l| ambient(&l.kind)).sum();
    let strength = radiance.max_channel();
    if strength <= 0.0 {
        return Ok(false);
    }
    let colour = radiance / strength;
    let mut file = Vec::new();
    let pixels = Image::opaque(2, 2, vec![colour.to_f32(); 4]);
    png::write(2, 2, &srgb_bytes(&pixels), &mut file)?;
    let mut coefficients = [Rgb::BLACK; 9];
    coefficients[0] = colour * (PI / Y00);
    let faces = [image("ambient", &file, pack, images); 6];
    describe(light, strength, &coefficients, 2, &[faces]);
    Ok(true)
}

/// Writes environments, and ambient light beside them; `false` if they are black.
fn surroundings(
    scene: &Scene,
    around: &[&Light],
    light: &mut Map<String, Value>,
    pack: &mut Pack,
    images: &mut Vec<Value>,
) -> io::Result<bool> {
    let turned = |d: DVec3| match scene.units.up {
        Up::Y => d,
        Up::Z => DVec3::new(d.x, -d.z, d.y),
    };
    let pictures: Vec<_> = around.iter().map(|l| picture(scene, &l.kind)).collect();
    let seen = |d: DVec3| {
        let d = turned(d);
        let parts = around.iter().zip(&pictures);
        parts
            .map(|(light, picture)| radiance(&light.kind, d, *picture))
            .sum()
    };
    // As dense as the pixels of the finest picture, whose rows are 180° together.
    let rows = pictures.iter().flatten().map(|p| p.height).max();
    let samples = rows.unwrap_or(0).div_ceil(2 * SHARPEST) + 1;
    let map = CubeMap::of(SHARPEST, samples.min(MOST_SAMPLES), seen);
    let intensity = map.mean().max_channel().max(map.peak() / MOST_RGBD);
    if !(intensity > 0.0 && intensity.is_finite()) {
        return Ok(false);
    }
    let map = map.scaled(1.0 / intensity);
    let mut levels = Vec::new();
    for level in levels_of(&map) {
        let mut faces = [0; 6];
        for (face, of_face) in faces.iter_mut().zip(level.rgbd_faces()) {
            let mut file = Vec::new();
            png::write_linear(&of_face, &mut file)?;
            *face = image("surroundings", &file, pack, images);
        }
        levels.push(faces);
    }
    let coefficients = map.irradiance_coefficients();
    describe(light, intensity, &coefficients, SHARPEST, &levels);
    Ok(true)
}

/// The map itself, and blurred for the other roughnesses.
fn levels_of(map: &CubeMap) -> Vec<CubeMap> {
    let count = (SHARPEST / ROUGHEST).ilog2();
    let mut coarse = map.halved();
    for _ in 1..count {
        coarse = coarse.halved();
    }
    let level = |k: u32| coarse.blurred(SHARPEST >> k, f64::from(k) / f64::from(count));
    let sharp = map.clone();
    std::iter::once(sharp)
        .chain((1..=count).map(level))
        .collect()
}

/// The radiance from everywhere; black of other lights.
fn ambient(kind: &LightKind) -> Rgb {
    match kind {
        LightKind::Ambient { radiance } => *radiance,
        _ => Rgb::BLACK,
    }
}

/// The radiance from a direction of the scene.
fn radiance(kind: &LightKind, direction: DVec3, picture: Option<&Image>) -> Rgb {
    match kind {
        LightKind::Environment(environment) => environment.radiance(direction, picture),
        other => ambient(other),
    }
}

/// The picture that an environment shows.
fn picture<'a>(scene: &'a Scene, kind: &LightKind) -> Option<&'a Image> {
    let LightKind::Environment(environment) = kind else {
        return None;
    };
    let texture = scene.textures.get(environment.texture()? as usize)?;
    texture.image.as_ref()
}

/// Whether the brightest pixel of an environment is so bright beside the mean that a sun or a lamp is in it,
/// which a cube map makes much larger.
pub(super) fn has_bright_spot(scene: &Scene, environment: &Environment) -> bool {
    picture(scene, &LightKind::Environment(*environment)).is_some_and(|image| {
        let channels = || image.pixels.iter().flatten().map(|&c| f64::from(c));
        let mean = channels().sum::<f64>() / (3 * image.pixels.len()).max(1) as f64;
        channels().fold(0.0, f64::max) > MOST_RGBD * mean
    })
}

/// Adds a PNG, and returns its index.
fn image(name: &str, png: &[u8], pack: &mut Pack, images: &mut Vec<Value>) -> usize {
    let mut image = named(name);
    image.insert("mimeType".into(), json!("image/png"));
    image.insert("bufferView".into(), json!(pack.bytes(png)));
    images.push(image.into());
    images.len() - 1
}

fn describe(
    light: &mut Map<String, Value>,
    intensity: f64,
    coefficients: &[Rgb; 9],
    size: u32,
    levels: &[[usize; 6]],
) {
    let coefficients = coefficients.map(Rgb::to_array);
    light.insert("intensity".into(), json!(intensity));
    light.insert("irradianceCoefficients".into(), json!(coefficients));
    light.insert("specularImageSize".into(), json!(size));
    light.insert("specularImages".into(), json!(levels));
    let mark = json!({ "azulejo": { (MARK): "Babylon.js" } });
    light.insert("extras".into(), mark);
}
