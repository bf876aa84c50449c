//! Irradiance at many points from that at fewer: direct light at every point, indirect light at the nodes of
//! [cells](crate::point_cells), from rays that read patches and are corrected by a few paths.

use crate::gather_pass::GatherPass;
use crate::gathered_values::GatheredValues;
use crate::gathering::{GatherEffort, GatherError, GatherTargets, Gathering, Paths};
use crate::path_pairs::{PairTargets, gather_pairs};
use crate::point_cells::PointCells;
use crate::point_light::{GatherSummary, PointLight};
use crate::report::Estimate;
use crate::sites::{
    IndirectGoal, NodeGather, SiteDirect, SiteLight, SiteStatistics, with_indirect,
};
use crate::strata::{ErrorParts, QuarterError};
use azulejo_scene::Rgb;
use azulejo_trace::{DiffuseLight, Measure};

/// Rays, for direct light alone, of the first pass over all points.
const DIRECT_RAYS: u32 = 64;

/// Part of the requested error that indirect light may make; direct light gets what that leaves.
const INDIRECT_SHARE: f64 = 0.9;

/// Least part of the requested error that is left to direct light.
const LEAST_DIRECT: f64 = 0.2;

/// Irradiance at all points of `pass` to `effort.error`.
pub(crate) fn gather_shared<L: DiffuseLight>(
    pass: &GatherPass<L>,
    targets: GatherTargets,
    effort: GatherEffort,
) -> Result<PointLight, GatherError> {
    let goal = effort.error.unwrap_or_default();
    // Find direct light roughly: it is needed to know what the mean is.
    let mut direct = Gathering {
        values: GatheredValues::direct_only(targets.points.len()),
        ..Gathering::new(targets)
    };
    let rays = DIRECT_RAYS.min(effort.most());
    pass.raise(&mut direct, &vec![rays; targets.points.len()])?;
    direct.strata.divide(&direct.gathered);
    // Gather indirect light at nodes, as if direct light were known.
    let known = SiteDirect {
        irradiance: direct.gathered.iter().map(|g| g.mean().to_f32()).collect(),
        variance: vec![[0.0; 3]; targets.points.len()],
    };
    let cells = PointCells::new(
        pass.gatherer.surfaces().tracer,
        targets.points,
        targets.areas,
        pass.seed,
    );
    let indirect_goal = IndirectGoal {
        relative: INDIRECT_SHARE * goal,
        least: 0.0,
    };
    // Without light on patches all rays are path traced.
    let way = if pass.light.patches.is_unknown() {
        NodeGather::Traced
    } else {
        NodeGather::Paired
    };
    let mut gather = |targets: &[PairTargets]| {
        gather_pairs(pass.gatherer, pass.light, targets, pass.seed, pass.run)
    };
    let (light, statistics) =
        with_indirect(cells, &known, indirect_goal, way, pass.run, &mut gather)?;
    // Spend rays on direct light until both together are as exact as is asked.
    let shares = direct.strata.shares();
    let mean_of = |of: &dyn Fn(usize) -> f64| -> f64 {
        shares
            .iter()
            .enumerate()
            .map(|(i, share)| share * of(i))
            .sum()
    };
    let mean = mean_of(&|i| Rgb::from(light[i].irradiance.map(f64::from)).mean());
    let direct_mean = mean_of(&|i| direct.gathered[i].mean().mean());
    let square = mean_of(&|i| {
        let error = Rgb::from(light[i].standard_error.map(f64::from));
        (error * error).mean()
    });
    if direct_mean > 0.0 {
        let permitted = (goal * mean).powi(2);
        let left = (permitted - square).max((LEAST_DIRECT * goal * mean).powi(2));
        let effort = GatherEffort {
            error: Some(left.sqrt() / direct_mean),
            paths: Paths::Always,
            ..effort
        };
        pass.spend(&mut direct, effort, &mut |_| ())?;
    }
    let found = combined(&direct, &known, &light, &statistics, goal);
    pass.run
        .progress
        .measured(Measure::Error(found.summary.error));
    Ok(found)
}

