//! Sampling of directions in proportion to the radiance of an environment.

use azulejo_scene::environment::solid_angle_of_band;
use azulejo_scene::{Environment, EnvironmentSource, Image, Projection, Rgb};
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// Most columns and rows of a table: larger pictures share cells.
const MOST_CELLS: (u32, u32) = (1024, 512);

/// Columns and rows for what is not a picture.
const SMOOTH_CELLS: (u32, u32) = (512, 256);

/// Samples per cell and direction of what is not summed pixel by pixel.
const PER_CELL: u32 = 2;

/// Share of the samples that are spread over all directions, so that nothing is missed that is
/// smaller than what the cells resolve.
const EVERYWHERE: f64 = 0.01;

/// A density over directions, constant in cells of azimuth and zenith angle (Pharr, Jakob,
/// Humphreys, *Physically Based Rendering*, 2016, 14.2.4).
pub(super) struct DirectionTable {
    columns: u32,
    rows: u32,
    /// Per row, the probability of all rows up to it.
    row_ends: Vec<f64>,
    /// Per cell, the probability of the cells of its row up to it, within the row.
    column_ends: Vec<f64>,
    total: Rgb,
}

impl DirectionTable {
    /// `None` if the environment is black.
    pub fn new(environment: &Environment, image: Option<&Image>) -> Option<DirectionTable> {
        let EnvironmentCells {
            columns,
            rows,
            mut flux,
        } = cells(environment, image)?;
        let total: Rgb = flux.iter().copied().sum();
        let mean = total.mean();
        if mean.is_nan() || mean <= 0.0 {
            return None;
        }
        let width = TAU / f64::from(columns);
        let (mut row_ends, mut column_ends) = (Vec::new(), Vec::with_capacity(flux.len()));
        let mut before = 0.0;
        for (row, flux) in flux.chunks_mut(columns as usize).enumerate() {
            let solid_angle = band(row as u32, rows, width);
            let everywhere = EVERYWHERE * solid_angle / (2.0 * TAU);
            let probability = |f: &Rgb| (1.0 - EVERYWHERE) * f.mean() / mean + everywhere;
            let of_row: f64 = flux.iter().map(probability).sum();
            let mut sum = 0.0;
            column_ends.extend(flux.iter().map(|f| {
                sum += probability(f) / of_row;
                sum
            }));
            before += of_row;
            row_ends.push(before);
        }
        Some(DirectionTable {
            columns,
            rows,
            row_ends,
            column_ends,
            total,
        })
    }

    /// Integral of the radiance over all directions, W/m².
    pub fn total(&self) -> Rgb {
        self.total
    }

    /// A unit direction of the environment's frame for two numbers in 0..1.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let (row, across_row) = choose(&self.row_ends, u[0]);
        let (column, across_column) = choose(self.row(row), u[1]);
        // Uniform over the solid angle of the cell.
        let edge = |row: usize| (PI * row as f64 / f64::from(self.rows)).cos();
        let z = edge(row) + across_row * (edge(row + 1) - edge(row));
        let azimuth = TAU * ((column as f64 + across_column) / f64::from(self.columns) - 0.5);
        direction(z, azimuth)
    }

    /// Density of [`sample`](DirectionTable::sample), 1/sr.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let (u, v) = Projection::Equirectangular.place(direction);
        let index = |x: f64, count: u32| ((x * f64::from(count)) as usize).min(count as usize - 1);
        let (row, column) = (index(v, self.rows), index(u, self.columns));
        let cell = step(&self.row_ends, row) * step(self.row(row), column);
        cell / band(row as u32, self.rows, TAU / f64::from(self.columns))
    }

    fn row(&self, row: usize) -> &[f64] {
        let columns = self.columns as usize;
        &self.column_ends[row * columns..][..columns]
    }
}

/// The environment's flux through cells, radiance times solid angle.
struct EnvironmentCells {
    columns: u32,
    rows: u32,
    flux: Vec<Rgb>,
}

fn cells(environment: &Environment, image: Option<&Image>) -> Option<EnvironmentCells> {
    let image = image.filter(|i| i.width > 0 && i.height > 0);
    match environment.source {
        EnvironmentSource::Picture { projection, .. } => {
            let image = image?;
            let (columns, rows) = (
                image.width.min(MOST_CELLS.0),
                image.height.min(MOST_CELLS.1),
            );
            Some(match projection {
                Projection::Equirectangular => pixel_cells(environment, image, columns, rows),
                Projection::AngularMap => {
                    sampled_cells(environment, Some(image), 2 * columns.max(2), rows.max(2))
                }
            })
        }
        EnvironmentSource::Sky(_) => {
            let (columns, rows) = SMOOTH_CELLS;
            Some(sampled_cells(environment, None, columns, rows))
        }
    }
}

