//! Small pictures of the material library, rendered once in the background.

use super::background::BackgroundWorker;
use super::light::PreviewLight;
use super::sphere::{self, SphereImage, SphereKey};
use azulejo::scene::Material;
use azulejo::trace::Progress;
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Width and height of the pictures, pixels.
const SIDE: u32 = 96;

/// Paths per pixel of successive passes over one picture, in each round over all pictures.
const ROUNDS: [&[u32]; 2] = [&[2], &[8, 16]];

/// Pictures of spheres of some materials, in a studio.
#[derive(Default)]
pub struct SpherePictures {
    textures: Vec<Option<TextureHandle>>,
    running: Option<RunningPictures>,
}

struct RunningPictures {
    results: Receiver<(usize, SphereImage)>,
    progress: Arc<Progress>,
    /// Kept until the last picture is done.
    _worker: BackgroundWorker,
}

impl SpherePictures {
    /// Starts rendering the first time, and takes what has been rendered since the last call.
    pub fn update(&mut self, context: &Context, materials: impl FnOnce() -> Vec<Material>) {
        if self.textures.is_empty() {
            let materials = materials();
            self.textures = vec![None; materials.len()];
            self.running = Some(start(materials, context.clone()));
        }
        self.take(context);
    }

    /// The picture of a material by its place in the list, if there is one already.
    pub fn of(&self, index: usize) -> Option<&TextureHandle> {
        self.textures.get(index)?.as_ref()
    }

    /// Whether pictures are still being rendered.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    fn take(&mut self, context: &Context) {
        let Some(running) = &self.running else {
            return;
        };
        loop {
            match running.results.try_recv() {
                Ok((index, image)) => {
                    let picture = ColorImage::from_rgb([image.side; 2], &image.rgb);
                    let name = format!("library {index}");
                    let texture = context.load_texture(name, picture, TextureOptions::LINEAR);
                    if let Some(place) = self.textures.get_mut(index) {
                        *place = Some(texture);
                    }
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => break,
            }
        }
        self.running = None;
    }
}

impl Drop for RunningPictures {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

fn start(materials: Vec<Material>, context: Context) -> RunningPictures {
    let (sender, results) = channel();
    let progress = Arc::new(Progress::new());
    let own = progress.clone();
    let worker = BackgroundWorker::new("library pictures");
    worker.spawn(move || {
        let light = PreviewLight::studio();
        let keys = materials.iter().map(|m| SphereKey::new(m, &light, SIDE));
        let keys: Vec<SphereKey> = keys.collect();
        // All are shown coarsely before the first one is refined.
        for passes in ROUNDS {
            for (index, key) in keys.iter().enumerate() {
                let mut show = |image| {
                    // The receiver may be gone.
                    let _ = sender.send((index, image));
                    context.request_repaint();
                };
                if sphere::draw_passes(key, passes, &own, &mut show).is_err() {
                    return;
                }
            }
        }
        drop(sender);
        context.request_repaint();
    });
    RunningPictures {
        results,
        progress,
        _worker: worker,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Rgb;
    use azulejo::trace::time::{Duration, Instant};

    #[test]
    fn each_material_gets_a_picture_and_none_blocks() {
        let context = Context::default();
        let mut pictures = SpherePictures::default();
        let materials = || {
            [0.1, 0.8]
                .map(|grey| Material::diffuse("", Rgb::grey(grey)))
                .to_vec()
        };
        pictures.update(&context, materials);
        let begin = Instant::now();
        while pictures.is_busy() {
            assert!(begin.elapsed() < Duration::from_secs(60), "no pictures");
            std::thread::sleep(Duration::from_millis(2));
            pictures.update(&context, || panic!("they are started once"));
        }
        assert!((0..2).all(|k| pictures.of(k).is_some()));
        assert!(pictures.of(2).is_none());
    }
}
