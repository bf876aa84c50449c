//! The texture of the viewport, which egui displays.

use crate::command::Selection;
use crate::gpu::{ColorScale, GpuError, PixelBuffer, Renderer, ViewportFrame};
use crate::view::ModelView;
use eframe::egui_wgpu::RenderState;
use egui::{Color32, Painter, Rect, TextureId, Ui};
use std::time::Duration;

/// The graphics device is lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceLost(pub GpuError);

/// Everything that a drawing depends on: if it is unchanged, nothing is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawStamp {
    pub view: ModelView,
    pub size: [u32; 2],
    pub revision: u64,
    pub selection: Selection,
    pub seen: Option<u64>,
    pub lightmap: Option<u64>,
    pub task_plane: Option<u64>,
    pub scale: ColorScale,
}

/// The drawing on the screen.
#[derive(Clone, Debug, PartialEq)]
struct LastDrawing {
    stamp: DrawStamp,
    is_dark: bool,
    is_smooth: bool,
}

/// Number of triangles above which antialiasing by a software driver is too slow.
const MAX_SMOOTH: usize = 200_000;
/// How long the view must be still before a software driver draws with antialiasing.
const REST: Duration = Duration::from_millis(150);

/// A renderer and its texture.
pub struct ViewportTexture {
    state: RenderState,
    renderer: Renderer,
    texture: Option<TextureId>,
    drawn: Option<LastDrawing>,
    /// The error of the last attempt, until something changes.
    failure: Option<GpuError>,
}

impl ViewportTexture {
    pub fn new(state: &RenderState) -> Result<ViewportTexture, DeviceLost> {
        let renderer =
            Renderer::new(state.device.clone(), state.queue.clone()).map_err(DeviceLost)?;
        Ok(ViewportTexture {
            state: state.clone(),
            renderer,
            texture: None,
            drawn: None,
            failure: None,
        })
    }

    /// Whether the device is still available.
    pub fn check(&self) -> Result<(), DeviceLost> {
        match self.renderer.check() {
            Err(lost @ GpuError::Lost { .. }) => Err(DeviceLost(lost)),
            _ => Ok(()),
        }
    }

    /// Reads the last drawing back.
    pub fn read(&self) -> Result<PixelBuffer, GpuError> {
        self.renderer.read()
    }

    /// The device.
    pub fn state(&self) -> &RenderState {
        &self.state
    }

    /// Positions on the colour scale by pixel; see [`Renderer::values`].
    pub fn values(&mut self, frame: &ViewportFrame) -> Result<PixelBuffer, GpuError> {
        self.renderer.values(frame)
    }

    /// Draws a frame unless it is unchanged, and displays it.
    pub fn draw(
        &mut self,
        ui: &Ui,
        painter: &Painter,
        rect: Rect,
        stamp: DrawStamp,
        frame: &ViewportFrame,
    ) -> Result<(), DeviceLost> {
        let is_smooth = self.wants_antialiasing(ui, &stamp, frame);
        let drawing = LastDrawing {
            stamp,
            is_dark: ui.visuals().dark_mode,
            is_smooth,
        };
        if self.drawn.as_ref() != Some(&drawing) {
            let frame = ViewportFrame {
                antialiasing: is_smooth,
                ..frame.clone()
            };
            match self.renderer.draw(&frame) {
                Ok(shown) => {
                    let (view, is_new) = (shown.view.clone(), shown.is_new);
                    self.failure = None;
                    self.register(&view, is_new);
                }
                Err(lost @ GpuError::Lost { .. }) => return Err(DeviceLost(lost)),
                Err(other) => self.failure = Some(other),
            }
            self.drawn = Some(drawing);
        }
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

    /// Whether to use antialiasing: always with a GPU; with a software driver once the view is
    /// still, because it takes three times as long.
    fn wants_antialiasing(&self, ui: &Ui, stamp: &DrawStamp, frame: &ViewportFrame) -> bool {
        if !self.renderer.is_software() {
            return true;
        }
        let triangles = frame.objects.iter().map(|o| o.mesh.faces.triangle_count());
        if triangles.sum::<usize>() > MAX_SMOOTH {
            return false;
        }
        let Some(last) = &self.drawn else {
            return true;
        };
        let moves = last.stamp.view.camera != stamp.view.camera;
        if moves {
            ui.ctx().request_repaint_after(REST);
            return false;
        }
        // Events that change nothing keep the current quality.
        last.is_smooth || !ui.input(|i| i.pointer.any_down())
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
