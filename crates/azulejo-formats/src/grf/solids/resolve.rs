//! Converts blocks to solids: resolves figures and definitions by name, and copies instances.

use super::super::document::{BlockKind, GrfBlock, GrfName, MeshBlock, NameKind, SourcePosition};
use super::super::placement::BlockPlace;
use super::super::resolve::{GrfResolver, ResolveResult};
use super::{
    CsgBlock, DEEPEST, ExactBlock, SolidBlock, SolidDefinition, SolidKind, TextBlock, has_inverse,
};
use azulejo_scene::{
    BicubicPatch, Csg, Exact, Figure, MaterialId, Mesh, Primitive, Prism, Shape, Solid,
};
use glam::DAffine3;
use std::rc::Rc;
use std::sync::Arc;

/// Solids, the depth of their nesting, and the cost of copying them, in vertices and corners. If
/// nothing is kept, only the numbers.
#[derive(Debug, Default)]
pub(in crate::grf) struct Made {
    solids: Vec<Solid>,
    depth: usize,
    elements: u64,
}

/// The state of an `ext define`.
#[derive(Debug)]
pub(in crate::grf) enum Defined<'d> {
    /// Not converted yet.
    Open(&'d SolidDefinition, SourcePosition),
    /// Being converted: needing it now means that it contains itself.
    Busy,
    Done(Rc<Made>),
}

impl<'d> GrfResolver<'d> {
    /// Converts all definitions of a list of blocks, before any block can refer to one: their names
    /// are resolved where they are defined.
    pub fn make_definitions(&mut self, blocks: &[&'d GrfBlock]) -> ResolveResult<()> {
        for block in blocks {
            if let BlockKind::Define(definition) = &block.kind {
                self.defined(&definition.name, block.place)?;
            }
        }
        Ok(())
    }

    fn defined(&mut self, name: &'d GrfName, place: SourcePosition) -> ResolveResult<Rc<Made>> {
        let name: &'d str = name;
        let mut scopes = self.scopes.iter_mut().enumerate().rev();
        let defined = scopes.find_map(|(level, s)| Some((level, s.solids.get_mut(name)?)));
        let Some((level, slot)) = defined else {
            return Err(self.undefined(NameKind::Solid, name, place));
        };
        let (definition, at) = match slot {
            Defined::Done(made) => return Ok(Rc::clone(made)),
            Defined::Open(definition, at) => (*definition, *at),
            Defined::Busy => {
                return Err(self.fail(
                    place,
                    format!("an instance of `{name}` inside of `{name}`"),
                    "instances without a cycle",
                ));
            }
        };
        *slot = Defined::Busy;
        let mut made = Made::default();
        self.deeper(at)?;
        self.solids(&definition.solids, definition.material.as_ref(), &mut made)?;
        self.depth -= 1;
        let made = Rc::new(made);
        self.scopes[level]
            .solids
            .insert(name, Defined::Done(Rc::clone(&made)));
        Ok(made)
    }

    fn deeper(&mut self, place: SourcePosition) -> ResolveResult<()> {
        self.depth += 1;
        self.check_depth(self.depth - 1, place)
    }

    /// Rejects one more level around solids that are nested this deep.
    fn check_depth(&self, depth: usize, place: SourcePosition) -> ResolveResult<()> {
        if depth <= DEEPEST {
            return Ok(());
        }
        Err(self.fail(
            place,
            "one more level of solids or definitions",
            &format!("at most {DEEPEST} nested levels, instances included"),
        ))
    }

    fn figure_named(&self, name: &GrfName, place: SourcePosition) -> ResolveResult<Arc<Figure>> {
        let figure = self.lookup(NameKind::Figure, name, place, |s| &s.figures)?;
        Ok(Arc::clone(figure))
    }
}

impl<'d> GrfResolver<'d> {
    pub fn exact(&mut self, block: &'d ExactBlock, place: BlockPlace) -> ResolveResult<()> {
        let mut made = Made::default();
        self.solids(&block.solids, block.notes.material.as_ref(), &mut made)?;
        if !self.instances.keeps() {
            return Ok(());
        }
        let mut exact = Exact::new(made.solids);
        if let Some(map) = place.outer {
            exact.transform(&map);
        }
        if !exact.solids.iter().all(is_placed) {
            return Err(self.fail(
                place.source,
                "a shape that transforms flatten, or that overflows",
                "invertible transforms",
            ));
        }
        if let Some(skin) = &block.skin {
            let materials = self.skin_materials(skin, &exact, place.source)?;
            let mesh = self.built_mesh(&skin.mesh, materials, place)?;
            exact.proxy = Some(Box::new(mesh));
        }
        self.push_object(&block.notes, Shape::Exact(exact))
    }

