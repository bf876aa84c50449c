//! Surfaces that emit: flat polygons and curved parts of primitives.

use super::flat_faces::{FaceKey, flat_faces, is_flat};
use super::tiles::{MergedTile, Tile, merged};
use crate::Surfaces;
use crate::lambert::{is_in_front, point_to_polygon};
use azulejo_scene::math::area_vector;
use azulejo_scene::{Material, Primitive, Rgb, Shape};
use glam::DVec3;
use std::borrow::Cow;
use std::f64::consts::PI;

/// Distance of a small emitter, as a multiple of its radius, beyond which its integral is off by less than 1e-4.
const FAR: f64 = 25.0;

/// The same for its middle alone, if the height above the horizon is as much.
const VERY_FAR: f64 = 100.0;

/// Height above the horizon, in the same measure, above which that holds: where the cosine is small, its changes count.
const HIGH: f64 = 4.0;

/// What a surface emits, and how often it is chosen as a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Emission {
    /// Radiance of the front, W/(sr·m²).
    pub radiance: Rgb,
    /// Whether the back emits too.
    pub emits_back: bool,
    /// Its power, mean over the channels, as a share of that of all lights: the probability with
    /// which it is sampled.
    pub share: f64,
}

impl Emission {
    /// With the power for a share, of a surface of that area.
    pub fn new(radiance: Rgb, emits_back: bool, area: f64) -> Emission {
        let sides = if emits_back { 2.0 } else { 1.0 };
        let power = radiance.mean() * sides * area;
        Emission {
            radiance,
            emits_back,
            share: if power.is_finite() { power } else { 0.0 },
        }
    }

    /// Radiance in a direction of which `cos` is the cosine to the normal.
    pub fn radiance_to(&self, cos: f64) -> Rgb {
        if cos > 0.0 || self.emits_back {
            self.radiance
        } else {
            Rgb::BLACK
        }
    }
}

/// A point of an emitter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterPoint {
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Area per unit of the square of random numbers: one over the density by area.
    pub area: f64,
}

/// A flat convex polygon that emits: a face, or several of one plane that fill it.
#[derive(Clone, Debug)]
pub(crate) struct FlatEmitter {
    /// Corners, counter-clockwise from the front. On the heap, as there may be very many.
    pub polygon: Box<[DVec3]>,
    /// Unit normal of the front.
    pub normal: DVec3,
    pub area: f64,
    pub emission: Emission,
    /// The mean of the corners, and the farthest of them from there.
    pub centre: DVec3,
    pub radius: f64,
}

impl FlatEmitter {
    fn new(tile: &Tile<(Rgb, bool)>) -> FlatEmitter {
        let across = area_vector(&tile.polygon);
        let area = across.length();
        let (radiance, emits_back) = tile.property;
        let corners = tile.polygon.len() as f64;
        let centre = tile.polygon.iter().sum::<DVec3>() / corners;
        let distances = tile.polygon.iter().map(|corner| corner.distance(centre));
        FlatEmitter {
            centre,
            radius: distances.fold(0.0, f64::max),
            polygon: tile.polygon.iter().copied().collect(),
            normal: across.normalize_or_zero(),
            area,
            emission: Emission::new(radiance, emits_back, area),
        }
    }

    /// How many sides emit.
    pub fn sides(&self) -> usize {
        1 + usize::from(self.emission.emits_back)
    }

