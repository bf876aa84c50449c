//! Perspective views from the VIEW and VPORT tables.

use super::axes::world_from_entity;
use super::record::Record;
use azulejo_scene::Camera;
use glam::DQuat;

/// Film width to which lens lengths refer, in millimetres.
const FILM: f64 = 36.0;

/// The camera of a VIEW or VPORT; `None` for a parallel projection, which has no eye point.
pub(super) fn camera(record: &Record) -> Option<Camera> {
    const PERSPECTIVE: i64 = 1;
    let is_view = record.kind == b"VIEW";
    // Codes of direction, target, twist; a view has a width, a viewport an aspect ratio.
    let (direction, target, twist) = if is_view { (11, 12, 50) } else { (16, 17, 51) };
    let aspect = match (is_view, record.real(41, 0.0)) {
        (true, width) => width / record.real(40, 0.0),
        (false, aspect) => aspect,
    };
    if record.integer(71, 0) & PERSPECTIVE == 0 {
        return None;
    }
    let (to_eye, target) = (record.point(direction), record.point(target));
    let aspect = if aspect.is_finite() && aspect > 0.0 {
        aspect
    } else {
        1.0
    };
    let lens = Some(record.real(42, 50.0))
        .filter(|lens| *lens > 0.0)
        .unwrap_or(50.0);
    let axes = world_from_entity(to_eye);
    // The twist rotates the image counter-clockwise, hence the camera clockwise.
    let untwist = DQuat::from_axis_angle(axes.z_axis, -record.real(twist, 0.0).to_radians());
    let camera = Camera {
        name: record.text(2).trim_start_matches('*').to_owned(),
        eye: target + to_eye,
        target,
        up: untwist * axes.y_axis,
        vertical_fov: 2.0 * (0.5 * FILM / lens / aspect).atan(),
        size: None,
    };
    is_usable(&camera).then_some(camera)
}

/// Whether the camera has a view direction and a usable field of view.
fn is_usable(camera: &Camera) -> bool {
    let (right, up, forward) = camera.axes();
    let angle = 1e-6..std::f64::consts::PI - 1e-6;
    [camera.eye, right, up, forward]
        .iter()
        .all(|v| v.is_finite())
        && angle.contains(&camera.vertical_fov)
}
