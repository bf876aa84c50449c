//! From polygons to drawable geometry: triangles over vertices with one normal each.

use azulejo::scene::{MaterialId, Mesh};
use std::ops::Range;

/// Limits on the vertices and triangles of a piece. Its buffers stay far below the limits of any
/// GPU, and temporary buffers stay small.
const MAX_VERTICES: usize = 1 << 18;
const MAX_TRIANGLES: usize = 1 << 19;

/// Marks a missing vertex.
const NONE: u32 = u32::MAX;

/// Some faces of a mesh, sorted by material.
#[derive(Debug, Default)]
pub struct MeshPiece {
    /// For each vertex: the index of the mesh vertex, and of one of the corners that share it.
    pub vertices: Vec<[u32; 2]>,
    /// Three vertices of the piece per triangle.
    pub triangles: Vec<u32>,
    /// The face of each triangle.
    pub faces: Vec<u32>,
    /// The range of `triangles` for each material.
    pub ranges: Vec<(MaterialId, Range<u32>)>,
    /// Two vertices of the piece per edge, if edges were requested, without duplicates.
    pub edges: Vec<u32>,
}

/// Passes the pieces of a mesh to `use_piece`, in a reproducible order. An error from `use_piece`
/// ends the loop.
pub fn for_each_piece<E>(
    mesh: &Mesh,
    with_edges: bool,
    mut use_piece: impl FnMut(&MeshPiece) -> Result<(), E>,
) -> Result<(), E> {
    let mut walker = PieceBuilder::new(mesh, with_edges);
    let mut visit = |face: usize| {
        if walker.is_full(face) {
            use_piece(walker.finish())?;
            walker.clear();
        }
        walker.add(face);
        Ok(())
    };
    match sorted_by_material(mesh) {
        None => (0..mesh.faces.len()).try_for_each(&mut visit)?,
        Some(order) => order.iter().try_for_each(|&f| visit(f as usize))?,
    }
    if walker.piece.triangles.is_empty() {
        return Ok(());
    }
    use_piece(walker.finish())
}

/// The faces sorted by material, with a stable sort; `None` if they are already sorted.
fn sorted_by_material(mesh: &Mesh) -> Option<Vec<u32>> {
    let materials = &mesh.face_materials;
    if materials.is_sorted() {
        return None;
    }
    let mut order: Vec<u32> = (0..materials.len() as u32).collect();
    order.sort_by_key(|&f| materials[f as usize]);
    Some(order)
}

struct PieceBuilder<'a> {
    mesh: &'a Mesh,
    with_edges: bool,
    /// Whether a mesh vertex can become several vertices here.
    splits: bool,
    /// The newest vertex of the piece made from each mesh vertex.
    newest: Vec<u32>,
    /// For each vertex of the piece, the previous one made from the same mesh vertex.
    before: Vec<u32>,
    piece: MeshPiece,
    corners: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> PieceBuilder<'a> {
    fn new(mesh: &'a Mesh, with_edges: bool) -> PieceBuilder<'a> {
        let normals = mesh.normals.as_ref().is_some_and(|n| n.corners.is_some());
        let uvs = mesh.uvs.as_ref().is_some_and(|t| t.corners.is_some());
        PieceBuilder {
            mesh,
            with_edges,
            splits: normals || uvs,
            newest: vec![NONE; mesh.positions.len()],
            before: Vec::new(),
            piece: MeshPiece::default(),
            corners: Vec::new(),
            triangles: Vec::new(),
        }
    }

    fn is_full(&self, face: usize) -> bool {
        let more = self.mesh.faces.corner_range(face).len();
        !self.piece.triangles.is_empty()
            && (self.piece.vertices.len() + more > MAX_VERTICES
                || self.piece.faces.len() + more > MAX_TRIANGLES)
    }

    fn add(&mut self, face: usize) {
        let range = self.mesh.faces.corner_range(face);
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        corners.extend(range.map(|corner| self.vertex(corner)));
        self.open_range(self.mesh.face_materials[face]);
        if let [a, b, c] = corners[..] {
            self.piece.triangles.extend([a, b, c]);
            self.piece.faces.push(face as u32);
        } else {
            self.triangles.clear();
            self.mesh.triangulate_into(face, &mut self.triangles);
            for triangle in &self.triangles {
                let triangle = triangle.map(|k| corners[k as usize]);
                self.piece.triangles.extend(triangle);
                self.piece.faces.push(face as u32);
            }
        }
        if let Some((_, range)) = self.piece.ranges.last_mut() {
            range.end = self.piece.triangles.len() as u32;
        }
        if self.with_edges {
            let next = corners.iter().cycle().skip(1);
            let edges = corners.iter().zip(next);
            self.piece.edges.extend(edges.flat_map(|(&a, &b)| [a, b]));
        }
        self.corners = corners;
    }

    fn open_range(&mut self, material: MaterialId) {
        if self.piece.ranges.last().is_none_or(|r| r.0 != material) {
            let start = self.piece.triangles.len() as u32;
            self.piece.ranges.push((material, start..start));
        }
    }

    /// The piece's vertex for a corner of the mesh.
    fn vertex(&mut self, corner: usize) -> u32 {
        let vertex = self.mesh.faces.corners[corner];
        let newest = self.newest[vertex as usize];
        let mut index = newest;
        while index != NONE && !self.is_same(index, corner) {
            index = self.before[index as usize];
        }
        if index != NONE {
            return index;
        }
        let made = self.piece.vertices.len() as u32;
        self.piece.vertices.push([vertex, corner as u32]);
        self.before.push(newest);
        self.newest[vertex as usize] = made;
        made
    }

    /// Whether a vertex of the piece has the normal and texture coordinates of a corner.
    fn is_same(&self, vertex: u32, corner: usize) -> bool {
        if !self.splits {
            return true;
        }
        let other = self.piece.vertices[vertex as usize][1] as usize;
        let agrees = |index: Option<&Vec<u32>>| index.is_none_or(|i| i[other] == i[corner]);
        let normals = self.mesh.normals.as_ref().and_then(|n| n.corners.as_ref());
        let uvs = self.mesh.uvs.as_ref().and_then(|t| t.corners.as_ref());
        agrees(normals) && agrees(uvs)
    }

    fn finish(&mut self) -> &MeshPiece {
        if self.with_edges {
            self.piece.edges = unique(&self.piece);
        }
        &self.piece
    }

    fn clear(&mut self) {
        for &[vertex, _] in &self.piece.vertices {
            self.newest[vertex as usize] = NONE;
        }
        self.before.clear();
        self.piece.vertices.clear();
        self.piece.triangles.clear();
        self.piece.faces.clear();
        self.piece.ranges.clear();
        self.piece.edges.clear();
    }
}

