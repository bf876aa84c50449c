//! Vertices of a mesh under construction, and their conversion to mesh attributes.

use super::irradiance::StoredIrradiance;
use azulejo_scene::{Attribute, Mesh, Rgb};
use glam::{DVec2, DVec3};

/// Lists by vertex. But for the positions, each is empty or as long as the positions.
#[derive(Clone, Debug)]
pub(super) struct Vertices {
    /// Positions; ones that are not finite are unusable.
    pub positions: Vec<DVec3>,
    /// Unit normals; zero if missing.
    pub normals: Vec<DVec3>,
    /// Texture coordinates.
    pub uvs: Vec<DVec2>,
    /// Texture coordinates of lightmaps.
    pub lightmap_uvs: Vec<DVec2>,
    /// Colours that multiply the reflectance.
    pub colors: Vec<Rgb>,
    /// Irradiance.
    pub light: Vec<Rgb>,
    /// The set of colours that stores irradiance.
    pub irradiance: Option<StoredIrradiance>,
}

impl Vertices {
    /// No vertices, of a mesh that stores its irradiance in this way.
    pub fn new(irradiance: Option<StoredIrradiance>) -> Vertices {
        Vertices {
            positions: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            lightmap_uvs: Vec::new(),
            colors: Vec::new(),
            light: Vec::new(),
            irradiance,
        }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether a vertex exists and has a finite position.
    pub fn is_usable(&self, vertex: u32) -> bool {
        let position = self.positions.get(vertex as usize);
        position.is_some_and(|p| p.is_finite())
    }

    /// Stores a set of colours as irradiance or as colours.
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

    /// Gives normals unit length, and replaces texture coordinates that are not finite.
    pub fn make_usable(&mut self) {
        for normal in self.normals.iter_mut().filter(|n| !is_unit(**n)) {
            *normal = normal.normalize_or_zero();
        }
        let uvs = self.uvs.iter_mut().chain(&mut self.lightmap_uvs);
        for uv in uvs.filter(|uv| !uv.is_finite()) {
            *uv = DVec2::ZERO;
        }
    }

    /// Appends the vertices of another primitive; attributes that only one of the two has get neutral
    /// values in the other.
    pub fn append(&mut self, other: Vertices) {
        let (here, there) = (self.len(), other.len());
        join(&mut self.normals, other.normals, here, there, DVec3::ZERO);
        join(&mut self.uvs, other.uvs, here, there, DVec2::ZERO);
        let uvs = other.lightmap_uvs;
        join(&mut self.lightmap_uvs, uvs, here, there, DVec2::ZERO);
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
        retain(&mut self.lightmap_uvs, marked);
        retain(&mut self.colors, marked);
        retain(&mut self.light, marked);
    }
}

/// Whether a vector has length 1 within single precision. Such normals are kept
/// unchanged in both directions, so that they do not drift.
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

/// Gives a mesh with faces its vertices, and returns how many of them have no
/// usable normal though others have one.
pub(super) fn finish(mesh: &mut Mesh, mut vertices: Vertices) -> usize {
    drop_unused(mesh, &mut vertices);
    // Unused vertices may have non-finite positions.
    for position in vertices.positions.iter_mut().filter(|p| !p.is_finite()) {
        *position = DVec3::ZERO;
    }
    mesh.positions = vertices.positions;
    mesh.uvs = per_vertex(vertices.uvs);
    mesh.lightmap_uvs = per_vertex(vertices.lightmap_uvs);
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

/// Drops the vertices that no face uses, if they are the majority: some writers keep the
/// vertices of all meshes in one list.
fn drop_unused(mesh: &mut Mesh, vertices: &mut Vertices) {
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

/// Normals per corner: those of the vertices, and face normals for vertices without one.
fn with_face_normals(mesh: &Mesh, mut values: Vec<DVec3>) -> Attribute<DVec3> {
    let mut corners = mesh.faces.corners.clone();
    for face in 0..mesh.faces.len() {
        let range = mesh.faces.corner_range(face);
        let is_missing = |v: &u32| values[*v as usize] == DVec3::ZERO;
        let missing: Vec<bool> = mesh.faces.get(face).iter().map(is_missing).collect();
        if !missing.contains(&true) {
            continue;
        }
        // A face without area is invisible; any unit vector will do.
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
