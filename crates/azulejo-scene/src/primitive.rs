//! Primitives with their parameterization.

use crate::math::{Aabb, normal_matrix};
use crate::{MaterialId, Mesh, Rgb};
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::{PI, TAU};

/// A unit primitive under an affine map.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// The unit primitive.
    pub kind: PrimitiveKind,
    /// Its transform; invertible, but for [`PrimitiveKind::Square`], whose third axis is not used.
    /// A map that mirrors leaves the outside the front.
    pub world_from_object: DAffine3,
    /// Its one material.
    pub material: MaterialId,
    /// Irradiance on the surface, once the scene is solved.
    pub light: Option<Box<SurfaceLight>>,
}

/// The unit primitives. Their front is the outside. All are closed but the tube and the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PrimitiveKind {
    /// Radius 1 around the origin. One part: `u` is the azimuth from +x over 2π, `v` runs from
    /// the pole z = −1 to z = 1 in equal angles.
    Sphere,
    /// Radius 1 around the z axis, 0 <= z <= 1, closed. Parts: side (`v` = z), bottom, top; on
    /// the caps `v` is the distance from the axis.
    Cylinder,
    /// Radius 1 at z = 0 and `top` at z = 1, closed. Parts: side, bottom, and the top if
    /// `top` > 0.
    Cone {
        /// Radius of the upper end, 0..=1.
        top: f64,
    },
    /// The side alone of a cone or cylinder, open: radius 1 at z = 0 and `top` at z = 1. One
    /// part, as the side of a cone.
    Tube {
        /// Radius of the upper end, 0..=1.
        top: f64,
    },
    /// The cube 0..=1 in each coordinate. Parts: x = 0, x = 1, y = 0, y = 1, z = 0, z = 1.
    Cuboid,
    /// The square 0..=1 in x and y, z = 0, front toward +z: any parallelogram, and GRF's area
    /// light. One part with `u` = x, `v` = y.
    Square,
}

/// A point of a primitive's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// World position.
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// World area per unit of `u v` at this point.
    pub area_density: f64,
}

/// How finely one part of a primitive is divided: `nu × nv` cells, `(nu+1) × (nv+1)` vertices,
/// `u` fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceGrid {
    /// Cells along `u`.
    pub nu: u32,
    /// Cells along `v`.
    pub nv: u32,
}

/// Irradiance at the vertices of the grids of a primitive's parts, one part after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceLight {
    /// One grid per part.
    pub grids: Vec<SurfaceGrid>,
    /// Irradiance at each grid vertex, W/m².
    pub irradiance: Vec<Rgb>,
    /// Its standard error, as long as `irradiance` or empty.
    pub error: Vec<Rgb>,
}

impl SurfaceGrid {
    /// Number of vertices.
    pub fn vertices(&self) -> usize {
        (self.nu as usize + 1) * (self.nv as usize + 1)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.nu as usize * self.nv as usize
    }
}

impl SurfaceLight {
    /// Bilinearly interpolated irradiance at `(u, v)` of a part; black for a part without grid.
    pub fn at(&self, part: usize, u: f64, v: f64) -> Rgb {
        let Some(cell) = self.cell(part, u, v) else {
            return Rgb::BLACK;
        };
        let ([a, b, c, d], fu, fv) = cell;
        let value = |k: usize| self.irradiance[k];
        (1.0 - fv) * ((1.0 - fu) * value(a) + fu * value(b))
            + fv * ((1.0 - fu) * value(c) + fu * value(d))
    }

    /// The corners of the grid's cell at `(u, v)` of a part, as indices of `irradiance`; none for a part
    /// without grid.
    pub fn around(&self, part: usize, u: f64, v: f64) -> impl Iterator<Item = usize> + use<> {
        let cell = self.cell(part, u, v);
        cell.into_iter().flat_map(|(corners, ..)| corners)
    }

