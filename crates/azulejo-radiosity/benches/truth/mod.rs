//! Ground truth by brute force: path traced irradiance. Shares no code with azulejo except the
//! scene's data: its own triangles, random numbers and mirrors.

use azulejo_scene::{Rgb, Scene, Shape};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A triangle with its material.
struct Tri {
    a: DVec3,
    e1: DVec3,
    e2: DVec3,
    n: DVec3,
    area: f64,
    diffuse: Rgb,
    mirror: Rgb,
    emission: Rgb,
}

/// A scene of a few triangles.
pub struct Brute {
    tris: Vec<Tri>,
    lamps: Vec<usize>,
}

/// xorshift64*: Vigna, *An experimental exploration of Marsaglia's xorshift generators*, 2016.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}

impl Brute {
    /// The triangles of a scene of meshes.
    pub fn new(scene: &Scene) -> Brute {
        let mut tris = Vec::new();
        for object in &scene.objects {
            let Shape::Mesh(mesh) = &object.shape else {
                panic!("brute force knows meshes only")
            };
            for face in 0..mesh.faces.len() {
                let material = &scene.materials[mesh.face_materials[face] as usize];
                let p = mesh.face_positions(face);
                for [i, j, k] in mesh.triangulate(face) {
                    let (a, b, c) = (p[i as usize], p[j as usize], p[k as usize]);
                    let cross = (b - a).cross(c - a);
                    tris.push(Tri {
                        a,
                        e1: b - a,
                        e2: c - a,
                        n: cross.normalize(),
                        area: 0.5 * cross.length(),
                        diffuse: material.diffuse,
                        mirror: material.mirror,
                        emission: material.emission,
                    });
                }
            }
        }
        let lamps = (0..tris.len())
            .filter(|&t| !tris[t].emission.is_black())
            .collect();
        Brute { tris, lamps }
    }

    /// Points spread evenly over the diffuse surfaces, in proportion to area, each with the
    /// normal of the front.
    pub fn points(&self, count: usize, seed: u64) -> Vec<(DVec3, DVec3)> {
        let total: f64 = self
            .tris
            .iter()
            .filter(|t| !t.diffuse.is_black())
            .map(|t| t.area)
            .sum();
        let mut random = Random(seed | 1);
        let mut points = Vec::with_capacity(count);
        for i in 0..count {
            let mut rest = (i as f64 + random.next()) / count as f64 * total;
            let t = self
                .tris
                .iter()
                .filter(|t| !t.diffuse.is_black())
                .find(|t| {
                    rest -= t.area;
                    rest < 0.0
                });
            let t = t.unwrap_or(&self.tris[0]);
            let (u, v) = (random.next().sqrt(), random.next());
            points.push((t.a + u * (1.0 - v) * t.e1 + u * v * t.e2, t.n));
        }
        points
    }

    /// Irradiance at each point from `paths` paths, with its variance.
    pub fn irradiance(&self, points: &[(DVec3, DVec3)], paths: u32) -> Vec<(Rgb, Rgb)> {
        points
            .par_iter()
            .enumerate()
            .map(|(i, &(p, n))| self.at(p, n, paths, i as u64))
            .collect()
    }

    fn at(&self, p: DVec3, n: DVec3, paths: u32, key: u64) -> (Rgb, Rgb) {
        let mut random = Random((key + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let (mut sum, mut squares) = (Rgb::BLACK, Rgb::BLACK);
        for _ in 0..paths {
            let e = self.path(p, n, &mut random);
            sum += e;
            squares += e * e;
        }
        let mean = sum / f64::from(paths);
        let variance = (squares / f64::from(paths) - mean * mean) / f64::from(paths);
        (mean, variance)
    }

    /// One sample of irradiance: a lamp sampled at each diffuse point, and a path that continues.
    fn path(&self, mut p: DVec3, mut n: DVec3, random: &mut Random) -> Rgb {
        let (mut found, mut weight) = (Rgb::BLACK, Rgb::WHITE);
        loop {
            found += weight * self.lamp(p, n, random);
            let mut d = cosine(n, random);
            let mut origin = p + 1e-6 * n;
            let mut by_mirror = false;
            let hit = loop {
                let Some(t) = self.closest(origin, d) else {
                    return found;
                };
                let tri = &self.tris[t.0];
                let facing = if tri.n.dot(d) < 0.0 { tri.n } else { -tri.n };
                // Lamps hit directly were sampled; those in a mirror were not.
                if by_mirror && tri.n.dot(d) < 0.0 {
                    found += weight * tri.emission * PI;
                }
                if tri.mirror.is_black() {
                    break (t.0, origin + t.1 * d, facing);
                }
                weight *= tri.mirror;
                origin = origin + t.1 * d + 1e-6 * facing;
                d -= 2.0 * d.dot(facing) * facing;
                by_mirror = true;
            };
            let rho = self.tris[hit.0].diffuse;
            let go_on = rho.max_channel();
            if random.next() >= go_on {
                return found;
            }
            weight = weight * rho / go_on;
            (p, n) = (hit.1, hit.2);
        }
    }

    fn lamp(&self, p: DVec3, n: DVec3, random: &mut Random) -> Rgb {
        let chosen = self.lamps
            [((random.next() * self.lamps.len() as f64) as usize).min(self.lamps.len() - 1)];
        let t = &self.tris[chosen];
        let (u, v) = (random.next().sqrt(), random.next());
        let y = t.a + u * (1.0 - v) * t.e1 + u * v * t.e2;
        let d = y - p;
        let r2 = d.length_squared();
        let (cos_p, cos_y) = (d.dot(n), -d.dot(t.n));
        if cos_p <= 0.0 || cos_y <= 0.0 {
            return Rgb::BLACK;
        }
        let origin = p + 1e-6 * n;
        if self.blocked(origin, y - origin, chosen) {
            return Rgb::BLACK;
        }
        t.emission * (cos_p * cos_y / (r2 * r2) * t.area * self.lamps.len() as f64)
    }

    fn closest(&self, o: DVec3, d: DVec3) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for (i, tri) in self.tris.iter().enumerate() {
            if let Some(t) = tri.meet(o, d).filter(|&t| best.is_none_or(|b| t < b.1)) {
                best = Some((i, t));
            }
        }
        best
    }

    fn blocked(&self, o: DVec3, d: DVec3, except: usize) -> bool {
        let hit =
            |(i, tri): (usize, &Tri)| i != except && tri.meet(o, d).is_some_and(|t| t < 1.0 - 1e-9);
        self.tris.iter().enumerate().any(hit)
    }
}

impl Tri {
    fn meet(&self, o: DVec3, d: DVec3) -> Option<f64> {
        let p = d.cross(self.e2);
        let inv = 1.0 / p.dot(self.e1);
        let s = o - self.a;
        let u = s.dot(p) * inv;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = s.cross(self.e1);
        let v = d.dot(q) * inv;
        let t = self.e2.dot(q) * inv;
        (v >= 0.0 && u + v <= 1.0 && t > 1e-7).then_some(t)
    }
}

/// A cosine-distributed direction: the normal plus a point of the unit sphere.
fn cosine(n: DVec3, random: &mut Random) -> DVec3 {
    let z = 1.0 - 2.0 * random.next();
    let phi = 2.0 * PI * random.next();
    let r = (1.0 - z * z).max(0.0).sqrt();
    (n + DVec3::new(r * phi.cos(), r * phi.sin(), z)).normalize()
}
