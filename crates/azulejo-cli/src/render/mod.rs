//! `render`: the second pass, or the path tracer that serves as its reference.

pub mod args;
mod cost;
mod layers;
mod rtrace;
mod views;

use crate::failure::Failure;
use crate::report::{Report, bytes, count, number, percent, short};
use crate::session::Session;
use crate::{input, pass, values};
use args::{ImageArgs, RenderArgs, RenderStyle, ToneName};
use azulejo::output::Output;
use azulejo::surroundings::is_studio_part;
use azulejo_formats::picture::{exr, hdr, png};
use azulejo_render::{MeasuredImage, PictureLayers, ReferencePass, SecondPass, Tone};
use azulejo_scene::{Image, Object, Scene};
use azulejo_trace::Tracer;
use std::path::Path;
use views::PictureView;

/// File formats of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ImageFormat {
    Png,
    Exr,
    Hdr,
}

/// [`SecondPass::evenness`] of a model in a studio, which is so much larger that few patches are left for the model.
const EVENNESS_IN_STUDIOS: f64 = 0.2;

/// Bytes that a pixel takes while it is computed, with its layers: measured.
const PIXEL_BYTES: u64 = 200;

/// What to say of a picture that takes more than half of so much memory.
///
/// # Errors
/// It takes more than all of it.
fn memory_of((width, height): (u32, u32), memory: Option<u64>) -> Result<Option<String>, Failure> {
    let needed = u64::from(width) * u64::from(height) * PIXEL_BYTES;
    let Some(memory) = memory.filter(|memory| needed > memory / 2) else {
        return Ok(None);
    };
    let words = format!(
        "a picture of {width}x{height} pixels takes about {} of memory, of the machine's {}",
        bytes(needed),
        bytes(memory)
    );
    if needed > memory {
        return Err(Failure::failed(format_args!(
            "{words}: ask for a smaller one"
        )));
    }
    Ok(Some(words))
}

/// Runs `render`.
pub fn run(args: &RenderArgs, session: &mut Session) -> Result<Report, Failure> {
    // Refuse formats and outputs that do not fit before anything is read.
    let format = format_of(&args.output)?;
    check_layers(args, format)?;
    rtrace::check(args)?;
    let output = Output::check(&args.output)?;
    let errors = args.picture.error_image.as_deref().map(errors_of);
    let errors = errors.transpose()?;
    session.claim_stdout(output.is_stdout())?;
    session.set_makes_image();
    let instant = args.first_pass.instant();
    // A reference computes the light of lamps anew, so it takes the place of lightmaps.
    let mut scene = if args.picture.reference {
        input::read_relit(&args.input, instant, session)?
    } else {
        input::read_lit(&args.input, instant, session)?
    };
    let mut report = Report::default();
    // The look of RTRACE has lights and a view of its own, and needs no first pass.
    if args.look.look == RenderStyle::Rtrace {
        let image = rtrace::draw(&scene, args, session)?;
        let target = (&output, args.output.as_path());
        write_rtrace(&image, format, target, session, &mut report)?;
        return Ok(report);
    }
    let (views, size) = views::choose(args, &scene)?;
    if let Some(words) = memory_of(size, session.memory())? {
        session.note(&words);
    }
    // Path tracing takes the place of both passes in each view.
    if args.picture.reference {
        let tracer = args.first_pass.engine.prepare()?.tracer(&scene)?;
        for view in &views {
            let lit = (&scene, &tracer);
            let measured = reference(
                lit,
                args,
                (view, size),
                errors.as_ref(),
                session,
                &mut report,
            )?;
            deliver(&measured, lit, (view, format), args, session, &mut report)?;
        }
        return Ok(report);
    }
    // The first pass is common to all views; only the second is repeated for each.
    let tracer = lit(&mut scene, args, session, &mut report)?;
    let mut options = options(&args.picture, args.first_pass.seed, size);
    if scene.objects.iter().any(|o| is_studio_part(&o.name)) {
        options.evenness = EVENNESS_IN_STUDIOS;
    }
    for view in &views {
        let shown = (&scene, &tracer, &view.camera);
        let measured = cost::render(&args.picture, &options, shown, session, &mut report)?;
        let lit = (&scene, &tracer);
        deliver(&measured, lit, (view, format), args, session, &mut report)?;
    }
    Ok(report)
}

