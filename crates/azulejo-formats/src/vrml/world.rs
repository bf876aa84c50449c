//! From the tree of nodes to the scene: groups, and what may stand in them.

use super::stage::{Frame, Opened, Placed, Source, Stage};
use super::tree::{Document, Node};
use super::{lights, shape, surroundings};
use crate::reading::text::shortened;
use crate::{Lod, ReadError};
use glam::{DAffine3, DQuat, DVec3};
use std::rc::Rc;

/// How deep groups may stand inside one another once prototypes are unfolded.
const MOST_DEPTH: u32 = 200;

/// What a node costs of what a model may unfold to: many nodes may show nothing, but take time.
const NODE: u64 = 32;

/// Where a node stands.
#[derive(Clone)]
pub(super) struct Place {
    /// Its frame in the world.
    pub frame: Frame,
    /// How many groups are around it.
    pub depth: u32,
}

impl Place {
    fn inside(&self, frame: Frame) -> Place {
        Place {
            frame,
            depth: self.depth + 1,
        }
    }
}

/// Puts what a file holds under `frame`.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn build(
    stage: &mut Stage,
    document: &Document,
    frame: &Frame,
) -> Result<(), ReadError> {
    let mut frame = frame.clone();
    if let Some(metres) = document.metres.filter(|m| *m > 0.0 && m.is_finite()) {
        if stage.is_outermost() {
            stage.scene.units.metres_per_unit = Some(metres);
        } else {
            // The file around this one has its own unit.
            let scale = metres / stage.scene.units.metres();
            frame = frame.moved(DAffine3::from_scale(DVec3::splat(scale)));
        }
    }
    let place = Place { frame, depth: 0 };
    for node in &document.roots {
        visit(stage, node, &place)?;
    }
    Ok(())
}

/// Puts a node into the scene, with all that is in it.
fn visit(stage: &mut Stage, node: &Rc<Node>, place: &Place) -> Result<(), ReadError> {
    stage.spend(NODE)?;
    if place.depth >= MOST_DEPTH {
        let message = format!("group inside {MOST_DEPTH} others: skipped");
        stage.warn(&node.source, node.at, message);
        return Ok(());
    }
    if node.proto.is_some() {
        let Some(shown) = unfold(stage, node)? else {
            return Ok(());
        };
        let frame = place.frame.named(node.name.as_deref());
        return visit(stage, &shown, &place.inside(frame));
    }
    match &*node.kind {
        "Shape" => shape::place(stage, node, &place.frame),
        "Inline" | "InlineLoadControl" => inline(stage, node, place),
        "PointLight" | "SpotLight" | "DirectionalLight" => {
            lights::place(stage, node, place);
            Ok(())
        }
        "Viewpoint" | "Background" | "TextureBackground" | "Fog" | "NavigationInfo" => {
            surroundings::place(stage, node, &place.frame);
            Ok(())
        }
        // They tell people and programs what azulejo has no use for.
        "WorldInfo" | "MetadataBoolean" | "MetadataDouble" | "MetadataFloat"
        | "MetadataInteger" | "MetadataSet" | "MetadataString" => Ok(()),
        "Switch" => switch(stage, node, place),
        "LOD" => levels(stage, node, place),
        _ => match groups(&node.kind) {
            Some(fields) => group(stage, node, fields, place),
            None => {
                skip(stage, node);
                Ok(())
            }
        },
    }
}

/// Counts a node that is not shown.
#[cold]
pub(super) fn skip(stage: &mut Stage, node: &Node) {
    let message = format!("node {}: skipped", shortened(&node.kind));
    stage.warn(&node.source, node.at, message);
}

