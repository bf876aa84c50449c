//! What may occlude: convex blockers, and bounding boxes of curved objects.

use super::convex_merge::{ConvexPolygon, merged};
use super::images::FlatMirror;
use super::planes::SurfacePlanes;
use crate::analytic::Blocker;
use crate::patch::Patches;
use crate::row::Side;
use azulejo_scene::math::{Aabb, Frame, Ray, area_vector};
use azulejo_trace::sampling::{cosine_about, sobol};
use azulejo_trace::{KernelRay, Surfaces};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};

/// All occluders of a scene.
pub(super) struct SceneOccluders {
    /// Flat ones, merged where patches are parts of one convex polygon, without walls that have the
    /// whole scene on one side.
    pub flat: Vec<Blocker>,
    /// Bounding boxes of objects with curved patches.
    pub curved: Vec<Aabb>,
    /// For each patch, whether the sides may see its back: it is not part of a closed surface, or
    /// some side is inside.
    pub shows_back: Vec<bool>,
    /// The planes of flat patches, and the depth that does not count.
    pub planes: SurfacePlanes,
    /// Size of the scene.
    pub size: f64,
}

impl SceneOccluders {
    /// The occluders as seen from some sides of patches.
    pub fn new(patches: &Patches, surfaces: &Surfaces, sides: &[Side]) -> SceneOccluders {
        let flat: Vec<usize> = (0..patches.len())
            .filter(|&i| patches.polygon(i).is_some())
            .collect();
        let polygons: Vec<Vec<DVec3>> = flat
            .iter()
            .filter_map(|&i| Some(patches.polygon(i)?.to_vec()))
            .collect();
        let bounds = |i: usize| surfaces.scene.objects[patches.face(i).object as usize].bounds();
        let mut curved: Vec<Aabb> = (0..patches.len())
            .filter(|&i| patches.polygon(i).is_none())
            .map(bounds)
            .collect();
        curved.dedup();
        let points = polygons.iter().flatten().copied();
        let bounds = curved
            .iter()
            .fold(Aabb::around(points), |all, b| all.union(*b));
        let size = bounds.diagonal();
        let planes = SurfacePlanes::new(patches, surfaces.scene, &bounds);
        let numbers: Vec<u32> = flat.iter().map(|&i| planes.number(i)).collect();
        let (joined, flat_surfaces) = merged(&polygons, &numbers, size, planes.graze);
        let mut surface = vec![None; patches.len()];
        let known = flat.iter().zip(&flat_surfaces);
        known.for_each(|(&i, &of)| surface[i] = of);
        let mut entered = seen_from_inside(patches, surfaces, sides, &surface);
        // Rows on backs see the backs of their own surface wherever it is not convex.
        let own_backs = sides.iter().filter(|&side| side % 2 == 1);
        entered.extend(own_backs.filter_map(|&side| surface[(side / 2) as usize]));
        entered.extend(inside_out(&polygons, &flat_surfaces, &bounds));
        let is_inside = |of: &Option<u32>| of.is_none_or(|s| entered.contains(&s));
        let shows_back = surface.iter().map(is_inside).collect();
        let blocker = |part: ConvexPolygon| {
            let front = area_vector(&part.polygon).normalize_or_zero();
            let plane = planes.of(flat[part.first], front)?;
            let mut blocker = Blocker::facing(part.polygon.into_iter().collect(), plane.normal)?;
            blocker.offset = plane.offset;
            blocker.graze = planes.graze.max(2.0 * plane.thickness);
            blocker.is_one_sided = part.surface.is_some_and(|s| !entered.contains(&s));
            Some(blocker)
        };
        let corners = ExtremePoints::new(&polygons, &curved);
        let blockers = joined.into_iter().filter_map(blocker);
        SceneOccluders {
            flat: blockers.filter(|b| !corners.is_wall(b, size)).collect(),
            curved,
            shows_back,
            planes,
            size,
        }
    }
}

impl SceneOccluders {
    /// Mirrors: coplanar patches of one material, merged.
    pub fn mirrors(&self, patches: &Patches, surfaces: &Surfaces, of: &[usize]) -> Vec<FlatMirror> {
        let mut materials: Vec<u32> = of.iter().map(|&i| patches.material(i)).collect();
        materials.sort_unstable();
        materials.dedup();
        let joined = materials.iter().flat_map(|&material| {
            let flat = of.iter().filter(|&&i| patches.material(i) == material);
            let (planes, polygons): (Vec<u32>, Vec<Vec<DVec3>>) = flat
                .filter_map(|&i| Some((self.planes.number(i), patches.polygon(i)?.to_vec())))
                .unzip();
            let reflectance = surfaces.scene.materials[material as usize].mirror;
            let (joined, _) = merged(&polygons, &planes, self.size, self.planes.graze);
            joined.into_iter().map(move |j| FlatMirror {
                polygon: j.polygon,
                reflectance,
            })
        });
        joined.collect()
    }
}

/// Rays per side that test for insides of closed surfaces.
const PROBE_RAYS: u32 = 8;

