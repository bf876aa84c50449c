//! Converts drawings to a scene: every INSERT becomes a copy of its block.

use super::color::{Color, FOREGROUND, Paint};
use super::drawing::{Appearance, DxfBlock, DxfDrawing, Finish, Insert, Layer};
use super::finish::material;
use super::ids::{AppearanceId, LayerId};
use super::light::transformed;
use super::project::{Node, Project};
use super::surfaces::LayerMesh;
use crate::reading::text::shortened;
use crate::reading::warnings::Warnings;
use crate::surface::materials::Materials;
use azulejo_scene::{MaterialId, Mesh, MeshInstance, Object, Scene, Shape, SharedMesh};
use glam::DAffine3;
use std::collections::HashMap;

/// Longest path of blocks in an object's name, in bytes; names of deeper blocks are left out.
pub(super) const LONGEST_PATH: usize = 1000;

/// Instantiates all blocks.
pub(super) fn instantiate(mut project: Project, warnings: &mut Warnings) -> Scene {
    // The drawing's own surfaces are instantiated only once, so they need not be copied.
    let surfaces = std::mem::take(&mut project.root_mut().surfaces);
    let mut placer = Placer {
        project: &project,
        scene: Scene::default(),
        materials: Materials::default(),
        shared: HashMap::new(),
        warnings,
    };
    let context = Context::default();
    let drawing = &project.drawings[0];
    for LayerMesh { layer, mesh, .. } in surfaces.meshes {
        if let Some(layer) = placer.shown(drawing, layer, &context) {
            placer.add_mesh(drawing, mesh, layer, &context);
        }
    }
    placer.add_contents(Node::ROOT, &DAffine3::IDENTITY, &context);
    let Placer {
        mut scene,
        materials,
        shared,
        ..
    } = placer;
    drop(shared);
    scene.unfold_single_instances();
    scene.materials = materials.into_list();
    scene
}

/// What a block inherits from its INSERT.
#[derive(Clone, Debug)]
struct Context<'a> {
    /// Names of the enclosing blocks, joined by `/`.
    path: String,
    /// The layer that replaces layer 0; none for the drawing itself.
    layer: Option<EffectiveLayer<'a>>,
    /// The colour of entities with colour by block.
    paint: Paint,
    /// The MATERIAL of entities with material by block.
    finish: Option<&'a Finish>,
}

impl Default for Context<'_> {
    fn default() -> Self {
        Context {
            path: String::new(),
            layer: None,
            paint: FOREGROUND,
            finish: None,
        }
    }
}

/// A layer, possibly of another drawing, with its MATERIAL.
#[derive(Clone, Copy, Debug)]
struct EffectiveLayer<'a> {
    layer: &'a Layer,
    finish: Option<&'a Finish>,
}

/// An appearance with the inherited properties of its context.
struct Resolved<'a> {
    plane: EffectiveLayer<'a>,
    paint: Paint,
    finish: Option<&'a Finish>,
}

struct Placer<'a, 'w> {
    project: &'a Project,
    scene: Scene,
    materials: Materials,
    /// The meshes of blocks, by their address and what their appearances are under the INSERT.
    shared: HashMap<(*const Mesh, Vec<MaterialId>), SharedMesh>,
    warnings: &'w mut Warnings,
}

