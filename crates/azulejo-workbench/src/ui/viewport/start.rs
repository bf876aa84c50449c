//! What an empty window shows: files to open again, examples, and what can be done next.

use super::super::actions::ActionTarget;
use super::super::panel_context::PanelContext;
use crate::app::THUMBNAIL;
use crate::command::Command;
use crate::document::Example;
use crate::variants::{all, script_name};
use azulejo::formats::disk;
use azulejo::render::srgb_from_linear;
use egui::{
    Align2, Button, Color32, ColorImage, FontId, Rect, RichText, Role, ScrollArea, Sense,
    StrokeKind, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo,
};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Recent files that are shown.
const MAX_RECENT: usize = 6;

/// The start screen, with the pictures that it has loaded.
#[derive(Default)]
pub struct StartScreen {
    recent: HashMap<PathBuf, Option<TextureHandle>>,
    examples: HashMap<String, Option<TextureHandle>>,
    /// The recent files that still exist; looked for once while the screen is shown.
    files: Option<Vec<PathBuf>>,
}

impl StartScreen {
    /// Forgets what is on disk, so that it is looked for again the next time.
    pub fn leave(&mut self) {
        (self.files, self.recent) = (None, HashMap::new());
    }

    /// Draws the screen; returns the chosen actions.
    pub fn show(&mut self, ui: &mut Ui, rect: Rect, cx: &mut PanelContext) -> Vec<ActionTarget> {
        let recent = &cx.app.preferences.recent;
        let files = self.files.get_or_insert_with(|| {
            let there = recent
                .iter()
                .filter(|path| disk::metadata(path).is_ok_and(|meta| meta.is_file()));
            there.take(MAX_RECENT).cloned().collect()
        });
        let files = files.clone();
        let mut targets = Vec::new();
        ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
        let width = (rect.width() - 32.0).clamp(120.0, 680.0);
        let place = Rect::from_center_size(rect.center(), Vec2::new(width, rect.height() - 24.0));
        let builder = egui::UiBuilder::new().max_rect(place).id_salt("start");
        ui.scope_builder(builder, |ui| {
            ScrollArea::vertical()
                .auto_shrink([false, false])
                .show(ui, |ui| {
                    ui.add_space((0.06 * rect.height()).min(48.0));
                    heading(ui, cx, &mut targets);
                    if !files.is_empty() {
                        ui.add_space(18.0);
                        ui.strong(cx.tr("Recent files"));
                        self.recent_files(ui, cx, &files);
                    }
                    ui.add_space(18.0);
                    ui.strong(cx.tr("Examples"));
                    self.examples(ui, cx);
                    let lab = cx.tr("Lab: eight lessons with a number to find");
                    if !cx.app.lab.is_open && ui.link(lab).clicked() {
                        cx.send(Command::ShowLab(Some(cx.app.lab.lesson)));
                    }
                    ui.add_space(18.0);
                    steps(ui, cx);
                });
        });
        targets
    }

    fn recent_files(&mut self, ui: &mut Ui, cx: &mut PanelContext, files: &[PathBuf]) {
        ui.horizontal_wrapped(|ui| {
            for path in files {
                let kept = cx.app.thumbnails.path(path);
                let context = ui.ctx().clone();
                let picture = self.recent.entry(path.clone()).or_insert_with(|| {
                    let bytes = disk::read(kept?).ok()?;
                    texture(&context, &path.to_string_lossy(), &bytes)
                });
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let folder = path.parent().unwrap_or(Path::new("")).display().to_string();
                if tile(ui, picture.as_ref(), &name)
                    .on_hover_text(folder)
                    .clicked()
                {
                    cx.send(Command::Open(vec![path.clone()]));
                }
            }
        });
    }

    fn examples(&mut self, ui: &mut Ui, cx: &mut PanelContext) {
        ui.horizontal_wrapped(|ui| {
            for example in all() {
                let (name, about, bytes) = described(example, cx);
                let context = ui.ctx().clone();
                let key = script_name(example);
                let picture = self.examples.entry(key.clone());
                let picture = picture.or_insert_with(|| texture(&context, &key, bytes));
                if tile(ui, picture.as_ref(), name)
                    .on_hover_text(about)
                    .clicked()
                {
                    cx.send(Command::OpenExample(example));
                }
            }
        });
    }
}

