//! Lights in groups, by which one of very many is chosen at little cost: a group first, then a light of it, both in
//! proportion to about what they would give if nothing stood between.
//!
//! A light tree of two levels (Estevez and Kulla, *Importance sampling of many lights with adaptive tree splitting*,
//! HPG 2018): a globe of a thousand triangles takes a hundred estimates a choice.

use super::GatherPoint;
use super::direct::MOST_TERMS;
use super::terms::{Target, Term};
use crate::Surfaces;
use crate::lights::{FlatEmitter, Lights, unoccluded};
use crate::sampling::{cumulative_sums, sample_discrete};
use azulejo_scene::{LightKind, Rgb};
use glam::DVec3;
use std::f64::consts::PI;

/// Most lights of a group, if there are up to four thousand; else a quarter of the root of their number, so that
/// neither groups nor lights of one are many.
const MOST: usize = 16;

/// A light by its number: of the flat emitters, or of the lights without area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Which {
    Flat(u32),
    Delta(u32),
}

/// A light as its group knows it.
#[derive(Clone, Copy)]
struct Member {
    which: Which,
    centre: DVec3,
    /// Of a sphere around the centre that has all of it.
    radius: f64,
    /// What [`LightCluster::intensity`] sums.
    intensity: f64,
    /// What [`LightCluster::along`] sums.
    along: DVec3,
}

/// Lights that are near one another.
struct LightCluster {
    lights: Vec<Which>,
    centre: DVec3,
    /// Of a sphere around the middles of the lights that has their corners, too.
    radius: f64,
    /// Radiance times area of all, brightest channel, W/sr. A point counts as a ball: twice its intensity.
    intensity: f64,
    /// The same along the normals of those that emit to one side.
    along: DVec3,
}

/// Part of a group's intensity that it is taken to have in every direction.
const EVERYWHERE: f64 = 0.02;

/// The same from within a group, where its lamps fill the view.
const NEAR: f64 = 0.5;

/// The lights of a kind of which there are many, each in one group.
pub(super) struct LightClusters {
    clusters: Vec<LightCluster>,
    has_flat: bool,
    has_delta: bool,
}

impl LightClusters {
    /// Groups `flat` and the lights without area that have a place, either if they are many; `None` if neither are.
    pub fn new(flat: &[FlatEmitter], delta: &[LightKind]) -> Option<LightClusters> {
        let [has_flat, has_delta] = [flat.len(), delta.len()].map(|count| count > MOST_TERMS);
        let mut members = Vec::new();
        if has_flat {
            members.extend((0..).zip(flat).map(|(k, lamp)| Member::flat(k, lamp)));
        }
        if has_delta {
            members.extend(
                (0..)
                    .zip(delta)
                    .filter_map(|(k, light)| Member::delta(k, light)),
            );
        }
        if members.is_empty() {
            return None;
        }
        let most = MOST.max(members.len().isqrt() / 4);
        let mut clusters = Vec::new();
        let mut parts = vec![members];
        while let Some(mut part) = parts.pop() {
            if part.len() <= most {
                clusters.push(LightCluster::of(&part));
                continue;
            }
            let centres = || part.iter().map(|light| light.centre);
            let low = centres().fold(DVec3::INFINITY, DVec3::min);
            let high = centres().fold(DVec3::NEG_INFINITY, DVec3::max);
            let axis = (high - low).max_position();
            part.sort_by(|a, b| {
                let order = a.centre[axis].total_cmp(&b.centre[axis]);
                order.then(a.which.cmp(&b.which))
            });
            let half = part.split_off(part.len() / 2);
            parts.extend([half, part]);
        }
        Some(LightClusters {
            clusters,
            has_flat,
            has_delta,
        })
    }

    /// Whether flat emitters are in groups.
    pub fn has_flat(&self) -> bool {
        self.has_flat
    }

    /// Whether a light without area is in a group.
    pub fn has(&self, light: &LightKind) -> bool {
        self.has_delta && Member::delta(0, light).is_some()
    }

    /// The cumulative sums of about what each group would give a point, W/m².
    pub fn cumulative(&self, point: &GatherPoint) -> Vec<f64> {
        cumulative_sums(
            self.clusters
                .iter()
                .map(|cluster| cluster.irradiance(point)),
        )
    }

