//! Poses: a scene and a command must give the same result when the scene is written in another way.
//!
//! A pose is a scene, a command and some changes that leave light as it is: another place, another unit,
//! other digits, another file format, divided faces. The original and the changed scene are given to the
//! program, as users do, and the two results are compared within what they state as errors.
//!
//! | module | content |
//! |---|---|
//! | `scenes` | what is changed |
//! | `changes` | how |
//! | `survey`, `site` | where everything is afterwards, by its place alone |
//! | `commands`, `measures` | what is asked, and what is read from the answer |
//! | `process` | runs of the program with a time limit |
//! | `compare` | whether two results are the same |
//! | `dice` | random choices |
//! | `table` | records and their tables |

mod changes;
mod commands;
mod compare;
mod dice;
// Of the reader of known answers, poses need the scenes.
#[allow(dead_code, unused_imports)]
#[path = "../../src/known/factors/mod.rs"]
mod known_factors;
mod measures;
mod process;
mod scenes;
mod site;
mod survey;
mod table;

use changes::{CHANGES, Change, Pose};
use commands::{Measure, PosedCommand};
use compare::{Quantity, compare};
use dice::Dice;
use measures::Inquiry;
use process::RunEnd;
use scenes::{PosedScene, SceneFamily};
use site::Site;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};
use survey::{Original, Partition};
pub use table::{PoseCounts, PoseOutcome, PoseRecord, csv_heading, tables};

/// Longest time of a run: far beyond what any takes alone, since others may run beside it.
const LIMIT: Duration = Duration::from_secs(180);

/// Most changes of a pose.
const MOST_CHANGES: usize = 4;

/// Change of a quantity for a change of areas: of the surface that sends, of that which receives, and of
/// those between them on both sides.
const SLACK: f64 = 4.0;

/// Poses that are tried for each that a part of a name leaves.
const TRIES: u64 = 10_000;

/// Which poses are run, and where.
pub struct PoseChoice {
    /// Seed of all that is random.
    pub seed: u64,
    /// How many poses are drawn, unless some are named.
    pub count: u64,
    /// Of those drawn, the ones that have this in SCENE:COMMAND:CHANGES.
    pub only: Option<String>,
    /// Poses by their numbers, or as SCENE:COMMAND:CHANGE+CHANGE.
    pub named: Vec<String>,
    /// Folder of the runs, with one folder a pose.
    pub folder: PathBuf,
    /// Whether models of the folder `AZULEJO_DATA` are among the scenes.
    pub has_corpus: bool,
}

/// A scene, a command and changes.
struct PosePlan<'a> {
    /// What `--pose` takes.
    key: String,
    posed: &'a PosedScene,
    command: &'a PosedCommand,
    changes: Vec<&'static Change>,
    /// Parameters of the changes.
    dice: Dice,
}

/// The result for an original, which many poses share.
struct Base {
    folder: PathBuf,
    site: Site,
    end: RunEnd,
}

/// All that poses need.
struct Poses<'a> {
    seed: u64,
    folder: &'a Path,
    families: &'a [SceneFamily],
    commands: &'a [PosedCommand],
    originals: HashMap<&'a str, Rc<Original>>,
    bases: HashMap<(&'a str, &'a str), Rc<Base>>,
}

/// Runs poses one after another, and tells each record as soon as it is there.
///
/// # Errors
/// Poses that do not exist, and folders that cannot be written. What fails in a pose is in its record.
pub fn run(choice: &PoseChoice, tell: &mut dyn FnMut(PoseRecord)) -> Result<(), String> {
    let (families, commands) = (scenes::families(choice.has_corpus), commands::commands());
    let mut poses = Poses {
        seed: choice.seed,
        folder: &choice.folder,
        families: &families,
        commands: &commands,
        originals: HashMap::new(),
        bases: HashMap::new(),
    };
    for plan in poses.plans(choice)? {
        let start = Instant::now();
        let mut record = poses.judged(plan).map_err(|e| e.to_string())?;
        record.seconds = start.elapsed().as_secs_f64();
        tell(record);
    }
    Ok(())
}

