//! Enclosures with form factors of catalogues. Mirrors are unfolded axis by axis.

use crate::expected::{disks, opposed_strips, triangle_factor};
use crate::net_radiation::{GreyPaint, NetRadiation};
use azulejo_testing::closed_forms::{on_common_edge, opposed, parallel, perpendicular};
use std::f64::consts::PI;

/// Weights of images below which they are left out.
const FAINT: f64 = 1e-16;

/// A convex body in another that it is seen from alike all over; areas alike for plates. Directions from
/// the outer one that miss the inner one miss it after every reflection.
pub fn nested(areas: [f64; 2], paint: &GreyPaint) -> NetRadiation {
    let [m1, m2] = [paint.mirror[0], paint.mirror[1]];
    let (both, ratio) = (1.0 / (1.0 - m1 * m2), areas[0] / areas[1]);
    let factors = [
        [m2 * both, both],
        [ratio * both, (1.0 - ratio) / (1.0 - m2) + ratio * m1 * both],
    ];
    NetRadiation::new(&areas, paint, |i, j| factors[i][j])
}

/// An infinitely long duct with these three sides.
pub fn triangle(sides: [f64; 3], paint: &GreyPaint) -> NetRadiation {
    NetRadiation::new(&sides, paint, |i, j| {
        if i == j {
            0.0
        } else {
            triangle_factor(sides[i], sides[j], sides[3 - i - j])
        }
    })
}

/// An infinitely long rectangular duct: bottom, right, top, left.
pub fn rectangular_duct(width: f64, height: f64, paint: &GreyPaint) -> NetRadiation {
    let sides = [width, height, width, height];
    let diagonal = width.hypot(height);
    NetRadiation::new(&sides, paint, |i, j| match i.abs_diff(j) {
        0 => 0.0,
        2 => opposed_strips(sides[i], sides[1 - i % 2]),
        _ => triangle_factor(sides[i], sides[j], diagonal),
    })
}

/// A rectangular groove, open above: bottom, right, left.
pub fn slot(width: f64, depth: f64, paint: &GreyPaint) -> NetRadiation {
    let duct = rectangular_duct(width, depth, &GreyPaint::matt(&[1.0; 4]));
    let row = |i: usize| [0, 1, 3][i];
    NetRadiation::new(&[width, depth, depth], paint, |i, j| {
        duct.factor(row(i), row(j))
    })
}

/// Two infinitely long strips of width 1 that meet at `angle` < 90°; the second may be a mirror, which
/// shows the first itself at twice the angle.
pub fn strips(angle: f64, paint: &GreyPaint) -> NetRadiation {
    let at = |angle: f64| 1.0 - (0.5 * angle).sin();
    let factors = [
        [paint.mirror[1] * at(2.0 * angle), at(angle)],
        [at(angle), 0.0],
    ];
    NetRadiation::new(&[1.0; 2], paint, |i, j| factors[i][j])
}

/// Base, top and wall between coaxial disks: a cylinder or a cone without its tip.
pub fn frustum(r1: f64, r2: f64, h: f64, paint: &GreyPaint) -> NetRadiation {
    let wall = PI * (r1 + r2) * h.hypot(r2 - r1);
    let areas = [PI * r1 * r1, PI * r2 * r2, wall];
    let (f12, f21) = (disks(r1, r2, h), disks(r2, r1, h));
    let (f31, f32) = (areas[0] / wall * (1.0 - f12), areas[1] / wall * (1.0 - f21));
    let factors = [
        [0.0, f12, 1.0 - f12],
        [f21, 0.0, 1.0 - f21],
        [f31, f32, 1.0 - f31 - f32],
    ];
    NetRadiation::new(&areas, paint, |i, j| factors[i][j])
}

/// A closed cylinder whose top may be a mirror.
pub fn mirrored_cylinder(r: f64, h: f64, paint: &GreyPaint) -> NetRadiation {
    let m = paint.mirror[1];
    let (near, far) = (disks(r, r, h), disks(r, r, 2.0 * h));
    let wall = 2.0 * PI * r * h;
    let areas = [PI * r * r, PI * r * r, wall];
    // The wall sees itself where it sees neither base nor top, and its image beyond the top.
    let to_base = areas[0] / wall * (1.0 - near);
    let to_image_of_base = areas[0] / wall * (near - far);
    let to_images_of_wall = m * (to_base - to_image_of_base);
    let factors = [
        [m * far, near, 1.0 - near + m * (near - far)],
        [near, 0.0, 1.0 - near],
        [
            to_base + m * to_image_of_base,
            to_base,
            1.0 - 2.0 * to_base + to_images_of_wall,
        ],
    ];
    NetRadiation::new(&areas, paint, |i, j| factors[i][j])
}

