//! The pictures of a lightmap: irradiance, or the radiance that surfaces show.

use super::args::{BakeArgs, ConventionArg, DirectionalArg, ExposureArg, ImageArg};
use super::source::BakeSource;
use crate::failure::Failure;
use crate::report::{Report, number, percent, short};
use crate::session::Session;
use azulejo::bake::{linear_bytes, srgb_bytes, srgb_bytes_up_to};
use azulejo::lightmap::{
    Baked, BytePicture, BytePictures, TexelRadiance, direction_bytes, png_page,
};
use azulejo_formats::gltf::patch::{LightmapPage, MediaType};
use azulejo_formats::picture::ktx2::{self, Ktx2Texels};
use azulejo_formats::picture::{hdr, png};
use azulejo_scene::Image;

/// Part of the largest irradiance below which 8 bits are coarser than a hundredth.
const DIM: f64 = 0.1;

/// Largest share of the area below it that is not reported.
const MUCH_DIM: f64 = 0.2;

/// The pictures of a lightmap in a file.
pub struct Pictures {
    /// All of them.
    pub pages: Vec<LightmapPage>,
    /// Which of them each triangle of each receiver has.
    pub of_triangles: Vec<Vec<u32>>,
}

impl Pictures {
    /// One for each page.
    fn by_pages(baked: &Baked, pages: Vec<LightmapPage>) -> Pictures {
        let receivers = baked.atlas.layout.receivers.iter();
        Pictures {
            pages,
            of_triangles: receivers.map(|r| r.pages.clone()).collect(),
        }
    }
}

/// The pictures of all pages, as the convention wants them.
pub fn pictures(
    args: &BakeArgs,
    source: &BakeSource,
    baked: &Baked,
    padding: u32,
    session: &mut Session,
    report: &mut Report,
) -> Result<Pictures, Failure> {
    // Pictures of irradiance and of occlusion do not depend on the colours of surfaces.
    match args.convention() {
        ConventionArg::Plain => return Ok(Pictures::by_pages(baked, Vec::new())),
        ConventionArg::Moz | ConventionArg::Mx => {
            // 8 bits cover a small range of light, so much brighter surfaces may have a picture of their own.
            let bytes = BytePictures::new(baked, args.separates_bright());
            if bytes.bright_share > 0.0 {
                session.note(&format!(
                    "{} of the area is so much brighter than the rest that it has a picture of its own",
                    percent(bytes.bright_share)
                ));
            }
            say_dim(args, baked, &bytes, session, report);
            if matches!(args.files.image, ImageArg::Ktx2 | ImageArg::Ktx2Half) {
                session.note(
                    "KHR_texture_basisu names a KTX2 with bright texels, which three.js shows, but which its \
                     specification does not have: validators will say so",
                );
            }
            return Ok(Pictures {
                pages: irradiance(args, source, baked, &bytes)?,
                of_triangles: bytes.of_triangles,
            });
        }
        ConventionArg::Occlusion => {
            let pages = baked.lightmap.pages.iter().enumerate();
            let picture = |(place, page): (usize, &azulejo::bake::LightmapPage)| {
                let bytes = linear_bytes(&page.irradiance);
                let name = name("occlusion", baked, place);
                png_page(name, page.size, &bytes, 1.0).map_err(Failure::failed)
            };
            let pages: Result<Vec<LightmapPage>, Failure> = pages.map(picture).collect();
            return Ok(Pictures::by_pages(baked, pages?));
        }
        ConventionArg::Emissive | ConventionArg::Unlit => {}
    }
    // The other conventions show radiance: irradiance times the colour of the surface at each texel.
    let radiance = session
        .with_progress(|progress| TexelRadiance::new(baked, &source.scene, padding, progress))?;
    let unit = if source.scene.units.photometric {
        "cd/m²"
    } else {
        "W/(sr·m²)"
    };
    let pages = shown(args, baked, (radiance, unit), session, report)?;
    Ok(Pictures::by_pages(baked, pages))
}

