//! Textures of a model that is written to another folder.

use azulejo_formats::disk as fs;
use azulejo_formats::picture::{hdr, png};
use azulejo_formats::{Files, Folder, read_picture};
use azulejo_scene::{Image, Scene, Texture};
use std::io;
use std::path::Path;

/// The image files of a model's textures, relative to its folder.
pub(super) struct Pictures {
    /// The file of each texture.
    pub names: Vec<String>,
    /// Those that must be written.
    pub new: Vec<(String, Vec<u8>)>,
}

impl Pictures {
    /// For a model at `path`. Images that are found from the folder `home` remain where they are; all
    /// other loaded images are to be written next to the model, under unique names that start with
    /// its own.
    pub fn beside(path: &Path, home: Option<&Path>, scene: &Scene) -> io::Result<Pictures> {
        let mut pictures = Pictures {
            names: Vec::new(),
            new: Vec::new(),
        };
        let home = home.map(Folder::new);
        for texture in &scene.textures {
            let name = match &texture.image {
                Some(image) if !home.as_ref().is_some_and(|f| is_in(f, texture, image)) => {
                    let (bytes, extension) = encoded(image)?;
                    pictures.place(path, &plain_name(&texture.path), extension, bytes)
                }
                _ => texture.path.clone(),
            };
            pictures.names.push(name);
        }
        Ok(pictures)
    }

    /// A name for an image next to the model, or the one it has been written to before.
    fn place(&mut self, path: &Path, name: &str, extension: &str, bytes: Vec<u8>) -> String {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut number = 1;
        loop {
            let file = match number {
                1 => format!("{stem}-{name}.{extension}"),
                n => format!("{stem}-{name}-{n}.{extension}"),
            };
            let mut new = self.new.iter();
            let known = new.find(|(other, _)| other.to_lowercase() == file.to_lowercase());
            let there = match known {
                Some((_, other)) => Ok(*other == bytes),
                None => fs::read(path.with_file_name(&file)).map(|other| other == bytes),
            };
            match there {
                Ok(true) => return file,
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    self.new.push((file.clone(), bytes));
                    return file;
                }
                // Another file of this name, or something that is not a file.
                _ => number += 1,
            }
        }
    }
}

/// Whether the texture's path leads from a folder to its image.
fn is_in(folder: &Folder, texture: &Texture, image: &Image) -> bool {
    let bytes = folder.read(&texture.path).ok();
    let there = bytes.and_then(|bytes| read_picture(&bytes).ok());
    there.is_some_and(|there| there == *image)
}

/// An image as a file, and its extension: PNG, or HDR for values above 1.
fn encoded(image: &Image) -> io::Result<(Vec<u8>, &'static str)> {
    let mut bytes = Vec::new();
    if image.pixels.iter().flatten().any(|&v| v > 1.0) {
        hdr::write(image, &mut bytes)?;
        return Ok((bytes, "hdr"));
    }
    png::write_linear(image, &mut bytes)?;
    Ok((bytes, "png"))
}

