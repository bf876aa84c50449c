//! The window: all its parts around an app.

mod closing;
mod panels;
mod place;

use super::actions::{self, ActionTarget, WindowAction};
use super::brdf::{apply_file, with_description};
use super::dialogs::{BakeDialog, BrdfFileChoice, Dialogs, NativeSupport, PrismDialog, TextDialog};
use super::focus::{self, FocusTrail};
use super::lab::LabPanel;
use super::lightmap::{LightmapView, LightmapWindow};
use super::material::MaterialPanel;
use super::panel_context::PanelContext;
use super::script::ScriptPlayer;
use super::tree::SceneTree;
use super::viewport::{DeviceLost, Viewport};
use super::{inspector, light, menu, messages, view_tab};
use crate::app::{App, Severity};
use crate::command::Command;
use crate::document::{Edit, SurfacePick};
use crate::ending::EndRequest;
#[cfg(target_arch = "wasm32")]
use crate::platform;
use crate::preferences::{Theme, WindowPlace};
use crate::variants::all;
use azulejo::output::Output;
use azulejo::scene::math::Ray;
use azulejo::trace::Progress;
use clap::ValueEnum;
use egui::{CentralPanel, Panel, Ui, ViewportCommand};
use panels::{PanelWidths, SidePanel};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

/// The tabs of the right panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PanelTab {
    /// Properties of the selection.
    #[default]
    Object,
    /// The material being edited.
    Material,
    /// The solver.
    Light,
    /// Display settings.
    View,
}

/// The window.
pub struct Workbench {
    /// The state that the window shows and changes.
    pub app: App,
    /// The active tab of the right panel.
    pub tab: PanelTab,
    viewport: Viewport,
    tree: SceneTree,
    dialogs: Dialogs,
    materials: MaterialPanel,
    lab: LabPanel,
    /// The window with the lightmap.
    pub lightmap: LightmapWindow,
    shows_messages: bool,
    /// Counts mouse presses: each is one gesture.
    press: u64,
    player: Option<ScriptPlayer>,
    was_focused: bool,
    focus: FocusTrail,
    dressed: Option<(Theme, f32)>,
    title: String,
    /// Whether the window closes at the user's request.
    is_leaving: bool,
    /// Where the window is, once that is known.
    place: Option<WindowPlace>,
    /// Whether a script has chosen the size of the window.
    is_sized_by_script: bool,
    /// The request of the system to end the program.
    ending: EndRequest,
    /// Receives the app if the window cannot stay open.
    rescue: Option<Sender<Box<Rescued>>>,
}

/// What is saved from a window that could not stay open.
pub struct Rescued {
    /// The state, with all that is not saved.
    pub app: App,
    /// The script with its remaining steps.
    pub player: Option<ScriptPlayer>,
    /// The cause, if it was a lost device.
    pub loss: Option<DeviceLost>,
}

/// The app is saved even during a panic: drivers panic when a GPU is unplugged, and so may this
/// code.
impl Drop for Workbench {
    fn drop(&mut self) {
        if !self.is_leaving {
            self.hand_over(None);
        }
    }
}

impl Workbench {
    /// Creates a window without a graphics device: everything but the image of the model works.
    pub fn new(app: App) -> Workbench {
        Workbench {
            app,
            tab: PanelTab::default(),
            viewport: Viewport::default(),
            tree: SceneTree::default(),
            dialogs: Dialogs::default(),
            materials: MaterialPanel::default(),
            lab: LabPanel::default(),
            lightmap: LightmapWindow::default(),
            shows_messages: false,
            press: 0,
            player: None,
            was_focused: true,
            focus: FocusTrail::default(),
            dressed: None,
            title: String::new(),
            is_leaving: false,
            place: None,
            is_sized_by_script: false,
            ending: EndRequest::default(),
            rescue: None,
        }
    }

    /// Creates a window of eframe around `viewport`, which uses the window's device.
    pub fn in_window(
        mut app: App,
        viewport: Viewport,
        context: &eframe::CreationContext<'_>,
    ) -> Workbench {
        place::bring_back(context, app.preferences.window);
        let egui = context.egui_ctx.clone();
        app.set_repaint(Arc::new(move || egui.request_repaint()));
        let mut window = Workbench::new(app);
        window.viewport = viewport;
        window.dialogs.set_native_files(NativeSupport::ask());
        window
    }

