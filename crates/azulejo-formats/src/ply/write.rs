//! Writes scenes as PLY, binary little-endian.

use super::assemble::DEFAULT_REFLECTANCE;
use crate::surface::losses::LossList;
use crate::surface::single::CoordinateReach;
use crate::surface::tessellate::{exact_counts, lit_mesh_of};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Attribute, Mesh, Rgb, Scene, Up};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};

/// Writes a scene: all objects in one list of vertices and one of faces, with the irradiance if any
/// object is solved.
///
/// Positions, texture coordinates and colours read back to the same values, normals and irradiance
/// are in single precision. Colours are bytes, as other programs expect; where bytes are not exact, the
/// numbers stand beside them. Exact primitives become polygons. Vertices whose corners have several
/// normals or texture coordinates are written once for each, sheets with light on both sides twice
/// ([`Scene::split_sides`]). [`losses`] describes what else the
/// format cannot represent.
///
/// # Errors
/// Those of `out`, and more than 2³² vertices.
pub fn write(scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
    let scene = &*scene.split_sides();
    let parts: Vec<PlyPart<'_>> = scene
        .objects
        .iter()
        .map(|o| PlyPart::new(lit_mesh_of(o)))
        .collect();
    let count: usize = parts.iter().map(|p| p.vertices.len()).sum();
    if u32::try_from(count).is_err() {
        let message = "PLY supports at most 2^32 vertices";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let layout = PlyLayout::new(scene, &parts);
    let mut out = BufWriter::new(out);
    layout.header(scene, &parts, &mut out)?;
    for (object, part) in parts.iter().enumerate() {
        layout.vertices(object as u32, part, &mut out)?;
    }
    let mut first = 0;
    for part in &parts {
        layout.faces(scene, part, first, &mut out)?;
        first += part.vertices.len() as u32;
    }
    out.flush()
}

/// Descriptions of what [`write()`] would omit from a scene, or change: "2 cameras".
pub fn losses(scene: &Scene) -> Vec<String> {
    let [primitives, solids] = exact_counts(scene);
    LossList::new(scene)
        .count(usize::from(scene.background.is_some()), "background")
        .count(usize::from(scene.fog.is_some()), "fog")
        .count(primitives, "exact primitives that become polygons")
        .count(solids, "exact shapes that become polygons")
        .materials(
            |m| m.is_specular() || m.is_emitter() || m.brdf.is_some() || m.opacity.is_some(),
            "materials of which only the diffuse reflectance is kept",
        )
        .materials(
            |m| m.textures.len() > 1,
            "materials of which only the first texture is kept",
        )
        .meshes(
            |m| m.back.is_some(),
            "meshes whose sheets are written twice, once with the light of each side",
        )
        .meshes(
            |m| m.mesh.is_grouped() && m.mesh.normals.is_none(),
            "meshes whose smoothing groups are omitted",
        )
        .meshes(
            |m| is_by_corner(&m.mesh.normals) || is_by_corner(&m.mesh.uvs),
            "meshes whose vertices are split where normals or texture coordinates differ",
        )
        .finish()
}

fn is_by_corner<T>(attribute: &Option<Attribute<T>>) -> bool {
    attribute.as_ref().is_some_and(|a| a.corners.is_some())
}

/// An object whose vertices are split so that each has one normal and one texture coordinate.
struct PlyPart<'a> {
    mesh: Cow<'a, Mesh>,
    vertices: Vec<PlyVertex>,
    /// Index into `vertices` of each corner.
    corners: Vec<u32>,
}

/// A vertex and the indices of its corner attributes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct PlyVertex {
    vertex: u32,
    normal: u32,
    uv: u32,
}

