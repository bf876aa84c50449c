//! Cards over the model: what is being done and how long it takes, and what can be done next.

use super::super::actions::{ACTIONS, Action, ActionTarget, key_text, label};
use super::super::light::{count, percent, seconds};
use super::super::panel_context::PanelContext;
use crate::app::RenderedImage;
use crate::command::Command;
use crate::jobs::{Job, JobKind};
use crate::platform::IS_PAGE;
use crate::view::Shading;
use azulejo::radiosity::SolveError;
use egui::{
    Align2, Button, DragValue, Frame, Id, KeyboardShortcut, ProgressBar, Rect, RichText, Ui, Vec2,
};
use std::sync::Arc;

/// Width of a card, points.
pub const WIDTH: f32 = 340.0;
/// Height of the buttons in the upper left corner, points.
const BUTTONS: f32 = 26.0;
/// Distance of a card from the edge of the viewport, points.
const GAP: f32 = 12.0;

/// Draws a card at one side of `rect`.
fn card(ui: &mut Ui, rect: Rect, at: Align2, name: &str, body: impl FnOnce(&mut Ui)) {
    // Below the buttons that move, rotate and resize what is selected.
    let rect = Rect::from_min_max(rect.min + Vec2::new(0.0, BUTTONS), rect.max);
    let width = WIDTH.min(rect.width() - 4.0 * GAP).max(80.0);
    // Where the card ends is known after it is drawn; the size of the last frame places it.
    let id = ui.scope_id().with(("card", name));
    let last: Vec2 = ui
        .data(|d| d.get_temp(id))
        .unwrap_or(Vec2::new(width, 80.0));
    let place = at.align_size_within_rect(last, rect.shrink(GAP));
    let builder = egui::UiBuilder::new().max_rect(place).id_salt(name);
    let drawn = ui.scope_builder(builder, |ui| {
        let frame = Frame::popup(ui.style()).inner_margin(10.0);
        frame.show(ui, |ui| {
            ui.set_width(width - 24.0);
            body(ui);
        })
    });
    let size = drawn.response.rect.size();
    if (size - last).length() > 0.5 {
        ui.ctx().request_repaint();
    }
    ui.data_mut(|d| d.insert_temp(id, size));
}

fn title(ui: &mut Ui, text: impl Into<String>) {
    ui.label(RichText::new(text).size(17.0).strong());
}

/// The job that a card is about: the solver, a lightmap or a file, whichever runs.
pub fn show_progress(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) -> bool {
    let jobs = cx.app.jobs();
    let kinds = [JobKind::Solve, JobKind::Bake, JobKind::Load];
    let job = kinds
        .iter()
        .find_map(|&k| jobs.iter().find(|j| j.kind == k));
    let Some(job) = job else {
        return false;
    };
    card(ui, rect, Align2::CENTER_TOP, "progress", |ui| {
        let kind = job.kind;
        title(ui, headline(cx, job));
        bar(ui, cx, job);
        if let Some(line) = remaining(cx, job) {
            ui.label(line);
        }
        ui.horizontal(|ui| match (kind, cx.app.lighting.is_paused) {
            (JobKind::Solve, rests) => {
                let (name, command) = if rests {
                    (cx.tr("Resume"), Command::Resume)
                } else {
                    (cx.tr("Pause"), Command::Pause)
                };
                if !IS_PAGE && ui.button(name).clicked() {
                    cx.send(command);
                }
                if ui.button(cx.tr("Stop")).clicked() {
                    cx.send(Command::StopSolving);
                }
            }
            _ => {
                if ui.button(cx.tr("Cancel")).clicked() {
                    cx.send(Command::Cancel(job.id));
                }
            }
        });
    });
    true
}

