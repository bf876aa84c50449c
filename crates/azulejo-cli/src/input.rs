//! Models from files to one scene.

use super::failure::Failure;
use super::placement::Placement;
use super::placement::{self, PlaceArg};
use super::session::Session;
use super::surroundings;
use super::surroundings::args::{Site, SurroundingsArgs};
use super::values::{self, UpArg};
use azulejo::luminaire::PlacedLuminaire;
use azulejo::models::{self, read_bytes};
use azulejo::recipe::Recipe;
use azulejo_formats::{Lod, ReadOptions, VertexColors, camera_json};
use azulejo_scene::{Scene, Units, Up};
use clap::builder::Resettable;
use clap::{Args, ValueHint};
use globset::GlobMatcher;
use jiff::Timestamp;
use std::path::{Path, PathBuf};

/// The models to read.
#[derive(Clone, Debug, Args)]
pub struct InputArgs {
    /// Model files, merged into one scene if several; `-` is standard input
    #[arg(value_name = "SCENE", required = true, value_hint = ValueHint::FilePath,
          help_heading = Resettable::Reset)]
    pub scenes: Vec<PathBuf>,
    /// Add the point lights of a camera file (.json)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath,
          help_heading = "Light from outside")]
    pub lights: Option<PathBuf>,
    /// Add a luminaire of a photometric file (.ies, .ldt): FILE@X,Y,Z[,TILT,ROTATE,SPIN], then lm=LUMENS, cct=KELVIN or
    /// set=N if wanted. May be given several times
    ///
    /// It hangs at X,Y,Z, in units of the scene, and aims down. In degrees, TILT takes its aim toward its plane of 0
    /// degrees, ROTATE turns that plane from +x, counter-clockwise as seen from above, and SPIN turns it about its own
    /// axis before. Lamp set N is one of EULUMDAT.
    #[arg(long, value_name = "FILE@X,Y,Z,...", value_parser = placement::luminaire, allow_hyphen_values = true,
          help_heading = "Light from outside")]
    pub lamp: Vec<PlacedLuminaire>,
    #[command(flatten)]
    pub reading: ReadingArgs,
    #[command(flatten)]
    pub outside: SurroundingsArgs,
}

impl InputArgs {
    /// The files that are read.
    pub fn files_mut(&mut self) -> Vec<&mut PathBuf> {
        let named = self.scenes.iter_mut().chain(&mut self.lights);
        let more = (self.reading.recipe.iter_mut()).chain(&mut self.outside.environment);
        let lamps = self.lamp.iter_mut().map(|lamp| &mut lamp.file);
        named.chain(more).chain(lamps).collect()
    }
}

/// When the sun stands where it stands, for commands that do nothing else with time.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct ClockArgs {
    /// Date and time for which the sun is computed, as in 2025-06-21T14:00+02:00, at the LAT,LON of --place
    #[arg(long, value_name = "TIME", value_parser = values::when, help_heading = "Time")]
    pub time: Option<Timestamp>,
}

