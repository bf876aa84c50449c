//! Measures of a form factor matrix: its deviation from another, and its closure, reciprocity and
//! energy balance.

use azulejo_factors::{FormFactors, Patches, reflectances};
use azulejo_scene::{Rgb, Scene};

/// The entries of a row: columns, ascending, with their form factors.
pub type SparseRow = Vec<(u32, f64)>;

/// Reflectance and exitance of the patches of a matrix.
pub struct PatchSurfaces {
    /// Diffuse reflectance ρ_d.
    pub reflectance: Vec<Rgb>,
    /// Emitted exitance M, W/m².
    pub exitance: Vec<Rgb>,
}

impl PatchSurfaces {
    /// Those of the fronts of all patches.
    pub fn new(scene: &Scene, patches: &Patches) -> PatchSurfaces {
        let exitance = |p: usize| scene.materials[patches.material(p) as usize].exitance();
        PatchSurfaces {
            reflectance: reflectances(scene, patches),
            exitance: (0..patches.len()).map(exitance).collect(),
        }
    }
}

/// Relative error of a row, Σ_j |X_ij − R_ij| / Σ_j R_ij; 0 for a row that sees nothing in either.
pub fn row_error(row: &[(u32, f64)], reference: &[(u32, f64)]) -> f64 {
    let negated = reference.iter().map(|&(j, r)| (j, -r));
    let mut both: SparseRow = row.iter().copied().chain(negated).collect();
    both.sort_by_key(|e| e.0);
    let columns = both.chunk_by(|a, b| a.0 == b.0);
    let wrong: f64 = columns
        .map(|c| c.iter().map(|e| e.1).sum::<f64>().abs())
        .sum();
    // Sums of nothing are −0.
    let whole = reference.iter().map(|e| e.1).sum::<f64>().abs();
    if wrong == 0.0 { 0.0 } else { wrong / whole }
}

/// Mean and largest of some numbers; zeros for none.
pub fn mean_and_largest(numbers: &[f64]) -> (f64, f64) {
    let sum: f64 = numbers.iter().sum();
    let largest = numbers.iter().copied().fold(0.0, f64::max);
    (sum / numbers.len().max(1) as f64, largest)
}

/// Relative errors of radiosities, of the mean of the channels, where the reference is not dark.
pub fn radiosity_errors(radiosities: &[Rgb], reference: &[Rgb]) -> Vec<f64> {
    let pairs = radiosities
        .iter()
        .zip(reference)
        .filter(|(_, r)| r.mean() > 0.0);
    pairs
        .map(|(b, r)| (b.mean() / r.mean() - 1.0).abs())
        .collect()
}

/// The light of a closed system of patches.
pub struct PatchRadiosity {
    /// B of each row, W/m².
    pub leaving: Vec<Rgb>,
    /// H of each row, W/m².
    pub arriving: Vec<Rgb>,
}

/// Relative change at which the bounces end.
const TOLERANCE: f64 = 1e-9;

/// More bounces than this are not followed.
const MOST_BOUNCES: usize = 1_000;

/// Solves B = M + ρ_d X B by Jacobi's iteration from B = M, until nothing changes by more than
/// a billionth of the largest.
pub fn radiosity(factors: &FormFactors, surfaces: &PatchSurfaces) -> PatchRadiosity {
    let mut leaving = surfaces.exitance.clone();
    let mut arriving = Vec::new();
    for _ in 0..MOST_BOUNCES {
        arriving = times(factors, &leaving);
        let (mut change, mut largest) = (0f64, 0f64);
        for (i, b) in leaving.iter_mut().enumerate() {
            let next = surfaces.exitance[i] + surfaces.reflectance[i] * arriving[i];
            change = change.max((next - *b).map(f64::abs).max_channel());
            largest = largest.max(next.max_channel());
            *b = next;
        }
        if change <= TOLERANCE * largest {
            break;
        }
    }
    PatchRadiosity { leaving, arriving }
}

/// X times a vector; half of the matrix is stored, so each pair is used both ways.
fn times(factors: &FormFactors, b: &[Rgb]) -> Vec<Rgb> {
    let mut power = vec![Rgb::BLACK; b.len()];
    for i in 0..factors.len() {
        for e in factors.exchange.upper(i) {
            let j = e.column as usize;
            power[i] += b[j] * e.value;
            if j != i {
                power[j] += b[i] * e.value;
            }
        }
    }
    power
        .iter()
        .zip(&factors.areas)
        .map(|(&p, &a)| p / a)
        .collect()
}

