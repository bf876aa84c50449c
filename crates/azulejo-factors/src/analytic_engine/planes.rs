//! Which patches lie in one plane, within the rounding of their coordinates.
//!
//! A wall that is turned and written with six decimals is not a plane: its patches stick out of each other's
//! planes by the rounding, and would hide each other. Surfaces that share edges and deviate from one plane
//! by no more than their coordinates' rounding explains are therefore taken as one plane, fitted to all of
//! them; apart from each other, if their heights agree besides. How far corners really are from these
//! planes is the depth that does not count, so that where coordinates are exact, next to nothing is ignored.

use crate::patch::Patches;
use azulejo_scene::math::{Aabb, area_vector};
use azulejo_scene::{CoordinateDigits, CoordinateRounding, Scene};
use glam::DVec3;
use std::collections::{HashMap, VecDeque};

/// Distance of corners from a plane that rounding explains, in largest errors of a coordinate: an error
/// of √3 in space, of the corner and of the plane, and as much again where the plane goes on beyond its
/// corners.
const ROUNDINGS: f64 = 6.0;

/// The same for coordinates of any digits, over the size of the scene: programs that write models
/// calculate in single precision at best.
const LEAST_ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// More than this, over the size of the scene, is shape and no rounding, whatever the digits.
const MOST_ROUNDING: f64 = 1e-4;

/// Cosine of the angle up to which surfaces may lie in one plane: 1.1°.
const SAME_WAY: f64 = 0.999_8;

/// Depth that does not count beside rounding: that of double precision, over the size of the scene and
/// over its distance from the origin.
const GRAZE: [f64; 2] = [1e-10, 8.0 * f64::EPSILON];

/// A plane that surfaces lie in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePlane {
    /// Unit normal, and normal · p of its points.
    pub normal: DVec3,
    pub offset: f64,
    /// Largest distance of a corner.
    pub thickness: f64,
}

/// The planes of all flat patches.
pub(crate) struct SurfacePlanes {
    planes: Vec<SurfacePlane>,
    /// For each patch its plane, or [`CURVED`].
    of_patch: Vec<u32>,
    /// Depth that counts nowhere.
    pub graze: f64,
    /// What the coordinates' digits are, where that made a difference.
    pub rounding: Option<CoordinateRounding>,
}

/// The plane of patches that have none.
const CURVED: u32 = u32::MAX;

impl SurfacePlanes {
    /// The planes of some patches, of a scene of this size.
    pub fn new(patches: &Patches, scene: &Scene, bounds: &Aabb) -> SurfacePlanes {
        let size = bounds.diagonal();
        let roundings = scene.objects.iter().map(|o| o.shape.coordinate_rounding());
        let roundings: Vec<CoordinateRounding> = roundings.collect();
        let regions = flat_regions(patches, &roundings, size);
        let mut sheets = connected(&regions);
        let mut graze = depth(&sheets).max(exact_depth(bounds));
        let planes = coplanar(&mut sheets, graze);
        graze = graze.max(depth(&sheets));
        let mut of_patch = vec![CURVED; patches.len()];
        for (sheet, &plane) in sheets.iter().zip(&planes.of_sheet) {
            let members = sheet.regions.iter().flat_map(|&r| &regions[r].patches);
            members.for_each(|&patch| of_patch[patch] = plane);
        }
        let coarsest = |a: &CoordinateRounding, b: &CoordinateRounding| a.error.total_cmp(&b.error);
        SurfacePlanes {
            planes: planes.list,
            of_patch,
            graze: 2.0 * graze,
            rounding: roundings
                .into_iter()
                .max_by(coarsest)
                .filter(|_| graze > exact_depth(bounds)),
        }
    }

    /// The plane of a flat patch, with the normal of its front.
    pub fn of(&self, patch: usize, front: DVec3) -> Option<SurfacePlane> {
        let plane = self.planes.get(self.of_patch[patch] as usize)?;
        let sign = if plane.normal.dot(front) < 0.0 {
            -1.0
        } else {
            1.0
        };
        Some(SurfacePlane {
            normal: sign * plane.normal,
            offset: sign * plane.offset,
            ..*plane
        })
    }

    /// A number per patch, the same in one plane.
    pub fn number(&self, patch: usize) -> u32 {
        self.of_patch[patch]
    }

