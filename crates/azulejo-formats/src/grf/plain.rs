//! GRF in the words of 2001 alone, for readers that know no extensions.

use super::document::{AppearanceChange, GrfName, MeshBlock, NameKind, ObjectNotes, VertexList};
use super::from_scene::{GrfNames, brdf_of, polygons};
use super::has_area;
use super::write::{FileName, GrfOutput, brdf, faces, point, rgb, vertices};
use crate::surface::tessellate::{exact_counts, lit_mesh_of};
use azulejo_scene::{
    Material, MaterialId, Mesh, Object, PrimitiveKind, Rgb, Scene, Shape, Sidedness, Units,
};
use glam::DVec3;
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};

/// How far the fourth corner of a parallelogram may lie from where it belongs, relative to its
/// edges.
const ROUNDING: f64 = 1e-9;

/// Writes a scene without extensions, with these file names for its textures: exact shapes as
/// meshes, lamps that are parallelograms as `light`, matt surfaces by `rgb`, others by `brdf`, both
/// sides of a sheet as two faces. Names of objects become comments.
///
/// # Errors
/// Those of `out`.
pub fn write_plain(scene: &Scene, pictures: &[String], out: &mut dyn Write) -> io::Result<()> {
    let scene = &*scene.split_sides();
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let writer = PlainWriter {
        scene,
        names: GrfNames::new(scene),
    };
    writer.head(&mut out)?;
    for (path, name) in pictures.iter().zip(&writer.names.textures) {
        let plain: String = path
            .chars()
            .filter(|c| *c != '"' && !c.is_control())
            .collect();
        writeln!(out, "def {name} = texture {}", FileName(&plain))?;
    }
    for (material, name) in scene.materials.iter().zip(&writer.names.materials) {
        write!(out, "def {name} = ")?;
        if is_matt(material) {
            writeln!(out, "rgb {}", rgb(material.diffuse))?;
        } else {
            brdf(&mut out, &brdf_of(material))?;
        }
    }
    let is_scope = !scene.materials.is_empty();
    if is_scope {
        out.write_all(b"begin\n")?;
    }
    for object in &scene.objects {
        writer.object(&mut out, object)?;
    }
    out.write_all(if is_scope { b"end def\n" } else { b";\n" })?;
    out.flush()
}

/// Descriptions of what [`write_plain`] omits from a scene or changes.
pub fn plain_losses(scene: &Scene) -> Vec<String> {
    let materials =
        |lost: fn(&Material) -> bool| scene.materials.iter().filter(|m| lost(m)).count();
    let meshes = |lost: fn(&Mesh) -> bool| {
        let is = |o: &&Object| o.shape.mesh().is_some_and(lost);
        scene.objects.iter().filter(is).count()
    };
    let [primitives, solids] = exact_counts(scene);
    // Primitives that are lamps are written as lights, not as polygons.
    let is_primitive = |o: &&Object| matches!(o.shape, Shape::Primitive(_));
    let lamps = scene
        .objects
        .iter()
        .filter(is_primitive)
        .filter(|o| plain_lamp(scene, o).is_some());
    let counts = [
        (usize::from(scene.units != Units::default()), "the unit"),
        (usize::from(scene.background.is_some()), "the background"),
        (usize::from(scene.fog.is_some()), "the fog"),
        (scene.cameras.len(), "cameras"),
        (scene.lights.len(), "lights without area"),
        (
            primitives - lamps.count(),
            "exact primitives that become polygons",
        ),
        (solids, "exact shapes that become polygons"),
        (
            materials(|m| m.dielectric.is_some()),
            "dielectrics, of which reflection remains",
        ),
        (
            materials(|m| m.emits_back),
            "materials whose backs emit no more",
        ),
        (
            materials(|m| m.sidedness != Sidedness::Unsaid),
            "materials that say which sides are seen",
        ),
        (meshes(|m| m.is_grouped()), "meshes with smoothing groups"),
        (
            meshes(|m| !m.irradiance_error.is_empty()),
            "meshes with standard errors of irradiance",
        ),
        (
            meshes(|m| m.back.is_some()),
            "meshes whose backs become faces of their own",
        ),
    ];
    // What a scene has only once is described without a number.
    let described = |&(count, what): &(usize, &str)| match count {
        0 => None,
        1 if what.starts_with("the ") => Some(what.to_owned()),
        _ => Some(format!("{count} {what}")),
    };
    let words = counts.iter().filter_map(described);
    words.chain(super::losses(scene)).collect()
}

