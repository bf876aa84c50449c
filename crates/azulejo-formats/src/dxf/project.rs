//! A drawing with all external references: nesting of blocks, and how much they expand to.

use super::drawing::{DxfBlock, DxfDrawing, Insert};
use super::ids::{BlockId, MODEL_SPACE};
use super::instantiate::LONGEST_PATH;
use super::pairs::Pairs;
use super::parse::{parse, position};
use super::surfaces::LayerMesh;
use crate::reading::detect::{Format, detect};
use crate::reading::files::beside;
use crate::reading::options::Budget;
use crate::reading::text::{into_decoded, shortened};
use crate::reading::warnings::Warnings;
use crate::{FileError, Files, ReadError, ReadOptions};
use std::borrow::Cow;
use std::collections::HashMap;

/// Deepest nesting of blocks, external references included; deeper ones are left out.
const DEEPEST: u32 = 64;

/// Most external files.
const MOST_FILES: usize = 1000;

/// Cost of an INSERT or a light in elements.
const COST_OF_NODE: u64 = 8;

/// Cost of an object besides its name, vertices and corners: it takes as much memory as 32 vertices, with its
/// place in the tracer and in the tables that commands make of objects.
const COST_OF_OBJECT: u64 = 32;

/// Bytes of the names of objects that count as one element.
const BYTES_PER_ELEMENT: u64 = 24;

/// All drawings; the first is the one being read.
#[derive(Debug)]
pub(super) struct Project {
    /// The drawings.
    pub drawings: Vec<DxfDrawing>,
    /// Drawings of external references, by the drawing and the block that name them.
    references: HashMap<Node, usize>,
    /// What each block expands to.
    extents: HashMap<Node, Extent>,
}

/// A block of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Node {
    /// Index of the drawing.
    pub drawing: usize,
    /// The block in it.
    pub block: BlockId,
}

/// What a block expands to.
#[derive(Clone, Copy, Debug, Default)]
struct Extent {
    /// Vertices, corners and the cost of nodes and objects.
    elements: u64,
    /// Number of objects.
    objects: u64,
    /// Most bytes of their names, in which the blocks inside this one occur.
    name_bytes: u64,
    /// Greatest nesting depth of blocks.
    height: u32,
    /// Whether it is still being computed: an INSERT that leads here closes a cycle.
    is_open: bool,
}

impl Extent {
    /// Of a block without its inserted blocks.
    fn surface_extent(drawing: &DxfDrawing, block: &DxfBlock) -> Extent {
        let mut extent = Extent {
            elements: block.lights.len() as u64 * COST_OF_NODE,
            ..Extent::default()
        };
        for LayerMesh { layer, mesh, .. } in &block.surfaces.meshes {
            let size = mesh.positions.len() + mesh.faces.corners.len();
            extent.elements += size as u64 + COST_OF_OBJECT;
            extent.objects += 1;
            extent.name_bytes += drawing.layers[*layer as usize].name.len() as u64;
        }
        extent
    }

    /// Adds `count` INSERTs of a block of that name.
    fn insert(&mut self, count: u64, inner: &Extent, name: &str) {
        let times = |each: u64| count.saturating_mul(each);
        let names = inner.objects.saturating_mul(name.len() as u64 + 1);
        let most = inner.objects.saturating_mul(LONGEST_PATH as u64);
        let names = inner.name_bytes.saturating_add(names).min(most);
        let elements = times(inner.elements.saturating_add(COST_OF_NODE));
        self.elements = self.elements.saturating_add(elements);
        self.objects = self.objects.saturating_add(times(inner.objects));
        self.name_bytes = self.name_bytes.saturating_add(times(names));
        self.height = self.height.max(inner.height + 1);
    }

    /// What it takes from the budget.
    fn cost(&self) -> u64 {
        let names = self.name_bytes / BYTES_PER_ELEMENT;
        self.elements.saturating_add(names)
    }
}

