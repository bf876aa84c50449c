//! The rendered image in the viewport.

use crate::app::App;
use azulejo::scene::Image;
use egui::{Color32, Rect, TextureHandle, TextureOptions, Ui, Vec2};
use std::sync::Arc;

/// The rectangle of an image of this size: as large as possible, centred.
pub fn fit(rect: Rect, (width, height): (u32, u32)) -> Rect {
    let size = Vec2::new(width.max(1) as f32, height.max(1) as f32);
    let scale = (rect.width() / size.x).min(rect.height() / size.y);
    Rect::from_center_size(rect.center(), scale * size)
}

/// The rendered image as a texture.
#[derive(Default)]
pub struct RenderTexture {
    texture: Option<TextureHandle>,
    made_of: Option<(Arc<Image>, f64)>,
}

impl RenderTexture {
    /// Draws the current image, as large as possible.
    pub fn show(&mut self, ui: &Ui, rect: Rect, app: &App) {
        ui.painter().rect_filled(rect, 0.0, Color32::BLACK);
        let Some(picture) = &app.render else { return };
        if let Some(image) = &picture.image {
            self.refresh(ui, image, app.picture_exposure(image));
        } else {
            self.made_of = None;
        }
        if let (Some(texture), Some(_)) = (&self.texture, &self.made_of) {
            let place = fit(rect, picture.size);
            let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            ui.painter()
                .image(texture.id(), place, whole, Color32::WHITE);
        }
    }

    fn refresh(&mut self, ui: &Ui, image: &Arc<Image>, exposure: f64) {
        let is_same = self.made_of.as_ref().is_some_and(|(old, old_exposure)| {
            Arc::ptr_eq(old, image) && *old_exposure == exposure
        });
        if is_same {
            return;
        }
        let pixels = pixels(image, exposure);
        match &mut self.texture {
            Some(texture) => texture.set(pixels, TextureOptions::LINEAR),
            None => {
                let context = ui.ctx();
                self.texture =
                    Some(context.load_texture("rendering", pixels, TextureOptions::LINEAR));
            }
        }
        self.made_of = Some((Arc::clone(image), exposure));
    }
}

/// An image as displayed by egui.
fn pixels(image: &Image, exposure: f64) -> Arc<egui::ColorImage> {
    let bytes = crate::app::shown(image, exposure);
    let size = [image.width as usize, image.height as usize];
    Arc::new(egui::ColorImage::from_rgb(size, &bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_fills_what_its_shape_allows() {
        let rect = Rect::from_min_size(egui::pos2(10.0, 20.0), Vec2::new(200.0, 100.0));
        assert_eq!(fit(rect, (400, 200)), rect);
        let upright = fit(rect, (50, 100));
        assert_eq!(upright.size(), Vec2::new(50.0, 100.0));
        assert_eq!(upright.center(), rect.center());
        assert!(fit(rect, (0, 0)).is_finite());
    }
}