/// Default samples per pixel: enough for an image, and for a reference with a known error.
const SAMPLES: u32 = 16;
const REFERENCE_SAMPLES: u32 = 256;

/// Renders a view by path tracing, and writes its error image if requested.
fn reference(
    (scene, tracer): (&Scene, &Tracer),
    args: &RenderArgs,
    (view, size): (&PictureView, (u32, u32)),
    errors: Option<&(Output, ImageFormat)>,
    session: &Session,
    report: &mut Report,
) -> Result<MeasuredImage, Failure> {
    let options = ReferencePass {
        size,
        samples_per_pixel: args.picture.spp.unwrap_or(REFERENCE_SAMPLES),
        seed: args.first_pass.seed,
        clamp: args.picture.clamp,
        ..ReferencePass::default()
    };
    let measured = session.with_progress(|progress| {
        azulejo_render::reference(scene, tracer, &view.camera, &options, progress)
    })?;
    let error = measured.relative_error();
    let words = format!(
        "{} relative RMSE, estimated from the pixels' standard errors",
        percent(error)
    );
    report.fact("error", number(error), "error", words);
    if let Some((output, format)) = errors {
        write_linear(&measured.error, *format, output, session)?;
    }
    Ok(measured)
}

/// Layers need a format that has them, and a filter samples.
fn check_layers(args: &RenderArgs, format: ImageFormat) -> Result<(), Failure> {
    if args.picture.denoise && args.picture.spp.is_some_and(|spp| spp < LEAST_DENOISED) {
        return Err(Failure::misuse(format_args!(
            "--denoise needs standard errors: at least --spp {LEAST_DENOISED}"
        )));
    }
    if args.picture.layers.is_none() || format == ImageFormat::Exr {
        return Ok(());
    }
    Err(Failure::misuse(format_args!(
        "{}: --layers needs a format that holds layers: choose a name that ends in .exr",
        args.output.display()
    )))
}

/// Writes the image of a view, with its layers if they are requested.
fn deliver(
    measured: &MeasuredImage,
    (scene, tracer): (&Scene, &Tracer),
    (view, format): (&PictureView, ImageFormat),
    args: &RenderArgs,
    session: &mut Session,
    report: &mut Report,
) -> Result<(), Failure> {
    state_clamp(measured, args, report);
    say_dark(&measured.image, tracer, view, session);
    let picture = &args.picture;
    let exposed = |image: &Image| {
        azulejo_render::auto_exposure_of_surfaces(image, scene, tracer, &view.camera)
    };
    let target = (view, format, &exposed as AutoExposure);
    if picture.layers.is_none() && !picture.denoise {
        return write(&measured.image, target, args, session, report);
    }
    let size = (measured.image.width, measured.image.height);
    let samples = picture.spp.unwrap_or(SAMPLES);
    let seen = session.with_progress(|progress| {
        azulejo_render::picture_layers(scene, tracer, &view.camera, size, samples, progress)
    })?;
    let filtered = if picture.denoise {
        Some(denoised(measured, &seen, session, report)?)
    } else {
        None
    };
    let image = filtered.as_ref().unwrap_or(&measured.image);
    let Some(names) = &picture.layers else {
        return write(image, target, args, session, report);
    };
    refuse_overflow(image)?;
    let channels = layers::channels(image, measured, &seen, names);
    let comments = layers::comments(measured, picture.clamp.is_some());
    view.output.write(session.progress(), |out| {
        exr::write_channels(size, channels, &comments, out)
    })?;
    let names = layers::chosen(names).len();
    report.fact("layers", names, "layers", count(names));
    state_output(size, &view.path, report);
    Ok(())
}

/// Fewest samples per pixel for a filter: each half of them needs two.
const LEAST_DENOISED: u32 = 4;

/// The image without most of its noise; states what was done.
fn denoised(
    measured: &MeasuredImage,
    seen: &PictureLayers,
    session: &Session,
    report: &mut Report,
) -> Result<Image, Failure> {
    let filtered =
        session.with_progress(|progress| azulejo_render::denoise(measured, seen, progress))?;
    let [change, bias] = [filtered.change, filtered.bias];
    let [before, after] = [filtered.error_before, filtered.error_after];
    let words = format!(
        "{} relative RMSE, about {} before; pixels changed by {}, the mean by {}",
        percent(after),
        percent(before),
        percent(change),
        percent(bias)
    );
    report.fact("denoised_error", number(after), "denoised", words);
    report.value("denoised_error_before", number(before));
    report.value("denoised_change", number(change));
    report.value("denoised_bias", number(bias));
    Ok(filtered.image)
}

