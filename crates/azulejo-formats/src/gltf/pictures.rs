//! Textures of materials: files beside the model, data URIs and buffer views.

use super::accessor::Data;
use super::uri::{self, Uri};
use crate::Files;
use crate::picture::PixelBudget;
use crate::surface::textures::Textures;
use azulejo_scene::{Image, OpacityPicture, Rgb, Texture, TextureId, WrapMode};
use glam::DVec3;
use gltf_json::texture::WrappingMode;
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use std::borrow::Cow;
use std::collections::HashMap;

/// How often the bytes of the buffers may be decoded as textures, so that a hostile file cannot
/// have one picture decoded a thousand times: once as a colour, and once as an emission.
const MOST_DECODED: usize = 2;

/// Extensions that name pictures in other formats, in order of preference.
const OTHER_PICTURES: [&str; 4] = [
    "EXT_texture_webp",
    "MSFT_texture_dds",
    "KHR_texture_basisu",
    BRIGHT_PICTURES,
];

/// The extension of textures that names a Radiance HDR picture, beside a darker one for others.
pub(super) const BRIGHT_PICTURES: &str = "MOZ_texture_rgbe";

/// Extensions of textures with pictures of light: of these, bright ones come before the PNG for others.
const LIGHT_PICTURES: [&str; 2] = [BRIGHT_PICTURES, "KHR_texture_basisu"];

/// The pictures of a file, each loaded once.
pub(super) struct Pictures<'a> {
    root: &'a Root,
    data: &'a Data<'a>,
    files: &'a dyn Files,
    textures: Textures,
    /// Bytes of buffers that may still be decoded.
    left: usize,
    /// Loaded textures by index of the image.
    known: HashMap<usize, TextureId>,
    means: HashMap<usize, Result<Rgb, String>>,
    /// Pixels that may still be decoded for their mean alone.
    passing: PixelBudget,
}

