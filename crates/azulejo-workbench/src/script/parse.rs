//! Parsing scripts.

use crate::ui::PanelTab;
use crate::view::{Shading, ViewDirection};
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
    /// `action NAME`: a menu entry by its English name.
    Action(String),
    /// `select NAME`, `select all`, `select nothing`: all objects, lights and cameras with this
    /// name, or with this last component of their name.
    Select(String),
    /// `rename NAME`: renames the selection.
    Rename(String),
    /// `move X Y Z`, `scale F`, `turn X Y Z` in degrees: transforms the selection.
    Move(DVec3),
    /// See [`ScriptStep::Move`].
    Scale(f64),
    /// See [`ScriptStep::Move`].
    Turn(DVec3),
    /// `material new NAME`: adds a material and assigns it to the selection.
    MaterialNew(String),
    /// `material brdf DESCRIPTION`: sets the reflection model of the selected material.
    MaterialBrdf(String),
    /// `material color R G B`: makes the selected material diffuse with a linear colour.
    MaterialColor(DVec3),
    /// `material emit R G B`: sets the emission of the selected material, W/(sr·m²) or cd/m².
    MaterialEmit(DVec3),
    /// `shading NAME`, such as `irradiance` or `false-color`.
    Shading(Shading),
    /// `view front`, `back`, `left`, `right`, `top`, `bottom`, `corner`, `all`.
    View(Option<ViewDirection>),
    /// `camera EX EY EZ TX TY TZ`: sets the camera's position and target.
    Camera(DVec3, DVec3),
    /// `tab object`, `material`, `light`, `view`.
    Tab(PanelTab),
    /// `patches N`: sets the number of patches.
    Patches(u32),
    /// `solve` or `solve 5%`: solves the light, optionally to a given error.
    Solve(Option<f64>),
    /// `render N` or `picture N`: renders up to N paths per pixel.
    Render(u32),
    /// `save FILE`, `export FILE`, `save-render FILE` or `save-picture FILE`.
    Save(PathBuf),
    /// See [`ScriptStep::Save`].
    Export(PathBuf),
    /// See [`ScriptStep::Save`].
    SaveRender(PathBuf),
    /// `screenshot FILE`: writes the window as PNG.
    Screenshot(PathBuf),
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
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let path = || match rest {
        "" => Err(format!("{word} needs a file")),
        some => Ok(PathBuf::from(some)),
    };
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
        "action" => ScriptStep::Action(action(rest)?),
        "select" => ScriptStep::Select(rest.to_owned()),
        "rename" => ScriptStep::Rename(rest.to_owned()),
        "move" => ScriptStep::Move(vector(rest)?),
        "scale" => ScriptStep::Scale(numbers::<1>(rest)?[0]),
        "turn" => ScriptStep::Turn(vector(rest)?),
        "material" => material(rest)?,
        "shading" => ScriptStep::Shading(shading(rest)?),
        "view" => ScriptStep::View(side(rest)?),
        "camera" => {
            let [a, b, c, d, e, f] = numbers(rest)?;
            let (eye, target) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
            if eye.distance(target).is_nan() || eye.distance(target) <= 0.0 {
                return Err("the target of the camera is its own position".into());
            }
            ScriptStep::Camera(eye, target)
        }
        "tab" => ScriptStep::Tab(tab(rest)?),
        "patches" => ScriptStep::Patches(whole(rest, 10_000_000)?),
        "solve" => ScriptStep::Solve(error(rest)?),
        "render" | "picture" => ScriptStep::Render(whole(rest, 65_536)?),
        "save" => ScriptStep::Save(path()?),
        "export" => ScriptStep::Export(path()?),
        "save-render" | "save-picture" => ScriptStep::SaveRender(path()?),
        "screenshot" => ScriptStep::Screenshot(path()?),
        "wait" => ScriptStep::Wait(match rest {
            "" => None,
            some => Some(numbers::<1>(some)?[0].clamp(0.0, 3_600.0)),
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

const STEPS: [&str; 23] = [
    "size",
    "open",
    "add",
    "action",
    "select",
    "rename",
    "move",
    "scale",
    "turn",
    "material",
    "shading",
    "view",
    "camera",
    "tab",
    "patches",
    "solve",
    "render",
    "save",
    "export",
    "save-render",
    "screenshot",
    "wait",
    "quit",
];

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let wrong = || format!("\"{text}\" is not {N} numbers");
    let parsed: Option<Vec<f64>> = words
        .iter()
        .map(|w| w.parse().ok().filter(|x: &f64| x.is_finite()))
        .collect();
    parsed.and_then(|v| v.try_into().ok()).ok_or_else(wrong)
}

fn vector(text: &str) -> Result<DVec3, String> {
    numbers::<3>(text).map(DVec3::from)
}

fn whole(text: &str, most: u32) -> Result<u32, String> {
    let n: Option<u32> = text.parse().ok();
    n.filter(|n| (1..=most).contains(n))
        .ok_or_else(|| format!("\"{text}\" is not a number from 1 to {most}"))
}

fn error(text: &str) -> Result<Option<f64>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    let value = text.strip_suffix('%').and_then(|t| t.trim().parse().ok());
    let valid = value.filter(|p: &f64| (0.01..=100.0).contains(p));
    valid
        .map(|p| Some(p / 100.0))
        .ok_or_else(|| format!("\"{text}\" is not an error, expected as in 5%"))
}

