//! Points by brightness: what error each may have, and what it has.
//!
//! An error of a hundredth of the mean irradiance hides all of a dark room, and an error of a
//! hundredth of what a dark point gets costs more than all other points together. So the permitted
//! error grows with brightness, but less than in proportion.

use azulejo_scene::Rgb;
use azulejo_trace::{Gathered, Termination, sequence_gain};

/// Number of strata: each gathers in its own way.
const STRATA: usize = 8;

/// The same where each point is to reach an error: the fewer points of a stratum, the more alike.
const STRATA_OF_EACH: usize = 64;

/// Share of the mean irradiance below which points are taken to have that, where each is to reach an error.
pub(crate) const DARKEST_OF_EACH: f64 = 1e-3;

/// Points per stratum, at least: fewer would not show how they are lit.
const LEAST: usize = 16;

/// Permitted errors are in proportion to this power of irradiance.
const TOLERANCE_POWER: f64 = 0.6;

/// Share of the mean irradiance below which nobody will miss a stratum's light: its errors are
/// permitted to be those of [`DARK_AS`], or what no light reaches would take all rays.
const DARKEST: f64 = 0.01;

/// See [`DARKEST`].
const DARK_AS: f64 = 0.1;

/// Degrees of freedom of one point's variance.
pub(crate) const OWN: f64 = 3.0;

/// Points that say as much of each other's variance as is used of it.
const ALIKE: usize = 5;

/// What of a requested error is aimed at: estimated errors have errors.
const MARGIN: f64 = 0.95;

/// An error by its causes, both relative to the mean irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorParts {
    /// From the number of rays.
    pub noise: f64,
    /// From the size of the patches, measured at a sample of the points.
    pub discretization: f64,
    /// From interpolating indirect light between points.
    pub interpolation: f64,
}

/// The error of a quarter of the points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct QuarterError {
    /// Mean irradiance, W/m².
    pub mean: f64,
    /// Root mean square of the error, W/m².
    pub error: f64,
}

/// The points of a gather, divided by brightness.
#[derive(Clone, Debug)]
pub struct Strata {
    /// Share of the total area of every point.
    shares: Vec<f64>,
    /// Stratum of every point.
    of: Vec<u8>,
    strata: Vec<Stratum>,
    /// Number of channels that have light.
    channels: f64,
    /// Whether an error is asked of each point, relative to its own irradiance.
    is_each: bool,
}

#[derive(Clone, Debug, Default)]
struct Stratum {
    points: Vec<u32>,
    termination: Termination,
    /// Mean square of the difference that path tracing makes, (W/m²)², if it was measured.
    discretization: f64,
    /// Mean square of the error of interpolation, (W/m²)².
    interpolation: f64,
}

/// How much points of the least areas count where rays are distributed, relative to those of the mean area: in proportion
/// to the root of their areas they would get hardly any. So their error is at most about three times that of equal rays.
pub(crate) const LEAST_WEIGHT: f64 = 1.0 / 81.0;

/// Mean irradiance of a stratum, and the variance of its estimate.
#[derive(Clone, Copy, Debug)]
pub struct StratumError {
    /// Share of the area.
    pub share: f64,
    /// Mean irradiance, W/m².
    pub mean: f64,
    /// Mean variance by noise, (W/m²)², `gain` included.
    pub noise: f64,
    /// Mean square by discretization, (W/m²)².
    pub discretization: f64,
    /// Mean square by interpolation, (W/m²)².
    pub interpolation: f64,
    /// Variance of an estimate relative to that of independent replicates.
    pub gain: f64,
}

impl Strata {
    /// One stratum of all points, which count by `areas`, or alike if there are none.
    pub fn new(count: usize, areas: &[f64]) -> Strata {
        let total: f64 = areas.iter().sum();
        let alike = 1.0 / count.max(1) as f64;
        let share = |i: usize| match areas.get(i) {
            Some(a) if total > 0.0 => a / total,
            _ => alike,
        };
        Strata {
            shares: (0..count).map(share).collect(),
            of: vec![0; count],
            strata: vec![Stratum {
                points: (0..count as u32).collect(),
                ..Stratum::default()
            }],
            channels: 3.0,
            is_each: false,
        }
    }

    /// Asks an error of each point, relative to its own irradiance.
    pub fn ask_each(&mut self) {
        self.is_each = true;
    }

    /// Whether an error is asked of each point.
    pub fn is_each(&self) -> bool {
        self.is_each
    }

