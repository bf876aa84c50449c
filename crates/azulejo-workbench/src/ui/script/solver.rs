//! Steps that set and start the solver, by their first word.

use super::fields::{number, percent, switch, unless, variant, whole};
use super::step::{StepResult, commands};
use crate::command::Command;
use crate::first_pass::LightSettings;

/// The step of this first word; `None` if it is not one of the solver.
pub(super) fn parse(word: &str, rest: &str) -> Option<StepResult> {
    Some(match word {
        "engine" => set(variant("engine", rest), |s, engine| s.engine = engine),
        "patches" => set(whole(rest, 10_000_000), |s, count| s.patches = count),
        "time" => set(unless("none", rest, seconds), |s, time| s.time = time),
        "bounces" => set(unless("none", rest, count), |s, n| s.bounces = n),
        "keep-mesh" => set(switch(rest), |s, keeps| s.keep_mesh = keeps),
        "solve" => solve(rest),
        _ => return None,
    })
}

/// A step that changes the settings by a value.
fn set<T: 'static>(
    value: Result<T, String>,
    change: impl FnOnce(&mut LightSettings, T) + 'static,
) -> StepResult {
    let value = value?;
    Ok(commands(move |app| {
        let mut settings = app.lighting.settings;
        change(&mut settings, value);
        Ok(vec![Command::SetLight(settings)])
    }))
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = number(text)?;
    if (0.1..=1e6).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(format!("a time limit of {seconds} s, expected 0.1 to 1e6"))
    }
}

fn count(text: &str) -> Result<u32, String> {
    if text == "0" {
        return Ok(0);
    }
    whole(text, 1_000)
}

/// `solve`, or `solve 5%`: to an error that is reached however long it takes.
fn solve(text: &str) -> StepResult {
    let error = match text {
        "" => None,
        text => Some(percent(text, 0.01)?),
    };
    Ok(commands(move |app| {
        let Some(error) = error else {
            return Ok(vec![Command::Solve]);
        };
        let settings = LightSettings {
            error,
            time: None,
            ..app.lighting.settings
        };
        Ok(vec![Command::SetLight(settings), Command::Solve])
    }))
}
