//! Temperatures where several bands meet given fluxes: Newton's method on the radiosities.
//!
//! What arrives on a row, H_k in band k, decides what leaves it: its temperature is given, or such
//! that Σ_k ε_k E_k(T) = q + Σ_k ε_k H_k, and
//!
//! ```text
//! J_k = ε_k E_k(T) + ρ_k H_k,    H_k = F_k J_k + outside
//! ```
//!
//! so that J is a fixed point of one product with the matrix and a function of each row alone. That
//! function is nearly linear (in one grey band it is), and few steps of Newton's method suffice. Their
//! linear systems are solved by BiCGSTAB (van der Vorst, SIAM J. Sci. Stat. Comput. 13, 1992), only as well
//! as the step deserves (Eisenstat and Walker, SIAM J. Sci. Comput. 17, 1996). Bands with one matrix
//! share its products, because reading it is what takes the time.

use super::heat::{HeatProblem, RowCondition, SolvedBand};
use super::reflections::arriving;
use super::{ExchangeError, STEFAN_BOLTZMANN, SurfaceBand};
use azulejo_trace::Progress;
use rayon::prelude::*;

/// Most steps of Newton's method.
const STEPS: usize = 60;

/// Most iterations for one step.
const ITERATIONS: usize = 400;

/// What may be missing to a radiosity, relative to the largest.
const TOLERANCE: f64 = 1e-12;

/// What counts as solved where rounding prevents the above.
const ENOUGH: f64 = 1e-10;

/// What a step may leave of the residual: at least and at most.
const STEP_TOLERANCE: [f64; 2] = [1e-8, 1e-2];

/// Most halvings and steps towards the temperature of a row.
const TEMPERATURE_STEPS: usize = 200;

/// Radiosities of all bands: one list of rows for each.
type Radiosities = Vec<Vec<f64>>;

/// The temperatures, the bands at these, and the number of steps.
pub(super) fn temperatures(
    problem: &HeatProblem,
    bands: &[&SurfaceBand],
    targets: &[f64],
    progress: &Progress,
) -> Result<(Vec<f64>, Vec<SolvedBand>, usize), ExchangeError> {
    let newton = NewtonWork::new(problem, bands, targets)?;
    let mut radiosities = newton.start(progress)?;
    let mut before = f64::INFINITY;
    let mut tolerance = STEP_TOLERANCE[1];
    for step in 0..STEPS {
        let rows = newton.rows(&radiosities);
        let missing = difference(&rows.radiosities, &radiosities);
        let worst = largest(&missing) / largest(&radiosities).max(f64::MIN_POSITIVE);
        let is_stuck = worst <= ENOUGH && worst >= 0.5 * before;
        if worst <= TOLERANCE || is_stuck {
            let (temperatures, solved) = newton.solved(rows)?;
            return Ok((temperatures, solved, step));
        }
        if step > 0 {
            let gain = (worst / before).powi(2);
            tolerance = gain.clamp(STEP_TOLERANCE[0], STEP_TOLERANCE[1]);
        }
        before = worst;
        let change = newton.step(&rows, &missing, tolerance, progress)?;
        for (band, change) in radiosities.iter_mut().zip(change) {
            band.iter_mut().zip(change).for_each(|(j, d)| *j += d);
        }
    }
    Err(ExchangeError::Diverges { iterations: STEPS })
}

struct NewtonWork<'a> {
    problem: &'a HeatProblem<'a>,
    bands: &'a [&'a SurfaceBand<'a>],
    targets: &'a [f64],
    /// ρ_d of each band.
    diffuse: Vec<Vec<f64>>,
    /// What arrives from outside in each band, W/m².
    outside: Vec<Vec<f64>>,
    /// Rows whose temperature is sought, and that emit.
    unknown: Vec<bool>,
}

/// What leaves all rows for what arrives on them.
struct RowState {
    temperatures: Vec<f64>,
    /// H of each band.
    irradiations: Radiosities,
    /// J of each band.
    radiosities: Radiosities,
    /// dE/dT of each band where the temperature is sought; zero elsewhere.
    slopes: Vec<Vec<f64>>,
}

