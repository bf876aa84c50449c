//! Arguments of `form-factors`.

use crate::engine::EngineArgs;
use crate::first_pass::DivisionArgs;
use crate::input::{ClockArgs, InputArgs};
use crate::parts::PartArgs;
use crate::values;
use azulejo::periods::Periods;
use azulejo_exchange::archive::ArchivePrecision;
use azulejo_exchange::files::FactorFormat;
use azulejo_exchange::files::openfoam::OpenFoamVersion;
use azulejo_factors::Closure;
use azulejo_scene::sky::SkyDivision;
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum, ValueHint};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::LazyLock;

/// `form-factors`
#[derive(Debug, Args)]
pub struct FormFactorArgs {
    /// Output file, its format chosen by extension: .npz (for scipy.sparse.load_npz), .csv, .vtu and
    /// others; `-` writes CSV to standard output
    ///
    /// Also View3D's .txt and .vf (text or binary as its input specifies), .idf, .epjson, .vwf, .bdf, .mtx:
    /// see --format. For OpenFOAM, the folder of a case.
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: PathBuf,
    /// Output format, regardless of the extension
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub format: Option<FormatName>,
    /// Table of emissivities and mirror reflectances (name, eps, rho_s), as for `exchange`, instead
    /// of the model's materials
    #[arg(long, value_name = "TABLE", value_hint = ValueHint::FilePath)]
    pub materials: Option<PathBuf>,
    /// Write no journal next to the output; an interrupted computation then starts over
    #[arg(long, conflicts_with = "part")]
    pub no_journal: bool,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub computation: ComputationArgs,
    #[command(flatten)]
    pub matrix: MatrixArgs,
    #[command(flatten)]
    pub from: FromArgs,
    #[command(flatten)]
    pub programs: ProgramArgs,
    #[command(flatten)]
    pub clock: ClockArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// How factors are computed.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Computation")]
pub struct ComputationArgs {
    #[command(flatten)]
    pub division: DivisionArgs,
    /// Rays per patch; makes --engine auto choose rays [default: 4096, or planned for the groups of --by]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rays: Option<u32>,
    /// RMS error of row sums that the analytic engine has to reach before closure: 1e-12 to 0.01
    /// [default: 1e-11 for up to 32 rows, otherwise 5e-5, or 3e-4 where that takes long and --engine is auto]
    ///
    /// Below 1e-6 every pair is exact to about that.
    #[arg(long, value_name = "SHARE", value_parser = values::tolerance)]
    pub tolerance: Option<f64>,
    /// Add the back sides of all faces as further patches
    #[arg(long)]
    pub two_sided: bool,
    /// Repeat the model periodically along these axes: `x,y`, or `x=96,y=64` with the period in the
    /// model's units if it is not the size of the model. Computed by rays
    #[arg(long, value_name = "AXIS[=LENGTH],...", value_parser = Periods::from_str)]
    pub periodic: Option<Periods>,
    /// Seed of the random numbers; the same seed gives the same result
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Memory limit; work that is estimated to need more is refused before it begins
    /// [default: the machine's memory]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub memory: Option<u64>,
    /// Replace the engine's results by closed-form solutions for close pairs and pairs with
    /// emitters; with `never`, the matrix holds the engine's results alone, and closure is enforced
    /// only on request
    #[arg(long, value_name = "WHEN", value_enum, default_value_t = FormulasName::Auto,
          help_heading = "Matrix")]
    pub formulas: FormulasName,
    /// Enforce closure: adjust pairs in proportion to their variances so that rows sum to 1 (in open
    /// scenes with sky and ground) [default: closed; never with --formulas=never]
    #[arg(long, value_name = "WHEN", value_enum, num_args = 0..=1, require_equals = true,
          default_missing_value = "always", help_heading = "Matrix")]
    pub closure: Option<ClosureName>,
    #[command(flatten)]
    pub engine: EngineArgs,
}

/// Output formats, by the names of their table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatName(pub FactorFormat);

impl ValueEnum for FormatName {
    fn value_variants<'a>() -> &'a [FormatName] {
        static NAMES: LazyLock<Vec<FormatName>> = LazyLock::new(|| {
            let table = FactorFormat::table().iter();
            table.map(|entry| FormatName(entry.format)).collect()
        });
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let mut table = FactorFormat::table().iter();
        let entry = table.find(|entry| entry.format == self.0)?;
        Some(PossibleValue::new(entry.name).help(entry.about))
    }
}

