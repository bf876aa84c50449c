//! Puts the irradiance of vertices into a file, as colours of its vertices.

use super::super::irradiance::{self, StoredIrradiance};
use super::super::origin::ObjectOrigin;
use super::super::topology;
use super::accessors::NewAccessors;
use super::additions::Additions;
use super::assign::{Assignment, Entry, assignments};
use super::edits::Edit;
use super::error::PatchError;
use super::glb::Parts;
use super::notes::Notes;
use super::primitives::PrimitiveJson;
use super::scan::{Span, member};
use super::source::{Source, parsed};
use super::splits::VertexGroup;
use super::types::{
    Convention, GltfFile, InstanceMode, LightmapEdit, LightmapUvs, LightsMode, ObjectLayout,
    Output, PatchedFile,
};
use super::{uncompress, undo};
use azulejo_scene::{Rgb, Scene};
use serde_json::{Map, json};
use std::collections::{HashMap, HashSet};

/// Puts the irradiance of the vertices of a scene into its file.
pub fn edited(
    file: &GltfFile,
    origins: &[ObjectOrigin],
    scene: &Scene,
    output: Output,
    mut notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let parts = Parts::of(file.bytes, file.name)?;
    let root = parsed(&parts, file)?;
    let source = Source::new(parts, &root, file);
    let layouts = layouts(scene, origins).map_err(|fault| source.refused(fault))?;
    let edit = LightmapEdit {
        objects: &layouts,
        pages: &[],
        uvs: LightmapUvs::default(),
        instances: InstanceMode::Copy,
        convention: Convention::Plain,
        lights: LightsMode::Keep,
        mipmaps: false,
        output,
    };
    let assignments = assignments(&source, origins, &edit, &mut notes)?;
    let left = file.options.most_unpacked;
    let mut additions = Additions::new(&source, output.stem, "light", left);
    let spans = source.list("meshes");
    let meshes = spans
        .iter()
        .map(|span| PrimitiveJson::of_mesh(source.text(), span));
    let meshes: Vec<Vec<PrimitiveJson>> = meshes.collect();
    let work = VertexLight {
        accessors: NewAccessors::new(&source),
        source: &source,
        scene,
        scale: irradiance::scale(scene),
    };
    let mut uncompressed = HashSet::new();
    for assignment in &assignments {
        let mesh = assignment.mesh;
        let lit = work.assignment(
            assignment,
            &spans[mesh],
            &meshes[mesh],
            &mut additions,
            &mut notes,
        )?;
        if assignment.entry == Entry::Own {
            uncompressed.extend(lit.into_iter().map(|primitive| (mesh, primitive)));
        }
    }
    uncompress::lists(&source, &meshes, &uncompressed, &mut additions);
    if undo::found(&source.parts).is_some() {
        // What undoes the edit before is lost: its text is no longer what it was.
        return undo::unsealed(&source, additions, notes);
    }
    let mut facts = Map::new();
    facts.insert("convention".into(), json!(undo::OF_VERTICES));
    undo::sealed(&source, additions, facts, notes)
}

/// A place for every face of the objects that have light: their vertices stay as they are.
fn layouts(scene: &Scene, origins: &[ObjectOrigin]) -> Result<Vec<Option<ObjectLayout>>, String> {
    if scene.objects.len() != origins.len() {
        let (objects, origins) = (scene.objects.len(), origins.len());
        return Err(format!(
            "a scene of {objects} objects, of which {origins} are the file's"
        ));
    }
    let objects = scene.objects.iter().zip(origins);
    let layouts = objects.map(|(object, origin)| {
        let placed = object.shape.placed_mesh();
        let Some(placed) = placed.filter(|placed| !placed.irradiance.is_empty()) else {
            return Ok(None);
        };
        let count = placed.mesh.faces.len();
        let are_triangles = placed.mesh.faces.corners.len() == 3 * count;
        if count != origin.faces.len() || !are_triangles {
            let node = origin.node;
            return Err(format!("node {node}: other faces than those of the file"));
        }
        Ok(Some(ObjectLayout {
            uvs: vec![[[0.0; 2]; 3]; count],
            pages: vec![0; count],
        }))
    });
    layouts.collect()
}

/// Colours of the vertices of primitives with these attributes.
type Colours<'t> = HashMap<(&'t str, &'t str), Vec<[f32; 3]>>;

/// The light of a scene, and the file that it goes into.
struct VertexLight<'v, 's> {
    source: &'v Source<'s>,
    accessors: NewAccessors<'v>,
    scene: &'v Scene,
    /// Irradiance of a colour of 1.
    scale: f64,
}

