//! The files of a lightmap.

use super::BakedDocument;
use azulejo::bake::LightmapPage;
use azulejo::formats::gltf::patch::{
    self, Container, Convention, InstanceMode, LightmapEdit, LightmapUvs, LightsMode, MediaType,
};
use azulejo::formats::picture::{exr, png};
use azulejo::lightmap::{BakedLight, BytePicture, BytePictures};
use azulejo::output::{Draft, Output, commit};
use azulejo::scene::Image;
use azulejo::trace::Progress;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What of a lightmap is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightmapFile {
    /// The model with the lightmap, as `.glb` or `.gltf`.
    Model,
    /// Irradiance as `.exr`.
    Irradiance,
    /// Its standard error, likewise.
    StandardError,
}

impl LightmapFile {
    /// The extension of its files, where none is given.
    pub fn extension(self) -> &'static str {
        match self {
            LightmapFile::Model => "glb",
            LightmapFile::Irradiance | LightmapFile::StandardError => "exr",
        }
    }
}

/// Writes a file of a lightmap, and those that belong to it, or none; returns notes.
///
/// # Errors
///
/// Why not, as text.
pub fn write(
    baked: &BakedDocument,
    what: LightmapFile,
    path: &Path,
    progress: &Progress,
) -> Result<Vec<String>, String> {
    let extension = path.extension().and_then(|e| e.to_str());
    let extension = extension.map(str::to_ascii_lowercase);
    let (files, notes) = match (what, extension.as_deref()) {
        (LightmapFile::Model, Some("glb")) => model(baked, path, Container::Glb)?,
        (LightmapFile::Model, Some("gltf")) => model(baked, path, Container::Json)?,
        (LightmapFile::Model, _) => {
            return Err("expected a name that ends with .glb or .gltf".into());
        }
        (_, Some("exr")) => (
            pages(baked, what, path).map_err(|e| e.to_string())?,
            Vec::new(),
        ),
        _ => return Err("expected a name that ends with .exr".into()),
    };
    let drafts: Result<Vec<Draft>, String> = files
        .iter()
        .map(|(path, bytes)| draft(path, bytes).map_err(|e| e.to_string()))
        .collect();
    commit(drafts?, progress).map_err(|e| e.to_string())?;
    Ok(notes)
}

fn draft(path: &Path, bytes: &[u8]) -> Result<Draft, azulejo::output::OutputError> {
    let mut draft = Output::check(path)?.draft()?;
    draft.write_all(bytes).map_err(|e| draft.error(e))?;
    Ok(draft)
}

/// Files with their contents.
type FileList = Vec<(PathBuf, Vec<u8>)>;

/// The model, with the files beside it.
fn model(
    baked: &BakedDocument,
    path: &Path,
    container: Container,
) -> Result<(FileList, Vec<String>), String> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_moz = baked.settings.convention == Convention::Moz;
    let pictures = BytePictures::new(&baked.baked, is_moz);
    let picture = |receiver: usize, t: usize| pictures.of_triangles[receiver][t];
    let edit = LightmapEdit {
        content: None,
        objects: &baked.source.layouts_in(&baked.baked, picture),
        pages: &encoded(baked, &pictures).map_err(|e| e.to_string())?,
        uvs: LightmapUvs::default(),
        instances: InstanceMode::Copy,
        convention: baked.settings.convention,
        lights: match baked.settings.light {
            BakedLight::Indirect => LightsMode::Keep,
            _ => LightsMode::Dim,
        },
        mipmaps: false,
        output: patch::Output {
            container,
            stem: &stem,
        },
    };
    let file = baked.source.file.patched();
    let patched = patch::with_lightmap(&file, &baked.source.origins, &edit);
    let patched = patched.map_err(|e| e.to_string())?;
    let beside = patched.files.into_iter();
    let mut files: FileList = beside
        .map(|(name, bytes)| (path.with_file_name(name), bytes))
        .collect();
    files.push((path.to_owned(), patched.bytes));
    Ok((files, patched.notes))
}

/// The pages as pictures for viewers.
fn encoded(baked: &BakedDocument, pictures: &BytePictures) -> io::Result<Vec<patch::LightmapPage>> {
    let picture = |picture: &BytePicture| {
        let [width, height] = baked.baked.lightmap.pages[picture.page].size;
        let mut file = Vec::new();
        png::write(width, height, &picture.rgb, &mut file)?;
        Ok(patch::LightmapPage {
            directions: Vec::new(),
            name: picture.name.clone(),
            picture: file,
            media_type: MediaType::Png,
            intensity: picture.intensity,
            fallback: None,
        })
    };
    pictures.pictures.iter().map(picture).collect()
}

/// The numbers of all pages.
fn pages(baked: &BakedDocument, what: LightmapFile, path: &Path) -> io::Result<FileList> {
    let pages = &baked.baked.lightmap.pages;
    let file = |(number, page): (usize, &LightmapPage)| {
        let values = match what {
            LightmapFile::StandardError => &page.standard_error,
            _ => &page.irradiance,
        };
        let image = Image::opaque(page.size[0], page.size[1], values.clone());
        let mut file = Vec::new();
        exr::write(&image, &mut file)?;
        Ok((numbered(path, number, pages.len()), file))
    };
    pages.iter().enumerate().map(file).collect()
}

/// The name of a page's file: that of all, with its number where there are several.
pub fn numbered(path: &Path, number: usize, count: usize) -> PathBuf {
    if count == 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{}.{extension}", number + 1))
}
