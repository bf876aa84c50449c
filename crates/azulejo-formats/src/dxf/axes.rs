//! Object coordinate systems (OCS) of planar entities.

use glam::{DMat3, DVec3};

/// Axes of an entity's own coordinates in those of the drawing, by its extrusion direction: the
/// columns of the matrix, the last of which is the direction.
///
/// *DXF Reference*, "Arbitrary Axis Algorithm". Without a direction they are the drawing's axes.
pub(super) fn world_from_entity(extrusion: DVec3) -> DMat3 {
    // The default direction needs no rounding.
    if extrusion == DVec3::Z {
        return DMat3::IDENTITY;
    }
    let z = extrusion.try_normalize().unwrap_or(DVec3::Z);
    let near_pole = z.x.abs() < 1.0 / 64.0 && z.y.abs() < 1.0 / 64.0;
    let other = if near_pole { DVec3::Y } else { DVec3::Z };
    let x = other.cross(z).normalize();
    DMat3::from_cols(x, z.cross(x).normalize(), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(extrusion: [f64; 3], x: [f64; 3], y: [f64; 3]) {
        let axes = world_from_entity(DVec3::from_array(extrusion));
        let z = DVec3::from_array(extrusion).normalize();
        let expected = DMat3::from_cols(DVec3::from_array(x), DVec3::from_array(y), z);
        assert!(
            axes.abs_diff_eq(expected, 1e-15),
            "{extrusion:?}: {axes} and not {expected}"
        );
    }

    #[test]
    fn by_hand() {
        check([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        // The result of MIRROR.
        check([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        // A wall that faces along x, and one along −y.
        check([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        check([0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        // Z × (0, 3, 4)/5 = (−3/5, 0, 0).
        check([0.0, 3.0, 4.0], [-1.0, 0.0, 0.0], [0.0, -0.8, 0.6]);
        // Y × (a, 0, c) = (c, 0, −a) as long as a and the y of the direction are below 1/64.
        let (a, c) = (0.01, f64::sqrt(1.0 - 1e-4));
        check([a, 0.0, c], [c, 0.0, -a], [0.0, 1.0, 0.0]);
        // Z × (a, 0, c) = (0, a, 0) beyond that.
        let (a, c) = (0.02, f64::sqrt(1.0 - 4e-4));
        check([a, 0.0, c], [0.0, 1.0, 0.0], [-c, 0.0, a]);
    }

    #[test]
    fn no_direction() {
        assert_eq!(world_from_entity(DVec3::ZERO), DMat3::IDENTITY);
    }

    proptest! {
        #[test]
        fn always_a_rotation(x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0, small in 0..20) {
            let direction = DVec3::new(x, y, z * f64::from(1 << small)) * 1e-3;
            prop_assume!(direction.length() > 1e-9);
            let axes = world_from_entity(direction);
            prop_assert!((axes * axes.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
            prop_assert!((axes.determinant() - 1.0).abs() < 1e-12);
            prop_assert!((axes.z_axis - direction.normalize()).length() < 1e-12);
            // The x axis stays in the drawing's xy plane, except near the pole.
            prop_assert!(axes.x_axis.z.abs() < 1.0 / 63.0);
        }
    }
}
