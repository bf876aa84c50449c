//! Writes scenes as DXF of release 12: polyface meshes, one layer for each object.

use super::color::Paint;
use crate::surface::losses::{LossList, is_more_than_colour};
use crate::surface::tessellate::mesh_of;
use azulejo_scene::{Mesh, Rgb, Scene, Units, Up};
use glam::DVec3;
use std::collections::{HashMap, HashSet};
use std::io::{self, BufWriter, Write};

/// Most vertices of a polyface mesh, which counts them in 16 bits.
const MOST_VERTICES: usize = 32_767;
/// Most characters of a layer's name in release 12.
const MOST_NAME: usize = 31;

/// Writes each object as polyface meshes on a layer of its name, with z up: the oldest form that
/// keeps shared vertices, which every program reads.
///
/// Coordinates read back to the same values. Faces of more than four corners become triangles,
/// colours the nearest of AutoCAD's 255. [`losses`] describes what else the format cannot represent.
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let scene = &scene.clone().adapted(Units {
        up: Up::Z,
        ..scene.units
    });
    let layers = layer_names(scene);
    let colors: Vec<u8> = scene.materials.iter().map(|m| nearest(m.diffuse)).collect();
    let mut out = BufWriter::new(out);
    out.write_all(b"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n")?;
    let count = layers.len();
    write!(
        out,
        "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n{count}\n"
    )?;
    for layer in &layers {
        write!(out, "0\nLAYER\n2\n{layer}\n70\n0\n62\n7\n6\nCONTINUOUS\n")?;
    }
    out.write_all(b"0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n")?;
    for (object, layer) in scene.objects.iter().zip(&layers) {
        let mesh = mesh_of(object);
        for part in parts(&mesh) {
            part.write(&mesh, layer, &colors, &mut out)?;
        }
    }
    out.write_all(b"0\nENDSEC\n0\nEOF\n")?;
    out.flush()
}

/// Descriptions of what [`write()`] would omit from a scene, or change.
pub fn losses(scene: &Scene) -> Vec<String> {
    let odd_color = |c: Rgb| Paint::Index(nearest(c)).reflectance() != c;
    let layers = layer_names(scene);
    let named = scene.objects.iter().zip(&layers);
    let renamed = named.filter(|(o, layer)| o.name != **layer).count();
    LossList::new(scene)
        .materials(|m| odd_color(m.diffuse), "colours, to the nearest of 255")
        .materials(
            is_more_than_colour,
            "materials of which only the colour is kept",
        )
        .count(renamed, "objects whose names change")
        .exact_shapes()
        .polygons(4)
        .corner_attributes()
        .irradiance()
        .once(scene.units.metres_per_unit.is_some(), "the unit")
        .finish()
}

/// Some faces of a mesh whose vertices 16 bits can count.
#[derive(Default)]
struct PolyfacePart {
    vertices: Vec<u32>,
    /// The corners, from 1, with 0 for the fourth of a triangle, and the face in the mesh.
    faces: Vec<([usize; 4], usize)>,
}

fn parts(mesh: &Mesh) -> Vec<PolyfacePart> {
    let mut parts = Vec::new();
    let mut part = PolyfacePart::default();
    let mut known: HashMap<u32, usize> = HashMap::new();
    let mut triangles = Vec::new();
    for face in 0..mesh.faces.len() {
        let corners = mesh.faces.get(face);
        let mut pieces: Vec<Vec<u32>> = Vec::new();
        if corners.len() <= 4 {
            pieces.push(corners.to_vec());
        } else {
            triangles.clear();
            mesh.triangulate_into(face, &mut triangles);
            let piece = |t: &[u32; 3]| t.iter().map(|&k| corners[k as usize]).collect();
            pieces.extend(triangles.iter().map(piece));
        }
        for piece in pieces {
            if part.vertices.len() + piece.len() > MOST_VERTICES
                || part.faces.len() == MOST_VERTICES
            {
                parts.push(std::mem::take(&mut part));
                known.clear();
            }
            let mut ring = [0; 4];
            for (slot, v) in ring.iter_mut().zip(piece) {
                *slot = *known.entry(v).or_insert_with(|| {
                    part.vertices.push(v);
                    part.vertices.len()
                });
            }
            part.faces.push((ring, face));
        }
    }
    if !part.faces.is_empty() {
        parts.push(part);
    }
    parts
}

impl PolyfacePart {
    fn write(
        &self,
        mesh: &Mesh,
        layer: &str,
        colors: &[u8],
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let color = |face: usize| colors[mesh.face_materials[face] as usize];
        let whole = self.faces.first().map_or(7, |(_, face)| color(*face));
        write!(
            out,
            "0\nPOLYLINE\n8\n{layer}\n62\n{whole}\n66\n1\n{}70\n64\n71\n{}\n72\n{}\n",
            Coordinates(DVec3::ZERO),
            self.vertices.len(),
            self.faces.len()
        )?;
        for &v in &self.vertices {
            let place = Coordinates(mesh.positions[v as usize]);
            write!(out, "0\nVERTEX\n8\n{layer}\n{place}70\n192\n")?;
        }
        for ([a, b, c, d], face) in &self.faces {
            let zero = Coordinates(DVec3::ZERO);
            let color = color(*face);
            write!(out, "0\nVERTEX\n8\n{layer}\n62\n{color}\n{zero}70\n128\n")?;
            write!(out, "71\n{a}\n72\n{b}\n73\n{c}\n")?;
            if *d > 0 {
                write!(out, "74\n{d}\n")?;
            }
        }
        write!(out, "0\nSEQEND\n8\n{layer}\n")
    }
}

/// The groups 10, 20 and 30.
struct Coordinates(DVec3);

impl std::fmt::Display for Coordinates {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (code, x) in [(10, self.0.x), (20, self.0.y), (30, self.0.z)] {
            if x == 0.0 || (1e-5..1e16).contains(&x.abs()) {
                writeln!(f, "{code}\n{x:?}")?;
            } else {
                writeln!(f, "{code}\n{x:e}")?;
            }
        }
        Ok(())
    }
}

/// The colour index whose surface is nearest to a reflectance, by displayed colours.
fn nearest(color: Rgb) -> u8 {
    let shown = |c: Rgb| c.map(|x| x.max(0.0).powf(1.0 / 2.2));
    let target = shown(color);
    let distance = |index: u8| {
        let difference = shown(Paint::Index(index).reflectance()) - target;
        difference.to_array().iter().map(|x| x * x).sum::<f64>()
    };
    let by_distance = |a: &u8, b: &u8| distance(*a).total_cmp(&distance(*b));
    (1..=255).min_by(by_distance).unwrap_or(7)
}

/// A valid name for the layer of each object, all different whatever the case.
fn layer_names(scene: &Scene) -> Vec<String> {
    let mut taken = HashSet::new();
    // How far the numbers behind each name have come.
    let mut next: HashMap<String, usize> = HashMap::new();
    let valid = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '$');
    let mut unique = |name: &str| {
        let plain: String = name
            .chars()
            .map(|c| if valid(c) { c } else { '_' })
            .collect();
        let plain = if plain.is_empty() { "object" } else { &*plain };
        let number = next.entry(plain.to_ascii_lowercase()).or_insert(0);
        loop {
            *number += 1;
            let end = match *number {
                1 => String::new(),
                n => format!("_{n}"),
            };
            let room = MOST_NAME - end.len();
            let name = format!("{}{end}", &plain[..plain.len().min(room)]);
            if taken.insert(name.to_ascii_lowercase()) {
                return name;
            }
        }
    };
    scene.objects.iter().map(|o| unique(&o.name)).collect()
}
