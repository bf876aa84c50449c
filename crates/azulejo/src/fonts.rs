//! The fonts of this machine, for text inside files.

use azulejo_formats::outline::typeface::Typeface;
use azulejo_formats::{FileError, Files, FontFile, FontRequest};
use fontdb::{Database, FaceInfo, Family, ID, Query, Source, Style, Weight};
use std::path::Path;
use std::sync::OnceLock;

/// Families that stand for the generic ones, the first that is installed: DejaVu is on most machines that share
/// scenes, and the others are what these families are on Linux, Windows and macOS.
const GENERIC: [(&str, &[&str]); 3] = [
    (
        "serif",
        &[
            "DejaVu Serif",
            "Liberation Serif",
            "Noto Serif",
            "Times New Roman",
            "Times",
        ],
    ),
    (
        "sans-serif",
        &[
            "DejaVu Sans",
            "Liberation Sans",
            "Noto Sans",
            "Arial",
            "Helvetica",
        ],
    ),
    (
        "monospace",
        &[
            "DejaVu Sans Mono",
            "Liberation Mono",
            "Noto Sans Mono",
            "Courier New",
            "Menlo",
        ],
    ),
];

/// Faces that are opened in the search for one with given characters.
const MOST_OPENED: usize = 400;

/// Fonts for text inside files: one that the user names, or those of the system.
///
/// Which font is found depends on what is installed, but not on the order in which the system lists it.
#[derive(Debug, Default)]
pub struct Fonts {
    chosen: Option<FontFile>,
    /// Those of the system, which are listed when a text is met.
    system: OnceLock<Database>,
}

impl Fonts {
    /// A font that is used whatever a text asks for, from a file that has been read.
    pub fn only(name: &Path, bytes: Vec<u8>, face: u32) -> Fonts {
        let name = name.display().to_string();
        Fonts {
            chosen: Some(FontFile { name, bytes, face }),
            system: OnceLock::new(),
        }
    }

    /// The font for a request: of the first of its families that is installed the face that CSS would choose (Fonts
    /// Level 4, 5.2); without any, of a family for sans-serif text; without those, the first of all. If that lacks the
    /// requested characters, the most similar face that has them. `None` without any font, or any that has them.
    pub fn find(&self, request: &FontRequest) -> Option<FontFile> {
        if let Some(chosen) = &self.chosen {
            return has_all(&chosen.bytes, chosen.face, &request.characters)
                .then(|| chosen.clone());
        }
        let database = self.system.get_or_init(installed);
        let best = best(database, request)?;
        let is_complete = |id: &ID| {
            let has = database
                .with_face_data(*id, |bytes, face| has_all(bytes, face, &request.characters));
            has == Some(true)
        };
        let found = if is_complete(&best) {
            best
        } else {
            let mut others: Vec<&FaceInfo> = database.faces().collect();
            others.sort_by_key(|face| unlikeness(face, request));
            let mut others = others.into_iter().take(MOST_OPENED).map(|face| face.id);
            others.find(is_complete)?
        };
        opened(database, found)
    }
}

/// The fonts of the system, sorted by their paths.
fn installed() -> Database {
    let mut listed = Database::new();
    listed.load_system_fonts();
    let mut faces: Vec<FaceInfo> = listed.faces().cloned().collect();
    faces.sort_by_cached_key(|face| (path(face), face.index));
    let mut sorted = Database::new();
    for face in faces {
        sorted.push_face_info(face);
    }
    sorted
}

fn path(face: &FaceInfo) -> String {
    match &face.source {
        Source::File(path) => path.display().to_string(),
        Source::Binary(_) => String::new(),
    }
}

/// The best face of the families, or of any.
fn best(database: &Database, request: &FontRequest) -> Option<ID> {
    let generic = |family: &str| {
        let known = GENERIC
            .iter()
            .find(|(name, _)| family.eq_ignore_ascii_case(name));
        known.map(|(_, families)| *families)
    };
    let mut names: Vec<&str> = Vec::new();
    for family in request
        .families
        .iter()
        .map(String::as_str)
        .chain(["sans-serif"])
    {
        match generic(family) {
            Some(families) => names.extend(families),
            None => names.push(family),
        }
    }
    // Names as the database spells them.
    let spelled = |wanted: &&str| {
        let families = database.faces().flat_map(|face| &face.families);
        let mut families = families.map(|(name, _)| name.as_str());
        families.find(|name| name.to_lowercase() == wanted.to_lowercase())
    };
    let families: Vec<Family> = names.iter().filter_map(spelled).map(Family::Name).collect();
    let query = Query {
        families: &families,
        weight: Weight(request.weight),
        style: if request.is_italic {
            Style::Italic
        } else {
            Style::Normal
        },
        ..Query::default()
    };
    let first = || database.faces().map(|face| face.id).next();
    database.query(&query).or_else(first)
}