/// Share of black pixels among those of surfaces from which a picture is said to be black.
const BLACK: f64 = 0.95;

/// Says why a picture shows nothing.
fn say_dark(image: &Image, tracer: &Tracer, view: &PictureView, session: &mut Session) {
    match azulejo_render::black_share_of_surfaces(image, tracer, &view.camera) {
        None => session.note("no surface is in view: --from, --at, --fov and --camera choose the view"),
        Some(share) if share >= BLACK => session.note(&format!(
            "no light reaches {} of what is in view: lamps may be inside of a closed model, or a wall between; \
             --from and --at look from elsewhere, --sky 1 adds light from outside",
            percent(share)
        )),
        Some(_) => {}
    }
}

/// States how much light a clamp removed, which is its bias.
fn state_clamp(measured: &MeasuredImage, args: &RenderArgs, report: &mut Report) {
    if args.picture.clamp.is_some() {
        let removed = measured.removed;
        let words = format!("{} of the light in the image removed", percent(removed));
        report.fact("clamped", number(removed), "clamped", words);
    }
}

/// The output and format of an error image; a PNG could not hold its values.
fn errors_of(path: &Path) -> Result<(Output, ImageFormat), Failure> {
    match format_of(path)? {
        ImageFormat::Png => Err(Failure::misuse(format_args!(
            "{}: an error image needs a format of linear values, expected .exr or .hdr",
            path.display()
        ))),
        format => Ok((Output::check(path)?, format)),
    }
}

/// Solves the scene unless it is solved, and returns its tracer.
fn lit(
    scene: &mut Scene,
    args: &RenderArgs,
    session: &mut Session,
    report: &mut Report,
) -> Result<Tracer, Failure> {
    let prepared = args.first_pass.engine.prepare()?;
    let solved = scene.is_solved();
    report.value("solved_before", solved);
    if solved {
        say_unmapped(scene, session);
        return prepared.tracer(scene);
    }
    let tracer = prepared.tracer(scene)?;
    let first = pass::options(&args.first_pass, &prepared, session);
    let first = cost::first_pass(&args.first_pass, first);
    let light = pass::solve_with(scene, &tracer, &args.first_pass, &first, session)?;
    pass::describe(&light.report, &args.first_pass, &prepared, scene, report)?;
    cost::describe_first_pass(&args.first_pass, &light.report, report);
    scene.set_irradiance(light.irradiance);
    // The subdivided mesh has other faces than the one of the first tracer.
    prepared.tracer(scene)
}

/// Says that objects without a lightmap get their light from those with one.
fn say_unmapped(scene: &Scene, session: &mut Session) {
    let reflects = |o: &Object| {
        let mut materials = o.shape.mesh().into_iter().flat_map(|m| &m.face_materials);
        materials.any(|&m| !scene.materials[m as usize].diffuse.is_black())
    };
    let unlit = |o: &&Object| {
        let placed = o.shape.placed_mesh();
        let on_vertices = placed.is_some_and(|m| !m.irradiance.is_empty());
        reflects(o) && !on_vertices && !scene.is_lightmapped(&o.shape)
    };
    if scene.has_lightmap() {
        let count = scene.objects.iter().filter(unlit).count();
        if count > 0 {
            session.note(&format!(
                "{count} objects have no lightmap: they show the light of lamps, and of the surfaces that \
                 have one"
            ));
        }
    }
}

