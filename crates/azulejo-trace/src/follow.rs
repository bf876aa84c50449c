//! Follows paths through mirrors and glass, and by chance from glossy surfaces, to every surface
//! that they reach.

use crate::interaction::{
    Branching, Continuation, DielectricInterface, Roulette, SPLIT_DEPTH, SurfaceInteraction,
};
use crate::medium::Leg;
use crate::sampling::{hash, uniform};
use crate::{KernelHit, KernelRay, Surfaces};
use azulejo_scene::brdf::Lobes;
use azulejo_scene::math::Frame;
use azulejo_scene::{Material, Rgb};
use glam::DVec3;

/// A ray of a path, and what the path carries.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Its next stretch.
    pub leg: Leg,
    /// Chosen by the caller and handed back with every event.
    pub id: u32,
    /// Share of the light that this path carries, per channel.
    pub weight: Rgb,
    /// What lies between the start of the path and this ray.
    pub via: Via,
    /// Interfaces passed so far.
    pub depth: u16,
    /// Density of the ray's direction, 1/sr, if it was sampled from glossy lobes; 0 otherwise.
    /// Multiple importance sampling weights by it the light that next event estimation finds too.
    pub density: f32,
    /// Whether it passed a thin pane, straight on. Such panes do not count for `via` and `density`,
    /// as shadow rays pass them too.
    pub passed_pane: bool,
}

impl Path {
    /// One that sets out.
    pub fn new(ray: KernelRay, id: u32, weight: Rgb) -> Path {
        Path {
            leg: Leg::from(ray),
            id,
            weight,
            via: Via::Direct,
            depth: 0,
            density: 0.0,
            passed_pane: false,
        }
    }
}

/// What lies between the start of a path and its current ray, beside thin panes that it passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Via {
    /// Nothing.
    Direct,
    /// One mirror, this item.
    Mirror(u32),
    /// Glass, a glossy surface, or more than one mirror.
    Many,
}

/// What happened to a path.
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// It reached a surface, with its whole weight; what the surface mirrors or transmits
    /// continues (additive model, Sillion and Puech 1989).
    Surface {
        /// The surface point.
        hit: KernelHit,
        /// Whether it arrived at the front.
        front: bool,
    },
    /// The surface absorbed the path's weight in addition to what its material's reflectances
    /// imply. Coloured glass absorbs what it neither mirrors nor transmits. Other surfaces absorb
    /// 1 − ρ_d − ρ_s of what reaches them; glossy ones absorb less, by what they send on, and
    /// this weight is negative.
    Absorbed,
    /// It left the scene.
    Escape,
    /// What it still carried was too little to follow: the residue.
    Cut,
}

/// A path is dropped, and its weight reported as [`Event::Cut`], below this share of the heaviest
/// path of its batch: weights have a unit, and most are divided by the number of paths.
pub const WEIGHT_CUT: f64 = 1e-6;

/// A path is dropped after this many interfaces: facing perfect mirrors would hold it forever.
pub const DEPTH_CUT: u16 = 1000;

/// A surface that both mirrors and has lobes splits a path at its first interface alone: the
/// noise of later choices averages out over the many paths of a row, and what they would cost
/// does not.
const MIRROR_SPLIT_DEPTH: u32 = 1;

/// Share of the heaviest path below which later interfaces play roulette. The cost of a path, and
/// the variance of what it finds, favour survival in proportion to weight (measured: bright glossy
/// rooms take a half to a third of the time that [`Roulette::SHARE`] takes, and 1 no less).
const LATER_SHARE: f64 = 0.3;

/// How a path of that depth goes on from a surface with lobes, seen from `wo`.
pub(crate) fn branching(material: &Material, lobes: &Lobes, wo: DVec3, depth: u16) -> Branching {
    let splits = u32::from(depth) < MIRROR_SPLIT_DEPTH;
    Branching::new(splits, material.mirror_at(wo.z).mean(), || lobes.likely(wo))
}

/// Working memory of [`follow`], kept between calls to save allocations.
#[derive(Default)]
pub struct Scratch {
    rays: Vec<KernelRay>,
    hits: Vec<KernelHit>,
    next: Vec<Path>,
}

