//! The text of a script, read into steps.

use super::fields::{
    name, number, numbers, one_of, path, split, two_points, unless, variant, whole,
};
use super::selected::{material_named, selected_one};
use super::step::{ScriptStep, StepResult, command, commands};
use super::{bake, light, material, scene, solver, view};
use crate::app::App;
use crate::command::{Command, Selection};
use crate::document::{ItemId, MAX_POINTS, TaskPlaneSettings};
use std::path::PathBuf;

/// Parses a script.
///
/// # Errors
///
/// A message with the line, what was found and what was expected.
pub fn parse(text: &str, name: &str) -> Result<Vec<(usize, ScriptStep)>, String> {
    let mut steps = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let step = step(line).map_err(|e| format!("{name}:{}: {e}", k + 1))?;
        steps.push((k + 1, step));
    }
    Ok(steps)
}

fn step(line: &str) -> StepResult {
    let (word, rest) = split(line);
    let parsers = [scene::parse, view::parse, solver::parse, bake::parse];
    if let Some(step) = parsers.iter().find_map(|parse| parse(word, rest)) {
        return step;
    }
    let file = |make: fn(PathBuf) -> Command| Ok(command(make(path(word, rest)?)));
    match word {
        "size" => {
            let [w, h] = numbers(rest)?;
            if !(100.0..=16_384.0).contains(&w) || !(100.0..=16_384.0).contains(&h) {
                return Err(format!("a window of {w} × {h}, expected 100 to 16384"));
            }
            Ok(ScriptStep::Size(w as f32, h as f32))
        }
        "open" => file(|path| Command::Open(vec![path])),
        "add" => file(|path| Command::Add(vec![path])),
        "example" => Ok(command(Command::OpenExample(variant(word, rest)?))),
        "lab" => lab(rest),
        "lab-scene" => Ok(command(Command::OpenLesson)),
        "recipe" => file(Command::ApplyRecipe),
        "environment" => file(|path| Command::LoadEnvironment(path, None)),
        "action" => action(rest).map(ScriptStep::Action),
        "select" => Ok(select(rest)),
        "select-material" => {
            let name = name(word, rest)?;
            Ok(commands(move |app| {
                let material = Some(material_named(app, &name)?);
                let selection = app.selection.clone();
                Ok(vec![Command::Select(Selection {
                    material,
                    ..selection
                })])
            }))
        }
        "select-faces" => {
            let indices = indices(rest)?;
            Ok(commands(|app| {
                let faces = Some((selected_one(app)?, indices));
                let selection = app.selection.clone();
                Ok(vec![Command::Select(Selection { faces, ..selection })])
            }))
        }
        "material" => material::parse(rest),
        "light" => light::parse(rest),
        "tab" => variant(word, rest).map(ScriptStep::Tab),
        "probe" => two_points(rest).map(ScriptStep::Probe),
        "form-factors" => two_points(rest).map(ScriptStep::FormFactors),
        "compare-engines" => Ok(command(Command::CompareEngines)),
        "remove-probe" => {
            let number = whole(rest, u32::MAX)?;
            Ok(command(Command::RemoveProbe(u64::from(number))))
        }
        "save-probes" => file(Command::SaveProbes),
        "task-plane" => {
            let settings = task_plane(rest)?;
            Ok(commands(move |_| {
                let set = Command::SetTaskPlane(settings);
                Ok(vec![set, Command::MeasureTaskPlane])
            }))
        }
        "remove-task-plane" => Ok(command(Command::RemoveTaskPlane)),
        "save-task-plane" => file(Command::SaveTaskPlane),
        "render" | "picture" => whole(rest, 65_536).map(ScriptStep::Render),
        "stop-render" => Ok(command(Command::StopRender)),
        "resume-render" => Ok(command(Command::ResumeRender)),
        "close-render" => Ok(command(Command::CloseRender)),
        "save" => file(Command::SaveAs),
        "export" => file(Command::Export),
        "save-render" | "save-picture" => file(Command::SaveRender),
        "screenshot" => path(word, rest).map(ScriptStep::Screenshot),
        "preference" => {
            let (key, value) = split(rest);
            let (key, value) = (name(word, key)?, name(word, value)?);
            Ok(commands(move |app| {
                let preferences = app.preferences.with(&key, &value)?;
                Ok(vec![Command::SetPreferences(Box::new(preferences))])
            }))
        }
        "clear-messages" => Ok(command(Command::ClearMessages)),
        "wait" => Ok(ScriptStep::Wait(match rest {
            "" => None,
            seconds => Some(number(seconds)?.clamp(0.0, 3_600.0)),
        })),
        "quit" => Ok(ScriptStep::Quit),
        other => Err(format!("unknown step \"{other}\", expected one of {STEPS}")),
    }
}

