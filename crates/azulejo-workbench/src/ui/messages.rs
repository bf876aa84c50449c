//! The message list and the status bar.

use super::panel_context::PanelContext;
use crate::app::Severity;
use crate::command::{Command, Selection};
use crate::document::ItemId;
use egui::{
    Align, Align2, Color32, Layout, ProgressBar, Rect, RichText, Role, ScrollArea, Sense,
    TextStyle, Ui, Vec2, WidgetInfo, pos2,
};
use std::time::Duration;

/// Draws the message list. Clicking a message about an object selects that object.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let app = cx.app;
    ui.horizontal(|ui| {
        ui.strong(cx.tr("Messages"));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.small_button(cx.tr("Clear")).clicked() {
                cx.send(Command::ClearMessages);
            }
        });
    });
    let height = ui.text_style_height(&TextStyle::Body);
    ScrollArea::vertical()
        .auto_shrink([false, false])
        .stick_to_bottom(true)
        .show_rows(ui, height, app.messages.len(), |ui, range| {
            for message in &app.messages[range] {
                let text = RichText::new(message.text.replace('\n', " "));
                let text = match color(message.level, ui) {
                    Some(color) => text.color(color),
                    None => text,
                };
                let known = message.about.filter(|&id| app.document.has(id));
                match known {
                    None => {
                        ui.add(egui::Label::new(text).truncate())
                            .on_hover_text(&message.text);
                    }
                    Some(id) => {
                        let link = ui.add(egui::Link::new(text));
                        if link.on_hover_text(&message.text).clicked() {
                            go_to_item(cx, id);
                        }
                    }
                }
            }
        });
}

/// Selects an item and frames it in the view.
fn go_to_item(cx: &mut PanelContext, id: ItemId) {
    let mut view = cx.app.view.clone();
    view.frame(cx.app.document.frame_of(&[id]));
    cx.send(Command::Select(Selection::one(id)));
    cx.send(Command::SetView(Box::new(view)));
}

fn color(level: Severity, ui: &Ui) -> Option<Color32> {
    match level {
        Severity::Note => None,
        Severity::Warning => Some(ui.visuals().warn_fg_color),
        Severity::Error => Some(ui.visuals().error_fg_color),
    }
}

/// Draws the status bar: jobs, the last message, and `probe`, the text for the point under the
/// mouse. Returns whether the message list should be toggled.
pub fn status(ui: &mut Ui, cx: &mut PanelContext, probe: Option<&str>) -> bool {
    let mut asks_messages = false;
    ui.horizontal(|ui| {
        // As high with text as without: the view must not change its size.
        ui.set_min_height(ui.spacing().interact_size.y);
        for job in cx.app.jobs() {
            let progress = &job.progress;
            let (done, total) = (progress.done(), progress.total());
            let stage = progress.stage();
            ui.label(short(&job.title));
            match total {
                0 => unknown_share(ui, cx.stage(&stage), job.started.elapsed()),
                total => {
                    let share = (done as f32 / total as f32).min(1.0);
                    let bar = ProgressBar::new(share).desired_width(BAR);
                    ui.add(bar.text(RichText::new(cx.stage(&stage)).small()));
                }
            }
            let cancel = ui.small_button("✖").on_hover_text(cx.tr("Cancel"));
            if cancel.clicked() {
                cx.send(Command::Cancel(job.id));
            }
            ui.separator();
        }
        let problems = cx.app.messages.iter();
        let problems = problems.filter(|m| m.level >= Severity::Warning).count();
        if problems > 0 {
            let text = format!("⚠ {problems}");
            let text = RichText::new(text).color(ui.visuals().warn_fg_color);
            let hover = cx.tr("Messages");
            asks_messages = ui
                .add(egui::Button::new(text).frame(false))
                .on_hover_text(hover)
                .clicked();
        }
        match (probe, cx.app.messages.last()) {
            (Some(probe), _) => {
                ui.add(egui::Label::new(probe).truncate());
            }
            (None, Some(last)) => {
                let text = RichText::new(last.text.replace('\n', " "));
                let text = match color(last.level, ui) {
                    Some(color) => text.color(color),
                    None => text.weak(),
                };
                ui.add(egui::Label::new(text).truncate())
                    .on_hover_text(&last.text);
            }
            (None, None) => {}
        }
    });
    asks_messages
}

/// Width of a progress bar, points.
const BAR: f32 = 120.0;

/// An indeterminate progress bar: a block moves to and fro. It moves when the window is repainted
/// anyway, as it is while jobs run.
fn unknown_share(ui: &mut Ui, stage: &str, time: Duration) {
    const PERIOD: f32 = 3.0;
    let height = ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(Vec2::new(BAR, height), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, stage));
    let round = 0.5 * height;
    ui.painter()
        .rect_filled(rect, round, ui.visuals().extreme_bg_color);
    let phase = time.as_secs_f32().rem_euclid(PERIOD) / PERIOD;
    let way = 1.0 - (2.0 * phase - 1.0).abs();
    let left = rect.left() + way * 0.75 * BAR;
    let block = Rect::from_min_size(pos2(left, rect.top()), Vec2::new(0.25 * BAR, height));
    ui.painter()
        .rect_filled(block, round, ui.visuals().selection.bg_fill);
    let font = TextStyle::Small.resolve(ui.style());
    let color = ui.visuals().text_color();
    let painter = ui.painter().with_clip_rect(rect);
    let at = rect.left_center() + Vec2::new(round, 0.0);
    painter.text(at, Align2::LEFT_CENTER, stage, font, color);
}

/// A title shortened at its start, since the end of a path says most.
fn short(title: &str) -> String {
    const MAX_CHARS: usize = 32;
    let count = title.chars().count();
    if count > MAX_CHARS {
        format!(
            "…{}",
            title.chars().skip(count - MAX_CHARS).collect::<String>()
        )
    } else {
        title.to_owned()
    }
}