/// Where the bytes of a picture come from.
enum PictureSource<'a> {
    /// In the file itself.
    Embedded(Cow<'a, [u8]>),
    /// In another file of this name.
    File(Cow<'a, str>),
}

impl<'a> Pictures<'a> {
    /// No pictures yet.
    pub fn new(data: &'a Data<'a>, files: &'a dyn Files) -> Pictures<'a> {
        Pictures {
            root: data.root,
            data,
            files,
            textures: Textures::default(),
            left: MOST_DECODED * data.buffers.size(),
            known: HashMap::new(),
            means: HashMap::new(),
            passing: PixelBudget::default(),
        }
    }

    /// All pictures that were requested.
    pub fn finish(self) -> Vec<Texture> {
        self.textures.into_list()
    }

    /// The texture's picture, if it has one, and a warning if there is one.
    pub fn index(
        &mut self,
        texture: Index<gltf_json::Texture>,
    ) -> (Option<TextureId>, Option<String>) {
        let Some(image) = self.image(texture) else {
            let problem = "texture without a picture: not used";
            return (None, Some(problem.to_owned()));
        };
        let (id, problem) = self.of_image(image, self.wrap(texture));
        (Some(id), problem)
    }

    /// The texture's picture of light: that in a format of bright texels, where it can be loaded, else the other.
    pub fn of_light(
        &mut self,
        texture: Index<gltf_json::Texture>,
    ) -> (Option<TextureId>, Option<String>) {
        let extensions = self.root.get(texture).and_then(|t| t.extensions.as_ref());
        let others = extensions.map(|e| &e.others);
        let named = LIGHT_PICTURES.iter().filter_map(|name| {
            let image = others?.get(*name)?.get("source")?.as_u64()?;
            (image < self.root.images.len() as u64).then_some((*name, image as usize))
        });
        let mut problem = None;
        let mut problem_of_basis = None;
        for (name, bright) in named {
            let (id, its_problem) = self.of_image(bright, self.wrap(texture));
            if self.is_loaded(id) {
                return (Some(id), its_problem);
            }
            match name {
                BRIGHT_PICTURES => problem = its_problem,
                _ => problem_of_basis = its_problem,
            }
        }
        let (other, its_problem) = self.index(texture);
        // Basis Universal beside a PNG is as it should be, and is not read.
        let problem = problem.or(its_problem);
        if other.is_some_and(|id| self.is_loaded(id)) {
            return (other, problem);
        }
        (other, problem_of_basis.or(problem))
    }

    /// The picture of an image, and a warning if there is one.
    fn of_image(&mut self, image: usize, wrap: [WrapMode; 2]) -> (TextureId, Option<String>) {
        if let Some(&known) = self.known.get(&image) {
            return (self.textures.wrapped(known, wrap), None);
        }
        let (id, problem) = match self.source(image) {
            Ok(PictureSource::File(name)) => self.textures.index("", &name, self.files),
            Ok(PictureSource::Embedded(bytes)) => {
                let name = self.name(image);
                self.textures.embedded(name, Ok(bytes.into_owned()))
            }
            Err(fault) => {
                let name = self.name(image);
                self.textures.embedded(name, Err(fault))
            }
        };
        self.known.insert(image, id);
        (self.textures.wrapped(id, wrap), problem)
    }

    /// How a texture goes on beyond its edges, by its sampler.
    fn wrap(&self, texture: Index<gltf_json::Texture>) -> [WrapMode; 2] {
        let sampler = self
            .root
            .get(texture)
            .and_then(|t| self.root.get(t.sampler?));
        let mode = |given: &Checked<WrappingMode>| match given {
            Checked::Valid(WrappingMode::ClampToEdge) => WrapMode::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => WrapMode::Mirror,
            _ => WrapMode::Repeat,
        };
        sampler.map_or([WrapMode::Repeat; 2], |s| {
            [mode(&s.wrap_s), mode(&s.wrap_t)]
        })
    }

    /// Adds a picture that was made from others.
    ///
    /// # Errors
    /// The reason, if it is too large.
    pub fn add(&mut self, name: &str, image: Image) -> Result<TextureId, String> {
        self.textures.add_pixels(name.to_owned(), image)
    }

    /// The first of some pictures that has an alpha channel, as an opacity.
    pub fn alpha_of(&self, pictures: &[TextureId]) -> Option<OpacityPicture> {
        self.textures.alpha_of(pictures)
    }

    /// Whether the pixels of a picture are loaded.
    pub fn is_loaded(&self, id: TextureId) -> bool {
        self.textures.is_loaded(id)
    }

    /// The mean of the numbers of a picture that was requested, if it could be loaded.
    pub fn mean_numbers(&self, id: TextureId) -> Option<DVec3> {
        Some(self.textures.numbers(id)?.mean())
    }

    /// The mean of a picture that was requested; black if it could not be loaded.
    pub fn mean_of(&self, id: TextureId) -> Rgb {
        self.textures.image(id).map_or(Rgb::BLACK, mean)
    }

    /// The mean of a texture as linear light.
    ///
    /// # Errors
    /// The reason, for a picture that cannot be loaded.
    pub fn mean(&mut self, texture: Index<gltf_json::Texture>) -> Result<Rgb, String> {
        let image = self.image(texture).ok_or("which has no picture")?;
        if let Some(known) = self.means.get(&image) {
            return known.clone();
        }
        let mean = self.load(image).map(|image| mean(&image));
        self.means.insert(image, mean.clone());
        mean
    }

    /// An image, decoded for its pixels alone.
    ///
    /// # Errors
    /// The reason, for a picture that cannot be loaded.
    pub fn load(&mut self, image: usize) -> Result<Image, String> {
        if image >= self.root.images.len() {
            return Err("which is not in the file".to_owned());
        }
        let bytes = match self.source(image)? {
            PictureSource::Embedded(bytes) => bytes,
            PictureSource::File(name) => {
                let read = self.files.read(&name);
                Cow::Owned(read.map_err(|e| e.to_string())?)
            }
        };
        self.passing.decode(&bytes)
    }

    fn image(&self, texture: Index<gltf_json::Texture>) -> Option<usize> {
        let texture = self.root.get(texture)?;
        if self.root.get(texture.source).is_some() {
            return Some(texture.source.value());
        }
        // Pictures in other formats than glTF's own are named by extensions.
        let others = &texture.extensions.as_ref()?.others;
        let named = |name: &&str| others.get(*name)?.get("source")?.as_u64();
        let source = OTHER_PICTURES.iter().find_map(named)? as usize;
        (source < self.root.images.len()).then_some(source)
    }

    /// The name of an embedded picture, used in place of a file name.
    fn name(&self, image: usize) -> String {
        let name = self.root.images[image].name.clone();
        name.filter(|n| !n.is_empty())
            .unwrap_or_else(|| format!("image {image}"))
    }

    fn source(&mut self, image: usize) -> Result<PictureSource<'a>, String> {
        let json = &self.root.images[image];
        match (json.buffer_view, &json.uri) {
            (Some(view), _) => {
                let bytes = self.data.buffers.view(view)?;
                let left = self.left.checked_sub(bytes.len());
                self.left = left.ok_or("more pictures than the buffers can hold")?;
                Ok(PictureSource::Embedded(bytes.into()))
            }
            (None, Some(uri)) => Ok(match uri::read(uri)? {
                Uri::Data(bytes) => PictureSource::Embedded(bytes.into()),
                Uri::File(name) => PictureSource::File(name),
            }),
            (None, None) => Err("an image without a uri".to_owned()),
        }
    }
}

fn mean(image: &Image) -> Rgb {
    let pixels = image.pixels.iter().map(|p| Rgb::from(p.map(f64::from)));
    let sum = pixels.fold(Rgb::BLACK, |sum, pixel| sum + pixel);
    sum * (1.0 / image.pixels.len().max(1) as f64)
}