/// The first words of all steps, in the order of the table in `docs/workbench/scripts.md`.
const STEPS: &str = "\
    size, open, add, example, lab, lab-scene, recipe, environment, save, export, save-render, screenshot, \
    action, select, select-material, select-faces, rename, move, turn, scale, place, cone, \
    text, prism, material, light, background, fog, units, shading, view, camera, fov, \
    take-view, look-through, exposure, range, color-map, logarithmic, isolines, backdrop, \
    show-in, compare, hide-backs, section, orientation-cube, tab, engine, patches, time, \
    bounces, keep-mesh, solve, probe, remove-probe, save-probes, task-plane, \
    save-task-plane, remove-task-plane, form-factors, compare-engines, render, stop-render, resume-render, \
    close-render, bake, lightmap, save-lightmap, save-error-map, preference, \
    clear-messages, wait, quit";

/// `lab N` or `lab none`: a lesson by its number, or no lab.
fn lab(text: &str) -> StepResult {
    let lesson = unless("none", text, |number| number.parse())?;
    Ok(command(Command::ShowLab(lesson)))
}

/// `select all`, `select nothing`, or everything of this name.
fn select(name: &str) -> ScriptStep {
    let name = name.to_owned();
    commands(move |app| {
        let select = match &*name {
            "all" => Command::SelectAll,
            "nothing" => Command::Select(Selection::default()),
            name => {
                let ids = items_named(app, name);
                if ids.is_empty() {
                    return Err(format!("nothing is named \"{name}\""));
                }
                let selection = Selection::default();
                Command::Select(Selection { ids, ..selection })
            }
        };
        Ok(vec![select])
    })
}

/// The objects, lights and cameras with this name, or with this last component of their name.
fn items_named(app: &App, name: &str) -> Vec<ItemId> {
    let document = &app.document;
    let objects = document.objects.iter().map(|i| (i.id, &i.name));
    let lights = document.lights.iter().map(|l| (l.id, &l.light.name));
    let cameras = document.cameras.iter().map(|c| (c.id, &c.camera.name));
    let is_named = |n: &str| n == name || n.rsplit('/').next() == Some(name);
    let items = objects.chain(lights).chain(cameras);
    let items = items.filter(|(_, n)| is_named(n));
    items.map(|(id, _)| id).collect()
}

fn task_plane(text: &str) -> Result<TaskPlaneSettings, String> {
    let [height, margin, x, y] = numbers(text)?;
    let whole = |n: f64| n.fract() == 0.0 && (1.0..=f64::from(MAX_POINTS)).contains(&n);
    if !whole(x) || !whole(y) {
        return Err(format!("{x} by {y} points, expected 1 to {MAX_POINTS}"));
    }
    Ok(TaskPlaneSettings {
        height,
        margin,
        counts: [x as u32, y as u32],
    })
}

fn indices(text: &str) -> Result<Vec<u32>, String> {
    let words = text.split_whitespace();
    let indices: Option<Vec<u32>> = words.map(|w| w.parse().ok()).collect();
    let indices = indices.filter(|indices| !indices.is_empty());
    indices.ok_or_else(|| format!("\"{text}\" is not a list of face indices"))
}

/// Former labels of actions, so that old scripts still run.
const FORMER_LABELS: [(&str, &str); 16] = [
    ("Save picture…", "Save image…"),
    ("Select nothing", "Select none"),
    ("Picture by rays", "Render image"),
    ("Normals and backs", "Normals and back faces"),
    ("Go on", "Resume"),
    ("Take the light off", "Discard solution"),
    ("Clear light", "Discard solution"),
    ("From the front", "Front view"),
    ("From behind", "Back view"),
    ("From the right", "Right view"),
    ("From the left", "Left view"),
    ("From above", "Top view"),
    ("From below", "Bottom view"),
    ("From the corner", "Corner view"),
    ("Picture of the surroundings…", "Environment map…"),
    ("Keys", "Keyboard shortcuts"),
];

