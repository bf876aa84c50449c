//! What rows see of the sky, by patches of it: directly, and by way of mirrors and glass.

use super::points::POINTS;
use super::{FactorPoint, FormFactors, PointFactors, PreparedPlan, RowRemainder};
use crate::error::FactorsError;
use crate::rays::straight;
use azulejo_scene::environment::upright;
use azulejo_scene::math::Ray;
use azulejo_scene::sky::SkyDivision;
use azulejo_scene::{Material, Up};
use azulejo_trace::Progress;
use azulejo_trace::follow::{Event, Scratch, follow};
use azulejo_trace::sampling::{hash, seeds, sobol};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Fewest rays of each row, and toward each patch of the sky.
const LEAST_RAYS: usize = 8192;
const LEAST_OF_PATCH: usize = 16;

/// Memory of a share with its error, while those of all rows are put together.
const BYTES: usize = 2 * 2 * size_of::<f32>();

/// The share of each row's light that leaves toward each patch of the sky, with its standard error.
///
/// The irradiance of a row is π times the sum of its shares times the radiances of the patches.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyFactors {
    /// The patches.
    pub division: SkyDivision,
    /// North of the scene, radians clockwise, seen from above, from +y where z is up and from −z where y is up.
    pub north: f64,
    /// One row after the other, a share for each patch: that of patch 0 is what leaves toward the ground, and the
    /// others add up to what leaves toward the sky.
    pub shares: Vec<f32>,
    /// Their standard errors, as those of independent rays: an upper bound.
    pub errors: Vec<f32>,
}

impl SkyFactors {
    /// Unit vectors of the scene to the middles of the patches, straight down for the ground, where `up` is up.
    pub fn directions(&self, up: Up) -> Vec<DVec3> {
        let world = upright(up, self.north);
        let patches = 0..self.division.count();
        patches
            .map(|k| world * self.division.direction(k))
            .collect()
    }

    /// Solid angles of the patches, sr.
    pub fn solid_angles(&self) -> Vec<f64> {
        let patches = 0..self.division.count();
        patches.map(|k| self.division.solid_angle(k)).collect()
    }

    /// The shares of a row.
    pub fn row(&self, row: usize) -> &[f32] {
        let count = self.division.count();
        &self.shares[row * count..][..count]
    }

    /// The standard errors of a row.
    pub fn row_errors(&self, row: usize) -> &[f32] {
        let count = self.division.count();
        &self.errors[row * count..][..count]
    }

    /// Means over groups of rows, by area: `groups` has the group of each row, `None` of those in none.
    #[must_use]
    pub fn grouped(&self, areas: &[f64], groups: &[Option<u32>], group_count: usize) -> SkyFactors {
        let count = self.division.count();
        let mut wholes = vec![0.0; group_count];
        for (area, group) in areas.iter().zip(groups) {
            if let Some(group) = group {
                wholes[*group as usize] += area;
            }
        }
        let mean = |values: &[f32], power: f64| -> Vec<f64> {
            let mut sums = vec![0.0; group_count * count];
            let rows = values.chunks(count).zip(areas).zip(groups);
            for ((row, area), group) in rows {
                let Some(group) = group.map(|group| group as usize) else {
                    continue;
                };
                let share = area / f64::max(wholes[group], f64::MIN_POSITIVE);
                for (sum, &value) in sums[group * count..].iter_mut().zip(row) {
                    *sum += (share * f64::from(value)).powf(power);
                }
            }
            sums
        };
        let shares = mean(&self.shares, 1.0);
        let squares = mean(&self.errors, 2.0);
        SkyFactors {
            shares: shares.into_iter().map(|x| x as f32).collect(),
            errors: squares.into_iter().map(|x| x.sqrt() as f32).collect(),
            ..*self
        }
    }
}

