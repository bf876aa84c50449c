//! Meshes that stand in several places: `ext shared_mesh` names a mesh, and `ext mesh_instance` places it
//! again. Files that are included several times have their meshes shared, too.

use super::document::{BoxedError, GrfName, MeshBlock, MeshInstanceBlock, SourcePosition};
use super::entries::{EntryValue, GrfEntries};
use super::parser::{GrfParser, ParseResult};
use super::placement::BlockPlace;
use super::resolve::{GrfResolver, ResolveResult};
use super::write::{GrfOutput, affine_map, object, rgb_list};
use azulejo_scene::{
    BackIrradiance, MaterialId, Mesh, MeshInstance, PrimitiveKind, Rgb, Shape, SharedMesh,
    VertexLight,
};
use glam::DAffine3;
use std::collections::HashMap;
use std::io::{self, Write};

impl<'a> GrfParser<'a, '_, '_> {
    /// The name and the place in an `ext shared_mesh`.
    pub fn shared_mesh(
        &mut self,
        entries: &mut GrfEntries<'a>,
    ) -> ParseResult<(GrfName, DAffine3)> {
        let name = self.shared_mesh_name(entries, "name")?;
        Ok((name, self.map(entries, PrimitiveKind::Cuboid)?))
    }

    /// An `ext mesh_instance`. How many vertices its mesh has is not known yet.
    pub fn mesh_instance(
        &mut self,
        entries: &mut GrfEntries<'a>,
    ) -> ParseResult<MeshInstanceBlock> {
        let mut block = MeshInstanceBlock {
            of: self.shared_mesh_name(entries, "of")?,
            map: self.map(entries, PrimitiveKind::Cuboid)?,
            irradiance: self.take_colors(entries, "irad")?,
            irradiance_error: self.take_colors(entries, "irad_error")?,
            ..MeshInstanceBlock::default()
        };
        if let Some(entry) = entries.take("back_vertices") {
            let vertex = |n: &f64| (*n >= 0.0 && *n <= f64::from(u32::MAX)).then_some(*n as u32);
            let vertices: Option<Vec<u32>> = match &entry.value {
                EntryValue::Numbers(numbers) => numbers.iter().map(vertex).collect(),
                _ => None,
            };
            let Some(vertices) = vertices else {
                return Err(self.wrong(&entry, "indices of vertices"));
            };
            let values = self.take_colors(entries, "back")?;
            let errors = self.take_colors(entries, "back_error")?;
            block.back = Some((vertices, values, errors));
        }
        Ok(block)
    }

    fn shared_mesh_name(
        &mut self,
        entries: &mut GrfEntries<'a>,
        key: &str,
    ) -> ParseResult<GrfName> {
        let (word, _) = self.needed_word(entries, key)?;
        Ok(self.shared.intern(word))
    }

    /// A list of colours; empty without the key.
    fn take_colors(&mut self, entries: &mut GrfEntries<'a>, key: &str) -> ParseResult<Vec<Rgb>> {
        let Some(entry) = entries.take(key) else {
            return Ok(Vec::new());
        };
        let EntryValue::Vectors(list) = &entry.value else {
            return Err(self.wrong(&entry, "triples (r, g, b)"));
        };
        let colors = list.iter();
        Ok(colors
            .map(|&v| self.not_negative(entry.offset, Rgb::from(v)))
            .collect())
    }
}

/// Writes that a mesh stands in its own coordinates, its name, and its place.
pub(super) fn shared_mesh(
    out: &mut GrfOutput<'_>,
    name: &GrfName,
    map: &DAffine3,
) -> io::Result<()> {
    write!(out, "ext shared_mesh begin name = {name}")?;
    affine_map(out, map)?;
    out.write_all(b" end ext\n")
}

/// Writes one more place of a mesh.
pub(super) fn mesh_instance(out: &mut GrfOutput<'_>, block: &MeshInstanceBlock) -> io::Result<()> {
    object(out, &block.notes, None)?;
    write!(out, "ext mesh_instance begin of = {}", block.of)?;
    affine_map(out, &block.map)?;
    let mut lists = vec![
        ("irad", &block.irradiance),
        ("irad_error", &block.irradiance_error),
    ];
    if let Some((vertices, values, errors)) = &block.back {
        out.write_all(b"\nback_vertices =")?;
        vertices.iter().try_for_each(|v| write!(out, " {v}"))?;
        lists.extend([("back", values), ("back_error", errors)]);
    }
    let is_short = lists.iter().all(|(_, list)| list.is_empty());
    out.write_all(if is_short { b" " } else { b"\n" })?;
    for (key, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        rgb_list(out, key, list)?;
    }
    out.write_all(b"end ext\n")
}

impl MeshInstanceBlock {
    /// The block of an instance of the mesh of that name.
    pub fn from_instance(of: GrfName, instance: &MeshInstance) -> MeshInstanceBlock {
        let light = instance.light.as_deref().cloned().unwrap_or_default();
        let back = light.back.map(|back| {
            let known = |v: &u32| back.irradiance[*v as usize].is_some();
            let vertices: Vec<u32> = (0..back.irradiance.len() as u32).filter(known).collect();
            let errors = vertices.iter().filter_map(|&v| back.error.get(v as usize));
            let errors = errors.copied().collect();
            let values = back.irradiance.into_iter().flatten().collect();
            (vertices, values, errors)
        });
        MeshInstanceBlock {
            of,
            map: instance.world_from_mesh,
            irradiance: light.irradiance,
            irradiance_error: light.error,
            back,
            ..MeshInstanceBlock::default()
        }
    }

