//! From where RTRACE looks.

use super::shade::Draws;
use azulejo_scene::math::Ray;
use azulejo_scene::rtrace::Rtrace;
use glam::DVec3;

/// A viewpoint and a picture's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the viewer stands.
    pub eye: DVec3,
    /// What is looked at; not the eye. The farther it is, the less everything fades, if `focus`
    /// does not say another distance.
    pub look: DVec3,
    /// Points up in the picture; not along the gaze.
    pub up: DVec3,
    /// Half the horizontal and half the vertical aperture, radians, whatever the picture's size:
    /// its pixels need not be square.
    pub half_angles: [f64; 2],
    /// Picture size in pixels, width then height.
    pub size: (u32, u32),
    /// `P`: radius of the lens, in widths and heights of what the picture shows where it is
    /// sharp; 0 for a pinhole.
    pub aperture: f64,
    /// `F`: distance at which the picture is sharp, > 0; it then counts for the fading, too.
    /// `None`: that of the point looked at.
    pub focus: Option<f64>,
}

/// One of a viewer's two eyes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// `v1`.
    Left,
    /// `v2`.
    Right,
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
            aperture: 0.0,
            focus: None,
        }
    }

    /// The view of one of two eyes that are `separation` apart and look at the same point.
    pub fn of_eye(self, side: Side, separation: f64) -> View {
        let right = (self.look - self.eye).cross(self.up).normalize_or_zero();
        let half = match side {
            Side::Left => -0.5 * separation,
            Side::Right => 0.5 * separation,
        };
        View {
            eye: self.eye + half * right,
            ..self
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
    /// Distance at which everything is sharp, and 0.8 of it is left.
    focus: f64,
    eye: DVec3,
    corner: DVec3,
    across: DVec3,
    down: DVec3,
    /// Across and down the lens; zero for a pinhole.
    aperture: [DVec3; 2],
}

impl Lens {
    pub fn new(view: &View) -> Lens {
        let gaze = view.look - view.eye;
        let forward = gaze.normalize();
        let right = forward.cross(view.up).normalize();
        let down = forward.cross(right);
        let [h, v] = view.half_angles.map(f64::tan);
        let focus = view.focus.unwrap_or(gaze.length());
        let (width, height) = (2.0 * h * right, 2.0 * v * down);
        let across = width / f64::from(view.size.0);
        let down = height / f64::from(view.size.1);
        Lens {
            size: view.size,
            pixel: focus * (across + down).length(),
            focus,
            eye: view.eye,
            corner: forward - 0.5 * (width + height),
            across,
            down,
            aperture: [width, height].map(|edge| view.aperture * focus * edge),
        }
    }

    /// The ray through a point of the picture, in pixels from the upper left corner, and through
    /// any point of the lens.
    pub fn ray(&self, x: f64, y: f64, draws: &mut Draws) -> Ray {
        let direction = (self.corner + x * self.across + y * self.down).normalize();
        if self.aperture == [DVec3::ZERO; 2] {
            return Ray::new(self.eye, direction);
        }
        // In the disk, and as in RTRACE denser toward its sides.
        let u = 2.0 * draws.uniform() - 1.0;
        let v = (1.0 - u * u).sqrt() * (2.0 * draws.uniform() - 1.0);
        let moved = u * self.aperture[0] + v * self.aperture[1];
        Ray::new(
            self.eye + moved,
            (self.focus * direction - moved).normalize(),
        )
    }

    /// How much of anything is left after a distance: 0.8 where the picture is sharp.
    pub fn fade(&self, distance: f64) -> f64 {
        self.focus / (self.focus + 0.25 * distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        View {
            eye: DVec3::new(0.0, 0.0, 8.0),
            look: DVec3::ZERO,
            up: DVec3::Y,
            half_angles: [45f64.to_radians(), 30f64.to_radians()],
            size: (20, 10),
            aperture: 0.0,
            focus: None,
        }
    }

    #[test]
    fn the_picture_spans_both_apertures() {
        let lens = Lens::new(&view());
        let mut draws = Draws::new(0, 0);
        let corner = lens.ray(0.0, 10.0, &mut draws).direction;
        assert!(
            (corner / -corner.z - DVec3::new(-1.0, -30f64.to_radians().tan(), -1.0)).length()
                < 1e-12
        );
        assert!((lens.fade(8.0) - 0.8).abs() < 1e-12);
        assert!((lens.pixel - 8.0 * 0.1f64.hypot(0.2 * 30f64.to_radians().tan())).abs() < 1e-12);
    }

    #[test]
    fn rays_through_the_lens_meet_where_it_is_sharp() {
        let lens = Lens::new(&View {
            aperture: 0.1,
            focus: Some(4.0),
            ..view()
        });
        let mut draws = Draws::new(5, 6);
        let sharp = DVec3::new(0.0, 0.0, 4.0);
        for _ in 0..50 {
            let ray = lens.ray(10.0, 5.0, &mut draws);
            let moved = ray.origin - view().eye;
            assert!(moved.x.abs() <= 0.8 && moved.y.abs() <= 0.5 && moved != DVec3::ZERO);
            let missed = (sharp - ray.origin).cross(ray.direction).length();
            assert!(missed < 1e-12, "{missed}");
        }
        assert!((lens.fade(4.0) - 0.8).abs() < 1e-12);
    }

    #[test]
    fn two_eyes_stand_side_by_side() {
        let eye = |side| view().of_eye(side, 3.0).eye;
        assert!((eye(Side::Left) - DVec3::new(-1.5, 0.0, 8.0)).length() < 1e-12);
        assert!((eye(Side::Right) - DVec3::new(1.5, 0.0, 8.0)).length() < 1e-12);
    }
}
