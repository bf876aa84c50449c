//! Daylight at points in all hours of a year, from one matrix.
//!
//! All that is diffuse is linear, so that the irradiance of a point is
//!
//! ```text
//! E = Σ_k C_k L_k + Σ_j R_j H_j + H      C_k = π (S_k + Σ_j R_j S_jk)
//! ```
//!
//! with the radiance L_k of patch k of the sky, the shares S_k and S_jk that point and row see of it, and the irradiance H
//! of the point and H_j of rows by the sun alone, by one ray each to where it stands: daylight coefficients (Tregenza and
//! Waters, *Daylight coefficients*, Lighting Research and Technology 15, 1983), with the sun apart as in the five-phase
//! method (McNeil, *The five-phase method for simulating complex fenestration with Radiance*, 2013), but for all of its
//! reflections. By reciprocity R_j, what the point receives of the light on row j, is A_j J_j for the radiosity J if the
//! point itself shone: J = ρ (F_point / A + F J).

use crate::archive::write::list;
use crate::enclosure::Enclosure;
use crate::points::{SeenFromPoints, write_points};
use crate::thermal::ExchangeError;
use crate::thermal::network::reflections::Reflections;
use azulejo_factors::form_factors::{FactorPoint, PointFactors, PreparedPlan, SkyFactors};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use azulejo_scene::environment::upright;
use azulejo_scene::sky::{Sky, SkyDivision};
use azulejo_trace::Progress;
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::io::{self, Write};

/// Hours whose rays to the sun are traced together.
const HOURS_AT_ONCE: usize = 128;

/// Points whose reflections are solved together.
const POINTS_AT_ONCE: usize = 64;

/// Places along each side of a patch of the sky at which its radiance is asked for.
const SIDE: usize = 2;

/// Sun and sky at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Daylight {
    /// The sky, with its ground.
    pub sky: Sky,
    /// Irradiance of level ground by the sky alone.
    pub diffuse_horizontal: f64,
    /// Unit, toward the sun in the sky's frame.
    pub toward_sun: DVec3,
    /// Irradiance by the sun of what faces it; 0 below the horizon.
    pub direct_normal: f64,
}

/// Light at points in the records of a year: sums in the unit of irradiance times hours.
pub struct YearAtPoints {
    /// The points.
    pub points: Vec<FactorPoint>,
    /// How long a record is, hours.
    pub record_hours: f64,
    /// Irradiance in each record, one record after the other, if it was asked for.
    pub irradiance: Option<Vec<f32>>,
    /// All light.
    pub sum: Vec<f64>,
    /// Of that straight from the sun.
    pub direct_sun: Vec<f64>,
    /// Of that straight from the sky.
    pub sky: Vec<f64>,
    /// Standard error of the sum, by the rays that found what the point sees.
    pub standard_error: Vec<f64>,
}

/// Bytes that [`year_at_points`] takes besides the matrix, of points, rows, patches of the sky and records that are kept.
pub fn bytes_of_year([points, rows, patches, records]: [usize; 4]) -> u64 {
    let coefficients = points * (rows + 2 * patches) + rows * HOURS_AT_ONCE;
    let single = coefficients + points * (records + 2 * HOURS_AT_ONCE);
    let solving = 2 * rows * POINTS_AT_ONCE;
    (single * size_of::<f32>() + solving * size_of::<f64>()) as u64
}