/// The node that an instance of a prototype stands for, and so on until it is none. `None`, with
/// a warning, if there is no such node.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn unfold(
    stage: &mut Stage,
    instance: &Rc<Node>,
) -> Result<Option<Rc<Node>>, ReadError> {
    // Prototypes of other files may stand for each other in a circle.
    const MOST_UNFOLDED: usize = 32;
    let mut node = instance.clone();
    for _ in 0..MOST_UNFOLDED {
        let Some(proto) = node.proto.clone() else {
            return Ok(Some(node));
        };
        let defined = match proto.urls.is_empty() {
            true => Some(proto),
            false => external(stage, &node, &proto.urls)?,
        };
        let mut made = 0;
        let shown = defined.and_then(|proto| proto.unfold(&node, &mut made));
        stage.spend(NODE * (1 + made))?;
        let Some(shown) = shown else {
            let kind = shortened(&node.kind);
            let message = format!("{kind}, a prototype that stands for nothing: skipped");
            stage.warn(&node.source, node.at, message);
            return Ok(None);
        };
        node = shown;
    }
    let message = "prototype that stands for itself: skipped";
    stage.warn(&instance.source, instance.at, message);
    Ok(None)
}

/// A prototype that another file defines: the one behind `#`, else the file's first.
fn external(
    stage: &mut Stage,
    node: &Node,
    urls: &[String],
) -> Result<Option<Rc<super::tree::Proto>>, ReadError> {
    let wanted = urls.iter().find_map(|url| url.split_once('#'));
    let document = match stage.open(&node.source, node.at, urls) {
        None => return Ok(None),
        Some(Opened::Known(document)) => document,
        Some(Opened::New(source)) => match super::document(stage, &source) {
            Ok(document) => document,
            Err(e) => {
                stage.close();
                super::refuse(stage, &node.source, node.at, &source, e)?;
                return Ok(None);
            }
        },
    };
    stage.close();
    let mut protos = document.protos.iter();
    Ok(match wanted {
        Some((_, name)) => protos.rfind(|proto| *proto.name == *name),
        None => protos.next(),
    }
    .cloned())
}

/// The nodes of a field, with a warning if it holds something else.
fn nodes<'n>(stage: &mut Stage, node: &'n Node, field: &str) -> &'n [Rc<Node>] {
    if node.value(field).is_some_and(|value| !value.is_nodes()) {
        let message = format!("{field} of {} that is no node: skipped", node.kind);
        stage.warn(&node.source, node.at, message);
    }
    node.nodes(field)
}

/// The first node of a field, with prototypes unfolded.
///
/// # Errors
/// The model unfolds to more than the options allow.
pub(super) fn child(
    stage: &mut Stage,
    node: &Node,
    field: &str,
) -> Result<Option<Rc<Node>>, ReadError> {
    match nodes(stage, node, field).first() {
        Some(child) => unfold(stage, child),
        None => Ok(None),
    }
}

/// The fields in which a group keeps its children; `None` for a node that is no group.
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

fn group(stage: &mut Stage, node: &Node, fields: &[&str], place: &Place) -> Result<(), ReadError> {
    let lost = match &*node.kind {
        "Billboard" => Some("Billboard: stands as it is, and does not turn to the viewer"),
        "Collision" if !node.nodes("proxy").is_empty() => {
            Some("proxy of a Collision, which is never seen: not shown")
        }
        _ => None,
    };
    if let Some(message) = lost {
        stage.warn(&node.source, node.at, message);
    }
    let frame = place.frame.named(node.name.as_deref());
    let place = place.inside(match is_transformation(&node.kind) {
        true => frame.moved(transformation(node)),
        false => frame,
    });
    for field in fields {
        for child in nodes(stage, node, field) {
            visit(stage, child, &place)?;
        }
    }
    Ok(())
}

fn is_transformation(kind: &str) -> bool {
    matches!(
        kind,
        "Transform" | "CADPart" | "EspduTransform" | "HAnimHumanoid" | "HAnimJoint" | "HAnimSite"
    )
}

