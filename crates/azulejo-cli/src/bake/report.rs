//! The report of a lightmap.

use crate::failure::Failure;
use crate::first_pass::FirstPassArgs;
use crate::pass;
use crate::report::{Report, count, number, percent, short};
use azulejo::bake::{Lightmap, QuarterLight};
use azulejo::lightmap::{Baked, direction_errors};
use azulejo_scene::Scene;

/// Light of a quarter of the area, relative to the mean, of which no relative error is given.
const DARK: f64 = 1e-2;

/// Difference between texels and patches up to which either may be inexact.
const LEAST_DIFFERENCE: f64 = 0.05;

/// Largest share of the area with sides that differ that is not reported.
const FEW_SIDES: f64 = 0.005;

/// Adds what was baked, and its error.
///
/// # Errors
/// If so much of the emitted power is missing that the result cannot be trusted, unless `args` allow it.
pub fn describe(
    baked: &Baked,
    args: &FirstPassArgs,
    scene: &Scene,
    report: &mut Report,
) -> Result<(), Failure> {
    if let Some(pass) = &baked.report {
        pass::refuse_imbalance(pass, args)?;
    }
    pages(baked, scene, report);
    light(baked, args, scene, report);
    report.line("by quarters", quarter_errors(&baked.lightmap));
    doubts(baked, report);
    seams(baked, report);
    if baked.lightmap.buried > 0 {
        let words = format!("{} inside of solids", count(baked.lightmap.buried));
        report.fact(
            "buried_texels",
            baked.lightmap.buried,
            "buried texels",
            words,
        );
    }
    Ok(())
}

/// Adds the charts and the texels.
fn pages(baked: &Baked, scene: &Scene, report: &mut Report) {
    let layout = &baked.atlas.layout;
    let sizes: Vec<String> = layout
        .pages
        .iter()
        .map(|[width, height]| format!("{width} × {height}"))
        .collect();
    let charts = format!(
        "{} on {} of {} texels",
        count(layout.charts),
        if sizes.len() == 1 {
            "a page".to_owned()
        } else {
            format!("{} pages", sizes.len())
        },
        sizes.join(", ")
    );
    report.fact("charts", layout.charts, "charts", charts);
    let covered = baked.lightmap.covered_share();
    let density = layout.density(&baked.atlas.receivers) / scene.units.metres();
    let words = format!(
        "{} cover surfaces, {} of the pages; {} per metre",
        count(baked.texels.sites),
        percent(covered),
        short(density)
    );
    report.fact("texels", baked.texels.sites, "texels", words);
    report.value("covered", number(covered));
    report.value("texels_per_metre", number(density));
}

/// Adds how light was gathered, its mean and its errors.
fn light(baked: &Baked, args: &FirstPassArgs, scene: &Scene, report: &mut Report) {
    // Only light has a first pass with a report; occlusion is a share, without a unit of irradiance.
    let is_light = baked.report.is_some();
    let nodes = if baked.texels.nodes == baked.texels.sites {
        "gathered at every texel".to_owned()
    } else {
        format!(
            "gathered at {}, interpolated between",
            count(baked.texels.nodes)
        )
    };
    let (what, mean_name, unit) = match (is_light, scene.units.photometric) {
        (true, true) => ("indirect light", "mean irradiance", "lx"),
        (true, false) => ("indirect light", "mean irradiance", "W/m²"),
        (false, _) => ("occlusion", "mean", "of the hemisphere is free"),
    };
    report.fact("nodes", baked.texels.nodes, what, nodes);
    // State the mean, to which errors are relative, and the error beside the requested one.
    let mean = baked.lightmap.mean();
    report.fact(
        "mean",
        number(mean.mean()),
        mean_name,
        format!("{} {unit}", short(mean.mean())),
    );
    let error = baked.lightmap.relative_error();
    let request = args.error.map_or(String::new(), |requested| {
        format!(", {} requested", percent(requested))
    });
    report.fact(
        "error",
        number(error),
        "estimated error",
        format!("{} of the {}{request}", percent(error), mean_name),
    );
    if let Some(harmonics) = &baked.harmonics {
        let errors = direction_errors(harmonics);
        let [radiance, direction] = errors.map(percent);
        let words = format!(
            "coefficients of band 0 to {radiance}, of band 1 to {direction} of the mean of band 0"
        );
        report.fact("direction_errors", errors.map(number), "directions", words);
    }
    // State apart what interpolation between texels misses: more texels reduce that part, more rays do not.
    if is_light {
        let whole = mean.mean();
        let between = if whole > 0.0 {
            baked.between_texels / whole
        } else {
            0.0
        };
        report.fact(
            "between_texels",
            number(between),
            "between texels",
            format!(
                "{} of the mean: light that texels are too coarse for",
                percent(between)
            ),
        );
    }
}

/// The errors from dark texels to bright ones.
fn quarter_errors(lightmap: &Lightmap) -> String {
    let dark = DARK * lightmap.mean().mean();
    let error = |q: &QuarterLight| {
        if q.mean > dark {
            percent(q.error / q.mean)
        } else {
            "dark".to_owned()
        }
    };
    let quarters = lightmap.quarters();
    let errors: Vec<String> = quarters.iter().map(error).collect();
    format!("{} (dark to bright)", errors.join(", "))
}

/// Adds a caution where the patches of the first pass had other light.
fn doubts(baked: &Baked, report: &mut Report) {
    report.value("beside_patches", number(baked.beside_patches));
    if baked.beside_patches.abs() > f64::max(baked.lightmap.relative_error(), LEAST_DIFFERENCE) {
        let more = if baked.beside_patches > 0.0 {
            "more"
        } else {
            "less"
        };
        let words = format!(
            "{} {more} light than the patches of the first pass: one of both is off by that; a smaller --error \
             finds out",
            percent(baked.beside_patches.abs())
        );
        report.line("caution", words);
    }
}

/// Adds how much the light of both sides of a seam, and of a sheet, differs.
fn seams(baked: &Baked, report: &mut Report) {
    let seams = &baked.seams;
    if seams.points + seams.abrupt > 0 {
        let apart = seams.after / baked.lightmap.mean().mean();
        let abrupt = seams.abrupt as f64 / (seams.points + seams.abrupt) as f64;
        let mut words = format!("{} of the mean apart", percent(apart));
        if seams.abrupt > 0 {
            words += &format!(", but for {} where light changes abruptly", percent(abrupt));
        }
        report.fact("seams", number(apart), "seams", words);
        report.value("abrupt_seams", number(abrupt));
    }
    report.value("differing_sides", number(baked.differing_sides));
    if baked.differing_sides > FEW_SIDES {
        let words = format!(
            "of {} of the area have light that differs by more than a tenth: one is baked, --double-sided split \
             bakes both",
            percent(baked.differing_sides)
        );
        report.line("both sides", words);
    }
}
