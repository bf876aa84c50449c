//! The files of a lightmap.

use super::args::{BakeArgs, LightArg, LightsArg};
use super::pictures::{self, Pictures};
use super::source::BakeSource;
use crate::draft_list::DraftList;
use crate::failure::Failure;
use crate::report::{Report, percent};
use crate::session::Session;
use azulejo::bake::web_page::{self, PageModel};
use azulejo::bake::{DIRECTIONAL, LightmapPage};
use azulejo::lightmap::Baked;
use azulejo::output::Output;
use azulejo::page;
use azulejo_formats::Files;
use azulejo_formats::gltf::patch::{
    self, Container, LightmapEdit, LightmapUvs, LightsMode, PatchedFile,
};
use azulejo_formats::picture::exr::{self, ChannelValues, NamedChannel};
use azulejo_scene::{Image, Up};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

/// What the main output is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutputKind {
    Glb,
    Json,
    Page,
}

/// What files have beside pictures.
pub struct WrittenPlaces {
    /// Where texture coordinates are.
    pub uvs: LightmapUvs,
    /// Texels around charts.
    pub padding: u32,
    /// What the lightmap was computed from.
    pub content: String,
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
            Some(path) if args.html => Some((Output::check(path)?, OutputKind::Page)),
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

    /// The first file that is written; nothing if all goes to standard output.
    pub fn file(&self) -> Option<&Path> {
        let main = self.main.as_ref().map(|(output, _)| output);
        let main = main.filter(|output| !output.is_stdout());
        let maps = self.lightmap.as_deref().or(self.error_map.as_deref());
        main.map(Output::path).or(maps)
    }

    /// Writes all files, or none.
    pub fn write(
        &self,
        args: &BakeArgs,
        source: &BakeSource,
        baked: &Baked,
        places: WrittenPlaces,
        session: &mut Session,
        report: &mut Report,
    ) -> Result<(), Failure> {
        // All files stay drafts until the last is complete, so that a failure replaces none of them.
        let mut drafts = DraftList::default();
        let pages = &baked.lightmap.pages;
        // Lightmap and error map have floats of 16 bits where these can hold them, unless 32 are requested.
        for (path, values) in [
            (
                &self.lightmap,
                (|p| &p.irradiance) as fn(&LightmapPage) -> &Vec<[f32; 3]>,
            ),
            (&self.error_map, |p| &p.standard_error),
        ] {
            let Some(path) = path else { continue };
            if let Some(harmonics) = &baked.harmonics {
                let up = source.scene.units.up;
                for (number, page) in pages.iter().enumerate() {
                    let file = layered(
                        page,
                        harmonics.each_ref().map(|h| &h.pages[number]),
                        values,
                        up,
                    )?;
                    drafts.add(&numbered(path, number, pages.len()), &file)?;
                }
                continue;
            }
            let is_half = !args.files.float && is_in_range(baked, values, path, session);
            for (number, page) in pages.iter().enumerate() {
                let [width, height] = page.size;
                let image = Image::opaque(width, height, values(page).clone());
                let mut file = Vec::new();
                let write = if is_half { exr::write_half } else { exr::write };
                write(&image, &mut file).map_err(Failure::failed)?;
                drafts.add(&numbered(path, number, pages.len()), &file)?;
            }
        }
        match &self.main {
            Some((output, OutputKind::Page)) => {
                let mut file = Vec::new();
                write_page(args, source, baked, &mut file).map_err(Failure::failed)?;
                drafts.add_to(output, &file)?;
            }
            Some((output, kind)) => {
                let pictures =
                    pictures::pictures(args, source, baked, places.padding, session, report)?;
                let patched = patched((output, *kind), args, source, baked, &pictures, &places)?;
                patched.notes.iter().for_each(|note| session.note(note));
                if patched.leaves_dark {
                    session.note(
                        "the lamps of the file are dark now, and some things have no lightmap in their place: \
                         --baked-lights keep leaves lamps as they are, as does --light indirect",
                    );
                }
                // A file in another folder takes along the files that it names, which it would not reach from there.
                for (name, file) in copied(output.path(), source, &patched)? {
                    drafts.add(&output.path().with_file_name(name), &file)?;
                }
                for (name, file) in &patched.files {
                    drafts.add(&output.path().with_file_name(name), file)?;
                }
                drafts.add_to(output, &patched.bytes)?;
            }
            None => {}
        }
        let written = drafts.commit(session)?;
        let names = written.join(", ");
        report.fact("output", written, "wrote", names);
        Ok(())
    }
}