/// |Σ_j X_ij (1 − ρ_s,j) + what meets no column − 1| of every row: 0 where all light is accounted
/// for.
pub fn closure_errors(factors: &FormFactors) -> Vec<f64> {
    let ends: Vec<Rgb> = factors.ends.iter().map(|&e| Rgb::grey(e)).collect();
    let sums = times(factors, &ends);
    let rows = sums.iter().zip(&factors.rest);
    rows.map(|(sum, rest)| (sum.mean() + rest.sum() - 1.0).abs())
        .collect()
}

/// Largest |A_i X_ij − A_j X_ji| over its mean row, Σ_j A_i X_ij / n, of some rows.
pub fn reciprocity_error(factors: &FormFactors, rows: &[usize]) -> f64 {
    let mut worst = 0f64;
    for &i in rows {
        let row: Vec<(u32, f64, f32)> = factors.row(i).collect();
        let mean = row.iter().map(|(_, x, _)| x).sum::<f64>() / row.len().max(1) as f64;
        for (j, x, _) in row {
            let (back, _) = factors.get(j as usize, i as u32);
            let there = factors.areas[i] * x;
            let off = (there - factors.areas[j as usize] * back).abs();
            worst = worst.max(off / (factors.areas[i] * mean));
        }
    }
    worst
}

/// Emitted power that is neither absorbed nor leaves the scene, as a share; `None` without emission.
pub fn energy_error(
    factors: &FormFactors,
    surfaces: &PatchSurfaces,
    light: &PatchRadiosity,
) -> Option<f64> {
    let (mut emitted, mut spent) = (0.0, 0.0);
    for i in 0..factors.len() {
        let area = factors.areas[i];
        let kept = Rgb::grey(factors.ends[i]) - surfaces.reflectance[i];
        let lost = factors.rest[i].sum();
        emitted += area * surfaces.exitance[i].mean();
        spent += area * ((light.arriving[i] * kept).mean() + light.leaving[i].mean() * lost);
    }
    (emitted > 0.0).then(|| ((emitted - spent) / emitted).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_factors::{FormFactorOptions, PatchSize, form_factors};
    use azulejo_scene::Shape;
    use azulejo_scene::synthetic::cube_room;
    use azulejo_trace::{Progress, Tracer};

    #[test]
    fn rows_are_compared_entry_by_entry() {
        let reference = [(0, 0.5), (2, 0.25), (7, 0.25)];
        assert_eq!(row_error(&reference, &reference), 0.0);
        assert_eq!(row_error(&[], &reference), 1.0);
        assert_eq!(
            row_error(&[(0, 0.5), (1, 0.25), (7, 0.5)], &reference),
            0.75
        );
        assert_eq!(row_error(&[], &[]), 0.0);
        assert_eq!(row_error(&[(3, 0.1)], &[]), f64::INFINITY);
        assert_eq!(mean_and_largest(&[1.0, 3.0]), (2.0, 3.0));
        assert_eq!(mean_and_largest(&[]), (0.0, 0.0));
        let errors = radiosity_errors(&[Rgb::grey(1.1), Rgb::WHITE], &[Rgb::WHITE, Rgb::BLACK]);
        assert!(errors.len() == 1 && (errors[0] - 0.1).abs() < 1e-12);
    }

    /// A furnace: M = 1 and ρ = 0.5 all over a closed room make B = 2 whatever the form factors,
    /// as long as rows sum to 1.
    #[test]
    fn a_closed_room_conserves_energy() {
        let mut scene = cube_room();
        for material in &mut scene.materials {
            material.diffuse = Rgb::grey(0.5);
            material.emission = Rgb::grey(std::f64::consts::FRAC_1_PI);
        }
        assert!(matches!(scene.objects[0].shape, Shape::Mesh(_)));
        let size = PatchSize::Edge(0.5);
        let options = FormFactorOptions {
            size,
            rays: 256,
            ..FormFactorOptions::default()
        };
        let factors =
            form_factors(&scene, &Tracer::new(&scene), &options, &Progress::new()).unwrap();
        let surfaces = PatchSurfaces::new(&scene, &Patches::new(&scene, size));
        let light = radiosity(&factors, &surfaces);
        let twos = vec![Rgb::grey(2.0); factors.len()];
        let worst = mean_and_largest(&radiosity_errors(&light.leaving, &twos)).1;
        assert!(worst < 1e-6, "{worst}");
        assert!(mean_and_largest(&closure_errors(&factors)).1 < 1e-6);
        assert!(energy_error(&factors, &surfaces, &light).unwrap() < 1e-6);
        assert!(reciprocity_error(&factors, &[0, 7, 23]) < 1e-12);
        let dark = PatchSurfaces {
            exitance: vec![Rgb::BLACK; factors.len()],
            ..surfaces
        };
        assert_eq!(
            energy_error(&factors, &dark, &radiosity(&factors, &dark)),
            None
        );
    }
}
