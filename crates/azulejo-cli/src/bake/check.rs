//! `bake --check`: what is wrong with the lightmap of a glTF file, or with coordinates for one.

use super::args::BakeArgs;
use super::source::read_file;
use super::verdict::{Grade, TestRow, atlas_rows, table};
use crate::failure::Failure;
use crate::report::{Report, count, percent};
use crate::session::Session;
use azulejo::bake::check::{CheckOptions, check};
use azulejo::bake::{
    Atlas, Coverage, Layout, Lightmap, LightmapPage, Receiver, ReceiverLayout, kept_layout,
    seam_errors,
};
use azulejo::models::read_bytes;
use azulejo_formats::gltf;
use azulejo_formats::gltf::patch::{self, FoundLightmap};
use azulejo_formats::picture::{self, exr};
use azulejo_scene::{Image, Scene};
use azulejo_trace::{Progress, Tracer};
use std::path::Path;

/// Size of pages where neither a picture nor an option says it.
const SIZE: u32 = 1024;

/// Difference along seams above which it is reported, as a share of the mean.
const SEAM_LIMIT: f64 = 0.01;

/// Difference above which a texel is counted, as a share of its value.
const OFF: f64 = 0.01;

/// Error of the picture in the file above which it is reported, as a share of the mean.
const PICTURE_LIMIT: f64 = 0.02;

/// A file with what was found of its lightmap.
struct CheckedFile {
    receivers: Vec<Receiver>,
    layout: Layout,
    lightmap: FoundLightmap,
    /// Decoded pictures, if there are any.
    pictures: Option<Vec<Image>>,
}

/// Runs `bake --check`. The answer may be no: then the second result is a failure.
pub fn run(
    args: &BakeArgs,
    session: &mut Session,
) -> Result<(Report, Result<(), Failure>), Failure> {
    let [path] = &args.input.scenes[..] else {
        return Err(Failure::misuse("--check takes one glTF file"));
    };
    let file = read(args, path, session)?;
    let options = CheckOptions {
        gap: 2.0,
        crease: args.texels.crease,
    };
    let atlas = session.with_progress(|_| check(&file.receivers, &file.layout, &options));
    let mut report = Report::default();
    describe(&file, &mut report);
    let mut rows = atlas_rows(&atlas, &options);
    if !atlas.is_complete {
        session.note("too many triangles overlap to compare all pairs");
        report.value("complete", false);
    }
    rows.extend(picture_rows(args, &file)?);
    let is_good = rows.iter().all(|row| row.grade != Grade::Defect);
    table(&rows, &file.receivers, &mut report);
    report.value("ok", is_good);
    let end = if is_good { Ok(()) } else { Err(Failure::Found) };
    Ok((report, end))
}

/// The objects of a file that have coordinates, and its pictures.
fn read(args: &BakeArgs, path: &Path, session: &mut Session) -> Result<CheckedFile, Failure> {
    let file = read_file(&args.input.reading, path)?;
    if let Some(lost) = patch::lost(&file.bytes, &file.name).map_err(Failure::failed)? {
        return Err(Failure::failed(lost));
    }
    let read = gltf::read_with_origins(&file.bytes, &file.name, &file.files, &file.options);
    let (loaded, origins) = read.map_err(Failure::failed)?;
    let lightmap = patch::found_lightmap(&file.patched(), &origins, args.files.uv_set);
    let lightmap = lightmap.map_err(Failure::failed)?;
    let instances = origins.iter().filter(|o| o.instance.is_some()).count();
    if instances > 0 {
        session.note("instances by EXT_mesh_gpu_instancing share one mesh: not checked");
    }
    let is_checked = |number: usize| origins[number].instance.is_none();
    let (receivers, coordinates) = receivers(&loaded.scene, &lightmap, is_checked);
    if receivers.is_empty() {
        let set = args.files.uv_set.unwrap_or(1);
        return Err(Failure::failed(format_args!(
            "{}: no object has texture coordinates for a lightmap (TEXCOORD_{set})",
            path.display()
        )));
    }
    let pictures = pictures(&lightmap, session)?;
    let size = |number: usize| match pictures.as_ref().map(|list: &Vec<Image>| &list[number]) {
        Some(image) if args.texels.size.is_none() => [image.width, image.height],
        _ => [args.texels.size.unwrap_or(SIZE); 2],
    };
    let sizes = (0..lightmap.pages.len()).map(size).collect();
    // Light changes where something stands on a surface: charts that end there have no seam.
    let tracer = Tracer::new(&loaded.scene);
    let crease = args.texels.crease;
    let layout = kept_layout(&receivers, coordinates, sizes, crease, Some(&tracer));
    Ok(CheckedFile {
        receivers,
        layout,
        lightmap,
        pictures,
    })
}

