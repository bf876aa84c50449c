//! The steps of a script, and how they are written.

use super::bake::{self, BakeStep};
use super::fields::{name, number, numbers, one_of, path, split, two_points, whole};
use super::light::{self, LightStep};
use super::material::{self, MaterialStep};
use super::scene::{self, SceneStep};
use super::solver::{self, SolverStep};
use super::view::{self, ViewStep};
use crate::app::{Example, MAX_POINTS, TaskPlaneSettings};
use crate::ui::PanelTab;
use glam::DVec3;
use std::path::PathBuf;

/// One step of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum ScriptStep {
    /// `size W H`: size of the window in points.
    Size(f32, f32),
    /// `open FILE`, `add FILE`: one file each.
    Open(PathBuf),
    /// See [`ScriptStep::Open`].
    Add(PathBuf),
    /// `example NAME`: opens an example.
    Example(Example),
    /// `recipe FILE`: applies a recipe.
    Recipe(PathBuf),
    /// `environment FILE`: adds a picture of the surroundings.
    Environment(PathBuf),
    /// `action NAME`: a menu entry by its English name.
    Action(String),
    /// `select NAME`, `select all`, `select nothing`: all objects, lights and cameras with this
    /// name, or with this last component of their name.
    Select(String),
    /// `select-material NAME`.
    SelectMaterial(String),
    /// `select-faces K ...`: faces of the selected mesh by their indices.
    SelectFaces(Vec<u32>),
    /// An edit of the scene and its objects.
    Scene(SceneStep),
    /// `material ...`: changes the selected material.
    Material(MaterialStep),
    /// `light ...`: changes the selected light.
    Light(LightStep),
    /// A change of the view.
    View(ViewStep),
    /// `tab object`, `material`, `light`, `view`.
    Tab(PanelTab),
    /// Sets or starts the solver.
    Solver(SolverStep),
    /// Bakes a lightmap, saves or shows it.
    Bake(BakeStep),
    /// `probe EX EY EZ TX TY TZ`: pins a probe where the ray from one point toward another first
    /// meets a surface.
    Probe(DVec3, DVec3),
    /// `form-factors EX EY EZ TX TY TZ`: computes the form factors of the patch there.
    FormFactors(DVec3, DVec3),
    /// `remove-probe N`.
    RemoveProbe(u32),
    /// `save-probes FILE`: writes the table of probes as CSV.
    SaveProbes(PathBuf),
    /// `task-plane HEIGHT MARGIN NX NY`: measures a task plane, metres.
    TaskPlane(TaskPlaneSettings),
    /// `remove-task-plane`.
    RemoveTaskPlane,
    /// `save-task-plane FILE`: writes its points as CSV.
    SaveTaskPlane(PathBuf),
    /// `render N` or `picture N`: renders up to N paths per pixel.
    Render(u32),
    /// `stop-render`: stops rendering and keeps the image.
    StopRender,
    /// `resume-render`: continues to render it.
    ResumeRender,
    /// `close-render`: closes the rendered image.
    CloseRender,
    /// `save FILE`, `export FILE`, `save-render FILE` or `save-picture FILE`.
    Save(PathBuf),
    /// See [`ScriptStep::Save`].
    Export(PathBuf),
    /// See [`ScriptStep::Save`].
    SaveRender(PathBuf),
    /// `screenshot FILE`: writes the window as PNG.
    Screenshot(PathBuf),
    /// `preference KEY VALUE`: sets a preference by its key in `workbench.toml`.
    Preference(String, String),
    /// `clear-messages`: clears the message list.
    ClearMessages,
    /// `wait SECONDS`, or `wait` until only a render is running.
    Wait(Option<f64>),
    /// `quit`: closes the window.
    Quit,
}

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