/// Both kinds of light together. `known` is the direct light that is part of `light`.
fn combined(
    direct: &Gathering,
    known: &SiteDirect,
    light: &[SiteLight],
    statistics: &SiteStatistics,
    goal: f64,
) -> PointLight {
    let direct_errors = direct.standard_errors();
    let estimate = |i: usize| {
        let [all, error] = [light[i].irradiance, light[i].standard_error];
        let indirect =
            Rgb::from(all.map(f64::from)) - Rgb::from(known.irradiance[i].map(f64::from));
        let error = Rgb::from(error.map(f64::from));
        let own = direct_errors[i];
        Estimate {
            value: (direct.gathered[i].mean() + indirect).map(|e| e.max(0.0)),
            error: (error * error + own * own).map(f64::sqrt),
        }
    };
    let estimates: Vec<Estimate> = (0..light.len()).map(estimate).collect();
    // The stated error is that of the mean square, without what small samples add to the bars of points.
    let direct_strata = direct.errors();
    let square = |i: usize| {
        let error = Rgb::from(light[i].standard_error.map(f64::from));
        let gain = direct_strata[direct.strata.of(i)].gain;
        let noise = direct.strata.mean_of(direct.gathered[i].variance()) * gain;
        direct.strata.mean_of(error * error) + noise
    };
    let squares: Vec<f64> = (0..light.len()).map(square).collect();
    let summary = summary(direct, (&estimates, &squares), statistics, goal);
    PointLight { estimates, summary }
}

fn summary(
    direct: &Gathering,
    (estimates, squares): (&[Estimate], &[f64]),
    statistics: &SiteStatistics,
    goal: f64,
) -> GatherSummary {
    let strata = &direct.strata;
    // Means of points by their areas.
    let (mut mean, mut square, mut each) = (0.0, 0.0, (0.0, 0));
    let brightness: Vec<f64> = estimates.iter().map(|e| strata.mean_of(e.value)).collect();
    for (i, estimate) in estimates.iter().enumerate() {
        let of_point = strata.mean_of(estimate.error * estimate.error);
        mean += strata.share(i) * brightness[i];
        square += strata.share(i) * squares[i];
        if brightness[i] > 0.0 {
            each = (
                each.0 + of_point / (brightness[i] * brightness[i]),
                each.1 + 1,
            );
        }
    }
    let mut order: Vec<usize> = (0..estimates.len()).collect();
    order.sort_by(|&a, &b| brightness[a].total_cmp(&brightness[b]));
    let mut quarters = [QuarterError::default(); 4];
    let mut areas = [0.0; 4];
    for (rank, &i) in order.iter().enumerate() {
        let q = rank * 4 / order.len();
        areas[q] += strata.share(i);
        quarters[q].mean += strata.share(i) * brightness[i];
        quarters[q].error += strata.share(i) * squares[i];
    }
    for (quarter, area) in quarters.iter_mut().zip(areas) {
        if area > 0.0 {
            quarter.mean /= area;
            quarter.error = (quarter.error / area).sqrt();
        }
    }
    let relative = |square: f64| {
        if mean > 0.0 {
            square.sqrt() / mean
        } else {
            0.0
        }
    };
    let interpolation = statistics.interpolation;
    let error = relative(square);
    let [read, traced] = statistics.rays;
    let count = estimates.len().max(1) as u64;
    GatherSummary {
        points: estimates.len(),
        rays: (read + traced).div_ceil(count) as u32,
        error,
        error_each: (each.0 / f64::from(each.1.max(1))).sqrt(),
        parts: ErrorParts {
            noise: relative((square - interpolation * interpolation).max(0.0)),
            discretization: 0.0,
            interpolation: relative(interpolation * interpolation),
        },
        quarters,
        path_traced: statistics.path_traced,
        rays_needed: if error > goal {
            (error / goal).powi(2)
        } else {
            1.0
        },
        interpolated: 1.0 - statistics.nodes as f64 / count as f64,
        records: None,
    }
}
