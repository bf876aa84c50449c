//! Progressive rendering of the current view by path tracing.

use super::files::with_default_extension;
use super::saving::PendingQuestion;
use super::{App, JobResult, Severity, Stopwatch};
use crate::command::FileRequest;
use crate::document::{SceneDocument, Solution};
use crate::jobs::{JobKind, JobSender};
use azulejo::formats::picture::{exr, png};
use azulejo::render::{FinalGather, SecondPass, Tone, auto_exposure, render, tone_map};
use azulejo::scene::{Camera, Image, Scene};
use azulejo::trace::{Progress, Tracer};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// An image being rendered.
#[derive(Clone, Debug)]
pub struct RenderedImage {
    /// Width and height of the finished image, pixels.
    pub size: (u32, u32),
    /// Linear radiance; `None` before the first pass. The first passes may have a lower resolution.
    pub image: Option<Arc<Image>>,
    /// Paths per pixel so far.
    pub samples: u32,
    /// Paths per pixel of the finished image.
    pub most: u32,
    /// Time spent rendering.
    pub passes: Stopwatch,
}

impl RenderedImage {
    /// Estimated time to the finished image, from the time of the paths so far.
    pub fn time_left(&self) -> Option<Duration> {
        let missing = self.most.checked_sub(self.samples).filter(|&n| n > 0)?;
        let share = f64::from(missing) / f64::from(self.samples);
        Duration::try_from_secs_f64(self.passes.elapsed().as_secs_f64() * share).ok()
    }
}

/// What a rendered image shows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RenderSubject {
    revision: u64,
    /// The address of the solution.
    light: usize,
    camera: Camera,
}

/// Limit on the number of pixels of an interactive render.
const MAX_PIXELS: u64 = 1 << 26;
/// How long the view must be still before rendering starts.
const QUIET: Duration = Duration::from_millis(80);
/// Final gather rays of each path.
const GATHER: u32 = 8;

impl App {
    /// Restarts the current render, if there is one, because its scene or view has changed.
    pub(super) fn restart_render(&mut self) {
        if let Some(render) = &self.render {
            let (size, most) = (render.size, render.most);
            self.start_render(size, most);
        }
    }

    /// Renders the view of the viewport progressively, up to `most` paths per pixel.
    pub(super) fn start_render(&mut self, size: (u32, u32), most: u32) {
        let pixels = u64::from(size.0) * u64::from(size.1);
        if !(1..=MAX_PIXELS).contains(&pixels) {
            let why = self.tr("cannot render an image of this size in pixels");
            let text = format!("{why}: {} × {}", size.0, size.1);
            self.report(Severity::Error, text);
            return;
        }
        self.jobs.cancel_kind(JobKind::Render);
        if self.render.is_none() && self.show_closed_render(size, most) {
            return;
        }
        let last = self.render.take().filter(|p| p.size == size);
        self.render = Some(RenderedImage {
            size,
            // Keep the old image until the new one is available, to avoid flicker.
            image: last.and_then(|p| p.image),
            samples: 0,
            most,
            passes: Stopwatch::default(),
        });
        self.run_render(None);
    }

    /// Renders the paths that are still missing; `before` is the image of those that are not.
    fn run_render(&mut self, before: Option<(Image, u32)>) {
        let Some(render) = &mut self.render else {
            return;
        };
        render.passes.resume();
        let work = RenderJob {
            document: self.document.clone(),
            solution: self.lighting.solution.clone(),
            camera: self.view.camera.clone(),
            size: render.size,
            most: render.most,
            before,
            gather: Some(self.preferences.picture_gather).filter(|&rays| rays > 0),
        };
        let title = self.tr("rendering");
        self.start_job(JobKind::Render, title, move |progress, outbox| {
            // While the camera moves, every frame requests another render: only the one that is
            // still current a little later copies the scene and builds its BVH.
            crate::platform::sleep(QUIET);
            if progress.advance(0).is_ok() {
                work.run(progress, outbox);
            }
            Ok(())
        });
    }

