//! The tasks of a suite, each with a key of all that its result depends on.

use super::suite::{
    EmbreeTable, EngineTable, OneOrMany, ReferenceTable, SceneTable, Suite, SuiteSource,
};
use crate::content_key::{self, ContentHasher, ContentKey};
use crate::engine::{EngineArgs, EngineName, GpuName};
use crate::failure::Failure;
use crate::values;
use azulejo::models;
use azulejo_factors::PatchSize;
use azulejo_factors::form_factors::Closure;
use azulejo_formats::{Folder, ReadOptions};
use azulejo_scene::Scene;
use clap::ValueEnum;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The tasks of a suite, in order: for each scene its reference and its runs, repetition by
/// repetition; then the cases with known solutions. Tasks are made one by one, because there may be
/// any number of repetitions.
pub struct ExperimentPlan {
    scenes: Vec<PlannedScene>,
    /// Settings that compute the cases with known solutions.
    truths: Vec<EngineSetting>,
    /// The seeds of the repetitions.
    seeds: Range<u64>,
}

/// A scene with its runs.
struct PlannedScene {
    scene: SceneChoice,
    /// Its reference, and the number of rows to keep.
    reference: Option<(EngineSetting, usize)>,
    settings: Vec<EngineSetting>,
}

/// Work for one child process.
#[derive(Clone, Debug)]
pub enum Task {
    /// Computes the reference of a scene, with this number of rows to keep.
    Reference(SceneChoice, EngineSetting, usize),
    /// Computes a scene with an engine and a seed, and compares with the reference.
    Run(SceneChoice, EngineSetting, u64),
    /// Computes all scenes with known solutions with an engine.
    Truths(EngineSetting),
}

/// One scene with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneChoice {
    /// Its name in the report.
    pub name: String,
    /// Its origin.
    pub origin: Origin,
    /// Approximate number of patches; `None` does not divide faces.
    pub patches: Option<usize>,
}

/// The origin of a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Origin {
    /// A model file, and the key of its scene, with all that other files add to it.
    File(PathBuf, ContentKey),
    /// The unit cube, seen from inside.
    Cube,
    /// A room with a table and two boxes; approximate number of facets.
    RoomWithTable(usize),
    /// A box of 12,922 facets; number of mirrors, and factor on the number of facets.
    CornellThesis(usize, f64),
    /// A street of 61,795 facets under a sky; factor on the number of facets.
    Street(f64),
}

/// One engine with its parameters.
#[derive(Clone, Debug)]
pub struct EngineSetting {
    /// Its name in the report.
    pub name: String,
    /// The engine's options, as on the command line.
    pub args: EngineArgs,
    /// Rays per row, if specified.
    pub rays: Option<u32>,
    /// Whether closed forms replace rays where they are more accurate.
    pub formulas: bool,
    /// Target for the error of row sums, if specified.
    pub accuracy: Option<f64>,
    /// Scenes in which closure is enforced.
    pub closure: Closure,
    /// Whether to do without it where it is not available.
    pub is_optional: bool,
}

const GENERATORS: [&str; 4] = ["cube", "room_with_table", "cornell_thesis", "street"];

impl ExperimentPlan {
    /// The tasks of a suite.
    ///
    /// # Errors
    /// What is invalid in the suite, with its position.
    pub fn new(suite: &Suite, source: &SuiteSource) -> Result<ExperimentPlan, Failure> {
        let scenes = suite.scene.iter().map(|s| choices(s, source));
        let scenes = scenes.collect::<Result<Vec<_>, _>>()?;
        let settings = suite.engine.iter().map(|e| settings(e, source));
        let settings = settings.collect::<Result<Vec<_>, _>>()?;
        check_names(suite, source)?;
        if settings.is_empty() || (scenes.is_empty() && !suite.truths) {
            let message =
                "nothing to do: expected at least one [[engine]], and a [[scene]] or truths = true";
            return Err(source.wrong(0, message));
        }
        let reference = suite.reference.as_ref().map(|r| reference(r, source));
        let reference = reference.transpose()?;
        let mut planned = Vec::new();
        for (table, choices) in suite.scene.iter().zip(scenes) {
            let is_for = |engine: &EngineTable| {
                let is_this = |name: &Spanned<String>| name.get_ref() == table.name.get_ref();
                engine.scenes.is_empty() || engine.scenes.iter().any(is_this)
            };
            let engines = suite.engine.iter().zip(&settings);
            let engines = engines.filter(|(engine, _)| is_for(engine));
            let scene_settings: Vec<EngineSetting> =
                engines.flat_map(|(_, settings)| settings.clone()).collect();
            planned.extend(choices.into_iter().map(|scene| PlannedScene {
                scene,
                reference: reference.clone(),
                settings: scene_settings.clone(),
            }));
        }
        let first = suite.run.seed;
        Ok(ExperimentPlan {
            scenes: planned,
            truths: if suite.truths {
                let settings = settings.into_iter().flatten();
                settings.filter(|s| !s.is_particles()).collect()
            } else {
                Vec::new()
            },
            seeds: first..first.saturating_add(suite.run.repetitions.max(1).into()),
        })
    }

