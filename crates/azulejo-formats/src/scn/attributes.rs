//! Object attributes: surfaces, transforms and textures; and lights.

use super::ScnResult;
use super::scope::TextureCommand;
use super::translate::ScnTranslator;
use crate::sff::document::{SurfaceRecord, TextureKind};
use azulejo_scene::Rgb;
use azulejo_scene::rtrace::{RtraceLight, RtraceLightKind, RtraceSource};
use glam::{DMat3, DMat4, DVec3};

/// Words that begin a transform, except `none`.
const TRANSFORMS: [&str; 4] = ["scale", "translate", "rotate", "general"];

/// Distance of lights that represent directional ones.
const FAR: f64 = 100_000.0;

/// A surface of the first type.
fn phong(
    color: Rgb,
    diffuse: Rgb,
    specular: Rgb,
    numbers: [f64; 2],
    transparency: Rgb,
) -> SurfaceRecord {
    plain(
        color,
        RtraceSource::Phong {
            diffuse,
            specular,
            phong: numbers[0],
            metal: numbers[1],
            transparency,
        },
    )
}

fn plain(color: Rgb, source: RtraceSource) -> SurfaceRecord {
    SurfaceRecord {
        color,
        is_emitter: false,
        is_unshadowed: false,
        source,
    }
}

