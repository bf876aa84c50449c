//! Writes scenes as VRML97 and as X3D in XML.

use super::markup::{MarkupField, MarkupNode, write_classic, write_xml};
use crate::surface::losses::LossList;
use crate::surface::phong::Highlight;
use crate::surface::tessellate::mesh_of;
use azulejo_scene::{
    Attribute, Material, MaterialId, Mesh, Object, OpacityMode, Rgb, Scene, Sidedness, Units, Up,
};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{self, Write};

/// Factor between `shininess` and the exponent of a highlight: ISO/IEC 14772-1, 4.14.4.
const SHININESS: f64 = 128.0;

/// Writes a scene as VRML97, with these file names for its textures.
///
/// Objects are shapes of faces in groups by the path of their name; faces of several materials become
/// several shapes. Lengths are metres, y is up. Coordinates read back to the same values.
/// [`losses`] describes what the format cannot represent.
///
/// # Errors
/// Those of `out`.
pub fn write(scene: &Scene, pictures: &[String], out: &mut dyn Write) -> io::Result<()> {
    write_classic(&nodes(scene, pictures), out)
}

/// As [`write()`], as X3D 3.3 in XML.
///
/// # Errors
/// Those of `out`.
pub fn write_x3d(scene: &Scene, pictures: &[String], out: &mut dyn Write) -> io::Result<()> {
    write_xml(&nodes(scene, pictures), out)
}

/// Descriptions of what [`write()`] and [`write_x3d`] would omit from a scene, or change.
pub fn losses(scene: &Scene) -> Vec<String> {
    let names = DefNames::default();
    let renamed = scene.objects.iter().filter(|o| {
        let mut parts = o.name.split('/');
        !o.name.is_empty() && parts.any(|part| names.valid(part) != part)
    });
    let is_odd_opacity = |m: &Material| {
        let opacity = m.opacity.as_ref();
        opacity.is_some_and(|o| o.picture.is_some() || o.mode != OpacityMode::Blend)
    };
    LossList::new(scene)
        .count(usize::from(scene.background.is_some()), "background")
        .count(usize::from(scene.fog.is_some()), "fog")
        .exact_shapes()
        .count(renamed.count(), "objects whose names change")
        .meshes(
            |m| {
                m.mesh
                    .face_materials
                    .iter()
                    .any(|id| *id != m.mesh.face_materials[0])
            },
            "meshes that become several shapes",
        )
        .meshes(
            |m| m.mesh.is_grouped() && m.mesh.normals.is_none(),
            "meshes whose smoothing groups are omitted",
        )
        .irradiance()
        .single_precision(", in programs that read them")
        .materials(
            Material::is_specular,
            "materials whose mirror or glass is omitted",
        )
        .materials(
            |m| m.brdf.is_some() && highlight(m).is_none(),
            "reflection models",
        )
        .materials(
            |m| m.emission.max_channel() > 1.0,
            "materials that emit more than 1, which other programs cut",
        )
        .materials(
            |m| !m.textures.is_empty() && m.diffuse != Rgb::WHITE,
            "textured materials, whose colour other programs replace",
        )
        .materials(is_odd_opacity, "pictures and masks of opacity")
        .materials(
            |m| m.textures.len() > 1,
            "materials of which only the first texture is kept",
        )
        .finish()
}

/// The highlight of a material, as these formats have it.
fn highlight(material: &Material) -> Option<Highlight> {
    let highlight = Highlight::of(material).filter(|_| material.mirror.is_black());
    highlight.map(|h| h.around_normal())
}

/// Valid and different names for nodes.
#[derive(Default)]
struct DefNames {
    taken: HashSet<String>,
    /// How far the numbers behind each name have come.
    next: HashMap<String, usize>,
}

impl DefNames {
    /// A name as both encodings allow it.
    fn valid(&self, name: &str) -> String {
        let is_odd =
            |c: char| c.is_control() || c.is_whitespace() || "\"'#,.:[]\\{}<>&".contains(c);
        let mut valid: String = name
            .chars()
            .map(|c| if is_odd(c) { '_' } else { c })
            .collect();
        let starts_badly = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-');
        if valid.is_empty() || valid.starts_with(starts_badly) {
            valid.insert(0, '_');
        }
        valid
    }

