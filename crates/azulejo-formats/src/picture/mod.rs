//! Pictures: PNG, JPEG, Radiance HDR, OpenEXR, BMP, TGA, GIF, SGI, TIFF, WebP, DDS and KTX2, and what
//! their readers share.

mod blocks;
pub mod bmp;
mod budget;
pub mod cryptomatte;
pub mod dds;
pub(crate) mod error;
pub mod exr;
pub mod gif;
pub mod hdr;
pub mod jpeg;
pub mod ktx2;
mod ktx2_writer;
pub mod png;
mod samples;
pub mod sgi;
pub(crate) mod srgb;
pub mod tga;
pub mod tiff;
pub mod webp;

pub(crate) use budget::PixelBudget;
pub use error::PictureError;

use azulejo_scene::Image;
use error::malformed;

/// A format that models may have their pictures in, with its reader and that of its size.
struct PictureFormat {
    name: &'static str,
    /// Whether bytes are in this format, from their first ones.
    fits: fn(&[u8]) -> bool,
    read: fn(&[u8]) -> Result<Image, PictureError>,
    size: fn(&[u8]) -> Result<[u64; 2], PictureError>,
}

/// A row of [`FORMATS`]: the name, whether bytes fit, and the module of the reader.
macro_rules! picture_format {
    ($name:literal, $fits:expr, $module:ident) => {
        PictureFormat {
            name: $name,
            fits: $fits,
            read: $module::read,
            size: $module::size,
        }
    };
}

/// All formats, TGA last, which has no magic number.
const FORMATS: [PictureFormat; 12] = [
    picture_format!("JPEG", |b| b.starts_with(b"\xff\xd8"), jpeg),
    picture_format!("Radiance HDR", |b| b.starts_with(b"#?"), hdr),
    picture_format!("PNG", |b| b.starts_with(b"\x89PNG"), png),
    picture_format!("OpenEXR", |b| b.starts_with(b"v/1\x01"), exr),
    picture_format!("GIF", |b| b.starts_with(b"GIF8"), gif),
    picture_format!(
        "WebP",
        |b| b.starts_with(b"RIFF") && b.get(8..12) == Some(b"WEBP"),
        webp
    ),
    picture_format!(
        "TIFF",
        |b| b.starts_with(b"II*\0") || b.starts_with(b"MM\0*"),
        tiff
    ),
    picture_format!("DDS", |b| b.starts_with(b"DDS "), dds),
    picture_format!("KTX2", |b| b.starts_with(ktx2::START), ktx2),
    picture_format!("SGI", |b| b.starts_with(b"\x01\xda"), sgi),
    picture_format!(
        "BMP",
        |b| b.starts_with(b"BM") && b.get(15..18) == Some(&[0; 3]),
        bmp
    ),
    picture_format!("TGA", tga::is_tga, tga),
];

fn format_of(bytes: &[u8]) -> Result<&'static PictureFormat, PictureError> {
    let format = FORMATS.iter().find(|format| (format.fits)(bytes));
    format.ok_or_else(|| {
        let names = FORMATS.each_ref().map(|format| format.name);
        malformed(format!(
            "a picture of no known format ({})",
            names.join(", ")
        ))
    })
}

/// Reads a picture as linear light, in the format that its content shows.
///
/// # Errors
/// [`PictureError`]: another format, damaged, or larger than its bytes justify.
pub fn decode(bytes: &[u8]) -> Result<Image, PictureError> {
    (format_of(bytes)?.read)(bytes)
}

/// The size of a picture that [`decode`] reads, from its header alone.
fn size(bytes: &[u8]) -> Result<[u64; 2], PictureError> {
    (format_of(bytes)?.size)(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tests_of_formats as files;

    /// A small file of every format.
    mod tests_of_formats {
        use super::super::{bmp, dds, exr, gif, hdr, jpeg, ktx2, png, sgi, tga, tiff, webp};
        use azulejo_scene::Image;

        pub fn all() -> Vec<(&'static str, Vec<u8>)> {
            let (mut png, mut hdr, mut exr) = (Vec::new(), Vec::new(), Vec::new());
            png::write(2, 1, &[0; 6], &mut png).unwrap();
            hdr::write(&Image::new(2, 1), &mut hdr).unwrap();
            exr::write(&Image::new(2, 1), &mut exr).unwrap();
            vec![
                ("JPEG", jpeg::tests::grey()),
                ("Radiance HDR", hdr),
                ("PNG", png),
                ("OpenEXR", exr),
                ("GIF", gif::tests::SMALL.to_vec()),
                (
                    "WebP",
                    webp::tests::file(image_webp::ColorType::Rgb8, &[0; 6]),
                ),
                (
                    "TIFF",
                    tiff::tests::file::<::tiff::encoder::colortype::Gray8>(&[0; 2]),
                ),
                ("DDS", dds::tests::file(b"DXT1", 0, &[0; 8])),
                ("KTX2", ktx2::tests::file(43, 0, &[0; 8])),
                ("SGI", sgi::tests::file(0, 1, 1, &[0; 2])),
                ("BMP", bmp::tests::file([2, 1], 24, 0, &[], &[0; 8])),
                ("TGA", tga::tests::file(2, 1, 24, 0, &[], &[0; 6])),
            ]
        }
    }

    #[test]
    fn formats_are_known_by_their_content() {
        for (name, bytes) in files::all() {
            assert_eq!(format_of(&bytes).ok().map(|f| f.name), Some(name));
            let image = decode(&bytes).unwrap();
            let shown = [image.width, image.height].map(u64::from);
            assert_eq!(size(&bytes), Ok(shown), "{name}");
        }
        let error = decode(b"v 0 0 0\n").unwrap_err().to_string();
        assert!(error.contains("of no known format (JPEG,"), "{error}");
    }

    /// A header that claims a large picture reserves nothing, whatever the format.
    #[test]
    fn claims_are_not_believed() {
        for (name, bytes) in files::all() {
            for at in 0..bytes.len().min(200).saturating_sub(8) {
                let mut claimed = bytes.clone();
                claimed[at..at + 8]
                    .copy_from_slice(&[0xff, 0xff, 0xff, 0x3f, 0xff, 0xff, 0xff, 0x3f]);
                if let Ok(image) = decode(&claimed) {
                    assert!(image.pixels.len() < 1 << 24, "{name} at {at}");
                }
            }
        }
    }
}
