//! The panels beside the view: as wide as the user has set them, whatever they contain.

use crate::command::Command;
use crate::preferences::Preferences;
use crate::ui::panel_context::PanelContext;
use egui::{Id, Panel, PanelState, Rect, Sense, Ui, UiBuilder};

/// Share of the window's width that both panels leave to the view.
const VIEW: f32 = 0.4;
/// No panel can be made narrower, points, unless the window is too small for it.
const NARROWEST: f32 = 96.0;

/// A panel beside the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SidePanel {
    /// The tree of the scene, at the left.
    Tree,
    /// The properties, at the right.
    Properties,
    /// The lab, at the left in place of the tree.
    Lab,
}

/// The widths of the panels in points; 0 where one is hidden.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PanelWidths {
    tree: f32,
    properties: f32,
    lab: f32,
}

impl PanelWidths {
    /// The widths in a window of this width: those that the user has set, or else a share of the
    /// window. They shrink where they would leave too little to the view.
    pub fn of(preferences: &Preferences, shows_lab: bool, window: f32) -> PanelWidths {
        let width = |is_shown: bool, set: f32, usual: f32| match (is_shown, set > 0.0) {
            (false, _) => 0.0,
            (true, true) => set.max(NARROWEST),
            (true, false) => usual,
        };
        let tree = width(
            preferences.shows_tree && !shows_lab,
            preferences.tree_width,
            (0.2 * window).min(220.0),
        );
        let properties = width(
            preferences.shows_properties,
            preferences.properties_width,
            (0.38 * window).min(380.0),
        );
        let lab = width(shows_lab, preferences.lab_width, (0.27 * window).min(340.0));
        let shrink = ((1.0 - VIEW) * window / (tree + properties + lab).max(1.0)).min(1.0);
        PanelWidths {
            tree: shrink * tree,
            properties: shrink * properties,
            lab: shrink * lab,
        }
    }

    fn get(&self, panel: SidePanel) -> f32 {
        match panel {
            SidePanel::Tree => self.tree,
            SidePanel::Properties => self.properties,
            SidePanel::Lab => self.lab,
        }
    }

    /// The most that a panel can be widened to in a window of this width.
    fn most(&self, panel: SidePanel, window: f32) -> f32 {
        let other = match panel {
            SidePanel::Tree | SidePanel::Lab => self.properties,
            SidePanel::Properties => self.tree + self.lab,
        };
        ((1.0 - VIEW) * window - other).max(self.get(panel))
    }

    /// The preferences after a panel was resized. What is displayed of the others is kept, too,
    /// if their width was set: they may have been shrunk, and would move otherwise.
    fn resized(&self, preferences: &Preferences, panel: SidePanel, width: f32) -> Preferences {
        let mut new = preferences.clone();
        for (stored, shown) in [
            (&mut new.tree_width, self.tree),
            (&mut new.properties_width, self.properties),
            (&mut new.lab_width, self.lab),
        ] {
            if *stored > 0.0 && shown > 0.0 {
                *stored = shown.round();
            }
        }
        match panel {
            SidePanel::Tree => new.tree_width = width,
            SidePanel::Properties => new.properties_width = width,
            SidePanel::Lab => new.lab_width = width,
        }
        new
    }
}

impl SidePanel {
    fn salt(self) -> &'static str {
        match self {
            SidePanel::Tree => "tree",
            SidePanel::Properties => "panel",
            SidePanel::Lab => "lab",
        }
    }

    /// Draws the panel, unless it is hidden. Its width goes to the preferences once the user has
    /// resized it.
    pub fn show(
        self,
        ui: &mut Ui,
        cx: &mut PanelContext,
        widths: PanelWidths,
        window: f32,
        body: impl FnOnce(&mut Ui, &mut PanelContext),
    ) {
        let width = widths.get(self);
        if width <= 0.0 {
            return;
        }
        let id = ui.scope_id().with(self.salt());
        let is_dragged = ui.input(|i| i.pointer.any_down() || i.pointer.any_released());
        if !is_dragged {
            set_width(ui, id, width);
        }
        let panel = match self {
            SidePanel::Tree | SidePanel::Lab => Panel::left(self.salt()),
            SidePanel::Properties => Panel::right(self.salt()),
        };
        let shown = panel
            .resizable(true)
            .default_size(width)
            .size_range(NARROWEST.min(width)..=widths.most(self, window))
            .show(ui, |ui| bounded(ui, |ui| body(ui, cx)));
        let shown_width = shown.response.rect.width();
        let is_held = ui.input(|i| i.pointer.any_down());
        if !is_held && (shown_width - width).abs() > 1.0 {
            let new = widths.resized(&cx.app.preferences, self, shown_width.round());
            cx.send(Command::SetPreferences(Box::new(new)));
        }
    }
}