/// What files of other programs need to know.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Files of other programs")]
pub struct ProgramArgs {
    /// Rows whose factors a .vtu also shows, as arrays F_from_NAME
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub vtu_rows: Vec<String>,
    /// The zone, space or enclosure of EnergyPlus [default: Zone]
    #[arg(long, value_name = "NAME")]
    pub zone: Option<String>,
    /// The version of OpenFOAM that reads the files: v1912 (or earlier), v2312 (or later), or org
    /// [default: that of the environment, or of polyMesh/boundary]
    #[arg(long, value_name = "VERSION", value_parser = openfoam_version)]
    pub openfoam: Option<OpenFoamVersion>,
    /// The version of CalculiX that reads the file, and accepts no other [default: 2.20]
    #[arg(long, value_name = "VERSION")]
    pub calculix: Option<String>,
}

fn openfoam_version(word: &str) -> Result<OpenFoamVersion, String> {
    let version = OpenFoamVersion::from_word(word);
    version.ok_or_else(|| "expected v1912 (or earlier), v2312 (or later) or org".to_owned())
}

/// Operations on the matrix between patches.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Matrix")]
pub struct MatrixArgs {
    /// One row per face, object or material instead of per patch
    ///
    /// Without --patches, --patch-size, --rays and --patch-points, division and rays are planned for the
    /// groups: flat faces stay whole or nearly so, and each group has enough rays.
    #[arg(long, value_name = "GROUP", value_enum)]
    pub by: Option<GroupBy>,
    /// Merge neighbouring patches of one object, side and material until N rows are left
    ///
    /// Rows are then clusters, named object/0, object/1, ... Each is one piece without holes, and the
    /// smallest joins a neighbour first, so that areas are about equal. More are left where no more can be
    /// joined: parts that do not touch, bends beyond --cluster-angle, rings. For OpenFOAM clusters consist of
    /// whole faces.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..),
          conflicts_with = "by")]
    pub cluster: Option<u32>,
    /// Largest angle between the normals of a cluster and of each of its patches, in degrees: 0 (flat
    /// clusters) to 180
    #[arg(long, value_name = "DEGREES", value_parser = values::angle, default_value_t = 30.0,
          requires = "cluster")]
    pub cluster_angle: f64,
    /// Drop pairs whose form factors are both below this fraction, and distribute their weight over
    /// the others; row sums and reciprocity are preserved
    #[arg(long, value_name = "SHARE", value_parser = values::fraction)]
    pub truncate: Option<f64>,
    /// Precision of the factors in an .npz: 64 bits for up to 4 million entries, otherwise 32
    /// (auto), or always single (32) or double (64)
    #[arg(long, value_name = "BITS", value_enum, default_value_t = PrecisionName::Auto)]
    pub precision: PrecisionName,
    /// Write the matrix as blocks between clusters of patches, in an .npz of a few per cent of its size;
    /// TOL, such as 1e-3, is the error of a product with it
    ///
    /// The error is relative to the largest product that there could be. By rays, and if it would not
    /// fit, the whole matrix never exists.
    #[arg(long, value_name = "TOL", value_parser = values::compression)]
    pub compress: Option<f64>,
    /// Also write the parts of each form factor: direct, by way of one mirror, and of more mirrors
    /// or glass
    #[arg(long)]
    pub separate: bool,
    /// Also write what each row, or point, sees of patches of the sky, in an .npz or a .csv: `tregenza` for 145 patches,
    /// `reinhart:2` for 577, `reinhart:4` for 2,305
    ///
    /// Columns are in the order of Radiance's gendaymtx, the ground first; the others add up to what escapes to the
    /// sky, mirrors and glass included. North is that of --north.
    #[arg(long, value_name = "DIVISION", value_parser = SkyDivision::from_str)]
    pub sky_patches: Option<SkyDivision>,
}

/// What points see, instead of the matrix.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "From points")]
pub struct FromArgs {
    /// Write what points see of objects (or of the groups of --by), sky and ground instead of the matrix, as .csv or
    /// .npz: text (x y z of a small globe, or x y z nx ny nz of an element, per line), or .npy
    ///
    /// A globe weighs all directions alike, an element by the cosine to its normal. By --rays rays from each.
    #[arg(long, value_name = "POINTS", value_hint = ValueHint::FilePath, conflicts_with_all =
          ["cluster", "truncate", "compress", "separate", "closure", "part"])]
    pub from: Option<PathBuf>,
    /// Replace each globe by the six faces of a small cube, along the axes: plane radiant temperatures
    #[arg(long, requires = "from")]
    pub six_directions: bool,
    /// Also write the radiant temperature of each point, from a table of those of surfaces: name, T (K) or T_C (°C), also
    /// for sky, ground, or space for both
    #[arg(long, value_name = "TABLE", requires = "from", value_hint = ValueHint::FilePath)]
    pub temperatures: Option<PathBuf>,
}

