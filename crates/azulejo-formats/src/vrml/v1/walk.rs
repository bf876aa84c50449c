//! Traverses the stream of nodes.

use super::lights;
use super::materials::V1MaterialCache;
use super::node::{NodeId, V1Document, V1Node, V1NodeKind};
use super::state::{
    ShapeHints, TraversalState, V1Binding, matrix_transform, rotation, transform, uv_transform,
};
use crate::reading::text::{shortened, text};
use crate::vrml::builder::{VrmlPlacement, VrmlSceneBuilder, VrmlSource};
use crate::{Lod, ReadError};
use azulejo_scene::Rgb;
use glam::{DAffine3, DVec3};

/// A traversal of the nodes of one file.
pub(super) struct V1Traversal<'d, 's, 'f> {
    pub builder: &'s mut VrmlSceneBuilder<'f>,
    pub source: &'s VrmlSource,
    pub document: &'d V1Document<'d>,
    pub state: TraversalState<'d>,
    pub cache: V1MaterialCache,
    /// The placement of the file, and of each group being traversed inside it.
    frames: Vec<VrmlPlacement>,
    /// Pending steps, the next one last. A list instead of recursion: groups that use each other
    /// may nest deeper than any stack.
    steps: Vec<TraversalStep<'d>>,
    inventor: bool,
}

/// A pending step of a traversal.
enum TraversalStep<'d> {
    Visit(NodeId),
    /// Leaves a group and restores the saved state.
    Leave(SavedState<'d>),
}

/// The part of the state that a group restores.
enum SavedState<'d> {
    NoFaces,
    Matrix(DAffine3),
    All(Box<TraversalState<'d>>),
}

/// Traverses a file and adds its content under `frame`.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn walk(
    builder: &mut VrmlSceneBuilder,
    source: &VrmlSource,
    document: &V1Document,
    frame: &VrmlPlacement,
    inventor: bool,
) -> Result<(), ReadError> {
    let mut walk = V1Traversal {
        builder,
        source,
        document,
        state: TraversalState::new(inventor),
        cache: V1MaterialCache::default(),
        frames: vec![frame.clone()],
        steps: Vec::new(),
        inventor,
    };
    walk.visit_all(&document.roots);
    while let Some(step) = walk.steps.pop() {
        match step {
            TraversalStep::Visit(id) => walk.visit(&document.nodes[id as usize])?,
            TraversalStep::Leave(kept) => walk.leave(kept),
        }
    }
    Ok(())
}

/// What a shape takes from the budget besides its vertices and corners.
const SHAPE: u64 = 16;

impl<'d> V1Traversal<'d, '_, '_> {
    /// Adds a warning about a node.
    pub fn warn(&mut self, node: &V1Node, message: impl Into<String>) {
        self.builder.warn(self.source, node.at, message);
    }

    /// The current placement of shapes.
    pub fn frame(&self) -> VrmlPlacement {
        let group = self.frames.last().cloned().unwrap_or_default();
        group.moved(self.state.matrix)
    }

    fn visit_all(&mut self, nodes: &[NodeId]) {
        let visits = nodes.iter().rev().map(|id| TraversalStep::Visit(*id));
        self.steps.extend(visits);
    }

    fn visit(&mut self, node: &'d V1Node<'d>) -> Result<(), ReadError> {
        // However simple, a shape is an object.
        let cost = if node.kind.is_shape() { SHAPE } else { 1 };
        self.builder.spend(cost)?;
        match node.kind {
            V1NodeKind::Separator | V1NodeKind::Unknown => {
                self.enter(node, &node.children, SavedState::All(Box::new(self.state)));
            }
            V1NodeKind::TransformSeparator => {
                self.enter(node, &node.children, SavedState::Matrix(self.state.matrix));
            }
            V1NodeKind::Group => self.enter(node, &node.children, SavedState::NoFaces),
            V1NodeKind::Switch => self.switch(node),
            V1NodeKind::Lod => self.lod(node),
            V1NodeKind::Inline => self.inline(node)?,
            _ if node.kind.is_shape() && self.is_invisible() => {
                self.warn(node, "shape with transparency 1: invisible, skipped");
            }
            V1NodeKind::IndexedFaceSet => {
                let around = self.state;
                for &child in &node.children {
                    let property = &self.document.nodes[child as usize];
                    if property.kind == V1NodeKind::VertexProperty {
                        self.vertex_property(property);
                    }
                }
                self.face_set(node)?;
                self.state = around;
            }
            V1NodeKind::Cube | V1NodeKind::Sphere | V1NodeKind::Cylinder | V1NodeKind::Cone => {
                self.solid(node)?
            }
            #[cfg(feature = "fonts")]
            V1NodeKind::AsciiText => self.text(node)?,
            V1NodeKind::PointLight | V1NodeKind::SpotLight | V1NodeKind::DirectionalLight => {
                self.light(node)
            }
            V1NodeKind::PerspectiveCamera => self.camera(node),
            V1NodeKind::Info => self.info(node),
            V1NodeKind::NoSurface | V1NodeKind::OrthographicCamera => {
                let name = text(node.type_name);
                self.warn(node, format!("{name} is not supported: skipped"));
            }
            _ => self.property(node),
        }
        Ok(())
    }

