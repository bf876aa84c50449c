//! Polygons as VRML and X3D define them: pools of values, and lists of indices in which −1 ends a
//! face.

use crate::surface::smooth;
use azulejo_scene::{Attribute, Faces, Mesh, Rgb};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Cosine of an angle that is due to rounding only.
const FLAT: f64 = 1.0 - 1e-12;

/// Marks an index without a value.
const NONE: u32 = u32::MAX;

/// An IndexedFaceSet of any version of VRML.
pub(super) struct FaceSet<'a> {
    /// The pool of vertices.
    pub positions: &'a [DVec3],
    /// Indices into `positions`; −1 ends a face, and the last face needs none.
    pub coord_index: &'a [i32],
    /// Colours, or other per-surface values. Bound to faces they are returned as
    /// [`BuiltFaceSet::face_values`], bound to vertices they become [`Mesh::colors`].
    pub colors: Option<BoundPool<'a, Rgb>>,
    /// Normals of any length; if absent, they are computed with `crease_angle`.
    pub normals: Option<BoundPool<'a, DVec3>>,
    /// Texture coordinates.
    pub uvs: Option<BoundPool<'a, DVec2>>,
    /// Whether corners run counter-clockwise as seen from the front.
    pub ccw: bool,
    /// Faces whose normals differ by less than this are smoothed across their common edge, radians.
    /// With 0 the mesh has no normals.
    pub crease_angle: f64,
    /// Whether unused vertices are dropped, because other face sets share the pool.
    pub drop_unused: bool,
}

/// A pool of values and its binding to faces and corners.
#[derive(Clone, Copy)]
pub(super) struct BoundPool<'a, T> {
    /// The pool.
    pub values: &'a [T],
    /// The index list of the `Indexed` bindings. Without one, vertices use [`FaceSet::coord_index`]
    /// and faces the order of the pool.
    pub index: Option<&'a [i32]>,
    /// What a value belongs to.
    pub binding: Binding,
}

/// The element that each value of a pool belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binding {
    /// The whole set: the first value holds for all faces.
    Overall,
    /// A face, in the order of the faces.
    PerFace,
    /// A face; the index has one entry per face.
    PerFaceIndexed,
    /// A corner, in the order of all corners of all faces.
    PerVertex,
    /// A corner; the index has its entry at the same position as `coord_index`.
    PerVertexIndexed,
}

/// The result of building a face set.
#[derive(Debug, Default)]
pub(super) struct BuiltFaceSet {
    /// The polygons, all with material 0, in the coordinates of `positions`.
    pub mesh: Mesh,
    /// The colour of each face as an index into [`FaceSet::colors`], if these are bound to faces or
    /// to the whole set; otherwise empty.
    pub face_values: Vec<u32>,
    /// The problems that were repaired.
    pub problems: FaceSetProblems,
}

/// Problems of a face set, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FaceSetProblems {
    /// Faces with one or two corners, dropped.
    pub slivers: usize,
    /// Faces with a corner whose position is missing or not finite, dropped.
    pub stray_faces: usize,
    /// Faces or corners without a colour: the last of the pool is used.
    pub stray_colors: usize,
    /// Corners without a normal: the normal of the face is used.
    pub stray_normals: usize,
    /// Corners with a zero normal: the normal of the face is used.
    pub zero_normals: usize,
    /// Corners without texture coordinates: (0, 0) is used.
    pub stray_uvs: usize,
}

impl FaceSetProblems {
    /// Each problem as a message with its count, which may be 0.
    pub fn messages(&self) -> [(&'static str, usize); 6] {
        [
            ("face with fewer than three corners: skipped", self.slivers),
            (
                "face with a coordIndex out of range: skipped",
                self.stray_faces,
            ),
            (
                "face or corner with a colour or material index out of range: the last one is used",
                self.stray_colors,
            ),
            (
                "corner with a normal index out of range: the face normal is used",
                self.stray_normals,
            ),
            (
                "corner with a zero normal: the face normal is used",
                self.zero_normals,
            ),
            (
                "corner with a texture coordinate index out of range: (0, 0) is used",
                self.stray_uvs,
            ),
        ]
    }
}

impl FaceSet<'_> {
    /// Upper bound of the number of elements of the mesh, for a budget.
    pub fn cost(&self) -> u64 {
        let pool = if self.drop_unused {
            0
        } else {
            self.positions.len()
        };
        (pool + self.coord_index.len()) as u64
    }
}

