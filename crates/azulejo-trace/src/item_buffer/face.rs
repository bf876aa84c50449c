//! One face of a hemicube for the rasterizer.

use super::view::{HemicubeView, Plane};
use glam::DVec3;

/// Planes closer to the viewpoint than this are seen edge-on. Far below the step by which viewpoints
/// leave their own patch, far above rounding.
const EDGE_ON: f64 = 1e-9;

/// A face: an image whose points (x, y), −1..=1, lie in the direction x u + y v + w.
pub(super) struct Face {
    /// u along the columns, v along the rows, w through the middle.
    pub axes: [DVec3; 3],
    /// The same.
    pub rows: [[f32; 3]; 3],
    pub eye: DVec3,
    /// The viewpoint, and the remainder beyond single precision.
    pub high: [f32; 3],
    pub low: [f32; 3],
    /// Whether the image is mirrored.
    pub is_turned: bool,
    /// The plane behind which the reflected world begins.
    pub begin: Option<Begin>,
}

/// The plane of a mirror as the border of the reflected world.
pub(super) struct Begin {
    pub plane: Plane,
    /// As [`Depth::nearness`].
    pub nearness: [f64; 3],
}

/// The nearness of a plane at the points of an image.
pub(super) struct Depth {
    /// Coefficients of x, y and 1 in 1/w, w the distance along the face's axis.
    pub nearness: [f64; 3],
    /// Whether the viewpoint is on the side that the plane's normal points to.
    pub is_above: bool,
}

impl Face {
    /// A face of a view, by its number as in [`HemicubeView::face_axes`].
    pub fn new(view: &HemicubeView, face: usize) -> Face {
        let axes = view.face_axes(face);
        let high = view.eye.as_vec3();
        let begin = |plane: Plane| {
            let nearness = view.begin_nearness(&axes)?;
            Some(Begin { plane, nearness })
        };
        Face {
            axes,
            rows: axes.map(|a| a.as_vec3().to_array()),
            eye: view.eye,
            high: high.to_array(),
            low: (view.eye - high.as_dvec3()).as_vec3().to_array(),
            is_turned: view.is_turned,
            begin: view.begin.and_then(begin),
        }
    }

    /// `None` if the viewpoint is in the plane.
    pub fn depth(&self, plane: &Plane) -> Option<Depth> {
        let away = plane.offset - plane.normal.dot(self.eye);
        // n · (eye + w d) = offset, so 1/w = n · d / away: linear in the image. NaN fails.
        let (inverse, [u, v, w]) = (1.0 / away, &self.axes);
        let along = |axis: &DVec3| plane.normal.dot(*axis) * inverse;
        (away.abs() > EDGE_ON).then(|| Depth {
            nearness: [along(u), along(v), along(w)],
            is_above: away < 0.0,
        })
    }

    /// The direction of a point of the image.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        x * self.axes[0] + y * self.axes[1] + self.axes[2]
    }

    /// Components of a world vector along the axes.
    pub fn components(&self, v: DVec3) -> [f64; 3] {
        self.axes.map(|a| a.dot(v))
    }
}
