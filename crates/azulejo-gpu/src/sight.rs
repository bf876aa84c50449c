//! Where one looks from: the eye and its images behind mirrors, and what the faces of the
//! hemicube show of it. In local coordinates, −1..=1 about the world's centre.

use crate::mesh::{Local, Plane};
use azulejo_scene::Rgb;
use azulejo_scene::math::reflect;
use azulejo_trace::item_buffer::{NO_MIRROR, View};
use glam::DVec3;

/// A reflected world begins this far behind its mirror, in units of half the world's size: what
/// lies in the mirror's plane is not seen in it. Far eyes have larger rounding.
const LEAVING: f64 = 16.0 * f32::EPSILON as f64;

/// A hemicube, as it is or as mirrors show it.
#[derive(Clone, Debug)]
pub struct Sight {
    pub eye: DVec3,
    /// x, y, and z along the normal; left-handed after an odd number of mirrors.
    pub axes: [DVec3; 3],
    /// Product of the reflectances on the way.
    pub tint: Rgb,
    /// The last mirror on the way, or [`NO_MIRROR`].
    pub mirror: u32,
    /// Where its world begins: what has less than the plane's offset is not of it.
    pub begin: Option<Plane>,
}

impl Sight {
    pub fn new(view: &View, local: &Local) -> Sight {
        Sight {
            eye: local.point(view.eye),
            axes: view.axes(),
            tint: Rgb::WHITE,
            mirror: NO_MIRROR,
            begin: None,
        }
    }

    /// What a mirror shows of it, seen from the side on which the eye is.
    pub fn behind(&self, mirror: u32, plane: &Plane, reflectance: Rgb) -> Sight {
        let Plane { normal, offset } = *plane;
        let height = normal.dot(self.eye) - offset;
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        let eye = self.eye - 2.0 * height * normal;
        let step = LEAVING * eye.abs().max_element().max(1.0);
        Sight {
            eye,
            axes: self.axes.map(|a| reflect(a, normal)),
            tint: self.tint * reflectance,
            mirror,
            begin: Some(Plane {
                normal: side * normal,
                offset: side * offset + step,
            }),
        }
    }

    /// Axes of a face: the picture's points (u, v) lie in the direction u x + v y + w.
    pub fn face(&self, face: usize) -> [DVec3; 3] {
        let [x, y, z] = self.axes;
        match face {
            0 => [x, y, z],
            1 => [y, z, x],
            2 => [-y, z, -x],
            3 => [-x, z, y],
            _ => [x, z, -y],
        }
    }

    /// How near the begin of a reflected world is in a face: coefficients of u, v and 1 in 1/w.
    pub fn begin_in(&self, axes: &[DVec3; 3]) -> Option<[f64; 3]> {
        let plane = self.begin.as_ref()?;
        // n · (eye + w d) = offset, so 1/w = n · d / away.
        let away = plane.offset - plane.normal.dot(self.eye);
        (away > 0.0).then(|| axes.map(|a| plane.normal.dot(a) / away))
    }
}