impl<'a> Placer<'a, '_> {
    /// Adds a block's lights and its inserted blocks.
    fn add_contents(&mut self, node: Node, map: &DAffine3, context: &Context<'a>) {
        let (drawing, block) = self.project.get(node);
        for (layer, light) in &block.lights {
            if self.shown(drawing, *layer, context).is_some() {
                self.scene.lights.extend(transformed(light, map));
            }
        }
        for insert in &block.inserts {
            self.add_insert(node, insert, map, context);
        }
    }

    fn add_insert(&mut self, node: Node, insert: &Insert, map: &DAffine3, context: &Context<'a>) {
        let (drawing, _) = self.project.get(node);
        let Some(target) = self.project.target(node, insert) else {
            return;
        };
        let appearance = self.resolved(drawing, insert.appearance, context);
        let layer = appearance.plane.layer;
        if layer.is_frozen {
            return self.note_hidden(layer);
        }
        let block = self.project.get(target).1;
        // The name and the base point of an external reference are those of its block here.
        let outer = &drawing.blocks[insert.block as usize];
        let inner = Context {
            path: joined(&context.path, &outer.name),
            layer: Some(appearance.plane),
            paint: appearance.paint,
            finish: appearance.finish,
        };
        let base = insert.matrix * outer.base;
        for row in 0..insert.rows {
            for column in 0..insert.columns {
                let step =
                    f64::from(column) * insert.column_step + f64::from(row) * insert.row_step;
                let local =
                    DAffine3::from_mat3_translation(insert.matrix, insert.origin + step - base);
                self.add_block(target, block, &(*map * local), &inner);
            }
        }
    }

    fn add_block(&mut self, node: Node, block: &DxfBlock, map: &DAffine3, context: &Context<'a>) {
        let drawing = self.project.get(node).0;
        for LayerMesh { layer, mesh, .. } in &block.surfaces.meshes {
            if let Some(layer) = self.shown(drawing, *layer, context) {
                self.add_instance(drawing, mesh, map, layer, context);
            }
        }
        self.add_contents(node, map, context);
    }

    /// Adds a mesh of a block, which INSERTs of the same appearance share.
    fn add_instance(
        &mut self,
        drawing: &'a DxfDrawing,
        mesh: &Mesh,
        map: &DAffine3,
        layer: &'a Layer,
        context: &Context<'a>,
    ) {
        let mut used: Vec<AppearanceId> = mesh.face_materials.clone();
        used.dedup();
        let materials: HashMap<AppearanceId, MaterialId> = used
            .iter()
            .map(|&a| (a, self.material(drawing, a, context)))
            .collect();
        let of_runs = used.iter().map(|a| materials[a]).collect();
        let key = (std::ptr::from_ref(mesh), of_runs);
        let shared = self.shared.entry(key).or_insert_with(|| {
            let mut mesh = mesh.clone();
            let slots = mesh.face_materials.iter_mut();
            slots.for_each(|slot| *slot = materials[slot]);
            SharedMesh::new(mesh)
        });
        match shared.placed(*map).filter(MeshInstance::is_finite) {
            Some(placed) => {
                let name = joined(&context.path, &layer.name);
                let shape = Shape::Instance(placed);
                self.scene.objects.push(Object::new(name, shape));
            }
            // A map that flattens, or one that overflows.
            None => {
                let mut mesh = mesh.clone();
                mesh.transform(map);
                self.add_mesh(drawing, mesh, layer, context);
            }
        }
    }

    /// Adds a transformed mesh.
    fn add_mesh(
        &mut self,
        drawing: &'a DxfDrawing,
        mut mesh: Mesh,
        layer: &'a Layer,
        context: &Context<'a>,
    ) {
        if mesh.faces.is_empty() {
            return;
        }
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            let message = "surfaces whose coordinates overflow, by nested scales: left out";
            return self.warnings.add_whole(&drawing.file, message);
        }
        let mut known: HashMap<AppearanceId, MaterialId> = HashMap::new();
        let mut last = (AppearanceId::MAX, 0);
        for slot in &mut mesh.face_materials {
            if last.0 != *slot {
                let id = *known
                    .entry(*slot)
                    .or_insert_with(|| self.material(drawing, *slot, context));
                last = (*slot, id);
            }
            *slot = last.1;
        }
        let name = joined(&context.path, &layer.name);
        self.scene
            .objects
            .push(Object::new(name, Shape::Mesh(mesh)));
    }

    fn material(
        &mut self,
        drawing: &'a DxfDrawing,
        appearance: AppearanceId,
        context: &Context<'a>,
    ) -> MaterialId {
        let Resolved {
            plane,
            paint,
            finish,
        } = self.resolved(drawing, appearance, context);
        let layer = plane.layer;
        self.materials
            .index(material(&layer.name, layer.paint, paint, finish))
    }

    /// An appearance with everything that it inherits from its layer and its INSERT.
    fn resolved(
        &self,
        drawing: &'a DxfDrawing,
        appearance: AppearanceId,
        context: &Context<'a>,
    ) -> Resolved<'a> {
        let Appearance {
            layer,
            color,
            finish,
        } = drawing.appearances[appearance as usize];
        let plane = layer_in(drawing, layer, context);
        let paint = match color {
            Color::ByLayer => plane.layer.paint,
            Color::ByBlock => context.paint,
            Color::Own(paint) => paint,
        };
        let finish = match drawing.finishes.get(&finish) {
            None | Some(Finish::ByLayer) => plane.finish,
            Some(Finish::ByBlock) => context.finish,
            own => own,
        };
        Resolved {
            plane,
            paint,
            finish,
        }
    }

    /// The layer of an entity in a block, if it is visible.
    fn shown(
        &mut self,
        drawing: &'a DxfDrawing,
        id: LayerId,
        context: &Context<'a>,
    ) -> Option<&'a Layer> {
        let layer = layer_in(drawing, id, context).layer;
        if layer.is_off || layer.is_frozen {
            self.note_hidden(layer);
            return None;
        }
        Some(layer)
    }

    fn note_hidden(&mut self, layer: &Layer) {
        let name = shortened(&layer.name);
        let message = format!("layer \"{name}\" is off or frozen: its content is left out");
        self.warnings
            .add_whole(&self.project.drawings[0].file, message);
    }
}

/// The layer of an entity in a block: layer 0 becomes that of the INSERT.
fn layer_in<'a>(drawing: &'a DxfDrawing, id: LayerId, context: &Context<'a>) -> EffectiveLayer<'a> {
    let layer = &drawing.layers[id as usize];
    match context.layer {
        Some(outer) if layer.is_zero() => outer,
        _ => EffectiveLayer {
            layer,
            finish: drawing.finishes.get(&layer.finish),
        },
    }
}

/// A path with a name appended, unless one of them is empty or it becomes too long.
fn joined(path: &str, name: &str) -> String {
    match (path, name) {
        ("", name) => name.to_owned(),
        (path, "") => path.to_owned(),
        _ if path.len() + name.len() > LONGEST_PATH => path.to_owned(),
        _ => format!("{path}/{name}"),
    }
}
