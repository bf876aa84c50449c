//! The menu bar and the toolbar.

use super::actions::{ACTIONS, Action, ActionTarget, Menu, key_text, label, shading_action};
use super::panel_context::PanelContext;
use super::viewport::action_button as tool;
use crate::app::App;
use crate::command::Command;
use crate::jobs::JobKind;
use crate::ui::focus;
use crate::variants::all;
use egui::{Button, ComboBox, Event, Key, Role, Ui, WidgetInfo};

/// Draws the menus; returns the chosen actions.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) -> Vec<ActionTarget> {
    let mut targets = Vec::new();
    let requested = menu_by_key(ui, cx);
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in all::<Menu>() {
            if menu == Menu::Shading {
                continue;
            }
            let title = ui.menu_button(menu.label(cx.language), |ui| {
                entries(ui, cx, menu, &mut targets);
                if menu == Menu::File {
                    recent(ui, cx);
                }
                if menu == Menu::View {
                    ui.menu_button(Menu::Shading.label(cx.language), |ui| {
                        entries(ui, cx, Menu::Shading, &mut targets);
                    });
                }
            });
            if requested == Some(menu) {
                title.response.request_focus();
            }
            if title.response.has_focus() {
                ui.data_mut(|d| d.insert_temp(focused_menu(), menu));
            }
        }
    });
    targets
}

/// Where the menu is kept whose title had the focus last.
fn focused_menu() -> egui::Id {
    egui::Id::unique("focused menu")
}

/// Whether a key was pressed in this frame while Alt was held: it may have been released since.
fn pressed_with_alt(ui: &Ui, letter: Key) -> bool {
    let is_it = |event: &Event| match event {
        Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } => *key == letter && modifiers.alt && !modifiers.command,
        _ => false,
    };
    ui.input(|i| i.events.iter().any(is_it))
}

/// The menu whose title gets the focus: the first one by F10, and by Alt with a letter the next one that
/// begins with it.
fn menu_by_key(ui: &Ui, cx: &PanelContext) -> Option<Menu> {
    if cx.is_covered {
        return None;
    }
    let shown = || all().filter(|&m| m != Menu::Shading);
    if ui.input(|i| i.key_pressed(Key::F10) && i.modifiers.is_none()) {
        return shown().next();
    }
    let letters = shown().filter_map(|menu| {
        let initial = menu.label(cx.language).chars().next()?;
        let letter = Key::from_name(&initial.to_uppercase().to_string())?;
        pressed_with_alt(ui, letter).then_some(menu)
    });
    let menus: Vec<Menu> = letters.collect();
    let last: Option<Menu> = ui.data(|d| d.get_temp(focused_menu()));
    let after = last.and_then(|last| menus.iter().position(|&m| m == last));
    let next = after.map_or(0, |k| (k + 1) % menus.len());
    menus.get(next).copied()
}

fn entries(ui: &mut Ui, cx: &PanelContext, menu: Menu, targets: &mut Vec<ActionTarget>) {
    for action in ACTIONS.iter().filter(|a| a.menu == menu) {
        targets.extend(entry(ui, cx, action));
    }
}

fn entry(ui: &mut Ui, cx: &PanelContext, action: &Action) -> Option<ActionTarget> {
    let target = (action.target)(cx.app);
    let name = label(cx.app, action);
    let is_chosen = || current(cx.app).is_some_and(|c| c.label == action.label);
    let is_switch = action.is_on.is_some() || action.menu == Menu::Shading;
    let is_on = is_switch && action.is_on.map_or_else(is_chosen, |is_on| is_on(cx.app));
    let label = match (is_switch, is_on) {
        (false, _) => name.clone(),
        (true, true) => format!("✔ {name}"),
        (true, false) => format!("      {name}"),
    };
    let key = action.key.map(|key| key_text(ui.ctx(), &key, cx.language));
    let mut button = Button::new(label);
    if let Some(key) = &key {
        button = button.shortcut_text(key.clone());
    }
    let mut response = ui.add_enabled(target.is_some(), button);
    if action.lacks_page() {
        response = response
            .on_disabled_hover_text(cx.tr("Not in a page: only where azulejo is installed."));
    }
    if is_switch {
        // Without the tick, which is a state.
        let words = key.map_or_else(|| name.clone(), |key| format!("{name} {key}"));
        response.widget_info(|| {
            WidgetInfo::selected(Role::Button, target.is_some(), is_on, words.clone())
        });
    }
    let clicked = response.clicked();
    if clicked {
        ui.close();
    }
    target.filter(|_| clicked)
}

