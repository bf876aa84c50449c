//! Reading of model files.

use crate::files::Refused;
#[cfg(feature = "fonts")]
use crate::fonts::Fonts;
use azulejo_formats::disk::{self as fs, File};
use azulejo_formats::{
    FileError, Files, Folder, Format, ReadError, ReadOptions, RecognizedModel, gltf, recognize,
};
#[cfg(feature = "fonts")]
use azulejo_formats::{FontFile, FontRequest};
use azulejo_scene::{MOST_FACE_CORNERS, Object, Scene};
use azulejo_trace::{Cancelled, Progress};
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Size limit of files, bytes.
pub const MAX_FILE: u64 = 4 << 30;

/// Size limit of streams, which may never end, bytes.
pub const MAX_STREAM: u64 = 1 << 30;

/// Options for reading a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Options of the format's reader.
    pub options: ReadOptions,
    /// Folders, other than the model's own, in which it may refer to files.
    pub allow: Vec<PathBuf>,
    /// A folder in which files are searched that are not in the model's own: that of the model of
    /// which this is a copy.
    pub home: Option<PathBuf>,
}

/// Why a model could not be read.
#[derive(Debug)]
#[non_exhaustive]
pub enum ReadFailure {
    /// Cancelled.
    Cancelled,
    /// The file could not be read, or is larger than [`MAX_FILE`] or [`MAX_STREAM`].
    File(Refused),
    /// The path is a folder.
    Directory(PathBuf),
    /// The content is not a model, or is damaged.
    Content(ReadError),
    /// A face has more than [`MOST_FACE_CORNERS`] corners.
    Face(VastFace),
}

/// A face of too many corners.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VastFace {
    /// The model.
    pub path: PathBuf,
    /// Name of the object.
    pub object: String,
    /// Index of the face in it.
    pub face: usize,
    /// Its corners.
    pub corners: usize,
}

impl VastFace {
    /// The first in a scene.
    fn find(scene: &Scene, path: &Path) -> Option<VastFace> {
        let vast_face = |object: &Object| {
            let mesh = object.shape.mesh()?;
            let corners = |w: &[u32]| (w[1] - w[0]) as usize;
            let mut counts = mesh.faces.starts.windows(2).map(corners).enumerate();
            let (face, corners) = counts.find(|c| c.1 > MOST_FACE_CORNERS)?;
            Some(VastFace {
                path: path.to_owned(),
                object: object.name.clone(),
                face,
                corners,
            })
        };
        scene.objects.iter().find_map(vast_face)
    }
}

impl fmt::Display for VastFace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: object \"{}\", face {}: found {} corners, expected at most {MOST_FACE_CORNERS}; \
             divide the face into smaller ones in the program that wrote it",
            self.path.display(),
            self.object,
            self.face + 1,
            self.corners
        )
    }
}

impl fmt::Display for ReadFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReadFailure::Cancelled => Cancelled.fmt(f),
            ReadFailure::File(refused) => refused.fmt(f),
            ReadFailure::Directory(path) => {
                write!(f, "{} is a folder, expected a file", path.display())
            }
            ReadFailure::Content(error) => error.fmt(f),
            ReadFailure::Face(face) => face.fmt(f),
        }
    }
}

impl std::error::Error for ReadFailure {}

impl From<Cancelled> for ReadFailure {
    fn from(_: Cancelled) -> ReadFailure {
        ReadFailure::Cancelled
    }
}

/// Reads a model of any format; `-` is standard input.
///
/// Files that it refers to are searched in its folder and below, and where `reading` allows. Once
/// `progress` is cancelled no further file is read; a file that is being parsed is parsed to its end.
///
/// # Errors
/// [`ReadFailure`].
pub fn read(
    path: &Path,
    reading: &Reading,
    progress: &Progress,
) -> Result<RecognizedModel, ReadFailure> {
    let bytes = read_file(path, progress)?;
    parsed(&bytes, path, reading, progress)
}

/// [`read`] for light that is computed anew: without the lightmap that azulejo has put into a glTF file, so
/// that the lamps that were dimmed for it shine again. Says so in notes.
///
/// # Errors
/// [`ReadFailure`].
pub fn read_unbaked(
    path: &Path,
    reading: &Reading,
    progress: &Progress,
) -> Result<(RecognizedModel, Vec<String>), ReadFailure> {
    let bytes = read_file(path, progress)?;
    let (bytes, notes) = unbaked(bytes, &path.to_string_lossy());
    Ok((parsed(&bytes, path, reading, progress)?, notes))
}

