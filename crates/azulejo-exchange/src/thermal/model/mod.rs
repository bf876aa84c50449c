//! Thermal models: factors with surface properties, temperatures and fluxes, solved and written.
//!
//! [`ThermalModel::solve`] chooses the matrix of each band by its mirrors, combines rows to nodes, and solves
//! networks and heat balance; [`ThermalSolution::write`] writes the result.

mod error;
mod lists;
mod lump;
#[cfg(test)]
mod tests;
mod write;

pub use error::ModelError;
pub use write::{SolutionFormat, SolutionOptions, SolutionPart};

use crate::enclosure::{Enclosure, GroupBy, Groups};
use crate::thermal::bands::SpectralRange;
use crate::thermal::network::{
    ExchangeFactors, HeatBalance, HeatProblem, SurfaceBand, exchange_factors, heat_balance,
};
use crate::thermal::tables::{Conditions, Properties};
use azulejo_trace::Progress;

/// Temperature of sky and ground that nobody gives: that of space, K.
pub const DEEP_SPACE: f64 = 3.0;

/// What a row may lack of 1, or have too much, without a word.
const UNBALANCED: f64 = 0.01;

/// Standard errors of a sum beyond which it is not off by noise.
const FAR: f64 = 6.0;

/// Mirror reflectances, and other properties of one node, that differ by less count as equal.
pub const SAME: f64 = 1e-6;

/// Surfaces with their factors and properties.
#[derive(Clone, Debug)]
pub struct ThermalModel {
    /// Factors of the same rows with the names by which errors call them: one matrix for each set of mirror
    /// reflectances that bands have.
    pub matrices: Vec<(String, Enclosure)>,
    /// The bands with the properties of each row; their wavelengths do not overlap.
    pub bands: Vec<(SpectralRange, Vec<Properties>)>,
    /// Temperatures and fluxes; none if only the networks are wanted.
    pub conditions: Option<Conditions>,
    /// Temperatures of sky and ground, K; [`DEEP_SPACE`] where there is none.
    pub surroundings: [Option<f64>; 2],
    /// What is one node; each row if none.
    pub nodes: Option<GroupBy>,
    /// Whether the rows of a node are combined before the exchange is solved, so that each node has one
    /// radiosity, as network programs do; otherwise rows are solved and their exchange is added up.
    pub lump: bool,
}

/// The network of a band.
pub type BandNetwork = (SpectralRange, ExchangeFactors);

/// What a thermal model gives.
#[derive(Clone, Debug)]
pub struct ThermalSolution {
    /// The factors that were used first.
    pub enclosure: Enclosure,
    /// The nodes of its rows.
    pub nodes: Groups,
    /// Each band in which surfaces emit, with its network.
    pub networks: Vec<BandNetwork>,
    /// Temperatures and fluxes, if there were conditions.
    pub heat: Option<HeatBalance>,
    /// Temperatures of sky and ground, K.
    pub surroundings: [f64; 2],
    /// What the user should know: sentences without full stops.
    pub notes: Vec<String>,
}

