//! The orientation cube in a corner of the view: it turns with the camera, and its faces are
//! directions to look from.

use super::super::panel_context::PanelContext;
use super::gizmo::AXIS_COLORS;
use super::navigate::TURN;
use crate::command::Command;
use crate::variants::all;
use crate::view::{ModelView, ViewDirection};
use azulejo::scene::{Camera, Up};
use egui::epaint::Vertex;
use egui::{
    Color32, CursorIcon, FontId, Galley, Mesh, Painter, Pos2, Rect, Response, Sense, Shape, Stroke,
    Ui, Vec2,
};
use glam::{DVec2, DVec3};

/// Width and height of the cube's place, points.
const SIZE: f32 = 68.0;
/// Its distance from the corner of the view, points.
const GAP: f32 = 8.0;
/// Half an edge in points: turned in any way, the cube stays in its place.
const HALF: f64 = 19.0;
/// The smallest view that has room for it, points.
const SMALLEST: f32 = 160.0;
/// Faces that are seen at a flatter angle have no text; the cosine to the line of sight.
const FLAT: f64 = 0.3;

/// A face of the cube as it is seen: around the cube's centre, x right and y down, in points.
#[derive(Clone, Copy, Debug)]
struct CubeFace {
    direction: ViewDirection,
    /// The axis that it is perpendicular to: 0, 1 or 2.
    axis: usize,
    corners: [DVec2; 4],
    centre: DVec2,
    /// A point to the right and one upward, for someone who looks straight at it.
    right: DVec2,
    up: DVec2,
    /// Cosine of the angle to the line of sight: 1 if it is seen straight on.
    facing: f64,
}

/// The directions that the cube has faces for.
fn sides() -> impl Iterator<Item = ViewDirection> {
    all().filter(|&direction| direction != ViewDirection::Corner)
}

/// The normal of a face, and what is right and up in the view from there.
fn axes_of(direction: ViewDirection, up: Up) -> (DVec3, DVec3, DVec3) {
    let (u, back) = match up {
        Up::Y => (DVec3::Y, DVec3::Z),
        Up::Z => (DVec3::Z, DVec3::NEG_Y),
    };
    let (normal, above) = match direction {
        ViewDirection::Front | ViewDirection::Corner => (back, u),
        ViewDirection::Back => (-back, u),
        ViewDirection::Left => (DVec3::NEG_X, u),
        ViewDirection::Right => (DVec3::X, u),
        ViewDirection::Top => (u, -back),
        ViewDirection::Bottom => (-u, back),
    };
    (normal, above.cross(normal), above)
}

/// The faces that a camera sees, the nearest last.
fn faces(camera: &Camera, up: Up) -> Vec<CubeFace> {
    let (x, y, forward) = camera.axes();
    let seen = |p: DVec3| DVec2::new(p.dot(x), -p.dot(y));
    let mut faces: Vec<CubeFace> = sides()
        .map(|direction| {
            let (normal, right, above) = axes_of(direction, up);
            let around = [-right - above, right - above, right + above, -right + above];
            CubeFace {
                direction,
                axis: (0..3).find(|&k| normal[k] != 0.0).unwrap_or(0),
                corners: around.map(|side| HALF * seen(normal + side)),
                centre: HALF * seen(normal),
                right: seen(right),
                up: seen(above),
                facing: -normal.dot(forward),
            }
        })
        .filter(|face| face.facing > 1e-3)
        .collect();
    faces.sort_by(|a, b| a.facing.total_cmp(&b.facing));
    faces
}

/// The direction of the face at a point.
fn face_at(faces: &[CubeFace], at: DVec2) -> Option<ViewDirection> {
    let is_inside = |face: &&CubeFace| {
        let sides = (0..4).map(|k| {
            let (a, b) = (face.corners[k], face.corners[(k + 1) % 4]);
            (b - a).perp_dot(at - a)
        });
        let signs: Vec<bool> = sides.map(|side| side <= 0.0).collect();
        signs.iter().all(|&s| s == signs[0])
    };
    faces.iter().rev().find(is_inside).map(|f| f.direction)
}

