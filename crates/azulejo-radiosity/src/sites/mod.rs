//! Irradiance at many sites from that at some of them, such as texels of a lightmap.
//!
//! Sites are divided into [cells](SiteCells) with a *node* each, at which indirect light is gathered; direct light
//! is found at every site. In this order:
//!
//! | module | purpose |
//! |---|---|
//! | `cells` | what each kind of sites says: where they are, which are neighbours |
//! | `light` | what is found at sites and nodes |
//! | `least_squares` | the value between nodes |
//! | `nodes` | nodes with their light, its interpolation, and the error of that |
//! | `correction` | light that is read at the ends of rays, corrected by a few paths |
//! | `rays` | how many rays each node gets |
//! | `gather` | the whole: a first look, further ones, and as many nodes and rays as an error takes |

mod cells;
mod correction;
mod gather;
mod least_squares;
mod light;
mod nodes;
mod rays;

pub use cells::SiteCells;
pub use gather::{
    IndirectGoal, LookGather, PairGather, SiteStatistics, first_look, look_again, with_indirect,
};
pub use least_squares::plane_weights;
pub use light::{SiteDirect, SiteLight};
pub use nodes::{interpolated_direct, interpolated_signed};
