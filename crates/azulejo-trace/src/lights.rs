//! The light sources of a scene, and how a surface samples them.
//!
//! A glossy or matt surface that samples directions misses small lamps. Rays sampled toward the
//! lamps and rays sampled from the surface's lobes are two estimators of the same light; weighted
//! by their densities (multiple importance sampling, Veach and Guibas, SIGGRAPH 1995) they count
//! it once.

mod bevel_surface;
mod delta;
mod direction_table;
mod emitters;
mod flat_faces;
mod outside;
mod pictured;
mod prism_emitters;
mod tiles;

use crate::{Hit, KernelHit, KernelRay, Surfaces};
use azulejo_scene::{LightKind, Rgb};
pub(crate) use delta::{beyond, unoccluded, unoccluded_image};
pub(crate) use emitters::{CurvedEmitter, FlatEmitter, sample_polygon, side_toward};
use emitters::{Emission, EmitterPoint, FlatEmitters, curved_emitters};
pub(crate) use flat_faces::{FaceKey, FlatFace, flat_faces};
use glam::DVec3;
pub use outside::Outside;
pub(crate) use outside::SunDisc;
use pictured::PicturedEmitters;
use prism_emitters::{PrismEmitter, PrismPlace, prism_emitters};
pub(crate) use tiles::{Tile, merged};

/// If there are more lights without area than this, each sample takes this many of them.
const MOST_DELTA_LIGHTS: usize = 8;

/// All light sources of a scene but the emission of exact shapes other than prisms, and of those in
/// set operations, which paths find by chance alone. Immutable; shared by all threads.
pub struct Lights<'a> {
    flat: FlatEmitters,
    /// Curved emitters in the order of their keys.
    pub(crate) curved: Vec<CurvedEmitter<'a>>,
    /// Prisms that emit, in the order of their keys.
    prisms: Vec<PrismEmitter<'a>>,
    /// Emitters of pictures, together one light.
    pictured: PicturedEmitters<'a>,
    /// Point and spot lights, and directional ones without size.
    pub(crate) delta: Vec<LightKind>,
    /// Environments and suns.
    pub(crate) outside: Outside<'a>,
    /// Radiance of the surroundings that is the same from everywhere, W/(sr·m²): of ambient lights, and of even skies.
    pub(crate) ambient: Rgb,
    /// Sum of the shares of the emitters up to each: the flat ones, the curved ones, the prisms, and all
    /// of pictures.
    ends: Vec<f64>,
}

/// A point of an emitter, or of what is outside, sampled from another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit, toward the light.
    pub direction: DVec3,
    /// Where a shadow ray ends: a little before the emitter.
    pub target: DVec3,
    /// What arrives if nothing stands between, W/(sr·m²).
    pub radiance: Rgb,
    /// Density of the sample over solid angle, 1/sr.
    pub pdf: f64,
}

/// A light without area, as a point of a surface sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeltaLightSample {
    /// Where a shadow ray ends.
    pub target: DVec3,
    /// Unit, toward the light.
    pub direction: DVec3,
    /// Irradiance of the surface if nothing stands between, W/m².
    pub irradiance: Rgb,
}

impl<'a> Lights<'a> {
    /// Collects the light sources of a scene.
    pub fn new(surfaces: &Surfaces<'a>) -> Lights<'a> {
        let mut flat = FlatEmitters::new(surfaces);
        let mut curved = curved_emitters(surfaces);
        let mut prisms = prism_emitters(surfaces.scene);
        let mut pictured = PicturedEmitters::new(surfaces);
        let ends = normalized(&mut flat.emitters, &mut curved, &mut prisms, &mut pictured);
        let (mut delta, mut ambient) = (Vec::new(), Rgb::BLACK);
        for light in &surfaces.scene.lights {
            match light.kind {
                LightKind::Ambient { radiance } => ambient += radiance,
                LightKind::Environment(environment) => ambient += environment.split_even().0,
                LightKind::Directional { half_angle, .. } if half_angle > 0.0 => {}
                ref kind => delta.push(kind.clone()),
            }
        }
        let outside = Outside::new(surfaces.scene);
        Lights {
            flat,
            curved,
            prisms,
            pictured,
            delta,
            outside,
            ambient,
            ends,
        }
    }

    /// The flat emitters.
    pub(crate) fn flat(&self) -> &[FlatEmitter] {
        &self.flat.emitters
    }

    /// Whether surfaces emit pictures.
    pub(crate) fn has_pictures(&self) -> bool {
        !self.pictured.is_empty()
    }

    /// A point of the surfaces that emit pictures, for two numbers in 0..1, and what it emits.
    pub(crate) fn pictured_point(&self, u: (f64, f64)) -> (Emission, EmitterPoint) {
        self.pictured.point(u)
    }

    /// Whether there is nothing to sample: no emitter, no light without area, and nothing outside.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty() && self.delta.is_empty() && self.outside.is_empty()
    }