/// Checks that an action exists; accepts former names.
fn action(name: &str) -> Result<String, String> {
    let known = crate::ui::actions::ACTIONS.iter().map(|a| a.label);
    let renamed = FORMER_LABELS.iter().find(|(former, _)| *former == name);
    let name = renamed.map_or(name, |(_, label)| *label);
    let labels: Vec<&str> = known.collect();
    one_of("action", name, &labels, str::to_owned).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Edit, Example};
    use crate::ui::PanelTab;
    use crate::view::Shading;
    use glam::DVec3;

    fn step(line: &str) -> ScriptStep {
        parse(line, "s.txt").unwrap().remove(0).1
    }

    /// The commands of a step in the state of `app`.
    fn made(app: &App, line: &str) -> Vec<Command> {
        match step(line) {
            ScriptStep::Commands(step) => step.make(app).unwrap(),
            _ => panic!("{line} is not a step that executes commands"),
        }
    }

    #[test]
    fn scripts_are_read() {
        let text = "# a remark\n\nopen a b.3ds\naction Area light\ntab light\nwait\nquit";
        let steps = parse(text, "s.txt").unwrap();
        assert_eq!(
            steps.iter().map(|s| s.0).collect::<Vec<_>>(),
            [3, 4, 5, 6, 7]
        );
        assert!(matches!(&steps[1].1, ScriptStep::Action(label) if label == "Area light"));
        assert!(matches!(steps[2].1, ScriptStep::Tab(PanelTab::Light)));
        assert!(matches!(steps[3].1, ScriptStep::Wait(None)));
        assert!(matches!(steps[4].1, ScriptStep::Quit));
    }

    #[test]
    fn steps_make_commands_of_the_state() {
        let mut app = App::quiet();
        app.execute(Command::OpenExample(Example::CornellBox));
        app.execute(Command::SelectAll);
        let by = DVec3::new(1.0, -2.0, 0.5);
        match &made(&app, "move 1 -2 0.5")[..] {
            [Command::Edit(Edit::Transform(ids, map), None)] => {
                assert_eq!((ids, map.translation), (&app.selection.ids, by));
            }
            _ => panic!("another command"),
        }
        match &made(&app, "solve 5%")[..] {
            [Command::SetLight(settings), Command::Solve] => assert_eq!(settings.error, 0.05),
            _ => panic!("other commands"),
        }
        match &made(&app, "shading false-color")[..] {
            [Command::SetView(view)] => assert_eq!(view.shading, Shading::FalseColor),
            _ => panic!("another command"),
        }
        match &made(&app, "open a b.3ds")[..] {
            [Command::Open(paths)] => assert_eq!(*paths, [PathBuf::from("a b.3ds")]),
            _ => panic!("another command"),
        }
    }

    #[test]
    fn former_names_still_work() {
        assert!(matches!(step("picture 8"), ScriptStep::Render(8)));
        let save = made(&App::quiet(), "save-picture a.png");
        assert!(matches!(&save[..], [Command::SaveRender(path)] if *path == *"a.png"));
        for (former, label) in FORMER_LABELS {
            let renamed = step(&format!("action {former}"));
            assert!(matches!(renamed, ScriptStep::Action(name) if name == label));
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (line, expected) in [
            ("dance", "unknown step \"dance\""),
            ("open", "open needs a file"),
            ("move 1 2", "\"1 2\" is not 3 numbers"),
            ("move 1 2 nan", "is not 3 numbers"),
            ("solve 5", "expected as in 5%"),
            ("action Fly", "no action \"Fly\""),
            ("shading pink", "no shading \"pink\""),
            ("patches 0", "is not a number from 1"),
            ("material wood", "expected new, use, rename, brdf"),
            ("material glass thick", "\"thick\" is not a number"),
            ("light up", "expected color, position"),
            ("light sky 17", "no sky \"17\""),
            ("light weather 1", "is not 2 or 4 numbers"),
            ("place 1 2 3 4", "is not 3, 6 or 9 numbers"),
            ("units 1 x watts", "expected y or z"),
            ("fog 1 1 1", "is not 4 numbers, nor \"none\""),
            ("exposure bright", "is not a number, nor \"auto\""),
            ("backdrop 1 2", "is not a colour"),
            ("backdrop 1 2 256", "is not a colour"),
            ("example teapot", "no example \"teapot\""),
            ("show-in candles", "no unit of light \"candles\""),
            ("compare pink", "no shading \"pink\""),
            ("compare flat 2", "expected 0 to 1"),
            ("orientation-cube", "expected on or off"),
            ("section w 0.5", "no axis \"w\""),
            ("section x 0.5 up", "expected flipped"),
            ("fov 0", "expected 1 to 170"),
            ("engine steam", "no engine \"steam\""),
            ("time 0", "expected 0.1"),
            ("bake size=8", "expected 16 to 8192"),
            ("bake error=5", "expected as in 5%"),
            ("bake light=red", "expected one of total, indirect, direct"),
            ("bake texels-per-metre=-1", "expected more than 0"),
            ("bake thoroughly", "expected size, texels-per-metre"),
            ("lightmap upside-down", "expected one of light, false-color"),
            ("save-lightmap", "save-lightmap needs a file"),
            ("select-faces one", "is not a list of face indices"),
            ("text 1 1 -", "text needs a name"),
            ("logarithmic yes", "expected on or off"),
            ("preference theme", "preference needs a name"),
            ("task-plane 1 0 2.5 2", "expected 1 to 256"),
            ("tab left", "no tab \"left\""),
            ("size 1 1", "expected 100 to 16384"),
            ("camera 1 2 3 1 2 3", "its own position"),
        ] {
            let error = parse(&format!("quit\n{line}"), "s.txt").err().unwrap();
            assert!(error.starts_with("s.txt:2: "), "{error}");
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn every_first_word_is_known_and_documented() {
        let page = include_str!("../../../../../docs/workbench/scripts.md");
        for word in STEPS.split(", ") {
            let error = parse(word, "s.txt").err().unwrap_or_default();
            assert!(!error.contains("unknown step"), "{word}: {error}");
            assert!(
                page.contains(&format!("`{word}")),
                "{word} is not documented"
            );
        }
    }
}
