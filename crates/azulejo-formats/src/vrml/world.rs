//! Converts the tree of nodes to a scene: groups and their children.

use super::builder::{OpenedFile, ShapeOutcome, VrmlPlacement, VrmlSceneBuilder};
use super::lights;
use super::tree::{VrmlDocument, VrmlNode};
use crate::reading::text::shortened;
use crate::{Lod, ReadError};
use glam::{DAffine3, DQuat, DVec3};
use std::rc::Rc;

/// Maximum depth of nested groups once prototypes are unfolded.
const MOST_DEPTH: u32 = 200;

/// What a node takes from the budget: many nodes may display nothing, but still take time.
const NODE: u64 = 32;

/// The position of a node in the hierarchy.
#[derive(Clone)]
pub(super) struct NodePosition {
    /// Its transformation and name path.
    pub frame: VrmlPlacement,
    /// The number of enclosing groups.
    pub depth: u32,
}

impl NodePosition {
    fn inside(&self, frame: VrmlPlacement) -> NodePosition {
        NodePosition {
            frame,
            depth: self.depth + 1,
        }
    }
}

/// Adds the content of a file under `frame`.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn build(
    builder: &mut VrmlSceneBuilder,
    document: &VrmlDocument,
    frame: &VrmlPlacement,
) -> Result<(), ReadError> {
    let mut frame = frame.clone();
    if let Some(metres) = document.metres.filter(|m| *m > 0.0 && m.is_finite()) {
        if builder.is_outermost() {
            builder.scene.units.metres_per_unit = Some(metres);
        } else {
            // The enclosing file has a unit of its own.
            let scale = metres / builder.scene.units.metres();
            frame = frame.moved(DAffine3::from_scale(DVec3::splat(scale)));
        }
    }
    let place = NodePosition { frame, depth: 0 };
    for node in &document.roots {
        builder.visit(node, &place)?;
    }
    Ok(())
}

