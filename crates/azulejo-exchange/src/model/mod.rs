//! A thermal model: enclosures with the properties of a table, and nodes. The command line and Python
//! solve the same one, so that their numbers are the same to the last bit.

mod lumped;
mod results;
#[cfg(test)]
mod tests;

pub use results::{ConductanceList, ThermalResult, ThermalResultFormat};

use crate::bands::SpectralRange;
use crate::enclosure::{Enclosure, GroupBy, Groups};
use crate::network::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, SurfaceBand, exchange_factors,
    heat_balance,
};
use crate::tables::{Conditions, MaterialTable, Properties, TableError};
use azulejo_trace::Progress;
use std::fmt;
use std::sync::Arc;

/// Difference of properties that counts as none.
const SAME: f64 = 1e-6;

/// Temperature of sky and ground that nothing says: that of space, K.
pub const SPACE: f64 = 3.0;

/// Surfaces with their properties in all bands, and the nodes that they belong to.
#[derive(Clone, Debug)]
pub struct ThermalModel {
    enclosures: Vec<Arc<Enclosure>>,
    bands: Vec<ModelBand>,
    nodes: Groups,
    /// The nodes of the rows before these were combined.
    lumped: Option<Groups>,
}

/// A band of a model.
#[derive(Clone, Debug)]
struct ModelBand {
    range: SpectralRange,
    /// The number of its enclosure.
    enclosure: usize,
    emissivity: Vec<f64>,
}

/// Why surfaces, properties and nodes do not fit together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// The rows of a matrix, by number, are not those of the first.
    OtherRows(usize),
    /// Rows without a record.
    Table(TableError),
    /// No matrix was computed with the mirrors of a band.
    Mirrors {
        /// The name of a row that differs.
        row: String,
        /// Its mirror reflectance in the first matrix.
        computed: f64,
        /// The one in the table.
        asked: f64,
        /// The band.
        range: SpectralRange,
    },
    /// Rows to be combined have several values.
    Uneven {
        /// Their node.
        node: String,
        /// `eps` or `rho_s`.
        what: &'static str,
        /// The smallest and the largest.
        values: [f64; 2],
    },
    /// Rows to be combined have different temperatures or fluxes.
    UnevenConditions {
        /// Their node.
        node: String,
    },
}

impl From<TableError> for ModelError {
    fn from(error: TableError) -> ModelError {
        ModelError::Table(error)
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            ModelError::OtherRows(k) => {
                write!(f, "the rows of matrix {k} are not those of the first")
            }
            ModelError::Table(error) => error.fmt(f),
            ModelError::Mirrors {
                row,
                computed,
                asked,
                range,
            } => {
                let band = match range {
                    SpectralRange::Thermal => String::new(),
                    range => format!(" in the band {range}"),
                };
                write!(
                    f,
                    "factors were computed with mirror reflectance {computed} of \"{row}\", the table has \
                     {asked}{band}: mirrors take part in the factors, so compute these with the same table"
                )
            }
            ModelError::Uneven { node, what, values } => write!(
                f,
                "lump: the rows of \"{node}\" have {what} from {} to {}, expected one value: choose nodes \
                 that are even (by material), or do not lump",
                values[0], values[1]
            ),
            ModelError::UnevenConditions { node } => write!(
                f,
                "lump: the rows of \"{node}\" have different temperatures or fluxes"
            ),
        }
    }
}

impl std::error::Error for ModelError {}

/// The nodes of rows: groups, or each row where `by` is `None` or rows are groups already.
pub fn nodes(enclosure: &Enclosure, by: Option<GroupBy>) -> Groups {
    match by {
        Some(by) if !enclosure.rows.are_groups => enclosure.groups(by),
        _ => Groups {
            of_rows: (0..enclosure.len() as u32).map(Some).collect(),
            names: enclosure.rows.names.clone(),
        },
    }
}

/// The largest share of a row's light that ends where nothing absorbs it.
pub fn lost(enclosure: &Enclosure) -> f64 {
    let rest = enclosure.factors.rest.iter();
    rest.map(|r| r.hidden + r.cut).fold(0.0, f64::max)
}

/// Gives that light to the sky.
pub fn give_lost_to_sky(enclosure: &mut Enclosure) {
    for row in &mut enclosure.factors.rest {
        row.sky += row.hidden + row.cut;
        (row.hidden, row.cut) = (0.0, 0.0);
    }
}

