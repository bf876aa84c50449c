//! How the model is looked at: nothing here changes it.

use crate::gpu::Projection;
use azulejo::scene::math::Aabb;
use azulejo::scene::{Camera, Image, Rgb, Up};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What the viewport shows of surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shading {
    /// Vertices.
    Points,
    /// Edges.
    Lines,
    /// Edges that no surface covers.
    HiddenLines,
    /// One shade a face.
    Flat,
    /// Shades that run over edges.
    #[default]
    Gouraud,
    /// With pictures on surfaces.
    Textured,
    /// The light that was solved.
    Irradiance,
    /// Irradiance by a colour map.
    FalseColor,
    /// The patches that the solver divided surfaces into.
    Patches,
    /// What a picked patch sees.
    FormFactors,
    /// Directions of surfaces, and their backs.
    Normals,
}

impl Shading {
    /// All of them, in the order of menus.
    pub const ALL: [Shading; 11] = [
        Shading::Points,
        Shading::Lines,
        Shading::HiddenLines,
        Shading::Flat,
        Shading::Gouraud,
        Shading::Textured,
        Shading::Irradiance,
        Shading::FalseColor,
        Shading::Patches,
        Shading::FormFactors,
        Shading::Normals,
    ];

    /// Its name in scripts.
    pub fn word(self) -> &'static str {
        match self {
            Shading::Points => "points",
            Shading::Lines => "lines",
            Shading::HiddenLines => "hidden-lines",
            Shading::Flat => "flat",
            Shading::Gouraud => "gouraud",
            Shading::Textured => "textured",
            Shading::Irradiance => "irradiance",
            Shading::FalseColor => "false-color",
            Shading::Patches => "patches",
            Shading::FormFactors => "form-factors",
            Shading::Normals => "normals",
        }
    }

    /// Whether it shows what was solved.
    pub fn shows_light(self) -> bool {
        matches!(
            self,
            Shading::Irradiance | Shading::FalseColor | Shading::Patches
        )
    }
}

/// A colour map that reads the same to the colour-blind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColorMap {
    /// Blue, green, yellow.
    #[default]
    Viridis,
    /// Blue to yellow, made for all kinds of colour vision.
    Cividis,
    /// Black, purple, white.
    Magma,
    /// Black to white.
    Grey,
}

impl ColorMap {
    /// All of them.
    pub const ALL: [ColorMap; 4] = [
        ColorMap::Viridis,
        ColorMap::Cividis,
        ColorMap::Magma,
        ColorMap::Grey,
    ];
}

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColor {
    /// The map.
    pub map: ColorMap,
    /// The values of both its ends, W/m² or lux; `None` takes them from what is shown.
    pub range: Option<(f64, f64)>,
    /// Equal steps are equal ratios.
    pub logarithmic: bool,
    /// Number of lines of equal value, 0 for none.
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

/// What is behind the model.
#[derive(Clone, Debug, Default)]
pub enum Backdrop {
    /// The scene's own background, or a quiet gradient where it has none.
    #[default]
    Scene,
    /// One colour, sRGB.
    Color([u8; 3]),
    /// A picture.
    Image(Arc<Image>, Fit),
}

/// Pictures are the same if they are one: to compare their pixels in every frame takes too long.
impl PartialEq for Backdrop {
    fn eq(&self, other: &Backdrop) -> bool {
        match (self, other) {
            (Backdrop::Scene, Backdrop::Scene) => true,
            (Backdrop::Color(a), Backdrop::Color(b)) => a == b,
            (Backdrop::Image(a, fit), Backdrop::Image(b, other)) => {
                Arc::ptr_eq(a, b) && fit == other
            }
            _ => false,
        }
    }
}

/// How a picture fills the background.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fit {
    /// As large as the viewport.
    #[default]
    Scaled,
    /// In the middle, in its own size.
    Centered,
    /// Again and again.
    Tiled,
}

/// The 16 colours of the first personal computers, by name, sRGB.
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

/// A side from which to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// From the front, a little above and aside.
    Corner,
}

impl ViewDirection {
    /// All of them.
    pub const ALL: [ViewDirection; 7] = [
        ViewDirection::Front,
        ViewDirection::Back,
        ViewDirection::Left,
        ViewDirection::Right,
        ViewDirection::Top,
        ViewDirection::Bottom,
        ViewDirection::Corner,
    ];
}

/// The look at the model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelView {
    /// From where.
    pub camera: Camera,
    /// What of surfaces.
    pub shading: Shading,
    /// Factor between radiance and display; `None` chooses it from what is shown.
    pub exposure: Option<f64>,
    /// How values become colours.
    pub false_color: FalseColor,
    /// What is behind.
    pub backdrop: Backdrop,
    /// Whether lights and cameras are drawn.
    pub shows_markers: bool,
    /// Whether the axes' grid is drawn.
    pub shows_grid: bool,
    /// Whether the scene's fog is drawn.
    pub shows_fog: bool,
}

impl Default for ModelView {
    fn default() -> ModelView {
        ModelView {
            camera: whole(Aabb::EMPTY, Up::Y),
            shading: Shading::default(),
            exposure: None,
            false_color: FalseColor::default(),
            backdrop: Backdrop::default(),
            shows_markers: true,
            shows_grid: false,
            shows_fog: true,
        }
    }
}

