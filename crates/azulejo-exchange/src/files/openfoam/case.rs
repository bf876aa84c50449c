//! The case that files are for.

use super::boundary::{BoundaryPatch, read_boundary};
use super::rows::GROUP;
use azulejo_formats::ReadError;
use std::fs;
use std::path::{Path, PathBuf};

/// Versions between which the files differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenFoamVersion {
    /// openfoam.com up to v1912.
    V1912,
    /// openfoam.com from v2312 on.
    V2312,
    /// openfoam.org.
    Org,
}

impl OpenFoamVersion {
    /// From what users write and what `WM_PROJECT_VERSION` and files hold: `v1912`, `1912.200506`,
    /// `v2312`, `org`, or the small numbers of openfoam.org. `None` for others, and for versions of
    /// which it is not known which files they read.
    pub fn from_word(word: &str) -> Option<OpenFoamVersion> {
        let word = word.trim();
        if word.eq_ignore_ascii_case("org") || word == "dev" {
            return Some(OpenFoamVersion::Org);
        }
        let digits = word.trim_start_matches('v');
        let end = digits.find(|c: char| !c.is_ascii_digit());
        let number: u32 = digits[..end.unwrap_or(digits.len())].parse().ok()?;
        match number {
            ..100 => Some(OpenFoamVersion::Org),
            1606..=1912 => Some(OpenFoamVersion::V1912),
            2312.. => Some(OpenFoamVersion::V2312),
            _ => None,
        }
    }

    /// From the banner of a file, `|  \\    /   O peration     | Version:  v1912 |`.
    fn from_banner(text: &str) -> Option<OpenFoamVersion> {
        let (_, after) = text.split_once("Version:")?;
        OpenFoamVersion::from_word(after.split_whitespace().next()?)
    }
}

/// The folders of regions beside a mesh, of which patches take part, in order.
fn regions(constant: &Path) -> Vec<String> {
    let entries = fs::read_dir(constant).into_iter().flatten().flatten();
    let takes_part = |folder: &PathBuf| {
        let boundary = fs::read_to_string(folder.join("polyMesh").join("boundary"));
        boundary.is_ok_and(|text| text.contains(GROUP))
    };
    let folders = entries.map(|entry| entry.path()).filter(takes_part);
    let mut names: Vec<String> = folders.map(|folder| folder.display().to_string()).collect();
    names.sort();
    names
}

/// A case: its folder, its patches, and the version that it is for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenFoamCase {
    /// The folder that the files belong in: that of `polyMesh`.
    pub folder: PathBuf,
    /// The patches of `polyMesh/boundary`, in order.
    pub patches: Vec<BoundaryPatch>,
    /// The version.
    pub version: OpenFoamVersion,
}

impl OpenFoamCase {
    /// Reads the patches of a case from `constant/polyMesh/boundary`, or `polyMesh/boundary` for the
    /// folder of a region or time. Without a version, that of the file is taken.
    ///
    /// # Errors
    /// [`ReadError`]: there is no such file, it is damaged, its version is not known, or none of its patches takes
    /// part, as where the patches of a region do.
    pub fn open(
        folder: &Path,
        version: Option<OpenFoamVersion>,
    ) -> Result<OpenFoamCase, ReadError> {
        let places = [folder.to_owned(), folder.join("constant")];
        let boundary = |place: &PathBuf| place.join("polyMesh").join("boundary");
        let place = places.into_iter().find(|p| boundary(p).is_file());
        let Some(place) = place else {
            return Err(ReadError::whole(
                folder.display().to_string(),
                "no constant/polyMesh/boundary",
                "the folder of a case with its mesh, written as text and not packed",
            ));
        };
        let path = boundary(&place);
        let name = path.display().to_string();
        let bytes = fs::read(&path)
            .map_err(|e| ReadError::whole(&name, e.to_string(), "a readable file"))?;
        let case = OpenFoamCase::read(&bytes, &name, place, version)?;
        let takes_part = |p: &BoundaryPatch| p.groups.iter().any(|group| group == GROUP);
        if case.version != OpenFoamVersion::Org && !case.patches.iter().any(takes_part) {
            let lack = format!("no patch with inGroups ({GROUP})");
            let expected = match regions(&case.folder).as_slice() {
                [] => "a patch that takes part".to_owned(),
                regions => format!(
                    "the folder of a region that has one: {}",
                    regions.join(", ")
                ),
            };
            return Err(ReadError::whole(&name, lack, expected));
        }
        Ok(case)
    }

    fn read(
        bytes: &[u8],
        name: &str,
        folder: PathBuf,
        version: Option<OpenFoamVersion>,
    ) -> Result<OpenFoamCase, ReadError> {
        let patches = read_boundary(bytes, name)?;
        let text = String::from_utf8_lossy(bytes);
        let version = version.or_else(|| OpenFoamVersion::from_banner(&text));
        let unknown = || {
            let expected = "the version that will read the files (--openfoam): v1912 (or earlier), v2312 (or later) or org";
            ReadError::whole(name, "no version whose files are known", expected)
        };
        Ok(OpenFoamCase {
            folder,
            patches,
            version: version.ok_or_else(unknown)?,
        })
    }

    /// The entry `location` of files, below the case.
    pub(super) fn location(&self) -> String {
        let mut names = self.folder.components().rev();
        let mut name = || Some(names.next()?.as_os_str().to_string_lossy().into_owned());
        let last = name().unwrap_or_else(|| "constant".into());
        match name() {
            Some(parent) if parent == "constant" => format!("constant/{last}"),
            _ => last,
        }
    }
}