/// Traces `paths` to their ends and reports every surface they reach to `on_event`.
///
/// Per path the shares add up: what is deposited at surfaces times what these absorb or reflect
/// diffusely, what escapes and what is cut make the weight it started with. Empties `paths`.
/// The order of events depends on the paths alone. `seed` keys the choices at glass and on glossy
/// surfaces, from which a path continues in one direction, sampled in proportion to what its
/// lobes reflect.
pub fn follow(
    surfaces: &Surfaces,
    paths: &mut Vec<Path>,
    scratch: &mut Scratch,
    seed: u32,
    mut on_event: impl FnMut(&Path, Event),
) {
    let heaviest = paths.iter().map(|p| p.weight.max_channel());
    let heaviest = heaviest.fold(0.0, f64::max);
    let mut wave = 0;
    while !paths.is_empty() {
        scratch.rays.clear();
        scratch.rays.extend(paths.iter().map(|p| p.leg.ray));
        surfaces.tracer.closest(&scratch.rays, &mut scratch.hits);
        for (index, (path, hit)) in paths.iter().zip(&scratch.hits).enumerate() {
            let (hit, front) = path.leg.hit(surfaces, hit);
            if hit.item == KernelHit::MISS {
                on_event(path, Event::Escape);
                continue;
            }
            let film = path.leg.air_film(surfaces, &hit);
            if film.is_none() {
                on_event(path, Event::Surface { hit, front });
            }
            if film.is_some() || surfaces.is_specular(hit.item) {
                let (at, material) = film.unwrap_or_else(|| {
                    let at = SurfaceInteraction::new(surfaces.tracer, &path.leg.ray, &hit);
                    (at, surfaces.material(hit.item))
                });
                let specular = SpecularHit {
                    path,
                    item: hit.item,
                    material,
                    at,
                    key: hash(&[seed, wave, index as u32]),
                    heaviest,
                };
                specular.scatter(surfaces, |outcome| match outcome {
                    Outcome::Path(next) => scratch.next.push(next),
                    Outcome::Weak(rest) => on_event(&rest, Event::Cut),
                    Outcome::Absorbed(absorbed) => on_event(&absorbed, Event::Absorbed),
                });
            }
        }
        std::mem::swap(paths, &mut scratch.next);
        scratch.next.clear();
        wave += 1;
    }
}

/// What becomes of a path at a specular or glossy surface.
enum Outcome {
    /// A part that continues.
    Path(Path),
    /// A part that is too weak to follow.
    Weak(Path),
    /// What the surface absorbs.
    Absorbed(Path),
}

/// A path at a mirror, a dielectric or a glossy surface.
struct SpecularHit<'p> {
    path: &'p Path,
    item: u32,
    material: &'p Material,
    at: SurfaceInteraction,
    /// Keys its random numbers.
    key: u32,
    /// Weight of the heaviest path that set out with it.
    heaviest: f64,
}

