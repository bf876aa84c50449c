//! What is known of a lightmap, and of one texel.

use super::page::{Texel, luminance};
use super::with_unit;
use crate::app::light_unit::ShownUnit;
use crate::bake::BakedDocument;
use crate::ui::light::{count, percent, seconds};
use crate::ui::panel_context::PanelContext;
use crate::ui::viewport::number;
use azulejo::bake::layout::NO_CHART;
use egui::{Grid, Label, Ui};

/// Draws what is known of the lightmap.
pub fn show(ui: &mut Ui, cx: &PanelContext, result: &BakedDocument) {
    let baked = &result.baked;
    let layout = &baked.atlas.layout;
    let metres = result.source.scene.units.metres();
    let density = layout.density(&baked.atlas.receivers) / metres;
    let mean = baked.lightmap.mean().luminance();
    let unit = ShownUnit::of(cx.app);
    let pages: Vec<String> = layout
        .pages
        .iter()
        .map(|[width, height]| format!("{width} × {height}"))
        .collect();
    let pages = match &pages[..] {
        [one] => one.clone(),
        several => format!("{} ({}…)", several.len(), several[0]),
    };
    rows(
        ui,
        "lightmap facts",
        &[
            (cx.tr("Charts"), count(layout.charts.into())),
            (cx.tr("Pages"), pages),
            (cx.tr("Covered"), percent(baked.lightmap.covered_share())),
            (cx.tr("Texels per metre"), number(density)),
            (
                cx.tr("Mean irradiance"),
                with_unit(unit.factor * mean, unit.irradiance()),
            ),
            (
                cx.tr("Estimated error"),
                percent(baked.lightmap.relative_error()),
            ),
            (cx.tr("Time"), seconds(result.time)),
        ],
    );
}

/// Draws what is known of the texel under the pointer.
pub fn texel(ui: &mut Ui, cx: &PanelContext, result: &BakedDocument, texel: Option<&Texel>) {
    let Some(&Texel { page, place }) = texel else {
        ui.weak(cx.tr("Point at a texel to see its values."));
        return;
    };
    let of = &result.baked.lightmap.pages[page];
    let at = place[1] as usize * of.size[0] as usize + place[0] as usize;
    let mut facts = vec![(cx.tr("Texel"), format!("{}, {}", place[0], place[1]))];
    let chart = of.charts[at];
    if chart != NO_CHART {
        let unit = ShownUnit::of(cx.app);
        let value = |light: [f32; 3]| with_unit(unit.factor * luminance(light), unit.irradiance());
        let density = result.densities.get(chart as usize).copied();
        facts.extend([
            (cx.tr("Irradiance"), value(of.irradiance[at])),
            (cx.tr("Standard error"), value(of.standard_error[at])),
            (cx.tr("Chart"), chart.to_string()),
            (cx.tr("Texels per metre"), number(density.unwrap_or(0.0))),
        ]);
    }
    rows(ui, "texel facts", &facts);
}

fn rows(ui: &mut Ui, id: &str, facts: &[(&str, String)]) {
    let grid = Grid::new(id).num_columns(2).spacing([12.0, 2.0]);
    grid.show(ui, |ui| {
        for (name, value) in facts {
            ui.label(*name);
            ui.add(Label::new(value).wrap());
            ui.end_row();
        }
    });
}
