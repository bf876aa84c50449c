//! The window with the lightmap: its pages, charts and errors.

mod facts;
mod page;

pub use page::{LightmapView, PageView};

use super::inputs;
use super::panel_context::PanelContext;
use super::viewport::{LegendText, number, paint_legend};
use crate::app::light_unit::ShownUnit;
use crate::bake::{BakedDocument, LightmapFile};
use crate::command::{Command, FileRequest};
use crate::gpu::ColorScale;
use crate::variants::all;
use egui::{
    Color32, ComboBox, Rect, Response, RichText, ScrollArea, Sense, Slider, TextureHandle,
    TextureOptions, Ui, Vec2, pos2, vec2,
};
use page::{PagePicture, Texel};
use std::sync::Arc;

/// Size of the picture when the window opens, points.
const FIRST_SIZE: f32 = 360.0;
/// Width of the legend, points.
const LEGEND: f32 = 112.0;
/// Stops by which the exposure of the light is changed at most.
const STOPS: f64 = 10.0;

/// The window that shows the pages of the lightmap.
#[derive(Default)]
pub struct LightmapWindow {
    /// Whether it is open.
    pub is_open: bool,
    /// The page, and the colours of its texels.
    pub view: PageView,
    /// Whether a texel is a point wide, instead of all being in view.
    has_full_size: bool,
    /// The lightmap that was last seen: a new one opens the window.
    seen: Option<Arc<BakedDocument>>,
    shown: Option<ShownPage>,
}

/// A page as a texture.
struct ShownPage {
    of: Arc<BakedDocument>,
    view: PageView,
    picture: PagePicture,
    texture: TextureHandle,
}

impl LightmapWindow {
    /// Opens the window, or closes it.
    pub fn toggle(&mut self) {
        self.is_open = !self.is_open;
    }

    /// Draws the window if it is open; a lightmap that is new opens it.
    pub fn show(&mut self, ui: &Ui, cx: &mut PanelContext) {
        let Some(result) = cx.app.lightmap.result.clone() else {
            (self.is_open, self.seen, self.shown) = (false, None, None);
            return;
        };
        if !self.seen.as_ref().is_some_and(|s| Arc::ptr_eq(s, &result)) {
            self.is_open = true;
            self.view.page = 0;
            self.seen = Some(Arc::clone(&result));
        }
        if !self.is_open {
            self.shown = None;
            return;
        }
        let mut is_open = true;
        egui::Window::new(cx.tr("Lightmap"))
            .id(egui::Id::unique("lightmap"))
            .open(&mut is_open)
            .default_pos([240.0, 90.0])
            .default_size([FIRST_SIZE + 220.0, FIRST_SIZE + 60.0])
            .collapsible(true)
            .resizable(true)
            .show(ui.ctx(), |ui| self.content(ui, cx, &result));
        self.is_open = is_open;
    }

    fn content(&mut self, ui: &mut Ui, cx: &mut PanelContext, result: &Arc<BakedDocument>) {
        self.controls(ui, cx, result);
        self.view.map = cx.app.view.false_color.map;
        self.refresh(ui, result);
        ui.horizontal_top(|ui| {
            let height = ui.available_height();
            if let Some(scale) = self.shown.as_ref().and_then(|s| s.picture.scale) {
                let (rect, _) = ui.allocate_exact_size(vec2(LEGEND, height), Sense::hover());
                self.legend(ui, cx, rect, &scale);
            }
            let free = vec2(ui.available_width() - 200.0, height);
            let size = free.max(Vec2::splat(120.0));
            let under = ui.allocate_ui(size, |ui| self.picture(ui, cx)).inner;
            ui.vertical(|ui| {
                facts::show(ui, cx, result);
                ui.separator();
                files(ui, cx);
                ui.separator();
                facts::texel(ui, cx, result, under.as_ref());
            });
        });
    }

