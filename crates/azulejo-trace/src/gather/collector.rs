//! Sums the light that the paths of a gather find.

use super::next_event::NextEvent;
use super::{
    DiffuseHit, DiffuseLight, GatherPoint, Gatherer, MOST_SURVIVAL, REPLICATES, SURE_BOUNCES,
    Termination,
};
use crate::follow::{Event, Path, Scratch, Via, follow};
use crate::interaction::Roulette;
use crate::sampling::{cosine_hemisphere, hash, uniform};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};
use std::f64::consts::PI;

/// A hit from which a path goes on instead of reading the radiosity there.
struct Contact {
    id: u32,
    /// Weight of what the surface reflects.
    weight: Rgb,
    at: DiffuseHit,
}

/// What becomes of a path at a diffuse surface.
enum PathEnd {
    /// It reads this radiosity.
    Read(Rgb),
    /// What is reflected goes on, with this weight.
    GoesOn(Rgb),
    /// It ends.
    Absorbed,
}

/// Decides where paths end that have left so many diffuse surfaces.
struct Ending {
    termination: Termination,
    bounces: u32,
    seed: u32,
}

impl Ending {
    fn at(
        &self,
        light: &impl DiffuseLight,
        path: &Path,
        at: &DiffuseHit,
        replicate: usize,
    ) -> PathEnd {
        let may_go_on = self.bounces < self.termination.most_bounces();
        match self.termination {
            Termination::Radiosity => {
                let outgoing = light.outgoing(at, replicate);
                if may_go_on && path.depth == 0 && at.hit.t < outgoing.footprint {
                    PathEnd::GoesOn(path.weight * light.reflectance(at))
                } else {
                    PathEnd::Read(Rgb::from(outgoing.radiosity.map(f64::from)))
                }
            }
            Termination::Roulette => {
                let weight = path.weight * light.reflectance(at);
                match self.survival(weight, path, at) {
                    Some(odds) if may_go_on => PathEnd::GoesOn(weight / odds),
                    _ => PathEnd::Absorbed,
                }
            }
        }
    }

    /// Roulette by the weight of what is reflected; the paths of a gather begin with weight 1.
    fn survival(&self, weight: Rgb, path: &Path, at: &DiffuseHit) -> Option<f64> {
        if self.bounces < SURE_BOUNCES {
            return (weight.max_channel() > 0.0).then_some(1.0);
        }
        let roulette = Roulette {
            below: 1.0,
            most: MOST_SURVIVAL,
        };
        let place = [path.id, at.hit.item, at.hit.t.to_bits()];
        let chance = || uniform(&[hash(&[self.seed, 0x5c]), hash(&place)]).into();
        roulette.survival(weight.max_channel(), chance)
    }
}

/// Sums what paths find.
pub(super) struct Collector<'g, 'a, L> {
    gatherer: &'g Gatherer<'a>,
    light: &'g L,
    /// Per point and replicate.
    sums: Vec<[[f64; 3]; REPLICATES]>,
    near: Vec<Contact>,
    next_event: NextEvent,
    termination: Termination,
}

impl<'g, 'a, L: DiffuseLight> Collector<'g, 'a, L> {
    pub(super) fn new(
        gatherer: &'g Gatherer<'a>,
        light: &'g L,
        points: usize,
        termination: Termination,
    ) -> Self {
        Collector {
            gatherer,
            light,
            termination,
            sums: vec![[[0.0; 3]; REPLICATES]; points],
            near: Vec::new(),
            next_event: NextEvent::default(),
        }
    }

    /// The sum of what the paths of each point and replicate found.
    pub(super) fn sums(&self) -> &[[[f64; 3]; REPLICATES]] {
        &self.sums
    }

    /// Whether hits wait for [`contacts`](Collector::contacts).
    pub(super) fn has_contacts(&self) -> bool {
        !self.near.is_empty()
    }

    /// Follows `paths`, which have left `bounces` diffuse surfaces, and sums the light that they
    /// reach; hits from which they go on are kept for [`contacts`](Collector::contacts).
    pub(super) fn follow(
        &mut self,
        paths: &mut Vec<Path>,
        scratch: &mut Scratch,
        seed: u32,
        bounces: u32,
    ) {
        let (gatherer, light) = (self.gatherer, self.light);
        let ending = Ending {
            termination: self.termination,
            bounces,
            seed,
        };
        let ambient = gatherer.ambient() * PI;
        let (sums, near) = (&mut self.sums, &mut self.near);
        let next_event = &mut self.next_event;
        follow(&gatherer.surfaces, paths, scratch, seed, |path, event| {
            let (point, replicate) = (path.id as usize / REPLICATES, path.id as usize % REPLICATES);
            let found = match event {
                Event::Escape => ambient,
                Event::Cut | Event::Absorbed => return,
                Event::Surface { hit, front } => {
                    next_event.add(gatherer, path, &hit, path.id, seed);
                    let ray = path.ray;
                    let at = DiffuseHit { ray, hit, front };
                    let stray = gatherer.stray_exitance(path, &hit, front);
                    match ending.at(light, path, &at, replicate) {
                        PathEnd::Read(radiosity) => stray + radiosity,
                        PathEnd::GoesOn(weight) => {
                            let id = path.id;
                            near.push(Contact { id, weight, at });
                            stray
                        }
                        PathEnd::Absorbed => stray,
                    }
                }
            };
            let sum = &mut sums[point][replicate];
            (0..3).for_each(|k| sum[k] += path.weight[k] * found[k]);
        });
        next_event.resolve(gatherer, |id, found| {
            let sum = &mut sums[id as usize / REPLICATES][id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += found[k]);
        });
    }

    /// Goes on from the hits that were kept: one sample of the direct light there, and one ray that
    /// continues. `origins` are the points of the gather. Fills `paths`.
    pub(super) fn contacts(&mut self, origins: &[GatherPoint], paths: &mut Vec<Path>, seed: u32) {
        let gatherer = self.gatherer;
        let tracer = gatherer.surfaces.tracer;
        let contacts = std::mem::take(&mut self.near);
        let mut points = Vec::with_capacity(contacts.len());
        paths.clear();
        for (index, contact) in contacts.iter().enumerate() {
            let found = tracer.resolve(&tracer.world_ray(&contact.at.ray), &contact.at.hit);
            let normal = if contact.at.front {
                found.normal
            } else {
                -found.normal
            };
            let weight = contact.weight;
            let key = hash(&[origins[contact.id as usize / REPLICATES].key, index as u32]);
            points.push((
                GatherPoint {
                    position: found.position,
                    normal,
                    key,
                },
                weight,
            ));
            let [u1, u2] = [0, 1].map(|d| f64::from(uniform(&[seed, key, contact.id, d])));
            let direction = Frame::from_normal(normal).to_world(cosine_hemisphere(u1, u2));
            let ray =
                tracer.kernel_ray(&Ray::new(tracer.leaving(found.position, normal), direction));
            if weight.max_channel() > 0.0 {
                paths.push(Path {
                    ray,
                    id: contact.id,
                    weight,
                    via: Via::Direct,
                    depth: 0,
                    density: 0.0,
                });
            }
        }
        let at: Vec<GatherPoint> = points.iter().map(|(p, _)| *p).collect();
        let direct = gatherer.direct_light().single_sample(&at, seed ^ 0x51);
        for ((contact, (_, weight)), e) in contacts.iter().zip(&points).zip(direct) {
            let sum =
                &mut self.sums[contact.id as usize / REPLICATES][contact.id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += weight[k] * e[k]);
        }
    }
}
