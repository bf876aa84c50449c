//! Light as a target: where a point should look to find lamps, and how dense such looks are.
//!
//! A glossy or matt surface that gathers light by chance misses small lamps. Rays drawn toward the
//! lamps and rays drawn from the surface's lobes are two ways to the same light; weighted by
//! their densities (multiple importance sampling, Veach and Guibas, SIGGRAPH 1995) they count it
//! once.

use crate::gather::unoccluded;
use crate::{KernelHit, KernelRay, Surfaces};
use azulejo_scene::{LightKind, Primitive, Rgb, Shape};
use glam::DVec3;

/// More lights without area than this are tried by turns.
const MOST_POINTS: usize = 8;

/// Lamps and lights of a scene, ready to be drawn from.
pub struct Lights<'a> {
    lamps: Vec<Lamp<'a>>,
    /// Sum of the power of the lamps up to each, as shares of all.
    ends: Vec<f64>,
    points: Vec<LightKind>,
}

/// One item that shines.
struct Lamp<'a> {
    item: u32,
    piece: Piece<'a>,
    /// Radiance of the front, W/(sr·m²).
    radiance: Rgb,
    emits_back: bool,
    /// Probability that it is chosen.
    share: f64,
}

enum Piece<'a> {
    /// Corner, two edges.
    Triangle([DVec3; 3]),
    /// A part of a primitive.
    Part(&'a Primitive, usize),
}

/// A place on a lamp, as a point sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Unit, toward the lamp.
    pub direction: DVec3,
    /// The place, a little before the lamp.
    pub target: DVec3,
    /// What arrives if nothing stands between, W/(sr·m²).
    pub radiance: Rgb,
    /// Density of [`Lights::look`] over solid angle, 1/sr.
    pub pdf: f64,
}

/// A light without area, as a point of a surface sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where it stands.
    pub target: DVec3,
    /// Unit, toward it.
    pub direction: DVec3,
    /// Irradiance of the surface if nothing stands between, W/m².
    pub irradiance: Rgb,
}

/// Where a piece is met, its normal there and its area per unit of the square.
struct Place {
    position: DVec3,
    normal: DVec3,
    area: f64,
}

impl<'a> Lights<'a> {
    /// Collects all items that shine, but for those of exact shapes, which are found by chance
    /// alone, and all lights without area.
    pub fn new(surfaces: &Surfaces<'a>) -> Lights<'a> {
        let items = (0..surfaces.tracer.item_count()).filter(|&item| surfaces.is_emitter(item));
        let mut lamps: Vec<Lamp> = items.filter_map(|item| Lamp::new(surfaces, item)).collect();
        let power: f64 = lamps.iter().map(|lamp| lamp.share).sum();
        let mut sum = 0.0;
        let mut ends = Vec::with_capacity(lamps.len());
        for lamp in &mut lamps {
            lamp.share /= power;
            sum += lamp.share;
            ends.push(sum);
        }
        let is_point = |kind: &LightKind| !matches!(kind, LightKind::Ambient { .. });
        let kinds = surfaces.scene.lights.iter().map(|light| light.kind);
        Lights {
            lamps,
            ends,
            points: kinds.filter(is_point).collect(),
        }
    }

    /// Whether nothing can be looked at.
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty() && self.points.is_empty()
    }

    /// Whether there are lights without area.
    pub fn has_beams(&self) -> bool {
        !self.points.is_empty()
    }

    /// A look at a lamp from `p`, for three numbers in 0..1; `None` if there is none or it shows
    /// its dark side.
    pub fn look(&self, surfaces: &Surfaces, p: DVec3, [u0, u1, u2]: [f64; 3]) -> Option<Look> {
        let last = self.lamps.len().checked_sub(1)?;
        let lamp = &self.lamps[self.ends.partition_point(|&end| end <= u0).min(last)];
        let place = lamp.piece.place(u1, u2);
        let way = place.position - p;
        let direction = way.try_normalize()?;
        let side = -direction.dot(place.normal);
        let radiance = lamp.radiance_to(side);
        let facing = place.normal * 1f64.copysign(side);
        let pdf = lamp.share * way.length_squared() / (side.abs() * place.area);
        (!radiance.is_black() && pdf.is_finite() && pdf > 0.0).then(|| Look {
            direction,
            target: surfaces.tracer.leaving(place.position, facing),
            radiance,
            pdf,
        })
    }