impl Project {
    /// Reads a drawing, and the files that its blocks refer to.
    ///
    /// # Errors
    /// Errors of [`parse`] for the drawing itself, and a drawing that expands to more than `options`
    /// allow.
    pub fn read(
        bytes: &[u8],
        name: &str,
        files: &dyn Files,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Project, ReadError> {
        let drawing = parse(bytes, name, options, warnings)?;
        let mut reader = ProjectReader {
            project: Project {
                drawings: vec![drawing],
                references: HashMap::new(),
                extents: HashMap::new(),
            },
            sources: vec![DrawingSource {
                path: String::new(),
                bytes: bytes.into(),
            }],
            by_path: HashMap::new(),
            bytes_left: options.most_unpacked,
            files,
            options,
            warnings,
        };
        let extent = reader.extent(Node::ROOT, 0);
        Budget::new(options)
            .spend(extent.cost())
            .map_err(|e| e.error(name))?;
        Ok(reader.project)
    }

    /// A block and its drawing.
    pub fn get(&self, node: Node) -> (&DxfDrawing, &DxfBlock) {
        let drawing = &self.drawings[node.drawing];
        (drawing, &drawing.blocks[node.block as usize])
    }

    /// The drawing itself, as a block.
    pub fn root_mut(&mut self) -> &mut DxfBlock {
        &mut self.drawings[0].blocks[MODEL_SPACE as usize]
    }

    /// The block that an INSERT instantiates; `None` if that is missing or empty.
    pub fn target(&self, node: Node, insert: &Insert) -> Option<Node> {
        if insert.is_refused {
            return None;
        }
        let target = self.followed(Node {
            block: insert.block,
            ..node
        });
        let extent = self.extents.get(&target)?;
        (extent.elements > 0).then_some(target)
    }

    /// The block, or the drawing that it refers to.
    fn followed(&self, node: Node) -> Node {
        match self.references.get(&node) {
            Some(&drawing) => Node {
                drawing,
                block: MODEL_SPACE,
            },
            None => node,
        }
    }
}

impl Node {
    /// The drawing itself.
    pub const ROOT: Node = Node {
        drawing: 0,
        block: MODEL_SPACE,
    };
}

/// The source of a drawing.
struct DrawingSource<'a> {
    /// Its path relative to the first drawing's folder; empty for the first.
    path: String,
    bytes: Cow<'a, [u8]>,
}

/// A project under construction.
struct ProjectReader<'a, 'w> {
    project: Project,
    /// Sources in the order of the drawings.
    sources: Vec<DrawingSource<'a>>,
    /// The drawing of each external file, or why it could not be read.
    by_path: HashMap<String, Result<usize, String>>,
    bytes_left: u64,
    files: &'a dyn Files,
    options: &'a ReadOptions,
    warnings: &'w mut Warnings,
}

impl ProjectReader<'_, '_> {
    /// Computes what a block expands to. INSERTs that cannot be followed are marked, with a
    /// warning.
    fn extent(&mut self, node: Node, depth: u32) -> Extent {
        let open = Extent {
            is_open: true,
            ..Extent::default()
        };
        self.project.extents.insert(node, open);
        let (drawing, block) = self.project.get(node);
        let mut extent = Extent::surface_extent(drawing, block);
        for i in 0..block.inserts.len() {
            match self.inserted(node, i, depth) {
                Ok(inner) if inner.elements > 0 => {
                    let (drawing, block) = self.project.get(node);
                    let insert = &block.inserts[i];
                    let name = &drawing.blocks[insert.block as usize].name;
                    extent.insert(insert.count(), &inner, name);
                }
                Ok(_) => {}
                Err(why) => self.refuse(node, i, &why),
            }
        }
        self.project.extents.insert(node, extent);
        extent
    }

    /// What an INSERT's block expands to, or why it cannot be followed.
    fn inserted(&mut self, node: Node, insert: usize, depth: u32) -> Result<Extent, String> {
        let block = self.project.get(node).1.inserts[insert].block;
        let target = Node { block, ..node };
        if !self.project.get(target).1.is_defined {
            return Err("is not defined".to_owned());
        }
        self.follow_reference(target)?;
        let target = self.project.followed(target);
        let extent = match self.project.extents.get(&target) {
            Some(known) => *known,
            None if depth + 1 >= DEEPEST => return Err(too_deep()),
            None => self.extent(target, depth + 1),
        };
        if extent.is_open {
            return Err("contains itself".to_owned());
        }
        if extent.height + 1 >= DEEPEST {
            return Err(too_deep());
        }
        Ok(extent)
    }

