//! DXF: faces and the box as ezdxf has them, with blocks unfolded.

use super::Quantity::{Bounds, Faces, Triangles};
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["dxf/"],
    compared: &[
        (Faces, &["raw_faces"]),
        (Triangles, &["second_triangles"]),
        (Bounds, &["second"]),
    ],
    allowed: &[],
    exceptions: &[],
};