    /// What is taken as flat, in words; nothing where all coordinates are exact.
    pub fn note(&self) -> Option<String> {
        let rounding = self.rounding?;
        let digits = match rounding.digits {
            CoordinateDigits::Decimals(count) => format!("coordinates have {count} decimals"),
            CoordinateDigits::Single => "coordinates have single precision".to_owned(),
            CoordinateDigits::Double => "coordinates were calculated".to_owned(),
        };
        Some(format!(
            "faces within {:.2e} of one plane are taken to lie in it: {digits}",
            0.5 * self.graze
        ))
    }
}

/// The depth that rounding in double precision explains.
fn exact_depth(bounds: &Aabb) -> f64 {
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    0.5 * (GRAZE[0] * bounds.diagonal()).max(GRAZE[1] * reach)
}

/// The largest depth of sheets that are flat but for rounding.
fn depth(sheets: &[Sheet]) -> f64 {
    let flat = sheets.iter().filter(|s| s.plane.thickness <= s.tolerance);
    flat.map(|s| s.plane.thickness).fold(0.0, f64::max)
}

/// The patches of a flat piece of a face.
struct FlatRegion {
    patches: Vec<usize>,
    corners: Vec<DVec3>,
    area: DVec3,
    plane: SurfacePlane,
    /// Distance from a plane that rounding explains.
    tolerance: f64,
    /// Regions across its edges.
    neighbours: Vec<usize>,
}

fn flat_regions(patches: &Patches, roundings: &[CoordinateRounding], size: f64) -> Vec<FlatRegion> {
    let tolerance = |object: u32| {
        let error = roundings.get(object as usize).map_or(0.0, |r| r.error);
        (ROUNDINGS * error).clamp(LEAST_ROUNDING * size, MOST_ROUNDING * size)
    };
    let mut regions: Vec<FlatRegion> = Vec::new();
    let mut numbers: HashMap<u32, usize> = HashMap::new();
    let mut edges: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    for patch in 0..patches.len() {
        let Some(polygon) = patches.polygon(patch) else {
            continue;
        };
        let number = *numbers
            .entry(patches.region_number(patch))
            .or_insert_with(|| {
                regions.push(FlatRegion::empty(tolerance(patches.face(patch).object)));
                regions.len() - 1
            });
        regions[number].add(patch, &polygon);
        for (k, &start) in polygon.iter().enumerate() {
            let ends = [start, polygon[(k + 1) % polygon.len()]].map(bits);
            if let Some(&other) = edges.get(&[ends[1], ends[0]])
                && other != number
            {
                regions[number].neighbours.push(other);
                regions[other].neighbours.push(number);
            }
            edges.insert(ends, number);
        }
    }
    for region in &mut regions {
        region.neighbours.sort_unstable();
        region.neighbours.dedup();
        region.plane = fitted(region.area, &region.corners);
    }
    regions
}

/// A position as a key.
fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

impl FlatRegion {
    fn empty(tolerance: f64) -> FlatRegion {
        FlatRegion {
            patches: Vec::new(),
            corners: Vec::new(),
            area: DVec3::ZERO,
            plane: fitted(DVec3::ZERO, &[]),
            tolerance,
            neighbours: Vec::new(),
        }
    }

    fn add(&mut self, patch: usize, polygon: &[DVec3]) {
        self.patches.push(patch);
        self.corners.extend(polygon);
        self.area += area_vector(polygon);
    }
}

/// The plane with the normal of an area vector through the mean of some points.
fn fitted(area: DVec3, points: &[DVec3]) -> SurfacePlane {
    let normal = area.normalize_or_zero();
    let first = points.first().copied().unwrap_or_default();
    // From a point nearby, so that large coordinates do not cancel.
    let heights = || points.iter().map(|&p| normal.dot(p - first));
    let mean = heights().sum::<f64>() / points.len().max(1) as f64;
    SurfacePlane {
        normal,
        offset: normal.dot(first) + mean,
        thickness: heights().map(|h| (h - mean).abs()).fold(0.0, f64::max),
    }
}

/// Regions that hang together and lie in one plane.
struct Sheet {
    regions: Vec<usize>,
    corners: Vec<DVec3>,
    area: DVec3,
    plane: SurfacePlane,
    tolerance: f64,
}

impl Sheet {
    fn of(number: usize, region: &FlatRegion) -> Sheet {
        Sheet {
            regions: vec![number],
            corners: region.corners.clone(),
            area: region.area,
            plane: region.plane,
            tolerance: region.tolerance,
        }
    }

    /// Whether a region deviates from the plane by no more than rounding explains.
    fn takes(&self, region: &FlatRegion) -> bool {
        let tolerance = self.tolerance.max(region.tolerance);
        self.plane.normal.dot(region.plane.normal) > SAME_WAY
            && lie_in(&self.plane, &region.corners, tolerance)
    }

