//! Which triangles have another one back to back with them, of which a ray hits one by chance.

use crate::exact::point_on_triangle;
use crate::{KernelHit, KernelRay, Tracer};
use azulejo_scene::math::Aabb;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Distance of two faces back to back, in units of the rounding of coordinates: a few for each, and for slanting
/// rays.
pub(crate) const BACK_TO_BACK: f32 = 16.0;

/// Cells of planes: this many for each unit of slope, and along the scene. Coarse, so that rounding seldom puts a plane
/// into several.
const SLOPES: f64 = 32.0;
const OFFSETS: f64 = 32_768.0;

/// A triangle that rounding spreads over more cells than this is a sliver, and counts as back to back.
const MOST_CELLS: usize = 64;

/// Radians by which rounding may turn a triangle that is not a sliver.
const MOST_TURN: f64 = 0.1;

/// If a cell needs more tests of two boxes than this for each of its triangles, all in it are unknown: a wall of 100,000
/// on either side needs half as many.
const MOST_TESTS: usize = 2048;

/// If there are more pairs than this for each triangle, besides a few, all triangles are unknown.
const MOST_PAIRS: usize = 32;
const FEW_PAIRS: usize = 1 << 20;

/// Triangles that may be back to back with others.
#[derive(Default)]
pub(crate) struct BackToBack {
    /// A triangle, and one behind it, in order.
    pairs: Vec<[u32; 2]>,
    /// Triangles that may have others behind them that are in no pair.
    unknown: Vec<bool>,
    /// Distance within which planes are the same.
    rounding: f64,
}

impl BackToBack {
    /// Whether a triangle may have others behind it that are in no pair.
    pub fn is_unknown(&self, item: u32) -> bool {
        self.unknown
            .get(item as usize)
            .is_none_or(|unknown| *unknown)
    }

    /// The hits of a ray on the triangles that are back to back with the one that it hits. Which of them the tracer
    /// reports is rounding, and at the same `t` it is the first.
    pub fn hits<'b>(
        &'b self,
        tracer: &'b Tracer,
        ray: &KernelRay,
        hit: &'b KernelHit,
    ) -> impl Iterator<Item = KernelHit> + 'b {
        let first = self.pairs.partition_point(|pair| pair[0] < hit.item);
        let pairs = self.pairs[first..].iter();
        let pairs = pairs.take_while(|pair| pair[0] == hit.item);
        let ray = tracer.world_ray(ray);
        let near = 4.0 * self.rounding;
        pairs.filter_map(move |&[_, other]| {
            let at = |item| {
                let corners = tracer.triangle_corners(item);
                point_on_triangle(corners, &ray, hit.t.into())
            };
            let (here, there) = (at(hit.item), at(other));
            let uv = [there.u as f32, there.v as f32];
            (here.position.distance(there.position) <= near)
                .then(|| KernelHit::on_surface(hit.t, other, uv))
        })
    }
}

/// The triangles of a tracer that may be back to back: in one plane but for rounding, with opposite sides in front, and
/// with boxes that overlap. Some are named that are not; none is left out, but those beside slivers.
///
/// In a scene that has other shapes, instances or copies none is examined, and all are unknown.
pub(crate) fn back_to_back(tracer: &Tracer) -> BackToBack {
    if !tracer.has_triangles_alone() {
        return BackToBack::default();
    }
    let planes = Planes::new(tracer);
    let items = 0..tracer.triangles.len() as u32;
    let mut entries: Vec<PlaneEntry> = (items.clone().into_par_iter())
        .flat_map_iter(|item| planes.entries(item))
        .collect();
    entries.par_sort_unstable_by_key(|e| (e.cell, e.item));
    let mut backs = BackToBack {
        pairs: Vec::new(),
        unknown: vec![false; items.len()],
        rounding: planes.rounding,
    };
    for entry in entries.iter().filter(|e| e.cell == SLIVER) {
        backs.unknown[entry.item as usize] = true;
    }
    for cell in entries.chunk_by(|a, b| a.cell == b.cell) {
        planes.compare(cell, &mut backs);
        if backs.pairs.len() > FEW_PAIRS + MOST_PAIRS * items.len() {
            return BackToBack::default();
        }
    }
    backs.pairs.sort_unstable();
    backs.pairs.dedup();
    backs
}

/// Steepest axis, slopes along the other two, and offset along the axis.
type PlaneCell = [i32; 4];

/// Where slivers are kept.
const SLIVER: PlaneCell = [3, 0, 0, 0];

/// A triangle in a cell.
struct PlaneEntry {
    cell: PlaneCell,
    item: u32,
    /// Whether its normal points along the axis of the cell, not against it.
    is_along: bool,
}

