//! What a picture may cost by default, in rays, and what is said where that limits it.
//!
//! Numbers of rays, never seconds: the same command gives the same picture on every machine.

use super::args::ImageArgs;
use super::layers;
use crate::failure::Failure;
use crate::first_pass::FirstPassArgs;
use crate::pass::times;
use crate::report::{Report, percent};
use crate::session::Session;
use azulejo_radiosity::FirstPass;
use azulejo_render::{
    FinalGather, MeasuredImage, SecondPass, render_measured, render_with_errors, render_within,
};
use azulejo_scene::{Camera, Scene};
use azulejo_trace::Tracer;

/// Rays of the first pass from all vertices together.
const FIRST_PASS_RAYS: f64 = 16e6;

/// Error to which these rays are spent, as by default.
const ERROR: f64 = 0.03;

/// Rays of the second pass for each pixel.
const RAYS_PER_PIXEL: u64 = 96;

/// Contrast up to which a pixel needs few samples: steps of less are not seen.
const CONTRAST: f64 = 0.05;

/// The first pass for a picture, as `pass` unless its effort was not chosen: then with a limited number of rays.
pub fn first_pass(args: &FirstPassArgs, pass: FirstPass) -> FirstPass {
    FirstPass {
        ray_budget: is_limited(args).then_some(FIRST_PASS_RAYS),
        ..pass
    }
}

/// Whether the first pass has a limit because the command line sets none.
fn is_limited(args: &FirstPassArgs) -> bool {
    let division = args.division.patches.is_some() || args.division.patch_size.is_some();
    let is_chosen =
        args.requested_error().is_some() || args.rays.is_some() || args.limit().is_some();
    !division && !is_chosen
}

/// Says how to go on where the limit kept the first pass from its error.
pub fn describe_first_pass(
    args: &FirstPassArgs,
    found: &azulejo_radiosity::Report,
    report: &mut Report,
) {
    if !is_limited(args) || found.error <= ERROR || found.rays_needed <= 1.0 {
        return;
    }
    let words = format!(
        "the light has an error of {}: {} would take {} the rays that a picture takes by default; \
         --error {} allows them",
        percent(found.error),
        percent(ERROR),
        times(found.rays_needed),
        percent(ERROR)
    );
    report.line("limit", words);
}

/// Renders a view by the second pass, with fewer rays than `options` have if it would take too many and its effort was
/// not chosen; says how to go on then.
pub fn render(
    args: &ImageArgs,
    options: &SecondPass,
    (scene, tracer, camera): (&Scene, &Tracer, &Camera),
    session: &Session,
    report: &mut Report,
) -> Result<MeasuredImage, Failure> {
    let is_chosen = args.spp.is_some() || args.gather.is_some();
    let tells_direct = layers::tell_direct_light(args.layers.as_deref());
    session.with_progress(|progress| {
        if tells_direct {
            return Ok(render_measured(scene, tracer, camera, options, progress)?);
        }
        if is_chosen {
            return Ok(render_with_errors(
                scene, tracer, camera, options, progress,
            )?);
        }
        let rays = RAYS_PER_PIXEL * u64::from(options.size.0) * u64::from(options.size.1);
        let is_plain = args.layers.is_none() && !args.denoise;
        let options = SecondPass {
            contrast: is_plain.then_some(CONTRAST),
            ..options.clone()
        };
        let (image, taken) = render_within(rays, scene, tracer, camera, &options, progress)?;
        describe_second_pass(&options, &taken, report);
        Ok(image)
    })
}

/// Says how to go on where the limit made a picture coarser than `whole`.
fn describe_second_pass(whole: &SecondPass, taken: &SecondPass, report: &mut Report) {
    if taken == whole {
        return;
    }
    let mut limits = Vec::new();
    let (samples, all) = (taken.samples_per_pixel, whole.samples_per_pixel);
    if samples < all {
        limits.push(format!("{samples} samples per pixel instead of {all}"));
    }
    if let (FinalGather::Uneven(rays), FinalGather::Uneven(all)) = (taken.gather, whole.gather)
        && rays < all
    {
        limits.push(format!(
            "{rays} rays instead of {all} where light is gathered"
        ));
    }
    let words = limits.join(", and ") + ", because more would cost much";
    report.line(
        "limit",
        format!("{words}: --spp {all} lifts the limit, --denoise smooths dots"),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::synthetic::{CornellVariant, cornell_box};
    use azulejo_trace::Progress;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        first: FirstPassArgs,
    }

    fn parsed(line: &str) -> FirstPassArgs {
        Line::parse_from(format!("render {line}").split_whitespace()).first
    }

    #[test]
    fn the_effort_is_limited_unless_it_is_chosen() {
        let limited = |line: &str| first_pass(&parsed(line), FirstPass::default()).ray_budget;
        assert_eq!(limited("--seed 1"), Some(FIRST_PASS_RAYS));
        for chosen in [
            "--error 1%",
            "--error-each 5%",
            "--rays 10",
            "--time 5s",
            "--patches 100",
            "--patch-size 1",
        ] {
            assert_eq!(limited(chosen), None, "{chosen}");
        }
    }

    #[test]
    fn where_the_limit_matters_the_report_says_how_to_go_on() {
        let scene = cornell_box(CornellVariant::Diffuse);
        let pass = FirstPass {
            rays: Some(8),
            error: Some(ERROR),
            ..FirstPass::default()
        };
        let tracer = Tracer::new(&scene);
        let light = azulejo_radiosity::solve(&scene, &tracer, &pass, &Progress::new());
        let text = |line: &str| {
            let mut report = Report::default();
            let light_report = &light.as_ref().expect("nobody cancels").report;
            describe_first_pass(&parsed(line), light_report, &mut report);
            let mut text = Vec::new();
            report.write_lines(&mut text).expect("memory suffices");
            String::from_utf8(text).expect("text")
        };
        assert!(text("").contains("--error 3% allows them"), "{}", text(""));
        assert_eq!(text("--rays 8"), "");
    }

    #[test]
    fn a_coarser_picture_says_how_to_go_on() {
        let whole = SecondPass {
            gather: FinalGather::Uneven(16),
            ..SecondPass::default()
        };
        let text = |taken: &SecondPass| {
            let mut report = Report::default();
            describe_second_pass(&whole, taken, &mut report);
            let mut text = Vec::new();
            report.write_lines(&mut text).expect("memory suffices");
            String::from_utf8(text).expect("text")
        };
        let taken = SecondPass {
            gather: FinalGather::Uneven(4),
            samples_per_pixel: 8,
            ..whole.clone()
        };
        assert!(
            text(&taken).contains(
                "8 samples per pixel instead of 16, and 4 rays instead of 16 where light is gathered"
            ),
            "{}",
            text(&taken)
        );
        let taken = SecondPass {
            gather: FinalGather::Uneven(8),
            ..whole.clone()
        };
        assert!(text(&taken).contains("--spp 16 lifts the limit"));
        assert!(!text(&taken).contains("samples"), "{}", text(&taken));
        assert_eq!(text(&whole), "");
    }
}
