//! Gebhart factors, script-F and conductances between nodes.

use super::reflections::{LANES, Reflections, from_flat, lanes};
use super::{ExchangeError, SurfaceBand};
use crate::enclosure::Groups;
use azulejo_factors::form_factors::RowRemainder;
use azulejo_trace::Progress;
use rayon::prelude::*;

/// Radiative conductances between nodes, and what follows from them. Nodes are groups of rows, each
/// at one temperature, and after them `sky` and `ground` where light leaves the scene.
///
/// GR_ab = Σ_i∈a ε_i A_i H_i, in square metres, with the irradiation H that node b causes when it emits
/// alone as a black body would with one watt per square metre: Q_a→b = σ GR_ab (T_a⁴ − T_b⁴). It is the GR of ESATAN and the
/// radiation conductor of SINDA, without σ. Both directions are computed, each from its own solution, and
/// their mean is kept, so that reciprocity is exact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExchangeFactors {
    /// Names of the nodes.
    pub names: Vec<String>,
    /// Areas, m²; for sky and ground Σ A_i X_is, the area that would send them as much.
    pub areas: Vec<f64>,
    /// Σ ε_i A_i of each node, m²; for sky and ground their area.
    pub emitting: Vec<f64>,
    /// Whether each node is a surface, not sky or ground.
    pub is_surface: Vec<bool>,
    /// GR_ab, m², row by row.
    pub conductances: Vec<f64>,
    /// Their standard errors, m².
    pub errors: Vec<f64>,
    /// Largest difference of GR_ab and GR_ba before their mean was taken, relative to the smaller of
    /// both nodes' `emitting`: the error of the solution.
    pub asymmetry: f64,
}

impl ExchangeFactors {
    /// Number of nodes, with sky and ground.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// GR_ab and its standard error, m².
    pub fn conductance(&self, a: usize, b: usize) -> (f64, f64) {
        let at = a * self.len() + b;
        (self.conductances[at], self.errors[at])
    }

    /// Gebhart's (absorption) factor B_ab and its standard error: the share of what a emits that b
    /// absorbs in the end, after all reflections. Zeros if a emits nothing.
    pub fn gebhart(&self, a: usize, b: usize) -> (f64, f64) {
        self.per(self.emitting[a], a, b)
    }

    /// The transfer factor (script-F, Hottel's grey interchange factor) and its standard error:
    /// GR_ab over the area of a.
    pub fn script_f(&self, a: usize, b: usize) -> (f64, f64) {
        self.per(self.areas[a], a, b)
    }

    fn per(&self, whole: f64, a: usize, b: usize) -> (f64, f64) {
        let (value, error) = self.conductance(a, b);
        if whole > 0.0 {
            (value / whole, error / whole)
        } else {
            (0.0, 0.0)
        }
    }

    /// Σ_b B_ab of each node that is a surface: 1 if the factors close.
    pub fn row_sums(&self) -> Vec<f64> {
        let surfaces = (0..self.len()).filter(|&a| self.is_surface[a]);
        let sum = |a: usize| (0..self.len()).map(|b| self.gebhart(a, b).0).sum();
        surfaces.map(sum).collect()
    }
}

/// Products of pairs of nodes and pairs of rows up to which standard errors are exact to first order;
/// beyond, they are bounds, up to √2 too large.
const EXACT_ERRORS: u64 = 4_000_000_000;

/// Where light leaves the scene.
struct Opening {
    name: &'static str,
    share: fn(&RowRemainder) -> f64,
    error: fn(&RowRemainder) -> f64,
}

const OPENINGS: [Opening; 2] = [
    Opening {
        name: "sky",
        share: |r| r.sky,
        error: |r| r.sky_error,
    },
    Opening {
        name: "ground",
        share: |r| r.ground,
        error: |r| r.ground_error,
    },
];

/// Conductances between groups of rows, in one band. Rows without a group absorb, and emit nothing.
///
/// One system is solved for each node; its cost grows with nodes times pairs. Standard errors
/// propagate those of the factors, as if pairs were independent.
///
/// # Errors
/// [`ExchangeError`].
///
/// # Panics
/// If there is not one group for each row.
pub fn exchange_factors(
    band: &SurfaceBand,
    nodes: &Groups,
    progress: &Progress,
) -> Result<ExchangeFactors, ExchangeError> {
    assert_eq!(
        nodes.of_rows.len(),
        band.enclosure.len(),
        "one group for each row"
    );
    let work = Work::new(band, nodes);
    progress.begin("exchange factors", work.nodes() as u64);
    let reflections = Reflections::new(band.enclosure, &work.diffuse, progress)?;
    let sources: Vec<Vec<f64>> = (0..work.nodes()).map(|b| work.source(b)).collect();
    let radiosities = reflections.solve(&sources, progress)?;
    let arriving = reflections.arriving(&radiosities);
    let absorbed: Vec<Vec<f64>> = (0..work.nodes())
        .into_par_iter()
        .map(|b| work.absorbed(b, &radiosities[b], &arriving[b]))
        .collect();
    let variances = work.variances(&radiosities, progress)?;
    Ok(work.finish(&absorbed, &variances))
}

