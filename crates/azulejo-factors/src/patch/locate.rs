//! From a hit to its patch.

use super::Patches;
use super::cells::{Cells, NO_CORNER};
use super::irregular::{Irregular, bounds};
use super::outline::Outline;
use azulejo_scene::PrimitiveKind;
use glam::DVec2;

/// How a region's patches are found from plane coordinates.
#[derive(Clone, Copy)]
enum Finder {
    /// No patch, or only one.
    One,
    /// A bilinear grid; `(a, b)` is how far corner 2 is from completing a parallelogram.
    Quad { nu: u32, nv: u32, a: f32, b: f32 },
    /// Congruent triangles.
    Triangle { k: u32 },
    /// Bins over a plane.
    Bins(u32),
    /// Cells of `u`, `v`.
    Part { nu: u32, nv: u32 },
}

/// Everything that [`Patches::locate`] reads.
#[derive(Default)]
pub(super) struct Locator {
    /// First patch and finder of each region, and where the corners of its triangles are stored.
    regions: Vec<(u32, u32, Finder)>,
    /// Plane coordinates of the corners of each tracer triangle: the first corner, and from it
    /// to the other two.
    corners: Vec<[f32; 6]>,
    bins: Vec<Bins>,
}

impl Locator {
    pub fn new(outline: &Outline, cells: &[Cells], region_patches: &[u32]) -> Locator {
        let mut locator = Locator::default();
        for ((region, cells), &first) in outline.regions.iter().zip(cells).zip(region_patches) {
            let start = locator.corners.len() as u32;
            let (plane, finder) = locator.plane(outline, region, cells);
            for t in outline.triangles_of(region) {
                let p = t.map(|k| plane.get(k as usize).copied().unwrap_or_default());
                let (e, f) = (p[1] - p[0], p[2] - p[0]);
                locator
                    .corners
                    .push([p[0].x, p[0].y, e.x, e.y, f.x, f.y].map(|x| x as f32));
            }
            locator.regions.push((first, start, finder));
        }
        locator
    }

    /// Coordinates of a region's corners in the plane that its finder uses.
    fn plane(
        &mut self,
        outline: &Outline,
        region: &super::outline::Region,
        cells: &Cells,
    ) -> (Vec<DVec2>, Finder) {
        match cells {
            Cells::None => (Vec::new(), Finder::One),
            &Cells::Part { nu, nv } => (Vec::new(), Finder::Part { nu, nv }),
            &Cells::Triangle { k } => (
                vec![DVec2::ZERO, DVec2::X, DVec2::Y],
                if k == 1 {
                    Finder::One
                } else {
                    Finder::Triangle { k }
                },
            ),
            &Cells::Quad { nu, nv } => {
                let p: Vec<_> = outline
                    .slots_of(region)
                    .iter()
                    .map(|s| s.position)
                    .collect();
                let (e, f, d) = (p[1] - p[0], p[3] - p[0], p[2] - p[0]);
                let whole = e.cross(f).dot(region.normal);
                let opposite = DVec2::new(
                    d.cross(f).dot(region.normal) / whole,
                    e.cross(d).dot(region.normal) / whole,
                );
                let (a, b) = ((opposite.x - 1.0) as f32, (opposite.y - 1.0) as f32);
                let finder = if nu * nv == 1 {
                    Finder::One
                } else {
                    Finder::Quad { nu, nv, a, b }
                };
                (vec![DVec2::ZERO, DVec2::X, opposite, DVec2::Y], finder)
            }
            Cells::Irregular(mesh) => {
                self.bins.push(Bins::new(mesh));
                (
                    mesh.corners.clone(),
                    Finder::Bins(self.bins.len() as u32 - 1),
                )
            }
        }
    }
}

/// Whether a primitive's patches are flat parallelograms.
pub(super) fn is_flat(kind: PrimitiveKind) -> bool {
    matches!(kind, PrimitiveKind::Cuboid | PrimitiveKind::Square)
}

impl Patches {
    /// The patch that a hit lies on.
    /// `triangle` counts the face's triangles as `Mesh::triangulate` returns them; `u`, `v` are the
    /// weights of that triangle's corners 1 and 2. For an exact primitive `face` is the part and
    /// `u`, `v` its parameters. Every input gives a patch: near a border rounding may choose the
    /// neighbour, and a face without patches gives some patch near it in the numbering (0 in an
    /// empty scene).
    pub fn locate(&self, object: u32, face: u32, triangle: u32, u: f32, v: f32) -> u32 {
        let patch = self.find(object, face, triangle, u, v).unwrap_or(0);
        patch.min((self.corners.len() as u32).saturating_sub(1))
    }

    /// The patch of a triangle or part that is a single patch.
    pub fn only_patch(&self, object: u32, face: u32, triangle: u32) -> Option<u32> {
        let [start, end] = self.face_ends(object, face)?;
        let region = start + triangle.min((end - start).checked_sub(1)?);
        match *self.locator.regions.get(region as usize)? {
            (first, _, Finder::One) if (first as usize) < self.corners.len() => Some(first),
            _ => None,
        }
    }