/// Makes a panel as wide as it should be in this frame, which may not be what it was in the last
/// one: the window was resized, or another panel hidden.
fn set_width(ui: &Ui, id: Id, width: f32) {
    let outer_rect =
        Rect::from_min_size(ui.max_rect().min, egui::vec2(width, ui.max_rect().height()));
    ui.data_mut(|d| d.insert_persisted(id, PanelState { outer_rect }));
}

/// Draws contents that cannot widen what surrounds them: what does not fit is clipped.
fn bounded(ui: &mut Ui, body: impl FnOnce(&mut Ui)) {
    let rect = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(UiBuilder::new().max_rect(rect));
    inner.shrink_clip_rect(rect.expand2(egui::vec2(2.0, 0.0)));
    body(&mut inner);
    ui.allocate_rect(rect, Sense::hover());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn widths(preferences: &Preferences, window: f32) -> [f32; 2] {
        let widths = PanelWidths::of(preferences, false, window);
        [widths.tree, widths.properties]
    }

    #[test]
    fn panels_leave_enough_to_the_view() {
        let usual = Preferences::default();
        assert_eq!(widths(&usual, 1280.0), [220.0, 380.0]);
        assert_eq!(widths(&usual, 800.0), [160.0, 304.0]);
        let wide = Preferences {
            tree_width: 500.0,
            properties_width: 700.0,
            ..usual
        };
        assert_eq!(widths(&wide, 2400.0), [500.0, 700.0]);
        for window in [320.0, 480.0, 800.0, 1200.0] {
            let [tree, properties] = widths(&wide, window);
            assert!(tree + properties < (1.0 - VIEW) * window + 0.1, "{window}");
            assert!((tree / properties - 5.0 / 7.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_hidden_panel_leaves_its_place_to_the_other() {
        let alone = Preferences {
            shows_tree: false,
            properties_width: 400.0,
            ..Preferences::default()
        };
        assert_eq!(widths(&alone, 800.0), [0.0, 400.0]);
        let shown = PanelWidths::of(&alone, false, 800.0);
        assert!((shown.most(SidePanel::Properties, 800.0) - 480.0).abs() < 1e-3);
    }

    #[test]
    fn the_lab_takes_the_place_of_the_tree() {
        let usual = Preferences::default();
        let shown = PanelWidths::of(&usual, true, 1280.0);
        assert_eq!(
            [shown.tree, shown.properties, shown.lab],
            [0.0, 380.0, 340.0]
        );
        let narrow = PanelWidths::of(&usual, true, 480.0);
        assert!(narrow.properties + narrow.lab < (1.0 - VIEW) * 480.0 + 0.1);
        let new = shown.resized(&usual, SidePanel::Lab, 260.0);
        assert_eq!((new.lab_width, new.tree_width), (260.0, 0.0));
    }

    #[test]
    fn what_is_resized_stays_where_it_was_left() {
        let wide = Preferences {
            tree_width: 500.0,
            properties_width: 700.0,
            ..Preferences::default()
        };
        let shown = PanelWidths::of(&wide, false, 800.0);
        let new = shown.resized(&wide, SidePanel::Properties, 250.0);
        assert_eq!(widths(&new, 800.0), [200.0, 250.0]);
        let usual = Preferences::default();
        let shown = PanelWidths::of(&usual, false, 800.0);
        let new = shown.resized(&usual, SidePanel::Tree, 120.0);
        // The other one still follows the window.
        assert_eq!((new.tree_width, new.properties_width), (120.0, 0.0));
    }
}
