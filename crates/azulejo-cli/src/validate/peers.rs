//! The closed forms by other programs that are installed, which a script in Python calls in their own ways.

use super::record::{CheckRecord, ValidationPart};
use super::{Validator, closed_forms};
use crate::child;
use crate::failure::Failure;
use crate::known::factors::{Case, CaseKind, PatchGroup, Question};
use crate::report::short;
use azulejo::output::Output;
use azulejo_factors::PatchSize;
use azulejo_scene::Shape;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Calls a program and prints its matrix of a model: one line of JSON for each model.
const ADAPTER: &str = include_str!("../../data/peers.py");

/// The programs that the script knows, as it names them.
const PEERS: [&str; 3] = ["view3d", "pyviewfactor", "raystrack"];

/// Longest time for all models of a program.
const LIMIT: Duration = Duration::from_secs(600);

/// What other programs answered.
#[derive(Debug, Default, Serialize)]
pub struct PeerResults {
    /// Those that ran.
    pub answered: Vec<PeerAnswers>,
    /// Those that did not, with the reason.
    pub missing: Vec<(&'static str, String)>,
}

/// The answers of a program.
#[derive(Debug, Serialize)]
pub struct PeerAnswers {
    /// Its name and version.
    pub program: String,
    /// By cases; those that it refused are not among them.
    pub answers: Vec<PeerAnswer>,
    /// CPU time, s.
    pub seconds: f64,
}

/// An answer of a program.
#[derive(Debug, Serialize)]
pub struct PeerAnswer {
    /// The case.
    pub case: String,
    /// The form factor.
    pub found: f64,
    /// The known value.
    pub expected: f64,
}

/// A line of the script.
#[derive(Deserialize)]
struct PeerLine {
    program: String,
    #[serde(default)]
    seconds: f64,
    /// The matrix; none if the program refused the model.
    factors: Option<Vec<Vec<f64>>>,
}

impl PeerAnswer {
    fn relative_error(&self) -> f64 {
        (self.found / self.expected - 1.0).abs()
    }
}

impl PeerAnswers {
    /// Root mean square and maximum of the relative errors.
    pub fn errors(&self) -> [f64; 2] {
        let errors = || self.answers.iter().map(PeerAnswer::relative_error);
        let squares: f64 = errors().map(|e| e * e).sum();
        let mean = squares / self.answers.len().max(1) as f64;
        [mean.sqrt(), errors().fold(0.0, f64::max)]
    }

    /// The same in words.
    pub fn summary(&self) -> String {
        let [typical, largest] = self.errors();
        format!(
            "{} closed forms in {:.2} CPU s, relative error {} RMS, {} at most",
            self.answers.len(),
            self.seconds,
            short(typical),
            short(largest)
        )
    }