/// The light at points in each record of a year, and its sum; `None` is night. `enclosure` has the factors of the plan and
/// what rows see of the patches of the sky, `seen` what points see of single rows and of these patches.
///
/// Rows reflect the mean of their channels. The result does not depend on the number of threads.
///
/// # Errors
/// [`ExchangeError::Cancelled`], and those of solving for reflections.
///
/// # Panics
/// If the patches of the sky are not known of both.
pub fn year_at_points(
    (prepared, enclosure): (&PreparedPlan, &Enclosure),
    seen: SeenFromPoints,
    (records, record_hours): (&[Option<Daylight>], f64),
    keep: bool,
    progress: &Progress,
) -> Result<YearAtPoints, ExchangeError> {
    let (Some(of_rows), Some(of_points)) = (&enclosure.sky, &seen.sky) else {
        panic!("rows and points see patches of the sky");
    };
    let reflectances: Vec<f64> = enclosure
        .rows
        .diffuse
        .iter()
        .map(|rho| rho.mean())
        .collect();
    let reflections = Reflections::new(enclosure, &reflectances, progress)?;
    let responses = Responses::new((enclosure, &seen), &reflectances, &reflections, progress)?;
    let world = upright(enclosure.rows.up, of_rows.north);
    let sums = responses.year((prepared, world), records, keep, progress)?;
    // The light that leaves rows in all of the year says what errors of the factors of points to them mean.
    let by_sky = |row: usize| -> f64 { PI * dot(of_rows.row(row), &sums.radiances) };
    let outside = sums
        .sun_on_rows
        .iter()
        .enumerate()
        .map(|(row, sun)| sun + by_sky(row));
    let emitted: Vec<f64> = outside
        .zip(&reflectances)
        .map(|(outside, rho)| rho * outside)
        .collect();
    let radiosities = reflections.solve(&[emitted], progress)?.remove(0);
    let standard_error = |k: usize| {
        let of_sky = of_points.row_errors(k).iter().zip(&sums.radiances);
        let of_sky = of_sky.map(|(error, radiance)| PI * f64::from(*error) * radiance);
        let factors = seen.seen[k].factors.iter();
        let of_rows = factors.map(|(row, factor)| factor.error * radiosities[*row as usize]);
        record_hours * of_sky.chain(of_rows).map(|e| e * e).sum::<f64>().sqrt()
    };
    let scaled = |sums: &[f64]| sums.iter().map(|sum| record_hours * sum).collect();
    let points = 0..seen.points.len();
    let sky = |k: usize| record_hours * PI * dot(&of_points.row(k)[1..], &sums.radiances[1..]);
    Ok(YearAtPoints {
        record_hours,
        sum: scaled(&sums.all),
        direct_sun: scaled(&sums.sun_at_points),
        sky: points.clone().map(sky).collect(),
        standard_error: points.map(standard_error).collect(),
        irradiance: sums.irradiance,
        points: seen.points,
    })
}

/// What points receive of light elsewhere, the numbers of all points side by side.
struct Responses<'a> {
    division: SkyDivision,
    points: &'a [FactorPoint],
    /// C of each patch of the sky.
    of_patches: Vec<f32>,
    /// R of each row.
    of_rows: Vec<f32>,
}

/// Sums over the records of a year.
struct YearSums {
    irradiance: Option<Vec<f32>>,
    /// Of each point, all light and that straight from the sun.
    all: Vec<f64>,
    sun_at_points: Vec<f64>,
    sun_on_rows: Vec<f64>,
    /// Of each patch of the sky.
    radiances: Vec<f64>,
}

impl<'a> Responses<'a> {
    fn new(
        (enclosure, seen): (&Enclosure, &'a SeenFromPoints),
        reflectances: &[f64],
        reflections: &Reflections,
        progress: &Progress,
    ) -> Result<Responses<'a>, ExchangeError> {
        let (areas, points) = (&enclosure.factors.areas, seen.seen.len());
        progress.begin("reflections", points as u64);
        let mut of_rows = vec![0f32; areas.len() * points];
        for (block, few) in seen.seen.chunks(POINTS_AT_ONCE).enumerate() {
            let source = |point: &PointFactors| {
                let mut source = vec![0.0; areas.len()];
                for (row, factor) in &point.factors {
                    let row = *row as usize;
                    source[row] = reflectances[row] * factor.value / areas[row];
                }
                source
            };
            let sources: Vec<Vec<f64>> = few.iter().map(source).collect();
            for (k, radiosities) in reflections.solve(&sources, progress)?.iter().enumerate() {
                for (row, (radiosity, area)) in radiosities.iter().zip(areas).enumerate() {
                    of_rows[row * points + block * POINTS_AT_ONCE + k] = (area * radiosity) as f32;
                }
            }
        }
        let (Some(sky_of_rows), Some(sky_of_points)) = (&enclosure.sky, &seen.sky) else {
            panic!("rows and points see patches of the sky");
        };
        let mut responses = Responses {
            division: sky_of_rows.division,
            points: &seen.points,
            of_patches: Vec::new(),
            of_rows,
        };
        responses.of_patches = responses.patches(sky_of_rows, sky_of_points);
        Ok(responses)
    }