    /// The corners of a cell, row by row, and where `(u, v)` lies between them.
    fn cell(&self, part: usize, u: f64, v: f64) -> Option<([usize; 4], f64, f64)> {
        let grid = self.grids.get(part)?;
        let start: usize = self.grids[..part].iter().map(SurfaceGrid::vertices).sum();
        let split = |x: f64, n: u32| {
            let x = x.clamp(0.0, 1.0) * f64::from(n);
            let cell = (x.floor() as usize).min(n as usize - 1);
            (cell, x - cell as f64)
        };
        let ((i, fu), (j, fv)) = (split(u, grid.nu), split(v, grid.nv));
        let row = grid.nu as usize + 1;
        let corner = |di: usize, dj: usize| start + (j + dj) * row + i + di;
        Some((
            [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)],
            fu,
            fv,
        ))
    }
}

impl PrimitiveKind {
    /// Number of parts, each with its own `u`, `v`.
    pub fn parts(&self) -> usize {
        match *self {
            PrimitiveKind::Sphere | PrimitiveKind::Square | PrimitiveKind::Tube { .. } => 1,
            PrimitiveKind::Cylinder => 3,
            PrimitiveKind::Cone { top } => 2 + usize::from(top > 0.0),
            PrimitiveKind::Cuboid => 6,
        }
    }

    /// Object-space position and the derivatives by `u` and `v`, ordered so that
    /// `du × dv` points outside.
    fn point(&self, part: usize, u: f64, v: f64) -> (DVec3, DVec3, DVec3) {
        // Flat parts need no angle.
        let is_flat = matches!(self, PrimitiveKind::Cuboid | PrimitiveKind::Square);
        let angle = if is_flat { 0.0 } else { TAU * u };
        let (sin, cos) = angle.sin_cos();
        let ring = |r: f64, z: f64| DVec3::new(r * cos, r * sin, z);
        let d_ring = |r: f64| DVec3::new(-TAU * r * sin, TAU * r * cos, 0.0);
        let side = |top: f64| {
            let r = 1.0 + (top - 1.0) * v;
            (ring(r, v), d_ring(r), ring(top - 1.0, 1.0))
        };
        let cap = |r: f64, z: f64, up: bool| {
            // Radius as a function of v, so that du × dv points out of the cap.
            let (p, du, dv) = (ring(v * r, z), d_ring(v * r), ring(r, 0.0));
            if up { (p, -du, dv) } else { (p, du, dv) }
        };
        match (*self, part) {
            (PrimitiveKind::Sphere, _) => {
                let (s, c) = (PI * (v - 0.5)).sin_cos();
                (ring(c, s), d_ring(c), PI * ring(-s, c))
            }
            (PrimitiveKind::Cylinder, 0) => side(1.0),
            (PrimitiveKind::Cylinder, 1) => cap(1.0, 0.0, false),
            (PrimitiveKind::Cylinder, _) => cap(1.0, 1.0, true),
            (PrimitiveKind::Cone { top }, 0) | (PrimitiveKind::Tube { top }, _) => side(top),
            (PrimitiveKind::Cone { .. }, 1) => cap(1.0, 0.0, false),
            (PrimitiveKind::Cone { top }, _) => cap(top, 1.0, true),
            (PrimitiveKind::Cuboid, 0) => (DVec3::new(0.0, v, u), DVec3::Z, DVec3::Y),
            (PrimitiveKind::Cuboid, 1) => (DVec3::new(1.0, u, v), DVec3::Y, DVec3::Z),
            (PrimitiveKind::Cuboid, 2) => (DVec3::new(u, 0.0, v), DVec3::X, DVec3::Z),
            (PrimitiveKind::Cuboid, 3) => (DVec3::new(v, 1.0, u), DVec3::Z, DVec3::X),
            (PrimitiveKind::Cuboid, 4) => (DVec3::new(v, u, 0.0), DVec3::Y, DVec3::X),
            (PrimitiveKind::Cuboid, _) => (DVec3::new(u, v, 1.0), DVec3::X, DVec3::Y),
            (PrimitiveKind::Square, _) => (DVec3::new(u, v, 0.0), DVec3::X, DVec3::Y),
        }
    }

