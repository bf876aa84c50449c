//! Solver controls: start, pause, stop, and progress.

use super::super::actions::{ACTIONS, key_text};
use super::super::panel_context::PanelContext;
use super::percent;
use crate::command::Command;
use crate::jobs::{Job, JobKind};
use egui::{Button, ProgressBar, RichText, Ui};
use std::time::Duration;

/// Draws the buttons, the progress bar and the state.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    buttons(ui, cx);
    let job = cx.app.jobs().iter().find(|j| j.kind == JobKind::Solve);
    let state = state(cx, job.is_some());
    let text = RichText::new(state.words(cx));
    ui.label(match state {
        SolverState::Dark if !cx.app.document.has_light() => text.color(ui.visuals().warn_fg_color),
        SolverState::Old => text.color(ui.visuals().warn_fg_color),
        _ => text,
    });
    if let Some(job) = job {
        progress(ui, cx, job);
    }
}

fn buttons(ui: &mut Ui, cx: &mut PanelContext) {
    let (runs, rests) = (cx.app.is_busy(JobKind::Solve), cx.app.lighting.is_paused);
    let (language, has_light) = (cx.language, cx.app.document.has_light());
    ui.horizontal(|ui| {
        let mut button = |name: &str, action: &str, makes_sense: bool, command: Command| {
            let button = Button::new(name).min_size(egui::vec2(72.0, 0.0));
            let key = ACTIONS
                .iter()
                .find(|a| a.label == action)
                .and_then(|a| a.key);
            let key = key.map(|k| key_text(ui.ctx(), &k, language));
            let button = ui.add_enabled(makes_sense, button);
            let button = button.on_hover_text(key.unwrap_or_default());
            if button.clicked() {
                cx.send(command);
            }
        };
        match (runs, rests) {
            (false, _) => button(language.tr("Start"), "Solve", has_light, Command::Solve),
            (true, false) => button(language.tr("Pause"), "Pause", true, Command::Pause),
            (true, true) => button(language.tr("Resume"), "Resume", true, Command::Resume),
        }
        button(language.tr("Stop"), "Stop", runs, Command::StopSolving);
    });
}

/// State of the solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SolverState {
    Dark,
    Settling,
    Resting,
    Done,
    Stopped,
    FromFile,
    Old,
}

fn state(cx: &PanelContext, runs: bool) -> SolverState {
    let lighting = &cx.app.lighting;
    match (&lighting.solution, runs) {
        (_, true) if lighting.is_paused => SolverState::Resting,
        (_, true) => SolverState::Settling,
        (None, false) => SolverState::Dark,
        (Some(_), false) if !lighting.is_current => SolverState::Old,
        (Some(solution), false) if solution.report.is_some() => SolverState::Done,
        (Some(_), false) if lighting.began.is_some() => SolverState::Stopped,
        (Some(_), false) => SolverState::FromFile,
    }
}

impl SolverState {
    fn words(self, cx: &PanelContext) -> String {
        let lighting = &cx.app.lighting;
        let took = seconds(lighting.stopwatch.elapsed());
        match self {
            SolverState::Dark if !cx.app.document.has_light() => cx
                .tr("There is no light source: add a light or an emissive material.")
                .into(),
            SolverState::Dark => cx.tr("Not solved yet.").into(),
            SolverState::Settling => format!("{} {took}", cx.tr("Converging:")),
            SolverState::Resting => format!("{} {took}", cx.tr("Paused after")),
            SolverState::Stopped => cx.tr("Stopped early: a rough solution.").into(),
            SolverState::FromFile => cx.tr("This light was loaded with the file.").into(),
            SolverState::Old => cx
                .tr("This light is from an earlier state of the model.")
                .into(),
            SolverState::Done => {
                let report = lighting.solution.as_ref().and_then(|s| s.report.as_ref());
                let error = percent(report.map_or(0.0, |r| r.error));
                let (done, after) = (cx.tr("Done: error"), cx.tr("solved in"));
                format!("{done} {error}, {after} {took}")
            }
        }
    }
}

/// The current stage, its share done and the remaining time.
fn progress(ui: &mut Ui, cx: &PanelContext, job: &Job) {
    let (done, total) = (job.progress.done(), job.progress.total());
    let share = match total {
        0 => 0.0,
        total => (done as f64 / total as f64).min(1.0),
    };
    let stage = job.progress.stage();
    let name = cx.stage(&stage);
    let text = format!("{name} {:.0} %", 100.0 * share);
    let bar = ProgressBar::new(share as f32).text(text);
    ui.add(bar.desired_width(ui.available_width().min(340.0)));
    if let Some(left) = cx.app.lighting.time_left(share).filter(|_| total > 0) {
        let words = cx.tr("Time left in this stage: about");
        ui.weak(format!("{words} {}", seconds(left)));
    }
}

/// A duration as text.
pub fn seconds(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6_000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3_600.0),
    }
}