    /// The same, different from all before.
    fn unique(&mut self, name: &str) -> String {
        let valid = self.valid(name);
        let number = self.next.entry(valid.clone()).or_insert(0);
        loop {
            *number += 1;
            let name = match *number {
                1 => valid.clone(),
                n => format!("{valid}_{n}"),
            };
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}

fn nodes(scene: &Scene, pictures: &[String]) -> Vec<MarkupNode> {
    let scene = scene.clone().adapted(Units {
        metres_per_unit: Some(1.0),
        up: Up::Y,
        photometric: scene.units.photometric,
    });
    let mut writer = VrmlWriter {
        scene: &scene,
        pictures,
        names: DefNames::default(),
        materials: HashMap::new(),
    };
    let objects: Vec<(Vec<&str>, &Object)> = scene
        .objects
        .iter()
        .map(|o| (o.name.split('/').collect(), o))
        .collect();
    writer.level(&objects, 0)
}

struct VrmlWriter<'s> {
    scene: &'s Scene,
    pictures: &'s [String],
    names: DefNames,
    /// The names of materials that were written.
    materials: HashMap<MaterialId, String>,
}

impl VrmlWriter<'_> {
    /// The nodes of objects that have the first `depth` names in common; each run of a common next
    /// name is a group.
    fn level(&mut self, objects: &[(Vec<&str>, &Object)], depth: usize) -> Vec<MarkupNode> {
        let mut out = Vec::new();
        let mut rest = objects;
        while let Some(((path, object), others)) = rest.split_first() {
            if path.len() <= depth + 1 {
                let name = path.get(depth).copied().unwrap_or("");
                out.extend(self.object(name, object));
                rest = others;
                continue;
            }
            let is_same =
                |o: &(Vec<&str>, &Object)| o.0.len() > depth + 1 && o.0[..=depth] == path[..=depth];
            let run = rest.iter().take_while(|o| is_same(o)).count();
            let def = self.names.unique(path[depth]);
            let children = self.level(&rest[..run], depth + 1);
            out.push(group(Some(def), children));
            rest = &rest[run..];
        }
        out
    }

    fn object(&mut self, name: &str, object: &Object) -> Option<MarkupNode> {
        let mesh = mesh_of(object);
        let mut parts: BTreeMap<MaterialId, Vec<usize>> = BTreeMap::new();
        for (face, &material) in mesh.face_materials.iter().enumerate() {
            parts.entry(material).or_default().push(face);
        }
        let def = (!name.is_empty()).then(|| self.names.unique(name));
        let mut shapes: Vec<MarkupNode> = parts
            .iter()
            .map(|(&material, faces)| self.shape(&mesh, material, faces))
            .collect();
        match shapes.len() {
            0 => None,
            1 => shapes.pop().map(|shape| MarkupNode { def, ..shape }),
            _ => Some(group(def, shapes)),
        }
    }

    fn shape(&mut self, mesh: &Mesh, id: MaterialId, faces: &[usize]) -> MarkupNode {
        let mut shape = MarkupNode::new("Shape");
        let appearance = self.appearance(id);
        shape.child("appearance", appearance);
        let material = &self.scene.materials[id as usize];
        shape.child("geometry", face_set(mesh, material, faces));
        shape
    }

    fn appearance(&mut self, id: MaterialId) -> MarkupNode {
        let material = &self.scene.materials[id as usize];
        let mut appearance = MarkupNode::new("Appearance");
        let mut node = MarkupNode::new("Material");
        if let Some(name) = self.materials.get(&id) {
            node.reuse = Some(name.clone());
        } else {
            let name = self.names.unique(match &*material.name {
                "" => "material",
                name => name,
            });
            self.materials.insert(id, name.clone());
            node.def = Some(name);
            node.value("diffuseColor", numbers(&material.diffuse.to_array()));
            if material.is_emitter() {
                node.value("emissiveColor", numbers(&material.emission.to_array()));
            }
            if let Some(opacity) = material.opacity.filter(|o| o.constant < 1.0) {
                node.value("transparency", numbers(&[1.0 - opacity.constant]));
            }
            if let Some(highlight) = highlight(material) {
                let ks = highlight.ks.map(|k| k.min(1.0));
                node.value("specularColor", numbers(&ks.to_array()));
                node.value("shininess", numbers(&[(highlight.n / SHININESS).min(1.0)]));
            }
        }
        appearance.child("material", node);
        if let Some(path) = material
            .textures
            .first()
            .map(|&t| &self.pictures[t as usize])
        {
            let mut texture = MarkupNode::new("ImageTexture");
            let url = MarkupField::Texts(vec![path.clone()]);
            texture.fields.push(("url", url));
            appearance.child("texture", texture);
        }
        appearance
    }
}

