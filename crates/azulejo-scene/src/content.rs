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

use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::sync::Arc;

/// Receives the bytes of a content, part by part.
pub type ContentSink<'s> = dyn FnMut(&[u8]) + 's;

/// What has a content.
pub trait ContentBytes {
    /// Passes all bytes of the content to `sink`, in parts of any length.
    fn feed(&self, sink: &mut ContentSink<'_>);
}

/// Feeds the fields of a structure in their order; does not compile if one is missing.
macro_rules! content_of_fields {
    ($type:ident { $($field:ident),+ $(,)? }) => {
        impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                let $type { $($field),+ } = self;
                $($field.feed(sink);)+
            }
        }
    };
}

/// Feeds the number of a variant without fields.
macro_rules! content_of_kinds {
    ($type:ident { $($kind:ident = $number:literal),+ $(,)? }) => {
        impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                let number: u8 = match self { $($type::$kind => $number),+ };
                number.feed(sink);
            }
        }
    };
}

pub(crate) use {content_of_fields, content_of_kinds};

/// Feeds a number by its bytes.
macro_rules! content_of_numbers {
    ($($type:ident)+) => {
        $(impl ContentBytes for $type {
            fn feed(&self, sink: &mut ContentSink<'_>) {
                sink(&self.to_le_bytes());
            }
        })+
    };
}

content_of_numbers! { u8 u32 u64 f32 f64 }

impl ContentBytes for bool {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        u8::from(*self).feed(sink);
    }
}

impl ContentBytes for usize {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        (*self as u64).feed(sink);
    }
}

impl ContentBytes for str {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.len().feed(sink);
        sink(self.as_bytes());
    }
}

impl ContentBytes for String {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.as_str().feed(sink);
    }
}

impl<T: ContentBytes> ContentBytes for [T] {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.len().feed(sink);
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<T: ContentBytes, const N: usize> ContentBytes for [T; N] {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<T: ContentBytes> ContentBytes for Vec<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.as_slice().feed(sink);
    }
}

impl<T: ContentBytes> ContentBytes for Option<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.is_some().feed(sink);
        self.iter().for_each(|item| item.feed(sink));
    }
}

impl<T: ContentBytes + ?Sized> ContentBytes for Box<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        (**self).feed(sink);
    }
}

/// Shared content counts like separate content.
impl<T: ContentBytes + ?Sized> ContentBytes for Arc<T> {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        (**self).feed(sink);
    }
}

impl<A: ContentBytes, B: ContentBytes> ContentBytes for (A, B) {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.0.feed(sink);
        self.1.feed(sink);
    }
}

impl ContentBytes for DVec2 {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.to_array().feed(sink);
    }
}

impl ContentBytes for DVec3 {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.to_array().feed(sink);
    }
}

impl ContentBytes for DQuat {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.to_array().feed(sink);
    }
}

impl ContentBytes for DAffine3 {
    fn feed(&self, sink: &mut ContentSink<'_>) {
        self.to_cols_array().feed(sink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{CornellVariant, cornell_box, cube_room};
    use crate::{Exact, Object, Primitive, Prism, Rgb, Scene, Shape, Solid};
    use crate::{Figure, brdf};

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