struct Work<'a> {
    band: &'a SurfaceBand<'a>,
    nodes: &'a Groups,
    diffuse: Vec<f64>,
    openings: Vec<&'static Opening>,
}

impl Work<'_> {
    fn new<'a>(band: &'a SurfaceBand<'a>, nodes: &'a Groups) -> Work<'a> {
        let rest = &band.enclosure.factors.rest;
        let is_open = |o: &&Opening| rest.iter().any(|r| (o.share)(r) > 0.0);
        Work {
            band,
            nodes,
            diffuse: band.diffuse(),
            openings: OPENINGS.iter().filter(is_open).collect(),
        }
    }

    fn surfaces(&self) -> usize {
        self.nodes.names.len()
    }

    fn nodes(&self) -> usize {
        self.surfaces() + self.openings.len()
    }

    /// H₀ of a row for one watt per square metre of an opening.
    fn opening_share(&self, opening: &Opening, i: usize) -> f64 {
        (opening.share)(&self.band.enclosure.factors.rest[i])
    }

    /// What leaves rows before any exchange when node b emits alone.
    fn source(&self, b: usize) -> Vec<f64> {
        let rows = 0..self.band.enclosure.len();
        match b.checked_sub(self.surfaces()) {
            None => {
                let emits = |i: usize| self.nodes.of_rows[i] == Some(b as u32);
                let row = |i: usize| {
                    if emits(i) {
                        self.band.emissivity[i]
                    } else {
                        0.0
                    }
                };
                rows.map(row).collect()
            }
            Some(k) => {
                let opening = self.openings[k];
                rows.map(|i| self.diffuse[i] * self.opening_share(opening, i))
                    .collect()
            }
        }
    }

    /// What each node absorbs of what node b emits, in square scene units.
    fn absorbed(&self, b: usize, radiosity: &[f64], arriving: &[f64]) -> Vec<f64> {
        let areas = &self.band.enclosure.factors.areas;
        let from = b.checked_sub(self.surfaces()).map(|k| self.openings[k]);
        let mut absorbed = vec![0.0; self.nodes()];
        for i in 0..areas.len() {
            let direct = from.map_or(0.0, |o| areas[i] * self.opening_share(o, i));
            if let Some(a) = self.nodes.of_rows[i] {
                absorbed[a as usize] += self.band.emissivity[i] * (arriving[i] + direct);
            }
            for (k, opening) in self.openings.iter().enumerate() {
                let leaves = areas[i] * self.opening_share(opening, i) * radiosity[i];
                absorbed[self.surfaces() + k] += leaves;
            }
        }
        absorbed
    }

    /// Variances of the conductances, row by row, from those of the factors: with J of both nodes,
    /// Σ_i<j σ²(S_ij) (J^a_i J^b_j + J^a_j J^b_i)² + Σ_i σ²(S_ii) (J^a_i J^b_i)², and
    /// Σ_i (A_i σ(X_is) J^a_i)² for an opening s = b.
    fn variances(
        &self,
        radiosities: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<f64>, ExchangeError> {
        let count = self.nodes();
        let pairs = self.band.enclosure.operator().numbers();
        let products = (count * (count + 1) / 2) as u64;
        let mut variances = if products.saturating_mul(pairs) <= EXACT_ERRORS {
            self.pair_variances(radiosities, progress)?
        } else {
            self.variance_bounds(radiosities, progress)?
        };
        for (k, opening) in self.openings.iter().enumerate() {
            let s = self.surfaces() + k;
            for a in 0..count {
                let variance = self.opening_variance(opening, &radiosities[a]);
                variances[a * count + s] += variance;
                if a != s {
                    variances[s * count + a] += variance;
                }
            }
        }
        Ok(variances)
    }

    fn opening_variance(&self, opening: &Opening, radiosity: &[f64]) -> f64 {
        let factors = &self.band.enclosure.factors;
        let rows = factors.areas.iter().zip(&factors.rest).zip(radiosity);
        let row = |((area, rest), j): ((&f64, &RowRemainder), &f64)| {
            (area * (opening.error)(rest) * j).powi(2)
        };
        rows.map(row).filter(|v| v.is_finite()).sum()
    }

    fn pair_variances(
        &self,
        radiosities: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<f64>, ExchangeError> {
        let count = radiosities.len();
        let factors = self.band.enclosure.operator();
        let row = |a: usize| -> Result<Vec<f64>, ExchangeError> {
            progress.advance(0)?;
            let one = |b: usize| {
                let (r, j) = (&radiosities[a], &radiosities[b]);
                factors.variance_between(r, j)
            };
            Ok((a..count).map(one).collect())
        };
        let upper: Result<Vec<Vec<f64>>, ExchangeError> =
            (0..count).into_par_iter().map(row).collect();
        let upper = upper?;
        let at = |k: usize| {
            let (a, b) = (k / count, k % count);
            upper[a.min(b)][a.max(b) - a.min(b)]
        };
        Ok((0..count * count).map(at).collect())
    }

    /// Bounds by (x + y)² ≤ 2x² + 2y², which need one product with the matrix for each node.
    fn variance_bounds(
        &self,
        radiosities: &[Vec<f64>],
        progress: &Progress,
    ) -> Result<Vec<f64>, ExchangeError> {
        let count = radiosities.len();
        let factors = self.band.enclosure.operator();
        let mut variances = vec![0.0; count * count];
        let square = |v: &Vec<f64>| v.iter().map(|x| x * x).collect::<Vec<f64>>();
        let squares: Vec<Vec<f64>> = radiosities.par_iter().map(square).collect();
        for (block, few) in squares.chunks(LANES).enumerate() {
            progress.advance(0)?;
            let x: Vec<[f64; LANES]> = lanes(few);
            let spread = factors.variance_lanes(x.as_flattened(), LANES);
            let spread: Vec<[f64; LANES]> = from_flat(spread);
            let row = |r: &Vec<f64>| {
                let mut sums = [0.0; LANES];
                for (r, spread) in r.iter().zip(&spread) {
                    (0..LANES).for_each(|lane| sums[lane] += 2.0 * r * spread[lane]);
                }
                sums
            };
            let sums: Vec<[f64; LANES]> = squares.par_iter().map(row).collect();
            for (a, sums) in sums.iter().enumerate() {
                for lane in 0..few.len() {
                    variances[a * count + block * LANES + lane] = sums[lane];
                }
            }
        }
        Ok(variances)
    }

    /// Means of both directions, in square metres.
    fn finish(&self, absorbed: &[Vec<f64>], variances: &[f64]) -> ExchangeFactors {
        let unit = self.band.enclosure.metres_per_unit().powi(2);
        let (count, factors) = (self.nodes(), &self.band.enclosure.factors);
        let (mut areas, mut emitting) = (vec![0.0; count], vec![0.0; count]);
        for i in 0..factors.len() {
            if let Some(a) = self.nodes.of_rows[i] {
                areas[a as usize] += unit * factors.areas[i];
                emitting[a as usize] += unit * factors.areas[i] * self.band.emissivity[i];
            }
            for (k, opening) in self.openings.iter().enumerate() {
                let share = unit * factors.areas[i] * self.opening_share(opening, i);
                areas[self.surfaces() + k] += share;
                emitting[self.surfaces() + k] += share;
            }
        }
        let mut asymmetry: f64 = 0.0;
        let mut mean = |k: usize| {
            let (a, b) = (k / count, k % count);
            let [one, other] = [absorbed[a][b], absorbed[b][a]];
            let whole = emitting[a].min(emitting[b]);
            if whole > 0.0 {
                asymmetry = asymmetry.max(unit * (one - other).abs() / whole);
            }
            unit * 0.5 * (one + other)
        };
        let conductances = (0..count * count).map(&mut mean).collect();
        let names = self.nodes.names.iter().cloned();
        let openings = self.openings.iter().map(|o| o.name.to_owned());
        ExchangeFactors {
            names: crate::enclosure::unique(names.chain(openings).collect()),
            areas,
            emitting,
            is_surface: (0..count).map(|a| a < self.surfaces()).collect(),
            conductances,
            errors: variances.iter().map(|v| unit * v.max(0.0).sqrt()).collect(),
            asymmetry,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thermal::bands::SpectralRange;
    use crate::thermal::network::tests::{each_row, random_enclosure};
    use azulejo_factors::form_factors::Exchange;

    /// For many nodes variances have bounds, from one to two times what they are.
    #[test]
    fn bounds_of_variances_hold() {
        let n = 11;
        let mut enclosure = random_enclosure(n, 4);
        let with_error = |e: &Exchange| Exchange {
            error: 0.01 * e.value as f32,
            ..*e
        };
        let exchange = &enclosure.factors.exchange;
        let row = |i: usize| exchange.upper(i).iter().map(with_error).collect::<Vec<_>>();
        enclosure.factors.exchange = (0..n).map(row).collect();
        let band = SurfaceBand {
            emissivity: enclosure.factors.ends.iter().map(|e| 0.5 * e).collect(),
            enclosure: &enclosure,
            range: SpectralRange::Thermal,
        };
        let nodes = each_row(n);
        let work = Work::new(&band, &nodes);
        let sources: Vec<Vec<f64>> = (0..n).map(|b| work.source(b)).collect();
        let progress = Progress::new();
        let reflections = Reflections::new(&enclosure, &work.diffuse, &progress).unwrap();
        let radiosities = reflections.solve(&sources, &progress).unwrap();
        let exact = work.pair_variances(&radiosities, &progress).unwrap();
        let bounds = work.variance_bounds(&radiosities, &progress).unwrap();
        for (exact, bound) in exact.iter().zip(&bounds) {
            let ratio = bound / exact;
            assert!((1.0 - 1e-9..=2.0 + 1e-9).contains(&ratio), "{ratio}");
        }
    }
}