fn group(def: Option<String>, children: Vec<MarkupNode>) -> MarkupNode {
    let mut group = MarkupNode::new("Group");
    group.def = def;
    group
        .fields
        .push(("children", MarkupField::Nodes(children)));
    group
}

/// Some faces of a mesh, with the vertices and values that they use.
fn face_set(mesh: &Mesh, material: &Material, faces: &[usize]) -> MarkupNode {
    let mut node = MarkupNode::new("IndexedFaceSet");
    match material.sidedness {
        Sidedness::One => node.value("solid", "TRUE".to_owned()),
        Sidedness::Two => node.value("solid", "FALSE".to_owned()),
        Sidedness::Unsaid => {}
    }
    // Readers need not look whether all faces are convex if none has more than three corners.
    if faces.iter().any(|&f| mesh.faces.get(f).len() > 3) {
        node.value("convex", "FALSE".to_owned());
    }
    let corners = |f: usize| mesh.faces.corner_range(f);
    let vertex = |corner: usize| mesh.faces.corners[corner];
    let (used, index) = indexed(faces, corners, vertex);
    node.list("coordIndex", index);
    let points = used.iter().map(|&v| mesh.positions[v as usize].to_array());
    node.child("coord", values("Coordinate", "point", points));
    if let Some(normals) = &mesh.normals {
        let (used, index) = indexed(faces, corners, |c| value_index(normals, c, vertex(c)));
        let vectors = used
            .iter()
            .map(|&v| unit(normals.values[v as usize]).to_array());
        node.child("normal", values("Normal", "vector", vectors));
        node.list("normalIndex", index);
    }
    if let Some(uvs) = &mesh.uvs {
        let (used, index) = indexed(faces, corners, |c| value_index(uvs, c, vertex(c)));
        let points = used.iter().map(|&v| uvs.values[v as usize].to_array());
        node.child("texCoord", values("TextureCoordinate", "point", points));
        node.list("texCoordIndex", index);
    }
    if !mesh.colors.is_empty() {
        // A vertex colour replaces that of the material.
        let color = |&v: &u32| (mesh.colors[v as usize] * material.diffuse).to_array();
        node.child("color", values("Color", "color", used.iter().map(color)));
    }
    node
}

fn unit(normal: DVec3) -> DVec3 {
    normal.try_normalize().unwrap_or(DVec3::Y)
}

fn value_index<T>(attribute: &Attribute<T>, corner: usize, vertex: u32) -> u32 {
    let corners = attribute.corners.as_ref();
    corners.map_or(vertex, |index| index[corner])
}

/// The values that the corners of some faces use, and the faces' indices into them, each face ended
/// by −1.
fn indexed(
    faces: &[usize],
    corners: impl Fn(usize) -> std::ops::Range<usize>,
    value: impl Fn(usize) -> u32,
) -> (Vec<u32>, Vec<String>) {
    let mut used: BTreeMap<u32, usize> = BTreeMap::new();
    for &face in faces {
        used.extend(corners(face).map(|c| (value(c), 0)));
    }
    for (number, slot) in used.values_mut().enumerate() {
        *slot = number;
    }
    let face = |&face: &usize| {
        let ring = corners(face).map(|c| used[&value(c)].to_string());
        let ring: Vec<String> = ring.collect();
        format!("{} -1", ring.join(" "))
    };
    let index = faces.iter().map(face).collect();
    (used.into_keys().collect(), index)
}

fn values<const N: usize>(
    kind: &'static str,
    field: &'static str,
    list: impl Iterator<Item = [f64; N]>,
) -> MarkupNode {
    let mut node = MarkupNode::new(kind);
    node.list(field, list.map(|v| numbers(&v)).collect());
    node
}

/// Numbers in the shortest form that reads back to the same values.
fn numbers(list: &[f64]) -> String {
    let number = |x: &f64| {
        if *x == 0.0 || (1e-5..1e16).contains(&x.abs()) {
            x.to_string()
        } else {
            format!("{x:e}")
        }
    };
    list.iter().map(number).collect::<Vec<_>>().join(" ")
}
