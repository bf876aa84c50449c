//! Models from files to one scene.

use super::args::{Input, Trust};
use super::failure::Failure;
use super::session::Session;
use azulejo_formats::{Folder, Loaded, camera_json};
use azulejo_scene::Scene;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Largest model that is read.
const MAX_FILE: u64 = 4 << 30;
/// The same for what has no length of its own: a pipe may never end.
const MAX_STREAM: u64 = 1 << 30;

/// Reads all models of a command and merges them; says what was skipped.
pub fn read_all(input: &Input, session: &mut Session) -> Result<Scene, Failure> {
    let (first, rest) = input
        .scenes
        .split_first()
        .ok_or_else(|| Failure::misuse("no scene given"))?;
    let mut scene = read_one(first, &input.trust, session)?;
    for path in rest {
        let other = read_one(path, &input.trust, session)?;
        if other.units != scene.units {
            let (a, b) = (first.display(), path.display());
            session.note(&format!(
                "{a} and {b} have different units; lengths are merged as they are"
            ));
        }
        scene.merge(other);
    }
    if let Some(path) = &input.lights {
        let lights = camera_json::read_lights(&read_bytes(path)?, &path.to_string_lossy());
        scene.lights.extend(lights.map_err(Failure::failed)?);
    }
    Ok(scene)
}

/// Reads one model; says what was skipped.
pub fn read_one(path: &Path, trust: &Trust, session: &mut Session) -> Result<Scene, Failure> {
    session.progress().begin("reading", 0);
    let bytes = read_bytes(path)?;
    session.progress().advance(0)?;
    let mut folder = Folder::of_model(path);
    for allowed in &trust.allow {
        folder = folder.allow(allowed);
    }
    let name = path.to_string_lossy();
    let Loaded { scene, warnings } =
        azulejo_formats::read(&bytes, &name, &folder).map_err(Failure::failed)?;
    session.progress().advance(0)?;
    warnings.iter().for_each(|w| session.warn(w));
    Ok(scene)
}

/// The bytes of a file, or of standard input for `-`.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let failed = |e: io::Error| Failure::file("read", path, &e);
    if path == Path::new("-") {
        return limited(io::stdin().lock(), 0, MAX_STREAM).map_err(failed);
    }
    let meta = fs::metadata(path).map_err(failed)?;
    if meta.is_dir() {
        let message = format!("{} is a directory, expected a file", path.display());
        return Err(Failure::Failed(message));
    }
    let limit = if meta.is_file() { MAX_FILE } else { MAX_STREAM };
    let file = File::open(path).map_err(failed)?;
    limited(file, meta.len(), limit).map_err(failed)
}

/// Reads to the end, but no more than `limit` bytes; `length` is what to expect.
fn limited(source: impl Read, length: u64, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if length <= limit {
        bytes.try_reserve_exact(length as usize)?;
        source.take(limit + 1).read_to_end(&mut bytes)?;
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
        assert_eq!(limited(&b"1234"[..], 4, 4).unwrap(), b"1234");
        for (length, limit) in [(0, 3), (9, 3)] {
            let said = limited(&b"1234"[..], length, limit)
                .unwrap_err()
                .to_string();
            assert!(said.contains("larger than 3 bytes"), "{said}");
        }
        assert!(limited(io::repeat(7), 0, 1000).is_err());
    }
}
