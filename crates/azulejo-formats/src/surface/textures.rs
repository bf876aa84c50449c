//! The pictures of a scene under construction, each once.

use crate::picture::PixelBudget;
use crate::reading::files::beside;
use crate::reading::text::shortened;
use crate::{FileError, Files};
use azulejo_scene::{
    Image, NumberMap, OpacityChannel, OpacityPicture, Texture, TextureId, WrapMode,
};
use std::collections::HashMap;

/// Pictures in the order in which they are first named, one per file.
#[derive(Debug, Default)]
pub(crate) struct Textures {
    list: Vec<Texture>,
    known: HashMap<String, TextureId>,
    /// The textures of a picture by how they go on beyond its edges.
    wrapped: HashMap<(TextureId, [WrapMode; 2]), TextureId>,
    pixels: PixelBudget,
}

impl Textures {
    /// The index of the picture `name`, which is named in the file `of` (empty for the model
    /// itself, else its name relative to the model's folder), and a warning if there is one.
    ///
    /// The picture is searched beside `of`, beside the model, and in both places without the folders
    /// of its name, which often exist only on its author's machine. All formats of
    /// [`picture`](crate::picture) are loaded, recognized by their content. A picture that cannot be loaded keeps its name, and only
    /// the first request for it returns the warning.
    pub fn index(
        &mut self,
        of: &str,
        name: &str,
        files: &dyn Files,
    ) -> (TextureId, Option<String>) {
        let name = normalized_path(name);
        let named_path = beside(of, &name);
        if let Some(&known) = self.known.get(&named_path) {
            return (known, None);
        }
        let (path, read) = find(&named_path, &name, files);
        let (id, problem) = match self.known.get(&path) {
            Some(&known) => (known, None),
            None => {
                self.known
                    .insert(path.clone(), self.list.len() as TextureId);
                self.embedded(path, read.map_err(|e| e.to_string()))
            }
        };
        self.known.insert(named_path, id);
        (id, problem)
    }

    /// Adds a picture that is embedded in the model's own file, under a unique name, and returns
    /// a warning if there is one; `read` holds its bytes, or why they cannot be read.
    pub fn embedded(
        &mut self,
        name: String,
        read: Result<Vec<u8>, String>,
    ) -> (TextureId, Option<String>) {
        let image = read.and_then(|bytes| self.pixels.decode(&bytes));
        let shown = shortened(&name);
        let warning = |why| format!("picture \"{shown}\" is not used: {why}");
        let problem = image.as_ref().err().map(warning);
        let id = self.list.len() as TextureId;
        self.list.push(Texture {
            path: name,
            image: image.ok(),
            ..Texture::default()
        });
        (id, problem)
    }

    /// A picture that goes on beyond its edges in this way: itself, if it was not requested with
    /// another, else a copy; itself, too, if all pictures together have no pixels left for that.
    pub fn wrapped(&mut self, id: TextureId, wrap: [WrapMode; 2]) -> TextureId {
        if let Some(&known) = self.wrapped.get(&(id, wrap)) {
            return known;
        }
        let is_first = self.wrapped.keys().all(|(other, _)| *other != id);
        let wrapped = match self.list.get_mut(id as usize) {
            Some(texture) if is_first => {
                texture.wrap = wrap;
                id
            }
            Some(texture) => {
                let pixels = texture.image.as_ref().map(|image| self.pixels.admit(image));
                if pixels.is_some_and(|admitted| admitted.is_err()) {
                    return id;
                }
                let copy = Texture {
                    wrap,
                    ..texture.clone()
                };
                self.list.push(copy);
                (self.list.len() - 1) as TextureId
            }
            None => id,
        };
        self.wrapped.insert((id, wrap), wrapped);
        wrapped
    }

    /// Whether the pixels of a picture are loaded.
    pub fn is_loaded(&self, id: TextureId) -> bool {
        self.list
            .get(id as usize)
            .is_some_and(|t| t.image.is_some())
    }

    /// A picture as an opacity: its alpha channel if it has one, else its brightness.
    pub fn opacity(&self, texture: TextureId) -> OpacityPicture {
        let has_alpha = self
            .image(texture)
            .is_some_and(|image| image.alpha.is_some());
        OpacityPicture {
            texture,
            channel: if has_alpha {
                OpacityChannel::Alpha
            } else {
                OpacityChannel::Luminance
            },
        }
    }

    /// The first of some pictures that has an alpha channel, as an opacity.
    pub fn alpha_of(&self, pictures: &[TextureId]) -> Option<OpacityPicture> {
        let opacities = pictures.iter().map(|&texture| self.opacity(texture));
        opacities
            .into_iter()
            .find(|p| p.channel == OpacityChannel::Alpha)
    }

