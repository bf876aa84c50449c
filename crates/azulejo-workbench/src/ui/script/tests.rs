//! Scripts can do what the controls do: for every command and every edit there is a step.

use super::{ScriptPlayer, parse};
use crate::app::App;
use crate::document::tests::example;
use crate::ui::Workbench;
use azulejo::formats::brdf::text;
use azulejo::formats::picture::{hdr, png};
use azulejo::scene::Image;
use azulejo::scene::brdf::Description;
use egui_kittest::Harness;
use std::collections::BTreeSet;
use std::fmt::{self, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Commands without a step, and why they need none.
const WITHOUT_STEP: [(&str, &str); 16] = [
    ("KeepFaces", "the step `keep-mesh` says so before solving"),
    ("DismissFinerMesh", "closes a message"),
    ("DismissFailure", "closes a message, which fails the script"),
    (
        "SaveUnfinishedRender",
        "answers a question, which fails the script",
    ),
    ("SaveAnyway", "answers a question, which fails the script"),
    ("Discard", "answers a question, which fails the script"),
    (
        "CancelPending",
        "answers a question, which fails the script",
    ),
    ("Recover", "answers the question after a crash"),
    ("DeleteRecovery", "answers the question after a crash"),
    ("RequestFile", "opens a dialog; steps name their files"),
    ("DialogClosed", "closes a dialog"),
    ("Pause", "a step waits for the solver that it starts"),
    ("Resume", "a step waits for the solver that it starts"),
    ("StopSolving", "a step waits for the solver that it starts"),
    ("Cancel", "a step waits for the jobs that it starts"),
    (
        "ShowLightmap",
        "a tick in the window whose view the step `lightmap` chooses",
    ),
];

const MODEL: &str =
    "o plate\nv 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nusemtl tiles\nf 4 3 2 1\nf 1 2 3 4\n";

/// The steps of all scripts together send every command; `DIR` is a folder.
const SCRIPTS: [&str; 5] = [
    // Objects and materials.
    "open SHAPES\n add DIR/plate.obj\n select column\n rename pillar\n move 0 0.1 0\n\
     place 1 0 0 0 45 0 1 2 1\n action Duplicate\n action Hide\n action Show all\n action Delete\n\
     action Undo\n action Redo\n select all\n action Cone\n cone 0.5\n text 0.2 0.25 - hi\n\
     prism 0.5 1 6\n material new wood\n material mirror 0.5 0.5 0.5\n material glass 1.5 thin\n\
     material library brushed-steel\n\
     material rename pane\n material color 0.5 0.4 0.3\n material load DIR/ward.brdf\n\
     action Material\n select nothing\n select-material material\n action Delete\n select plate\n\
     select-faces 0 1\n material use pane\n action Remove unused materials\n\
     action Camera from this view\n take-view\n look-through\n clear-messages\n",
    // Light, views and files.
    "open SHAPES\n action Point light\n light position 0 1 0\n light color 2 1 1\n\
     action Spot light\n light cone 10 30\n light direction 0 -1 0\n\
     action Sun\n light sun 200 30\n light size 1\n action Sky\n light sky 3\n light level 100\n\
     light ground 0.3\n light sun 100 20\n light weather 600 150\n environment DIR/sun.hdr\n\
     light picture DIR/sun.hdr\n light rotation 90\n light extract-sun\n\
     background 1 1 1\n fog 0.5 0.5 0.5 40 exponential\n units 0.5 y watts\n recipe DIR/dark.toml\n\
     view front\n camera 0 1.5 8 0 1 0\n fov 60\n exposure 0.5\n range 0 10\n color-map viridis\n\
     logarithmic on\n isolines 4\n backdrop 10 20 30\n backdrop DIR/grey.png\n background tiled 2\n\
     engine rays\n patches 40\n time 20\n bounces 2\n tab light\n solve 90%\n\
     probe 0 1.5 3 0 1.4 0\n form-factors 0 1.5 3 0 1.4 0\n action Measure the probes\n\
     save-probes DIR/probes.csv\n remove-probe 1\n\
     task-plane 0.8 0 3 2\n save-task-plane DIR/plane.csv\n remove-task-plane\n action Task plane\n render 1\n stop-render\n resume-render\n save-render DIR/r.png\n close-render\n\
     show-in lumens\n compare false-color 0.3\n hide-backs on\n orientation-cube off\n section y 0.8 flipped\n\
     section none\n action Discard solution\n\
     export DIR/copy.obj\n save DIR/lit.grf\n action Save\n preference theme dark\n action New\n quit\n",
    // What belongs to an imported model.
    "example cornell-box\n open DIR/plate.obj\n action Studio\n recipe DIR/dark.toml\n action Forget recipes\n\
     save DIR/plate.grf\n action Quit\n",
    // Lightmaps.
    "open DIR/plate.obj\n action Studio\n bake size=32 error=100% light=direct\n lightmap error\n\
     save-lightmap DIR/baked.glb\n save-error-map DIR/error.exr\n lightmap none\n\
     save DIR/plate.grf\n action Quit\n",
    // The lab.
    "lab 1\n lab-scene\n form-factors 0 0.5 0 0 0 0\n compare-engines\n lab none\n quit\n",
];

/// A folder with the files that the scripts name; deleted at the end.
struct ScriptFolder(PathBuf);

impl ScriptFolder {
    fn new() -> ScriptFolder {
        let name = format!("azulejo-steps-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
        write("plate.obj", MODEL.as_bytes());
        write("dark.toml", b"[[material]]\nname = \"*\"\ndiffuse = 0.2\n");
        let ward: Description = "ward_duer kd=0.3 ks=0.1 ax=0.2 ay=0.2".parse().unwrap();
        let mut bytes = Vec::new();
        text::write(&ward, &mut bytes).unwrap();
        write("ward.brdf", &bytes);
        let mut sky = Image::opaque(512, 256, vec![[0.5; 3]; 512 * 256]);
        sky.pixels[100 * 512 + 300] = [40_000.0; 3];
        let mut bytes = Vec::new();
        hdr::write(&sky, &mut bytes).unwrap();
        write("sun.hdr", &bytes);
        let mut bytes = Vec::new();
        png::write(1, 1, &[128; 3], &mut bytes).unwrap();
        write("grey.png", &bytes);
        ScriptFolder(folder)
    }

    fn script(&self, text: &str) -> String {
        let shapes = example("shapes.grf");
        text.replace("DIR", &self.0.to_string_lossy())
            .replace("SHAPES", &shapes.to_string_lossy())
    }
}

impl Drop for ScriptFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Plays a script to its end; returns the names of the commands and edits that it sent.
fn play(text: &str) -> [BTreeSet<String>; 2] {
    let player = ScriptPlayer::new(parse(text, "s.txt").unwrap(), "s.txt");
    let outcome = player.outcome();
    let show = |ui: &mut egui::Ui, window: &mut Workbench| window.show(ui);
    let mut window = Harness::builder()
        .with_size([900.0, 700.0])
        .build_ui_state(show, Workbench::new(App::quiet()));
    window.state_mut().play(player);
    let begin = Instant::now();
    while outcome.lock().unwrap().is_none() {
        assert!(begin.elapsed() < Duration::from_secs(120), "no end: {text}");
        std::thread::sleep(Duration::from_millis(1));
        window.step();
    }
    assert_eq!(outcome.lock().unwrap().clone(), Some(Ok(())), "{text}");
    let (commands, edits) = &window.state().app.executed;
    [
        commands.iter().map(variant).collect(),
        edits.iter().map(variant).collect(),
    ]
}

/// The name of the variant of an enum's value.
fn variant(value: &impl fmt::Debug) -> String {
    /// Stops after the first word, as the rest may be a whole document.
    struct FirstWord(String);
    impl Write for FirstWord {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            let end = text.find(|c: char| !c.is_alphanumeric());
            self.0.push_str(&text[..end.unwrap_or(text.len())]);
            if end.is_some() {
                Err(fmt::Error)
            } else {
                Ok(())
            }
        }
    }
    let mut word = FirstWord(String::new());
    let _ = write!(word, "{value:?}");
    word.0
}

/// The variants of an enum by the lines that declare them.
fn variants(source: &str, name: &str) -> BTreeSet<String> {
    let body = source
        .split(&format!("pub enum {name} {{\n"))
        .nth(1)
        .unwrap();
    let body = body.split("\n}\n").next().unwrap();
    let lines = body.lines().filter_map(|line| line.strip_prefix("    "));
    let declared = lines.filter(|line| line.starts_with(|c: char| c.is_ascii_uppercase()));
    let end = |line: &str| {
        line.find(|c: char| !c.is_alphanumeric())
            .unwrap_or(line.len())
    };
    declared.map(|line| line[..end(line)].to_owned()).collect()
}

#[test]
fn every_command_and_every_edit_has_a_step() {
    let folder = ScriptFolder::new();
    let mut sent = [BTreeSet::new(), BTreeSet::new()];
    for script in SCRIPTS {
        let played = play(&folder.script(script));
        for (all, new) in sent.iter_mut().zip(played) {
            all.extend(new);
        }
    }
    let [mut commands, edits] = sent;
    commands.extend(WITHOUT_STEP.map(|(name, _)| name.to_owned()));
    let known = variants(include_str!("../../command.rs"), "Command");
    assert!(known.len() > 40, "{known:?}");
    let missing: Vec<_> = known.difference(&commands).collect();
    assert!(missing.is_empty(), "commands without a step: {missing:?}");
    let known = variants(include_str!("../../document/edit.rs"), "Edit");
    assert!(known.len() > 20, "{known:?}");
    let missing: Vec<_> = known.difference(&edits).collect();
    assert!(missing.is_empty(), "edits without a step: {missing:?}");
}

#[test]
fn exceptions_are_commands_and_have_a_reason() {
    let known = variants(include_str!("../../command.rs"), "Command");
    for (name, why) in WITHOUT_STEP {
        assert!(known.contains(name), "{name} is not a command");
        assert!(why.len() > 10, "{name}: {why}");
    }
}
