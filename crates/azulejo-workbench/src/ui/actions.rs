//! All actions of menus and keyboard shortcuts in one table, which the list of shortcuts uses too.

use super::material_actions::duplicate;
use crate::app::App;
use crate::command::{Command, FileRequest, Selection};
use crate::document::{Edit, ItemId, NewLightKind, NewShapeKind};
use crate::jobs::JobKind;
use crate::platform::IS_PAGE;
use crate::preferences::Preferences;
use crate::view::{Comparison, SectionPlane, Shading, ViewDirection};
use crate::words::Language;
use azulejo::scene::MaterialId;
use clap::ValueEnum;
use egui::{Event, Key, KeyboardShortcut, Modifiers};

/// A menu entry with an optional shortcut.
pub struct Action {
    /// The menu that contains it.
    pub menu: Menu,
    /// Its English label, which is its name in scripts, too.
    pub label: &'static str,
    /// The keys that choose it.
    pub key: Option<KeyboardShortcut>,
    /// What it does in the current state; `None` if it is disabled.
    pub target: fn(&App) -> Option<ActionTarget>,
    /// Whether it is on, for what is switched on and off.
    pub is_on: Option<fn(&App) -> bool>,
}

impl Action {
    /// Whether a page in a browser cannot do it, and this is one.
    pub fn lacks_page(&self) -> bool {
        IS_PAGE && matches!(self.label, "Bake a lightmap…" | "Pause" | "Quit" | "Resume")
    }

    const fn ticked(mut self, is_on: fn(&App) -> bool) -> Action {
        self.is_on = Some(is_on);
        self
    }
}

/// The target of an action.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are a few at a time, and none is stored"
)]
pub enum ActionTarget {
    /// A command for the app.
    Command(Command),
    /// A function of the window.
    Window(WindowAction),
}

/// Actions of the window itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowAction {
    /// Shows the shortcuts.
    Keys,
    /// Opens the preferences.
    Preferences,
    /// Opens the dialog for solid text.
    Text,
    /// Opens the dialog for a prism.
    Prism,
    /// Shows information about azulejo.
    About,
    /// Shows or hides the message list.
    Messages,
    /// Renders the view, or returns to the viewport.
    ToggleRender,
    /// Renames the selection.
    Rename,
    /// Opens the dialog for a lightmap.
    Bake,
    /// Shows the lightmap, or hides it.
    ToggleLightmap,
    /// Measures the task plane and shows its figures.
    TaskPlane,
    /// Pins a probe at the surface point under the mouse, or else at the next click.
    AddProbe,
}

/// A menu of the menu bar, or a submenu.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Menu {
    /// Opening and saving, recipes and preferences.
    File,
    /// Undo, the selection and its changes.
    Edit,
    /// New objects.
    Add,
    /// Camera and display settings.
    View,
    /// Shading modes; a submenu of View.
    Shading,
    /// The solver, probes and lightmaps.
    Light,
    /// Shortcuts, messages, and what azulejo is.
    Help,
}

impl Menu {
    /// Its title in the menu bar.
    pub fn label(self, language: Language) -> &'static str {
        match self {
            Menu::File => language.tr("File"),
            Menu::Edit => language.tr("Edit"),
            Menu::Add => language.tr("Add"),
            Menu::View => language.tr("View"),
            Menu::Shading => language.tr("Shading"),
            Menu::Light => language.tr("Light"),
            Menu::Help => language.tr("Help"),
        }
    }
}

const fn key(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::SHIFT, key))
}

const fn alt(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::ALT, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        key,
    ))
}

const fn action(
    menu: Menu,
    label: &'static str,
    key: Option<KeyboardShortcut>,
    target: fn(&App) -> Option<ActionTarget>,
) -> Action {
    Action {
        menu,
        label,
        key,
        target,
        is_on: None,
    }
}

fn done(command: Command) -> Option<ActionTarget> {
    Some(ActionTarget::Command(command))
}

fn enabled_if(holds: bool, command: Command) -> Option<ActionTarget> {
    holds.then_some(ActionTarget::Command(command))
}

fn edit(edit: Edit) -> Option<ActionTarget> {
    done(Command::Edit(edit, None))
}

fn selected(app: &App, make: impl Fn(Vec<ItemId>) -> Edit) -> Option<ActionTarget> {
    let ids = &app.selection.ids;
    (!ids.is_empty()).then(|| ActionTarget::Command(Command::Edit(make(ids.clone()), None)))
}

