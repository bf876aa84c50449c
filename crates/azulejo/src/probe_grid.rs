//! Light at the points of a grid, for things that move through a scene: irradiance volumes and light probes.
//!
//! Each probe has the radiance around it as nine coefficients of [real spherical harmonics](azulejo_scene::harmonics),
//! which give the irradiance of any normal. Probes inside of solids have none of their own.

use azulejo_factors::{PointNormal, ProxyScene};
use azulejo_radiosity::{FirstPass, Report, SolveError, SolvedLight};
use azulejo_scene::harmonics::{HARMONICS, Y00, cosine_factor, harmonic_irradiance};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Rgb, Scene};
use azulejo_trace::sampling::{hash, uniform, uniform_sphere};
use azulejo_trace::{GatherPoint, Harmonics, IncidentDomain, Run, Tracer, sequence_gain};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;

/// Rays of each probe before its noise is known.
const FIRST_RAYS: u32 = 128;

/// A probe with so many rays gets no more.
const MOST_RAYS: u32 = 1 << 14;

/// Times that rays are added.
const ROUNDS: u32 = 8;

/// What of a requested error is aimed at: estimated errors have errors.
const NOISE_SHARE: f64 = 0.95;

/// Places and normals at which the irradiance is also gathered, to see what patches and higher bands are off by.
const CHECKED: u32 = 64;

/// Error where none is requested.
const DEFAULT_ERROR: f64 = 0.03;

/// Share of directions in which a probe inside of a solid meets its inner side, and the share of the mean light below
/// which it is dark there.
const INSIDE: f64 = 0.9;
const DARK: f64 = 0.01;

/// A box divided into cells, with a probe in the middle of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeGrid {
    /// The box, scene units.
    pub bounds: Aabb,
    /// Cells along each axis, 1 or more.
    pub resolution: [u32; 3],
}