    /// The tasks, in order.
    pub fn tasks(&self) -> impl Iterator<Item = Task> {
        let scene_tasks = |planned| self.scene_tasks(planned);
        let truths = self.truths.iter().cloned().map(Task::Truths);
        self.scenes.iter().flat_map(scene_tasks).chain(truths)
    }

    fn scene_tasks<'a>(&'a self, planned: &'a PlannedScene) -> impl Iterator<Item = Task> + 'a {
        let PlannedScene {
            scene,
            reference,
            settings,
        } = planned;
        let reference = reference
            .iter()
            .map(|(setting, rows)| Task::Reference(scene.clone(), setting.clone(), *rows));
        let runs = self.seeds.clone().flat_map(move |seed| {
            let run = move |s: &EngineSetting| Task::Run(scene.clone(), s.clone(), seed);
            settings.iter().map(run)
        });
        reference.chain(runs)
    }

    /// Number of tasks.
    pub fn len(&self) -> u64 {
        let repetitions = self.seeds.end - self.seeds.start;
        let scene_tasks = |p: &PlannedScene| {
            u64::from(p.reference.is_some()) + p.settings.len() as u64 * repetitions
        };
        self.scenes.iter().map(scene_tasks).sum::<u64>() + self.truths.len() as u64
    }

    /// Whether there is nothing to do.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The tasks in words: one line for all repetitions of a run.
    pub fn lines(&self) -> Vec<String> {
        let seeds = match self.seeds.end - self.seeds.start {
            1 => format!("seed {}", self.seeds.start),
            _ => format!("seeds {} to {}", self.seeds.start, self.seeds.end - 1),
        };
        let mut lines = Vec::new();
        for planned in &self.scenes {
            let scene = &planned.scene;
            lines.extend(
                planned
                    .reference
                    .iter()
                    .map(|_| format!("{scene}, reference")),
            );
            let run = |setting: &EngineSetting| format!("{scene}, {setting}, {seeds}");
            lines.extend(planned.settings.iter().map(run));
        }
        let truths = self.truths.iter().cloned().map(Task::Truths);
        lines.extend(truths.map(|t| t.to_string()));
        lines
    }

    /// The task with this key.
    pub fn find(&self, key: &str) -> Option<Task> {
        let seed = key.rsplit_once(", seed ").and_then(|(_, n)| n.parse().ok());
        let seed = seed.filter(|n| self.seeds.contains(n));
        let seeds = seed.map_or(self.seeds.start..self.seeds.start, |n| n..n + 1);
        let one = ExperimentPlan {
            seeds,
            scenes: Vec::new(),
            truths: self.truths.clone(),
        };
        let scene_tasks = self
            .scenes
            .iter()
            .flat_map(|planned| one.scene_tasks(planned));
        let mut tasks = scene_tasks.chain(one.tasks());
        tasks.find(|task| task.key() == key)
    }

    /// The task of a scene's reference.
    pub fn reference_of(&self, scene: &SceneChoice) -> Option<Task> {
        let planned = self.scenes.iter().find(|p| p.scene == *scene)?;
        let (setting, rows) = planned.reference.as_ref()?;
        Some(Task::Reference(scene.clone(), setting.clone(), *rows))
    }

    /// Keeps only the first setting of each engine on each scene, with one repetition.
    pub fn quick(&mut self) {
        self.seeds.end = self.seeds.start + 1;
        for planned in &mut self.scenes {
            let mut seen = Vec::new();
            planned.settings.retain(|setting| {
                let is_new = !seen.contains(&setting.name);
                seen.push(setting.name.clone());
                is_new
            });
        }
    }