/// Groups of patches that become one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GroupBy {
    /// Faces of objects
    Face,
    /// Objects
    Object,
    /// Materials
    Material,
}

impl From<GroupBy> for azulejo_exchange::GroupBy {
    fn from(by: GroupBy) -> azulejo_exchange::GroupBy {
        match by {
            GroupBy::Face => azulejo_exchange::GroupBy::Face,
            GroupBy::Object => azulejo_exchange::GroupBy::Object,
            GroupBy::Material => azulejo_exchange::GroupBy::Material,
        }
    }
}

impl FormFactorArgs {
    /// The groups whose factors alone are written: not the shapes of their patches, as VTK's files have them.
    pub fn only_groups(&self) -> Option<azulejo_exchange::GroupBy> {
        let by = self
            .matrix
            .by
            .filter(|_| self.file_format() != Some(FactorFormat::Vtu));
        by.map(Into::into)
    }

    /// Scenes in which closure is enforced, if that was said: all for uDALES, which checks it.
    pub fn closure(&self) -> Option<ClosureName> {
        let is_checked = self.file_format() == Some(FactorFormat::Udales);
        let default = is_checked.then_some(ClosureName::Always);
        self.computation.closure.or(default)
    }

    /// The format of the output, as chosen or by its name.
    pub fn file_format(&self) -> Option<FactorFormat> {
        let format = self.format.map(|name| name.0);
        format.or_else(|| FactorFormat::from_path(&self.output))
    }
}

/// Exactness of an archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrecisionName {
    /// 64 bits for up to 4 million entries, 32 beyond
    Auto,
    /// 32 bits
    Single,
    /// 64 bits
    Double,
}

impl From<PrecisionName> for ArchivePrecision {
    fn from(name: PrecisionName) -> ArchivePrecision {
        match name {
            PrecisionName::Auto => ArchivePrecision::Auto,
            PrecisionName::Single => ArchivePrecision::Single,
            PrecisionName::Double => ArchivePrecision::Double,
        }
    }
}

impl ComputationArgs {
    /// Whether division and samples are left to the program.
    pub fn is_planned(&self) -> bool {
        let division = &self.division;
        let is_divided = division.patches.is_some() || division.patch_size.is_some();
        !is_divided && self.rays.is_none() && self.engine.patch_points.is_none()
    }

    /// When closure is enforced.
    pub fn closure(&self) -> Closure {
        match (self.closure, self.formulas) {
            (Some(name), _) => name.into(),
            (None, FormulasName::Auto) => Closure::Closed,
            (None, FormulasName::Never) => Closure::Never,
        }
    }
}

/// Pairs that closed forms compute, whatever the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormulasName {
    /// Close pairs and pairs with emitters, where the formula has the smaller standard error
    Auto,
    /// None
    Never,
}

/// Scenes in which closure is enforced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ClosureName {
    /// In no scene
    Never,
    /// In closed scenes without mirrors and glass
    Closed,
    /// In all scenes
    Always,
}

impl From<ClosureName> for Closure {
    fn from(name: ClosureName) -> Closure {
        match name {
            ClosureName::Never => Closure::Never,
            ClosureName::Closed => Closure::Closed,
            ClosureName::Always => Closure::Always,
        }
    }
}

/// Examples and notes below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo form-factors room.obj -o f.npz --patches 2000 --rays 4096
  azulejo form-factors room.obj -o f.csv --patch-size 0 --by object --closure
  azulejo form-factors room.vs3 -o f.txt
  azulejo form-factors car.obj -o car.npz --cluster 500
  azulejo form-factors street.obj -o f.npz --by face --truncate 0.01% --memory 8G
  azulejo form-factors city.stl -o vfsparse.inp.001 --by face --periodic x,y
  azulejo form-factors room.obj -o room.vtu --vtu-rows floor/0
  azulejo form-factors zone.obj -o zone.idf --by object --zone Room --closure
  azulejo form-factors city.obj -o part-3 --shard 3/64
  azulejo form-factors city.obj -o f.npz --patches 100000 --rays 1024 --compress 1e-3
  azulejo form-factors room.obj -o seen.csv --from desk.txt
  python3 -c 'import scipy.sparse as s; print(s.load_npz(\"f.npz\").sum(axis=1))'

The entry in row i, column j is the share of the light leaving patch i diffusely that arrives at
patch j, with its standard error. Patches emit and receive on their front side and block light from
both. Light that leaves the scene upwards and downwards is in rows to \"sky\" and \"ground\" of a
CSV, and in arrays of these names of an .npz.

After an interruption, the same command resumes: completed work is kept in FILE.journal until FILE
is complete. docs/form-factors.md describes files, errors, closure and truncation.";
