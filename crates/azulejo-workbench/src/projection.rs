//! From world space to pixels, in `f64` until the last step.

use azulejo::scene::Camera;
use azulejo::scene::math::Ray;
use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4, Mat4};

/// Minimum ratio of near to far distance: the resolution of an OpenGL depth buffer, which is not a
/// float to its last bit.
const NEAREST_SHARE: f64 = 2e-5;

/// A camera with an image of known size.
///
/// View space: x right, y up, z backward, the camera at the origin. The depth is the near distance
/// divided by the distance: 1 at the near plane, 0 at infinity.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    eye: DVec3,
    /// Rows: right, up, backward.
    view_from_world: DMat3,
    near: f64,
    /// Reciprocals of the half extents at distance 1.
    scale: DVec2,
    size: DVec2,
}

impl Projection {
    /// The projection of a camera. Degenerate cameras (no direction, `up` parallel to the view, no
    /// field of view) are corrected.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Projection {
        let (forward, up) = (camera.target - camera.eye, camera.up);
        let forward = forward.try_normalize().unwrap_or(-DVec3::Z);
        let right = forward.cross(up).try_normalize();
        let right = right.unwrap_or_else(|| forward.any_orthonormal_vector());
        let size = DVec2::new(f64::from(size[0].max(1)), f64::from(size[1].max(1)));
        let half = (0.5 * camera.vertical_fov).clamp(1e-4, 1.55).tan();
        Projection {
            eye: camera.eye,
            view_from_world: DMat3::from_cols(right, right.cross(forward), -forward).transpose(),
            near: 1e-3,
            scale: DVec2::new(size.y / size.x, 1.0) / half,
            size,
        }
    }

    /// The same projection with the near plane as far away as the bounding spheres (centre, radius)
    /// of objects and overlays allow. The extent of overlays matters only if there are no objects.
    /// The far plane is at infinity.
    pub fn around(
        mut self,
        objects: impl IntoIterator<Item = (DVec3, f64)>,
        marks: impl IntoIterator<Item = (DVec3, f64)>,
    ) -> Projection {
        let (nearest, farthest) = self.depths(objects);
        let (near_mark, far_mark) = self.depths(marks);
        let nearest = nearest.min(near_mark);
        let farthest = if farthest > 0.0 { farthest } else { far_mark };
        if farthest > 0.0 {
            self.near = (0.9 * nearest).max(NEAREST_SHARE * farthest);
        }
        self
    }

    /// The least and greatest depth of the spheres that are not behind the camera.
    fn depths(&self, spheres: impl IntoIterator<Item = (DVec3, f64)>) -> (f64, f64) {
        let (mut nearest, mut farthest) = (f64::INFINITY, 0f64);
        for (centre, radius) in spheres {
            let depth = -self.to_view(centre).z;
            if depth + radius > 0.0 && (depth + radius).is_finite() {
                nearest = nearest.min(depth - radius);
                farthest = farthest.max(depth + radius);
            }
        }
        (nearest, farthest)
    }

    /// A world position in view space.
    pub fn to_view(&self, p: DVec3) -> DVec3 {
        self.view_from_world * (p - self.eye)
    }

    /// Pixel coordinates of a world position from the upper left corner; `None` behind the camera.
    pub fn project(&self, p: DVec3) -> Option<DVec2> {
        let v = self.to_view(p);
        let ndc = DVec2::new(v.x, v.y) * self.scale / -v.z;
        let unit = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        (v.z < 0.0).then_some(unit * self.size)
    }

    /// The ray through a point of the image, in pixels from the upper left corner; its direction is
    /// normalized.
    pub fn ray(&self, pixel: DVec2) -> Ray {
        let unit = pixel / self.size;
        let ndc = DVec2::new(2.0 * unit.x - 1.0, 1.0 - 2.0 * unit.y);
        let direction = (ndc / self.scale).extend(-1.0).normalize();
        Ray::new(self.eye, self.view_from_world.transpose() * direction)
    }

    /// Size of a pixel at a point in world units; distances below the near plane count as near.
    pub fn pixel_at(&self, p: DVec3) -> f64 {
        let depth = (-self.to_view(p).z).max(self.near);
        2.0 * depth / (self.scale.y * self.size.y)
    }

    pub(crate) fn near(&self) -> f64 {
        self.near
    }

    pub(crate) fn size(&self) -> DVec2 {
        self.size
    }

    /// The world axes in view space, as columns.
    pub(crate) fn rotation(&self) -> DMat3 {
        self.view_from_world
    }

    /// From an object's space, translated by `origin`, to view space.
    pub(crate) fn view_from(&self, world_from_object: &DAffine3, origin: DVec3) -> DAffine3 {
        let centre = world_from_object.transform_point3(origin);
        DAffine3 {
            matrix3: self.view_from_world * world_from_object.matrix3,
            translation: self.to_view(centre),
        }
    }

    /// A view-space position in clip coordinates.
    pub(crate) fn clip(&self, v: DVec3) -> DVec4 {
        DVec4::new(v.x * self.scale.x, v.y * self.scale.y, self.near, -v.z)
    }

    pub(crate) fn clip_from(&self, view_from: &DAffine3) -> Mat4 {
        let column =
            |v: DVec3| DVec4::new(v.x * self.scale.x, v.y * self.scale.y, 0.0, -v.z).as_vec4();
        let m = view_from.matrix3;
        Mat4::from_cols(
            column(m.x_axis),
            column(m.y_axis),
            column(m.z_axis),
            self.clip(view_from.translation).as_vec4(),
        )
    }

    /// Whether a sphere in view space may be visible.
    pub(crate) fn sees(&self, centre: DVec3, radius: f64) -> bool {
        let beyond = |scale: f64, x: f64| {
            // Distance to the plane |x| scale = -z, positive outside.
            (x.abs() * scale + centre.z) / scale.hypot(1.0)
        };
        !(centre.z - radius > -self.near
            || beyond(self.scale.x, centre.x) > radius
            || beyond(self.scale.y, centre.y) > radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::math::Aabb;

    fn camera() -> Camera {
        let bounds = Aabb::around([DVec3::ZERO, DVec3::splat(4.0)]);
        Camera::framing(bounds, 1.5, DVec3::Y)
    }

    #[test]
    fn a_ray_goes_where_its_points_are_projected() {
        let view = Projection::new(&camera(), [300, 200]);
        for pixel in [(150.0, 100.0), (0.0, 0.0), (290.0, 33.0)] {
            let pixel = DVec2::from(pixel);
            let back = view.project(view.ray(pixel).at(7.0)).expect("in front");
            assert!((back - pixel).length() < 1e-9, "{pixel} {back}");
        }
        assert_eq!(view.project(view.ray(DVec2::ZERO).at(-1.0)), None);
    }

    #[test]
    fn the_ray_is_the_cameras() {
        let (camera, pixel) = (camera(), DVec2::new(30.0, 40.0));
        let ray = Projection::new(&camera, [300, 200]).ray(pixel);
        let expected = camera.ray(0.1, 0.2, 1.5);
        assert!((ray.direction - expected.direction).length() < 1e-12);
    }

    #[test]
    fn spheres_are_left_out_only_outside_the_picture() {
        let view = Projection::new(&camera(), [300, 200]);
        let check = |pixel: (f64, f64), radius: f64, expected: bool| {
            let ray = view.ray(pixel.into());
            let centre = view.to_view(ray.at(10.0));
            assert_eq!(view.sees(centre, radius), expected, "{pixel:?}");
        };
        check((150.0, 100.0), 0.1, true);
        check((-100.0, 100.0), 0.1, false);
        check((-100.0, 100.0), 6.0, true);
        check((150.0, 1000.0), 0.1, false);
        assert!(!view.sees(DVec3::Z, 0.5), "behind");
    }

    #[test]
    fn cameras_without_sense_still_have_finite_axes() {
        let mut camera = camera();
        camera.up = camera.target - camera.eye;
        assert!(Projection::new(&camera, [0, 0]).rotation().is_finite());
        camera.target = camera.eye;
        assert!(Projection::new(&camera, [1, 1]).rotation().is_finite());
    }
}
