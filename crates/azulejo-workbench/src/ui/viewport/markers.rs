//! Overlays of the viewport: markers of lights and cameras, the grid and the axes.

use crate::app::App;
use crate::document::{ItemId, SceneCamera, light_position};
use crate::gpu::{Overlay, OverlayStyle, Projection};
use crate::view::Shading;
use azulejo::scene::math::Aabb;
use azulejo::scene::{Camera, LightKind, Shape, Up};
use egui::{Pos2, Rect, Vec2};
use glam::DVec3;

/// Yellow for lights, blue for cameras, grey for the ground.
const LIGHT: [u8; 3] = [255, 214, 64];
const CAMERA: [u8; 3] = [96, 170, 255];
const GROUND: [u8; 3] = [128, 128, 128];
const CHOSEN: [u8; 3] = [255, 150, 30];

/// What is drawn beside the model: the grid, markers of lights and cameras, handles.
pub fn overlay(app: &App, shading: Shading) -> Overlay {
    let mut overlay = Overlay::default();
    let bounds = app.document.bounds(None);
    let size = if bounds.is_empty() {
        1.0
    } else {
        bounds.diagonal().max(1e-9)
    };
    if app.view.shows_grid || bounds.is_empty() {
        grid(&mut overlay, bounds, app.document.units.up);
    }
    if app.view.shows_markers {
        for lamp in app.document.lights.iter().filter(|l| !l.hidden) {
            let ink = ink(LIGHT, app.selection.ids.contains(&lamp.id));
            light(&mut overlay, &lamp.light.kind, bounds, size, ink);
        }
        for view in seen_cameras(app, size) {
            let ink = ink(CAMERA, app.selection.ids.contains(&view.id));
            camera(&mut overlay, &view.camera, size, ink);
        }
    }
    if shading.shows_light() {
        chosen_faces(&mut overlay, app);
    }
    overlay
}

/// The cameras that are not hidden, and that one does not look through: the lines of that one would
/// cross in the middle of the view. `size` is that of the model.
fn seen_cameras(app: &App, size: f64) -> impl Iterator<Item = &SceneCamera> {
    let own = app.view.camera.eye;
    let cameras = app.document.cameras.iter().filter(|c| !c.hidden);
    cameras.filter(move |c| c.camera.eye.distance(own) > 1e-6 * size)
}

/// Marks selected faces of the model on the patches that they were divided into.
fn chosen_faces(overlay: &mut Overlay, app: &App) {
    let Some((item, faces)) = (app.selection.faces.as_ref())
        .and_then(|(id, faces)| Some((app.document.object(*id)?, faces)))
    else {
        return;
    };
    let is_lit = (app.lighting.solution.as_ref()).is_some_and(|s| s.shown(item).is_some());
    let Shape::Mesh(mesh) = &*item.shape else {
        return;
    };
    if !is_lit || item.hidden {
        return;
    }
    for face in faces.iter().map(|&f| f as usize) {
        if face < mesh.faces.len() {
            let corners = mesh.faces.get(face).iter();
            let placed =
                corners.map(|&v| item.placement.transform_point3(mesh.positions[v as usize]));
            let placed: Vec<DVec3> = placed.collect();
            overlay.polyline(&placed, true, OverlayStyle::new(CHOSEN, 2.5));
        }
    }
}

/// The light or camera whose marker is nearest to a point of the window, if one is near.
pub fn at(mouse: Pos2, rect: Rect, view: &Projection, app: &App) -> Option<ItemId> {
    const PICK_RADIUS: f32 = 12.0;
    if !app.view.shows_markers {
        return None;
    }
    let bounds = app.document.bounds(None);
    let lights = app.document.lights.iter().filter(|l| !l.hidden);
    let lights = lights.map(|l| (l.id, light_position(&l.light.kind, bounds)));
    let cameras = seen_cameras(app, bounds.diagonal().max(0.0));
    let cameras = cameras.map(|c| (c.id, c.camera.eye));
    let distance = |p: DVec3| {
        let p = view.project(p)?;
        let p = rect.min + Vec2::new(p.x as f32, p.y as f32);
        Some(p.distance(mouse)).filter(|d| *d < PICK_RADIUS)
    };
    let near = lights.chain(cameras);
    let near = near.filter_map(|(id, p)| Some((id, distance(p)?)));
    near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(id, _)| id)
}

fn ink(color: [u8; 3], is_selected: bool) -> OverlayStyle {
    if is_selected {
        OverlayStyle::new(CHOSEN, 2.5)
    } else {
        OverlayStyle::new(color, 1.5)
    }
}

/// The centre of the selection, markers included.
pub fn middle(app: &App) -> Option<DVec3> {
    let ids = &app.selection.ids;
    if ids.is_empty() {
        return None;
    }
    let bounds = app.document.bounds_with_markers(ids, 0.0);
    (!bounds.is_empty()).then(|| bounds.centre())
}

