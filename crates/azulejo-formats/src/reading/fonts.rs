//! Fonts that texts in files ask for.

/// What a text asks of its font.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct FontRequest {
    /// Names of families, the preferred one first; also `serif`, `sans-serif` and `monospace`, which stand for any
    /// such family. Case does not matter.
    pub families: Vec<String>,
    /// Weight as in CSS, 1..=1000: 400 is regular, 700 bold.
    pub weight: u16,
    /// Whether letters lean.
    pub is_italic: bool,
    /// Characters that the font must have; if none, the best face of the families is asked for.
    pub characters: String,
}

impl FontRequest {
    /// A regular face of one of these families.
    pub fn regular<S: Into<String>>(families: impl IntoIterator<Item = S>) -> FontRequest {
        FontRequest {
            families: families.into_iter().map(Into::into).collect(),
            weight: 400,
            is_italic: false,
            characters: String::new(),
        }
    }
}

/// A face of a font file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FontFile {
    /// Where it comes from, as messages name it.
    pub name: String,
    /// TrueType, OpenType or Type 1.
    pub bytes: Vec<u8>,
    /// Index of the face, 0 except in collections.
    pub face: u32,
}