/// Builds the mesh.
pub(super) fn build(set: &FaceSet) -> BuiltFaceSet {
    let mut built = BuiltFaceSet::default();
    let kept = faces(set, &mut built);
    color(set, &kept, &mut built);
    built.mesh.face_materials = vec![0; kept.len()];
    let uvs = set.uvs.map(|bound| {
        let corners = corner_values(set, &kept, &bound);
        uv_attribute(&built.mesh, &bound, corners, &mut built.problems)
    });
    built.mesh.uvs = uvs;
    let normals = set.normals.map(|bound| {
        let corners = corner_values(set, &kept, &bound);
        normal_attribute(&built.mesh, set.ccw, &bound, corners, &mut built.problems)
    });
    built.mesh.normals = normals;
    if !set.ccw {
        built.mesh.flip();
    }
    if built.mesh.normals.is_none() && set.crease_angle > 0.0 {
        built.mesh.normals = creased(&built.mesh, set.crease_angle);
    }
    if built.mesh.normals.is_none() {
        built.mesh.be_flat();
    }
    built
}

/// Texture coordinates of a face set without any: the bounding box projected along its shortest
/// side. `u` runs from 0 to 1 along the longest side, `v` along the second at the same scale.
pub(super) fn box_mapping(positions: &[DVec3]) -> Vec<DVec2> {
    let finite = positions.iter().copied().filter(|p| p.is_finite());
    let bounds = azulejo_scene::math::Aabb::around(finite);
    let size = bounds.size();
    let mut axes = [0, 1, 2];
    // Equal sides keep the order x, y, z, as the standard requires: the sort is stable.
    axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    let along = |p: &DVec3, axis: usize| {
        let share = (p[axis] - bounds.min[axis]) / size[axes[0]];
        if share.is_finite() { share } else { 0.0 }
    };
    let uv = |p| DVec2::new(along(p, axes[0]), along(p, axes[1]));
    positions.iter().map(uv).collect()
}

/// A valid face and its position in the file.
struct KeptFace {
    /// Index of its first corner in `coord_index`.
    start: u32,
    /// Number of corners before it.
    corners_before: u32,
    /// Number of faces before it, dropped ones included.
    ordinal: u32,
}

/// Adds the faces and positions to the mesh and returns which faces were kept.
fn faces(set: &FaceSet, built: &mut BuiltFaceSet) -> Vec<KeptFace> {
    let mut kept = Vec::new();
    let mut corners = Vec::with_capacity(set.coord_index.len());
    let mut starts = vec![0];
    let (mut start, mut corners_before, mut ordinal) = (0, 0, 0);
    for polygon in set.coord_index.split(|i| *i == -1) {
        let exists = |i: &i32| {
            let place = usize::try_from(*i).ok().and_then(|i| set.positions.get(i));
            place.is_some_and(|p| p.is_finite())
        };
        if polygon.len() < 3 {
            built.problems.slivers += usize::from(!polygon.is_empty());
        } else if !polygon.iter().all(exists) {
            built.problems.stray_faces += 1;
        } else {
            corners.extend(polygon.iter().map(|i| *i as u32));
            starts.push(corners.len() as u32);
            kept.push(KeptFace {
                start,
                corners_before,
                ordinal,
            });
        }
        start += polygon.len() as u32 + 1;
        corners_before += polygon.len() as u32;
        ordinal += u32::from(!polygon.is_empty());
    }
    corners.shrink_to_fit();
    let mesh = &mut built.mesh;
    mesh.positions = if set.drop_unused {
        let used = renumber(&mut corners, set.positions.len());
        used.iter().map(|&i| set.positions[i as usize]).collect()
    } else {
        // A scene must not contain non-finite positions, even if no face uses them.
        let somewhere = |p: &DVec3| if p.is_finite() { *p } else { DVec3::ZERO };
        set.positions.iter().map(somewhere).collect()
    };
    mesh.faces = Faces { starts, corners };
    kept
}

