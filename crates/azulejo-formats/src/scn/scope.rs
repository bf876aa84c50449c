//! What holds for the objects that follow: surfaces, transforms and textures, by scope.

use crate::sff::document::{RecordKind, SffPosition, SffRecord, TextureKind, TextureRecord};
use glam::DMat4;

/// From `group` to `ungroup`, from an object's name to its `data`, or inside of a set operation.
#[derive(Clone, Debug)]
pub(super) struct ScnScope {
    /// From 1; 0 before the first.
    pub surface: u32,
    pub refraction: f64,
    /// Whether this scope itself set them.
    pub sets_surface: bool,
    pub sets_refraction: bool,
    transforms: Vec<DMat4>,
    textures: Vec<TextureCommand>,
    /// Whether it is the inside of a set operation or list, to which the transforms and textures
    /// around it belong.
    is_inside: bool,
}

/// A texture command.
#[derive(Clone, Debug)]
pub(super) enum TextureCommand {
    /// A texture of its own.
    Record {
        place: SffPosition,
        matrix: DMat4,
        kind: TextureKind,
        file: String,
    },
    /// What follows moves with the object.
    Local,
    /// What follows stays in the world.
    Invariant,
}

/// All scopes, the outermost first.
#[derive(Clone, Debug)]
pub(super) struct ScnScopes(Vec<ScnScope>);

impl ScnScopes {
    /// The scene's own.
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

    /// The innermost.
    pub fn innermost(&self) -> &ScnScope {
        // The scene's own is never left.
        &self.0[self.0.len() - 1]
    }

    fn innermost_mut(&mut self) -> &mut ScnScope {
        let last = self.0.len() - 1;
        &mut self.0[last]
    }

    /// How many there are.
    pub fn depth(&self) -> usize {
        self.0.len()
    }

    /// Opens a scope, which begins with the surface around it.
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

    /// Leaves the innermost scope, but never the scene's own.
    pub fn leave(&mut self) {
        if self.0.len() > 1 {
            self.0.pop();
        }
    }

    pub fn set_surface(&mut self, surface: u32) {
        let scope = self.innermost_mut();
        (scope.surface, scope.sets_surface) = (surface, true);
    }

    /// The surface of everything that has none, from now on.
    pub fn set_default(&mut self, surface: u32) {
        let without = self.0.iter_mut().filter(|s| s.surface == 0);
        without.for_each(|s| s.surface = surface);
    }

    pub fn set_refraction(&mut self, refraction: f64) {
        let scope = self.innermost_mut();
        (scope.refraction, scope.sets_refraction) = (refraction, true);
    }

    /// Takes a change of the refraction back.
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

    /// The scopes whose transforms and textures an object here gets, the innermost first.
    fn around(&self) -> impl Iterator<Item = &ScnScope> {
        let inside = self.0.iter().rposition(|s| s.is_inside).unwrap_or(0);
        self.0[inside..].iter().rev()
    }

    /// How many records an object gets here.
    pub fn record_count(&self) -> usize {
        let counts = self.around().map(|s| s.transforms.len() + s.textures.len());
        counts.sum()
    }

    /// The records behind an object: transforms and textures of the latest.
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
            // A texture gets the point that the one before left: one that does nothing else
            // takes it into the object's space, or back.
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
