//! Markers of the probes in the viewport.

use super::{PanelContext, number};
use crate::app::Probe;
use crate::app::light_unit::ShownUnit;
use crate::gpu::Projection;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui, Vec2};
use glam::DVec3;

/// Draws a cross with a number at each probe; those on back-facing sides are faint.
pub fn paint(ui: &Ui, rect: Rect, view: &Projection, cx: &PanelContext) {
    let app = cx.app;
    let painter = ui.painter().with_clip_rect(rect);
    let eye = app.view.camera.eye;
    for probe in &app.probes {
        let Some(p) = view.project(probe.pick.position) else {
            continue;
        };
        let at = rect.min + Vec2::new(p.x as f32, p.y as f32);
        if rect.contains(at) {
            cross(
                &painter,
                at,
                &words(probe, ShownUnit::of(app)),
                strength(probe, eye),
            );
        }
    }
}

fn strength(probe: &Probe, eye: DVec3) -> f32 {
    let pick = &probe.pick;
    if pick.normal.dot(eye - pick.position) > 0.0 && probe.site.is_some() {
        1.0
    } else {
        0.35
    }
}

/// The number of a probe, and its irradiance where known.
fn words(probe: &Probe, unit: ShownUnit) -> String {
    let front = probe.site.as_ref().filter(|s| s.paint.is_front);
    let light = front.and_then(|s| s.light).map(|l| l.0);
    match probe.measured.map(|m| m.value).or(light) {
        Some(light) => {
            let shown = number(unit.factor * light.luminance());
            format!("{}: {shown} {}", probe.number, unit.irradiance())
        }
        None => probe.number.to_string(),
    }
}

/// White on black, so that it is visible on any surface.
pub fn cross(painter: &Painter, at: Pos2, words: &str, strength: f32) {
    const ARM: f32 = 6.0;
    let strokes = [(3.5, Color32::BLACK), (1.5, Color32::WHITE)];
    for (width, color) in strokes {
        let stroke = Stroke::new(width, color.gamma_multiply(strength));
        for arm in [Vec2::new(ARM, 0.0), Vec2::new(0.0, ARM)] {
            painter.line_segment([at - arm, at + arm], stroke);
        }
    }
    if words.is_empty() {
        return;
    }
    let color = Color32::WHITE.gamma_multiply(strength);
    let galley = painter.layout_no_wrap(words.into(), FontId::proportional(12.0), color);
    let pick = Align2::LEFT_CENTER.anchor_size(at + Vec2::new(ARM + 5.0, 0.0), galley.size());
    let back = Color32::from_black_alpha(170).gamma_multiply(strength);
    painter.rect_filled(pick.expand2(Vec2::new(3.0, 1.0)), 3.0, back);
    painter.galley(pick.min, galley, color);
}
