//! Memory use of a document, and how much of it another document does not share.

use super::{SceneCamera, SceneDocument, SceneLight, SceneObject};
use azulejo::scene::brdf::{Content, Description, Measured};
use azulejo::scene::{
    Attribute, Curve, Exact, Figure, Leaf, Material, Mesh, Primitive, Rgb, Shape, Solid, Texture,
};
use std::collections::HashMap;
use std::sync::Arc;

/// Sizes in bytes of the shared allocations, by address.
#[derive(Default)]
struct SharedAllocations(HashMap<*const (), u64>);

impl SharedAllocations {
    fn note<T>(&mut self, part: &Arc<T>, bytes: impl FnOnce(&T) -> u64) {
        let pointer = Arc::as_ptr(part).cast();
        self.0.entry(pointer).or_insert_with(|| bytes(part));
    }

    fn forget<T>(&mut self, part: &Arc<T>) {
        self.0.remove(&Arc::as_ptr(part).cast());
    }

    fn bytes(&self) -> u64 {
        self.0.values().sum()
    }
}

impl SceneDocument {
    /// Approximate size in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes_beyond(&SceneDocument::default())
    }

    /// Approximate number of bytes that are freed if this document is dropped while `other` stays:
    /// its lists, and allocations that `other` does not share. Small objects are not counted.
    pub fn bytes_beyond(&self, other: &SceneDocument) -> u64 {
        let mut alone = SharedAllocations::default();
        self.note_items(other, &mut alone);
        self.note_materials(other, &mut alone);
        if !alone.0.is_empty() {
            // Whatever the other document uses as well is not freed.
            (other.objects.iter()).for_each(|item| forget_item(item, &mut alone));
            (other.materials.iter()).for_each(|material| forget_material(material, &mut alone));
            (other.textures.iter()).for_each(|texture| alone.forget(texture));
        }
        self.lists() + alone.bytes()
    }

    /// Bytes of its lists and of their elements, without what these point to.
    fn lists(&self) -> u64 {
        let lights = self.lights.iter();
        let lights = lights.map(|l| size_of::<SceneLight>() + l.light.name.capacity());
        let cameras = self.cameras.iter();
        let cameras = cameras.map(|c| size_of::<SceneCamera>() + c.camera.name.capacity());
        let pointers = self.objects.len() + self.materials.len() + self.textures.len();
        let bytes = pointers * size_of::<usize>() + lights.sum::<usize>() + cameras.sum::<usize>();
        bytes as u64
    }

    fn note_items(&self, other: &SceneDocument, alone: &mut SharedAllocations) {
        let mut others = other.objects.iter().peekable();
        for item in &self.objects {
            // Both lists are sorted by id.
            while others.next_if(|o| o.id < item.id).is_some() {}
            let same = others.next_if(|o| o.id == item.id);
            if same.is_some_and(|o| Arc::ptr_eq(o, item)) {
                continue;
            }
            alone.note(item, |i| {
                (size_of::<SceneObject>() + i.name.capacity()) as u64
            });
            if !same.is_some_and(|o| Arc::ptr_eq(&o.shape, &item.shape)) {
                note_shape(&item.shape, alone);
            }
        }
    }

    /// Materials and textures are compared by index; after a deletion the shifted ones count as well.
    fn note_materials(&self, other: &SceneDocument, alone: &mut SharedAllocations) {
        for (k, material) in self.materials.iter().enumerate() {
            let then = other.materials.get(k);
            if !then.is_some_and(|o| Arc::ptr_eq(o, material)) {
                note_material(material, alone);
            }
        }
        for (k, texture) in self.textures.iter().enumerate() {
            let then = other.textures.get(k);
            if !then.is_some_and(|o| Arc::ptr_eq(o, texture)) {
                alone.note(texture, texture_bytes);
            }
        }
    }
}

fn note_shape(shape: &Arc<Shape>, parts: &mut SharedAllocations) {
    parts.note(shape, shape_bytes);
    for_each_figure(shape, |figure| parts.note(figure, figure_bytes));
}

