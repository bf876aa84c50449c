//! Where one looks from: the eye and its images behind mirrors, and what the faces of the
//! hemicube show of it.

use super::View;
use super::world::{Local, LocalMirror, Plane};
use azulejo_scene::Rgb;
use azulejo_scene::math::reflect;
use glam::DVec3;

/// A reflected world begins this far behind its mirror, in units of half the world's size, so
/// that nothing that lies in the mirror's plane is seen in it: the step of
/// [`Tracer::leaving`](crate::Tracer::leaving).
const LEAVING: f64 = 16.0 * f32::EPSILON as f64;

/// Planes closer to the eye than this are seen edge-on. Far below the step by which eyes leave
/// their own patch, far above rounding.
const EDGE_ON: f64 = 1e-9;

/// A hemicube in local coordinates, as it is or as mirrors show it.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    pub eye: DVec3,
    /// x, y, and z along the normal.
    pub axes: [DVec3; 3],
    /// Whether the axes are left-handed, as they are after an odd number of mirrors.
    pub is_turned: bool,
    /// Product of the reflectances on the way.
    pub tint: Rgb,
    /// Where the last mirror's world begins: what has less than the plane's offset is not of it.
    pub begin: Option<Plane>,
}

impl Sight {
    pub fn new(view: &View, local: &Local) -> Sight {
        Sight {
            eye: local.point(view.eye),
            axes: view.axes(),
            is_turned: false,
            tint: Rgb::WHITE,
            begin: None,
        }
    }

    /// What the mirror shows of it, seen from the side on which the eye is.
    pub fn behind(&self, mirror: &LocalMirror) -> Sight {
        let Plane { normal, offset } = mirror.plane;
        let height = normal.dot(self.eye) - offset;
        let side = if height < 0.0 { -1.0 } else { 1.0 };
        Sight {
            eye: self.eye - 2.0 * height * normal,
            axes: self.axes.map(|a| reflect(a, normal)),
            is_turned: !self.is_turned,
            tint: self.tint * mirror.reflectance,
            begin: Some(Plane {
                normal: side * normal,
                offset: side * offset + LEAVING,
            }),
        }
    }

    /// A face of the hemicube: 0 is the top, 1 to 4 those towards +x, −x, +y, −y.
    pub fn face(&self, face: usize) -> Face {
        let [x, y, z] = self.axes;
        let axes = match face {
            0 => [x, y, z],
            1 => [y, z, x],
            2 => [-y, z, -x],
            3 => [-x, z, y],
            _ => [x, z, -y],
        };
        let high = self.eye.as_vec3();
        let face = Face {
            axes,
            rows: axes.map(|a| a.as_vec3().to_array()),
            eye: self.eye,
            high: high.to_array(),
            low: (self.eye - high.as_dvec3()).as_vec3().to_array(),
            is_turned: self.is_turned,
            begin: None,
        };
        let begin = |plane: Plane| {
            let nearness = face.depth(&plane)?.nearness;
            Some(Begin { plane, nearness })
        };
        Face {
            begin: self.begin.and_then(begin),
            ..face
        }
    }
}

/// A face: a picture whose points (x, y), −1..=1, lie in the direction x u + y v + w.
pub(super) struct Face {
    /// u to the columns' end, v to the rows' end, w through the middle.
    pub axes: [DVec3; 3],
    /// The same.
    pub rows: [[f32; 3]; 3],
    pub eye: DVec3,
    /// The eye, and what is left of it beyond single precision.
    pub high: [f32; 3],
    pub low: [f32; 3],
    /// Whether right and left are exchanged.
    pub is_turned: bool,
    /// Where a reflected world begins.
    pub begin: Option<Begin>,
}

/// The plane of a mirror as the border of the world that it shows.
pub(super) struct Begin {
    pub plane: Plane,
    /// As [`Depth::nearness`].
    pub nearness: [f64; 3],
}

/// How near a plane is in the points of a picture.
pub(super) struct Depth {
    /// Coefficients of x, y and 1 in 1/w, w the distance along the face's axis.
    pub nearness: [f64; 3],
    /// Whether the eye is on the side that the plane's normal points to.
    pub is_above: bool,
}

impl Face {
    /// `None` if the eye is in the plane.
    pub fn depth(&self, plane: &Plane) -> Option<Depth> {
        let away = plane.offset - plane.normal.dot(self.eye);
        // n · (eye + w d) = offset, so 1/w = n · d / away: linear in the picture. NaN fails.
        let (inverse, [u, v, w]) = (1.0 / away, &self.axes);
        let along = |axis: &DVec3| plane.normal.dot(*axis) * inverse;
        (away.abs() > EDGE_ON).then(|| Depth {
            nearness: [along(u), along(v), along(w)],
            is_above: away < 0.0,
        })
    }

    /// The direction of a point of the picture.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        x * self.axes[0] + y * self.axes[1] + self.axes[2]
    }

    /// Components of a world vector along the axes.
    pub fn components(&self, v: DVec3) -> [f64; 3] {
        self.axes.map(|a| a.dot(v))
    }
}