impl ThermalModel {
    /// Solves networks, and temperatures and fluxes if there are conditions.
    ///
    /// # Errors
    /// Matrices of different rows, mirrors that no matrix has, uneven nodes that are to be lumped, and the
    /// errors of [`exchange_factors`] and [`heat_balance`].
    ///
    /// # Panics
    /// If there is no matrix or no band, or if properties or conditions are not those of its rows.
    pub fn solve(mut self, progress: &Progress) -> Result<ThermalSolution, ModelError> {
        self.check_rows()?;
        // Choose for each band the matrix that was computed with its mirrors.
        let used = self
            .bands
            .iter()
            .map(|(range, rows)| self.matching(*range, rows))
            .collect::<Result<Vec<usize>, _>>()?;
        // Rows are combined before the exchange is solved if they are lumped, else their exchange is added up.
        let nodes = self.groups();
        let nodes = if self.lump {
            lump::lump(&mut self, &nodes, progress)?
        } else {
            nodes
        };
        let mut notes: Vec<String> = self.note_unbalanced().into_iter().collect();
        let bands: Vec<SurfaceBand> = self
            .bands
            .iter()
            .zip(&used)
            .map(|((range, rows), &k)| SurfaceBand {
                enclosure: &self.matrices[k].1,
                range: *range,
                emissivity: rows.iter().map(|p| p.emissivity).collect(),
            })
            .collect();
        // Surfaces emit nothing in the solar band, which has no network.
        let mut networks = Vec::new();
        for band in bands.iter().filter(|b| b.range != SpectralRange::Solar) {
            networks.push((band.range, exchange_factors(band, &nodes, progress)?));
        }
        // Solve for temperatures and fluxes with sky and ground, by default at the temperature of space.
        let surroundings = self.surroundings.map(|t| t.unwrap_or(DEEP_SPACE));
        let heat = match &self.conditions {
            Some(conditions) => {
                self.note_surroundings(&mut notes);
                let problem = HeatProblem {
                    bands: &bands,
                    conditions: &conditions.rows,
                    surroundings,
                    solar: &self.sunlight(&bands, conditions, &mut notes),
                };
                Some(heat_balance(&problem, &nodes, progress)?)
            }
            None => None,
        };
        Ok(ThermalSolution {
            enclosure: self.matrices.swap_remove(0).1,
            nodes,
            networks,
            heat,
            surroundings,
            notes,
        })
    }

    fn check_rows(&self) -> Result<(), ModelError> {
        let (of, first) = &self.matrices[0];
        let names = &first.rows.names;
        match self.matrices.iter().find(|(_, e)| e.rows.names != *names) {
            Some((matrix, _)) => Err(ModelError::OtherRows {
                matrix: matrix.clone(),
                of: of.clone(),
            }),
            None => Ok(()),
        }
    }

    /// The first matrix that was computed with the mirrors of a band.
    fn matching(&self, range: SpectralRange, rows: &[Properties]) -> Result<usize, ModelError> {
        let differs = |enclosure: &Enclosure| {
            let mirrors = enclosure.mirror_reflectances();
            let mut pairs = mirrors.iter().zip(rows).enumerate();
            let off = pairs.find(|(_, (a, b))| (*a - b.mirror).abs() > SAME);
            off.map(|(i, (a, b))| (i, *a, b.mirror))
        };
        let mut closest = None;
        for (k, (name, enclosure)) in self.matrices.iter().enumerate() {
            let Some((i, computed, expected)) = differs(enclosure) else {
                return Ok(k);
            };
            closest.get_or_insert_with(|| ModelError::OtherMirrors {
                matrix: name.clone(),
                row: enclosure.rows.names[i].clone(),
                computed,
                expected,
                range,
            });
        }
        Err(closest.unwrap_or(ModelError::NoMatrix))
    }

    fn groups(&self) -> Groups {
        let enclosure = &self.matrices[0].1;
        match self.nodes {
            Some(by) if !enclosure.rows.are_groups => enclosure.groups(by),
            _ => Groups {
                of_rows: (0..enclosure.len() as u32).map(Some).collect(),
                names: enclosure.rows.names.clone(),
            },
        }
    }