    /// The polygon as `p` sees it: counter-clockwise if it can light that point.
    pub fn toward(&self, p: DVec3) -> Cow<'_, [DVec3]> {
        side_toward(&self.polygon, self.emission.emits_back, p)
    }

    /// Unit normal of the side that emits towards a point.
    pub fn normal_toward(&self, p: DVec3) -> DVec3 {
        if self.emission.emits_back && !is_in_front(p, &self.polygon) {
            return -self.normal;
        }
        self.normal
    }

    /// Form factor from a point with unit normal `n`, if nothing stood between: exact, but where the emitter is so
    /// small and far away that the integral over it is as good by the midpoints of the edges of its triangles, which
    /// are exact to the second degree (Hammer and Stroud, *Numerical integration over simplexes*, 1956), or even by
    /// the middle of a triangle, which is exact to the first.
    pub fn form_factor(&self, p: DVec3, n: DVec3) -> f64 {
        let way = self.centre - p;
        let (facing, height) = (self.facing(way), way.dot(n));
        // Turned away, or below the horizon.
        if facing <= 0.0 || height <= -self.radius {
            return 0.0;
        }
        let is_far = way.length_squared() > (FAR * self.radius).powi(2);
        let is_high = height > HIGH * self.radius;
        if !(is_far && is_high) || self.polygon.len() > 4 {
            return point_to_polygon(p, n, &self.toward(p));
        }
        let is_triangle = self.polygon.len() == 3;
        if is_triangle && height > VERY_FAR * self.radius {
            let square = way.length_squared();
            return facing * self.area * height / (PI * square * square);
        }
        // The distance to the plane is the same from everywhere.
        let kernel = |y: DVec3| {
            let way = y - p;
            way.dot(n) / way.length_squared().powi(2)
        };
        let o = self.polygon[0];
        let mut sum = 0.0;
        for two in self.polygon[1..].windows(2) {
            let [a, b] = [two[0], two[1]];
            let twice_area = if is_triangle {
                2.0 * self.area
            } else {
                (a - o).cross(b - o).length()
            };
            let middles = [o + a, o + b, a + b].map(|sum| kernel(0.5 * sum));
            sum += twice_area * middles.iter().sum::<f64>();
        }
        facing * sum / (6.0 * PI)
    }

    /// How far a point is in front of a side that emits, if `way` leads from there to the middle.
    #[inline]
    fn facing(&self, way: DVec3) -> f64 {
        let facing = -way.dot(self.normal);
        if self.emission.emits_back {
            facing.abs()
        } else {
            facing
        }
    }

    /// The point of two numbers in 0..1.
    pub fn point(&self, u: (f64, f64)) -> EmitterPoint {
        EmitterPoint {
            position: sample_polygon(&self.polygon, u),
            normal: self.normal,
            area: self.area,
        }
    }
}

/// A polygon, turned round if it emits from its back and `p` is behind it.
pub(crate) fn side_toward(polygon: &[DVec3], emits_back: bool, p: DVec3) -> Cow<'_, [DVec3]> {
    if emits_back && !is_in_front(p, polygon) {
        return polygon.iter().rev().copied().collect();
    }
    Cow::Borrowed(polygon)
}

/// A curved part of a primitive that emits from its outside, and from its inside if `emits_back`.
#[derive(Clone, Debug)]
pub(crate) struct CurvedEmitter<'a> {
    pub primitive: &'a Primitive,
    /// Which of its parts.
    pub part: usize,
    /// The middle of the primitive and the square of a radius around it, for rough estimates.
    pub centre: DVec3,
    /// See `centre`.
    pub radius2: f64,
    pub emission: Emission,
    pub key: FaceKey,
}

impl<'a> CurvedEmitter<'a> {
    fn new(
        object: u32,
        primitive: &'a Primitive,
        part: usize,
        (radiance, emits_back): (Rgb, bool),
    ) -> CurvedEmitter<'a> {
        let bounds = primitive.bounds();
        let area = whole_area(primitive, part);
        CurvedEmitter {
            primitive,
            part,
            centre: bounds.centre(),
            radius2: (0.5 * bounds.diagonal()).powi(2) / 3.0,
            emission: Emission::new(radiance, emits_back, area),
            key: FaceKey {
                object,
                face: part as u32,
                triangle: 0,
            },
        }
    }

    /// The point of two numbers in 0..1.
    pub fn point(&self, u: (f64, f64)) -> EmitterPoint {
        let at = self.primitive.point(self.part, u.0, u.1);
        EmitterPoint {
            position: at.position,
            normal: at.normal,
            area: at.area_density,
        }
    }
}

/// Area of a part of a primitive, to some percent, which is enough to choose by.
fn whole_area(primitive: &Primitive, part: usize) -> f64 {
    const STEPS: usize = 8;
    let middle = |k: usize| (k as f64 + 0.5) / STEPS as f64;
    let at = |k: usize| primitive.point(part, middle(k % STEPS), middle(k / STEPS));
    let all = (0..STEPS * STEPS).map(|k| at(k).area_density);
    all.sum::<f64>() / (STEPS * STEPS) as f64
}

/// The flat emitters of a scene in the order of their first faces.
#[derive(Default)]
pub(crate) struct FlatEmitters {
    pub emitters: Vec<FlatEmitter>,
    /// Faces that emit, ascending, and the emitter of each.
    faces: Vec<(FaceKey, u32)>,
}

