//! Models from files to one scene.

use super::args::{Input, Reading};
use super::failure::Failure;
use super::placement::{self, Placement};
use super::session::Session;
use super::values::UpArg;
use azulejo_formats::{Folder, Loaded, ReadOptions, camera_json};
use azulejo_scene::{Scene, Units};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Largest model that is read.
const MAX_FILE: u64 = 4 << 30;
/// The same for what has no length of its own: a pipe may never end.
const MAX_STREAM: u64 = 1 << 30;

/// Reads all models of a command, puts each in its place and merges them; says what was skipped.
///
/// The first model's axes and unit become the scene's, unless the command line says others.
pub fn read_all(input: &Input, session: &mut Session) -> Result<Scene, Failure> {
    if !session.makes_picture() && matches!(input.reading.up, Some(UpArg::Picture(_))) {
        return Err(Failure::misuse(
            "--up: expected y or z; a direction is for pictures",
        ));
    }
    let mut placements = Placements::new(&input.reading.place, &input.scenes)?;
    let mut whole: Option<Scene> = None;
    for (i, path) in input.scenes.iter().enumerate() {
        let placement = placements.next(path);
        let mut model = read_one(path, &input.reading, session)?;
        if let Some(placement) = placement {
            model.units.up = placement.up.unwrap_or(model.units.up);
            model.units.metres_per_unit = placement.unit.or(model.units.metres_per_unit);
        }
        let wanted = wanted_units(&input.reading, whole.as_ref().unwrap_or(&model).units);
        tell_adaptation(path, model.units, wanted, session);
        let mut model = model.adapted(wanted);
        if let Some(placement) = placement {
            let map = placement.scene_from_model(model.bounds(), wanted.up);
            model = model.transformed(&map);
            model.validate().map_err(|e| unplaceable(path, &e))?;
        }
        if let Some(branch) = branch_name(&input.scenes, i, placement) {
            placement::name_branch(&mut model, &branch);
        }
        match &mut whole {
            None => whole = Some(model),
            Some(scene) => {
                scene.units.metres_per_unit = model.units.metres_per_unit;
                scene.merge(model);
            }
        }
    }
    let mut scene = whole.ok_or_else(|| Failure::misuse("no scene given"))?;
    if let Some(path) = &input.lights {
        let lights = camera_json::read_lights(&read_bytes(path)?, &path.to_string_lossy());
        scene.lights.extend(lights.map_err(Failure::failed)?);
    }
    Ok(scene)
}

fn unplaceable(path: &Path, problem: &impl std::fmt::Display) -> Failure {
    Failure::Failed(format!(
        "{}: cannot be placed so: {problem}",
        path.display()
    ))
}

/// Units of the scene: what the command line says, else those there are.
fn wanted_units(reading: &Reading, units: Units) -> Units {
    Units {
        metres_per_unit: reading.unit.or(units.metres_per_unit),
        up: match reading.up {
            Some(UpArg::Scene(up)) => up,
            _ => units.up,
        },
        ..units
    }
}

fn tell_adaptation(path: &Path, from: Units, to: Units, session: &mut Session) {
    let path = path.display();
    if from.up != to.up {
        session.note(&format!(
            "{path}: turned from {:?} up to {:?} up",
            from.up, to.up
        ));
    }
    match (from.metres_per_unit, to.metres_per_unit) {
        (Some(a), Some(b)) if a != b => {
            session.note(&format!(
                "{path}: scaled from units of {a} m to units of {b} m"
            ));
        }
        (None, Some(b)) => {
            session.note(&format!("{path}: does not say its unit; taken as {b} m"));
        }
        _ => {}
    }
    if from.photometric != to.photometric {
        let say = |is: bool| if is { "photometric" } else { "radiometric" };
        let (a, b) = (say(from.photometric), say(to.photometric));
        session.note(&format!(
            "{path}: its light is {a} and is taken as {b}, number for number"
        ));
    }
}

/// A branch is named by its file, or as its placement says; one file alone has no branch.
fn branch_name(paths: &[PathBuf], i: usize, placement: Option<&Placement>) -> Option<String> {
    let stem = |path: &PathBuf| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let named = placement.and_then(|p| p.name.clone());
    if named.is_some() || paths.len() == 1 {
        return named;
    }
    let name = stem(&paths[i]);
    match paths[..i].iter().filter(|p| stem(p) == name).count() {
        0 => Some(name),
        before => Some(format!("{name} {}", before + 1)),
    }
}

/// Hands out placements: the first about a file for its first mention, and so on.
struct Placements<'a>(Vec<&'a Placement>);

impl<'a> Placements<'a> {
    fn new(list: &'a [Placement], paths: &[PathBuf]) -> Result<Placements<'a>, Failure> {
        match list
            .iter()
            .find(|p| !paths.iter().any(|path| p.is_about(path)))
        {
            Some(p) => Err(Failure::misuse(format_args!(
                "--place {}: no scene of that name is given",
                p.file
            ))),
            None => Ok(Placements(list.iter().collect())),
        }
    }

    fn next(&mut self, path: &Path) -> Option<&'a Placement> {
        let at = self.0.iter().position(|p| p.is_about(path))?;
        Some(self.0.remove(at))
    }
}

/// Reads one model; says what was skipped.
fn read_one(path: &Path, reading: &Reading, session: &mut Session) -> Result<Scene, Failure> {
    session.progress().begin("reading", 0);
    let bytes = read_bytes(path)?;
    session.progress().advance(0)?;
    let mut folder = Folder::of_model(path);
    for allowed in &reading.allow {
        folder = folder.allow(allowed);
    }
    let options = ReadOptions {
        lod: reading.lod,
        most_elements: reading.most_elements,
        ..ReadOptions::default()
    };
    let name = path.to_string_lossy();
    let Loaded { scene, warnings } =
        azulejo_formats::read_with(&bytes, &name, &folder, &options).map_err(Failure::failed)?;
    session.progress().advance(0)?;
    warnings.iter().for_each(|w| session.warn(w));
    if let Ok(format) = azulejo_formats::recognise(&bytes, &name) {
        session.has_read(format);
    }
    match warnings.len() {
        0 => Ok(scene),
        n if reading.strict => Err(Failure::Failed(format!(
            "{name}: {n} kinds of things were skipped or mended, and --strict forbids it"
        ))),
        _ => Ok(scene),
    }
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
