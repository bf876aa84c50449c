//! Where the viewport is drawn: a texture of the graphics card that egui shows.

use crate::command::Selection;
use crate::gpu::{Frame, GpuError, Renderer, Scale};
use crate::view::View;
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Rect, TextureId, Ui};

/// The graphics card is gone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss(pub GpuError);

/// What a drawing was made from: the same again need not be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamp {
    pub view: View,
    pub size: [u32; 2],
    pub revision: u64,
    pub selection: Selection,
    pub seen: Option<u64>,
    pub scale: Scale,
}

/// A renderer and its picture.
pub struct Screen {
    state: RenderState,
    renderer: Renderer,
    texture: Option<TextureId>,
    drawn: Option<(Stamp, bool)>,
    /// What could not be drawn, until something changes.
    failure: Option<GpuError>,
}

impl Screen {
    pub fn new(state: &RenderState) -> Result<Screen, Loss> {
        let renderer = Renderer::new(state.device.clone(), state.queue.clone()).map_err(Loss)?;
        Ok(Screen {
            state: state.clone(),
            renderer,
            texture: None,
            drawn: None,
            failure: None,
        })
    }

    /// Whether the card is still there.
    pub fn check(&self) -> Result<(), Loss> {
        match self.renderer.check() {
            Err(lost @ GpuError::Lost { .. }) => Err(Loss(lost)),
            _ => Ok(()),
        }
    }

    /// Draws a frame, unless it is the last one again, and shows it.
    pub fn draw(&mut self, ui: &Ui, rect: Rect, stamp: Stamp, frame: &Frame) -> Result<(), Loss> {
        let key = (stamp, ui.visuals().dark_mode);
        if self.drawn.as_ref() != Some(&key) {
            match self.renderer.draw(frame) {
                Ok(shown) => {
                    let (view, is_new) = (shown.view.clone(), shown.is_new);
                    self.failure = None;
                    self.register(&view, is_new);
                }
                Err(lost @ GpuError::Lost { .. }) => return Err(Loss(lost)),
                Err(other) => self.failure = Some(other),
            }
            self.drawn = Some(key);
        }
        let painter = ui.painter();
        if let Some(failure) = &self.failure {
            painter.rect_filled(rect, 0.0, Color32::from_gray(40));
            let font = egui::FontId::proportional(14.0);
            let text = failure.to_string();
            let galley = painter.layout(text, font, Color32::WHITE, 0.8 * rect.width());
            painter.galley(rect.center() - 0.5 * galley.size(), galley, Color32::WHITE);
        } else if let Some(texture) = self.texture {
            let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            painter.image(texture, rect, whole, Color32::WHITE);
        }
        Ok(())
    }

    fn register(&mut self, view: &wgpu::TextureView, is_new: bool) {
        let mut renderer = self.state.renderer.write();
        let filter = wgpu::FilterMode::Nearest;
        let device = &self.state.device;
        match self.texture {
            None => {
                self.texture = Some(renderer.register_native_texture(device, view, filter));
            }
            Some(id) if is_new => {
                renderer.update_egui_texture_from_wgpu_texture(device, view, filter, id);
            }
            Some(_) => {}
        }
    }
}