    /// Keeps only tasks with `name` in their lines, and the references that they need.
    pub fn only(&mut self, name: &str) {
        let seeds = self.seeds.clone();
        for planned in &mut self.scenes {
            let scene = planned.scene.to_string();
            let wants_reference = format!("{scene}, reference").contains(name);
            planned.settings.retain(|setting| {
                let plan = ExperimentPlan {
                    scenes: vec![PlannedScene {
                        scene: planned.scene.clone(),
                        reference: None,
                        settings: vec![setting.clone()],
                    }],
                    truths: Vec::new(),
                    seeds: seeds.clone(),
                };
                plan.lines()[0].contains(name)
            });
            if planned.settings.is_empty() && !wants_reference {
                planned.reference = None;
            }
        }
        self.truths
            .retain(|s| Task::Truths(s.clone()).to_string().contains(name));
    }
}

/// Scenes have different names, and engines refer to existing ones.
fn check_names(suite: &Suite, source: &SuiteSource) -> Result<(), Failure> {
    let known: Vec<&str> = suite
        .scene
        .iter()
        .map(|s| s.name.get_ref().as_str())
        .collect();
    for (i, scene) in suite.scene.iter().enumerate() {
        if known[..i].contains(&known[i]) {
            let message = format_args!("there is another scene \"{}\"", known[i]);
            return Err(source.wrong(scene.name.span().start, message));
        }
    }
    for name in suite.engine.iter().flat_map(|e| &e.scenes) {
        if !known.contains(&name.get_ref().as_str()) {
            return Err(source.unknown("scene", name, &known));
        }
    }
    Ok(())
}

fn choices(table: &SceneTable, source: &SuiteSource) -> Result<Vec<SceneChoice>, Failure> {
    let choice = |origin| SceneChoice {
        name: table.name.get_ref().clone(),
        origin,
        patches: table.patches,
    };
    let (facets, mirrors) = (table.facets.options(), table.mirrors.options());
    let detail = table.detail.unwrap_or(1.0);
    // A parameter that a file or a generator does not have is an error, rather than ignored.
    let only = |facets: bool, mirrors: bool, detail: bool| -> Result<(), Failure> {
        let extra = [
            (!facets && table.facets != OneOrMany::default(), "facets"),
            (!mirrors && table.mirrors != OneOrMany::default(), "mirrors"),
            (!detail && table.detail.is_some(), "detail"),
        ];
        let Some((_, name)) = extra.iter().find(|(is_extra, _)| *is_extra) else {
            return Ok(());
        };
        let message = format_args!(
            "\"{}\" does not have a parameter `{name}`",
            table.name.get_ref()
        );
        Err(source.wrong(table.name.span().start, message))
    };
    // The test is stated so that it also refuses a detail that is not a number.
    if !(detail > 0.0 && detail <= 16.0) {
        let message = format_args!("detail is {detail}, expected more than 0 and at most 16");
        return Err(source.wrong(table.name.span().start, message));
    }
    // A list of facets or mirrors makes one scene for each of its values.
    let origins = match (&table.file, &table.generator) {
        (Some(file), None) => {
            only(false, false, false)?;
            vec![model(file, source)?]
        }
        (None, Some(generator)) => match generator.get_ref().as_str() {
            "cube" => {
                only(false, false, false)?;
                vec![Origin::Cube]
            }
            "room_with_table" => {
                only(true, false, false)?;
                let counts = facets.iter().map(|f| f.unwrap_or(2_000));
                counts.map(Origin::RoomWithTable).collect()
            }
            "cornell_thesis" => {
                only(false, true, true)?;
                let counts = mirrors.iter().map(|m| m.unwrap_or(0));
                counts.map(|m| Origin::CornellThesis(m, detail)).collect()
            }
            "street" => {
                only(false, false, true)?;
                vec![Origin::Street(detail)]
            }
            _ => return Err(source.unknown("generator", generator, &GENERATORS)),
        },
        _ => {
            let message = "expected either file or generator in this [[scene]]";
            return Err(source.wrong(table.name.span().start, message));
        }
    };
    Ok(origins.into_iter().map(choice).collect())
}

/// A model file, relative to the suite.
fn model(file: &Spanned<String>, source: &SuiteSource) -> Result<Origin, Failure> {
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let path = folder.join(file.get_ref());
    let bytes = models::read_bytes(&path).map_err(|e| source.wrong(file.span().start, e))?;
    let mut hasher = ContentHasher::new();
    let key = match model_scene(&path) {
        Ok(scene) => hasher.add(&scene).key(),
        // The failure of its tasks, not of the suite.
        Err(_) => hasher.add(&*bytes).key(),
    };
    Ok(Origin::File(path, key))
}

/// The scene of a model file.
pub fn model_scene(path: &Path) -> Result<Scene, Failure> {
    let (bytes, name) = (models::read_bytes(path)?, path.to_string_lossy());
    let (folder, options) = (Folder::of_model(path), ReadOptions::default());
    let read = azulejo_formats::read_with(&bytes, &name, &folder, &options);
    Ok(read.map_err(Failure::failed)?.scene)
}