fn hide(ids: Vec<ItemId>, hidden: bool) -> Option<ActionTarget> {
    enabled_if(
        !ids.is_empty(),
        Command::Edit(Edit::Hide(ids, hidden), None),
    )
}

/// The material selected in the tree, if nothing else is selected: shortcuts apply to it then.
fn chosen_material(app: &App) -> Option<MaterialId> {
    let material = app.selection.material;
    material.filter(|_| app.selection.is_empty())
}

fn change_view(
    app: &App,
    change: impl FnOnce(&mut crate::view::ModelView),
) -> Option<ActionTarget> {
    let mut view = app.view.clone();
    change(&mut view);
    done(Command::SetView(Box::new(view)))
}

fn change_preferences(app: &App, change: impl FnOnce(&mut Preferences)) -> Option<ActionTarget> {
    let mut preferences = app.preferences.clone();
    change(&mut preferences);
    done(Command::SetPreferences(Box::new(preferences)))
}

fn shade(app: &App, shading: Shading) -> Option<ActionTarget> {
    change_view(app, |view| view.shading = shading)
}

fn from(app: &App, side: ViewDirection) -> Option<ActionTarget> {
    let bounds = app.document.model_bounds();
    let up = app.document.units.up;
    change_view(app, |view| view.view_from(side, bounds, up))
}

/// The label of an action in the language of the window, with the edit that undo or redo applies
/// to.
pub fn label(app: &App, action: &Action) -> String {
    let name = app.preferences.language.tr(action.label);
    let (undo, redo) = app.undo_texts();
    match (action.label, undo, redo) {
        ("Undo", Some(what), _) | ("Redo", _, Some(what)) => format!("{name}: {what}"),
        _ => name.to_owned(),
    }
}

/// The menu entry of a shading mode.
pub fn shading_action(app: &App, shading: Shading) -> Option<&'static Action> {
    (ACTIONS.iter().filter(|a| a.menu == Menu::Shading)).find(|action| {
        let target = (action.target)(app);
        matches!(target, Some(ActionTarget::Command(Command::SetView(view))) if view.shading == shading)
    })
}

