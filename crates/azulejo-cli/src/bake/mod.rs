//! `bake`: the third pass, from a scene to a lightmap in a glTF file or a page.

pub mod args;
mod check;
mod coordinates;
mod page;
mod pictures;
mod report;
mod source;
mod verdict;
mod written;

use crate::failure::Failure;
use crate::report::Report;
use crate::session::Session;
use crate::{pass, report as words};
use args::{BakeArgs, ConventionArg, DoubleSidedArg, ImageArg, InstancesArg, LightArg, TexelArgs};
use azulejo::bake::{Resolution, UnwrapOptions};
use azulejo::lightmap::{BakeError, BakeOptions, Baked, BakedSides, bake, bake_occlusion};
use azulejo::output::Output;
use azulejo::surroundings::STUDIO_FLOOR;
use azulejo_scene::Scene;
use source::BakeSource;
pub use source::read_file;
use written::BakeOutputs;

/// Size of pages where none is given, and where the density is.
const SIZE: u32 = 1024;
const MOST_SIZE: u32 = 8192;

/// Distance up to which things occlude, as a share of the size of the model.
const OCCLUSION_DISTANCE: f64 = 0.1;

/// Texels per length of the floor of a studio, relative to those of the model: it is far larger.
const STUDIO_DENSITY: f64 = 0.25;

/// Error beside the requested one up to which that counts as reached.
const TOLERATED: f64 = 1.2;

/// Runs `bake --check`: the report, and whether all is well.
pub use check::run as check;

/// Runs `bake`.
pub fn run(args: &BakeArgs, session: &mut Session) -> Result<Report, Failure> {
    if args.strip {
        return strip(args, session);
    }
    refuse_misplaced(args)?;
    let outputs = BakeOutputs::check(args)?;
    session.claim_stdout(outputs.is_stdout())?;
    let prepared = args.first_pass.engine.prepare()?;
    let mut source = source::read(args, session)?;
    if source.receivers.is_empty() {
        return Err(Failure::failed(
            "there is no surface that could receive a lightmap: what is animated, skinned, morphed or instanced by \
             EXT_mesh_gpu_instancing does not, nor do points and lines",
        ));
    }
    let tracer = prepared.tracer(&source.scene)?;
    let charts = charts(&args.texels, &source.scene);
    let chosen = coordinates::choose(args, &source, &charts, session)?;
    let options = BakeOptions {
        charts,
        coordinates: chosen.coordinates,
        densities: densities(&args.texels, &source, session),
        follows_light: args.texels.follows_light(),
        pass: pass::options(&args.first_pass, &prepared, session),
        light: args.texels.light.baked().unwrap_or_default(),
        sides: sides(args, &source),
    };
    session.limit_time(args.first_pass.limit());
    let baked = pass::with_forecast(&args.first_pass, session, |progress| {
        let BakeSource {
            scene, receivers, ..
        } = &source;
        match args.texels.light.baked() {
            Some(_) => bake(scene, &tracer, receivers, &options, progress),
            None => {
                let distance = occlusion_distance(&args.texels, scene);
                bake_occlusion(scene, &tracer, receivers, &options, distance, progress)
            }
        }
    });
    let mut baked = baked.map_err(|error| match error {
        BakeError::Solve(error) => pass::failure(error),
        BakeError::Layout(error) => Failure::failed(error),
        other => Failure::failed(other),
    })?;
    source.turn_to_light(&mut baked).map_err(Failure::failed)?;
    let mut summary = Report::default();
    report::describe(&baked, &args.first_pass, &source.scene, &mut summary)?;
    say_unreached(&baked, args, session);
    if options.follows_light && !baked.follows_light {
        session.note(
            "--density auto: texel density stays uniform, because packing charts of different densities would cost more \
             texels than sharper shadows gain",
        );
    }
    let places = (chosen.uvs, options.charts.padding);
    outputs.write(args, &source, &baked, places, session, &mut summary)?;
    Ok(summary)
}