fn forget_item(item: &Arc<SceneObject>, parts: &mut SharedAllocations) {
    parts.forget(item);
    parts.forget(&item.shape);
    for_each_figure(&item.shape, |figure| parts.forget(figure));
}

fn for_each_figure(shape: &Shape, mut see: impl FnMut(&Arc<Figure>)) {
    let Shape::Exact(exact) = shape else { return };
    for leaf in exact.leaves() {
        if let Leaf::Prism(prism) = leaf {
            see(&prism.figure);
        }
    }
}

fn note_material(material: &Arc<Material>, parts: &mut SharedAllocations) {
    parts.note(material, |m| {
        let own = m.name.capacity() + vector(&m.textures) + size_of::<Material>();
        own as u64
    });
    if let Some(measured) = measured(material) {
        parts.note(measured, measured_bytes);
    }
}

fn forget_material(material: &Arc<Material>, parts: &mut SharedAllocations) {
    parts.forget(material);
    if let Some(measured) = measured(material) {
        parts.forget(measured);
    }
}

fn measured(material: &Material) -> Option<&Arc<Measured>> {
    match material.brdf.as_ref()?.description() {
        Description::File { content, .. } => match content.as_deref()? {
            Content::Measured(measured) => Some(measured),
            _ => None,
        },
        _ => None,
    }
}

fn measured_bytes(measured: &Measured) -> u64 {
    match measured {
        Measured::Merl(merl) => merl.sizes().iter().product::<usize>() as u64 * 12,
        // These have no known size; this is more than most of them have.
        _ => 8 << 20,
    }
}

fn texture_bytes(texture: &Texture) -> u64 {
    let pixels = texture.image.as_ref().map_or(0, |i| vector(&i.pixels));
    (size_of::<Texture>() + texture.path.capacity() + pixels) as u64
}

fn figure_bytes(figure: &Figure) -> u64 {
    let curves: usize = (figure.contours.iter())
        .map(|c| size_of::<Vec<Curve>>() + vector(&c.curves))
        .sum();
    (size_of::<Figure>() + curves) as u64
}

fn shape_bytes(shape: &Shape) -> u64 {
    let inner = match shape {
        Shape::Mesh(mesh) => mesh_bytes(mesh),
        Shape::Instance(instance) => mesh_bytes(&instance.mesh),
        Shape::Primitive(primitive) => light_bytes(primitive),
        Shape::Exact(exact) => exact_bytes(exact),
    };
    (size_of::<Shape>() + inner) as u64
}

/// Without the figures, which are shared.
fn exact_bytes(exact: &Exact) -> usize {
    let inner = |leaf: &Leaf| match leaf {
        Leaf::Primitive(primitive) => light_bytes(primitive),
        Leaf::Patch(patch) => size_of_val(&*patch.points),
        Leaf::Mesh(mesh) => mesh_bytes(mesh),
        Leaf::Prism(_) => 0,
    };
    let leaves = exact.leaves();
    let skin = exact.proxy.as_deref().map_or(0, mesh_bytes);
    let inner: usize = leaves.iter().map(inner).sum();
    leaves.len() * size_of::<Solid>() + inner + skin
}

fn light_bytes(primitive: &Primitive) -> usize {
    let light = primitive.light.as_ref();
    light.map_or(0, |l| vector(&l.irradiance) + vector(&l.error))
}

fn mesh_bytes(mesh: &Mesh) -> usize {
    let colors: [&Vec<Rgb>; 3] = [&mesh.colors, &mesh.irradiance, &mesh.irradiance_error];
    let faces = &mesh.faces;
    let numbers = [
        &faces.starts,
        &faces.corners,
        &mesh.face_materials,
        &mesh.smoothing,
    ];
    let back = mesh.back.as_deref();
    size_of::<Mesh>()
        + back.map_or(0, |b| vector(&b.irradiance) + vector(&b.error))
        + vector(&mesh.positions)
        + mesh.normals.as_ref().map_or(0, attribute)
        + mesh.uvs.as_ref().map_or(0, attribute)
        + mesh.lightmap_uvs.as_ref().map_or(0, attribute)
        + colors.into_iter().map(vector).sum::<usize>()
        + numbers.into_iter().map(vector).sum::<usize>()
}

