//! The table of formats.

use std::path::Path;

/// A file format of matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorFormat {
    /// Sparse arrays.
    Npz,
    /// One line per entry.
    Csv,
    /// View3D's output as text.
    View3d,
    /// View3D's output in binary.
    View3dBinary,
    /// Polygons with arrays, for VTK.
    Vtu,
    /// Files of a case of OpenFOAM, as text.
    OpenFoam,
    /// The same in binary.
    OpenFoamBinary,
    /// Input of EnergyPlus.
    EnergyPlus,
    /// The same as JSON.
    EnergyPlusJson,
    /// Files of an experiment of uDALES.
    Udales,
    /// CalculiX's `.vwf`.
    CalculiX,
    /// Elmer's `ViewFactors.dat` as text.
    Elmer,
    /// The same in binary.
    ElmerBinary,
    /// A block of MOOSE's input.
    Moose,
    /// `RADLST` and `RADMTX` with cavities.
    Nastran,
    /// `RADLST` and `RADMTX` of NASTRAN-95.
    NastranClassic,
    /// Coordinates of a sparse matrix.
    MatrixMarket,
}

/// What users see of a format.
#[derive(Clone, Copy, Debug)]
pub struct FormatEntry {
    /// The format.
    pub format: FactorFormat,
    /// Its name on command lines and in Python.
    pub name: &'static str,
    /// Extensions that mean it, in small letters.
    pub extensions: &'static [&'static str],
    /// What it is, in a few words.
    pub about: &'static str,
}

/// All formats.
#[rustfmt::skip]
const FORMATS: [FormatEntry; 17] = {
    use FactorFormat as F;
    const fn entry(
        format: FactorFormat,
        name: &'static str,
        extensions: &'static [&'static str],
        about: &'static str,
    ) -> FormatEntry {
        FormatEntry { format, name, extensions, about }
    }
    [
        entry(F::Npz, "npz", &["npz"], "Sparse, for NumPy and SciPy"),
        entry(F::Csv, "csv", &["csv"], "One line per entry"),
        entry(F::View3d, "view3d", &["txt", "vf"], "View3D's output as text"),
        entry(F::View3dBinary, "view3d-binary", &[], "View3D's output in binary"),
        entry(F::Vtu, "vtu", &["vtu"], "Polygons with arrays, for ParaView, VTK and meshio"),
        entry(F::OpenFoam, "openfoam", &[], "F, globalFaceFaces, finalAgglom and mapDist in an OpenFOAM case; the output is its folder"),
        entry(F::OpenFoamBinary, "openfoam-binary", &[], "The same in binary"),
        entry(F::EnergyPlus, "energyplus", &["idf"], "EnergyPlus: ZoneProperty:UserViewFactors:BySurfaceName"),
        entry(F::EnergyPlusJson, "energyplus-json", &["epjson"], "The same as epJSON"),
        entry(F::Udales, "udales", &[], "vfsparse.inp.NNN and its companions; the output is vfsparse.inp.NNN"),
        entry(F::CalculiX, "calculix", &["vwf"], "CalculiX: *VIEWFACTOR, READ"),
        entry(F::Elmer, "elmer", &["dat"], "Elmer's ViewFactors.dat as text"),
        entry(F::ElmerBinary, "elmer-binary", &[], "Elmer's ViewFactors.dat in binary"),
        entry(F::Moose, "moose", &["i"], "A block of MOOSE's input: ConstantViewFactorSurfaceRadiation"),
        entry(F::Nastran, "nastran", &["bdf"], "RADLST and RADMTX of Nastran, by cavity"),
        entry(F::NastranClassic, "nastran-95", &[], "RADLST and RADMTX of NASTRAN-95"),
        entry(F::MatrixMarket, "matrix-market", &["mtx"], "Matrix Market coordinates"),
    ]
};

impl FactorFormat {
    /// All formats with what users see of them.
    pub fn table() -> &'static [FormatEntry] {
        &FORMATS
    }

    fn entry(self) -> &'static FormatEntry {
        let entry = FORMATS.iter().find(|e| e.format == self);
        // A test asserts that the table is complete.
        entry.unwrap_or(&FORMATS[0])
    }

    /// Its name on command lines and in Python.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The format of a name.
    pub fn from_name(name: &str) -> Option<FactorFormat> {
        let entry = FORMATS.iter().find(|e| e.name == name);
        entry.map(|e| e.format)
    }

    /// The format that a file's name means, by its extension, or by the name itself where programs
    /// demand one (`vfsparse.inp.001`); letters may be large or small.
    pub fn from_path(path: &Path) -> Option<FactorFormat> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        if name.starts_with("vfsparse.inp.") {
            return Some(FactorFormat::Udales);
        }
        let (_, extension) = name.rsplit_once('.')?;
        let entry = FORMATS.iter().find(|e| e.extensions.contains(&extension));
        entry.map(|e| e.format)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn formats_are_known_by_name_and_extension() {
        for (name, format) in [
            ("a/b.NPZ", Some(FactorFormat::Npz)),
            ("b.vf", Some(FactorFormat::View3d)),
            ("room.epJSON", Some(FactorFormat::EnergyPlusJson)),
            ("x/vfsparse.inp.042", Some(FactorFormat::Udales)),
            ("ViewFactors.dat", Some(FactorFormat::Elmer)),
            ("npz", None),
            ("a.obj", None),
            ("/", None),
        ] {
            assert_eq!(FactorFormat::from_path(Path::new(name)), format, "{name}");
        }
    }

    #[test]
    fn the_table_is_complete_and_without_doubles() {
        for entry in FactorFormat::table() {
            assert_eq!(entry.format.name(), entry.name);
            assert_eq!(FactorFormat::from_name(entry.name), Some(entry.format));
        }
        // The last of the enumeration has the last place.
        assert_eq!(FORMATS.len(), FactorFormat::MatrixMarket as usize + 1);
        for (k, entry) in FORMATS.iter().enumerate() {
            assert_eq!(entry.format as usize, k, "{}", entry.name);
        }
        let extensions: Vec<_> = FORMATS.iter().flat_map(|e| e.extensions).collect();
        let different: HashSet<_> = extensions.iter().collect();
        assert_eq!(different.len(), extensions.len());
    }
}
