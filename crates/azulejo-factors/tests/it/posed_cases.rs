//! The same cases in other poses: answers do not depend on how a scene stands, nor on the last digits of its
//! coordinates.

use crate::cases::{Case, Question};
use azulejo_scene::{PositionHistory, Scene, Shape};
use glam::{DAffine3, DQuat, DVec3};

/// How a case stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pose {
    /// As it is written: mostly parallel to the axes, with round numbers.
    Straight,
    /// Turned about no particular axis, and moved by some times its size.
    Turned,
    /// Turned, with the coordinates of meshes as decimals, as in the files of most programs.
    Rounded,
}

impl Pose {
    /// All poses.
    pub const ALL: [Pose; 3] = [Pose::Straight, Pose::Turned, Pose::Rounded];
}

/// Largest rounding of coordinates, over the shortest edge of the scene.
const ROUNDING: f64 = 1e-7;

/// Largest relative change of an answer by rounding, over that ratio: of faces that touch, and of the areas and
/// distances of mirrors that repeat themselves many times.
const SENSITIVITY: f64 = 200.0;

impl Case {
    /// The case in a pose; the truth of a rounded one is as uncertain as rounding makes it.
    ///
    /// `None` for cases whose groups are parts between angles about an axis, and for rounded ones without
    /// meshes.
    pub fn posed(&self, pose: Pose) -> Option<Case> {
        if pose == Pose::Straight {
            return Some(self.clone());
        }
        if self.has_turns() {
            return None;
        }
        let turn = DQuat::from_axis_angle(DVec3::new(0.48, -0.64, 0.6), 1.1);
        let size = extent(&self.scene);
        let map = DAffine3::from_rotation_translation(turn, size * DVec3::new(2.3, -1.7, 0.9));
        let mut case = self.clone();
        case.scene = case.scene.transformed(&map);
        if pose == Pose::Rounded {
            let decimals = (-(ROUNDING * shortest_edge(&self.scene)?).log10()).ceil() as i32;
            round(&mut case.scene, 10f64.powi(decimals));
            case.truth.error += SENSITIVITY * ROUNDING * case.truth.value.abs();
        }
        Some(case)
    }

    fn has_turns(&self) -> bool {
        match &self.question {
            Question::Factor { from, to } => from.turns.is_some() || to.turns.is_some(),
            Question::Radiosity { groups, .. } | Question::Flux { groups, .. } => {
                groups.iter().any(|surface| surface.group.turns.is_some())
            }
        }
    }
}

/// The largest extent of the scene's meshes and bodies.
fn extent(scene: &Scene) -> f64 {
    let sizes = scene.objects.iter().map(|o| o.bounds().diagonal());
    sizes.fold(0.0, f64::max)
}

/// The shortest edge of all meshes.
fn shortest_edge(scene: &Scene) -> Option<f64> {
    let meshes = scene.objects.iter().filter_map(|o| o.shape.placed_mesh());
    let edges = meshes.flat_map(|mesh| {
        (0..mesh.mesh.faces.len()).flat_map(move |face| {
            let corners = mesh.face_positions(face);
            let next = corners.clone().into_iter().cycle().skip(1);
            corners
                .into_iter()
                .zip(next)
                .map(|(a, b)| a.distance(b))
                .collect::<Vec<f64>>()
        })
    });
    edges.filter(|&length| length > 0.0).min_by(f64::total_cmp)
}

/// Rounds the positions of meshes to multiples of 1 / `units`.
fn round(scene: &mut Scene, units: f64) {
    for object in &mut scene.objects {
        if let Shape::Mesh(mesh) = &mut object.shape {
            for position in &mut mesh.positions {
                *position = (*position * units).round() / units;
            }
            // What is read from a file knows no more.
            mesh.history = PositionHistory::NONE;
        }
    }
}