impl FlatEmitters {
    /// Merges faces that fill a convex polygon, as far as they emit alike: a lamp divided into
    /// triangles costs as little as one that is not.
    /// Those that emit pictures are left out.
    pub fn new(surfaces: &Surfaces) -> FlatEmitters {
        let (mut keys, mut tiles) = (Vec::new(), Vec::new());
        flat_faces(surfaces.scene, Material::is_emitter, |face| {
            let emission = surfaces.mean_emission(face.id);
            if emission.is_black() || surfaces.emitted_picture(face.key.object, face.id).is_some() {
                return;
            }
            keys.push(face.key);
            tiles.push(Tile {
                polygon: face.polygon,
                normal: face.normal,
                property: (emission, face.material.emits_back),
            });
        });
        let mut lamps = FlatEmitters::default();
        for (number, MergedTile { tile, members }) in (0..).zip(merged(tiles)) {
            let of = |member: u32| (keys[member as usize], number);
            lamps.faces.extend(members.into_iter().map(of));
            lamps.emitters.push(FlatEmitter::new(&tile));
        }
        lamps.faces.sort_unstable();
        lamps
    }

    /// The emitter that a triangle belongs to.
    pub fn find(&self, triangle: FaceKey) -> Option<&FlatEmitter> {
        // A whole face stands under its triangle 0, for all of its triangles.
        let after = self.faces.partition_point(|(key, _)| *key <= triangle);
        let (key, number) = self.faces[..after].last()?;
        let is_of_face = (key.object, key.face) == (triangle.object, triangle.face);
        is_of_face.then(|| &self.emitters[*number as usize])
    }
}

/// The curved emitters of a scene in the order of their keys.
pub(crate) fn curved_emitters<'a>(surfaces: &Surfaces<'a>) -> Vec<CurvedEmitter<'a>> {
    let mut emitters = Vec::new();
    for (object, o) in (0..).zip(&surfaces.scene.objects) {
        let Shape::Primitive(primitive) = &o.shape else {
            continue;
        };
        let emission = surfaces.mean_emission(primitive.material);
        if !emission.is_black() && !is_flat(primitive.kind) {
            let material = &surfaces.scene.materials[primitive.material as usize];
            let emitted = (emission, material.emits_back);
            let parts = 0..primitive.kind.parts();
            emitters.extend(parts.map(|part| CurvedEmitter::new(object, primitive, part, emitted)));
        }
    }
    emitters
}

/// A point of a convex polygon, uniform by area, continuous in `u` but for fan borders.
pub(crate) fn sample_polygon(polygon: &[DVec3], u: (f64, f64)) -> DVec3 {
    let o = polygon[0];
    let is_parallelogram = polygon.len() == 4
        && (polygon[1] + polygon[3] - polygon[0] - polygon[2]).length_squared()
            < 1e-18 * (polygon[2] - o).length_squared();
    if is_parallelogram {
        return o + u.0 * (polygon[1] - o) + u.1 * (polygon[3] - o);
    }
    let area = |k: usize| (polygon[k] - o).cross(polygon[k + 1] - o).length();
    let total: f64 = (1..polygon.len() - 1).map(area).sum();
    let mut rest = u.0 * total;
    let mut k = 1;
    while k + 2 < polygon.len() && rest >= area(k) {
        rest -= area(k);
        k += 1;
    }
    // Osada et al. 2002, eq. (1): uniform over the triangle.
    let a = (rest / area(k).max(f64::MIN_POSITIVE))
        .clamp(0.0, 1.0)
        .sqrt();
    o + a * (1.0 - u.1) * (polygon[k] - o) + a * u.1 * (polygon[k + 1] - o)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lambert::ArrayPolygon;

    fn emitter(corners: &[DVec3], emits_back: bool) -> FlatEmitter {
        let mut polygon = ArrayPolygon::default();
        corners.iter().for_each(|&corner| polygon.push(corner));
        FlatEmitter::new(&Tile {
            normal: area_vector(&polygon).normalize(),
            polygon,
            property: (Rgb::WHITE, emits_back),
        })
    }

    #[test]
    fn far_emitters_are_integrated_as_well_as_near_ones() {
        let corners = [[0.0, 0.0], [2.0, 0.1], [2.2, 1.0], [-0.3, 1.5]];
        let corners = corners.map(|[x, y]| DVec3::new(x, y, 0.2 * x));
        for count in [3, 4] {
            for emits_back in [false, true] {
                let lamp = emitter(&corners[..count], emits_back);
                for k in 0..2000 {
                    let [a, b, c, d, e] =
                        [0, 1, 2, 3, 4].map(|d| f64::from(crate::sampling::uniform(&[k, d])));
                    let direction = DVec3::new(a - 0.5, b - 0.5, c - 0.5).normalize();
                    let p = (5.0 + 200.0 * d * d) * direction;
                    let n = DVec3::new(e - 0.5, a - 0.5, d - 0.5).normalize();
                    let exact = point_to_polygon(p, n, &lamp.toward(p));
                    let factor = lamp.form_factor(p, n);
                    assert!(
                        (factor - exact).abs() <= 1e-4 * exact,
                        "{factor} for {exact} at {p}"
                    );
                }
            }
        }
    }
}
