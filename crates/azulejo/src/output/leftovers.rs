//! Drafts of processes that were killed before they could remove them.

use crate::machine;
use azulejo_formats::disk::{self as fs, File};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The name of a draft of this process.
pub(super) fn draft_name(number: u32) -> String {
    format!(".azulejo-{}-{number}.tmp", machine::process())
}

/// The process that wrote a draft, by its name.
fn writer_of(name: &str) -> Option<u32> {
    let ids = name.strip_prefix(".azulejo-")?.strip_suffix(".tmp")?;
    let (process, number) = ids.split_once('-')?;
    number.parse::<u32>().ok()?;
    process.parse().ok()
}

/// Removes the drafts beside `target` that nobody writes any more. Looks at each folder once.
///
/// A draft that is still written is locked, and its process is alive; where it can be neither locked
/// nor its process looked for, it is left alone. What cannot be removed stays.
pub(super) fn remove(target: &Path) {
    static KNOWN: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let is_new = known
        .get_or_insert_default()
        .insert(fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()));
    drop(known);
    if is_new {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let writer = entry.file_name().to_str().and_then(writer_of);
            let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
            if is_file && writer.is_some_and(is_gone) && is_free(&entry.path()) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Whether no process of this machine has this number, where that is known.
fn is_gone(process: u32) -> bool {
    let processes = Path::new("/proc");
    let is_known = processes.join("self").exists();
    process != machine::process() && !(is_known && processes.join(process.to_string()).exists())
}

/// Whether no process, of this machine or another one, has locked a draft.
fn is_free(draft: &Path) -> bool {
    File::open(draft).is_ok_and(|file| file.try_lock().is_ok())
}