    fn controls(&mut self, ui: &mut Ui, cx: &mut PanelContext, result: &BakedDocument) {
        ui.horizontal_wrapped(|ui| {
            let view = &mut self.view;
            let combo = ComboBox::from_id_salt("lightmap view").width(150.0);
            let quantity = &mut view.quantity;
            inputs::choice(combo, ui, quantity, all(), |&one| name(one, cx))
                .accessible_name(cx.tr("Displayed quantity"));
            let pages = result.baked.lightmap.pages.len();
            view.page = view.page.min(pages.saturating_sub(1));
            if pages > 1 {
                let mut shown = view.page + 1;
                inputs::labelled(ui, cx.tr("Page"), Slider::new(&mut shown, 1..=pages));
                view.page = shown - 1;
            }
            if view.quantity == LightmapView::Light {
                let slider = Slider::new(&mut view.stops, -STOPS..=STOPS).max_decimals(1);
                inputs::labelled(ui, cx.tr("Stops"), slider);
            } else if view.quantity != LightmapView::Charts {
                ui.checkbox(&mut view.is_logarithmic, cx.tr("Logarithmic"));
            }
            ui.checkbox(&mut self.has_full_size, cx.tr("Full size"));
            if let Some(shown) = &cx.app.lightmap.shown {
                let mut is_shown = shown.is_shown;
                if ui
                    .checkbox(&mut is_shown, cx.tr("In the viewport"))
                    .changed()
                {
                    cx.send(Command::ShowLightmap(is_shown));
                }
            }
        });
        if !cx.app.lightmap.is_current {
            let text =
                RichText::new(cx.tr("This lightmap belongs to an earlier state of the model."));
            ui.label(text.color(ui.visuals().warn_fg_color));
        }
    }

    /// Makes the texture anew if it shows something else.
    fn refresh(&mut self, ui: &Ui, result: &Arc<BakedDocument>) {
        let is_same = |s: &ShownPage| Arc::ptr_eq(&s.of, result) && s.view == self.view;
        if self.shown.as_ref().is_some_and(is_same) {
            return;
        }
        let most = ui.input(|i| i.max_texture_side);
        let picture = PagePicture::new(result, &self.view, most);
        let texture = ui.ctx().load_texture(
            "lightmap",
            picture.pixels(),
            TextureOptions {
                // Texels are seen as such.
                magnification: egui::TextureFilter::Nearest,
                ..TextureOptions::LINEAR
            },
        );
        self.shown = Some(ShownPage {
            of: Arc::clone(result),
            view: self.view,
            picture,
            texture,
        });
    }

    /// Draws the page; returns the texel under the pointer.
    fn picture(&self, ui: &mut Ui, cx: &PanelContext) -> Option<Texel> {
        let shown = self.shown.as_ref()?;
        let [width, height] = shown.picture.size.map(|n| n as f32);
        let free = ui.available_size();
        let scale = if self.has_full_size {
            1.0
        } else {
            (free.x / width).min(free.y / height)
        };
        let area = ScrollArea::both()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                let size = scale * vec2(width, height);
                let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
                let about = name(self.view.quantity, cx);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, about));
                let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter()
                    .image(shown.texture.id(), rect, whole, Color32::WHITE);
                under(&response, rect, scale, &shown.picture)
            });
        area.inner
    }

    fn legend(&self, ui: &Ui, cx: &PanelContext, rect: Rect, scale: &ColorScale) {
        let unit = match self.view.quantity {
            LightmapView::Error => cx.tr("% of the mean"),
            LightmapView::Density => cx.tr("texels per metre"),
            _ => ShownUnit::of(cx.app).irradiance(),
        };
        let text = LegendText {
            unit,
            beyond: (false, true),
        };
        let scale = match self.view.quantity {
            LightmapView::FalseColor => ColorScale {
                display: ShownUnit::of(cx.app).factor,
                ..*scale
            },
            _ => *scale,
        };
        paint_legend(ui.painter(), rect, &scale, text);
    }
}

/// The texel under the pointer.
fn under(response: &Response, rect: Rect, scale: f32, picture: &PagePicture) -> Option<Texel> {
    let at = (response.hover_pos()? - rect.min) / scale;
    picture.texel([at.x, at.y])
}

/// The buttons that save a lightmap.
fn files(ui: &mut Ui, cx: &mut PanelContext) {
    for (name, what) in [
        (cx.tr("Save the model…"), LightmapFile::Model),
        (cx.tr("Save the irradiance…"), LightmapFile::Irradiance),
        (cx.tr("Save the error…"), LightmapFile::StandardError),
    ] {
        if ui.button(name).clicked() {
            cx.send(Command::RequestFile(FileRequest::SaveLightmap(what)));
        }
    }
}

/// The name of what is shown.
fn name(view: LightmapView, cx: &PanelContext) -> &'static str {
    match view {
        LightmapView::Light => cx.tr("Light"),
        LightmapView::FalseColor => cx.tr("False colours"),
        LightmapView::Error => cx.tr("Standard error"),
        LightmapView::Charts => cx.tr("Charts"),
        LightmapView::Density => cx.tr("Texel density"),
    }
}

/// A value with its unit.
fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", number(value))
}
