//! Follows rays through mirrors and glass, and by chance from glossy surfaces, to everything that
//! they see.

use crate::sampling::{hash, uniform};
use crate::{Hit, KernelHit, KernelRay, Surfaces};
use azulejo_scene::brdf::Lobes;
use azulejo_scene::fresnel;
use azulejo_scene::math::{Frame, Ray, reflect};
use azulejo_scene::{Dielectric, Material, Rgb};
use glam::DVec3;

/// A ray on its way, and what it stands for.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Where it goes next.
    pub ray: KernelRay,
    /// Whatever the caller wants to know when the path arrives.
    pub id: u32,
    /// Share of the light that this path carries, per channel.
    pub weight: Rgb,
    /// What it met so far.
    pub via: Via,
    /// Interfaces met so far.
    pub depth: u16,
    /// Density of the ray's direction, 1/sr, if a glossy surface sent it there by chance; 0
    /// otherwise. What is also looked for by other ways is weighted by it.
    pub density: f32,
}

/// What stood between the start of a path and where it is now.
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
    /// It reached a surface, with its whole weight; what the surface mirrors or transmits goes
    /// on (additive model, Sillion and Puech 1989).
    Surface {
        /// Where.
        hit: KernelHit,
        /// Whether it arrived at the front.
        front: bool,
    },
    /// The surface kept the path's weight beyond what its material tells. Of coloured glass it
    /// is what it neither mirrored nor let pass. Other surfaces keep 1 − ρ_d − ρ_s of what
    /// reaches them; glossy ones keep less, by what they send on, and this weight is negative.
    Absorbed,
    /// It left the scene.
    Escape,
    /// What it still carried was too little to follow: the residue.
    Cut,
}

/// A path is dropped, and its weight reported as [`Event::Cut`], below this share of the heaviest
/// path that it set out with: weights have a unit, and most are divided by the number of paths.
pub const WEIGHT_CUT: f64 = 1e-6;

/// A path is dropped after this many interfaces: facing perfect mirrors would hold it forever.
pub const DEPTH_CUT: u16 = 1000;

/// Dielectrics split a path in two at its first interfaces; later ones choose one branch.
const SPLIT_DEPTH: u16 = 2;

/// Below this share of the heaviest path, one that leaves a glossy surface lives on by chance with
/// this weight: rooms of glossy walls end, and the mean stays right.
const ROULETTE: f64 = 0.01;

/// Working memory of [`follow`], kept between calls to save allocations.
#[derive(Default)]
pub struct Scratch {
    rays: Vec<KernelRay>,
    hits: Vec<KernelHit>,
    next: Vec<Path>,
}

/// Traces `paths` to their ends and tells `on_event` of every surface they reach.
///
/// Per path the shares add up: what is deposited at surfaces times what these absorb or reflect
/// diffusely, what escapes and what is cut make the weight it started with. Empties `paths`.
/// The order of events depends on the paths alone. `seed` keys the choices at glass and on glossy
/// surfaces, from which a path goes on in one direction, drawn in proportion to what its lobes
/// reflect.
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
        scratch.rays.extend(paths.iter().map(|p| p.ray));
        surfaces.tracer.closest(&scratch.rays, &mut scratch.hits);
        for (index, (path, hit)) in paths.iter().zip(&scratch.hits).enumerate() {
            if hit.item == KernelHit::MISS {
                on_event(path, Event::Escape);
                continue;
            }
            on_event(
                path,
                Event::Surface {
                    hit: *hit,
                    front: surfaces.is_front(&path.ray, hit),
                },
            );
            if surfaces.is_specular(hit.item) {
                let meeting = Meeting {
                    path,
                    hit,
                    key: hash(&[seed, wave, index as u32]),
                    heaviest,
                };
                meeting.go_on(surfaces, |next| match next {
                    Next::Path(p) => scratch.next.push(p),
                    Next::Weak(rest) => on_event(&rest, Event::Cut),
                    Next::Kept(kept) => on_event(&kept, Event::Absorbed),
                });
            }
        }
        std::mem::swap(paths, &mut scratch.next);
        scratch.next.clear();
        wave += 1;
    }
}