/// How little a face is like what is asked for.
fn unlikeness(face: &FaceInfo, request: &FontRequest) -> (bool, u16) {
    let leans = face.style != Style::Normal;
    (
        leans != request.is_italic,
        face.weight.0.abs_diff(request.weight),
    )
}

fn has_all(bytes: &[u8], face: u32, characters: &str) -> bool {
    if characters.is_empty() {
        return true;
    }
    let typeface = Typeface::read(bytes, "", face);
    typeface.is_ok_and(|typeface| {
        let mut visible = characters
            .chars()
            .filter(|c| !c.is_control() && !c.is_whitespace());
        visible.all(|c| typeface.has(c))
    })
}

fn opened(database: &Database, id: ID) -> Option<FontFile> {
    let info = database.face(id)?;
    let family = info.families.first().map_or("", |(name, _)| name);
    let name = format!("{family} ({})", path(info));
    database.with_face_data(id, |bytes, face| FontFile {
        name,
        bytes: bytes.to_vec(),
        face,
    })
}

/// No files, but fonts: what a drawing may use.
impl Files for Fonts {
    fn read(&self, _name: &str) -> Result<Vec<u8>, FileError> {
        Err(FileError::Missing)
    }

    fn font(&self, request: &FontRequest) -> Option<FontFile> {
        self.find(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A database of faces that need no files, with weights and styles.
    fn database(faces: &[(&str, u16, Style)]) -> Database {
        let mut database = Database::new();
        for (k, (family, weight, style)) in (0..).zip(faces) {
            database.push_face_info(FaceInfo {
                id: ID::dummy(),
                source: Source::File(format!("{k}.ttf").into()),
                index: 0,
                families: vec![((*family).to_owned(), fontdb::Language::English_UnitedStates)],
                post_script_name: String::new(),
                style: *style,
                weight: Weight(*weight),
                stretch: fontdb::Stretch::Normal,
                monospaced: false,
            });
        }
        database
    }

    #[test]
    fn families_are_found_by_name_weight_and_style() {
        let plain = Style::Normal;
        let database = database(&[
            ("Zeta", 400, plain),
            ("DejaVu Sans", 400, plain),
            ("DejaVu Sans", 700, plain),
            ("DejaVu Sans", 400, Style::Oblique),
            ("Times New Roman", 400, plain),
        ]);
        let check = |families: &[&str], weight: u16, is_italic: bool, expected: &str| {
            let request = FontRequest {
                weight,
                is_italic,
                ..FontRequest::regular(families.iter().copied())
            };
            let found = best(&database, &request).and_then(|id| database.face(id));
            assert_eq!(found.map(path).as_deref(), Some(expected), "{families:?}");
        };
        check(&["zeta"], 700, false, "0.ttf");
        check(&["Nowhere", "Zeta"], 400, false, "0.ttf");
        check(&["sans-serif"], 400, false, "1.ttf");
        check(&["sans-serif"], 900, false, "2.ttf");
        check(&["sans-serif"], 400, true, "3.ttf");
        check(&["Serif"], 400, false, "4.ttf");
        check(&["Nowhere"], 400, false, "1.ttf");
        check(&[], 400, false, "1.ttf");
    }

    #[test]
    fn a_chosen_font_is_used_for_all_and_refuses_what_it_lacks() {
        let fonts = Fonts::only(Path::new("a.ttf"), b"no font".to_vec(), 0);
        let mut request = FontRequest::regular(["serif"]);
        assert_eq!(
            fonts.find(&request).map(|f| f.name).as_deref(),
            Some("a.ttf")
        );
        request.characters = "a".into();
        assert_eq!(fonts.find(&request), None);
    }
}
