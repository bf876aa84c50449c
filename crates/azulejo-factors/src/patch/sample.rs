//! Points of a patch, uniform by area, from the unit square with little distortion.

use super::Patches;
use super::bent::onto;
use super::cells::Cells;
use azulejo_scene::SurfacePoint;
use glam::DVec3;

/// A point sampled uniformly by area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    /// Position on the patch.
    pub position: DVec3,
    /// Unit normal of the surface's front there.
    pub normal: DVec3,
    /// Weight of this point in a mean over samples; 1 on flat patches, with mean 1 on all.
    pub weight: f64,
}

/// Samples points of one patch, with everything shared looked up once.
#[derive(Clone, Copy)]
pub struct Sampler<'a> {
    patches: &'a Patches,
    patch: usize,
    /// Unit normal; zero on a curved patch.
    normal: DVec3,
    form: SampledForm,
    /// The triangles that the tracer sees, where they are not in one plane.
    bent: Option<&'a [[DVec3; 3]]>,
}

/// The form of a flat patch.
#[derive(Clone, Copy)]
enum SampledForm {
    /// The first corner, and from it to the other two.
    Triangle([DVec3; 3]),
    /// Four corners, and the density of area at them.
    Quad([DVec3; 4], [f64; 4]),
    Curved,
}

impl Sampler<'_> {
    /// The point for `(u1, u2)` in the unit square: see [`Patches::sample`].
    pub fn sample(&self, u1: f64, u2: f64) -> PatchPoint {
        let position = match &self.form {
            SampledForm::Curved => return self.patches.sample_curved(self.patch, u1, u2),
            &SampledForm::Triangle([corner, e, f]) => {
                let (v, w) = triangle_from_square(u1, u2);
                corner + v * e + w * f
            }
            &SampledForm::Quad([a, b, c, d], densities) => {
                let (s, t, _) = sample_bilinear(densities, u1, u2);
                let (low, high) = (a + s * (b - a), d + s * (c - d));
                low + t * (high - low)
            }
        };
        let position = match self.bent {
            Some(triangles) => onto(triangles, self.normal, position),
            None => position,
        };
        PatchPoint {
            position,
            normal: self.normal,
            weight: 1.0,
        }
    }
}

impl Patches {
    /// The point of patch `i` for `(u1, u2)` in the unit square.
    ///
    /// Uniform points of the square give points uniform by area (times `weight` on curved patches),
    /// and neighbours stay neighbours, so stratification is preserved. Triangles: Heitz, *A
    /// Low-Distortion Map Between Triangle and Square*, 2019. Quadrilaterals: the inverse of the
    /// bilinear density. They lie on the triangles that the tracer sees, also where a face is not exactly flat.
    pub fn sample(&self, i: usize, u1: f64, u2: f64) -> PatchPoint {
        self.sampler(i).sample(u1, u2)
    }

    /// A sampler of patch `i`.
    pub fn sampler(&self, i: usize) -> Sampler<'_> {
        let normal = self.region(i).normal;
        let form = if normal == DVec3::ZERO {
            SampledForm::Curved
        } else {
            let polygon = self.corner_points(i);
            match *polygon {
                [a, b, c, d] => SampledForm::Quad([a, b, c, d], quad_densities(&polygon, normal)),
                [a, b, c] => SampledForm::Triangle([a, b - a, c - a]),
                _ => SampledForm::Triangle([polygon[0], DVec3::ZERO, DVec3::ZERO]),
            }
        };
        Sampler {
            patches: self,
            patch: i,
            normal,
            form,
            bent: self.bent.get(&self.owner[i]).map(|triangles| &**triangles),
        }
    }

    fn sample_curved(&self, i: usize, u1: f64, u2: f64) -> PatchPoint {
        let (s, t, weight) = self.sample_parameters(i, u1, u2);
        let point = self.curved_point(i, s, t);
        PatchPoint {
            position: point.position,
            normal: point.normal,
            weight,
        }
    }

    /// Parameters in the unit square of a curved patch for `(u1, u2)`, and the weight of the point.
    pub(super) fn sample_parameters(&self, i: usize, u1: f64, u2: f64) -> (f64, f64, f64) {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let densities = corners.map(|(s, t)| self.curved_point(i, s, t).area_density);
        let (s, t, pdf) = sample_bilinear(lifted(densities), u1, u2);
        let (nu, nv) = self.part_grid(i);
        // area_density is per unit of the part's u v, of which a cell has 1/(nu nv).
        let density = self.curved_point(i, s, t).area_density;
        let cell_density = density / (f64::from(nu) * f64::from(nv));
        (s, t, cell_density / (pdf * self.areas[i]))
    }

    /// The point of a primitive's cell at `(s, t)` in the unit square.
    pub(super) fn curved_point(&self, i: usize, s: f64, t: f64) -> SurfacePoint {
        let face = self.region(i).face;
        let (nu, nv) = self.part_grid(i);
        let cell = i as u32 - self.region_patches[self.owner[i] as usize];
        let u = (f64::from(cell % nu) + s) / f64::from(nu);
        let v = (f64::from(cell / nu) + t) / f64::from(nv);
        match &self.primitives[face.object as usize] {
            Some(p) => p.point(face.face as usize, u, v),
            // Only regions of primitives have no normal of their own.
            None => SurfacePoint {
                position: DVec3::ZERO,
                normal: DVec3::Z,
                area_density: 0.0,
            },
        }
    }

    fn part_grid(&self, i: usize) -> (u32, u32) {
        match self.cells[self.owner[i] as usize] {
            Cells::Part { nu, nv } => (nu, nv),
            _ => (1, 1),
        }
    }
}

/// Barycentric weights of corners 1 and 2.
fn triangle_from_square(u1: f64, u2: f64) -> (f64, f64) {
    if u2 > u1 {
        let x = 0.5 * u1;
        (x, u2 - x)
    } else {
        let y = 0.5 * u2;
        (u1 - y, y)
    }
}

/// Area per unit of parameters at the corners of a quadrilateral; bilinear in between.
fn quad_densities(p: &[DVec3], normal: DVec3) -> [f64; 4] {
    lifted([0, 1, 2, 3].map(|k| {
        let (next, before) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        next.cross(before).dot(normal)
    }))
}

/// Keeps densities away from zero (poles, flat corners), where their inverse is undefined.
fn lifted(densities: [f64; 4]) -> [f64; 4] {
    let most = densities.iter().fold(f64::MIN_POSITIVE, |a, &b| a.max(b));
    densities.map(|d| d.max(1e-3 * most))
}

/// A point of the unit square by a bilinear density with the values `w` at (0,0), (1,0), (1,1)
/// and (0,1), all > 0; and the density there, normalized.
fn sample_bilinear(w: [f64; 4], u1: f64, u2: f64) -> (f64, f64, f64) {
    if w.iter().all(|x| (x - w[0]).abs() <= 1e-9 * w[0]) {
        return (u1, u2, 1.0);
    }
    let t = sample_linear(w[0] + w[1], w[3] + w[2], u2);
    let left = w[0] + t * (w[3] - w[0]);
    let right = w[1] + t * (w[2] - w[1]);
    let s = sample_linear(left, right, u1);
    let mean = 0.25 * (w[0] + w[1] + w[2] + w[3]);
    (s, t, (left + s * (right - left)) / mean)
}

/// A number in 0..=1 by a density linear from `a` to `b`.
fn sample_linear(a: f64, b: f64, u: f64) -> f64 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    (u * (a + b) / (a + root)).min(1.0)
}