impl<'a> Poses<'a> {
    /// The poses that are asked for.
    fn plans(&self, choice: &PoseChoice) -> Result<Vec<PosePlan<'a>>, String> {
        if !choice.named.is_empty() {
            let plans = choice.named.iter().map(|words| self.named(words));
            return plans.collect();
        }
        let drawn = (0..choice.count.saturating_mul(TRIES)).map(|k| self.drawn(k));
        let is_wanted = |plan: &PosePlan| {
            let name = plan.name();
            choice.only.as_ref().is_none_or(|only| name.contains(only))
        };
        let plans: Vec<PosePlan> = drawn
            .filter(is_wanted)
            .take(choice.count as usize)
            .collect();
        match (plans.is_empty(), &choice.only) {
            (true, Some(only)) => Err(format!(
                "no pose has \"{only}\" in its name, which is SCENE:COMMAND:CHANGE+CHANGE"
            )),
            _ => Ok(plans),
        }
    }

    /// The pose of a number.
    fn drawn(&self, number: u64) -> PosePlan<'a> {
        let mut dice = Dice::new(self.seed, &format!("pose {number}"));
        let family: &'a SceneFamily = dice.one_of(self.families);
        let posed: &'a PosedScene = dice.one_of(family);
        let traits = posed.traits();
        let suited: Vec<&PosedCommand> = self.commands.iter().filter(|c| c.suits(traits)).collect();
        let command = *dice.one_of(&suited);
        let mut places: Vec<usize> = (0..CHANGES.len())
            .filter(|&k| command.suits_change(CHANGES[k].name, traits))
            .collect();
        dice.shuffle(&mut places);
        places.truncate(1 + dice.below(MOST_CHANGES));
        places.sort_unstable();
        PosePlan {
            key: number.to_string(),
            posed,
            command,
            changes: places.into_iter().map(|k| &CHANGES[k]).collect(),
            dice,
        }
    }

    /// A pose by its number, or by names of its scene, command and changes.
    fn named(&self, words: &str) -> Result<PosePlan<'a>, String> {
        if let Ok(number) = words.parse() {
            return Ok(self.drawn(number));
        }
        let wrong = |what: &str, name: &str, names: Vec<&str>| {
            let names = names.join(", ");
            format!("no {what} \"{name}\"; there are {names}")
        };
        let parts: Vec<&str> = words.split(':').collect();
        let [scene, command, changes] = parts[..] else {
            let form = "a number or SCENE:COMMAND:CHANGE+CHANGE";
            return Err(format!("pose {words}: expected {form}"));
        };
        let mut scenes = self.families.iter().flatten();
        let posed = scenes.clone().find(|s| s.name == scene).ok_or_else(|| {
            wrong(
                "scene",
                scene,
                scenes.by_ref().map(|s| s.name.as_str()).collect(),
            )
        })?;
        let commands = self.commands;
        let command = commands.iter().find(|c| c.name == command).ok_or_else(|| {
            wrong(
                "command",
                command,
                commands.iter().map(|c| c.name.as_str()).collect(),
            )
        })?;
        let names: Vec<&str> = changes.split('+').collect();
        for name in &names {
            if !CHANGES.iter().any(|c| c.name == *name) {
                return Err(wrong(
                    "change",
                    name,
                    CHANGES.iter().map(|c| c.name).collect(),
                ));
            }
        }
        Ok(PosePlan {
            key: words.to_owned(),
            posed,
            command,
            changes: CHANGES.iter().filter(|c| names.contains(&c.name)).collect(),
            dice: Dice::new(self.seed, words),
        })
    }

    /// Runs a pose; what fails in it is in the record.
    fn judged(&mut self, mut plan: PosePlan<'a>) -> io::Result<PoseRecord> {
        let mut pose = Pose::new(
            plan.posed.scene.clone(),
            plan.command.formats(plan.posed.traits()),
        );
        for change in &plan.changes {
            (change.apply)(&mut pose, &mut plan.dice);
        }
        let mut record = PoseRecord {
            key: plan.key.clone(),
            scene: plan.posed.name.clone(),
            command: plan.command.name.clone(),
            changes: plan.changes.iter().map(|c| c.name).collect(),
            words: pose.words.join(", "),
            outcome: PoseOutcome::Right,
            problem: String::new(),
            quantities: 0,
            off: 0,
            nearness: None,
            slack: 0.0,
            seconds: 0.0,
        };
        if let Err(problem) = self.compared(&plan, &pose, &mut record)? {
            record.outcome = PoseOutcome::Off;
            record.problem = problem;
        }
        Ok(record)
    }

    fn compared(
        &mut self,
        plan: &PosePlan<'a>,
        pose: &Pose,
        record: &mut PoseRecord,
    ) -> io::Result<Result<(), String>> {
        let original = self.original(plan.posed);
        let base = match self.base(plan, &original)? {
            Ok(base) => base,
            Err(problem) => return Ok(Err(format!("the original: {problem}"))),
        };
        let name: String = plan
            .key
            .chars()
            .map(|c| if c.is_alphanumeric() { c } else { '-' })
            .collect();
        let folder = self.folder.join(name);
        std::fs::create_dir_all(&folder)?;
        let site = match Site::new(&folder, &original, pose) {
            Ok(site) => site,
            Err(problem) => return Ok(Err(problem)),
        };
        let mut groups = groups(&original, [&base.site, &site], plan.command.measure);
        let moved = site.moved + base.site.moved;
        original.slivers(moved).for_each(|pair| groups.join(pair));
        let is_exact = plan.changes.iter().all(|c| c.name == "threads");
        let mut inquiry = Inquiry {
            command: plan.command,
            posed: plan.posed,
            original: &original,
            site: &site,
            folder: &folder,
            groups: &groups,
            seed: self.seed + u64::from(!is_exact),
        };
        let arguments = match inquiry.arguments() {
            Ok(arguments) => arguments,
            Err(problem) => return Ok(Err(problem)),
        };
        let end = process::run(&folder, &arguments, LIMIT)?;
        let quantities = answer(&inquiry, &end);
        inquiry.site = &base.site;
        inquiry.folder = &base.folder;
        let expected = answer(&inquiry, &base.end);
        // Formats may divide faces, too.
        let is_divided =
            |c: &&'static Change| matches!(c.name, "triangles" | "quarters" | "format");
        let divided = plan.changes.iter().any(is_divided);
        let bent = if divided { original.bent } else { 0.0 };
        record.slack = SLACK * (original.sensitivity * moved + bent);
        if matches!(base.end, RunEnd::Unfinished) || matches!(end, RunEnd::Unfinished) {
            record.outcome = PoseOutcome::Unfinished;
            let whose = if matches!(end, RunEnd::Unfinished) {
                "the pose"
            } else {
                "the original"
            };
            record.problem = format!("{whose} did not end within {} s", LIMIT.as_secs());
            return Ok(Ok(()));
        }
        Ok(expected
            .map_err(|e| format!("the original: {e}"))
            .and_then(|mut expected| {
                let mut quantities = quantities?;
                measures::keep_comparable(&mut expected, &mut quantities);
                record.judge(&compare(&expected, &quantities, record.slack, is_exact));
                Ok(())
            }))
    }

    fn original(&mut self, posed: &'a PosedScene) -> Rc<Original> {
        let known = self.originals.entry(&posed.name);
        known
            .or_insert_with(|| Rc::new(Original::new(posed)))
            .clone()
    }

    /// The result for the original, computed once.
    fn base(
        &mut self,
        plan: &PosePlan<'a>,
        original: &Original,
    ) -> io::Result<Result<Rc<Base>, String>> {
        let key = (plan.posed.name.as_str(), plan.command.name.as_str());
        if let Some(base) = self.bases.get(&key) {
            return Ok(Ok(base.clone()));
        }
        let folder = self.folder.join(format!("original-{}", self.bases.len()));
        std::fs::create_dir_all(&folder)?;
        let pose = Pose::new(plan.posed.scene.clone(), &[]);
        let site = match Site::new(&folder, original, &pose) {
            Ok(site) => site,
            Err(problem) => return Ok(Err(problem)),
        };
        let arguments = Inquiry {
            command: plan.command,
            posed: plan.posed,
            original,
            site: &site,
            folder: &folder,
            groups: &Partition::new(0),
            seed: self.seed,
        }
        .arguments();
        let arguments = match arguments {
            Ok(arguments) => arguments,
            Err(problem) => return Ok(Err(problem)),
        };
        let end = process::run(&folder, &arguments, LIMIT)?;
        let base = Rc::new(Base { folder, site, end });
        self.bases.insert(key, base.clone());
        Ok(Ok(base))
    }
}

impl PosePlan<'_> {
    fn name(&self) -> String {
        let changes: Vec<&str> = self.changes.iter().map(|c| c.name).collect();
        let (scene, command) = (&self.posed.name, &self.command.name);
        format!("{scene}:{command}:{}", changes.join("+"))
    }
}

/// The finest groups of elements that both files can tell apart.
fn groups(original: &Original, sites: [&Site; 2], measure: Measure) -> Partition {
    let by_object = measure != Measure::Factors { by_object: false };
    let mut groups = Partition::new(original.objects.len());
    if by_object {
        let mut first: HashMap<usize, usize> = HashMap::new();
        for (element, &object) in original.objects.iter().enumerate() {
            let known = *first.entry(object).or_insert(element);
            groups.join([known, element]);
        }
    }
    sites
        .iter()
        .for_each(|site| site.join(&mut groups, by_object));
    groups
}

/// The quantities of a run that succeeded.
fn answer(inquiry: &Inquiry, end: &RunEnd) -> Result<Vec<Quantity>, String> {
    match end {
        RunEnd::Done(printed) => inquiry.answer(printed),
        RunEnd::Refused(words) => Err(words.clone()),
        RunEnd::Unfinished => Err("unfinished".to_owned()),
    }
}