impl ThermalModel {
    /// Surfaces of one or several matrices with the same rows, of which each band takes the first that
    /// was computed with its mirrors. With `lump`, the rows of a node are combined to one.
    ///
    /// # Errors
    /// [`ModelError`].
    ///
    /// # Panics
    /// If there is no enclosure, or not one node for each row.
    pub fn new(
        enclosures: Vec<Arc<Enclosure>>,
        materials: &MaterialTable,
        nodes: Groups,
        lump: bool,
    ) -> Result<ThermalModel, ModelError> {
        let first = &enclosures[0];
        let is_other = |e: &Arc<Enclosure>| e.rows.names != first.rows.names;
        if let Some(k) = enclosures.iter().position(is_other) {
            return Err(ModelError::OtherRows(k));
        }
        let properties = materials.of_rows(first)?;
        let bands = materials.bands.iter().zip(&properties);
        let band = |(band, rows): (&crate::tables::TableBand, &Vec<Properties>)| {
            Ok(ModelBand {
                range: band.range,
                enclosure: matching(&enclosures, band.range, rows)?,
                emissivity: rows.iter().map(|p| p.emissivity).collect(),
            })
        };
        let bands = bands.map(band).collect::<Result<_, ModelError>>()?;
        let model = ThermalModel {
            enclosures,
            bands,
            nodes,
            lumped: None,
        };
        if lump { model.lump() } else { Ok(model) }
    }

    /// The first matrix, whose rows are those of the model.
    pub fn enclosure(&self) -> &Arc<Enclosure> {
        &self.enclosures[0]
    }

    /// The nodes of its rows.
    pub fn nodes(&self) -> &Groups {
        &self.nodes
    }

    /// Whether sunlight has an effect.
    pub fn has_solar_band(&self) -> bool {
        self.bands.iter().any(|b| b.range == SpectralRange::Solar)
    }

    fn surface_bands(&self) -> Vec<SurfaceBand<'_>> {
        let band = |b: &ModelBand| SurfaceBand {
            enclosure: &self.enclosures[b.enclosure],
            range: b.range,
            emissivity: b.emissivity.clone(),
        };
        self.bands.iter().map(band).collect()
    }

    /// The conductances in each band but the solar one.
    ///
    /// # Errors
    /// [`ExchangeError`].
    pub fn networks(
        &self,
        progress: &Progress,
    ) -> Result<Vec<(SpectralRange, ExchangeFactors)>, ExchangeError> {
        let bands = self.surface_bands();
        let bands = bands.iter().filter(|b| b.range != SpectralRange::Solar);
        bands
            .map(|band| Ok((band.range, exchange_factors(band, &self.nodes, progress)?)))
            .collect()
    }

    /// Temperatures and fluxes. Sunlight on rows of which the conditions say none is that of the matrix.
    ///
    /// # Errors
    /// [`ExchangeError`].
    pub fn heat(
        &self,
        conditions: &Conditions,
        surroundings: [f64; 2],
        progress: &Progress,
    ) -> Result<HeatBalance, ExchangeError> {
        let bands = self.surface_bands();
        let problem = HeatProblem {
            bands: &bands,
            conditions: &conditions.rows,
            surroundings,
            solar: &self.sunlight(conditions),
        };
        heat_balance(&problem, &self.nodes, progress)
    }

    /// Sunlight on each row; empty if there is none.
    pub fn sunlight(&self, conditions: &Conditions) -> Vec<f64> {
        let outside = &self.enclosure().outside;
        let of_matrix = |i: usize| outside.as_ref().map_or(0.0, |o| o[i].irradiance.mean());
        let rows = conditions.solar.iter().enumerate();
        let solar: Vec<f64> = rows.map(|(i, e)| e.unwrap_or_else(|| of_matrix(i))).collect();
        if solar.iter().any(|&e| e > 0.0) {
            solar
        } else {
            Vec::new()
        }
    }
}

/// The first matrix that was computed with the mirrors of a band.
fn matching(
    enclosures: &[Arc<Enclosure>],
    range: SpectralRange,
    rows: &[Properties],
) -> Result<usize, ModelError> {
    let differs = |enclosure: &Enclosure| {
        let mirrors = enclosure.mirror_reflectances();
        let mut pairs = mirrors.iter().zip(rows).enumerate();
        let off = pairs.find(|(_, (a, b))| (*a - b.mirror).abs() > SAME);
        off.map(|(i, (a, b))| (i, *a, b.mirror))
    };
    let found = enclosures.iter().position(|e| differs(e).is_none());
    found.ok_or_else(|| {
        let (i, computed, asked) = differs(&enclosures[0]).unwrap_or_default();
        ModelError::Mirrors {
            row: enclosures[0].rows.names[i].clone(),
            computed,
            asked,
            range,
        }
    })
}
