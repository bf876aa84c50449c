//! Loading files in other units than the document's.

use super::*;
use azulejo::scene::{Units, Up};

/// Writes the sample in other units.
fn write_in(folder: &TestFolder, name: &str, up: Up, metres: f64) -> PathBuf {
    let mut scene = sample().scene();
    scene.units.up = up;
    scene.units.metres_per_unit = Some(metres);
    let path = folder.path(name);
    azulejo::models::write(&scene, &path, &Progress::new()).unwrap();
    path
}

#[test]
fn what_is_done_while_a_file_is_read_gives_the_units() {
    let folder = TestFolder::new("late-units");
    let path = write_in(&folder, "cm.grf", Up::Z, 0.01);
    let add = |meanwhile: &[Command]| {
        let mut app = App::quiet();
        app.execute(Command::Add(vec![path.clone()]));
        meanwhile.iter().for_each(|c| app.execute(c.clone()));
        settle(&mut app);
        check_no_error(&app);
        app
    };
    let size = |app: &App, name: &str| {
        let item = app
            .document
            .objects
            .iter()
            .find(|i| i.name == name)
            .unwrap();
        item.bounds().size()
    };
    let alone = add(&[]);
    assert_eq!(alone.document.units.up, Up::Z);
    let meanwhile = add(&[
        Command::AddShape(crate::document::NewShapeKind::Cuboid),
        Command::Edit(
            Edit::SetUnits(Units {
                metres_per_unit: Some(1.0),
                ..Units::default()
            }),
            None,
        ),
    ]);
    assert_eq!(meanwhile.document.units.up, Up::Y);
    let (a, b) = (size(&alone, "ball"), size(&meanwhile, "ball"));
    assert!((0.01 * a - b).length() < 1e-9, "{a} {b}");
    let (a, b) = (size(&alone, "room/floor"), size(&meanwhile, "room/floor"));
    assert!((0.01 * a.z - b.y).abs() < 1e-9, "{a} {b}");
    let told = |text: &str| meanwhile.messages.iter().any(|m| m.text.contains(text));
    assert!(told("turned from Z up to Y up") && told("scaled from units of 0.01 m"));
    assert!(!alone.messages.iter().any(|m| m.text.contains("turned")));
    meanwhile.document.scene().validate().unwrap();
}

#[test]
fn units_of_what_joins_are_adapted() {
    let folder = TestFolder::new("units");
    let write = |name: &str, up: Up, metres: f64| write_in(&folder, name, up, metres);
    let (metres, inches) = (write("m.grf", Up::Y, 1.0), write("in.grf", Up::Z, 0.0254));
    let mut app = App::quiet();
    run(&mut app, Command::Open(vec![metres, inches]));
    check_no_error(&app);
    let (a, b) = (&app.document.objects[0], &app.document.objects[4]);
    assert_eq!(b.name, format!("in/{}", a.name));
    let (a, b) = (a.bounds(), b.bounds());
    assert!(
        (b.size().x - 0.0254 * a.size().x).abs() < 1e-9,
        "{a:?} {b:?}"
    );
    // What was up along z is now up along y.
    assert!(
        (b.size().y - 0.0254 * a.size().z).abs() < 1e-9,
        "{a:?} {b:?}"
    );
    assert!(app.messages.iter().any(|m| m.text.contains("in.grf")));
}

#[test]
fn adding_to_nothing_takes_the_units_of_the_file() {
    let mut app = App::quiet();
    run(&mut app, Command::Add(vec![example("cornell.grf")]));
    assert_eq!(app.document.units.metres_per_unit, Some(0.001));
    assert!(app.is_changed() && app.file.is_none());
}