/// Sums over pixels, exact: they are constant over their solid angles.
fn pixel_cells(
    environment: &Environment,
    image: &Image,
    columns: u32,
    rows: u32,
) -> EnvironmentCells {
    let mut flux = vec![Rgb::BLACK; (columns * rows) as usize];
    let width = TAU / f64::from(image.width);
    for (y, pixels) in image.pixels.chunks(image.width as usize).enumerate() {
        let solid_angle = band(y as u32, image.height, width);
        let row = y * rows as usize / image.height as usize;
        for (x, pixel) in pixels.iter().enumerate() {
            let column = x * columns as usize / image.width as usize;
            flux[row * columns as usize + column] +=
                Rgb::from(pixel.map(f64::from)) * environment.scale * solid_angle;
        }
    }
    EnvironmentCells {
        columns,
        rows,
        flux,
    }
}

/// Means of samples in each cell.
fn sampled_cells(
    environment: &Environment,
    image: Option<&Image>,
    columns: u32,
    rows: u32,
) -> EnvironmentCells {
    let local = Environment {
        world_from_environment: DQuat::IDENTITY,
        ..*environment
    };
    let width = TAU / f64::from(columns);
    let within = |k: u32| (f64::from(k) + 0.5) / f64::from(PER_CELL);
    let cell = |index: u32| {
        let (row, column) = (index / columns, index % columns);
        let edge = |row: u32| (PI * f64::from(row) / f64::from(rows)).cos();
        let mut sum = Rgb::BLACK;
        for down in 0..PER_CELL {
            for across in 0..PER_CELL {
                let z = edge(row) + within(down) * (edge(row + 1) - edge(row));
                let azimuth = width * (f64::from(column) + within(across)) - PI;
                sum += local.radiance(direction(z, azimuth), image);
            }
        }
        sum * (band(row, rows, width) / f64::from(PER_CELL * PER_CELL))
    };
    EnvironmentCells {
        columns,
        rows,
        flux: (0..columns * rows).map(cell).collect(),
    }
}

/// The unit direction at height `z` that a picture shows `azimuth` radians to the right of its
/// middle.
fn direction(z: f64, azimuth: f64) -> DVec3 {
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * azimuth.cos(), -across * azimuth.sin(), z)
}

/// Solid angle of one cell of a row.
fn band(row: u32, rows: u32, width: f64) -> f64 {
    let edge = |row: u32| PI * f64::from(row) / f64::from(rows);
    solid_angle_of_band(edge(row), edge(row + 1), width)
}

/// The interval that holds `u` times the last end, and how far along it that is, 0..1.
fn choose(ends: &[f64], u: f64) -> (usize, f64) {
    let u = u * ends[ends.len() - 1];
    let chosen = ends.partition_point(|&end| end <= u).min(ends.len() - 1);
    let before = if chosen == 0 { 0.0 } else { ends[chosen - 1] };
    let share = (u - before) / (ends[chosen] - before);
    (chosen, share.clamp(0.0, 1.0))
}

fn step(ends: &[f64], k: usize) -> f64 {
    let before = if k == 0 { 0.0 } else { ends[k - 1] };
    (ends[k] - before) / ends[ends.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::Up;

    #[test]
    fn a_uniform_picture_is_sampled_uniformly() {
        let mut image = Image::new(8, 4);
        image.pixels.fill([2.0; 3]);
        for projection in [Projection::Equirectangular, Projection::AngularMap] {
            let environment = Environment::picture(0, projection, Up::Z);
            let table = DirectionTable::new(&environment, Some(&image)).unwrap();
            assert!((table.total().r - 8.0 * PI).abs() < 1e-9);
            for u in [[0.0, 0.0], [0.3, 0.9], [0.999_999, 0.5]] {
                let d = table.sample(u);
                assert!((table.pdf(d) * 4.0 * PI - 1.0).abs() < 1e-9, "{d}");
            }
            assert!((table.sample([0.25, 0.5]).z - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn black_ones_give_no_light() {
        let environment = Environment::picture(0, Projection::Equirectangular, Up::Z);
        assert!(DirectionTable::new(&environment, Some(&Image::new(4, 2))).is_none());
        assert!(DirectionTable::new(&environment, Some(&Image::new(0, 0))).is_none());
        assert!(DirectionTable::new(&environment, None).is_none());
    }

    #[test]
    fn the_density_integrates_to_one() {
        let mut image = Image::new(16, 8);
        image.pixels[37] = [5.0, 1.0, 0.0];
        image.pixels[90] = [0.0, 1.0, 0.0];
        let environment = Environment::picture(0, Projection::Equirectangular, Up::Z);
        let table = DirectionTable::new(&environment, Some(&image)).unwrap();
        let (mut sum, width) = (0.0, TAU / 16.0);
        for row in 0..8 {
            for column in 0..16 {
                let zenith = PI * (f64::from(row) + 0.5) / 8.0;
                let azimuth = width * (f64::from(column) + 0.5) - PI;
                let d = direction(zenith.cos(), azimuth);
                sum += table.pdf(d) * band(row, 8, width);
            }
        }
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
    }
}
