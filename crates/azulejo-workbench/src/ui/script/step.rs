//! The steps of a script, ready to be played.

use crate::app::App;
use crate::command::Command;
use crate::ui::PanelTab;
use crate::ui::lightmap::LightmapView;
use glam::DVec3;
use std::path::PathBuf;

/// Makes the commands of a step from the state when it is its turn.
pub(super) type MakeCommands = Box<dyn FnOnce(&App) -> Result<Vec<Command>, String>>;

/// A step, or what is wrong with its text.
pub(super) type StepResult = Result<ScriptStep, String>;

/// One step of a script. `docs/workbench/scripts.md` describes them all.
pub enum ScriptStep {
    /// Executes commands.
    Commands(StepCommands),
    /// Sets the size of the window in points.
    Size(f32, f32),
    /// Runs a menu entry by its English name.
    Action(String),
    /// Loads a reflection model into the selected material.
    LoadBrdf(PathBuf),
    /// Shows a tab of the properties.
    Tab(PanelTab),
    /// Opens the window with the lightmap for a view of a page, counted from 1, or closes it.
    ShowLightmap(Option<(LightmapView, u32)>),
    /// Pins a probe where the ray from one point toward another first meets a surface.
    Probe([DVec3; 2]),
    /// Computes the form factors of the patch where such a ray meets a surface.
    FormFactors([DVec3; 2]),
    /// Renders up to this many paths per pixel.
    Render(u32),
    /// Writes the window as PNG.
    Screenshot(PathBuf),
    /// Waits for some seconds, or until only a render is running.
    Wait(Option<f64>),
    /// Closes the window.
    Quit,
}

/// The commands of a step, which depend on the state when it is its turn.
pub struct StepCommands(MakeCommands);

impl StepCommands {
    /// The commands in this state.
    pub(super) fn make(self, app: &App) -> Result<Vec<Command>, String> {
        (self.0)(app)
    }
}

/// A step that executes commands.
pub(super) fn commands(
    make: impl FnOnce(&App) -> Result<Vec<Command>, String> + 'static,
) -> ScriptStep {
    ScriptStep::Commands(StepCommands(Box::new(make)))
}

/// A step that executes one command, whatever the state.
pub(super) fn command(command: Command) -> ScriptStep {
    commands(|_| Ok(vec![command]))
}