fn recent(ui: &mut Ui, cx: &mut PanelContext) {
    let files = cx.app.preferences.recent.clone();
    ui.separator();
    ui.menu_button(cx.tr("Recent"), |ui| {
        if files.is_empty() {
            ui.weak(cx.tr("No recent files"));
        }
        for path in files {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let folder = path.parent().unwrap_or(&path).display().to_string();
            if ui.button(&*name).on_hover_text(folder).clicked() {
                cx.send(Command::Open(vec![path.clone()]));
                ui.close();
            }
        }
    });
}

/// Smallest width at which the toolbar has all its buttons, points.
const WIDE: f32 = 900.0;

/// Draws the toolbar; returns the chosen actions.
pub fn tools(ui: &mut Ui, cx: &mut PanelContext) -> Vec<ActionTarget> {
    let mut targets = Vec::new();
    // The menus have what a narrow window leaves out.
    let is_wide = ui.available_width() >= WIDE;
    ui.horizontal_wrapped(|ui| {
        if !is_wide {
            ui.spacing_mut().item_spacing.x = 4.0;
        }
        targets.extend(tool(ui, cx, "Open…"));
        if is_wide {
            targets.extend(tool(ui, cx, "Add…"));
        }
        targets.extend(tool(ui, cx, "Save"));
        gap(ui, is_wide);
        for label in ["Undo", "Redo"] {
            targets.extend(tool(ui, cx, label));
        }
        gap(ui, is_wide);
        targets.extend(tool(ui, cx, "Studio"));
        if is_wide {
            targets.extend(tool(ui, cx, "Area light"));
        }
        gap(ui, is_wide);
        shading(ui, cx, &mut targets);
        targets.extend(tool(ui, cx, "Frame all"));
        targets.extend(tool(ui, cx, "Render image"));
        if cx.app.render.is_some() {
            targets.extend(tool(ui, cx, "Save image…"));
        }
        gap(ui, is_wide);
        let solver = match (cx.app.is_busy(JobKind::Solve), cx.app.lighting.is_paused) {
            (false, _) => &["Solve"][..],
            (true, false) => &["Pause", "Stop"],
            (true, true) => &["Resume", "Stop"],
        };
        for label in solver {
            targets.extend(tool(ui, cx, label));
        }
    });
    targets
}

/// Separates groups of buttons, with a line where there is room for it.
fn gap(ui: &mut Ui, is_wide: bool) {
    if is_wide {
        ui.separator();
    } else {
        ui.add_space(2.0);
    }
}

fn shading(ui: &mut Ui, cx: &PanelContext, targets: &mut Vec<ActionTarget>) {
    ComboBox::new("shading", "")
        .selected_text(current(cx.app).map_or("", |a| cx.tr(a.label)))
        .height(400.0)
        .show_ui(ui, |ui| {
            focus::close_list(ui);
            for action in ACTIONS.iter().filter(|a| a.menu == Menu::Shading) {
                let is_it = current(cx.app).is_some_and(|c| c.label == action.label);
                if ui.selectable_label(is_it, cx.tr(action.label)).clicked() {
                    targets.extend((action.target)(cx.app));
                }
            }
        })
        .response
        .on_hover_text(cx.tr("Shading mode"));
}

/// The action of the current shading mode.
fn current(app: &App) -> Option<&'static Action> {
    shading_action(app, app.view.shading)
}