impl<'a> NewtonWork<'a> {
    fn new(
        problem: &'a HeatProblem<'a>,
        bands: &'a [&'a SurfaceBand<'a>],
        targets: &'a [f64],
    ) -> Result<NewtonWork<'a>, ExchangeError> {
        let emits = |i: usize| bands.iter().any(|band| band.emissivity[i] > 0.0);
        let mut unknown = Vec::new();
        for (i, condition) in problem.conditions.iter().enumerate() {
            let has_flux = matches!(condition, RowCondition::Flux(_));
            if has_flux && !emits(i) && targets[i] != 0.0 {
                let row = problem.name(i);
                return Err(ExchangeError::NeitherEmitsNorAbsorbs { row });
            }
            unknown.push(has_flux && emits(i));
        }
        Ok(NewtonWork {
            problem,
            bands,
            targets,
            diffuse: bands.iter().map(|band| band.diffuse()).collect(),
            outside: bands
                .iter()
                .map(|b| problem.surroundings_light(b))
                .collect(),
            unknown,
        })
    }

    /// Radiosities near those sought: of black surfaces, at the temperatures of grey ones with the mean
    /// emissivity of the bands.
    fn start(&self, progress: &Progress) -> Result<Radiosities, ExchangeError> {
        let count = self.bands.len() as f64;
        let mean = |i: usize| self.bands.iter().map(|b| b.emissivity[i]).sum::<f64>() / count;
        let grey = SurfaceBand {
            enclosure: self.bands[0].enclosure,
            range: crate::thermal::bands::SpectralRange::Thermal,
            emissivity: (0..self.targets.len()).map(mean).collect(),
        };
        let (temperatures, _) = self.problem.grey(&grey, self.targets, progress)?;
        let radiosity = |(band, diffuse): (&&SurfaceBand, &Vec<f64>)| {
            let rows = (0..temperatures.len()).into_par_iter();
            let leaves =
                |i: usize| (band.emissivity[i] + diffuse[i]) * band.range.emission(temperatures[i]);
            rows.map(leaves).collect()
        };
        Ok(self
            .bands
            .iter()
            .zip(&self.diffuse)
            .map(radiosity)
            .collect())
    }

    /// F J of each band.
    fn arriving(&self, radiosities: &[Vec<f64>]) -> Radiosities {
        let first = self.bands[0].enclosure;
        let is_shared = self.bands.iter().all(|b| std::ptr::eq(b.enclosure, first));
        let mut sums = if is_shared {
            arriving(first.operator(), radiosities)
        } else {
            let bands = self.bands.iter().zip(radiosities);
            let one = |(band, radiosity): (&&SurfaceBand, &Vec<f64>)| {
                arriving(band.enclosure.operator(), std::slice::from_ref(radiosity))
            };
            bands.flat_map(one).collect()
        };
        for (sums, band) in sums.iter_mut().zip(self.bands) {
            for (sum, &area) in sums.iter_mut().zip(&band.enclosure.factors.areas) {
                *sum = if area > 0.0 { *sum / area } else { 0.0 };
            }
        }
        sums
    }

    /// What leaves all rows by what the radiosities bring to them.
    fn rows(&self, radiosities: &[Vec<f64>]) -> RowState {
        let mut irradiations = self.arriving(radiosities);
        for (h, outside) in irradiations.iter_mut().zip(&self.outside) {
            h.iter_mut()
                .zip(outside)
                .for_each(|(h, outside)| *h += outside);
        }
        let rows = 0..self.targets.len();
        let temperature = |i: usize| self.temperature(i, &irradiations);
        let temperatures: Vec<f64> = rows.clone().into_par_iter().map(temperature).collect();
        let per_band = |value: &(dyn Fn(usize, usize) -> f64 + Sync)| -> Vec<Vec<f64>> {
            let band = |k: usize| rows.clone().into_par_iter().map(|i| value(k, i)).collect();
            (0..self.bands.len()).map(band).collect()
        };
        RowState {
            radiosities: per_band(&|k, i| {
                let band = self.bands[k];
                let emitted = band.emissivity[i] * band.range.emission(temperatures[i]);
                emitted + self.diffuse[k][i] * irradiations[k][i]
            }),
            slopes: per_band(&|k, i| {
                if self.unknown[i] {
                    self.bands[k].range.slope(temperatures[i])
                } else {
                    0.0
                }
            }),
            temperatures,
            irradiations,
        }
    }

    /// The temperature of a row: given, or what balances its flux; zero where less than nothing is
    /// left to emit. Rows that do not emit are as warm as what they see.
    fn temperature(&self, i: usize, irradiations: &[Vec<f64>]) -> f64 {
        if let RowCondition::Temperature(given) = self.problem.conditions[i] {
            return given;
        }
        if !self.unknown[i] {
            let arrives: f64 = irradiations.iter().map(|h| h[i]).sum();
            return (arrives.max(0.0) / STEFAN_BOLTZMANN).powf(0.25);
        }
        let emission = |t: f64| -> f64 {
            let bands = self.bands.iter();
            bands.map(|b| b.emissivity[i] * b.range.emission(t)).sum()
        };
        let slope = |t: f64| -> f64 {
            self.bands
                .iter()
                .map(|b| b.emissivity[i] * b.range.slope(t))
                .sum()
        };
        solved_increasing(emission, slope, self.balance(i, irradiations))
    }

    /// What a row has to emit.
    fn balance(&self, i: usize, irradiations: &[Vec<f64>]) -> f64 {
        let bands = self.bands.iter().zip(irradiations);
        self.targets[i] + bands.map(|(b, h)| b.emissivity[i] * h[i]).sum::<f64>()
    }

    /// The change of radiosities that removes what is missing, to first order: (I − C F) x = missing, where
    /// C is how the radiosities of a row answer to its irradiations.
    fn step(
        &self,
        rows: &RowState,
        missing: &[Vec<f64>],
        tolerance: f64,
        progress: &Progress,
    ) -> Result<Radiosities, ExchangeError> {
        let own = |i: usize| {
            let bands = self.bands.iter().zip(&rows.slopes);
            let own: f64 = bands.map(|(band, s)| band.emissivity[i] * s[i]).sum();
            if own > 0.0 { own.recip() } else { 0.0 }
        };
        let warmed: Vec<f64> = (0..self.targets.len()).map(own).collect();
        let times = |x: &Radiosities| {
            progress.advance(0)?;
            let arriving = self.arriving(x);
            let warmer = |i: usize| {
                let bands = self.bands.iter().zip(&arriving);
                warmed[i] * bands.map(|(b, h)| b.emissivity[i] * h[i]).sum::<f64>()
            };
            let warmer: Vec<f64> = (0..self.targets.len()).map(warmer).collect();
            let mut product = x.clone();
            for (k, product) in product.iter_mut().enumerate() {
                let band = self.bands[k];
                for (i, p) in product.iter_mut().enumerate() {
                    let emitted = band.emissivity[i] * rows.slopes[k][i] * warmer[i];
                    *p -= emitted + self.diffuse[k][i] * arriving[k][i];
                }
            }
            Ok(product)
        };
        bicgstab(times, missing, tolerance)
    }

    /// Temperatures and bands, of rows that all emit more than nothing.
    fn solved(&self, rows: RowState) -> Result<(Vec<f64>, Vec<SolvedBand>), ExchangeError> {
        let is_below_zero = |&i: &usize| {
            let missing = self.balance(i, &rows.irradiations);
            // Rounding may leave a little less than nothing.
            self.unknown[i] && missing < -1e-9 * self.targets[i].abs()
        };
        if let Some(i) = (0..self.targets.len()).find(is_below_zero) {
            let row = self.problem.name(i);
            return Err(ExchangeError::BelowZero { row });
        }
        let bands = rows.radiosities.into_iter().zip(rows.irradiations);
        let solved = bands.map(|(radiosity, irradiation)| SolvedBand {
            radiosity,
            irradiation,
        });
        Ok((rows.temperatures, solved.collect()))
    }
}