/// All actions in the order of the menus.
pub const ACTIONS: &[Action] = &[
    action(Menu::File, "New", ctrl(Key::N), |_| done(Command::New)),
    action(Menu::File, "Open…", ctrl(Key::O), |_| {
        done(Command::RequestFile(FileRequest::Open))
    }),
    action(Menu::File, "Add…", ctrl_shift(Key::O), |_| {
        done(Command::RequestFile(FileRequest::Add))
    }),
    action(Menu::File, "Save", ctrl(Key::S), |a| {
        enabled_if(
            !a.document.objects.is_empty() || a.is_changed(),
            Command::Save,
        )
    }),
    action(Menu::File, "Save as…", ctrl_shift(Key::S), |_| {
        done(Command::RequestFile(FileRequest::SaveAs))
    }),
    action(Menu::File, "Export…", ctrl(Key::E), |_| {
        done(Command::RequestFile(FileRequest::Export))
    }),
    action(Menu::File, "Save image…", ctrl_shift(Key::P), |a| {
        // What is shown before the first path of each pixel is coarse.
        let has_paths = a.render.as_ref().is_some_and(|r| r.samples > 0);
        enabled_if(has_paths, Command::RequestFile(FileRequest::SaveRender))
    }),
    action(Menu::File, "Apply recipe…", None, |a| {
        let has_surfaces = !a.document.objects.is_empty();
        enabled_if(has_surfaces, Command::RequestFile(FileRequest::Recipe))
    }),
    action(Menu::File, "Forget recipes", None, |a| {
        let forget = Command::Edit(Edit::ForgetRecipes, None);
        enabled_if(a.document.has_recipes(), forget)
    }),
    action(Menu::File, "Preferences…", ctrl(Key::Comma), |_| {
        Some(ActionTarget::Window(WindowAction::Preferences))
    }),
    action(Menu::File, "Quit", ctrl(Key::Q), |_| {
        enabled_if(!IS_PAGE, Command::Quit)
    }),
    action(Menu::Edit, "Undo", ctrl(Key::Z), |a| {
        enabled_if(a.undo_labels().0.is_some(), Command::Undo)
    }),
    action(Menu::Edit, "Redo", ctrl_shift(Key::Z), |a| {
        enabled_if(a.undo_labels().1.is_some(), Command::Redo)
    }),
    action(Menu::Edit, "Select all", ctrl(Key::A), |_| {
        done(Command::SelectAll)
    }),
    action(Menu::Edit, "Select none", ctrl_shift(Key::A), |_| {
        done(Command::Select(Selection::default()))
    }),
    action(Menu::Edit, "Duplicate", ctrl(Key::D), |a| {
        selected(a, Edit::Duplicate).or_else(|| {
            let copy = duplicate(&a.document, chosen_material(a)?);
            edit(copy?)
        })
    }),
    action(Menu::Edit, "Delete", key(Key::Delete), |a| {
        let material = || edit(Edit::DeleteMaterial(chosen_material(a)?));
        selected(a, Edit::Delete).or_else(material)
    }),
    action(Menu::Edit, "Remove unused materials", None, |a| {
        let used = a.document.used_materials().len();
        let command = Command::Edit(Edit::DeleteUnusedMaterials, None);
        enabled_if(used < a.document.materials.len(), command)
    }),
    action(Menu::Edit, "Rename…", key(Key::F2), |a| {
        (a.selection.ids.len() == 1).then_some(ActionTarget::Window(WindowAction::Rename))
    }),
    action(Menu::Edit, "Hide", key(Key::H), |a| {
        let shown = |id: &ItemId| a.document.is_hidden(*id) == Some(false);
        let ids = a.selection.ids.iter().copied().filter(shown).collect();
        hide(ids, true)
    }),
    action(Menu::Edit, "Show all", shift(Key::H), |a| {
        hide(a.document.hidden(), false)
    }),
    action(Menu::Add, "Box", None, |_| {
        done(Command::AddShape(NewShapeKind::Cuboid))
    }),
    action(Menu::Add, "Sphere", None, |_| {
        done(Command::AddShape(NewShapeKind::Sphere))
    }),
    action(Menu::Add, "Cylinder", None, |_| {
        done(Command::AddShape(NewShapeKind::Cylinder))
    }),
    action(Menu::Add, "Cone", None, |_| {
        done(Command::AddShape(NewShapeKind::Cone))
    }),
    action(Menu::Add, "Prism…", None, |_| {
        Some(ActionTarget::Window(WindowAction::Prism))
    }),
    action(Menu::Add, "Square", None, |_| {
        done(Command::AddShape(NewShapeKind::Square))
    }),
    action(Menu::Add, "Text…", None, |_| {
        Some(ActionTarget::Window(WindowAction::Text))
    }),
    action(Menu::Add, "Area light", ctrl(Key::L), |_| {
        done(Command::AddShape(NewShapeKind::AreaLight))
    }),
    action(Menu::Add, "Point light", None, |_| {
        done(Command::AddLight(NewLightKind::Point))
    }),
    action(Menu::Add, "Spot light", None, |_| {
        done(Command::AddLight(NewLightKind::Spot))
    }),
    action(Menu::Add, "Sun", None, |_| {
        done(Command::AddLight(NewLightKind::Sun))
    }),
    action(Menu::Add, "Sky", None, |_| {
        done(Command::AddLight(NewLightKind::Sky))
    }),
    action(Menu::Add, "Ambient light", None, |_| {
        done(Command::AddLight(NewLightKind::Ambient))
    }),
    action(Menu::Add, "Environment map…", None, |_| {
        done(Command::RequestFile(FileRequest::Environment(None)))
    }),
    action(Menu::Add, "Studio", None, |a| {
        let is_dark_model = !a.document.objects.is_empty() && !a.document.has_light();
        enabled_if(is_dark_model, Command::Edit(Edit::AddStudio, None))
    }),
    action(Menu::Add, "Camera from this view", ctrl(Key::K), |a| {
        edit(Edit::AddCamera(a.view.camera.clone()))
    }),
    action(Menu::Add, "Task plane", None, |a| {
        let can_measure = !a.document.objects.is_empty() && a.document.has_light();
        can_measure.then_some(ActionTarget::Window(WindowAction::TaskPlane))
    }),
    action(Menu::Add, "Material", ctrl(Key::M), |_| {
        let white = azulejo::scene::Material::diffuse("material", azulejo::scene::Rgb::grey(0.7));
        edit(Edit::AddMaterial(white))
    }),
    action(Menu::View, "Frame all", key(Key::Home), |a| {
        let bounds = a.document.model_bounds();
        change_view(a, |view| view.frame(bounds))
    }),
    action(Menu::View, "Frame selection", key(Key::Period), |a| {
        let bounds = a.document.frame_of(&a.selection.ids);
        if bounds.is_empty() {
            None
        } else {
            change_view(a, |view| view.frame(bounds))
        }
    }),
    action(Menu::View, "Front view", key(Key::Num1), |a| {
        from(a, ViewDirection::Front)
    }),
    action(Menu::View, "Back view", alt(Key::Num1), |a| {
        from(a, ViewDirection::Back)
    }),
    action(Menu::View, "Right view", key(Key::Num3), |a| {
        from(a, ViewDirection::Right)
    }),
    action(Menu::View, "Left view", alt(Key::Num3), |a| {
        from(a, ViewDirection::Left)
    }),
    action(Menu::View, "Top view", key(Key::Num7), |a| {
        from(a, ViewDirection::Top)
    }),
    action(Menu::View, "Bottom view", alt(Key::Num7), |a| {
        from(a, ViewDirection::Bottom)
    }),
    action(Menu::View, "Corner view", key(Key::Num0), |a| {
        from(a, ViewDirection::Corner)
    }),
    action(Menu::View, "Scene tree", key(Key::F3), |a| {
        // The lab is in the place of a tree that is shown.
        if a.lab.is_open && a.preferences.shows_tree {
            return done(Command::ShowLab(None));
        }
        change_preferences(a, |p| p.shows_tree = !p.shows_tree)
    })
    .ticked(|a| a.preferences.shows_tree && !a.lab.is_open),
    action(Menu::View, "Properties", key(Key::F4), |a| {
        change_preferences(a, |p| p.shows_properties = !p.shows_properties)
    })
    .ticked(|a| a.preferences.shows_properties),
    action(Menu::View, "Lights and cameras", key(Key::L), |a| {
        change_view(a, |view| view.shows_markers = !view.shows_markers)
    })
    .ticked(|a| a.view.shows_markers),
    action(Menu::View, "Grid", key(Key::G), |a| {
        change_view(a, |view| view.shows_grid = !view.shows_grid)
    })
    .ticked(|a| a.view.shows_grid),
    action(Menu::View, "Orientation cube", None, |a| {
        change_view(a, |view| view.shows_cube = !view.shows_cube)
    })
    .ticked(|a| a.view.shows_cube),
    action(Menu::View, "Fog", None, |a| {
        change_view(a, |view| view.shows_fog = !view.shows_fog)
    })
    .ticked(|a| a.view.shows_fog),
    action(Menu::View, "Hide back faces", key(Key::B), |a| {
        change_view(a, |view| view.hides_backs = !view.hides_backs)
    })
    .ticked(|a| a.view.hides_backs),
    action(Menu::View, "Cut away the ceiling", key(Key::X), |a| {
        let section = SectionPlane::below_ceiling(a.document.units.up);
        change_view(a, |view| {
            view.section = view.section.is_none().then_some(section);
        })
    })
    .ticked(|a| a.view.section.is_some()),
    action(Menu::View, "Compare", key(Key::C), |a| {
        let with = match a.view.shading {
            Shading::Textured => Shading::Irradiance,
            _ => Shading::Textured,
        };
        change_view(a, |view| {
            let comparison = Comparison { with, at: 0.5 };
            view.comparison = view.comparison.is_none().then_some(comparison);
        })
    })
    .ticked(|a| a.view.comparison.is_some()),
    action(Menu::View, "Render image", key(Key::F12), |a| {
        let has_surfaces = !a.document.objects.is_empty() || a.render.is_some();
        has_surfaces.then_some(ActionTarget::Window(WindowAction::ToggleRender))
    }),
    action(Menu::View, "Back to the model", key(Key::Escape), |a| {
        match a.failure {
            // One key closes one thing.
            Some(_) => done(Command::DismissFailure),
            None => enabled_if(a.render.is_some(), Command::CloseRender),
        }
    }),
    action(Menu::Shading, "Points", ctrl(Key::Num1), |a| {
        shade(a, Shading::Points)
    }),
    action(Menu::Shading, "Lines", ctrl(Key::Num2), |a| {
        shade(a, Shading::Lines)
    }),
    action(Menu::Shading, "Hidden lines", ctrl(Key::Num3), |a| {
        shade(a, Shading::HiddenLines)
    }),
    action(Menu::Shading, "Flat", ctrl(Key::Num4), |a| {
        shade(a, Shading::Flat)
    }),
    action(Menu::Shading, "Gouraud", ctrl(Key::Num5), |a| {
        shade(a, Shading::Gouraud)
    }),
    action(Menu::Shading, "Textured", ctrl(Key::Num6), |a| {
        shade(a, Shading::Textured)
    }),
    action(Menu::Shading, "Irradiance", ctrl(Key::Num7), |a| {
        shade(a, Shading::Irradiance)
    }),
    action(Menu::Shading, "False colours", ctrl(Key::Num8), |a| {
        shade(a, Shading::FalseColor)
    }),
    action(Menu::Shading, "Standard error", None, |a| {
        shade(a, Shading::Error)
    }),
    action(Menu::Shading, "Patches", ctrl(Key::Num9), |a| {
        shade(a, Shading::Patches)
    }),
    action(
        Menu::Shading,
        "Form factors of a patch",
        ctrl(Key::Num0),
        |a| shade(a, Shading::FormFactors),
    ),
    action(
        Menu::Shading,
        "Normals and back faces",
        ctrl(Key::Minus),
        |a| shade(a, Shading::Normals),
    ),
    action(Menu::Light, "Solve", key(Key::F5), |a| {
        let is_possible = !a.document.objects.is_empty() && !a.is_busy(JobKind::Solve);
        enabled_if(is_possible, Command::Solve)
    }),
    action(Menu::Light, "Pause", key(Key::F6), |a| {
        let runs = a.is_busy(JobKind::Solve) && !a.lighting.is_paused;
        enabled_if(runs && !IS_PAGE, Command::Pause)
    }),
    action(Menu::Light, "Resume", shift(Key::F6), |a| {
        let rests = a.is_busy(JobKind::Solve) && a.lighting.is_paused;
        enabled_if(rests, Command::Resume)
    }),
    action(Menu::Light, "Stop", key(Key::F7), |a| {
        if a.is_busy(JobKind::Solve) {
            done(Command::StopSolving)
        } else {
            enabled_if(a.is_busy(JobKind::Render), Command::StopRender)
        }
    }),
    action(Menu::Light, "Pin a probe", key(Key::P), |a| {
        (!a.document.objects.is_empty()).then_some(ActionTarget::Window(WindowAction::AddProbe))
    }),
    action(Menu::Light, "Measure the probes", None, |a| {
        enabled_if(!a.probes.is_empty(), Command::MeasureProbes)
    }),
    action(Menu::Light, "Discard solution", None, |a| {
        enabled_if(a.lighting.solution.is_some(), Command::ClearLight)
    }),
    action(Menu::Light, "Bake a lightmap…", key(Key::F9), |a| {
        let can_bake = !a.document.objects.is_empty() && a.document.has_light();
        let is_free = !a.is_busy(JobKind::Bake);
        (can_bake && is_free && !IS_PAGE).then_some(ActionTarget::Window(WindowAction::Bake))
    }),
    action(Menu::Light, "Lightmap", shift(Key::F9), |a| {
        let result = a.lightmap.result.as_ref();
        result.map(|_| ActionTarget::Window(WindowAction::ToggleLightmap))
    }),
    action(Menu::Help, "Lab", key(Key::F1), |a| {
        let lesson = (!a.lab.is_open).then_some(a.lab.lesson);
        done(Command::ShowLab(lesson))
    })
    .ticked(|a| a.lab.is_open),
    action(
        Menu::Help,
        "Keyboard shortcuts",
        key(Key::Questionmark),
        |_| Some(ActionTarget::Window(WindowAction::Keys)),
    ),
    action(Menu::Help, "Messages", key(Key::F8), |_| {
        Some(ActionTarget::Window(WindowAction::Messages))
    }),
    action(Menu::Help, "About azulejo", None, |_| {
        Some(ActionTarget::Window(WindowAction::About))
    }),
];