    /// Runs a script. It cannot operate the desktop's file dialogs, so there will be none.
    pub fn play(&mut self, player: ScriptPlayer) {
        self.dialogs.set_native_files(NativeSupport::default());
        self.player = Some(player);
    }

    /// Sets the receiver of the app for the case that the device is lost.
    pub fn rescue_to(&mut self, rescue: Sender<Box<Rescued>>) {
        self.rescue = Some(rescue);
    }

    /// Sets the size of the window in points for a script; it is not kept for the next session.
    pub fn resize_for_script(&mut self, context: &egui::Context, size: egui::Vec2) {
        self.is_sized_by_script = true;
        context.send_viewport_cmd(ViewportCommand::InnerSize(size));
    }

    /// Lets the window end at a request of the system.
    pub fn end_on(&mut self, request: EndRequest) {
        self.ending = request;
    }

    /// Whether a script is running.
    pub fn is_playing(&self) -> bool {
        self.player.is_some()
    }

    /// The size of the viewport in pixels.
    pub fn viewport_size(&self) -> (u32, u32) {
        self.viewport.size()
    }

    /// The displayed surface that a ray hits first.
    pub fn surface_at(&self, ray: &Ray) -> Option<SurfacePick> {
        self.viewport.patch_at(ray)
    }

    /// Runs one frame.
    pub fn show(&mut self, ui: &mut Ui) {
        if let Err(loss) = self.viewport.check() {
            // Before anything is painted: egui would panic on a lost device.
            self.on_device_lost(ui.ctx(), loss);
            return;
        }
        self.app.poll();
        self.end_if_asked(ui.ctx());
        self.dress(ui.ctx());
        self.open_dropped_files(ui.ctx());
        let mut targets = Vec::new();
        if !self.dialogs.is_open(&self.app) {
            targets = actions::pressed(ui.ctx(), &self.app);
        }
        let (commands, loss) = self.parts(ui, &mut targets);
        let (width, height) = self.viewport.size();
        self.app.view.aspect = f64::from(width) / f64::from(height);
        let acted = !commands.is_empty() || !targets.is_empty();
        commands.into_iter().for_each(|c| self.app.execute(c));
        targets.into_iter().for_each(|w| self.run_action(w));
        if let Some(loss) = loss {
            self.on_device_lost(ui.ctx(), loss);
        }
        let has_dialog = self.dialogs.is_open(&self.app);
        self.focus.end_frame(ui.ctx(), has_dialog);
        self.make_thumbnail();
        self.step_script(ui.ctx());
        self.schedule_repaint(ui.ctx(), acted);
        self.update_window(ui.ctx());
    }

