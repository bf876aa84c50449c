//! The files of a lightmap.

use super::args::{BakeArgs, ImageArg, LightArg, LightsArg};
use super::page;
use super::source::BakeSource;
use crate::failure::Failure;
use crate::report::{Report, bytes, percent};
use crate::session::Session;
use azulejo::bake::{LightmapPage, srgb_bytes};
use azulejo::lightmap::Baked;
use azulejo::output::{Draft, Output, commit};
use azulejo_formats::gltf::patch::{
    self, Container, LightmapEdit, LightmapUvs, LightsMode, MediaType, PatchedFile,
};
use azulejo_formats::picture::{exr, hdr, png};
use azulejo_scene::Image;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Part of the largest irradiance below which 8 bits are coarser than a hundredth.
const DIM: f64 = 0.1;

/// Share of the area below it from which on that is said.
const MUCH_DIM: f64 = 0.2;

/// What the main output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputKind {
    Glb,
    Json,
    Page,
}

/// Checked outputs of a command.
pub struct BakeOutputs {
    main: Option<(Output, OutputKind)>,
    lightmap: Option<PathBuf>,
    error_map: Option<PathBuf>,
}

impl BakeOutputs {
    /// Checks that the files can be written, before the work begins.
    pub fn check(args: &BakeArgs) -> Result<BakeOutputs, Failure> {
        let main = match &args.output {
            None => None,
            Some(path) => Some((Output::check(path)?, kind_of(path)?)),
        };
        for path in [&args.files.lightmap, &args.files.error_map]
            .into_iter()
            .flatten()
        {
            if path
                .extension()
                .is_none_or(|e| !e.eq_ignore_ascii_case("exr"))
            {
                return Err(Failure::misuse(format_args!(
                    "{}: expected a name that ends with .exr",
                    path.display()
                )));
            }
            Output::check(path)?;
        }
        Ok(BakeOutputs {
            main,
            lightmap: args.files.lightmap.clone(),
            error_map: args.files.error_map.clone(),
        })
    }

    /// Whether a result goes to standard output.
    pub fn is_stdout(&self) -> bool {
        self.main
            .as_ref()
            .is_some_and(|(output, _)| output.is_stdout())
    }

    /// Writes all files, or none.
    pub fn write(
        &self,
        args: &BakeArgs,
        source: &BakeSource,
        baked: &Baked,
        uvs: LightmapUvs,
        session: &mut Session,
        report: &mut Report,
    ) -> Result<(), Failure> {
        let mut drafts = DraftList::default();
        let pages = &baked.lightmap.pages;
        for (path, values) in [
            (
                &self.lightmap,
                (|p| &p.irradiance) as fn(&LightmapPage) -> &Vec<[f32; 3]>,
            ),
            (&self.error_map, |p| &p.standard_error),
        ] {
            let Some(path) = path else { continue };
            for (number, page) in pages.iter().enumerate() {
                let [width, height] = page.size;
                let image = Image::opaque(width, height, values(page).clone());
                let mut file = Vec::new();
                exr::write(&image, &mut file).map_err(Failure::failed)?;
                drafts.add(&numbered(path, number, pages.len()), &file)?;
            }
        }
        match &self.main {
            Some((output, OutputKind::Page)) => {
                let mut file = Vec::new();
                page::write(args, source, baked, &mut file).map_err(Failure::failed)?;
                drafts.add_to(output, &file)?;
            }
            Some((output, kind)) => {
                let patched = self.patched(output, *kind, args, source, baked, uvs)?;
                patched.notes.iter().for_each(|note| session.note(note));
                say_dim(args, baked, session, report);
                for (name, file) in &patched.files {
                    drafts.add(&output.path().with_file_name(name), file)?;
                }
                drafts.add_to(output, &patched.bytes)?;
            }
            None => {}
        }
        commit(drafts.drafts, session.progress())?;
        let names = drafts.written.join(", ");
        report.fact("output", drafts.written, "wrote", names);
        Ok(())
    }

