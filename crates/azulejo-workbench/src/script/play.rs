//! Running a script in a window.

use super::parse::ScriptStep;
use crate::app::{App, Severity};
use crate::command::{Command, Selection};
use crate::document::{Edit, ItemId};
use crate::jobs::JobKind;
use crate::ui::Workbench;
use crate::ui::actions::ACTIONS;
use crate::ui::brdf::with_description;
use azulejo::output::Output;
use azulejo::scene::brdf::Description;
use azulejo::scene::{Camera, Material, Rgb};
use azulejo::trace::Progress;
use egui::{ColorImage, ScreenshotCallback, ViewportCommand};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Runs a script in a window, step by step.
pub struct ScriptPlayer {
    steps: VecDeque<(usize, ScriptStep)>,
    name: String,
    waits: Option<WaitCondition>,
    /// Number of errors reported before the step.
    errors_before: u64,
    line: usize,
    outcome: Arc<Mutex<Option<Result<(), String>>>>,
}

/// The condition that ends a step.
enum WaitCondition {
    /// At least this many more frames, and then until only a render is running.
    Jobs(u32),
    /// This many more frames, in which the layout settles.
    Frames(u32),
    /// A point in time.
    Until(Instant),
    /// This many paths per pixel.
    Samples(u32),
    /// A screenshot for this file, requested at this time.
    Screenshot(PathBuf, Instant, Receiver<Arc<ColorImage>>),
}

/// Frames in which the layout settles and jobs deliver their results.
const SETTLE: u32 = 4;
/// Interval between checks of the condition.
const REST: Duration = Duration::from_millis(30);
/// Timeout of a screenshot.
const PATIENCE: Duration = Duration::from_secs(60);

impl ScriptPlayer {
    /// Runs `steps` of the script `name`, which is used in messages. Relative paths start at the
    /// current folder of the process.
    pub fn new(steps: Vec<(usize, ScriptStep)>, name: &str) -> ScriptPlayer {
        ScriptPlayer {
            steps: steps.into(),
            name: name.to_owned(),
            waits: Some(WaitCondition::Frames(SETTLE)),
            errors_before: 0,
            line: 0,
            outcome: Arc::default(),
        }
    }

    /// Receives the outcome of the script: `Ok`, or an error message.
    pub fn outcome(&self) -> Arc<Mutex<Option<Result<(), String>>>> {
        Arc::clone(&self.outcome)
    }

    /// How long the window may wait before the next check: while a job is running, drawing would
    /// take its processors.
    pub fn rest(&self) -> Duration {
        match self.waits {
            None | Some(WaitCondition::Frames(_)) => Duration::ZERO,
            Some(_) => REST,
        }
    }

    /// Whether a step failed.
    pub fn has_failed(&self) -> bool {
        let outcome = self.outcome.lock();
        outcome.is_ok_and(|o| matches!(*o, Some(Err(_))))
    }

    /// Runs the script as far as the frame allows; returns `false` at its end.
    pub fn step(&mut self, window: &mut Workbench, context: &egui::Context) -> bool {
        if let Some(why) = self.failure(&window.app) {
            return self.end(Err(why));
        }
        match self.still_waits(window) {
            Ok(true) => return true,
            Ok(false) => self.waits = None,
            Err(why) => return self.end(Err(why)),
        }
        let Some((line, step)) = self.steps.pop_front() else {
            return self.end(Ok(()));
        };
        self.line = line;
        self.errors_before = window.app.errors;
        if step == ScriptStep::Quit {
            window.app.execute(Command::Discard);
            window.app.allow_close();
            return self.end(Ok(()));
        }
        match self.begin(step, window, context) {
            Ok(wait) => self.waits = Some(wait),
            Err(why) => return self.end(Err(why)),
        }
        true
    }

    fn end(&mut self, result: Result<(), String>) -> bool {
        let result = result.map_err(|why| format!("{}:{}: {why}", self.name, self.line));
        if let Ok(mut outcome) = self.outcome.lock() {
            *outcome = Some(result);
        }
        false
    }

    /// The first error reported since the step began.
    fn failure(&self, app: &App) -> Option<String> {
        if app.question.is_some() {
            return Some("a question is open that a script cannot answer: save first".into());
        }
        if app.asking.is_some() {
            return Some("a dialog is open that a script cannot answer".into());
        }
        if app.errors == self.errors_before {
            return None;
        }
        let errors = app
            .messages
            .iter()
            .rev()
            .filter(|m| m.level == Severity::Error);
        let last = errors.map(|m| m.text.clone()).next();
        Some(last.unwrap_or_else(|| "a job failed".into()))
    }

