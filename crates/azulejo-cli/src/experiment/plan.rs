//! The tasks of a suite, each with a key of all that its result depends on.

use super::suite::{EngineTable, OneOrMany, ReferenceTable, SceneTable, Suite, SuiteSource};
use crate::engine::{EngineArgs, EngineName, GpuName};
use crate::failure::Failure;
use crate::values;
use azulejo::models;
use azulejo_factors::form_factors::{Closure, MOST_RAYS};
use clap::ValueEnum;
use std::fmt;
use std::path::PathBuf;
use toml::Spanned;

/// The tasks of a suite, in order.
pub struct ExperimentPlan {
    /// For each scene its reference and its runs; then the scenes with known solutions.
    pub tasks: Vec<Task>,
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
    /// A model file, and the checksum of its bytes.
    File(PathBuf, u32),
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
        let mut tasks = Vec::new();
        for (table, choices) in suite.scene.iter().zip(&scenes) {
            for scene in choices {
                if let Some((setting, rows)) = &reference {
                    tasks.push(Task::Reference(scene.clone(), setting.clone(), *rows));
                }
                for (engine, settings) in suite.engine.iter().zip(&settings) {
                    let wanted = |name: &Spanned<String>| name.get_ref() == table.name.get_ref();
                    if !engine.scenes.is_empty() && !engine.scenes.iter().any(wanted) {
                        continue;
                    }
                    for setting in settings {
                        let seeds = (0..u64::from(suite.run.repetitions.max(1)))
                            .map(|r| suite.run.seed + r);
                        tasks.extend(seeds.map(|s| Task::Run(scene.clone(), setting.clone(), s)));
                    }
                }
            }
        }
        if suite.truths {
            tasks.extend(settings.into_iter().flatten().map(Task::Truths));
        }
        Ok(ExperimentPlan { tasks })
    }

    /// Keeps only the first setting of each engine on each scene, with one repetition.
    pub fn quick(&mut self) {
        let mut seen = Vec::new();
        self.tasks.retain(|task| match task {
            Task::Run(scene, setting, _) => {
                let new = (scene.to_string(), setting.name.clone());
                let is_new = !seen.contains(&new);
                seen.push(new);
                is_new
            }
            _ => true,
        });
    }

    /// Keeps only tasks with `name` in their names, and the references that they need.
    pub fn only(&mut self, name: &str) {
        let is_named = |task: &Task| task.to_string().contains(name);
        let needed: Vec<String> = self
            .tasks
            .iter()
            .filter(|t| is_named(t))
            .filter_map(|t| t.scene().map(|s| s.to_string()))
            .collect();
        self.tasks.retain(|task| match task {
            Task::Reference(scene, ..) => needed.contains(&scene.to_string()),
            _ => is_named(task),
        });
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
    if !(detail > 0.0 && detail <= 16.0) {
        let message = format_args!("detail is {detail}, expected more than 0 and at most 16");
        return Err(source.wrong(table.name.span().start, message));
    }
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
    let folder = source.path.parent().unwrap_or(std::path::Path::new(""));
    let path = folder.join(file.get_ref());
    let bytes = models::read_bytes(&path).map_err(|e| source.wrong(file.span().start, e))?;
    Ok(Origin::File(path, crc32fast::hash(&bytes)))
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
                    embree: table.embree.clone(),
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
        (.., Some(n)) if !(1..=MOST_RAYS).contains(&n) => wrong("rays", n, "1 to 1048576"),
        _ => Ok(()),
    }
}

/// Refuses relative errors outside of 0 to 1.
fn accuracy(asked: Option<f64>) -> Result<(), Failure> {
    match asked {
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
    check(&args, table.rays).map_err(|e| source.wrong(start, e))?;
    accuracy(table.accuracy).map_err(|e| source.wrong(start, e))?;
    let setting = EngineSetting {
        name: "reference".to_owned(),
        args,
        rays: table.rays,
        formulas: true,
        accuracy: table.accuracy,
        closure: Closure::default(),
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
            Origin::File(path, sum) => format!("{} ({sum:08x})", path.display()),
            Origin::Cube => "cube".to_owned(),
            Origin::RoomWithTable(facets) => format!("room_with_table of {facets}"),
            Origin::CornellThesis(mirrors, detail) => {
                format!("cornell_thesis with {mirrors} mirrors, detail {detail}")
            }
            Origin::Street(detail) => format!("street, detail {detail}"),
        };
        format!("{} ({origin}{patches})", self.name)
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
    fn key(&self) -> String {
        let gpu = self
            .args
            .gpu
            .map_or(String::new(), |g| format!(", gpu {g:?}"));
        let number =
            |name: &str, n: Option<u32>| n.map_or(String::new(), |n| format!(", {n} {name}"));
        format!(
            "{} ({:?}{}{}{}{gpu}{}, {}, closure {:?})",
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
            write!(f, ", {rays} rays")?;
        }
        if let Some(pixels) = self.args.resolution {
            write!(f, ", {pixels} pixels")?;
        }
        if let Some(points) = self.args.patch_points {
            write!(f, ", {points} points")?;
        }
        match self.accuracy {
            Some(accuracy) => write!(f, ", accuracy {accuracy:e}"),
            None => Ok(()),
        }
    }
}
