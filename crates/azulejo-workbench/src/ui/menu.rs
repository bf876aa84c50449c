//! The menu bar and the bar of tools under it.

use super::actions::{ACTIONS, Action, ActionTarget, Menu};
use super::desk::PanelContext;
use crate::app::App;
use crate::command::Command;
use crate::jobs::JobKind;
use egui::{Button, ComboBox, Ui};

/// Draws the menus; returns what was chosen.
pub fn show(ui: &mut Ui, desk: &mut PanelContext) -> Vec<ActionTarget> {
    let mut wishes = Vec::new();
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            if menu == Menu::Shading {
                continue;
            }
            ui.menu_button(menu.label(desk.language), |ui| {
                entries(ui, desk, menu, &mut wishes);
                if menu == Menu::File {
                    recent(ui, desk);
                }
                if menu == Menu::View {
                    ui.menu_button(Menu::Shading.label(desk.language), |ui| {
                        entries(ui, desk, Menu::Shading, &mut wishes);
                    });
                }
            });
        }
    });
    wishes
}

fn entries(ui: &mut Ui, desk: &PanelContext, menu: Menu, wishes: &mut Vec<ActionTarget>) {
    for action in ACTIONS.iter().filter(|a| a.menu == menu) {
        wishes.extend(entry(ui, desk, action));
    }
}

fn entry(ui: &mut Ui, desk: &PanelContext, action: &Action) -> Option<ActionTarget> {
    let wish = (action.wish)(desk.app);
    let label = label(desk, action);
    let mut button = Button::new(label);
    if let Some(key) = action.key {
        button = button.shortcut_text(ui.ctx().format_shortcut(&key));
    }
    let clicked = ui.add_enabled(wish.is_some(), button).clicked();
    if clicked {
        ui.close();
    }
    wish.filter(|_| clicked)
}

/// The name of an action, and of what it is about.
fn label(desk: &PanelContext, action: &Action) -> String {
    let name = desk.say(action.label);
    let (undo, redo) = desk.app.undo_labels();
    match (action.label, undo, redo) {
        ("Undo", Some(what), _) | ("Redo", _, Some(what)) => {
            format!("{name}: {}", desk.say(what))
        }
        _ => name.to_owned(),
    }
}

fn recent(ui: &mut Ui, desk: &mut PanelContext) {
    let files = desk.app.preferences.recent.clone();
    ui.separator();
    ui.menu_button(desk.say("Recent"), |ui| {
        if files.is_empty() {
            ui.weak(desk.say("nothing yet"));
        }
        for path in files {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let folder = path.parent().unwrap_or(&path).display().to_string();
            if ui.button(&*name).on_hover_text(folder).clicked() {
                desk.wish(Command::Open(vec![path.clone()]));
                ui.close();
            }
        }
    });
}

/// Draws the tools that one wants all the time.
pub fn tools(ui: &mut Ui, desk: &mut PanelContext) -> Vec<ActionTarget> {
    let mut wishes = Vec::new();
    ui.horizontal_wrapped(|ui| {
        for label in ["Open…", "Add…", "Save"] {
            wishes.extend(tool(ui, desk, label));
        }
        ui.separator();
        for label in ["Undo", "Redo"] {
            wishes.extend(tool(ui, desk, label));
        }
        ui.separator();
        wishes.extend(tool(ui, desk, "Area light"));
        ui.separator();
        shading(ui, desk, &mut wishes);
        wishes.extend(tool(ui, desk, "Frame all"));
        wishes.extend(tool(ui, desk, "Picture by rays"));
        if desk.app.picture.is_some() {
            wishes.extend(tool(ui, desk, "Save picture…"));
        }
        ui.separator();
        let solver = match (
            desk.app.is_busy(JobKind::Solve),
            desk.app.lighting.is_paused,
        ) {
            (false, _) => &["Solve"][..],
            (true, false) => &["Pause", "Stop"],
            (true, true) => &["Go on", "Stop"],
        };
        for label in solver {
            wishes.extend(tool(ui, desk, label));
        }
    });
    wishes
}

fn tool(ui: &mut Ui, desk: &PanelContext, label: &str) -> Option<ActionTarget> {
    let action = ACTIONS.iter().find(|a| a.label == label)?;
    let wish = (action.wish)(desk.app);
    let button = ui.add_enabled(wish.is_some(), Button::new(desk.say(action.label)));
    let button = match action.key {
        Some(key) => button.on_hover_text(ui.ctx().format_shortcut(&key)),
        None => button,
    };
    wish.filter(|_| button.clicked())
}

fn shading(ui: &mut Ui, desk: &PanelContext, wishes: &mut Vec<ActionTarget>) {
    ComboBox::new("shading", "")
        .selected_text(current(desk.app).map_or("", |a| desk.say(a.label)))
        .height(400.0)
        .show_ui(ui, |ui| {
            for action in ACTIONS.iter().filter(|a| a.menu == Menu::Shading) {
                let is_it = current(desk.app).is_some_and(|c| c.label == action.label);
                if ui.selectable_label(is_it, desk.say(action.label)).clicked() {
                    wishes.extend((action.wish)(desk.app));
                }
            }
        })
        .response
        .on_hover_text(desk.say("What surfaces show"));
}

/// The action of the shading that is on.
fn current(app: &App) -> Option<&'static Action> {
    (ACTIONS.iter().filter(|a| a.menu == Menu::Shading)).find(|action| {
        let wish = (action.wish)(app);
        matches!(wish, Some(ActionTarget::Do(Command::SetView(view))) if view.shading == app.view.shading)
    })
}