    /// Object-space normal of the outside, any length, exact also at poles and apexes.
    fn normal(&self, part: usize, u: f64, v: f64) -> DVec3 {
        let (p, du, dv) = self.point(part, u, v);
        match (*self, part) {
            (PrimitiveKind::Sphere, _) => p,
            (PrimitiveKind::Cylinder, 1) | (PrimitiveKind::Cone { .. }, 1) => -DVec3::Z,
            (PrimitiveKind::Cylinder, 2) | (PrimitiveKind::Cone { .. }, 2) => DVec3::Z,
            (PrimitiveKind::Cone { top }, 0) | (PrimitiveKind::Tube { top }, _) => {
                let (sin, cos) = (TAU * u).sin_cos();
                DVec3::new(cos, sin, 1.0 - top)
            }
            _ => du.cross(dv),
        }
    }

    /// Part and `(u, v)` of an object-space point on (or, by rounding, near) the surface.
    pub fn locate(&self, p: DVec3) -> (usize, f64, f64) {
        let azimuth = || p.y.atan2(p.x).rem_euclid(TAU) / TAU;
        let radius = || p.x.hypot(p.y);
        let turned = |top: f64| -> (usize, f64, f64) {
            let radius = radius();
            // The distances to the side and to the two caps: the point belongs to the nearest.
            let side = (radius - (1.0 + (top - 1.0) * p.z)).abs();
            let (bottom, upper) = (
                p.z.abs(),
                if top > 0.0 {
                    f64::abs(1.0 - p.z)
                } else {
                    f64::INFINITY
                },
            );
            if side <= bottom && side <= upper {
                (0, azimuth(), p.z.clamp(0.0, 1.0))
            } else if bottom <= upper {
                (1, azimuth(), radius.min(1.0))
            } else {
                (2, azimuth(), (radius / top).min(1.0))
            }
        };
        match *self {
            PrimitiveKind::Sphere => (0, azimuth(), 0.5 + p.z.atan2(radius()) / PI),
            PrimitiveKind::Cylinder => turned(1.0),
            PrimitiveKind::Cone { top } => turned(top),
            PrimitiveKind::Tube { .. } => (0, azimuth(), p.z.clamp(0.0, 1.0)),
            PrimitiveKind::Square => (0, p.x.clamp(0.0, 1.0), p.y.clamp(0.0, 1.0)),
            PrimitiveKind::Cuboid => {
                let c = p.clamp(DVec3::ZERO, DVec3::ONE);
                let distance = [p.x, 1.0 - p.x, p.y, 1.0 - p.y, p.z, 1.0 - p.z].map(f64::abs);
                let part = (0..6).fold(0, |best, k| {
                    if distance[k] < distance[best] {
                        k
                    } else {
                        best
                    }
                });
                let (u, v) = match part {
                    0 => (c.z, c.y),
                    1 => (c.y, c.z),
                    2 => (c.x, c.z),
                    3 => (c.z, c.x),
                    4 => (c.y, c.x),
                    _ => (c.x, c.y),
                };
                (part, u, v)
            }
        }
    }
}

impl Primitive {
    /// A primitive of one material, without irradiance.
    pub fn new(
        kind: PrimitiveKind,
        world_from_object: DAffine3,
        material: MaterialId,
    ) -> Primitive {
        Primitive {
            kind,
            world_from_object,
            material,
            light: None,
        }
    }

    /// A sphere.
    pub fn sphere(centre: DVec3, radius: f64, material: MaterialId) -> Primitive {
        let map = DAffine3::from_scale_rotation_translation(
            DVec3::splat(radius),
            glam::DQuat::IDENTITY,
            centre,
        );
        Primitive::new(PrimitiveKind::Sphere, map, material)
    }

    /// A parallelogram: one corner and the two edges that leave it, front toward `edge1 × edge2`.
    pub fn parallelogram(
        corner: DVec3,
        edge1: DVec3,
        edge2: DVec3,
        material: MaterialId,
    ) -> Primitive {
        let map = DAffine3 {
            matrix3: DMat3::from_cols(edge1, edge2, edge1.cross(edge2).normalize_or_zero()),
            translation: corner,
        };
        Primitive::new(PrimitiveKind::Square, map, material)
    }

