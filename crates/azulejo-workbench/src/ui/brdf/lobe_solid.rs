//! A lobe as a solid, rotated by dragging or with the arrow keys.

use super::lobes::{LobeSurface, RINGS, SECTORS};
use super::theme::{brightness, grid};
use super::view::LobeView;
use crate::ui::focus::keep_arrows;
use crate::words::Language;
use egui::{Color32, Key, Mesh, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Degrees per point of a drag, and per press of an arrow key.
const TURN: [f32; 2] = [0.5, 5.0];

/// Size and scale of the drawing.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeViewport {
    /// Size on the screen, points.
    pub size: Vec2,
    /// The value drawn with radius 1.
    pub top: f64,
    pub color: Color32,
}

/// Draws a lobe; dragging and arrow keys change `view.orbit`.
pub(super) fn draw(
    ui: &mut Ui,
    language: Language,
    view: &mut LobeView,
    body: &LobeSurface,
    stage: LobeViewport,
) {
    let LobeViewport { size, top, color } = stage;
    let response = ui.allocate_response(size, Sense::click_and_drag());
    if response.clicked() || response.drag_started() {
        response.request_focus();
    }
    turn(ui, &response, &mut view.orbit);
    let words = language.tr("Lobe in 3D; drag or use the arrow keys to rotate it");
    let info = || egui::WidgetInfo::labeled(egui::accesskit::Role::Image, true, words);
    response.widget_info(info);
    if !ui.is_rect_visible(response.rect) {
        return;
    }
    let painter = ui.painter_at(response.rect);
    let eye = OrbitCamera::new(view.orbit, response.rect);
    painter.extend(eye.floor(grid(ui)));
    painter.add(eye.solid(&lobe_mesh(body, view, top), color));
    painter.extend(eye.light(body.light, ui.visuals().strong_text_color()));
    if brightness(body.mirrored) > 5e-4 {
        let away = DVec3::new(-body.light.x, -body.light.y, body.light.z);
        let ends = [DVec3::ZERO, away].map(|p| eye.project(p));
        painter.extend(Shape::dotted_line(&ends, color, 5.0, 1.5));
    }
    if response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        painter.rect_stroke(
            response.rect.shrink(1.0),
            3,
            stroke,
            egui::StrokeKind::Inside,
        );
    }
    response.on_hover_text(words);
}

/// The largest value of a lobe.
pub(super) fn largest_value(view: &LobeView, body: &LobeSurface) -> f64 {
    let points = body.rings.iter().flatten();
    let values = points.map(|(w, f)| view.value(brightness(*f), w.z));
    values.filter(|v| v.is_finite()).fold(0.0, f64::max)
}

fn turn(ui: &Ui, response: &egui::Response, orbit: &mut [f32; 2]) {
    let mut by = Vec2::ZERO;
    if response.dragged() {
        by = response.drag_delta() * vec2(-TURN[0], TURN[0]);
    }
    if response.has_focus() {
        keep_arrows(response);
        let pressed = |key| ui.input(|i| f32::from(u8::from(i.key_pressed(key))));
        by.x += TURN[1] * (pressed(Key::ArrowRight) - pressed(Key::ArrowLeft));
        by.y += TURN[1] * (pressed(Key::ArrowUp) - pressed(Key::ArrowDown));
    }
    orbit[0] = (orbit[0] + by.x).rem_euclid(360.0);
    orbit[1] = (orbit[1] + by.y).clamp(-5.0, 90.0);
}

/// The surface of the lobe in space.
fn lobe_mesh(body: &LobeSurface, view: &LobeView, top: f64) -> Vec<Vec<DVec3>> {
    let point = |&(w, f): &(DVec3, _)| w * view.share(view.value(brightness(f), w.z), top);
    body.rings
        .iter()
        .map(|ring| ring.iter().map(point).collect())
        .collect()
}

/// An orthographic camera that looks at the origin.
struct OrbitCamera {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    /// Points on the screen per unit of length.
    zoom: f64,
    center: Pos2,
}

impl OrbitCamera {
    fn new([around, above]: [f32; 2], rect: Rect) -> OrbitCamera {
        let [around, above] = [around, above].map(|a| f64::from(a).to_radians());
        let ((sa, ca), (sb, cb)) = (around.sin_cos(), above.sin_cos());
        let toward = DVec3::new(cb * ca, cb * sa, sb);
        // Also valid when looking straight down.
        let right = DVec3::new(-sa, ca, 0.0);
        let (width, height) = (f64::from(rect.width()), f64::from(rect.height()));
        let zoom = (0.44 * width).min(0.6 * height);
        let drop = 0.5 * zoom * cb;
        OrbitCamera {
            right,
            up: toward.cross(right),
            toward,
            zoom,
            center: pos2(rect.center().x, rect.center().y + drop as f32),
        }
    }

