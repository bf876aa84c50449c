//! Radiative exchange between surfaces, from their form factors.
//!
//! An [`Enclosure`] is a matrix of form factors together with its rows: their names, corners and
//! reflectances. It needs no scene, and is what [`archive`] stores in an `.npz` and reads again.
//!
//! | read in this order | purpose |
//! |---|---|
//! | [`enclosure`] | form factors with a description of their rows, grouped by face, object, material or place |
//! | [`archive`] | the same as an `.npz` |
//! | [`store`] | the same as a store of chunks (Zarr), for matrices larger than memory |
//! | [`bands`] | bands of wavelengths, and black emission in them |
//! | [`tables`] | tables of materials and boundary conditions |
//! | [`network`] | Gebhart factors, conductances, temperatures and fluxes |
//! | [`model`] | all of this together: properties and conditions in, networks and temperatures out |
//! | [`files`] | files of other programs |

pub mod archive;
pub mod bands;
pub mod enclosure;
pub mod files;
pub mod model;
pub mod network;
pub mod store;
pub mod tables;

pub use bands::{SpectralRange, band_fraction};
pub use enclosure::{
    CellMesh, ClusterError, ClusterOptions, Enclosure, GroupBy, Groups, OutsideLight, RowTable,
};
pub use model::{ModelError, ThermalModel, ThermalSolution};
pub use network::{
    ExchangeError, ExchangeFactors, HeatBalance, HeatProblem, RowCondition, SurfaceBand,
    exchange_factors, heat_balance,
};