    /// Adds the solids of blocks; `around` is the brdf of the enclosing block.
    fn solids(
        &mut self,
        blocks: &'d [SolidBlock],
        around: Option<&'d GrfName>,
        made: &mut Made,
    ) -> ResolveResult<()> {
        // Most blocks make one solid, and a definition keeps its list.
        made.solids.reserve_exact(blocks.len());
        for block in blocks {
            let brdf = block.material.as_ref().or(around);
            self.solid(block, brdf, made)?;
        }
        Ok(())
    }

    fn solid(
        &mut self,
        block: &'d SolidBlock,
        brdf: Option<&'d GrfName>,
        made: &mut Made,
    ) -> ResolveResult<()> {
        let place = block.place;
        match &block.kind {
            SolidKind::Text(text) => self.text(text, brdf, place, made),
            SolidKind::Instance(of, map) => self.instance(of, map.as_deref(), place, made),
            SolidKind::Shell(pieces) => {
                let pieces = self.operand(pieces, brdf, place, made)?;
                self.push(Solid::Shell(pieces), made);
                Ok(())
            }
            SolidKind::Csg(csg) => self.csg(csg, brdf, place, made),
            _ => self.leaf(block, brdf, made),
        }
    }

    /// A solid that does not consist of others.
    fn leaf(
        &mut self,
        block: &'d SolidBlock,
        brdf: Option<&'d GrfName>,
        made: &mut Made,
    ) -> ResolveResult<()> {
        let place = block.place;
        let solid = match &block.kind {
            SolidKind::Primitive(kind, map) => {
                let material = self.named_material(brdf, None, place)?;
                Solid::Primitive(Primitive::new(*kind, **map, material))
            }
            SolidKind::Prism(figure, map, bevel) => Solid::Prism(Prism {
                figure: self.figure_named(figure, place)?,
                world_from_figure: **map,
                material: self.named_material(brdf, None, place)?,
                bevel: bevel.clone(),
            }),
            SolidKind::Patch(points) => Solid::Patch(BicubicPatch {
                points: points.clone(),
                material: self.named_material(brdf, None, place)?,
            }),
            SolidKind::Mesh(mesh) => Solid::Mesh(Box::new(self.solid_mesh(mesh, brdf, place)?)),
            _ => return Ok(()),
        };
        self.push(solid, made);
        Ok(())
    }

    /// Adds a solid, of whose parts the cost is known.
    fn push(&self, solid: Solid, made: &mut Made) {
        made.elements += own_elements(&solid);
        if self.instances.keeps() {
            made.solids.push(solid);
        }
    }

    /// Solids one level deeper than those of the whole to which they belong.
    fn operand(
        &mut self,
        blocks: &'d [SolidBlock],
        brdf: Option<&'d GrfName>,
        place: SourcePosition,
        whole: &mut Made,
    ) -> ResolveResult<Vec<Solid>> {
        let mut made = Made::default();
        self.deeper(place)?;
        self.solids(blocks, brdf, &mut made)?;
        self.depth -= 1;
        whole.elements = whole.elements.saturating_add(made.elements);
        whole.depth = whole.depth.max(made.depth + 1);
        self.check_depth(whole.depth, place)?;
        Ok(made.solids)
    }

    fn csg(
        &mut self,
        block: &'d CsgBlock,
        brdf: Option<&'d GrfName>,
        place: SourcePosition,
        made: &mut Made,
    ) -> ResolveResult<()> {
        let left = self.operand(&block.left, brdf, place, made)?;
        let right = self.operand(&block.right, brdf, place, made)?;
        if self.instances.keeps() {
            self.check_operand(&left, &block.left)?;
            self.check_operand(&right, &block.right)?;
        }
        let operation = block.operation;
        let csg = Csg {
            operation,
            left,
            right,
        };
        self.push(Solid::Csg(Box::new(csg)), made);
        Ok(())
    }

