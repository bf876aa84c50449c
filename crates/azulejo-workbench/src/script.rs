//! Sessions that play by themselves: a list of steps, one a line.
//!
//! ```text
//! # A model, a lamp, two materials, light, a file and a picture.
//! size 1280 800
//! open cow.3ds
//! action Area light
//! select cow
//! material brdf ward_duer ks=0.3 kd=0.4 ax=0.1 ay=0.3
//! solve 5%
//! shading irradiance
//! screenshot lit.png
//! save lit.grf
//! ```
//!
//! Steps that start a job wait until it ends. A step that fails ends the script, and the command
//! with status 1.

mod parse;
mod play;

pub use parse::{ScriptStep, parse};
pub use play::ScriptPlayer;
