//! Small pictures of recent files, kept between sessions.

use azulejo::formats::picture::png;
use azulejo::output::Output;
use azulejo::trace::Progress;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// Width and height of a thumbnail, pixels.
pub const THUMBNAIL: [u32; 2] = [192, 128];

/// Pictures that are kept; the oldest are deleted.
const MAX_KEPT: usize = 64;

/// The folder of the thumbnails.
#[derive(Clone, Debug, Default)]
pub struct Thumbnails {
    folder: Option<PathBuf>,
}

impl Thumbnails {
    /// Thumbnails in a folder, which need not exist; without one there are none.
    pub fn new(folder: Option<PathBuf>) -> Thumbnails {
        Thumbnails { folder }
    }

    /// The file of the thumbnail of a model, which need not exist.
    pub fn path(&self, model: &Path) -> Option<PathBuf> {
        let mut hasher = DefaultHasher::new();
        model.hash(&mut hasher);
        let name = format!("{:016x}.png", hasher.finish());
        Some(self.folder.as_ref()?.join(name))
    }

    /// Writes the thumbnail of a model from an image of any size, three bytes per pixel. Without a
    /// thumbnail nothing is lost, so that failures are not reported.
    pub fn store(&self, model: &Path, width: u32, height: u32, rgb: &[u8]) {
        let Some(path) = self.path(model) else {
            return;
        };
        let Some(small) = reduced(width, height, rgb) else {
            return;
        };
        if let Some(folder) = path.parent()
            && std::fs::create_dir_all(folder).is_ok()
            && let Ok(output) = Output::check(&path)
        {
            let [w, h] = THUMBNAIL;
            let _ = output.write(&Progress::new(), |out| png::write(w, h, &small, out));
            self.prune();
        }
    }

    fn prune(&self) {
        let entries = self.folder.as_ref().and_then(|f| std::fs::read_dir(f).ok());
        let files = entries.into_iter().flatten().flatten();
        let mut kept: Vec<_> = files
            .filter_map(|file| Some((file.metadata().ok()?.modified().ok()?, file.path())))
            .collect();
        kept.sort();
        let superfluous = kept.len().saturating_sub(MAX_KEPT);
        for (_, path) in kept.drain(..superfluous) {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The middle of an image in the shape of a thumbnail, each pixel the mean of those that it covers.
fn reduced(width: u32, height: u32, rgb: &[u8]) -> Option<Vec<u8>> {
    let [w, h] = THUMBNAIL;
    if width < w || height < h || rgb.len() < 3 * width as usize * height as usize {
        return None;
    }
    let scale = (f64::from(width) / f64::from(w)).min(f64::from(height) / f64::from(h));
    let left = 0.5 * (f64::from(width) - scale * f64::from(w));
    let top = 0.5 * (f64::from(height) - scale * f64::from(h));
    let mut small = Vec::with_capacity(3 * w as usize * h as usize);
    let range = |start: f64, k: u32, end: u32| {
        let first = (start + scale * f64::from(k)) as u32;
        let last = (start + scale * f64::from(k + 1)).ceil() as u32;
        first.min(end - 1)..last.clamp(first + 1, end)
    };
    for y in 0..h {
        for x in 0..w {
            let (mut sum, mut count) = ([0u32; 3], 0u32);
            for row in range(top, y, height) {
                for column in range(left, x, width) {
                    let start = 3 * (row as usize * width as usize + column as usize);
                    for (sum, &byte) in sum.iter_mut().zip(&rgb[start..start + 3]) {
                        *sum += u32::from(byte);
                    }
                    count += 1;
                }
            }
            small.extend(sum.map(|s| (s / count.max(1)) as u8));
        }
    }
    Some(small)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thumbnail_is_the_middle_of_a_picture() {
        let (width, height) = (800, 400);
        let pixel = |k: u32| {
            let x = k % width;
            // Red outside of the middle 600 pixels, which have the shape of a thumbnail.
            if (100..700).contains(&x) {
                [0, 128, 0]
            } else {
                [255, 0, 0]
            }
        };
        let rgb: Vec<u8> = (0..width * height).flat_map(pixel).collect();
        let small = reduced(width, height, &rgb).unwrap();
        assert_eq!(small.len(), 3 * 192 * 128);
        assert!(small.chunks(3).all(|p| p == [0, 128, 0]));
        assert_eq!(reduced(10, 10, &[0; 300]), None);
    }

    #[test]
    fn thumbnails_are_kept_by_the_path_of_their_model() {
        let folder = std::env::temp_dir().join(format!("azulejo-thumbs-{}", std::process::id()));
        let thumbnails = Thumbnails::new(Some(folder.clone()));
        let model = Path::new("/a/model.obj");
        thumbnails.store(model, 192, 128, &[7; 3 * 192 * 128]);
        let path = thumbnails.path(model).unwrap();
        assert!(path.exists() && path.starts_with(&folder));
        assert_ne!(thumbnails.path(Path::new("/b/model.obj")), Some(path));
        assert_eq!(Thumbnails::default().path(model), None);
        let _ = std::fs::remove_dir_all(folder);
    }
}
