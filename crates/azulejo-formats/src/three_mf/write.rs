//! Writes scenes as 3MF.

use super::UNITS;
use crate::picture::srgb::srgb_from_linear;
use crate::surface::closed::closed_meshes;
use crate::surface::losses::{LossList, is_more_than_colour};
use crate::surface::tessellate::mesh_of;
use azulejo_scene::{Material, MaterialId, Mesh, Rgb, Scene, Units, Up};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::io::{self, BufWriter, Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const CONTENT_TYPES: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\
    <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
    <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\
    </Types>\n";

const RELATIONSHIPS: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
    <Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" \
    Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>\n";

/// Id of the list of materials; objects follow.
const MATERIALS: usize = 1;

/// [`write_within`] with polygons that deviate from exact shapes by at most a thousandth of a solid's size.
///
/// # Errors
/// As [`write_within`].
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    write_within(scene, None, out)
}

/// Writes each object as a mesh of triangles with a material for each, all in one build, with z up.
///
/// Coordinates of meshes read back to the same values; if the format does not have the unit of the scene, they are
/// converted to metres. Objects that enclose a volume are models, all others surfaces.
/// Polygons of exact solids deviate from them by at most `tolerance` scene units, > 0, without it by a thousandth of
/// their size, and are closed also where equal positions are merged: each edge has two triangles, of opposite directions.
/// [`losses`] describes what the format cannot represent.
///
/// # Errors
/// Those of `out`; solids that cannot be closed, with their object; packages of 4 GiB and more.
pub fn write_within(scene: &Scene, tolerance: Option<f64>, out: &mut dyn Write) -> io::Result<()> {
    let (unit, metres) = unit(scene);
    let tolerance = tolerance.map(|t| t * scene.units.metres_per_unit.unwrap_or(metres) / metres);
    let scene = scene.clone().adapted(Units {
        up: Up::Z,
        metres_per_unit: scene.units.metres_per_unit.map(|_| metres),
        ..scene.units
    });
    let meshes = closed_meshes(&scene, tolerance)?;
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    // In memory, because the size of a part precedes it.
    let mut package = ZipWriter::new(Cursor::new(Vec::new()));
    package.start_file("[Content_Types].xml", options)?;
    package.write_all(CONTENT_TYPES.as_bytes())?;
    package.start_file("_rels/.rels", options)?;
    package.write_all(RELATIONSHIPS.as_bytes())?;
    package.start_file("3D/3dmodel.model", options)?;
    let mut part = BufWriter::new(&mut package);
    model(&scene, &meshes, unit, &mut part)?;
    part.flush()?;
    drop(part);
    out.write_all(package.finish()?.get_ref())?;
    out.flush()
}

/// The unit of the file and its length in metres: that of the scene, or millimetres where none is known, as slicers
/// take STL and OBJ.
fn unit(scene: &Scene) -> (&'static str, f64) {
    let metres = scene.units.metres_per_unit.unwrap_or(1e-3);
    let same = |u: &&(&str, f64)| (u.1 / metres - 1.0).abs() < 1e-9;
    *UNITS.iter().find(same).unwrap_or(&UNITS[5])
}

/// Descriptions of what [`write()`] would omit from a scene, or change.
pub fn losses(scene: &Scene) -> Vec<String> {
    let known = scene.units.metres_per_unit;
    let is_odd = known.is_some_and(|metres| (unit(scene).1 / metres - 1.0).abs() > 1e-9);
    let empty = scene
        .objects
        .iter()
        .filter(|o| triangles(&mesh_of(o)).is_empty());
    LossList::new(scene)
        .count(usize::from(scene.background.is_some()), "background")
        .count(usize::from(scene.fog.is_some()), "fog")
        .materials(
            is_more_than_colour,
            "materials of which only the colour is kept",
        )
        .materials(
            |m| m.opacity.is_some(),
            "materials with an opacity, which become opaque",
        )
        .count(empty.count(), "objects without area")
        .exact_shapes()
        .polygons(3)
        .corner_attributes()
        .irradiance()
        .single_precision(", in programs that read them")
        .once(is_odd, "the unit, converted to metres")
        .once(known.is_none(), "an unknown unit, written as millimetres")
        .finish()
}