/// How models are read and put together.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadingArgs {
    /// Place a model: FILE:translate=1,0,2,rotate=0,90,0,scale=2; or LAT,LON, the place on Earth for
    /// which the sun is computed
    ///
    /// Steps are applied in the given order: degrees about x, y, z; one scale factor or three. fit=2
    /// scales the model so that its largest side is 2, and stands it on the origin; up=z and unit=mm
    /// override the file's axis and unit; name=lamp names its branch in the scene. LAT,LON are in
    /// degrees, north and east positive; with --time or --sun.
    #[arg(long, value_name = "FILE:HOW|LAT,LON", value_parser = placement::place,
          allow_hyphen_values = true)]
    pub place: Vec<PlaceArg>,
    /// Up axis of the scene, to which models are rotated [default: that of the first model]. For
    /// `render`, also a direction X,Y,Z that points up in the image only
    #[arg(long, value_name = "y|z", value_parser = values::up, allow_hyphen_values = true)]
    pub up: Option<UpArg>,
    /// Unit of length of the scene, to which models are scaled: mm, cm, m, km, in, ft, or a number
    /// of metres [default: that of the first model]
    #[arg(long, value_name = "UNIT", value_parser = values::unit)]
    pub unit: Option<f64>,
    /// Level of detail of models that have several: finest, coarsest, all, a viewing distance in the
    /// model's units, or a level as in lod1.3 (CityJSON)
    #[arg(long, value_name = "LEVEL", default_value = "finest", value_parser = values::lod)]
    pub lod: Lod,
    /// Colours of vertices in OBJ and PLY are linear, or sRGB as screens show them [default: linear, or
    /// sRGB if Blender wrote the file]
    #[arg(long, value_name = "linear|srgb")]
    pub vertex_colors: Option<VertexColors>,
    /// Set of lamps of a model in EULUMDAT, from 1 [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub lamp_set: Option<u32>,
    /// Revolve axisymmetric elements (CAX, DCAX of Abaqus and CalculiX) around the axis y, as N facets for each edge
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=3600))]
    pub revolve: Option<u32>,
    /// Apply a recipe (TOML) to the scene: rules by names of materials and objects, lights, cameras,
    /// background, fog. May be given several times
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub recipe: Vec<PathBuf>,
    /// Reverse the faces of the objects of these names, with the wildcards * and ?: their backs
    /// become their fronts
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = values::names)]
    pub flip: Vec<GlobMatcher>,
    /// Fail if anything in a model had to be skipped or repaired
    #[arg(long)]
    pub strict: bool,
    /// Maximum number of vertices and face corners to which the instances and curves of a model may
    /// expand
    #[arg(long, value_name = "N", default_value_t = ReadOptions::default().most_elements)]
    pub most_elements: u64,
    /// Also read files in this folder that a model refers to by `..` or an absolute path
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub allow: Vec<PathBuf>,
}

impl ReadingArgs {
    /// The options of readers.
    pub fn options(&self, darkens_unpainted: bool) -> ReadOptions {
        ReadOptions {
            lod: self.lod,
            most_elements: self.most_elements,
            darkens_unpainted,
            vertex_colors: self.vertex_colors,
            sectors: self.revolve,
            lamp_set: self.lamp_set.map(|set| set as usize),
            ..ReadOptions::default()
        }
    }

    /// How models are placed.
    pub fn placements(&self) -> impl Iterator<Item = &Placement> {
        self.place.iter().filter_map(|place| match place {
            PlaceArg::Model(placement) => Some(placement),
            PlaceArg::Site(_) => None,
        })
    }

    /// The place on Earth.
    pub fn site(&self) -> Option<Site> {
        self.place.iter().rev().find_map(|place| match place {
            PlaceArg::Site(site) => Some(*site),
            PlaceArg::Model(_) => None,
        })
    }
}

/// What a command does with its models.
#[derive(Clone, Copy)]
enum Purpose {
    /// It converts or describes them as they are, with the sun of an instant.
    AsGiven(Option<Timestamp>),
    /// It shows light, for an instant at which the sun stands somewhere.
    Lit(Option<Timestamp>),
    /// It computes light in place of what the models have.
    Relit(Option<Timestamp>),
}

/// Reads all models of a command, places and merges them, and reports what was skipped.
///
/// The scene has the axes and unit of the first model, unless the command line specifies others.
pub fn read_all(
    input: &InputArgs,
    clock: ClockArgs,
    session: &mut Session,
) -> Result<Scene, Failure> {
    read_all_for(input, Purpose::AsGiven(clock.time), session)
}

/// [`read_all`] for light, at an instant if one is given.
pub fn read_lit(
    input: &InputArgs,
    instant: Option<Timestamp>,
    session: &mut Session,
) -> Result<Scene, Failure> {
    read_all_for(input, Purpose::Lit(instant), session)
}

