//! Which entry of which mesh each object of the scene is given its light by.

use super::super::origin::{FaceOrigin, ObjectOrigin};
use super::error::PatchError;
use super::notes::Notes;
use super::source::Source;
use super::splits::{PrimitiveFaces, turned};
use super::types::{Convention, InstanceMode, LightmapEdit, LightmapUvs, ObjectLayout};
use std::collections::{HashMap, HashSet};

/// An offset and a scale of texture coordinates: uv ↦ offset + scale · uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The offset.
    pub offset: [f32; 2],
    /// The scale.
    pub scale: [f32; 2],
}

/// An object that receives light.
#[derive(Clone, Debug)]
pub struct Assignment<'l> {
    /// Its number in the scene.
    pub object: usize,
    /// Its node.
    pub node: usize,
    /// The mesh of the node.
    pub mesh: usize,
    /// Where its mesh entry comes from.
    pub entry: Entry,
    /// Its faces by primitive.
    pub parts: Vec<PrimitiveFaces<'l>>,
}

/// The mesh entry of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Entry {
    /// The mesh of its node, changed.
    Own,
    /// A changed copy.
    Copy,
    /// A copy with the coordinates of another assignment, but other materials.
    Moved(usize, Placement),
    /// That of another assignment; the node says how its coordinates are moved.
    Shared(usize, Placement),
}

/// How far moved coordinates may be from those that are wanted: a small part of a texel.
const MOST_OFF: f64 = 1e-6;

/// Finds the entries for all objects.
///
/// # Errors
/// Layouts that do not fit the origins.
pub fn assignments<'l>(
    source: &Source,
    origins: &'l [ObjectOrigin],
    edit: &LightmapEdit<'l>,
    notes: &mut Notes,
) -> Result<Vec<Assignment<'l>>, PatchError> {
    if origins.len() != edit.objects.len() {
        let found = format!(
            "{} layouts for {} objects",
            edit.objects.len(),
            origins.len()
        );
        return Err(source.refused(found));
    }
    let (mut receivers, nodes) = receivers(source, origins, edit, notes)?;
    let kept = meshes_of_nodes_without(source, &nodes);
    let is_copied = edit.instances == InstanceMode::Copy;
    let mut first_of: HashMap<usize, usize> = HashMap::new();
    for i in 0..receivers.len() {
        let mesh = receivers[i].mesh;
        let first = *first_of.entry(mesh).or_insert(i);
        let base = (first < i && !is_copied).then(|| &receivers[first]);
        let moved = base.and_then(|base| moved(&base.parts, &receivers[i].parts));
        receivers[i].entry = match (moved, edit.instances) {
            (Some(placement), InstanceMode::Node) => Entry::Shared(first, placement),
            (Some(placement), _) => Entry::Moved(first, placement),
            (None, _) if first == i && !kept.contains(&mesh) => Entry::Own,
            (None, _) => {
                if !is_copied && first != i {
                    notes.add(
                        "instance whose coordinates are not moved and scaled ones: gets a copy",
                    );
                }
                Entry::Copy
            }
        };
    }
    Ok(receivers)
}

/// The objects with a layout and faces, without those whose nodes cannot have a lightmap of their own, and the nodes that
/// can. Entries are still to be found.
fn receivers<'l>(
    source: &Source,
    origins: &'l [ObjectOrigin],
    edit: &LightmapEdit<'l>,
    notes: &mut Notes,
) -> Result<(Vec<Assignment<'l>>, HashSet<usize>), PatchError> {
    let mut receivers = Vec::new();
    let mut nodes = HashSet::new();
    for (object, (origin, layout)) in origins.iter().zip(edit.objects).enumerate() {
        let Some(layout) = layout else { continue };
        let Some(mesh) = source.mesh_of(origin.node) else {
            let found = format!("a layout for node {}, which has no mesh", origin.node);
            return Err(source.refused(found));
        };
        let parts = parts(origin, layout, edit);
        let parts = parts.map_err(|f| source.refused(format!("node {}: {f}", origin.node)))?;
        if origin.instance.is_some() {
            notes.add("node with instances (EXT_mesh_gpu_instancing): receives no lightmap");
        } else if !nodes.insert(origin.node) {
            notes.add("node that occurs twice in the scene: has the lightmap of its first place");
        } else if !parts.is_empty() {
            receivers.push(Assignment {
                object,
                node: origin.node,
                mesh,
                entry: Entry::Own,
                parts,
            });
        }
    }
    Ok((receivers, nodes))
}

