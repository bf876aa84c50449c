//! MGF: what the lines of the file itself say.

use super::Quantity::Faces;
use super::Rules;

pub const RULES: Rules = Rules {
    folders: &["mgf/"],
    compared: &[(Faces, &["raw_faces"])],
    allowed: &[],
    exceptions: &[],
};