/// A file without the lightmap or the light on vertices that azulejo has put into it, and what is to be said of that; the file itself,
/// if it has none.
pub fn unbaked(bytes: Vec<u8>, name: &str) -> (Vec<u8>, Vec<String>) {
    if !matches!(recognize(&bytes, name), Ok(Format::Gltf)) {
        return (bytes, Vec::new());
    }
    let Ok(stripped) = gltf::patch::strip(&bytes, name) else {
        return (bytes, Vec::new());
    };
    let what = if stripped.is_of_vertices {
        "the light that azulejo has put on its vertices"
    } else {
        "its lightmap, which azulejo has baked,"
    };
    let mut notes = vec![format!("{name}: {what} is removed first")];
    notes.extend(stripped.notes);
    (stripped.bytes, notes)
}

fn parsed(
    bytes: &[u8],
    path: &Path,
    reading: &Reading,
    progress: &Progress,
) -> Result<RecognizedModel, ReadFailure> {
    progress.begin("parsing", 0);
    progress.advance(0)?;
    let around = CancellableFiles::of(path, reading, progress);
    let name = path.to_string_lossy();
    let read = azulejo_formats::read_with(bytes, &name, &around, &reading.options);
    // What a reader makes of files that it was not given is no reason.
    progress.advance(0)?;
    let model = read.map_err(ReadFailure::Content)?;
    match VastFace::find(&model.scene, path) {
        None => Ok(model),
        Some(face) => Err(ReadFailure::Face(face)),
    }
}

/// The files around a model, with errors once the work is cancelled.
struct CancellableFiles<'a> {
    own: Folder,
    home: Option<Folder>,
    #[cfg(feature = "fonts")]
    fonts: Fonts,
    progress: &'a Progress,
}

impl<'a> CancellableFiles<'a> {
    fn of(path: &Path, reading: &Reading, progress: &'a Progress) -> CancellableFiles<'a> {
        let own = Folder::of_model(path);
        let own = (reading.allow.iter()).fold(own, |folder, more| folder.allow(more));
        CancellableFiles {
            own,
            home: reading.home.as_ref().map(Folder::new),
            #[cfg(feature = "fonts")]
            fonts: Fonts::default(),
            progress,
        }
    }
}

impl Files for CancellableFiles<'_> {
    fn read(&self, name: &str) -> Result<Vec<u8>, FileError> {
        if self.progress.is_cancelled() {
            return Err(FileError::Io(io::ErrorKind::Interrupted.into()));
        }
        match (self.own.read(name), &self.home) {
            (Err(FileError::Missing | FileError::Outside), Some(home)) => home.read(name),
            (read, _) => read,
        }
    }

    #[cfg(feature = "fonts")]
    fn font(&self, request: &FontRequest) -> Option<FontFile> {
        self.fonts.find(request)
    }
}

/// The bytes of a file, or of standard input for `-`.
///
/// # Errors
/// [`ReadFailure::Directory`], and [`ReadFailure::File`] for what is too large too.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadFailure> {
    read_file(path, &Progress::new())
}

/// The same, with progress in bytes and cancellation.
fn read_file(path: &Path, progress: &Progress) -> Result<Vec<u8>, ReadFailure> {
    let failed = |error: io::Error| {
        if progress.is_cancelled() {
            ReadFailure::Cancelled
        } else {
            ReadFailure::File(Refused {
                deed: "read",
                path: path.to_owned(),
                error,
            })
        }
    };
    if path == Path::new("-") {
        return limited(io::stdin().lock(), 0, MAX_STREAM, progress).map_err(failed);
    }
    let meta = fs::metadata(path).map_err(failed)?;
    if meta.is_dir() {
        return Err(ReadFailure::Directory(path.to_owned()));
    }
    let limit = if meta.is_file() { MAX_FILE } else { MAX_STREAM };
    let file = File::open(path).map_err(failed)?;
    limited(file, meta.len(), limit, progress).map_err(failed)
}