impl ScnTranslator<'_> {
    /// Reads a surface after its keyword; returns its number.
    pub fn surface(&mut self) -> ScnResult<u32> {
        let is_emitter = self.stream.take(&["emitter"]);
        let is_unshadowed = self.stream.take(&["noshadow"]);
        let is_emitter = is_emitter || self.stream.take(&["emitter"]);
        let mut surface = self.surface_form()?;
        // The sign of a number is the flag, so it cannot be zero.
        if is_emitter {
            surface.color.r = surface.color.r.max(0.001);
        }
        if is_unshadowed {
            surface.color.g = surface.color.g.max(0.001);
        }
        (surface.is_emitter, surface.is_unshadowed) = (is_emitter, is_unshadowed);
        self.number_of(surface)
    }

    fn surface_form(&mut self) -> ScnResult<SurfaceRecord> {
        let stream = &mut self.stream;
        let (black, white) = (Rgb::BLACK, Rgb::WHITE);
        let tenth = Rgb::grey(0.1);
        // Strauss is a reflection model of its own.
        if stream.take(&["strauss"]) {
            let (color, smooth, metal) = (stream.color()?, stream.color()?, stream.color()?);
            let transparency = self.transparency()?;
            let source = RtraceSource::Strauss {
                smooth,
                metal,
                transparency,
            };
            return Ok(plain(color, source));
        }
        // Matte, plastic and metal are Phong surfaces whose coefficients derive from fewer parameters.
        if stream.take(&["matte"]) {
            let color = stream.color()?;
            return Ok(phong(color, Rgb::grey(0.999), black, [0.0, 0.0], black));
        }
        if stream.take(&["plastic"]) {
            let (color, s) = (stream.color()?, stream.color()?);
            let f = stream.within(0.0, 1.0, "focus of a highlight")?;
            let specular = s * 0.1;
            let numbers = [10.0 + 90.0 * f, 0.0];
            return Ok(phong(color, white - specular, specular, numbers, black));
        }
        if stream.take(&["metal", "metallic"]) {
            let (color, s) = (stream.color()?, stream.color()?);
            let f = stream.within(0.0, 1.0, "focus of a highlight")?;
            let specular = Rgb::grey(0.9) + s * 0.1;
            let numbers = [10.0 + 90.0 * f, 1.0];
            return Ok(phong(color, white - specular, specular, numbers, black));
        }
        // Glass and dielectrics also set the index of refraction of their scope.
        let glass = stream.take(&["glass"]);
        if glass || stream.take(&["dielectric", "die"]) {
            let (color, t) = (stream.color()?, stream.color()?);
            let n = if glass {
                1.52
            } else {
                stream.within(1.0, 300.0, "index of refraction")?
            };
            self.scopes.set_refraction(n);
            return Ok(phong(color, black, white - t, [100.0, 0.0], t));
        }
        // A surface without a keyword is a colour alone, or one followed by the coefficients.
        let color = stream.color()?;
        if !stream.color_follows() {
            return Ok(phong(color, Rgb::grey(0.9), tenth, [3.0, 0.0], tenth));
        }
        let (diffuse, specular) = (stream.color()?, stream.color()?);
        let exponent = stream.within(0.0, 300.0, "exponent of a highlight")?;
        let metal = stream.within(0.0, 1.0, "metal")?;
        let transparency = self.transparency()?;
        Ok(phong(
            color,
            diffuse,
            specular,
            [exponent, metal],
            transparency,
        ))
    }

    fn transparency(&mut self) -> ScnResult<Rgb> {
        if self.stream.color_follows() {
            self.stream.color()
        } else {
            Ok(Rgb::BLACK)
        }
    }

    /// The surface of objects without one.
    pub fn default_surface(&mut self) -> ScnResult<u32> {
        let (color, dim) = (Rgb::grey(0.9), Rgb::grey(0.1));
        self.number_of(phong(color, color, dim, [4.0, 0.0], Rgb::BLACK))
    }

    /// Reads a transform after its keyword, `None` for one that drops the previous ones.
    pub fn transform(&mut self) -> ScnResult<Option<DMat4>> {
        if self.stream.take(&["none", "reset"]) {
            return Ok(None);
        }
        match self.transform_if_any()? {
            Some(matrix) => Ok(Some(matrix)),
            None => {
                let expected = "none, scale, translate, rotate or general";
                Err(self.stream.unexpected(expected))
            }
        }
    }

    /// Reads a transform without its keyword, if one follows.
    pub fn transform_if_any(&mut self) -> ScnResult<Option<DMat4>> {
        let stream = &mut self.stream;
        // Look at the word without taking it, as a transform is optional here.
        let place = stream.place();
        let Some(word) = stream.peek_word().filter(|w| TRANSFORMS.contains(w)) else {
            return Ok(None);
        };
        stream.word();
        let matrix = match word {
            "scale" => {
                let x = stream.real()?;
                // A single factor scales all axes alike.
                let scale = if stream.real_follows() {
                    DVec3::new(x, stream.real()?, stream.real()?)
                } else {
                    DVec3::splat(x)
                };
                DMat4::from_scale(scale)
            }
            "translate" => DMat4::from_translation(stream.point()?),
            "rotate" => {
                // The axis is a letter or a vector.
                let axis = match stream.peek_word() {
                    Some("x") => DVec3::X,
                    Some("y") => DVec3::Y,
                    Some("z") => DVec3::Z,
                    _ => DVec3::ZERO,
                };
                let axis = if axis == DVec3::ZERO {
                    stream.vector()?.normalize()
                } else {
                    stream.word();
                    axis
                };
                DMat4::from_axis_angle(axis, stream.real()?.to_radians())
            }
            _ => {
                // A general transform is a matrix by rows, with a translation if a fourth point follows.
                let rows = [stream.point()?, stream.point()?, stream.point()?];
                let shift = if stream.point_follows() {
                    stream.point()?
                } else {
                    DVec3::ZERO
                };
                let linear = DMat3::from_cols_array_2d(&rows.map(|r| r.to_array())).transpose();
                let mut matrix = DMat4::from_mat3(linear);
                matrix.w_axis = shift.extend(1.0);
                matrix
            }
        };
        // As in SFF, a transform must have an inverse.
        if matrix.determinant() != 0.0 && matrix.inverse().is_finite() {
            return Ok(Some(matrix));
        }
        let found = "a singular transform";
        Err(stream.error(place, found, "a matrix whose determinant is not zero"))
    }

    /// Reads what follows `texture`; `None` drops the previous textures.
    pub fn texture(&mut self) -> ScnResult<Option<TextureCommand>> {
        let place = self.stream.place();
        if self.stream.take(&["none", "reset"]) {
            return Ok(None);
        }
        if self.stream.take(&["local"]) {
            return Ok(Some(TextureCommand::Local));
        }
        if self.stream.take(&["invariant"]) {
            return Ok(Some(TextureCommand::Invariant));
        }
        if let Some(matrix) = self.transform_if_any()? {
            return Ok(Some(TextureCommand::Record {
                place,
                matrix,
                kind: TextureKind {
                    number: 0,
                    values: Vec::new(),
                },
                file: String::new(),
            }));
        }
        match self.named_texture()? {
            Some(texture) => Ok(Some(texture)),
            None => {
                let expected = "none, local, invariant, a transform or a texture name";
                Err(self.stream.unexpected(expected))
            }
        }
    }

    /// Reads a texture that begins with its name, if one follows.
    pub fn named_texture(&mut self) -> ScnResult<Option<TextureCommand>> {
        let place = self.stream.place();
        let word = self.stream.peek_word().unwrap_or_default();
        let Some(number) = TEXTURES.iter().position(|t| t.0 == word) else {
            return Ok(None);
        };
        self.stream.word();
        let (_, numbers, has_file) = TEXTURES[number];
        let mut values = Vec::new();
        match word {
            "checkers" => values.push(self.texture_surface()?),
            "blotch" => values.extend([self.stream.real()?, self.texture_surface()?]),
            "wood" if self.stream.color_follows() => {
                values.extend(self.stream.color()?.to_array());
            }
            "wood" => values.extend([0.5, 0.5, 0.35]),
            // SCN omits its omega.
            "fbm_bump" => {
                let (offset, k) = (self.stream.real()?, self.stream.real()?);
                values.extend([offset, k, 0.5, self.stream.real()?, self.stream.real()?]);
            }
            "gradient" => {
                values.push(self.stream.real()?);
                values.extend(self.stream.vector()?.to_array());
            }
            "bump3" => {
                values.push(self.stream.real()?);
                let size = self.stream.real_follows();
                values.push(if size { self.stream.real()? } else { 0.001 });
            }
            _ => {
                for _ in 0..numbers {
                    values.push(self.stream.real()?);
                }
            }
        }
        let file = if !has_file {
            String::new()
        } else if word == "image_map" {
            self.stream.file_name()?
        } else {
            self.stream.file_name_if_any()
        };
        let matrix = self.transform_if_any()?.unwrap_or(DMat4::ZERO);
        let kind = TextureKind {
            number: number as u32,
            values,
        };
        Ok(Some(TextureCommand::Record {
            place,
            matrix,
            kind,
            file: if word == "blotch" {
                String::new()
            } else {
                file
            },
        }))
    }

    fn texture_surface(&mut self) -> ScnResult<f64> {
        if !self.stream.take(&["surface"]) {
            return Err(self.stream.unexpected("surface"));
        }
        let refraction = self.scopes.innermost().refraction;
        let sets = self.scopes.innermost().sets_refraction;
        let surface = self.surface()?;
        // Glass in a texture does not refract.
        self.scopes.restore_refraction(refraction, sets);
        Ok(f64::from(surface))
    }

    /// Reads a light after its keyword.
    pub fn light(&mut self) -> ScnResult<RtraceLight> {
        let stream = &mut self.stream;
        let place = stream.place();
        let kind = stream.word().unwrap_or_default();
        let position;
        let mut color = Rgb::WHITE;
        let kind = match kind {
            "point" => {
                position = stream.point()?;
                if stream.color_follows() {
                    color = stream.wide_color()?;
                }
                RtraceLightKind::Point
            }
            "directional" | "dir" => {
                position = -FAR * stream.vector()?.normalize();
                if stream.color_follows() {
                    color = stream.color()?;
                }
                // A negative colour means no attenuation with distance.
                color *= -1.0;
                RtraceLightKind::Point
            }
            "spot" => {
                position = stream.point()?;
                let direction = stream.vector()?.normalize();
                color = stream.wide_color()?;
                let (mut angle, mut factor) = (45.0, 1.0);
                if stream.real_follows() {
                    angle = stream.within(0.0, 180.0, "angle of a spotlight")?;
                    if stream.real_follows() {
                        factor = stream.within(1.0, 300.0, "factor of a spotlight")?;
                    }
                }
                RtraceLightKind::Spot {
                    direction,
                    half_angle: f64::to_radians(angle),
                    factor,
                }
            }
            "extended" | "ext" => {
                position = stream.point()?;
                color = stream.wide_color()?;
                RtraceLightKind::Extended {
                    radius: stream.positive("radius of a light")?,
                    samples: samples(stream)?,
                }
            }
            "linear" => {
                position = stream.point()?;
                color = stream.wide_color()?;
                RtraceLightKind::Planar {
                    edges: [stream.vector()?, DVec3::ZERO],
                    samples: [samples(stream)?, 0],
                }
            }
            "planar" => {
                position = stream.point()?;
                color = stream.wide_color()?;
                RtraceLightKind::Planar {
                    edges: [stream.vector()?, stream.vector()?],
                    samples: [samples(stream)?, samples(stream)?],
                }
            }
            other => {
                let expected = "point, directional, spot, extended, linear or planar";
                return Err(stream.error(place, format!("light \"{other}\""), expected));
            }
        };
        let channels = color.to_array();
        Ok(RtraceLight {
            position,
            brightness: color.map(f64::abs),
            fades: channels.map(|c| c >= 0.0),
            kind,
        })
    }
}