fn step(line: &str) -> Result<ScriptStep, String> {
    let (word, rest) = split(line);
    if let Some(step) = scene::parse(word, rest) {
        return step.map(ScriptStep::Scene);
    }
    if let Some(step) = view::parse(word, rest) {
        return step.map(ScriptStep::View);
    }
    if let Some(step) = solver::parse(word, rest) {
        return step.map(ScriptStep::Solver);
    }
    if let Some(step) = bake::parse(word, rest) {
        return step.map(ScriptStep::Bake);
    }
    let path = || path(word, rest);
    Ok(match word {
        "size" => {
            let [w, h] = numbers(rest)?;
            if !(100.0..=16_384.0).contains(&w) || !(100.0..=16_384.0).contains(&h) {
                return Err(format!("a window of {w} × {h}, expected 100 to 16384"));
            }
            ScriptStep::Size(w as f32, h as f32)
        }
        "open" => ScriptStep::Open(path()?),
        "add" => ScriptStep::Add(path()?),
        "example" => {
            let name = |example: Example| example.script_name().to_owned();
            ScriptStep::Example(one_of("example", rest, &Example::ALL, name)?)
        }
        "recipe" => ScriptStep::Recipe(path()?),
        "environment" => ScriptStep::Environment(path()?),
        "action" => ScriptStep::Action(action(rest)?),
        "select" => ScriptStep::Select(rest.to_owned()),
        "select-material" => ScriptStep::SelectMaterial(name(word, rest)?),
        "select-faces" => ScriptStep::SelectFaces(indices(rest)?),
        "material" => ScriptStep::Material(material::parse(rest)?),
        "light" => ScriptStep::Light(light::parse(rest)?),
        "tab" => {
            let name = |tab: PanelTab| format!("{tab:?}").to_ascii_lowercase();
            ScriptStep::Tab(one_of("tab", rest, &PanelTab::ALL, name)?)
        }
        "probe" => two_points(rest).map(|[from, to]| ScriptStep::Probe(from, to))?,
        "form-factors" => two_points(rest).map(|[from, to]| ScriptStep::FormFactors(from, to))?,
        "remove-probe" => ScriptStep::RemoveProbe(whole(rest, u32::MAX)?),
        "save-probes" => ScriptStep::SaveProbes(path()?),
        "task-plane" => ScriptStep::TaskPlane(task_plane(rest)?),
        "remove-task-plane" => ScriptStep::RemoveTaskPlane,
        "save-task-plane" => ScriptStep::SaveTaskPlane(path()?),
        "render" | "picture" => ScriptStep::Render(whole(rest, 65_536)?),
        "stop-render" => ScriptStep::StopRender,
        "resume-render" => ScriptStep::ResumeRender,
        "close-render" => ScriptStep::CloseRender,
        "save" => ScriptStep::Save(path()?),
        "export" => ScriptStep::Export(path()?),
        "save-render" | "save-picture" => ScriptStep::SaveRender(path()?),
        "screenshot" => ScriptStep::Screenshot(path()?),
        "preference" => {
            let (key, value) = split(rest);
            ScriptStep::Preference(name(word, key)?, name(word, value)?)
        }
        "clear-messages" => ScriptStep::ClearMessages,
        "wait" => ScriptStep::Wait(match rest {
            "" => None,
            some => Some(number(some)?.clamp(0.0, 3_600.0)),
        }),
        "quit" => ScriptStep::Quit,
        other => {
            return Err(format!(
                "unknown step \"{other}\", expected one of {}",
                STEPS.join(", ")
            ));
        }
    })
}