fn headline(cx: &PanelContext, job: &Job) -> String {
    match job.kind {
        JobKind::Solve if cx.app.lighting.is_paused => cx.tr("The solver is paused").into(),
        JobKind::Solve => cx.tr("Solving the light").into(),
        JobKind::Bake => cx.tr("Baking the lightmap").into(),
        _ => {
            let path = std::path::Path::new(&job.title);
            let name = path.file_name().unwrap_or(path.as_os_str());
            format!("{} {}", cx.tr("Loading"), name.to_string_lossy())
        }
    }
}

fn bar(ui: &mut Ui, cx: &PanelContext, job: &Job) {
    let (done, total) = (job.progress.done(), job.progress.total());
    let stage = job.progress.stage();
    let stage = cx.stage(&stage);
    if total == 0 {
        // Nothing that moves by itself: frames would take time from the solver.
        ui.label(format!("{stage}…"));
        return;
    }
    let share = (done as f32 / total as f32).min(1.0);
    ui.add(ProgressBar::new(share).text(format!("{stage} {:.0} %", 100.0 * share)));
}

/// The error that the solver has reached, and the time that is left.
fn remaining(cx: &PanelContext, job: &Job) -> Option<String> {
    if job.kind != JobKind::Solve {
        return None;
    }
    let lighting = &cx.app.lighting;
    let target = percent(lighting.settings.error);
    let reached = lighting.reached_error().map(|error| {
        let (name, goal) = (cx.tr("error"), cx.tr("target"));
        format!("{name} {} ({goal} {target})", percent(error))
    });
    // Before the first estimate of the error, only the limit is known.
    let about = match lighting.reached_error() {
        Some(_) => cx.tr("about"),
        None => cx.tr("at most"),
    };
    let left = lighting.time_to_target();
    let left = left.map(|left| format!("{about} {}", seconds(left)));
    let parts: Vec<String> = reached.into_iter().chain(left).collect();
    (!parts.is_empty()).then(|| parts.join(" · "))
}

/// The state of the rendered image in words.
pub fn render_state(cx: &PanelContext) -> String {
    let Some(render) = &cx.app.render else {
        return String::new();
    };
    let RenderedImage { samples, most, .. } = render;
    let unit = cx.tr("paths per pixel");
    let mut text = format!("{samples} / {most} {unit}");
    let runs = cx.app.is_busy(JobKind::Render);
    if let Some(left) = render.time_left().filter(|_| runs) {
        text = format!("{text} · {} {}", cx.tr("about"), seconds(left));
    }
    text
}

/// The card of the rendered image: its progress, and the way back to the model.
pub fn show_render(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) -> Vec<ActionTarget> {
    let Some(render) = &cx.app.render else {
        return Vec::new();
    };
    let runs = cx.app.is_busy(JobKind::Render);
    let mut targets = Vec::new();
    card(ui, rect, Align2::CENTER_BOTTOM, "render", |ui| {
        let share = render.samples as f32 / render.most.max(1) as f32;
        ui.add(ProgressBar::new(share).text(render_state(cx)));
        picture_size(ui, cx, render);
        ui.horizontal_wrapped(|ui| {
            if runs {
                if ui.button(cx.tr("Stop")).clicked() {
                    cx.send(Command::StopRender);
                }
            } else if render.samples < render.most && ui.button(cx.tr("Resume")).clicked() {
                cx.send(Command::ResumeRender);
            }
            targets.extend(action_button(ui, cx, "Save image…"));
            let back = ui.button(cx.tr("Back to the model"));
            if back.on_hover_text("Esc").clicked() {
                cx.send(Command::CloseRender);
            }
        });
    });
    targets
}