/// Receivers with the coordinates that the file has for them.
pub fn receivers(
    scene: &Scene,
    lightmap: &FoundLightmap,
    is_wanted: impl Fn(usize) -> bool,
) -> (Vec<Receiver>, Vec<ReceiverLayout>) {
    let objects = scene.objects.iter().zip(&lightmap.objects).enumerate();
    let receiver = |(number, (object, layout)): (usize, (_, &Option<patch::ObjectLayout>))| {
        let layout = layout.as_ref().filter(|_| is_wanted(number))?;
        let receiver = Receiver::of_object(object)?;
        (receiver.triangles.len() == layout.uvs.len()).then(|| {
            let coordinates = ReceiverLayout {
                uvs: layout.uvs.clone(),
                pages: layout.pages.clone(),
                ..ReceiverLayout::default()
            };
            (receiver, coordinates)
        })
    };
    objects.filter_map(receiver).unzip()
}

/// The pictures of all pages; none if the file names none, or one cannot be read.
fn pictures(
    lightmap: &FoundLightmap,
    session: &mut Session,
) -> Result<Option<Vec<Image>>, Failure> {
    let mut list = Vec::new();
    for page in &lightmap.pages {
        let image = match &page.picture {
            Ok(None) => return Ok(None),
            Ok(Some(bytes)) => picture::decode(bytes).map_err(|e| e.to_string()),
            Err(fault) => Err(fault.clone()),
        };
        match image {
            Ok(image) => list.push(image),
            Err(fault) => {
                session.note(&format!(
                    "a picture of the lightmap cannot be read: {fault}"
                ));
                return Ok(None);
            }
        }
    }
    Ok(Some(list))
}

fn describe(file: &CheckedFile, report: &mut Report) {
    let triangles: usize = file.receivers.iter().map(|r| r.triangles.len()).sum();
    let words = format!(
        "{} triangles of {} objects, TEXCOORD_{}",
        count(triangles),
        count(file.receivers.len()),
        file.lightmap.set
    );
    report.fact("uv_set", file.lightmap.set, "coordinates", words);
    report.value("triangles", triangles);
    let sizes: Vec<String> = file
        .layout
        .pages
        .iter()
        .map(|[width, height]| format!("{width} × {height}"))
        .collect();
    let kind = match (&file.pictures, file.lightmap.is_named) {
        (Some(_), _) => "",
        (None, true) => ", pictures not read",
        (None, false) => ", no lightmap",
    };
    let words = format!("{}{kind}", sizes.join(", "));
    report.fact("pages", file.layout.pages.len(), "pages", words);
    report.fact(
        "charts",
        file.layout.charts,
        "charts",
        count(file.layout.charts),
    );
}

/// Tests of the pictures.
fn picture_rows(args: &BakeArgs, file: &CheckedFile) -> Result<Vec<TestRow>, Failure> {
    let has_size = |(image, size): (&Image, &[u32; 2])| [image.width, image.height] == *size;
    let pictures = file
        .pictures
        .as_ref()
        .filter(|list| list.iter().zip(&file.layout.pages).all(has_size));
    let Some(pictures) = pictures else {
        return match &args.files.lightmap {
            None => Ok(Vec::new()),
            Some(_) => Err(Failure::failed(
                "--lightmap: the file has no picture of this size to compare with",
            )),
        };
    };
    let mut rows = Vec::new();
    let intensities = file.lightmap.pages.iter().map(|p| p.intensity as f32);
    let pages: Vec<LightmapPage> = pictures
        .iter()
        .zip(intensities)
        .map(|(image, intensity)| LightmapPage {
            irradiance: scaled(image, intensity),
            charts: vec![0; image.pixels.len()],
            ..LightmapPage::dark([image.width, image.height])
        })
        .collect();
    let weights = weights(file)?;
    rows.extend(seam_row(file, &pages, &weights));
    if let Some(path) = &args.files.lightmap {
        rows.extend(compared(path, &pages, &weights)?);
    }
    Ok(rows)
}