    fn still_waits(&mut self, window: &Workbench) -> Result<bool, String> {
        let app = &window.app;
        Ok(match &mut self.waits {
            None => false,
            // Nothing waits for a render, which may take long.
            Some(WaitCondition::Jobs(frames)) => {
                *frames = frames.saturating_sub(1);
                *frames > 0 || app.jobs().iter().any(|j| j.kind != JobKind::Render)
            }
            Some(WaitCondition::Frames(left)) => {
                *left = left.saturating_sub(1);
                *left > 0
            }
            Some(WaitCondition::Until(moment)) => Instant::now() < *moment,
            Some(WaitCondition::Samples(wanted)) => {
                let found = app.render.as_ref().map_or(0, |p| p.samples);
                if found < *wanted && !app.is_busy(JobKind::Render) {
                    return Err(format!("{found} paths per pixel, expected {wanted}"));
                }
                found < *wanted
            }
            Some(WaitCondition::Screenshot(path, since, picture)) => match picture.try_recv() {
                Ok(image) => {
                    write_png(path, &image)?;
                    false
                }
                Err(_) if since.elapsed() > PATIENCE => {
                    return Err("no screenshot was received".into());
                }
                Err(_) => true,
            },
        })
    }

    fn begin(
        &self,
        step: ScriptStep,
        window: &mut Workbench,
        context: &egui::Context,
    ) -> Result<WaitCondition, String> {
        let settle = WaitCondition::Frames(SETTLE);
        match step {
            ScriptStep::Size(w, h) => {
                context.send_viewport_cmd(ViewportCommand::InnerSize(egui::vec2(w, h)));
            }
            ScriptStep::Screenshot(path) => {
                let (send, picture) = channel();
                let callback = ScreenshotCallback::new(move |image| {
                    // The script may have ended meanwhile.
                    let _ = send.send(image);
                });
                context.send_viewport_cmd(ViewportCommand::Screenshot(callback));
                return Ok(WaitCondition::Screenshot(path, Instant::now(), picture));
            }
            ScriptStep::Wait(None) => return Ok(WaitCondition::Jobs(0)),
            ScriptStep::Wait(Some(seconds)) => {
                let until = Instant::now() + Duration::from_secs_f64(seconds);
                return Ok(WaitCondition::Until(until));
            }
            ScriptStep::Tab(tab) => window.tab = tab,
            ScriptStep::Action(name) => {
                let action = ACTIONS.iter().find(|a| a.label == name);
                let target = action.and_then(|a| (a.target)(&window.app));
                let target = target.ok_or_else(|| format!("\"{name}\" is not available now"))?;
                window.run_action(target);
                // Its effect is visible a few frames later; a job that it started takes longer.
                return Ok(WaitCondition::Jobs(SETTLE));
            }
            ScriptStep::Render(samples) => {
                let (width, height) = window.viewport_size();
                window.app.execute(Command::Render {
                    width,
                    height,
                    paths: Some(samples),
                });
                return Ok(WaitCondition::Samples(samples));
            }
            other => return run(&mut window.app, other),
        }
        Ok(settle)
    }
}