    /// The first region of a face, and the first after it.
    fn face_ends(&self, object: u32, face: u32) -> Option<[u32; 2]> {
        let face = self.face_base.get(object as usize)?.checked_add(face)? as usize;
        let ends = self.face_regions.get(face..face.checked_add(2)?)?;
        Some([ends[0], ends[1]])
    }

    fn find(&self, object: u32, face: u32, triangle: u32, u: f32, v: f32) -> Option<u32> {
        let [start, end] = self.face_ends(object, face)?;
        // A bent face has one region per triangle.
        let (region, triangle) = if end - start > 1 {
            (start + triangle.min(end - start - 1), 0)
        } else {
            (start, triangle)
        };
        let (first, corners, finder) = *self.locator.regions.get(region as usize)?;
        let plane = || -> Option<(f32, f32)> {
            let c = self
                .locator
                .corners
                .get(corners as usize + triangle as usize)?;
            Some((c[0] + u * c[2] + v * c[4], c[1] + u * c[3] + v * c[5]))
        };
        let local = match finder {
            Finder::One => 0,
            Finder::Part { nu, nv } => grid_cell(u, v, nu, nv),
            Finder::Quad { nu, nv, a, b } => {
                let (x, y) = plane()?;
                let (s, t) = inverse_bilinear(x, y, a, b);
                grid_cell(s, t, nu, nv)
            }
            Finder::Triangle { k } => {
                let (x, y) = plane()?;
                triangle_cell(x, y, k)
            }
            Finder::Bins(i) => {
                let (x, y) = plane()?;
                self.locator.bins[i as usize].find(x, y)
            }
        };
        Some(first + local)
    }
}

fn grid_cell(s: f32, t: f32, nu: u32, nv: u32) -> u32 {
    // Conversions saturate and take NaN to 0, so every input has a cell.
    let cell = |x: f32, n: u32| ((x * n as f32) as u32).min(n - 1);
    cell(t, nv) * nu + cell(s, nu)
}

/// The `(s, t)` with `s + a s t = x` and `t + b s t = y`.
fn inverse_bilinear(x: f32, y: f32, a: f32, b: f32) -> (f32, f32) {
    if a == 0.0 && b == 0.0 {
        return (x, y); // a parallelogram, the common case
    }
    let half = 1.0 + a * y - b * x;
    let root = (half * half + 4.0 * b * x).max(0.0).sqrt();
    let s = 2.0 * x / (half + root);
    (s, y / (1.0 + b * s))
}

/// Which of the `k²` triangles contains the point with weights `x`, `y` of corners 1 and 2.
fn triangle_cell(x: f32, y: f32, k: u32) -> u32 {
    let scale = k as f32;
    let (x, y) = ((x * scale).max(0.0), (y * scale).max(0.0));
    let j = (y as u32).min(k - 1);
    let i = (x as u32).min(k - 1 - j);
    let upper = x - i as f32 + (y - j as f32) > 1.0 && i + 1 < k - j;
    // Rows below j have 2(k − r) − 1 triangles each.
    j * (2 * k - j) + 2 * i + u32::from(upper)
}

/// Patches of an irregular region in the bins of a uniform grid aligned with the lattice, so that
/// most bins lie in one square.
struct Bins {
    low: [f32; 2],
    per_unit: f32,
    count: [u32; 2],
    starts: Vec<u32>,
    /// Patches that overlap each bin; at least one per bin.
    items: Vec<u32>,
    /// The number of patches that are squares; these come first, then triangles.
    squares: u32,
    /// For each patch the affine functions that are the weights of the corners next to the first.
    weights: Vec<[f32; 6]>,
}

/// Limit of bins per patch: more leave fewer candidates in each, but take more memory.
const BINS_PER_PATCH: f64 = 4.0;
/// Bins along one direction.
const MOST_BINS: f64 = 4096.0;
/// A hit this far outside a patch is accepted without testing the others.
const NEAR_ENOUGH: f32 = -1e-6;

impl Bins {
    fn new(mesh: &Irregular) -> Bins {
        let (low, high) = bounds(&mesh.points);
        let size = high - low;
        let target = BINS_PER_PATCH * mesh.cells.len() as f64;
        // A needle's bounding box is nearly flat, so its area alone would require far too many
        // bins.
        let least = (size.x * size.y / target)
            .sqrt()
            .max(size.max_element() / target.clamp(1.0, MOST_BINS));
        let step = if mesh.spacing > least {
            mesh.spacing / (mesh.spacing / least).floor()
        } else {
            least
        };
        let low = mesh.origin + ((low - mesh.origin) / step).floor() * step;
        let count = ((high - low) / step).ceil().max(DVec2::ONE);
        let at = |k: u32| mesh.points[k as usize];
        let weights = |&[a, b, c, d]: &[u32; 4]| {
            let last = if d == NO_CORNER { c } else { d };
            affine_weights([a, b, last].map(at))
        };
        let mut bins = Bins {
            low: low.as_vec2().to_array(),
            per_unit: (1.0 / step) as f32,
            count: [count.x as u32, count.y as u32],
            starts: Vec::new(),
            items: Vec::new(),
            squares: mesh.squares as u32,
            weights: mesh.cells.iter().map(weights).collect(),
        };
        bins.fill(mesh, low, step);
        bins
    }