fn light(overlay: &mut Overlay, kind: &LightKind, bounds: Aabb, size: f64, ink: OverlayStyle) {
    let at = light_position(kind, bounds);
    let reach = 0.04 * size;
    match *kind {
        LightKind::Point { .. } => star(overlay, at, reach, ink),
        LightKind::Spot {
            direction, outer, ..
        } => {
            star(overlay, at, 0.5 * reach, ink);
            // A wider cone cannot be drawn; its axis can.
            let angle = outer.min(1.4);
            overlay.cone(at, direction * (4.0 * reach), angle, ink);
            overlay.arrow(at, at + direction * (4.0 * reach), ink);
        }
        LightKind::Luminaire { world_from_web, .. } => {
            star(overlay, at, reach, ink);
            overlay.arrow(at, at - world_from_web.z_axis * (4.0 * reach), ink);
        }
        LightKind::Directional { direction, .. } => {
            let (u, v) = direction.any_orthonormal_pair();
            for shift in [DVec3::ZERO, u, -u, v, -v] {
                let from = at + reach * shift;
                overlay.arrow(from, from + direction * (4.0 * reach), ink);
            }
        }
        LightKind::Ambient { .. } | LightKind::Environment(_) => {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                overlay.circle(at, axis, reach, ink);
            }
        }
    }
}

fn star(overlay: &mut Overlay, at: DVec3, reach: f64, ink: OverlayStyle) {
    overlay.cross(at, 2.0 * reach, ink);
    for s in [
        DVec3::ONE,
        DVec3::new(-1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, 1.0),
        DVec3::new(1.0, 1.0, -1.0),
    ] {
        let d = s * (0.4 * reach);
        overlay.line(at - d, at + d, ink);
    }
}

/// A pyramid with its apex at the camera's position.
fn camera(overlay: &mut Overlay, camera: &Camera, size: f64, ink: OverlayStyle) {
    let (right, up, forward) = camera.axes();
    let reach = 0.08 * size;
    let half = reach * (0.5 * camera.vertical_fov).tan().min(2.0);
    let aspect = camera
        .size
        .map_or(4.0 / 3.0, |(w, h)| f64::from(w) / f64::from(h.max(1)));
    let corner =
        |x: f64, y: f64| camera.eye + reach * forward + half * (aspect * x * right + y * up);
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    overlay.polyline(&corners, true, ink);
    for p in corners {
        overlay.line(camera.eye, p, ink);
    }
    overlay.polyline(&[corners[3], corner(0.0, 1.6), corners[2]], false, ink);
}

/// A grid on the ground with a round spacing, and the axes.
fn grid(overlay: &mut Overlay, bounds: Aabb, up: Up) {
    let (size, centre, ground) = if bounds.is_empty() {
        (4.0, DVec3::ZERO, 0.0)
    } else {
        let axis = up.axis();
        let low = bounds.min.dot(axis);
        (bounds.diagonal().max(1e-6), bounds.centre(), low)
    };
    let step = 10f64.powf((0.2 * size).log10().floor());
    let step = if size / step > 25.0 { 5.0 * step } else { step };
    let (u, v) = match up {
        Up::Y => (DVec3::X, DVec3::Z),
        Up::Z => (DVec3::X, DVec3::Y),
    };
    let count = ((0.75 * size / step).ceil() as i32).clamp(2, 40);
    let origin = |axis: DVec3| (centre.dot(axis) / step).round() * step;
    let at = |i: f64, j: f64| {
        (origin(u) + i * step) * u + (origin(v) + j * step) * v + ground * up.axis()
    };
    let far = f64::from(count);
    let thin = OverlayStyle::new(GROUND, 1.0);
    for k in -count..=count {
        let k = f64::from(k);
        overlay.line(at(k, -far), at(k, far), thin);
        overlay.line(at(-far, k), at(far, k), thin);
    }
    let axes = [
        (DVec3::X, [224, 82, 74]),
        (DVec3::Y, [130, 196, 72]),
        (DVec3::Z, [84, 146, 236]),
    ];
    for (axis, color) in axes {
        overlay.arrow(
            DVec3::ZERO,
            0.25 * size * axis,
            OverlayStyle::new(color, 2.0),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::{sample, solved};
    use crate::view::Shading;
    use std::sync::Arc;

    #[test]
    fn what_is_hidden_has_no_sign() {
        let mut app = App::quiet();
        app.document = sample();
        let lines = |app: &App| overlay(app, app.view.shading).lines.len();
        let markers = lines(&app);
        let rect = Rect::from_min_size(Pos2::ZERO, Vec2::splat(100.0));
        let view = Projection::new(&app.document.cameras[0].camera, [100, 100]);
        let bulb = view.project(DVec3::new(0.0, 1.5, 0.0)).unwrap();
        let mouse = Pos2::new(bulb.x as f32, bulb.y as f32);
        assert_eq!(at(mouse, rect, &view, &app), Some(ItemId(5)));
        app.document.lights[0].hidden = true;
        assert_eq!(at(mouse, rect, &view, &app), None);
        let without_light = lines(&app);
        assert!(without_light < markers);
        app.document.cameras[0].hidden = true;
        assert!(lines(&app) < without_light);
    }

    #[test]
    fn selected_faces_are_marked_on_what_the_solver_divided() {
        let mut app = App::quiet();
        app.document = sample();
        app.selection.faces = Some((ItemId(1), vec![1]));
        app.view.shading = Shading::Irradiance;
        let marks = |app: &App| overlay(app, app.view.shading).lines.len();
        let before = marks(&app);
        app.lighting.solution = Some(Arc::new(solved(&app.document)));
        assert_eq!(marks(&app), before + 3);
        let marked = overlay(&app, app.view.shading).lines.split_off(before);
        let corners = [(-2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| DVec3::new(x, 0.0, -y));
        assert!(marked.iter().map(|line| line.from).eq(corners));
        // The model's own polygons are highlighted directly.
        app.view.shading = Shading::Flat;
        assert_eq!(marks(&app), before);
    }
}