fn model(scene: &Scene, meshes: &[Cow<Mesh>], unit: &str, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"{unit}\" xml:lang=\"en-US\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n\
         <metadata name=\"Application\">azulejo</metadata>\n<resources>"
    )?;
    if !scene.materials.is_empty() {
        materials(&scene.materials, out)?;
    }
    let mut items = Vec::new();
    for (object, mesh) in scene.objects.iter().zip(meshes) {
        let id = MATERIALS + 1 + items.len();
        if mesh_object(&object.name, mesh, id, out)? {
            items.push(id);
        }
    }
    writeln!(out, "</resources>\n<build>")?;
    for id in items {
        writeln!(out, "<item objectid=\"{id}\"/>")?;
    }
    writeln!(out, "</build>\n</model>")
}

fn materials(materials: &[Material], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<basematerials id=\"{MATERIALS}\">")?;
    for (k, material) in materials.iter().enumerate() {
        let number = format!("material {k}");
        let name = if material.name.is_empty() {
            &number
        } else {
            &material.name
        };
        let (name, color) = (XmlText(name), DisplayColor(material.diffuse));
        writeln!(out, "<base name=\"{name}\" displaycolor=\"{color}\"/>")?;
    }
    writeln!(out, "</basematerials>")
}

/// The triangles of a mesh with the material of each; those that use a vertex twice, which
/// 3MF forbids, are left out.
fn triangles(mesh: &Mesh) -> Vec<([u32; 3], MaterialId)> {
    let mut triangles = Vec::new();
    let mut pieces = Vec::new();
    for face in 0..mesh.faces.len() {
        pieces.clear();
        mesh.triangulate_into(face, &mut pieces);
        let corners = mesh.faces.get(face);
        for [a, b, c] in pieces.iter().map(|t| t.map(|k| corners[k as usize])) {
            if a != b && b != c && c != a {
                triangles.push(([a, b, c], mesh.face_materials[face]));
            }
        }
    }
    triangles
}

/// Writes an object; `false` if nothing of it is left.
fn mesh_object(name: &str, mesh: &Mesh, id: usize, out: &mut dyn Write) -> io::Result<bool> {
    let triangles = triangles(mesh);
    let Some(&(_, usual)) = triangles.first() else {
        return Ok(false);
    };
    // Vertices that no triangle uses are left out.
    let mut places: HashMap<u32, usize> = HashMap::new();
    let mut used = Vec::new();
    for v in triangles.iter().flat_map(|t| t.0) {
        places.entry(v).or_insert_with(|| {
            used.push(v);
            used.len() - 1
        });
    }
    let kind = if mesh.is_closed() { "model" } else { "surface" };
    let name = XmlText(name);
    writeln!(
        out,
        "<object id=\"{id}\" type=\"{kind}\" name=\"{name}\" pid=\"{MATERIALS}\" \
         pindex=\"{usual}\">\n<mesh>\n<vertices>"
    )?;
    for v in used {
        let [x, y, z] = mesh.positions[v as usize].to_array();
        writeln!(out, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for (triangle, material) in triangles {
        let [a, b, c] = triangle.map(|v| places[&v]);
        write!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"")?;
        if material != usual {
            write!(out, " pid=\"{MATERIALS}\" p1=\"{material}\"")?;
        }
        writeln!(out, "/>")?;
    }
    writeln!(out, "</triangles>\n</mesh>\n</object>")?;
    Ok(true)
}

/// A colour as sRGB in hexadecimal digits.
struct DisplayColor(Rgb);

impl fmt::Display for DisplayColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let byte = |c: f64| {
            (255.0 * srgb_from_linear(c as f32))
                .round()
                .clamp(0.0, 255.0) as u8
        };
        let [r, g, b] = self.0.to_array().map(byte);
        write!(f, "#{r:02X}{g:02X}{b:02X}")
    }
}

/// Text in an attribute; characters that XML cannot have become question marks.
struct XmlText<'a>(&'a str);

impl fmt::Display for XmlText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\t' | '\n' | '\r' => write!(f, "&#{};", c as u32)?,
                '\0'..=' ' if c != ' ' => f.write_str("?")?,
                '\u{fffe}' | '\u{ffff}' => f.write_str("?")?,
                c => write!(f, "{c}")?,
            }
        }
        Ok(())
    }
}
