//! Follows the stream of nodes.

use super::lights;
use super::looks::Looks;
use super::node::{Document, Kind, Node, NodeId};
use super::state::{Hints, Per, State, matrix_transform, rotation, transform, uv_transform};
use crate::reading::text::{shortened, text};
use crate::vrml::stage::{Frame, Source, Stage};
use crate::{Lod, ReadError};
use azulejo_scene::Rgb;
use glam::{DAffine3, DVec3};

/// A walk through the nodes of one file.
pub(super) struct Walk<'d, 's, 'f> {
    pub stage: &'s mut Stage<'f>,
    pub source: &'s Source,
    pub document: &'d Document<'d>,
    pub state: State<'d>,
    pub looks: Looks,
    /// Where the file stands, and inside it each group that is being walked through.
    frames: Vec<Frame>,
    /// What is left to do, the next at the end. A list and not recursion: groups that use each
    /// other may nest deeper than any stack.
    steps: Vec<Step<'d>>,
    inventor: bool,
}

/// Something to do.
enum Step<'d> {
    Visit(NodeId),
    /// A group ends, and what of the state was kept before it comes back.
    Leave(Kept<'d>),
}

/// What of the state a group brings back.
enum Kept<'d> {
    Nothing,
    Matrix(DAffine3),
    All(Box<State<'d>>),
}

/// Walks through a file and puts what it shows under `frame`.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn walk(
    stage: &mut Stage,
    source: &Source,
    document: &Document,
    frame: &Frame,
    inventor: bool,
) -> Result<(), ReadError> {
    let mut walk = Walk {
        stage,
        source,
        document,
        state: State::new(inventor),
        looks: Looks::default(),
        frames: vec![frame.clone()],
        steps: Vec::new(),
        inventor,
    };
    walk.visit_all(&document.roots);
    while let Some(step) = walk.steps.pop() {
        match step {
            Step::Visit(id) => walk.visit(&document.nodes[id as usize])?,
            Step::Leave(kept) => walk.leave(kept),
        }
    }
    Ok(())
}

impl<'d> Walk<'d, '_, '_> {
    /// Counts a warning about a node.
    pub fn warn(&mut self, node: &Node, message: impl Into<String>) {
        self.stage.warn(self.source, node.at, message);
    }

    /// Where a shape stands that comes now, and the names on the way there.
    pub fn frame(&self) -> Frame {
        let group = self.frames.last().cloned().unwrap_or_default();
        group.moved(self.state.matrix)
    }

    fn visit_all(&mut self, nodes: &[NodeId]) {
        let visits = nodes.iter().rev().map(|id| Step::Visit(*id));
        self.steps.extend(visits);
    }

    fn visit(&mut self, node: &'d Node<'d>) -> Result<(), ReadError> {
        self.stage.spend(1)?;
        match node.kind {
            Kind::Separator | Kind::Unknown => {
                self.enter(node, &node.children, Kept::All(Box::new(self.state)));
            }
            Kind::TransformSeparator => {
                self.enter(node, &node.children, Kept::Matrix(self.state.matrix));
            }
            Kind::Group => self.enter(node, &node.children, Kept::Nothing),
            Kind::Switch => self.switch(node),
            Kind::Lod => self.lod(node),
            Kind::Inline => self.inline(node)?,
            _ if node.kind.is_shape() && self.is_invisible() => {
                self.warn(node, "shape of transparency 1: left out");
            }
            Kind::IndexedFaceSet => self.face_set(node)?,
            Kind::Cube | Kind::Sphere | Kind::Cylinder | Kind::Cone => self.solid(node)?,
            Kind::PointLight | Kind::SpotLight | Kind::DirectionalLight => self.light(node),
            Kind::PerspectiveCamera => self.camera(node),
            Kind::Info => self.info(node),
            Kind::NoSurface | Kind::OrthographicCamera => {
                let name = text(node.type_name);
                self.warn(node, format!("{name} is not read: skipped"));
            }
            Kind::Silent => {}
            _ => self.property(node),
        }
        Ok(())
    }

    /// Nodes that change the state.
    fn property(&mut self, node: &'d Node<'d>) {
        let state = &mut self.state;
        match node.kind {
            Kind::Coordinate3 => state.points = node.vectors("point").unwrap_or(&[DVec3::ZERO]),
            Kind::Normal => state.normals = node.vectors("vector").unwrap_or(&[]),
            Kind::TextureCoordinate2 => state.uvs = node.vectors2("point").unwrap_or(&[]),
            Kind::Material => state.material = Some(node),
            Kind::MaterialBinding => self.state.material_binding = self.part(node),
            Kind::NormalBinding => self.state.normal_binding = self.part(node),
            Kind::Texture2 => self.state.texture = self.texture(node),
            Kind::Texture2Transform => state.uv_matrix *= uv_transform(node),
            Kind::ShapeHints => state.hints = Hints::of(node, self.inventor),
            Kind::Transform => state.matrix *= transform(node),
            Kind::Translation => {
                let by = node.vector("translation", DVec3::ZERO);
                state.matrix *= DAffine3::from_translation(by);
            }
            Kind::Rotation => {
                state.matrix *= DAffine3::from_quat(rotation(node.exactly("rotation")));
            }
            Kind::Scale => {
                let by = node.vector("scaleFactor", DVec3::ONE);
                state.matrix *= DAffine3::from_scale(by);
            }
            Kind::MatrixTransform => match matrix_transform(node) {
                Some(map) => state.matrix *= map,
                None => self.warn(node, "matrix that is not affine: not used"),
            },
            _ => {}
        }
    }

