//! The division of one region: its points and the cells between them.

use super::irregular::Irregular;

/// Marks the missing fourth corner of a triangle.
pub(super) const NO_CORNER: u32 = u32::MAX;

/// The division of a region. Its points are numbered locally, row by row.
pub(super) enum Cells {
    /// No patch.
    None,
    /// A grid of `nu × nv` quadrilaterals; side 0 has `nu` pieces, side 1 has `nv`.
    Quad { nu: u32, nv: u32 },
    /// `k²` congruent triangles.
    Triangle { k: u32 },
    /// Squares and triangles without a regular pattern.
    Irregular(Box<Irregular>),
    /// A grid over the parameters of a primitive's part.
    Part { nu: u32, nv: u32 },
}

/// Where a local point lies in its region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CornerOrigin {
    /// Point `step` of a side, 0 being the corner at which the side starts.
    Side { side: u32, step: u32 },
    /// Inside, in the order of numbering.
    Inside,
}

impl Cells {
    /// Number of patches.
    pub fn len(&self) -> usize {
        match self {
            Cells::None => 0,
            Cells::Quad { nu, nv } | Cells::Part { nu, nv } => *nu as usize * *nv as usize,
            Cells::Triangle { k } => *k as usize * *k as usize,
            Cells::Irregular(mesh) => mesh.cells.len(),
        }
    }

    /// The local corners of every patch in order, counter-clockwise from the front (for parts of
    /// primitives: in the direction of `u`, `v`).
    pub fn for_each(&self, mut f: impl FnMut([u32; 4])) {
        match *self {
            Cells::None => {}
            Cells::Quad { nu, nv } | Cells::Part { nu, nv } => {
                let row = nu + 1;
                for j in 0..nv {
                    for i in 0..nu {
                        let p = j * row + i;
                        f([p, p + 1, p + row + 1, p + row]);
                    }
                }
            }
            Cells::Triangle { k } => {
                for j in 0..k {
                    let (row, above) = (triangle_row(k, j), triangle_row(k, j + 1));
                    for i in 0..k - j {
                        f([row + i, row + i + 1, above + i, NO_CORNER]);
                        if i + 1 < k - j {
                            f([row + i + 1, above + i + 1, above + i, NO_CORNER]);
                        }
                    }
                }
            }
            Cells::Irregular(ref mesh) => {
                mesh.cells.iter().for_each(|&ring| f(ring));
            }
        }
    }

    /// Calls `f` with the origin of every local point in order. Not for parts of primitives.
    pub fn for_each_point(&self, mut f: impl FnMut(CornerOrigin)) {
        let side = |side, step| CornerOrigin::Side { side, step };
        match *self {
            Cells::None | Cells::Part { .. } => {}
            Cells::Quad { nu, nv } => {
                for (i, j) in (0..=nv).flat_map(|j| (0..=nu).map(move |i| (i, j))) {
                    f(if j == 0 && i < nu {
                        side(0, i)
                    } else if i == nu && j < nv {
                        side(1, j)
                    } else if j == nv && i > 0 {
                        side(2, nu - i)
                    } else if i == 0 {
                        side(3, nv - j)
                    } else {
                        CornerOrigin::Inside
                    });
                }
            }
            Cells::Triangle { k } => {
                for (i, j) in (0..=k).flat_map(|j| (0..=k - j).map(move |i| (i, j))) {
                    f(if j == 0 && i < k {
                        side(0, i)
                    } else if i + j == k && j < k {
                        side(1, j)
                    } else if i == 0 {
                        side(2, k - j)
                    } else {
                        CornerOrigin::Inside
                    });
                }
            }
            Cells::Irregular(ref mesh) => {
                for (s, &count) in mesh.sides.iter().enumerate() {
                    (0..count).for_each(|step| f(side(s as u32, step)));
                }
                (0..mesh.points.len() - mesh.border()).for_each(|_| f(CornerOrigin::Inside));
            }
        }
    }

    /// Calls `f` for every local point in order with its weights over the region's corners,
    /// which sum to 1 (pairs of corner and weight). Not for parts of primitives.
    pub fn for_each_weight(&self, mut f: impl FnMut(&[(u32, f64)])) {
        match *self {
            Cells::None | Cells::Part { .. } => {}
            Cells::Quad { nu, nv } => {
                for j in 0..=nv {
                    let t = f64::from(j) / f64::from(nv);
                    for i in 0..=nu {
                        let s = f64::from(i) / f64::from(nu);
                        f(&[
                            (0, (1.0 - s) * (1.0 - t)),
                            (1, s * (1.0 - t)),
                            (2, s * t),
                            (3, (1.0 - s) * t),
                        ]);
                    }
                }
            }
            Cells::Triangle { k } => {
                let w = |n: u32| f64::from(n) / f64::from(k);
                for j in 0..=k {
                    (0..=k - j).for_each(|i| f(&[(0, w(k - i - j)), (1, w(i)), (2, w(j))]));
                }
            }
            Cells::Irregular(ref mesh) => mesh.weights.iter().for_each(|w| f(w)),
        }
    }
}

/// Number of points in the rows before row `j` of a triangle divided into `k²`.
fn triangle_row(k: u32, j: u32) -> u32 {
    // Row r has k + 1 − r points.
    j * (k + 1) - j * j.saturating_sub(1) / 2
}