fn settings(table: &EngineTable, source: &SuiteSource) -> Result<Vec<EngineSetting>, Failure> {
    let engine = engine(&table.engine, source)?;
    let gpu = table.gpu.as_ref().map(|g| gpu(g, source)).transpose()?;
    let closure = table.closure.as_ref().map(|c| closure(c, source));
    let closure = closure.transpose()?.unwrap_or_default();
    accuracy(table.accuracy).map_err(|e| source.wrong(table.engine.span().start, e))?;
    let mut settings = Vec::new();
    for &rays in &table.rays.options() {
        for &resolution in &table.resolution.options() {
            for &patch_points in &table.patch_points.options() {
                let args = EngineArgs {
                    engine,
                    gpu,
                    resolution,
                    patch_points,
                    embree: table.embree.as_ref().and_then(EmbreeTable::option),
                };
                check(&args, rays).map_err(|e| source.wrong(table.engine.span().start, e))?;
                settings.push(EngineSetting {
                    name: table
                        .name
                        .clone()
                        .unwrap_or_else(|| table.engine.get_ref().clone()),
                    args,
                    rays,
                    formulas: table.formulas,
                    accuracy: table.accuracy,
                    closure,
                    is_optional: table.optional,
                });
            }
        }
    }
    Ok(settings)
}

/// Numbers as the command line wants them.
fn check(args: &EngineArgs, rays: Option<u32>) -> Result<(), Failure> {
    args.check()?;
    let wrong = |name: &str, n: u32, what: &str| {
        Err(Failure::failed(format_args!(
            "{name} is {n}, expected {what}"
        )))
    };
    match (args.resolution, args.patch_points, rays) {
        (Some(n), ..) if values::resolution(&n.to_string()).is_err() => {
            wrong("resolution", n, "an even number from 2 to 4096")
        }
        (_, Some(n), _) if !(1..=4096).contains(&n) => wrong("patch_points", n, "1 to 4096"),
        (.., Some(0)) => wrong("rays", 0, "at least 1"),
        _ => Ok(()),
    }
}

/// Refuses relative errors outside of 0 to 1.
fn accuracy(share: Option<f64>) -> Result<(), Failure> {
    match share {
        Some(a) if !(a > 0.0 && a <= 1.0) => Err(Failure::failed(format_args!(
            "accuracy is {a}, expected more than 0 and at most 1"
        ))),
        _ => Ok(()),
    }
}

fn reference(
    table: &ReferenceTable,
    source: &SuiteSource,
) -> Result<(EngineSetting, usize), Failure> {
    let args = EngineArgs {
        engine: engine(&table.engine, source)?,
        gpu: None,
        resolution: table.resolution,
        patch_points: table.patch_points,
        embree: None,
    };
    let start = table.engine.span().start;
    if args.engine == EngineName::Particles {
        let message = "particles have no form factors: choose another engine for the reference";
        return Err(source.wrong(start, message));
    }
    check(&args, table.rays).map_err(|e| source.wrong(start, e))?;
    accuracy(table.accuracy).map_err(|e| source.wrong(start, e))?;
    let setting = EngineSetting {
        name: "reference".to_owned(),
        args,
        rays: table.rays,
        formulas: true,
        accuracy: table.accuracy,
        closure: Closure::default(),
        is_optional: false,
    };
    Ok((setting, table.rows.max(1)))
}

fn engine(name: &Spanned<String>, source: &SuiteSource) -> Result<EngineName, Failure> {
    named(name, "engine", source)
}

fn gpu(name: &Spanned<String>, source: &SuiteSource) -> Result<GpuName, Failure> {
    named(name, "gpu", source)
}

fn closure(name: &Spanned<String>, source: &SuiteSource) -> Result<Closure, Failure> {
    match name.get_ref().as_str() {
        "never" => Ok(Closure::Never),
        "closed" => Ok(Closure::Closed),
        "always" => Ok(Closure::Always),
        _ => Err(source.unknown("closure", name, &["never", "closed", "always"])),
    }
}

/// A value of the command line by its name.
fn named<T: ValueEnum>(
    name: &Spanned<String>,
    what: &str,
    source: &SuiteSource,
) -> Result<T, Failure> {
    T::from_str(name.get_ref(), false).map_err(|_| {
        let known: Vec<String> = T::value_variants()
            .iter()
            .filter_map(|v| v.to_possible_value())
            .map(|v| v.get_name().to_owned())
            .collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        source.unknown(what, name, &known)
    })
}