/// An image's name without folders and extension, of characters that are valid everywhere.
fn plain_name(path: &str) -> String {
    const MOST: usize = 60;
    let file = path.rsplit(['/', '\\']).next().unwrap_or(path);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '_' {
            c
        } else {
            '-'
        }
    };
    let name: String = stem.chars().take(MOST).map(plain).collect();
    match name.trim_matches('-') {
        "" => "picture".to_owned(),
        name => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{Reading, read, write, write_copy};
    use azulejo_scene::synthetic::cube_room;
    use azulejo_trace::Progress;
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("azulejo-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(folder.join("other")).unwrap();
        folder
    }

    /// A picture of 8 bits, another of light that 8 bits do not say, and one brighter than white.
    fn images() -> [Image; 3] {
        let srgb = (0..4u8).flat_map(|k| [60 * k, 7, 255]).collect::<Vec<u8>>();
        let mut file = Vec::new();
        png::write(2, 2, &srgb, &mut file).unwrap();
        let eight = read_picture(&file).unwrap();
        let of = |v: f32| Image {
            width: 2,
            height: 1,
            pixels: vec![[v, 0.5, 0.25]; 2],
            alpha: None,
        };
        let (mut sixteen, mut bright) = (Vec::new(), Vec::new());
        png::write_linear(&of(0.123_4), &mut sixteen).unwrap();
        hdr::write(&of(4.0), &mut bright).unwrap();
        [
            eight,
            read_picture(&sixteen).unwrap(),
            read_picture(&bright).unwrap(),
        ]
    }

    fn scene(names: [&str; 3]) -> Scene {
        let mut scene = cube_room();
        scene.textures = (names.into_iter().zip(images()))
            .map(|(path, image)| Texture {
                path: path.to_owned(),
                image: Some(image),
                ..Texture::default()
            })
            .collect();
        scene
    }

    fn pixels(scene: &Scene) -> Vec<Option<Image>> {
        scene.textures.iter().map(|t| t.image.clone()).collect()
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().flatten();
        let mut names: Vec<String> = entries
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn pictures_that_are_in_no_file_come_back_from_grf() {
        let folder = folder("pictures");
        let (path, progress) = (folder.join("room.grf"), Progress::new());
        let scene = scene(["wood", "a/b:c.jpg", "wood"]);
        fs::write(folder.join("room-wood.png"), "of somebody else").unwrap();
        // Twice: the second time they are there.
        for _ in 0..2 {
            let losses = write(&scene, &path, &progress).unwrap();
            assert!(losses.is_empty(), "{losses:?}");
            let expected = [
                "other",
                "room-b-c.png",
                "room-wood-2.png",
                "room-wood.hdr",
                "room-wood.png",
                "room.grf",
            ];
            assert_eq!(names(&folder), expected);
        }
        let kept = fs::read_to_string(folder.join("room-wood.png")).unwrap();
        assert_eq!(kept, "of somebody else");
        let read_again = |path: &Path| read(path, &Reading::default(), &progress).unwrap().scene;
        let again = read_again(&path);
        assert_eq!(pixels(&again), pixels(&scene));
        // What is found where it is stays there; elsewhere it is not.
        write(&again, &folder.join("b.grf"), &progress).unwrap();
        assert_eq!(names(&folder).len(), 7);
        let elsewhere = folder.join("other/c.grf");
        write(&again, &elsewhere, &progress).unwrap();
        assert_eq!(names(&folder.join("other")).len(), 4);
        assert_eq!(pixels(&read_again(&elsewhere)), pixels(&scene));
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_copy_leaves_pictures_at_home() {
        let folder = folder("copy");
        let (home, progress) = (folder.join("other"), Progress::new());
        let mut file = Vec::new();
        let mut scene = scene(["wood.png", "b", "c"]);
        png::write_linear(&images()[0], &mut file).unwrap();
        fs::write(home.join("wood.png"), file).unwrap();
        let path = folder.join("copy.grf");
        write_copy(&scene, &path, Some(&home), &progress).unwrap();
        assert_eq!(
            names(&folder),
            ["copy-b.png", "copy-c.hdr", "copy.grf", "other"]
        );
        let reading = Reading {
            home: Some(home),
            ..Reading::default()
        };
        let again = read(&path, &reading, &progress).unwrap().scene;
        assert_eq!(pixels(&again), pixels(&scene));
        assert_eq!(again.textures[0].path, "wood.png");
        // Without a home nothing may stay, not even what is found beside the copy.
        scene = again;
        write_copy(&scene, &folder.join("d.grf"), None, &progress).unwrap();
        assert!(folder.join("d-copy-b.png").exists() && folder.join("d-wood.png").exists());
        fs::remove_dir_all(folder).unwrap();
    }
}