    /// Draws all parts of the window; returns their commands, and a device loss.
    fn parts(
        &mut self,
        ui: &mut Ui,
        targets: &mut Vec<ActionTarget>,
    ) -> (Vec<Command>, Option<DeviceLost>) {
        let Workbench {
            app,
            viewport,
            tree,
            dialogs,
            lab,
            ..
        } = self;
        let (is_pressed, is_held) = ui.input(|i| {
            // A change in the frame in which the button is released belongs to the drag.
            let is_held = i.pointer.any_down() || i.pointer.any_released();
            (i.pointer.any_pressed(), is_held)
        });
        let writes = ui.ctx().text_edit_focused();
        self.press += u64::from(is_pressed);
        let mut cx = PanelContext {
            language: app.preferences.language,
            gesture: is_held.then_some(self.press),
            is_covered: dialogs.is_open(app),
            app,
            commands: Vec::new(),
        };
        let window = ui.available_width();
        Panel::top("menu").show(ui, |ui| {
            targets.extend(menu::show(ui, &mut cx));
            targets.extend(menu::tools(ui, &mut cx));
        });
        Panel::bottom("status").show(ui, |ui| {
            if messages::status(ui, &mut cx, viewport.probe()) {
                targets.push(ActionTarget::Window(WindowAction::Messages));
            }
        });
        if self.shows_messages {
            Panel::bottom("messages")
                .resizable(true)
                .default_size(130.0)
                .show(ui, |ui| messages::show(ui, &mut cx));
        }
        let widths = PanelWidths::of(&app.preferences, app.lab.is_open, window);
        let before = cx.commands.len();
        SidePanel::Tree.show(ui, &mut cx, widths, window, |ui, cx| tree.show(ui, cx));
        SidePanel::Lab.show(ui, &mut cx, widths, window, |ui, cx| lab.show(ui, cx));
        if let Some(tab) = tab_of_choice(&cx, &cx.commands[before..], self.tab) {
            self.tab = tab;
        }
        SidePanel::Properties.show(ui, &mut cx, widths, window, |ui, cx| {
            tabs(ui, &mut self.tab, cx);
            ui.separator();
            egui::ScrollArea::vertical()
                .id_salt(self.tab as u8)
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    match self.tab {
                        PanelTab::Object => inspector::show(ui, cx),
                        PanelTab::Material => self.materials.show(ui, cx),
                        PanelTab::Light => {
                            if light::show(ui, cx) {
                                targets.push(ActionTarget::Window(WindowAction::AddProbe));
                            }
                        }
                        PanelTab::View => view_tab::show(ui, cx),
                    }
                    focus::follow(ui);
                });
        });
        let shown = CentralPanel::no_frame().show(ui, |ui| viewport.show(ui, &mut cx));
        self.lightmap.show(ui, &mut cx);
        let chosen = dialogs.show(ui, &mut cx);
        let commands = cx.commands;
        // A press elsewhere ends typing, and is itself not part of it.
        self.press += u64::from(is_pressed && writes);
        if let Some(chosen) = chosen {
            self.use_brdf_file(chosen);
        }
        match shown.inner {
            Ok(chosen) => targets.extend(chosen),
            Err(loss) => return (commands, Some(loss)),
        }
        (commands, None)
    }

    /// Executes an action.
    pub fn run_action(&mut self, target: ActionTarget) {
        match target {
            ActionTarget::Command(command) => self.execute_action(command),
            ActionTarget::Window(WindowAction::Keys) => self.dialogs.keys = true,
            ActionTarget::Window(WindowAction::Preferences) => self.dialogs.preferences = true,
            ActionTarget::Window(WindowAction::About) => self.dialogs.about = true,
            ActionTarget::Window(WindowAction::Messages) => {
                self.shows_messages = !self.shows_messages
            }
            ActionTarget::Window(WindowAction::Prism) => {
                self.dialogs.prism = Some(PrismDialog::new(self.app.default_size()));
            }
            ActionTarget::Window(WindowAction::Text) => {
                let size = 0.25 * self.app.default_size();
                self.dialogs.text = Some(TextDialog::new(size));
            }
            ActionTarget::Window(WindowAction::Bake) => {
                self.dialogs.bake = Some(BakeDialog::new(self.app.lightmap.settings));
            }
            ActionTarget::Window(WindowAction::ToggleLightmap) => self.lightmap.toggle(),
            ActionTarget::Window(WindowAction::TaskPlane) => {
                self.tab = PanelTab::Light;
                self.app.execute(Command::AddTaskPlane);
            }
            ActionTarget::Window(WindowAction::AddProbe) => match self.viewport.pointed_surface() {
                Some(place) => self.app.execute(Command::AddProbe(place)),
                None => self.viewport.pins_next = true,
            },
            ActionTarget::Window(WindowAction::Rename) => {
                self.show_tree();
                self.tree.begin_rename(&self.app);
            }
            ActionTarget::Window(WindowAction::ToggleRender) => {
                let (width, height) = self.viewport.size();
                self.app.execute(match self.app.render {
                    Some(_) => Command::CloseRender,
                    None => Command::Render {
                        width,
                        height,
                        paths: None,
                    },
                });
            }
        }
    }

    /// Executes a command of the menus; what it adds shows its properties.
    fn execute_action(&mut self, command: Command) {
        let count = |app: &App| app.document.objects.len() + app.document.lights.len();
        let (before, selected) = (count(&self.app), self.app.selection.ids.clone());
        self.app.execute(command);
        if count(&self.app) > before && self.app.selection.ids != selected {
            self.tab = PanelTab::Object;
        }
    }

    /// Shows the tree of the scene, in which things are renamed.
    fn show_tree(&mut self) {
        self.app.execute(Command::ShowLab(None));
        if !self.app.preferences.shows_tree {
            let mut preferences = self.app.preferences.clone();
            preferences.shows_tree = true;
            let command = Command::SetPreferences(Box::new(preferences));
            self.app.execute(command);
        }
    }

    /// Keeps a small picture of a file that was opened or saved, once the viewport shows all of it.
    fn make_thumbnail(&mut self) {
        if self.app.is_blank() || !self.app.jobs().is_empty() || self.app.render.is_some() {
            return;
        }
        if let Some(path) = self.app.thumbnail_wanted.take()
            && let Some((width, height, rgb)) = self.viewport.pixels()
        {
            self.app.thumbnails.store(&path, width, height, &rgb);
        }
    }

    /// Opens the window with the lightmap for a view of a page, counted from 1, or closes it.
    ///
    /// # Errors
    ///
    /// A message if there is no such page.
    pub fn show_lightmap(&mut self, shown: Option<(LightmapView, u32)>) -> Result<(), String> {
        self.lightmap.is_open = shown.is_some();
        if let Some((quantity, page)) = shown {
            let result = self.app.lightmap.result.as_ref();
            let count = result.map_or(0, |r| r.baked.lightmap.pages.len());
            let page = page as usize;
            if !(1..=count).contains(&page) {
                return Err(format!("page {page} of a lightmap of {count}"));
            }
            (self.lightmap.view.quantity, self.lightmap.view.page) = (quantity, page - 1);
        }
        Ok(())
    }

    /// Loads or saves a reflection model.
    fn use_brdf_file(&mut self, chosen: BrdfFileChoice) {
        let done = match chosen {
            BrdfFileChoice::LoadBrdf(path) => self.load_brdf(&path),
            BrdfFileChoice::SaveBrdf(path) => self.save_brdf(&path),
        };
        if let Err(why) = done {
            self.app.report(Severity::Error, why);
        }
    }

    /// Loads a reflection model from a file into the selected material.
    ///
    /// # Errors
    ///
    /// A message with the reason.
    pub fn load_brdf(&mut self, path: &Path) -> Result<(), String> {
        let id = self.app.selection.material;
        let id = id.ok_or("no material is selected")?;
        let material = self.app.document.materials.get(id as usize);
        let material = material.ok_or("the material no longer exists")?;
        let bytes = azulejo::models::read_bytes(path).map_err(|e| e.to_string())?;
        let file = apply_file(&bytes, path)?;
        let new = with_description(material, file.description).map_err(|e| e.to_string())?;
        for warning in file.warnings {
            self.app.report(Severity::Warning, warning);
        }
        let edit = Edit::SetMaterial(id, new);
        self.app.execute(Command::Edit(edit, None));
        Ok(())
    }

    fn save_brdf(&mut self, path: &Path) -> Result<(), String> {
        let text = self.materials.saving.take();
        let text = text.ok_or("nothing waits to be saved")?;
        let path = match path.extension() {
            Some(_) => path.to_owned(),
            None => path.with_extension("brdf"),
        };
        let output = Output::check(&path).map_err(|e| e.to_string())?;
        output
            .write(&Progress::new(), |out| out.write_all(text.as_bytes()))
            .map_err(|e| e.to_string())?;
        let note = format!("{}: {}", path.display(), self.app.tr("saved"));
        self.app.report(Severity::Note, note);
        Ok(())
    }

    fn open_dropped_files(&mut self, context: &egui::Context) {
        let dropped = context.input(|i| i.raw.dropped_files.clone());
        #[cfg(not(target_arch = "wasm32"))]
        self.open_files(dropped.iter().map(|f| f.path().to_owned()).collect());
        #[cfg(target_arch = "wasm32")]
        self.open_arrived(&dropped, context);
    }

    /// Reads what is dropped on the page, and opens what has been read.
    #[cfg(target_arch = "wasm32")]
    fn open_arrived(&mut self, dropped: &[egui::DroppedFileHandle], context: &egui::Context) {
        let files = dropped
            .iter()
            .filter_map(|f| f.web_file().cloned())
            .collect::<Vec<_>>();
        if !files.is_empty() {
            let context = context.clone();
            platform::read_dropped(files, move || context.request_repaint());
        }
        for arrived in platform::take_dropped() {
            for error in arrived.errors {
                self.app.report(Severity::Error, error);
            }
            self.open_files(arrived.paths);
        }
    }

    /// Opens files, or adds them to what is there.
    fn open_files(&mut self, paths: Vec<PathBuf>) {
        if paths.is_empty() {
            return;
        }
        let is_empty = self.app.document.objects.is_empty();
        self.app.execute(if is_empty {
            Command::Open(paths)
        } else {
            Command::Add(paths)
        });
    }

    fn dress(&mut self, context: &egui::Context) {
        let style = (self.app.preferences.theme, self.app.preferences.scale);
        if self.dressed == Some(style) {
            return;
        }
        context.set_theme(match style.0 {
            Theme::System => egui::ThemePreference::System,
            Theme::Light => egui::ThemePreference::Light,
            Theme::Dark => egui::ThemePreference::Dark,
        });
        context.set_zoom_factor(style.1);
        // The text size is set in the preferences; Ctrl with digits selects a shading mode.
        context.options_mut(|options| {
            options.zoom_with_keyboard = false;
            // Commit typed text before the click that leaves the field takes effect.
            options.input_options.surrender_focus_on = egui::SurrenderFocusOn::Presses;
        });
        self.dressed = Some(style);
    }

    /// Passes the app to the next window, and closes this one.
    fn on_device_lost(&mut self, context: &egui::Context, loss: DeviceLost) {
        if self.rescue.is_none() {
            self.app.report(Severity::Error, loss.0.to_string());
            self.viewport = Viewport::default();
            return;
        }
        self.hand_over(Some(loss));
        context.send_viewport_cmd(ViewportCommand::Close);
    }

    /// Passes all state to the code that opens the next window.
    fn hand_over(&mut self, loss: Option<DeviceLost>) {
        if let Some(rescue) = self.rescue.take() {
            let app = std::mem::replace(&mut self.app, App::quiet());
            let player = self.player.take();
            let _ = rescue.send(Box::new(Rescued { app, player, loss }));
        }
    }

    fn step_script(&mut self, context: &egui::Context) {
        if let Some(mut player) = self.player.take() {
            let goes_on = player.step(self, context);
            context.request_repaint_after(player.rest());
            if goes_on {
                self.player = Some(player);
            } else if player.has_failed() {
                // The caller waits for the exit status.
                self.app.allow_close();
            }
        }
    }

    /// Schedules the next frame: at once after a command, periodically while jobs run.
    fn schedule_repaint(&mut self, context: &egui::Context, acted: bool) {
        if acted {
            context.request_repaint();
        }
        if self.app.jobs().iter().any(|j| !j.progress.is_paused()) {
            // Often enough for bars that move; a software driver takes the solver's processors.
            context.request_repaint_after(Duration::from_millis(250));
        }
        if let Some(rest) = self.app.repaint_after() {
            context.request_repaint_after(rest);
        }
    }
}