/// Reads to the end, at most `limit` bytes; `length` is the expected number.
fn limited(
    mut source: impl Read,
    length: u64,
    limit: u64,
    progress: &Progress,
) -> io::Result<Vec<u8>> {
    const PIECE: u64 = 1 << 22;
    progress.begin("reading", length);
    let mut bytes = Vec::new();
    if length <= limit {
        bytes.try_reserve_exact(length as usize)?;
        loop {
            let room = limit + 1 - bytes.len() as u64;
            let piece = source.by_ref().take(room.min(PIECE));
            let read = { piece }.read_to_end(&mut bytes)?;
            let goes_on = progress.advance(read as u64);
            goes_on.map_err(|_| io::ErrorKind::Interrupted)?;
            if read == 0 {
                break;
            }
        }
    }
    if length > limit || bytes.len() as u64 > limit {
        let message = format!("larger than {limit} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_end_is_refused() {
        let read =
            |source: &mut dyn Read, length, limit| limited(source, length, limit, &Progress::new());
        assert_eq!(read(&mut &b"1234"[..], 4, 4).unwrap(), b"1234");
        for (length, limit) in [(0, 3), (9, 3)] {
            let message = read(&mut &b"1234"[..], length, limit)
                .unwrap_err()
                .to_string();
            assert!(message.contains("larger than 3 bytes"), "{message}");
        }
        assert!(read(&mut io::repeat(7), 0, 1000).is_err());
    }

    #[test]
    fn a_reader_that_is_cancelled_stops_and_tells_how_far_it_is() {
        /// Is cancelled by somebody after a few pieces.
        struct Endless<'a>(&'a Progress);
        impl Read for Endless<'_> {
            fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
                if self.0.done() > 0 {
                    self.0.cancel();
                }
                Ok(into.len())
            }
        }
        let progress = Progress::new();
        let stopped = limited(Endless(&progress), 1 << 30, 1 << 40, &progress);
        assert_eq!(stopped.unwrap_err().kind(), io::ErrorKind::Interrupted);
        assert!(progress.done() < 1 << 24 && progress.total() == 1 << 30);
        // No further file is read for a model that nobody waits for.
        let progress = Progress::new();
        let around = CancellableFiles::of(Path::new("a.obj"), &Reading::default(), &progress);
        progress.cancel();
        let read = around.read("a.mtl");
        assert!(matches!(read, Err(FileError::Io(_))), "{read:?}");
    }

    #[test]
    fn faces_of_too_many_corners_are_named() {
        let model = std::env::temp_dir().join(format!("azulejo-vast-{}.obj", std::process::id()));
        let read_with = |corners: usize| {
            let mut text = String::from("o tile\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no disc\n");
            for k in 0..corners {
                let angle = k as f64 / corners as f64 * std::f64::consts::TAU;
                text += &format!("v {} {} 1\n", angle.cos(), angle.sin());
            }
            let ring: Vec<String> = (0..corners).map(|k| (k + 4).to_string()).collect();
            text += &format!("f {}\n", ring.join(" "));
            fs::write(&model, text).unwrap();
            read(&model, &Reading::default(), &Progress::new())
        };
        assert!(read_with(MOST_FACE_CORNERS).is_ok());
        let message = read_with(MOST_FACE_CORNERS + 1).unwrap_err().to_string();
        let expected = "object \"disc\", face 1: found 65537 corners, expected at most 65536";
        assert!(message.contains(expected), "{message}");
        fs::remove_file(model).unwrap();
    }

    #[test]
    fn failures_say_what_was_there() {
        let folder = std::env::temp_dir();
        let missing = folder.join(format!("azulejo-missing-{}.obj", std::process::id()));
        let picture = folder.join(format!("azulejo-picture-{}.obj", std::process::id()));
        fs::write(&picture, b"\x89PNG").unwrap();
        let reading = Reading::default();
        for (path, message) in [
            (&missing, "No such file or directory"),
            (&folder, "is a folder, expected a file"),
            (&picture, "found a PNG picture, expected a model in"),
        ] {
            let failure = read(path, &reading, &Progress::new()).unwrap_err();
            assert!(failure.to_string().contains(message), "{failure}");
        }
        let progress = Progress::new();
        progress.cancel();
        let cancelled = read(&picture, &reading, &progress);
        assert!(matches!(cancelled, Err(ReadFailure::Cancelled)));
        fs::remove_file(picture).unwrap();
    }
}
