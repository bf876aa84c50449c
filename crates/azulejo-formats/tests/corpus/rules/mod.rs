//! The columns compared for each format, and where and why azulejo differs.
//!
//! One file per format with `pub const RULES: Rules`; [`ALL`] lists them.

mod dxf;
mod gltf;
mod mgf;
mod obj;
mod openflight;
mod ply;
mod stl;
mod studio3ds;
mod vrml;
mod vrml1;
mod x3d;

use crate::counts::Counts;
use crate::truth::Row;

/// Every format that is compared.
const ALL: &[&Rules] = &[
    &dxf::RULES,
    &gltf::RULES,
    &mgf::RULES,
    &obj::RULES,
    &openflight::RULES,
    &ply::RULES,
    &stl::RULES,
    &studio3ds::RULES,
    &vrml1::RULES,
    &vrml::RULES,
    &x3d::RULES,
];

/// The rules for a file of the corpus, by its folder; the first match applies.
pub fn of(path: &str) -> Option<&'static Rules> {
    let has = |rules: &&&Rules| rules.folders.iter().any(|f| path.starts_with(f));
    ALL.iter().find(has).copied()
}

/// What is compared in the files of a format.
pub struct Rules {
    /// Path prefixes to which the rules apply: `"3ds/"`.
    pub folders: &'static [&'static str],
    /// Quantities, each with the columns of the reference table that it must equal: the first
    /// non-empty one in the file's row is used; if all are empty, nothing is compared.
    pub compared: &'static [(Quantity, &'static [&'static str])],
    /// Files that refer to files outside their folder, with the additional folder of the corpus
    /// that is allowed.
    pub allowed: &'static [(&'static str, &'static str)],
    /// Where azulejo differs.
    pub exceptions: &'static [Exception],
}

/// Quantities that can be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Placed meshes and primitives.
    Objects,
    /// Sum of the objects' vertices.
    Vertices,
    /// Distinct positions of each object and material; compared only if there are as many such
    /// pairs as the column `assimp_meshes` states.
    Positions,
    /// Polygons.
    Faces,
    /// Triangles after triangulation of the polygons.
    Triangles,
    /// The bounding box of everything, to 1e-4 of its size. Columns are `assimp`, `second` or
    /// `third`; with the suffix ` turned`, a file with z up that the program has rotated to y up.
    Bounds,
}

/// One quantity of one file that differs from the columns.
pub struct Exception {
    pub path: &'static str,
    pub quantity: Quantity,
    pub expected: Expected,
    /// Why azulejo is right, or which reference it follows.
    pub why: &'static str,
}

/// The correct result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// This count.
    Count(usize),
    /// The value of another column.
    Column(&'static str),
    /// This bounding box: least and greatest corner.
    Box([f64; 3], [f64; 3]),
    /// The file is rejected, whatever the quantity.
    Refused,
    /// There are no surfaces, and a warning reports it.
    Nothing,
}

impl Rules {
    /// The exceptions for a file.
    pub fn about<'a>(&'a self, path: &'a str) -> impl Iterator<Item = &'a Exception> {
        self.exceptions.iter().filter(move |e| e.path == path)
    }

    /// A folder from which a file may read besides its own.
    pub fn allowed(&self, path: &str) -> Option<&'static str> {
        let entry = self.allowed.iter().find(|(file, _)| *file == path);
        entry.map(|(_, folder)| *folder)
    }
}

impl Exception {
    /// Whether the expected result holds.
    pub fn holds(&self, counts: &Counts, row: &Row) -> Result<(), String> {
        match self.expected {
            Expected::Count(n) => equal(self.quantity, counts.get(self.quantity), n, "the rule"),
            Expected::Column(column) => agrees(counts, row, self.quantity, &[column]),
            Expected::Box(min, max) => same_box(counts, [min, max], "the rule"),
            Expected::Refused => Err("was to be refused".into()),
            Expected::Nothing if counts.objects == 0 => Ok(()),
            Expected::Nothing => Err("was to have no surfaces".into()),
        }
    }
}

impl Counts {
    fn get(&self, quantity: Quantity) -> usize {
        match quantity {
            Quantity::Objects => self.objects,
            Quantity::Vertices => self.vertices,
            Quantity::Positions => self.positions,
            Quantity::Faces => self.faces,
            Quantity::Triangles => self.triangles,
            Quantity::Bounds => unreachable!("a box is not a count"),
        }
    }
}

/// Compares a quantity with the first non-empty column.
///
/// # Errors
/// A description of the difference.
pub fn agrees(
    counts: &Counts,
    row: &Row,
    quantity: Quantity,
    columns: &[&str],
) -> Result<(), String> {
    if quantity == Quantity::Bounds {
        let said = |c: &&str| Some((row_box(row, c)?, (*c).to_owned()));
        return match columns.iter().find_map(said) {
            Some((expected, column)) => same_box(counts, expected, &column),
            None => Ok(()),
        };
    }
    if quantity == Quantity::Positions && row.count("assimp_meshes") != Some(counts.parts) {
        return Ok(());
    }
    let said = |c: &&str| Some((row.count(c)?, (*c).to_owned()));
    match columns.iter().find_map(said) {
        Some((expected, column)) => equal(quantity, counts.get(quantity), expected, &column),
        None => Ok(()),
    }
}

fn equal(quantity: Quantity, found: usize, expected: usize, source: &str) -> Result<(), String> {
    if found == expected {
        Ok(())
    } else {
        let name = format!("{quantity:?}").to_lowercase();
        Err(format!("{name} {found}, {source} says {expected}"))
    }
}

/// The bounding box in a column; `None` if it is empty.
fn row_box(row: &Row, column: &str) -> Option<[[f64; 3]; 2]> {
    let Some(column) = column.strip_suffix(" turned") else {
        return row.bounds(column);
    };
    // (x, y, z) with z up had become (x, z, −y).
    let [min, max] = row.bounds(column)?;
    Some([[min[0], -max[2], min[1]], [max[0], -min[2], max[1]]])
}

fn same_box(counts: &Counts, expected: [[f64; 3]; 2], source: &str) -> Result<(), String> {
    let found = [counts.bounds.min.to_array(), counts.bounds.max.to_array()];
    let size = counts.bounds.diagonal();
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * size + 1e-5 * a.abs();
    let pairs = found.iter().flatten().zip(expected.iter().flatten());
    if !counts.bounds.is_empty() && pairs.into_iter().all(|(&a, &b)| near(a, b)) {
        Ok(())
    } else {
        Err(format!("bounds {found:?}, {source} says {expected:?}"))
    }
}
