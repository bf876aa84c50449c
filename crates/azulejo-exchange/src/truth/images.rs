//! Boxes and ducts with mirrors, cell by cell: they are repeated in all cells that are seen through mirrors.

use super::GreyPaint;
use super::enclosures::{GreyEnclosure, crossed_strings};
use azulejo_factors::analytic::form_factor;
use glam::{DVec2, DVec3};

/// Weights of cells below which they are left out.
const FAINT: f64 = 1e-15;

/// Cells along an axis, and what is seen of them through the mirrors at both ends of the first one.
fn cells([low, high]: [f64; 2]) -> Vec<(i32, f64)> {
    let mut cells = vec![(0, 1.0)];
    for (way, mut next) in [(1, [high, low]), (-1, [low, high])] {
        let (mut k, mut weight) = (1, next[0]);
        while weight > FAINT {
            cells.push((way * k, weight));
            next.swap(0, 1);
            weight *= next[0];
            k += 1;
        }
    }
    cells
}

/// All cells with their weights; mirrors are those of x0 x1 y0 y1 z0 z1.
fn cells_of_box(mirrors: &[f64]) -> Vec<([i32; 3], f64)> {
    let along = |axis: usize| {
        let ends = mirrors.get(2 * axis..2 * axis + 2);
        cells(ends.map_or([0.0; 2], |ends| [ends[0], ends[1]]))
    };
    let mut all = Vec::new();
    for (x, wx) in along(0) {
        for &(y, wy) in &along(1) {
            let both = wx * wy;
            let rest = along(2);
            let seen = rest.iter().filter(|(_, wz)| both * wz > FAINT);
            all.extend(seen.map(|&(z, wz)| ([x, y, z], both * wz)));
        }
    }
    all
}

/// Where face `to` of a cell lies along its axis, if face `from` of the first cell sees it: mirror
/// images have their ends exchanged in every other cell.
fn plane(from: usize, to: usize, cell: [i32; 3]) -> Option<i32> {
    let (axis, side) = (from / 2, (from % 2) as i32);
    let is_ahead = if side == 0 {
        cell[axis] >= 0
    } else {
        cell[axis] <= 0
    };
    let k = cell[to / 2];
    let plane = k + ((to % 2) as i32 ^ k.rem_euclid(2));
    let is_coplanar = to / 2 == axis && plane == side;
    // Nearer ends of other cells are seen from behind: they belong to the cell before.
    let is_far = k == 0 || plane == k + i32::from(k > 0);
    (is_ahead && is_far && !is_coplanar).then_some(plane)
}

/// The face of a cell at `at` along `axis`, in cells, seen from inside of its cell.
fn face(size: [f64; 3], axis: usize, at: i32, cell: [i32; 3]) -> Vec<DVec3> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |(a, b): (i32, i32)| {
        let mut p = cell;
        (p[axis], p[u], p[v]) = (at, cell[u] + a, cell[v] + b);
        DVec3::from_array(size) * DVec3::from_array(p.map(f64::from))
    };
    let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(corner).to_vec();
    if at > cell[axis] {
        corners.reverse();
    }
    corners
}

/// A box whose faces x0 x1 y0 y1 z0 z1 may be mirrors.
pub fn mirrored_box(size: [f64; 3], paint: &GreyPaint) -> GreyEnclosure {
    let cells = cells_of_box(&paint.mirror);
    let area = |i: usize| size[(i / 2 + 1) % 3] * size[(i / 2 + 2) % 3];
    let areas: Vec<f64> = (0..6).map(area).collect();
    GreyEnclosure::new(&areas, paint, |i, j| {
        let from = face(size, i / 2, (i % 2) as i32, [0; 3]);
        let share = |&(cell, weight): &([i32; 3], f64)| {
            let plane = plane(i, j, cell)?;
            Some(weight * form_factor(&from, &face(size, j / 2, plane, cell)))
        };
        cells.iter().filter_map(share).sum()
    })
}

/// The side of a square cell at `at` along `axis`, round the cell.
fn side(axis: usize, at: i32, cell: [i32; 3]) -> [DVec2; 2] {
    let corner = |along: i32| {
        let mut p = [cell[0], cell[1]];
        (p[axis], p[1 - axis]) = (at, cell[1 - axis] + along);
        DVec2::from_array(p.map(f64::from))
    };
    let is_upper = at > cell[axis];
    let [first, last] = if is_upper == (axis == 0) {
        [0, 1]
    } else {
        [1, 0]
    };
    [corner(first), corner(last)]
}

/// An infinitely long square duct whose sides x0 x1 y0 y1 may be mirrors.
pub fn mirrored_duct(paint: &GreyPaint) -> GreyEnclosure {
    let cells = cells_of_box(&paint.mirror);
    GreyEnclosure::new(&[1.0; 4], paint, |i, j| {
        let from = side(i / 2, (i % 2) as i32, [0; 3]);
        let share = |&(cell, weight): &([i32; 3], f64)| {
            let to = side(j / 2, plane(i, j, cell)?, cell);
            Some(weight * crossed_strings(from, to))
        };
        cells.iter().filter_map(share).sum()
    })
}

/// A unit cube of 24 squares, four of each of z0, z1, x0, x1, y0, y1; and the heights of their centres.
pub fn cube_of_24(paint: &GreyPaint) -> (GreyEnclosure, Vec<f64>) {
    let mut polygons = Vec::new();
    for (axis, at) in [(2, 0), (2, 1), (0, 0), (0, 1), (1, 0), (1, 1)] {
        let face = face([1.0; 3], axis, at, [0; 3]);
        let along = [face[1] - face[0], face[3] - face[0]].map(|v| v / 2.0);
        for (a, b) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let start = face[0] + a * along[0] + b * along[1];
            let [u, v] = along;
            polygons.push(vec![start, start + u, start + u + v, start + v]);
        }
    }
    let cube = GreyEnclosure::new(&[0.25; 24], paint, |i, j| {
        if i / 4 == j / 4 {
            0.0
        } else {
            form_factor(&polygons[i], &polygons[j])
        }
    });
    let height = |p: &Vec<DVec3>| p.iter().map(|p| p.z).sum::<f64>() / 4.0;
    let heights = polygons.iter().map(height).collect();
    (cube, heights)
}
