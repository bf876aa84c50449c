//! Conversion of a document to other units.

use super::SceneDocument;
use azulejo::scene::{Primitive, PrimitiveKind, Scene, Shape, Units};
use glam::DAffine3;
use std::sync::Arc;

impl SceneDocument {
    /// Converts the document to other units, as [`Scene::adapted`] does; shapes stay as they are
    /// and only placements change.
    pub fn adapted(mut self, units: Units) -> SceneDocument {
        if self.units == units {
            return self;
        }
        let scene = self.beside_objects().adapted(units);
        let map = match scene.objects.first().map(|o| &o.shape) {
            Some(Shape::Primitive(origin)) => origin.world_from_object,
            _ => DAffine3::IDENTITY,
        };
        if map != DAffine3::IDENTITY {
            for item in &mut self.objects {
                let item = Arc::make_mut(item);
                item.placement = map * item.placement;
            }
            self.rtrace = None;
        }
        let lights = self.lights.iter_mut().zip(scene.lights);
        lights.for_each(|(lamp, light)| lamp.light = light);
        let cameras = self.cameras.iter_mut().zip(scene.cameras);
        cameras.for_each(|(view, camera)| view.camera = camera);
        self.fog = scene.fog;
        self.units = scene.units;
        self
    }

    /// Everything but the objects that depends on the units, with one object at the origin that
    /// stands for them: its placement gives theirs.
    fn beside_objects(&self) -> Scene {
        let origin = Primitive::new(PrimitiveKind::Cuboid, DAffine3::IDENTITY, 0);
        Scene {
            objects: vec![azulejo::scene::Object::new("", Shape::Primitive(origin))],
            lights: self.lights.iter().map(|l| l.light.clone()).collect(),
            cameras: self.cameras.iter().map(|c| c.camera.clone()).collect(),
            fog: self.fog,
            units: self.units,
            ..Scene::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::sample_scene;
    use azulejo::scene::Up;

    #[test]
    fn a_document_is_adapted_as_its_scene_is() {
        let centimetres = Units {
            metres_per_unit: Some(0.01),
            up: Up::Z,
            photometric: true,
        };
        let nobody_says = Units {
            metres_per_unit: None,
            ..centimetres
        };
        let scene = sample_scene();
        for units in [scene.units, centimetres, nobody_says] {
            let document = SceneDocument::of_scene(scene.clone(), None).adapted(units);
            assert_eq!(document.scene(), scene.clone().adapted(units), "{units:?}");
        }
    }
}
