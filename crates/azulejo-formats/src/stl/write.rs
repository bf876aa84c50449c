//! Writes scenes as binary STL.

use crate::surface::closed::closed_meshes;
use crate::surface::losses::LossList;
use azulejo_scene::{Rgb, Scene, Units, Up};
use glam::DVec3;
use std::io::{self, BufWriter, Write};

/// [`write_within`] with polygons that deviate from exact shapes by at most a thousandth of a solid's size.
///
/// # Errors
/// As [`write_within`].
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    write_within(scene, None, out)
}

/// Writes all faces as triangles of one solid, with z up, as programs expect.
///
/// Coordinates are in single precision. [`losses`] describes what the format cannot represent. Polygons of exact solids
/// deviate from them by at most `tolerance` scene units, > 0, without it by a thousandth of their size, and are closed
/// where equal positions are merged: each edge has two triangles, of opposite directions. Meshes are as they are.
///
/// # Errors
/// Those of `out`; solids that cannot be closed, with their object; coordinates beyond single precision, and more than
/// 2³² triangles.
pub fn write_within(scene: &Scene, tolerance: Option<f64>, out: &mut dyn Write) -> io::Result<()> {
    let turned = scene.clone().adapted(Units {
        up: Up::Z,
        ..scene.units
    });
    let mut facets: Vec<[DVec3; 3]> = Vec::new();
    let mut triangles = Vec::new();
    for mesh in closed_meshes(&turned, tolerance)? {
        for face in 0..mesh.faces.len() {
            triangles.clear();
            mesh.triangulate_into(face, &mut triangles);
            let ring = mesh.face_positions(face);
            facets.extend(triangles.iter().map(|t| t.map(|k| ring[k as usize])));
        }
    }
    let invalid = |message: &str| io::Error::new(io::ErrorKind::InvalidData, message.to_owned());
    let count =
        u32::try_from(facets.len()).map_err(|_| invalid("STL holds at most 2^32 triangles"))?;
    let most = facets.iter().flatten().map(|p| p.abs().max_element());
    if most.fold(0.0, f64::max) > f64::from(f32::MAX) {
        return Err(invalid("coordinates beyond what numbers of 32 bits hold"));
    }
    let mut out = BufWriter::new(out);
    // Not "solid", by which readers would take it for the text format.
    let mut head = [b' '; 80];
    head[..7].copy_from_slice(b"azulejo");
    out.write_all(&head)?;
    out.write_all(&count.to_le_bytes())?;
    for [a, b, c] in facets {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for v in [normal, a, b, c] {
            for x in v.to_array() {
                out.write_all(&(x as f32).to_le_bytes())?;
            }
        }
        out.write_all(&[0, 0])?;
    }
    out.flush()
}

/// Descriptions of what [`write()`] would omit from a scene, or change.
pub fn losses(scene: &Scene) -> Vec<String> {
    let objects = scene.objects.len();
    LossList::new(scene)
        .materials(|m| m.diffuse != Rgb::grey(0.5), "materials")
        .count(
            if objects > 1 { objects } else { 0 },
            "objects that become one",
        )
        .exact_shapes()
        .polygons(3)
        .corner_attributes()
        .irradiance()
        .single_precision("")
        .once(scene.units.metres_per_unit.is_some(), "the unit")
        .finish()
}
