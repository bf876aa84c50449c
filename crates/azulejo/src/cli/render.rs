//! `render`: the second pass, from scene to picture.

use super::args::{LookName, Picture, RenderArgs, ToneName};
use super::failure::Failure;
use super::output::Output;
use super::report::{Report, number, short};
use super::session::Session;
use super::{input, look, pass, view};
use azulejo_formats::{exr, hdr, png};
use azulejo_render::{SecondPass, Tone};
use azulejo_scene::{Image, Scene};
use azulejo_trace::Tracer;
use std::path::Path;

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
    Hdr,
}

/// Runs `render`.
pub fn run(args: &RenderArgs, session: &mut Session) -> Result<Report, Failure> {
    let format = format_of(&args.output)?;
    look::check(args)?;
    let output = Output::check(&args.output)?;
    session.claim_stdout(output.is_stdout())?;
    session.set_makes_picture();
    let mut scene = input::read_all(&args.input, session)?;
    let mut report = Report::default();
    let image = match args.look.look {
        LookName::Physical => physical(&mut scene, args, session, &mut report)?,
        LookName::Rtrace => look::draw(&scene, args, session)?,
    };
    write(&image, format, args, &output, session, &mut report)?;
    let (width, height) = (image.width, image.height);
    report.value("width", width);
    report.value("height", height);
    let path = args.output.display().to_string();
    let words = format!("{path}, {width} x {height} pixels");
    report.fact("output", path, "wrote", words);
    Ok(report)
}

/// Solves the scene if it carries no light yet, and draws it.
fn physical(
    scene: &mut Scene,
    args: &RenderArgs,
    session: &Session,
    report: &mut Report,
) -> Result<Image, Failure> {
    let (camera, size) = view::choose(&args.view, args.picture.size, scene, args.input.reading.up)?;
    let tracer = lit(scene, args, session, report)?;
    let options = options(&args.picture, args.first_pass.seed, size);
    let image = session
        .watched(|progress| azulejo_render::render(scene, &tracer, &camera, &options, progress))?;
    Ok(image)
}

/// Makes sure that the scene carries light, and prepares it for tracing.
fn lit(
    scene: &mut Scene,
    args: &RenderArgs,
    session: &Session,
    report: &mut Report,
) -> Result<Tracer, Failure> {
    let chosen = args.first_pass.engine.choose()?;
    let solved = scene.is_solved();
    report.value("solved_before", solved);
    if solved {
        return chosen.tracer(scene);
    }
    let tracer = chosen.tracer(scene)?;
    let light = pass::solve(scene, &tracer, &args.first_pass, &chosen, session)?;
    pass::describe(&light.report, &chosen, scene.units, report);
    scene.set_irradiance(light.irradiance);
    // The refined mesh has other faces than the one that was traced so far.
    chosen.tracer(scene)
}

fn format_of(path: &Path) -> Result<Format, Failure> {
    if path == Path::new("-") {
        return Ok(Format::Png);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match extension.to_ascii_lowercase().as_str() {
        "png" => Ok(Format::Png),
        "exr" => Ok(Format::Exr),
        "hdr" => Ok(Format::Hdr),
        _ => Err(Failure::misuse(format_args!(
            "{}: unknown kind of picture, expected .png, .exr or .hdr",
            path.display()
        ))),
    }
}

fn options(picture: &Picture, seed: u64, size: (u32, u32)) -> SecondPass {
    SecondPass {
        size,
        samples_per_pixel: picture.spp,
        gather: picture.gather,
        seed,
        ..SecondPass::default()
    }
}

fn tone(name: ToneName) -> Tone {
    match name {
        ToneName::Linear => Tone::Linear,
        ToneName::Reinhard => Tone::Reinhard,
        ToneName::Filmic => Tone::Filmic,
    }
}

fn write(
    image: &Image,
    format: Format,
    args: &RenderArgs,
    output: &Output,
    session: &Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let progress = session.progress();
    match format {
        Format::Exr => output.write(progress, |out| exr::write(image, out)),
        Format::Hdr => output.write(progress, |out| hdr::write(image, out)),
        Format::Png if args.look.look == LookName::Rtrace => {
            let pixels = azulejo_render::rtrace::bytes(image);
            output.write(progress, |out| {
                png::write(image.width, image.height, &pixels, out)
            })
        }
        Format::Png => {
            let factor = match args.picture.exposure {
                Some(stops) => stops.exp2(),
                None => azulejo_render::auto_exposure(image),
            };
            let stops = factor.log2();
            let words = match args.picture.exposure {
                Some(_) => format!("{} stops", short(stops)),
                None => format!("{} stops, chosen from the picture", short(stops)),
            };
            report.fact("exposure", number(stops), "exposure", words);
            let pixels = azulejo_render::tone_map(image, factor, tone(args.picture.tone));
            output.write(progress, |out| {
                png::write(image.width, image.height, &pixels, out)
            })
        }
    }
}