    /// Applies a node that changes the state.
    fn property(&mut self, node: &'d V1Node<'d>) {
        let state = &mut self.state;
        match node.kind {
            V1NodeKind::Coordinate3 => {
                state.points = node.vectors("point").unwrap_or(&[DVec3::ZERO])
            }
            V1NodeKind::Normal => state.normals = node.vectors("vector").unwrap_or(&[]),
            V1NodeKind::TextureCoordinate2 => state.uvs = node.vectors2("point").unwrap_or(&[]),
            V1NodeKind::Material => state.material = Some(node),
            V1NodeKind::MaterialBinding => self.state.material_binding = self.part(node),
            V1NodeKind::NormalBinding => self.state.normal_binding = self.part(node),
            V1NodeKind::FontStyle => state.font = Some(node),
            V1NodeKind::Texture2 => self.state.texture = self.texture(node),
            V1NodeKind::Texture2Transform => state.uv_matrix *= uv_transform(node),
            V1NodeKind::ShapeHints => state.hints = ShapeHints::of(node, self.inventor),
            V1NodeKind::Transform => state.matrix *= transform(node),
            V1NodeKind::Translation => {
                let by = node.vector("translation", DVec3::ZERO);
                state.matrix *= DAffine3::from_translation(by);
            }
            V1NodeKind::Rotation => {
                state.matrix *= DAffine3::from_quat(rotation(node.exactly("rotation")));
            }
            V1NodeKind::Scale => {
                let by = node.vector("scaleFactor", DVec3::ONE);
                state.matrix *= DAffine3::from_scale(by);
            }
            V1NodeKind::MatrixTransform => match matrix_transform(node) {
                Some(map) => state.matrix *= map,
                None => self.warn(node, "matrix that is not affine: ignored"),
            },
            _ => {}
        }
    }

    /// Applies the coordinates and normals of a shape itself, which replace the current ones.
    fn vertex_property(&mut self, node: &'d V1Node<'d>) {
        let normal_binding = match node.word("normalBinding") {
            "" => V1Binding::VertexIndexed,
            word => self.binding(node, word),
        };
        let material_binding = match node.word("materialBinding") {
            "" => V1Binding::Overall,
            word => self.binding(node, word),
        };
        let state = &mut self.state;
        state.points = node.vectors("vertex").unwrap_or(state.points);
        if let Some(normals) = node.vectors("normal") {
            (state.normals, state.normal_binding) = (normals, normal_binding);
        }
        state.uvs = node.vectors2("texCoord").unwrap_or(state.uvs);
        state.material_binding = material_binding;
    }

    fn part(&mut self, node: &V1Node) -> V1Binding {
        self.binding(node, node.word("value"))
    }

    fn binding(&mut self, node: &V1Node, word: &str) -> V1Binding {
        V1Binding::named(word).unwrap_or_else(|| {
            let shown = shortened(word);
            self.warn(node, format!("unknown binding {shown}: DEFAULT is used"));
            V1Binding::Default
        })
    }

    fn enter(&mut self, node: &V1Node, children: &[NodeId], kept: SavedState<'d>) {
        let outer = self.frames.last().cloned().unwrap_or_default();
        self.frames.push(outer.named(node.name.as_deref()));
        self.steps.push(TraversalStep::Leave(kept));
        self.visit_all(children);
    }

