//! `probe`: irradiance at points, and radiance or hits along rays.

mod grid;
mod year;

use super::clock::Clock;
use super::engine::PreparedEngine;
use super::failure::Failure;
use super::first_pass::FirstPassArgs;
use super::input::InputArgs;
use super::parts::PartArgs;
use super::report::{Report, count, number, seconds, short};
use super::runner::{Completion, DividedWork, Runner, Sharing};
use super::session::Session;
use super::{input, pass, points, runner};
use azulejo::output::Output;
use azulejo_render::SecondPass;
use azulejo_scene::Scene;
use azulejo_scene::math::{Aabb, Ray};
use azulejo_trace::{Cancelled, KernelHit, Progress, Tracer};
use clap::{Args, ValueHint};
use rayon::prelude::*;
use std::path::Path;
use std::path::PathBuf;

/// `probe`
#[derive(Debug, Args)]
pub struct ProbeArgs {
    #[command(flatten)]
    pub probes: ProbeSources,
    /// Normals of the points: .npy (n x 3)
    #[arg(long, value_name = "FILE", requires = "points", value_hint = ValueHint::FilePath)]
    pub normals: Option<PathBuf>,
    /// Output file: .npy (f64), or text with any other extension; `-` writes text to standard
    /// output [default: `-`, or none with --json]; with --year .csv or .npz, with --grid .json, .npz or .ktx2
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub output: Option<PathBuf>,
    /// Sun and sky of all hours of --weather, at --points: the sum of the year as .csv, or the hours, too, as .npz
    ///
    /// In kWh/m² of solar radiation and W/m², or in klx·h and lx in photometric scenes without --solar. Other lights
    /// do not count.
    #[arg(long, requires_all = ["points", "weather"],
          conflicts_with_all = ["time", "sun", "environment", "studio", "lights", "bounces", "error",
                                "error_each"])]
    pub year: bool,
    /// The box that --grid divides into cells, a probe in the middle of each, in scene units [default: that of the
    /// scene]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = grid::bounds,
          allow_hyphen_values = true)]
    pub grid_box: Option<Aabb>,
    #[command(flatten)]
    pub part: PartArgs,
    #[command(flatten)]
    pub first_pass: FirstPassArgs,
    #[command(flatten)]
    pub input: InputArgs,
}

/// The quantity to measure.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub struct ProbeSources {
    /// Irradiance at points: text (x y z nx ny nz per line), or .npy (n x 3, with --normals;
    /// or n x 6)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub points: Option<PathBuf>,
    /// Radiance along rays: 8 little-endian f32 per ray (origin, tmin, direction, tmax)
    #[arg(long, value_name = "RAYS", value_hint = ValueHint::FilePath)]
    pub radiance: Option<PathBuf>,
    /// Light around the points of a grid, as spherical harmonics of bands 0 to 2, for things that move through the
    /// scene: .json, .npz, or .ktx2, an irradiance volume of Bevy
    #[arg(long, value_name = "NX,NY,NZ", value_parser = grid::resolution, requires = "output")]
    pub grid: Option<[u32; 3]>,
    /// What rays hit: t, object, triangle, u, v; a miss is inf, -1, -1, 0, 0
    #[arg(long, value_name = "RAYS", value_hint = ValueHint::FilePath)]
    pub hits: Option<PathBuf>,
}

/// Examples below the help.
pub const EXAMPLES: &str = "\
Examples:
  azulejo probe room.obj --points desk.txt -o lux.txt --error 2%
  azulejo probe room.obj --points p.npy --normals n.npy -o e.npy --time 10s
  azulejo probe room.obj --hits rays.f32 -o hits.npy --json
  azulejo probe room.glb --grid 16,8,16 -o volume.json --error 2%
  azulejo probe room.obj --points roof.txt --weather munich.epw --year -o year.npz

Each point gives six numbers: the irradiance in red, green and blue, and its standard error.
Irradiance is in W/m² if emission is in W/(sr·m²).";

/// Columns of an irradiance: E and its standard error.
const IRRADIANCE: usize = 6;
/// Columns of a radiance.
const RADIANCE: usize = 3;
/// Columns of a hit: t, object, triangle, u, v.
const HIT: usize = 5;
/// Rays between two polls of the progress.
const BATCH: usize = 4096;

/// Rows of numbers to be written.
struct ProbeResults {
    columns: usize,
    values: Vec<f64>,
}

