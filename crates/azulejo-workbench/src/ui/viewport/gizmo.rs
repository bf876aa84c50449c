//! The transform gizmo: handles that move, rotate and scale the selection.

use crate::gpu::Projection;
use egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2};
use glam::{DAffine3, DVec2, DVec3};

/// What the handles do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GizmoMode {
    /// Move along an axis.
    #[default]
    Move,
    /// Rotate about an axis.
    Rotate,
    /// Scale along an axis, or uniformly with the handle in the middle.
    Scale,
}

/// A handle being dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GizmoHandle {
    mode: GizmoMode,
    /// 0, 1, 2 for the axes; 3 for uniform scaling.
    axis: usize,
    centre: DVec3,
    /// The mouse position at the last update.
    last: Pos2,
}

/// Length of an axis on the screen, points.
const LENGTH: f64 = 80.0;
/// Picking distance from a handle, points.
const PICK_RADIUS: f32 = 8.0;
const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
/// Red, green and blue that also differ in brightness.
pub(super) const AXIS_COLORS: [Color32; 3] = [
    Color32::from_rgb(224, 82, 74),
    Color32::from_rgb(130, 196, 72),
    Color32::from_rgb(84, 146, 236),
];

/// The gizmo of a selection in a viewport.
pub struct Gizmo<'a> {
    /// The projection, in points of the viewport.
    pub view: &'a Projection,
    /// The rectangle of the viewport on the screen.
    pub rect: Rect,
    /// The centre of the selection.
    pub centre: DVec3,
    pub mode: GizmoMode,
}

