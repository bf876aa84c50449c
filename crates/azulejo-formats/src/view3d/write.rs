//! Writes scenes as View3D files.

use crate::surface::mean_plane::MeanPlane;
use crate::surface::tessellate::{self, mesh_of};
use azulejo_scene::{Material, Mesh, Scene};
use glam::DVec3;
use std::io::{self, BufWriter, Write};

/// Corners farther from their plane than this, relative to the radius, are written as triangles.
const FLAT: f64 = 1e-6;

/// Writes a scene as an F 3 file: a one-sided surface for each face, with its object's name.
///
/// The emissivity is the absorptance of the material, 1 − ρ_d − ρ_s, averaged over the channels.
/// Faces that are not flat and convex, or have more than four corners, are written as triangles
/// that View3D combines; exact shapes become polygons, faces without area are omitted. Coordinates
/// read back to the same values. [`losses`] describes what the format cannot represent.
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let surfaces = surfaces(scene);
    writeln!(out, "T {} surfaces, written by azulejo", surfaces.firsts)?;
    writeln!(out, "F 3")?;
    for (k, p) in surfaces.vertices.iter().enumerate() {
        let p = *p + DVec3::ZERO;
        writeln!(out, "V {} {} {} {}", k + 1, p.x, p.y, p.z)?;
    }
    for (k, surface) in surfaces.list.iter().enumerate() {
        let WrittenSurface {
            corners: [a, b, c, d],
            combined,
            emissivity,
            name,
        } = surface;
        let n = k + 1;
        writeln!(
            out,
            "S {n} {a} {b} {c} {d} 0 {combined} {emissivity} {name}"
        )?;
    }
    writeln!(out, "End of data")?;
    out.flush()
}

/// Descriptions of what [`write()`] would omit from a scene, or change.
pub fn losses(scene: &Scene) -> Vec<String> {
    let materials =
        |lost: fn(&Material) -> bool| scene.materials.iter().filter(|m| lost(m)).count();
    let [primitives, solids] = tessellate::exact_counts(scene);
    let written = surfaces(scene);
    let counts = [
        (scene.lights.len(), "lights without area"),
        (scene.cameras.len(), "cameras"),
        (primitives + solids, "exact shapes that become polygons"),
        (
            materials(Material::is_emitter),
            "emitting materials, of which only the emissivity is kept",
        ),
        (
            materials(Material::is_specular),
            "mirrors and transparent materials, which become diffuse",
        ),
        (
            materials(|m| m.opacity.is_some()),
            "materials with an opacity, which become opaque",
        ),
        (written.degenerate, "faces without area"),
        (
            written.divided,
            "faces that become several surfaces, combined",
        ),
    ];
    let present = counts.into_iter().filter(|(n, _)| *n > 0);
    present.map(|(n, what)| format!("{n} {what}")).collect()
}

/// A surface as it is written.
struct WrittenSurface {
    /// Vertices from 1; the last is 0 in a triangle.
    corners: [u32; 4],
    /// The surface that it is combined with, from 1, or 0.
    combined: usize,
    emissivity: f64,
    name: String,
}

#[derive(Default)]
struct WrittenSurfaces {
    vertices: Vec<DVec3>,
    list: Vec<WrittenSurface>,
    /// The number of surfaces that are not parts of others.
    firsts: usize,
    degenerate: usize,
    divided: usize,
}

/// All surfaces: the first parts of all faces, then the others, because additional parts at the end
/// do not change View3D's row numbers.
fn surfaces(scene: &Scene) -> WrittenSurfaces {
    let mut surfaces = WrittenSurfaces::default();
    let mut parts = Vec::new();
    for object in &scene.objects {
        let mesh = mesh_of(object);
        let first = surfaces.vertices.len() as u32 + 1;
        surfaces.vertices.extend(&mesh.positions);
        let name = word(&object.name);
        for face in 0..mesh.faces.len() {
            let mut pieces = pieces(&mesh, face).into_iter();
            let material = &scene.materials[mesh.face_materials[face] as usize];
            let surface = |piece: Vec<u32>, combined| {
                let corner = |k: usize| piece.get(k).map_or(0, |v| first + v);
                WrittenSurface {
                    corners: [0, 1, 2, 3].map(corner),
                    combined,
                    emissivity: emissivity(material),
                    name: name.clone(),
                }
            };
            let Some(piece) = pieces.next() else {
                surfaces.degenerate += 1;
                continue;
            };
            surfaces.list.push(surface(piece, 0));
            let root = surfaces.list.len();
            let known = parts.len();
            parts.extend(pieces.map(|piece| surface(piece, root)));
            surfaces.divided += usize::from(parts.len() > known);
        }
    }
    surfaces.firsts = surfaces.list.len();
    surfaces.list.extend(parts);
    surfaces
}

/// A face as triangles and quadrilaterals that have an area and are flat and convex.
fn pieces(mesh: &Mesh, face: usize) -> Vec<Vec<u32>> {
    let corners = mesh.faces.get(face);
    let at = |v: &[u32]| -> Vec<DVec3> { v.iter().map(|&v| mesh.positions[v as usize]).collect() };
    let has_area = |v: &[u32]| {
        let plane = MeanPlane::of(&at(v));
        plane.area > 1e-10 * plane.radius * plane.radius
    };
    if corners.len() <= 4 && has_area(corners) && MeanPlane::is_flat_and_convex(&at(corners), FLAT)
    {
        return vec![corners.to_vec()];
    }
    let triangles = mesh.triangulate(face).into_iter();
    let triangles = triangles.map(|t| t.map(|k| corners[k as usize]).to_vec());
    triangles.filter(|t| has_area(t)).collect()
}

/// The absorptance and emissivity of a grey surface, within View3D's limits.
fn emissivity(material: &Material) -> f64 {
    let reflected = (0..3).map(|k| material.diffuse[k] + material.mirror[k]);
    let emissivity: f64 = 1.0 - reflected.sum::<f64>() / 3.0;
    // More digits have no physical meaning, and the files should be readable.
    (emissivity.clamp(0.001, 0.999) * 1e6).round() / 1e6
}

/// A name as one word of the 15 characters that View3D keeps.
fn word(name: &str) -> String {
    let fits = |c: char| {
        if c.is_ascii_graphic() && c != ',' && c != '!' {
            c
        } else {
            '_'
        }
    };
    // The end of a path is more specific than its beginning.
    let last = name
        .rsplit('/')
        .find(|part| !part.is_empty())
        .unwrap_or("surface");
    last.chars().take(15).map(fits).collect()
}
