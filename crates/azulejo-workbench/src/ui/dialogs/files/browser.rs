//! The state of azulejo's own file dialog: a folder, what is selected in it, and what is typed.
//!
//! It knows no window: every key and click is a method.

use super::listing::{FolderEntry, FolderReading, ListOptions, SortColumn};
use super::typed_path::{has_folders, is_folder, resolve};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Which files a dialog is for.
#[derive(Clone, Copy, Debug)]
pub struct BrowserTask {
    /// Whether a file is written, which need not exist.
    pub saves: bool,
    /// Whether several files may be chosen.
    pub many: bool,
    /// Extensions of the listed files; empty for all.
    pub extensions: &'static [&'static str],
}

/// Why the dialog does not do what was asked.
#[derive(Clone, Debug, PartialEq)]
pub enum BrowserProblem {
    /// There is no such file.
    NoFile(PathBuf),
    /// There is no such folder.
    NoFolder(PathBuf),
    /// A folder could not be created, with the system's reason.
    NotCreated(String),
}

/// What a click does to the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowClick {
    /// Selects nothing else.
    Only,
    /// Selects it too, or no longer.
    Toggle,
    /// Selects all from the last one to it.
    Range,
}

/// The state of the dialog.
pub struct FileBrowser {
    /// What it is for.
    pub task: BrowserTask,
    /// The displayed folder.
    pub folder: PathBuf,
    /// What the list shows.
    options: ListOptions,
    /// What `~` stands for.
    home: Option<PathBuf>,
    entries: Vec<FolderEntry>,
    /// The numbers of the listed entries.
    shown: Vec<usize>,
    /// The folder, while it is being read.
    reading: Option<FolderReading>,
    /// Why the folder cannot be read.
    pub unreadable: Option<String>,
    /// Why the last request failed.
    pub problem: Option<BrowserProblem>,
    /// The text of the name field.
    pub name: String,
    /// The name that the dialog proposed.
    proposed: String,
    /// The typed text that the list is filtered by. A name that was put into the field by a selection
    /// filters nothing.
    filter: String,
    /// The entry that arrow keys start from.
    cursor: Option<usize>,
    /// Where a range begins.
    anchor: Option<usize>,
    selected: BTreeSet<usize>,
    /// Whether Enter takes the selection of the list, not the name: the last one touched.
    takes_list: bool,
    /// What the cursor goes to once the folder is read: the folder that was left.
    came_from: Option<PathBuf>,
}

impl FileBrowser {
    /// Opens a dialog in `folder`, with a proposed name.
    pub fn new(task: BrowserTask, folder: PathBuf, name: String, options: ListOptions) -> Self {
        let home = directories::UserDirs::new().map(|dirs| dirs.home_dir().to_owned());
        FileBrowser {
            reading: Some(FolderReading::start(folder.clone())),
            task,
            folder,
            options,
            home,
            entries: Vec::new(),
            shown: Vec::new(),
            unreadable: None,
            problem: None,
            proposed: name.clone(),
            name,
            filter: String::new(),
            cursor: None,
            anchor: None,
            selected: BTreeSet::new(),
            takes_list: false,
            came_from: None,
        }
    }

    /// Takes the content of the folder, if it comes within `patience`; returns whether it is still
    /// being read.
    pub fn poll(&mut self, patience: Duration) -> bool {
        let Some(reading) = &self.reading else {
            return false;
        };
        let Some(content) = reading.wait(patience) else {
            return true;
        };
        self.reading = None;
        match content {
            Ok(entries) => self.entries = entries,
            Err(why) => self.unreadable = Some(why),
        }
        self.list();
        if let Some(left) = self.came_from.take() {
            let is_it = |&k: &usize| self.entries[k].path == left;
            self.cursor = self.shown.iter().copied().find(is_it);
            self.selected.extend(self.cursor);
            self.takes_list = self.cursor.is_some() && !self.task.saves;
        }
        false
    }

    /// Whether the folder is still being read.
    pub fn is_reading(&self) -> bool {
        self.reading.is_some()
    }

    /// What the list shows.
    pub fn options(&self) -> ListOptions {
        self.options
    }