    /// C of each patch.
    fn patches(&self, of_rows: &SkyFactors, of_points: &SkyFactors) -> Vec<f32> {
        let points = self.points.len();
        let mut coefficients = vec![0f32; self.division.count() * points];
        let each = coefficients.par_chunks_mut(points.max(1)).enumerate();
        each.for_each(|(patch, sums)| {
            for (point, sum) in sums.iter_mut().enumerate() {
                *sum = of_points.row(point)[patch];
            }
            for (row, response) in self.of_rows.chunks(points.max(1)).enumerate() {
                add(sums, of_rows.row(row)[patch], response);
            }
            sums.iter_mut().for_each(|sum| *sum *= PI as f32);
        });
        coefficients
    }

    /// All records, some at a time; `world` turns the sky's frame into that of the scene.
    fn year(
        &self,
        (prepared, world): (&PreparedPlan, DQuat),
        records: &[Option<Daylight>],
        keep: bool,
        progress: &Progress,
    ) -> Result<YearSums, ExchangeError> {
        let (points, rows) = (self.points.len(), prepared.rows());
        let mut sums = YearSums {
            irradiance: keep.then(|| vec![0.0; records.len() * points]),
            all: vec![0.0; points],
            sun_at_points: vec![0.0; points],
            sun_on_rows: vec![0.0; rows],
            radiances: vec![0.0; self.division.count()],
        };
        let lit = records
            .iter()
            .enumerate()
            .filter_map(|(k, record)| Some((k, (*record)?)));
        let lit: Vec<(usize, Daylight)> = lit.collect();
        progress.begin("hours", lit.len() as u64);
        for (block, few) in lit.chunks(HOURS_AT_ONCE).enumerate() {
            let toward: Vec<DVec3> = few
                .iter()
                .map(|(_, hour)| world * hour.toward_sun)
                .collect();
            let on_rows = prepared.parallel_on_rows((&toward, block * HOURS_AT_ONCE), progress)?;
            let at_points = prepared.parallel_at_points(self.points, &toward, progress)?;
            let hour = |(k, (_, hour)): (usize, &(usize, Daylight))| {
                let radiances = radiances(self.division, hour);
                let mut irradiance = vec![0f32; points];
                let beam = |share: &f32| share * hour.direct_normal as f32;
                // Only what shines is added: most rows of a room have no sun.
                let suns = on_rows.iter().skip(k).step_by(few.len()).map(beam);
                let patches = radiances
                    .iter()
                    .copied()
                    .zip(self.of_patches.chunks(points.max(1)));
                for (x, response) in patches.chain(suns.zip(self.of_rows.chunks(points.max(1)))) {
                    add(&mut irradiance, x, response);
                }
                let suns = at_points.iter().skip(k).step_by(few.len()).map(beam);
                irradiance
                    .iter_mut()
                    .zip(suns)
                    .for_each(|(all, sun)| *all += sun);
                (radiances, irradiance)
            };
            let found: Vec<_> = few.par_iter().enumerate().map(hour).collect();
            // In the order of hours, so that sums are the same for any number of threads.
            for (k, ((number, hour), (radiances, irradiance))) in few.iter().zip(found).enumerate()
            {
                progress.advance(1)?;
                let of_hour = |shares: &[f32], i: usize| {
                    f64::from(shares[i * few.len() + k]) * hour.direct_normal
                };
                (0..points).for_each(|i| sums.sun_at_points[i] += of_hour(&at_points, i));
                (0..rows).for_each(|i| sums.sun_on_rows[i] += of_hour(&on_rows, i));
                sums.all
                    .iter_mut()
                    .zip(&irradiance)
                    .for_each(|(sum, e)| *sum += f64::from(*e));
                sums.radiances
                    .iter_mut()
                    .zip(&radiances)
                    .for_each(|(sum, l)| *sum += f64::from(*l));
                if let Some(table) = &mut sums.irradiance {
                    table[number * points..][..points].copy_from_slice(&irradiance);
                }
            }
        }
        Ok(sums)
    }
}

