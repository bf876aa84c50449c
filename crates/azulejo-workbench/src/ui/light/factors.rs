//! Form factors of the picked patch.

use super::super::panel_context::PanelContext;
use super::{engines, percent};
use crate::first_pass::PatchFormFactors;
use crate::ui::help::{self, HelpTerm};
use crate::ui::viewport::number;
use azulejo::factors::form_factors::{Factor, GroupFactor};
use egui::{Grid, ProgressBar, Ui};

/// Number of objects listed.
const MAX_OBJECTS: usize = 12;

/// Draws the sum, and the objects with the largest form factors.
pub fn show(ui: &mut Ui, cx: &mut PanelContext, seen: &PatchFormFactors) {
    let app = cx.app;
    let name = app.document.name(seen.pick.item).unwrap_or_default();
    ui.label(format!("{} {name}", cx.tr("Patch of")));
    // If the sum exceeds 1 a little, nothing leaves the scene.
    let outside = (1.0 - seen.sum).max(0.0);
    let (sum, rest) = (cx.tr("Sum"), cx.tr("leaves the scene"));
    let text = format!("{sum} {:.4}; {} {rest}", seen.sum, percent(outside));
    ui.horizontal(|ui| {
        ui.label(text).on_hover_text(
            cx.tr("Fractions of the light leaving the patch. In a closed scene they sum to 1."),
        );
        help::mark(ui, cx.language, HelpTerm::FormFactor);
    });
    // The objects come in descending order of their form factors; a click selects one.
    let grid = Grid::new("form factors").num_columns(3).striped(true);
    grid.show(ui, |ui| {
        ui.weak(cx.tr("Object"));
        ui.horizontal(|ui| {
            ui.weak("F");
            help::mark(ui, cx.language, HelpTerm::StandardError);
        });
        ui.end_row();
        for (id, found) in seen.objects.iter().take(MAX_OBJECTS) {
            let name = app.document.name(*id).unwrap_or_default();
            if ui
                .link(super::probes::shortened(name))
                .on_hover_text(name)
                .clicked()
            {
                cx.select(*id, false);
            }
            let label = ui.add(egui::Label::new(with_error(found.factor)).extend());
            label.on_hover_text(estimates(cx, found));
            // To a screen reader the bar is a meter with the name of the object.
            let factor = found.factor.value;
            let bar = ProgressBar::new(factor.clamp(0.0, 1.0) as f32);
            let width = (ui.available_width() - 8.0).clamp(24.0, 90.0);
            ui.add(bar.desired_width(width).desired_height(8.0))
                .widget_info(|| {
                    let words = format!("{name} {}", percent(factor));
                    egui::WidgetInfo::labeled(egui::Role::Meter, true, words)
                });
            ui.end_row();
        }
    });
    // Tell how many objects the table leaves out.
    if let Some(more) = seen
        .objects
        .len()
        .checked_sub(MAX_OBJECTS)
        .filter(|n| *n > 0)
    {
        ui.weak(format!("+ {more} {}", cx.tr("more objects")));
    }
    engines::show(ui, cx);
}

/// A form factor with its standard error, to two digits of that: four decimals at least, and six at most.
fn with_error(f: Factor) -> String {
    const DECIMALS: (i32, i32) = (4, 6);
    let digits = match f.error {
        error if error > 0.0 => 1 - error.log10().floor() as i32,
        error if error.is_nan() => return format!("{:.4} ± ?", f.value),
        _ => DECIMALS.1 + 2,
    };
    let decimals = digits.clamp(DECIMALS.0, DECIMALS.1) as usize;
    if digits > DECIMALS.1 + 1 {
        // By formulas: the error is in digits that are not shown.
        return format!("{:.decimals$}", f.value);
    }
    format!("{:.decimals$} ± {:.decimals$}", f.value, f.error)
}

/// The independent estimates of a form factor, and its standard error with one more digit.
fn estimates(cx: &PanelContext, found: &GroupFactor) -> String {
    let Some(estimates) = found.estimates else {
        return cx
            .tr("By formulas, at least in part: there are no independent estimates.")
            .into();
    };
    let texts = estimates.map(|f| format!("{f:.6}"));
    let error = number(found.factor.error);
    format!(
        "{}:\n{}\n{}: {error}",
        cx.tr("Independent estimates"),
        texts.join("\n"),
        cx.tr("Standard error")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_two_digits() {
        for (value, error, text) in [
            (0.19984321, 0.00041, "0.19984 ± 0.00041"),
            (0.19984321, 0.0123, "0.1998 ± 0.0123"),
            (0.1998248957, 1e-11, "0.199825"),
            (0.1998248957, 0.0, "0.199825"),
            (0.1998248957, 2e-6, "0.199825 ± 0.000002"),
            (0.2, f64::NAN, "0.2000 ± ?"),
        ] {
            assert_eq!(with_error(Factor { value, error }), text);
        }
    }
}
