//! Radiative exchange between surfaces, from their form factors.
//!
//! An [`Enclosure`] is a matrix of form factors together with its rows: their names, corners and
//! reflectances. It needs no scene, and is what [`archive`] stores in an `.npz` and reads again.
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`enclosure`] | form factors with a description of their rows, grouped by face, object, material or place |
//! | [`archive`] | the same as an `.npz` |
//! | [`files`] | files of other programs |
//! | [`points`] | what points see |
//! | [`thermal`] | networks, temperatures and fluxes |
//! | [`daylight`] | irradiance at points in all hours of a year |

pub mod archive;
pub mod daylight;
pub mod enclosure;
pub mod files;
pub mod points;
pub mod thermal;

pub use enclosure::{
    CellMesh, ClusterError, ClusterOptions, Enclosure, GroupBy, Groups, OutsideLight, RowTable,
};
pub use thermal::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, ModelError, RowCondition,
    SpectralRange, SurfaceBand, ThermalModel, ThermalSolution, band_fraction, exchange_factors,
    heat_balance,
};
