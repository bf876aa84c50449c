//! Positions and bounding boxes of the markers of lights and cameras.

use super::{ItemId, SceneDocument};
use azulejo::scene::LightKind;
use azulejo::scene::math::Aabb;
use glam::DVec3;

/// Position of a light's marker: lights without a position are drawn above the model, whose
/// bounding box is `bounds`.
pub fn light_position(kind: &LightKind, bounds: Aabb) -> DVec3 {
    let bounds = if bounds.is_empty() {
        Aabb::around([DVec3::ZERO])
    } else {
        bounds
    };
    match *kind {
        LightKind::Point { position, .. }
        | LightKind::Spot { position, .. }
        | LightKind::Luminaire { position, .. } => position,
        LightKind::Directional { direction, .. } => {
            bounds.centre() - direction * (0.7 * bounds.diagonal().max(1.0))
        }
        LightKind::Ambient { .. } | LightKind::Environment(_) => {
            bounds.centre() + DVec3::ONE * (0.4 * bounds.diagonal())
        }
    }
}

impl SceneDocument {
    /// Bounding box of objects and of light and camera markers, which extend `radius` world units
    /// to each side.
    pub fn bounds_with_markers(&self, ids: &[ItemId], radius: f64) -> Aabb {
        let bounds = self.bounds(None);
        let lights = ids.iter().filter_map(|&id| self.light(id));
        let lights = lights.map(|lamp| light_position(&lamp.light.kind, bounds));
        let cameras = ids.iter().filter_map(|&id| self.camera(id));
        let places = lights.chain(cameras.map(|view| view.camera.eye));
        let reach = DVec3::splat(radius);
        places.fold(self.bounds(Some(ids)), |around, place| {
            around.with_point(place - reach).with_point(place + reach)
        })
    }

    /// The box that the view should show to frame these items. Lights and cameras have no size of
    /// their own, so they count as a twentieth of the model.
    pub fn frame_of(&self, ids: &[ItemId]) -> Aabb {
        let bounds = self.bounds(None);
        let size = if bounds.is_empty() {
            0.0
        } else {
            bounds.diagonal()
        };
        let radius = if size > 0.0 { 0.05 * size } else { 0.5 };
        self.bounds_with_markers(ids, radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::sample;
    use crate::document::{Edit, NewLight, NewLightKind};

    #[test]
    fn lights_and_cameras_have_a_frame() {
        let document = sample();
        let radius = 0.05 * document.bounds(None).diagonal();
        let (ball, bulb, view) = (ItemId(3), ItemId(5), ItemId(6));
        let around = |at: DVec3| {
            let reach = DVec3::splat(radius);
            Aabb::around([at - reach, at + reach])
        };
        assert_eq!(document.frame_of(&[]), Aabb::EMPTY);
        assert_eq!(document.frame_of(&[ball]), document.bounds(Some(&[ball])));
        let at = DVec3::new(0.0, 1.5, 0.0);
        assert_eq!(document.frame_of(&[bulb]), around(at));
        let eye = document.cameras[0].camera.eye;
        assert_eq!(document.frame_of(&[view]), around(eye));
        let both = document.frame_of(&[bulb, ball]);
        assert_eq!(both, around(at).union(document.bounds(Some(&[ball]))));
    }

    #[test]
    fn lights_of_an_empty_model_are_somewhere() {
        let mut document = SceneDocument::default();
        for kind in [
            NewLightKind::Point,
            NewLightKind::Sun,
            NewLightKind::Ambient,
        ] {
            let new = NewLight {
                kind,
                at: DVec3::Y,
                toward: DVec3::ZERO,
            };
            let ids = Edit::AddLight(new).apply(&mut document).unwrap();
            let frame = document.frame_of(&ids);
            assert!(!frame.is_empty() && frame.diagonal().is_finite());
        }
    }
}