fn scaled(image: &Image, intensity: f32) -> Vec<[f32; 3]> {
    let texels = image.pixels.iter();
    texels.map(|t| t.map(|v| intensity * v)).collect()
}

/// Texels that cover surfaces, by page, with the area that they cover.
fn weights(file: &CheckedFile) -> Result<Vec<Vec<(usize, f64)>>, Failure> {
    let page_weights = |page: u32| {
        let coverage = Coverage::new(&file.receivers, &file.layout, page, &Progress::new())?;
        let texels = coverage.texels.iter();
        Ok(texels
            .map(|t| (t.index as usize, f64::from(t.area)))
            .collect())
    };
    (0..file.layout.pages.len() as u32)
        .map(page_weights)
        .collect()
}

/// Differences on both sides of seams; `None` if there are no seams.
fn seam_row(
    file: &CheckedFile,
    pages: &[LightmapPage],
    weights: &[Vec<(usize, f64)>],
) -> Option<TestRow> {
    let (mut sum, mut whole) = (0.0, 0.0);
    for (page, of_page) in pages.iter().zip(weights) {
        for &(texel, area) in of_page {
            sum += area * mean(page.irradiance[texel]);
            whole += area;
        }
    }
    let atlas = Atlas {
        receivers: file.receivers.clone(),
        layout: file.layout.clone(),
        turned: Vec::new(),
    };
    let lightmap = Lightmap {
        pages: pages.to_vec(),
        buried: 0,
    };
    let errors = seam_errors(&lightmap, &atlas);
    let share = errors.before / f64::max(sum / whole, f64::MIN_POSITIVE);
    (errors.points > 0).then(|| TestRow {
        count: errors.points,
        ..TestRow::new(
            "seams",
            "light across seams",
            format!("{} of the mean apart", percent(share)),
            share,
            percent(SEAM_LIMIT),
            Grade::poor_if(share > SEAM_LIMIT),
        )
    })
}

fn mean(texel: [f32; 3]) -> f64 {
    texel.iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0
}

/// The picture in the file beside the irradiance in a file of its own.
fn compared(
    path: &Path,
    pages: &[LightmapPage],
    weights: &[Vec<(usize, f64)>],
) -> Result<Vec<TestRow>, Failure> {
    let (mut squares, mut sum, mut off, mut whole) = (0.0, 0.0, 0.0, 0.0);
    for (place, (page, page_weights)) in pages.iter().zip(weights).enumerate() {
        let file = page_of_irradiance(path, place, pages)?;
        for &(texel, area) in page_weights {
            let (own, truth) = (page.irradiance[texel], file.pixels[texel]);
            let square = |k: usize| f64::from(own[k] - truth[k]).powi(2);
            squares += area * (square(0) + square(1) + square(2)) / 3.0;
            sum += area * mean(truth);
            let is_off = (mean(own) - mean(truth)).abs() > OFF * mean(truth);
            off += if is_off { area } else { 0.0 };
            whole += area;
        }
    }
    let whole = f64::max(whole, f64::MIN_POSITIVE);
    let error = (squares / whole).sqrt() / f64::max(sum / whole, f64::MIN_POSITIVE);
    Ok(vec![
        TestRow::new(
            "picture_error",
            "picture beside EXR",
            format!("{} of the mean (root mean square)", percent(error)),
            error,
            percent(PICTURE_LIMIT),
            Grade::poor_if(error.is_nan() || error > PICTURE_LIMIT),
        ),
        TestRow::new(
            "picture_off",
            "off by more than 1%",
            format!("{} of the area", percent(off / whole)),
            off / whole,
            "",
            Grade::Good,
        ),
    ])
}

/// The irradiance of one of the pages, in a file of its own.
fn page_of_irradiance(path: &Path, place: usize, pages: &[LightmapPage]) -> Result<Image, Failure> {
    let numbered = super::written::numbered(path, place, pages.len());
    // Bright surfaces with pictures of their own lie on the page of the others.
    let path = if numbered.exists() { &numbered } else { path };
    let file = exr::read(&read_bytes(path)?);
    let file = file.map_err(|e| Failure::failed(format_args!("{}: {e}", path.display())))?;
    let [width, height] = pages[place].size;
    if [file.width, file.height] != [width, height] {
        return Err(Failure::failed(format_args!(
            "{}: {} × {} texels: expected {width} × {height}, as the picture in the file has",
            path.display(),
            file.width,
            file.height,
        )));
    }
    Ok(file)
}
