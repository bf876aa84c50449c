//! The task plane.

use crate::window::*;
use azulejo_workbench::app::App;
use azulejo_workbench::command::Command;
use azulejo_workbench::ui::PanelTab;
use egui::accesskit::Role;

#[test]
fn a_task_plane_is_added_judged_moved_and_removed() {
    let mut app = App::quiet();
    app.execute(Command::OpenExample(
        azulejo_workbench::document::Example::CornellBox,
    ));
    let mut window = window(app);
    click(&mut window, "Add");
    click_last(&mut window, "Task plane");
    assert_eq!(window.state().tab, PanelTab::Light);
    wait(&mut window);
    let plane = &window.state().app.task_plane;
    let first = plane.result.as_ref().expect("it is measured").number;
    for text in ["Minimum", "Mean", "Maximum", "Uniformity U0"] {
        assert!(says(&window, text), "{text}: {:#?}", labels(&window));
    }
    set(&mut window, "Height", 0.3);
    set(&mut window, "Points 1", 4.0);
    assert!(says(&window, "These figures are for another height"));
    // A spinner turns until it is done.
    find(&window, Role::Button, "Measure the plane").click();
    window.run_steps(3);
    wait(&mut window);
    let plane = &window.state().app.task_plane;
    let second = plane.result.as_ref().expect("it is measured");
    assert!(second.number != first && second.cells.len() == 4 * 12);
    assert_eq!(plane.settings.height, 0.3);
    check_no_error(&window);
    find(&window, Role::Button, "Remove the plane").click();
    window.run();
    assert!(!says(&window, "Uniformity U0"));
}
