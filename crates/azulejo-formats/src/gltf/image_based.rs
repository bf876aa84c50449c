//! `EXT_lights_image_based`: the light of the surroundings, as coefficients of spherical harmonics
//! and as a cube map.
//!
//! Coefficients are those of irradiance, as Babylon.js reads them: each band of the radiance times
//! π, 2π/3 and π/4 (Ramamoorthi and Hanrahan, *An Efficient Representation for Irradiance
//! Environment Maps*, SIGGRAPH 2001). Where they say that all directions are alike, they are the
//! light; elsewhere the sharpest level of the cube map is.

use super::json_parts::named;
use super::material::Surfaces;
use super::pack::Pack;
use crate::picture::png;
use crate::picture::srgb::srgb_bytes;
use azulejo_scene::{Environment, Image, LightKind, Projection, Rgb, Scene, Up};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::io;

/// Its name.
pub(super) const NAME: &str = "EXT_lights_image_based";

/// The constant spherical harmonic Y₀₀.
const CONSTANT: f64 = 0.282_094_791_773_878_14;

/// Factors of the bands by which radiance becomes irradiance.
const BANDS: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];

/// Most rows of the picture that a cube map becomes.
const MOST_ROWS: u32 = 1024;

/// Rows of the picture that coefficients become.
const SMOOTH_ROWS: u32 = 32;

/// Reads light number `index`.
///
/// # Errors
/// What is wrong with it.
pub(super) fn read(light: &Value, surfaces: &mut Surfaces) -> Result<LightKind, String> {
    let intensity = light.get("intensity").map_or(Some(1.0), Value::as_f64);
    let intensity = intensity.filter(|i| *i >= 0.0 && i.is_finite());
    let intensity = intensity.ok_or("its intensity is no number of at least 0")?;
    let harmonics = coefficients(light);
    if let Some(radiance) = harmonics.as_ref().and_then(uniform) {
        let radiance = (radiance * intensity).map(|c| c.max(0.0));
        return Ok(LightKind::Ambient { radiance });
    }
    let picture = match cube_map(light, surfaces)? {
        Some(picture) => picture,
        None => smooth(&harmonics.ok_or("neither pictures nor coefficients")?),
    };
    let texture = surfaces.add_picture("surroundings", picture)?;
    let mut environment = Environment::picture(texture, Projection::Equirectangular, Up::Y);
    environment.scale = Rgb::grey(intensity);
    let rotation: Option<[f64; 4]> = light
        .get("rotation")
        .and_then(|r| serde_json::from_value(r.clone()).ok());
    if let Some(rotation) = rotation.map(DQuat::from_array)
        && rotation.is_finite()
        && rotation.length() > 0.0
    {
        let turned = rotation.normalize() * environment.world_from_environment;
        environment.world_from_environment = turned.normalize();
    }
    Ok(LightKind::Environment(environment))
}

/// The nine coefficients.
fn coefficients(light: &Value) -> Option<[Rgb; 9]> {
    let list: Vec<[f64; 3]> =
        serde_json::from_value(light.get("irradianceCoefficients")?.clone()).ok()?;
    let list: [[f64; 3]; 9] = list.try_into().ok()?;
    let is_finite = list.iter().flatten().all(|v| v.is_finite());
    is_finite.then(|| list.map(Rgb::from))
}

/// The radiance, if it is the same in all directions.
fn uniform(harmonics: &[Rgb; 9]) -> Option<Rgb> {
    let most = harmonics[0].map(f64::abs).max_channel() * 1e-6;
    let rest = harmonics[1..].iter();
    let is_uniform = rest
        .map(|c| c.map(f64::abs).max_channel())
        .all(|c| c <= most);
    is_uniform.then(|| harmonics[0] * (CONSTANT / PI))
}

/// The sharpest level of the cube map; `None` if there is none.
fn cube_map(light: &Value, surfaces: &mut Surfaces) -> Result<Option<Image>, String> {
    let Some(level) = light.get("specularImages").and_then(|levels| levels.get(0)) else {
        return Ok(None);
    };
    let faces: Vec<usize> = serde_json::from_value(level.clone()).unwrap_or_default();
    let faces: [usize; 6] = faces
        .try_into()
        .map_err(|_| "a cube map that is not of six images")?;
    let mut images = Vec::with_capacity(6);
    for face in faces {
        images.push(surfaces.picture(face)?);
    }
    let rows = 2 * images.iter().map(|i| i.height).max().unwrap_or(1);
    let seen = |d: DVec3| face_pixel(&images, d);
    Ok(Some(panorama(rows.clamp(2, MOST_ROWS), seen)))
}