    fn refuse(&mut self, node: Node, insert: usize, why: &str) {
        let drawing = &mut self.project.drawings[node.drawing];
        let name = |block: BlockId| shortened(&drawing.blocks[block as usize].name);
        let refused = &drawing.blocks[node.block as usize].inserts[insert];
        let message = format!(
            "INSERT of block \"{}\", which {why}: left out",
            name(refused.block)
        );
        let offset = refused.offset;
        drawing.blocks[node.block as usize].inserts[insert].is_refused = true;
        let bytes = &self.sources[node.drawing].bytes;
        let encoding = || Pairs::new(bytes).encoding;
        self.warnings.add(&drawing.file, message, || {
            position(bytes, encoding(), offset)
        });
    }

    /// Reads the file that a block refers to, if it does.
    fn follow_reference(&mut self, node: Node) -> Result<(), String> {
        let Some(name) = self.project.get(node).1.external.clone() else {
            return Ok(());
        };
        if !self.project.references.contains_key(&node) {
            let drawing = self.external(node.drawing, &name)?;
            self.project.references.insert(node, drawing);
        }
        Ok(())
    }

    /// The drawing in a file that another drawing names, or the reason of failure.
    fn external(&mut self, from: usize, name: &str) -> Result<usize, String> {
        let mut problem = FileError::Missing.to_string();
        for path in candidates(&self.sources[from].path, name) {
            if let Some(known) = self.by_path.get(&path) {
                return known.clone();
            }
            match self.files.read(&path) {
                Ok(bytes) => {
                    let read = self.add(&path, bytes);
                    self.by_path.insert(path, read.clone());
                    return read;
                }
                Err(e) => problem = e.to_string(),
            }
        }
        Err(format!(
            "is the external file \"{}\": {problem}",
            shortened(name)
        ))
    }

    /// Adds an external drawing.
    fn add(&mut self, path: &str, bytes: Vec<u8>) -> Result<usize, String> {
        let refused = |why: &str| format!("is the external file \"{}\": {why}", shortened(path));
        let left = self.bytes_left.checked_sub(bytes.len() as u64);
        match left {
            Some(left) if self.project.drawings.len() <= MOST_FILES => self.bytes_left = left,
            _ => return Err(refused("too many or too large files")),
        }
        match detect(&bytes) {
            Ok(Format::Dxf) => {}
            Ok(other) => return Err(refused(&format!("{}, not DXF", other.name()))),
            Err(unrecognized) => return Err(refused(unrecognized.looks_like)),
        }
        let bytes = into_decoded(bytes);
        let drawing = parse(&bytes, path, self.options, self.warnings)
            .map_err(|e| refused(&format!("found {}, expected {}", e.found, e.expected)))?;
        self.project.drawings.push(drawing);
        self.sources.push(DrawingSource {
            path: path.to_owned(),
            bytes: bytes.into(),
        });
        Ok(self.project.drawings.len() - 1)
    }
}

fn too_deep() -> String {
    format!("is more than {DEEPEST} blocks deep")
}

/// Possible paths of an external file: as written, and beside the drawing,
/// because most were written on another computer; each as DXF in place of DWG.
fn candidates(from: &str, name: &str) -> Vec<String> {
    let plain = name.replace('\\', "/");
    let alone = plain.rsplit('/').next().unwrap_or_default();
    let spellings = if alone == plain {
        vec![alone]
    } else {
        vec![plain.as_str(), alone]
    };
    let mut paths = Vec::new();
    for spelling in spellings {
        let path = beside(from, spelling);
        let stem = path.len().checked_sub(4).filter(|&stem| {
            let ending = path.get(stem..);
            ending.is_some_and(|ending| ending.eq_ignore_ascii_case(".dwg"))
        });
        paths.extend(stem.map(|stem| format!("{}.dxf", &path[..stem])));
        paths.push(path);
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn external_files_are_looked_for_beside_the_drawing() {
        let check = |from, name, expected: &[&str]| assert_eq!(candidates(from, name), expected);
        check("", "part.dxf", &["part.dxf"]);
        check("", "part.DWG", &["part.dxf", "part.DWG"]);
        check(
            "x/a.dxf",
            "C:\\b\\part.dwg",
            &["C:/b/part.dxf", "C:/b/part.dwg", "x/part.dxf", "x/part.dwg"],
        );
    }
}