/// A cylinder without top: base and wall.
pub fn cylindrical_cavity(r: f64, depth: f64, paint: &GreyPaint) -> NetRadiation {
    let closed = frustum(r, r, depth, &GreyPaint::matt(&[1.0; 3]));
    let areas = [PI * r * r, 2.0 * PI * r * depth];
    NetRadiation::new(&areas, paint, |i, j| closed.factor(2 * i, 2 * j))
}

/// A unit cube: floor, ceiling, four walls as one.
pub fn cube_of_three(paint: &GreyPaint) -> NetRadiation {
    let (f12, side) = (opposed(1.0, 1.0, 1.0), on_common_edge(1.0, 1.0, 1.0));
    let factors = [
        [0.0, f12, 4.0 * side],
        [f12, 0.0, 4.0 * side],
        [side, side, f12 + 2.0 * side],
    ];
    NetRadiation::new(&[1.0, 1.0, 4.0], paint, |i, j| factors[i][j])
}

/// A box with its faces x0 x1 y0 y1 z0 z1.
pub fn room(size: [f64; 3], paint: &GreyPaint) -> NetRadiation {
    let area = |i: usize| size[(i / 2 + 1) % 3] * size[(i / 2 + 2) % 3];
    let areas: Vec<f64> = (0..6).map(area).collect();
    NetRadiation::new(&areas, paint, |i, j| {
        let (a, b) = (i / 2, j / 2);
        if i == j {
            0.0
        } else if a == b {
            opposed(size[(a + 1) % 3], size[(a + 2) % 3], size[a])
        } else {
            // Face a extends along b, and b along a; both along the third axis.
            on_common_edge(size[3 - a - b], size[b], size[a])
        }
    })
}

/// A unit cube of 24 squares in four groups alike: those of the floor and of the ceiling, and the lower
/// and the upper ones of the walls.
pub fn cube_of_24(paint: &GreyPaint) -> NetRadiation {
    let (near, far, whole) = ([0.0, 0.5], [0.5, 1.0], [0.0, 1.0]);
    // From a square in a corner of the floor to half of the height of all walls.
    let to_walls = |height| {
        let along = |x| perpendicular(x, near, whole, height);
        2.0 * (along(near) + along(far))
    };
    // From a low square of a wall to a half of the height of the others.
    let between_walls = |height| {
        let across = |x| perpendicular(x, near, height, whole);
        parallel(near, near, whole, height, 1.0) + across(near) + across(far)
    };
    let top = parallel(near, near, whole, whole, 1.0);
    let factors = [
        [0.0, top, to_walls(near), to_walls(far)],
        [top, 0.0, to_walls(far), to_walls(near)],
        [0.0, 0.0, between_walls(near), between_walls(far)],
        [0.0, 0.0, 0.0, between_walls(near)],
    ];
    NetRadiation::reciprocal(&[1.0, 1.0, 2.0, 2.0], paint, |i, j| factors[i][j])
}

/// Weights of what is seen beyond 0, 1, 2… mirrors in turn.
fn beyond([first, second]: [f64; 2]) -> Vec<f64> {
    let (mut weights, mut weight, mut next) = (Vec::new(), 1.0, [first, second]);
    while weight > FAINT {
        weights.push(weight);
        weight *= next[0];
        next.swap(0, 1);
    }
    weights
}

/// One axis of a box of mirrors, by their reflectances at its lower and upper end.
struct MirroredAxis([f64; 2]);

impl MirroredAxis {
    /// Cells to both ways with their weights.
    fn cells(&self) -> Vec<(f64, f64)> {
        let [low, high] = self.0;
        let up = beyond([high, low]).into_iter().enumerate();
        let down = beyond([low, high]).into_iter().enumerate().skip(1);
        let up = up.map(|(k, w)| (k as f64, w));
        up.chain(down.map(|(k, w)| (-(k as f64), w))).collect()
    }