/// T × C × R × SR × S × −SR × −C, ISO/IEC 14772-1, 6.52.
fn transformation(node: &Node) -> DAffine3 {
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

/// A turn about an axis of any length; about none it is none.
pub(super) fn rotation([x, y, z, angle]: [f64; 4]) -> DQuat {
    match DVec3::new(x, y, z).try_normalize() {
        Some(axis) => DQuat::from_axis_angle(axis, angle),
        None => DQuat::IDENTITY,
    }
}

/// The children of a node that chooses among them: VRML97 has another name for them.
fn choices<'n>(stage: &mut Stage, node: &'n Node, vrml97: &str) -> &'n [Rc<Node>] {
    match nodes(stage, node, "children") {
        [] => nodes(stage, node, vrml97),
        children => children,
    }
}

fn switch(stage: &mut Stage, node: &Node, place: &Place) -> Result<(), ReadError> {
    let children = choices(stage, node, "choice");
    let chosen = usize::try_from(node.number("whichChoice", -1.0) as i64).ok();
    let chosen = chosen.filter(|i| *i < children.len());
    let hidden = children.len() - usize::from(chosen.is_some());
    let message = "child of a Switch that is not chosen: not shown";
    stage.warn_many(&node.source, node.at, message, hidden);
    let place = place.inside(place.frame.named(node.name.as_deref()));
    match chosen {
        Some(i) => visit(stage, &children[i], &place),
        None => Ok(()),
    }
}

fn levels(stage: &mut Stage, node: &Node, place: &Place) -> Result<(), ReadError> {
    let children = choices(stage, node, "level");
    let place = place.inside(place.frame.named(node.name.as_deref()));
    let level = match stage.options.lod {
        Lod::Finest => 0,
        Lod::Coarsest => {
            let mut left = MOST_LOOKED_AT;
            let shows = |n: &Rc<Node>| shows_something(n, &mut left);
            children.iter().rposition(shows).unwrap_or(0)
        }
        Lod::Distance(distance) => {
            let ranges = node.numbers("range");
            let beyond = ranges.iter().take_while(|range| distance >= **range);
            beyond.count().min(children.len().saturating_sub(1))
        }
        Lod::All => {
            for child in children {
                visit(stage, child, &place)?;
            }
            return Ok(());
        }
    };
    let message = "level of detail that is not the one asked for: not shown";
    let hidden = children.len().saturating_sub(1);
    stage.warn_many(&node.source, node.at, message, hidden);
    match children.get(level) {
        Some(child) => visit(stage, child, &place),
        None => Ok(()),
    }
}

/// How many nodes are looked at for whether a level of detail is empty.
const MOST_LOOKED_AT: u32 = 10_000;

/// Whether a node is likely to have a surface. Prototypes are believed to.
fn shows_something(node: &Node, left: &mut u32) -> bool {
    if *left == 0 || node.proto.is_some() || matches!(&*node.kind, "Shape" | "Inline") {
        return true;
    }
    *left -= 1;
    let fields = ["children", "choice", "level", "shape", "skeleton", "skin"];
    let children = || fields.iter().flat_map(|field| node.nodes(field));
    children().any(|child| shows_something(child, left))
}

fn inline(stage: &mut Stage, node: &Node, place: &Place) -> Result<(), ReadError> {
    if !node.flag("load", true) {
        stage.warn(
            &node.source,
            node.at,
            "Inline that is not to be loaded: skipped",
        );
        return Ok(());
    }
    let frame = place.frame.named(node.name.as_deref());
    let urls = node.strings("url");
    super::include(stage, &node.source, node.at, &urls, &frame)
}

/// Says what became of an object.
pub(super) fn report(stage: &mut Stage, source: &Source, at: usize, what: &str, placed: Placed) {
    let why = match placed {
        Placed::Object => return,
        Placed::Nothing => "without faces",
        Placed::Nowhere => "flattened to nothing, or beyond all numbers",
    };
    let message = format!("{} {why}: skipped", shortened(what));
    stage.warn(source, at, message);
}
