//! Exchange areas of unoccluded pairs, by Gauss's rule on both facets.
//!
//! With the same number of points for all pairs, the sum over pairs of points is a plain loop over
//! columns, which the compiler vectorizes. For facets of radii r₁ and r₂ at distance d, m² points
//! on each have a relative error of about c (r₁ + r₂)^2m / d^2m.

use super::gauss_square;
use glam::DVec3;
use std::f64::consts::PI;
use std::ops::Range;

/// Relative error over (r₁ + r₂)⁴/d⁴ of four points on either facet, measured in the tests.
pub(super) const FOUR: f64 = 0.06;
/// Relative error over (r₁ + r₂)⁶/d⁶ of nine points on either facet.
pub(super) const NINE: f64 = 0.02;

/// Gauss points of many facets, `N` on each.
#[derive(Debug)]
pub(super) struct GaussPoints<const N: usize> {
    x: [Vec<f64>; N],
    y: [Vec<f64>; N],
    z: [Vec<f64>; N],
    /// Weights: areas.
    w: [Vec<f64>; N],
    /// The facets' planes: normal · p = offset.
    normals: [Vec<f64>; 3],
    offsets: Vec<f64>,
}

/// The points and the plane of one facet.
pub(super) struct FacetPoints<const N: usize> {
    points: [(DVec3, f64); N],
    normal: DVec3,
    offset: f64,
}

impl<const N: usize> GaussPoints<N> {
    pub fn new() -> GaussPoints<N> {
        let empty = || std::array::from_fn(|_| Vec::new());
        GaussPoints {
            x: empty(),
            y: empty(),
            z: empty(),
            w: empty(),
            normals: Default::default(),
            offsets: Vec::new(),
        }
    }

    /// Appends a facet.
    pub fn push(&mut self, polygon: &[DVec3], normal: DVec3) {
        let nodes = gauss_square::<N>(polygon, normal);
        for (k, (p, weight)) in nodes.into_iter().enumerate() {
            self.x[k].push(p.x);
            self.y[k].push(p.y);
            self.z[k].push(p.z);
            self.w[k].push(weight);
        }
        for axis in 0..3 {
            self.normals[axis].push(normal[axis]);
        }
        self.offsets
            .push(polygon.first().map_or(0.0, |p| p.dot(normal)));
    }

    pub fn own(&self, i: usize) -> FacetPoints<N> {
        let point = |k: usize| {
            let p = DVec3::new(self.x[k][i], self.y[k][i], self.z[k][i]);
            (p, self.w[k][i])
        };
        FacetPoints {
            points: std::array::from_fn(point),
            normal: DVec3::from_array(self.normals.each_ref().map(|n| n[i])),
            offset: self.offsets[i],
        }
    }

    /// Exchange areas of one facet with a range of others, into `into`. All must be fully in front
    /// of each other.
    pub fn exchange(&self, own: &FacetPoints<N>, others: Range<usize>, into: &mut [f64]) {
        let n = others.len();
        // Slices of equal length, so that the loop needs no bounds checks.
        let [x, y, z, w] = [&self.x, &self.y, &self.z, &self.w]
            .map(|v| v.each_ref().map(|v| &v[others.clone()][..n]));
        let [nx, ny, nz] = self.normals.each_ref().map(|v| &v[others.clone()][..n]);
        let (offsets, into) = (&self.offsets[others.clone()][..n], &mut into[..n]);
        for k in 0..n {
            let mut sum = 0.0;
            // Heights of the row's points above the column's plane, times their weights.
            let heights: [f64; N] = std::array::from_fn(|q| {
                let (p, weight) = own.points[q];
                (p.x * nx[k] + p.y * ny[k] + p.z * nz[k] - offsets[k]) * weight
            });
            for p in 0..N {
                let (x, y, z) = (x[p][k], y[p][k], z[p][k]);
                let height = own.normal.x * x + own.normal.y * y + own.normal.z * z - own.offset;
                let mut inner = 0.0;
                for (height, (o, _)) in heights.iter().zip(&own.points) {
                    let (dx, dy, dz) = (x - o.x, y - o.y, z - o.z);
                    let squared = dx * dx + dy * dy + dz * dz;
                    inner += height / (squared * squared);
                }
                sum += height * w[p][k] * inner;
            }
            into[k] = sum * (1.0 / PI);
        }
    }
}