/// Former labels of actions, so that old scripts still run.
const FORMER_LABELS: [(&str, &str); 7] = [
    ("Save picture…", "Save image…"),
    ("Select nothing", "Select none"),
    ("Picture by rays", "Render image"),
    ("Normals and backs", "Normals and back faces"),
    ("Go on", "Resume"),
    ("Take the light off", "Clear light"),
    ("Keys", "Keyboard shortcuts"),
];

/// Checks that an action exists; accepts former names.
fn action(name: &str) -> Result<String, String> {
    let known = crate::ui::actions::ACTIONS.iter().map(|a| a.label);
    let renamed = FORMER_LABELS.iter().find(|(former, _)| *former == name);
    let name = renamed.map_or(name, |(_, label)| *label);
    if known.clone().any(|label| label == name) {
        Ok(name.to_owned())
    } else {
        let all: Vec<&str> = known.collect();
        Err(format!(
            "no action \"{name}\", expected one of {}",
            all.join(", ")
        ))
    }
}

fn material(text: &str) -> Result<ScriptStep, String> {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    match word {
        "new" => Ok(ScriptStep::MaterialNew(rest.trim().to_owned())),
        "brdf" => Ok(ScriptStep::MaterialBrdf(rest.trim().to_owned())),
        "color" => Ok(ScriptStep::MaterialColor(vector(rest)?)),
        "emit" => Ok(ScriptStep::MaterialEmit(vector(rest)?)),
        other => Err(format!(
            "material \"{other}\", expected new, brdf, color or emit"
        )),
    }
}

fn shading(text: &str) -> Result<Shading, String> {
    let found = Shading::ALL.into_iter().find(|s| s.word() == text);
    found.ok_or_else(|| {
        let all: Vec<&str> = Shading::ALL.into_iter().map(Shading::word).collect();
        format!("no shading \"{text}\", expected one of {}", all.join(", "))
    })
}

fn side(text: &str) -> Result<Option<ViewDirection>, String> {
    Ok(Some(match text {
        "front" => ViewDirection::Front,
        "back" => ViewDirection::Back,
        "left" => ViewDirection::Left,
        "right" => ViewDirection::Right,
        "top" => ViewDirection::Top,
        "bottom" => ViewDirection::Bottom,
        "corner" => ViewDirection::Corner,
        "all" => return Ok(None),
        other => {
            return Err(format!(
                "no view \"{other}\", expected front, back, left, right, top, bottom, corner, all"
            ));
        }
    }))
}

fn tab(text: &str) -> Result<PanelTab, String> {
    let found = PanelTab::ALL
        .into_iter()
        .find(|t| format!("{t:?}").to_ascii_lowercase() == text);
    found.ok_or_else(|| format!("no tab \"{text}\", expected object, material, light or view"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_read() {
        let text = "# a remark\n\nopen a b.3ds\naction Area light\nsolve 5%\nmove 1 -2 0.5\n\
                    material brdf ward_duer ks=0.3\nshading false-color\ntab light\nwait\nquit";
        let steps = parse(text, "s.txt").unwrap();
        let expected = [
            ScriptStep::Open("a b.3ds".into()),
            ScriptStep::Action("Area light".into()),
            ScriptStep::Solve(Some(0.05)),
            ScriptStep::Move(DVec3::new(1.0, -2.0, 0.5)),
            ScriptStep::MaterialBrdf("ward_duer ks=0.3".into()),
            ScriptStep::Shading(Shading::FalseColor),
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
        for (line, said) in [
            ("dance", "unknown step \"dance\""),
            ("open", "open needs a file"),
            ("move 1 2", "\"1 2\" is not 3 numbers"),
            ("move 1 2 nan", "is not 3 numbers"),
            ("solve 5", "expected as in 5%"),
            ("action Fly", "no action \"Fly\""),
            ("shading pink", "no shading \"pink\""),
            ("patches 0", "is not a number from 1"),
            ("material wood", "expected new, brdf, color or emit"),
            ("tab left", "no tab \"left\""),
            ("size 1 1", "expected 100 to 16384"),
            ("camera 1 2 3 1 2 3", "its own position"),
        ] {
            let error = parse(&format!("quit\n{line}"), "s.txt").unwrap_err();
            assert!(error.starts_with("s.txt:2: "), "{error}");
            assert!(error.contains(said), "{error}");
        }
    }
}