/// The edges without duplicates: edges between the same mesh vertices are the same.
fn unique(piece: &MeshPiece) -> Vec<u32> {
    // Sort by mesh vertices; the vertices of the piece, which are below 2^32, follow.
    let of_mesh = |v: u32| u64::from(piece.vertices[v as usize][0]);
    let mut edges: Vec<(u64, [u32; 2])> = piece
        .edges
        .chunks_exact(2)
        .map(|e| {
            let (a, b) = (of_mesh(e[0]), of_mesh(e[1]));
            (a.min(b) << 32 | a.max(b), [e[0], e[1]])
        })
        .collect();
    edges.sort_unstable_by_key(|e| e.0);
    edges.dedup_by_key(|e| e.0);
    edges.into_iter().flat_map(|e| e.1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Attribute;
    use glam::DVec3;

    /// A strip of squares in the plane z = 0 with the given materials.
    fn strip(materials: &[MaterialId]) -> Mesh {
        let mut mesh = Mesh::default();
        for k in 0..=materials.len() {
            let x = k as f64;
            mesh.positions
                .extend([DVec3::new(x, 0.0, 0.0), DVec3::new(x, 1.0, 0.0)]);
        }
        for (k, &m) in (0..).zip(materials) {
            mesh.push_face(&[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1], m);
        }
        mesh
    }

    /// Numbers of vertices, triangles and edges, and the ranges of materials.
    type PieceSummary = (usize, usize, usize, Vec<(MaterialId, Range<u32>)>);

    fn pieces(mesh: &Mesh) -> Vec<PieceSummary> {
        let mut summaries = Vec::new();
        let Ok(()) = for_each_piece(mesh, true, |p| {
            let counts = (p.vertices.len(), p.faces.len(), p.edges.len() / 2);
            summaries.push((counts.0, counts.1, counts.2, p.ranges.clone()));
            Ok::<(), std::convert::Infallible>(())
        });
        summaries
    }

    #[test]
    fn squares_share_vertices_and_edges() {
        assert_eq!(pieces(&strip(&[5, 5])), [(6, 4, 7, vec![(5, 0..12)])]);
        assert_eq!(pieces(&Mesh::default()), []);
    }

    #[test]
    fn faces_of_one_material_follow_each_other() {
        let ranges = vec![(1, 0..6), (2, 6..18)];
        assert_eq!(pieces(&strip(&[2, 1, 2])), [(8, 6, 10, ranges)]);
    }

    #[test]
    fn corners_with_normals_of_their_own_are_vertices_of_their_own() {
        let mut mesh = strip(&[0, 0]);
        mesh.normals = Some(Attribute {
            values: vec![DVec3::Z, DVec3::X],
            corners: Some(vec![0, 0, 0, 0, 1, 1, 1, 1]),
        });
        // Edges are still those of the mesh.
        assert_eq!(pieces(&mesh), [(8, 4, 7, vec![(0, 0..12)])]);
    }

    #[test]
    fn large_meshes_come_in_pieces() {
        let mesh = strip(&vec![0; MAX_VERTICES]);
        let counts = pieces(&mesh);
        assert!(counts.len() > 1 && counts.iter().all(|p| p.0 <= MAX_VERTICES));
        assert_eq!(counts.iter().map(|p| p.1).sum::<usize>(), 2 * MAX_VERTICES);
    }
}