    fn patched(
        &self,
        output: &Output,
        kind: OutputKind,
        args: &BakeArgs,
        source: &BakeSource,
        baked: &Baked,
        uvs: LightmapUvs,
    ) -> Result<PatchedFile, Failure> {
        let stem = output.path().file_stem().unwrap_or_default();
        let edit = LightmapEdit {
            objects: &source.layouts(baked),
            pages: &pictures(args, baked)?,
            uvs,
            instances: args.files.instances.written(),
            convention: args.files.convention.written(),
            lights: lights(args),
            mipmaps: args.texels.mips > 0,
            output: patch::Output {
                container: match kind {
                    OutputKind::Json => Container::Json,
                    _ => Container::Glb,
                },
                stem: &stem.to_string_lossy(),
            },
        };
        let file = source.file.patched();
        patch::with_lightmap(&file, &source.origins, &edit).map_err(Failure::failed)
    }
}

fn kind_of(path: &Path) -> Result<OutputKind, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("glb") => Ok(OutputKind::Glb),
        Some("gltf") => Ok(OutputKind::Json),
        Some("html" | "htm") => Ok(OutputKind::Page),
        _ => Err(Failure::misuse(format_args!(
            "{}: a lightmap is written to .glb, .gltf or .html",
            path.display()
        ))),
    }
}

fn lights(args: &BakeArgs) -> LightsMode {
    match args.files.baked_lights {
        Some(lights) => lights.written(),
        None if args.texels.light == LightArg::Indirect => LightsArg::Keep.written(),
        None => LightsArg::Dim.written(),
    }
}

/// The pictures of all pages.
fn pictures(args: &BakeArgs, baked: &Baked) -> Result<Vec<patch::LightmapPage>, Failure> {
    let count = baked.lightmap.pages.len();
    let picture = |(number, page): (usize, &LightmapPage)| {
        let [width, height] = page.size;
        let (rgb, intensity) = srgb_bytes(&page.irradiance);
        let mut small = Vec::new();
        png::write(width, height, &rgb, &mut small).map_err(Failure::failed)?;
        let name = match count {
            1 => "lightmap".to_owned(),
            _ => format!("lightmap {}", number + 1),
        };
        Ok(match args.files.image {
            ImageArg::Png => patch::LightmapPage {
                name,
                picture: small,
                media_type: MediaType::Png,
                intensity,
                fallback: None,
            },
            ImageArg::Hdr => {
                let image = Image::opaque(width, height, page.irradiance.clone());
                let mut file = Vec::new();
                hdr::write(&image, &mut file).map_err(Failure::failed)?;
                patch::LightmapPage {
                    name,
                    picture: file,
                    media_type: MediaType::Hdr,
                    intensity: 1.0,
                    fallback: None,
                }
            }
        })
    };
    baked
        .lightmap
        .pages
        .iter()
        .enumerate()
        .map(picture)
        .collect()
}

/// Says how much of a lightmap is so dark that 8 bits show it worse than was asked for.
fn say_dim(args: &BakeArgs, baked: &Baked, session: &mut Session, report: &mut Report) {
    if args.files.image != ImageArg::Png {
        return;
    }
    let dim = baked.lightmap.share_below(DIM);
    report.value("dim_share", dim);
    if dim > MUCH_DIM {
        session.note(&format!(
            "{} of the area is below a tenth of the brightest texel, where the steps of an 8-bit PNG \
             are more than 1%: --lightmap E.exr or --image hdr keep it",
            percent(dim)
        ));
    }
}

/// The name of a page's file.
pub fn numbered(path: &Path, number: usize, count: usize) -> PathBuf {
    if count == 1 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{}.{extension}", number + 1))
}

/// Files that are put in place together.
#[derive(Default)]
struct DraftList {
    drafts: Vec<Draft>,
    written: Vec<String>,
}

impl DraftList {
    fn add(&mut self, path: &Path, file: &[u8]) -> Result<(), Failure> {
        self.add_to(&Output::check(path)?, file)
    }

    fn add_to(&mut self, output: &Output, file: &[u8]) -> Result<(), Failure> {
        let mut draft = output.draft()?;
        draft.write_all(file).map_err(|e| draft.error(e))?;
        let size = bytes(file.len() as u64);
        self.written
            .push(format!("{} ({size})", output.path().display()));
        self.drafts.push(draft);
        Ok(())
    }
}
