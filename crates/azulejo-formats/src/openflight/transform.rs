//! Transforms: matrices, degrees of freedom, and state inherited through the hierarchy.

use super::fields::RecordFields;
use azulejo_scene::math::normal_matrix;
use glam::{DAffine3, DMat3, DVec3};

/// State inherited from the nodes above.
#[derive(Clone, Copy, Debug)]
pub(super) struct InheritedState {
    pub world: DAffine3,
    /// Transforms normals to world coordinates, without normalizing them.
    pub normals: DMat3,
    /// Whether the orientation of faces is reversed.
    pub mirrored: bool,
    /// The combined opacity of the objects above.
    pub opacity: f64,
}

impl InheritedState {
    /// The state at the root.
    pub fn world() -> InheritedState {
        InheritedState {
            world: DAffine3::IDENTITY,
            normals: DMat3::IDENTITY,
            mirrored: false,
            opacity: 1.0,
        }
    }

    /// The state of a child with a transform of its own.
    pub fn then(&self, local: &DAffine3) -> InheritedState {
        let world = self.world * *local;
        InheritedState {
            world,
            normals: normal_matrix(world.matrix3),
            mirrored: world.matrix3.determinant() < 0.0,
            ..*self
        }
    }
}

/// The map of a matrix record; `None` if it is too short or not finite.
///
/// The file uses row vectors, so its rows are our columns.
pub(super) fn matrix(record: RecordFields) -> Option<DAffine3> {
    let row = |k: usize| record.singles(4 + 16 * k);
    let map = DAffine3::from_cols(row(0)?, row(1)?, row(2)?, row(3)?);
    map.is_finite().then_some(map)
}

/// A matrix with all digits of its translation: it has single precision, but the records of the individual
/// translations that it is made of have double. They count where their sum is what the matrix has.
pub(super) fn with_exact_translation<'a>(
    matrix: DAffine3,
    translations: impl Iterator<Item = RecordFields<'a>>,
) -> DAffine3 {
    let sum: DVec3 = translations.filter_map(|record| record.doubles(32)).sum();
    if sum.as_vec3() == matrix.translation.as_vec3() {
        DAffine3 {
            translation: sum,
            ..matrix
        }
    } else {
        matrix
    }
}

/// The map of a degree of freedom at its current values; `None` if they are not finite.
///
/// In the frame given by three points of the record, a point is scaled, rotated about z (yaw),
/// about y (roll) and about x (pitch), and translated.
pub(super) fn degree_of_freedom(record: RecordFields) -> Option<DAffine3> {
    let frame = frame(record)?;
    let current = |group: usize| record.double(88 + 32 * group + 16);
    let vector = |z: usize| Some(DVec3::new(current(z + 2)?, current(z + 1)?, current(z)?));
    let angle = |group: usize| current(group).map(f64::to_radians);
    // Some exporters write a scale of 0 for none.
    let scale = vector(6)?.map(|s| if s == 0.0 { 1.0 } else { s });
    let turn = DMat3::from_rotation_x(angle(3)?)
        * DMat3::from_rotation_y(angle(4)?)
        * DMat3::from_rotation_z(angle(5)?);
    let inner = DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), vector(0)?);
    let map = frame * inner * frame.inverse();
    map.is_finite().then_some(map)
}

/// The frame of a degree of freedom: origin, a point on its x axis, a point in its xy plane.
fn frame(record: RecordFields) -> Option<DAffine3> {
    // The editor's value for a point that is not set.
    let unset = DVec3::splat(-1e8);
    let point = |at: usize, default: DVec3| {
        let given = record.doubles(at)?;
        Some(if given == unset { default } else { given })
    };
    let origin = point(16, DVec3::ZERO)?;
    let x = point(40, origin + DVec3::X)? - origin;
    let y = point(64, origin + DVec3::Y)? - origin;
    let x = x.try_normalize().unwrap_or(DVec3::X);
    let z = x.cross(y).try_normalize().unwrap_or(DVec3::Z);
    let y = z.cross(x).try_normalize()?;
    Some(DAffine3::from_cols(x, y, x.cross(y), origin))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record with doubles from byte 16.
    fn dof(points: [DVec3; 3], current: [f64; 9]) -> Vec<u8> {
        let mut bytes = vec![0; 16];
        let mut put = |x: f64| bytes.extend(x.to_be_bytes());
        points.iter().flat_map(|p| p.to_array()).for_each(&mut put);
        for value in current {
            [-9.0, 9.0, value, 1.0].into_iter().for_each(&mut put);
        }
        bytes
    }

    fn check(points: [DVec3; 3], current: [f64; 9], from: DVec3, expected: DVec3) {
        let map = degree_of_freedom(RecordFields(&dof(points, current))).unwrap();
        let to = map.transform_point3(from);
        assert!((to - expected).length() < 1e-12, "{current:?}: {to}");
    }

    const WORLD: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];
    const STILL: [f64; 9] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0];

    #[test]
    fn current_values_move() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        let with = |changes: &[(usize, f64)]| {
            let mut values = STILL;
            changes.iter().for_each(|&(k, v)| values[k] = v);
            values
        };
        check(WORLD, STILL, p, p);
        check(WORLD, [0.0; 9], p, p);
        let moved = with(&[(0, 30.0), (1, 20.0), (2, 10.0)]);
        check(WORLD, moved, p, DVec3::new(11.0, 22.0, 33.0));
        check(WORLD, with(&[(5, 90.0)]), DVec3::X, DVec3::Y);
        check(WORLD, with(&[(3, 90.0)]), DVec3::Y, DVec3::Z);
        check(WORLD, with(&[(4, 90.0)]), DVec3::Z, DVec3::X);
        check(WORLD, with(&[(6, 2.0)]), p, DVec3::new(1.0, 2.0, 6.0));
        // Yaw comes first: it rotates x to y, which pitch rotates to z.
        check(WORLD, with(&[(3, 90.0), (5, 90.0)]), DVec3::X, DVec3::Z);
    }

    #[test]
    fn they_do_so_in_their_own_frame() {
        let at = DVec3::new(5.0, 0.0, 0.0);
        let mut turned = STILL;
        turned[5] = 90.0;
        let here = [at, at + DVec3::Y, at - DVec3::X];
        check(here, turned, at + DVec3::X, at + DVec3::Y);
        let unset = [DVec3::splat(-1e8); 3];
        check(unset, turned, DVec3::X, DVec3::Y);
        let flat = [at, at, at];
        check(flat, turned, at + DVec3::X, at + DVec3::Y);
    }

    #[test]
    fn what_is_no_number_is_no_map() {
        let mut broken = STILL;
        broken[0] = f64::NAN;
        assert!(degree_of_freedom(RecordFields(&dof(WORLD, broken))).is_none());
        assert!(degree_of_freedom(RecordFields(&[0; 100])).is_none());
        assert!(matrix(RecordFields(&[0; 60])).is_none());
        assert!(matrix(RecordFields(&[0xff; 68])).is_none());
    }
}