/// The meshes of nodes that receive nothing.
pub fn meshes_of_nodes_without(source: &Source, receiving: &HashSet<usize>) -> HashSet<usize> {
    let nodes = 0..source.data.root.nodes.len();
    let others = nodes.filter(|node| !receiving.contains(node));
    others.filter_map(|node| source.mesh_of(node)).collect()
}

/// The faces of an object by primitive.
fn parts<'l>(
    origin: &'l ObjectOrigin,
    layout: &'l ObjectLayout,
    edit: &LightmapEdit,
) -> Result<Vec<PrimitiveFaces<'l>>, String> {
    let count = origin.faces.len();
    if layout.uvs.len() != count || layout.pages.len() != count {
        let (uvs, pages) = (layout.uvs.len(), layout.pages.len());
        return Err(format!(
            "coordinates of {uvs} and pages of {pages} faces, of {count}"
        ));
    }
    let is_written = matches!(edit.uvs, LightmapUvs::Added(_));
    if is_written && !layout.uvs.iter().flatten().flatten().all(|v| v.is_finite()) {
        return Err("coordinates that are not finite".to_owned());
    }
    let mut parts: Vec<PrimitiveFaces> = Vec::new();
    let mut at = 0;
    for faces in origin.faces.chunk_by(|a, b| a.primitive == b.primitive) {
        let part = part(faces, at, layout, origin.mirrored)?;
        if parts
            .last()
            .is_some_and(|last| last.primitive >= part.primitive)
        {
            return Err("faces that are not in the order of their primitives".to_owned());
        }
        if edit.convention != Convention::Plain && part.page as usize >= edit.pages.len() {
            return Err(format!("page {} of {}", part.page, edit.pages.len()));
        }
        parts.push(part);
        at += faces.len();
    }
    let pages: HashSet<u32> = parts.iter().map(|part| part.page).collect();
    if edit.convention == Convention::Mx && pages.len() > 1 {
        return Err("faces on several pages, of which MX_lightmap allows one".to_owned());
    }
    Ok(parts)
}

fn part<'l>(
    faces: &'l [FaceOrigin],
    at: usize,
    layout: &'l ObjectLayout,
    mirrored: bool,
) -> Result<PrimitiveFaces<'l>, String> {
    let pages = &layout.pages[at..][..faces.len()];
    let (primitive, page) = match (faces.first(), pages.first()) {
        (Some(face), Some(page)) => (face.primitive as usize, *page),
        _ => return Err("no faces".to_owned()),
    };
    if pages.iter().any(|p| *p != page) {
        return Err(format!("primitive {primitive} on several pages"));
    }
    Ok(PrimitiveFaces {
        primitive,
        faces,
        uvs: &layout.uvs[at..][..faces.len()],
        page,
        mirrored,
    })
}

/// How the coordinates of one object become those of another of the same mesh, if an offset and a scale
/// are all they differ by.
fn moved(base: &[PrimitiveFaces], other: &[PrimitiveFaces]) -> Option<Placement> {
    let same = |(a, b): (&PrimitiveFaces, &PrimitiveFaces)| {
        (a.primitive, a.faces) == (b.primitive, b.faces)
    };
    if base.len() != other.len() || !base.iter().zip(other).all(same) {
        return None;
    }
    let u = axis(base, other, 0)?;
    let v = axis(base, other, 1)?;
    Some(Placement {
        offset: [u.0, v.0],
        scale: [u.1, v.1],
    })
}

/// Offset and scale of one coordinate.
fn axis(base: &[PrimitiveFaces], other: &[PrimitiveFaces], k: usize) -> Option<(f32, f32)> {
    let pairs = || corners(base, k).zip(corners(other, k));
    let least = pairs().min_by(|a, b| a.0.total_cmp(&b.0))?;
    let most = pairs().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let scale = match most.0 - least.0 {
        0.0 => 1.0,
        width => (most.1 - least.1) / width,
    };
    let offset = least.1 - scale * least.0;
    let (offset, scale) = (offset as f32, scale as f32);
    let is_near = |(from, to): (f64, f64)| {
        (f64::from(offset) + f64::from(scale) * from - to).abs() <= MOST_OFF
    };
    pairs().all(is_near).then_some((offset, scale))
}

/// A coordinate of all corners in the order of the file.
fn corners<'p>(parts: &'p [PrimitiveFaces], k: usize) -> impl Iterator<Item = f64> + 'p {
    parts.iter().flat_map(move |part| {
        let mirrored = part.mirrored;
        let coordinate =
            move |uvs: &[[f32; 2]; 3]| turned(*uvs, mirrored).map(|uv| f64::from(uv[k]));
        part.uvs.iter().flat_map(coordinate)
    })
}