/// [`read_lit`] for light that takes the place of lightmaps: those that azulejo has baked are removed with what
/// was done for them, others are left out.
pub fn read_relit(
    input: &InputArgs,
    instant: Option<Timestamp>,
    session: &mut Session,
) -> Result<Scene, Failure> {
    let mut scene = read_all_for(input, Purpose::Relit(instant), session)?;
    if scene.drop_lightmaps() {
        session.note(
            "materials or nodes have a lightmap of another program: its light is left out, and computed \
             anew from the lamps of the model",
        );
    }
    Ok(scene)
}

fn read_all_for(
    input: &InputArgs,
    purpose: Purpose,
    session: &mut Session,
) -> Result<Scene, Failure> {
    // A direction given by --up turns the picture and not the scene, so only images have a use for it.
    if !session.makes_image() && matches!(input.reading.up, Some(UpArg::Picture(_))) {
        return Err(Failure::misuse(
            "--up: expected y or z; a direction applies to images only",
        ));
    }
    let mut placements = PlacementQueue::new(&input.reading, &input.scenes)?;
    let mut whole: Option<Scene> = None;
    for (path, branch) in input.scenes.iter().zip(branches(&input.scenes)) {
        let placement = placements.next(path);
        let mut model = read_one(path, &input.reading, purpose, session)?;
        if let Some(placement) = placement {
            model.units.up = placement.up.unwrap_or(model.units.up);
            model.units.metres_per_unit = placement.unit.or(model.units.metres_per_unit);
        }
        // The command line or else the first model sets axes and unit of the scene; other models are adapted.
        let units = scene_units(&input.reading, whole.as_ref().unwrap_or(&model).units);
        for change in models::changes(model.units, units) {
            let hint = match (change, input.reading.up) {
                (models::Change::Turned { to, .. }, Some(_)) => {
                    let axis = if to == Up::Z { "z" } else { "y" };
                    let path = path.display();
                    format!(
                        " (if it is drawn with {axis} up: --place {path}:up={axis} in place of --up)"
                    )
                }
                _ => String::new(),
            };
            session.note(&format!("{}: {change}{hint}", path.display()));
        }
        let mut model = model.adapted(units);
        // The steps of a placement are in the axes and unit of the scene, so they come after these.
        if let Some(placement) = placement {
            let map = placement.scene_from_model(model.bounds(), units.up);
            model = model.transformed(&map);
            model.validate().map_err(|e| unplaceable(path, &e))?;
        }
        if let Some(branch) = placement.and_then(|p| p.name.clone()).or(branch) {
            models::name_branch(&mut model, &branch);
        }
        // A model with a unit gives it to the models before it, if these have none.
        match &mut whole {
            None => whole = Some(model),
            Some(scene) => {
                scene.units.metres_per_unit = model.units.metres_per_unit;
                scene.merge(model);
            }
        }
    }
    let mut scene = whole.ok_or_else(|| Failure::misuse("no scene given"))?;
    // Recipes, flips and lights apply to the whole scene, not to single models.
    for path in &input.reading.recipe {
        apply_recipe(path, &mut scene, input.reading.strict, session)?;
    }
    flip(&mut scene, &input.reading.flip, session)?;
    if let Some(path) = &input.lights {
        let lights = camera_json::read_lights(&read_bytes(path)?, &path.to_string_lossy());
        scene.lights.extend(lights.map_err(Failure::failed)?);
    }
    for lamp in &input.lamp {
        let lights = lamp.lights(scene.units).map_err(Failure::failed)?;
        scene.lights.extend(lights);
    }
    surroundings::add(
        &mut scene,
        &input.outside,
        input.reading.site(),
        purpose.instant(),
        session,
    )?;
    Ok(scene)
}

/// Applies a recipe; rules that match nothing are reported, or refused if `is_strict`.
fn apply_recipe(
    path: &Path,
    scene: &mut Scene,
    is_strict: bool,
    session: &mut Session,
) -> Result<(), Failure> {
    let outcome = Recipe::read(path)?.apply(scene)?;
    outcome.limited.iter().for_each(|words| session.note(words));
    match outcome.unmatched.first() {
        Some(first) if is_strict => Err(Failure::failed(first)),
        _ => {
            let unmatched = outcome.unmatched.iter();
            unmatched.for_each(|words| session.note(words));
            Ok(())
        }
    }
}

