//! The commands that are run on scenes and changed scenes.

use super::scenes::SceneTraits;

/// What is read from the output of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Form factors between objects, or between faces.
    Factors {
        /// Whether rows are objects.
        by_object: bool,
    },
    /// Conductances between objects.
    Exchange,
    /// Balance of energy, and mean irradiance of objects.
    Solve,
    /// Irradiance at points.
    Probe,
    /// Mean irradiance of the texels of objects.
    Bake,
    /// Mean radiance of blocks of pixels.
    Render,
    /// Areas, and what is inside out.
    Info,
}

/// A command with its options.
#[derive(Clone, Debug)]
pub struct PosedCommand {
    /// Its name in tables and in `--pose`.
    pub name: String,
    /// Options, in addition to those of its measure.
    pub options: Vec<String>,
    /// What is read from its output.
    pub measure: Measure,
    /// Most faces of a scene that it is run on.
    most_faces: usize,
    /// Whether it knows exact shapes.
    takes_solids: bool,
    /// Whether both sides of each face count.
    is_two_sided: bool,
}

/// Formats that keep surfaces; that keep the names of objects, too; that keep matt surfaces and their light;
/// that keep mirrors; that keep all.
const SURFACES: &[&str] = &[
    "grf", "obj", "glb", "gltf", "ply", "sff", "vs3", "wrl", "x3d", "stl", "dxf",
];
const NAMED: &[&str] = &["grf", "obj", "glb", "gltf", "ply", "wrl", "x3d", "dxf"];
const LIGHT: &[&str] = &["grf", "obj", "glb", "gltf"];
const MIRRORS: &[&str] = &["grf", "obj"];
const ALL: &[&str] = &["grf"];

/// Engines of form factors: name, options, most faces, whether they know exact shapes.
const ENGINES: [(&str, &str, usize, bool); 5] = [
    ("auto", "", 24, false),
    ("rays", "--rays 1024", 150, true),
    ("hemicube", "--resolution 64 --gpu off", 60, false),
    ("hybrid", "--resolution 64 --gpu off --rays 1024", 60, false),
    ("analytic", "", 24, false),
];

/// Engines of the first pass.
const FIRST_PASSES: [(&str, &str, usize); 6] = [
    ("auto", "", 200),
    ("rays", "", 200),
    ("hemicube", "--resolution 32 --gpu off", 60),
    ("hybrid", "--resolution 32 --gpu off", 60),
    ("analytic", "", 24),
    ("particles", "", 200),
];

/// All commands.
pub fn commands() -> Vec<PosedCommand> {
    let mut commands = Vec::new();
    for (engine, options, most_faces, takes_solids) in ENGINES {
        for (by_object, is_two_sided) in [(false, false), (true, false), (true, true)] {
            let group = if by_object { "object" } else { "row" };
            let (words, sides) = if is_two_sided {
                (" two-sided", " --two-sided")
            } else {
                ("", "")
            };
            // By row the engine alone, otherwise as users have it.
            let formulas = match engine {
                "rays" | "hemicube" | "hybrid" if !by_object => "--formulas never",
                _ => "",
            };
            commands.push(PosedCommand {
                most_faces,
                // A solid stands on something: which of the two surfaces in one place a ray from inside meets has no
                // answer.
                takes_solids: takes_solids && by_object && !is_two_sided,
                is_two_sided,
                ..PosedCommand::new(
                    format!("form-factors {engine} by {group}{words}"),
                    &format!("--engine {engine} {options} {formulas}{sides}"),
                    Measure::Factors { by_object },
                )
            });
        }
    }
    for (engine, options, most_faces) in FIRST_PASSES {
        commands.push(PosedCommand {
            most_faces,
            takes_solids: !matches!(engine, "analytic" | "hemicube" | "hybrid"),
            ..PosedCommand::new(
                format!("solve {engine}"),
                &format!("--engine {engine} --rays 128 {options}"),
                Measure::Solve,
            )
        });
    }
    commands.extend([
        PosedCommand::new("exchange", "--engine rays --rays 1024", Measure::Exchange),
        PosedCommand::new("probe", "--rays 256", Measure::Probe),
        PosedCommand::new("bake", "--size 128 --rays 64", Measure::Bake),
        PosedCommand::new(
            "render",
            "--size 24x24 --spp 64 --rays 128",
            Measure::Render,
        ),
        PosedCommand::new(
            "render reference",
            "--size 16x16 --reference",
            Measure::Render,
        ),
        PosedCommand {
            // Every scene has a command.
            most_faces: usize::MAX,
            ..PosedCommand::new("info", "", Measure::Info)
        },
    ]);
    commands
}

impl PosedCommand {
    fn new(name: impl Into<String>, options: &str, measure: Measure) -> PosedCommand {
        PosedCommand {
            name: name.into(),
            options: options.split_whitespace().map(str::to_owned).collect(),
            measure,
            most_faces: 200,
            takes_solids: true,
            is_two_sided: false,
        }
    }

    /// Whether it is run on a scene.
    pub fn suits(&self, scene: SceneTraits) -> bool {
        let needs_light = !matches!(
            self.measure,
            Measure::Factors { .. } | Measure::Exchange | Measure::Info
        );
        scene.faces <= self.most_faces
            && (self.takes_solids || scene.is_polygonal)
            && (scene.is_lit || !needs_light)
            && (scene.is_apart || !self.is_two_sided)
    }

    /// Whether a change leaves what it computes as it is. Particles from outside start all around the scene, and
    /// hardly any meets it if something lies far away.
    pub fn suits_change(&self, change: &str, scene: SceneTraits) -> bool {
        change != "double" || !scene.has_lights || !self.name.contains("particles")
    }

    /// Formats that keep all of a scene that it needs.
    pub fn formats(&self, scene: SceneTraits) -> &'static [&'static str] {
        match self.measure {
            _ if !scene.is_polygonal => ALL,
            Measure::Info => SURFACES,
            Measure::Exchange => NAMED,
            _ if scene.is_specular => MIRRORS,
            Measure::Factors { by_object: true } => NAMED,
            Measure::Factors { by_object: false } => SURFACES,
            _ if scene.has_lights => ALL,
            _ => LIGHT,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::families;
    use super::*;

    /// Every command has scenes of the first family, and names say what is run.
    #[test]
    fn commands_have_scenes() {
        let scenes = &families(false)[0];
        let commands = commands();
        for command in &commands {
            let suited = scenes.iter().filter(|s| command.suits(s.traits())).count();
            assert!(suited > 1, "{}", command.name);
        }
        let mut names: Vec<&str> = commands.iter().map(|c| c.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), commands.len());
    }
}