/// A surface that a colour describes.
fn is_matt(material: &Material) -> bool {
    material.brdf.is_none() && material.mirror.is_black()
}

/// An emitting parallelogram: its corner, its edges and its radiance.
struct PlainLamp {
    corner: DVec3,
    edges: [DVec3; 2],
    radiance: Rgb,
}

/// The lamp that an object is, if it is a parallelogram that reflects nothing.
fn plain_lamp(scene: &Scene, object: &Object) -> Option<PlainLamp> {
    let material = |id: MaterialId| {
        let material = &scene.materials[id as usize];
        let is_even = material.is_emitter() && material.emission_picture.is_none();
        let is_lamp = is_even && is_matt(material) && material.diffuse.is_black();
        (is_lamp && material.textures.is_empty()).then_some(material.emission)
    };
    match &object.shape {
        Shape::Primitive(p) if p.kind == PrimitiveKind::Square => {
            let map = p.world_from_object;
            Some(PlainLamp {
                corner: map.translation,
                edges: [map.matrix3.x_axis, map.matrix3.y_axis],
                radiance: material(p.material)?,
            })
        }
        Shape::Mesh(mesh) => {
            let (&first, rest) = mesh.face_materials.split_first()?;
            let radiance = material(first).filter(|_| rest.iter().all(|m| *m == first))?;
            let [a, b, c, d] = quadrilateral(mesh)?;
            let edges = [b - a, d - a];
            let gap = (a + edges[0] + edges[1] - c).length();
            let is_closed = gap <= ROUNDING * (edges[0].length() + edges[1].length());
            let lamp = PlainLamp {
                corner: a,
                edges,
                radiance,
            };
            (is_closed && has_area(edges[0], edges[1])).then_some(lamp)
        }
        _ => None,
    }
}

/// The corners of a mesh that is one quadrilateral, or two triangles that make one.
fn quadrilateral(mesh: &Mesh) -> Option<[DVec3; 4]> {
    match mesh.faces.len() {
        1 => mesh.face_positions(0).try_into().ok(),
        2 => {
            let one: [DVec3; 3] = mesh.face_positions(0).try_into().ok()?;
            let two: [DVec3; 3] = mesh.face_positions(1).try_into().ok()?;
            let alone = |of: &[DVec3; 3], from: &[DVec3; 3]| {
                let mut others = (0..3).filter(|&k| !from.contains(&of[k]));
                others.next().filter(|_| others.next().is_none())
            };
            let (k, far) = (alone(&one, &two)?, alone(&two, &one)?);
            let at = |list: &[DVec3; 3], k: usize| list[k % 3];
            // The shared edge runs the other way in the other triangle.
            let shared = [at(&one, k + 1), at(&one, k + 2)];
            let is_turned = [at(&two, far + 2), at(&two, far + 1)] == shared;
            is_turned.then_some([one[k], shared[0], two[far], shared[1]])
        }
        _ => None,
    }
}

struct PlainWriter<'s> {
    scene: &'s Scene,
    names: GrfNames,
}

