//! Rules for materials and objects, carried out.

use super::RecipeError;
use super::surface::SurfaceRule;
use azulejo_scene::{MaterialId, Mesh, Object, Scene, Shape};
use std::collections::HashMap;
use std::sync::Arc;

/// Changes the materials that a rule matches; returns their number.
pub(super) fn change_materials(rule: &SurfaceRule<'_>, scene: &mut Scene) -> usize {
    let matched = scene.materials.iter_mut().filter(|m| rule.matches(&m.name));
    matched.map(|material| rule.change(material)).count()
}

/// Gives the objects that a rule matches changed copies of their materials; returns their number.
pub(super) fn change_objects(
    rule: &SurfaceRule<'_>,
    scene: &mut Scene,
) -> Result<usize, RecipeError> {
    let mut copies: HashMap<MaterialId, MaterialId> = HashMap::new();
    // The shared meshes that have been changed, before and after; the old ones are kept, so that no
    // other gets the address of one.
    let mut renumbered: HashMap<*const Mesh, (Arc<Mesh>, Arc<Mesh>)> = HashMap::new();
    let mut matched = 0;
    let photometric = scene.units.photometric;
    let Scene {
        objects, materials, ..
    } = scene;
    for object in objects.iter_mut().filter(|o| rule.matches(&o.name)) {
        matched += 1;
        let radiance = rule.radiance(area(object), photometric)?;
        if radiance.is_some() {
            // Each lamp has a radiance of its own, by its area.
            copies.clear();
            renumbered.clear();
        }
        let mut copy = |id: MaterialId| {
            *copies.entry(id).or_insert_with(|| {
                let mut material = materials[id as usize].clone();
                rule.change(&mut material);
                material.emission = radiance.unwrap_or(material.emission);
                materials.push(material);
                materials.len() as MaterialId - 1
            })
        };
        match &mut object.shape {
            Shape::Mesh(mesh) => mesh.face_materials.iter_mut().for_each(|m| *m = copy(*m)),
            Shape::Instance(instance) => {
                let old = instance.mesh.clone();
                let new = renumbered.entry(Arc::as_ptr(&old)).or_insert_with(|| {
                    let mut mesh = Mesh::clone(&old);
                    mesh.face_materials.iter_mut().for_each(|m| *m = copy(*m));
                    (old, Arc::new(mesh))
                });
                instance.mesh = new.1.clone();
            }
            Shape::Primitive(p) => p.material = copy(p.material),
            Shape::Exact(_) => {
                return Err(RecipeError::Content(rule.place(&format!(
                    "the object \"{}\" is a solid, whose materials only a rule for materials can \
                     change",
                    object.name
                ))));
            }
        }
    }
    Ok(matched)
}

/// Area of an object, square scene units.
fn area(object: &Object) -> f64 {
    match &object.shape {
        Shape::Primitive(p) => p.area(),
        shape => shape.placed_mesh().map_or(0.0, |mesh| mesh.area()),
    }
}
