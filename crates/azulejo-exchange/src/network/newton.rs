//! Temperatures where several bands meet given fluxes: Newton's method.
//!
//! The residual of a row is what is missing to its flux, Σ_k ε_k (E_k(T) − H_k) − q. Its derivative is
//! applied, not stored: one solution of each band per product. The systems are solved by BiCGSTAB (van der
//! Vorst, SIAM J. Sci. Stat. Comput. 13, 1992), because bands make them unsymmetric.

use super::heat::{HeatProblem, RowCondition, SolvedBand};
use super::reflections::Reflections;
use super::{ExchangeError, SurfaceBand};
use azulejo_trace::Progress;

/// Most steps of Newton's method.
const STEPS: usize = 60;

/// Most iterations for one step.
const ITERATIONS: usize = 400;

/// What may be missing of a flux, relative to the largest emission.
const TOLERANCE: f64 = 1e-12;

/// What a step may leave of the residual.
const STEP_TOLERANCE: f64 = 1e-6;

/// The temperatures, the bands at these, and the number of steps.
pub(super) fn temperatures(
    problem: &HeatProblem,
    bands: &[&SurfaceBand],
    targets: &[f64],
    progress: &Progress,
) -> Result<(Vec<f64>, Vec<SolvedBand>, usize), ExchangeError> {
    let work = NewtonWork::new(problem, bands, targets, progress)?;
    let mut temperatures = work.start(progress)?;
    for step in 0..STEPS {
        let solved: Vec<SolvedBand> = bands
            .iter()
            .map(|band| problem.band(band, &temperatures, progress))
            .collect::<Result<_, _>>()?;
        let (missing, scale) = work.missing(&temperatures, &solved);
        let worst = missing.iter().fold(0.0, |worst: f64, r| worst.max(r.abs()));
        if worst <= TOLERANCE * scale {
            return Ok((temperatures, solved, step));
        }
        let change = work.step(&temperatures, &missing, progress)?;
        for i in 0..temperatures.len() {
            // Halved at most, so that temperatures stay positive.
            let next = temperatures[i] + change[i];
            temperatures[i] = next.max(0.5 * temperatures[i]);
        }
    }
    Err(ExchangeError::Diverges { iterations: STEPS })
}

struct NewtonWork<'a> {
    problem: &'a HeatProblem<'a>,
    bands: &'a [&'a SurfaceBand<'a>],
    targets: &'a [f64],
    /// The system of each band, with all temperatures known.
    reflections: Vec<Reflections<'a>>,
    /// Rows whose temperature is sought.
    unknown: Vec<bool>,
}

