//! How exactly the coordinates of a mesh are known: by the digits that they were written with.

use glam::{DAffine3, DVec3};

/// The digits of a list of coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoordinateDigits {
    /// More than single precision holds, and more than a dozen decimals.
    #[default]
    Double,
    /// Every coordinate is a number of single precision (24 bits).
    Single,
    /// No coordinate has more decimals than this.
    Decimals(u8),
}

/// The rounding of a list of coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoordinateRounding {
    /// Largest error of a coordinate, ≥ 0, in scene units: half a unit in the last place of the largest.
    pub error: f64,
    /// The digits that it follows from.
    pub digits: CoordinateDigits,
}

/// Most decimals that are told from double precision.
const MOST_DECIMALS: u8 = 12;

/// Numbers with fewer units in the last place than this have decimals, the rest is double precision.
const MOST_UNITS: f64 = 1e15;

impl CoordinateRounding {
    /// The rounding of some positions, by their digits.
    ///
    /// Numbers that are both single and have few decimals, such as 0.5, are taken for what rounds less.
    /// Without positions, or if some are not finite, the error is 0.
    pub fn of(positions: &[DVec3]) -> CoordinateRounding {
        let reach = reach(positions);
        if !reach.is_finite() {
            return CoordinateRounding::default();
        }
        let (mut is_single, mut decimals) = (true, Some(0));
        for x in positions.iter().flat_map(|p| p.to_array()) {
            is_single &= f64::from(x as f32) == x;
            decimals =
                decimals.and_then(|known| (known..=MOST_DECIMALS).find(|&d| has_decimals(x, d)));
            if !is_single && decimals.is_none() {
                break;
            }
        }
        let single = f64::from(f32::EPSILON) * reach;
        let unit = |base: f64| decimals.map(|d| base.powi(-i32::from(d)));
        // Far from the origin all numbers of single precision have few decimals, at most one for each bit behind the
        // point: decimals were meant where they leave some of these bits unused.
        let leaves_bits = unit(2.0).is_some_and(|last| last > single);
        let (step, digits) = match (unit(10.0), decimals) {
            (Some(step), Some(d)) if !is_single || (leaves_bits && step < single) => {
                (step, CoordinateDigits::Decimals(d))
            }
            _ if is_single => (single, CoordinateDigits::Single),
            _ => (f64::EPSILON * reach, CoordinateDigits::Double),
        };
        CoordinateRounding {
            error: 0.5 * step,
            digits,
        }
    }

    /// The rounding after a map of the positions, which then reach as far as `reach`.
    pub(crate) fn mapped(self, map: &DAffine3, reach: f64) -> CoordinateRounding {
        let m = map.matrix3;
        // At most the norm of the matrix, by rows.
        let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
        CoordinateRounding {
            error: self.error * rows.max_element() + f64::EPSILON * reach,
            digits: self.digits,
        }
    }
}

/// Whether a number is a multiple of 10^−d, as far as its bits tell.
fn has_decimals(x: f64, d: u8) -> bool {
    let units = x * 10f64.powi(i32::from(d));
    units.abs() < MOST_UNITS && (units - units.round()).abs() <= f64::EPSILON * units.abs()
}

/// The largest coordinate.
pub(crate) fn reach(positions: &[DVec3]) -> f64 {
    let largest = |p: &DVec3| p.abs().max_element();
    positions.iter().map(largest).fold(0.0, f64::max)
}

/// The rounding of a mesh's positions before they were mapped, where the numbers no longer tell it.
///
/// Two meshes with the same positions are equal however these came about.
#[derive(Clone, Copy, Debug, Default)]
pub struct PositionHistory(pub(crate) Option<CoordinateRounding>);

impl PositionHistory {
    /// No map yet: the positions tell.
    pub const NONE: PositionHistory = PositionHistory(None);
}

impl PartialEq for PositionHistory {
    fn eq(&self, _: &PositionHistory) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;
    use glam::dvec3;

    #[track_caller]
    fn check(positions: &[DVec3], digits: CoordinateDigits, error: f64) {
        let rounding = CoordinateRounding::of(positions);
        assert_eq!(rounding.digits, digits, "{rounding:?}");
        assert!(
            (rounding.error - error).abs() <= 1e-3 * error,
            "{rounding:?}"
        );
    }

    #[test]
    fn digits_are_told_from_numbers() {
        let single = f64::from(1.1f32);
        let eps = 0.5 * f64::from(f32::EPSILON);
        check(
            &[dvec3(0.123456, -4.2, 3.0)],
            CoordinateDigits::Decimals(6),
            5e-7,
        );
        check(
            &[dvec3(500_000.123, 5_400_000.5, 0.001)],
            CoordinateDigits::Decimals(3),
            5e-4,
        );
        check(
            &[dvec3(single, 0.0, -2.0)],
            CoordinateDigits::Single,
            2.0 * eps,
        );
        check(&[dvec3(4.0, 3.0, 2.5)], CoordinateDigits::Single, 4.0 * eps);
        check(
            &[dvec3(1.0 / 3.0, single, 0.1)],
            CoordinateDigits::Double,
            0.5 * f64::EPSILON * single,
        );
        check(&[], CoordinateDigits::Single, 0.0);
    }

    /// What has been moved far away in single precision has seven or eight decimals, all of which are its bits.
    #[test]
    fn bits_behind_the_point_are_no_decimals() {
        let far =
            |k: f32| dvec3(0.37, 0.11, -0.53) * f64::from(k) + dvec3(65_710.0, 42_001.0, -33_333.0);
        let positions = [1.0, 2.3, 3.7].map(|k| far(k).as_vec3().as_dvec3());
        let error = 0.5 * f64::from(f32::EPSILON) * positions[2].x;
        check(&positions, CoordinateDigits::Single, error);
        check(
            &[dvec3(70_000.125, 3.0, 0.0)],
            CoordinateDigits::Decimals(3),
            5e-4,
        );
    }

    #[test]
    fn maps_keep_the_rounding_of_the_file() {
        let positions = vec![dvec3(1.234, 0.0, 0.5), dvec3(0.125, 2.0, 0.25)];
        let mut mesh = Mesh {
            positions,
            ..Mesh::default()
        };
        let turn = DAffine3::from_rotation_x(0.3) * DAffine3::from_scale(DVec3::splat(1e3));
        mesh.transform(&turn);
        let rounding = mesh.coordinate_rounding();
        assert_eq!(rounding.digits, CoordinateDigits::Decimals(3));
        assert!((0.5..0.71).contains(&rounding.error), "{rounding:?}");
    }
}