impl PreparedPlan<'_> {
    /// What each row sees of the patches of the sky, scaled to what `factors`, computed from this plan, have of sky and
    /// ground. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// [`FactorsError::TooLarge`] if they need more than the memory of the plan, and [`FactorsError::Cancelled`].
    pub fn sky_factors(
        &self,
        division: SkyDivision,
        north: f64,
        factors: &FormFactors,
        progress: &Progress,
    ) -> Result<SkyFactors, FactorsError> {
        self.sky_of_all(&factors.rest, (division, north), progress, |row, sky| {
            let (side, flip) = (self.sides.side(row), self.sides.flip(row));
            let sampler = self.plan.patches.sampler(self.sides.patch(row));
            let start = |[u1, u2]: [f64; 2]| {
                let at = sampler.sample(u1, u2);
                RayStart {
                    position: at.position,
                    normal: Some(flip * at.normal),
                    weight: at.weight,
                }
            };
            sky.shares(self, side, &start)
        })
    }

    /// The same of points: `seen` is what [`factors_from_points`](PreparedPlan::factors_from_points) found of them. Shares
    /// are of the hemisphere weighted by cosine, or of the whole sphere.
    ///
    /// # Errors
    /// As [`sky_factors`](PreparedPlan::sky_factors).
    ///
    /// # Panics
    /// If there are fewer points than were seen from.
    pub fn sky_from_points(
        &self,
        (division, north): (SkyDivision, f64),
        points: &[FactorPoint],
        seen: &[PointFactors],
        progress: &Progress,
    ) -> Result<SkyFactors, FactorsError> {
        let placed = self.placed(points);
        let rests: Vec<RowRemainder> = seen.iter().map(|point| point.rest).collect();
        self.sky_of_all(&rests, (division, north), progress, |k, sky| {
            let start = |_: [f64; 2]| RayStart {
                position: placed[k],
                normal: points[k].normal,
                weight: 1.0,
            };
            sky.shares(self, hash(&[k as u32, POINTS]), &start)
        })
    }

    /// The shares that `of` finds of each row, scaled to what is known of them.
    fn sky_of_all(
        &self,
        rests: &[RowRemainder],
        (division, north): (SkyDivision, f64),
        progress: &Progress,
        of: impl Fn(usize, &SkySampling) -> Vec<Share> + Sync,
    ) -> Result<SkyFactors, FactorsError> {
        let (rows, memory) = (rests.len(), self.plan.options.memory);
        let bytes = (rows * division.count() * BYTES) as u64;
        if bytes > memory {
            return Err(FactorsError::TooLarge {
                rows,
                bytes,
                memory,
            });
        }
        progress.begin("patches of the sky", rows as u64);
        let up = self.gatherer.surfaces().scene.units.up;
        let sky = SkySampling {
            division,
            world_from_sky: upright(up, north),
        };
        let rows: Vec<Vec<[f32; 2]>> = (rests.par_iter().enumerate())
            .map(|(row, rest)| {
                progress.advance(1)?;
                let mut shares = of(row, &sky);
                scale(rest, &mut shares);
                let single = |share: &Share| [share.value as f32, share.error as f32];
                Ok(shares.iter().map(single).collect())
            })
            .collect::<Result<_, FactorsError>>()?;
        let all = || rows.iter().flatten();
        Ok(SkyFactors {
            division,
            north,
            shares: all().map(|share| share[0]).collect(),
            errors: all().map(|share| share[1]).collect(),
        })
    }
}

/// Where a ray starts that is sent to the sky.
pub(super) struct RayStart {
    pub position: DVec3,
    /// Unit; `None` where all directions count alike.
    pub normal: Option<DVec3>,
    pub weight: f64,
}

/// How the sky is sampled.
struct SkySampling {
    division: SkyDivision,
    world_from_sky: DQuat,
}

impl SkySampling {
    /// The shares of what starts where `start` says, by two numbers in 0..1, by rays toward all patches of the sky and,
    /// where there are mirrors, of the ground that these may show: each ray counts for the patch toward which it leaves
    /// the scene. `name` keys the random numbers.
    fn shares(
        &self,
        plan: &PreparedPlan,
        name: u32,
        start: &dyn Fn([f64; 2]) -> RayStart,
    ) -> Vec<Share> {
        let SkySampling {
            division,
            world_from_sky,
        } = *self;
        let surfaces = plan.gatherer.surfaces();
        let (mut paths, mut scratch) = (Vec::new(), Scratch::default());
        let mut shares = vec![Share::default(); division.count()];
        let mut trace = |toward: Option<usize>,
                         rays: usize,
                         direction: &dyn Fn([f64; 2]) -> DVec3,
                         angle: f64| {
            let key = toward.map_or(u32::MAX, |patch| patch as u32);
            let seeds = seeds(&[plan.seed, name, key, 0x5c1]);
            let mut free = 0.0;
            for k in 0..rays as u32 {
                let [u1, u2, u3, u4] = [0, 1, 2, 3].map(|d| f64::from(sobol(k, d, seeds[d])));
                let at = start([u1, u2]);
                let to = world_from_sky * direction([u3, u4]);
                // By the cosine over the hemisphere, or of the whole sphere.
                let density = at.normal.map_or(0.25 / PI, |normal| normal.dot(to) / PI);
                let weight = at.weight * density * angle / rays as f64;
                if weight > 0.0 {
                    free += weight;
                    let normal = at.normal.unwrap_or(DVec3::ZERO);
                    let ray = Ray::new(surfaces.tracer.leaving(at.position, normal), to);
                    paths.push(straight(surfaces.tracer, &ray, weight, k));
                }
            }
            let mut straight_on = [0.0; 2];
            let chances = hash(&[plan.seed, name, key, 0xc4a]);
            follow(
                surfaces,
                &mut paths,
                &mut scratch,
                chances,
                |path, event| {
                    if let Event::Escape = event {
                        let direction = surfaces.tracer.world_ray(&path.leg.ray).direction;
                        let patch = division.patch(world_from_sky.conjugate() * direction);
                        let weight = path.weight.mean();
                        shares[patch].value += weight;
                        if Some(patch) == toward {
                            straight_on[0] += weight;
                            straight_on[1] += weight * weight;
                        } else {
                            shares[patch].error += weight * weight;
                        }
                    }
                },
            );
            // Independent rays would have this variance, and one more of them could always see or not.
            if let Some(patch) = toward {
                let [sum, square] = straight_on;
                let count = rays as f64;
                shares[patch].error +=
                    (square - sum * sum / count).max(0.0) + (free / count).powi(2);
            }
        };
        let of_patch = (LEAST_RAYS / division.count()).max(LEAST_OF_PATCH);
        for patch in 1..division.count() {
            let within = |u: [f64; 2]| division.direction_in(patch, u);
            trace(Some(patch), of_patch, &within, division.solid_angle(patch));
        }
        if surfaces.scene.materials.iter().any(Material::is_specular) {
            let below = |u: [f64; 2]| division.direction_in(0, u);
            trace(None, LEAST_RAYS, &below, division.solid_angle(0));
        }
        shares
            .iter_mut()
            .for_each(|share| share.error = share.error.sqrt());
        shares
    }
}