/// A file of irradiance, or of its standard error, with the coefficients of the radiance above the texels as layers,
/// in the axes of glTF.
fn layered(
    page: &LightmapPage,
    harmonics: [&LightmapPage; DIRECTIONAL],
    values: fn(&LightmapPage) -> &Vec<[f32; 3]>,
    up: Up,
) -> Result<Vec<u8>, Failure> {
    let channel = |layer: &str, texels: &[[f32; 3]], sign: f32| {
        [0, 1, 2].map(|k| NamedChannel {
            name: format!("{layer}{}", ["R", "G", "B"][k]),
            values: ChannelValues::Float(texels.iter().map(|texel| sign * texel[k]).collect()),
        })
    };
    let mut channels = Vec::from(channel("", values(page), 1.0));
    let [l00, l1m, l10, l11] = harmonics.map(|page| &values(page)[..]);
    // Standard errors have no sign.
    let is_error = std::ptr::eq(values(page), &page.standard_error);
    let (l1m, l10, down) = match up {
        Up::Y => (l1m, l10, 1.0),
        Up::Z if is_error => (l10, l1m, 1.0),
        Up::Z => (l10, l1m, -1.0),
    };
    for (layer, texels, sign) in [
        ("L00.", l00, 1.0),
        ("L1-1.", l1m, 1.0),
        ("L10.", l10, down),
        ("L11.", l11, 1.0),
    ] {
        channels.extend(channel(layer, texels, sign));
    }
    let [width, height] = page.size;
    let mut file = Vec::new();
    let written = exr::write_channels((width, height), channels, LAYERS, &[], &mut file);
    written.map_err(Failure::failed)?;
    Ok(file)
}

/// What a file with directions says of its layers.
const LAYERS: &str = "R, G, B: irradiance, or its standard error. L00, L1-1, L10, L11: coefficients of real spherical \
    harmonics of the radiance above each texel (bands 0 and 1: the constant, y, z, x), in the axes of glTF, y up.";

/// Writes the page that shows the lightmap.
fn write_page(
    args: &BakeArgs,
    source: &BakeSource,
    baked: &Baked,
    out: &mut dyn Write,
) -> io::Result<()> {
    let title = args.input.scenes.first().and_then(|path| path.file_stem());
    let model = PageModel {
        title: title.unwrap_or_default().to_string_lossy().into_owned(),
        note: format!(
            "Irradiance is known to {} of its mean (one standard error).",
            percent(baked.lightmap.relative_error())
        ),
        ..page::of_baked(&source.scene, baked)?
    };
    web_page::write(&model, out)
}

/// Files that a file in another folder than the one it was read from names: it would not find them.
fn copied(
    path: &Path,
    source: &BakeSource,
    patched: &PatchedFile,
) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        std::fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()
    };
    let is_same = folder(Path::new(&source.file.name)) == folder(path);
    if !source.is_given || is_same || path == Path::new("-") {
        return Ok(Vec::new());
    }
    let names = patch::named_files(&patched.bytes, &source.file.name).map_err(Failure::failed)?;
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for name in names {
        let is_inside = Path::new(&name)
            .components()
            .all(|part| matches!(part, Component::Normal(_)));
        let is_known = patched.files.iter().chain(&files).any(|f| f.0 == name);
        // What cannot be read is missing as it was before.
        if let (true, false, Ok(bytes)) = (is_inside, is_known, source.file.files.read(&name)) {
            files.push((name, bytes));
        }
    }
    Ok(files)
}

/// The file with its lightmap.
fn patched(
    (output, kind): (&Output, OutputKind),
    args: &BakeArgs,
    source: &BakeSource,
    baked: &Baked,
    pictures: &Pictures,
    places: &WrittenPlaces,
) -> Result<PatchedFile, Failure> {
    let stem = output.path().file_stem().unwrap_or_default();
    let picture = |receiver: usize, t: usize| pictures.of_triangles[receiver][t];
    let edit = LightmapEdit {
        objects: &source.layouts_in(baked, picture),
        pages: &pictures.pages,
        uvs: places.uvs,
        instances: args.files.instances.written(),
        convention: args.convention().written(),
        lights: lights(args),
        mipmaps: args.texels.mips > 0,
        content: Some(&places.content),
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

/// Part of the mean irradiance down to which floats of 16 bits must have all of theirs.
const DARK: f64 = 1e-3;

/// Whether floats of 16 bits can hold what a file gets, and what is said if not.
fn is_in_range(
    baked: &Baked,
    values: fn(&LightmapPage) -> &Vec<[f32; 3]>,
    path: &Path,
    session: &mut Session,
) -> bool {
    let texels = baked.lightmap.pages.iter().flat_map(values);
    let most = texels.flatten().copied().fold(0.0, f32::max);
    let mean = baked.lightmap.mean().mean();
    let fault = if most > exr::MOST_HALF {
        "values above 65504"
    } else if mean > 0.0 && DARK * mean < f64::from(exr::LEAST_HALF) {
        "values so small"
    } else {
        return true;
    };
    session.note(&format!(
        "{}: floats of 32 bits, since those of 16 have no {fault}",
        path.display()
    ));
    false
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
