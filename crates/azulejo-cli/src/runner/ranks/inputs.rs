//! The files of a work, which rank 0 reads for all: ranks on other machines, and those that find other
//! files under the same paths, get copies.

use super::Ranks;
use super::link::Link;
use crate::failure::Failure;
use crate::runner::command::named_files;
use crate::runner::header::NamedFile;
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// What rank 0 says of its files.
#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    /// Its version.
    version: String,
    /// Memory of its machine, bytes.
    memory: Option<u64>,
    files: Vec<NamedFile>,
}

/// Copies of files, in a folder that is removed when they are no longer needed.
#[derive(Debug)]
pub struct ReceivedFiles {
    folder: Option<PathBuf>,
    /// Memory of the machine of rank 0, bytes.
    pub memory: Option<u64>,
}

impl Drop for ReceivedFiles {
    fn drop(&mut self) {
        if let Some(folder) = &self.folder {
            // What cannot be removed is left to the system's temporary folder.
            let _ = fs::remove_dir_all(folder);
        }
    }
}

impl Ranks {
    /// Gives the files of the work to the ranks that lack them: those that the command names, and those read for
    /// its models. At rank 0, once it has read them.
    ///
    /// # Errors
    /// One cannot be read again; a rank is of another version; the work was cancelled.
    pub fn share_files(
        &self,
        command_files: &[PathBuf],
        read: &[(PathBuf, Vec<String>)],
    ) -> Result<(), Failure> {
        let manifest = Manifest {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            memory: self.memory,
            files: named_files(command_files, read)?,
        };
        let text = serde_json::to_vec(&manifest).map_err(Failure::failed)?;
        self.link.broadcast(text)?;
        let answers = self.link.all_gather(vec![SAME])?;
        if let Some(rank) = answers.iter().position(|a| *a == [OTHER_VERSION]) {
            return Err(Failure::failed(format_args!(
                "rank {rank} runs another version of azulejo than rank 0, {}: start the same on all machines",
                manifest.version
            )));
        }
        if !answers.iter().any(|a| *a == [LACKS]) {
            return Ok(());
        }
        for file in &manifest.files {
            let path = PathBuf::from(file.name());
            let bytes = fs::read(&path).map_err(|e| Failure::file("read", &path, &e))?;
            self.link.broadcast(bytes)?;
        }
        Ok(())
    }
}

/// Answers to the manifest.
const SAME: u8 = 0;
const LACKS: u8 = 1;
const OTHER_VERSION: u8 = 2;

/// Finds out which files rank 0 reads, and has the command read the same: its own where they are, otherwise
/// copies. `is_near` says that rank 0 is on the same machine; elsewhere no file system is trusted, nor burdened by
/// many ranks at once.
///
/// # Errors
/// Copies cannot be written; the work was cancelled.
pub fn receive(
    link: &Link,
    rank: usize,
    is_near: bool,
    command_files: Vec<&mut PathBuf>,
) -> Result<ReceivedFiles, Failure> {
    let text = link.broadcast(Vec::new())?;
    let manifest = serde_json::from_slice::<Manifest>(&text).ok();
    let known = manifest.filter(|m| m.version == env!("CARGO_PKG_VERSION"));
    let Some(manifest) = known else {
        link.all_gather(vec![OTHER_VERSION])?;
        return Err(Failure::Cancelled);
    };
    let has_all = is_near && manifest.files.iter().all(NamedFile::is_here);
    let answers = link.all_gather(vec![if has_all { SAME } else { LACKS }])?;
    let mut received = ReceivedFiles {
        folder: None,
        memory: manifest.memory,
    };
    if !answers.iter().any(|a| *a == [LACKS]) {
        return Ok(received);
    }
    let folder = std::env::temp_dir().join(format!("azulejo-rank-{rank}-{}", std::process::id()));
    if !has_all {
        fs::create_dir_all(&folder).map_err(|e| Failure::file("create", &folder, &e))?;
        received.folder = Some(folder.clone());
    }
    let mut models: Vec<(String, PathBuf)> = Vec::new();
    for (number, file) in manifest.files.iter().enumerate() {
        // All ranks take part in each broadcast, whether they need it or not.
        let bytes = link.broadcast(Vec::new())?;
        if has_all {
            continue;
        }
        let place = match &file.beside {
            None => {
                let own = folder.join(number.to_string());
                let name = Path::new(&file.path).file_name().unwrap_or_default();
                let place = own.join(name);
                models.push((file.path.clone(), place.clone()));
                place
            }
            Some(name) => {
                let model = models.iter().find(|(path, _)| *path == file.path);
                match (model, is_below(name)) {
                    (Some((_, model)), true) => model.with_file_name(name),
                    _ => continue,
                }
            }
        };
        let parent = place.parent().unwrap_or(&folder);
        let written = fs::create_dir_all(parent).and_then(|()| fs::write(&place, bytes));
        written.map_err(|e| Failure::file("write", &place, &e))?;
    }
    for file in command_files {
        let is_this = |(path, _): &&(String, PathBuf)| Path::new(path) == file.as_path();
        if let Some((_, copy)) = models.iter().find(is_this) {
            file.clone_from(copy);
        }
    }
    Ok(received)
}

/// Whether a name stays in its folder.
fn is_below(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}