impl ProbeGrid {
    /// Number of probes.
    pub fn len(&self) -> usize {
        self.resolution.map(|n| n as usize).iter().product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Column, row and layer of a probe: those along x follow each other, then those along y.
    pub fn cell(&self, probe: usize) -> [u32; 3] {
        let [x, y, _] = self.resolution.map(|n| n as usize);
        [probe % x, probe / x % y, probe / (x * y)].map(|n| n as u32)
    }

    /// The number of the probe in a cell.
    pub fn probe(&self, cell: [u32; 3]) -> usize {
        let [x, y, z] = cell.map(|n| n as usize);
        let [nx, ny, _] = self.resolution.map(|n| n as usize);
        (z * ny + y) * nx + x
    }

    /// Where a probe is.
    pub fn position(&self, probe: usize) -> DVec3 {
        let [cell, cells] =
            [self.cell(probe), self.resolution].map(|n| DVec3::from(n.map(f64::from)));
        let share = (cell + 0.5) / cells;
        self.bounds.min + share * (self.bounds.max - self.bounds.min)
    }
}

/// The light of a grid.
#[derive(Clone, Debug)]
pub struct GridLight {
    /// Its probes.
    pub grid: ProbeGrid,
    /// Coefficients of the radiance around each, W/(sr·m²) (cd/m² in photometric scenes).
    pub coefficients: Vec<[Rgb; HARMONICS]>,
    /// Their standard errors.
    pub standard_errors: Vec<[Rgb; HARMONICS]>,
    /// Whether a probe is inside of a solid, in the dark: it has the mean light of those around that are not.
    pub is_inside: Vec<bool>,
    /// Mean number of rays of a probe, without shadow rays.
    pub rays: f64,
    /// Root mean square of the standard error of irradiance over all probes and normals, relative to the mean.
    pub noise: f64,
    /// The same of what coefficients cannot say, because it is in higher bands, and of what the light of patches is off
    /// by, from a sample: about 0.13 where all light is from one direction. `None` if no time was left for that.
    pub systematic: Option<f64>,
    /// The light between patches.
    pub report: Report,
}

/// The light of a grid, with rays until noise is as small as the error of `pass`, or as many as it says.
///
/// # Errors
/// As [`SolvedLight::new`].
pub fn grid_light(
    scene: &Scene,
    tracer: &Tracer,
    grid: ProbeGrid,
    pass: &FirstPass,
    run: Run,
) -> Result<GridLight, SolveError> {
    let proxy = ProxyScene::new(scene, tracer, pass.size);
    let solved = SolvedLight::new(&proxy, pass, run)?;
    solved.agree()?;
    // Light comes from all around: the normal is any that is not an axis of most models.
    let points: Vec<GatherPoint> = (0..grid.len())
        .map(|probe| GatherPoint {
            position: grid.position(probe),
            normal: DVec3::new(0.36, 0.48, 0.8),
            key: probe as u32,
        })
        .collect();
    // Gather with a few rays, and then with more where the noise of these is largest.
    let first = pass.rays.unwrap_or(FIRST_RAYS).clamp(4, MOST_RAYS);
    let mut direct = Gathers::new(solved.direct_harmonics(&points, 0..1)?, 1);
    let around = |points: &[GatherPoint], rays| {
        solved.harmonics(points, IncidentDomain::Sphere, rays, None, 0)
    };
    let mut indirect = Gathers::new(around(&points, 0..first)?, first);
    let is_fixed = pass.rays.is_some() && pass.error.is_none();
    if !is_fixed {
        let mean = mean_irradiance(&direct.light) + mean_irradiance(&indirect.light);
        let permitted = (NOISE_SHARE * pass.error.unwrap_or(DEFAULT_ERROR) * mean).powi(2);
        let mut shadow_rays =
            |points: &[GatherPoint], rays| Ok(solved.direct_harmonics(points, rays)?);
        direct.refine(&points, 0.5 * permitted, run, &mut shadow_rays)?;
        let rest = permitted - direct.variance();
        indirect.refine(&points, rest, run, &mut |points, rays| around(points, rays))?;
    }
    // State what is left, and which probes are inside of solids.
    let rays = indirect.rays.iter().map(|&n| f64::from(n)).sum::<f64>() / grid.len().max(1) as f64;
    let mean = mean_irradiance(&direct.light) + mean_irradiance(&indirect.light);
    let noise = (direct.variance() + indirect.variance()).sqrt() / mean.max(f64::MIN_POSITIVE);
    let gains = indirect.gains();
    let (direct, found) = (direct.light, indirect.light);
    let light: Vec<Harmonics> = direct.iter().zip(&found).map(|(d, i)| d.plus(i)).collect();
    let is_inside = probes_inside(&solved, &points, &light);
    let error = |(direct, indirect): (&Harmonics, &Harmonics)| {
        std::array::from_fn(|k| {
            let [of_direct, of_indirect] =
                [direct, indirect].map(|h| h.coefficients[k].standard_error());
            let gained = of_indirect * of_indirect * gains[k];
            (of_direct * of_direct + gained).map(f64::sqrt)
        })
    };
    let mut of_grid = GridLight {
        coefficients: light.iter().map(Harmonics::mean).collect(),
        standard_errors: direct.iter().zip(&found).map(error).collect(),
        is_inside,
        rays,
        noise,
        systematic: None,
        report: solved.report(),
        grid,
    };
    of_grid.systematic = match systematic(&of_grid, &solved) {
        Ok(systematic) => Some(systematic),
        Err(SolveError::OutOfTime) => None,
        Err(error) => return Err(error),
    };
    of_grid.fill();
    Ok(of_grid)
}

/// Mean irradiance over all probes and normals.
fn mean_irradiance(light: &[Harmonics]) -> f64 {
    let sum: f64 = light.iter().map(|h| h.coefficients[0].mean().mean()).sum();
    sum * PI * Y00 / light.len().max(1) as f64
}

/// Light of all probes from as many rays as each has.
struct Gathers {
    light: Vec<Harmonics>,
    rays: Vec<u32>,
}

/// The light at points from these of their rays.
type HarmonicGather<'g> =
    dyn FnMut(&[GatherPoint], Range<u32>) -> Result<Vec<Harmonics>, SolveError> + 'g;

impl Gathers {
    fn new(light: Vec<Harmonics>, rays: u32) -> Gathers {
        Gathers {
            rays: vec![rays; light.len()],
            light,
        }
    }

    /// How much less the variance of each coefficient is than that of independent replicates.
    fn gains(&self) -> [f64; HARMONICS] {
        std::array::from_fn(|k| {
            sequence_gain(self.light.iter().map(|h| &h.coefficients[k]), Rgb::mean)
        })
    }

    /// The mean square of the standard error of irradiance over all normals, of each probe: that of a coefficient counts
    /// by the square of its factor, over 4π.
    fn variances(&self) -> Vec<f64> {
        let gains = self.gains();
        let of_probe = |h: &Harmonics| {
            let of = |k: usize| {
                let error = h.coefficients[k].standard_error();
                gains[k] * (error * error).mean() * cosine_factor(k).powi(2)
            };
            (0..HARMONICS).map(of).sum::<f64>() / (4.0 * PI)
        };
        self.light.iter().map(of_probe).collect()
    }

    /// The mean of these.
    fn variance(&self) -> f64 {
        self.variances().iter().sum::<f64>() / self.light.len().max(1) as f64
    }

