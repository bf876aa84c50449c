//! Definitions that several objects share: shapes, outlines, textures.

use super::rows::{TreeItem, TreeLeaf};
use crate::document::{ItemId, SceneDocument};
use crate::words::Language;
use azulejo::scene::{Figure, Leaf as Solid, Shape, Texture};
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::sync::Arc;

/// Uses of definitions, in the order of their first occurrence.
struct SharedUses<K> {
    places: HashMap<K, usize>,
    uses: Vec<Uses<K>>,
}

/// The users of a definition.
struct Uses<K> {
    what: K,
    /// Number of uses.
    count: usize,
    /// The objects that use it, without duplicates.
    users: Vec<ItemId>,
}

impl<K: Copy + Eq + Hash> SharedUses<K> {
    fn new() -> SharedUses<K> {
        SharedUses {
            places: HashMap::new(),
            uses: Vec::new(),
        }
    }

    fn note(&mut self, what: K, user: ItemId, times: usize) {
        let uses = &mut self.uses;
        let at = *self.places.entry(what).or_insert_with(|| {
            uses.push(Uses {
                what,
                count: 0,
                users: Vec::new(),
            });
            uses.len() - 1
        });
        let entry = &mut self.uses[at];
        entry.count += times;
        if entry.users.last() != Some(&user) {
            entry.users.push(user);
        }
    }
}

/// The shared definitions by kind; kinds without any are empty.
pub(super) fn of(
    document: &SceneDocument,
    language: Language,
) -> [(&'static str, Vec<TreeItem>); 3] {
    [
        (language.tr("Shapes"), shapes(document, language)),
        (language.tr("Outlines"), outlines(document, language)),
        (language.tr("Textures"), textures(document, language)),
    ]
}

fn definition(name: &str, count: usize, users: Vec<ItemId>) -> TreeItem {
    TreeItem {
        label: format!("{name} × {count}"),
        leaf: TreeLeaf::Definition(users),
        shown: None,
    }
}

/// The name of the first object that uses a definition, without its groups.
fn name_of<'a>(document: &'a SceneDocument, users: &[ItemId], language: Language) -> &'a str {
    let name = users.first().and_then(|&id| document.name(id));
    let last = name.and_then(|name| name.rsplit('/').next());
    let known = last.filter(|name| !name.is_empty());
    known.unwrap_or(language.tr("Unnamed"))
}

/// Shapes used by several objects. The undo history holds references as well, so addresses are
/// compared instead of reference counts.
fn shapes(document: &SceneDocument, language: Language) -> Vec<TreeItem> {
    let mut shared: SharedUses<*const Shape> = SharedUses::new();
    for item in &document.objects {
        shared.note(Arc::as_ptr(&item.shape), item.id, 1);
    }
    let several = shared.uses.into_iter().filter(|u| u.count > 1);
    several
        .map(|u| {
            let name = name_of(document, &u.users, language);
            definition(name, u.count, u.users)
        })
        .collect()
}

/// Outlines used by several prisms. A shape used several times counts once.
fn outlines(document: &SceneDocument, language: Language) -> Vec<TreeItem> {
    let mut shared: SharedUses<*const Figure> = SharedUses::new();
    let mut seen: HashSet<*const Shape> = HashSet::new();
    let mut curves: HashMap<*const Figure, usize> = HashMap::new();
    for item in &document.objects {
        let Shape::Exact(exact) = &*item.shape else {
            continue;
        };
        let times = usize::from(seen.insert(Arc::as_ptr(&item.shape)));
        for leaf in exact.leaves() {
            if let Solid::Prism(prism) = leaf {
                let figure = Arc::as_ptr(&prism.figure);
                shared.note(figure, item.id, times);
                let count = || prism.figure.curve_count();
                curves.entry(figure).or_insert_with(count);
            }
        }
    }
    let several = shared.uses.into_iter().filter(|u| u.count > 1);
    several
        .map(|u| {
            let name = name_of(document, &u.users, language);
            let count = curves.get(&u.what).copied().unwrap_or_default();
            let name = format!("{name} ({count} {})", language.tr("curves"));
            definition(&name, u.count, u.users)
        })
        .collect()
}