    /// What an engine of azulejo answered to the same cases.
    pub fn of_engine(&self, engine: &str, records: &[CheckRecord]) -> PeerAnswers {
        let answers = self.answers.iter().filter_map(|answer| {
            let record = records.iter().find(|r| {
                (r.part, &*r.engine, &*r.subject)
                    == (ValidationPart::ClosedForms, engine, &*answer.case)
            })?;
            Some((record, answer))
        });
        let answers: Vec<(&CheckRecord, &PeerAnswer)> = answers.collect();
        PeerAnswers {
            program: format!("azulejo, {engine}"),
            seconds: answers.iter().map(|(record, _)| record.seconds).sum(),
            answers: (answers.iter())
                .map(|(record, answer)| PeerAnswer {
                    case: answer.case.clone(),
                    found: record.found,
                    expected: answer.expected,
                })
                .collect(),
        }
    }
}

/// Writes the cases that all programs understand into the folder, and asks the programs.
pub fn ask(validator: &Validator, folder: &Path) -> Result<PeerResults, Failure> {
    let wanted = |case: &Case| validator.wants(ValidationPart::ClosedForms, &case.id);
    let cases = closed_forms::all().into_iter().filter(wanted);
    let cases: Vec<(Case, [usize; 2])> = cases
        .filter_map(|case| Some((between(&case)?, case)))
        .map(|(pair, case)| (case, pair))
        .collect();
    let mut results = PeerResults::default();
    if cases.is_empty() {
        return Ok(results);
    }
    let models = write_models(&cases, &folder.join("peers"), validator)?;
    for name in PEERS {
        let mut command = Command::new("python3");
        command.args(["-c", ADAPTER, name]).args(&models);
        validator.tell(&format!("{} closed forms by {name}", cases.len()));
        match child::output(&mut command, Some(LIMIT), validator.progress) {
            Ok(Ok(text)) => results.answered.push(read(name, &text, &cases)?),
            Ok(Err(reason)) => results.missing.push((name, reason)),
            Err(Failure::Cancelled) => return Err(Failure::Cancelled),
            Err(failure) => results.missing.push((name, format!("python3: {failure}"))),
        }
    }
    Ok(results)
}

/// The two polygons whose form factor is the question, where all surfaces are whole triangles and quadrilaterals that are
/// seen from their fronts, and nothing reflects like a mirror.
fn between(case: &Case) -> Option<[usize; 2]> {
    let is_plain = matches!(case.kind, CaseKind::Polygons | CaseKind::Shadow);
    let Question::Factor { from, to } = &case.question else {
        return None;
    };
    let is_whole = |group: &PatchGroup| !group.inside && group.turns.is_none();
    let is_small = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => mesh.faces.len() == 1 && mesh.faces.get(0).len() <= 4,
        _ => false,
    };
    let fits = is_plain
        && case.size == PatchSize::Edge(0.0)
        && case.truth.value > 0.0
        && is_whole(from)
        && is_whole(to)
        && case.scene.objects.iter().all(|o| is_small(&o.shape));
    fits.then_some([from.object as usize, to.object as usize])
}

/// Writes each case as OBJ.
fn write_models(
    cases: &[(Case, [usize; 2])],
    folder: &Path,
    validator: &Validator,
) -> Result<Vec<PathBuf>, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| Failure::file("create", folder, &e))?;
    let mut paths = Vec::new();
    for (case, _) in cases {
        let path = folder.join(format!("{}.obj", case.id.replace([' ', '/'], "_")));
        let output = Output::check(&path)?;
        output.write(validator.progress, |out| {
            out.write_all(obj(case).as_bytes())
        })?;
        paths.push(path);
    }
    Ok(paths)
}

/// A case as OBJ, a polygon for each object.
fn obj(case: &Case) -> String {
    let (mut text, mut count) = (String::new(), 0);
    for object in &case.scene.objects {
        let Shape::Mesh(mesh) = &object.shape else {
            continue;
        };
        let corners = mesh.face_positions(0);
        let _ = writeln!(text, "# object {}", object.name);
        for p in &corners {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        let numbers = (1..=corners.len()).map(|k| (count + k).to_string());
        let _ = writeln!(text, "f {}", numbers.collect::<Vec<_>>().join(" "));
        count += corners.len();
    }
    text
}

/// What the script printed.
fn read(name: &str, text: &str, cases: &[(Case, [usize; 2])]) -> Result<PeerAnswers, Failure> {
    let mut answers = PeerAnswers {
        program: name.to_owned(),
        answers: Vec::new(),
        seconds: 0.0,
    };
    for (line, (case, [from, to])) in text.lines().zip(cases) {
        let line: PeerLine = serde_json::from_str(line)
            .map_err(|e| Failure::failed(format_args!("{name} answered {line:?}: {e}")))?;
        answers.program = line.program;
        answers.seconds += line.seconds;
        let row = line.factors.as_ref().and_then(|rows| rows.get(*from));
        if let Some(&found) = row.and_then(|row| row.get(*to)) {
            answers.answers.push(PeerAnswer {
                case: case.id.clone(),
                found,
                expected: case.truth.value,
            });
        }
    }
    Ok(answers)
}
