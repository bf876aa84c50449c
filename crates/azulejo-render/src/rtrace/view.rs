//! RTRACE's camera.

use super::shade::RaySampler;
use azulejo_scene::math::Ray;
use azulejo_scene::rtrace::Rtrace;
use glam::DVec3;

/// A viewpoint and an image size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The viewpoint.
    pub eye: DVec3,
    /// The point looked at; not the eye. The farther it is, the less colours fade, unless `focus`
    /// sets another distance.
    pub look: DVec3,
    /// Points up in the image; not along the viewing direction.
    pub up: DVec3,
    /// Half the horizontal and half the vertical field of view, radians. It does not depend on the
    /// image size: pixels need not be square.
    pub half_angles: [f64; 2],
    /// Image size in pixels, width then height.
    pub size: (u32, u32),
    /// `P`: radius of the lens, in widths and heights of the field of view at the focal distance; 0
    /// for a pinhole.
    pub aperture: f64,
    /// `F`: focal distance, > 0, which also sets the fading. `None`: the distance of the point
    /// looked at.
    pub focus: Option<f64>,
}

/// An eye of a stereo pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// `v1`.
    Left,
    /// `v2`.
    Right,
}

impl View {
    /// The view stored in a scene.
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

    /// The view of one eye of a pair, `separation` apart, that are directed at the same point.
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

/// A view with what its rays share computed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lens {
    /// Columns and rows of pixels.
    pub size: (u32, u32),
    /// Length of a pixel's diagonal at the point that is looked at.
    pub pixel: f64,
    /// Focal distance, at which colours have faded to 0.8.
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
        let toward = view.look - view.eye;
        let forward = toward.normalize();
        let right = forward.cross(view.up).normalize();
        let down = forward.cross(right);
        let [h, v] = view.half_angles.map(f64::tan);
        let focus = view.focus.unwrap_or(toward.length());
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

    /// The ray through a point of the image, in pixels from the upper left corner, and through
    /// any point of the lens.
    pub fn ray(&self, x: f64, y: f64, sampler: &mut RaySampler) -> Ray {
        let direction = (self.corner + x * self.across + y * self.down).normalize();
        if self.aperture == [DVec3::ZERO; 2] {
            return Ray::new(self.eye, direction);
        }
        // In the disk, denser toward its sides as in RTRACE.
        let u = 2.0 * sampler.uniform() - 1.0;
        let v = (1.0 - u * u).sqrt() * (2.0 * sampler.uniform() - 1.0);
        let moved = u * self.aperture[0] + v * self.aperture[1];
        Ray::new(
            self.eye + moved,
            (self.focus * direction - moved).normalize(),
        )
    }

    /// The share of a colour that is left after a distance: 0.8 at the focal distance.
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
    fn the_image_spans_both_apertures() {
        let lens = Lens::new(&view());
        let mut sampler = RaySampler::new(0, 0);
        let corner = lens.ray(0.0, 10.0, &mut sampler).direction;
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
        let mut sampler = RaySampler::new(5, 6);
        let sharp = DVec3::new(0.0, 0.0, 4.0);
        for _ in 0..50 {
            let ray = lens.ray(10.0, 5.0, &mut sampler);
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
