//! Camera and display settings. Nothing here changes the model.

use crate::projection::Projection;
use azulejo::scene::math::Aabb;
use azulejo::scene::{Camera, Rgb, Up};
use clap::ValueEnum;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Shading modes of the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// Vertices.
    Points,
    /// Edges.
    Lines,
    /// Edges with hidden lines removed.
    HiddenLines,
    /// One colour per face.
    Flat,
    /// Smooth shading.
    #[default]
    Gouraud,
    /// Smooth shading with textures.
    Textured,
    /// The solved light.
    Irradiance,
    /// Irradiance in false colours.
    FalseColor,
    /// The relative standard error of the irradiance in false colours.
    Error,
    /// The patches of the solver.
    Patches,
    /// Form factors of a picked patch.
    FormFactors,
    /// Normals as colours, back faces in red.
    Normals,
}

impl Shading {
    /// Whether it displays the solved light.
    pub fn shows_light(self) -> bool {
        matches!(
            self,
            Shading::Irradiance | Shading::FalseColor | Shading::Error | Shading::Patches
        )
    }
}

/// The unit in which light is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LightUnit {
    /// That of the document's numbers.
    #[default]
    #[value(name = "file")]
    Document,
    /// Watts.
    #[value(name = "watts")]
    Radiometric,
    /// Lumens.
    #[value(name = "lumens")]
    Photometric,
}

/// A plane that cuts the model open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlane {
    /// The axis that it is perpendicular to: 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Where it cuts, 0 at the lower end of the model to 1 at the upper one.
    pub at: f64,
    /// Whether the lower side is cut away instead of the upper one.
    pub is_flipped: bool,
}

impl SectionPlane {
    /// Normal and offset of the plane n · x = d in a model of these bounds; n · x > d is cut away.
    pub fn plane(&self, bounds: Aabb) -> (DVec3, f64) {
        let axis = self.axis.min(2);
        let at = bounds.min[axis] + self.at * (bounds.max[axis] - bounds.min[axis]);
        let sign = if self.is_flipped { -1.0 } else { 1.0 };
        (sign * DVec3::AXES[axis], sign * at)
    }

    /// The section that takes the ceiling off.
    pub fn below_ceiling(up: Up) -> SectionPlane {
        let axis = match up {
            Up::Y => 1,
            Up::Z => 2,
        };
        SectionPlane {
            axis,
            at: 0.85,
            is_flipped: false,
        }
    }
}

/// Two shading modes side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// What is shown at the right.
    pub with: Shading,
    /// Where the halves meet, 0 at the left edge to 1.
    pub at: f32,
}

/// Colour maps suitable for all kinds of colour vision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ColorMap {
    /// Blue, green, yellow.
    #[default]
    Viridis,
    /// Blue to yellow, optimized for colour vision deficiency.
    Cividis,
    /// Black, purple, white.
    Magma,
    /// Black to white.
    Grey,
}

/// The settings of false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColor {
    /// The colours from low values to high ones.
    pub map: ColorMap,
    /// Values at both ends, W/m² or lux; `None` takes the range of the displayed values.
    pub range: Option<(f64, f64)>,
    /// Whether the scale is logarithmic.
    pub logarithmic: bool,
    /// Number of isolines; 0 for none.
    pub isolines: u32,
}

impl Default for FalseColor {
    fn default() -> FalseColor {
        FalseColor {
            map: ColorMap::default(),
            range: None,
            logarithmic: false,
            isolines: 8,
        }
    }
}

/// The background of the viewport.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Backdrop {
    /// The scene's own background, or a neutral gradient.
    #[default]
    Scene,
    /// One colour, sRGB.
    Color([u8; 3]),
}

/// The 16 colours of early personal computers, with their names, sRGB.
pub const COLORS: [(&str, [u8; 3]); 16] = [
    ("Black", [0, 0, 0]),
    ("Maroon", [128, 0, 0]),
    ("Green", [0, 128, 0]),
    ("Olive", [128, 128, 0]),
    ("Navy", [0, 0, 128]),
    ("Purple", [128, 0, 128]),
    ("Teal", [0, 128, 128]),
    ("Silver", [192, 192, 192]),
    ("Grey", [128, 128, 128]),
    ("Red", [255, 0, 0]),
    ("Lime", [0, 255, 0]),
    ("Yellow", [255, 255, 0]),
    ("Blue", [0, 0, 255]),
    ("Fuchsia", [255, 0, 255]),
    ("Aqua", [0, 255, 255]),
    ("White", [255, 255, 255]),
];

