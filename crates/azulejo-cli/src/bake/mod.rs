//! `bake`: the third pass, from a scene to a lightmap in a glTF file or a page.

pub mod args;
mod check;
mod coordinates;
mod pictures;
mod report;
mod source;
mod stale;
mod verdict;
mod work;
mod written;

use crate::failure::Failure;
use crate::report::Report;
use crate::runner::Runner;
use crate::session::Session;
use crate::{report as words, runner};
use args::{BakeArgs, ConventionArg, ImageArg, InstancesArg, LightArg};
use azulejo::lightmap::Baked;
use azulejo::output::Output;
pub use source::read_file;
use work::BakeWork;
use written::{BakeOutputs, WrittenPlaces};

/// Error beside the requested one up to which that counts as reached.
const TOLERATED: f64 = 1.2;

/// Runs `bake --check`: the report, and whether all is well.
pub use check::run as check;

/// Runs `bake --verify`: the report, and whether the lightmap is up to date.
pub use stale::run as verify;

/// Bakes the lightmap, or a part of it, and writes it.
pub fn run(args: &BakeArgs, runner: Runner, session: &mut Session) -> Result<Report, Failure> {
    if args.strip {
        return strip(args, session);
    }
    refuse_misplaced(args)?;
    refuse_indivisible(args, &runner)?;
    let outputs = runner
        .writes()
        .then(|| BakeOutputs::check(args))
        .transpose()?;
    session.claim_stdout(outputs.as_ref().is_some_and(BakeOutputs::is_stdout))?;
    let prepared = args.first_pass.engine.prepare()?;
    let mut source = source::read(args, session)?;
    runner.share_files(session)?;
    let (work, uvs) = BakeWork::new(args, &source, &prepared, session)?;
    let mut summary = Report::default();
    let file = outputs.as_ref().and_then(BakeOutputs::file);
    let baked = work.compute(runner, file, session, &mut summary)?;
    let (Some(baked), Some(outputs)) = (baked, outputs) else {
        return Ok(summary);
    };
    let (mut baked, rest) = (baked.value, baked.rest);
    let content = work.content().to_string();
    let options = work.into_options();
    source.turn_to_light(&mut baked).map_err(Failure::failed)?;
    report::describe(&baked, &args.first_pass, &source.scene, &mut summary)?;
    say_unreached(&baked, args, session);
    if options.follows_light && !baked.follows_light {
        session.note(
            "--density auto: texel density stays uniform, because packing charts of different densities would cost more \
             texels than sharper shadows gain",
        );
    }
    let places = WrittenPlaces {
        uvs,
        padding: options.charts.padding,
        content,
    };
    outputs.write(args, &source, &baked, places, session, &mut summary)?;
    rest.finish(&mut summary);
    Ok(summary)
}

/// Says that the requested error is not reached, and what would.
fn say_unreached(baked: &Baked, args: &BakeArgs, session: &mut Session) {
    let error = baked.lightmap.relative_error();
    let Some(requested) = args
        .first_pass
        .error
        .filter(|requested| error > TOLERATED * requested)
    else {
        return;
    };
    let between = baked.between_texels / baked.lightmap.mean().mean();
    let why = if session.progress().out_of_time() {
        "there was no time for more".to_owned()
    } else if between > requested {
        format!(
            "light changes abruptly between texels, which makes {} of it: more texels reduce that",
            words::percent(between)
        )
    } else {
        "interpolation and noise between the points that were gathered are larger".to_owned()
    };
    session.note(&format!(
        "the error is {}, not {}: {why}",
        words::percent(error),
        words::percent(requested)
    ));
}

/// Refuses to divide a lightmap whose texels depend on each other's light, or on the time, and to write pictures of
/// a part of one.
fn refuse_indivisible(args: &BakeArgs, runner: &Runner) -> Result<(), Failure> {
    runner::refuse_indivisible(&args.first_pass, runner)?;
    let Some(by) = runner.shared_by().filter(|_| runner.is_part()) else {
        return Ok(());
    };
    if args.files.directional.is_some() {
        return Err(Failure::misuse(format_args!(
            "{by}: --directional asks all texels for their light, of which a part has its own: run one process"
        )));
    }
    if args.texels.light == LightArg::Direct {
        return Err(Failure::misuse(format_args!(
            "{by}: --light direct has no number of rays: texels get more of them where their light differs from that \
             of their neighbours, which a part does not have; run one process"
        )));
    }
    let maps = [
        (&args.files.lightmap, "--lightmap"),
        (&args.files.error_map, "--error-map"),
    ];
    if let Some((_, option)) = maps.into_iter().find(|(path, _)| path.is_some()) {
        return Err(Failure::misuse(format_args!(
            "{by}: a part has no picture of the whole: give {option} to azulejo merge"
        )));
    }
    Ok(())
}