impl VrmlSceneBuilder<'_> {
    /// Adds a node and everything below it to the scene.
    fn visit(&mut self, node: &Rc<VrmlNode>, place: &NodePosition) -> Result<(), ReadError> {
        self.spend(NODE)?;
        if place.depth >= MOST_DEPTH {
            let message = format!("group nested more than {MOST_DEPTH} deep: skipped");
            self.warn_node(node, message);
            return Ok(());
        }
        if node.proto.is_some() {
            let Some(shown) = self.unfold(node)? else {
                return Ok(());
            };
            let frame = place.frame.named(node.name.as_deref());
            return self.visit(&shown, &place.inside(frame));
        }
        match &*node.kind {
            "Shape" => self.place_shape(node, &place.frame),
            "Inline" | "InlineLoadControl" => self.inline(node, place),
            "PointLight" | "SpotLight" | "DirectionalLight" => {
                lights::place(self, node, place);
                Ok(())
            }
            "Viewpoint" | "Background" | "TextureBackground" | "Fog" | "NavigationInfo" => {
                self.place_environment(node, &place.frame);
                Ok(())
            }
            // Metadata, which azulejo does not use.
            "WorldInfo" | "MetadataBoolean" | "MetadataDouble" | "MetadataFloat"
            | "MetadataInteger" | "MetadataSet" | "MetadataString" => Ok(()),
            "Switch" => self.switch(node, place),
            "LOD" => self.levels(node, place),
            _ => match groups(&node.kind) {
                Some(fields) => self.group(node, fields, place),
                None => {
                    self.skip(node);
                    Ok(())
                }
            },
        }
    }

    /// Counts a node that is not supported.
    #[cold]
    pub(super) fn skip(&mut self, node: &VrmlNode) {
        let message = format!("node {}: skipped", shortened(&node.kind));
        self.warn_node(node, message);
    }

    /// The node that an instance of a prototype stands for, unfolded until it is not an instance.
    /// `None`, with a warning, if there is no such node.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn unfold(
        &mut self,
        instance: &Rc<VrmlNode>,
    ) -> Result<Option<Rc<VrmlNode>>, ReadError> {
        // Prototypes of several files may refer to each other in a cycle.
        const MOST_UNFOLDED: usize = 32;
        let mut node = instance.clone();
        for _ in 0..MOST_UNFOLDED {
            let Some(proto) = node.proto.clone() else {
                return Ok(Some(node));
            };
            let defined = if proto.urls.is_empty() {
                Some(proto)
            } else {
                self.external_prototype(&node, &proto.urls)?
            };
            let mut made = 0;
            let shown = defined.and_then(|proto| proto.unfold(&node, &mut made));
            self.spend(NODE * (1 + made))?;
            let Some(shown) = shown else {
                let kind = shortened(&node.kind);
                let message = format!("instance of {kind}, a prototype without a body: skipped");
                self.warn_node(&node, message);
                return Ok(None);
            };
            node = shown;
        }
        let message = "prototype that refers to itself: skipped";
        self.warn_node(instance, message);
        Ok(None)
    }

    /// A prototype defined in another file: the one named after `#`, otherwise the file's first.
    fn external_prototype(
        &mut self,
        node: &VrmlNode,
        urls: &[String],
    ) -> Result<Option<Rc<super::tree::Prototype>>, ReadError> {
        let fragment = urls.iter().find_map(|url| url.split_once('#'));
        let document = match self.open(&node.source, node.at, urls) {
            None => return Ok(None),
            Some(OpenedFile::Known(document)) => document,
            Some(OpenedFile::New(source)) => match self.document(&source) {
                Ok(document) => document,
                Err(e) => {
                    self.close();
                    self.refuse(&node.source, node.at, &source, e)?;
                    return Ok(None);
                }
            },
        };
        self.close();
        let mut protos = document.protos.iter();
        Ok(match fragment {
            Some((_, name)) => protos.rfind(|proto| *proto.name == *name),
            None => protos.next(),
        }
        .cloned())
    }

    /// The nodes of a field, with a warning if it holds other values.
    fn nodes<'n>(&mut self, node: &'n VrmlNode, field: &str) -> &'n [Rc<VrmlNode>] {
        if node.value(field).is_some_and(|value| !value.is_nodes()) {
            let message = format!("{field} of {} is not a node: skipped", node.kind);
            self.warn_node(node, message);
        }
        node.nodes(field)
    }

    /// The first node of a field, with prototypes unfolded.
    ///
    /// # Errors
    /// The model unfolds to more than the options allow.
    pub(super) fn child(
        &mut self,
        node: &VrmlNode,
        field: &str,
    ) -> Result<Option<Rc<VrmlNode>>, ReadError> {
        match self.nodes(node, field).first() {
            Some(child) => self.unfold(child),
            None => Ok(None),
        }
    }

    fn group(
        &mut self,
        node: &VrmlNode,
        fields: &[&str],
        place: &NodePosition,
    ) -> Result<(), ReadError> {
        let lost = match &*node.kind {
            "Billboard" => {
                Some("Billboard: kept in its original orientation, it does not turn to the viewer")
            }
            "Collision" if !node.nodes("proxy").is_empty() => {
                Some("proxy of a Collision, which is never visible: skipped")
            }
            _ => None,
        };
        if let Some(message) = lost {
            self.warn_node(node, message);
        }
        let frame = place.frame.named(node.name.as_deref());
        let place = place.inside(if is_transformation(&node.kind) {
            frame.moved(transformation(node))
        } else {
            frame
        });
        for field in fields {
            for child in self.nodes(node, field) {
                self.visit(child, &place)?;
            }
        }
        Ok(())
    }

    /// The children of a Switch or LOD: VRML97 has another name for them.
    fn choices<'n>(&mut self, node: &'n VrmlNode, vrml97: &str) -> &'n [Rc<VrmlNode>] {
        match self.nodes(node, "children") {
            [] => self.nodes(node, vrml97),
            children => children,
        }
    }

    fn switch(&mut self, node: &VrmlNode, place: &NodePosition) -> Result<(), ReadError> {
        let children = self.choices(node, "choice");
        let chosen = usize::try_from(node.number("whichChoice", -1.0) as i64).ok();
        let chosen = chosen.filter(|i| *i < children.len());
        let hidden = children.len() - usize::from(chosen.is_some());
        let message = "child of a Switch that is not selected: skipped";
        self.warn_many(&node.source, node.at, message, hidden);
        let place = place.inside(place.frame.named(node.name.as_deref()));
        match chosen {
            Some(i) => self.visit(&children[i], &place),
            None => Ok(()),
        }
    }

    fn levels(&mut self, node: &VrmlNode, place: &NodePosition) -> Result<(), ReadError> {
        let children = self.choices(node, "level");
        let place = place.inside(place.frame.named(node.name.as_deref()));
        let level = match self.options.lod {
            Lod::Finest | Lod::Numbered(_) => 0,
            Lod::Coarsest => {
                let mut left = MOST_LOOKED_AT;
                let shows = |n: &Rc<VrmlNode>| shows_something(n, &mut left);
                children.iter().rposition(shows).unwrap_or(0)
            }
            Lod::Distance(distance) => {
                let ranges = node.numbers("range");
                let beyond = ranges.iter().take_while(|range| distance >= **range);
                beyond.count().min(children.len().saturating_sub(1))
            }
            Lod::All => {
                for child in children {
                    self.visit(child, &place)?;
                }
                return Ok(());
            }
        };
        let message = "level of detail that is not the requested one: skipped";
        let hidden = children.len().saturating_sub(1);
        self.warn_many(&node.source, node.at, message, hidden);
        match children.get(level) {
            Some(child) => self.visit(child, &place),
            None => Ok(()),
        }
    }

    fn inline(&mut self, node: &VrmlNode, place: &NodePosition) -> Result<(), ReadError> {
        if !node.flag("load", true) {
            self.warn_node(node, "Inline with load FALSE: skipped");
            return Ok(());
        }
        let frame = place.frame.named(node.name.as_deref());
        let urls = node.strings("url");
        self.include(&node.source, node.at, &urls, &frame)
    }

    /// Warns about an object that was not added.
    pub(super) fn report(&mut self, node: &VrmlNode, placed: ShapeOutcome) {
        let why = match placed {
            ShapeOutcome::Object => return,
            ShapeOutcome::NoFaces => "without faces",
            ShapeOutcome::Degenerate => "with a singular or overflowing transformation",
        };
        let message = format!("{} {why}: skipped", shortened(&node.kind));
        self.warn_node(node, message);
    }
}