impl<'a> PlyPart<'a> {
    /// Vertices keep their order; copies for further corner values follow.
    fn new(mesh: Cow<'a, Mesh>) -> PlyPart<'a> {
        let plain = |vertex| PlyVertex {
            vertex,
            normal: vertex,
            uv: vertex,
        };
        let mut vertices: Vec<PlyVertex> = (0..mesh.positions.len() as u32).map(plain).collect();
        if !is_by_corner(&mesh.normals) && !is_by_corner(&mesh.uvs) {
            let corners = mesh.faces.corners.clone();
            return PlyPart {
                mesh,
                vertices,
                corners,
            };
        }
        let mut is_taken = vec![false; vertices.len()];
        let mut others = HashMap::new();
        let own = std::iter::zip(0.., &mesh.faces.corners).map(|(corner, &vertex)| {
            let combined = PlyVertex {
                vertex,
                normal: index(mesh.normals.as_ref(), corner, vertex),
                uv: index(mesh.uvs.as_ref(), corner, vertex),
            };
            let at = vertex as usize;
            if !is_taken[at] {
                is_taken[at] = true;
                vertices[at] = combined;
            }
            if vertices[at] == combined {
                return vertex;
            }
            *others.entry(combined).or_insert_with(|| {
                vertices.push(combined);
                (vertices.len() - 1) as u32
            })
        });
        let corners = own.collect();
        // Vertices without faces have no corner that selects a value; where nothing has a face, the
        // lists are empty, and there is no value at all.
        for (vertex, taken) in std::iter::zip(&mut vertices, is_taken) {
            if !taken {
                (vertex.normal, vertex.uv) = (0, 0);
            }
        }
        PlyPart {
            mesh,
            vertices,
            corners,
        }
    }

    /// Zero, which PLY's readers take for missing, where the mesh has none.
    fn normal(&self, vertex: PlyVertex) -> DVec3 {
        let normals = self.mesh.normals.as_ref();
        let value = normals.and_then(|n| n.values.get(vertex.normal as usize));
        value.copied().unwrap_or_default()
    }

    /// The colour of the faces around each vertex, if these agree at all of them.
    fn face_colors(&self, scene: &Scene) -> Option<Vec<Rgb>> {
        let mut colors = vec![None; self.vertices.len()];
        for (face, &material) in self.mesh.face_materials.iter().enumerate() {
            let color = scene.materials[material as usize].diffuse;
            for &corner in &self.corners[self.mesh.faces.corner_range(face)] {
                if *colors[corner as usize].get_or_insert(color) != color {
                    return None;
                }
            }
        }
        let known = colors.into_iter().map(|c| c.unwrap_or(Rgb::WHITE));
        Some(known.collect())
    }

    fn uv(&self, vertex: PlyVertex) -> DVec2 {
        let uvs = self.mesh.uvs.as_ref();
        let value = uvs.and_then(|uv| uv.values.get(vertex.uv as usize));
        value.copied().unwrap_or_default()
    }
}

/// The index of a corner's value in an attribute.
fn index<T>(attribute: Option<&Attribute<T>>, corner: usize, vertex: u32) -> u32 {
    let corners = attribute.and_then(|a| a.corners.as_ref());
    corners.map_or(vertex, |index| index[corner])
}

/// The scalar types that are written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ScalarFormat {
    Byte,
    Float,
    Double,
}

impl ScalarFormat {
    fn name(self) -> &'static str {
        match self {
            ScalarFormat::Byte => "uchar",
            ScalarFormat::Float => "float",
            ScalarFormat::Double => "double",
        }
    }

    /// Single precision if that is exact for all, and the model not far from the origin: there it would look
    /// as if digits had been lost.
    fn for_positions(positions: impl Iterator<Item = DVec3> + Clone) -> ScalarFormat {
        let bounds = Aabb::around(positions.clone());
        if CoordinateReach::of(bounds).is_some_and(|extent| extent.is_far()) {
            return ScalarFormat::Double;
        }
        ScalarFormat::for_coordinates(positions.flat_map(|p| p.to_array()))
    }

    /// Single precision if that is exact for all.
    fn for_coordinates(mut values: impl Iterator<Item = f64>) -> ScalarFormat {
        if values.all(|x| f64::from(x as f32) == x) {
            ScalarFormat::Float
        } else {
            ScalarFormat::Double
        }
    }

    /// What shares need beside bytes; `None` if bytes are exact for all.
    fn beside_bytes<'c>(colors: impl Iterator<Item = &'c Rgb> + Clone) -> Option<ScalarFormat> {
        let values = colors.flat_map(|c| c.to_array());
        let is_byte = |x: f64| (255.0 * x).round() / 255.0 == x && (0.0..=1.0).contains(&x);
        (!values.clone().all(is_byte)).then(|| ScalarFormat::for_coordinates(values))
    }

    fn write(self, values: &[f64], out: &mut dyn Write) -> io::Result<()> {
        for &value in values {
            match self {
                ScalarFormat::Byte => out.write_all(&[(255.0 * value).round() as u8]),
                // Irradiance beyond the range of single precision is clamped to it.
                ScalarFormat::Float => {
                    out.write_all(&(value.min(f64::from(f32::MAX)) as f32).to_le_bytes())
                }
                ScalarFormat::Double => out.write_all(&value.to_le_bytes()),
            }?;
        }
        Ok(())
    }
}