/// Options of the first pass that mean nothing here.
fn refuse_misplaced(args: &BakeArgs) -> Result<(), Failure> {
    let given = [
        (args.first_pass.keep_mesh, "--keep-mesh"),
        (args.first_pass.sides.is_some(), "--sides"),
        (args.first_pass.no_interpolation, "--no-interpolation"),
        (args.first_pass.error_each.is_some(), "--error-each"),
    ];
    if let Some((_, option)) = given.into_iter().find(|(is_given, _)| *is_given) {
        return Err(Failure::misuse(format_args!(
            "{option} is about light on vertices; a lightmap has texels"
        )));
    }
    refuse_conventions(args)
}

/// Options of files that do not fit each other.
fn refuse_conventions(args: &BakeArgs) -> Result<(), Failure> {
    let files = &args.files;
    let convention = args.convention();
    let is_occlusion = args.texels.light == LightArg::Ao;
    let is_for_occlusion = matches!(convention, ConventionArg::Occlusion | ConventionArg::Plain);
    if is_occlusion && !is_for_occlusion {
        return Err(Failure::misuse(
            "--light ao is a share, not light: add --as occlusion or --as plain",
        ));
    }
    if !is_occlusion && convention == ConventionArg::Occlusion {
        return Err(Failure::misuse("--as occlusion is for --light ao"));
    }
    if !is_occlusion && args.texels.ao_distance.is_some() {
        return Err(Failure::misuse("--ao-distance is for --light ao"));
    }
    if is_occlusion && args.texels.follows_light() {
        return Err(Failure::misuse(
            "--density auto follows the edges of shadows, which --light ao has none of",
        ));
    }
    if is_occlusion && args.is_page() {
        return Err(Failure::misuse(
            "--light ao: a page shows light, of which this is none",
        ));
    }
    let pass = &args.first_pass;
    let is_gathered = pass.rays.is_some() && pass.error.is_none() && pass.limit().is_none();
    if args.texels.denoise && (!is_gathered || args.texels.light == LightArg::Direct) {
        return Err(Failure::misuse(
            "--denoise is for --rays without --error and --time: only then each texel is gathered by itself, and has \
             noise of its own; otherwise light is interpolated between texels, and direct light follows the error",
        ));
    }
    if files.directional.is_some() && !(args.has_place_for_directions()) {
        return Err(Failure::misuse(
            "--directional is for --as moz, and for --lightmap with --as plain: other conventions, pages and --light ao have \
             no place for directions",
        ));
    }
    let is_node = matches!(files.instances, InstancesArg::Node);
    if is_node && convention != ConventionArg::Mx {
        return Err(Failure::misuse(
            "--instances node: only MX_lightmap has offsets at nodes: --as mx",
        ));
    }
    let shows_radiance = matches!(convention, ConventionArg::Emissive | ConventionArg::Unlit);
    if files.conventions.iter().any(|c| *c != convention) {
        return Err(Failure::misuse(
            "--as: one convention at a time: viewers that know both would add up their light",
        ));
    }
    if files.exposure.is_some() && !shows_radiance {
        return Err(Failure::misuse(
            "--exposure is for --as unlit and --as emissive: other lightmaps have a scale of their own",
        ));
    }
    if (shows_radiance || is_occlusion) && files.image != ImageArg::Png {
        return Err(Failure::misuse(
            "--as unlit, emissive and occlusion are for viewers that know only PNG: --image png",
        ));
    }
    Ok(())
}

/// Removes a lightmap.
fn strip(args: &BakeArgs, session: &mut Session) -> Result<Report, Failure> {
    let ([input], Some(path)) = (&args.input.scenes[..], &args.output) else {
        return Err(Failure::misuse("--strip takes one file, and -o OUT"));
    };
    let output = Output::check(path)?;
    session.claim_stdout(output.is_stdout())?;
    let stripped = source::stripped(input, session.progress())?;
    // The file comes back in the container in which it was written last, and its name has to fit that.
    let is_glb = stripped.bytes.starts_with(b"glTF");
    let (kind, other) = if is_glb {
        ("glb", "gltf")
    } else {
        ("gltf", "glb")
    };
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(other))
    {
        return Err(Failure::misuse(format_args!(
            "{}: without its lightmap the file is a .{kind}",
            path.display()
        )));
    }
    // A file that another program or version has written since cannot be restored exactly.
    stripped.notes.iter().for_each(|note| session.note(note));
    if !stripped.is_exact {
        session.note("the file is not what it was before");
    }
    output.write(session.progress(), |out| out.write_all(&stripped.bytes))?;
    let mut report = Report::default();
    let size = words::bytes(stripped.bytes.len() as u64);
    let shown = output.path().display().to_string();
    report.fact("output", shown.clone(), "wrote", format!("{shown}, {size}"));
    report.value("exact", stripped.is_exact);
    // Files that only the lightmap used stay on the disk, and are named for the user to remove.
    if !stripped.unused_files.is_empty() {
        let names = stripped.unused_files.join(", ");
        report.fact(
            "unused_files",
            stripped.unused_files,
            "no longer used",
            names,
        );
    }
    Ok(report)
}