    /// Density, 1/sr, with which [`look`](Lights::look) from the origin of `ray` finds the place
    /// that it hit; zero for what is not looked at.
    pub fn pdf(&self, surfaces: &Surfaces, ray: &KernelRay, hit: &KernelHit) -> f64 {
        let found = self.lamps.binary_search_by_key(&hit.item, |lamp| lamp.item);
        let Ok(lamp) = found.map(|at| &self.lamps[at]) else {
            return 0.0;
        };
        let ray = surfaces.tracer.world_ray(ray);
        let at = surfaces.tracer.resolve(&ray, hit);
        let way = at.position - ray.origin;
        let cos = way.normalize_or_zero().dot(at.normal).abs();
        let pdf = lamp.share * way.length_squared() / (cos * lamp.piece.area(at.u, at.v));
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The lights without area above the horizon of a surface: all where they are few, some by
    /// turns where they are many, which `u` in 0..1 chooses; then they count for the others.
    pub fn beams(
        &self,
        surfaces: &Surfaces,
        p: DVec3,
        normal: DVec3,
        u: f64,
    ) -> impl Iterator<Item = Beam> {
        let count = self.points.len();
        let tried = count.min(MOST_POINTS);
        let first = ((u * count as f64) as usize).min(count.saturating_sub(1));
        let (step, scale) = (
            count.div_ceil(MOST_POINTS).max(1),
            count as f64 / tried.max(1) as f64,
        );
        (0..tried).filter_map(move |k| {
            // Equally spaced from a random start: each light is as likely as any other.
            let light = match count == tried {
                true => &self.points[k],
                false => &self.points[(first + k * step) % count],
            };
            let (target, irradiance) = unoccluded(light, p, normal, surfaces)?;
            Some(Beam {
                target,
                direction: (target - p).try_normalize()?,
                irradiance: irradiance * scale,
            })
        })
    }
}

impl<'a> Lamp<'a> {
    /// With its power for a share; `None` for what has no area, or no points to draw.
    fn new(surfaces: &Surfaces<'a>, number: u32) -> Option<Lamp<'a>> {
        let item = surfaces.item(number);
        let piece = match &surfaces.scene.objects[item.object as usize].shape {
            Shape::Mesh(mesh) => {
                let face = item.face as usize;
                let corners = mesh.triangulate(face);
                let corners = corners.get(item.triangle as usize)?;
                let vertices = mesh.faces.get(face);
                let [a, b, c] = corners.map(|k| mesh.positions[vertices[k as usize] as usize]);
                Piece::Triangle([a, b - a, c - a])
            }
            Shape::Primitive(p) => Piece::Part(p, item.face as usize),
            Shape::Exact(_) => return None,
        };
        let material = surfaces.material(number);
        let sides = if material.emits_back { 2.0 } else { 1.0 };
        let share = material.emission.mean() * sides * piece.whole_area();
        (item.instance.is_none() && share > 0.0 && share.is_finite()).then_some(Lamp {
            item: number,
            piece,
            radiance: material.emission,
            emits_back: material.emits_back,
            share,
        })
    }

    /// Radiance toward a place of which `side` is the cosine to the normal.
    fn radiance_to(&self, side: f64) -> Rgb {
        if side > 0.0 || self.emits_back {
            self.radiance
        } else {
            Rgb::BLACK
        }
    }
}

impl Piece<'_> {
    fn place(&self, u1: f64, u2: f64) -> Place {
        match self {
            Piece::Triangle([a, e1, e2]) => {
                // Osada et al. 2002, eq. (1): uniform over the triangle.
                let root = u1.sqrt();
                let across = e1.cross(*e2);
                Place {
                    position: *a + root * (1.0 - u2) * *e1 + root * u2 * *e2,
                    normal: across.normalize_or_zero(),
                    area: 0.5 * across.length(),
                }
            }
            Piece::Part(primitive, part) => {
                let at = primitive.point(*part, u1, u2);
                Place {
                    position: at.position,
                    normal: at.normal,
                    area: at.area_density,
                }
            }
        }
    }

    /// Area per unit of the square at a hit's parameters.
    fn area(&self, u: f64, v: f64) -> f64 {
        match self {
            Piece::Triangle(_) => self.whole_area(),
            Piece::Part(primitive, part) => primitive.point(*part, u, v).area_density,
        }
    }

    /// Area; of a part of a primitive to some percent, which is enough to choose by.
    fn whole_area(&self) -> f64 {
        match self {
            Piece::Triangle([_, e1, e2]) => 0.5 * e1.cross(*e2).length(),
            Piece::Part(primitive, part) => {
                const STEPS: usize = 8;
                let middle = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                let at = |k: usize| primitive.point(*part, middle(k % STEPS), middle(k / STEPS));
                let all = (0..STEPS * STEPS).map(|k| at(k).area_density);
                all.sum::<f64>() / (STEPS * STEPS) as f64
            }
        }
    }
}

/// The weight of a sample of density `own` where the same light could have come of one of density
/// `other`: Veach's power heuristic.
pub fn mis_weight(own: f64, other: f64) -> f64 {
    if own.is_infinite() {
        return 1.0;
    }
    let (own, other) = (own * own, other * other);
    own / (own + other).max(f64::MIN_POSITIVE)
}
