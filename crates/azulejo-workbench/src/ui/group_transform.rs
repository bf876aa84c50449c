//! Transforming several objects by numbers.

use super::inputs;
use super::inspector::{speed, vector};
use super::panel_context::PanelContext;
use super::viewport::middle;
use crate::document::Edit;
use egui::{Button, Grid, Id, Ui};
use glam::{DAffine3, DQuat, DVec3, EulerRot};

/// The transform to apply.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GroupTransform {
    /// World units.
    shift: DVec3,
    /// About x, then y, then z; degrees.
    turn: DVec3,
    /// > 0.
    factor: f64,
}

impl Default for GroupTransform {
    fn default() -> GroupTransform {
        GroupTransform {
            shift: DVec3::ZERO,
            turn: DVec3::ZERO,
            factor: 1.0,
        }
    }
}

impl GroupTransform {
    /// The map for objects with their centre at `centre`, which is translated but otherwise fixed.
    fn map(&self, centre: DVec3) -> DAffine3 {
        let [x, y, z] = self.turn.to_array().map(f64::to_radians);
        let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
        let about =
            DAffine3::from_scale_rotation_translation(DVec3::splat(self.factor), turn, DVec3::ZERO);
        DAffine3::from_translation(centre + self.shift)
            * about
            * DAffine3::from_translation(-centre)
    }
}

/// Draws the fields. The transform is applied only on request, as one undo step: while dragging,
/// the centre of rotation would move.
pub fn show(ui: &mut Ui, cx: &mut PanelContext) {
    let id = Id::unique("together");
    let mut changes: GroupTransform = ui.data(|d| d.get_temp(id)).unwrap_or_default();
    Grid::new("together").num_columns(2).show(ui, |ui| {
        let speed = speed(&cx.app.document);
        vector(ui, cx.tr("Move by"), &mut changes.shift, speed);
        vector(ui, cx.tr("Rotate by °"), &mut changes.turn, 0.5);
        let drag = inputs::number(&mut changes.factor, 1e-6..=1e6).speed(0.01);
        inputs::labelled_row(ui, cx.tr("Scale by"), drag);
    });
    let button = Button::new(cx.tr("Apply to all"));
    let is_some = changes != GroupTransform::default();
    if ui.add_enabled(is_some, button).clicked() {
        let centre = middle(cx.app).unwrap_or_default();
        let ids = cx.app.selection.ids.clone();
        cx.edit(Edit::Transform(ids, changes.map(centre)));
        changes = GroupTransform::default();
    }
    ui.data_mut(|d| d.insert_temp(id, changes));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_moved_and_what_is_beside_it_turns_and_grows() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let changes = GroupTransform {
            shift: DVec3::new(0.0, 0.5, 0.0),
            turn: DVec3::new(90.0, 0.0, 90.0),
            factor: 2.0,
        };
        let map = changes.map(centre);
        let close = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a}, expected {b}");
        close(map.transform_point3(centre), centre + changes.shift);
        // About x first: y becomes z, which the rotation about z preserves.
        close(map.transform_vector3(DVec3::Y), 2.0 * DVec3::Z);
        close(map.transform_vector3(DVec3::X), 2.0 * DVec3::Y);
        assert_eq!(GroupTransform::default().map(centre), DAffine3::IDENTITY);
    }
}
