//! Records of the objects' section.

use super::SffResult;
use super::document::*;
use super::lines::SffLines;
use super::parse::placed;
use super::{block, data};
use azulejo_scene::Operation;

/// The description of valid record types.
const EXPECTED: &str =
    "an object: 1 to 7, 64 (texture), 65 (transform), 66 (set operation) or 67 (list)";

/// Reads a record up to the end of its line, and the data below it.
pub(super) fn read(lines: &mut SffLines) -> SffResult<RecordKind> {
    let place = lines.place();
    let kind = match lines.index()? {
        number @ 1..=7 => return object(lines, number),
        64 => {
            let texture = texture(lines)?;
            return Ok(RecordKind::Texture(Box::new(texture)));
        }
        65 => RecordKind::Transform {
            object: lines.index()?,
            matrix: Box::new(lines.matrix()?),
        },
        66 => csg(lines)?,
        67 => list(lines)?,
        other => {
            let found = format!("a record of type {other}");
            return Err(lines.error(place, found, EXPECTED));
        }
    };
    lines.end_record();
    Ok(kind)
}

fn appearance(lines: &mut SffLines) -> SffResult<RecordAppearance> {
    Ok(RecordAppearance {
        surface: lines.index()?,
        refraction: lines.number()?,
    })
}

fn object(lines: &mut SffLines, number: u32) -> SffResult<RecordKind> {
    let place = lines.place();
    let mut appearance = appearance(lines)?;
    if appearance.refraction < 1.0 {
        lines.warn(place, "index of refraction below 1: taken as 1".into());
        appearance.refraction = 1.0;
    }
    let geometry = match number {
        1 => SffGeometry::Sphere {
            centre: lines.point()?,
            radius: lines.positive("radius")?,
        },
        2 => SffGeometry::Cuboid {
            centre: lines.point()?,
            half: glam::DVec3::new(
                lines.positive("half size")?,
                lines.positive("half size")?,
                lines.positive("half size")?,
            ),
        },
        3 => SffGeometry::Patches(placed(lines, data::patches)?),
        4 => SffGeometry::Cone(cone(lines)?),
        5 => SffGeometry::Polygons(placed(lines, data::polygons)?),
        6 => {
            let general = appearance.surface == 0;
            SffGeometry::Triangles(placed(lines, |lines| data::triangles(lines, general))?)
        }
        _ => SffGeometry::Text(data::here_or_file(lines, block::read)?),
    };
    if matches!(number, 1 | 2 | 4) {
        lines.end_record();
    }
    Ok(RecordKind::Object {
        appearance,
        geometry,
    })
}

fn cone(lines: &mut SffLines) -> SffResult<SffCone> {
    let place = lines.place();
    let cone = SffCone {
        base: lines.point()?,
        base_radius: lines.within(0.0, f64::MAX, "radius of a cone")?,
        apex: lines.point()?,
        apex_radius: lines.within(0.0, f64::MAX, "radius of a cone")?,
    };
    if cone.base_radius.max(cone.apex_radius) == 0.0 || cone.base == cone.apex {
        let found = "a cone without height or radius";
        let expected = "two different points, and a positive radius";
        return Err(lines.error(place, found, expected));
    }
    Ok(cone)
}

fn csg(lines: &mut SffLines) -> SffResult<RecordKind> {
    let place = lines.place();
    match lines.index()? {
        0 => {
            let appearance = appearance(lines)?;
            let place = lines.place();
            let operation = match lines.index()? {
                0 => Operation::Union,
                1 => Operation::Difference,
                2 => Operation::Intersection,
                other => {
                    let found = format!("set operation {other}");
                    let expected = "0 (union), 1 (subtraction) or 2 (intersection)";
                    return Err(lines.error(place, found, expected));
                }
            };
            Ok(RecordKind::CsgBegin {
                appearance,
                operation,
            })
        }
        1 => Ok(RecordKind::CsgNext),
        2 => Ok(RecordKind::CsgEnd),
        other => {
            let expected = "66 0 (begin), 66 1 (the right side) or 66 2 (end)";
            Err(lines.error(place, format!("66 {other}"), expected))
        }
    }
}

fn list(lines: &mut SffLines) -> SffResult<RecordKind> {
    let place = lines.place();
    match lines.index()? {
        0 => Ok(RecordKind::ListBegin {
            appearance: appearance(lines)?,
        }),
        1 => Ok(RecordKind::ListEnd),
        other => {
            let expected = "67 0 (begin) or 67 1 (end)";
            Err(lines.error(place, format!("67 {other}"), expected))
        }
    }
}

/// The data after the matrix of each texture type: how many numbers, and whether a file name.
const TEXTURES: [(usize, bool); 21] = [
    (0, false),
    (1, false),
    (2, false),
    (1, false),
    (0, true),
    (6, true),
    (5, false),
    (3, false),
    (1, false),
    (1, true),
    (3, false),
    (3, false),
    (0, true),
    (1, false),
    (0, true),
    (1, false),
    (0, true),
    (4, true),
    (4, true),
    (1, false),
    (2, false),
];

/// Whether a texture type may name a colour map or image.
pub(super) fn has_file(number: u32) -> bool {
    TEXTURES.get(number as usize).is_some_and(|t| t.1)
}

/// Reads a texture after its 64, which the last section omits, and the end of its line.
pub(super) fn texture(lines: &mut SffLines) -> SffResult<TextureRecord> {
    let place = lines.place();
    let number = lines.index()?;
    let Some(&(count, has_file)) = TEXTURES.get(number as usize) else {
        let found = format!("a texture of type {number}");
        return Err(lines.error(place, found, "a type of 0 to 20"));
    };
    let object = lines.index()?;
    let matrix = lines.matrix()?;
    let mut values = Vec::new();
    match number {
        6 => fbm_bump(lines, &mut values)?,
        7 => wood(lines, &mut values)?,
        _ => {
            for _ in 0..count {
                values.push(lines.number()?);
            }
        }
    }
    // A missing name is the dash of a comment, which the original takes as the name.
    let file = (has_file.then(|| lines.word_on_line()).flatten()).filter(|w| *w != b"-");
    let file = file.map(|w| crate::reading::text::text(w).into_owned());
    lines.end_record();
    Ok(TextureRecord {
        place,
        object,
        matrix,
        kind: TextureKind { number, values },
        file: file.unwrap_or_default(),
    })
}

/// The manuals list four numbers, the program reads five: the third of them is omega.
fn fbm_bump(lines: &mut SffLines, values: &mut Vec<f64>) -> SffResult<()> {
    let has_omega = lines.rest_is_blank() || lines.numbers_left_on_line() != 4;
    for k in 0..5 {
        let value = if k == 2 && !has_omega {
            0.5
        } else {
            lines.number()?
        };
        values.push(value);
    }
    Ok(())
}

/// Three numbers, or −1 for the default colour.
fn wood(lines: &mut SffLines, values: &mut Vec<f64>) -> SffResult<()> {
    let red = lines.number()?;
    if red < 0.0 {
        values.extend([0.5, 0.5, 0.35]);
    } else {
        values.extend([red, lines.number()?, lines.number()?]);
    }
    Ok(())
}