fn heading(ui: &mut Ui, cx: &PanelContext, targets: &mut Vec<ActionTarget>) {
    ui.label(RichText::new("azulejo").size(30.0).strong());
    ui.label(cx.tr("Global illumination for the models people already have."));
    ui.add_space(14.0);
    ui.horizontal_wrapped(|ui| {
        let open = Button::new(RichText::new(cx.tr("Open…")).size(16.0));
        let open = ui.add(open.min_size(Vec2::new(120.0, 34.0)));
        if open.on_hover_text("Ctrl+O").clicked() {
            let request = crate::command::FileRequest::Open;
            targets.push(ActionTarget::Command(Command::RequestFile(request)));
        }
        ui.label(cx.tr("or drop files here"));
    });
}

/// What comes next, in the order of work.
fn steps(ui: &mut Ui, cx: &PanelContext) {
    ui.strong(cx.tr("From a model to an image"));
    let steps = [
        (cx.tr("Open…"), cx.tr("a model of any common format")),
        (
            cx.tr("Studio"),
            cx.tr("adds lamps and a floor, or a lamp in a room"),
        ),
        (
            cx.tr("Solve"),
            cx.tr("computes the light for all viewpoints"),
        ),
        (
            cx.tr("Render image"),
            cx.tr("traces an image of the current view"),
        ),
    ];
    ui.spacing_mut().item_spacing.y = 3.0;
    for (number, (what, about)) in (1..).zip(steps) {
        ui.horizontal_wrapped(|ui| {
            ui.weak(format!("{number}."));
            ui.label(what.trim_end_matches('…'));
            ui.weak(about);
        });
    }
}

fn described(example: Example, cx: &PanelContext) -> (&'static str, &'static str, &'static [u8]) {
    match example {
        Example::CornellBox => (
            cx.tr("Cornell box"),
            cx.tr("Coloured walls that tint each other."),
            include_bytes!("start/cornell-box.png"),
        ),
        Example::MirrorBlock => (
            cx.tr("Mirror block"),
            cx.tr("A mirror that throws light into its surroundings."),
            include_bytes!("start/mirror-block.png"),
        ),
        Example::SolidText => (
            cx.tr("3D text"),
            cx.tr("Solid letters with exact outlines, in a studio."),
            include_bytes!("start/solid-text.png"),
        ),
    }
}

/// A picture with a name, which works as a button.
fn tile(ui: &mut Ui, picture: Option<&TextureHandle>, name: &str) -> egui::Response {
    const SIZE: Vec2 = Vec2::new(154.0, 130.0);
    let (rect, response) = ui.allocate_exact_size(SIZE, Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    let visuals = ui.style().interact(&response);
    let stroke = if response.has_focus() {
        ui.visuals().selection.stroke
    } else {
        visuals.bg_stroke
    };
    let painter = ui.painter();
    painter.rect(rect, 5.0, visuals.weak_bg_fill, stroke, StrokeKind::Inside);
    let shown = Rect::from_min_size(rect.min + Vec2::splat(5.0), Vec2::new(144.0, 96.0));
    let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    match picture {
        Some(picture) => {
            painter.image(picture.id(), shown, whole, Color32::WHITE);
        }
        None => {
            painter.rect_filled(shown, 3.0, ui.visuals().extreme_bg_color);
        }
    }
    let words = painter.layout_job({
        let color = visuals.text_color();
        let mut job = egui::text::LayoutJob::simple_singleline(
            name.into(),
            FontId::proportional(13.0),
            color,
        );
        job.wrap.max_width = SIZE.x - 12.0;
        job.wrap.max_rows = 1;
        job
    });
    let below = Rect::from_min_max(egui::pos2(rect.left(), shown.bottom()), rect.max);
    let at = Align2::CENTER_CENTER.align_size_within_rect(words.size(), below);
    painter.galley(at.min, words, visuals.text_color());
    response
}

/// A PNG as a texture; `None` if it cannot be read.
fn texture(context: &egui::Context, name: &str, bytes: &[u8]) -> Option<TextureHandle> {
    let image = azulejo::formats::read_picture(bytes).ok()?;
    let [w, h] = THUMBNAIL;
    if (image.width, image.height) != (w, h) {
        return None;
    }
    let byte = |x: f32| (255.0 * srgb_from_linear(f64::from(x))).round() as u8;
    let rgb: Vec<u8> = image.pixels.iter().flatten().map(|&x| byte(x)).collect();
    let pixels = ColorImage::from_rgb([w as usize, h as usize], &rgb);
    Some(context.load_texture(name, pixels, TextureOptions::LINEAR))
}
