//! `EXT_lights_image_based`: the light of the surroundings, as coefficients of spherical harmonics
//! and as a cube map.
//!
//! Coefficients are those of irradiance: each band of the radiance times π, 2π/3 and π/4 (Ramamoorthi and
//! Hanrahan, *An Efficient Representation for Irradiance Environment Maps*, SIGGRAPH 2001). Where they say
//! that all directions are alike, they are the light; elsewhere the sharpest level of the cube map is.
//!
//! Babylon.js, the only viewer that reads the extension, takes the harmonics of the second band with the
//! opposite sign, and turns the cube map around (see [`super::cube_map`]). Files are written and read as it
//! shows them; azulejo's own files without [`MARK`] have the signs of the paper and the faces of OpenGL.

use super::cube_map::{face_of, opengl_face_of, unpacked};
use super::material::Surfaces;
use azulejo_scene::harmonics::{Y00, cosine_factor, real_harmonics};
use azulejo_scene::{Environment, Image, LightKind, Projection, Rgb, Up};
use glam::{DQuat, DVec3};
use serde_json::Value;
use std::f64::consts::PI;

/// Its name.
pub(super) const NAME: &str = "EXT_lights_image_based";

/// Name of the extra of a light that is written as Babylon.js shows it.
pub(super) const MARK: &str = "shownBy";

/// Most rows of the picture that a cube map becomes.
const MOST_ROWS: u32 = 1024;

/// Rows of the picture that coefficients become.
const SMOOTH_ROWS: u32 = 32;

/// Reads a light of a file that azulejo has written, or not.
///
/// # Errors
/// What is wrong with it.
pub(super) fn read(
    light: &Value,
    is_ours: bool,
    surfaces: &mut Surfaces,
) -> Result<LightKind, String> {
    let is_marked = || light["extras"]["azulejo"].get(MARK).is_some();
    let is_of_paper = is_ours && !is_marked();
    let intensity = light.get("intensity").map_or(Some(1.0), Value::as_f64);
    let intensity = intensity.filter(|i| *i >= 0.0 && i.is_finite());
    let intensity = intensity.ok_or("its intensity is not a number of at least 0")?;
    let harmonics = coefficients(light);
    if let Some(radiance) = harmonics.as_ref().and_then(uniform) {
        let radiance = (radiance * intensity).map(|c| c.max(0.0));
        return Ok(LightKind::Ambient { radiance });
    }
    let picture = match cube_map(light, is_of_paper, surfaces)? {
        Some(picture) => picture,
        None => smooth(
            &harmonics.ok_or("neither pictures nor coefficients")?,
            is_of_paper,
        ),
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
    is_uniform.then(|| harmonics[0] * (Y00 / PI))
}

/// The sharpest level of the cube map; `None` if there is none.
fn cube_map(
    light: &Value,
    is_of_paper: bool,
    surfaces: &mut Surfaces,
) -> Result<Option<Image>, String> {
    let Some(level) = light.get("specularImages").and_then(|levels| levels.get(0)) else {
        return Ok(None);
    };
    let faces: Vec<usize> = serde_json::from_value(level.clone()).unwrap_or_default();
    let faces: [usize; 6] = faces
        .try_into()
        .map_err(|_| "a cube map that is not of six images")?;
    let mut images = Vec::with_capacity(6);
    for face in faces {
        images.push(unpacked(surfaces.picture(face)?));
    }
    let rows = 2 * images.iter().map(|i| i.height).max().unwrap_or(1);
    let place = if is_of_paper { opengl_face_of } else { face_of };
    let seen = |d: DVec3| face_pixel(&images, place(d));
    Ok(Some(panorama(rows.clamp(2, MOST_ROWS), seen)))
}

/// What six faces show at a place.
fn face_pixel(images: &[Image], (face, s, t): (usize, f64, f64)) -> [f32; 3] {
    let image = &images[face];
    if image.width == 0 || image.height == 0 {
        return [0.0; 3];
    }
    let index = |x: f64, size: u32| {
        let place = (0.5 + 0.5 * x) * f64::from(size);
        (place as u32).min(size - 1)
    };
    image.pixel(index(s, image.width), index(t, image.height))
}

/// The real spherical harmonics of a unit direction with the signs of Babylon.js in band 1: those of the paper are the
/// harmonics of the opposite direction.
pub(super) fn harmonics(d: DVec3) -> [f64; 9] {
    real_harmonics(-d)
}

/// The radiance that coefficients describe, nowhere below 0.
fn smooth(coefficients: &[Rgb; 9], is_of_paper: bool) -> Image {
    panorama(SMOOTH_ROWS, |d| {
        let d = if is_of_paper { -d } else { d };
        let terms = coefficients.iter().zip(harmonics(d)).enumerate();
        let radiance: Rgb = terms.map(|(k, (c, y))| *c * (y / cosine_factor(k))).sum();
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