impl Task {
    /// The scene that is computed, if it is a single one.
    pub fn scene(&self) -> Option<&SceneChoice> {
        match self {
            Task::Reference(scene, ..) | Task::Run(scene, ..) => Some(scene),
            Task::Truths(_) => None,
        }
    }

    /// All that the result depends on, as text: a task that was done under this key is not repeated.
    pub fn key(&self) -> String {
        match self {
            Task::Reference(scene, setting, rows) => {
                format!(
                    "reference of {}, {rows} rows by {}",
                    scene.key(),
                    setting.key()
                )
            }
            Task::Run(scene, setting, seed) => {
                format!("{} by {}, seed {seed}", scene.key(), setting.key())
            }
            Task::Truths(setting) => format!("truths by {}", setting.key()),
        }
    }
}

/// The name, in which `--only` searches.
impl fmt::Display for Task {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Task::Reference(scene, ..) => write!(f, "{scene}, reference"),
            Task::Run(scene, setting, seed) => write!(f, "{scene}, {setting}, seed {seed}"),
            Task::Truths(setting) => write!(f, "truths, {setting}"),
        }
    }
}

impl SceneChoice {
    fn key(&self) -> String {
        let patches = self
            .patches
            .map_or(String::new(), |n| format!(" in {n} patches"));
        let origin = match &self.origin {
            Origin::File(path, key) => format!("{} ({})", path.display(), content_key::shown(key)),
            Origin::Cube => "cube".to_owned(),
            Origin::RoomWithTable(facets) => format!("room_with_table of {facets}"),
            Origin::CornellThesis(mirrors, detail) => {
                format!("cornell_thesis with {mirrors} mirrors, detail {detail}")
            }
            Origin::Street(detail) => format!("street, detail {detail}"),
        };
        format!("{} ({origin}{patches})", self.name)
    }

    /// How finely its faces are divided.
    pub fn size(&self) -> PatchSize {
        self.patches.map_or(PatchSize::Edge(0.0), PatchSize::Count)
    }

    /// Number of mirrors, if the suite specifies it.
    pub fn mirrors(&self) -> Option<usize> {
        match self.origin {
            Origin::CornellThesis(mirrors, _) => Some(mirrors),
            _ => None,
        }
    }
}

impl fmt::Display for SceneChoice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.name)?;
        match self.origin {
            Origin::RoomWithTable(facets) => write!(f, ", {facets} facets"),
            Origin::CornellThesis(mirrors, _) => write!(f, ", {mirrors} mirrors"),
            _ => Ok(()),
        }
    }
}

impl EngineSetting {
    /// Whether it computes light alone, without form factors.
    pub fn is_particles(&self) -> bool {
        self.args.engine == EngineName::Particles
    }

    /// What is missing for an optional engine; `None` if nothing is, or if it has to be there.
    pub fn missing(&self) -> Option<String> {
        let prepared = self.is_optional.then(|| self.args.prepare())?;
        prepared.err().map(|e| e.to_string())
    }

    fn key(&self) -> String {
        let gpu = self
            .args
            .gpu
            .map_or(String::new(), |g| format!(", gpu {g:?}"));
        let number =
            |name: &str, n: Option<u32>| n.map_or(String::new(), |n| format!(", {n} {name}"));
        let embree = match &self.args.embree {
            None => String::new(),
            Some(None) => ", Embree".to_owned(),
            Some(Some(path)) => format!(", Embree {}", path.display()),
        };
        format!(
            "{} ({:?}{embree}{}{}{}{gpu}{}, {}, closure {:?})",
            self.name,
            self.args.engine,
            number("rays", self.rays),
            number("pixels", self.args.resolution),
            number("points", self.args.patch_points),
            if self.formulas { "" } else { ", no formulas" },
            self.accuracy
                .map_or(String::new(), |a| format!(", accuracy {a:e}")),
            self.closure,
        )
    }
}

impl fmt::Display for EngineSetting {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.name)?;
        if let Some(rays) = self.rays {
            let what = if self.is_particles() {
                "particles"
            } else {
                "rays"
            };
            write!(f, ", {rays} {what}")?;
        }
        if let Some(pixels) = self.args.resolution {
            write!(f, ", {pixels} pixels")?;
        }
        if let Some(points) = self.args.patch_points {
            let plural = if points == 1 { "" } else { "s" };
            write!(f, ", {points} point{plural}")?;
        }
        match self.accuracy {
            Some(accuracy) => write!(f, ", accuracy {accuracy:e}"),
            None => Ok(()),
        }
    }
}