    /// The environments and suns.
    pub fn outside(&self) -> &Outside<'a> {
        &self.outside
    }

    /// A direction in which something outside shines, as seen from `p`, for three numbers in 0..1.
    /// `None` if nothing does.
    pub fn sample_outside(
        &self,
        surfaces: &Surfaces,
        p: DVec3,
        u: [f64; 3],
    ) -> Option<LightSample> {
        let sample = self.outside.sample(u)?;
        Some(LightSample {
            direction: sample.direction,
            target: beyond(surfaces, p, sample.direction),
            radiance: sample.radiance,
            pdf: sample.pdf,
        })
    }

    /// Whether there are lights without area.
    pub fn has_delta_lights(&self) -> bool {
        !self.delta.is_empty()
    }

    /// A point of an emitter as seen from `p`, for three numbers in 0..1: emitters are chosen by
    /// their power. `None` if there is none, it shows its dark side, or the numbers miss its outline.
    pub fn sample(&self, surfaces: &Surfaces, p: DVec3, u: [f64; 3]) -> Option<LightSample> {
        let last = self.ends.len().checked_sub(1)?;
        let chosen = self.ends.partition_point(|&end| end <= u[0]).min(last);
        let (emission, point) = self.point(chosen, (u[1], u[2]))?;
        let toward = point.position - p;
        let direction = toward.try_normalize()?;
        let cos = -direction.dot(point.normal);
        let radiance = emission.radiance_to(cos);
        let facing = point.normal * 1f64.copysign(cos);
        let pdf = emission.share * toward.length_squared() / (cos.abs() * point.area);
        (!radiance.is_black() && pdf.is_finite() && pdf > 0.0).then(|| LightSample {
            direction,
            target: surfaces.tracer.leaving(point.position, facing),
            radiance,
            pdf,
        })
    }

    /// A point of the emitter of that number, in the order of `ends`; `None` where the numbers miss its
    /// outline.
    fn point(&self, number: usize, u: (f64, f64)) -> Option<(Emission, EmitterPoint)> {
        if let Some(light) = self.flat().get(number) {
            return Some((light.emission, light.point(u)));
        }
        let number = number - self.flat().len();
        if let Some(light) = self.curved.get(number) {
            return Some((light.emission, light.point(u)));
        }
        match self.prisms.get(number - self.curved.len()) {
            Some(light) => Some((light.emission, light.point(u)?)),
            None => Some(self.pictured.point(u)),
        }
    }

    /// Density, 1/sr, with which [`sample`](Lights::sample) from the origin of `ray` finds the
    /// point that it hit; zero for what is never sampled.
    pub fn pdf(&self, surfaces: &Surfaces, ray: &KernelRay, hit: &KernelHit) -> f64 {
        let item = surfaces.item(hit.item);
        let key = FaceKey {
            object: item.object,
            face: item.face,
            triangle: item.triangle,
        };
        let ray = surfaces.tracer.world_ray(ray);
        let at = surfaces.tracer.resolve(&ray, hit);
        let on_prism = self.find_prism(key, &at);
        let lamp = on_prism.or_else(|| self.find(key, (at.u, at.v)));
        let Some((share, area)) = lamp else {
            return 0.0;
        };
        let toward = at.position - ray.origin;
        let cos = toward.normalize_or_zero().dot(at.normal).abs();
        let pdf = share * toward.length_squared() / (cos * area);
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The same of a prism that emits.
    fn find_prism(&self, key: FaceKey, at: &Hit) -> Option<(f64, f64)> {
        let key = (key.object, key.face);
        let index = self.prisms.binary_search_by_key(&key, |l| l.key).ok()?;
        let place = PrismPlace {
            part: at.triangle,
            u: at.u,
            position: at.position,
        };
        let light = &self.prisms[index];
        Some((light.emission.share, light.area_at(place)))
    }

    /// Share of an emitter and its area per unit of the square at `(u, v)`.
    fn find(&self, key: FaceKey, (u, v): (f64, f64)) -> Option<(f64, f64)> {
        if let Some(light) = self.flat.find(key) {
            return Some((light.emission.share, light.area));
        }
        if let Ok(curved) = self.curved.binary_search_by_key(&key, |l| l.key) {
            let light = &self.curved[curved];
            return Some((light.emission.share, light.point((u, v)).area));
        }
        self.pictured.find(key, (u, v))
    }

    /// The lights without area above the horizon of a surface. Where they are few it is all of
    /// them; where they are many, equally spaced ones from a start that `u` in 0..1 chooses, each
    /// counting for the others too.
    pub fn sample_delta(
        &self,
        surfaces: &Surfaces,
        p: DVec3,
        normal: DVec3,
        u: f64,
    ) -> impl Iterator<Item = DeltaLightSample> {
        let count = self.delta.len();
        let tried = count.min(MOST_DELTA_LIGHTS);
        let first = ((u * count as f64) as usize).min(count.saturating_sub(1));
        let (step, scale) = (
            count.div_ceil(MOST_DELTA_LIGHTS).max(1),
            count as f64 / tried.max(1) as f64,
        );
        (0..tried).filter_map(move |k| {
            // Equally spaced from a random start: each light is as likely as any other.
            let light = if count == tried {
                &self.delta[k]
            } else {
                &self.delta[(first + k * step) % count]
            };
            let (target, irradiance) = unoccluded(light, p, normal, surfaces)?;
            Some(DeltaLightSample {
                target,
                direction: (target - p).try_normalize()?,
                irradiance: irradiance * scale,
            })
        })
    }
}