    /// Its irradiance on a mesh with `count` vertices; `None` if the block has another number.
    fn light(&self, count: usize) -> Option<Option<Box<VertexLight>>> {
        if self.irradiance.is_empty() {
            let is_empty = self.irradiance_error.is_empty() && self.back.is_none();
            return is_empty.then_some(None);
        }
        let errors = self.irradiance_error.len();
        if self.irradiance.len() != count || ![0, count].contains(&errors) {
            return None;
        }
        let back = match &self.back {
            Some(back) => Some(Box::new(back_irradiance(back, count)?)),
            None => None,
        };
        Some(Some(Box::new(VertexLight {
            irradiance: self.irradiance.clone(),
            error: self.irradiance_error.clone(),
            back,
        })))
    }
}

/// The irradiance of backs from a list of vertices; `None` if the lists do not fit.
fn back_irradiance(
    (vertices, values, errors): &(Vec<u32>, Vec<Rgb>, Vec<Rgb>),
    count: usize,
) -> Option<BackIrradiance> {
    let number = vertices.len();
    if values.len() != number || ![0, number].contains(&errors.len()) {
        return None;
    }
    let mut back = BackIrradiance {
        irradiance: vec![None; count],
        error: Vec::new(),
    };
    for (&v, &value) in vertices.iter().zip(values) {
        *back.irradiance.get_mut(v as usize)? = Some(value);
    }
    if !errors.is_empty() {
        back.error = vec![Rgb::BLACK; count];
        for (&v, &error) in vertices.iter().zip(errors) {
            back.error[v as usize] = error;
        }
    }
    Some(back)
}

/// The meshes of a document that stand in several places.
#[derive(Default)]
pub(super) struct SharedMeshes<'d> {
    /// By the name in `ext shared_mesh`.
    named: HashMap<&'d str, SharedMesh>,
    /// The meshes of files that are included several times, by their block, with the materials of
    /// their faces, which depend on the place of the include.
    included: HashMap<*const MeshBlock, Vec<(Vec<MaterialId>, SharedMesh)>>,
}

impl<'d> GrfResolver<'d> {
    /// The mesh of a file that is included several times; `None` where it has to be copied.
    pub fn included_instance(
        &mut self,
        block: &'d MeshBlock,
        materials: &[MaterialId],
        place: BlockPlace,
    ) -> ResolveResult<Option<MeshInstance>> {
        let has_light = !block.vertices.irradiance.is_empty();
        // Named colours may be others at every include.
        if !self.is_repeated || has_light || !block.vertices.named_colors.is_empty() {
            return Ok(None);
        }
        // Every place counts as a copy does, since the first pass divides them all.
        let size = block.vertices.positions.len() + block.faces.corners.len();
        self.spend(size as u64, place.source)?;
        let map = place.outer.unwrap_or(DAffine3::IDENTITY);
        let known = self.shared_meshes.included.entry(block).or_default();
        if let Some((_, shared)) = known.iter_mut().find(|(of, _)| of == materials) {
            return Ok(shared.placed(map));
        }
        let mesh = self.whole_mesh(
            block,
            materials.to_vec(),
            BlockPlace {
                outer: None,
                ..place
            },
        )?;
        let mut shared = SharedMesh::new(mesh);
        let placed = shared.placed(map);
        let known = self.shared_meshes.included.entry(block).or_default();
        known.push((materials.to_vec(), shared));
        Ok(placed)
    }

    /// The first place of a mesh with an `ext shared_mesh`, from the mesh in its own coordinates.
    pub fn named_instance(
        &mut self,
        (name, map): &'d (GrfName, DAffine3),
        mut mesh: Mesh,
        place: BlockPlace,
    ) -> ResolveResult<MeshInstance> {
        let light = (!mesh.irradiance.is_empty()).then(|| {
            Box::new(VertexLight {
                irradiance: std::mem::take(&mut mesh.irradiance),
                error: std::mem::take(&mut mesh.irradiance_error),
                back: mesh.back.take(),
            })
        });
        let mut shared = SharedMesh::new(mesh);
        let placed = shared.placed(place.outer.unwrap_or(DAffine3::IDENTITY) * *map);
        self.shared_meshes.named.insert(name, shared);
        let mut placed = placed.ok_or_else(|| self.flattened(place.source))?;
        placed.light = light;
        Ok(placed)
    }

    pub fn mesh_instance(
        &mut self,
        block: &'d MeshInstanceBlock,
        place: BlockPlace,
    ) -> ResolveResult<()> {
        let map = place.outer.unwrap_or(DAffine3::IDENTITY) * block.map;
        let named = self.shared_meshes.named.get(&*block.of);
        let size = named.map_or(0, |s| {
            s.mesh().positions.len() + s.mesh().faces.corners.len()
        });
        self.spend(size as u64, place.source)?;
        let Some(shared) = self.shared_meshes.named.get_mut(&*block.of) else {
            let found = format!("an instance of `{}`", block.of);
            let expected = "the name of an `ext shared_mesh` before it";
            return Err(self.fail(place.source, found, expected));
        };
        let count = shared.mesh().positions.len();
        let Some(mut placed) = shared.placed(map) else {
            return Err(self.flattened(place.source));
        };
        let Some(light) = block.light(count) else {
            let expected = format!("as many as `{}` has vertices, {count}", block.of);
            return Err(self.fail(
                place.source,
                "another number of values of irradiance",
                &expected,
            ));
        };
        placed.light = light;
        self.push_object(&block.notes, Shape::Instance(placed))
    }

    fn flattened(&self, place: SourcePosition) -> BoxedError {
        self.fail(
            place,
            "an instance that a transform flattens, or that overflows",
            "an invertible transform",
        )
    }
}