/// Pictures of irradiance, all with a PNG.
fn irradiance(
    args: &BakeArgs,
    source: &BakeSource,
    baked: &Baked,
    bytes: &BytePictures,
) -> Result<Vec<LightmapPage>, Failure> {
    let picture = |picture: &BytePicture| {
        let page = &baked.lightmap.pages[picture.page];
        let intensity = picture.intensity;
        let mut png = picture.png(baked).map_err(Failure::failed)?;
        if let Some(form) = args.files.directional.map(DirectionalArg::form) {
            let up = source.scene.units.up;
            for bytes in direction_bytes(baked, picture.page, form, up) {
                let mut file = Vec::new();
                let [width, height] = page.size;
                png::write_data(width, height, &bytes, &mut file).map_err(Failure::failed)?;
                png.directions.push(file);
            }
        }
        let bright = |media_type, picture| LightmapPage {
            picture,
            media_type,
            fallback: Some(png.picture.clone()),
            ..png.clone()
        };
        let levels = args.texels.mips + 1;
        let ktx2 = |texels| {
            let mut file = Vec::new();
            let written = ktx2::write(&scaled(page, intensity), texels, levels, &mut file);
            written.map_err(Failure::failed)?;
            Ok(bright(MediaType::Ktx2, file))
        };
        match args.files.image {
            ImageArg::Png => Ok(png),
            ImageArg::Hdr => {
                let mut file = Vec::new();
                let written = hdr::write(&scaled(page, intensity), &mut file);
                written.map_err(Failure::failed)?;
                Ok(bright(MediaType::Hdr, file))
            }
            ImageArg::Ktx2 => ktx2(Ktx2Texels::SharedExponent),
            ImageArg::Ktx2Half => ktx2(Ktx2Texels::Half),
        }
    };
    bytes.pictures.iter().map(picture).collect()
}

/// Irradiance over that of a texel of 1: the PNG for others has the same scale.
fn scaled(page: &azulejo::bake::LightmapPage, intensity: f64) -> Image {
    let [width, height] = page.size;
    let share = if intensity > 0.0 {
        1.0 / intensity
    } else {
        1.0
    };
    let texels = page.irradiance.iter();
    let texels = texels.map(|texel| texel.map(|v| (share * f64::from(v)) as f32));
    Image::opaque(width, height, texels.collect())
}

/// Pictures of radiance; where the target ends at 1, darkened or brightened and cut there.
fn shown(
    args: &BakeArgs,
    baked: &Baked,
    (mut radiance, unit): (TexelRadiance, &str),
    session: &mut Session,
    report: &mut Report,
) -> Result<Vec<LightmapPage>, Failure> {
    let exposure = match (args.files.exposure, args.convention()) {
        (Some(ExposureArg::Factor(factor)), _) => Some(factor),
        (Some(ExposureArg::Auto), _) | (None, ConventionArg::Unlit) => Some(radiance.exposure()),
        (None, _) => None,
    };
    if let Some(exposure) = exposure {
        let cut = radiance.expose(exposure);
        let words = format!(
            "{}: white is {} {unit}",
            short(exposure),
            short(1.0 / exposure)
        );
        report.fact("exposure", number(exposure), "exposure", words);
        report.value("cut_share", number(cut));
        if cut > 0.0 {
            session.note(&format!(
                "{} of the area is brighter than white, and cut there: --exposure sets what white is",
                percent(cut)
            ));
        }
    }
    let texels = radiance.pages.iter().enumerate();
    let picture = |(place, texels): (usize, &Vec<[f32; 3]>)| {
        let (rgb, intensity) = match exposure {
            Some(_) => (srgb_bytes_up_to(texels, 1.0), 1.0),
            None => srgb_bytes(texels),
        };
        let size = baked.lightmap.pages[place].size;
        let name = name("lightmap", baked, place);
        png_page(name, size, &rgb, intensity).map_err(Failure::failed)
    };
    texels.map(picture).collect()
}

/// The name of a page's picture.
fn name(what: &str, baked: &Baked, place: usize) -> String {
    match baked.lightmap.pages.len() {
        1 => what.to_owned(),
        _ => format!("{what} {}", place + 1),
    }
}

/// Says how much of a lightmap is so dark that 8 bits show it worse than was asked for.
fn say_dim(
    args: &BakeArgs,
    baked: &Baked,
    bytes: &BytePictures,
    session: &mut Session,
    report: &mut Report,
) {
    if args.files.image != ImageArg::Png {
        return;
    }
    let dim = bytes.share_below(baked, DIM);
    report.value("dim_share", dim);
    if dim > MUCH_DIM {
        session.note(&format!(
            "{} of the area is below a tenth of the brightest texel, where the steps of an 8-bit PNG \
             are more than 1%: --lightmap E.exr, --image ktx2 and --image hdr keep it",
            percent(dim)
        ));
    }
}
