//! VRML 1.0: triangles and box as Coin has them.

use super::Quantity::{Bounds, Triangles};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &[
        "wrl/castle/castle/old/vrml_1/",
        "wrl/castle/vrml_1/",
        "wrl/coin/",
    ],
    compared: &[(Triangles, &["second_triangles"]), (Bounds, &["second"])],
    allowed: &[],
    exceptions: &[],
};