/// What becomes of a path at a mirror or glass.
enum Next {
    /// A part that goes on.
    Path(Path),
    /// A part that is too weak to follow.
    Weak(Path),
    /// What the glass keeps.
    Kept(Path),
}

/// A path at a mirror, glass or a glossy surface.
struct Meeting<'p> {
    path: &'p Path,
    hit: &'p KernelHit,
    /// Keys its random numbers.
    key: u32,
    /// Weight of the heaviest path that set out with it.
    heaviest: f64,
}

/// A direction that a path goes on in.
struct Way {
    direction: DVec3,
    share: Rgb,
    via: Via,
    density: f64,
}

impl Way {
    /// The same, taken with that probability.
    fn over(self, odds: f64) -> Way {
        Way {
            share: self.share / odds,
            ..self
        }
    }

    fn sharp(direction: DVec3, share: Rgb, via: Via) -> Way {
        Way {
            direction,
            share,
            via,
            density: 0.0,
        }
    }
}

impl Meeting<'_> {
    /// The parts that the path is divided into; those too light to follow are weak.
    fn go_on(&self, surfaces: &Surfaces, mut push: impl FnMut(Next)) {
        let ray = surfaces.tracer.world_ray(&self.path.ray);
        let at = surfaces.tracer.resolve(&ray, self.hit);
        let direction = ray.direction.normalize();
        let facing = if at.entering { at.normal } else { -at.normal };
        let material = surfaces.material(self.hit.item);
        let send = |way: Way| push(self.next(surfaces, &at, facing, way));
        match material.dielectric {
            Some(glass) => {
                let kept = self.at_glass(material, &glass, (direction, facing), &at, send);
                if kept.max_channel() > f64::EPSILON {
                    push(Next::Kept(self.kept(kept)));
                }
            }
            None => {
                let sent = self.at_surface(surfaces, material, &at, (direction, facing), send);
                if sent != material.mirror {
                    push(Next::Kept(self.kept(material.mirror - sent)));
                }
            }
        }
    }

    /// Sends what a surface mirrors and what its glossy lobes reflect; returns the share that was
    /// sent on.
    ///
    /// At the first interface a path is divided in two where a surface does both; later it takes
    /// one way by chance, or rooms of such surfaces would hold twice as many paths each time.
    fn at_surface(
        &self,
        surfaces: &Surfaces,
        material: &Material,
        at: &Hit,
        (direction, facing): (DVec3, DVec3),
        mut send: impl FnMut(Way),
    ) -> Rgb {
        let via = match self.path.via {
            Via::Direct => Via::Mirror(self.hit.item),
            _ => Via::Many,
        };
        let mirror = Way::sharp(reflect(direction, facing), material.mirror, via);
        let Some(lobes) = material.glossy() else {
            send(mirror);
            return material.mirror;
        };
        let frame = surfaces.frame(at, facing);
        let wo = frame.to_local(-direction);
        let mirrored = material.mirror.mean();
        let divides = self.path.depth == 0 || mirrored == 0.0;
        let odds = match divides {
            true => 1.0,
            false => mirrored / (mirrored + lobes.likely(wo)),
        };
        let takes_mirror = mirrored > 0.0 && (divides || self.chance(4) < odds);
        let takes_lobe = divides || !takes_mirror;
        let ways = [
            takes_mirror.then(|| mirror.over(odds)),
            takes_lobe
                .then(|| self.scattered(lobes, &frame, wo))
                .flatten()
                .map(|way| way.over(if divides { 1.0 } else { 1.0 - odds })),
        ];
        let mut sent = Rgb::BLACK;
        for (k, way) in ways.into_iter().flatten().enumerate() {
            if let Some(way) = self.survivor(way, 5 + k as u32) {
                sent += way.share;
                send(way);
            }
        }
        sent
    }

    /// The part that goes on in that way.
    fn next(&self, surfaces: &Surfaces, at: &Hit, facing: DVec3, way: Way) -> Next {
        let weight = self.path.weight * way.share;
        let side = facing * 1f64.copysign(way.direction.dot(facing));
        let ray = Ray::new(surfaces.tracer.leaving(at.position, side), way.direction);
        let next = Path {
            ray: surfaces.tracer.kernel_ray(&ray),
            id: self.path.id,
            weight,
            via: way.via,
            depth: self.path.depth + 1,
            density: way.density as f32,
        };
        let least = WEIGHT_CUT * self.heaviest;
        if weight.max_channel() > least && next.depth < DEPTH_CUT {
            Next::Path(next)
        } else {
            Next::Weak(next)
        }
    }

    fn kept(&self, share: Rgb) -> Path {
        Path {
            weight: self.path.weight * share,
            ..*self.path
        }
    }

    fn chance(&self, dimension: u32) -> f64 {
        uniform(&[self.key, dimension]).into()
    }

    /// A direction drawn from glossy lobes; `None` if it is lost below the surface.
    fn scattered(&self, lobes: &Lobes, frame: &Frame, wo: DVec3) -> Option<Way> {
        let sample = lobes.sample(wo, [0, 1, 2].map(|d| self.chance(d)))?;
        Some(Way {
            direction: frame.to_world(sample.wi),
            share: sample.weight,
            via: Via::Many,
            density: sample.pdf,
        })
    }

    /// Russian roulette: a way that carries little goes on by chance, and is heavier then.
    fn survivor(&self, way: Way, dimension: u32) -> Option<Way> {
        let weight = (self.path.weight * way.share).max_channel();
        let odds = (weight / (ROULETTE * self.heaviest)).min(1.0);
        // A weight of zero has no odds at all.
        (self.chance(dimension) < odds).then(|| way.over(odds))
    }

    /// Sends what glass mirrors and passes; returns the share that it keeps.
    fn at_glass(
        &self,
        material: &Material,
        glass: &Dielectric,
        (direction, facing): (DVec3, DVec3),
        at: &Hit,
        mut send: impl FnMut(Way),
    ) -> Rgb {
        let (mirrored, passed) = glass_shares(glass, direction, facing, at.entering);
        let reflected_share = material.mirror * mirrored.0;
        let sharp = |direction, share| Way::sharp(direction, share, Via::Many);
        match passed {
            None => send(sharp(mirrored.1, reflected_share)),
            Some((direction_in, passed_share)) if self.path.depth < SPLIT_DEPTH => {
                send(sharp(mirrored.1, reflected_share));
                send(sharp(direction_in, passed_share));
            }
            Some(_) if self.chance(0) < mirrored.0 => {
                send(sharp(mirrored.1, material.mirror));
            }
            Some((direction_in, passed_share)) => {
                send(sharp(direction_in, passed_share / (1.0 - mirrored.0)));
            }
        }
        Rgb::WHITE - reflected_share - glass.transmittance * (1.0 - mirrored.0)
    }
}

/// Reflectance and direction of the mirrored part; direction and share of the part that passes.
///
/// Paths run against the light, so the share that passes into a body carries the square of the
/// ratio of indices: L/n² is what refraction conserves. Behind a pane is the same medium as before.
fn glass_shares(
    glass: &Dielectric,
    direction: DVec3,
    facing: DVec3,
    entering: bool,
) -> ((f64, DVec3), Option<(DVec3, Rgb)>) {
    let eta = if entering || glass.thin {
        glass.ior
    } else {
        1.0 / glass.ior
    };
    let (split, density) = match glass.thin {
        true => (fresnel::pane(direction, facing, eta), 1.0),
        false => (fresnel::split(direction, facing, eta), eta * eta),
    };
    let share = glass.transmittance * ((1.0 - split.reflectance) / density);
    let passed = split.refracted.map(|d| (d, share));
    ((split.reflectance, split.reflected), passed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tracer;
    use azulejo_scene::{Object, Primitive, Scene, Shape};

    /// What becomes of one path straight through two sheets of a material, by kind of event.
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
        let start = Path {
            ray,
            id: 0,
            weight,
            via: Via::Direct,
            depth: 0,
            density: 0.0,
        };
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