impl SpecularHit<'_> {
    /// Divides the path into the parts that continue, are cut and are absorbed.
    fn scatter(&self, surfaces: &Surfaces, mut push: impl FnMut(Outcome)) {
        let material = self.material;
        let send = |next: Continuation| push(self.next(surfaces, next));
        match self.at.interface(material) {
            Some(interface) => {
                let absorbed = self.at_glass(&interface, send);
                if absorbed.max_channel() > f64::EPSILON {
                    push(Outcome::Absorbed(self.absorbed(absorbed)));
                }
            }
            None => {
                let sent = self.at_surface(surfaces, send);
                if sent != material.mirror {
                    push(Outcome::Absorbed(self.absorbed(material.mirror - sent)));
                }
            }
        }
    }

    /// Sends what glass mirrors and passes; returns the share that it absorbs.
    fn at_glass(&self, interface: &DielectricInterface, send: impl FnMut(Continuation)) -> Rgb {
        let depth = self.path.depth.into();
        let next = interface.continuations(depth, SPLIT_DEPTH, || self.chance(0));
        next.into_iter().flatten().for_each(send);
        interface.absorbed()
    }

    /// Sends what a surface mirrors and what its glossy lobes reflect; returns the share that was
    /// sent on.
    fn at_surface(&self, surfaces: &Surfaces, mut send: impl FnMut(Continuation)) -> Rgb {
        let material = self.material;
        let Some(lobes) = material.glossy() else {
            send(self.at.mirrored(material.mirror));
            return material.mirror;
        };
        let frame = self.at.frame(surfaces);
        let wo = frame.to_local(-self.at.direction);
        let mirror = self.at.mirrored(material.mirror_at(wo.z));
        let branching = branching(material, lobes, wo, self.path.depth);
        let (of_mirror, of_lobes) = branching.choose(|| self.chance(4));
        let mirror = of_mirror.map(|probability| mirror.over(probability));
        let scattered = of_lobes.and_then(|probability| {
            let sampled = self.sampled(lobes, &frame, wo)?;
            Some(Continuation {
                density: sampled.density * probability,
                ..sampled.over(probability)
            })
        });
        let mut sent = Rgb::BLACK;
        let next = [mirror, scattered].into_iter().flatten();
        for (k, next) in next.enumerate() {
            if let Some(next) = self.survivor(next, 5 + k as u32) {
                sent += next.weight;
                send(next);
            }
        }
        sent
    }

    /// The part that continues in that direction.
    fn next(&self, surfaces: &Surfaces, next: Continuation) -> Outcome {
        let weight = self.path.weight * next.weight;
        let next = Path {
            leg: self.at.leg(surfaces, &next, self.path.leg.medium),
            id: self.path.id,
            weight,
            via: self.via(&next),
            depth: self.path.depth + 1,
            density: next.density_after(self.path.density.into()) as f32,
            passed_pane: self.path.passed_pane || next.is_straight,
        };
        let least = WEIGHT_CUT * self.heaviest;
        if weight.max_channel() > least && next.depth < DEPTH_CUT {
            Outcome::Path(next)
        } else {
            Outcome::Weak(next)
        }
    }

    /// What stands between the start of the path and where it continues.
    fn via(&self, next: &Continuation) -> Via {
        let is_mirrored = self.material.dielectric.is_none() && next.density == 0.0;
        match self.path.via {
            via if next.is_straight => via,
            Via::Direct if is_mirrored => Via::Mirror(self.item),
            _ => Via::Many,
        }
    }

    fn absorbed(&self, share: Rgb) -> Path {
        Path {
            weight: self.path.weight * share,
            ..*self.path
        }
    }

    fn chance(&self, dimension: u32) -> f64 {
        uniform(&[self.key, dimension]).into()
    }

    /// A direction sampled from glossy lobes; `None` if it falls below the surface.
    fn sampled(&self, lobes: &Lobes, frame: &Frame, wo: DVec3) -> Option<Continuation> {
        let sample = lobes.sample(wo, [0, 1, 2].map(|d| self.chance(d)))?;
        Some(Continuation {
            direction: frame.to_world(sample.wi),
            weight: sample.weight,
            density: sample.pdf,
            is_straight: false,
        })
    }

    /// Russian roulette relative to the heaviest path, as weights have a unit. Glossy surfaces
    /// alone play it: what mirrors and glass lose is reported as residue.
    fn survivor(&self, next: Continuation, dimension: u32) -> Option<Continuation> {
        let share = if self.path.depth == 0 {
            Roulette::SHARE
        } else {
            LATER_SHARE
        };
        let roulette = Roulette::below(share * self.heaviest);
        let weight = (self.path.weight * next.weight).max_channel();
        let survival = roulette.survival(weight, || self.chance(dimension));
        survival.map(|odds| next.over(odds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracer;
    use azulejo_scene::math::Ray;
    use azulejo_scene::{Dielectric, Object, Primitive, Scene, Shape};

    /// Weights of one path straight through two sheets of a material: escaped, absorbed, cut.
    fn fates(material: Material) -> [f64; 3] {
        fates_of(Rgb::WHITE, material)
    }

    fn fates_of(weight: Rgb, material: Material) -> [f64; 3] {
        let mut scene = Scene::default();
        let glass = scene.add_material(material);
        for (z, edge1, edge2) in [(0.0, DVec3::X, DVec3::Y), (1.0, DVec3::Y, DVec3::X)] {
            let corner = DVec3::new(-0.3, -0.4, z);
            let sheet = Primitive::parallelogram(corner, edge1, edge2, glass);
            scene
                .objects
                .push(Object::new("sheet", Shape::Primitive(sheet)));
        }
        let tracer = Tracer::new(&scene);
        let surfaces = Surfaces::new(&scene, &tracer);
        let ray = tracer.kernel_ray(&Ray::new(DVec3::new(0.0, 0.0, 2.0), -DVec3::Z));
        let start = Path::new(ray, 0, weight);
        let mut fates = [0.0; 3];
        follow(
            &surfaces,
            &mut vec![start],
            &mut Scratch::default(),
            1,
            |path, event| match event {
                Event::Escape => fates[0] += path.weight.r,
                Event::Absorbed => fates[1] += path.weight.r,
                Event::Cut => fates[2] += path.weight.r,
                Event::Surface { .. } => {}
            },
        );
        fates
    }

    #[test]
    fn coloured_glass_keeps_what_it_does_not_pass() {
        let mut material = Material::dielectric("filter", 1.0);
        material.dielectric = Some(Dielectric {
            ior: 1.0,
            transmittance: Rgb::grey(0.1),
            thin: false,
        });
        let [escaped, absorbed, cut] = fates(material);
        assert!((escaped - 0.01).abs() < 1e-6 && (absorbed - 0.99).abs() < 1e-6 && cut < 1e-6);
    }

    /// Straight through two panes, each of two surfaces that mirror 4%.
    #[test]
    fn panes_mirror_and_pass() {
        let [escaped, absorbed, cut] = fates(Material::pane("window", 1.5));
        assert!(
            (escaped + cut - 1.0).abs() < 1e-12 && absorbed == 0.0,
            "{escaped} {cut}"
        );
        let mut tinted = Material::pane("tinted", 1.5);
        tinted.mirror = Rgb::BLACK;
        let [escaped, absorbed, _] = fates(tinted);
        let through = (0.96f64 / 1.04).powi(2);
        assert!((escaped - through).abs() < 1e-12, "{escaped}");
        assert!((absorbed - (1.0 - through)).abs() < 1e-12, "{absorbed}");
    }

    /// One of a million rays is followed as far as a single one.
    #[test]
    fn what_is_cut_does_not_depend_on_the_unit() {
        let window = || Material::pane("window", 1.5);
        let (whole, small) = (fates(window()), fates_of(Rgb::grey(1e-6), window()));
        for (whole, small) in whole.into_iter().zip(small) {
            assert!((whole - 1e6 * small).abs() < 1e-12, "{whole} {small}");
        }
    }

    #[test]
    fn clear_glass_keeps_nothing() {
        let [escaped, absorbed, _] = fates(Material::dielectric("air", 1.0));
        assert!((escaped - 1.0).abs() < 1e-6 && absorbed == 0.0);
    }
}
