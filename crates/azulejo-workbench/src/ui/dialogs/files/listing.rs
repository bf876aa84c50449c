//! The content of a folder: reading, sorting and filtering it. It knows no window.

use std::cmp::Ordering;
use std::fs::{DirEntry, Metadata};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, SystemTime};

/// A file or folder of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct FolderEntry {
    /// Its name as it is displayed.
    pub name: String,
    /// Its name in lower case, by which it is found.
    key: String,
    /// What it is sorted by.
    sort_key: String,
    /// Its path, exactly.
    pub path: PathBuf,
    /// Whether it is a folder, or a link to one.
    pub is_folder: bool,
    is_hidden: bool,
    /// Bytes of a file; `None` for folders and what cannot be asked.
    pub size: Option<u64>,
    /// When it was written last.
    pub modified: Option<SystemTime>,
}

/// What the list is sorted by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SortColumn {
    /// The name, whatever its case.
    #[default]
    Name,
    /// The number of bytes.
    Size,
    /// The date.
    Modified,
}

/// The order of the list. Folders come first in any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SortOrder {
    /// What it is sorted by.
    pub column: SortColumn,
    /// Whether the largest, latest or last comes first.
    pub is_descending: bool,
}

impl SortOrder {
    /// The order after a click on the header of `column`: the other direction if it is sorted by it
    /// already.
    pub fn clicked(self, column: SortColumn) -> SortOrder {
        SortOrder {
            column,
            is_descending: self.column == column && !self.is_descending,
        }
    }

    fn compare(self, a: &FolderEntry, b: &FolderEntry) -> Ordering {
        let by_name = || {
            a.sort_key
                .cmp(&b.sort_key)
                .then_with(|| a.path.cmp(&b.path))
        };
        let order = match self.column {
            SortColumn::Name => by_name(),
            SortColumn::Size => a.size.cmp(&b.size).then_with(by_name),
            SortColumn::Modified => a.modified.cmp(&b.modified).then_with(by_name),
        };
        let order = if self.is_descending {
            order.reverse()
        } else {
            order
        };
        b.is_folder.cmp(&a.is_folder).then(order)
    }
}

/// What the list shows, and how. It outlives the dialog.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListOptions {
    /// The order.
    pub order: SortOrder,
    /// Whether hidden files and folders are shown.
    pub shows_hidden: bool,
    /// Whether files with unknown extensions are shown.
    pub shows_all: bool,
}

impl ListOptions {
    /// The numbers of the entries that are shown, in their order: folders, and files with one of
    /// `extensions` (all files if there are none), with `typed` in their names.
    pub fn shown(self, entries: &[FolderEntry], extensions: &[&str], typed: &str) -> Vec<usize> {
        let typed = typed.to_lowercase();
        let is_shown = |e: &FolderEntry| {
            (self.shows_hidden || !e.is_hidden || typed.starts_with('.'))
                && (self.shows_all || e.is_folder || is_offered(&e.path, extensions))
                && e.key.contains(&typed)
        };
        let mut shown: Vec<usize> = (0..entries.len())
            .filter(|&k| is_shown(&entries[k]))
            .collect();
        shown.sort_by(|&a, &b| self.order.compare(&entries[a], &entries[b]));
        shown
    }
}

impl FolderEntry {
    /// Whether its name begins with `text`, whatever the case.
    pub fn begins_with(&self, text: &str) -> bool {
        self.key.starts_with(&text.to_lowercase())
    }

    fn new(entry: &DirEntry) -> FolderEntry {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        // What a link leads to; a link to nowhere is listed as a file.
        let metadata = std::fs::metadata(&path).ok();
        let is_folder = metadata.as_ref().is_some_and(Metadata::is_dir);
        FolderEntry {
            key: name.to_lowercase(),
            sort_key: sort_key(&name),
            is_hidden: is_hidden(&name, metadata.as_ref()),
            is_folder,
            size: metadata.as_ref().filter(|_| !is_folder).map(Metadata::len),
            modified: metadata.and_then(|m| m.modified().ok()),
            name,
            path,
        }
    }
}