impl ProbeResults {
    /// Rows of light; an error for numbers that are beyond all numbers.
    fn from_light(columns: usize, values: Vec<f64>) -> Result<ProbeResults, Failure> {
        match values.iter().filter(|v| v.is_infinite()).count() {
            0 => Ok(ProbeResults { columns, values }),
            lost => Err(Failure::failed(format_args!(
                "{} of {} results are not finite: the lights are too bright",
                count(lost),
                count(values.len())
            ))),
        }
    }
}

/// Measures at all points or rays, or a part of the points, and writes it.
pub fn run(args: &ProbeArgs, runner: Runner, session: &mut Session) -> Result<Report, Failure> {
    if let (true, Some(points)) = (args.year, &args.probes.points) {
        return year::run(args, points, &runner, session);
    }
    if let Some(resolution) = args.probes.grid {
        return grid::run(args, resolution, &runner, session);
    }
    if args.grid_box.is_some() {
        return Err(Failure::misuse("--grid-box is the box of --grid"));
    }
    refuse_indivisible(args, &runner)?;
    let default = (!session.json()).then_some(Path::new("-"));
    let output = args.output.as_deref().or(default);
    let output = output.filter(|_| runner.writes());
    let output = output.map(Output::check).transpose()?;
    session.claim_stdout(output.as_ref().is_some_and(Output::is_stdout))?;
    let prepared = args.first_pass.engine.prepare()?;
    let probes = &args.probes;
    let instant = args.first_pass.instant();
    let mut scene = if probes.points.is_some() {
        input::read_relit(&args.input, instant, session)?
    } else {
        input::read_lit(&args.input, instant, session)?
    };
    runner.share_files(session)?;
    let mut report = Report::default();
    let mut rest = Completion::default();
    let rows = match (&probes.points, &probes.radiance, &probes.hits) {
        (Some(path), _, _) => {
            let file = output.as_ref().and_then(Output::file);
            let work = (args, &prepared, file);
            let part = irradiance(&scene, path, work, runner, session, &mut report)?;
            let Some((rows, completion)) = part else {
                return Ok(report);
            };
            rest = completion;
            rows
        }
        (_, Some(path), _) => radiance(&mut scene, path, args, &prepared, session, &mut report)?,
        (_, _, Some(path)) => hits(&scene, path, &prepared, session, &mut report)?,
        _ => return Err(Failure::misuse("nothing to probe")),
    };
    if let Some(output) = output {
        points::write_rows(&output, rows.columns, &rows.values, session.progress())?;
        report.value("output", output.path().display().to_string());
    }
    rest.finish(&mut report);
    Ok(report)
}

/// Refuses to share rays between processes, and work that depends on the time.
fn refuse_indivisible(args: &ProbeArgs, runner: &Runner) -> Result<(), Failure> {
    if let (Some(by), None) = (runner.shared_by(), &args.probes.points) {
        return Err(Failure::misuse(format_args!(
            "{by} divides --points; --radiance and --hits take a file of rays, which can be divided itself"
        )));
    }
    runner::refuse_indivisible(&args.first_pass, runner)
}

/// Prepares the scene for tracing and reports how long that took.
fn build(scene: &Scene, prepared: &PreparedEngine, report: &mut Report) -> Result<Tracer, Failure> {
    let clock = Clock::start();
    let tracer = prepared.tracer(scene)?;
    spent("building", "build", clock, report);
    Ok(tracer)
}

/// Adds wall-clock and CPU time of a part of the work.
fn spent(label: &str, key: &str, clock: Clock, report: &mut Report) {
    let (wall, cpu) = (clock.wall(), clock.cpu());
    let words = format!("{}, {} of CPU time", seconds(wall), seconds(cpu));
    report.line(label, words);
    report.value(&format!("{key}_seconds"), number(wall));
    report.value(&format!("{key}_cpu_seconds"), number(cpu));
}

/// Irradiance at the points of a file; `None` if another process makes the result.
fn irradiance(
    scene: &Scene,
    path: &Path,
    (args, prepared, output): (&ProbeArgs, &PreparedEngine, Option<&Path>),
    runner: Runner,
    session: &mut Session,
    report: &mut Report,
) -> Result<Option<(ProbeResults, Completion)>, Failure> {
    let points = points::read_points(path, args.normals.as_deref())?;
    let tracer = build(scene, prepared, report)?;
    let options = pass::options(&args.first_pass, prepared, session);
    let clock = Clock::start();
    let plan = DividedWork {
        key: &|| pass::work_key(scene, &tracer, &options, &points),
        sharing: Sharing::All,
        output,
    };
    let probed = runner.compute(&plan, session, report, |blocks, session| {
        let probed = pass::with_forecast(&args.first_pass, (blocks, session), |run| {
            azulejo_radiosity::probe(scene, &tracer, &points, &options, run)
        });
        pass::unless_elsewhere(probed)
    })?;
    let Some(probed) = probed else {
        return Ok(None);
    };
    spent("tracing", "trace", clock, report);
    let (value, rest) = (probed.value, probed.rest);
    pass::describe(&value.report, &args.first_pass, prepared, scene, report)?;
    let row = |e: &azulejo_radiosity::Estimate| [e.value.to_array(), e.error.to_array()].concat();
    let values = value.estimates.iter().flat_map(row).collect();
    Ok(Some((ProbeResults::from_light(IRRADIANCE, values)?, rest)))
}