/// The closed surfaces whose inside some side sees, because objects stand in them or cross them.
fn seen_from_inside(
    patches: &Patches,
    surfaces: &Surfaces,
    sides: &[Side],
    surface: &[Option<u32>],
) -> HashSet<u32> {
    let tracer = surfaces.tracer;
    let seen = |&side: &Side| {
        let (patch, flip) = ((side / 2) as usize, if side % 2 == 0 { 1.0 } else { -1.0 });
        let ray = |k: u32| {
            let [u1, u2, u3, u4] = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, side)));
            let at = patches.sample(patch, u1, u2);
            let normal = flip * at.normal;
            let way = cosine_about(&Frame::from_normal(normal), u3, u4);
            tracer.kernel_ray(&Ray::new(tracer.leaving(at.position, normal), way))
        };
        let rays: Vec<KernelRay> = (0..PROBE_RAYS).map(ray).collect();
        let mut hits = Vec::new();
        tracer.closest(&rays, &mut hits);
        let backs = rays
            .iter()
            .zip(hits)
            .filter(|(ray, hit)| hit.is_hit() && !surfaces.is_front(ray, hit));
        let surface_ids =
            backs.filter_map(|(_, hit)| surface[patches.locate_hit(surfaces, &hit) as usize]);
        // One or two rays may have slipped through a crack between triangles.
        let mut surface_ids: Vec<u32> = surface_ids.collect();
        surface_ids.sort_unstable();
        let many = surface_ids
            .chunk_by(|a, b| a == b)
            .filter(|group| 2 * group.len() as u32 >= PROBE_RAYS);
        many.map(|group| group[0]).collect::<Vec<u32>>()
    };
    sides.par_iter().flat_map_iter(seen).collect()
}

/// The closed surfaces whose fronts are inside, and outside of whose bounds there is something that may see
/// their backs: bodies that are turned inside out, but not the room that all the rest is in.
fn inside_out(polygons: &[Vec<DVec3>], surface: &[Option<u32>], scene: &Aabb) -> Vec<u32> {
    let mut closed: BTreeMap<u32, (f64, Aabb)> = BTreeMap::new();
    for (polygon, of) in polygons.iter().zip(surface) {
        let Some(of) = of else { continue };
        let (volume, bounds) = closed.entry(*of).or_insert((0.0, Aabb::EMPTY));
        // Gauss's theorem, about a point nearby, so that distant scenes do not cancel.
        *volume += area_vector(polygon).dot(polygon[0] - scene.centre()) / 3.0;
        *bounds = polygon.iter().fold(*bounds, |all, &c| all.with_point(c));
    }
    let is_seen = |(volume, bounds): &(f64, Aabb)| *volume < 0.0 && !contains(bounds, scene);
    let seen = closed.into_iter().filter(|(_, of)| is_seen(of));
    seen.map(|(surface, _)| surface).collect()
}

/// Whether a box contains another, but for rounding.
fn contains(outer: &Aabb, inner: &Aabb) -> bool {
    let margin = DVec3::splat(1e-9 * inner.diagonal());
    (outer.min - margin).cmple(inner.min).all() && (outer.max + margin).cmpge(inner.max).all()
}

/// The corners of the scene, the outermost first.
struct ExtremePoints {
    corners: Vec<DVec3>,
}

impl ExtremePoints {
    fn new(polygons: &[Vec<DVec3>], curved: &[Aabb]) -> ExtremePoints {
        let ends = curved.iter().flat_map(|b| {
            (0..8).map(|k| {
                let pick = |axis: usize| {
                    if k >> axis & 1 == 0 {
                        b.min[axis]
                    } else {
                        b.max[axis]
                    }
                };
                DVec3::new(pick(0), pick(1), pick(2))
            })
        });
        let mut corners: Vec<DVec3> = polygons.iter().flatten().copied().chain(ends).collect();
        for (k, way) in directions().enumerate() {
            let furthest =
                |a: &usize, b: &usize| corners[*a].dot(way).total_cmp(&corners[*b].dot(way));
            if let Some(i) = (k..corners.len()).max_by(furthest) {
                corners.swap(k, i);
            }
        }
        ExtremePoints { corners }
    }

    /// Whether the whole scene lies on one side, so that the polygon occludes nothing.
    fn is_wall(&self, blocker: &Blocker, size: f64) -> bool {
        let (mut is_above, mut is_below) = (false, false);
        let graze = blocker.graze.max(1e-9 * size);
        self.corners.iter().all(|&c| {
            let height = blocker.height(c);
            is_above |= height > graze;
            is_below |= height < -graze;
            !(is_above && is_below)
        })
    }
}

/// The axes and diagonals.
fn directions() -> impl Iterator<Item = DVec3> {
    let step = |k: i32| f64::from(k % 3 - 1);
    (0..27)
        .map(move |k| DVec3::new(step(k), step(k / 3), step(k / 9)))
        .filter(|d| *d != DVec3::ZERO)
}