/// Steps that do not need the window.
fn run(app: &mut App, step: ScriptStep) -> Result<WaitCondition, String> {
    let settle = Ok(WaitCondition::Frames(SETTLE));
    match step {
        ScriptStep::Open(path) => {
            app.execute(Command::Open(vec![path]));
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::Add(path) => {
            app.execute(Command::Add(vec![path]));
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::Save(path) => {
            app.execute(Command::SaveAs(path));
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::Export(path) => {
            app.execute(Command::Export(path));
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::SaveRender(path) => {
            app.execute(Command::SaveRender(path));
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::Solve(error) => {
            if let Some(error) = error {
                // A script that specifies an error wants it reached, however long it takes.
                let settings = crate::first_pass::LightSettings {
                    error,
                    time: None,
                    ..app.lighting.settings
                };
                app.execute(Command::SetLight(settings));
            }
            app.execute(Command::Solve);
            return Ok(WaitCondition::Jobs(0));
        }
        ScriptStep::Patches(patches) => {
            let settings = crate::first_pass::LightSettings {
                patches,
                ..app.lighting.settings
            };
            app.execute(Command::SetLight(settings));
        }
        ScriptStep::Select(name) => select(app, &name)?,
        ScriptStep::Shading(shading) => change_view(app, |view| view.shading = shading),
        ScriptStep::View(side) => {
            let (bounds, up) = (app.document.bounds(None), app.document.units.up);
            change_view(app, |view| match side {
                Some(side) => view.view_from(side, bounds, up),
                None => view.frame(bounds),
            });
        }
        ScriptStep::Camera(eye, target) => change_view(app, |view| {
            view.camera = Camera {
                eye,
                target,
                ..view.camera.clone()
            };
        }),
        other => return change(app, other).map(|()| WaitCondition::Frames(SETTLE)),
    }
    settle
}

/// Steps that edit the document.
fn change(app: &mut App, step: ScriptStep) -> Result<(), String> {
    let ids = app.selection.ids.clone();
    let edit = match step {
        ScriptStep::Rename(name) => match ids[..] {
            [id] => Edit::Rename(id, name),
            _ => return Err(format!("{} items are selected, expected one", ids.len())),
        },
        ScriptStep::Move(by) => Edit::Transform(some(ids)?, DAffine3::from_translation(by)),
        ScriptStep::Scale(factor) => {
            let map = DAffine3::from_scale(DVec3::splat(factor));
            Edit::Transform(some(ids)?, about(app, map))
        }
        ScriptStep::Turn(degrees) => {
            let [x, y, z] = degrees.to_array().map(f64::to_radians);
            let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y);
            let turn = turn * DMat3::from_rotation_x(x);
            Edit::Transform(some(ids)?, about(app, DAffine3::from_mat3(turn)))
        }
        ScriptStep::MaterialNew(name) => {
            let white = Material::diffuse(name, Rgb::grey(0.7));
            app.execute(Command::Edit(Edit::AddMaterial(white), None));
            let new = (app.document.materials.len() - 1) as u32;
            app.execute(Command::Edit(Edit::Assign(some(ids.clone())?, new), None));
            app.execute(Command::Select(Selection {
                ids,
                material: Some(new),
                ..Selection::default()
            }));
            return Ok(());
        }
        ScriptStep::MaterialBrdf(text) => {
            let description: Description = text.parse().map_err(|e| format!("{e}"))?;
            return set_material(app, |material| {
                with_description(material, description).map_err(|e| e.to_string())
            });
        }
        ScriptStep::MaterialColor(c) => {
            return set_material(app, |m| {
                Ok(Material {
                    emission: m.emission,
                    emits_back: m.emits_back,
                    ..Material::diffuse(m.name.clone(), Rgb::new(c.x, c.y, c.z))
                })
            });
        }
        ScriptStep::MaterialEmit(c) => {
            return set_material(app, |m| {
                Ok(Material {
                    emission: Rgb::new(c.x, c.y, c.z),
                    ..m.clone()
                })
            });
        }
        other => return Err(format!("{other:?} is not an edit of the document")),
    };
    app.execute(Command::Edit(edit, None));
    Ok(())
}

fn some(ids: Vec<ItemId>) -> Result<Vec<ItemId>, String> {
    if ids.is_empty() {
        Err("nothing is selected".into())
    } else {
        Ok(ids)
    }
}

/// Applies a map about the centre of the selection.
fn about(app: &App, map: DAffine3) -> DAffine3 {
    let centre = app.document.bounds(Some(&app.selection.ids)).centre();
    DAffine3::from_translation(centre) * map * DAffine3::from_translation(-centre)
}

fn set_material(
    app: &mut App,
    change: impl FnOnce(&Material) -> Result<Material, String>,
) -> Result<(), String> {
    let id = app.selection.material.ok_or("no material is selected")?;
    let old = app.document.materials.get(id as usize);
    let new = change(old.ok_or("the material is gone")?)?;
    app.execute(Command::Edit(Edit::SetMaterial(id, new), None));
    Ok(())
}

fn change_view(app: &mut App, change: impl FnOnce(&mut crate::view::ModelView)) {
    let mut view = app.view.clone();
    change(&mut view);
    app.execute(Command::SetView(Box::new(view)));
}

fn select(app: &mut App, name: &str) -> Result<(), String> {
    match name {
        "all" => app.execute(Command::SelectAll),
        "nothing" => app.execute(Command::Select(Selection::default())),
        name => {
            let ids = named(app, name);
            if ids.is_empty() {
                return Err(format!("nothing is named \"{name}\""));
            }
            app.execute(Command::Select(Selection {
                ids,
                ..Selection::default()
            }));
        }
    }
    Ok(())
}

/// The objects, lights and cameras with this name, or with this last component of their name.
fn named(app: &App, name: &str) -> Vec<ItemId> {
    let document = &app.document;
    let items = document.objects.iter().map(|i| (i.id, &i.name));
    let lights = document.lights.iter().map(|l| (l.id, &l.light.name));
    let cameras = document.cameras.iter().map(|c| (c.id, &c.camera.name));
    let all = items.chain(lights).chain(cameras);
    let is_it = |n: &str| n == name || n.rsplit('/').next() == Some(name);
    all.filter(|(_, n)| is_it(n)).map(|(id, _)| id).collect()
}

fn write_png(path: &Path, image: &ColorImage) -> Result<(), String> {
    let [width, height] = image.size.map(|n| n as u32);
    let rgb: Vec<u8> = (image.pixels.iter())
        .flat_map(|p| [p.r(), p.g(), p.b()])
        .collect();
    let output = Output::check(path).map_err(|e| e.to_string())?;
    output
        .write(&Progress::new(), |out| {
            azulejo::formats::picture::png::write(width, height, &rgb, out)
        })
        .map_err(|e| e.to_string())
}
