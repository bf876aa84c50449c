//! Which dialog opens, and what is done with its answer.

use super::*;
use crate::app::App;

fn context(app: &App) -> PanelContext<'_> {
    PanelContext {
        app,
        language: app.preferences.language,
        gesture: None,
        is_covered: false,
        commands: Vec::new(),
    }
}

fn chooser() -> FileChooser {
    FileChooser {
        native: NativeSupport::known(),
        ..FileChooser::default()
    }
}

/// A folder that is deleted at the end of the test.
struct ChosenFolder(PathBuf);

impl ChosenFolder {
    fn new(name: &str) -> ChosenFolder {
        let own = format!("azulejo-chosen-{name}-{}", std::process::id());
        let path = std::env::temp_dir().join(own);
        std::fs::create_dir_all(&path).unwrap();
        ChosenFolder(path)
    }
}

impl Drop for ChosenFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn the_desktops_dialog_opens_where_there_is_one() {
    let app = App::quiet();
    let open = |chooser: &FileChooser| chooser.open(FileRequest::Open, &context(&app));
    let FileDialogKind::NativeWanted(request) = open(&chooser()) else {
        panic!("it is known");
    };
    assert!(request.many && !request.saves);
    assert!(request.types[0].1.contains(&"OBJ".to_owned()));
    let none = FileChooser::default();
    assert!(matches!(open(&none), FileDialogKind::Typed(_)));
}

#[test]
fn a_path_is_typed_where_the_dialog_of_the_desktop_fails() {
    let app = App::quiet();
    let mut cx = context(&app);
    let mut chooser = chooser();
    let chosen = chooser.close(FileRequest::Open, FileAnswer::Failed, &mut cx);
    assert!(chosen.is_none() && cx.commands.is_empty());
    assert!(matches!(
        chooser.dialog,
        Some((FileRequest::Open, FileDialogKind::Typed(_)))
    ));
    assert!(!chooser.native.is_known(), "it is not tried again");
}

#[test]
fn a_dialog_of_the_desktop_that_is_cancelled_cancels_what_waits() {
    let app = App::quiet();
    let mut cx = context(&app);
    let mut chooser = chooser();
    let chosen = chooser.close(FileRequest::SaveAs, FileAnswer::Cancelled, &mut cx);
    assert!(chosen.is_none() && !chooser.is_open());
    assert_eq!(cx.commands, [Command::CancelPending]);
}

/// The desktop has asked about the name that it knows, but not about one with an extension.
#[test]
fn a_file_is_asked_about_once() {
    let folder = ChosenFolder::new("asked");
    let app = App::quiet();
    let mut cx = context(&app);
    let mut chooser = chooser();
    let path = folder.0.join("a.grf");
    std::fs::write(&path, "").unwrap();
    let mut close = |name: &str| {
        let answer = FileAnswer::Chosen(vec![folder.0.join(name)]);
        let chosen = chooser.close(FileRequest::SaveAs, answer, &mut cx);
        (
            chosen.map(|c| c.first),
            chooser.replacing.take().map(|r| r.1),
        )
    };
    assert_eq!(close("a.grf"), (Some(path.clone()), None));
    assert_eq!(close("a"), (None, Some(path.clone())));
    assert_eq!(close("b"), (Some(folder.0.join("b.grf")), None));
    // Nobody has asked about what was typed.
    let dialog = PathDialog::new(true, folder.0.clone(), "a.grf".into());
    chooser.dialog = Some((FileRequest::SaveAs, FileDialogKind::Typed(dialog)));
    let typed = FileAnswer::Chosen(vec![path.clone()]);
    let chosen = chooser.close(FileRequest::SaveAs, typed, &mut cx);
    assert!(chosen.is_none());
    assert_eq!(chooser.replacing.map(|r| r.1), Some(path));
}
