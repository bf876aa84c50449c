//! Converts exact shapes to the most compact blocks.

use super::super::document::{GrfName, ObjectNotes, SourcePosition};
use super::skin::{mesh_block, skin_block};
use super::{
    CsgBlock, ExactBlock, FigureBlock, GlyphBlock, GlyphOrigin, SolidBlock, SolidKind, TextBlock,
};
use azulejo_scene::{Exact, Figure, MaterialId, Prism, Scene, Shape, Solid};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::HashMap;
use std::sync::Arc;

/// The names of a scene's figures. Prisms that share a figure share its name; equal figures that
/// are not shared stay separate.
#[derive(Debug, Default)]
pub(in crate::grf) struct Figures {
    names: HashMap<*const Figure, GrfName>,
    /// In the order of their first use by the scene's objects.
    pub blocks: Vec<FigureBlock>,
}

impl Figures {
    /// The figures of all objects.
    pub fn of(scene: &Scene) -> Figures {
        let mut figures = Figures::default();
        for object in &scene.objects {
            if let Shape::Exact(exact) = &object.shape {
                exact.solids.iter().for_each(|s| figures.gather(s));
            }
        }
        figures
    }

    fn gather(&mut self, solid: &Solid) {
        match solid {
            Solid::Prism(prism) => self.add(&prism.figure),
            Solid::Shell(pieces) => pieces.iter().for_each(|s| self.gather(s)),
            Solid::Csg(csg) => {
                let sides = csg.left.iter().chain(&csg.right);
                sides.for_each(|s| self.gather(s));
            }
            Solid::Primitive(_) | Solid::Patch(_) | Solid::Mesh(_) => {}
        }
    }

    fn add(&mut self, figure: &Arc<Figure>) {
        let number = self.blocks.len();
        self.names.entry(Arc::as_ptr(figure)).or_insert_with(|| {
            let name = GrfName::from(format!("f{number}"));
            self.blocks.push(FigureBlock {
                name: GrfName::clone(&name),
                figure: Arc::clone(figure),
            });
            name
        });
    }

    fn name(&self, figure: &Arc<Figure>) -> GrfName {
        self.names[&Arc::as_ptr(figure)].clone()
    }
}

/// The block of an exact shape; `materials` are the names of the scene's brdfs.
pub(in crate::grf) fn exact_block(
    exact: &Exact,
    figures: &Figures,
    materials: &[GrfName],
    notes: ObjectNotes,
) -> ExactBlock {
    let writer = SolidWriter { figures, materials };
    let common = exact.solids.iter().find_map(material);
    ExactBlock {
        solids: writer.blocks(&exact.solids, common),
        skin: skin_block(exact, None),
        notes: ObjectNotes {
            material: common.map(|m| writer.materials[m as usize].clone()),
            ..notes
        },
    }
}

/// The material of the first solid that has one; a mesh without faces has none.
fn material(solid: &Solid) -> Option<MaterialId> {
    match solid {
        Solid::Primitive(p) => Some(p.material),
        Solid::Prism(p) => Some(p.material),
        Solid::Patch(p) => Some(p.material),
        Solid::Mesh(m) => m.face_materials.first().copied(),
        Solid::Shell(pieces) => pieces.iter().find_map(material),
        Solid::Csg(csg) => csg.left.iter().chain(&csg.right).find_map(material),
    }
}

struct SolidWriter<'s> {
    figures: &'s Figures,
    materials: &'s [GrfName],
}

impl SolidWriter<'_> {
    /// Blocks inside one with the material `around`. Consecutive prisms that differ only in
    /// position form a text.
    fn blocks(&self, solids: &[Solid], around: Option<MaterialId>) -> Vec<SolidBlock> {
        let runs = solids.chunk_by(are_glyphs);
        let block = |run: &[Solid]| {
            let own = material(&run[0]);
            SolidBlock {
                place: SourcePosition::default(),
                material: (own.filter(|_| own != around))
                    .map(|m| self.materials[m as usize].clone()),
                kind: self.kind(run, own.or(around)),
            }
        };
        runs.map(block).collect()
    }

    fn kind(&self, run: &[Solid], around: Option<MaterialId>) -> SolidKind {
        if run.len() > 1 {
            return SolidKind::Text(Box::new(self.text(run)));
        }
        match &run[0] {
            Solid::Primitive(p) => SolidKind::Primitive(p.kind, Box::new(p.world_from_object)),
            Solid::Prism(p) => {
                let name = self.figures.name(&p.figure);
                SolidKind::Prism(name, Box::new(p.world_from_figure), p.bevel.clone())
            }
            Solid::Patch(p) => SolidKind::Patch(p.points.clone()),
            Solid::Mesh(m) => SolidKind::Mesh(Box::new(mesh_block((**m).clone()))),
            Solid::Shell(pieces) => SolidKind::Shell(self.blocks(pieces, around)),
            Solid::Csg(csg) => SolidKind::Csg(Box::new(CsgBlock {
                operation: csg.operation,
                left: self.blocks(&csg.left, around),
                right: self.blocks(&csg.right, around),
            })),
        }
    }

    fn text(&self, run: &[Solid]) -> TextBlock {
        let prisms = || run.iter().filter_map(prism);
        let mut text = TextBlock {
            string: None,
            map: prisms()
                .next()
                .map_or(DAffine3::IDENTITY, |p| p.world_from_figure),
            bevel: prisms().next().and_then(|p| p.bevel.clone()),
            glyphs: Vec::with_capacity(run.len()),
        };
        for p in prisms() {
            let figure = self.figures.name(&p.figure);
            let pen = pen(&text, p.world_from_figure.translation);
            text.glyphs.push(GlyphBlock { figure, pen });
        }
        text
    }
}

fn prism(solid: &Solid) -> Option<&Prism> {
    match solid {
        Solid::Prism(prism) => Some(prism),
        _ => None,
    }
}

fn are_glyphs(a: &Solid, b: &Solid) -> bool {
    let (Some(a), Some(b)) = (prism(a), prism(b)) else {
        return false;
    };
    let axes = |p: &Prism| p.world_from_figure.matrix3;
    a.material == b.material && axes(a) == axes(b) && a.bevel == b.bevel
}

/// The glyph origin that reproduces a position exactly: two coordinates along the text if some give
/// the same bits, short ones preferred.
fn pen(text: &TextBlock, place: DVec3) -> GlyphOrigin {
    let (across, up) = (text.map.matrix3.x_axis, text.map.matrix3.y_axis);
    let way = place - text.map.translation;
    // The normal equations of two unknowns.
    let (aa, au, uu) = (across.dot(across), across.dot(up), up.dot(up));
    let (wa, wu) = (way.dot(across), way.dot(up));
    let size = aa * uu - au * au;
    let near = DVec2::new(wa * uu - wu * au, wu * aa - wa * au) / size;
    if !near.is_finite() {
        return GlyphOrigin::At(place);
    }
    for x in candidates(near.x) {
        for y in candidates(near.y) {
            let pen = GlyphOrigin::Along(DVec2::new(x, y));
            if text.map_at(pen).translation == place {
                return pen;
            }
        }
    }
    GlyphOrigin::At(place)
}

/// A number rounded to few digits, to more, and its neighbours.
fn candidates(x: f64) -> [f64; 8] {
    let rounded = |scale: f64| (x * scale).round() / scale;
    let (up, down) = (x.next_up(), x.next_down());
    [
        rounded(1e3),
        rounded(1e6),
        rounded(1e9),
        rounded(1e12),
        x,
        up,
        down,
        up.next_up(),
    ]
}
