//! Groups of rows by what they are pieces of, and the names of these groups.

use super::matrix::FormFactors;
use crate::patch::FaceId;
use azulejo_scene::{MaterialId, Scene};
use std::collections::HashMap;

/// What rows of one group have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroupBy {
    /// The face of an object.
    Face,
    /// The object.
    Object,
    /// The material.
    Material,
}

/// A group for each row, as [`FormFactors::grouped`] takes them, and a name for each group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedGroups {
    /// The group of each row.
    pub of_rows: Vec<Option<u32>>,
    /// The name of each group, no two alike.
    pub names: Vec<String>,
}

impl NamedGroups {
    /// The groups of all rows of a matrix of `scene`, numbered by first appearance. Back sides are
    /// separate groups.
    pub fn new(scene: &Scene, factors: &FormFactors, by: GroupBy) -> NamedGroups {
        let object = |i: usize| factors.faces[i].object;
        let name = |i: usize| match by {
            GroupBy::Face => face_name(scene, factors.faces[i]),
            GroupBy::Object => object_name(scene, object(i)),
            GroupBy::Material => material_name(scene, factors.materials[i]),
        };
        let key = |i: usize| match by {
            GroupBy::Face => (object(i), factors.faces[i].face),
            GroupBy::Object => (object(i), 0),
            GroupBy::Material => (factors.materials[i], 0),
        };
        let (mut numbers, mut names) = (HashMap::new(), Vec::new());
        let of_rows = (0..factors.len())
            .map(|i| {
                let is_back = factors.is_back[i];
                let number = numbers.entry((key(i), is_back)).or_insert_with(|| {
                    names.push(name(i) + if is_back { " (back)" } else { "" });
                    names.len() as u32 - 1
                });
                Some(*number)
            })
            .collect();
        NamedGroups {
            of_rows,
            names: unique_names(names),
        }
    }
}

/// Makes names unique by appending their numbers to those that occur several times.
pub fn unique_names(names: Vec<String>) -> Vec<String> {
    let mut uses: HashMap<&str, usize> = HashMap::new();
    for name in &names {
        *uses.entry(name).or_default() += 1;
    }
    let is_shared: Vec<bool> = names.iter().map(|n| uses[n.as_str()] > 1).collect();
    let rows = names.into_iter().zip(is_shared).enumerate();
    rows.map(|(i, (name, is_shared))| {
        if is_shared {
            format!("{name} #{i}")
        } else {
            name
        }
    })
    .collect()
}

fn object_name(scene: &Scene, object: u32) -> String {
    match scene.objects[object as usize].name.as_str() {
        "" => format!("object {object}"),
        name => name.to_owned(),
    }
}

fn face_name(scene: &Scene, face: FaceId) -> String {
    format!("{}/{}", object_name(scene, face.object), face.face)
}

fn material_name(scene: &Scene, material: MaterialId) -> String {
    match scene.materials[material as usize].name.as_str() {
        "" => format!("material {material}"),
        name => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FormFactorOptions, form_factors};
    use azulejo_scene::synthetic::cube_room;
    use azulejo_trace::{Progress, Tracer};

    fn check(by: GroupBy, two_sided: bool, expected: &[&str]) {
        let mut scene = cube_room();
        scene.objects[0].name = "room".to_owned();
        scene.materials[0].name = "grey".to_owned();
        scene.merge(scene.clone());
        let options = FormFactorOptions {
            two_sided,
            rays: 4,
            analytic: false,
            ..FormFactorOptions::default()
        };
        let factors = form_factors(&scene, &Tracer::new(&scene), &options, &Progress::new());
        let groups = NamedGroups::new(&scene, &factors.unwrap(), by);
        assert_eq!(groups.names, expected);
        let last = groups.of_rows.iter().flatten().max();
        assert_eq!(last, Some(&(expected.len() as u32 - 1)));
    }

    #[test]
    fn names_are_unique_and_backs_are_separate() {
        check(GroupBy::Object, false, &["room #0", "room #1"]);
        check(GroupBy::Material, false, &["grey #0", "grey #1"]);
        let with_backs = ["room #0", "room (back) #1", "room #2", "room (back) #3"];
        check(GroupBy::Object, true, &with_backs);
    }
}
