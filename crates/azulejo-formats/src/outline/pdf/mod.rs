//! PDF drawings: the filled and stroked shapes of a page, and its letters.
//!
//! hayro reads the file and interprets what its pages draw; here its paths become
//! [`Figure`](azulejo_scene::Figure)s, clipped, y up. `docs/formats/svg.md` documents how everything is interpreted.

mod device;
#[cfg(test)]
mod tests;
mod unpacked;

use crate::outline::drawing::Drawing;
use crate::{ReadError, ReadOptions};
use device::{PdfDevice, Stopped};
use hayro_interpret::font::FontQuery;
use hayro_interpret::hayro_syntax::content::TypedIter;
use hayro_interpret::hayro_syntax::object::{Array, Number, Rect, Stream};
use hayro_interpret::hayro_syntax::page::{Page, Rotation};
use hayro_interpret::hayro_syntax::{DecryptionError, LoadPdfError, Pdf};
use hayro_interpret::{
    Context, InterpreterCache, InterpreterSettings, InterpreterWarning, RenderContent,
};
use kurbo::{Affine, Shape};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Longest interpretation of a page: a small file can ask for unlimited work, such as a long form that it draws again and
/// again.
const LONGEST: Duration = Duration::from_secs(120);

/// Device pixels per unit of the page: so many that hayro takes no shape for one without an area, which it replaces by a
/// line of a pixel, and no clip path for one that covers the page.
const PIXELS: f64 = (1_u64 << 30) as f64;

/// Metres per unit of a page without a `UserUnit`: ISO 32000-2, 8.3.2.3.
const POINT: f64 = 0.0254 / 72.0;

/// What is expected of a file.
const EXPECTED: &str = "a PDF without damage and password";

/// Whether bytes are a PDF: its header may come after up to a kilobyte of something else.
pub(crate) fn is_pdf(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1024)];
    head.windows(5).any(|w| w == b"%PDF-")
}

/// Reads the page that `options` name. `name` is used in messages.
///
/// # Errors
/// A file that is damaged or needs a password, a page that it does not have or that consists of pictures, and a page that
/// takes too long or expands to more than `options` allow. Anything less is left out with a warning.
pub fn read(bytes: &[u8], name: &str, options: &ReadOptions) -> Result<Drawing, ReadError> {
    unpacked::check(bytes, name, options)?;
    // Only a panic ends hayro's work; the device starts one when a limit is reached, which prints nothing.
    let stopped = Cell::new(None);
    let read = catch_unwind(AssertUnwindSafe(|| {
        interpreted(bytes, name, options, LONGEST, &stopped)
    }));
    read.unwrap_or_else(|payload| {
        let known = stopped.take().filter(|_| payload.is::<Stopped>());
        let found = "a PDF with damage that its reader does not survive";
        Err(known.unwrap_or_else(|| ReadError::whole(name, found, EXPECTED)))
    })
}

/// Reads a page, or leaves what is wrong in `stopped` and unwinds.
fn interpreted(
    bytes: &[u8],
    name: &str,
    options: &ReadOptions,
    longest: Duration,
    stopped: &Cell<Option<ReadError>>,
) -> Result<Drawing, ReadError> {
    let pdf = Pdf::new(bytes.to_vec()).map_err(|e| unreadable(name, e))?;
    let pages = pdf.pages();
    let number = options.page.unwrap_or(1);
    let Some(page) = number.checked_sub(1).and_then(|index| pages.get(index)) else {
        let expected = match pages.len() {
            0 => "a PDF with pages".to_owned(),
            count => format!("a page from 1 to {count}"),
        };
        return Err(ReadError::whole(
            name,
            format!("no page {number}"),
            expected,
        ));
    };
    let content = content(page, name, options)?;
    let sheet = Sheet::new(page);
    let device_from_page = Affine::scale(PIXELS) * sheet.map;
    let mut device = PdfDevice::new(name, options, longest, sheet.size, PIXELS, stopped);
    if pages.len() > 1 && options.page.is_none() {
        let count = pages.len();
        device.warn(format!(
            "one of {count} pages is taken, the first (#2 behind the name takes the second)"
        ));
    }
    let notes = Arc::new(Mutex::new(Vec::new()));
    let settings = InterpreterSettings {
        render_content: RenderContent::ANNOTATIONS,
        ..settings(&notes)
    };
    let cache = InterpreterCache::new();
    let seen = device_from_page.transform_rect_bbox(page_rect(page));
    let mut context = Context::new(device_from_page, seen, &cache, page.xref(), settings);
    let operations = TypedIter::new(&content);
    hayro_interpret::interpret(operations, page.resources(), &mut context, &mut device);
    hayro_interpret::interpret_page(page, &mut context, &mut device);
    let notes = std::mem::take(&mut *notes.lock().unwrap_or_else(PoisonError::into_inner));
    for note in notes {
        device.warn(note);
    }
    let (shapes, images, warnings) = device.finish();
    if shapes.is_empty() && images > 0 && options.keeps {
        let found = format!("page {number} with {images} pictures and no outlines");
        let expected = "filled or stroked shapes or letters: trace the picture first, as Inkscape and potrace do";
        return Err(ReadError::whole(name, found, expected));
    }
    let user_unit = page.raw().get::<Number>(b"UserUnit");
    let user_unit = user_unit.map_or(1.0, |unit| unit.as_f64());
    Ok(Drawing {
        shapes,
        metres_per_unit: Some(POINT * user_unit).filter(|m| *m > 0.0 && m.is_normal()),
        warnings,
    })
}