    /// Gives the noisiest probes four times their rays, until the mean variance is as permitted.
    fn refine(
        &mut self,
        points: &[GatherPoint],
        permitted: f64,
        run: Run,
        gather: &mut HarmonicGather,
    ) -> Result<(), SolveError> {
        for _ in 0..ROUNDS {
            let noisy = noisiest(&self.variances(), permitted);
            let mut alike: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
            for probe in noisy.into_iter().filter(|&p| self.rays[p] < MOST_RAYS) {
                alike.entry(self.rays[probe]).or_default().push(probe);
            }
            if alike.is_empty() || run.progress.out_of_time() {
                break;
            }
            for (rays, probes) in alike {
                let chosen: Vec<GatherPoint> = probes.iter().map(|&p| points[p]).collect();
                let more = gather(&chosen, rays..4 * rays)?;
                for (&probe, more) in probes.iter().zip(&more) {
                    let light = &mut self.light[probe];
                    *light = light.scaled(0.25).plus(&more.scaled(0.75));
                    self.rays[probe] = 4 * rays;
                }
            }
        }
        Ok(())
    }
}

/// The largest of some values, which quartered leave the mean of all at most `permitted`, or all.
fn noisiest(variances: &[f64], permitted: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..variances.len()).collect();
    order.sort_by(|&a, &b| variances[b].total_cmp(&variances[a]));
    let mut left = variances.iter().sum::<f64>() - permitted * variances.len() as f64;
    let is_taken = |probe: &usize| {
        let is_above = left > 0.0;
        left -= 0.75 * variances[*probe];
        is_above
    };
    order.into_iter().take_while(is_taken).collect()
}

/// Which probes are inside of solids, in the dark.
fn probes_inside(solved: &SolvedLight, points: &[GatherPoint], light: &[Harmonics]) -> Vec<bool> {
    let brightness = |h: &Harmonics| h.coefficients[0].mean().max_channel();
    let mean = light.iter().map(brightness).sum::<f64>() / light.len().max(1) as f64;
    let is_dark = |probe: &usize| brightness(&light[*probe]) <= DARK * mean;
    let dark: Vec<usize> = (0..points.len()).filter(is_dark).collect();
    let positions: Vec<DVec3> = dark.iter().map(|&probe| points[probe].position).collect();
    let shares = azulejo_bake::shares_inside(solved.gatherer().surfaces(), &positions);
    let mut is_inside = vec![false; points.len()];
    for (probe, share) in dark.into_iter().zip(shares) {
        is_inside[probe] = share >= INSIDE;
    }
    is_inside
}

/// Root mean square by which irradiance from coefficients is off beyond their noise, relative to the mean, from a sample
/// of places and normals at which it is gathered by itself.
fn systematic(light: &GridLight, solved: &SolvedLight) -> Result<f64, SolveError> {
    let outside: Vec<usize> = (0..light.grid.len())
        .filter(|&p| !light.is_inside[p])
        .collect();
    if outside.is_empty() {
        return Ok(0.0);
    }
    let choose = |k: u32| outside[hash(&[k, 0x9b1]) as usize % outside.len()];
    let normal = |k: u32| uniform_sphere(uniform(&[k, 0x9b2]).into(), uniform(&[k, 0x9b3]).into());
    let chosen: Vec<(usize, DVec3)> = (0..CHECKED).map(|k| (choose(k), normal(k))).collect();
    let points: Vec<PointNormal> = chosen
        .iter()
        .map(|&(probe, normal)| PointNormal {
            position: light.grid.position(probe),
            normal,
        })
        .collect();
    let truth = solved.probe(&points)?;
    let (mut squares, mut mean) = (0.0, 0.0);
    for ((probe, normal), truth) in chosen.iter().zip(&truth.estimates) {
        let found = harmonic_irradiance(&light.coefficients[*probe], *normal);
        let off = found - truth.value;
        // What both state as noise is not counted again.
        let errors = &light.standard_errors[*probe];
        let noise: f64 = (0..HARMONICS)
            .map(|k| (errors[k] * errors[k]).mean() * cosine_factor(k).powi(2) / (4.0 * PI))
            .sum();
        squares += (off * off).mean() - noise - (truth.error * truth.error).mean();
        mean += truth.value.mean();
    }
    let count = f64::from(CHECKED);
    Ok((squares / count).max(0.0).sqrt() / (mean / count).max(f64::MIN_POSITIVE))
}