    /// Stops rendering and keeps the image, if there is one yet.
    pub(super) fn stop_render(&mut self) {
        self.jobs.cancel_kind(JobKind::Render);
        match &mut self.render {
            Some(render) if render.image.is_some() => render.passes.pause(),
            _ => self.render = None,
        }
    }

    /// Continues with an image that was stopped. The model and the view are still those of the
    /// image: a change of either closes it or starts it again.
    pub(super) fn resume_render(&mut self) {
        if self.is_busy(JobKind::Render) {
            return;
        }
        let Some(render) = self.render.as_ref().filter(|r| r.samples < r.most) else {
            return;
        };
        let image = render.image.as_deref().filter(|_| render.samples > 0);
        let before = image.cloned().map(|image| (image, render.samples));
        self.run_render(before);
    }

    /// Shows the image that was closed last and continues it, if it is of this view of the model as it
    /// is now.
    fn show_closed_render(&mut self, size: (u32, u32), most: u32) -> bool {
        let Some((subject, closed)) = self.closed_render.take() else {
            return false;
        };
        if subject != self.render_subject() || closed.size != size || closed.samples == 0 {
            return false;
        }
        let most = most.max(closed.samples);
        self.render = Some(RenderedImage { most, ..closed });
        self.resume_render();
        true
    }

    /// What a rendered image depends on: the model, its light and the camera.
    fn render_subject(&self) -> RenderSubject {
        RenderSubject {
            revision: self.revision,
            light: self
                .lighting
                .solution
                .as_ref()
                .map_or(0, |s| Arc::as_ptr(s) as usize),
            camera: self.view.camera.clone(),
        }
    }

    pub(super) fn close_render(&mut self) {
        self.jobs.cancel_kind(JobKind::Render);
        if let Some(mut render) = self.render.take() {
            render.passes.pause();
            self.closed_render = Some((self.render_subject(), render));
        }
        if self.question == Some(PendingQuestion::UnfinishedRender) {
            self.question = None;
        }
    }

    /// Called when the render job has ended.
    pub(super) fn end_render(&mut self) {
        if let Some(render) = &mut self.render {
            render.passes.pause();
        }
        if self.question == Some(PendingQuestion::UnfinishedRender) {
            (self.question, self.asking) = (None, Some(FileRequest::SaveRender));
        }
    }

    pub(super) fn take_render(&mut self, image: Image, samples: u32) {
        if let Some(render) = &mut self.render {
            render.image = Some(Arc::new(image));
            render.samples = samples;
        }
    }

    /// The exposure of a rendered image: that of the view, so that both are alike; without solved light,
    /// one that suits the image.
    pub fn picture_exposure(&self, image: &Image) -> f64 {
        match (self.view.exposure, self.lighting.range) {
            (Some(exposure), _) => exposure,
            (None, Some(_)) => self.auto_exposure(),
            (None, None) => auto_exposure(image),
        }
    }

    /// Writes the current image: PNG as displayed, EXR and HDR with linear radiance.
    pub(super) fn save_render(&mut self, path: PathBuf) {
        self.asking = None;
        let render = self.render.as_ref().filter(|p| p.samples > 0);
        let Some(image) = render.and_then(|p| p.image.clone()) else {
            return self.fail(self.tr("there is no image yet: render one first"));
        };
        let path = with_default_extension(path, "png");
        let exposure = self.picture_exposure(&image);
        let Some(output) = self.output(&path) else {
            return;
        };
        let saved = self.tr("saved");
        self.start_saving(path.clone(), move |progress, outbox| {
            let extension = path.extension().and_then(|e| e.to_str());
            let kind = extension.map(str::to_ascii_lowercase);
            output
                .write(progress, |out| {
                    write_picture(&image, kind.as_deref(), exposure, out)
                })
                .map_err(|e| e.to_string())?;
            outbox.send(JobResult::Note(format!("{}: {saved}", path.display())));
            Ok(())
        });
    }
}