/// Fonts and encodings of hayro, and what of them is to be said.
fn settings(notes: &Arc<Mutex<Vec<String>>>) -> InterpreterSettings {
    let plain = InterpreterSettings::default();
    let note = |notes: &Mutex<Vec<String>>, note: String| {
        let mut notes = notes.lock().unwrap_or_else(PoisonError::into_inner);
        if !notes.contains(&note) {
            notes.push(note);
        }
    };
    let (missing, unsupported) = (notes.clone(), notes.clone());
    let find = plain.font_resolver;
    InterpreterSettings {
        font_resolver: Arc::new(move |query| {
            let name = match query {
                FontQuery::Standard(font) => font.postscript_name(),
                FontQuery::Fallback(font) => font.post_script_name.as_deref().unwrap_or("?"),
            };
            let name = crate::reading::text::shortened(name);
            note(
                &missing,
                format!(
                    "font {name} is not in the file: its letters, if any, are those of a similar one of PDFium's"
                ),
            );
            find(query)
        }),
        warning_sink: Arc::new(move |warning| {
            if let InterpreterWarning::UnsupportedFont = warning {
                let message = "font that cannot be read: its letters are Helvetica's, or left out";
                note(&unsupported, message.to_owned());
            }
        }),
        ..plain
    }
}

/// What a page draws, from all its streams.
///
/// # Errors
/// It is more than the options allow: a page may name a stream any number of times.
fn content(page: &Page, name: &str, options: &ReadOptions) -> Result<Vec<u8>, ReadError> {
    const CONTENTS: &[u8] = b"Contents";
    let mut content = Vec::new();
    let streams = page.raw().get::<Array>(CONTENTS);
    let streams = streams.iter().flat_map(|a| a.iter::<Stream>());
    for stream in page
        .raw()
        .get::<Stream>(CONTENTS)
        .into_iter()
        .chain(streams)
    {
        content.extend_from_slice(&stream.decoded_data().unwrap_or_default());
        // An operator ends with its stream.
        content.push(b'\n');
        if content.len() as u64 > options.most_unpacked {
            return Err(unpacked::too_much(name, options));
        }
    }
    Ok(content)
}

/// What is seen of a page, in its coordinates.
fn page_rect(page: &Page) -> kurbo::Rect {
    let usable = |rect: &Rect| rect.x1 > rect.x0 && rect.y1 > rect.y0;
    let seen = Some(page.intersected_crop_box()).filter(usable);
    let Rect { x0, y0, x1, y1 } = seen.unwrap_or_else(|| page.media_box());
    kurbo::Rect::new(x0, y0, x1, y1)
}

/// A page as it is seen.
struct Sheet {
    /// Turned as it is seen, with the lower left corner at the origin, from its own coordinates.
    map: Affine,
    /// What is seen, from the origin.
    size: kurbo::Size,
}

impl Sheet {
    fn new(page: &Page) -> Sheet {
        // Clockwise.
        let turned = match page.rotation() {
            Rotation::None => Affine::IDENTITY,
            Rotation::Horizontal => Affine::new([0.0, -1.0, 1.0, 0.0, 0.0, 0.0]),
            Rotation::Flipped => Affine::new([-1.0, 0.0, 0.0, -1.0, 0.0, 0.0]),
            Rotation::FlippedHorizontal => Affine::new([0.0, 1.0, -1.0, 0.0, 0.0, 0.0]),
        };
        let seen = (turned * page_rect(page).to_path(0.1)).bounding_box();
        Sheet {
            map: turned.then_translate(-seen.origin().to_vec2()),
            size: seen.size(),
        }
    }
}

/// Why a file cannot be read.
fn unreadable(name: &str, error: LoadPdfError) -> ReadError {
    let found = match error {
        LoadPdfError::Invalid => "a PDF so damaged that no page is found",
        LoadPdfError::Decryption(DecryptionError::PasswordProtected) => {
            "a PDF that needs a password"
        }
        LoadPdfError::Decryption(DecryptionError::UnsupportedAlgorithm) => {
            "a PDF with an unknown encryption"
        }
        LoadPdfError::Decryption(
            DecryptionError::MissingIDEntry | DecryptionError::InvalidEncryption,
        ) => "a PDF with damaged encryption",
    };
    ReadError::whole(name, found, EXPECTED)
}
