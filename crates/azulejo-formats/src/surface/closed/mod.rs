//! Solids as closed meshes of triangles, for printers: every edge has exactly two triangles, of opposite directions, no
//! triangle is without area, and coordinates are of single precision, as those who read them have it.
//!
//! | module | content |
//! |---|---|
//! | `shell` | the triangles of one solid: rounding, gaps of rounding, needles, edges of more than two faces |
//! | `apart` | what coincides in several places of a file, moved apart by the least |
//!
//! The polygons of a solid are a cycle: each edge is used as often in one direction as in the other. Whatever merges
//! vertices keeps that, so that rounding to single precision opens nothing. What it does is to make triangles without
//! area, and edges that several pairs of triangles share.

mod apart;
mod shell;

use super::single::spacing;
use super::tessellate::{chord_error, mesh_within};
use apart::Shells;
use azulejo_scene::math::Aabb;
use azulejo_scene::{Exact, Mesh, Object, Primitive, Scene, Shape, Solid};
use glam::DVec3;
use shell::Shell;
use std::borrow::Cow;
use std::io;

/// Most faces of the polygons of one solid.
const MOST_FACES: usize = 1 << 22;
/// Smallest chord error as a fraction of a solid's size: a few steps of single precision.
const FINEST: f64 = 1e-6;

/// The polygons of all objects: triangles that are closed where the object is solid, its own polygons otherwise.
///
/// `tolerance` is the chord error of exact shapes in scene units, > 0; without it a thousandth of the size of an
/// object's largest solid.
///
/// # Errors
/// `InvalidData` where a solid cannot be closed, with the object and what to do.
pub(crate) fn closed_meshes<'a>(
    scene: &'a Scene,
    tolerance: Option<f64>,
) -> io::Result<Vec<Cow<'a, Mesh>>> {
    let mut shells = Shells::default();
    let mut is_solid = vec![false; scene.objects.len()];
    for (k, object) in (0..).zip(&scene.objects) {
        let Some(exact) = solids_of(object) else {
            continue;
        };
        let refused = |what: String| {
            let message = format!("object \"{}\": {what}", object.name);
            io::Error::new(io::ErrorKind::InvalidData, message)
        };
        is_solid[k as usize] = true;
        let meshes = polygons(&exact, tolerance).map_err(refused)?;
        for (solid, mesh) in exact.solids.iter().zip(meshes) {
            let shell = closed_shell(&mesh, &solid.bounds()).map_err(refused)?;
            shells.add(k, shell);
        }
    }
    shells.move_apart();
    if let Some((object, what)) = shells.flaw() {
        let name = &scene.objects[object as usize].name;
        let message = format!("object \"{name}\": {what}");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    let closed = shells.meshes(scene.objects.len());
    let mut meshes = Vec::with_capacity(closed.len());
    for (k, (object, closed)) in scene.objects.iter().zip(closed).enumerate() {
        meshes.push(if is_solid[k] {
            Cow::Owned(closed.unwrap_or_default())
        } else {
            mesh_within(object, tolerance)
        });
    }
    Ok(meshes)
}

/// The objects that are not closed, by their names, with the number of edges that have an odd number of faces. Exact
/// solids are closed, whatever their polygons: writers see to that.
pub fn open_objects(scene: &Scene) -> Vec<(&str, usize)> {
    let open = |object| match solids_of(object) {
        Some(_) => 0,
        None => mesh_within(object, None).open_edges(),
    };
    let objects = scene.objects.iter().map(|o| (o.name.as_str(), open(o)));
    objects.filter(|(_, edges)| *edges > 0).collect()
}

/// The solids of an object that is made of nothing else; meshes are as they are.
fn solids_of(object: &Object) -> Option<Cow<'_, Exact>> {
    let exact = match &object.shape {
        Shape::Mesh(_) | Shape::Instance(_) => return None,
        Shape::Primitive(p) => Cow::Owned(Exact::new(vec![Solid::Primitive(without_light(p))])),
        Shape::Exact(exact) => Cow::Borrowed(exact),
    };
    let is_solid = |solid: &Solid| solid.open_part().is_none();
    exact.solids.iter().all(is_solid).then_some(exact)
}

fn without_light(primitive: &Primitive) -> Primitive {
    Primitive {
        light: None,
        ..primitive.clone()
    }
}

/// A mesh for each solid.
fn polygons(exact: &Exact, tolerance: Option<f64>) -> Result<Vec<Mesh>, String> {
    let sizes = exact.solids.iter().map(|s| s.bounds().diagonal());
    let largest = sizes.fold(0.0, f64::max);
    if let Some(tolerance) = tolerance.filter(|t| *t < FINEST * largest) {
        let least = FINEST * largest;
        return Err(format!(
            "found a tolerance of {tolerance:e}, expected at least {least:.1e}, a millionth of its size: coordinates \
             have single precision"
        ));
    }
    let error = tolerance.unwrap_or_else(|| chord_error(exact));
    exact.tessellate_each(error, MOST_FACES).ok_or_else(|| {
        format!(
            "found more than {MOST_FACES} polygons at a tolerance of {error:e}, expected a larger --tolerance"
        )
    })
}

/// The closed triangles of one solid.
fn closed_shell(mesh: &Mesh, bounds: &Aabb) -> Result<Shell, String> {
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    if reach > f64::from(f32::MAX) {
        return Err("coordinates beyond what numbers of 32 bits hold".to_owned());
    }
    let mut shell = Shell::new(mesh);
    // Set operations may leave gaps of their rounding.
    let open = shell.close(FINEST * bounds.diagonal() + 4.0 * spacing(reach));
    if open > 0 {
        return Err(format!(
            "found {open} open edges in the polygons of its solids, expected a closed surface; another --tolerance may \
             cut them elsewhere, and GRF keeps exact shapes"
        ));
    }
    shell.flip_needles();
    shell.split_vertices();
    Ok(shell)
}

/// A position in single precision, without negative zeros.
fn single(p: DVec3) -> DVec3 {
    DVec3::from_array(p.to_array().map(|x| f64::from(x as f32) + 0.0))
}

/// Distance between numbers of single precision around the largest of some coordinates.
fn coarseness(points: [DVec3; 3]) -> f64 {
    let reach = points.map(|p| p.abs().max_element());
    spacing(reach.into_iter().fold(0.0, f64::max))
}

/// The corner of a triangle that is opposite to its longest side, and its height over that.
fn height(points: [DVec3; 3]) -> (usize, f64) {
    let [a, b, c] = points;
    let sides = [c - b, a - c, b - a].map(DVec3::length);
    let longest = (1..3).fold(0, |k, n| if sides[n] > sides[k] { n } else { k });
    let area = (b - a).cross(c - a).length();
    let height = if sides[longest] > 0.0 {
        area / sides[longest]
    } else {
        0.0
    };
    (longest, height)
}