/// Whether there is a cube in a view: it may be switched off, and a small view has no room for it.
fn is_shown(rect: Rect, view: &ModelView) -> bool {
    view.shows_cube && rect.width() >= SMALLEST && rect.height() >= SMALLEST
}

/// The part of a view for cards of this width, which must not cover the cube.
pub fn room_for_cards(rect: Rect, view: &ModelView, width: f32) -> Rect {
    let is_beside = rect.width() >= width + 2.0 * (SIZE + 2.0 * GAP);
    if is_beside || !is_shown(rect, view) {
        return rect;
    }
    let below = rect.min + Vec2::new(0.0, SIZE - 2.0 * GAP);
    Rect::from_min_max(below, rect.max)
}

/// Draws the cube; a click looks from a face, dragging orbits. It takes no focus: keys go on to
/// move the view.
pub fn show(ui: &mut Ui, viewport: &Response, cx: &mut PanelContext, view: &ModelView) {
    let rect = viewport.rect;
    if !is_shown(rect, view) {
        return;
    }
    let corner = rect.right_top() + Vec2::new(-GAP - SIZE, GAP);
    let place = Rect::from_min_size(corner, Vec2::splat(SIZE));
    let sense = Sense::CLICK | Sense::DRAG;
    let response = ui.interact(place, ui.scope_id().with("cube"), sense);
    let name = cx.tr("Orientation cube");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
    // A press outside of what has the focus ends it; this one is a part of the view.
    let is_used = response.is_pointer_button_down_on() || response.clicked();
    if is_used && viewport.lost_focus() {
        viewport.request_focus();
    }
    let up = cx.app.document.units.up;
    let faces = faces(&view.camera, up);
    let mouse = response.hover_pos().filter(|_| !response.dragged());
    let pointed = mouse.and_then(|mouse| {
        let at = mouse - place.center();
        face_at(&faces, DVec2::new(f64::from(at.x), f64::from(at.y)))
    });
    let mut look = view.clone();
    if response.dragged() {
        let by = response.drag_delta();
        look.orbit(TURN * f64::from(by.x), TURN * f64::from(by.y), up.axis());
        ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
    } else if let Some(side) = pointed {
        ui.ctx().set_cursor_icon(CursorIcon::PointingHand);
        if response.clicked() {
            look.view_from(side, cx.app.document.model_bounds(), up);
        }
    }
    if look != *view {
        cx.send(Command::SetView(Box::new(look)));
    }
    let painter = ui.painter().with_clip_rect(rect);
    for face in &faces {
        paint(&painter, place.center(), face, pointed, label(cx, face));
    }
}

fn label(cx: &PanelContext, face: &CubeFace) -> &'static str {
    match face.direction {
        ViewDirection::Front | ViewDirection::Corner => cx.tr("Front"),
        ViewDirection::Back => cx.tr("Back"),
        ViewDirection::Left => cx.tr("Left"),
        ViewDirection::Right => cx.tr("Right"),
        ViewDirection::Top => cx.tr("Top"),
        ViewDirection::Bottom => cx.tr("Bottom"),
    }
}

/// Draws a face in the colour of its axis, brighter the more it is turned to the viewer.
fn paint(
    painter: &Painter,
    centre: Pos2,
    face: &CubeFace,
    pointed: Option<ViewDirection>,
    text: &str,
) {
    let is_pointed = pointed == Some(face.direction);
    let light = if is_pointed {
        255.0
    } else {
        150.0 + 80.0 * face.facing as f32
    };
    let tint = if is_pointed { 0.6 } else { 0.3 };
    let [r, g, b, _] = AXIS_COLORS[face.axis].to_array();
    let mixed = [r, g, b].map(|c| ((1.0 - tint) * light + tint * f32::from(c)) as u8);
    let fill = Color32::from_rgb(mixed[0], mixed[1], mixed[2]);
    let corners = face.corners.map(|p| centre + points(p)).to_vec();
    let edge = Stroke::new(1.0, Color32::from_gray(60));
    painter.add(Shape::convex_polygon(corners, fill, edge));
    if face.facing > FLAT {
        let font = FontId::proportional(13.0);
        let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::from_gray(20));
        painter.add(lying_text(painter, &galley, centre, face));
    }
}