    /// Divides the points by what they have gathered so far, into strata of as many points each, and
    /// forgets what was known of the strata before, except how all points are gathered if that is
    /// the same for all.
    pub fn divide(&mut self, gathered: &[Gathered]) {
        let lit: Rgb = gathered.iter().map(Gathered::mean).sum();
        let channels = (0..3).filter(|&k| lit[k] > 0.0).count();
        self.channels = channels.max(1) as f64;
        let brightness: Vec<f64> = gathered.iter().map(|g| self.mean_of(g.mean())).collect();
        let order = by_brightness(&brightness);
        let count = if self.is_each {
            order.len().clamp(1, STRATA_OF_EACH)
        } else {
            (order.len() / LEAST).clamp(1, STRATA)
        };
        let termination = self.strata[0].termination;
        self.strata = vec![Stratum::default(); count];
        for (rank, &i) in order.iter().enumerate() {
            let stratum = rank * count / order.len();
            self.of[i as usize] = stratum as u8;
            self.strata[stratum].points.push(i);
        }
        for stratum in &mut self.strata {
            stratum.points.sort_unstable();
            stratum.termination = termination;
        }
    }

    /// Number of strata.
    pub fn count(&self) -> usize {
        self.strata.len()
    }

    /// Stratum of a point.
    pub fn of(&self, point: usize) -> usize {
        self.of[point].into()
    }

    /// The points of a stratum, in order.
    pub fn points(&self, stratum: usize) -> &[u32] {
        &self.strata[stratum].points
    }

    /// Share of the total area of a point.
    pub fn share(&self, point: usize) -> f64 {
        self.shares[point]
    }

    /// Area of a point relative to the mean, at least an 81st: how much its error counts where rays are
    /// distributed.
    pub fn weight(&self, point: usize) -> f64 {
        if self.is_each {
            return 1.0;
        }
        (self.shares[point] * self.shares.len() as f64).max(LEAST_WEIGHT)
    }

    /// Shares of the total area of all points.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// How the points of a stratum are gathered.
    pub fn termination(&self, stratum: usize) -> Termination {
        self.strata[stratum].termination
    }

    /// How a point is gathered.
    pub fn termination_of(&self, point: usize) -> Termination {
        self.termination(self.of(point))
    }

    /// Reads patches in this stratum, which makes this mean square error, (W/m²)².
    pub fn read_patches(&mut self, stratum: usize, discretization: f64) {
        self.strata[stratum].termination = Termination::Radiosity;
        self.strata[stratum].discretization = discretization;
    }

    /// Path traces this stratum, without discretization.
    pub fn trace_paths(&mut self, stratum: usize) {
        self.strata[stratum].termination = Termination::Roulette;
        self.strata[stratum].discretization = 0.0;
    }

    /// States the mean square error of interpolation in this stratum, (W/m²)².
    pub fn interpolate(&mut self, stratum: usize, error: f64) {
        self.strata[stratum].interpolation = error;
    }

    /// The same strata of other points, each of which is in the stratum of a point of these.
    /// `areas` are those of the new points.
    pub fn spread(&self, parents: &[u32], areas: &[f64]) -> Strata {
        let mut strata = Strata {
            of: parents.iter().map(|&p| self.of[p as usize]).collect(),
            channels: self.channels,
            strata: self.strata.clone(),
            ..Strata::new(parents.len(), areas)
        };
        strata.strata.iter_mut().for_each(|s| s.points.clear());
        for (i, &stratum) in strata.of.iter().enumerate() {
            strata.strata[usize::from(stratum)].points.push(i as u32);
        }
        strata
    }

    /// Share of the points in strata that are path traced.
    pub fn path_traced(&self) -> f64 {
        let traced = self
            .strata
            .iter()
            .filter(|s| s.termination == Termination::Roulette);
        let points: usize = traced.map(|s| s.points.len()).sum();
        points as f64 / self.of.len().max(1) as f64
    }

    /// Mean over the channels that have light.
    pub fn mean_of(&self, value: Rgb) -> f64 {
        3.0 * value.mean() / self.channels
    }

