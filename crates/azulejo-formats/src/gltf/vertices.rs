//! Vertices of a mesh under construction, and what a mesh makes of them.

use super::irradiance::Stored;
use azulejo_scene::{Attribute, Mesh, Rgb};
use glam::{DVec2, DVec3};

/// Lists by vertex. But for the positions, each is empty or as long as the positions.
#[derive(Clone, Debug)]
pub(super) struct Vertices {
    /// Positions; those that are not finite are nowhere.
    pub positions: Vec<DVec3>,
    /// Unit normals; zero where there is none.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub uvs: Vec<DVec2>,
    /// Colours that multiply the reflectance.
    pub colors: Vec<Rgb>,
    /// Irradiance.
    pub light: Vec<Rgb>,
    /// Which colours of the file are irradiance.
    pub irradiance: Option<Stored>,
}

impl Vertices {
    /// None, of a mesh that keeps its irradiance so.
    pub fn new(irradiance: Option<Stored>) -> Vertices {
        Vertices {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            light: Vec::new(),
            irradiance,
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether faces can stand on a vertex.
    pub fn is_somewhere(&self, vertex: u32) -> bool {
        let position = self.positions.get(vertex as usize);
        position.is_some_and(|p| p.is_finite())
    }

    /// Takes a set of colours for what it is.
    pub fn set_colors(&mut self, set: u32, values: Vec<Rgb>) {
        let finite = |c: f64| if c.is_finite() { c.max(0.0) } else { 0.0 };
        match self.irradiance {
            Some(stored) if stored.set == set => {
                self.light = values;
                self.light
                    .iter_mut()
                    .for_each(|c| *c = (*c * stored.scale).map(finite));
            }
            _ if set == 0 => {
                self.colors = values;
                self.colors
                    .iter_mut()
                    .for_each(|c| *c = c.map(|c| finite(c).min(1.0)));
            }
            _ => {}
        }
    }

    /// Gives normals unit length, and coordinates that are not finite a place.
    pub fn make_usable(&mut self) {
        for normal in self.normals.iter_mut().filter(|n| !is_unit(**n)) {
            *normal = normal.normalize_or_zero();
        }
        for uv in self.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = DVec2::ZERO;
        }
    }

    /// Appends the vertices of another primitive; what only one of the two has gets neutral
    /// values in the other.
    pub fn append(&mut self, other: Vertices) {
        let (here, there) = (self.len(), other.len());
        join(&mut self.normals, other.normals, here, there, DVec3::ZERO);
        join(&mut self.uvs, other.uvs, here, there, DVec2::ZERO);
        join(&mut self.colors, other.colors, here, there, Rgb::WHITE);
        join(&mut self.light, other.light, here, there, Rgb::BLACK);
        join(
            &mut self.positions,
            other.positions,
            here,
            there,
            DVec3::ZERO,
        );
    }

    /// Keeps the marked vertices.
    fn retain(&mut self, marked: &[bool]) {
        retain(&mut self.positions, marked);
        retain(&mut self.normals, marked);
        retain(&mut self.uvs, marked);
        retain(&mut self.colors, marked);
        retain(&mut self.light, marked);
    }
}

/// Whether a vector has length 1 as far as single precision can say. Such normals stay as they
/// are in both directions, so that they do not drift.
pub(super) fn is_unit(normal: DVec3) -> bool {
    (normal.length_squared() - 1.0).abs() < 1e-6
}

fn join<T: Copy>(list: &mut Vec<T>, other: Vec<T>, here: usize, there: usize, neutral: T) {
    if list.is_empty() && here == 0 {
        *list = other;
    } else if !list.is_empty() || !other.is_empty() {
        list.resize(here, neutral);
        list.extend(other);
        list.resize(here + there, neutral);
    }
}

fn retain<T>(list: &mut Vec<T>, marked: &[bool]) {
    let mut marks = marked.iter();
    list.retain(|_| marks.next().copied().unwrap_or(false));
}

/// Gives a mesh, which has its faces, the vertices that they stand on, and says how many have no
/// usable normal though others have one.
pub(super) fn finish(mesh: &mut Mesh, mut vertices: Vertices) -> usize {
    drop_strangers(mesh, &mut vertices);
    // What no face uses may be nowhere.
    for position in vertices.positions.iter_mut().filter(|p| !p.is_finite()) {
        *position = DVec3::ZERO;
    }
    mesh.positions = vertices.positions;
    mesh.uvs = per_vertex(vertices.uvs);
    mesh.colors = vertices.colors;
    mesh.irradiance = vertices.light;
    let missing = vertices
        .normals
        .iter()
        .filter(|n| **n == DVec3::ZERO)
        .count();
    if missing == vertices.normals.len() {
        return 0;
    }
    mesh.normals = Some(match missing {
        0 => Attribute::per_vertex(vertices.normals),
        _ => with_face_normals(mesh, vertices.normals),
    });
    missing
}

/// Drops the vertices that no face uses, if they are most of them: some writers keep the
/// vertices of all meshes in one list.
fn drop_strangers(mesh: &mut Mesh, vertices: &mut Vertices) {
    let mut used = vec![false; vertices.len()];
    for &v in &mesh.faces.corners {
        used[v as usize] = true;
    }
    let count = used.iter().filter(|u| **u).count();
    if 2 * count >= used.len() {
        return;
    }
    let mut next = 0;
    let place: Vec<u32> = used
        .iter()
        .map(|&used| {
            next += u32::from(used);
            next.saturating_sub(1)
        })
        .collect();
    for v in &mut mesh.faces.corners {
        *v = place[*v as usize];
    }
    vertices.retain(&used);
}

/// Normals by corner: those of the vertices, and for vertices without one those of the faces.
fn with_face_normals(mesh: &Mesh, mut values: Vec<DVec3>) -> Attribute<DVec3> {
    let mut corners = mesh.faces.corners.clone();
    for face in 0..mesh.faces.len() {
        let range = mesh.faces.corner_range(face);
        let is_missing = |v: &u32| values[*v as usize] == DVec3::ZERO;
        let missing: Vec<bool> = mesh.faces.get(face).iter().map(is_missing).collect();
        if !missing.contains(&true) {
            continue;
        }
        // A face without area is seen by nobody; any unit vector does.
        let own = values.len() as u32;
        values.push(mesh.face_area_vector(face).normalize_or(DVec3::Z));
        for (corner, missing) in corners[range].iter_mut().zip(missing) {
            if missing {
                *corner = own;
            }
        }
    }
    for value in values.iter_mut().filter(|n| **n == DVec3::ZERO) {
        *value = DVec3::Z;
    }
    Attribute {
        values,
        corners: Some(corners),
    }
}

/// Values per vertex, if there are any.
fn per_vertex<T: Copy>(values: Vec<T>) -> Option<Attribute<T>> {
    (!values.is_empty()).then(|| Attribute::per_vertex(values))
}