/// A text that lies on a face, and is foreshortened with it. Text shapes can only be rotated, so
/// its glyphs are placed one by one.
fn lying_text(painter: &Painter, galley: &Galley, centre: Pos2, face: &CubeFace) -> Mesh {
    let size = galley.size();
    let fits = (1.75 * HALF as f32 / size.x.max(1.0)).min(1.0);
    let atlas = painter.fonts(|fonts| fonts.font_image_size());
    let (right, up) = (fits * points(face.right), fits * points(face.up));
    let mut mesh = Mesh::default();
    for row in &galley.rows {
        let first = mesh.vertices.len() as u32;
        let glyphs = &row.visuals.mesh;
        mesh.indices
            .extend(glyphs.indices.iter().map(|k| first + k));
        mesh.vertices.extend(glyphs.vertices.iter().map(|vertex| {
            let at = row.pos.to_vec2() + vertex.pos.to_vec2() - 0.5 * size;
            Vertex {
                pos: centre + points(face.centre) + at.x * right - at.y * up,
                uv: Pos2::new(vertex.uv.x / atlas[0] as f32, vertex.uv.y / atlas[1] as f32),
                color: vertex.color,
            }
        }));
    }
    mesh
}

fn points(v: DVec2) -> Vec2 {
    Vec2::new(v.x as f32, v.y as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::math::Aabb;

    fn view_from(direction: ViewDirection, up: Up) -> ModelView {
        let mut view = ModelView::default();
        let bounds = Aabb::around([DVec3::ZERO, DVec3::splat(2.0)]);
        view.view_from(direction, bounds, up);
        view
    }

    #[test]
    fn looking_from_a_face_shows_it_straight_and_upright() {
        for up in [Up::Y, Up::Z] {
            for direction in sides() {
                let view = view_from(direction, up);
                let seen = faces(&view.camera, up);
                assert_eq!(face_at(&seen, DVec2::ZERO), Some(direction), "{up:?}");
                let face = seen.last().unwrap();
                assert!(face.facing > 0.999 && face.centre.length() < 0.1);
                assert!(
                    (face.right - DVec2::X).length() < 1e-3,
                    "{direction:?} {up:?}"
                );
                assert!((face.up + DVec2::Y).length() < 1e-3, "{direction:?} {up:?}");
            }
        }
    }

    #[test]
    fn a_corner_shows_three_faces_side_by_side_and_the_nearest_last() {
        for up in [Up::Y, Up::Z] {
            let view = view_from(ViewDirection::Corner, up);
            let seen = faces(&view.camera, up);
            let order: Vec<_> = seen.iter().map(|f| f.direction).collect();
            use ViewDirection::{Front, Right, Top};
            assert_eq!(order, [Top, Right, Front]);
            for face in &seen {
                assert_eq!(face_at(&seen, face.centre), Some(face.direction));
                let inside = |p: &DVec2| p.length() < 0.5 * f64::from(SIZE);
                assert!(face.corners.iter().all(inside), "{face:?}");
            }
            // Each face lies where its direction is.
            assert!(seen[0].centre.y < -5.0 && seen[1].centre.x > 5.0);
        }
    }

    #[test]
    fn beside_the_cube_is_no_face() {
        let view = view_from(ViewDirection::Front, Up::Y);
        let seen = faces(&view.camera, Up::Y);
        assert_eq!(face_at(&seen, DVec2::new(HALF + 1.0, 0.0)), None);
        assert_eq!(face_at(&seen, DVec2::new(0.0, -HALF - 1.0)), None);
        let near = DVec2::new(HALF - 1.0, HALF - 1.0);
        assert_eq!(face_at(&seen, near), Some(ViewDirection::Front));
    }
}
