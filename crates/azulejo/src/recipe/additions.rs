//! What a recipe adds: lights, cameras, background and fog.

use super::RecipeError;
use super::tables::{CameraTable, LightTable, RecipeSource, RecipeTables};
use crate::luminaire::{PlacedLuminaire, flux};
use azulejo_scene::{Camera, Fog, Light, LightKind, Scene, SceneBackground};
use glam::DVec3;

/// Adds lights, cameras, background and fog.
pub(super) fn add(
    recipe: &RecipeTables,
    scene: &mut Scene,
    source: &RecipeSource,
) -> Result<(), RecipeError> {
    for table in &recipe.light {
        let (table, at) = (table.get_ref(), table.span().start);
        match table.kind.as_str() {
            "luminaire" => {
                let lights = luminaire(table, at, scene, source)?;
                scene.lights.extend(lights);
            }
            _ => scene.lights.push(light(table, at, scene, source)?),
        }
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

/// The lights of a photometric file.
fn luminaire(
    table: &LightTable,
    at: usize,
    scene: &Scene,
    source: &RecipeSource,
) -> Result<Vec<Light>, RecipeError> {
    let wrong = |message: &str| source.wrong(at, message);
    let file = table.file.as_ref();
    let file = file.ok_or_else(|| wrong("a luminaire needs a `file`, IES or EULUMDAT"))?;
    let position = table.position;
    let position = position.ok_or_else(|| wrong("this light needs a `position`"))?;
    if table.intensity.is_some() || table.direction.is_some() {
        return Err(wrong(
            "a luminaire has `lumens`, `tilt`, `rotation` and `spin`, and neither `intensity` nor `direction`",
        ));
    }
    let placed = PlacedLuminaire {
        position: position.into(),
        tilt: table.tilt,
        rotation: table.rotation,
        spin: table.spin,
        lumens: table.lumens,
        temperature: table.temperature,
        lamp_set: table.lamp_set,
        // Beside the recipe, if it is not elsewhere.
        ..PlacedLuminaire::of(source.beside(file))
    };
    let lights = placed.lights(scene.units);
    let mut lights = lights.map_err(|e| source.wrong(at, e))?;
    if !table.name.is_empty() {
        lights
            .iter_mut()
            .for_each(|light| light.name.clone_from(&table.name));
    }
    Ok(lights)
}

fn light(
    table: &LightTable,
    at: usize,
    scene: &Scene,
    source: &RecipeSource,
) -> Result<Light, RecipeError> {
    let wrong = |message: &str| source.wrong(at, message);
    // A light that shines alike in all directions spreads its lumens over 4π sr.
    let intensity = match (&table.intensity, table.lumens) {
        (Some(color), None) => source.light(color)?,
        (None, Some(lumens)) => {
            let flux = flux(lumens, table.temperature, scene.units.photometric);
            let flux = flux.ok_or_else(|| wrong("lumens and temperature must be above 0"))?;
            flux / (4.0 * std::f64::consts::PI)
        }
        _ => return Err(wrong("a light has either `intensity` or `lumens`")),
    };
    // Read direction and position on demand: only kinds of lights that need them miss them.
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
        _ => {
            return Err(wrong(
                "kind: expected point, spot, directional or luminaire",
            ));
        }
    };
    Ok(Light {
        name: table.name.clone(),
        kind,
    })
}
