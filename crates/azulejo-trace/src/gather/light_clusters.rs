//! Lamps in groups, by which one of very many is chosen at little cost: a group first, then a lamp of it, both in
//! proportion to about what they would give if nothing stood between.
//!
//! A light tree of two levels (Estevez and Kulla, *Importance sampling of many lights with adaptive tree splitting*,
//! HPG 2018): a globe of a thousand triangles takes a hundred estimates a choice.

use super::GatherPoint;
use crate::lights::FlatEmitter;
use crate::sampling::{cumulative_sums, sample_discrete};
use glam::DVec3;

/// Most lamps of a group.
const MOST: usize = 16;

/// Lamps that are near one another.
struct LightCluster {
    lamps: Vec<u32>,
    centre: DVec3,
    /// Of a sphere around the middles of the lamps that has their corners, too.
    radius: f64,
    /// Radiance times area of all, brightest channel, W/sr.
    intensity: f64,
    /// The same along the normals of those that emit from one side.
    along: DVec3,
}

/// Part of a group's intensity that it is taken to have in every direction.
const EVERYWHERE: f64 = 0.02;

/// The same from within a group, where its lamps fill the view.
const NEAR: f64 = 0.5;

/// All lamps, each in one group.
pub(super) struct LightClusters(Vec<LightCluster>);

impl LightClusters {
    pub fn new(lamps: &[FlatEmitter]) -> LightClusters {
        let mut clusters = Vec::new();
        let mut parts: Vec<Vec<u32>> = vec![(0..lamps.len() as u32).collect()];
        while let Some(mut part) = parts.pop() {
            if part.len() <= MOST {
                clusters.push(LightCluster::of(part, lamps));
                continue;
            }
            let centre = |lamp: u32| lamps[lamp as usize].centre;
            let centres = || part.iter().map(|&lamp| centre(lamp));
            let low = centres().fold(DVec3::INFINITY, DVec3::min);
            let high = centres().fold(DVec3::NEG_INFINITY, DVec3::max);
            let axis = (high - low).max_position();
            part.sort_by(|&a, &b| {
                let [x, y] = [a, b].map(|lamp| centre(lamp)[axis]);
                x.total_cmp(&y).then(a.cmp(&b))
            });
            let half = part.split_off(part.len() / 2);
            parts.extend([half, part]);
        }
        LightClusters(clusters)
    }

    /// The cumulative sums of about what each group would give a point, W/m².
    pub fn cumulative(&self, point: &GatherPoint) -> Vec<f64> {
        cumulative_sums(self.0.iter().map(|cluster| cluster.irradiance(point)))
    }

    /// A lamp chosen by two numbers in 0..1, and its probability; `None` if none of its group can light the point.
    /// `cumulative` are the sums of the groups.
    pub fn lamp(
        &self,
        cumulative: &[f64],
        lamps: &[FlatEmitter],
        point: &GatherPoint,
        u: [f64; 2],
    ) -> Option<(u32, f64)> {
        let (cluster, of_cluster) = sample_discrete(cumulative, u[0])?;
        let members = &self.0[cluster].lamps;
        let irradiance = |&lamp: &u32| {
            let lamp = &lamps[lamp as usize];
            lamp.form_factor(point.position, point.normal) * lamp.emission.radiance.max_channel()
        };
        let (member, of_lamp) =
            sample_discrete(&cumulative_sums(members.iter().map(irradiance)), u[1])?;
        Some((members[member], of_cluster * of_lamp))
    }
}

impl LightCluster {
    fn of(lamps: Vec<u32>, all: &[FlatEmitter]) -> LightCluster {
        let (mut sum, mut intensity, mut along) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for &lamp in &lamps {
            let lamp = &all[lamp as usize];
            sum += lamp.centre;
            let of_lamp = lamp.emission.radiance.max_channel() * lamp.area;
            intensity += of_lamp;
            if !lamp.emission.emits_back {
                along += of_lamp * lamp.normal;
            }
        }
        let centre = sum / lamps.len().max(1) as f64;
        let reach = |lamp: &FlatEmitter| lamp.centre.distance(centre) + lamp.radius;
        let reaches = lamps.iter().map(|&lamp| reach(&all[lamp as usize]));
        LightCluster {
            centre,
            radius: reaches.fold(0.0, f64::max),
            intensity,
            along,
            lamps,
        }
    }

    /// About what it would give, W/m²: more than nothing wherever it can give something.
    fn irradiance(&self, point: &GatherPoint) -> f64 {
        let way = self.centre - point.position;
        let height = way.dot(point.normal) + self.radius;
        let square = way.length_squared() + self.radius * self.radius;
        // What is emitted along no one direction counts half.
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

    #[test]
    fn every_lamp_is_in_one_group_and_single_samples_are_right_on_average() {
        let scene = globe();
        let tracer = Tracer::new(&scene);
        let gatherer = Gatherer::new(Surfaces::new(&scene, &tracer));
        let lamps = gatherer.lights().flat();
        let clusters = gatherer.sources.clusters.as_ref().unwrap();
        let mut members: Vec<u32> = clusters.0.iter().flat_map(|c| c.lamps.clone()).collect();
        members.sort_unstable();
        assert_eq!(members, (0..lamps.len() as u32).collect::<Vec<_>>());
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