    /// Rejects sides of a set operation that are empty or have no interior.
    fn check_operand(&self, solids: &[Solid], blocks: &[SolidBlock]) -> ResolveResult<()> {
        let place = blocks
            .first()
            .map_or(SourcePosition::default(), |b| b.place);
        if solids.is_empty() {
            let found = "an empty side of a set operation: texts or instances without solids";
            return Err(self.fail(place, found, "solids on both sides"));
        }
        let Some(problem) = solids.iter().find_map(Solid::open_part) else {
            return Ok(());
        };
        // Texts and instances make several solids from one block: then the first one's position is
        // used.
        let found = format!("{problem} in a set operation, which is open and has no interior");
        let is_one_each = solids.len() == blocks.len();
        let open = solids.iter().position(|s| s.open_part().is_some());
        let block = open.filter(|_| is_one_each).and_then(|i| blocks.get(i));
        let place = block.map_or(place, |b| b.place);
        Err(self.fail(
            place,
            found,
            "closed solids; open pieces that close together are a `shell`",
        ))
    }

    fn text(
        &mut self,
        text: &'d TextBlock,
        brdf: Option<&'d GrfName>,
        place: SourcePosition,
        made: &mut Made,
    ) -> ResolveResult<()> {
        made.solids.reserve_exact(text.glyphs.len());
        let material = self.named_material(brdf, None, place)?;
        for glyph in &text.glyphs {
            let prism = Prism {
                figure: self.figure_named(&glyph.figure, place)?,
                world_from_figure: text.map_at(glyph.pen),
                material,
                bevel: text.bevel.clone(),
            };
            self.push(Solid::Prism(prism), made);
        }
        Ok(())
    }

    /// A mesh with a single material.
    fn solid_mesh(
        &mut self,
        mesh: &'d MeshBlock,
        brdf: Option<&'d GrfName>,
        place: SourcePosition,
    ) -> ResolveResult<Mesh> {
        let faces = mesh.faces.len();
        let materials = match faces {
            0 => Vec::new(),
            _ => vec![self.named_material(brdf, None, place)?; faces],
        };
        let place = BlockPlace {
            source: place,
            outer: None,
        };
        self.built_mesh(mesh, materials, place)
    }

    fn instance(
        &mut self,
        of: &'d GrfName,
        map: Option<&DAffine3>,
        place: SourcePosition,
        made: &mut Made,
    ) -> ResolveResult<()> {
        let defined = self.defined(of, place)?;
        if let Err(exhausted) = self.instances.spend(defined.elements) {
            let error = exhausted.error("");
            return Err(self.fail(place, error.found, &error.expected));
        }
        made.depth = made.depth.max(defined.depth);
        made.elements = made.elements.saturating_add(defined.elements);
        made.solids.reserve_exact(defined.solids.len());
        for solid in &defined.solids {
            let mut copy = solid.clone();
            if let Some(map) = map {
                copy.transform(map);
            }
            made.solids.push(copy);
        }
        Ok(())
    }

    /// The materials of a skin's faces.
    fn skin_materials(
        &self,
        skin: &super::SkinBlock,
        exact: &Exact,
        place: SourcePosition,
    ) -> ResolveResult<Vec<MaterialId>> {
        let leaves = exact.leaves();
        let material = |leaf: u32| match leaves.get(leaf as usize) {
            Some(leaf) => Ok(leaf.material()),
            None => Err(self.fail(
                place,
                format!(
                    "a skin with solid {leaf} on a shape with {} solids",
                    leaves.len()
                ),
                "the index of an existing solid",
            )),
        };
        if skin.leaves.is_empty() {
            (0..skin.mesh.faces.len()).map(|_| material(0)).collect()
        } else {
            skin.leaves.iter().map(|&leaf| material(leaf)).collect()
        }
    }
}

/// The cost of copying a solid without the parts of a compound, in vertices and corners.
fn own_elements(solid: &Solid) -> u64 {
    // A solid takes as much memory as a dozen vertices, in the scene and where its surface is measured
    // and traced.
    12 + match solid {
        Solid::Patch(_) => 4,
        Solid::Mesh(mesh) => (mesh.positions.len() + mesh.faces.corners.len()) as u64,
        Solid::Primitive(_) | Solid::Prism(_) | Solid::Shell(_) | Solid::Csg(_) => 0,
    }
}

/// Whether rays can hit a transformed solid.
fn is_placed(solid: &Solid) -> bool {
    match solid {
        Solid::Primitive(p) => super::super::is_invertible(p.kind, &p.world_from_object),
        Solid::Prism(p) => has_inverse(&p.world_from_figure),
        Solid::Patch(p) => p.points.iter().flatten().all(|p| p.is_finite()),
        Solid::Mesh(m) => m.positions.iter().all(|p| p.is_finite()),
        Solid::Shell(pieces) => pieces.iter().all(is_placed),
        Solid::Csg(csg) => csg.left.iter().chain(&csg.right).all(is_placed),
    }
}