/// The indices that occur, in ascending order; each entry is replaced by its position among them,
/// except [`NONE`]. Takes time proportional to the number of entries, whatever the size of the
/// pool.
fn renumber(indices: &mut [u32], pool: usize) -> Vec<u32> {
    let mut used: Vec<u32>;
    if pool / 4 > indices.len() {
        used = indices.iter().copied().filter(|i| *i != NONE).collect();
        used.sort_unstable();
        used.dedup();
        for i in indices.iter_mut().filter(|i| **i != NONE) {
            *i = used.binary_search(i).map_or(NONE, |place| place as u32);
        }
        return used;
    }
    let mut places = vec![NONE; pool];
    for &i in indices.iter().filter(|i| **i != NONE) {
        places[i as usize] = 0;
    }
    used = (0..pool as u32)
        .filter(|i| places[*i as usize] == 0)
        .collect();
    for (place, &i) in used.iter().enumerate() {
        places[i as usize] = place as u32;
    }
    for i in indices.iter_mut().filter(|i| **i != NONE) {
        *i = places[*i as usize];
    }
    used
}

impl<T> BoundPool<'_, T> {
    /// The value of a face, or [`NONE`].
    fn face_value(&self, face: &KeptFace) -> u32 {
        self.checked(match (self.binding, self.index) {
            (Binding::PerFaceIndexed, Some(index)) => entry(index, face.ordinal),
            (Binding::Overall, _) => 0,
            _ => face.ordinal,
        })
    }

    /// The value of the `k`-th corner of a face, or [`NONE`].
    fn corner_value(&self, coord_index: &[i32], face: &KeptFace, k: u32) -> u32 {
        match self.binding {
            Binding::PerVertex => self.checked(face.corners_before + k),
            Binding::PerVertexIndexed => {
                let index = self.index.unwrap_or(coord_index);
                self.checked(entry(index, face.start + k))
            }
            _ => self.face_value(face),
        }
    }

    fn checked(&self, value: u32) -> u32 {
        if (value as usize) < self.values.len() {
            value
        } else {
            NONE
        }
    }
}

/// An entry of an index, [`NONE`] if it is missing or negative.
fn entry(index: &[i32], at: u32) -> u32 {
    let entry = index.get(at as usize).copied();
    entry.and_then(|i| u32::try_from(i).ok()).unwrap_or(NONE)
}

/// For each corner the index of its value in the pool, or [`NONE`].
fn corner_values<T>(set: &FaceSet, kept: &[KeptFace], bound: &BoundPool<T>) -> Vec<u32> {
    let mut values = Vec::new();
    for face in kept {
        let rest = &set.coord_index[face.start as usize..];
        let corners = rest.iter().take_while(|i| **i != -1).count() as u32;
        values.extend((0..corners).map(|k| bound.corner_value(set.coord_index, face, k)));
    }
    values
}

/// Assigns colours to faces or vertices.
fn color(set: &FaceSet, kept: &[KeptFace], built: &mut BuiltFaceSet) {
    let Some(bound) = set.colors.filter(|c| !c.values.is_empty()) else {
        return;
    };
    let last = bound.values.len() as u32 - 1;
    let mut values = match bound.binding {
        Binding::PerVertex | Binding::PerVertexIndexed => corner_values(set, kept, &bound),
        _ => kept.iter().map(|face| bound.face_value(face)).collect(),
    };
    for value in values.iter_mut().filter(|v| **v == NONE) {
        *value = last;
        built.problems.stray_colors += 1;
    }
    match bound.binding {
        Binding::PerVertex | Binding::PerVertexIndexed => {
            color_vertices(&mut built.mesh, bound.values, &values);
        }
        _ => built.face_values = values,
    }
}

/// Gives each vertex the colour of its corners; a vertex whose corners differ in colour is split.
fn color_vertices(mesh: &mut Mesh, pool: &[Rgb], corners: &[u32]) {
    // Only colours that are used are compared, because many face sets may share a large pool.
    let color = |value: u32| super::tree::limited(pool[value as usize]);
    let mut vertex_values = vec![NONE; mesh.positions.len()];
    let mut parted = HashMap::new();
    for (vertex, &value) in mesh.faces.corners.iter_mut().zip(corners) {
        let known = vertex_values[*vertex as usize];
        if known == NONE {
            vertex_values[*vertex as usize] = value;
        } else if color(known) != color(value) {
            let key = (*vertex, color(value).to_array().map(f64::to_bits));
            *vertex = *parted.entry(key).or_insert_with(|| {
                mesh.positions.push(mesh.positions[*vertex as usize]);
                vertex_values.push(value);
                mesh.positions.len() as u32 - 1
            });
        }
    }
    let or_white = |&value: &u32| {
        if value == NONE {
            Rgb::WHITE
        } else {
            color(value)
        }
    };
    mesh.colors = vertex_values.iter().map(or_white).collect();
}

