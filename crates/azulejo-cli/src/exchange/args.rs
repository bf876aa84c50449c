//! Arguments of `exchange`.

use crate::form_factors::args::ComputationArgs;
use crate::input::{ClockArgs, InputArgs};
use crate::values;
use azulejo_exchange::GroupBy;
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;

/// `exchange`
#[derive(Debug, Args)]
pub struct ExchangeArgs {
    /// Table of emissivities: CSV, TSV or TOML with name, eps, and where needed rho_s, alpha,
    /// eps@8-14 (micrometres)
    #[arg(long, value_name = "TABLE", value_hint = ValueHint::FilePath)]
    pub materials: PathBuf,
    /// Table of temperatures and fluxes: name, and T (K) or T_C (°C) or q (W/m², 0: adiabatic), and
    /// where needed solar (incident solar irradiance, W/m²); also for space, sky and ground
    #[arg(long, value_name = "TABLE", value_hint = ValueHint::FilePath)]
    pub boundary: Option<PathBuf>,
    /// Output files, by their extension: .npz (all of it), .csv, .esatan and .sinda (conductances; with
    /// --boundary .csv has temperatures and heat), .vtu (with --boundary); `-` writes CSV
    #[arg(long, short, required = true, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Vec<PathBuf>,
    /// What forms a node of the network
    #[arg(long, value_name = "NODE", value_enum, default_value_t = NodeName::Object)]
    pub by: NodeName,
    /// Combine the rows of a node before the exchange is solved, so that each node has one radiosity, as
    /// network programs do; otherwise rows are solved and their exchange is added up
    #[arg(long)]
    pub lump: bool,
    /// Count energy that ends on back sides, or is cut off between mirrors, as lost to the sky
    #[arg(long)]
    pub lost_to_sky: bool,
    /// Name of the model in .esatan, of the submodel in .sinda
    #[arg(long, value_name = "NAME", default_value = "")]
    pub model: String,
    /// Multiply conductances in .sinda by the Stefan-Boltzmann constant
    #[arg(long)]
    pub sigma: bool,
    /// Leave out of lists the conductances below this fraction of the smaller node's emitting area
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub truncate: Option<f64>,
    #[command(flatten)]
    pub computation: ComputationArgs,
    #[command(flatten)]
    pub clock: ClockArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// Nodes of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NodeName {
    /// Each row of the matrix
    Row,
    /// Faces of objects
    Face,
    /// Objects
    Object,
    /// Materials
    Material,
}

impl NodeName {
    /// The groups; none for rows.
    pub fn groups(self) -> Option<GroupBy> {
        match self {
            NodeName::Row => None,
            NodeName::Face => Some(GroupBy::Face),
            NodeName::Object => Some(GroupBy::Object),
            NodeName::Material => Some(GroupBy::Material),
        }
    }
}

/// Examples and notes below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo exchange room.obj --materials optics.csv -o gr.csv
  azulejo form-factors satellite.stl -o f.npz --materials optics.csv --closure
  azulejo exchange f.npz --materials optics.csv -o gr.esatan -o gr.npz
  azulejo exchange f.npz --materials optics.csv --boundary temperatures.csv -o heat.csv -o heat.vtu

optics.csv:                     temperatures.csv:
  name,eps,rho_s                  name,T,q
  panel,0.85,0                    panel,320,
  radiator,0.05,0.9               *,,0
  *,0.8,0                         space,3,

SCENE is a model, whose factors are computed first, once for each set of mirrors that bands have; or
factors that form-factors wrote (.npz). Several .npz of the same rows are for bands with other mirrors:
each band takes the first whose mirrors are its own.

Q from a to b is sigma GR_ab (T_a^4 - T_b^4), with GR_ab = eps_a A_a B_ab in square metres. The mirrors of
the table must be in an .npz already: form-factors takes the same table. docs/exchange.md defines all quantities.";
