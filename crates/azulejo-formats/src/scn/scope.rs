//! The current attributes: surfaces, transforms and textures, by scope.

use crate::sff::document::{RecordKind, SffPosition, SffRecord, TextureKind, TextureRecord};
use glam::DMat4;

/// A scope: from `group` to `ungroup`, from an object's name to its `data`, or inside a set
/// operation.
#[derive(Clone, Debug)]
pub(super) struct ScnScope {
    /// Counted from 1; 0 before the first one.
    pub surface: u32,
    pub refraction: f64,
    /// Whether this scope itself sets the surface and the refraction.
    pub sets_surface: bool,
    pub sets_refraction: bool,
    transforms: Vec<DMat4>,
    textures: Vec<TextureCommand>,
    /// Whether it is the inside of a set operation or list, whose members do not get the outer
    /// transforms and textures: the operation does.
    is_inside: bool,
}

/// A texture command.
#[derive(Clone, Debug)]
pub(super) enum TextureCommand {
    /// A texture itself.
    Record {
        place: SffPosition,
        matrix: DMat4,
        kind: TextureKind,
        file: String,
    },
    /// The following textures move with the object.
    Local,
    /// The following textures stay in world coordinates.
    Invariant,
}

/// The open scopes, the outermost first.
#[derive(Clone, Debug)]
pub(super) struct ScnScopes(Vec<ScnScope>);

impl ScnScopes {
    /// The scope of the scene itself.
    pub fn new() -> ScnScopes {
        ScnScopes(vec![ScnScope {
            surface: 0,
            refraction: 1.0,
            sets_surface: false,
            sets_refraction: false,
            transforms: Vec::new(),
            textures: Vec::new(),
            is_inside: false,
        }])
    }

    /// The innermost scope.
    pub fn innermost(&self) -> &ScnScope {
        // The scope of the scene is never left.
        &self.0[self.0.len() - 1]
    }

    fn innermost_mut(&mut self) -> &mut ScnScope {
        let last = self.0.len() - 1;
        &mut self.0[last]
    }

    /// The number of open scopes.
    pub fn depth(&self) -> usize {
        self.0.len()
    }

    /// Opens a scope, which inherits the surface.
    pub fn enter(&mut self, is_inside: bool) {
        let around = self.innermost();
        let scope = ScnScope {
            surface: around.surface,
            refraction: around.refraction,
            sets_surface: false,
            sets_refraction: false,
            transforms: Vec::new(),
            textures: Vec::new(),
            is_inside,
        };
        self.0.push(scope);
    }

    /// Leaves the innermost scope, except that of the scene.
    pub fn leave(&mut self) {
        if self.0.len() > 1 {
            self.0.pop();
        }
    }

    pub fn set_surface(&mut self, surface: u32) {
        let scope = self.innermost_mut();
        (scope.surface, scope.sets_surface) = (surface, true);
    }

    /// Sets the surface of everything without one, from now on.
    pub fn set_default(&mut self, surface: u32) {
        let without = self.0.iter_mut().filter(|s| s.surface == 0);
        without.for_each(|s| s.surface = surface);
    }

    pub fn set_refraction(&mut self, refraction: f64) {
        let scope = self.innermost_mut();
        (scope.refraction, scope.sets_refraction) = (refraction, true);
    }

    /// Reverts a change of the refraction.
    pub fn restore_refraction(&mut self, refraction: f64, sets: bool) {
        let scope = self.innermost_mut();
        (scope.refraction, scope.sets_refraction) = (refraction, sets);
    }

    /// Adds a transform, or drops those of this scope.
    pub fn transform(&mut self, transform: Option<DMat4>) {
        let transforms = &mut self.innermost_mut().transforms;
        match transform {
            Some(transform) => transforms.push(transform),
            None => transforms.clear(),
        }
    }

    /// Adds a texture, or drops those of this scope.
    pub fn texture(&mut self, texture: Option<TextureCommand>) {
        let textures = &mut self.innermost_mut().textures;
        match texture {
            Some(texture) => textures.push(texture),
            None => textures.clear(),
        }
    }

    /// The scopes whose transforms and textures apply to an object here, the innermost first.
    fn around(&self) -> impl Iterator<Item = &ScnScope> {
        let inside = self.0.iter().rposition(|s| s.is_inside).unwrap_or(0);
        self.0[inside..].iter().rev()
    }

    /// The number of records that an object gets here.
    pub fn record_count(&self) -> usize {
        let counts = self.around().map(|s| s.transforms.len() + s.textures.len());
        counts.sum()
    }

    /// The records after an object: its transforms and textures.
    pub fn records(&self, place: SffPosition) -> Vec<SffRecord> {
        let mut records = Vec::new();
        let mut world_from_object = DMat4::IDENTITY;
        for transform in self.around().flat_map(|s| &s.transforms) {
            world_from_object = *transform * world_from_object;
            let matrix = Box::new(*transform);
            records.push(RecordKind::Transform { object: 0, matrix });
        }
        let mut follows = false;
        let null = |matrix: DMat4| TextureRecord {
            place,
            object: 0,
            matrix,
            kind: TextureKind {
                number: 0,
                values: Vec::new(),
            },
            file: String::new(),
        };
        for texture in self.around().flat_map(|s| &s.textures) {
            // A texture gets the point as transformed by the previous one: an empty texture
            // transforms it to object coordinates, or back.
            let record = match texture {
                TextureCommand::Record {
                    place,
                    matrix,
                    kind,
                    file,
                } => TextureRecord {
                    place: *place,
                    object: 0,
                    matrix: *matrix,
                    kind: kind.clone(),
                    file: file.clone(),
                },
                TextureCommand::Local if !follows => {
                    follows = true;
                    null(world_from_object)
                }
                TextureCommand::Invariant if follows => {
                    follows = false;
                    null(world_from_object.inverse())
                }
                TextureCommand::Local | TextureCommand::Invariant => continue,
            };
            records.push(RecordKind::Texture(Box::new(record)));
        }
        let placed = |kind| SffRecord { place, kind };
        records.into_iter().map(placed).collect()
    }
}