    /// The term of a light chosen by two numbers in 0..1, and its probability; `None` if none of its group can light
    /// the point. `cumulative` are the sums of the groups.
    pub fn choose(
        &self,
        cumulative: &[f64],
        (lights, surfaces): (&Lights, &Surfaces),
        point: &GatherPoint,
        u: [f64; 2],
    ) -> Option<(Term, f64)> {
        let (p, n) = (point.position, point.normal);
        let term = |&which: &Which| match which {
            Which::Flat(k) => {
                let lamp = &lights.flat()[k as usize];
                let radiance = lamp.emission.radiance;
                let full = radiance * (PI * lamp.form_factor(p, n));
                Some(Term::of_many(full, radiance, Target::Flat(k)))
            }
            Which::Delta(k) => {
                let (target, full) = unoccluded(&lights.delta[k as usize], p, n, surfaces)?;
                Some(Term::of_many(full, Rgb::BLACK, Target::Delta(target)))
            }
        };
        let (cluster, of_cluster) = sample_discrete(cumulative, u[0])?;
        let terms = self.clusters[cluster].lights.iter().map(term);
        let mut terms: Vec<Option<Term>> = terms.collect();
        let full = |term: &Option<Term>| term.as_ref().map_or(0.0, |term| term.full.max_channel());
        let (chosen, of_light) = sample_discrete(&cumulative_sums(terms.iter().map(full)), u[1])?;
        Some((terms[chosen].take()?, of_cluster * of_light))
    }
}

impl Member {
    fn flat(number: u32, lamp: &FlatEmitter) -> Member {
        let intensity = lamp.emission.radiance.max_channel() * lamp.area;
        let one_sided = if lamp.emission.emits_back { 0.0 } else { 1.0 };
        Member {
            which: Which::Flat(number),
            centre: lamp.centre,
            radius: lamp.radius,
            intensity,
            along: one_sided * intensity * lamp.normal,
        }
    }

    /// `None` for one infinitely far away.
    fn delta(number: u32, light: &LightKind) -> Option<Member> {
        let (centre, intensity, along) = match *light {
            LightKind::Point {
                position,
                intensity,
            } => (position, 2.0 * intensity.max_channel(), DVec3::ZERO),
            LightKind::Spot {
                position,
                direction,
                intensity,
                ..
            } => (
                position,
                intensity.max_channel(),
                intensity.max_channel() * direction.normalize_or_zero(),
            ),
            LightKind::Luminaire {
                position,
                world_from_web,
                scale,
                ref web,
            } => {
                // Between a point, which shines to all sides, and a spot.
                let mean = web.mean_direction();
                let most = scale.max_channel() * web.most();
                let intensity = (2.0 - mean.length()) * most;
                (position, intensity, intensity * (world_from_web * mean))
            }
            LightKind::Directional { .. }
            | LightKind::Ambient { .. }
            | LightKind::Environment(_) => return None,
        };
        Some(Member {
            which: Which::Delta(number),
            centre,
            radius: 0.0,
            intensity,
            along,
        })
    }
}

impl LightCluster {
    fn of(members: &[Member]) -> LightCluster {
        let sum: DVec3 = members.iter().map(|light| light.centre).sum();
        let centre = sum / members.len().max(1) as f64;
        let reach = |light: &Member| light.centre.distance(centre) + light.radius;
        LightCluster {
            lights: members.iter().map(|light| light.which).collect(),
            centre,
            radius: members.iter().map(reach).fold(0.0, f64::max),
            intensity: members.iter().map(|light| light.intensity).sum(),
            along: members.iter().map(|light| light.along).sum(),
        }
    }

