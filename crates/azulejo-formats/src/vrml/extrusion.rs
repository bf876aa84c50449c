//! Extrusions: a cross-section swept along a spine.

use super::builder::VrmlSceneBuilder;
use super::shape::{SurfaceFields, ValuePool};
use super::tree::{VrmlNode, triples};
use super::world::rotation;
use crate::ReadError;
use glam::{DMat3, DQuat, DVec2, DVec3};
use std::borrow::Cow;

/// The polygons of a node `Extrusion`; `None` if it has none.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn surface<'n>(
    builder: &mut VrmlSceneBuilder,
    node: &'n VrmlNode,
) -> Result<Option<SurfaceFields<'n>>, ReadError> {
    let form = ExtrusionFields::new(node);
    if form.spine.len() < 2 || form.section.len() < 2 {
        return Ok(None);
    }
    let vertices = form.spine.len() as u64 * form.section.len() as u64;
    builder.spend(12 * vertices)?;
    let numbers = [&*node.numbers("spine"), &*node.numbers("crossSection")];
    let lost = numbers
        .iter()
        .flat_map(|n| n.iter())
        .filter(|x| !x.is_finite());
    let message = "Extrusion with a number that is not finite: its point is skipped";
    builder.warn_many(&node.source, node.at, message, lost.count());
    let mut body = ExtrusionFaces::new(&form);
    body.sides();
    if !form.is_ring() {
        if node.flag("beginCap", true) {
            body.cap(0);
        }
        if node.flag("endCap", true) {
            body.cap(form.spine.len() - 1);
        }
    }
    let mut surface = SurfaceFields::new(node, body.positions, Cow::Owned(body.coord_index));
    surface.uvs = Some(ValuePool {
        index: Some(Cow::Owned(body.uv_index)),
        ..ValuePool::per_vertex(body.uvs)
    });
    Ok(Some(surface))
}

/// The fields of the node.
struct ExtrusionFields {
    spine: Vec<DVec3>,
    /// x and z of the cross-section.
    section: Vec<DVec2>,
    scale: Vec<DVec2>,
    orientation: Vec<DQuat>,
}

/// The square of two by two that VRML97 extrudes by default.
const SQUARE: [[f64; 2]; 5] = [
    [1.0, 1.0],
    [1.0, -1.0],
    [-1.0, -1.0],
    [-1.0, 1.0],
    [1.0, 1.0],
];

impl ExtrusionFields {
    fn new(node: &VrmlNode) -> ExtrusionFields {
        let mut spine = match node.value("spine") {
            Some(_) => triples(&node.numbers("spine")),
            None => vec![DVec3::ZERO, DVec3::Y],
        };
        spine.retain(|p| p.is_finite());
        let mut section = match node.value("crossSection") {
            Some(_) => node.points2("crossSection"),
            None => SQUARE.map(DVec2::from).to_vec(),
        };
        section.retain(|p| p.is_finite());
        let finite = |s: &DVec2| if s.is_finite() { *s } else { DVec2::ONE };
        let turns = node.numbers("orientation");
        let turn = |t: &[f64]| match *t {
            [x, y, z, angle] if t.iter().all(|x| x.is_finite()) => rotation([x, y, z, angle]),
            _ => DQuat::IDENTITY,
        };
        ExtrusionFields {
            spine,
            section,
            scale: node.points2("scale").iter().map(finite).collect(),
            orientation: turns.chunks_exact(4).map(turn).collect(),
        }
    }

    /// Whether the spine is closed.
    fn is_ring(&self) -> bool {
        self.spine.len() > 2 && self.spine.first() == self.spine.last()
    }

    /// Whether the cross-section is closed.
    fn is_tube(&self) -> bool {
        self.section.len() > 2 && self.section.first() == self.section.last()
    }

    /// Number of distinct points of the cross-section.
    fn around(&self) -> usize {
        self.section.len() - usize::from(self.is_tube())
    }
}

/// Entry `i` of a list with one value for all or one for each; the last entry where the list is too
/// short.
fn entry<T: Copy>(list: &[T], i: usize) -> Option<T> {
    list.get(i).or(list.last()).copied()
}

/// The planes of the cross-sections, as x, y and z axes: ISO/IEC 14772-1, 6.18.
fn planes(spine: &[DVec3], is_ring: bool) -> Vec<DMat3> {
    let (ys, mut zs) = (tangents(spine, is_ring), bends(spine, is_ring));
    let Some(first) = zs.iter().copied().find(|z| *z != DVec3::ZERO) else {
        return straight(&ys);
    };
    let mut previous = first;
    for z in &mut zs {
        if *z == DVec3::ZERO {
            *z = previous;
        } else if z.dot(previous) < 0.0 {
            *z = -*z;
        }
        previous = *z;
    }
    let plane = |(y, z): (&DVec3, &DVec3)| {
        let x = y.cross(*z).normalize_or(DVec3::X);
        // A bend copied from a neighbour need not be perpendicular to this tangent.
        DMat3::from_cols(x, *y, x.cross(*y))
    };
    ys.iter().zip(&zs).map(plane).collect()
}

/// The tangent of the spine at each of its points.
fn tangents(spine: &[DVec3], is_ring: bool) -> Vec<DVec3> {
    let last = spine.len() - 1;
    let tangent = |i: usize| {
        let (before, behind) = match i {
            0 if is_ring => (last - 1, 1),
            i if i == last && is_ring => (last - 1, 1),
            i => (i.saturating_sub(1), (i + 1).min(last)),
        };
        (spine[behind] - spine[before]).normalize_or_zero()
    };
    let mut tangents: Vec<DVec3> = (0..=last).map(tangent).collect();
    // Coincident points take the direction of their neighbours.
    let known = tangents.iter().copied().find(|t| *t != DVec3::ZERO);
    let mut previous = known.unwrap_or(DVec3::Y);
    for tangent in &mut tangents {
        if *tangent == DVec3::ZERO {
            *tangent = previous;
        }
        previous = *tangent;
    }
    tangents
}

