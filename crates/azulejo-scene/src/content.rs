//! The content of a scene as bytes, for hashes that identify it.
//!
//! The bytes are the same on every machine and with every compiler: numbers by their bits in
//! little-endian order, lists and texts with their length, kinds with a number. Every structure is taken
//! apart field by field, so that a new field cannot be forgotten. Two contents differ if and only if
//! their bytes do, except for what no pass reads: RTRACE's own parameters
//! ([`Scene::rtrace`](crate::Scene)).
//!
//! ```
//! use azulejo_scene::{Scene, content::ContentBytes, synthetic::cube_room};
//!
//! let bytes = |scene: &Scene| {
//!     let mut bytes = Vec::new();
//!     scene.feed(&mut |part| bytes.extend_from_slice(part));
//!     bytes
//! };
//! let mut scene = cube_room();
//! assert_eq!(bytes(&scene), bytes(&cube_room()));
//! scene.materials[0].diffuse.r *= 0.5;
//! assert_ne!(bytes(&scene), bytes(&cube_room()));
//! ```

mod shapes;
mod surfaces;

pub use crate::content_bytes::{ContentBytes, ContentSink};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{CornellVariant, cornell_box, cube_room};
    use crate::{Exact, Object, Primitive, Prism, Rgb, Scene, Shape, Solid};
    use crate::{Figure, brdf};
    use glam::{DAffine3, DVec3};
    use std::sync::Arc;

    fn bytes(content: &(impl ContentBytes + ?Sized)) -> Vec<u8> {
        let mut bytes = Vec::new();
        content.feed(&mut |part| bytes.extend_from_slice(part));
        bytes
    }

    #[test]
    fn bytes_do_not_depend_on_the_machine() {
        assert_eq!(bytes(&1.5), [0, 0, 0, 0, 0, 0, 0xf8, 0x3f]);
        assert_eq!(bytes("ab"), [2, 0, 0, 0, 0, 0, 0, 0, b'a', b'b']);
        assert_eq!(bytes(&Some(7u8)), [1, 7]);
        assert_eq!(bytes(&None::<u8>), [0]);
        assert_eq!(bytes(&Rgb::new(0.0, -0.0, 1.0)).len(), 24);
        assert_ne!(bytes(&0.0), bytes(&-0.0));
        // Neighbours do not run into each other.
        assert_ne!(bytes(&("a", "bc").map()), bytes(&("ab", "c").map()));
    }

    trait Owned {
        fn map(self) -> (String, String);
    }

    impl Owned for (&str, &str) {
        fn map(self) -> (String, String) {
            (self.0.to_owned(), self.1.to_owned())
        }
    }

    /// Everything that is changed in a scene changes its bytes.
    #[test]
    fn every_change_counts() {
        let mut scene = cornell_box(CornellVariant::Diffuse);
        let figure = Arc::new(Figure::default());
        let prism = Prism {
            figure,
            world_from_figure: DAffine3::IDENTITY,
            material: 0,
            bevel: None,
        };
        let solids = vec![
            Solid::Prism(prism),
            Solid::Primitive(Primitive::sphere(DVec3::ONE, 2.0, 0)),
        ];
        let exact = Shape::Exact(Exact::new(solids));
        scene.objects.push(Object::new("exact", exact));
        let glossy = brdf::Description::model("phong", [("n", 20.0.into()), ("kd", 0.3.into())]);
        scene.materials[0].brdf = Some(Arc::new(brdf::Brdf::new(glossy).unwrap()));
        type Change = fn(&mut Scene);
        let changes: [Change; 9] = [
            |s| s.objects[0].name.push('x'),
            |s| s.objects.truncate(1),
            |s| s.materials[0].emits_back = true,
            |s| s.materials[0].brdf = None,
            |s| s.background = Some(Rgb::BLACK.into()),
            |s| s.units.photometric = true,
            |s| mesh(s).positions[0].x += 1e-9,
            |s| mesh(s).faces.corners.swap(0, 1),
            |s| {
                let Some(Shape::Exact(exact)) = s.objects.last_mut().map(|o| &mut o.shape) else {
                    unreachable!("it was just added")
                };
                exact.solids.swap(0, 1);
            },
        ];
        let before = bytes(&scene);
        for (k, change) in changes.into_iter().enumerate() {
            let mut changed = scene.clone();
            change(&mut changed);
            assert_ne!(bytes(&changed), before, "change {k}");
        }
        assert_eq!(bytes(&scene.clone()), before);
    }

    fn mesh(scene: &mut Scene) -> &mut crate::Mesh {
        match &mut scene.objects[0].shape {
            Shape::Mesh(mesh) => mesh,
            _ => unreachable!("the first object is a mesh"),
        }
    }

    /// Tables of the same size, which look alike as text.
    #[test]
    fn measured_tables_count_number_by_number() {
        let measured = |value: f32| {
            let table = brdf::Merl::new([2, 2, 2], vec![[0.1, 0.2, value]; 8]).unwrap();
            let content = brdf::Content::Measured(Arc::new(brdf::Measured::Merl(table)));
            let description = brdf::Description::File {
                path: "a.binary".into(),
                content: Some(Arc::new(content)),
            };
            let mut scene = cube_room();
            let model = Arc::new(brdf::Brdf::new(description).unwrap());
            scene.materials[0].brdf = Some(model);
            scene
        };
        assert_eq!(bytes(&measured(0.1)), bytes(&measured(0.1)));
        assert_ne!(bytes(&measured(0.1)), bytes(&measured(0.100_001)));
    }
}