/// The properties that are written, and their types.
struct PlyLayout {
    positions: ScalarFormat,
    normals: Option<ScalarFormat>,
    uvs: Option<ScalarFormat>,
    /// Whether vertices have colours, in bytes.
    has_colors: bool,
    /// The same as numbers.
    colors: Option<ScalarFormat>,
    /// The colours of faces by vertex, of each part, if the vertices carry them.
    carried: Option<Vec<Vec<Rgb>>>,
    irradiance: Option<ScalarFormat>,
    errors: Option<ScalarFormat>,
    has_objects: bool,
    /// Whether the number of corners takes four bytes.
    wide_counts: bool,
    /// Whether faces have colours in bytes.
    has_face_colors: bool,
    face_colors: Option<ScalarFormat>,
    has_textures: bool,
}

impl PlyLayout {
    fn new(scene: &Scene, parts: &[PlyPart<'_>]) -> PlyLayout {
        let meshes = || parts.iter().map(|p| &*p.mesh);
        let positions = meshes().flat_map(|m| &m.positions);
        let uvs = meshes()
            .filter_map(|m| m.uvs.as_ref())
            .flat_map(|uv| &uv.values);
        let colors = meshes().flat_map(|m| &m.colors);
        let has = |list: fn(&Mesh) -> bool| meshes().any(list);
        let has_colors = has(|m| !m.colors.is_empty());
        let used = || meshes().flat_map(|m| &m.face_materials);
        let used = || used().map(|&m| &scene.materials[m as usize]);
        let has_uvs = has(|m| m.uvs.is_some());
        let has_textures = has_uvs && used().any(|m| !m.textures.is_empty());
        // Reader's defaults need not be written.
        let granted = if has_colors {
            Rgb::WHITE
        } else {
            DEFAULT_REFLECTANCE
        };
        let has_face_materials = has_textures || used().any(|m| m.diffuse != granted);
        let face_colors = || ScalarFormat::beside_bytes(used().map(|m| &m.diffuse));
        let is_carried = has_face_materials && !has_colors && !has_textures;
        let carried = || parts.iter().map(|p| p.face_colors(scene)).collect();
        let carried: Option<Vec<Vec<Rgb>>> = is_carried.then(carried).flatten();
        let colors = match carried {
            Some(_) => face_colors(),
            None => ScalarFormat::beside_bytes(colors),
        };
        let faces_have_colors = has_face_materials && carried.is_none();
        PlyLayout {
            positions: ScalarFormat::for_positions(positions.copied()),
            normals: has(|m| m.normals.is_some()).then_some(ScalarFormat::Float),
            uvs: has_uvs.then(|| ScalarFormat::for_coordinates(uvs.flat_map(|uv| uv.to_array()))),
            has_colors: has_colors || carried.is_some(),
            colors,
            carried,
            irradiance: has(|m| !m.irradiance.is_empty()).then_some(ScalarFormat::Float),
            errors: has(|m| !m.irradiance_error.is_empty()).then_some(ScalarFormat::Float),
            has_objects: parts.len() > 1,
            wide_counts: meshes().any(|m| m.faces.iter().any(|f| f.len() > 255)),
            // If vertices have colours, other programs would use those of faces instead.
            has_face_colors: faces_have_colors && !has_colors,
            face_colors: match face_colors() {
                // Without bytes beside them they are needed in any case.
                None if faces_have_colors && has_colors => Some(ScalarFormat::Byte),
                exact => exact.filter(|_| faces_have_colors),
            },
            has_textures,
        }
    }

    fn header(&self, scene: &Scene, parts: &[PlyPart<'_>], out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment written by azulejo"
        )?;
        self.information(scene, out)?;
        let vertices: usize = parts.iter().map(|p| p.vertices.len()).sum();
        writeln!(out, "element vertex {vertices}")?;
        self.vertex_properties(out)?;
        let faces: usize = parts.iter().map(|p| p.mesh.faces.len()).sum();
        let count = if self.wide_counts { "uint" } else { "uchar" };
        writeln!(
            out,
            "element face {faces}\nproperty list {count} uint vertex_indices"
        )?;
        let bytes = self.has_face_colors.then_some(ScalarFormat::Byte);
        properties(bytes, &CHANNELS, out)?;
        properties(self.face_colors, &channels("diffuse"), out)?;
        if self.has_textures {
            writeln!(out, "property int texnumber")?;
        }
        writeln!(out, "end_header")
    }

    /// Units, names of objects and textures.
    fn information(&self, scene: &Scene, out: &mut dyn Write) -> io::Result<()> {
        let units = scene.units;
        if units.up == Up::Z {
            writeln!(out, "comment azulejo up z")?;
        }
        if let Some(metres) = units.metres_per_unit {
            writeln!(out, "comment azulejo metres_per_unit {metres:e}")?;
        }
        if units.photometric {
            writeln!(out, "comment azulejo photometric")?;
        }
        if self.carried.is_some() {
            writeln!(out, "comment azulejo colours_of_faces")?;
        }
        if self.has_objects || scene.objects.iter().any(|o| !o.name.is_empty()) {
            for object in &scene.objects {
                writeln!(out, "comment azulejo object {}", one_line(&object.name))?;
            }
        }
        if self.has_textures {
            for texture in &scene.textures {
                writeln!(out, "comment TextureFile {}", one_line(&texture.path))?;
            }
        }
        Ok(())
    }

    fn vertex_properties(&self, out: &mut dyn Write) -> io::Result<()> {
        properties(Some(self.positions), &["x", "y", "z"], out)?;
        properties(self.normals, &["nx", "ny", "nz"], out)?;
        properties(self.uvs, &["s", "t"], out)?;
        let bytes = self.has_colors.then_some(ScalarFormat::Byte);
        properties(bytes, &CHANNELS, out)?;
        properties(self.colors, &channels("diffuse"), out)?;
        properties(self.irradiance, &channels("irradiance"), out)?;
        properties(self.errors, &channels("irradiance_error"), out)?;
        if self.has_objects {
            writeln!(out, "property uint object")?;
        }
        Ok(())
    }

    fn vertices(&self, object: u32, part: &PlyPart<'_>, out: &mut dyn Write) -> io::Result<()> {
        let mesh = &*part.mesh;
        // Objects without an attribute that others have get a neutral value.
        let color =
            |list: &[Rgb], v: PlyVertex, none| *list.get(v.vertex as usize).unwrap_or(&none);
        let colored = |kind: Option<ScalarFormat>, color: Rgb, out: &mut dyn Write| match kind {
            Some(kind) => kind.write(&color.to_array(), out),
            None => Ok(()),
        };
        for (index, &vertex) in part.vertices.iter().enumerate() {
            let position = mesh.positions[vertex.vertex as usize];
            self.positions.write(&position.to_array(), out)?;
            if let Some(kind) = self.normals {
                kind.write(&part.normal(vertex).to_array(), out)?;
            }
            if let Some(kind) = self.uvs {
                kind.write(&part.uv(vertex).to_array(), out)?;
            }
            if self.has_colors {
                let own = color(&mesh.colors, vertex, Rgb::WHITE);
                let carried = self.carried.as_ref();
                let shown = carried.map_or(own, |of_parts| of_parts[object as usize][index]);
                colored(Some(ScalarFormat::Byte), shown, out)?;
                colored(self.colors, shown, out)?;
            }
            let irradiance = color(&mesh.irradiance, vertex, Rgb::BLACK);
            colored(self.irradiance, irradiance, out)?;
            let error = color(&mesh.irradiance_error, vertex, Rgb::BLACK);
            colored(self.errors, error, out)?;
            if self.has_objects {
                out.write_all(&object.to_le_bytes())?;
            }
        }
        Ok(())
    }

    fn faces(
        &self,
        scene: &Scene,
        part: &PlyPart<'_>,
        first: u32,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        for face in 0..part.mesh.faces.len() {
            let corners = &part.corners[part.mesh.faces.corner_range(face)];
            if self.wide_counts {
                out.write_all(&(corners.len() as u32).to_le_bytes())?
            } else {
                out.write_all(&[corners.len() as u8])?
            }
            for corner in corners {
                out.write_all(&(first + corner).to_le_bytes())?;
            }
            let material = &scene.materials[part.mesh.face_materials[face] as usize];
            let bytes = self.has_face_colors.then_some(ScalarFormat::Byte);
            for kind in bytes.into_iter().chain(self.face_colors) {
                kind.write(&material.diffuse.to_array(), out)?;
            }
            if self.has_textures {
                let texture = material.textures.first();
                let number = texture.map_or(-1, |&t| t as i32);
                out.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(())
    }
}

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// Names of three properties.
fn channels(what: &str) -> [String; 3] {
    CHANNELS.map(|channel| format!("{what}_{channel}"))
}

fn properties(
    kind: Option<ScalarFormat>,
    names: &[impl AsRef<str>],
    out: &mut dyn Write,
) -> io::Result<()> {
    let Some(kind) = kind else { return Ok(()) };
    names
        .iter()
        .try_for_each(|name| writeln!(out, "property {} {}", kind.name(), name.as_ref()))
}

/// A name without line breaks.
fn one_line(name: &str) -> String {
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    name.chars().map(printable).collect()
}