impl PlainWriter<'_> {
    /// Comments as the original program wrote them.
    fn head(&self, out: &mut GrfOutput<'_>) -> io::Result<()> {
        let [mut vertices, mut faces] = [0, 0];
        for object in &self.scene.objects {
            let mesh = polygons(lit_mesh_of(object), ObjectNotes::default());
            vertices += mesh.vertices.positions.len();
            faces += mesh.faces.len();
        }
        writeln!(
            out,
            "// azulejo {}\n// Components: {}\n// Vertices: {vertices}, faces: {faces}",
            env!("CARGO_PKG_VERSION"),
            self.scene.objects.len()
        )?;
        let bounds = self.scene.bounds();
        if bounds.min.is_finite() && bounds.max.is_finite() {
            let (min, max) = (point(bounds.min), point(bounds.max));
            writeln!(out, "// Bounding box: {min} {max}")?;
        }
        Ok(())
    }

    fn object(&self, out: &mut GrfOutput<'_>, object: &Object) -> io::Result<()> {
        if !object.name.is_empty() {
            let name = object.name.replace(|c: char| c.is_control(), " ");
            writeln!(out, "// {}", name.trim())?;
        }
        if let Some(lamp) = plain_lamp(self.scene, object) {
            let [a, b] = lamp.edges;
            return writeln!(
                out,
                "light begin rgb {} {} {} {} end light",
                rgb(lamp.radiance),
                point(lamp.corner),
                point(a),
                point(b)
            );
        }
        let mesh = lit_mesh_of(object);
        let materials = mesh.face_materials.clone();
        let whole = polygons(mesh, ObjectNotes::default());
        let mut parts: Vec<(MaterialId, Vec<usize>)> = Vec::new();
        for (face, &material) in materials.iter().enumerate() {
            let is_known = |p: &&mut (MaterialId, Vec<usize>)| self.is_alike(p.0, material);
            match parts.iter_mut().find(is_known) {
                Some((_, faces)) => faces.push(face),
                None => parts.push((material, vec![face])),
            }
        }
        match &parts[..] {
            [] | [_] => self.mesh(out, &materials, whole),
            parts => parts.iter().try_for_each(|(_, faces)| {
                let own: Vec<MaterialId> = faces.iter().map(|&f| materials[f]).collect();
                self.mesh(out, &own, part(&whole, faces))
            }),
        }
    }

    /// Whether faces of two materials can be in one mesh: with the same emission, both or neither by
    /// `rgb`, and with the same textures, because nothing ends a texture but another.
    fn is_alike(&self, a: MaterialId, b: MaterialId) -> bool {
        let [a, b] = [a, b].map(|id| &self.scene.materials[id as usize]);
        a.emission == b.emission && is_matt(a) == is_matt(b) && a.textures == b.textures
    }

    /// Writes a mesh whose materials are alike.
    fn mesh(
        &self,
        out: &mut GrfOutput<'_>,
        materials: &[MaterialId],
        mut block: MeshBlock,
    ) -> io::Result<()> {
        let mut last = None;
        for (face, &id) in materials.iter().enumerate() {
            if last.replace(id) == Some(id) {
                continue;
            }
            let material = &self.scene.materials[id as usize];
            let kind = if is_matt(material) {
                NameKind::Color
            } else {
                NameKind::Brdf
            };
            let textures = material.textures.iter().filter(|_| face == 0);
            let textures = textures.map(|&t| (NameKind::Texture, &self.names.textures[t as usize]));
            let own = (kind, &self.names.materials[id as usize]);
            let changes = std::iter::once(own).chain(textures);
            let used = |(kind, name): (NameKind, &GrfName)| {
                (face as u32, AppearanceChange::Use(kind, name.clone()))
            };
            block.changes.extend(changes.map(used));
        }
        let first = materials.first();
        let emission = first.map_or(Rgb::BLACK, |m| self.scene.materials[*m as usize].emission);
        if emission.is_black() {
            out.write_all(b"begin mesh\n")?;
        } else {
            writeln!(out, "mesh light begin\nrgb {}", rgb(emission))?;
        }
        vertices(out, &block)?;
        faces(out, &block)?;
        out.write_all(b"end mesh\n")
    }
}

/// Some faces of a mesh, with the vertices that they use.
fn part(whole: &MeshBlock, faces: &[usize]) -> MeshBlock {
    let mut new: HashMap<u32, u32> = HashMap::new();
    let mut used: Vec<usize> = Vec::new();
    let mut part = MeshBlock::default();
    for &face in faces {
        let mut ring = Vec::new();
        for &v in whole.faces.get(face) {
            ring.push(*new.entry(v).or_insert_with(|| {
                used.push(v as usize);
                used.len() as u32 - 1
            }));
        }
        part.faces.push(&ring);
    }
    let list = &whole.vertices;
    part.vertices = VertexList {
        positions: used.iter().map(|&v| list.positions[v]).collect(),
        normals: list.normals.taken(&used),
        irradiance: list.irradiance.taken(&used),
        uvs: list.uvs.taken(&used),
        colors: list.colors.taken(&used),
        named_colors: Vec::new(),
    };
    part
}