    /// Changes what the list shows.
    pub fn set_options(&mut self, options: ListOptions) {
        if self.options != options {
            self.options = options;
            self.list();
        }
    }

    /// Sorts by a column, or the other way around.
    pub fn sort_by(&mut self, column: SortColumn) {
        let order = self.options.order.clicked(column);
        self.set_options(ListOptions {
            order,
            ..self.options
        });
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.shown.len()
    }

    /// The entry of a row.
    pub fn row(&self, row: usize) -> Option<&FolderEntry> {
        self.entries.get(*self.shown.get(row)?)
    }

    /// Whether a row is selected.
    pub fn is_selected(&self, row: usize) -> bool {
        self.shown
            .get(row)
            .is_some_and(|k| self.selected.contains(k))
    }

    /// The row of the cursor.
    pub fn cursor_row(&self) -> Option<usize> {
        let cursor = self.cursor?;
        self.shown.iter().position(|&k| k == cursor)
    }

    /// The number of selected files, if there are several.
    pub fn many_selected(&self) -> Option<usize> {
        let count = self.selected_files().count();
        (count > 1).then_some(count)
    }

    /// Whether there is anything to open or save.
    pub fn is_ready(&self) -> bool {
        !self.name.trim().is_empty() || (self.takes_list && self.cursor.is_some())
    }

    /// Displays another folder.
    pub fn enter(&mut self, folder: PathBuf) {
        self.folder = folder;
        self.refresh();
        self.problem = None;
        self.came_from = None;
        if !self.task.saves || has_folders(self.name.trim()) {
            self.name.clone_from(&self.proposed);
        }
    }

    /// Reads the folder again.
    pub fn refresh(&mut self) {
        self.reading = Some(FolderReading::start(self.folder.clone()));
        self.unreadable = None;
        self.entries.clear();
        self.shown.clear();
        self.filter.clear();
        self.select_none();
    }

    /// Displays the parent folder, with the cursor on the one that was left.
    pub fn enter_parent(&mut self) {
        if let Some(parent) = self.folder.parent() {
            let left = self.folder.clone();
            self.enter(parent.to_owned());
            self.came_from = Some(left);
        }
    }

    /// Reacts to a change of the name by typing: to open a file, it filters the list, and its best
    /// match is what Enter takes.
    pub fn typed(&mut self) {
        self.problem = None;
        self.select_none();
        if self.task.saves {
            return;
        }
        let text = self.name.trim();
        self.filter = if has_folders(text) {
            String::new()
        } else {
            text.to_owned()
        };
        self.list();
        if !self.filter.is_empty() {
            let begins = |&k: &usize| self.entries[k].begins_with(&self.filter);
            let best = self.shown.iter().copied().find(begins);
            self.cursor = best.or_else(|| self.shown.first().copied());
            self.anchor = self.cursor;
            self.selected.extend(self.cursor);
        }
    }

    /// Moves the cursor by a number of rows; `extends` the selection.
    pub fn step(&mut self, rows: isize, extends: bool) {
        let Some(last) = self.shown.len().checked_sub(1) else {
            return;
        };
        // Without a cursor it starts beside the list: a step leads to the first row or the last.
        let row = match self.cursor_row() {
            Some(row) => row.saturating_add_signed(rows),
            None if rows > 0 => rows.unsigned_abs() - 1,
            None => (last + 1).saturating_add_signed(rows),
        };
        let row = row.min(last);
        let how = if extends {
            RowClick::Range
        } else {
            RowClick::Only
        };
        self.click(row, how);
    }

    /// Selects a row.
    pub fn click(&mut self, row: usize, how: RowClick) {
        let Some(&entry) = self.shown.get(row) else {
            return;
        };
        self.problem = None;
        let how = if self.task.many { how } else { RowClick::Only };
        match how {
            RowClick::Only => {
                self.selected = BTreeSet::from([entry]);
                self.anchor = Some(entry);
            }
            RowClick::Toggle => {
                if !self.selected.remove(&entry) {
                    self.selected.insert(entry);
                }
                self.anchor = Some(entry);
            }
            RowClick::Range => {
                let anchor = self.anchor.unwrap_or(entry);
                let from = self.shown.iter().position(|&k| k == anchor).unwrap_or(row);
                let range = from.min(row)..=from.max(row);
                self.selected = self.shown[range].iter().copied().collect();
                self.anchor = Some(anchor);
            }
        }
        self.cursor = Some(entry);
        self.takes_list = true;
        self.take_name(entry);
    }

