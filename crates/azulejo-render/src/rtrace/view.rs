//! From where RTRACE looks.

use azulejo_scene::math::Ray;
use azulejo_scene::rtrace::Rtrace;
use glam::DVec3;

/// A viewpoint and a picture's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the viewer stands.
    pub eye: DVec3,
    /// What is looked at; not the eye. The farther it is, the less everything fades.
    pub look: DVec3,
    /// Points up in the picture; not along the gaze.
    pub up: DVec3,
    /// Half the horizontal and half the vertical aperture, radians, whatever the picture's size:
    /// its pixels need not be square.
    pub half_angles: [f64; 2],
    /// Picture size in pixels, width then height.
    pub size: (u32, u32),
}

impl View {
    /// The view that a scene brings.
    pub fn of(rtrace: &Rtrace, size: (u32, u32)) -> View {
        View {
            eye: rtrace.eye,
            look: rtrace.look,
            up: rtrace.up,
            half_angles: rtrace.half_angles,
            size,
        }
    }
}

/// A view with everything worked out that its rays share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    /// Columns and rows of pixels.
    pub size: (u32, u32),
    /// Length of a pixel's diagonal at the point that is looked at.
    pub pixel: f64,
    gaze_length: f64,
    eye: DVec3,
    corner: DVec3,
    across: DVec3,
    down: DVec3,
}

impl Lens {
    pub fn new(view: &View) -> Lens {
        let gaze = view.look - view.eye;
        let forward = gaze.normalize();
        let right = forward.cross(view.up).normalize();
        let down = forward.cross(right);
        let [h, v] = view.half_angles.map(f64::tan);
        let across = right * (2.0 * h / f64::from(view.size.0));
        let down_pixel = down * (2.0 * v / f64::from(view.size.1));
        Lens {
            size: view.size,
            pixel: gaze.length() * (across + down_pixel).length(),
            gaze_length: gaze.length(),
            eye: view.eye,
            corner: forward - h * right - v * down,
            across,
            down: down_pixel,
        }
    }

    /// The ray through a point of the picture, in pixels from the upper left corner.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let direction = self.corner + x * self.across + y * self.down;
        Ray::new(self.eye, direction.normalize())
    }

    /// How much of anything is left after a distance: 0.8 at the point looked at.
    pub fn fade(&self, distance: f64) -> f64 {
        self.gaze_length / (self.gaze_length + 0.25 * distance)
    }
}