impl Gizmo<'_> {
    fn on_screen(&self, p: DVec3) -> Option<Pos2> {
        let p = self.view.project(p)?;
        Some(self.rect.min + Vec2::new(p.x as f32, p.y as f32))
    }

    /// Length of a handle in world units.
    fn reach(&self) -> f64 {
        LENGTH * self.view.pixel_at(self.centre)
    }

    /// The polyline of a handle on the screen.
    fn lines(&self, axis: usize) -> Vec<Pos2> {
        let reach = self.reach();
        match self.mode {
            GizmoMode::Rotate => {
                let (u, v) = AXES[axis].any_orthonormal_pair();
                let at = |k: i32| {
                    let (s, c) = (std::f64::consts::TAU * f64::from(k) / 48.0).sin_cos();
                    self.centre + reach * (c * u + s * v)
                };
                (0..=48).filter_map(|k| self.on_screen(at(k))).collect()
            }
            GizmoMode::Move | GizmoMode::Scale => [self.centre, self.centre + reach * AXES[axis]]
                .into_iter()
                .filter_map(|p| self.on_screen(p))
                .collect(),
        }
    }

    /// The handle under the mouse.
    pub fn grip_at(&self, mouse: Pos2) -> Option<GizmoHandle> {
        let grip = |axis| GizmoHandle {
            mode: self.mode,
            axis,
            centre: self.centre,
            last: mouse,
        };
        let middle = self.on_screen(self.centre)?;
        if self.mode == GizmoMode::Scale && middle.distance(mouse) < PICK_RADIUS {
            return Some(grip(3));
        }
        let distance = |axis: usize| {
            let lines = self.lines(axis);
            let pieces = lines.windows(2).map(|w| to_segment(mouse, w[0], w[1]));
            pieces.fold(f32::INFINITY, f32::min)
        };
        let nearest = (0..3)
            .map(|k| (k, distance(k)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        nearest
            .filter(|(_, d)| *d < PICK_RADIUS)
            .map(|(k, _)| grip(k))
    }

    /// Draws the handles; the active one is highlighted.
    pub fn paint(&self, painter: &Painter, lit: Option<&GizmoHandle>) {
        for (axis, own) in AXIS_COLORS.into_iter().enumerate() {
            let is_lit = lit.is_some_and(|g| g.axis == axis || g.axis == 3);
            let color = if is_lit { Color32::WHITE } else { own };
            let lines = self.lines(axis);
            let stroke = Stroke::new(if is_lit { 3.5 } else { 2.5 }, color);
            lines.windows(2).for_each(|w| {
                painter.line_segment([w[0], w[1]], stroke);
            });
            let Some(&end) = lines.last().filter(|_| lines.len() == 2) else {
                continue;
            };
            match self.mode {
                GizmoMode::Scale => {
                    painter.rect_filled(Rect::from_center_size(end, Vec2::splat(9.0)), 1.0, color);
                }
                _ => tip(painter, lines[0], end, color),
            }
        }
        if let (GizmoMode::Scale, Some(middle)) = (self.mode, self.on_screen(self.centre)) {
            let square = Rect::from_center_size(middle, Vec2::splat(10.0));
            painter.rect_filled(square, 1.0, Color32::LIGHT_GRAY);
        }
    }

    /// The world-space transform for dragging a handle to `mouse`. Updates the handle's last
    /// position.
    pub fn drag(&self, grip: &mut GizmoHandle, mouse: Pos2) -> Option<DAffine3> {
        let map = match grip.mode {
            GizmoMode::Move => {
                let axis = AXES[grip.axis];
                let by = self.along(grip, axis, mouse)? - self.along(grip, axis, grip.last)?;
                DAffine3::from_translation(by * axis)
            }
            GizmoMode::Rotate => {
                let by = self.around(grip, mouse)? - self.around(grip, grip.last)?;
                about(grip.centre, DAffine3::from_axis_angle(AXES[grip.axis], by))
            }
            GizmoMode::Scale => {
                let factor = self.factor(grip, mouse)?;
                let mut scale = DVec3::ONE;
                match grip.axis {
                    3 => scale = DVec3::splat(factor),
                    axis => scale[axis] = factor,
                }
                about(grip.centre, DAffine3::from_scale(scale))
            }
        };
        grip.last = mouse;
        if grip.mode == GizmoMode::Move {
            grip.centre = map.transform_point3(grip.centre);
        }
        map.is_finite().then_some(map)
    }

    /// Position of the mouse along an axis: the point of the axis nearest to the mouse ray.
    fn along(&self, grip: &GizmoHandle, axis: DVec3, mouse: Pos2) -> Option<f64> {
        let ray = self.view.ray(in_view(mouse, self.rect));
        let (d, w) = (ray.direction.normalize(), ray.origin - grip.centre);
        let b = d.dot(axis);
        let parallel = 1.0 - b * b;
        // An axis that points at the camera has no such point.
        (parallel > 1e-4).then(|| (w.dot(axis) - b * w.dot(d)) / parallel)
    }

    /// The angle of the mouse about the centre, as seen along the axis.
    fn around(&self, grip: &GizmoHandle, mouse: Pos2) -> Option<f64> {
        let middle = self.on_screen(grip.centre)?;
        let v = mouse - middle;
        let toward_eye = self
            .view
            .ray(in_view(middle, self.rect))
            .direction
            .dot(AXES[grip.axis]);
        let angle = f64::from(v.y).atan2(f64::from(v.x));
        // Screen angles run clockwise; seen from behind, the axis turns the other way.
        Some(if toward_eye < 0.0 { -angle } else { angle })
    }

    fn factor(&self, grip: &GizmoHandle, mouse: Pos2) -> Option<f64> {
        let distance = |p: Pos2| match grip.axis {
            3 => Some(100.0 + f64::from(p.x - grip.last.x) - f64::from(p.y - grip.last.y)),
            axis => self.along(grip, AXES[axis], p),
        };
        let factor = distance(mouse)? / distance(grip.last)?;
        (factor.is_finite() && factor > 0.05 && factor < 20.0).then_some(factor)
    }
}

fn in_view(p: Pos2, rect: Rect) -> DVec2 {
    let p = p - rect.min;
    DVec2::new(f64::from(p.x), f64::from(p.y))
}

/// A linear map about another point than the origin.
fn about(centre: DVec3, map: DAffine3) -> DAffine3 {
    DAffine3::from_translation(centre) * map * DAffine3::from_translation(-centre)
}

fn to_segment(p: Pos2, a: Pos2, b: Pos2) -> f32 {
    let (ab, ap) = (b - a, p - a);
    let t = (ap.dot(ab) / ab.length_sq().max(1e-6)).clamp(0.0, 1.0);
    (ap - t * ab).length()
}

fn tip(painter: &Painter, from: Pos2, to: Pos2, color: Color32) {
    let along = (to - from).normalized();
    let across = along.rot90();
    let points = vec![to + 10.0 * along, to + 5.0 * across, to - 5.0 * across];
    painter.add(egui::Shape::convex_polygon(points, color, Stroke::NONE));
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Camera;

    fn view() -> Projection {
        let camera = Camera {
            name: String::new(),
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 0.6,
            size: None,
        };
        Projection::new(&camera, [400, 400])
    }

    fn gizmo(view: &Projection, mode: GizmoMode) -> Gizmo<'_> {
        Gizmo {
            view,
            rect: Rect::from_min_size(Pos2::new(50.0, 20.0), Vec2::splat(400.0)),
            centre: DVec3::ZERO,
            mode,
        }
    }

    #[test]
    fn an_axis_follows_the_mouse() {
        let view = view();
        let gizmo = gizmo(&view, GizmoMode::Move);
        let to = |p: DVec3| gizmo.on_screen(p).unwrap();
        let start = to(DVec3::new(0.5, 0.0, 0.0));
        let mut grip = gizmo.grip_at(start).unwrap();
        assert_eq!(grip.axis, 0);
        for x in [0.7, 1.5, -2.0] {
            let before = grip.centre.x;
            let map = gizmo
                .drag(&mut grip, to(DVec3::new(x + 0.5, 0.1, 0.0)))
                .unwrap();
            let moved = map.transform_point3(DVec3::ZERO);
            // Well below a pixel.
            assert!((before + moved.x - x).abs() < 1e-3, "{moved}");
            assert!(moved.y.abs() < 1e-9 && moved.z.abs() < 1e-9);
        }
    }

    #[test]
    fn rings_turn_as_the_mouse_does() {
        let view = view();
        let gizmo = gizmo(&view, GizmoMode::Rotate);
        let at = |degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            gizmo
                .on_screen(gizmo.reach() * DVec3::new(c, s, 0.0))
                .unwrap()
        };
        let mut grip = gizmo.grip_at(at(40.0)).unwrap();
        assert_eq!(grip.axis, 2);
        let map = gizmo.drag(&mut grip, at(70.0)).unwrap();
        let turned = map.transform_vector3(DVec3::X);
        assert!(
            (turned.y.atan2(turned.x).to_degrees() - 30.0).abs() < 0.1,
            "{turned}"
        );
    }

    #[test]
    fn scaling_leaves_the_middle_where_it_is() {
        let view = view();
        let mut gizmo = gizmo(&view, GizmoMode::Scale);
        gizmo.centre = DVec3::new(1.0, 0.0, 0.0);
        let to = |p: DVec3| gizmo.on_screen(p).unwrap();
        let mut grip = gizmo.grip_at(to(DVec3::new(1.0, 0.5, 0.0))).unwrap();
        let map = gizmo
            .drag(&mut grip, to(DVec3::new(1.0, 1.0, 0.0)))
            .unwrap();
        assert!((map.transform_point3(gizmo.centre) - gizmo.centre).length() < 1e-9);
        let grown = map.transform_vector3(DVec3::Y).y;
        assert!((grown - 2.0).abs() < 1e-3, "{grown}");
    }

    #[test]
    fn far_from_all_handles_there_is_none() {
        let view = view();
        for mode in [GizmoMode::Move, GizmoMode::Rotate, GizmoMode::Scale] {
            assert_eq!(gizmo(&view, mode).grip_at(Pos2::new(60.0, 30.0)), None);
        }
    }
}
