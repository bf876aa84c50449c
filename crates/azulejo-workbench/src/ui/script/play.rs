//! Running a script in a window.

use super::step::ScriptStep;
use crate::app::{App, Severity};
use crate::command::Command;
use crate::document::SurfacePick;
use crate::jobs::JobKind;
use crate::ui::Workbench;
use crate::ui::actions::ACTIONS;
use azulejo::output::Output;
use azulejo::scene::math::Ray;
use azulejo::trace::Progress;
use azulejo::trace::time::{Duration, Instant};
use egui::{ColorImage, ScreenshotCallback, ViewportCommand};
use glam::DVec3;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};

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
    /// This many more frames, in which the layout settles, whatever runs.
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
/// The same while only jobs are waited for: a software driver draws a frame in about this time.
const JOB_REST: Duration = Duration::from_millis(200);
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
            Some(WaitCondition::Jobs(0)) => JOB_REST,
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
        if matches!(step, ScriptStep::Quit) {
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
            Some(WaitCondition::Samples(target)) => {
                let samples = app.render.as_ref().map_or(0, |p| p.samples);
                if samples < *target && !app.is_busy(JobKind::Render) {
                    return Err(format!("{samples} paths per pixel, expected {target}"));
                }
                samples < *target
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
        match step {
            ScriptStep::Size(w, h) => {
                window.resize_for_script(context, egui::vec2(w, h));
            }
            ScriptStep::Screenshot(path) => return Ok(screenshot(path, context)),
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
            }
            ScriptStep::LoadBrdf(path) => window.load_brdf(&path)?,
            ScriptStep::ShowLightmap(shown) => window.show_lightmap(shown)?,
            ScriptStep::Probe([from, toward]) => {
                let pick = surface(window, from, toward)?;
                window.app.execute(Command::AddProbe(pick));
            }
            ScriptStep::FormFactors([from, toward]) => {
                let pick = surface(window, from, toward)?;
                window.app.execute(Command::FormFactorsFrom(pick));
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
            ScriptStep::Commands(step) => {
                let commands = step.make(&window.app)?;
                commands.into_iter().for_each(|c| window.app.execute(c));
            }
            // The caller ends the script.
            ScriptStep::Quit => {}
        }
        // The effect is visible a few frames later; a job that was started takes longer.
        Ok(WaitCondition::Jobs(SETTLE))
    }
}

fn screenshot(path: PathBuf, context: &egui::Context) -> WaitCondition {
    let (send, picture) = channel();
    let callback = ScreenshotCallback::new(move |image| {
        // The script may have ended meanwhile.
        let _ = send.send(image);
    });
    context.send_viewport_cmd(ViewportCommand::Screenshot(callback));
    WaitCondition::Screenshot(path, Instant::now(), picture)
}

/// The surface that is displayed where the ray from one point toward another first meets one.
fn surface(window: &Workbench, from: DVec3, toward: DVec3) -> Result<SurfacePick, String> {
    let direction = (toward - from).try_normalize();
    let direction = direction.ok_or("both points are the same")?;
    let pick = window.surface_at(&Ray::new(from, direction));
    pick.ok_or_else(|| "there is no surface in this direction".to_owned())
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