    /// About what it would give, W/m²: more than nothing wherever it can give something.
    fn irradiance(&self, point: &GatherPoint) -> f64 {
        let way = self.centre - point.position;
        let height = way.dot(point.normal) + self.radius;
        let square = way.length_squared() + self.radius * self.radius;
        // What is emitted along no one direction counts half. A place on a light without area has no distance to it.
        let square = square.max(f64::MIN_POSITIVE);
        let facing = -way.dot(self.along) / square.sqrt();
        let scattered = 0.5 * (self.intensity - self.along.length());
        // From near by some of it is seen from its front, however far aside the middle is.
        let near = NEAR * self.radius * self.radius / square;
        let toward = facing.max(0.0) + scattered + (EVERYWHERE + near) * self.intensity;
        toward * height.max(0.0) / (square * square.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::Gatherer;
    use crate::{Surfaces, Tracer};
    use azulejo_scene::{Light, LightKind, Material, Mesh, Object, Rgb, Scene, Shape};
    use std::f64::consts::{PI, TAU};

    /// A globe of a hundred lamps, half of it behind a plate, a wall that shines, and a light without area.
    fn globe() -> Scene {
        let mut scene = Scene::default();
        let glowing = scene.add_material(Material::emitter("glowing", Rgb::new(3.0, 2.0, 1.0)));
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let (rings, steps) = (10, 10);
        let mut mesh = Mesh::default();
        for k in 0..=rings {
            let height = PI * f64::from(k) / f64::from(rings);
            for j in 0..steps {
                let (sin, cos) = (TAU * f64::from(j) / f64::from(steps)).sin_cos();
                let p = DVec3::new(height.sin() * cos, height.sin() * sin, height.cos());
                mesh.positions.push(DVec3::Z * 2.0 + 0.5 * p);
            }
        }
        for k in 0..rings {
            for j in 0..steps {
                let [a, b] = [j, (j + 1) % steps].map(|j| k * steps + j);
                let [c, d] = [a, b].map(|v| v + steps);
                if k + 1 < rings {
                    mesh.push_face(&[a, c, d], glowing);
                }
                if k > 0 {
                    mesh.push_face(&[a, d, b], glowing);
                }
            }
        }
        let plate = [[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]];
        let mut shade = Mesh {
            positions: plate.map(|[x, y]| DVec3::new(x, y, 1.2)).to_vec(),
            ..Mesh::default()
        };
        shade.push_face(&[0, 1, 2, 3], grey);
        let wall = [[-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [-1.0, 2.0]];
        let mut shining = Mesh {
            positions: wall.map(|[y, z]| DVec3::new(-1.2, y, z)).to_vec(),
            ..Mesh::default()
        };
        shining.push_face(&[0, 1, 2, 3], glowing);
        for mesh in [mesh, shade, shining] {
            scene.objects.push(Object::new("part", Shape::Mesh(mesh)));
        }
        scene.lights.push(Light {
            name: "point".into(),
            kind: LightKind::Point {
                position: DVec3::new(-2.0, 0.0, 1.0),
                intensity: Rgb::grey(1.0),
            },
        });
        scene
    }

    /// A floor below `count` points and spots, a third of them behind a plate, with a directional light.
    fn stars(count: u32) -> Scene {
        let mut scene = Scene::default();
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        let plate = [[0.0, -3.0], [1.0, -3.0], [1.0, 3.0], [0.0, 3.0]];
        let mut shade = Mesh {
            positions: plate.map(|[x, y]| DVec3::new(x, y, 1.0)).to_vec(),
            ..Mesh::default()
        };
        shade.push_face(&[0, 1, 2, 3], grey);
        scene.objects.push(Object::new("plate", Shape::Mesh(shade)));
        for k in 0..count {
            let [x, y, z] = [0, 1, 2].map(|d| f64::from(crate::sampling::uniform(&[k, d])));
            let position = DVec3::new(4.0 * x - 2.0, 4.0 * y - 2.0, 1.5 + z);
            let intensity = Rgb::new(1.0, 0.5, 0.1) * (0.1 + x * x);
            let kind = if k % 3 == 0 {
                LightKind::Spot {
                    position,
                    direction: DVec3::new(x - 0.5, y - 0.5, -1.0).normalize(),
                    intensity,
                    inner: 0.3,
                    outer: 0.6,
                }
            } else {
                LightKind::Point {
                    position,
                    intensity,
                }
            };
            scene.lights.push(Light {
                name: format!("{k}"),
                kind,
            });
        }
        scene.lights.push(Light {
            name: "far".into(),
            kind: LightKind::Directional {
                direction: -DVec3::Z,
                irradiance: Rgb::grey(40.0),
                half_angle: 0.0,
            },
        });
        scene
    }

    #[test]
    fn very_many_lights_without_area_are_right_on_average() {
        // Listed one by one at points, and in groups alone.
        for count in [500, 2_000] {
            let scene = stars(count);
            let tracer = Tracer::new(&scene);
            let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
            let is_alone = gatherer.sources.groups_alone(gatherer.lights()).is_some();
            assert_eq!(is_alone, count == 2_000);
            for k in 0..4 {
                let point = GatherPoint {
                    position: DVec3::new(0.5 * f64::from(k) - 0.6, 0.1, 0.0),
                    normal: DVec3::new(0.0, 0.3, 1.0).normalize(),
                    key: k,
                };
                let (p, n) = (point.position, point.normal);
                let from = tracer.leaving(p, n);
                let (mut rays, mut fulls) = (Vec::new(), Vec::new());
                for light in &gatherer.lights().delta {
                    if let Some((target, full)) = unoccluded(light, p, n, gatherer.surfaces()) {
                        rays.push(crate::interaction::shadow_ray(&tracer, from, target));
                        fulls.push(full);
                    }
                }
                let mut shares = Vec::new();
                tracer.transmittance(&rays, &mut shares);
                let seen = fulls
                    .iter()
                    .zip(&shares)
                    .map(|(&full, &share)| full * share);
                let expected = seen.sum::<Rgb>().mean();
                let estimate = gatherer.direct(&[point], 512, 1)[0].whole();
                assert!(
                    (estimate.mean().mean() / expected - 1.0).abs() < 0.01,
                    "{count}: {estimate:?} for {expected}"
                );
                let rounds = 20_000;
                let (mut sum, mut squares) = (0.0, 0.0);
                for seed in 0..rounds {
                    let sample = gatherer.direct_light().single_sample(&[point], seed)[0].mean();
                    sum += sample;
                    squares += sample * sample;
                }
                let (mean, rounds) = (sum / f64::from(rounds), f64::from(rounds));
                let error = ((squares / rounds - mean * mean) / rounds).sqrt();
                assert!(
                    (mean - expected).abs() < 4.0 * error && error < 0.03 * expected,
                    "{count}, {k}: {mean} ± {error} for {expected}"
                );
            }
        }
    }

    #[test]
    fn every_lamp_is_in_one_group_and_single_samples_are_right_on_average() {
        let scene = globe();
        let tracer = Tracer::new(&scene);
        let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
        let lamps = gatherer.lights().flat();
        let clusters = gatherer.sources.clusters.as_ref().unwrap();
        let mut members: Vec<Which> = clusters
            .clusters
            .iter()
            .flat_map(|c| c.lights.clone())
            .collect();
        members.sort_unstable();
        let all = (0..lamps.len() as u32).map(Which::Flat);
        assert_eq!(members, all.collect::<Vec<_>>());
        assert!(lamps.len() > 90);
        let place = |k: u32| GatherPoint {
            // The first at the foot of the wall.
            position: DVec3::new(0.3 * f64::from(k) - 1.1999, 0.1, 0.0),
            normal: DVec3::new(0.0, 0.3, 1.0).normalize(),
            key: k,
        };
        let points: Vec<GatherPoint> = (0..6).map(place).collect();
        let exact = gatherer.direct(&points, 512, 1);
        let (mut sums, mut squares) = ([0.0; 6], [0.0; 6]);
        let rounds = 20_000;
        for seed in 0..rounds {
            let samples = gatherer.direct_light().single_sample(&points, seed);
            for (k, sample) in samples.iter().enumerate() {
                sums[k] += sample.mean();
                squares[k] += sample.mean().powi(2);
            }
        }
        for k in 0..6 {
            let count = f64::from(rounds);
            let mean = sums[k] / count;
            let error = ((squares[k] / count - mean * mean) / count).sqrt();
            let expected = exact[k].whole().mean().mean();
            assert!(
                (mean - expected).abs() < 4.0 * error + 0.002 * expected,
                "{k}: {mean} ± {error} for {expected}"
            );
            assert!(error < 0.03 * expected, "{k}: {mean} ± {error}");
        }
    }
}
