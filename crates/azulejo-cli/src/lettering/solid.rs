//! Conversion of flat outlines to a scene with one object of prisms.

use super::args::{EdgeArgs, FrameArgs, SurfaceArgs};
use super::values::{Edge, Flux};
use crate::failure::Failure;
use crate::report::{self, Report, count, number, short};
use crate::session::Session;
use azulejo::models::ModelOutput;
use azulejo_scene::{
    Bevel, BevelEnds, Exact, Material, Object, Prism, Rgb, Scene, Shape, Solid, TextFrame,
};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

impl FrameArgs {
    /// The frame of outlines whose unit is `scale` long, `depth` deep.
    pub fn frame(&self, scale: f64, depth: f64) -> TextFrame {
        let tan = |degrees: f64| degrees.to_radians().tan();
        let [p, u, e] = self.orientation;
        let up = u + tan(self.slant) * p;
        let extrusion = e + tan(self.oblique[0]) * p + tan(self.oblique[1]) * u;
        TextFrame {
            origin: self.at,
            progression: p,
            up: up.normalize(),
            extrusion: extrusion.normalize(),
            scale: [scale, scale * up.length(), depth * extrusion.length()].into(),
        }
    }
}

impl SurfaceArgs {
    /// The material; `color` is the default.
    pub fn material(&self, name: &str, color: Rgb) -> Material {
        let shines = self.mirror.is_some() || self.emission.is_some() || self.flux.is_some();
        let otherwise = if shines { Rgb::BLACK } else { color };
        Material {
            name: name.to_owned(),
            diffuse: self.color.unwrap_or(otherwise),
            mirror: self.mirror.unwrap_or(Rgb::BLACK),
            emission: self.emission.unwrap_or(match self.flux {
                Some(_) => Rgb::WHITE,
                None => Rgb::BLACK,
            }),
            ..Material::default()
        }
    }
}

/// What the flux of letters means for them.
#[derive(Debug)]
pub struct LetterLight {
    /// Of the whole, lm.
    flux: f64,
    /// Luminance, cd/m².
    luminance: f64,
    /// Length of the strokes, m.
    length: f64,
}

impl LetterLight {
    /// Adds a line of words.
    pub fn describe(&self, report: &mut Report) {
        let [flux, luminance, length] = [self.flux, self.luminance, self.length].map(short);
        let words = format!("{flux} lm, {luminance} cd/m² on all sides; {length} m of strokes");
        report.fact("flux", number(self.flux), "light", words);
        report.value("luminance", number(self.luminance));
        report.value("stroke_metres", number(self.length));
    }
}

impl SurfaceArgs {
    /// Gives the materials of a scene of solids their luminance, if they have a flux: Φ = πLA, since all of their
    /// surface is Lambertian.
    pub fn shine(&self, scene: &mut Scene) -> Result<Option<LetterLight>, Failure> {
        let Some(flux) = self.flux else {
            return Ok(None);
        };
        let metres = scene.units.metres();
        let (mut area, mut length) = (0.0, 0.0);
        for object in &scene.objects {
            if let Shape::Exact(exact) = &object.shape {
                let sizes = exact.solids.iter().map(|s| s.bounds().diagonal());
                let error = CHORD_ERROR * sizes.fold(0.0, f64::max);
                area += exact.areas(error).values().sum::<f64>() * metres * metres;
                length += 0.5 * exact.outline_length(error) * metres;
            }
        }
        let flux = match flux {
            Flux::Whole(flux) => flux,
            Flux::PerMetre(flux) => flux * length,
        };
        let luminance = flux / (PI * area);
        for material in &mut scene.materials {
            let color = material.emission;
            if color.luminance() <= 0.0 {
                let message = "--emission: black, expected the colour of the light of --flux";
                return Err(Failure::misuse(message));
            }
            material.emission = color * (luminance / color.luminance());
        }
        scene.units.photometric = true;
        Ok(Some(LetterLight {
            flux,
            luminance,
            length,
        }))
    }
}

