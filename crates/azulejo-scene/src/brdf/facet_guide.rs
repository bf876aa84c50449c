//! Importance sampling of facets in proportion to what they reflect, by tables.
//!
//! Facets sampled by their distribution alone ignore which of them the viewer sees, what hides them
//! and where light spreads otherwise than about facets, so that weights differ and many samples are
//! lost below the surface. Here the two numbers from which an isotropic distribution makes a normal
//! are chosen first, from a histogram of the weights over the unit square, for each of some angles of
//! the viewer: importance sampling in the space of random numbers (primary sample space). The density
//! stays known, so that the mean is right whatever the histogram.

/// Intervals of the cosine's square root: most of them toward grazing angles, where visible facets
/// are others than those that exist.
const VIEWS: usize = 24;

/// Rows of cells: intervals of the facets' slope with equal numbers of facets.
const ROWS: usize = 16;

/// Columns: intervals of half the azimuth about the viewer's, as the other half mirrors it.
const COLUMNS: usize = 16;

/// Points of a cell at which weights are evaluated, in each direction.
const POINTS: usize = 2;

/// Least density of a cell, over the mean: its points may have missed all light in it.
const LEAST: f64 = 0.02;

/// What facets of an isotropic distribution reflect, cell by cell.
#[derive(Debug)]
pub(super) struct FacetGuide {
    views: Vec<ViewCells>,
    /// Cosines of the azimuths between the columns, falling.
    borders: [f64; COLUMNS - 1],
}

/// The cells of one angle of the viewer.
#[derive(Debug)]
struct ViewCells {
    /// Sums of the cells' densities up to the end of each row, over their number.
    rows: [f64; ROWS],
    /// The same up to each cell of a row, from its start.
    columns: [[f64; COLUMNS]; ROWS],
    /// Density relative to that of the distribution of facets.
    density: [[f64; COLUMNS]; ROWS],
}

/// Two of them, and the share of the second: in between, so that samples move with the viewer without jumps.
struct BetweenViews<'a> {
    views: [&'a ViewCells; 2],
    share: f64,
}

impl BetweenViews<'_> {
    fn value(&self, of: impl Fn(&ViewCells) -> f64) -> f64 {
        let [a, b] = self.views.map(of);
        a + (b - a) * self.share
    }
}

impl FacetGuide {
    /// From the weight of a facet, what it reflects over the density of that with facets sampled by
    /// their distribution: for the viewer's cosine, the share of facets with smaller slopes, and the
    /// azimuth from the viewer's in turns, 0..½.
    pub fn new(weight: impl Fn(f64, f64, f64) -> f64) -> FacetGuide {
        let view = |k: usize| {
            let cos = ((k as f64 + 0.5) / VIEWS as f64).powi(2);
            ViewCells::new(|slope, azimuth| weight(cos, slope, azimuth))
        };
        let border = |k: usize| (std::f64::consts::PI * (k + 1) as f64 / COLUMNS as f64).cos();
        FacetGuide {
            views: (0..VIEWS).map(view).collect(),
            borders: std::array::from_fn(border),
        }
    }

    fn view(&self, cos: f64) -> BetweenViews<'_> {
        let at = cos.sqrt() * VIEWS as f64 - 0.5;
        let first = (at.max(0.0) as usize).min(VIEWS - 2);
        BetweenViews {
            views: [&self.views[first], &self.views[first + 1]],
            share: (at - first as f64).clamp(0.0, 1.0),
        }
    }

    /// The share of facets with smaller slopes, and the azimuth from the viewer's in turns, 0..1,
    /// for two numbers in 0..1 and the cosine of the viewer.
    pub fn choose(&self, cos: f64, u1: f64, u2: f64) -> (f64, f64) {
        let view = self.view(cos);
        let (row, slope) = within(ROWS, |k| view.value(|v| v.rows[k]), u1);
        let folded = if u2 < 0.5 { 2.0 * u2 } else { 2.0 - 2.0 * u2 };
        let (column, azimuth) = within(COLUMNS, |k| view.value(|v| v.columns[row][k]), folded);
        let slope = (row as f64 + slope) / ROWS as f64;
        let half = 0.5 * (column as f64 + azimuth) / COLUMNS as f64;
        (slope, if u2 < 0.5 { half } else { 1.0 - half })
    }

    /// Density of [`choose`](FacetGuide::choose) relative to that of the distribution of facets, for
    /// the viewer's cosine, the share of facets with smaller slopes, and the cosine of the azimuth
    /// from the viewer's.
    pub fn density(&self, cos: f64, slope: f64, cos_azimuth: f64) -> f64 {
        let row = ((slope * ROWS as f64) as usize).min(ROWS - 1);
        let column = self.borders.partition_point(|&border| border > cos_azimuth);
        self.view(cos).value(|v| v.density[row][column])
    }
}