    /// Sunlight on each row: as given, or else of the matrix; empty if there is none.
    fn sunlight(
        &self,
        bands: &[SurfaceBand],
        conditions: &Conditions,
        notes: &mut Vec<String>,
    ) -> Vec<f64> {
        let solar_band = bands.iter().find(|b| b.range == SpectralRange::Solar);
        let lit = solar_band.map_or(&self.matrices[0].1, |band| band.enclosure);
        let outside = |i: usize| lit.outside.as_ref().map_or(0.0, |o| o[i].irradiance.mean());
        let rows = conditions.solar.iter().enumerate();
        let solar: Vec<f64> = rows.map(|(i, e)| e.unwrap_or_else(|| outside(i))).collect();
        if solar.iter().all(|&e| e <= 0.0) {
            return Vec::new();
        }
        let Some(sun) = solar_band else {
            notes.push(
                "sunlight has no effect, because no absorptance of it (alpha) is given".into(),
            );
            return Vec::new();
        };
        let mirrors = sun.enclosure.mirror_reflectances();
        let mut given = conditions.solar.iter().zip(mirrors);
        if given.any(|(e, mirror)| e.is_some_and(|e| e > 0.0) && mirror > SAME) {
            notes.push(
                "sunlight that mirrors reflect must be in what is given of the surfaces that it reaches, because \
                 its direction is not known; factors that were computed with --sun have it"
                    .into(),
            );
        }
        solar
    }

    /// The row whose factors lack most of 1, or have most too much, if heat does not balance by it.
    fn note_unbalanced(&self) -> Option<String> {
        let worst_row = |(name, enclosure): &(String, Enclosure)| {
            let residuals = enclosure.residuals();
            let noise = enclosure.noise_of_sums();
            let rows = residuals.iter().zip(&noise).enumerate();
            // What is unknown may be noise.
            let rows = rows.filter(|(_, (off, noise))| off.abs() > FAR * **noise);
            let rows = rows.map(|(row, (off, _))| (row, off));
            let (row, off) = rows.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
            let title = enclosure.rows.names.get(row).cloned().unwrap_or_default();
            Some((name.clone(), title, *off))
        };
        let worst = self.matrices.iter().filter_map(worst_row);
        let (name, row, off) = worst.max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
        (off.abs() > UNBALANCED).then(|| {
            let share = 100.0 * off.abs();
            let fault = if off > 0.0 {
                format!("lack {share:.2}% of its light")
            } else {
                format!("exceed all of its light by {share:.2}%")
            };
            format!(
                "{name}: the factors of \"{row}\" {fault}, which is more than noise, so that heat does not balance: faces \
                 that overlap count twice; closing the rows spreads what is off over all factors"
            )
        })
    }

    /// Sky and ground that are seen, and whose temperature nobody gives.
    fn note_surroundings(&self, notes: &mut Vec<String>) {
        let rest = &self.matrices[0].1.factors.rest;
        let is_seen = [
            rest.iter().any(|r| r.sky > SAME),
            rest.iter().any(|r| r.ground > SAME),
        ];
        for (k, name) in ["sky", "ground"].into_iter().enumerate() {
            if is_seen[k] && self.surroundings[k].is_none() {
                notes.push(format!(
                    "no temperature of the {name} is given: {DEEP_SPACE} K, that of space, is taken"
                ));
            }
        }
    }
}

impl ThermalSolution {
    /// Largest deviation from 1 of the sums of Gebhart factors, over nodes that emit, in one network.
    pub fn closure(network: &ExchangeFactors) -> f64 {
        let sums = network.row_sums();
        let emitting = sums
            .iter()
            .zip(&network.emitting)
            .filter(|(_, e)| **e > 0.0);
        emitting
            .map(|(sum, _)| (sum - 1.0).abs())
            .fold(0.0, f64::max)
    }

    /// Heat that rows give off in excess of what sky and ground gain and the sun brings, W: 0, but for what
    /// factors lack.
    pub fn imbalance(&self) -> Option<f64> {
        let heat = self.heat.as_ref()?;
        let unit = self.enclosure.metres_per_unit().powi(2);
        let rows = heat.fluxes.iter().zip(&heat.solar);
        let rows = rows.zip(&self.enclosure.factors.areas);
        let given_off: f64 = rows.map(|((q, sun), area)| (q + sun) * area * unit).sum();
        Some(given_off - heat.to_surroundings.iter().sum::<f64>())
    }
}