    fn part(&mut self, node: &Node) -> Per {
        let word = node.word("value");
        Per::named(word).unwrap_or_else(|| {
            let shown = shortened(word);
            self.warn(node, format!("binding {shown} is not known: DEFAULT taken"));
            Per::Default
        })
    }

    fn enter(&mut self, node: &Node, children: &[NodeId], kept: Kept<'d>) {
        let outer = self.frames.last().cloned().unwrap_or_default();
        self.frames.push(outer.named(node.name.as_deref()));
        self.steps.push(Step::Leave(kept));
        self.visit_all(children);
    }

    fn leave(&mut self, kept: Kept<'d>) {
        self.frames.pop();
        match kept {
            Kept::Nothing => {}
            Kept::Matrix(matrix) => self.state.matrix = matrix,
            Kept::All(state) => self.state = *state,
        }
    }

    fn switch(&mut self, node: &'d Node<'d>) {
        let which = node.number("whichChild", -1.0);
        // By convention the cameras of a file stand in a switch of that name, which chooses the
        // first to look through; the others are meant to be there too.
        let all = which == -3.0 || node.name.as_deref() == Some("Cameras");
        let chosen: &[NodeId] = match node.children.get(which as usize..) {
            _ if all => &node.children,
            Some([first, ..]) if which >= 0.0 => std::slice::from_ref(first),
            _ => &[],
        };
        if chosen.is_empty() && node.has_shapes {
            self.warn(node, "Switch that chooses no child: nothing in it is shown");
        }
        self.enter(node, chosen, Kept::Nothing);
    }

    fn lod(&mut self, node: &'d Node<'d>) {
        let levels = &node.children;
        let shows = |id: &&NodeId| self.document.nodes[**id as usize].has_shapes;
        let chosen = match self.stage.options.lod {
            Lod::All => return self.enter(node, levels, Kept::Nothing),
            Lod::Finest => levels.first(),
            Lod::Coarsest => levels.iter().rev().find(shows),
            Lod::Distance(distance) => {
                let ranges = node.numbers("range").unwrap_or(&[]);
                let nearer = ranges.iter().position(|range| distance < *range);
                let level = nearer.unwrap_or(ranges.len());
                levels.get(level.min(levels.len().saturating_sub(1)))
            }
        };
        let chosen = chosen.map_or(&[][..], std::slice::from_ref);
        self.enter(node, chosen, Kept::Nothing);
    }

    fn inline(&mut self, node: &Node) -> Result<(), ReadError> {
        let names: Vec<String> = node.words("name").iter().map(|n| n.to_string()).collect();
        // A file inside this one that has no name yet is not an error: it may come later.
        if names.iter().all(String::is_empty) {
            return Ok(());
        }
        let frame = self.frame().named(node.name.as_deref());
        crate::vrml::include(self.stage, self.source, node.at, &names, &frame)
    }

    /// Conventions that browsers of the time kept alive.
    fn info(&mut self, node: &Node) {
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
                        self.stage.scene.background.get_or_insert(color);
                    }
                    _ => self.warn(node, "BackgroundColor that is no colour: not used"),
                }
            }
            Some("BackgroundImage") => self.warn(node, "BackgroundImage is not used"),
            _ => {}
        }
    }

    fn light(&mut self, node: &Node) {
        if !node.is_on("on") {
            return self.warn(node, "light that is off: skipped");
        }
        let frame = self.frame();
        match lights::light(node, &frame.world_from_object) {
            Some(kind) => {
                let name = frame.name(node.name.as_deref());
                self.stage
                    .scene
                    .lights
                    .push(azulejo_scene::Light { name, kind });
            }
            None => self.warn(node, "light without a place or a direction: skipped"),
        }
    }

    fn camera(&mut self, node: &Node) {
        let frame = self.frame();
        match lights::camera(node, &frame.world_from_object) {
            Some(camera) => self.stage.scene.cameras.push(azulejo_scene::Camera {
                name: frame.name(node.name.as_deref()),
                ..camera
            }),
            None => self.warn(
                node,
                "camera without a direction or with an impossible angle: skipped",
            ),
        }
    }
}