    /// Selects all files.
    pub fn select_all(&mut self) {
        if self.task.many {
            let files = self.shown.iter().copied();
            let files = files.filter(|&k| !self.entries[k].is_folder);
            self.selected = files.collect();
            self.cursor = self.selected.first().copied();
            self.takes_list = self.cursor.is_some();
            self.cursor.into_iter().for_each(|k| self.take_name(k));
        }
    }

    /// Opens or saves what is selected or typed, or enters a folder; returns the chosen files.
    pub fn accept(&mut self) -> Option<Vec<PathBuf>> {
        self.problem = None;
        if self.takes_list && self.cursor.is_some() {
            self.accept_list()
        } else {
            self.accept_name()
        }
    }

    /// Creates a folder and enters it.
    pub fn create_folder(&mut self, name: &str) {
        let path = resolve(&self.folder, self.home.as_deref(), name.trim());
        match std::fs::create_dir(&path) {
            Ok(()) => self.enter(path),
            Err(e) => self.problem = Some(BrowserProblem::NotCreated(e.to_string())),
        }
    }

    fn accept_list(&mut self) -> Option<Vec<PathBuf>> {
        if self.many_selected().is_some() {
            return Some(self.selected_files().map(Path::to_owned).collect());
        }
        let entry = self.entries.get(self.cursor?)?;
        let path = entry.path.clone();
        if entry.is_folder {
            self.enter(path);
            return None;
        }
        Some(vec![path])
    }

    fn accept_name(&mut self) -> Option<Vec<PathBuf>> {
        let text = self.name.trim();
        if text.is_empty() {
            return None;
        }
        let path = resolve(&self.folder, self.home.as_deref(), text);
        if path.is_dir() {
            self.name.clone_from(&self.proposed);
            self.enter(path);
            return None;
        }
        if is_folder(text) {
            self.problem = Some(BrowserProblem::NoFolder(path));
            return None;
        }
        let has_folder = path.parent().is_some_and(Path::is_dir);
        if path.exists() || (self.task.saves && has_folder) {
            return Some(vec![path]);
        }
        if !self.task.saves && self.cursor.is_some() {
            return self.accept_list();
        }
        let folder = path.parent().filter(|_| !has_folder).map(Path::to_owned);
        self.problem = Some(match folder {
            Some(folder) => BrowserProblem::NoFolder(folder),
            None => BrowserProblem::NoFile(path),
        });
        None
    }

    /// Puts the name of a selected entry into the name field. A folder is no name to save under.
    fn take_name(&mut self, entry: usize) {
        let entry = &self.entries[entry];
        if !self.task.saves || !entry.is_folder {
            self.name.clone_from(&entry.name);
        }
    }

    fn selected_files(&self) -> impl Iterator<Item = &Path> {
        let rows = self.shown.iter().filter(|k| self.selected.contains(k));
        let files = rows.map(|&k| &self.entries[k]).filter(|e| !e.is_folder);
        files.map(|e| &*e.path)
    }

    fn select_none(&mut self) {
        (self.cursor, self.anchor) = (None, None);
        self.selected.clear();
        self.takes_list = false;
    }

    /// Lists the entries anew. What is no longer listed is no longer selected.
    fn list(&mut self) {
        let extensions = self.task.extensions;
        self.shown = self.options.shown(&self.entries, extensions, &self.filter);
        let shown: BTreeSet<usize> = self.shown.iter().copied().collect();
        self.selected.retain(|k| shown.contains(k));
        self.cursor = self.cursor.filter(|k| shown.contains(k));
        self.takes_list &= self.cursor.is_some();
    }
}

#[cfg(test)]
mod tests;
