//! A mesh assembled from sheets of quadrilaterals that share their borders exactly.

use crate::{MaterialId, Mesh};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Merges corners of bit-identical positions.
#[derive(Default)]
pub(super) struct Sheets {
    mesh: Mesh,
    vertices: HashMap<[u64; 3], u32>,
}

impl Sheets {
    fn vertex(&mut self, p: DVec3) -> u32 {
        // Adding zero makes -0 and 0 the same corner.
        let key = p.to_array().map(|x| (x + 0.0).to_bits());
        let positions = &mut self.mesh.positions;
        *self.vertices.entry(key).or_insert_with(|| {
            positions.push(p);
            (positions.len() - 1) as u32
        })
    }

    /// Adds a polygon, counter-clockwise from its front.
    pub(super) fn face(&mut self, corners: &[DVec3], material: MaterialId) {
        let corners: Vec<u32> = corners.iter().map(|&p| self.vertex(p)).collect();
        self.mesh.push_face(&corners, material);
    }

    /// Adds the cells between rows of as many points each; the front is where (along the row) ×
    /// (from row to row) points. `material` of a column and a row; none leaves a hole.
    pub(super) fn sheet(
        &mut self,
        rows: &[Vec<DVec3>],
        material: impl Fn(usize, usize) -> Option<MaterialId>,
    ) {
        for (j, pair) in rows.windows(2).enumerate() {
            for i in 1..pair[0].len() {
                let corners = [pair[0][i - 1], pair[0][i], pair[1][i], pair[1][i - 1]];
                if let Some(material) = material(i - 1, j) {
                    self.face(&corners, material);
                }
            }
        }
    }

    pub(super) fn into_mesh(self) -> Mesh {
        self.mesh
    }
}

/// A grid of points in a horizontal plane, `x` along the rows, `y` from row to row.
pub(super) struct Plate(Vec<Vec<DVec2>>);

impl Plate {
    /// The intersections of lines.
    pub(super) fn from_lines(xs: &[f64], ys: &[f64]) -> Plate {
        let row = |&y: &f64| xs.iter().map(|&x| DVec2::new(x, y)).collect();
        Plate(ys.iter().map(row).collect())
    }

    /// A rotated rectangle of `nx × ny` cells.
    pub(super) fn turned(centre: DVec2, size: DVec2, angle: f64, [nx, ny]: [usize; 2]) -> Plate {
        let turn = DVec2::from_angle(angle);
        let part = |k: usize, n: usize| k as f64 / n as f64 - 0.5;
        let at = |i, j| centre + turn.rotate(DVec2::new(part(i, nx), part(j, ny)) * size);
        Plate(
            (0..=ny)
                .map(|j| (0..=nx).map(|i| at(i, j)).collect())
                .collect(),
        )
    }

    /// Numbers of cells along `x` and `y`.
    pub(super) fn cells(&self) -> [usize; 2] {
        [self.0[0].len() - 1, self.0.len() - 1]
    }

    /// Its points at a height.
    pub(super) fn at(&self, z: f64) -> Vec<Vec<DVec3>> {
        self.0
            .iter()
            .map(|row| row.iter().map(|p| p.extend(z)).collect())
            .collect()
    }

    /// Its border, counter-clockwise from above, first point again at the end.
    pub(super) fn border(&self) -> Vec<DVec2> {
        let (first, last) = (&self.0[0], &self.0[self.0.len() - 1]);
        let (left, right) = (
            self.0.iter().map(|r| r[0]),
            self.0.iter().map(|r| r[r.len() - 1]),
        );
        let mut border = first.clone();
        border.extend(right.skip(1));
        border.extend(last.iter().rev().skip(1));
        border.extend(left.rev().skip(1));
        border
    }
}

/// `n + 1` rows of points from one border to another, the ends exact.
pub(super) fn between(a: &[DVec3], b: &[DVec3], n: usize) -> Vec<Vec<DVec3>> {
    let row = |k: usize| {
        let t = k as f64 / n as f64;
        a.iter()
            .zip(b)
            .map(|(a, b)| *a * (1.0 - t) + *b * t)
            .collect()
    };
    (0..=n).map(row).collect()
}

/// A flat border at a height.
pub(super) fn raised(border: &[DVec2], z: f64) -> Vec<DVec3> {
    border.iter().map(|p| p.extend(z)).collect()
}

/// The ends of `n` equal steps from `a` to `b`.
pub(super) fn steps(a: f64, b: f64, n: usize) -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 / n as f64;
        a * (1.0 - t) + b * t
    };
    (0..=n).map(at).collect()
}

/// The border of a grid, counter-clockwise, first point again at the end.
pub(super) fn border(rows: &[Vec<DVec3>]) -> Vec<DVec3> {
    let last = rows.len() - 1;
    let mut border = rows[0].clone();
    border.extend(rows[1..].iter().map(|r| r[r.len() - 1]));
    border.extend(rows[last].iter().rev().skip(1));
    border.extend(rows[..last].iter().rev().map(|r| r[0]));
    border
}