/// Where a function that increases from 0 at 0 has a value, by Newton's method between bounds; 0 for
/// values below 0, and the largest number for those that it never reaches.
fn solved_increasing(function: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64, value: f64) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1_000.0);
    while function(high) < value {
        (low, high) = (high, 2.0 * high);
        if high > 1e60 {
            return f64::INFINITY;
        }
    }
    let mut t = 0.5 * (low + high);
    for _ in 0..TEMPERATURE_STEPS {
        let over = function(t) - value;
        if over == 0.0 {
            break;
        }
        if over > 0.0 {
            high = t
        } else {
            low = t
        }
        let newton = t - over / slope(t);
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        let is_done = (next - t).abs() <= 1e-15 * t;
        t = next;
        if is_done {
            break;
        }
    }
    t
}

/// Solves a system by BiCGSTAB (van der Vorst 1992); the last iterate if the method breaks down or stalls.
fn bicgstab(
    times: impl Fn(&Radiosities) -> Result<Radiosities, ExchangeError>,
    right: &[Vec<f64>],
    tolerance: f64,
) -> Result<Radiosities, ExchangeError> {
    let zero: Radiosities = right.iter().map(|band| vec![0.0; band.len()]).collect();
    // Start from 0: the right side is the first residual, and the shadow residual too.
    let (mut x, mut rest) = (zero.clone(), right.to_vec());
    let shadow = right;
    let (mut direction, mut image) = (zero.clone(), zero);
    let (mut rho, mut alpha, mut omega) = (1.0, 1.0, 1.0);
    let enough = tolerance * tolerance * dot(right, right);
    for _ in 0..ITERATIONS {
        if dot(&rest, &rest) <= enough {
            break;
        }
        // Renew the direction; where that divides by nothing, the method has broken down.
        let next = dot(shadow, &rest);
        let beta = next / rho * (alpha / omega);
        if !beta.is_finite() {
            break;
        }
        rho = next;
        for (d, (r, v)) in direction.iter_mut().zip(rest.iter().zip(&image)) {
            for (d, (r, v)) in d.iter_mut().zip(r.iter().zip(v)) {
                *d = r + beta * (*d - omega * v);
            }
        }
        // Make the step of biconjugate gradients along the direction.
        image = times(&direction)?;
        alpha = rho / dot(shadow, &image);
        if !alpha.is_finite() {
            break;
        }
        add(&mut rest, -alpha, &image);
        // Stabilize it: along the image of what is left, go to the least residual.
        let t = times(&rest)?;
        let curvature = dot(&t, &t);
        omega = if curvature > 0.0 {
            dot(&t, &rest) / curvature
        } else {
            0.0
        };
        add(&mut x, alpha, &direction);
        add(&mut x, omega, &rest);
        add(&mut rest, -omega, &t);
        if omega == 0.0 {
            break;
        }
    }
    Ok(x)
}