/// Whether a file has one of the extensions, whatever their case; any file if there are none.
pub fn is_offered(path: &Path, extensions: &[&str]) -> bool {
    let own = path.extension().unwrap_or_default().to_string_lossy();
    extensions.is_empty() || extensions.iter().any(|e| e.eq_ignore_ascii_case(&own))
}

/// A text by which names are sorted whatever their case, and their numbers by value: part 2 comes
/// before part 10.
fn sort_key(name: &str) -> String {
    let mut key = String::new();
    let mut number = String::new();
    for c in name.to_lowercase().chars() {
        if c.is_ascii_digit() {
            number.push(c);
            continue;
        }
        push_number(&mut key, &mut number);
        key.push(c);
    }
    push_number(&mut key, &mut number);
    key
}

/// Appends a number with leading zeros, if there is one, and begins another.
fn push_number(key: &mut String, number: &mut String) {
    const DIGITS: usize = 20;
    if !number.is_empty() {
        key.push_str(&format!("{number:0>DIGITS$}"));
        number.clear();
    }
}

#[cfg(windows)]
fn is_hidden(name: &str, metadata: Option<&Metadata>) -> bool {
    use std::os::windows::fs::MetadataExt;
    const HIDDEN: u32 = 2;
    name.starts_with('.') || metadata.is_some_and(|m| m.file_attributes() & HIDDEN != 0)
}

#[cfg(not(windows))]
fn is_hidden(name: &str, _: Option<&Metadata>) -> bool {
    name.starts_with('.')
}

/// Reads a folder.
///
/// # Errors
///
/// The system's reason why it cannot be read.
pub fn read_folder(folder: &Path) -> Result<Vec<FolderEntry>, String> {
    let entries = std::fs::read_dir(folder).map_err(|e| e.to_string())?;
    Ok(entries.flatten().map(|e| FolderEntry::new(&e)).collect())
}

/// A folder that is being read, in a thread of its own: a disk of the network may take its time.
pub struct FolderReading(Receiver<Result<Vec<FolderEntry>, String>>);

impl FolderReading {
    /// Begins to read.
    pub fn start(folder: PathBuf) -> FolderReading {
        let (sender, receiver) = channel();
        let read = move || {
            let _ = sender.send(read_folder(&folder));
        };
        // Without a thread the sender is dropped, which is told as an error.
        let _ = std::thread::Builder::new()
            .name("read folder".into())
            .spawn(read);
        FolderReading(receiver)
    }

    /// The content, if it comes within `patience`.
    pub fn wait(&self, patience: Duration) -> Option<Result<Vec<FolderEntry>, String>> {
        match self.0.recv_timeout(patience) {
            Ok(content) => Some(content),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Err("no thread to read it".into())),
        }
    }
}