fn uv_attribute(
    mesh: &Mesh,
    bound: &BoundPool<DVec2>,
    mut corners: Vec<u32>,
    problems: &mut FaceSetProblems,
) -> Attribute<DVec2> {
    let used = renumber(&mut corners, bound.values.len());
    let finite = |i: &u32| Some(bound.values[*i as usize]).filter(|uv| uv.is_finite());
    let mut values: Vec<DVec2> = used.iter().map(|i| finite(i).unwrap_or_default()).collect();
    let none = values.len() as u32;
    for corner in corners.iter_mut().filter(|c| **c == NONE) {
        *corner = none;
        problems.stray_uvs += 1;
    }
    if corners.contains(&none) {
        values.push(DVec2::ZERO);
    }
    attribute(mesh, values, corners, DVec2::ZERO)
}

fn normal_attribute(
    mesh: &Mesh,
    ccw: bool,
    bound: &BoundPool<DVec3>,
    mut corners: Vec<u32>,
    problems: &mut FaceSetProblems,
) -> Attribute<DVec3> {
    let used = renumber(&mut corners, bound.values.len());
    let unit = |i: &u32| bound.values[*i as usize].normalize_or_zero();
    let mut values: Vec<DVec3> = used.iter().map(unit).collect();
    for face in 0..mesh.faces.len() {
        let mut own = None;
        for corner in &mut corners[mesh.faces.corner_range(face)] {
            match values.get(*corner as usize) {
                Some(&DVec3::ZERO) => problems.zero_normals += 1,
                Some(_) => continue,
                None => problems.stray_normals += 1,
            }
            *corner = *own.get_or_insert_with(|| {
                let front = if ccw { 1.0 } else { -1.0 } * mesh.face_area_vector(face);
                values.push(front.normalize_or(DVec3::Z));
                values.len() as u32 - 1
            });
        }
    }
    // No corner uses these any more, but a mesh must not contain zero normals.
    for value in values.iter_mut().filter(|v| **v == DVec3::ZERO) {
        *value = DVec3::Z;
    }
    attribute(mesh, values, corners, DVec3::Z)
}

/// Values per vertex if the corners of every vertex agree, otherwise per corner. Vertices without
/// faces get `unused`.
fn attribute<T: Copy>(mesh: &Mesh, values: Vec<T>, corners: Vec<u32>, unused: T) -> Attribute<T> {
    let mut vertex_values = vec![NONE; mesh.positions.len()];
    let agree = mesh.faces.corners.iter().zip(&corners).all(|(&v, &value)| {
        let known = &mut vertex_values[v as usize];
        let agrees = *known == NONE || *known == value;
        *known = value;
        agrees
    });
    if agree {
        let value = |i: &u32| values.get(*i as usize).copied().unwrap_or(unused);
        Attribute::per_vertex(vertex_values.iter().map(value).collect())
    } else {
        Attribute {
            values,
            corners: Some(corners),
        }
    }
}