fn dot(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let bands = a.iter().zip(b);
    bands
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>())
        .sum()
}

fn add(to: &mut [Vec<f64>], factor: f64, x: &[Vec<f64>]) {
    for (to, x) in to.iter_mut().zip(x) {
        to.iter_mut().zip(x).for_each(|(to, x)| *to += factor * x);
    }
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> Radiosities {
    let bands = a.iter().zip(b);
    let band = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    bands.map(band).collect()
}

fn largest(bands: &[Vec<f64>]) -> f64 {
    let numbers = bands.iter().flatten();
    numbers.fold(0.0, |largest: f64, x| largest.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increasing_functions_are_inverted() {
        let (cube, slope) = (|t: f64| 3.0 * t.powi(3), |t: f64| 9.0 * t * t);
        for t in [1e-6, 0.3, 290.0, 1e5, 1e9] {
            let root = solved_increasing(cube, slope, cube(t));
            assert!((root - t).abs() <= 1e-14 * t, "{t} {root}");
        }
        assert_eq!(solved_increasing(cube, slope, 0.0), 0.0);
        assert_eq!(solved_increasing(cube, slope, -1.0), 0.0);
        let bounded = |t: f64| t / (1.0 + t);
        assert_eq!(solved_increasing(bounded, |_| 0.0, 2.0), f64::INFINITY);
    }
}
