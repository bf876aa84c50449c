//! Options by their names, as on the command line.

use crate::error::refused;
use azulejo::lightmap::{BakedLight, BakedSides};
use azulejo::spelling::unknown;
use azulejo_exchange::GroupBy;
use azulejo_factors::{Closure, Engine, Hemicube, PatchSize};
use azulejo_radiosity::StoredSides;
use azulejo_scene::Up;
use pyo3::prelude::*;

/// One of several values by its name.
fn choice<T: Clone>(what: &str, name: &str, known: &[(&str, T)]) -> PyResult<T> {
    let choice = known.iter().find(|(n, _)| *n == name);
    choice.map(|(_, value)| value.clone()).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(n, _)| *n).collect();
        refused(unknown(what, name, &names))
    })
}

/// The engine; hemicubes have a resolution and a number of points.
pub fn engine(name: &str, resolution: Option<u32>, points: Option<u32>) -> PyResult<Engine> {
    let default = Hemicube::default();
    let hemicube = Hemicube {
        resolution: resolution.unwrap_or(default.resolution),
        points: points.unwrap_or(default.points),
        device: default.device,
    };
    let known = [
        ("auto", Engine::Auto),
        ("rays", Engine::Rays),
        ("hemicube", Engine::Hemicube(hemicube.clone())),
        ("hybrid", Engine::Hybrid(hemicube)),
        ("analytic", Engine::Analytic),
        ("particles", Engine::Particles),
    ];
    let engine = choice("engine", name, &known)?;
    let has_hemicubes = matches!(engine, Engine::Hemicube(_) | Engine::Hybrid(_));
    for (option, value) in [("resolution", resolution), ("patch_points", points)] {
        if value.is_some() && !has_hemicubes {
            return Err(refused(format_args!(
                "{option} applies only to the engines hemicube and hybrid"
            )));
        }
    }
    Ok(engine)
}

/// How finely faces are divided, if that is said.
pub fn patch_size(patches: Option<usize>, edge: Option<f64>) -> Option<PatchSize> {
    let count = patches.map(PatchSize::Count);
    count.or(edge.map(PatchSize::Edge))
}

/// When closure is enforced.
pub fn closure(name: &str) -> PyResult<Closure> {
    let known = [
        ("never", Closure::Never),
        ("closed", Closure::Closed),
        ("always", Closure::Always),
    ];
    choice("closure", name, &known)
}

/// What the rows of a group have in common; `None` for patches.
pub fn group_by(name: &str) -> PyResult<Option<GroupBy>> {
    let known = [
        ("patch", None),
        ("face", Some(GroupBy::Face)),
        ("object", Some(GroupBy::Object)),
        ("material", Some(GroupBy::Material)),
    ];
    choice("group", name, &known)
}

/// What rows are nodes together; `None` for each by itself.
pub fn node(name: &str) -> PyResult<Option<GroupBy>> {
    let known = [
        ("row", None),
        ("face", Some(GroupBy::Face)),
        ("object", Some(GroupBy::Object)),
        ("material", Some(GroupBy::Material)),
    ];
    choice("node", name, &known)
}

/// Which side's irradiance surfaces store.
pub fn sides(name: &str) -> PyResult<StoredSides> {
    let known = [
        ("auto", StoredSides::BySurface),
        ("front", StoredSides::Front),
        ("brighter", StoredSides::Brighter),
        ("split", StoredSides::Split),
        ("unturned", StoredSides::Unturned),
    ];
    choice("sides", name, &known)
}

/// Which light a lightmap holds.
pub fn baked_light(name: &str) -> PyResult<BakedLight> {
    let known = [
        ("total", BakedLight::Total),
        ("indirect", BakedLight::Indirect),
        ("direct", BakedLight::Direct),
    ];
    choice("light", name, &known)
}

/// Which side of surfaces a lightmap has.
pub fn baked_sides(name: &str) -> PyResult<BakedSides> {
    let known = [
        ("front", BakedSides::Front),
        ("brighter", BakedSides::Brighter),
        ("split", BakedSides::Both),
    ];
    choice("sides", name, &known)
}

/// The axis that points away from the ground.
pub fn up(name: &str) -> PyResult<Up> {
    choice("up axis", name, &[("y", Up::Y), ("z", Up::Z)])
}