impl VertexLight<'_, '_> {
    /// Gives the mesh of an object its light, and returns the primitives that have it.
    fn assignment(
        &self,
        assignment: &Assignment,
        span: &Span,
        mesh: &[PrimitiveJson],
        additions: &mut Additions,
        notes: &mut Notes,
    ) -> Result<Vec<usize>, PatchError> {
        let text = self.source.text();
        let colours = self.colours(assignment, mesh);
        let colours = colours.map_err(|fault| {
            let node = assignment.node;
            self.source.refused(format!("node {node}: {fault}"))
        })?;
        let stored = StoredIrradiance {
            set: self.set(assignment, mesh),
            scale: self.scale,
        };
        let mut edit = Edit::default();
        let mut lit = Vec::new();
        for part in &assignment.parts {
            let json = &mesh[part.primitive];
            let change = edit.key("primitives").index(part.primitive);
            match self.primitive(json, &colours[&json.key], stored.set, change, additions)? {
                Ok(()) => lit.push(part.primitive),
                Err(fault) => notes.add(&format!("primitive without its light: {fault}")),
            }
            if json.has_draco() {
                notes.add("primitive compressed with Draco: is no longer");
            }
        }
        let extras = stored.extras(self.scene.units.photometric);
        let extras = extras["azulejo"]["irradiance"].to_string();
        let old = member(text, span, "extras");
        undo::add_extra(text, old, "irradiance", &extras, edit.key("extras"));
        if assignment.entry == Entry::Own {
            *additions.edit.key("meshes").index(assignment.mesh) = edit;
        } else {
            let entry = additions.append("meshes", edit.applied(text, span));
            let node = additions.edit.key("nodes").index(assignment.node);
            node.key("mesh").set(entry.to_string());
        }
        Ok(lit)
    }

    /// The set of colours for the light: that of the light before, else the one after the colours.
    fn set(&self, assignment: &Assignment, mesh: &[PrimitiveJson]) -> u32 {
        let json = self.source.data.root.meshes.get(assignment.mesh);
        let before = json.and_then(irradiance::of).map(|stored| stored.set);
        let parts = &assignment.parts;
        let mut lit = parts.iter().map(|part| &mesh[part.primitive]);
        let has_colours = lit.any(|json| json.attribute("COLOR_0").is_some());
        before.unwrap_or(u32::from(has_colours))
    }

    /// The colours of each list of vertices of a mesh.
    fn colours<'t>(
        &self,
        assignment: &Assignment,
        mesh: &[PrimitiveJson<'t>],
    ) -> Result<Colours<'t>, String> {
        let object = &self.scene.objects[assignment.object];
        let placed = object
            .shape
            .placed_mesh()
            .ok_or("an object without a mesh")?;
        let mut lists = Colours::new();
        let mut face = 0;
        for part in &assignment.parts {
            let json = mesh.get(part.primitive).ok_or("a primitive out of range")?;
            let count = json.count(self.source)?;
            let corners = json.corners(self.source, count)?;
            let mode = json.mode.ok_or("faces of a primitive without triangles")?;
            let all = topology::triangles(mode, &corners);
            let list = lists
                .entry(json.key)
                .or_insert_with(|| vec![[0.0; 3]; count]);
            for origin in part.faces {
                let triangle = origin.triangle as usize;
                if triangle >= all.count() {
                    return Err("a triangle out of range".to_owned());
                }
                let [a, b, c] = all.get(triangle);
                let order = if part.mirrored { [a, c, b] } else { [a, b, c] };
                for (vertex, own) in order.iter().zip(placed.mesh.faces.get(face)) {
                    let light = placed.irradiance.get(*own as usize);
                    let slot = list.get_mut(*vertex as usize);
                    let (slot, light) = slot.zip(light).ok_or("a vertex out of range")?;
                    *slot = self.share(*light);
                }
                face += 1;
            }
        }
        Ok(lists)
    }

    /// Light as a colour.
    fn share(&self, light: Rgb) -> [f32; 3] {
        (light * (1.0 / self.scale)).to_array().map(|c| c as f32)
    }

    /// Gives a primitive its colours; a fault leaves it as it is.
    fn primitive(
        &self,
        json: &PrimitiveJson,
        colours: &[[f32; 3]],
        set: u32,
        change: &mut Edit,
        additions: &mut Additions,
    ) -> Result<Result<(), String>, PatchError> {
        let name = format!("COLOR_{set}");
        let group = VertexGroup::new(colours.len());
        let copies = match self.accessors.copies(&group, json, &name, additions)? {
            Ok(copies) => copies,
            Err(fault) => return Ok(Err(fault)),
        };
        if json.has_draco() {
            let corners = match json.corners(self.source, colours.len()) {
                Ok(corners) => corners,
                Err(fault) => return Ok(Err(fault)),
            };
            let corners = self.accessors.corners(&corners, json.indices, additions)?;
            change.key("indices").set(corners.to_string());
            uncompress::primitive(change, json);
        }
        for (name, accessor) in &copies.attributes {
            change.key("attributes").key(name).set(accessor.to_string());
        }
        for (target, name, accessor) in &copies.targets {
            let target = change.key("targets").index(*target);
            target.key(name).set(accessor.to_string());
        }
        // Names are numbered without gaps (glTF 2.0, 3.7.2.1).
        if set > 0 && json.attribute("COLOR_0").is_none() {
            let white = vec![[1.0; 3]; colours.len()];
            let white = self.accessors.attribute(&white, additions)?;
            change
                .key("attributes")
                .key("COLOR_0")
                .set(white.to_string());
        }
        let accessor = self.accessors.attribute(colours, additions)?;
        change
            .key("attributes")
            .key(&name)
            .set(accessor.to_string());
        Ok(Ok(()))
    }
}
