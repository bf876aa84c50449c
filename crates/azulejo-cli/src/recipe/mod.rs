//! `--recipe`: what a file of rules adds to a model, each time the model is read.

mod surface;
mod tables;

use super::failure::Failure;
use super::session::Session;
use azulejo_scene::{
    Camera, Fog, Light, LightKind, MaterialId, Mesh, Object, Rgb, Scene, SceneBackground, Shape,
};
use glam::DVec3;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use surface::{RuleTarget, SurfaceRule};
use tables::{CameraTable, LightTable, RecipeSource, RecipeTables};

/// Applies a recipe to a scene; rules that match nothing are reported, or refused if `is_strict`.
pub fn apply(
    path: &Path,
    scene: &mut Scene,
    is_strict: bool,
    session: &mut Session,
) -> Result<(), Failure> {
    let (recipe, source) = RecipeSource::read(path)?;
    let mut unmatched = Vec::new();
    // Materials first: what objects get is a copy of what materials have become.
    for (tables, target) in [
        (&recipe.material, RuleTarget::Material),
        (&recipe.object, RuleTarget::Object),
    ] {
        for table in tables {
            let rule = SurfaceRule::new(table, target, &source)?;
            let matched = match target {
                RuleTarget::Material => change_materials(&rule, scene),
                RuleTarget::Object => change_objects(&rule, scene)?,
            };
            if matched == 0 {
                unmatched.push(rule.place(&format!(
                    "the rule {} matches no {}",
                    rule.words,
                    target.word()
                )));
            }
        }
    }
    add(&recipe, scene, &source)?;
    for id in 0..scene.materials.len() {
        let material = &mut scene.materials[id];
        if !material.limit_reflectance() {
            let name = material.name.clone();
            session.note(&format!(
                "{}: the material \"{name}\" would reflect more than arrives: scaled down",
                path.display()
            ));
        }
    }
    scene.validate().map_err(|invalid| {
        Failure::failed(format_args!(
            "{}: no valid scene: {invalid}",
            path.display()
        ))
    })?;
    match unmatched.first() {
        Some(first) if is_strict => Err(Failure::failed(first)),
        _ => {
            unmatched.iter().for_each(|words| session.note(words));
            Ok(())
        }
    }
}

/// Changes the materials that a rule matches; returns their number.
fn change_materials(rule: &SurfaceRule<'_>, scene: &mut Scene) -> usize {
    let matched = scene.materials.iter_mut().filter(|m| rule.matches(&m.name));
    matched.map(|material| rule.change(material)).count()
}

/// Gives the objects that a rule matches changed copies of their materials; returns their number.
fn change_objects(rule: &SurfaceRule<'_>, scene: &mut Scene) -> Result<usize, Failure> {
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
                return Err(Failure::failed(rule.place(&format!(
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

/// Adds lights, cameras, background and fog.
fn add(recipe: &RecipeTables, scene: &mut Scene, source: &RecipeSource) -> Result<(), Failure> {
    for table in &recipe.light {
        scene
            .lights
            .push(light(table.get_ref(), table.span().start, scene, source)?);
    }
    for table in &recipe.camera {
        let camera = camera(table.get_ref());
        let (right, up, forward) = camera.axes();
        let is_view = camera.eye.is_finite()
            && [right, up, forward].iter().all(|v| v.is_finite())
            && camera.vertical_fov > 0.0
            && camera.vertical_fov < std::f64::consts::PI;
        if !is_view {
            let message = "a camera that sees nothing: eye, target and up on one line, or a fov \
                           outside 0 to 180";
            return Err(source.wrong(table.span().start, message));
        }
        scene.cameras.push(camera);
    }
    if let Some(color) = &recipe.background {
        scene.background = Some(SceneBackground::Color(source.light(color)?));
    }
    if let Some(fog) = &recipe.fog {
        let table = fog.get_ref();
        if !(table.visibility > 0.0 && table.visibility.is_finite()) {
            return Err(source.wrong(fog.span().start, "visibility must be above 0"));
        }
        scene.fog = Some(Fog {
            color: source.light(&table.color)?,
            visibility: table.visibility,
            exponential: table.exponential,
        });
    }
    Ok(())
}

fn camera(table: &CameraTable) -> Camera {
    Camera {
        name: table.name.clone(),
        eye: DVec3::from_array(table.eye),
        target: DVec3::from_array(table.target),
        up: DVec3::from_array(table.up),
        vertical_fov: table.fov.to_radians(),
        size: table
            .size
            .map(|[width, height]| (width.max(1), height.max(1))),
    }
}

fn light(
    table: &LightTable,
    at: usize,
    scene: &Scene,
    source: &RecipeSource,
) -> Result<Light, Failure> {
    let wrong = |message: &str| source.wrong(at, message);
    let intensity = match (&table.intensity, table.lumens) {
        (Some(color), None) => source.light(color)?,
        (None, Some(lumens)) => {
            let flux = surface::flux(lumens, table.temperature, scene.units.photometric);
            let flux = flux.ok_or_else(|| wrong("lumens and temperature must be above 0"))?;
            flux / (4.0 * std::f64::consts::PI)
        }
        _ => return Err(wrong("a light has either `intensity` or `lumens`")),
    };
    let direction = || {
        let given = table.direction.map(DVec3::from_array);
        let unit = given.and_then(DVec3::try_normalize);
        unit.ok_or_else(|| wrong("this light needs a `direction` other than 0"))
    };
    let position = || {
        let given = table.position.map(DVec3::from_array);
        given.ok_or_else(|| wrong("this light needs a `position`"))
    };
    let kind = match &*table.kind {
        "point" => LightKind::Point {
            position: position()?,
            intensity,
        },
        "directional" if table.lumens.is_none() => LightKind::Directional {
            direction: direction()?,
            irradiance: intensity,
            half_angle: 0.0,
        },
        "spot" if table.lumens.is_none() => {
            let [inner, outer] = [table.inner, table.outer];
            if !(0.0 <= inner && inner <= outer && outer <= 180.0 && outer > 0.0) {
                return Err(wrong(
                    "angles of a spot: 0 <= inner <= outer <= 180 degrees",
                ));
            }
            LightKind::Spot {
                position: position()?,
                direction: direction()?,
                intensity,
                inner: inner.to_radians(),
                outer: outer.to_radians(),
            }
        }
        "spot" | "directional" => {
            return Err(wrong(
                "`lumens` is for point lights and objects; give `intensity`",
            ));
        }
        _ => return Err(wrong("kind: expected point, spot or directional")),
    };
    Ok(Light {
        name: table.name.clone(),
        kind,
    })
}

/// Whether a colour can be light: finite, nothing negative.
fn is_light(color: Rgb) -> bool {
    color.to_array().iter().all(|x| *x >= 0.0 && x.is_finite())
}