/// A shortcut as keyboards name its key, in the language of the window.
pub fn key_text(context: &egui::Context, key: &KeyboardShortcut, language: Language) -> String {
    let text = context.format_shortcut(key);
    let name = match key.logical_key {
        Key::Questionmark => "?",
        Key::Comma => ",",
        Key::Period => ".",
        Key::Minus => "−",
        Key::Escape => "Esc",
        Key::Delete => match language {
            Language::Spanish => "Supr",
            _ => "Del",
        },
        Key::Home => match language {
            Language::Spanish => "Inicio",
            _ => "Home",
        },
        _ => return text,
    };
    text.replace(key.logical_key.name(), name)
}

/// The actions whose shortcuts were pressed. Shortcuts without modifiers are disabled while a text
/// field has the focus.
pub fn pressed(context: &egui::Context, app: &App) -> Vec<ActionTarget> {
    let writes = context.text_edit_focused();
    let mut commands = Vec::new();
    // Shortcuts with more modifiers first: Ctrl+Z would match Ctrl+Shift+Z too.
    let mut keyed: Vec<(&Action, KeyboardShortcut)> =
        ACTIONS.iter().filter_map(|a| Some((a, a.key?))).collect();
    keyed.sort_by_key(|(_, k)| !(k.modifiers.shift || k.modifiers.alt));
    for (action, key) in keyed {
        let is_plain = !key.modifiers.command && !is_function(key.logical_key);
        // Text fields have their own select all and undo.
        if writes && (is_plain || action.menu == Menu::Edit) {
            continue;
        }
        if !context.input(|input| is_pressed(input, &key)) {
            continue;
        }
        // An open menu or list takes Escape for itself.
        if key.logical_key == Key::Escape && egui::Popup::is_any_open(context) {
            continue;
        }
        // A key that does nothing now is left to others: Escape closes much besides an image.
        let target = (action.target)(app);
        if target.is_some() && context.input_mut(|input| input.consume_shortcut(&key)) {
            commands.extend(target);
        }
    }
    commands
}