/// Standard directions of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ViewDirection {
    /// From the front.
    Front,
    /// From behind.
    Back,
    /// From the left.
    Left,
    /// From the right.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
    /// From the front, slightly above and aside.
    Corner,
}

/// Camera and display settings.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelView {
    /// Where the view is seen from, in world space.
    pub camera: Camera,
    /// What the colours of surfaces mean.
    pub shading: Shading,
    /// Factor from radiance to display; `None` selects it automatically.
    pub exposure: Option<f64>,
    /// The settings of false colours.
    pub false_color: FalseColor,
    /// The unit in which light is shown.
    pub light_unit: LightUnit,
    /// Another shading mode at the right of the view.
    pub comparison: Option<Comparison>,
    /// Whether back faces are hidden, which shows the inside of rooms from outside.
    pub hides_backs: bool,
    /// A plane that cuts the model open.
    pub section: Option<SectionPlane>,
    /// What is seen where the model is not.
    pub backdrop: Backdrop,
    /// Whether markers of lights and cameras are drawn.
    pub shows_markers: bool,
    /// Whether the grid with the axes is drawn.
    pub shows_grid: bool,
    /// Whether the scene's fog is drawn.
    pub shows_fog: bool,
    /// Width of the viewport over its height, by which the model is framed.
    pub aspect: f64,
    /// Whether the orientation cube is drawn.
    pub shows_cube: bool,
}

impl Default for ModelView {
    fn default() -> ModelView {
        ModelView {
            camera: camera_around(Aabb::EMPTY, 1.0, Up::Y),
            shading: Shading::default(),
            exposure: None,
            false_color: FalseColor::default(),
            light_unit: LightUnit::default(),
            comparison: None,
            hides_backs: false,
            section: None,
            backdrop: Backdrop::default(),
            shows_markers: true,
            shows_grid: false,
            shows_fog: true,
            aspect: 1.0,
            shows_cube: true,
        }
    }
}

/// A camera that sees all of `bounds`; a unit cube if they are empty.
pub fn camera_around(bounds: Aabb, aspect: f64, up: Up) -> Camera {
    let bounds = if bounds.is_empty() {
        Aabb::around([DVec3::splat(-0.5), DVec3::splat(0.5)])
    } else {
        bounds
    };
    Camera::framing(bounds, aspect.min(1.0), up.axis())
}

/// Minimum distance of an orbit from the pole, radians.
const POLE: f64 = 0.01;

impl ModelView {
    /// Orbits around the target: `right` and `up` in radians.
    pub fn orbit(&mut self, right: f64, up: f64, axis: DVec3) {
        let camera = &mut self.camera;
        let back = camera.eye - camera.target;
        let back = DQuat::from_axis_angle(axis, -right) * back;
        let height = back.angle_between(axis);
        let polar_angle = (height - up).clamp(POLE, std::f64::consts::PI - POLE);
        let side = axis.cross(back).try_normalize();
        // Straight above or below there is no horizontal direction; use the image's right.
        let side = side.unwrap_or_else(|| camera.axes().0);
        let back = DQuat::from_axis_angle(side, polar_angle - height) * back;
        camera.eye = camera.target + back;
        camera.up = axis;
    }

    /// Pans: `right` and `up` in fractions of the image's height.
    pub fn pan(&mut self, right: f64, up: f64) {
        let camera = &mut self.camera;
        let (x, y, _) = camera.axes();
        let distance = (camera.target - camera.eye).length();
        let height = 2.0 * distance * (0.5 * camera.vertical_fov).tan();
        let shift = height * (right * x + up * y);
        camera.eye += shift;
        camera.target += shift;
    }

    /// Changes the distance to the target by a factor.
    pub fn zoom(&mut self, factor: f64) {
        let camera = &mut self.camera;
        let back = (camera.eye - camera.target) * factor;
        if back.length() > 1e-9 && back.length() < 1e12 {
            camera.eye = camera.target + back;
        }
    }

