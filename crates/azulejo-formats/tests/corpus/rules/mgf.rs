//! MGF: counts of the statements in the file itself. Each is counted once, so files read several
//! times, by arrays or by other files, and tessellated surfaces differ.

use super::Quantity::Faces;
use super::{Exception, Expected, Rules};

/// A file with more polygons than `f` and `prism` statements: `faces`, because of `why`.
const fn unfolded(path: &'static str, faces: usize, why: &'static str) -> Exception {
    Exception {
        path,
        quantity: Faces,
        expected: Expected::Count(faces),
        why,
    }
}

pub const RULES: Rules = Rules {
    folders: &["mgf/"],
    compared: &[(Faces, &["raw_faces"])],
    allowed: &[
        ("mgf/hospital/main.mgf", "mgf"),
        ("mgf/hospital/structure.mgf", "mgf"),
        ("mgf/hospital/hosp.mgf", "mgf"),
    ],
    exceptions: &[
        unfolded(
            "mgf/corridor.mgf",
            1590,
            "arrays make 57 lamps: 67 f, tubes of 32 and 19 sides, a torus of 64 × 23",
        ),
        unfolded(
            "mgf/examp1.mgf",
            198,
            "arrays make 98 f, 4 prisms of 17 faces, 2 tubes of 16 sides",
        ),
        unfolded(
            "mgf/hospital/coatrack.mgf",
            869,
            "41 cyl, 11 cone and 1 ring",
        ),
        unfolded(
            "mgf/hospital/hosp.mgf",
            6697,
            "two of everything: it includes structure.mgf and all that this includes again",
        ),
        unfolded(
            "mgf/hospital/lampi2.mgf",
            119,
            "83 f, 2 tubes of 16 sides, 4 discs",
        ),
        unfolded(
            "mgf/hospital/main.mgf",
            3443,
            "57 files included: 2,574 f, and 869 polygons of coatrack.mgf",
        ),
        unfolded("mgf/hospital/mug.mgf", 714, "10 cyl, 3 cone and 3 ring"),
        unfolded(
            "mgf/hospital/structure.mgf",
            3443,
            "the same file as main.mgf",
        ),
        unfolded(
            "mgf/office3/office.mgf",
            2561,
            "319 f, 114 cyl, 16 cone and 13 ring",
        ),
    ],
};