/// Whether the key of a shortcut was pressed with or without Alt, as the shortcut has it: Alt and L is
/// not L.
fn is_pressed(input: &egui::InputState, shortcut: &KeyboardShortcut) -> bool {
    input.events.iter().any(|event| match event {
        Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } => *key == shortcut.logical_key && modifiers.alt == shortcut.modifiers.alt,
        _ => false,
    })
}

fn is_function(key: Key) -> bool {
    let name = key.name();
    name.len() > 1 && name.starts_with('F') && name[1..].bytes().all(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_key_means_two_things_and_no_name_stands_twice() {
        let keys: Vec<_> = ACTIONS.iter().filter_map(|a| a.key).collect();
        let distinct: HashSet<_> = keys.iter().map(|k| format!("{k:?}")).collect();
        assert_eq!(distinct.len(), keys.len());
        let names: HashSet<_> = ACTIONS.iter().map(|a| a.label).collect();
        assert_eq!(names.len(), ACTIONS.len());
    }

    #[test]
    fn no_key_is_a_digit_with_shift() {
        // With Shift, digit keys produce symbols that depend on the keyboard layout.
        let digits = Key::Num0..=Key::Num9;
        let keys = ACTIONS.iter().filter_map(|a| a.key);
        for key in keys.filter(|k| digits.contains(&k.logical_key)) {
            assert!(!key.modifiers.shift, "{key:?}");
        }
    }

    #[test]
    fn every_action_knows_when_it_makes_no_sense() {
        let app = App::quiet();
        let of = |label: &str| ACTIONS.iter().find(|a| a.label == label).unwrap();
        for label in ["Undo", "Redo", "Delete", "Pause", "Stop", "Show all"] {
            assert_eq!((of(label).target)(&app), None, "{label}");
        }
        assert!(ACTIONS.iter().any(|a| (a.target)(&app).is_some()));
    }

    #[test]
    fn lights_and_cameras_are_hidden_and_framed() {
        let mut app = App::quiet();
        app.document = crate::document::tests::sample();
        let target = |app: &App, label: &str| {
            let action = ACTIONS.iter().find(|a| a.label == label).unwrap();
            (action.target)(app)
        };
        assert_eq!(target(&app, "Frame selection"), None);
        let (bulb, view) = (ItemId(5), ItemId(6));
        app.selection.ids = vec![bulb, view];
        app.document.cameras[0].hidden = true;
        let hide = |ids: Vec<ItemId>, hidden| {
            Some(ActionTarget::Command(Command::Edit(
                Edit::Hide(ids, hidden),
                None,
            )))
        };
        assert_eq!(target(&app, "Hide"), hide(vec![bulb], true));
        assert_eq!(target(&app, "Show all"), hide(vec![view], false));
        app.document.lights[0].hidden = true;
        assert_eq!(target(&app, "Hide"), None);
        app.selection.ids = vec![bulb];
        let Some(ActionTarget::Command(Command::SetView(look))) = target(&app, "Frame selection")
        else {
            panic!("a light can be framed")
        };
        let middle = look.camera.target - glam::DVec3::new(0.0, 1.5, 0.0);
        assert!(middle.length() < 1e-9, "{middle}");
    }
}