/// Turns the objects of these names inside out.
fn flip(scene: &mut Scene, names: &[GlobMatcher], session: &mut Session) -> Result<(), Failure> {
    for name in names {
        let mut is_there = false;
        for object in &mut scene.objects {
            if !name.is_match(&object.name) {
                continue;
            }
            is_there = true;
            if !object.turn_inside_out() {
                session.note(&format!(
                    "--flip: \"{}\" is an exact shape, whose front is outside, and stays as it is",
                    object.name
                ));
            }
        }
        if !is_there {
            let message = format_args!("--flip: no object has the name \"{}\"", name.glob());
            return Err(Failure::misuse(message));
        }
    }
    Ok(())
}

fn unplaceable(path: &Path, problem: &impl std::fmt::Display) -> Failure {
    Failure::Failed(format!("{}: invalid --place: {problem}", path.display()))
}

/// Units of the scene: from the command line, otherwise `units`.
fn scene_units(reading: &ReadingArgs, units: Units) -> Units {
    Units {
        metres_per_unit: reading.unit.or(units.metres_per_unit),
        up: match reading.up {
            Some(UpArg::Scene(up)) => up,
            _ => units.up,
        },
        ..units
    }
}

/// The branches of several models, each named after its file; a single model has no branch.
fn branches(paths: &[PathBuf]) -> Vec<Option<String>> {
    if paths.len() == 1 {
        return vec![None];
    }
    let mut names: Vec<Option<String>> = Vec::new();
    for path in paths {
        let is_taken = |name: &str| names.iter().flatten().any(|n| n == name);
        names.push(Some(models::branch_name(path, is_taken)));
    }
    names
}

/// The placements not yet used: those of a file apply to its occurrences in order.
struct PlacementQueue<'a>(Vec<&'a Placement>);

impl<'a> PlacementQueue<'a> {
    fn new(reading: &'a ReadingArgs, paths: &[PathBuf]) -> Result<PlacementQueue<'a>, Failure> {
        match reading
            .placements()
            .find(|p| !paths.iter().any(|path| p.is_about(path)))
        {
            Some(p) => Err(Failure::misuse(format_args!(
                "--place {}: no scene of that name is given",
                p.file
            ))),
            None => Ok(PlacementQueue(reading.placements().collect())),
        }
    }

    fn next(&mut self, path: &Path) -> Option<&'a Placement> {
        let at = self.0.iter().position(|p| p.is_about(path))?;
        Some(self.0.remove(at))
    }
}

impl Purpose {
    fn instant(self) -> Option<Timestamp> {
        match self {
            Purpose::AsGiven(instant) | Purpose::Lit(instant) | Purpose::Relit(instant) => instant,
        }
    }
}

/// Reads one model and reports what was skipped.
fn read_one(
    path: &Path,
    reading: &ReadingArgs,
    purpose: Purpose,
    session: &mut Session,
) -> Result<Scene, Failure> {
    let how = models::Reading {
        options: reading.options(!matches!(purpose, Purpose::AsGiven(_))),
        allow: reading.allow.clone(),
        home: None,
    };
    let model = match purpose {
        Purpose::AsGiven(_) | Purpose::Lit(_) => models::read(path, &how, session.progress())?,
        Purpose::Relit(_) => {
            let (model, notes) = models::read_unbaked(path, &how, session.progress())?;
            notes.iter().for_each(|note| session.note(note));
            model
        }
    };
    model.warnings.iter().for_each(|w| session.warn(w));
    session.has_read(model.format);
    session.has_read_files(path, model.files);
    match model.warnings.len() {
        0 => Ok(model.scene),
        n if reading.strict => Err(Failure::Failed(format!(
            "{}: {n} warnings, which --strict turns into a failure",
            path.display()
        ))),
        _ => Ok(model.scene),
    }
}
