//! Text inside files, set in fonts that are found by what it asks for.

use super::typeface::{SettingError, Typeface};
use crate::reading::text::shortened;
use crate::{Files, FontFile, FontRequest};
use azulejo_scene::Line;
use std::collections::HashMap;
use std::rc::Rc;

/// Bytes in one text; more are no text.
const LONGEST: usize = 1 << 16;

/// Sets texts; each font is looked for once, and only if there is a text.
pub(crate) struct Letters<'f> {
    files: &'f dyn Files,
    faces: HashMap<FontRequest, Option<Rc<LetterFace>>>,
}

/// A face in which texts are set.
pub(crate) struct LetterFace {
    /// Its name and file.
    pub name: String,
    /// How far lines reach above the baseline, ems.
    pub ascent: f64,
    /// How far they reach below it, ems, positive.
    pub descent: f64,
    /// The height of capital letters, ems.
    pub capital: f64,
    typeface: Typeface,
}

/// A line of text, in ems.
pub(crate) struct TextLine {
    /// Its letters.
    pub line: Line,
    /// Their face.
    pub face: Rc<LetterFace>,
}

impl<'f> Letters<'f> {
    /// Letters of fonts that `files` find.
    pub fn new(files: &'f dyn Files) -> Letters<'f> {
        Letters {
            files,
            faces: HashMap::new(),
        }
    }

    /// Sets a line with `spacing` additional ems between letters, in the face that is asked for or, if that lacks
    /// characters, in one that has them all.
    ///
    /// # Errors
    /// What is to be said of a text that cannot be set.
    pub fn set(
        &mut self,
        text: &str,
        request: &FontRequest,
        spacing: f64,
    ) -> Result<TextLine, String> {
        let left_out = |why: &str| format!("text \"{}\": {why}, left out", shortened(text));
        if text.len() > LONGEST {
            return Err(left_out(&format!("longer than {LONGEST} bytes")));
        }
        let found = self.face(request);
        let face = found.ok_or_else(|| left_out("no font to set it in (install or name one)"))?;
        match face.typeface.setting().line(text, spacing) {
            Ok(line) => return Ok(TextLine { line, face }),
            Err(SettingError::NoGlyphs(_)) => {}
            Err(damaged) => return Err(left_out(&format!("{}: {damaged}", face.name))),
        }
        let complete = FontRequest {
            characters: text.to_owned(),
            ..request.clone()
        };
        let found = self.face(&complete);
        let set = found.and_then(|face| {
            let line = face.typeface.setting().line(text, spacing).ok()?;
            Some(TextLine { line, face })
        });
        set.ok_or_else(|| left_out("no font has all of its characters"))
    }

    fn face(&mut self, request: &FontRequest) -> Option<Rc<LetterFace>> {
        if let Some(known) = self.faces.get(request) {
            return known.clone();
        }
        let face = self.files.font(request).and_then(LetterFace::open);
        let face = face.map(Rc::new);
        self.faces.insert(request.clone(), face.clone());
        face
    }
}

impl LetterFace {
    /// Opens a font; `None` if it is damaged.
    fn open(file: FontFile) -> Option<LetterFace> {
        let typeface = Typeface::read(&file.bytes, &file.name, file.face).ok()?;
        let [ascent, descent] = typeface.line_extents();
        Some(LetterFace {
            name: file.name,
            ascent,
            descent,
            capital: typeface.capital_height(),
            typeface,
        })
    }
}

impl TextLine {
    /// In which font it is set, as a warning says it.
    pub fn remark(&self, request: &FontRequest) -> String {
        let wanted = request.families.first().map_or("any font", String::as_str);
        let (wanted, name) = (shortened(wanted), &self.face.name);
        format!("text that asks for {wanted}: set in {name}")
    }
}