    fn leave(&mut self, kept: SavedState<'d>) {
        self.frames.pop();
        match kept {
            SavedState::NoFaces => {}
            SavedState::Matrix(matrix) => self.state.matrix = matrix,
            SavedState::All(state) => self.state = *state,
        }
    }

    fn switch(&mut self, node: &'d V1Node<'d>) {
        let which = node.number("whichChild", -1.0);
        // By convention, the cameras of a file are the children of a switch with that name, which
        // selects the initial one; the others are available, too.
        let shows_every = which == -3.0 || node.name.as_deref() == Some("Cameras");
        let chosen: &[NodeId] = match node.children.get(which as usize..) {
            _ if shows_every => &node.children,
            Some([first, ..]) if which >= 0.0 => std::slice::from_ref(first),
            _ => &[],
        };
        if chosen.is_empty() && node.has_shapes {
            self.warn(
                node,
                "Switch with no child selected: its content is skipped",
            );
        }
        self.enter(node, chosen, SavedState::NoFaces);
    }

    fn lod(&mut self, node: &'d V1Node<'d>) {
        let levels = &node.children;
        let shows = |id: &&NodeId| self.document.nodes[**id as usize].has_shapes;
        let chosen = match self.builder.options.lod {
            Lod::All => return self.enter(node, levels, SavedState::NoFaces),
            Lod::Finest | Lod::Numbered(_) => levels.first(),
            Lod::Coarsest => levels.iter().rev().find(shows),
            Lod::Distance(distance) => {
                let ranges = node.numbers("range").unwrap_or(&[]);
                let nearer = ranges.iter().position(|range| distance < *range);
                let level = nearer.unwrap_or(ranges.len());
                levels.get(level.min(levels.len().saturating_sub(1)))
            }
        };
        let chosen = chosen.map_or(&[][..], std::slice::from_ref);
        self.enter(node, chosen, SavedState::NoFaces);
    }

    fn inline(&mut self, node: &V1Node) -> Result<(), ReadError> {
        let names: Vec<String> = node.words("name").iter().map(|n| n.to_string()).collect();
        // A nested file without a name is not an error: a script may set it later.
        if names.iter().all(String::is_empty) {
            return Ok(());
        }
        let frame = self.frame().named(node.name.as_deref());
        self.builder.include(self.source, node.at, &names, &frame)
    }

    /// Conventions supported by browsers of the time.
    fn info(&mut self, node: &V1Node) {
        match node.name.as_deref() {
            Some("BackgroundColor") => {
                let words = node.word("string");
                let numbers = words
                    .split([' ', ',', '\t', '\n'])
                    .filter(|w| !w.is_empty());
                let numbers: Option<Vec<f64>> = numbers.map(|w| w.parse().ok()).collect();
                match numbers.as_deref() {
                    Some(&[r, g, b]) if r >= 0.0 && g >= 0.0 && b >= 0.0 => {
                        let color = Rgb::new(r, g, b).map(|c| c.min(1.0));
                        self.builder.scene.background.get_or_insert(color.into());
                    }
                    _ => self.warn(node, "BackgroundColor that is not a colour: ignored"),
                }
            }
            Some("BackgroundImage") => self.warn(node, "BackgroundImage is ignored"),
            _ => {}
        }
    }

    fn light(&mut self, node: &V1Node) {
        if !node.is_on("on") {
            return self.warn(node, "light with on FALSE: skipped");
        }
        let frame = self.frame();
        match lights::light(node, &frame.world_from_object) {
            Some(kind) => {
                let name = frame.name(node.name.as_deref());
                self.builder
                    .scene
                    .lights
                    .push(azulejo_scene::Light { name, kind });
            }
            None => self.warn(node, "light without a valid position or direction: skipped"),
        }
    }

    fn camera(&mut self, node: &V1Node) {
        let frame = self.frame();
        match lights::camera(node, &frame.world_from_object) {
            Some(camera) => self.builder.scene.cameras.push(azulejo_scene::Camera {
                name: frame.name(node.name.as_deref()),
                ..camera
            }),
            None => self.warn(
                node,
                "camera without a direction or with an invalid angle: skipped",
            ),
        }
    }
}