/// What the faces +x, −x, +y, −y, +z, −z show in a direction (OpenGL 4.6, table 8.19).
fn face_pixel(images: &[Image], d: DVec3) -> [f32; 3] {
    let size = d.abs();
    let (face, s, t, depth) = if size.x >= size.y && size.x >= size.z {
        let is_back = d.x < 0.0;
        (
            usize::from(is_back),
            if is_back { d.z } else { -d.z },
            -d.y,
            size.x,
        )
    } else if size.y >= size.z {
        let is_down = d.y < 0.0;
        (
            2 + usize::from(is_down),
            d.x,
            if is_down { -d.z } else { d.z },
            size.y,
        )
    } else {
        let is_back = d.z < 0.0;
        (
            4 + usize::from(is_back),
            if is_back { -d.x } else { d.x },
            -d.y,
            size.z,
        )
    };
    let image = &images[face];
    if image.width == 0 || image.height == 0 {
        return [0.0; 3];
    }
    let index = |x: f64, size: u32| {
        let place = (0.5 + 0.5 * x / depth) * f64::from(size);
        (place as u32).min(size - 1)
    };
    image.pixel(index(s, image.width), index(t, image.height))
}

/// The radiance that coefficients describe, nowhere below 0.
fn smooth(harmonics: &[Rgb; 9]) -> Image {
    panorama(SMOOTH_ROWS, |d| {
        let basis = [
            CONSTANT,
            0.488_603 * d.y,
            0.488_603 * d.z,
            0.488_603 * d.x,
            1.092_548 * d.x * d.y,
            1.092_548 * d.y * d.z,
            0.315_392 * (3.0 * d.z * d.z - 1.0),
            1.092_548 * d.x * d.z,
            0.546_274 * (d.x * d.x - d.y * d.y),
        ];
        let band = |k: usize| BANDS[usize::from(k > 0) + usize::from(k > 3)];
        let terms = harmonics.iter().zip(basis).enumerate();
        let radiance: Rgb = terms.map(|(k, (c, y))| *c * (y / band(k))).sum();
        radiance.map(|c| c.max(0.0)).to_f32()
    })
}

/// An equirectangular picture, upright where y is up, of what is seen in directions of the world.
fn panorama(rows: u32, seen: impl Fn(DVec3) -> [f32; 3]) -> Image {
    let upright = Environment::picture(0, Projection::Equirectangular, Up::Y);
    let width = 2 * rows;
    let pixel = |k: u32| {
        let u = (f64::from(k % width) + 0.5) / f64::from(width);
        let v = (f64::from(k / width) + 0.5) / f64::from(rows);
        let local = Projection::Equirectangular.direction(u, v);
        seen(upright.world_from_environment * local)
    };
    Image {
        width,
        height: rows,
        pixels: (0..width * rows).map(pixel).collect(),
        ..Image::default()
    }
}

/// The extension for the ambient light of a scene, whose cube map is one white pixel in `images`;
/// `None` without ambient light.
///
/// # Errors
/// Those of encoding the pixel.
pub(super) fn ambient(
    scene: &Scene,
    pack: &mut Pack,
    images: &mut Vec<Value>,
) -> io::Result<Option<Value>> {
    let lights = scene.lights.iter().filter_map(|light| match light.kind {
        LightKind::Ambient { radiance } => Some((light, radiance)),
        _ => None,
    });
    let radiance: Rgb = lights.clone().map(|(_, radiance)| radiance).sum();
    let strength = radiance.max_channel();
    let Some((first, _)) = lights.into_iter().next().filter(|_| strength > 0.0) else {
        return Ok(None);
    };
    let colour = radiance / strength;
    let mut file = Vec::new();
    let pixel = Image {
        width: 1,
        height: 1,
        pixels: vec![colour.to_f32()],
        ..Image::default()
    };
    png::write(1, 1, &srgb_bytes(&pixel), &mut file)?;
    let mut image = named("ambient");
    image.insert("mimeType".into(), json!("image/png"));
    image.insert("bufferView".into(), json!(pack.bytes(&file)));
    images.push(image.into());
    let mut coefficients = [[0.0; 3]; 9];
    coefficients[0] = (colour * (PI / CONSTANT)).to_array();
    let mut light = named(&first.name);
    light.insert("intensity".into(), json!(strength));
    light.insert("irradianceCoefficients".into(), json!(coefficients));
    let faces = [images.len() - 1; 6];
    light.insert("specularImageSize".into(), json!(1));
    light.insert("specularImages".into(), json!([faces]));
    Ok(Some(json!({ "lights": [light] })))
}