/// The fields that hold the children of a group; `None` if the node is not a group.
fn groups(kind: &str) -> Option<&'static [&'static str]> {
    Some(match kind {
        "Group" | "Transform" | "StaticGroup" | "Anchor" | "Billboard" | "Collision"
        | "CADAssembly" | "CADLayer" | "CADPart" | "EspduTransform" | "HAnimJoint"
        | "HAnimSegment" | "HAnimSite" | "LayoutGroup" | "PickableGroup" | "ViewpointGroup"
        | "Viewport" | "Layer" => &["children"],
        "CADFace" => &["shape"],
        "CollidableOffset" | "CollidableShape" => &["collidable"],
        "HAnimHumanoid" => &["skeleton", "skin"],
        "LayerSet" => &["layers"],
        _ => return None,
    })
}

fn is_transformation(kind: &str) -> bool {
    matches!(
        kind,
        "Transform" | "CADPart" | "EspduTransform" | "HAnimHumanoid" | "HAnimJoint" | "HAnimSite"
    )
}

/// T × C × R × SR × S × −SR × −C, ISO/IEC 14772-1, 6.52.
fn transformation(node: &VrmlNode) -> DAffine3 {
    let center = node.vector("center", DVec3::ZERO);
    let translation = node.vector("translation", DVec3::ZERO);
    let turn = rotation(node.array("rotation", [0.0, 0.0, 1.0, 0.0]));
    let stretch = rotation(node.array("scaleOrientation", [0.0, 0.0, 1.0, 0.0]));
    let scale = node.vector("scale", DVec3::ONE);
    DAffine3::from_translation(translation + center)
        * DAffine3::from_quat(turn * stretch)
        * DAffine3::from_scale(scale)
        * DAffine3::from_quat(stretch.inverse())
        * DAffine3::from_translation(-center)
}

/// A rotation about an axis of any length; the identity if the axis is zero.
pub(super) fn rotation([x, y, z, angle]: [f64; 4]) -> DQuat {
    match DVec3::new(x, y, z).try_normalize() {
        Some(axis) => DQuat::from_axis_angle(axis, angle),
        None => DQuat::IDENTITY,
    }
}

/// Maximum number of nodes examined to decide whether a level of detail is empty.
const MOST_LOOKED_AT: u32 = 10_000;

/// Whether a node is likely to have a surface. Prototypes are assumed to have one.
fn shows_something(node: &VrmlNode, left: &mut u32) -> bool {
    if *left == 0 || node.proto.is_some() || matches!(&*node.kind, "Shape" | "Inline") {
        return true;
    }
    *left -= 1;
    let fields = ["children", "choice", "level", "shape", "skeleton", "skin"];
    let children = || fields.iter().flat_map(|field| node.nodes(field));
    children().any(|child| shows_something(child, left))
}