/// Textures with the objects that use them.
fn textures(document: &SceneDocument, language: Language) -> Vec<TreeItem> {
    let mut users = vec![Vec::new(); document.textures.len()];
    for item in &document.objects {
        let materials = item.materials().iter();
        let materials = materials.filter_map(|&m| document.materials.get(m as usize));
        for texture in materials.flat_map(|m| m.pictures()) {
            if let Some(users) = users.get_mut(texture as usize)
                && users.last() != Some(&item.id)
            {
                users.push(item.id);
            }
        }
    }
    let textures = document.textures.iter().zip(users);
    textures
        .map(|(texture, users)| definition(&picture(texture, language), users.len(), users))
        .collect()
}

/// The file name of a texture, and its size in pixels.
fn picture(texture: &Texture, language: Language) -> String {
    let name = texture.path.rsplit(['/', '\\']).next().unwrap_or_default();
    let name = match name {
        "" => language.tr("Unnamed"),
        known => known,
    };
    match &texture.image {
        Some(image) => format!("{name} ({} × {})", image.width, image.height),
        None => format!("{name} ({})", language.tr("not found")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::tests::sample;
    use crate::document::{Edit, NewShape, NewShapeKind, TextLayout};
    use azulejo::scene::Image;
    use glam::DVec3;

    /// Labels and users.
    fn of(document: &SceneDocument) -> Vec<(String, Vec<u64>)> {
        let groups = super::of(document, Language::English);
        let entries = groups.into_iter().flat_map(|(_, entries)| entries);
        let ids = |leaf: TreeLeaf| match leaf {
            TreeLeaf::Definition(users) => users.iter().map(|id| id.0).collect(),
            _ => panic!("{leaf:?}"),
        };
        entries.map(|t| (t.label, ids(t.leaf))).collect()
    }

    #[test]
    fn what_nobody_shares_is_no_definition() {
        assert!(of(&SceneDocument::default()).is_empty());
        let mut document = sample();
        document.textures.clear();
        assert_eq!(of(&document), []);
    }

    #[test]
    fn shapes_in_several_places_are_found_whatever_undo_holds() {
        let mut document = sample();
        document.textures.clear();
        let ball = ItemId(3);
        let copies = Edit::Duplicate(vec![ball]).apply(&mut document).unwrap();
        let before = document.clone();
        Edit::Duplicate(copies).apply(&mut document).unwrap();
        assert_eq!(of(&document), [("ball × 3".to_owned(), vec![3, 7, 8])]);
        assert_eq!(of(&before), [("ball × 2".to_owned(), vec![3, 7])]);
        // They share it even with another material.
        let ids = [3, 7, 8].map(ItemId).to_vec();
        Edit::Assign(ids, 0).apply(&mut document).unwrap();
        assert_eq!(of(&document), [("ball × 3".to_owned(), vec![3, 7, 8])]);
    }

    #[test]
    fn outlines_of_letters_are_counted() {
        let mut document = SceneDocument::default();
        let text = NewShape {
            kind: NewShapeKind::Text(TextLayout::set("pop", 0.2, None).unwrap()),
            at: DVec3::ZERO,
            size: 1.0,
            material: None,
        };
        Edit::AddShape(text).apply(&mut document).unwrap();
        let entries = of(&document);
        let [(label, users)] = &entries[..] else {
            panic!("one letter comes twice: {entries:?}")
        };
        assert!(label.starts_with("pop (") && label.ends_with("curves) × 2"));
        let id = document.objects[0].id;
        assert_eq!(*users, [id.0]);
        // A duplicate of the text has no more prisms.
        Edit::Duplicate(vec![id]).apply(&mut document).unwrap();
        let entries = of(&document);
        assert_eq!(entries[0], ("pop × 2".to_owned(), vec![id.0, id.0 + 1]));
        assert!(entries[1].0.ends_with("curves) × 2") && entries[1].1.len() == 2);
    }

    #[test]
    fn textures_say_their_file_their_size_and_who_has_them() {
        let mut document = sample();
        assert_eq!(of(&document)[0].0, "Unnamed (not found) × 2");
        document.textures = vec![Arc::new(Texture {
            path: "maps\\wood/oak.png".into(),
            image: Some(Image::new(4, 2)),
            ..Texture::default()
        })];
        // The floor in part, and the bead.
        assert_eq!(
            of(&document),
            [("oak.png (4 × 2) × 2".to_owned(), vec![1, 4])]
        );
    }
}
