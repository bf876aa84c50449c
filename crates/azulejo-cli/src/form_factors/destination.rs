//! Where a matrix is written, and in which format.

use super::args::FormFactorArgs;
use super::view3d::View3dInput;
use crate::failure::Failure;
use crate::session::Session;
use azulejo::output::{Output, commit};
use azulejo_exchange::Enclosure;
use azulejo_exchange::files::openfoam::{OpenFoamCase, OpenFoamVersion};
use azulejo_exchange::files::{FactorFiles, FactorFormat, FileOptions};
use azulejo_formats::view3d::MatrixLayout;
use std::path::{Path, PathBuf};

/// Files to be written, checked before the work begins.
pub struct Destination {
    /// The only file, or the first.
    pub output: Output,
    /// The folder of files whose names the format gives.
    folder: PathBuf,
    format: FactorFormat,
    /// Whether View3D's layout was chosen, rather than left to its input.
    has_layout: bool,
    options: FileOptions,
}

impl Destination {
    /// Finds the format, and checks that it can be written there.
    pub fn new(args: &FormFactorArgs) -> Result<Destination, Failure> {
        // The option or the name of the file gives the format; standard output has no name, and gets CSV.
        let is_stdout = args.output == Path::new("-");
        let format = match args.file_format() {
            Some(format) => format,
            None if is_stdout => FactorFormat::Csv,
            None => return Err(unknown(&args.output)),
        };
        refuse_without_effect(args, format)?;
        let mut options = FileOptions {
            precision: args.matrix.precision.into(),
            shown_rows: args.programs.vtu_rows.clone(),
            zone: args.programs.zone.clone(),
            calculix: args.programs.calculix.clone(),
            ..FileOptions::default()
        };
        // OpenFOAM and uDALES have more files, whose names the format gives within a folder.
        let mut folder = PathBuf::new();
        let file = match format {
            FactorFormat::OpenFoam | FactorFormat::OpenFoamBinary => {
                let case = open_case(args)?;
                folder.clone_from(&case.folder);
                options.case = Some(case);
                folder.join("F")
            }
            FactorFormat::Udales => {
                options.experiment = experiment(&args.output);
                folder = args.output.with_file_name("");
                args.output.clone()
            }
            _ => args.output.clone(),
        };
        // A .vf file without --format has the layout that its View3D input specifies.
        let is_vf = |path: &Path| {
            path.extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("vf"))
        };
        Ok(Destination {
            output: Output::check(&file)?,
            folder,
            format,
            has_layout: args.format.is_some() || !is_vf(&args.output),
            options,
        })
    }

    /// Writes the files of a matrix: all of them or none. Returns what was written.
    pub fn write(
        mut self,
        enclosure: &Enclosure,
        room: Option<&View3dInput>,
        session: &mut Session,
    ) -> Result<String, Failure> {
        let layout = match self.format {
            FactorFormat::View3dBinary => MatrixLayout::Binary,
            _ => MatrixLayout::Text,
        };
        self.options.view3d = room.map(|room| room.table(self.has_layout.then_some(layout)));
        let prepared = self.format.prepare(enclosure, &self.options);
        let FactorFiles { files, notes } = prepared.map_err(Failure::failed)?;
        notes.iter().for_each(|note| session.note(note));
        let (mut drafts, mut names) = (Vec::new(), Vec::new());
        for file in &files {
            let output = match file.name.as_str() {
                "" => None,
                name => Some(Output::check(&self.folder.join(name))?),
            };
            let output = output.as_ref().unwrap_or(&self.output);
            let mut draft = output.draft()?;
            file.write(&mut draft).map_err(|e| output.error(e))?;
            drafts.push(draft);
            names.push(output.path().display().to_string());
        }
        commit(drafts, session.progress())?;
        Ok(names.join(", "))
    }
}

/// Whether rows of the format are made of whole faces of the model.
pub fn wants_whole_faces(args: &FormFactorArgs) -> bool {
    use FactorFormat::{OpenFoam, OpenFoamBinary};
    matches!(args.file_format(), Some(OpenFoam | OpenFoamBinary))
}

/// Refuses what only another program's files have.
fn refuse_without_effect(args: &FormFactorArgs, format: FactorFormat) -> Result<(), Failure> {
    use FactorFormat::{CalculiX, EnergyPlus, EnergyPlusJson, Vtu};
    let programs = &args.programs;
    let is_energyplus = matches!(format, EnergyPlus | EnergyPlusJson);
    let idle = [
        (
            "--vtu-rows",
            "VTK",
            !programs.vtu_rows.is_empty() && format != Vtu,
        ),
        (
            "--zone",
            "EnergyPlus",
            programs.zone.is_some() && !is_energyplus,
        ),
        (
            "--calculix",
            "CalculiX",
            programs.calculix.is_some() && format != CalculiX,
        ),
    ];
    match idle.into_iter().find(|(.., is_idle)| *is_idle) {
        Some((option, of, _)) => Err(Failure::misuse(format_args!(
            "{option}: it applies to files for {of}, and {} is not one",
            args.output.display()
        ))),
        None => Ok(()),
    }
}

fn unknown(path: &Path) -> Failure {
    let message = if path.is_dir() {
        "a folder: --format openfoam writes to the folder of a case"
    } else {
        "unknown matrix format, expected .npz, .csv, .txt or .vf (View3D), .vtu, .idf, .epjson, .vwf, \
         .dat, .i, .bdf, .mtx or --format"
    };
    Failure::misuse(format_args!("{}: {message}", path.display()))
}

/// Reads the case that files are for, in the version of the options, the environment or its mesh.
fn open_case(args: &FormFactorArgs) -> Result<OpenFoamCase, Failure> {
    let environment_version = || {
        let word = std::env::var("WM_PROJECT_VERSION").ok()?;
        OpenFoamVersion::from_word(&word)
    };
    let version = args.programs.openfoam.or_else(environment_version);
    OpenFoamCase::open(&args.output, version).map_err(Failure::failed)
}

/// The number of an experiment, which is the suffix of its files.
fn experiment(path: &Path) -> Option<String> {
    let (_, suffix) = path.file_name()?.to_str()?.rsplit_once(".inp.")?;
    Some(suffix.to_owned())
}
