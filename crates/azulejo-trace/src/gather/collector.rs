//! Sums the light that the paths of a gather find.

use super::direct::Direct;
use super::next_event::NextEvent;
use super::{
    DiffuseHit, DiffuseLight, DirectLight, GatherPoint, Gatherer, LIGHT_WEIGHT, MOST_SURVIVAL,
    OutgoingRadiosity, REPLICATES, SURVIVAL, Termination, UNKNOWN_SHARE, UNKNOWN_SURVIVAL,
};
use crate::follow::{Event, Path, Scratch, follow};
use crate::sampling::{cosine_hemisphere, hash, uniform};
use azulejo_scene::Rgb;
use azulejo_scene::math::{Frame, Ray};

/// A diffuse hit from which a path may go on.
struct Contact {
    id: u32,
    /// Weight of the path that arrives.
    weight: Rgb,
    at: DiffuseHit,
    /// The radiosity that was read there, which what the path goes on to find replaces; black if
    /// none was.
    read: Rgb,
    /// Whether the hit is so near that its patch is too coarse to be read.
    is_near: bool,
}

/// Sums what paths find.
pub(super) struct Collector<'g, 'a, L> {
    gatherer: &'g Gatherer<'a>,
    light: &'g L,
    /// Per point and replicate.
    sums: Vec<[[f64; 3]; REPLICATES]>,
    near: Vec<Contact>,
    next_event: NextEvent,
    direct: Direct<'g>,
    termination: Termination,
    /// Whether there is no radiosity to be read.
    is_unknown: bool,
    /// Irradiance of each point as the patches give it: the scale of its roulette.
    expected: Vec<f64>,
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
            is_unknown: light.is_unknown(),
            sums: vec![[[0.0; 3]; REPLICATES]; points],
            near: Vec::new(),
            next_event: NextEvent::default(),
            direct: gatherer.direct_light(),
            expected: Vec::new(),
        }
    }

    /// The sum of what the paths of each point and replicate found.
    pub(super) fn sums(&self) -> &[[[f64; 3]; REPLICATES]] {
        &self.sums
    }

    /// Takes what has been gathered so far, beside `direct` light, as the scale of each point.
    pub(super) fn expect(&mut self, direct: &[DirectLight], rays: usize) {
        let of = |(sums, direct): (&[[f64; 3]; REPLICATES], &DirectLight)| {
            let indirect: Rgb = sums.iter().map(|&s| Rgb::from(s)).sum();
            (direct.whole().mean() + indirect / (rays * REPLICATES) as f64).max_channel()
        };
        self.expected = self.sums.iter().zip(direct).map(of).collect();
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
        let (termination, is_unknown) = (self.termination, self.is_unknown);
        let may_go_on = bounces < termination.most_bounces();
        let (sums, near) = (&mut self.sums, &mut self.near);
        let next_event = &mut self.next_event;
        follow(&gatherer.surfaces, paths, scratch, seed, |path, event| {
            let (point, replicate) = (path.id as usize / REPLICATES, path.id as usize % REPLICATES);
            let exitance = match event {
                Event::Escape => gatherer.escaped_exitance(path),
                Event::Cut | Event::Absorbed => return,
                Event::Surface { hit, front } => {
                    // Glossy surfaces sample the lights; what their paths meet of these is weighted against that.
                    next_event.add(gatherer, path, &hit, path.id, seed);
                    let ray = path.leg.ray;
                    let at = DiffuseHit { ray, hit, front };
                    let stray = gatherer.stray_exitance(path, &hit, front);
                    let outgoing = if is_unknown {
                        OutgoingRadiosity::default()
                    } else {
                        light.outgoing(&at, replicate)
                    };
                    // Patches are too coarse to be read from nearer than their size, unless through mirrors or glass.
                    let is_near = hit.t < outgoing.footprint && path.depth == 0;
                    let mut read = Rgb::from(outgoing.radiosity.map(f64::from));
                    // Keep hits from which paths go on; what is read there is then a control variate, or left out.
                    if may_go_on && (is_near || termination.is_random()) {
                        if is_near {
                            read = Rgb::BLACK;
                        }
                        near.push(Contact {
                            id: path.id,
                            weight: path.weight,
                            at,
                            read,
                            is_near,
                        });
                    }
                    stray + read
                }
            };
            let sum = &mut sums[point][replicate];
            (0..3).for_each(|k| sum[k] += path.weight[k] * exitance[k]);
        });
        // Test the samples of glossy surfaces for shadow together.
        next_event.resolve(gatherer, |id, contribution| {
            let sum = &mut sums[id as usize / REPLICATES][id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += contribution[k]);
        });
    }

    /// Goes on from the hits that were kept: one sample of the direct light there, and one ray that
    /// continues. `origins` are the points of the gather. Fills `paths`.
    ///
    /// What a hit reads is a control variate: with probability q the path finds S instead, and counts
    /// R + (S − R)/q, whose mean is that of S whatever R is.
    pub(super) fn contacts(&mut self, origins: &[GatherPoint], paths: &mut Vec<Path>, seed: u32) {
        let gatherer = self.gatherer;
        let tracer = gatherer.surfaces.tracer;
        let contacts = std::mem::take(&mut self.near);
        let mut points = Vec::with_capacity(contacts.len());
        paths.clear();
        for (index, contact) in contacts.iter().enumerate() {
            let (id, at) = (contact.id, &contact.at);
            let key = hash(&[origins[id as usize / REPLICATES].key, index as u32]);
            let random_key = hash(&[seed, key, id]);
            let random = |dimension: u32| f64::from(uniform(&[random_key, dimension]));
            let reflectance = self.light.reflectance(at);
            let odds = self.survival(contact, reflectance);
            let survives = odds >= 1.0 || random(2) < odds;
            // Direct light at a hit costs one ray and is most of what a path finds: where nothing is known it is
            // taken at all hits, and roulette decides on the rest.
            let direct_odds = if self.is_unknown { 1.0 } else { odds };
            if odds <= 0.0 || !(survives || self.is_unknown) {
                continue;
            }
            let arriving = contact.weight / direct_odds;
            if !self.is_unknown {
                let sum = &mut self.sums[id as usize / REPLICATES][id as usize % REPLICATES];
                (0..3).for_each(|k| sum[k] -= arriving[k] * contact.read[k]);
            }
            let (position, normal) = tracer.surface_point(&at.ray, &at.hit);
            let normal = if at.front { normal } else { -normal };
            let weight = arriving * reflectance;
            let point = GatherPoint {
                position,
                normal,
                key,
            };
            points.push((point, id, weight));
            if !survives {
                continue;
            }
            let direction =
                Frame::from_normal(normal).to_world(cosine_hemisphere(random(0), random(1)));
            let ray = tracer.kernel_ray(&Ray::new(tracer.leaving(position, normal), direction));
            paths.push(Path::new(ray, id, weight * (direct_odds / odds)));
        }
        let at: Vec<GatherPoint> = points.iter().map(|p| p.0).collect();
        let direct = self.direct.single_sample(&at, seed ^ 0x51);
        for (&(_, id, weight), e) in points.iter().zip(direct) {
            let sum = &mut self.sums[id as usize / REPLICATES][id as usize % REPLICATES];
            (0..3).for_each(|k| sum[k] += weight[k] * e[k]);
        }
    }

    /// The probability with which a path goes on. Without roulette 1; from near hits, which read
    /// nothing, by weight; elsewhere in proportion to what the path is expected to find, relative to
    /// what the point gets in all (Vorba and Křivánek, *Adjoint-driven Russian roulette and splitting
    /// in light transport simulation*, SIGGRAPH 2016).
    fn survival(&self, contact: &Contact, reflectance: Rgb) -> f64 {
        if reflectance.is_black() {
            return 0.0;
        }
        let weight = contact.weight.max_channel();
        if !self.termination.is_random() {
            return 1.0;
        }
        if contact.is_near {
            return (weight / LIGHT_WEIGHT).min(MOST_SURVIVAL);
        }
        if self.is_unknown {
            let carried = (contact.weight * reflectance).max_channel();
            return (UNKNOWN_SURVIVAL * carried).min(MOST_SURVIVAL);
        }
        let expected = self.expected[contact.id as usize / REPLICATES];
        // The light on a patch may be quite wrong, so a part does not depend on it.
        let share = (contact.read.max_channel() / expected.max(f64::MIN_POSITIVE)).min(1.0);
        let sure = UNKNOWN_SHARE * reflectance.max_channel();
        (SURVIVAL * weight * (share + sure)).min(MOST_SURVIVAL)
    }
}
