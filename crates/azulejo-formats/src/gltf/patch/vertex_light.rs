//! Puts the irradiance of vertices into a file, as colours of its vertices.

use super::super::irradiance::{self, StoredIrradiance};
use super::super::origin::ObjectOrigin;
use super::super::topology;
use super::additions::Additions;
use super::assign::{Assignment, assignments};
use super::error::PatchError;
use super::json::Json;
use super::mark;
use super::meshes::{drop_draco, place_mesh, uncompress};
use super::notes::Notes;
use super::primitives::{self, Primitive};
use super::source::Source;
use super::splits::{VertexGroup, turned};
use super::types::{
    Convention, InstanceMode, LightmapEdit, LightmapUvs, LightsMode, ObjectLayout, Output,
    PatchedFile,
};
use azulejo_scene::{Rgb, Scene};
use serde_json::json;
use std::collections::HashMap;

/// Puts the irradiance of the vertices of a scene into its file.
pub fn edited(
    source: &Source,
    origins: &[ObjectOrigin],
    scene: &Scene,
    output: Output,
    mut notes: Notes,
) -> Result<PatchedFile, PatchError> {
    let layouts = layouts(scene, origins).map_err(|fault| source.refused(fault))?;
    let edit = LightmapEdit {
        content: None,
        objects: &layouts,
        pages: &[],
        uvs: LightmapUvs::default(),
        instances: InstanceMode::Copy,
        convention: Convention::Plain,
        lights: LightsMode::Keep,
        mipmaps: false,
        output,
    };
    let meshes = primitives::of_meshes(&source.json);
    let mut additions = Additions::new(source, output.stem, "light");
    let scale = irradiance::scale(scene);
    for assignment in assignments(source, origins, &edit, &mut notes)? {
        let own = &meshes[assignment.mesh];
        let node = assignment.node;
        let fault = |fault| source.refused(format!("node {node}: {fault}"));
        let assignment = &assignment;
        let light = VertexLight {
            source,
            scene,
            scale,
            assignment,
            own,
        };
        let mesh = light.mesh(&mut additions, &mut notes).map_err(fault)?;
        if let Some(entry) = place_mesh(mesh, assignment.mesh, assignment.entry, &mut additions) {
            let node = additions.json.key("nodes").at(node);
            node.key("mesh").set(entry);
        }
    }
    drop_draco(&meshes, &mut additions.json);
    let facts = json!({ "convention": mark::OF_VERTICES });
    mark::finished(additions, facts.into(), notes)
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
            return Err(format!(
                "node {}: other faces than those of the file",
                origin.node
            ));
        }
        Ok(Some(ObjectLayout {
            uvs: vec![[[0.0; 2]; 3]; count],
            pages: vec![0; count],
        }))
    });
    layouts.collect()
}

/// The light of an object, and the mesh that gets it.
struct VertexLight<'v, 's> {
    source: &'v Source<'s>,
    scene: &'v Scene,
    /// Irradiance of a colour of 1.
    scale: f64,
    assignment: &'v Assignment<'v>,
    own: &'v [Primitive],
}

impl<'s> VertexLight<'_, 's> {
    /// The mesh with its light.
    fn mesh(&self, additions: &mut Additions<'s>, notes: &mut Notes) -> Result<Json<'s>, String> {
        let colours = self.colours()?;
        let stored = StoredIrradiance {
            set: self.set(),
            scale: self.scale,
        };
        let mesh = self.assignment.mesh;
        let mut json = self.source.json.entries("meshes")[mesh].clone();
        let mut extras = stored.extras(self.scene.units.photometric);
        let irradiance = extras["azulejo"]["irradiance"].take();
        for part in &self.assignment.parts {
            let own = &self.own[part.primitive];
            let primitive = json.key("primitives").at(part.primitive);
            mark::extra(primitive, "irradiance").set(irradiance.clone());
            let colours = &colours[&own.vertices];
            if let Err(fault) = self.give(primitive, own, colours, stored.set, additions, notes) {
                notes.add(&format!("primitive without its light: {fault}"));
            }
        }
        mark::extra(&mut json, "irradiance").set(irradiance);
        Ok(json)
    }

    /// The set of colours for the light: that of the light before, else the one after the colours.
    fn set(&self) -> u32 {
        let json = self.source.data.root.meshes.get(self.assignment.mesh);
        let before = json.and_then(irradiance::of).map(|stored| stored.set);
        let mut lit = self
            .assignment
            .parts
            .iter()
            .map(|part| &self.own[part.primitive]);
        let has_colours = lit.any(|own| own.attribute("COLOR_0").is_some());
        before.unwrap_or(u32::from(has_colours))
    }

    /// The colours of each list of vertices of the mesh.
    fn colours(&self) -> Result<HashMap<usize, Vec<[f32; 3]>>, String> {
        let object = &self.scene.objects[self.assignment.object];
        let placed = object
            .shape
            .placed_mesh()
            .ok_or("an object without a mesh")?;
        let mut lists = HashMap::new();
        let mut face = 0;
        for part in &self.assignment.parts {
            let own = self
                .own
                .get(part.primitive)
                .ok_or("a primitive out of range")?;
            let count = own.count(self.source)?;
            let corners = own.corners(self.source, count)?;
            let mode = own.mode.ok_or("faces of a primitive without triangles")?;
            let triangles = topology::triangles(mode, &corners);
            let list = lists
                .entry(own.vertices)
                .or_insert_with(|| vec![[0.0; 3]; count]);
            for origin in part.faces {
                let triangle = origin.triangle as usize;
                if triangle >= triangles.count() {
                    return Err("a triangle out of range".to_owned());
                }
                let order = turned(triangles.get(triangle), part.mirrored);
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
    fn give(
        &self,
        primitive: &mut Json<'s>,
        own: &Primitive,
        colours: &[[f32; 3]],
        set: u32,
        additions: &mut Additions<'s>,
        notes: &mut Notes,
    ) -> Result<(), String> {
        let name = format!("COLOR_{set}");
        let mut new = additions.copies(&VertexGroup::new(colours.len()), own, &name)?;
        // Names are numbered without gaps (glTF 2.0, 3.7.2.1).
        if set > 0 && own.attribute("COLOR_0").is_none() {
            let white = additions.vectors(colours.iter().map(|_| [1.0; 3]));
            new.attributes.push(("COLOR_0".to_owned(), white));
        }
        let colours = additions.vectors(colours.iter().copied());
        new.attributes.push((name, colours));
        if own.has_draco {
            let count = own.count(self.source)?;
            let corners = additions.corners(&own.corners(self.source, count)?, own.indices);
            primitive.key("indices").set(corners);
            uncompress(primitive, own, notes);
        }
        new.give(primitive);
        Ok(())
    }
}