fn samples(stream: &mut super::values::TokenStream) -> ScnResult<u32> {
    Ok(stream
        .within(1.0, 256.0, "number of samples of a light")?
        .round() as u32)
}

/// Textures in the order of SFF's numbers: name, how many numbers, whether a file.
const TEXTURES: [(&str, usize, bool); 21] = [
    // A texture without a name only transforms the point, as `texture scale` does.
    (" ", 0, false),
    ("checkers", 0, false),
    ("blotch", 0, true),
    ("bump", 1, false),
    ("marble", 0, true),
    ("fbm", 6, true),
    ("fbm_bump", 0, false),
    ("wood", 0, false),
    ("round", 1, false),
    ("bozo", 1, true),
    ("ripples", 3, false),
    ("waves", 3, false),
    ("spotted", 0, true),
    ("dents", 1, false),
    ("agate", 0, true),
    ("wrinkles", 1, false),
    ("granite", 0, true),
    ("gradient", 0, true),
    ("image_map", 4, true),
    ("gloss", 1, false),
    ("bump3", 0, false),
];

/// Whether a word begins an attribute of an object.
pub(super) fn is_attribute(word: &str) -> bool {
    let keywords = ["surface", "transform", "refraction", "ior", "texture"];
    keywords.contains(&word) || TEXTURES.iter().any(|t| t.0 == word)
}