/// Width, height and paths per pixel, and a button that renders with other ones.
fn picture_size(ui: &mut Ui, cx: &mut PanelContext, render: &RenderedImage) {
    let own = (render.size.0, render.size.1, render.most);
    let id = Id::unique("picture size");
    let kept: Option<(PictureSize, PictureSize)> = ui.data(|d| d.get_temp(id));
    // What was typed for another image is forgotten.
    let typed = kept.filter(|(of, _)| *of == own).map(|(_, typed)| typed);
    let (mut width, mut height, mut paths) = typed.unwrap_or(own);
    ui.horizontal_wrapped(|ui| {
        let mut field = |value: &mut u32, most: u32, name: &str, unit: &str| {
            let drag = DragValue::new(value).range(1..=most).suffix(unit);
            ui.add(drag.speed(1.0).update_while_editing(false))
                .on_hover_text(name)
                .accessible_name(name);
        };
        field(&mut width, 8192, cx.tr("Width"), " ×");
        field(&mut height, 8192, cx.tr("Height"), " px");
        field(&mut paths, 65_536, cx.tr("paths per pixel"), "");
        let settings = (width, height, paths);
        let button = Button::new(cx.tr("Render this size"));
        if ui.add_enabled(settings != own, button).clicked() {
            cx.send(Command::Render {
                width,
                height,
                paths: Some(paths),
            });
        }
    });
    ui.data_mut(|d| d.insert_temp(id, (own, (width, height, paths))));
}

/// Width and height in pixels, and paths per pixel.
type PictureSize = (u32, u32, u32);

/// A button for an entry of the menus, disabled where that is.
pub fn action_button(ui: &mut Ui, cx: &PanelContext, label: &str) -> Option<ActionTarget> {
    let action = ACTIONS.iter().find(|a| a.label == label)?;
    let target = (action.target)(cx.app);
    let button = ui.add_enabled(target.is_some(), Button::new(cx.tr(action.label)));
    let button = match action.key {
        Some(key) => button.on_hover_text(about(ui, cx, action, &key)),
        None => button,
    };
    target.filter(|_| button.clicked())
}

/// The key of a button; of undo and redo also what they apply to, which the button does not say.
fn about(ui: &Ui, cx: &PanelContext, action: &Action, key: &KeyboardShortcut) -> String {
    let key = key_text(ui.ctx(), key, cx.language);
    let text = label(cx.app, action);
    if text == cx.tr(action.label) {
        key
    } else {
        format!("{text} ({key})")
    }
}

/// What the model lacks, with buttons for it: a light source, a solution, a current solution.
pub fn show_next(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) -> Vec<ActionTarget> {
    let app = cx.app;
    let (lighting, shading) = (&app.lighting, app.view.shading);
    let is_dark = !app.document.has_light();
    // What is missing first is shown alone: light sources, then a solution, then a current one.
    let (text, labels): (&str, &[&str]) = if app.document.objects.is_empty() {
        return Vec::new();
    } else if app.lightmap.shown_in(shading).is_some() {
        // A lightmap stands in for the solution, whose state does not matter then.
        let is_old = app.lightmap.result.is_some() && !app.lightmap.is_current;
        if !is_old {
            return Vec::new();
        }
        (
            cx.tr("This lightmap belongs to an earlier state of the model."),
            &["Bake a lightmap…"],
        )
    } else if is_dark && (shading.shows_light() || lighting.solution.is_none()) {
        (
            cx.tr("There is no light source yet."),
            &["Studio", "Area light", "Sun"],
        )
    } else if lighting.solution.is_none() {
        (cx.tr("The light is not solved yet."), &["Solve"])
    } else if shading.shows_light() && !lighting.is_current {
        (
            cx.tr("This light is from an earlier state of the model."),
            &["Solve", "Discard solution"],
        )
    } else {
        return Vec::new();
    };
    // Form factors need no light, whatever the state of the solution.
    if shading == Shading::FormFactors {
        return Vec::new();
    }
    // The buttons are entries of the menus, with their keys.
    let mut targets = Vec::new();
    card(ui, rect, Align2::CENTER_TOP, "next", |ui| {
        ui.horizontal_wrapped(|ui| {
            ui.label(text);
            for label in labels {
                targets.extend(action_button(ui, cx, label));
            }
        });
    });
    targets
}

/// How much more than the target the error may be without being pointed out.
const SLACK: f64 = 1.1;