    /// Adds a picture whose pixels are numbers in the model, under a unique name.
    ///
    /// # Errors
    /// The pictures have too many pixels together.
    pub fn add_pixels(&mut self, name: String, image: Image) -> Result<TextureId, String> {
        self.pixels.admit(&image)?;
        self.list.push(Texture {
            path: name,
            image: Some(image),
            ..Texture::default()
        });
        Ok((self.list.len() - 1) as TextureId)
    }

    /// The pixels of a picture, if it could be loaded.
    pub fn image(&self, id: TextureId) -> Option<&Image> {
        self.list.get(id as usize)?.image.as_ref()
    }

    /// The numbers of a picture, if it could be loaded.
    pub fn numbers(&self, id: TextureId) -> Option<NumberMap> {
        NumberMap::new(self.list.get(id as usize)?)
    }

    /// All pictures, in the order of their indices.
    pub fn into_list(self) -> Vec<Texture> {
        self.list
    }
}

/// The first of a picture's possible paths that exists, with its bytes; or the first path and
/// the error there.
fn find(path: &str, name: &str, files: &dyn Files) -> (String, Result<Vec<u8>, FileError>) {
    let read = files.read(path);
    if !matches!(read, Err(FileError::Missing | FileError::Outside)) {
        return (path.to_owned(), read);
    }
    let base = name.rsplit('/').next().unwrap_or(name);
    for other in [name, base] {
        if other != path
            && let Ok(bytes) = files.read(other)
        {
            return (other.to_owned(), Ok(bytes));
        }
    }
    (path.to_owned(), read)
}

/// A file's name with `/` between folders and no `.` among them, so that a file is not read and
/// stored again for each spelling of its name.
pub(crate) fn normalized_path(name: &str) -> String {
    let parts = name.split(['/', '\\']).filter(|p| !matches!(*p, "" | "."));
    let path = parts.collect::<Vec<_>>().join("/");
    if name.starts_with(['/', '\\']) {
        format!("/{path}")
    } else {
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Memory;
    use crate::picture::hdr;

    fn picture() -> Vec<u8> {
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![[0.5; 3]],
            alpha: None,
        };
        let mut bytes = Vec::new();
        hdr::write(&image, &mut bytes).unwrap();
        bytes
    }

    /// Requests `names`, which occur in the file `of`: expects these indices, pictures, and
    /// number of missing ones.
    fn check(of: &str, names: &[&str], indices: &[u32], paths: &[&str], missing: usize) {
        let files = Memory::new()
            .with("wood.hdr", picture())
            .with("maps/tile.hdr", picture());
        let mut textures = Textures::default();
        let results = names.iter().map(|n| textures.index(of, n, &files));
        let (texture_indices, problems): (Vec<_>, Vec<_>) = results.unzip();
        assert_eq!(texture_indices, indices);
        let list = textures.into_list();
        let loaded: Vec<&str> = list.iter().map(|t| t.path.as_str()).collect();
        assert_eq!(loaded, paths);
        assert_eq!(problems.iter().flatten().count(), missing);
        assert_eq!(list.iter().filter(|t| t.image.is_none()).count(), missing);
    }

    #[test]
    fn one_file_is_one_picture() {
        let names = [
            "wood.hdr",
            ".\\wood.hdr",
            "C:\\art\\wood.hdr",
            "maps\\tile.hdr",
        ];
        check("", &names, &[0, 0, 0, 1], &["wood.hdr", "maps/tile.hdr"], 0);
        let names = ["tile.hdr", "maps/tile.hdr", "../wood.hdr", "wood.hdr"];
        check(
            "maps/a.mtl",
            &names,
            &[0, 0, 1, 1],
            &["maps/tile.hdr", "wood.hdr"],
            0,
        );
    }

    #[test]
    fn a_picture_that_goes_on_in_two_ways_is_two_textures() {
        let files = Memory::new().with("wood.hdr", picture());
        let mut textures = Textures::default();
        let (id, _) = textures.index("", "wood.hdr", &files);
        let (clamp, repeat) = ([WrapMode::Clamp; 2], [WrapMode::Repeat; 2]);
        let ids = [clamp, repeat, clamp, repeat].map(|wrap| textures.wrapped(id, wrap));
        assert_eq!(ids, [0, 1, 0, 1]);
        let list = textures.into_list();
        assert_eq!([list[0].wrap, list[1].wrap], [clamp, repeat]);
        assert_eq!(list[0].image, list[1].image);
    }

    #[test]
    fn missing_pictures_keep_their_names() {
        check(
            "",
            &["a.jpg", "b/c.jpg", "a.jpg"],
            &[0, 1, 0],
            &["a.jpg", "b/c.jpg"],
            2,
        );
    }
}
