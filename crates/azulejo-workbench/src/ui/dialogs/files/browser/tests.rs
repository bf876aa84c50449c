//! The file dialog without a window.

use super::*;

/// A folder that is deleted at the end of the test.
struct BrowsedFolder(PathBuf);

impl Drop for BrowsedFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl BrowsedFolder {
    /// A folder with three models, a text and a folder with one more model.
    fn new(name: &str) -> BrowsedFolder {
        let own = format!("azulejo-browser-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(own);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(path.join("sub/deep")).unwrap();
        for file in ["car.obj", "cat.obj", "tree.obj", "notes.txt", "sub/in.obj"] {
            std::fs::write(path.join(file), file).unwrap();
        }
        BrowsedFolder(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn open(&self) -> FileBrowser {
        self.browser(false, "")
    }

    fn save(&self) -> FileBrowser {
        self.browser(true, "new.grf")
    }

    fn browser(&self, saves: bool, name: &str) -> FileBrowser {
        let task = BrowserTask {
            saves,
            many: !saves,
            extensions: &["obj", "grf"],
        };
        let options = ListOptions::default();
        let mut browser = FileBrowser::new(task, self.0.clone(), name.into(), options);
        read(&mut browser);
        browser
    }
}

/// Waits until the folder is read.
fn read(browser: &mut FileBrowser) {
    assert!(!browser.poll(Duration::from_secs(20)), "it takes too long");
}

fn write(browser: &mut FileBrowser, name: &str) {
    browser.name = name.into();
    browser.typed();
}

fn rows(browser: &FileBrowser) -> Vec<&str> {
    let rows = (0..browser.len()).filter_map(|row| browser.row(row));
    rows.map(|e| &*e.name).collect()
}

#[test]
fn typing_filters_and_enter_takes_the_best_match() {
    let folder = BrowsedFolder::new("typing");
    let mut browser = folder.open();
    assert_eq!(rows(&browser), ["sub", "car.obj", "cat.obj", "tree.obj"]);
    write(&mut browser, "T");
    assert_eq!(rows(&browser), ["cat.obj", "tree.obj"]);
    assert_eq!(browser.cursor_row(), Some(1), "its beginning matches");
    assert_eq!(browser.accept(), Some(vec![folder.path("tree.obj")]));
    write(&mut browser, "ca");
    browser.step(1, false);
    assert_eq!(browser.name, "cat.obj");
    assert_eq!(rows(&browser), ["car.obj", "cat.obj"], "it is no filter");
    assert_eq!(browser.accept(), Some(vec![folder.path("cat.obj")]));
}

#[test]
fn typed_paths_lead_to_files_and_folders() {
    let folder = BrowsedFolder::new("paths");
    let mut browser = folder.open();
    // It is not listed, but it exists.
    write(&mut browser, "notes.txt");
    assert_eq!(browser.accept(), Some(vec![folder.path("notes.txt")]));
    write(&mut browser, "sub/in.obj");
    assert_eq!(browser.accept(), Some(vec![folder.path("sub/in.obj")]));
    write(&mut browser, "sub/");
    assert_eq!(browser.accept(), None);
    read(&mut browser);
    assert_eq!(browser.folder, folder.path("sub"));
    assert_eq!((&*browser.name, rows(&browser).len()), ("", 2));
    write(&mut browser, &folder.path("car.obj").to_string_lossy());
    assert_eq!(browser.accept(), Some(vec![folder.path("car.obj")]));
    write(&mut browser, "..");
    assert_eq!(browser.accept(), None);
    assert_eq!(browser.folder, folder.0);
    browser.home = Some(folder.path("sub"));
    write(&mut browser, "~/in.obj");
    assert_eq!(browser.accept(), Some(vec![folder.path("sub/in.obj")]));
}

#[test]
fn what_does_not_exist_is_told() {
    let folder = BrowsedFolder::new("missing");
    let mut browser = folder.open();
    let mut problem = |text: &str| {
        write(&mut browser, text);
        assert_eq!(browser.accept(), None);
        browser.problem.clone()
    };
    let no_file = BrowserProblem::NoFile(folder.path("zebra.obj"));
    assert_eq!(problem("zebra.obj"), Some(no_file));
    let no_folder = BrowserProblem::NoFolder(folder.path("zoo"));
    assert_eq!(problem("zoo/zebra.obj"), Some(no_folder.clone()));
    assert_eq!(problem("zoo/"), Some(no_folder.clone()));
    assert_eq!(problem(""), None);
    let mut browser = folder.save();
    write(&mut browser, "zoo/zebra.grf");
    assert_eq!(browser.accept(), None);
    assert_eq!(browser.problem, Some(no_folder));
}

#[test]
fn saving_takes_the_name_wherever_one_goes() {
    let folder = BrowsedFolder::new("saving");
    let mut browser = folder.save();
    assert_eq!(browser.accept(), Some(vec![folder.path("new.grf")]));
    browser.step(1, false);
    assert_eq!(browser.name, "new.grf", "a folder is no name");
    assert_eq!(browser.accept(), None);
    read(&mut browser);
    assert_eq!(browser.accept(), Some(vec![folder.path("sub/new.grf")]));
    browser.step(-1, false);
    assert_eq!(browser.name, "in.obj");
    write(&mut browser, "other");
    assert_eq!(browser.accept(), Some(vec![folder.path("sub/other")]));
    browser.enter_parent();
    read(&mut browser);
    assert_eq!(browser.accept(), Some(vec![folder.path("other")]));
    write(&mut browser, "sub");
    assert_eq!(browser.accept(), None);
    assert_eq!(browser.folder, folder.path("sub"));
    assert_eq!(browser.name, "new.grf", "the proposed one again");
}

#[test]
fn arrows_enter_folders_and_come_back_to_them() {
    let folder = BrowsedFolder::new("arrows");
    let mut browser = folder.open();
    browser.step(-1, false);
    assert_eq!(browser.cursor_row(), Some(3));
    browser.step(-100, false);
    assert_eq!(browser.cursor_row(), Some(0));
    assert_eq!(browser.accept(), None);
    read(&mut browser);
    assert_eq!(browser.folder, folder.path("sub"));
    assert_eq!(browser.cursor_row(), None);
    browser.enter_parent();
    read(&mut browser);
    assert_eq!(browser.folder, folder.0);
    assert_eq!(browser.cursor_row(), Some(0), "on the folder that was left");
}

#[test]
fn several_files_are_chosen_and_folders_are_none_of_them() {
    let folder = BrowsedFolder::new("several");
    let mut browser = folder.open();
    browser.click(1, RowClick::Only);
    browser.click(3, RowClick::Toggle);
    let two = vec![folder.path("car.obj"), folder.path("tree.obj")];
    assert_eq!(browser.many_selected(), Some(2));
    assert_eq!(browser.accept(), Some(two));
    browser.click(1, RowClick::Only);
    browser.step(1, true);
    let two = vec![folder.path("car.obj"), folder.path("cat.obj")];
    assert_eq!(browser.accept(), Some(two));
    browser.select_all();
    assert_eq!(browser.accept().map(|all| all.len()), Some(3));
    let mut browser = folder.save();
    browser.click(1, RowClick::Only);
    browser.click(2, RowClick::Toggle);
    assert_eq!(browser.many_selected(), None, "one is saved");
}

#[test]
fn sorting_keeps_the_selection() {
    let folder = BrowsedFolder::new("sorting");
    let mut browser = folder.open();
    browser.click(1, RowClick::Only);
    browser.sort_by(SortColumn::Name);
    assert_eq!(rows(&browser), ["sub", "tree.obj", "cat.obj", "car.obj"]);
    assert_eq!(browser.cursor_row(), Some(3));
    assert!(browser.is_selected(3) && !browser.is_selected(1));
}

#[test]
fn a_new_folder_is_entered_and_one_that_cannot_be_is_told() {
    let folder = BrowsedFolder::new("new-folder");
    let mut browser = folder.save();
    browser.create_folder("made");
    read(&mut browser);
    assert_eq!(browser.folder, folder.path("made"));
    assert_eq!(browser.name, "new.grf");
    browser.create_folder("no/where");
    assert!(matches!(
        browser.problem,
        Some(BrowserProblem::NotCreated(_))
    ));
    std::fs::remove_dir(folder.path("made")).unwrap();
    browser.refresh();
    read(&mut browser);
    assert!(browser.unreadable.is_some());
}

#[test]
fn ten_thousand_files_are_filtered_in_no_time() {
    let folder = BrowsedFolder::new("many");
    for k in 0..10_000 {
        std::fs::write(folder.path(&format!("{k}.obj")), "").unwrap();
    }
    let mut browser = folder.open();
    assert_eq!(browser.len(), 10_004);
    let begin = std::time::Instant::now();
    write(&mut browser, "9999");
    assert_eq!(rows(&browser), ["9999.obj"]);
    write(&mut browser, "");
    // Some milliseconds, with room for a busy machine and code that is not optimized.
    assert!(begin.elapsed() < Duration::from_secs(1));
}