    fn project(&self, p: DVec3) -> Pos2 {
        let flat = self.zoom * DVec2::new(p.dot(self.right), -p.dot(self.up));
        self.center + vec2(flat.x as f32, flat.y as f32)
    }

    /// Circles on the surface, and its axes.
    fn floor(&self, color: Color32) -> Vec<Shape> {
        let stroke = Stroke::new(1.0, color);
        let circle = |r: f64| {
            let point = |k: i32| {
                let (sin, cos) = (TAU * f64::from(k) / 48.0).sin_cos();
                self.project(r * DVec3::new(cos, sin, 0.0))
            };
            Shape::closed_line((0..48).map(point).collect(), stroke)
        };
        let axis = |a: DVec3| Shape::line_segment([self.project(-a), self.project(a)], stroke);
        let circles = [0.5, 1.0].map(circle);
        circles
            .into_iter()
            .chain([DVec3::X, DVec3::Y].map(axis))
            .collect()
    }

    /// Triangles sorted back to front, shaded by their angle to a lamp.
    fn solid(&self, rings: &[Vec<DVec3>], color: Color32) -> Mesh {
        let mut triangles = Vec::with_capacity(2 * RINGS * SECTORS);
        for pair in rings.windows(2) {
            for k in 0..pair[0].len().min(pair[1].len()) {
                let next = (k + 1) % pair[0].len();
                let [a, b, c, d] = [pair[0][k], pair[0][next], pair[1][next], pair[1][k]];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let depth = |t: &[DVec3; 3]| (t[0] + t[1] + t[2]).dot(self.toward);
        triangles.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let lamp = (self.toward + 0.3 * self.right + 0.9 * self.up).normalize();
        let mut mesh = Mesh::default();
        for corners in triangles {
            self.triangle(&mut mesh, corners, lamp, color);
        }
        mesh
    }

    fn triangle(&self, mesh: &mut Mesh, corners: [DVec3; 3], lamp: DVec3, color: Color32) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(normal) = normal.try_normalize() else {
            return;
        };
        let normal = normal * normal.dot(self.toward).signum();
        let light = 0.4 + 0.6 * normal.dot(lamp).max(0.0);
        let shade = |c: u8| (f64::from(c) * light) as u8;
        let color = Color32::from_rgb(shade(color.r()), shade(color.g()), shade(color.b()));
        let first = mesh.vertices.len() as u32;
        corners
            .iter()
            .for_each(|c| mesh.colored_vertex(self.project(*c), color));
        mesh.add_triangle(first, first + 1, first + 2);
    }

    /// The direction of the light.
    fn light(&self, light: DVec3, color: Color32) -> Vec<Shape> {
        let [from, to] = [1.1, 0.08].map(|t| self.project(light * t));
        let arrow = to - from;
        let along = arrow.normalized();
        let side = 3.0 * along.rot90();
        let head = vec![to, to - 8.0 * along + side, to - 8.0 * along - side];
        vec![
            Shape::line_segment([from, to - 4.0 * along], Stroke::new(1.5, color)),
            Shape::convex_polygon(head, color, Stroke::NONE),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_is_drawn_last() {
        let rect = Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0));
        let eye = OrbitCamera::new([-90.0, 0.0], rect);
        // Seen from −y, x is to the right and z up.
        assert!(eye.project(DVec3::X).x > eye.project(DVec3::ZERO).x);
        assert!(eye.project(DVec3::Z).y < eye.project(DVec3::ZERO).y);
        let far = [DVec3::Y, DVec3::Y + DVec3::X, DVec3::Y + DVec3::Z];
        let near = far.map(|p| p - 2.0 * DVec3::Y);
        let rings = [[near[0], far[0]], [near[1], far[1]]].map(|r| r.to_vec());
        let mesh = eye.solid(&rings, Color32::WHITE);
        assert_eq!(mesh.vertices.len() % 3, 0);
        assert!(mesh.vertices.iter().all(|v| v.pos.is_finite()));
    }

    #[test]
    fn straight_from_above_there_is_a_view() {
        let rect = Rect::from_min_size(Pos2::ZERO, vec2(200.0, 100.0));
        let eye = OrbitCamera::new([-106.0, 90.0], rect);
        assert!(eye.project(DVec3::X).is_finite() && eye.up.is_finite());
    }
}