    /// Flies: forward, right and up in world units, and turns the camera by radians.
    pub fn fly(&mut self, step: DVec3, yaw: f64, pitch: f64, axis: DVec3) {
        let camera = &mut self.camera;
        let (right, up, forward) = camera.axes();
        let shift = step.x * right + step.y * up + step.z * forward;
        let reach = (camera.target - camera.eye).length();
        camera.eye += shift;
        let turned = DQuat::from_axis_angle(axis, -yaw) * forward;
        let height = turned.angle_between(axis);
        let polar_angle = (height - pitch).clamp(POLE, std::f64::consts::PI - POLE);
        let side = turned.cross(axis).try_normalize().unwrap_or(right);
        let forward = DQuat::from_axis_angle(side, height - polar_angle) * turned;
        camera.target = camera.eye + reach * forward;
        camera.up = axis;
    }

    /// Frames `bounds` without changing the direction.
    pub fn frame(&mut self, bounds: Aabb) {
        if bounds.is_empty() {
            return;
        }
        let (_, _, forward) = self.camera.axes();
        let radius = (0.5 * bounds.diagonal()).max(1e-9);
        let half = 0.5 * self.camera.vertical_fov;
        // In a narrow viewport the sides are nearer than the top.
        let narrow = half.min((half.tan() * self.aspect).atan());
        let distance = radius / narrow.max(1e-3).sin();
        self.camera.target = bounds.centre();
        self.camera.eye = self.camera.target - forward * distance;
    }

    /// Frames `bounds` from a standard direction.
    pub fn view_from(&mut self, side: ViewDirection, bounds: Aabb, up: Up) {
        let (u, back) = match up {
            Up::Y => (DVec3::Y, DVec3::Z),
            Up::Z => (DVec3::Z, DVec3::NEG_Y),
        };
        // From exactly above, forward is up in the image.
        let tilt = 1e-4 * back;
        let from = match side {
            ViewDirection::Front => back,
            ViewDirection::Back => -back,
            ViewDirection::Left => DVec3::NEG_X,
            ViewDirection::Right => DVec3::X,
            ViewDirection::Top => u + tilt,
            ViewDirection::Bottom => -u + tilt,
            ViewDirection::Corner => 0.5 * DVec3::X + 0.35 * u + back,
        };
        self.camera.up = u;
        self.camera.eye = self.camera.target + from.normalize();
        self.frame(bounds);
    }
}