    fn add(&mut self, number: usize, region: &FlatRegion) {
        self.regions.push(number);
        self.corners.extend(&region.corners);
        self.area += region.area;
        self.tolerance = self.tolerance.max(region.tolerance);
        self.plane = SurfacePlane {
            thickness: self.plane.thickness,
            ..fitted(self.area, &self.corners)
        };
    }
}

/// Whether points are within a distance of a plane.
fn lie_in(plane: &SurfacePlane, points: &[DVec3], distance: f64) -> bool {
    let height = |p: &DVec3| (plane.normal.dot(*p) - plane.offset).abs();
    points.iter().all(|p| height(p) <= distance)
}

/// Sheets of connected regions, each grown from its largest, by area.
fn connected(regions: &[FlatRegion]) -> Vec<Sheet> {
    let mut order: Vec<usize> = (0..regions.len()).collect();
    let size = |&r: &usize| regions[r].area.length_squared();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let mut is_taken = vec![false; regions.len()];
    let mut sheets = Vec::new();
    for seed in order {
        if std::mem::replace(&mut is_taken[seed], true) {
            continue;
        }
        let mut sheet = Sheet::of(seed, &regions[seed]);
        let mut border: VecDeque<usize> = regions[seed].neighbours.iter().copied().collect();
        while let Some(next) = border.pop_front() {
            if !is_taken[next] && sheet.takes(&regions[next]) {
                is_taken[next] = true;
                sheet.add(next, &regions[next]);
                border.extend(&regions[next].neighbours);
            }
        }
        sheet.plane = fitted(sheet.area, &sheet.corners);
        sheets.push(sheet);
    }
    sheets
}

/// The planes of sheets.
struct CommonPlanes {
    list: Vec<SurfacePlane>,
    of_sheet: Vec<u32>,
}

/// Cells of normals, in which planes are looked up.
const NORMAL_CELLS: f64 = 16.0;

/// Gives sheets that do not hang together one plane, facing the same way or not, where their heights
/// agree: rounding moves the corners of one by `depth`, but all of a sheet lies above another only if it
/// was made so.
fn coplanar(sheets: &mut [Sheet], depth: f64) -> CommonPlanes {
    let mut list: Vec<SurfacePlane> = Vec::new();
    let mut of_sheet = Vec::with_capacity(sheets.len());
    let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
    for sheet in sheets.iter() {
        let own = &sheet.plane;
        let (normal, offset) = if is_upper(own.normal) {
            (own.normal, own.offset)
        } else {
            (-own.normal, -own.offset)
        };
        let is_same = |plane: &SurfacePlane| {
            let heights = || {
                sheet
                    .corners
                    .iter()
                    .map(|&p| plane.normal.dot(p) - plane.offset)
            };
            let mean = heights().sum::<f64>() / sheet.corners.len() as f64;
            plane.normal.dot(normal).abs() > SAME_WAY
                && mean.abs() <= 2.0 * (own.thickness.max(depth) + plane.thickness.max(depth))
                && heights().all(|h| h.abs() <= sheet.tolerance)
        };
        // Normals just at the border between ways are in either half.
        let candidates = [normal, -normal].into_iter().flat_map(near_cells);
        let known = candidates.filter_map(|cell| cells.get(&cell)).flatten();
        let number = known.copied().filter(|&k| is_same(&list[k as usize])).min();
        of_sheet.push(number.unwrap_or_else(|| {
            let number = list.len() as u32;
            list.push(SurfacePlane {
                normal,
                offset,
                ..*own
            });
            cells.entry(cell_of(normal)).or_default().push(number);
            number
        }));
    }
    for (sheet, &number) in sheets.iter_mut().zip(&of_sheet) {
        let plane = &mut list[number as usize];
        let heights = sheet
            .corners
            .iter()
            .map(|&p| (plane.normal.dot(p) - plane.offset).abs());
        plane.thickness = heights.fold(plane.thickness, f64::max);
        sheet.plane.thickness = plane.thickness;
    }
    CommonPlanes { list, of_sheet }
}

/// One of each two opposite normals.
fn is_upper(normal: DVec3) -> bool {
    normal.to_array().into_iter().find(|x| x.abs() > 1e-3) > Some(0.0)
}

fn cell_of(normal: DVec3) -> [i32; 3] {
    (normal * NORMAL_CELLS).round().to_array().map(|x| x as i32)
}

/// The cell of a normal and those around it.
fn near_cells(normal: DVec3) -> impl Iterator<Item = [i32; 3]> {
    let [x, y, z] = cell_of(normal);
    (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1])
}