fn attribute<T>(attribute: &Attribute<T>) -> usize {
    vector(&attribute.values) + attribute.corners.as_ref().map_or(0, vector)
}

fn vector<T>(values: &Vec<T>) -> usize {
    values.capacity() * size_of::<T>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::sample;
    use crate::document::{Edit, ItemId, NewShape, NewShapeKind, TextLayout};
    use azulejo::scene::Image;
    use glam::{DAffine3, DVec3};

    /// A document with a mesh of a million bytes, as the object with id 1.
    fn large() -> SceneDocument {
        let mut document = sample();
        let Shape::Mesh(mesh) = &*document.objects[0].shape else {
            panic!("the floor is a mesh")
        };
        let mut mesh = mesh.clone();
        mesh.positions
            .resize(1_000_000 / size_of::<DVec3>(), DVec3::ZERO);
        let shape = Arc::new(Shape::Mesh(mesh));
        Edit::SetShape(ItemId(1), shape)
            .apply(&mut document)
            .unwrap();
        document
    }

    /// Bytes that only `before` holds after the edit, apart from its lists.
    fn alone(before: &SceneDocument, edit: &Edit) -> u64 {
        let mut after = before.clone();
        edit.apply(&mut after).unwrap();
        before.bytes_beyond(&after) - before.lists()
    }

    #[test]
    fn a_step_holds_what_its_edit_took_away() {
        let document = large();
        assert_eq!(document.bytes_beyond(&document), document.lists());
        assert!(document.bytes() > 1_000_000 && document.bytes() < 1_100_000);
        let small = [
            Edit::Rename(ItemId(1), "ground".into()),
            Edit::Hide(vec![ItemId(1)], true),
            Edit::Transform(vec![ItemId(1)], DAffine3::from_translation(DVec3::X)),
            Edit::Duplicate(vec![ItemId(1)]),
            Edit::Assign(vec![ItemId(3)], 0),
            Edit::SetMaterial(1, Material::default()),
        ];
        for edit in small {
            assert!(alone(&document, &edit) < 2_000, "{edit:?}");
        }
        let large = [
            Edit::Assign(vec![ItemId(1)], 0),
            Edit::AssignFaces(ItemId(1), vec![0], 1),
            Edit::Delete(vec![ItemId(1)]),
        ];
        for edit in large {
            let bytes = alone(&document, &edit);
            assert!((1_000_000..1_010_000).contains(&bytes), "{edit:?}: {bytes}");
        }
    }

    #[test]
    fn what_stands_elsewhere_too_is_held_once() {
        let mut document = large();
        Edit::Duplicate(vec![ItemId(1)])
            .apply(&mut document)
            .unwrap();
        assert!(document.bytes() < 1_100_000);
        assert!(alone(&document, &Edit::Delete(vec![ItemId(1)])) < 2_000);
        let both = document.objects.iter().map(|i| i.id).collect();
        let bytes = alone(&document, &Edit::Delete(both));
        assert!((1_000_000..1_100_000).contains(&bytes), "{bytes}");
    }

    #[test]
    fn outlines_and_pictures_have_a_weight() {
        let mut document = SceneDocument::default();
        let text = NewShape {
            kind: NewShapeKind::Text(TextLayout::set("mmm", 0.2, None).unwrap()),
            at: DVec3::ZERO,
            size: 1.0,
            material: None,
        };
        let ids = Edit::AddShape(text).apply(&mut document).unwrap();
        let deletion = alone(&document, &Edit::Delete(ids.clone()));
        let without_outlines = alone(&document, &Edit::Assign(ids, 0));
        // Three letters share one outline.
        let Shape::Exact(exact) = &*document.objects[0].shape else {
            panic!("letters are exact")
        };
        let Solid::Prism(letter) = &exact.solids[0] else {
            panic!("a letter is a prism")
        };
        assert_eq!(deletion - without_outlines, figure_bytes(&letter.figure));

        let before = document.bytes();
        document.textures.push(Arc::new(Texture {
            path: String::new(),
            image: Some(Image::new(100, 100)),
            ..Texture::default()
        }));
        assert!(document.bytes() - before >= 120_000);
    }
}