impl<'a> NewtonWork<'a> {
    fn new(
        problem: &'a HeatProblem<'a>,
        bands: &'a [&'a SurfaceBand<'a>],
        targets: &'a [f64],
        progress: &Progress,
    ) -> Result<NewtonWork<'a>, ExchangeError> {
        let reflections = bands
            .iter()
            .map(|band| Reflections::new(band.enclosure, &band.diffuse(), progress));
        let emits = |i: usize| bands.iter().any(|band| band.emissivity[i] > 0.0);
        let mut unknown = Vec::new();
        for (i, condition) in problem.conditions.iter().enumerate() {
            let has_flux = matches!(condition, RowCondition::Flux(_));
            if has_flux && !emits(i) && targets[i] != 0.0 {
                let row = bands[0].enclosure.rows.names[i].clone();
                return Err(ExchangeError::NeitherEmitsNorAbsorbs { row });
            }
            unknown.push(has_flux && emits(i));
        }
        Ok(NewtonWork {
            reflections: reflections.collect::<Result<_, _>>()?,
            problem,
            bands,
            targets,
            unknown,
        })
    }

    /// Temperatures of grey surfaces with the mean emissivity of the bands.
    fn start(&self, progress: &Progress) -> Result<Vec<f64>, ExchangeError> {
        let count = self.bands.len() as f64;
        let mean = |i: usize| self.bands.iter().map(|b| b.emissivity[i]).sum::<f64>() / count;
        let grey = SurfaceBand {
            enclosure: self.bands[0].enclosure,
            range: crate::bands::SpectralRange::Thermal,
            emissivity: (0..self.targets.len()).map(mean).collect(),
        };
        let (mut temperatures, _) = self.problem.grey(&grey, self.targets, progress)?;
        for (t, unknown) in temperatures.iter_mut().zip(&self.unknown) {
            // At zero there is no slope to follow.
            if *unknown {
                *t = t.max(1.0);
            }
        }
        Ok(temperatures)
    }

    /// What is missing to the fluxes, and the largest emission.
    fn missing(&self, temperatures: &[f64], solved: &[SolvedBand]) -> (Vec<f64>, f64) {
        let mut missing = vec![0.0; temperatures.len()];
        let mut scale: f64 = f64::MIN_POSITIVE;
        for i in 0..temperatures.len() {
            let (mut leaves, mut size) = (0.0, self.targets[i].abs());
            for (band, solved) in self.bands.iter().zip(solved) {
                let (emission, h) = (band.range.emission(temperatures[i]), solved.irradiation[i]);
                leaves += band.emissivity[i] * (emission - h);
                size += band.emissivity[i] * emission.max(h);
            }
            scale = scale.max(size);
            if self.unknown[i] {
                missing[i] = self.targets[i] - leaves;
            }
        }
        (missing, scale)
    }

    /// The change of temperatures that removes what is missing, to first order.
    fn step(
        &self,
        temperatures: &[f64],
        missing: &[f64],
        progress: &Progress,
    ) -> Result<Vec<f64>, ExchangeError> {
        let slope = |band: &&SurfaceBand| -> Vec<f64> {
            let rows = temperatures.iter().zip(&self.unknown);
            rows.map(|(&t, unknown)| if *unknown { band.range.slope(t) } else { 0.0 })
                .collect()
        };
        let slopes: Vec<Vec<f64>> = self.bands.iter().map(slope).collect();
        let own = |i: usize| {
            let bands = self.bands.iter().zip(&slopes);
            let own: f64 = bands.map(|(band, s)| band.emissivity[i] * s[i]).sum();
            if own > 0.0 { own.recip() } else { 0.0 }
        };
        let inverse: Vec<f64> = (0..missing.len()).map(own).collect();
        let times = |x: &[f64]| self.times(&slopes, x, progress);
        bicgstab(times, &inverse, missing)
    }

    /// The change of fluxes with that of temperatures.
    fn times(
        &self,
        slopes: &[Vec<f64>],
        x: &[f64],
        progress: &Progress,
    ) -> Result<Vec<f64>, ExchangeError> {
        let mut product = vec![0.0; x.len()];
        for ((band, reflections), slopes) in self.bands.iter().zip(&self.reflections).zip(slopes) {
            let emitted: Vec<f64> = slopes.iter().zip(x).map(|(s, x)| s * x).collect();
            let source = band.emissivity.iter().zip(&emitted).map(|(e, x)| e * x);
            let radiosity = reflections.solve(&[source.collect()], progress)?;
            let arriving = reflections.arriving(&radiosity);
            let areas = &band.enclosure.factors.areas;
            for i in (0..x.len()).filter(|&i| self.unknown[i]) {
                let h = arriving[0][i] / areas[i].max(f64::MIN_POSITIVE);
                product[i] += band.emissivity[i] * (emitted[i] - h);
            }
        }
        Ok(product)
    }
}

/// Solves a system by BiCGSTAB with a diagonal preconditioner; the best that was found if it stalls.
fn bicgstab(
    times: impl Fn(&[f64]) -> Result<Vec<f64>, ExchangeError>,
    inverse: &[f64],
    right: &[f64],
) -> Result<Vec<f64>, ExchangeError> {
    let n = right.len();
    let precondition =
        |v: &[f64]| -> Vec<f64> { v.iter().zip(inverse).map(|(v, m)| v * m).collect() };
    let (mut x, mut rest) = (vec![0.0; n], right.to_vec());
    let shadow = rest.clone();
    let (mut direction, mut image) = (vec![0.0; n], vec![0.0; n]);
    let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
    let size = dot(right, right);
    for _ in 0..ITERATIONS {
        if dot(&rest, &rest) <= STEP_TOLERANCE * STEP_TOLERANCE * size {
            break;
        }
        let next = dot(&shadow, &rest);
        let beta = next / rho * (alpha / omega);
        if !beta.is_finite() {
            break;
        }
        rho = next;
        for i in 0..n {
            direction[i] = rest[i] + beta * (direction[i] - omega * image[i]);
        }
        let p = precondition(&direction);
        image = times(&p)?;
        alpha = rho / dot(&shadow, &image);
        if !alpha.is_finite() {
            break;
        }
        let half: Vec<f64> = (0..n).map(|i| rest[i] - alpha * image[i]).collect();
        let s = precondition(&half);
        let t = times(&s)?;
        let curvature = dot(&t, &t);
        omega = if curvature > 0.0 {
            dot(&t, &half) / curvature
        } else {
            0.0
        };
        for i in 0..n {
            x[i] += alpha * p[i] + omega * s[i];
            rest[i] = half[i] - omega * t[i];
        }
        if omega == 0.0 {
            break;
        }
    }
    Ok(x)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
