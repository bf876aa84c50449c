//! Energy balance of the solution.

use super::super::colors::lines;
use super::super::panel_context::PanelContext;
use super::percent;
use crate::app::light_unit::ShownUnit;
use crate::ui::help::{self, HelpTerm};
use crate::ui::viewport::{number, value};
use azulejo::radiosity::EnergyBalance;
use azulejo::scene::Rgb;
use egui::{Color32, Grid, ProgressBar, RichText, Ui};

/// Draws numbers and bars, with a warning if the energy balance does not close.
pub fn show(ui: &mut Ui, cx: &PanelContext, balance: &EnergyBalance) {
    let [blue, orange, green, purple, yellow] = lines(ui);
    // What no other share explains is noise of the solution, or left out by a limit on bounces.
    let rest = balance.emitted - balance.absorbed - balance.escaped - balance.cut;
    let unit = ShownUnit::of(cx.app);
    ui.horizontal(|ui| {
        ui.weak(cx.tr("Emitted = absorbed + escaped + cut off"));
        help::mark(ui, cx.language, HelpTerm::EnergyBalance);
    });
    // Each row has a power in the shown unit, and a bar of its share in the emitted power.
    let grid = Grid::new("energy").num_columns(3).spacing([10.0, 3.0]);
    grid.show(ui, |ui| {
        let mut row = |name: &str, about: &str, power: Rgb, share: f64, color: Color32| {
            ui.label(name).on_hover_text(about);
            let shown = unit.rgb(power);
            ui.label(format!("{} {}", number(shown.mean()), unit.flux()))
                .on_hover_text(format!("RGB {}", value(shown)));
            bar(ui, name, share, color);
            ui.end_row();
        };
        // In the dark the shares are 0, and not NaN.
        let emitted = balance.emitted.mean();
        let share = |power: Rgb| power.mean() / emitted.max(f64::MIN_POSITIVE);
        row(
            cx.tr("Emitted"),
            cx.tr("By emissive surfaces, and by lights as far as their light hits a surface."),
            balance.emitted,
            share(balance.emitted),
            yellow,
        );
        row(
            cx.tr("Absorbed"),
            cx.tr("By surfaces."),
            balance.absorbed,
            share(balance.absorbed),
            blue,
        );
        row(
            cx.tr("Escaped"),
            cx.tr("Out of an open scene."),
            balance.escaped,
            share(balance.escaped),
            green,
        );
        row(
            cx.tr("Cut off"),
            cx.tr("Between mirrors, where paths were cut off."),
            balance.cut,
            share(balance.cut),
            purple,
        );
        row(
            cx.tr("Unaccounted"),
            cx.tr("What is missing or in excess: the noise of the solution."),
            rest,
            balance.error(),
            orange,
        );
    });
    // A warning names the likely cause: a limit on bounces, or else too few samples.
    if balance.is_off() {
        let words = match cx.app.lighting.settings.bounces {
            Some(_) => cx.tr("The energy balance does not close: the bounces are limited."),
            None => cx.tr(
                "The energy balance does not close: aim at a smaller error, or allow more time.",
            ),
        };
        ui.label(RichText::new(format!("⚠ {words}")).color(ui.visuals().warn_fg_color));
    }
}

/// A bar with its percentage beside it, since a short bar has no space for text.
fn bar(ui: &mut Ui, name: &str, share: f64, color: Color32) {
    ui.horizontal(|ui| {
        let bar = ProgressBar::new(share.clamp(0.0, 1.0) as f32);
        let width = (ui.available_width() - 60.0).min(90.0);
        let bar = bar
            .desired_width(width.max(4.0))
            .desired_height(8.0)
            .fill(color);
        let words = format!("{name} {}", percent(share));
        ui.add(bar)
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Meter, true, words.clone()));
        ui.label(percent(share));
    });
}