fn radiance(
    scene: &mut Scene,
    path: &Path,
    args: &ProbeArgs,
    prepared: &PreparedEngine,
    session: &Session,
    report: &mut Report,
) -> Result<ProbeResults, Failure> {
    let rays = points::read_rays(path)?;
    if !scene.is_solved() {
        let tracer = prepared.tracer(scene)?;
        let light = pass::solve(scene, &tracer, &args.first_pass, prepared, session)?;
        pass::describe(&light.report, &args.first_pass, prepared, scene, report)?;
        scene.set_irradiance(light.irradiance);
    }
    let tracer = build(scene, prepared, report)?;
    let options = SecondPass {
        seed: args.first_pass.seed,
        ..SecondPass::default()
    };
    let clock = Clock::start();
    let radiances =
        session.with_progress(|p| azulejo_render::radiance(scene, &tracer, &rays, &options, p))?;
    spent("tracing", "trace", clock, report);
    report.fact("rays", rays.len(), "rays", count(rays.len()));
    ProbeResults::from_light(
        RADIANCE,
        radiances.iter().flat_map(|l| l.to_array()).collect(),
    )
}

fn hits(
    scene: &Scene,
    path: &Path,
    prepared: &PreparedEngine,
    session: &Session,
    report: &mut Report,
) -> Result<ProbeResults, Failure> {
    let rays = points::read_rays(path)?;
    let tracer = build(scene, prepared, report)?;
    let clock = Clock::start();
    let first_hits = session.with_progress(|p| trace(&tracer, &rays, p))?;
    let wall = clock.wall();
    spent("tracing", "trace", clock, report);
    let met = first_hits.iter().filter(|h| h.is_hit()).count();
    let rate = rays.len() as f64 / wall.max(1e-9);
    let words = format!(
        "{}, {} hits, {} million rays per second",
        count(rays.len()),
        count(met),
        short(rate * 1e-6)
    );
    report.fact("rays", rays.len(), "rays", words);
    report.value("hits", met);
    report.value("rays_per_second", number(rate));
    let row = |hit: &KernelHit| hit_row(scene, &tracer, hit);
    Ok(ProbeResults {
        columns: HIT,
        values: first_hits.iter().flat_map(row).collect(),
    })
}

/// The closest hit of each ray, in their order.
fn trace(tracer: &Tracer, rays: &[Ray], progress: &Progress) -> Result<Vec<KernelHit>, Cancelled> {
    progress.begin("tracing", rays.len() as u64);
    let parts: Result<Vec<Vec<KernelHit>>, Cancelled> = rays
        .par_chunks(BATCH)
        .map_init(Vec::new, |batch, rays| {
            batch.clear();
            batch.extend(rays.iter().map(|r| tracer.kernel_ray(r)));
            let mut hits = Vec::new();
            tracer.closest(batch, &mut hits);
            progress.advance(rays.len() as u64)?;
            Ok(hits)
        })
        .collect();
    Ok(parts?.concat())
}

/// t, object, triangle of the object, u, v; a miss is inf, −1, −1, 0, 0.
fn hit_row(scene: &Scene, tracer: &Tracer, hit: &KernelHit) -> [f64; HIT] {
    if !hit.is_hit() {
        return [f64::INFINITY, -1.0, -1.0, 0.0, 0.0];
    }
    let item = tracer.item(hit.item);
    let triangle = match scene.objects[item.object as usize].shape.mesh() {
        // A polygon of n corners is n − 2 triangles, so the corners before a face count them.
        Some(mesh) => mesh.faces.starts[item.face as usize] - 2 * item.face + item.triangle,
        None => item.face,
    };
    let [u, v] = hit.uv();
    [
        f64::from(hit.t),
        f64::from(item.object),
        f64::from(triangle),
        f64::from(u),
        f64::from(v),
    ]
}