/// The first words of all steps, in the order of the table in `docs/workbench/scripts.md`.
pub(super) const STEPS: [&str; 70] = [
    "size",
    "open",
    "add",
    "example",
    "recipe",
    "environment",
    "save",
    "export",
    "save-render",
    "screenshot",
    "action",
    "select",
    "select-material",
    "select-faces",
    "rename",
    "move",
    "turn",
    "scale",
    "place",
    "cone",
    "text",
    "prism",
    "material",
    "light",
    "background",
    "fog",
    "units",
    "shading",
    "view",
    "camera",
    "fov",
    "take-view",
    "look-through",
    "exposure",
    "range",
    "color-map",
    "logarithmic",
    "isolines",
    "backdrop",
    "show-in",
    "compare",
    "hide-backs",
    "section",
    "orientation-cube",
    "tab",
    "engine",
    "patches",
    "time",
    "bounces",
    "keep-mesh",
    "solve",
    "probe",
    "remove-probe",
    "save-probes",
    "task-plane",
    "save-task-plane",
    "remove-task-plane",
    "form-factors",
    "render",
    "stop-render",
    "resume-render",
    "close-render",
    "bake",
    "lightmap",
    "save-lightmap",
    "save-error-map",
    "preference",
    "clear-messages",
    "wait",
    "quit",
];

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
    let all: Option<Vec<u32>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    let some = all.filter(|v| !v.is_empty());
    some.ok_or_else(|| format!("\"{text}\" are no indices of faces"))
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
    use crate::view::Shading;

    #[test]
    fn scripts_are_read() {
        let text = "# a remark\n\nopen a b.3ds\naction Area light\nsolve 5%\nmove 1 -2 0.5\n\
                    material brdf ward_duer ks=0.3\nshading false-color\ntab light\nwait\nquit";
        let steps = parse(text, "s.txt").unwrap();
        let expected = [
            ScriptStep::Open("a b.3ds".into()),
            ScriptStep::Action("Area light".into()),
            ScriptStep::Solver(SolverStep::Solve(Some(0.05))),
            ScriptStep::Scene(SceneStep::Move(DVec3::new(1.0, -2.0, 0.5))),
            ScriptStep::Material(MaterialStep::Brdf("ward_duer ks=0.3".into())),
            ScriptStep::View(ViewStep::Shading(Shading::FalseColor)),
            ScriptStep::Tab(PanelTab::Light),
            ScriptStep::Wait(None),
            ScriptStep::Quit,
        ];
        assert!(steps.iter().map(|(_, s)| s).eq(&expected), "{steps:?}");
        assert_eq!(steps[0].0, 3);
    }

    #[test]
    fn former_names_still_work() {
        let step = |line: &str| parse(line, "s.txt").unwrap().remove(0).1;
        assert_eq!(step("picture 8"), step("render 8"));
        assert_eq!(step("save-picture a.png"), step("save-render a.png"));
        for (former, label) in FORMER_LABELS {
            let now = ScriptStep::Action(label.to_owned());
            assert_eq!(step(&format!("action {former}")), now);
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
            ("bake light=red", "expected total, indirect, direct"),
            ("bake texels-per-metre=-1", "expected more than 0"),
            ("bake thoroughly", "expected size, texels-per-metre"),
            ("lightmap upside-down", "expected light, false-color"),
            ("save-lightmap", "save-lightmap needs a file"),
            ("select-faces one", "are no indices"),
            ("text 1 1 -", "text needs a name"),
            ("logarithmic yes", "expected on or off"),
            ("preference theme", "preference needs a name"),
            ("task-plane 1 0 2.5 2", "expected 1 to 256"),
            ("tab left", "no tab \"left\""),
            ("size 1 1", "expected 100 to 16384"),
            ("camera 1 2 3 1 2 3", "its own position"),
        ] {
            let error = parse(&format!("quit\n{line}"), "s.txt").unwrap_err();
            assert!(error.starts_with("s.txt:2: "), "{error}");
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn every_first_word_is_known_and_documented() {
        let page = include_str!("../../../../docs/workbench/scripts.md");
        for word in STEPS {
            let error = parse(word, "s.txt").err().unwrap_or_default();
            assert!(!error.contains("unknown step"), "{word}: {error}");
            assert!(
                page.contains(&format!("`{word}")),
                "{word} is not documented"
            );
        }
    }
}