fn write_picture(
    image: &Image,
    kind: Option<&str>,
    exposure: f64,
    out: &mut dyn Write,
) -> io::Result<()> {
    match kind {
        Some("exr") => exr::write(image, out),
        Some("hdr") => azulejo::formats::picture::hdr::write(image, out),
        Some("png") => {
            let pixels = shown(image, exposure);
            png::write(image.width, image.height, &pixels, out)
        }
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "unknown image format, expected .png, .exr or .hdr",
        )),
    }
}

/// The image as displayed: 8-bit sRGB, three bytes per pixel.
pub fn shown(image: &Image, exposure: f64) -> Vec<u8> {
    tone_map(image, exposure, Tone::default())
}

/// The input of a render job.
struct RenderJob {
    document: SceneDocument,
    solution: Option<Arc<Solution>>,
    camera: Camera,
    size: (u32, u32),
    most: u32,
    /// The image of the paths already traced, with their number.
    before: Option<(Image, u32)>,
    /// Rays of the final gather.
    gather: Option<u32>,
}

impl RenderJob {
    /// Renders a coarse image first, then passes that each double the number of paths.
    fn run(&self, progress: &Progress, outbox: &JobSender<JobResult>) {
        let (scene, _) = self.document.lit_scene(self.solution.as_deref());
        if progress.advance(0).is_err() {
            return;
        }
        let tracer = Tracer::new(&scene);
        let draw = |size: (u32, u32), samples: u32, seed: u64| {
            let options = SecondPass {
                size,
                samples_per_pixel: samples,
                gather: match self.gather {
                    // Everywhere: where some faces are gathered and some interpolated, the edges
                    // between them show.
                    Some(rays) => FinalGather::Everywhere(rays),
                    None => FinalGather::Everywhere(GATHER),
                },
                seed,
                ..SecondPass::default()
            };
            self.draw(&scene, &tracer, &options, progress)
        };
        let (mut sum, mut done) = match &self.before {
            Some((image, samples)) => (Some(image.clone()), *samples),
            None => {
                let coarse = (self.size.0.div_ceil(4), self.size.1.div_ceil(4));
                let Some(first) = draw(coarse, 1, 0) else {
                    return;
                };
                outbox.send(JobResult::Render(Box::new(first), 0));
                (None, 0)
            }
        };
        let mut next = done.max(1);
        while done < self.most {
            let samples = next.min(self.most - done);
            let Some(image) = draw(self.size, samples, u64::from(done) + 1) else {
                return;
            };
            let mean = match sum.take() {
                None => image,
                Some(before) => blend(before, done, &image, samples),
            };
            done += samples;
            next = done;
            outbox.send(JobResult::Render(Box::new(mean.clone()), done));
            sum = Some(mean);
        }
    }

    /// Renders one pass; `None` if cancelled.
    fn draw(
        &self,
        scene: &Scene,
        tracer: &Tracer,
        options: &SecondPass,
        progress: &Progress,
    ) -> Option<Image> {
        render(scene, tracer, &self.camera, options, progress).ok()
    }
}

/// The mean of two images, weighted with their paths per pixel.
fn blend(mut a: Image, na: u32, b: &Image, nb: u32) -> Image {
    let share = nb as f32 / (na + nb) as f32;
    for (x, y) in a.pixels.iter_mut().zip(&b.pixels) {
        for (x, y) in x.iter_mut().zip(y) {
            *x += share * (y - *x);
        }
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blend_is_the_mean_of_all_paths() {
        let image = |v: f32| Image {
            width: 1,
            height: 1,
            pixels: vec![[v, 2.0 * v, 0.0]],
            alpha: None,
        };
        let mean = blend(image(1.0), 3, &image(5.0), 1);
        assert_eq!(mean.pixels, [[2.0, 4.0, 0.0]]);
    }
}