/// A display colour as linear light.
pub fn linear_from_srgb(color: [u8; 3]) -> Rgb {
    let channel = |c: u8| {
        let c = f64::from(c) / 255.0;
        if c <= 0.040_45 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    Rgb::new(channel(color[0]), channel(color[1]), channel(color[2]))
}

/// Whether a camera sees all corners of a box, in an image of this width over its height.
pub fn sees_all(camera: &Camera, aspect: f64, bounds: Aabb) -> bool {
    let width = (100.0 * aspect).round().max(1.0);
    let view = Projection::new(camera, [width as u32, 100]);
    (0..8).all(|k| {
        let at = view.project(corner(bounds, k));
        at.is_some_and(|at| at.min_element() >= 0.0 && at.x <= width && at.y <= 100.0)
    })
}

/// Corner `k`, 0..8, of a box.
fn corner(bounds: Aabb, k: u32) -> DVec3 {
    let pick = |bit: u32, low: f64, high: f64| if k & bit == 0 { low } else { high };
    DVec3::new(
        pick(1, bounds.min.x, bounds.max.x),
        pick(2, bounds.min.y, bounds.max.y),
        pick(4, bounds.min.z, bounds.max.z),
    )
}

/// Whether a camera sees most of a box; many files contain cameras that do not.
pub fn sees_most(camera: &Camera, bounds: Aabb) -> bool {
    let view = Projection::new(camera, [100, 100]);
    // The middle of each half diagonal: the corners themselves are often outside of a good view.
    let points = (0..8).map(|k| 0.5 * (corner(bounds, k) + bounds.centre()));
    let shown = points.filter(|&p| {
        let at = view.project(p);
        at.is_some_and(|at| at.min_element() >= -25.0 && at.max_element() <= 125.0)
    });
    shown.count() >= 6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variants::all;

    fn view() -> ModelView {
        let mut view = ModelView::default();
        view.camera.eye = DVec3::new(0.0, 0.0, 5.0);
        view.camera.target = DVec3::ZERO;
        view
    }

    fn is_near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-6, "{a}, expected {b}");
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_stops_at_the_pole() {
        let mut v = view();
        v.orbit(std::f64::consts::FRAC_PI_2, 0.0, DVec3::Y);
        is_near(v.camera.eye, DVec3::new(-5.0, 0.0, 0.0));
        v.orbit(0.0, 100.0, DVec3::Y);
        assert!((v.camera.eye.length() - 5.0).abs() < 1e-9);
        assert!(v.camera.eye.y > 4.99 && v.camera.axes().0.is_finite());
        v.orbit(0.3, -100.0, DVec3::Y);
        assert!(v.camera.eye.y < -4.99 && v.camera.axes().0.is_finite());
    }

    #[test]
    fn a_pan_shifts_by_shares_of_the_picture() {
        let mut v = view();
        let height = 10.0 * (0.5 * v.camera.vertical_fov).tan();
        v.pan(0.0, 1.0);
        is_near(v.camera.target, DVec3::new(0.0, height, 0.0));
    }

    #[test]
    fn flying_forward_goes_where_one_looks() {
        let mut v = view();
        v.fly(DVec3::new(0.0, 0.0, 2.0), 0.0, 0.0, DVec3::Y);
        is_near(v.camera.eye, DVec3::new(0.0, 0.0, 3.0));
        v.fly(DVec3::ZERO, std::f64::consts::FRAC_PI_2, 0.0, DVec3::Y);
        is_near(v.camera.target - v.camera.eye, DVec3::new(5.0, 0.0, 0.0));
        v.fly(DVec3::ZERO, 0.0, 0.5, DVec3::Y);
        assert!(v.camera.target.y > v.camera.eye.y);
    }

    #[test]
    fn a_narrow_view_is_framed_by_its_width() {
        let bounds = Aabb::around([DVec3::new(-3.0, -0.1, -0.1), DVec3::new(3.0, 0.1, 0.1)]);
        for aspect in [0.4, 1.0, 2.5] {
            let mut v = view();
            v.aspect = aspect;
            v.frame(bounds);
            assert!(sees_all(&v.camera, aspect, bounds), "{aspect}");
        }
        assert!(!sees_all(&camera_around(bounds, 1.0, Up::Y), 0.3, bounds));
    }

    #[test]
    fn a_camera_that_was_left_lying_about_is_known() {
        let bounds = Aabb::around([DVec3::splat(-1.0), DVec3::splat(1.0)]);
        let looks_from = |eye: DVec3, target: DVec3| {
            let mut camera = view().camera;
            (camera.eye, camera.target) = (eye, target);
            sees_most(&camera, bounds)
        };
        assert!(sees_most(&camera_around(bounds, 1.0, Up::Z), bounds));
        assert!(looks_from(DVec3::new(0.0, 0.5, 5.0), DVec3::ZERO));
        assert!(!looks_from(DVec3::new(0.0, 0.0, 0.5), DVec3::ZERO));
        assert!(!looks_from(
            DVec3::new(0.0, 0.0, 5.0),
            DVec3::new(0.0, 0.0, 9.0)
        ));
    }

    #[test]
    fn standard_views_look_at_the_middle() {
        let bounds = Aabb::around([DVec3::splat(1.0), DVec3::splat(3.0)]);
        for up in [Up::Y, Up::Z] {
            for side in all() {
                let mut v = view();
                v.view_from(side, bounds, up);
                is_near(v.camera.target, DVec3::splat(2.0));
                let (right, ..) = v.camera.axes();
                assert!(right.is_finite(), "{side:?} {up:?}");
            }
        }
        let mut v = view();
        v.view_from(ViewDirection::Top, bounds, Up::Z);
        assert!(v.camera.eye.z > 3.0);
    }
}
