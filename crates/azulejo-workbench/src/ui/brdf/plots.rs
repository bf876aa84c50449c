//! All plots of one material, or of two for comparison.

use super::badges::badges;
use super::curve;
use super::lobe_solid;
use super::lobes::{AlbedoCurve, SampledLobes, largest_albedo_difference, largest_difference};
use super::polar;
use super::surface_plots::SurfacePlots;
use super::theme::{lines, short};
use super::view::LobeView;
use crate::words::Language;
use egui::{Align, Color32, Layout, Sense, Shape, Stroke, TextWrapMode, Ui, vec2};

/// Draws the available results; `names` are those of the compared materials.
pub(super) fn show(
    ui: &mut Ui,
    language: Language,
    view: &mut LobeView,
    sides: &mut [SurfacePlots],
    names: &[String],
) {
    // With a common scale the larger of two lobes is drawn larger.
    let bodies = sides.iter().filter_map(|s| s.lobes.found());
    let top = bodies.map(|(_, lobes)| lobe_solid::largest_value(view, &lobes.body));
    let top = top.fold(f64::MIN_POSITIVE, f64::max);
    for (k, side) in sides.iter_mut().enumerate() {
        if names.len() > 1 {
            name(ui, k, &names[k]);
        }
        marks(ui, language, side);
        pictures(ui, language, view, side, (k, top));
    }
    ui.add_space(4.0);
    let lobes: Vec<&SampledLobes> = sides
        .iter()
        .filter_map(|s| s.lobes.found())
        .map(|f| &f.1)
        .collect();
    ui.strong(language.tr("Lobes in the plane of incidence"));
    let slices: Vec<_> = lobes.iter().map(|l| &l.slices[..]).collect();
    polar::draw(ui, language, view, &slices);
    view.ui(ui, language);
    ui.add_space(4.0);
    ui.strong(language.tr("Albedo against angle"));
    let curves: Vec<&AlbedoCurve> = sides
        .iter()
        .filter_map(|s| s.albedo.found())
        .map(|f| &f.1)
        .collect();
    curve::draw(ui, language, &curves);
    difference(ui, language, &lobes, &curves);
}

/// The name of a model with its line style in the plots.
fn name(ui: &mut Ui, index: usize, name: &str) {
    ui.horizontal(|ui| {
        let (place, _) = ui.allocate_exact_size(vec2(30.0, 10.0), Sense::hover());
        let ends = [place.left_center(), place.right_center()];
        let color = ui.visuals().strong_text_color();
        let stroke = Stroke::new(2.0, color);
        let line = match index {
            0 => vec![Shape::line_segment(ends, stroke)],
            _ => Shape::dashed_line(&ends, stroke, 5.0, 3.0),
        };
        ui.painter().extend(line);
        ui.add(egui::Label::new(egui::RichText::new(name).strong()).truncate());
    });
}

/// Badges, and a spinner while results are missing.
fn marks(ui: &mut Ui, language: Language, side: &SurfacePlots) {
    // In a narrow panel each has a row of its own, in which its text is wrapped.
    let is_narrow = ui.available_width() < 340.0;
    let layout = if is_narrow {
        Layout::top_down(Align::Min)
    } else {
        Layout::left_to_right(Align::Center).with_main_wrap(true)
    };
    let size = vec2(ui.available_width(), 22.0);
    ui.allocate_ui_with_layout(size, layout, |ui| {
        if is_narrow {
            ui.style_mut().wrap_mode = Some(TextWrapMode::Wrap);
        }
        if let Some((_, measures)) = side.measures.found() {
            badges(ui, language, measures);
        }
        if side.is_behind() {
            ui.add(egui::Spinner::new().size(14.0))
                .on_hover_text(language.tr("Computing; meanwhile the last result is shown."));
        }
        // As high as the badges, so that the layout does not jump.
        ui.allocate_exact_size(vec2(0.0, 22.0), Sense::hover());
    });
}

/// The sphere and the lobe.
fn pictures(
    ui: &mut Ui,
    language: Language,
    view: &mut LobeView,
    side: &mut SurfacePlots,
    (index, top): (usize, f64),
) {
    ui.horizontal(|ui| {
        let size = (0.4 * ui.available_width()).clamp(80.0, 160.0);
        side.sphere(ui, language, size);
        let size = vec2(ui.available_width().max(80.0), size);
        let color = lines(ui)[index];
        match side.lobes.found() {
            Some((_, lobes)) => {
                let stage = lobe_solid::LobeViewport { size, top, color };
                lobe_solid::draw(ui, language, view, &lobes.body, stage);
            }
            None => drop(ui.allocate_exact_size(size, Sense::hover())),
        }
    });
}

/// The difference between two models.
fn difference(ui: &mut Ui, language: Language, lobes: &[&SampledLobes], curves: &[&AlbedoCurve]) {
    let ([a, b], [c, d]) = (lobes, curves) else {
        return;
    };
    let [lobe, lobe_at] = <[f64; 2]>::from(largest_difference(&a.body, &b.body));
    let [share, share_at] = <[f64; 2]>::from(largest_albedo_difference(c, d));
    let at = language.tr("at");
    let (words, reflected, unit) = (
        language.tr("Largest difference:"),
        language.tr("albedo"),
        language.tr("1/sr"),
    );
    let color: Color32 = lines(ui)[1];
    ui.colored_label(color, format!("{words} f·cos θ {} {unit} {at} {lobe_at:.0}°, {reflected} {share:.3} {at} {share_at:.0}°", short(lobe)));
}