    fn fill(&mut self, mesh: &Irregular, low: DVec2, step: f64) {
        let [nx, ny] = self.count;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (i, cell) in (0..).zip(&mesh.cells) {
            let corners = cell.iter().filter(|&&k| k != NO_CORNER);
            let p: Vec<DVec2> = corners
                .map(|&k| (mesh.points[k as usize] - low) / step)
                .collect();
            let (least, most) = bounds(&p);
            // A square that touches a bin's border only by rounding does not count as overlapping
            // it.
            let range = |a: f64, b: f64, n: u32| {
                ((a + 1e-6) as u32).min(n - 1)..=((b - 1e-6) as u32).min(n - 1)
            };
            for y in range(least.y, most.y, ny) {
                for x in range(least.x, most.x, nx) {
                    if meets_bin(&p, x, y) {
                        pairs.push((y * nx + x, i));
                    }
                }
            }
        }
        let filled = super::Lists::new((nx * ny) as usize, pairs.iter().copied());
        let nearest = nearest_filled(&filled, self.count);
        self.starts.push(0);
        for bin in nearest {
            self.items.extend_from_slice(filled.get(bin as usize));
            self.starts.push(self.items.len() as u32);
        }
    }

    fn find(&self, x: f32, y: f32) -> u32 {
        let bin = |v: f32, axis: usize| {
            let b = (v - self.low[axis]) * self.per_unit;
            (b as u32).min(self.count[axis] - 1)
        };
        let bin = (bin(y, 1) * self.count[0] + bin(x, 0)) as usize;
        let (start, end) = (self.starts[bin] as usize, self.starts[bin + 1] as usize);
        if end - start == 1 {
            return self.items[start];
        }
        let mut best = (0, f32::NEG_INFINITY);
        for &i in &self.items[start..end] {
            let least = self.depth(i, x, y);
            if least >= NEAR_ENOUGH {
                return i;
            }
            if least > best.1 {
                best = (i, least);
            }
        }
        best.0
    }

    /// How far inside a patch a point is; negative outside.
    fn depth(&self, i: u32, x: f32, y: f32) -> f32 {
        let w = &self.weights[i as usize];
        let (b, c) = (w[0] + w[1] * x + w[2] * y, w[3] + w[4] * x + w[5] * y);
        let far = if i < self.squares {
            (1.0 - b).min(1.0 - c)
        } else {
            1.0 - b - c
        };
        b.min(c).min(far)
    }
}

/// For each bin the nearest one that has triangles (itself, if it has).
fn nearest_filled(lists: &super::Lists<u32>, [nx, ny]: [u32; 2]) -> Vec<u32> {
    let bins = nx * ny;
    let mut nearest = vec![u32::MAX; bins as usize];
    let mut queue: std::collections::VecDeque<u32> = (0..bins)
        .filter(|&b| !lists.get(b as usize).is_empty())
        .collect();
    queue.iter().for_each(|&b| nearest[b as usize] = b);
    while let Some(bin) = queue.pop_front() {
        let (x, y) = (bin % nx, bin / nx);
        let beside = [
            (x > 0).then(|| bin - 1),
            (x + 1 < nx).then(|| bin + 1),
            (y > 0).then(|| bin - nx),
            (y + 1 < ny).then(|| bin + nx),
        ];
        for other in beside.into_iter().flatten() {
            if nearest[other as usize] == u32::MAX {
                nearest[other as usize] = nearest[bin as usize];
                queue.push_back(other);
            }
        }
    }
    // Only a region without triangles has no filled bin; then every list is empty.
    nearest.iter().map(|&b| b.min(bins - 1)).collect()
}

/// Whether a convex polygon in bin coordinates may overlap the unit square at `(x, y)`;
/// conservative.
fn meets_bin(p: &[DVec2], x: u32, y: u32) -> bool {
    let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    (0..p.len()).all(|k| {
        let (a, b) = (p[k], p[(k + 1) % p.len()]);
        let side = b - a;
        // Half the extent of the square across the side.
        let reach = 0.501 * (side.x.abs() + side.y.abs());
        side.perp_dot(middle - a) >= -reach
    })
}

fn affine_weights([a, b, c]: [DVec2; 3]) -> [f32; 6] {
    let (e, f) = (b - a, c - a);
    let whole = e.perp_dot(f);
    // The weight of b is (p − a)×f / e×f, that of c is e×(p − a) / e×f.
    let row = |x: f64, y: f64| [-(x * a.x + y * a.y) / whole, x / whole, y / whole];
    let (b, c) = (row(f.y, -f.x), row(-e.y, e.x));
    [b[0], b[1], b[2], c[0], c[1], c[2]].map(|x| x as f32)
}