struct Planes<'t> {
    tracer: &'t Tracer,
    centre: DVec3,
    /// World units for each cell of offsets.
    width: f64,
    /// Distance within which planes are the same: that in which [`Surfaces::facing`](crate::Surfaces::facing) looks.
    rounding: f64,
    /// Distance by which rounding moves a corner.
    corner: f64,
}

impl<'t> Planes<'t> {
    fn new(tracer: &'t Tracer) -> Planes<'t> {
        let bounds = tracer.bounds();
        // The way of a ray: to its start, and on to the hit; in the kernel's coordinates and as long as √3 of these.
        let far = |p: DVec3| 3.0 * 3f64.sqrt() * tracer.frame.distance(p);
        let way = far(bounds.min).max(far(bounds.max)) + 2.0 * tracer.frame.reach();
        let rounding = f64::from(BACK_TO_BACK * f32::EPSILON) * way;
        Planes {
            tracer,
            centre: bounds.centre(),
            width: (bounds.diagonal() / OFFSETS).max(4.0 * rounding),
            rounding,
            corner: f64::from(f32::EPSILON)
                * tracer
                    .frame
                    .distance(bounds.min)
                    .max(tracer.frame.distance(bounds.max)),
        }
    }

    /// The cells of a triangle's plane, for each axis that may be the steepest.
    fn entries(&self, item: u32) -> Vec<PlaneEntry> {
        let [a, b, c] = self.tracer.triangle_corners(item).map(|p| p - self.centre);
        let across = (b - a).cross(c - a);
        let edges = [b - a, c - b, a - c].map(DVec3::length);
        // By how much rounding may turn it: by itself over its height.
        let turn = self.corner * edges.into_iter().fold(0.0, f64::max) / across.length();
        let steepest = across.abs().max_element();
        let away = a.length();
        let mut entries = Vec::new();
        for axis in 0..3 {
            if across[axis].abs() < (1.0 - 4.0 * turn) * steepest {
                continue;
            }
            let slope = across / across[axis];
            let cells = |value: f64, doubt: f64, width: f64| -> RangeInclusive<i32> {
                ((value - doubt) / width).floor() as i32..=((value + doubt) / width).floor() as i32
            };
            let [u, v] = [1, 2].map(|k| cells(slope[(axis + k) % 3], 4.0 * turn, 1.0 / SLOPES));
            let w = cells(
                a.dot(slope),
                2.0 * self.rounding + 4.0 * turn * away,
                self.width,
            );
            let sizes = [&u, &v, &w].map(|range| range.clone().count());
            let is_sliver = turn.is_nan() || turn > MOST_TURN;
            if is_sliver || sizes.into_iter().product::<usize>() > MOST_CELLS {
                return vec![PlaneEntry {
                    cell: SLIVER,
                    item,
                    is_along: true,
                }];
            }
            let is_along = across[axis] > 0.0;
            for (u, v) in u.flat_map(|u| v.clone().map(move |v| (u, v))) {
                let entry = |w| PlaneEntry {
                    cell: [axis as i32, u, v, w],
                    item,
                    is_along,
                };
                entries.extend(w.clone().map(entry));
            }
        }
        entries
    }

    /// Finds the triangles of a cell that another one opposes: those whose boxes overlap, in a sweep along the longest
    /// side of the box around all.
    fn compare(&self, cell: &[PlaneEntry], backs: &mut BackToBack) {
        if cell.iter().all(|entry| entry.is_along == cell[0].is_along) {
            return;
        }
        let bounds = |entry: &PlaneEntry| {
            let corners = self.tracer.triangle_corners(entry.item);
            (Aabb::around(corners), entry.item, entry.is_along)
        };
        let mut boxes: Vec<(Aabb, u32, bool)> = cell.iter().map(bounds).collect();
        let all = boxes
            .iter()
            .fold(Aabb::EMPTY, |all, (own, ..)| all.union(*own));
        let axis = (all.max - all.min).max_position();
        boxes.sort_by(|(a, ..), (b, ..)| a.min[axis].total_cmp(&b.min[axis]));
        let (near, mut tests) = (4.0 * self.rounding, 0);
        for (k, (a, first, is_along)) in boxes.iter().enumerate() {
            let later = boxes[k + 1..].iter();
            for (b, second, _) in later
                .take_while(|(b, ..)| b.min[axis] <= a.max[axis] + near)
                .inspect(|_| tests += 1)
                .filter(|(_, _, other)| other != is_along)
            {
                let gap = (a.min - b.max).max(b.min - a.max);
                if gap.max_element() <= near {
                    backs.pairs.extend([[*first, *second], [*second, *first]]);
                }
            }
            if tests > MOST_TESTS * cell.len() {
                for entry in cell {
                    backs.unknown[entry.item as usize] = true;
                }
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surfaces;
    use azulejo_scene::math::Ray;
    use azulejo_scene::{Material, Mesh, Object, Rgb, Scene, Shape};
    use glam::DQuat;
    use std::f64::consts::FRAC_PI_2;

    /// Triangles of a scene, and which of them are found.
    fn found(triangles: &[[DVec3; 3]]) -> Vec<bool> {
        let mut mesh = Mesh::default();
        for corners in triangles {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.push_face(&[first, first + 1, first + 2], 0);
        }
        let mut scene = Scene::default();
        scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        scene.objects.push(Object::new("all", Shape::Mesh(mesh)));
        let backs = back_to_back(&Tracer::new(&scene));
        let is_found = |item| backs.is_unknown(item) || backs.pairs.iter().any(|p| p[0] == item);
        (0..triangles.len() as u32).map(is_found).collect()
    }

    #[test]
    fn backs_are_found_in_any_pose_however_faces_are_divided() {
        let [o, x, y] = [DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y];
        let up = 3.0 * DVec3::Z;
        let triangles = [
            // A front, its back divided otherwise, and a back beside it.
            [o, x, y],
            [o, y, 0.5 * x],
            [2.0 * x, 2.0 * x + y, 3.0 * x],
            // A front in the same place, a back above, and a wall.
            [o, x, y],
            [o + up, y + up, x + up],
            [o, x, up],
        ];
        for k in 0..50 {
            let turn = DQuat::from_scaled_axis(0.3 * f64::from(k) * DVec3::new(1.0, 2.0, -0.5));
            let far = f64::from(k) * DVec3::new(30.0, -20.0, 7.0);
            let posed = triangles.map(|t| t.map(|p| (turn * p + far).as_vec3().as_dvec3()));
            let expected = [true, true, false, true, false, false];
            assert_eq!(found(&posed), expected, "pose {k}");
        }
    }

    #[test]
    fn rays_meet_the_face_that_shows_its_front() {
        let [o, x, y] = [DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y];
        for back in [vec![[o, y, x]], vec![[o, y, 0.5 * x], [0.5 * x, y, x]]] {
            for k in 0..20 {
                // In planes along the axes both are hit at the same distance.
                let turn = if k < 3 {
                    DQuat::from_axis_angle(DVec3::AXES[k as usize], FRAC_PI_2)
                } else {
                    DQuat::from_scaled_axis(0.3 * f64::from(k) * DVec3::new(1.0, 2.0, -0.5))
                };
                let far = f64::from(k) * DVec3::new(30.0, -20.0, 7.0);
                let pose = |p: DVec3| (turn * p + far).as_vec3().as_dvec3();
                let mut scene = Scene::default();
                for (name, triangles) in [("front", vec![[o, x, y]]), ("back", back.clone())] {
                    let mut mesh = Mesh::default();
                    for corners in &triangles {
                        let first = mesh.positions.len() as u32;
                        mesh.positions.extend(corners.map(pose));
                        mesh.push_face(&[first, first + 1, first + 2], 0);
                    }
                    scene.objects.push(Object::new(name, Shape::Mesh(mesh)));
                }
                scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
                let tracer = Tracer::new(&scene);
                let surfaces = Surfaces::new(&scene, &tracer);
                for (object, side) in [(0, 1.0), (1, -1.0)] {
                    for at in [0.2 * x + 0.3 * y, 0.7 * x + 0.1 * y] {
                        let from = pose(at + DVec3::new(0.3, -0.1, side));
                        let ray = tracer.kernel_ray(&Ray::between(from, pose(at)));
                        let ray = KernelRay { t_max: 2.0, ..ray };
                        let mut hits = Vec::new();
                        tracer.closest(&[ray], &mut hits);
                        let (hit, is_front) = surfaces.facing(&ray, &hits[0]);
                        assert!(is_front, "{k}");
                        assert_eq!(tracer.item(hit.item).object, object, "{k}");
                        let (position, _) = tracer.surface_point(&ray, &hit);
                        assert!(position.distance(pose(at)) < 1e-3, "{k}: {position}");
                    }
                }
            }
        }
    }

    #[test]
    fn slivers_count_as_back_to_back() {
        let sliver = [DVec3::ZERO, DVec3::X, DVec3::new(0.5, 1e-7, 0.0)];
        let far = [DVec3::Z, DVec3::X + DVec3::Z, DVec3::Y + DVec3::Z];
        assert_eq!(found(&[sliver, far]), [true, false]);
    }
}
