//! What surfaces reflect in the texels of a lightmap: for pictures that hold the light that leaves.

use crate::atlas::Atlas;
use crate::coverage::{Coverage, TriangleId};
use crate::layout::barycentric;
use crate::lightmap_page::LightmapPage;
use crate::pad::{fill, pad_charts};
use azulejo_scene::Rgb;
use azulejo_trace::{Cancelled, Progress};
use glam::DVec2;
use rayon::prelude::*;

/// Points along each axis of a texel at which a colour that varies is looked at: enough for pictures with eight
/// times the resolution of the page.
const GRID: u32 = 8;

/// Texels that are worked on together.
const BATCH: usize = 256;

/// The colour of surfaces.
pub trait SurfaceColor: Sync {
    /// Diffuse reflectance at a point of a triangle, at barycentric coordinates.
    fn at(&self, of: TriangleId, weights: [f64; 3]) -> Rgb;

    /// Whether it may differ between points of a triangle.
    fn varies(&self, of: TriangleId) -> bool;
}

/// The mean colour of the part of a surface that each texel of each page covers. It goes on for `padding` texels
/// around charts, and beyond, as light does.
///
/// # Errors
/// The caller cancelled.
pub fn texel_colors(
    atlas: &Atlas,
    colors: &impl SurfaceColor,
    padding: u32,
    progress: &Progress,
) -> Result<Vec<Vec<[f32; 3]>>, Cancelled> {
    let of_page = |number: u32| {
        let coverage = Coverage::new(&atlas.receivers, &atlas.layout, number, progress)?;
        let texels = &coverage.texels;
        progress.begin("colours", texels.len() as u64);
        let means: Result<Vec<Vec<[f32; 3]>>, Cancelled> = texels
            .par_chunks(BATCH)
            .enumerate()
            .map(|(batch, chunk)| {
                progress.advance(chunk.len() as u64)?;
                let mean = |i| mean_color(atlas, &coverage, colors, batch * BATCH + i);
                Ok((0..chunk.len()).map(mean).collect())
            })
            .collect();
        let mut page = LightmapPage::dark(coverage.size);
        for (texel, mean) in texels.iter().zip(means?.concat()) {
            page.irradiance[texel.index as usize] = mean;
            page.charts[texel.index as usize] = texel.chart;
        }
        pad_charts(&mut page, padding);
        fill(&mut page);
        Ok(page.irradiance)
    };
    (0..atlas.layout.pages.len() as u32).map(of_page).collect()
}

/// The mean over the pieces of a texel, by area.
fn mean_color(
    atlas: &Atlas,
    coverage: &Coverage,
    colors: &impl SurfaceColor,
    texel: usize,
) -> [f32; 3] {
    let covered = &coverage.texels[texel];
    let size = coverage.size;
    let corner = DVec2::new(
        (covered.index % size[0]).into(),
        (covered.index / size[0]).into(),
    );
    let centre = DVec2::from(covered.centre.map(f64::from));
    let (mut sum, mut area) = (Rgb::BLACK, 0.0);
    for piece in coverage.pieces(texel) {
        let of_receiver = &atlas.layout.receivers[piece.of.receiver as usize];
        let corners = of_receiver.texels(piece.of.triangle as usize, size);
        let color = piece_color(colors, piece.of, corners, corner, centre);
        sum += color * f64::from(piece.area);
        area += f64::from(piece.area);
    }
    let mean = sum / f64::max(area, f64::MIN_POSITIVE);
    mean.to_array().map(|c| c as f32)
}

/// The mean over a triangle within the texel that begins at `corner`.
fn piece_color(
    colors: &impl SurfaceColor,
    of: TriangleId,
    corners: [DVec2; 3],
    corner: DVec2,
    centre: DVec2,
) -> Rgb {
    if !colors.varies(of) {
        return colors.at(of, [1.0 / 3.0; 3]);
    }
    let (mut sum, mut count) = (Rgb::BLACK, 0u32);
    for k in 0..GRID * GRID {
        let step = DVec2::new((k % GRID).into(), (k / GRID).into());
        let weights = barycentric(corners, corner + (step + 0.5) / f64::from(GRID));
        if let Some(weights) = weights.filter(|all| all.iter().all(|&w| w >= 0.0)) {
            sum += colors.at(of, weights);
            count += 1;
        }
    }
    if count > 0 {
        return sum / f64::from(count);
    }
    // A sliver between the points: the point of it that is near the middle of what the texel covers.
    let weights = barycentric(corners, centre).unwrap_or([1.0 / 3.0; 3]);
    let inside = weights.map(|w| w.max(0.0));
    let whole: f64 = inside.iter().sum();
    colors.at(of, inside.map(|w| w / whole))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Layout, ReceiverLayout};
    use crate::receiver::Receiver;
    use glam::DVec3;

    /// A square on a page of 16 × 16 texels, with a border of four.
    fn square() -> Atlas {
        let (low, high) = (0.25, 0.75);
        let [a, b, c, d] = [[low, low], [high, low], [high, high], [low, high]];
        let receiver = Receiver {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            parts: vec![0; 2],
            density: 1.0,
            ..Receiver::default()
        };
        Atlas {
            receivers: vec![receiver],
            layout: Layout {
                pages: vec![[16, 16]],
                receivers: vec![ReceiverLayout {
                    uvs: vec![[a, b, c], [a, c, d]],
                    charts: vec![0; 2],
                    pages: vec![0; 2],
                    cuts: vec![[false; 3]; 2],
                }],
                charts: 1,
            },
            turned: Vec::new(),
        }
    }

    /// Red grows along the first edge of the square, green is whether a point is on its first triangle.
    struct Ramp;

    impl SurfaceColor for Ramp {
        fn at(&self, of: TriangleId, [_, b, c]: [f64; 3]) -> Rgb {
            match of.triangle {
                0 => Rgb::new(b + c, 1.0, 0.0),
                _ => Rgb::new(b, 0.0, 0.0),
            }
        }

        fn varies(&self, _: TriangleId) -> bool {
            true
        }
    }

    #[test]
    fn texels_have_the_mean_of_what_they_cover() {
        let pages = texel_colors(&square(), &Ramp, 2, &Progress::new()).unwrap();
        let texel = |column: usize, row: usize| pages[0][16 * row + column];
        for row in 4..12 {
            for column in 4..12 {
                let [red, green, _] = texel(column, row);
                let expected = (column as f32 - 3.5) / 8.0;
                assert!((red - expected).abs() < 1e-6, "{column}, {row}: {red}");
                // Above the diagonal is the first triangle; texels on it have half of both.
                let share = match column.cmp(&row) {
                    std::cmp::Ordering::Greater => 1.0,
                    std::cmp::Ordering::Equal => 0.5,
                    std::cmp::Ordering::Less => 0.0,
                };
                assert!((green - share).abs() < 1e-6, "{column}, {row}: {green}");
            }
        }
        // The padding goes on.
        assert_eq!(texel(3, 6), texel(4, 6));
        assert_eq!(texel(2, 6), texel(4, 6));
        assert!(pages[0].iter().all(|c| c[0] > 0.0));
    }
}