/// A button that solves the light for as long as it takes.
fn without_limit(ui: &mut Ui, cx: &mut PanelContext) {
    if ui.button(cx.tr("Solve without a time limit")).clicked() {
        let mut settings = cx.app.lighting.settings;
        settings.time = None;
        cx.send(Command::SetLight(settings));
        cx.send(Command::Solve);
    }
}

/// Tells that the solver stopped before the light reached the target accuracy, until it is
/// closed.
pub fn show_inaccurate(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) {
    let lighting = &cx.app.lighting;
    let Some(solution) = lighting.solution.as_ref().filter(|_| lighting.is_current) else {
        return;
    };
    let target = percent(lighting.settings.error);
    let goal = format!("({} {target})", cx.tr("target"));
    let text = match &solution.report {
        Some(report) if report.error > SLACK * lighting.settings.error => {
            let words = cx.tr("The light is less accurate than the target: error");
            format!("{words} {} {goal}", percent(report.error))
        }
        // A preview that was left when the solver stopped; light of a file has no solver.
        None if lighting.began.is_some() => cx.tr("Stopped early: a rough solution.").to_owned(),
        _ => return,
    };
    let closed = Id::unique("closed inaccuracy");
    let number = Arc::as_ptr(solution) as usize;
    if ui.data(|d| d.get_temp(closed)) == Some(number) {
        return;
    }
    card(ui, rect, Align2::CENTER_TOP, "inaccurate", |ui| {
        ui.label(format!("⚠ {text}"));
        ui.horizontal_wrapped(|ui| {
            without_limit(ui, cx);
            if ui.button(cx.tr("Close")).clicked() {
                ui.data_mut(|d| d.insert_temp(closed, number));
            }
        });
    });
}

/// Tells that the saved mesh is finer than the model, and offers to keep the model's.
pub fn show_finer_mesh(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) {
    let Some(finer) = cx.app.finer_mesh.clone() else {
        return;
    };
    card(ui, rect, Align2::CENTER_BOTTOM, "finer mesh", |ui| {
        let [saved, model] = [finer.saved, finer.model].map(|n| count(n as u64));
        let words = cx.tr("Saved with its light on a finer mesh:");
        let [faces, than] = [cx.tr("faces"), cx.tr("instead of")];
        ui.label(format!("{words} {saved} {faces} {than} {model}."));
        ui.horizontal_wrapped(|ui| {
            let about = cx.tr("Solves the light on the vertices of the model and saves again.");
            let keep = ui.button(cx.tr("Keep the faces of the model"));
            if keep.on_hover_text(about).clicked() {
                cx.send(Command::KeepFaces);
            }
            if ui.button(cx.tr("Close")).clicked() {
                cx.send(Command::DismissFinerMesh);
            }
        });
    });
}

/// The last failure, in the middle of the viewport, until it is dismissed.
pub fn show_failure(ui: &mut Ui, rect: Rect, cx: &mut PanelContext) {
    let Some(failure) = cx.app.failure.clone() else {
        return;
    };
    card(ui, rect, Align2::CENTER_CENTER, "failure", |ui| {
        let color = ui.visuals().error_fg_color;
        ui.label(
            RichText::new(format!("⚠ {}", cx.tr("The operation failed")))
                .size(17.0)
                .strong()
                .color(color),
        );
        egui::ScrollArea::vertical()
            .max_height(0.5 * rect.height())
            .show(ui, |ui| {
                ui.add(egui::Label::new(&failure).wrap().selectable(true));
            });
        ui.horizontal(|ui| {
            if failure.contains(&SolveError::OutOfTime.to_string()) {
                without_limit(ui, cx);
            }
            let close = ui.button(cx.tr("Close"));
            if close.clicked() {
                cx.send(Command::DismissFailure);
            }
            if ui.button(cx.tr("Copy")).clicked() {
                ui.ctx().copy_text(failure.clone());
            }
        });
    });
}