impl ViewCells {
    fn new(weight: impl Fn(f64, f64) -> f64) -> ViewCells {
        let middle = |cell: usize, k: usize, cells: usize| {
            (cell as f64 + (k as f64 + 0.5) / POINTS as f64) / cells as f64
        };
        let mut density = [[0.0; COLUMNS]; ROWS];
        for (r, row) in density.iter_mut().enumerate() {
            for (c, cell) in row.iter_mut().enumerate() {
                // The variance is least where cells are as likely as the root of their mean square.
                let square = |k: usize| {
                    let slope = middle(r, k / POINTS, ROWS);
                    let azimuth = 0.5 * middle(c, k % POINTS, COLUMNS);
                    weight(slope, azimuth).powi(2)
                };
                let squares: f64 = (0..POINTS * POINTS).map(square).sum();
                *cell = (squares / (POINTS * POINTS) as f64).sqrt();
            }
        }
        ViewCells::with_density(density)
    }

    /// Scales a density to a mean of 1 and sums it.
    fn with_density(mut density: [[f64; COLUMNS]; ROWS]) -> ViewCells {
        let count = (ROWS * COLUMNS) as f64;
        let mean = density.iter().flatten().sum::<f64>() / count;
        let scale = if mean > 0.0 && mean.is_finite() {
            (1.0 - LEAST) / mean
        } else {
            0.0
        };
        let base = if scale > 0.0 { LEAST } else { 1.0 };
        density
            .iter_mut()
            .flatten()
            .for_each(|d| *d = *d * scale + base);
        let mut columns = density;
        let (mut rows, mut sum) = ([0.0; ROWS], 0.0);
        for (row, end) in columns.iter_mut().zip(&mut rows) {
            let mut up_to = 0.0;
            for cell in row {
                up_to += *cell / count;
                *cell = up_to;
            }
            sum += up_to;
            *end = sum;
        }
        ViewCells {
            rows,
            columns,
            density,
        }
    }
}

/// The interval, of `count` with rising ends, that holds the fraction `u` of the last end, and where in it that lies.
fn within(count: usize, end: impl Fn(usize) -> f64, u: f64) -> (usize, f64) {
    let target = u * end(count - 1);
    let k = (0..count - 1)
        .find(|&k| end(k) > target)
        .unwrap_or(count - 1);
    let start = if k == 0 { 0.0 } else { end(k - 1) };
    let share = (target - start) / (end(k) - start);
    (k, share.clamp(0.0, 1.0 - f64::EPSILON))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::quadrature::lattice;
    use std::f64::consts::TAU;

    fn guide() -> FacetGuide {
        FacetGuide::new(|cos, slope, azimuth| {
            if azimuth > 0.4 {
                0.0
            } else {
                slope * (1.0 + cos) + azimuth
            }
        })
    }

    /// Samples over their density are uniform: every cell gets its area.
    #[test]
    fn density_is_that_of_choices() {
        let (guide, count) = (guide(), 100_000);
        for cos in [0.02, 0.5, 1.0] {
            let mut areas = [[0.0; 8]; 4];
            for [u1, u2, _] in lattice(count) {
                let (slope, azimuth) = guide.choose(cos, u1, u2);
                let density = guide.density(cos, slope, (TAU * azimuth).cos());
                let cell = &mut areas[(4.0 * slope) as usize][(8.0 * azimuth) as usize];
                *cell += 32.0 / (density * count as f64);
            }
            for area in areas.into_iter().flatten() {
                assert!((area - 1.0).abs() < 0.15, "{areas:?}");
            }
        }
    }

    /// Where nothing is reflected few samples go, and some.
    #[test]
    fn choices_follow_weights() {
        let guide = guide();
        let lost = lattice(10_000).filter(|&[u1, u2, _]| {
            let (_, azimuth) = guide.choose(0.5, u1, u2);
            (0.45..0.55).contains(&azimuth)
        });
        let share = lost.count() as f64 / 10_000.0;
        assert!((0.0005..0.01).contains(&share), "{share}");
    }
}