/// Normals smoothed across edges whose faces differ by less than `angle`; `None` if all faces stay
/// flat.
fn creased(mesh: &Mesh, angle: f64) -> Option<Attribute<DVec3>> {
    let flat = (0..mesh.faces.len()).map(|f| mesh.face_area_vector(f).normalize_or_zero());
    let flat = Vec::from_iter(flat);
    // Normals differ by π at most, whatever the rounding.
    let cos = if angle < PI { angle.cos() } else { -2.0 };
    let normals = smooth::corner_normals(mesh, |f, g| smooth::within(flat[f], flat[g], cos));
    let is_flat = |face: usize| {
        let mut corners = mesh.faces.corner_range(face);
        corners.all(|c| smooth::within(normals.at(c, mesh.faces.corners[c]), flat[face], FLAT))
    };
    let all_flat = (0..mesh.faces.len()).all(|f| flat[f] == DVec3::ZERO || is_flat(f));
    (!all_flat).then_some(normals)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unit squares side by side in the plane z = 0.
    const POOL: [DVec3; 7] = [
        DVec3::new(9.0, 9.0, 9.0),
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(2.0, 0.0, 0.0),
        DVec3::new(0.0, 1.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(2.0, 1.0, 0.0),
    ];
    const SQUARES: [i32; 9] = [1, 2, 5, 4, -1, 2, 3, 6, 5];
    const COLORS: [Rgb; 3] = [Rgb::BLACK, Rgb::grey(0.5), Rgb::WHITE];

    fn plain<'a>(coord_index: &'a [i32]) -> FaceSet<'a> {
        FaceSet {
            positions: &POOL,
            coord_index,
            colors: None,
            normals: None,
            uvs: None,
            ccw: true,
            crease_angle: 0.0,
            drop_unused: false,
        }
    }

    fn bound<'a, T>(
        values: &'a [T],
        index: Option<&'a [i32]>,
        binding: Binding,
    ) -> BoundPool<'a, T> {
        BoundPool {
            values,
            index,
            binding,
        }
    }

    #[test]
    fn polygons_and_what_is_none() {
        let check = |index: &[i32], faces: usize, slivers: usize, stray_faces: usize| {
            let built = build(&plain(index));
            let expected = FaceSetProblems {
                slivers,
                stray_faces,
                ..FaceSetProblems::default()
            };
            assert_eq!(built.mesh.faces.len(), faces, "{index:?}");
            assert_eq!(built.mesh.face_materials.len(), faces, "{index:?}");
            assert_eq!(built.problems, expected, "{index:?}");
            assert_eq!(built.mesh.positions.len(), 7);
        };
        check(&[], 0, 0, 0);
        check(&[-1, -1], 0, 0, 0);
        check(&SQUARES, 2, 0, 0);
        check(&[1, 2, 5, -1], 1, 0, 0);
        check(&[1, 2, -1, 3, -1, 1, 2, 5], 1, 2, 0);
        check(&[1, 2, 7, -1, 1, 2, -2, -1, 1, 2, i32::MIN], 0, 0, 3);
    }

    #[test]
    fn nowhere_is_no_place() {
        let pool = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NAN];
        let mut set = plain(&[0, 1, 2, -1, 1, 2, 3]);
        set.positions = &pool;
        let built = build(&set);
        assert_eq!((built.mesh.faces.len(), built.problems.stray_faces), (1, 1));
        assert!(built.mesh.positions.iter().all(|p| p.is_finite()));
    }

    #[test]
    fn a_shared_pool_is_cut_down() {
        for index in [&SQUARES[..], &[2, 3, 6]] {
            let mut set = plain(index);
            let whole = build(&set).mesh;
            set.drop_unused = true;
            let cut = build(&set).mesh;
            assert_eq!(cut.bounds(), whole.bounds());
            assert_eq!(cut.area(), whole.area());
            assert_eq!(cut.positions.len(), 3 * (index.len() / 3).clamp(1, 2));
        }
    }

    #[test]
    fn clockwise_faces_are_turned() {
        let mut set = plain(&SQUARES);
        set.ccw = false;
        set.crease_angle = 1.0;
        let mesh = build(&set).mesh;
        assert_eq!(mesh.face_area_vector(1), -DVec3::Z);
        assert_eq!(mesh.normals, None);
    }

    #[test]
    fn colours_of_faces() {
        let check = |binding, index: Option<&[i32]>, expected: [u32; 2], strays| {
            let mut set = plain(&SQUARES);
            set.colors = Some(bound(&COLORS, index, binding));
            let built = build(&set);
            assert_eq!(built.face_values, expected, "{binding:?}");
            assert_eq!(built.problems.stray_colors, strays, "{binding:?}");
            assert!(built.mesh.colors.is_empty());
        };
        check(Binding::Overall, None, [0, 0], 0);
        check(Binding::PerFace, None, [0, 1], 0);
        check(Binding::PerFaceIndexed, None, [0, 1], 0);
        check(Binding::PerFaceIndexed, Some(&[2, 1]), [2, 1], 0);
        check(Binding::PerFaceIndexed, Some(&[1]), [1, 2], 1);
        check(Binding::PerFaceIndexed, Some(&[-1, 3]), [2, 2], 2);
    }

    #[test]
    fn a_dropped_face_keeps_its_place_in_the_count() {
        let index = [1, 2, -1, 1, 2, 99, -1, 1, 2, 5];
        let mut set = plain(&index);
        set.colors = Some(bound(&COLORS, None, Binding::PerFace));
        assert_eq!(build(&set).face_values, [2]);
        let normals: Vec<DVec3> = (1..=8).map(|x| DVec3::new(x.into(), 1.0, 0.0)).collect();
        set.normals = Some(bound(&normals, None, Binding::PerVertex));
        let actual = build(&set).mesh.normals.unwrap();
        assert_eq!(actual.at(0, 1), normals[5].normalize());
        assert_eq!(actual.at(2, 5), normals[7].normalize());
    }

    #[test]
    fn colours_part_vertices_only_where_they_differ() {
        // The squares meet at vertices 2 and 5; the first gets one colour, the other two.
        let index = [0, 1, 2, 0, -1, 1, 0, 0, 1];
        let mut set = plain(&SQUARES);
        set.colors = Some(bound(&COLORS, Some(&index), Binding::PerVertexIndexed));
        let mesh = build(&set).mesh;
        assert_eq!(mesh.positions.len(), 8);
        assert_eq!(mesh.positions[7], POOL[5]);
        assert_eq!(mesh.faces.get(0), [1, 2, 5, 4]);
        assert_eq!(mesh.faces.get(1), [2, 3, 6, 7]);
        let at = |v: usize| mesh.colors[v].r;
        assert_eq!((at(0), at(2), at(5), at(7)), (1.0, 0.5, 1.0, 0.5));
    }

    #[test]
    fn colours_by_coord_index_and_in_order() {
        let mut set = plain(&[0, 1, 2]);
        set.colors = Some(bound(&COLORS, None, Binding::PerVertexIndexed));
        assert_eq!(build(&set).mesh.colors[..3], COLORS);
        let mut set = plain(&SQUARES);
        set.colors = Some(bound(&COLORS, None, Binding::PerVertex));
        let built = build(&set);
        assert_eq!(built.problems.stray_colors, 5);
        assert_eq!(built.mesh.colors[1..3], COLORS[..2]);
    }

    #[test]
    fn normals_are_made_unit_and_missing_ones_flat() {
        let values = [DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO];
        let index = [0, 0, 0, 0, -1, 1, 7, 0, 0];
        let mut set = plain(&SQUARES);
        set.normals = Some(bound(&values, Some(&index), Binding::PerVertexIndexed));
        let built = build(&set);
        let problems = built.problems;
        assert_eq!((problems.stray_normals, problems.zero_normals), (1, 1));
        let normals = built.mesh.normals.unwrap();
        assert_eq!(normals.at(0, 1), DVec3::Y);
        assert_eq!(normals.at(4, 2), DVec3::Z);
        assert_eq!(normals.at(5, 3), DVec3::Z);
    }

    #[test]
    fn values_of_vertices_stay_with_vertices() {
        let normals = [DVec3::Z; 7];
        let uvs = POOL.map(|p| p.truncate());
        let mut set = plain(&SQUARES);
        set.normals = Some(bound(&normals, None, Binding::PerVertexIndexed));
        set.uvs = Some(bound(&uvs, None, Binding::PerVertexIndexed));
        let mesh = build(&set).mesh;
        assert_eq!(mesh.normals.unwrap().corners, None);
        let actual = mesh.uvs.unwrap();
        assert_eq!(
            (actual.corners, actual.values[6]),
            (None, DVec2::new(2.0, 1.0))
        );
        set.uvs = Some(bound(&uvs[..6], None, Binding::PerVertexIndexed));
        let built = build(&set);
        assert_eq!(built.problems.stray_uvs, 1);
        assert_eq!(built.mesh.uvs.unwrap().at(6, 6), DVec2::ZERO);
    }

    #[test]
    fn creases() {
        let roof = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(-1.0, 0.0, -1.0)];
        let check = |crease_angle, expected: Option<bool>| {
            let mut set = plain(&[0, 1, 2, -1, 0, 2, 3]);
            set.positions = &roof;
            set.crease_angle = crease_angle;
            let normals = build(&set).mesh.normals;
            let smooth = normals.map(|n| n.at(0, 0) == n.at(3, 0));
            assert_eq!(smooth, expected, "{crease_angle}");
        };
        check(0.0, None);
        check(44f64.to_radians(), None);
        check(46f64.to_radians(), Some(true));
        check(7.0, Some(true));
    }

    #[test]
    fn boxes_are_mapped_along_their_longest_sides() {
        let uvs = box_mapping(&[DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 5.0, 3.0)]);
        assert_eq!(uvs, [DVec2::ZERO, DVec2::new(1.0, 0.75)]);
        assert_eq!(box_mapping(&[DVec3::ONE]), [DVec2::ZERO]);
        assert!(box_mapping(&[]).is_empty());
    }
}