fn format_of(path: &Path) -> Result<ImageFormat, Failure> {
    if path == Path::new("-") {
        return Ok(ImageFormat::Png);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match extension.to_ascii_lowercase().as_str() {
        "png" => Ok(ImageFormat::Png),
        "exr" => Ok(ImageFormat::Exr),
        "hdr" => Ok(ImageFormat::Hdr),
        _ => Err(Failure::misuse(format_args!(
            "{}: unknown image format, expected .png, .exr or .hdr",
            path.display()
        ))),
    }
}

fn options(picture: &ImageArgs, seed: u64, size: (u32, u32)) -> SecondPass {
    SecondPass {
        size,
        samples_per_pixel: picture.spp.unwrap_or(SAMPLES),
        gather: picture.gather.unwrap_or(values::DEFAULT_GATHER),
        seed,
        clamp: picture.clamp,
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

/// Rejects an image with values that its numbers of 32 bits cannot hold, which no program would show.
fn refuse_overflow(image: &Image) -> Result<(), Failure> {
    let is_lost = |pixel: &&[f32; 3]| !pixel.iter().all(|value| value.is_finite());
    match image.pixels.iter().filter(is_lost).count() {
        0 => Ok(()),
        lost => Err(Failure::failed(format_args!(
            "{} of the image's {} pixels are not finite: lights too bright for numbers of 32 bits",
            count(lost),
            count(image.pixels.len())
        ))),
    }
}

/// Writes an image of linear values.
fn write_linear(
    image: &Image,
    format: ImageFormat,
    output: &Output,
    session: &Session,
) -> Result<(), Failure> {
    output.write(session.progress(), |out| match format {
        ImageFormat::Hdr => hdr::write(image, out),
        _ => exr::write(image, out),
    })?;
    Ok(())
}

/// Writes a picture as RTRACE shades it.
fn write_rtrace(
    image: &Image,
    format: ImageFormat,
    (output, path): (&Output, &Path),
    session: &Session,
    report: &mut Report,
) -> Result<(), Failure> {
    refuse_overflow(image)?;
    match format {
        ImageFormat::Exr | ImageFormat::Hdr => write_linear(image, format, output, session)?,
        ImageFormat::Png => {
            let pixels = azulejo_render::rtrace::bytes(image);
            output.write(session.progress(), |out| {
                png::write(image.width, image.height, &pixels, out)
            })?;
        }
    }
    state_output((image.width, image.height), path, report);
    Ok(())
}

/// The exposure that suits an image of a view.
type AutoExposure<'a> = &'a dyn Fn(&Image) -> f64;

fn write(
    image: &Image,
    (view, format, exposed): (&PictureView, ImageFormat, AutoExposure),
    args: &RenderArgs,
    session: &Session,
    report: &mut Report,
) -> Result<(), Failure> {
    let (progress, output) = (session.progress(), &view.output);
    refuse_overflow(image)?;
    match format {
        ImageFormat::Exr | ImageFormat::Hdr => write_linear(image, format, output, session)?,
        ImageFormat::Png => {
            let factor = match args.picture.exposure {
                Some(stops) => stops.exp2(),
                None => exposed(image),
            };
            let stops = factor.log2();
            let words = match args.picture.exposure {
                Some(_) => format!("{} stops", short(stops)),
                None => format!("{} stops, automatic", short(stops)),
            };
            report.fact("exposure", number(stops), "exposure", words);
            let pixels = azulejo_render::tone_map(image, factor, tone(args.picture.tone));
            output.write(progress, |out| {
                png::write(image.width, image.height, &pixels, out)
            })?;
        }
    }
    state_output((image.width, image.height), &view.path, report);
    Ok(())
}

/// States the file and its size.
fn state_output((width, height): (u32, u32), path: &Path, report: &mut Report) {
    report.value("width", width);
    report.value("height", height);
    let path = path.display().to_string();
    let words = format!("{path}, {width} x {height} pixels");
    report.fact("output", path, "wrote", words);
}

#[cfg(test)]
mod tests {
    use super::memory_of;

    #[test]
    fn large_pictures_are_refused_before_they_fill_the_memory() {
        let machine = Some(8 << 30);
        let words = |size| memory_of(size, machine).map_err(|e| format!("{e:?}"));
        assert_eq!(words((1920, 1080)), Ok(None));
        let large = words((6000, 6000)).unwrap();
        assert!(large.is_some_and(|words| words.contains("6.7")));
        let refused = words((8192, 8192)).unwrap_err();
        assert!(
            refused.contains("12.5 GiB") && refused.contains("8 GiB"),
            "{refused}"
        );
        assert!(memory_of((16_384, 16_384), None).is_ok_and(|words| words.is_none()));
    }
}