impl EdgeArgs {
    /// The bevel of prisms whose outlines have a unit of that length, and that are that deep.
    pub fn bevel(&self, scale: f64, depth: f64) -> Result<Option<Arc<Bevel>>, Failure> {
        let Some(edge) = self.bevel else {
            return Ok(None);
        };
        let Edge {
            profile,
            radius,
            ends,
        } = edge;
        let bevel = Bevel {
            profile,
            inset: radius / scale,
            depth: radius / depth,
            ends,
        };
        if bevel.is_valid() {
            return Ok(Some(Arc::new(bevel)));
        }
        let (room, what) = match ends {
            BevelEnds::Front => (depth, "the depth"),
            BevelEnds::Both => (0.5 * depth, "half the depth, as there is one on both ends"),
        };
        Err(Failure::misuse(format_args!(
            "--bevel: a radius of {radius}, expected at most {room}, {what}"
        )))
    }
}

/// The scene of one object.
pub fn scene(name: &str, materials: Vec<Material>, prisms: Vec<Prism>) -> Result<Scene, Failure> {
    if prisms.is_empty() {
        let message = "nothing to extrude: no outline encloses anything";
        return Err(Failure::failed(message));
    }
    let mut scene = Scene {
        materials,
        ..Scene::default()
    };
    let solids = prisms.into_iter().map(Solid::Prism).collect();
    let shape = Shape::Exact(Exact::new(solids));
    scene.objects.push(Object::new(name, shape));
    if !scene.materials.iter_mut().all(Material::limit_reflectance) {
        let message = "--color and --mirror together exceed 1, which creates energy";
        return Err(Failure::misuse(message));
    }
    // Sizes and positions that are finite may have a product that is not.
    match scene.validate() {
        Ok(()) => Ok(scene),
        Err(e) => Err(Failure::failed(format_args!(
            "sizes or positions are out of range: {e}"
        ))),
    }
}

/// Chord error by which areas and lengths are measured, relative to the size of a solid.
const CHORD_ERROR: f64 = 1e-5;

/// Writes the scene and reports its content.
pub fn write(
    scene: &Scene,
    output: &ModelOutput,
    path: &Path,
    session: &mut Session,
) -> Result<Report, Failure> {
    session.write(scene, output)?;
    let prisms: usize = scene.objects.iter().map(prism_count).sum();
    let bounds = scene.bounds();
    let mut report = Report::default();
    let path = path.display().to_string();
    let words = format!("{path}: {} solids", count(prisms));
    report.fact("output", path, "wrote", words);
    report.value("solids", prisms);
    let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
    let words = format!("{} to {}", report::triple(min), report::triple(max));
    let value = serde_json::json!({ "min": min, "max": max });
    report.fact("bounds", value, "bounds", words);
    Ok(report)
}

fn prism_count(object: &Object) -> usize {
    match &object.shape {
        Shape::Exact(exact) => exact.solids.len(),
        Shape::Mesh(_) | Shape::Instance(_) | Shape::Primitive(_) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    /// The positions of a point of an outline on the front and on the back.
    fn check(args: FrameArgs, front: [f64; 3], back: [f64; 3]) {
        let map = args.frame(2.0, 0.5).world_from_glyph(DVec2::new(1.0, 0.0));
        for (z, expected) in [(0.0, front), (1.0, back)] {
            let position = map.transform_point3(DVec3::new(1.0, 1.0, z));
            assert!(
                position.distance(expected.into()) < 1e-12,
                "{position} {expected:?}"
            );
        }
    }

    #[test]
    fn frames_lean_and_turn() {
        let plain = FrameArgs {
            at: DVec3::new(0.0, 0.0, 7.0),
            orientation: [DVec3::X, DVec3::Y, DVec3::NEG_Z],
            slant: 0.0,
            oblique: [0.0; 2],
        };
        check(plain, [4.0, 2.0, 7.0], [4.0, 2.0, 6.5]);
        let slant = FrameArgs {
            slant: 45.0,
            ..plain
        };
        check(slant, [6.0, 2.0, 7.0], [6.0, 2.0, 6.5]);
        let oblique = FrameArgs {
            oblique: [45.0, -45.0],
            ..plain
        };
        check(oblique, [4.0, 2.0, 7.0], [4.5, 1.5, 6.5]);
    }
}
