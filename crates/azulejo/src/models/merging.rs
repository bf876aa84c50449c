//! Merging of models: units and names.

use azulejo_scene::{Scene, Units, Up};
use std::fmt;
use std::path::Path;

/// A change that [`Scene::adapted`] makes to a model whose units differ from the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Rotated to another up axis.
    Turned {
        /// Its former up axis.
        from: Up,
        /// Its new up axis.
        to: Up,
    },
    /// Scaled to another unit.
    Scaled {
        /// Its former unit in metres.
        from: f64,
        /// Its new unit in metres.
        to: f64,
    },
    /// The file specifies no unit; this one is assumed, in metres.
    UnitTaken(f64),
    /// The values of its lights are unchanged, but in other units.
    LightTaken {
        /// Whether the new units are photometric (lm, lx) or radiometric (W, W/m²).
        photometric: bool,
    },
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Change::Turned { from, to } => write!(f, "turned from {from:?} up to {to:?} up"),
            Change::Scaled { from, to } => {
                write!(f, "scaled from units of {from} m to units of {to} m")
            }
            Change::UnitTaken(unit) => write!(f, "no unit specified; {unit} m is taken"),
            Change::LightTaken { photometric } => {
                let say = |is: bool| if is { "photometric" } else { "radiometric" };
                let (from, to) = (say(!photometric), say(photometric));
                write!(
                    f,
                    "its light is {from} and is taken as {to}, with unchanged values"
                )
            }
        }
    }
}

/// The changes to a model in units `from` that is [adapted](Scene::adapted) to units `to`.
pub fn changes(from: Units, to: Units) -> Vec<Change> {
    let turned = (from.up != to.up).then_some(Change::Turned {
        from: from.up,
        to: to.up,
    });
    let unit = match (from.metres_per_unit, to.metres_per_unit) {
        (Some(a), Some(b)) if a != b => Some(Change::Scaled { from: a, to: b }),
        (None, Some(b)) => Some(Change::UnitTaken(b)),
        _ => None,
    };
    let light = (from.photometric != to.photometric).then_some(Change::LightTaken {
        photometric: to.photometric,
    });
    [turned, unit, light].into_iter().flatten().collect()
}

/// The name of a model's branch: its file name without extension, with a number if that is taken.
pub fn branch_name(path: &Path, is_taken: impl Fn(&str) -> bool) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let numbered = |n: u64| match n {
        1 => stem.clone().into_owned(),
        n => format!("{stem} {n}"),
    };
    let mut names = (1..).map(numbered);
    names.find(|name| !is_taken(name)).unwrap_or_default()
}

/// Moves all names to a branch: `table` becomes `branch/table`.
pub fn name_branch(scene: &mut Scene, branch: &str) {
    let under = |name: &mut String| {
        let path = if name.is_empty() {
            branch.to_owned()
        } else {
            format!("{branch}/{name}")
        };
        *name = path;
    };
    let Scene {
        objects,
        lights,
        cameras,
        ..
    } = scene;
    objects.iter_mut().for_each(|o| under(&mut o.name));
    lights.iter_mut().for_each(|l| under(&mut l.name));
    cameras.iter_mut().for_each(|c| under(&mut c.name));
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Object, synthetic::cube_room};

    fn check(from: Units, to: Units, expected: &[&str]) {
        let message: Vec<String> = changes(from, to).iter().map(Change::to_string).collect();
        assert_eq!(message, expected);
    }

    #[test]
    fn what_units_do_to_a_model() {
        let metres = Units {
            metres_per_unit: Some(1.0),
            up: Up::Y,
            photometric: false,
        };
        let other = Units {
            metres_per_unit: Some(0.01),
            up: Up::Z,
            photometric: true,
        };
        let silent = Units {
            metres_per_unit: None,
            ..metres
        };
        check(metres, metres, &[]);
        check(metres, silent, &[]);
        check(silent, metres, &["no unit specified; 1 m is taken"]);
        check(
            other,
            metres,
            &[
                "turned from Z up to Y up",
                "scaled from units of 0.01 m to units of 1 m",
                "its light is photometric and is taken as radiometric, with unchanged values",
            ],
        );
    }

    #[test]
    fn branches_are_named_by_their_files_and_told_apart() {
        let mut taken: Vec<String> = Vec::new();
        for expected in ["room", "room 2", "room 3"] {
            let name = branch_name(Path::new("/a/room.obj"), |n| taken.iter().any(|t| t == n));
            assert_eq!(name, expected);
            taken.push(name);
        }
        let mut room = cube_room();
        room.objects[0].name = "wall".into();
        room.objects.push(Object {
            name: String::new(),
            ..room.objects[0].clone()
        });
        name_branch(&mut room, "room 2");
        let names: Vec<&str> = room.objects.iter().map(|o| &*o.name).collect();
        assert_eq!(names, ["room 2/wall", "room 2"]);
    }
}
