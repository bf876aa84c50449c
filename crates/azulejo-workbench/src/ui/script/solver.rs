//! Steps that set and start the solver, by their first word.

use super::fields::{number, one_of, switch, unless, whole};
use crate::app::App;
use crate::command::Command;
use crate::first_pass::{EngineChoice, LightSettings};

/// What a step of the solver does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolverStep {
    /// `engine NAME`: `auto`, `rays`, `hemicube`, `hybrid`, `analytic`.
    Engine(EngineChoice),
    /// `patches N`: sets the number of patches.
    Patches(u32),
    /// `time SECONDS`, `time none`: sets the time limit.
    Time(Option<f64>),
    /// `bounces N`, `bounces none`: limits diffuse bounces.
    Bounces(Option<u32>),
    /// `keep-mesh on`, `off`: whether light is stored on the vertices of the model.
    KeepMesh(bool),
    /// `solve` or `solve 5%`: solves the light, optionally to a given error.
    Solve(Option<f64>),
}

/// The step of this first word; `None` if it is not one of the solver.
pub(super) fn parse(word: &str, rest: &str) -> Option<Result<SolverStep, String>> {
    Some(match word {
        "engine" => {
            let name = |engine: EngineChoice| format!("{engine:?}").to_ascii_lowercase();
            one_of("engine", rest, &EngineChoice::ALL, name).map(SolverStep::Engine)
        }
        "patches" => whole(rest, 10_000_000).map(SolverStep::Patches),
        "time" => unless("none", rest, seconds).map(SolverStep::Time),
        "bounces" if rest == "0" => Ok(SolverStep::Bounces(Some(0))),
        "bounces" => unless("none", rest, |n| whole(n, 1_000)).map(SolverStep::Bounces),
        "keep-mesh" => switch(rest).map(SolverStep::KeepMesh),
        "solve" => error(rest).map(SolverStep::Solve),
        _ => return None,
    })
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = number(text)?;
    if (0.1..=1e6).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(format!("a time limit of {seconds} s, expected 0.1 to 1e6"))
    }
}

fn error(text: &str) -> Result<Option<f64>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    let value = text.strip_suffix('%').and_then(|t| t.trim().parse().ok());
    let valid = value.filter(|p: &f64| (0.01..=100.0).contains(p));
    valid
        .map(|p| Some(p / 100.0))
        .ok_or_else(|| format!("\"{text}\" is not an error, expected as in 5%"))
}

impl SolverStep {
    /// The commands of the step.
    pub(super) fn commands(self, app: &App) -> Vec<Command> {
        let old = app.lighting.settings;
        let set = |settings: LightSettings| vec![Command::SetLight(settings)];
        match self {
            SolverStep::Engine(engine) => set(LightSettings { engine, ..old }),
            SolverStep::Patches(patches) => set(LightSettings { patches, ..old }),
            SolverStep::Time(time) => set(LightSettings { time, ..old }),
            SolverStep::Bounces(bounces) => set(LightSettings { bounces, ..old }),
            SolverStep::KeepMesh(keep_mesh) => set(LightSettings { keep_mesh, ..old }),
            SolverStep::Solve(None) => vec![Command::Solve],
            SolverStep::Solve(Some(error)) => {
                // A script that specifies an error wants it reached, however long it takes.
                let mut commands = set(LightSettings {
                    error,
                    time: None,
                    ..old
                });
                commands.push(Command::Solve);
                commands
            }
        }
    }
}