/// A number of bytes, in units of a thousand.
pub fn size_text(bytes: u64) -> String {
    let mut value = bytes as f64;
    let mut unit = "B";
    for next in ["kB", "MB", "GB", "TB"] {
        // What would be rounded to 1000 is one of the next.
        if value < 999.5 {
            break;
        }
        (value, unit) = (value / 1e3, next);
    }
    if unit == "B" || value >= 9.95 {
        format!("{value:.0} {unit}")
    } else {
        format!("{value:.1} {unit}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str, size: Option<u64>, seconds: u64) -> FolderEntry {
        FolderEntry {
            name: name.into(),
            key: name.to_lowercase(),
            sort_key: sort_key(name),
            path: name.into(),
            is_folder: size.is_none(),
            is_hidden: is_hidden(name, None),
            size,
            modified: Some(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds)),
        }
    }

    fn entries() -> Vec<FolderEntry> {
        vec![
            entry("b.obj", Some(10), 5),
            entry("A.GRF", Some(30), 3),
            entry("c.txt", Some(20), 4),
            entry("sub", None, 9),
            entry("Art", None, 1),
            entry(".hidden.obj", Some(1), 1),
        ]
    }

    fn names(options: ListOptions, typed: &str) -> Vec<String> {
        let entries = entries();
        let shown = options.shown(&entries, &["obj", "grf"], typed);
        shown.into_iter().map(|k| entries[k].name.clone()).collect()
    }

    fn sorted(column: SortColumn, is_descending: bool) -> ListOptions {
        ListOptions {
            order: SortOrder {
                column,
                is_descending,
            },
            ..ListOptions::default()
        }
    }

    #[test]
    fn folders_come_first_in_any_order() {
        let all = |column, down| names(sorted(column, down), "");
        assert_eq!(
            all(SortColumn::Name, false),
            ["Art", "sub", "A.GRF", "b.obj"]
        );
        assert_eq!(
            all(SortColumn::Name, true),
            ["sub", "Art", "b.obj", "A.GRF"]
        );
        assert_eq!(
            all(SortColumn::Size, false),
            ["Art", "sub", "b.obj", "A.GRF"]
        );
        assert_eq!(
            all(SortColumn::Modified, true),
            ["sub", "Art", "b.obj", "A.GRF"]
        );
    }

    #[test]
    fn numbers_are_sorted_by_value() {
        let mut names = ["part 10", "Part 9b", "part 9a", "part", "part 09 x"];
        names.sort_by_key(|name| sort_key(name));
        assert_eq!(
            names,
            ["part", "part 09 x", "part 9a", "Part 9b", "part 10"]
        );
    }

    #[test]
    fn a_second_click_turns_the_order_around() {
        let order = SortOrder::default().clicked(SortColumn::Size);
        assert_eq!(
            (order.column, order.is_descending),
            (SortColumn::Size, false)
        );
        assert!(order.clicked(SortColumn::Size).is_descending);
        assert!(
            !order
                .clicked(SortColumn::Size)
                .clicked(SortColumn::Name)
                .is_descending
        );
    }

    #[test]
    fn hidden_and_unknown_files_are_shown_on_demand() {
        let mut options = ListOptions {
            shows_all: true,
            ..ListOptions::default()
        };
        assert_eq!(
            names(options, ""),
            ["Art", "sub", "A.GRF", "b.obj", "c.txt"]
        );
        options.shows_hidden = true;
        assert_eq!(names(options, "")[2], ".hidden.obj");
        // Who types a dot means what is hidden.
        assert_eq!(names(ListOptions::default(), ".h"), [".hidden.obj"]);
    }

    #[test]
    fn what_is_typed_filters_whatever_its_case() {
        assert_eq!(names(ListOptions::default(), "a"), ["Art", "A.GRF"]);
        assert_eq!(names(ListOptions::default(), "zzz"), Vec::<String>::new());
    }

    #[test]
    fn a_folder_is_read_with_sizes_and_what_is_none_says_why() {
        let folder = std::env::temp_dir().join(format!("azulejo-list-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("sub")).unwrap();
        std::fs::write(folder.join("a.obj"), "12345").unwrap();
        let reading = FolderReading::start(folder.clone());
        let entries = reading.wait(Duration::from_secs(20)).unwrap().unwrap();
        let shown = ListOptions::default().shown(&entries, &[], "");
        let [sub, file] = [shown[0], shown[1]].map(|k| &entries[k]);
        assert!(sub.is_folder && sub.size.is_none());
        assert_eq!((file.size, &*file.name), (Some(5), "a.obj"));
        assert!(file.modified.is_some() && file.begins_with("A."));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(!read_folder(&folder).unwrap_err().is_empty());
    }

    #[test]
    fn sizes_are_told_in_two_or_three_digits() {
        let told = [0, 999, 1_000, 9_949, 9_951, 999_600, 3_400_000].map(size_text);
        assert_eq!(
            told,
            [
                "0 B", "999 B", "1.0 kB", "9.9 kB", "10 kB", "1.0 MB", "3.4 MB"
            ]
        );
    }
}