/// A camera that sees all of `bounds`; of a unit cube where there is nothing.
pub fn whole(bounds: Aabb, up: Up) -> Camera {
    let bounds = if bounds.is_empty() {
        Aabb::around([DVec3::splat(-0.5), DVec3::splat(0.5)])
    } else {
        bounds
    };
    Camera::framing(bounds, 1.0, up.axis())
}

/// How near the pole an orbit comes, radians.
const POLE: f64 = 0.01;

impl ModelView {
    /// Turns around the target: `right` and `up` radians.
    pub fn orbit(&mut self, right: f64, up: f64, axis: DVec3) {
        let camera = &mut self.camera;
        let back = camera.eye - camera.target;
        let back = DQuat::from_axis_angle(axis, -right) * back;
        let height = back.angle_between(axis);
        let wanted = (height - up).clamp(POLE, std::f64::consts::PI - POLE);
        let side = axis.cross(back).try_normalize();
        // Straight above or below there is no side; the picture's own right will do.
        let side = side.unwrap_or_else(|| camera.axes().0);
        let back = DQuat::from_axis_angle(side, wanted - height) * back;
        camera.eye = camera.target + back;
        camera.up = axis;
    }

    /// Shifts the picture: `right` and `up` in shares of its height.
    pub fn pan(&mut self, right: f64, up: f64) {
        let camera = &mut self.camera;
        let (x, y, _) = camera.axes();
        let distance = (camera.target - camera.eye).length();
        let height = 2.0 * distance * (0.5 * camera.vertical_fov).tan();
        let shift = height * (right * x + up * y);
        camera.eye += shift;
        camera.target += shift;
    }

    /// Goes nearer by a factor below 1, or further away.
    pub fn zoom(&mut self, factor: f64) {
        let camera = &mut self.camera;
        let back = (camera.eye - camera.target) * factor;
        if back.length() > 1e-9 && back.length() < 1e12 {
            camera.eye = camera.target + back;
        }
    }

    /// Flies: forward, right and up in world units, and turns the head by radians.
    pub fn fly(&mut self, step: DVec3, yaw: f64, pitch: f64, axis: DVec3) {
        let camera = &mut self.camera;
        let (right, up, forward) = camera.axes();
        let shift = step.x * right + step.y * up + step.z * forward;
        let reach = (camera.target - camera.eye).length();
        camera.eye += shift;
        let turned = DQuat::from_axis_angle(axis, -yaw) * forward;
        let height = turned.angle_between(axis);
        let wanted = (height - pitch).clamp(POLE, std::f64::consts::PI - POLE);
        let side = turned.cross(axis).try_normalize().unwrap_or(right);
        let forward = DQuat::from_axis_angle(side, height - wanted) * turned;
        camera.target = camera.eye + reach * forward;
        camera.up = axis;
    }

    /// Looks at `bounds` from where the camera is turned now.
    pub fn frame(&mut self, bounds: Aabb) {
        if bounds.is_empty() {
            return;
        }
        let (_, _, forward) = self.camera.axes();
        let radius = (0.5 * bounds.diagonal()).max(1e-9);
        let distance = radius / (0.5 * self.camera.vertical_fov).sin();
        self.camera.target = bounds.centre();
        self.camera.eye = self.camera.target - forward * distance;
    }

    /// Looks at `bounds` from a side.
    pub fn view_from(&mut self, side: ViewDirection, bounds: Aabb, up: Up) {
        let (u, back) = match up {
            Up::Y => (DVec3::Y, DVec3::Z),
            Up::Z => (DVec3::Z, DVec3::NEG_Y),
        };
        // From exactly above, the way to the front is up in the picture.
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

/// A colour of the screen as linear light.
pub fn linear(color: [u8; 3]) -> Rgb {
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

/// Whether a camera sees most of a box: many files bring cameras that were left lying about.
pub fn sees_most(camera: &Camera, bounds: Aabb) -> bool {
    let view = Projection::new(camera, [100, 100]);
    let corner = |k: u32| {
        let pick = |bit: u32, low: f64, high: f64| if k & bit == 0 { low } else { high };
        DVec3::new(
            pick(1, bounds.min.x, bounds.max.x),
            pick(2, bounds.min.y, bounds.max.y),
            pick(4, bounds.min.z, bounds.max.z),
        )
    };
    // The middle of each half diagonal: corners themselves are cut off in many a good picture.
    let points = (0..8).map(|k| 0.5 * (corner(k) + bounds.centre()));
    let shown = points.filter(|&p| {
        let at = view.project(p);
        at.is_some_and(|at| at.min_element() >= -25.0 && at.max_element() <= 125.0)
    });
    shown.count() >= 6
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_camera_that_was_left_lying_about_is_known() {
        let bounds = Aabb::around([DVec3::splat(-1.0), DVec3::splat(1.0)]);
        let looks_from = |eye: DVec3, target: DVec3| {
            let mut camera = view().camera;
            (camera.eye, camera.target) = (eye, target);
            sees_most(&camera, bounds)
        };
        assert!(sees_most(&whole(bounds, Up::Z), bounds));
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
            for side in ViewDirection::ALL {
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