/// The axis about which the spine bends at each of its points; zero where it is straight.
fn bends(spine: &[DVec3], is_ring: bool) -> Vec<DVec3> {
    let last = spine.len() - 1;
    let bend = |before: usize, i: usize, behind: usize| {
        let (to, from) = (spine[behind] - spine[i], spine[before] - spine[i]);
        let axis = to.cross(from);
        // Rounding makes straight spines bend.
        let is_straight = axis.length() <= 1e-9 * to.length() * from.length();
        if is_straight {
            DVec3::ZERO
        } else {
            axis.normalize_or_zero()
        }
    };
    let mut bends: Vec<DVec3> = (0..=last)
        .map(|i| match i {
            0 if is_ring => bend(last - 1, 0, 1),
            i if i == last && is_ring => bend(last - 1, 0, 1),
            i if i == 0 || i == last => DVec3::ZERO,
            i => bend(i - 1, i, i + 1),
        })
        .collect();
    if !is_ring && last >= 2 {
        bends[0] = bends[1];
        bends[last] = bends[last - 1];
    }
    bends
}

/// The planes along a straight spine: the smallest rotation of the model's y axis to its direction.
fn straight(tangents: &[DVec3]) -> Vec<DMat3> {
    let turn = DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, tangents[0]));
    let plane = |y: &DVec3| DMat3::from_cols(turn.x_axis, *y, turn.x_axis.cross(*y));
    tangents.iter().map(plane).collect()
}

/// The polygons of an extrusion.
struct ExtrusionFaces<'f> {
    form: &'f ExtrusionFields,
    positions: Vec<DVec3>,
    coord_index: Vec<i32>,
    uvs: Vec<DVec2>,
    uv_index: Vec<i32>,
}

impl<'f> ExtrusionFaces<'f> {
    /// The cross-sections placed along the spine, without faces.
    fn new(form: &'f ExtrusionFields) -> ExtrusionFaces<'f> {
        let planes = planes(&form.spine, form.is_ring());
        let mut positions = Vec::with_capacity(form.spine.len() * form.around());
        for (i, (point, plane)) in form.spine.iter().zip(&planes).enumerate() {
            let scale = entry(&form.scale, i).unwrap_or(DVec2::ONE);
            let turn = entry(&form.orientation, i).unwrap_or(DQuat::IDENTITY);
            let matrix = *plane * DMat3::from_quat(turn);
            let place = |s: &DVec2| *point + matrix * DVec3::new(s.x * scale.x, 0.0, s.y * scale.y);
            positions.extend(form.section[..form.around()].iter().map(place));
        }
        ExtrusionFaces {
            form,
            positions,
            coord_index: Vec::new(),
            uvs: Vec::new(),
            uv_index: Vec::new(),
        }
    }

    /// Adds a quadrilateral for each pair of adjacent spine and cross-section points. Texture
    /// coordinates follow the arc lengths of both.
    fn sides(&mut self) {
        let (rings, points) = (self.form.spine.len(), self.form.section.len());
        let us = shares(&self.form.section, |a, b| a.distance(b));
        let vs = shares(&self.form.spine, |a, b| a.distance(b));
        for v in &vs {
            self.uvs.extend(us.iter().map(|u| DVec2::new(*u, *v)));
        }
        let around = self.form.around();
        for i in 0..rings - 1 {
            for j in 0..points - 1 {
                let vertex = |di: usize, dj: usize| ((i + di) * around + (j + dj) % around) as i32;
                let uv = |di: usize, dj: usize| ((i + di) * points + j + dj) as i32;
                let corners = [(0, 0), (0, 1), (1, 1), (1, 0)];
                self.coord_index.extend(corners.map(|(i, j)| vertex(i, j)));
                self.uv_index.extend(corners.map(|(i, j)| uv(i, j)));
                self.coord_index.push(-1);
                self.uv_index.push(-1);
            }
        }
    }

    /// Adds the cross-section at one end of the spine as a face, with undistorted texture
    /// coordinates.
    fn cap(&mut self, ring: usize) {
        let around = self.form.around();
        if around < 3 {
            return;
        }
        let (start, start_uv) = (ring * around, self.uvs.len());
        let section = &self.form.section[..around];
        let low = section
            .iter()
            .copied()
            .reduce(DVec2::min)
            .unwrap_or_default();
        let high = section
            .iter()
            .copied()
            .reduce(DVec2::max)
            .unwrap_or_default();
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        self.uvs.extend(section.iter().map(|s| (s - low) / size));
        let mut push = |j: usize| {
            self.coord_index.push((start + j) as i32);
            self.uv_index.push((start_uv + j) as i32);
        };
        match ring {
            0 => (0..around).rev().for_each(&mut push),
            _ => (0..around).for_each(&mut push),
        }
        self.coord_index.push(-1);
        self.uv_index.push(-1);
    }
}

/// Normalized arc length of each point, 0 to 1; evenly spaced if the line has no length.
fn shares<T: Copy>(points: &[T], distance: impl Fn(T, T) -> f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut shares = vec![0.0];
    for pair in points.windows(2) {
        sum += distance(pair[0], pair[1]);
        shares.push(sum);
    }
    let last = (points.len() - 1) as f64;
    if sum > 0.0 && sum.is_finite() {
        shares.iter().map(|s| s / sum).collect()
    } else {
        (0..points.len()).map(|i| i as f64 / last).collect()
    }
}
