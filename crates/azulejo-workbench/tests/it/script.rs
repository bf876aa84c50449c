//! Scripts run in a window.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::script::{ScriptPlayer, parse};
use std::time::{Duration, Instant};

/// Runs a script; returns its outcome and the window.
fn play(text: &str) -> (Result<(), String>, TestWindow) {
    play_in(App::quiet(), text)
}

fn play_in(app: App, text: &str) -> (Result<(), String>, TestWindow) {
    let steps = parse(text, "s.txt").unwrap();
    let player = ScriptPlayer::new(steps, "s.txt");
    let outcome = player.outcome();
    let mut window = window(app);
    window.state_mut().play(player);
    let begin = Instant::now();
    loop {
        window.step();
        if let Some(result) = outcome.lock().unwrap().clone() {
            return (result, window);
        }
        assert!(begin.elapsed() < PATIENCE, "the script does not end");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_session_plays_to_its_end() {
    let folder = TestFolder::new("script");
    let model = folder.copy("shapes.grf");
    let (lit, copy, picture) = (
        folder.path("lit.grf"),
        folder.path("copy.glb"),
        folder.path("p.png"),
    );
    let text = format!(
        "size 1000 700\n\
         open {}\n\
         action Area light\n\
         move 0 -0.1 0\n\
         rename lamp of mine\n\
         select column\n\
         turn 0 30 0\n\
         scale 0.9\n\
         material new wood\n\
         material brdf ward_duer ks=0.2 kd=0.4 ax=0.2 ay=0.2\n\
         select cone\n\
         material color 0.5 0.4 0.3\n\
         tab light\n\
         patches 60\n\
         solve 50%\n\
         shading false-color\n\
         view corner\n\
         picture 1\n\
         save-picture {}\n\
         save {}\n\
         export {}\n\
         wait\n\
         quit\n",
        model.display(),
        picture.display(),
        lit.display(),
        copy.display()
    );
    let (outcome, window) = play(&text);
    assert_eq!(outcome, Ok(()));
    let app = &window.state().app;
    assert!(app.closing && app.lighting.is_current && !app.is_changed());
    assert!(lit.exists() && copy.exists() && picture.exists());
    assert!(
        app.document
            .objects
            .iter()
            .any(|i| i.name == "lamp of mine")
    );
    assert!(app.document.materials.iter().any(|m| m.name == "wood"));
}

#[test]
fn an_action_waits_for_what_it_began_and_a_picture_for_its_paths() {
    let folder = TestFolder::new("script-waits");
    let lit = folder.path("lit.grf");
    let text = format!(
        "open {}\nsolve 50%\nsave {}\naction Solve\naction Save\npicture 3\nquit\n",
        folder.copy("shapes.grf").display(),
        lit.display()
    );
    let mut app = App::quiet();
    app.preferences.picture_samples = 1;
    let (outcome, window) = play_in(app, &text);
    assert_eq!(outcome, Ok(()));
    let app = &window.state().app;
    assert!(app.lighting.is_current && !app.is_changed());
    assert!(app.render.as_ref().is_some_and(|p| p.samples >= 3));
}

#[test]
fn a_step_that_fails_ends_the_script_with_its_line() {
    let shapes = example("shapes.grf");
    let open = format!("open {}\n", shapes.display());
    for (text, line, said) in [
        (
            "open /nowhere/a.grf\nquit\n".to_owned(),
            1,
            "/nowhere/a.grf",
        ),
        (
            format!("{open}\nselect nobody\nquit\n"),
            3,
            "nothing is named \"nobody\"",
        ),
        (format!("{open}move 1 0 0\n"), 2, "nothing is selected"),
        (
            format!("{open}material emit 1 1 1\n"),
            2,
            "no material is selected",
        ),
        (format!("{open}action Undo\n"), 2, "is not available now"),
        (format!("{open}select cone\nscale 0\n"), 3, "singular"),
        (
            format!("{open}select cone\nmaterial brdf no_such_model\n"),
            3,
            "no_such_model",
        ),
        (format!("{open}save /nowhere/a.grf\n"), 2, "/nowhere/a.grf"),
        (
            format!("{open}action Area light\n{open}"),
            3,
            "a question is open",
        ),
        (format!("{open}action Export…\n"), 2, "a dialog is open"),
        ("solve\n".to_owned(), 1, "there is no light source"),
    ] {
        let (outcome, _) = play(&text);
        let why = outcome.unwrap_err();
        assert!(why.starts_with(&format!("s.txt:{line}: ")), "{why}");
        assert!(why.contains(said), "{why}");
    }
}