impl GridLight {
    /// Gives probes inside of solids the mean light of those around that are not, in rings around the latter; all stay
    /// dark if all are inside.
    fn fill(&mut self) {
        let mut is_empty = self.is_inside.clone();
        loop {
            let mut filled = Vec::new();
            for probe in (0..is_empty.len()).filter(|&p| is_empty[p]) {
                let around: Vec<usize> = self
                    .around(probe)
                    .filter(|&other| !is_empty[other])
                    .collect();
                if !around.is_empty() {
                    let share = 1.0 / around.len() as f64;
                    let mean = |values: &[[Rgb; HARMONICS]]| {
                        std::array::from_fn(|k| {
                            around.iter().map(|&other| values[other][k]).sum::<Rgb>() * share
                        })
                    };
                    filled.push((probe, mean(&self.coefficients), mean(&self.standard_errors)));
                }
            }
            if filled.is_empty() {
                return;
            }
            for (probe, coefficients, errors) in filled {
                is_empty[probe] = false;
                self.coefficients[probe] = coefficients;
                self.standard_errors[probe] = errors;
            }
        }
    }

    /// The probes that have a face in common with one.
    fn around(&self, probe: usize) -> impl Iterator<Item = usize> + '_ {
        let cell = self.grid.cell(probe);
        let beside = move |k: usize| {
            let axis = k / 2;
            let mut other = cell;
            other[axis] = cell[axis].checked_add_signed([-1, 1][k % 2])?;
            (other[axis] < self.grid.resolution[axis]).then(|| self.grid.probe(other))
        };
        (0..6).filter_map(beside)
    }

    /// The same light where y is up, as in glTF, of a scene whose z is: x, z and −y.
    pub fn turned_up(&self) -> GridLight {
        let old = self.grid;
        let turn = |p: DVec3| DVec3::new(p.x, p.z, -p.y);
        let (low, high) = (turn(old.bounds.min), turn(old.bounds.max));
        let [x, y, z] = old.resolution;
        let resolution = [x, z, y];
        let grid = ProbeGrid {
            bounds: Aabb {
                min: low.min(high),
                max: low.max(high),
            },
            resolution,
        };
        let source = |probe: usize| {
            let [x, height, back] = grid.cell(probe);
            old.probe([x, y - 1 - back, height])
        };
        let order: Vec<usize> = (0..grid.len()).map(source).collect();
        GridLight {
            grid,
            coefficients: order
                .iter()
                .map(|&p| turned(self.coefficients[p]))
                .collect(),
            standard_errors: order
                .iter()
                .map(|&p| turned_errors(self.standard_errors[p]))
                .collect(),
            is_inside: order.iter().map(|&p| self.is_inside[p]).collect(),
            report: self.report.clone(),
            ..*self
        }
    }
}

/// Coefficients of the same radiance in the axes x, z and −y.
fn turned(c: [Rgb; HARMONICS]) -> [Rgb; HARMONICS] {
    let half_root = 0.75_f64.sqrt();
    [
        c[0],
        c[2],
        c[1] * -1.0,
        c[3],
        c[7],
        c[5] * -1.0,
        c[6] * -0.5 - c[8] * half_root,
        c[4] * -1.0,
        c[8] * 0.5 - c[6] * half_root,
    ]
}

/// Standard errors of coefficients in the axes x, z and −y.
fn turned_errors(e: [Rgb; HARMONICS]) -> [Rgb; HARMONICS] {
    let both = |a: Rgb, b: Rgb| (a * a * 0.25 + b * b * 0.75).map(f64::sqrt);
    let (of_z, of_xy) = (both(e[6], e[8]), both(e[8], e[6]));
    [e[0], e[2], e[1], e[3], e[7], e[5], of_z, e[4], of_xy]
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::harmonics::real_harmonics;

    #[test]
    fn turned_light_is_the_same_light() {
        let coefficients: [Rgb; HARMONICS] =
            std::array::from_fn(|k| Rgb::grey(f64::from(uniform(&[k as u32]))));
        let radiance = |c: &[Rgb; HARMONICS], d: DVec3| -> f64 {
            let terms = c.iter().zip(real_harmonics(d));
            terms.map(|(c, y)| c.g * y).sum()
        };
        for k in 0..20 {
            let d = uniform_sphere(uniform(&[k, 1]).into(), uniform(&[k, 2]).into());
            let seen = radiance(&turned(coefficients), DVec3::new(d.x, d.z, -d.y));
            assert!((seen - radiance(&coefficients, d)).abs() < 1e-12);
        }
    }

    #[test]
    fn probes_are_in_the_middle_of_their_cells() {
        let grid = ProbeGrid {
            bounds: Aabb {
                min: DVec3::ZERO,
                max: DVec3::new(2.0, 3.0, 4.0),
            },
            resolution: [2, 3, 4],
        };
        assert_eq!(grid.len(), 24);
        for probe in 0..grid.len() {
            assert_eq!(grid.probe(grid.cell(probe)), probe);
            assert_eq!(
                grid.position(probe),
                DVec3::from(grid.cell(probe).map(f64::from)) + 0.5
            );
        }
    }
}