/// Says that the requested error is not reached, and what would.
fn say_unreached(baked: &Baked, args: &BakeArgs, session: &mut Session) {
    let error = baked.lightmap.relative_error();
    let Some(asked) = args
        .first_pass
        .error
        .filter(|asked| error > TOLERATED * asked)
    else {
        return;
    };
    let between = baked.between_texels / baked.lightmap.mean().mean();
    let why = if session.progress().out_of_time() {
        "there was no time for more".to_owned()
    } else if between > asked {
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
        words::percent(asked)
    ));
}

/// Options of the first pass that mean nothing here.
fn refuse_misplaced(args: &BakeArgs) -> Result<(), Failure> {
    let given = [
        (args.first_pass.keep_mesh, "--keep-mesh"),
        (args.first_pass.sides.is_some(), "--sides"),
        (args.first_pass.no_interpolation, "--no-interpolation"),
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
            "--light ao is no light: --as occlusion or --as plain",
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

/// How near things count as occluding, scene units.
fn occlusion_distance(args: &TexelArgs, scene: &Scene) -> f64 {
    let usual = || OCCLUSION_DISTANCE * scene.bounds().diagonal();
    args.ao_distance
        .map_or_else(usual, |metres| metres / scene.units.metres())
}

fn charts(args: &TexelArgs, scene: &Scene) -> UnwrapOptions {
    let resolution = match (args.texels_per_metre, args.count) {
        (Some(density), _) => Resolution::PerUnit(density * scene.units.metres()),
        (None, Some(texels)) => Resolution::Texels(texels),
        (None, None) => Resolution::Fill,
    };
    let size = match resolution {
        Resolution::Fill => SIZE,
        _ => MOST_SIZE,
    };
    UnwrapOptions {
        resolution,
        size: args.size.unwrap_or(size),
        pages: args.pages,
        padding: args.padding.max(1 << args.mips),
        blocks: args.blocks,
        crease: args.crease,
    }
}

/// How dense the texels of each receiver are, relative to others; empty if all are alike.
fn densities(args: &TexelArgs, source: &BakeSource, session: &mut Session) -> Vec<f64> {
    let studio = |r: &u32| match source.scene.objects[*r as usize].name.as_str() {
        STUDIO_FLOOR => STUDIO_DENSITY,
        _ => 1.0,
    };
    if args.object_densities().next().is_none() {
        let factors: Vec<f64> = source.receivers.iter().map(studio).collect();
        return if factors.iter().all(|f| *f == 1.0) {
            Vec::new()
        } else {
            factors
        };
    }
    let name = |&r: &u32| source.scene.objects[r as usize].name.as_str();
    for given in args.object_densities() {
        if !source
            .receivers
            .iter()
            .any(|r| given.names.is_match(name(r)))
        {
            session.note(&format!(
                "--density {}: no object has such a name",
                given.text
            ));
        }
    }
    let factor = |r: &u32| {
        let mut fits = args.object_densities().rev();
        fits.find(|given| given.names.is_match(name(r)))
            .map_or_else(|| studio(r), |given| given.factor)
    };
    source.receivers.iter().map(factor).collect()
}

/// The side that receives: glTF says which side is the front, other formats often do not.
fn sides(args: &BakeArgs, source: &BakeSource) -> BakedSides {
    let usual = if source.is_given {
        BakedSides::Front
    } else {
        BakedSides::Brighter
    };
    args.texels
        .double_sided
        .map_or(usual, DoubleSidedArg::baked)
}

/// Removes a lightmap.
fn strip(args: &BakeArgs, session: &mut Session) -> Result<Report, Failure> {
    let ([input], Some(path)) = (&args.input.scenes[..], &args.output) else {
        return Err(Failure::misuse("--strip takes one file, and -o OUT"));
    };
    let output = Output::check(path)?;
    session.claim_stdout(output.is_stdout())?;
    let stripped = source::stripped(input, session.progress())?;
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
    stripped.notes.iter().for_each(|note| session.note(note));
    if !stripped.is_exact {
        session.note("another program has written the file since: it is not what it was before");
    }
    output.write(session.progress(), |out| out.write_all(&stripped.bytes))?;
    let mut report = Report::default();
    let size = words::bytes(stripped.bytes.len() as u64);
    let shown = output.path().display().to_string();
    report.fact("output", shown.clone(), "wrote", format!("{shown}, {size}"));
    report.value("exact", stripped.is_exact);
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
