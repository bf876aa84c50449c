//! Irradiance on vertices as texels, so that a page shows it with its values and its errors.

use azulejo_bake::ReceiverLayout;
use azulejo_bake::web_page::PageLightmap;
use azulejo_scene::{Object, PlacedMesh, Rgb, Scene};

/// Light of vertices as a lightmap of which every triangle has 2 × 2 texels.
///
/// The centres of three texels are the triangle's corners, a, b and c. The fourth has b + c − a, so that a bilinear
/// filter is the linear interpolation between the corners. Pages have no negative light, so where it is below 0, light
/// between the corners is a little more than linear.
#[derive(Default)]
pub struct VertexTexels {
    /// The texels; `None` if no object has light.
    pub map: Option<PageLightmap>,
    /// Where the triangles of each object lie; `None` for objects without light.
    pub layouts: Vec<Option<ReceiverLayout>>,
}

/// Columns and rows of the corners of a triangle in its texels.
const CORNERS: [[usize; 2]; 3] = [[0, 0], [1, 0], [0, 1]];

impl VertexTexels {
    /// The texels of a scene whose faces are triangles.
    pub fn new(scene: &Scene) -> VertexTexels {
        let lit: Vec<Option<PlacedMesh>> = scene.objects.iter().map(lit_mesh).collect();
        let count: usize = lit.iter().flatten().map(|m| m.mesh.faces.len()).sum();
        if count == 0 {
            return VertexTexels {
                layouts: vec![None; lit.len()],
                map: None,
            };
        }
        let grid = Grid::of(count);
        let has_errors = (lit.iter().flatten()).all(|m| !m.irradiance_error.is_empty());
        let (mut irradiance, mut errors) = (grid.dark(), Vec::new());
        if has_errors {
            errors = grid.dark();
        }
        let mut cells = 0..count;
        let mut layouts = Vec::new();
        for placed in &lit {
            let Some(placed) = placed else {
                layouts.push(None);
                continue;
            };
            let mut layout = ReceiverLayout::default();
            for (triangle, cell) in placed.mesh.faces.iter().zip(&mut cells) {
                grid.fill(cell, triangle, placed.irradiance, &mut irradiance);
                if has_errors {
                    grid.fill(cell, triangle, placed.irradiance_error, &mut errors);
                }
                layout.uvs.push(grid.places(cell));
            }
            layout.charts = vec![0; layout.uvs.len()];
            layout.pages = vec![0; layout.uvs.len()];
            layouts.push(Some(layout));
        }
        let map = PageLightmap {
            width: grid.width as u32,
            height: grid.height as u32,
            irradiance,
            standard_error: errors,
        };
        VertexTexels {
            map: Some(map),
            layouts,
        }
    }
}

/// The mesh of an object whose vertices all have light.
fn lit_mesh(object: &Object) -> Option<PlacedMesh<'_>> {
    let placed = object.shape.placed_mesh()?;
    let (vertices, light) = (placed.mesh.positions.len(), placed.irradiance.len());
    (light == vertices && !placed.mesh.faces.is_empty()).then_some(placed)
}

/// Cells of 2 × 2 texels in rows.
struct Grid {
    /// Texels per row.
    width: usize,
    /// Rows of texels.
    height: usize,
}

impl Grid {
    /// A nearly square grid of so many cells, at least one.
    fn of(cells: usize) -> Grid {
        let columns = (cells as f64).sqrt().ceil() as usize;
        Grid {
            width: 2 * columns,
            height: 2 * cells.div_ceil(columns),
        }
    }

    fn dark(&self) -> Vec<[f32; 3]> {
        vec![[0.0; 3]; self.width * self.height]
    }

    /// The first column and row of a cell.
    fn origin(&self, cell: usize) -> [usize; 2] {
        let columns = self.width / 2;
        [2 * (cell % columns), 2 * (cell / columns)]
    }

    /// Where the corners of the triangle of a cell lie, as lightmaps have it.
    fn places(&self, cell: usize) -> [[f32; 2]; 3] {
        let origin = self.origin(cell);
        let sides = [self.width, self.height];
        let centre =
            |corner: [usize; 2], k: usize| ((origin[k] + corner[k]) as f64 + 0.5) / sides[k] as f64;
        CORNERS.map(|corner| [0, 1].map(|k| centre(corner, k) as f32))
    }

    /// Stores the values at the vertices of a triangle in its cell.
    fn fill(&self, cell: usize, triangle: &[u32], values: &[Rgb], texels: &mut [[f32; 3]]) {
        let [column, row] = self.origin(cell);
        let mut put = |[x, y]: [usize; 2], value: Rgb| {
            texels[(row + y) * self.width + column + x] = value.to_f32();
        };
        let [a, b, c] = [0, 1, 2].map(|k| values[triangle[k] as usize]);
        for (corner, value) in CORNERS.into_iter().zip([a, b, c]) {
            put(corner, value);
        }
        put([1, 1], b + c - a);
    }
}