/// The mean radiance of each patch, scaled so that together they give level ground what the sky gives it.
fn radiances(division: SkyDivision, hour: &Daylight) -> Vec<f32> {
    let within =
        || (0..SIDE * SIDE).map(|k| [k % SIDE, k / SIDE].map(|k| (k as f64 + 0.5) / SIDE as f64));
    let (mut means, mut horizontal) = (vec![hour.sky.ground], 0.0);
    for patch in 1..division.count() {
        let [mut radiance, mut sine] = [0.0; 2];
        for direction in within().map(|u| division.direction_in(patch, u)) {
            radiance += hour.sky.radiance(direction) / (SIDE * SIDE) as f64;
            sine += direction.z / (SIDE * SIDE) as f64;
        }
        means.push(radiance);
        horizontal += radiance * sine * division.solid_angle(patch);
    }
    let scale = if horizontal > 0.0 {
        hour.diffuse_horizontal / horizontal
    } else {
        0.0
    };
    means[1..].iter_mut().for_each(|mean| *mean *= scale);
    means.into_iter().map(|mean| mean as f32).collect()
}

/// Adds a multiple of numbers; nothing of zero.
fn add(to: &mut [f32], factor: f32, numbers: &[f32]) {
    if factor != 0.0 {
        to.iter_mut()
            .zip(numbers)
            .for_each(|(to, x)| *to += factor * x);
    }
}

fn dot(shares: &[f32], values: &[f64]) -> f64 {
    shares
        .iter()
        .zip(values)
        .map(|(share, value)| f64::from(*share) * value)
        .sum()
}

impl YearAtPoints {
    /// What reaches each point by way of surfaces and of the ground below the horizon.
    pub fn reflected(&self) -> Vec<f64> {
        let direct = self.direct_sun.iter().zip(&self.sky);
        let reflected = self
            .sum
            .iter()
            .zip(direct)
            .map(|(sum, (sun, sky))| sum - sun - sky);
        reflected.map(|rest| rest.max(0.0)).collect()
    }

    /// Writes one line for each point: position, normal, and the sums in thousands of the unit of irradiance times hours,
    /// in kWh/m² where that is W/m².
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "x,y,z,nx,ny,nz,sum,direct_sun,sky,reflected,std_error")?;
        let reflected = self.reflected();
        for (k, point) in self.points.iter().enumerate() {
            let [x, y, z] = point.position.to_array();
            let [nx, ny, nz] = point.normal.unwrap_or_default().to_array();
            let sums = [
                &self.sum,
                &self.direct_sun,
                &self.sky,
                &reflected,
                &self.standard_error,
            ];
            let [sum, sun, sky, reflected, error] = sums.map(|sums| (sums[k] / 1000.0) as f32);
            writeln!(
                out,
                "{x},{y},{z},{nx},{ny},{nz},{sum},{sun},{sky},{reflected},{error}"
            )?;
        }
        Ok(())
    }

    /// Writes the same as arrays, with the irradiance of each record, and the middle of each record in hours from the
    /// beginning of the year, in local standard time.
    ///
    /// # Errors
    /// Those of writing.
    pub fn write_npz(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut archive = NpzWriter::new(out);
        let table = self.irradiance.as_deref().unwrap_or_default();
        let records = table.len() / self.points.len().max(1);
        archive.add("irradiance", |w| {
            npy::write(&[records, self.points.len()], table, w)
        })?;
        let reflected = self.reflected();
        for (name, sums) in [
            ("sum", &self.sum),
            ("direct_sun", &self.direct_sun),
            ("sky", &self.sky),
            ("reflected", &reflected),
            ("standard_error", &self.standard_error),
        ] {
            archive.add(name, |w| list(sums, |sum| sum / 1000.0, w))?;
        }
        write_points(&self.points, &mut archive)?;
        let middles: Vec<f64> = (0..records)
            .map(|k| (k as f64 + 0.5) * self.record_hours)
            .collect();
        archive.add("time", |w| npy::write(&[records], &middles, w))?;
        archive.finish()
    }
}
