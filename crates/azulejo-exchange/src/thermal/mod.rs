//! Heat between surfaces: who absorbs what others emit, and which temperatures and fluxes follow.
//!
//! All of this needs an [`Enclosure`](crate::Enclosure) and the text of its files; nothing in
//! [`enclosure`](crate::enclosure), [`archive`](crate::archive) and [`files`](crate::files) needs it.
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`bands`] | bands of wavelengths, and black emission in them |
//! | [`network`] | Gebhart factors, conductances, temperatures and fluxes |
//! | [`tables`] | tables of materials and boundary conditions |
//! | [`model`] | all of this together: properties and conditions in, networks and temperatures out |
//! | [`conductances`] | networks as files of thermal programs |

pub mod bands;
pub mod conductances;
pub mod model;
pub mod network;
pub mod tables;

pub use bands::{SpectralRange, band_fraction};
pub use model::{ModelError, ThermalModel, ThermalSolution};
pub use network::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, RowCondition, SurfaceBand,
    exchange_factors, heat_balance,
};
