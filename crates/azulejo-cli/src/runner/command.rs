//! The command of a part: recorded as it was typed, and run again by `merge`.

use super::header::NamedFile;
use crate::content_key::shown;
use crate::failure::Failure;
use crate::parts::Shard;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What of a command's arguments is about its shard, its output and the places of files.
pub struct ShardedArgs<'a> {
    /// Its name.
    pub name: &'static str,
    /// `--shard`.
    pub shard: &'a mut Option<Shard>,
    /// `-o`.
    pub output: OutputArg<'a>,
    /// `--lightmap` and `--error-map`, where it has them.
    pub maps: Option<[&'a mut Option<PathBuf>; 2]>,
    /// The files that it reads.
    pub files: Vec<&'a mut PathBuf>,
}

/// The command of this process, as a part records it.
pub struct DescribedCommand {
    /// The files that it names.
    pub files: Vec<PathBuf>,
    /// A key of its other arguments, but those about its shard and output.
    pub options: String,
}

/// `-o` of a command that needs one, or can do without.
pub enum OutputArg<'a> {
    /// It needs one.
    Needed(&'a mut PathBuf),
    /// It can do without.
    Optional(&'a mut Option<PathBuf>),
}

impl OutputArg<'_> {
    /// Sets it, or leaves it out.
    ///
    /// # Errors
    /// The command cannot do without.
    pub fn set(self, path: Option<&Path>) -> Result<(), Failure> {
        match (self, path) {
            (OutputArg::Needed(output), Some(path)) => *output = path.to_owned(),
            (OutputArg::Needed(_), None) => return Err(Failure::misuse("-o OUT is missing")),
            (OutputArg::Optional(output), path) => *output = path.map(Path::to_owned),
        }
        Ok(())
    }
}

/// The arguments of this process.
///
/// # Errors
/// Some are not text.
pub fn typed() -> Result<Vec<String>, Failure> {
    let word = |word: std::ffi::OsString| {
        word.into_string().map_err(|word| {
            Failure::misuse(format_args!(
                "the command is recorded for other processes, and {} is not UTF-8: rename the file",
                word.display()
            ))
        })
    };
    std::env::args_os().skip(1).map(word).collect()
}

/// The folder in which this process runs; empty if that is not text, and then useless elsewhere.
pub fn folder() -> String {
    let folder = std::env::current_dir().ok();
    let text = folder.and_then(|folder| folder.into_os_string().into_string().ok());
    text.unwrap_or_default()
}

/// The content of a file as a key.
///
/// # Errors
/// It cannot be read.
fn content(path: &Path) -> std::io::Result<String> {
    Ok(shown(blake3::hash(&fs::read(path)?).as_bytes()))
}

/// Files with their contents, and those that were read for each model.
///
/// # Errors
/// One cannot be read.
pub fn named_files(
    files: &[PathBuf],
    read: &[(PathBuf, Vec<String>)],
) -> Result<Vec<NamedFile>, Failure> {
    let mut named = Vec::new();
    for path in files {
        let content = content(path).map_err(|e| Failure::file("read", path, &e))?;
        named.push(NamedFile {
            path: path.display().to_string(),
            beside: None,
            content,
        });
    }
    for (model, names) in read {
        for name in names {
            // A name in other capitals than the file's, or in another folder that is allowed, is left to the
            // key of the scene.
            let Ok(content) = content(&model.with_file_name(name)) else {
                continue;
            };
            named.push(NamedFile {
                path: model.display().to_string(),
                beside: Some(name.clone()),
                content,
            });
        }
    }
    Ok(named)
}

impl NamedFile {
    /// Whether it is where its name says, with the same content.
    pub fn is_here(&self) -> bool {
        content(Path::new(&self.name())).is_ok_and(|content| content == self.content)
    }
}

/// Where the files of a recorded command are now, by the paths that it names them by.
pub struct FoundFiles(HashMap<PathBuf, PathBuf>);

impl FoundFiles {
    /// Finds files by their contents: in `folder` if one is given, otherwise where the command names them,
    /// from here or from the folder in which it ran.
    ///
    /// # Errors
    /// Some are missing, or are not what they were: all are named.
    pub fn find(
        files: &[NamedFile],
        ran_in: &str,
        folder: Option<&Path>,
    ) -> Result<FoundFiles, Failure> {
        let mut places: HashMap<PathBuf, PathBuf> = HashMap::new();
        let (mut missing, mut changed) = (Vec::new(), Vec::new());
        // Locate the files that the command names: one of the same content wins over one that has changed.
        for file in files.iter().filter(|file| file.beside.is_none()) {
            let path = PathBuf::from(&file.path);
            let candidates = candidates(&path, ran_in, folder);
            let there: Vec<&PathBuf> = candidates.iter().filter(|c| c.is_file()).collect();
            let same = |c: &&&PathBuf| content(c).is_ok_and(|content| content == file.content);
            match (there.iter().find(same), there.first()) {
                (Some(same), _) => {
                    places.insert(path, same.to_path_buf());
                }
                (None, Some(other)) => {
                    changed.push(other.display().to_string());
                    places.insert(path, other.to_path_buf());
                }
                (None, None) => missing.push(file.path.clone()),
            }
        }
        // The files that were read for one of these have to lie beside it, where it is now.
        for file in files {
            let (Some(name), Some(place)) = (&file.beside, places.get(Path::new(&file.path)))
            else {
                continue;
            };
            let path = place.with_file_name(name);
            match content(&path) {
                Ok(content) if content == file.content => {}
                Ok(_) => changed.push(path.display().to_string()),
                Err(_) => missing.push(path.display().to_string()),
            }
        }
        // Name all of a kind in one failure, so that the user can bring them together at once.
        if !changed.is_empty() {
            return Err(Failure::failed(format_args!(
                "{} changed since the parts were computed: bring back the content of that time, or compute all \
                 parts again",
                listed(&changed, "has", "have")
            )));
        }
        if !missing.is_empty() {
            return Err(Failure::failed(format_args!(
                "{} not there, from which the parts were computed: say by --files FOLDER in which folder the files \
                 are now",
                listed(&missing, "is", "are")
            )));
        }
        Ok(FoundFiles(places))
    }

    /// Sets the files of a command to where they are.
    pub fn set(&self, files: Vec<&mut PathBuf>) {
        for file in files {
            if let Some(place) = self.0.get(file) {
                file.clone_from(place);
            }
        }
    }

    /// Whether a path is one of these files.
    pub fn has(&self, path: &Path) -> bool {
        let real = |path: &Path| fs::canonicalize(path).ok();
        let real_path = real(path);
        real_path.is_some() && self.0.values().any(|place| real(place) == real_path)
    }
}

/// Where a file may be.
fn candidates(path: &Path, ran_in: &str, folder: Option<&Path>) -> Vec<PathBuf> {
    match folder {
        Some(folder) => {
            let name = path.file_name().map(|name| folder.join(name));
            let below = path.is_relative().then(|| folder.join(path));
            below.into_iter().chain(name).collect()
        }
        None => vec![path.to_owned(), Path::new(ran_in).join(path)],
    }
}

/// Names with the verb that fits their number.
fn listed(names: &[String], one: &str, several: &str) -> String {
    let verb = if names.len() == 1 { one } else { several };
    format!("{} {verb}", names.join(", "))
}