    /// Cells that a face at the end `side` looks into.
    fn ahead(&self, side: usize) -> Vec<(f64, f64)> {
        let weights = beyond([self.0[1 - side], self.0[side]]);
        weights
            .into_iter()
            .enumerate()
            .map(|(k, w)| (k as f64, w))
            .collect()
    }

    /// Images of the end `to` as distances from a face at the end `from`.
    fn opposite(&self, from: usize, to: usize) -> Vec<(f64, f64)> {
        let ahead = self.ahead(from).into_iter().enumerate();
        let is_seen = |&(k, _): &(usize, _)| (k % 2 == 0) == (from != to);
        ahead
            .filter(is_seen)
            .map(|(_, (k, w))| (k + 1.0, w))
            .collect()
    }

    /// Images of the end `to` as distances beyond the nearer end of a perpendicular face.
    fn aside(&self, to: usize) -> Vec<(f64, f64)> {
        let toward = self.ahead(1 - to).into_iter().step_by(2);
        let away = self.ahead(to).into_iter().skip(1).step_by(2);
        toward.chain(away).collect()
    }
}

/// Σ of weights times values over three lists of images.
fn over_images(lists: [&[(f64, f64)]; 3], value: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for &(a, wa) in lists[0] {
        for &(b, wb) in lists[1] {
            for &(c, wc) in lists[2].iter().filter(|(_, wc)| wa * wb * wc > FAINT) {
                sum += wa * wb * wc * value(a, b, c);
            }
        }
    }
    sum
}

fn span(start: f64) -> [f64; 2] {
    [start, start + 1.0]
}

/// A unit cube whose faces x0 x1 y0 y1 z0 z1 may be mirrors.
pub fn mirrored_cube(paint: &GreyPaint) -> NetRadiation {
    let m = &paint.mirror;
    let axes = [0, 1, 2].map(|a| MirroredAxis([m[2 * a], m[2 * a + 1]]));
    let here = [0.0, 1.0];
    NetRadiation::reciprocal(&[1.0; 6], paint, |i, j| {
        let ([a, from], [b, to]) = ([i / 2, i % 2], [j / 2, j % 2]);
        if a == b {
            let lists = [
                &axes[a].opposite(from, to)[..],
                &axes[(a + 1) % 3].cells(),
                &axes[(a + 2) % 3].cells(),
            ];
            over_images(lists, |d, m, n| parallel(here, here, span(m), span(n), d))
        } else {
            let lists = [
                &axes[b].aside(to)[..],
                &axes[a].ahead(from),
                &axes[3 - a - b].cells(),
            ];
            over_images(lists, |x, z, n| {
                perpendicular(span(x), here, span(n), span(z))
            })
        }
    })
}

/// An infinitely long square duct whose sides x0 x1 y0 y1 may be mirrors, by crossed strings.
pub fn mirrored_duct(paint: &GreyPaint) -> NetRadiation {
    let m = &paint.mirror;
    let axes = [0, 1].map(|a| MirroredAxis([m[2 * a], m[2 * a + 1]]));
    let opposed = |d: f64, n: f64| {
        let string = |x: f64| x.hypot(d);
        0.5 * (string(n + 1.0) + string(n - 1.0) - 2.0 * string(n))
    };
    let across = |x: f64, z: f64| {
        let string = |dx: f64, dz: f64| (x + dx).hypot(z + dz);
        0.5 * (string(1.0, 0.0) + string(0.0, 1.0) - string(0.0, 0.0) - string(1.0, 1.0))
    };
    let alone = [(0.0, 1.0)];
    NetRadiation::reciprocal(&[1.0; 4], paint, |i, j| {
        let ([a, from], [b, to]) = ([i / 2, i % 2], [j / 2, j % 2]);
        if a == b {
            let (planes, cells) = (axes[a].opposite(from, to), axes[1 - a].cells());
            over_images([&planes, &cells, &alone], |d, n, _| opposed(d, n))
        } else {
            let (aside, ahead) = (axes[b].aside(to), axes[a].ahead(from));
            over_images([&aside, &ahead, &alone], |x, z, _| across(x, z))
        }
    })
}
