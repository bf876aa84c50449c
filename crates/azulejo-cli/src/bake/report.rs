//! What is said of a lightmap.

use crate::args::FirstPassArgs;
use crate::failure::Failure;
use crate::report::{Report, count, number, percent, short};
use azulejo::lightmap::Baked;
use azulejo_scene::Scene;

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
    let balance = &baked.report.balance;
    if balance.is_broken() && !args.allow_imbalance && args.bounces.is_none() {
        return Err(Failure::failed(format_args!(
            "{} of the emitted power is not accounted for, so nothing was written: request a smaller \
             error, more rays or more time, or accept it with --allow-imbalance",
            percent(balance.error())
        )));
    }
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
        count(baked.texels.samples),
        percent(covered),
        short(density)
    );
    report.fact("texels", baked.texels.samples, "texels", words);
    report.value("covered", number(covered));
    report.value("texels_per_metre", number(density));
    let nodes = format!(
        "gathered at {}, interpolated between",
        count(baked.texels.nodes)
    );
    report.fact("nodes", baked.texels.nodes, "indirect light", nodes);
    let unit = if scene.units.photometric {
        "lx"
    } else {
        "W/m²"
    };
    let mean = baked.lightmap.mean();
    report.fact(
        "mean",
        number(mean.mean()),
        "mean irradiance",
        format!("{} {unit}", short(mean.mean())),
    );
    let error = baked.lightmap.relative_error();
    let asked = args.error.map_or(String::new(), |asked| {
        format!(", {} asked for", percent(asked))
    });
    report.fact(
        "error",
        number(error),
        "estimated error",
        format!("{} of the mean irradiance{asked}", percent(error)),
    );
    let quarters = baked.lightmap.quarters();
    let by_quarter: Vec<String> = quarters.iter().map(|q| percent(q.error / q.mean)).collect();
    report.line(
        "by quarters",
        format!("{} (dark to bright)", by_quarter.join(", ")),
    );
    if baked.seams.points > 0 {
        let seams = baked.seams.after / mean.mean();
        let words = format!("{} of the mean apart", percent(seams));
        report.fact("seams", number(seams), "seams", words);
    }
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