/// Divides the power of all emitters by its sum; returns the sums up to each.
fn normalized(
    flat: &mut [FlatEmitter],
    curved: &mut [CurvedEmitter],
    prisms: &mut [PrismEmitter],
    pictured: &mut PicturedEmitters,
) -> Vec<f64> {
    let flat = flat.iter_mut().map(|l| &mut l.emission.share);
    let curved = curved.iter_mut().map(|l| &mut l.emission.share);
    let prisms = prisms.iter_mut().map(|l| &mut l.emission.share);
    let pictured = (!pictured.is_empty()).then_some(&mut pictured.share);
    let shares = flat.chain(curved).chain(prisms).chain(pictured);
    let mut shares: Vec<&mut f64> = shares.collect();
    let power: f64 = shares.iter().map(|share| **share).sum();
    let mut sum = 0.0;
    let up_to = |share: &mut &mut f64| {
        **share = if power > 0.0 { **share / power } else { 0.0 };
        sum += **share;
        sum
    };
    shares.iter_mut().map(up_to).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Tracer, interaction::shadow_ray};
    use azulejo_scene::math::Ray;
    use azulejo_scene::{
        Bevel, BevelEnds, BevelProfile, Contour, Curve, Exact, Figure, Material, Mesh, Object,
        Primitive, Prism, Scene, Shape, Solid,
    };
    use glam::{DAffine3, DMat3, DVec2};
    use std::sync::Arc;

    /// A polygon in a plane of constant z, by its corners.
    fn polygon(scene: &mut Scene, z: f64, corners: &[[f64; 2]], material: u32) {
        let mut mesh = Mesh {
            positions: corners.iter().map(|c| DVec3::new(c[0], c[1], z)).collect(),
            ..Mesh::default()
        };
        let face: Vec<u32> = (0..corners.len() as u32).collect();
        mesh.push_face(&face, material);
        scene.objects.push(Object::new("lamp", Shape::Mesh(mesh)));
    }

    /// Emitters of every shape around the origin: whole faces, a concave face in triangles, one
    /// that emits from both sides, a parallelogram and a sphere.
    fn lamps() -> Scene {
        let mut scene = Scene::default();
        let front = scene.add_material(Material::emitter("front", Rgb::new(1.0, 2.0, 3.0)));
        let mut both = Material::emitter("both", Rgb::grey(2.0));
        both.emits_back = true;
        let both = scene.add_material(both);
        let up = [[-1.0, -1.0], [1.0, -1.0], [1.5, 0.3], [0.0, 1.0]];
        let down: Vec<[f64; 2]> = up.iter().rev().copied().collect();
        polygon(&mut scene, 2.0, &down, front);
        polygon(&mut scene, -3.0, &down, both);
        let dart = [[4.0, 0.0], [6.0, -2.0], [5.0, 0.0], [6.0, 2.0]];
        polygon(&mut scene, -1.0, &dart, front);
        let corner = DVec3::new(-3.0, -1.0, -1.0);
        let sheet = Primitive::parallelogram(corner, DVec3::Y, DVec3::Z, front);
        let ball = Primitive::sphere(DVec3::new(0.0, 4.0, 0.0), 0.5, front);
        for primitive in [sheet, ball] {
            let shape = Shape::Primitive(primitive);
            scene.objects.push(Object::new("lamp", shape));
        }
        let bevel = Bevel {
            profile: BevelProfile::Round,
            inset: 0.15,
            depth: 0.3,
            ends: BevelEnds::Both,
        };
        for (at, bevel) in [
            ([0.5, -4.0, 0.8], None),
            ([-3.0, 3.5, 1.5], Some(Arc::new(bevel))),
        ] {
            let letter = Shape::Exact(letter(front, at.into(), bevel));
            scene.objects.push(Object::new("letter", letter));
        }
        scene
    }

    /// A ring of curves with a straight notch, leaning and turned away.
    fn letter(material: u32, at_origin: DVec3, bevel: Option<Arc<Bevel>>) -> Exact {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let cubic = |a: DVec2, b: DVec2, c: DVec2| Curve::Cubic {
            start: a,
            control1: b,
            control2: c,
        };
        let round = Contour {
            curves: vec![
                cubic(at(-1.0, 0.0), at(-1.0, -1.4), at(1.0, -1.4)),
                cubic(at(1.0, 0.0), at(1.0, 1.3), at(0.2, 1.3)),
                Curve::Line {
                    start: at(0.0, 1.0),
                },
            ],
        };
        let hole = Figure::polygon([at(-0.3, -0.3), at(-0.3, 0.2), at(0.4, 0.1)]);
        let mut figure = Figure {
            contours: vec![round],
            ..Figure::default()
        };
        figure.contours.extend(hole.contours);
        let axes = DMat3::from_cols(
            DVec3::new(0.8, 0.0, 0.3),
            DVec3::new(0.1, 0.9, 0.0),
            DVec3::new(-0.3, 0.2, 0.5),
        );
        Exact::new(vec![Solid::Prism(Prism {
            figure: Arc::new(figure),
            world_from_figure: DAffine3::from_mat3_translation(axes, at_origin),
            material,
            bevel,
        })])
    }

    #[test]
    fn rays_find_samples_with_the_density_of_the_samples() {
        let scene = lamps();
        let tracer = Tracer::new(&scene);
        let surfaces = Surfaces::new(&scene, &tracer);
        let lights = Lights::new(&surfaces);
        let mut counts = [0; 7];
        for k in 0..4000 {
            let u = [1, 2, 3].map(|d| f64::from(crate::sampling::uniform(&[k, d])));
            let Some(sample) = lights.sample(&surfaces, DVec3::ZERO, u) else {
                continue;
            };
            let mut blocked = Vec::new();
            let shadow = shadow_ray(&tracer, DVec3::ZERO, sample.target);
            tracer.any(&[shadow], &mut blocked);
            if blocked[0] {
                continue;
            }
            let ray = tracer.kernel_ray(&Ray::new(DVec3::ZERO, sample.direction));
            let mut hits = Vec::new();
            tracer.closest(&[ray], &mut hits);
            let pdf = lights.pdf(&surfaces, &ray, &hits[0]);
            let object = surfaces.item(hits[0].item).object as usize;
            // By the cosine, as the density has a pole where the ray grazes a sphere or the tight curve of a bevel: there a
            // hit that is off by rounding has another normal.
            let difference = (pdf.recip() - sample.pdf.recip()).abs();
            assert!(
                difference < 1e-3 / pdf + 3e-4,
                "object {object}: {pdf} and {}",
                sample.pdf
            );
            counts[object] += 1;
        }
        assert!(counts.iter().all(|&n| n > 50), "{counts:?}");
    }

    #[test]
    fn shares_are_those_of_power() {
        let scene = lamps();
        let tracer = Tracer::new(&scene);
        let lights = Lights::new(&Surfaces::new(&scene, &tracer));
        let shares = lights.flat().iter().map(|l| l.emission.share);
        let shares = shares.chain(lights.curved.iter().map(|l| l.emission.share));
        let shares = shares.chain(lights.prisms.iter().map(|l| l.emission.share));
        assert!((shares.sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((lights.ends.last().unwrap() - 1.0).abs() < 1e-12);
        // Of equal polygons the one that emits from both sides has twice the power.
        let [one, both] = [0, 1].map(|k: usize| lights.flat()[k].emission.share);
        assert!((both - 2.0 * one).abs() < 1e-12, "{one} {both}");
    }
}
