//! The sections of a file in their order.

use super::SffResult;
use super::document::*;
use super::lines::SffLines;
use super::{data, record};
use azulejo_scene::Rgb;
use azulejo_scene::rtrace::{RtraceLight, RtraceLightKind, RtraceSource};
use glam::DVec3;

impl SffDocument {
    /// Parses a whole file.
    ///
    /// # Errors
    /// The first malformed record.
    pub fn parse(lines: &mut SffLines) -> SffResult<SffDocument> {
        let title = lines.title();
        let view = view(lines)?;
        lines.title();
        let mut document = SffDocument {
            is_translated: title.starts_with("+L"),
            view,
            background: colors(lines)?,
            ambient: colors(lines)?,
            ..SffDocument::default()
        };
        lines.title();
        while !lines.section_ends() {
            document.lights.push(light(lines)?);
            lines.end_record();
        }
        lines.title();
        while !lines.section_ends() {
            document.surfaces.push(surface(lines)?);
            lines.end_record();
        }
        lines.title();
        while !lines.section_ends() {
            let place = lines.place();
            let kind = record::read(lines)?;
            document.objects.push(SffRecord { place, kind });
        }
        document.textures = textures(lines);
        Ok(document)
    }
}

fn view(lines: &mut SffLines) -> SffResult<SffView> {
    let place = lines.place();
    let mut point = || {
        let p = lines.point();
        lines.end_record();
        p
    };
    let (eye, target, up) = (point()?, point()?, point()?);
    let mut angle = || lines.within(0.5, 89.5, "angle of view");
    let angles = [angle()?, angle()?];
    lines.end_record();
    Ok(SffView {
        eye,
        target,
        up,
        angles,
        place,
    })
}

fn colors(lines: &mut SffLines) -> SffResult<Rgb> {
    let color = lines.color("background or ambient colour")?;
    lines.end_record();
    Ok(color)
}

fn light(lines: &mut SffLines) -> SffResult<RtraceLight> {
    let place = lines.place();
    let kind = lines.index()?;
    let position = lines.point()?;
    let signed = lines.point()?;
    let kind = match kind {
        1 => RtraceLightKind::Point,
        2 => RtraceLightKind::Spot {
            direction: lines.direction()?,
            half_angle: (lines.within(0.0, 180.0, "angle of a spotlight")?).to_radians(),
            factor: lines.within(1.0, 300.0, "factor of a spotlight")?,
        },
        3 => RtraceLightKind::Extended {
            radius: lines.positive("radius of a light")?,
            samples: samples(lines, 1.0)?,
        },
        4 => RtraceLightKind::Planar {
            edges: [lines.point()?, lines.point()?],
            samples: [samples(lines, 1.0)?, samples(lines, 0.0)?],
        },
        other => {
            let expected = "1 (point), 2 (spot), 3 (extended) or 4 (planar)";
            return Err(lines.error(place, format!("a light of type {other}"), expected));
        }
    };
    Ok(RtraceLight {
        position,
        brightness: Rgb::from(signed.abs().to_array()),
        fades: signed.to_array().map(|b| b >= 0.0),
        kind,
    })
}

fn samples(lines: &mut SffLines, least: f64) -> SffResult<u32> {
    Ok(lines
        .within(least, 256.0, "number of samples of a light")?
        .round() as u32)
}

fn surface(lines: &mut SffLines) -> SffResult<SurfaceRecord> {
    let place = lines.place();
    let kind = lines.index()?;
    let mut flagged = || lines.within(-1.0, 1.0, "parameter of a surface");
    let (red, green) = (flagged()?, flagged()?);
    let color = Rgb::new(red.abs(), green.abs(), unit(lines)?);
    let source = match kind {
        1 => RtraceSource::Phong {
            diffuse: triple(lines)?,
            specular: triple(lines)?,
            phong: lines.within(0.0, 300.0, "exponent of a highlight")?,
            metal: unit(lines)?,
            transparency: triple(lines)?,
        },
        2 => RtraceSource::Strauss {
            smooth: triple(lines)?,
            metal: triple(lines)?,
            transparency: triple(lines)?,
        },
        other => {
            let found = format!("a surface of type {other}");
            return Err(lines.error(place, found, "1 or 2"));
        }
    };
    Ok(SurfaceRecord {
        color,
        is_emitter: red < 0.0,
        is_unshadowed: green < 0.0,
        source,
    })
}

fn unit(lines: &mut SffLines) -> SffResult<f64> {
    lines.within(0.0, 1.0, "parameter of a surface")
}

fn triple(lines: &mut SffLines) -> SffResult<Rgb> {
    lines.color("parameter of a surface")
}

/// Reads the last section. Anything may follow the objects, so a record that is not a texture ends
/// it.
fn textures(lines: &mut SffLines) -> Vec<SffRecord> {
    let mut textures = Vec::new();
    lines.title();
    while lines.numbers_left_on_line() >= 2 {
        let place = lines.place();
        match record::texture(lines) {
            Ok(texture) => {
                let kind = RecordKind::Texture(Box::new(texture));
                textures.push(SffRecord { place, kind });
            }
            Err(e) => {
                let (found, expected) = (e.found, e.expected);
                let message = format!(
                    "after the objects: {found} instead of a texture with {expected}; the rest is ignored"
                );
                lines.warn(place, message);
                break;
            }
        }
    }
    textures
}

/// Reads the transform and the data of a shape, if these are in the file itself.
pub(super) fn placed<T>(
    lines: &mut SffLines,
    read: impl FnOnce(&mut SffLines) -> SffResult<T>,
) -> SffResult<Box<PlacedData<T>>> {
    let origin = lines.point()?;
    let mut scale = || lines.within(0.0, f64::MAX, "scale of a shape");
    let scale = DVec3::new(scale()?, scale()?, scale()?);
    let data = data::here_or_file(lines, read)?;
    Ok(Box::new(PlacedData {
        origin,
        scale,
        data,
    }))
}