    /// The errors of all strata.
    pub fn errors(&self, gathered: &[Gathered]) -> Vec<StratumError> {
        let of = |stratum: &Stratum| {
            let gain = self.gain(&stratum.points, gathered);
            let mut error = StratumError {
                share: 0.0,
                mean: 0.0,
                noise: 0.0,
                discretization: stratum.discretization,
                interpolation: stratum.interpolation,
                gain,
            };
            for &i in &stratum.points {
                let (g, share) = (&gathered[i as usize], self.shares[i as usize]);
                error.share += share;
                error.mean += share * self.mean_of(g.mean());
                error.noise += share * gain * self.mean_of(g.variance());
            }
            if error.share > 0.0 {
                error.mean /= error.share;
                error.noise /= error.share;
            }
            error
        };
        self.strata.iter().map(of).collect()
    }

    /// Variance of the estimates relative to that of independent replicates ([`sequence_gain`]).
    fn gain(&self, points: &[u32], gathered: &[Gathered]) -> f64 {
        let of_points = points.iter().map(|&i| &gathered[i as usize]);
        sequence_gain(of_points, |value| self.mean_of(value))
    }

    /// The whole error, relative to the mean irradiance.
    pub fn error(&self, errors: &[StratumError]) -> ErrorParts {
        let sum = |f: fn(&StratumError) -> f64| errors.iter().map(|e| e.share * f(e)).sum::<f64>();
        let mean = sum(|e| e.mean);
        let relative = |square: f64| {
            if mean > 0.0 {
                square.sqrt() / mean
            } else {
                0.0
            }
        };
        ErrorParts {
            noise: relative(sum(|e| e.noise)),
            discretization: relative(sum(|e| e.discretization)),
            interpolation: relative(sum(|e| e.interpolation)),
        }
    }

    /// Mean square error, (W/m²)², that each stratum may have for all to reach `goal`.
    pub fn permitted(&self, errors: &[StratumError], goal: f64) -> Vec<f64> {
        let mean: f64 = errors.iter().map(|e| e.share * e.mean).sum();
        if self.is_each {
            // Standard errors from few replicates are larger than these spread.
            let square = |(e, stratum): (&StratumError, &Stratum)| {
                let alike = stratum.points.len().clamp(1, ALIKE);
                let light = e.mean.max(DARKEST_OF_EACH * mean);
                (MARGIN * goal * light / coverage(OWN * alike as f64)).powi(2)
            };
            return errors.iter().zip(&self.strata).map(square).collect();
        }
        let power = |e: &StratumError| {
            let relative = e.mean / mean.max(f64::MIN_POSITIVE);
            let relative = if relative < DARKEST {
                DARK_AS
            } else {
                relative
            };
            relative.powf(2.0 * TOLERANCE_POWER)
        };
        let total: f64 = errors.iter().map(|e| e.share * power(e)).sum();
        let scale = (MARGIN * goal * mean).powi(2) / total.max(f64::MIN_POSITIVE);
        errors.iter().map(|e| scale * power(e)).collect()
    }

    /// Mean irradiance and error of the quarters of the points, from dark to bright.
    pub fn quarters(&self, gathered: &[Gathered], errors: &[StratumError]) -> [QuarterError; 4] {
        let brightness: Vec<f64> = gathered.iter().map(|g| self.mean_of(g.mean())).collect();
        let order = by_brightness(&brightness);
        let mut quarters = [QuarterError::default(); 4];
        let mut shares = [0.0; 4];
        for (rank, &i) in order.iter().enumerate() {
            let (i, q) = (i as usize, rank * 4 / order.len());
            let error = &errors[self.of(i)];
            let noise = self.mean_of(gathered[i].variance()) * error.gain;
            shares[q] += self.shares[i];
            quarters[q].mean += self.shares[i] * brightness[i];
            quarters[q].error +=
                self.shares[i] * (noise + error.discretization + error.interpolation);
        }
        for (quarter, share) in quarters.iter_mut().zip(shares) {
            if share > 0.0 {
                quarter.mean /= share;
                quarter.error = (quarter.error / share).sqrt();
            }
        }
        quarters
    }
}

/// Half of the deviation, in standard errors estimated with so many degrees of freedom, that covers
/// what two standard deviations of a normal distribution do: Student's t by its expansion in 1/ν
/// (Fisher and Cornish 1960), too small by 0.9% at ν = 3 and less above.
pub(crate) fn coverage(freedom: f64) -> f64 {
    let x = 1.0 / freedom;
    1.0 + x * (1.25 + x * (1.531 + x * 1.43))
}

/// The points from dark to bright.
fn by_brightness(brightness: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..brightness.len() as u32).collect();
    order.sort_by(|&a, &b| brightness[a as usize].total_cmp(&brightness[b as usize]));
    order
}