impl eframe::App for Workbench {
    fn ui(&mut self, ui: &mut Ui, frame: &mut eframe::Frame) {
        self.note_place(frame);
        self.show(ui);
        self.dialogs.open_native_files(frame, ui.ctx());
    }

    /// A hidden window is not drawn, but its jobs continue.
    fn logic(&mut self, context: &egui::Context, _: &mut eframe::Frame) {
        self.app.poll();
        #[cfg(target_arch = "wasm32")]
        platform::download_saved();
        self.end_if_asked(context);
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }
}

/// The tab that shows what was chosen in the tree, unless one that is open does.
fn tab_of_choice(cx: &PanelContext, sent: &[Command], open: PanelTab) -> Option<PanelTab> {
    let chosen = sent.iter().find_map(|command| match command {
        Command::Select(selection) => Some(selection),
        _ => None,
    })?;
    if chosen.material != cx.app.selection.material && chosen.ids == cx.app.selection.ids {
        return Some(PanelTab::Material);
    }
    let is_empty = chosen.ids.is_empty();
    let shows_it = matches!(open, PanelTab::Object | PanelTab::Material);
    (!is_empty && !shows_it).then_some(PanelTab::Object)
}

/// The tabs, in as many rows as they need.
fn tabs(ui: &mut Ui, chosen: &mut PanelTab, cx: &PanelContext) {
    ui.horizontal_wrapped(|ui| {
        for tab in all() {
            ui.selectable_value(chosen, tab, tab_name(tab, cx));
        }
    });
}

fn tab_name(tab: PanelTab, cx: &PanelContext) -> &'static str {
    match tab {
        PanelTab::Object => cx.tr("Object"),
        PanelTab::Material => cx.tr("Material"),
        PanelTab::Light => cx.tr("Light"),
        PanelTab::View => cx.tr("View"),
    }
}