    /// World position, normal and area density at `(u, v)` of a part.
    pub fn point(&self, part: usize, u: f64, v: f64) -> SurfacePoint {
        let (p, du, dv) = self.kind.point(part, u, v);
        let m = self.world_from_object.matrix3;
        SurfacePoint {
            position: self.world_from_object.transform_point3(p),
            normal: self.world_normal(self.kind.normal(part, u, v)),
            area_density: (m * du).cross(m * dv).length(),
        }
    }

    fn world_normal(&self, object_normal: DVec3) -> DVec3 {
        let m = self.world_from_object.matrix3;
        match self.kind {
            // A parallelogram has no outside: its front is defined by its edges.
            PrimitiveKind::Square => m.x_axis.cross(m.y_axis),
            _ => normal_matrix(m) * object_normal,
        }
        .normalize_or_zero()
    }

    /// How finely each part must be divided so that no chord deviates from the surface by more than
    /// `chord_error` and no cell is longer than `max_edge` (both in world units, > 0; infinity for
    /// no limit). At least 8 cells around, at most 4096 along any direction.
    pub fn grids(&self, chord_error: f64, max_edge: f64) -> Vec<SurfaceGrid> {
        let m = self.world_from_object.matrix3;
        let (sx, sy, sz) = (m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
        let count = |length: f64, least: u32| {
            let n = (length / max_edge).ceil();
            if n > f64::from(least) {
                n.min(4096.0) as u32
            } else {
                least
            }
        };
        // Sagitta of a chord that spans the angle 2a: r (1 − cos a).
        let arc = |r: f64| {
            let half = (1.0 - (chord_error / r).min(1.0)).acos();
            (PI / half.max(1e-3)).ceil().clamp(8.0, 4096.0) as u32
        };
        let r = sx.max(sy);
        let around = count(TAU * r, arc(r));
        let round = |nv| SurfaceGrid { nu: around, nv };
        match self.kind {
            PrimitiveKind::Sphere => {
                let big = r.max(sz);
                vec![SurfaceGrid {
                    nu: count(TAU * big, arc(big)),
                    nv: count(PI * big, arc(big).div_ceil(2)),
                }]
            }
            PrimitiveKind::Cylinder => {
                vec![round(count(sz, 1)), round(count(r, 1)), round(count(r, 1))]
            }
            PrimitiveKind::Tube { top } => vec![round(count(sz.hypot(r * (1.0 - top)), 1))],
            PrimitiveKind::Cone { top } => {
                let mut parts = vec![
                    round(count(sz.hypot(r * (1.0 - top)), 1)),
                    round(count(r, 1)),
                ];
                if top > 0.0 {
                    parts.push(round(count(top * r, 1)));
                }
                parts
            }
            PrimitiveKind::Cuboid => {
                let (nx, ny, nz) = (count(sx, 1), count(sy, 1), count(sz, 1));
                [(nz, ny), (ny, nz), (nx, nz), (nz, nx), (ny, nx), (nx, ny)]
                    .map(|(nu, nv)| SurfaceGrid { nu, nv })
                    .to_vec()
            }
            PrimitiveKind::Square => vec![SurfaceGrid {
                nu: count(sx, 1),
                nv: count(sy, 1),
            }],
        }
    }

    /// Polygons over the vertices of `grids`, in their order, front outside. Where a row
    /// collapses to a point (poles, axes, apexes) the cells are triangles.
    pub fn tessellate(&self, grids: &[SurfaceGrid]) -> Mesh {
        let mut mesh = Mesh::default();
        let mut normals = Vec::new();
        for (part, grid) in grids.iter().enumerate() {
            let base = mesh.positions.len() as u32;
            let row = grid.nu + 1;
            for j in 0..=grid.nv {
                for i in 0..=grid.nu {
                    let p = self.point(
                        part,
                        f64::from(i) / f64::from(grid.nu),
                        f64::from(j) / f64::from(grid.nv),
                    );
                    mesh.positions.push(p.position);
                    normals.push(p.normal);
                }
            }
            let (low, high) = self.collapsed_rows(part);
            let flip = self.is_reversed(part);
            for j in 0..grid.nv {
                for i in 0..grid.nu {
                    let at = |di: u32, dj: u32| base + (j + dj) * row + i + di;
                    let mut face = vec![at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                    if high && j + 1 == grid.nv {
                        face.remove(2);
                    } else if low && j == 0 {
                        face.remove(1);
                    }
                    if flip {
                        face.reverse();
                    }
                    mesh.push_face(&face, self.material);
                }
            }
        }
        mesh.normals = Some(crate::Attribute::per_vertex(normals));
        mesh
    }

    /// Whether the rows `v` = 0 and `v` = 1 of a part are single points.
    fn collapsed_rows(&self, part: usize) -> (bool, bool) {
        match (self.kind, part) {
            (PrimitiveKind::Sphere, _) => (true, true),
            (PrimitiveKind::Cone { top }, 0) | (PrimitiveKind::Tube { top }, _) => {
                (false, top <= 0.0)
            }
            (PrimitiveKind::Cylinder | PrimitiveKind::Cone { .. }, 1 | 2) => (true, false),
            _ => (false, false),
        }
    }

    /// Whether counter-clockwise in `(u, v)` is clockwise from outside.
    fn is_reversed(&self, part: usize) -> bool {
        let mirrored = self.world_from_object.matrix3.determinant() < 0.0
            && self.kind != PrimitiveKind::Square;
        // On an upper cap u still turns counter-clockwise, so u × v points down.
        let upper_cap = matches!(
            (self.kind, part),
            (PrimitiveKind::Cylinder | PrimitiveKind::Cone { .. }, 2)
        );
        mirrored != upper_cap
    }

    /// The smallest box around the shape, exact for ellipsoids, tight for the rest.
    pub fn bounds(&self) -> Aabb {
        let (m, t) = (
            self.world_from_object.matrix3,
            self.world_from_object.translation,
        );
        let circle = |centre: DVec3, r: f64| {
            let half = r * DVec3::new(
                m.row(0).truncate().length(),
                m.row(1).truncate().length(),
                m.row(2).truncate().length(),
            );
            let c = m * centre + t;
            Aabb {
                min: c - half,
                max: c + half,
            }
        };
        let corners = |zs: &[f64]| {
            Aabb::around(zs.iter().flat_map(|&z| {
                [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
                    .map(|(x, y)| m * DVec3::new(x, y, z) + t)
            }))
        };
        match self.kind {
            PrimitiveKind::Sphere => {
                let half = DVec3::new(m.row(0).length(), m.row(1).length(), m.row(2).length());
                Aabb {
                    min: t - half,
                    max: t + half,
                }
            }
            PrimitiveKind::Cylinder => circle(DVec3::ZERO, 1.0).union(circle(DVec3::Z, 1.0)),
            PrimitiveKind::Cone { top } | PrimitiveKind::Tube { top } => {
                circle(DVec3::ZERO, 1.0).union(circle(DVec3::Z, top))
            }
            PrimitiveKind::Cuboid => corners(&[0.0, 1.0]),
            PrimitiveKind::Square => corners(&[0.0]),
        }
    }

    /// Surface area: exact for boxes, parallelograms and balls, otherwise by the midpoint rule on
    /// 256 × 64 cells per part, to 1e-4 relative, the pole rows being the worst.
    pub fn area(&self) -> f64 {
        let axes = self.world_from_object.matrix3;
        let radius = axes.x_axis.length();
        match self.kind {
            PrimitiveKind::Cuboid | PrimitiveKind::Square => {
                let density = |part| self.point(part, 0.5, 0.5).area_density;
                return (0..self.kind.parts()).map(density).sum();
            }
            PrimitiveKind::Sphere if is_similarity(axes) => return 4.0 * PI * radius * radius,
            _ => {}
        }
        let part_area = |part| {
            let (nu, nv) = (256, 64);
            let mid = |i: i32, n: i32| (f64::from(i) + 0.5) / f64::from(n);
            let sum: f64 = (0..nu * nv)
                .map(|k| {
                    self.point(part, mid(k % nu, nu), mid(k / nu, nv))
                        .area_density
                })
                .sum();
            sum / f64::from(nu * nv)
        };
        (0..self.kind.parts()).map(part_area).sum()
    }
}

/// Whether a map keeps all angles, to rounding.
fn is_similarity(axes: DMat3) -> bool {
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let size = x.length_squared();
    let unequal = [y.length_squared() - size, z.length_squared() - size];
    let skewed = [x.dot(y), y.dot(z), z.dot(x)];
    let mut rests = unequal.iter().chain(&skewed);
    rests.all(|rest| rest.abs() <= 1e-12 * size)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds() -> [PrimitiveKind; 6] {
        use PrimitiveKind::*;
        [
            Sphere,
            Cylinder,
            Cone { top: 0.0 },
            Cone { top: 0.5 },
            Cuboid,
            Square,
        ]
    }

    fn skewed(kind: PrimitiveKind, mirror: f64) -> Primitive {
        let map = DAffine3::from_cols(
            DVec3::new(2.0 * mirror, 0.1, 0.0),
            DVec3::new(0.3, 1.5, 0.2),
            DVec3::new(0.0, 0.4, 0.8),
            DVec3::new(5.0, 6.0, 7.0),
        );
        Primitive::new(kind, map, 0)
    }

    #[test]
    fn locate_inverts_point() {
        for kind in kinds() {
            for part in 0..kind.parts() {
                for (u, v) in [(0.1, 0.2), (0.7, 0.9), (0.45, 0.5)] {
                    let (p, ..) = kind.point(part, u, v);
                    let (q, x, y) = kind.locate(p);
                    assert!(
                        q == part && (x - u).abs() < 1e-12 && (y - v).abs() < 1e-12,
                        "{kind:?} {part} {u} {v}: {q} {x} {y}"
                    );
                }
            }
        }
    }

    #[test]
    fn tessellation_faces_outside_also_when_mirrored() {
        for kind in kinds() {
            for mirror in [1.0, -1.0] {
                let shape = skewed(kind, mirror);
                let mesh = shape.tessellate(&shape.grids(0.01, f64::INFINITY));
                let normals = mesh.normals.as_ref().unwrap();
                for f in 0..mesh.faces.len() {
                    let n = mesh.face_area_vector(f);
                    let mean: DVec3 = mesh
                        .faces
                        .get(f)
                        .iter()
                        .map(|&v| normals.values[v as usize])
                        .sum();
                    assert!(n.dot(mean) > 0.0, "{kind:?} mirrored {mirror}, face {f}");
                }
            }
        }
    }

    #[test]
    fn chord_error_holds_on_a_sphere() {
        let s = Primitive::sphere(DVec3::ZERO, 3.0, 0);
        let mesh = s.tessellate(&s.grids(0.01, f64::INFINITY));
        for f in 0..mesh.faces.len() {
            for w in mesh.face_positions(f).windows(2) {
                assert!(0.5 * (w[0] + w[1]).length() > 3.0 - 0.01 - 1e-9);
            }
        }
    }

    #[test]
    fn areas() {
        let check = |shape: Primitive, expected: f64| {
            assert!(
                (shape.area() / expected - 1.0).abs() < 2e-4,
                "{:?}: {}",
                shape.kind,
                shape.area()
            );
        };
        check(Primitive::sphere(DVec3::ONE, 2.0, 0), 16.0 * PI);
        check(
            Primitive::new(PrimitiveKind::Cylinder, DAffine3::IDENTITY, 0),
            4.0 * PI,
        );
        check(
            Primitive::new(PrimitiveKind::Cone { top: 0.0 }, DAffine3::IDENTITY, 0),
            PI * (1.0 + 2f64.sqrt()),
        );
        check(
            Primitive::new(PrimitiveKind::Cuboid, DAffine3::IDENTITY, 0),
            6.0,
        );
    }

    #[test]
    fn bounds_hold_the_surface_tightly() {
        for kind in kinds() {
            let shape = skewed(kind, 1.0);
            let mesh = shape.tessellate(&shape.grids(1e-4, 0.05));
            let (b, m) = (shape.bounds(), mesh.bounds());
            assert!(
                (b.min - m.min).abs().max_element() < 1e-2
                    && (b.max - m.max).abs().max_element() < 1e-2,
                "{kind:?} {b:?} {m:?}"
            );
        }
    }
}