/// A share of light, and its standard error, or the square of that while it is summed.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    value: f64,
    error: f64,
}

/// Scales shares to what is known of sky and ground. A share of the sky that no ray found may be that of any patch.
fn scale(rest: &RowRemainder, shares: &mut [Share]) {
    let found: f64 = shares[1..].iter().map(|share| share.value).sum();
    shares[0] = Share {
        value: rest.ground,
        error: rest.ground_error,
    };
    let even = rest.sky / (shares.len() - 1) as f64;
    for share in &mut shares[1..] {
        *share = if found > 0.0 {
            Share {
                value: share.value * (rest.sky / found),
                error: share.error * (rest.sky / found),
            }
        } else {
            Share {
                value: even,
                error: rest.sky,
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::{FormFactorOptions, Plan};
    use crate::patch::PatchSize;
    use azulejo_scene::sky::direction_from;
    use azulejo_scene::{Material, Object, Primitive, Rgb, Scene, Shape, Up};
    use azulejo_trace::Tracer;
    use glam::dvec3;
    use std::f64::consts::{PI, TAU};

    /// Rectangles in a world with z up, each given by a corner and two sides; the first is a mirror if it is said.
    fn scene(rectangles: &[[DVec3; 3]], first: Material) -> Scene {
        let mut scene = Scene::default();
        scene.units.up = Up::Z;
        let first = scene.add_material(first);
        let grey = scene.add_material(Material::diffuse("grey", Rgb::grey(0.5)));
        for (k, &[corner, a, b]) in rectangles.iter().enumerate() {
            let material = if k == 0 { first } else { grey };
            let shape = Shape::Primitive(Primitive::parallelogram(corner, a, b, material));
            scene.objects.push(Object::new(format!("{k}"), shape));
        }
        scene
    }

    fn sky_of(scene: &Scene, division: SkyDivision) -> (SkyFactors, FormFactors) {
        let tracer = Tracer::new(scene);
        let options = FormFactorOptions {
            size: PatchSize::Edge(0.0),
            ..FormFactorOptions::default()
        };
        let plan = Plan::new(scene, &tracer, &options).unwrap();
        let (prepared, progress) = (plan.prepare(), Progress::new());
        let factors = prepared.compute(&progress).unwrap();
        let sky = prepared
            .sky_factors(division, 0.0, &factors, &progress)
            .unwrap();
        (sky, factors)
    }

    /// Level ground under an open sky: of a band between two altitudes sin² − sin² (Nusselt), each of its patches alike.
    #[test]
    fn level_ground_sees_each_patch_as_nusselt_says() {
        let ground = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let scene = scene(&[ground], Material::diffuse("ground", Rgb::grey(0.2)));
        for subdivisions in [1, 2] {
            let division = SkyDivision::reinhart(subdivisions).unwrap();
            let (sky, factors) = sky_of(&scene, division);
            assert_eq!(factors.len(), 1);
            let sum: f64 = sky.row(0)[1..].iter().map(|x| f64::from(*x)).sum();
            assert!((sum - factors.rest[0].sky).abs() < 1e-6 && (sum - 1.0).abs() < 1e-6);
            // sin² b − sin² a = (sin b − sin a) · 2 sin((a + b)/2) cos((b − a)/2), and sin² of the half of the zenith.
            let half = 0.25 * PI / (7.0 * subdivisions as f64 + 0.5);
            let zenith = division.count() - 1;
            for k in 1..=zenith {
                let band = division.solid_angle(k) / PI * division.direction(k).z * half.cos();
                let exact = if k == zenith {
                    half.sin().powi(2)
                } else {
                    band
                };
                let (found, error) = (f64::from(sky.row(0)[k]), f64::from(sky.errors[k]));
                assert!(
                    (found - exact).abs() < 4.0 * error,
                    "{k}: {found} ± {error}, {exact}"
                );
            }
        }
    }

    /// A wall that faces east sees nothing of the west, and half of the sky.
    #[test]
    fn a_wall_sees_the_half_of_the_sky_before_it() {
        let wall = [DVec3::ZERO, DVec3::Y, DVec3::Z];
        let scene = scene(&[wall], Material::diffuse("wall", Rgb::grey(0.2)));
        let (sky, factors) = sky_of(&scene, SkyDivision::TREGENZA);
        let row = sky.row(0);
        assert!((factors.rest[0].sky - 0.5).abs() < 1e-3 && (row[0] - 0.5).abs() < 1e-3);
        let toward = |azimuth: f64| row[sky.division.patch(direction_from(azimuth, 0.1))];
        assert!(toward(0.25 * TAU) > 0.01 && toward(0.75 * TAU) == 0.0);
    }

    /// Ground before a mirror sees the sky behind its back where the mirror shows it.
    #[test]
    fn mirrors_show_the_sky_on_the_other_side() {
        let mirror = [dvec3(0.0, -50.0, 0.0), 100.0 * DVec3::Y, 100.0 * DVec3::Z];
        let ground = [dvec3(0.5, -0.1, 0.0), 0.2 * DVec3::X, 0.2 * DVec3::Y];
        let scene = scene(
            &[mirror, ground],
            Material::mirror("mirror", Rgb::grey(1.0)),
        );
        let (sky, factors) = sky_of(&scene, SkyDivision::TREGENZA);
        let row = (0..factors.len())
            .find(|&i| factors.faces[i].object == 1)
            .unwrap();
        let patch = |azimuth: f64| sky.division.patch(direction_from(azimuth, 0.5));
        let toward = |azimuth: f64| sky.row(row)[patch(azimuth)];
        // Straight from the east, and again by way of the mirror; nothing from behind it.
        let (east, west) = (toward(0.25 * TAU), toward(0.75 * TAU));
        let seen = patch(0.25 * TAU);
        let free = sky.division.solid_angle(seen) * sky.division.direction(seen).z / PI;
        assert!(
            (f64::from(east) / free - 2.0).abs() < 0.1 && west == 0.0,
            "{east}, {west}, {free}"
        );
    }

    #[test]
    fn patches_that_memory_does_not_hold_are_refused() {
        let ground = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let scene = scene(&[ground], Material::diffuse("ground", Rgb::grey(0.2)));
        let (_, factors) = sky_of(&scene, SkyDivision::TREGENZA);
        let (tracer, progress) = (Tracer::new(&scene), Progress::new());
        let options = FormFactorOptions {
            size: PatchSize::Edge(0.0),
            memory: 1024,
            ..FormFactorOptions::default()
        };
        let plan = Plan::new(&scene, &tracer, &options).unwrap();
        let prepared = plan.prepare();
        let refused = prepared.sky_factors(SkyDivision::TREGENZA, 0.0, &factors, &progress);
        assert!(matches!(refused, Err(FactorsError::TooLarge { .. })));
    }

    #[test]
    fn groups_have_means_by_area() {
        let sky = SkyFactors {
            division: SkyDivision::TREGENZA,
            north: 0.0,
            shares: [vec![0.25; 146], vec![0.5; 146], vec![9.0; 146]].concat(),
            errors: [vec![0.3; 146], vec![0.4; 146], vec![9.0; 146]].concat(),
        };
        let groups = sky.grouped(&[1.0, 3.0, 1.0], &[Some(1), Some(1), None], 2);
        assert_eq!(groups.row(0), [0.0; 146]);
        assert_eq!(groups.row(1), [0.4375; 146]);
        let error = f64::from(groups.errors[146]);
        assert!((error - (0.075_f64.powi(2) + 0.3_f64.powi(2)).sqrt()).abs() < 1e-7);
    }
}
