//! `probe`: irradiance at points, and radiance or hits along rays.

use super::args::ProbeArgs;
use super::clock::Clock;
use super::engine::PreparedEngine;
use super::failure::Failure;
use super::ranks::RankJournal;
use super::report::{Report, count, number, seconds, short};
use super::session::Session;
use super::shards::{MergedParts, PartPlan, Shard};
use super::workers::Workers;
use super::{input, pass, points};
use azulejo::output::Output;
use azulejo_radiosity::{FirstPass, PointNormal, Probed, SolveError};
use azulejo_render::SecondPass;
use azulejo_scene::Scene;
use azulejo_scene::math::Ray;
use azulejo_trace::{Cancelled, Journal, KernelHit, Progress, Tracer};
use rayon::prelude::*;
use std::path::Path;

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
    fn of_light(columns: usize, values: Vec<f64>) -> Result<ProbeResults, Failure> {
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

/// Runs `probe`.
pub fn run(args: &ProbeArgs, session: &mut Session) -> Result<Report, Failure> {
    match (args.shard, session.ranks().cloned()) {
        (Some(shard), _) => part(args, shard, session),
        (None, Some(ranks)) if !ranks.is_root() => help(args, session),
        (None, _) => whole(args, None, session),
    }
}

/// Runs `probe` with points from parts.
pub fn run_merged(
    args: &ProbeArgs,
    parts: &MergedParts,
    session: &mut Session,
) -> Result<Report, Failure> {
    whole(args, Some(parts), session)
}

/// Measures irradiance at a part of the points.
fn part(args: &ProbeArgs, shard: Shard, session: &mut Session) -> Result<Report, Failure> {
    let Some(points) = &args.probes.points else {
        return Err(Failure::misuse(
            "--shard divides --points; --radiance and --hits take a file of rays, which can be divided itself",
        ));
    };
    pass::refuse_indivisible(&args.first_pass)?;
    let output = args.output.as_deref().unwrap_or(Path::new("-"));
    let planned = PartPlan::check(shard, output)?;
    let prepared = args.first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    let points = points::read_points(points, args.normals.as_deref())?;
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&args.first_pass, &prepared, session);
    let part = planned.open(&pass::work_key(&scene, &tracer, &options, &points), session)?;
    let mut report = Report::default();
    part.fill(session, &mut report, |part, session| {
        let done = session.with_progress(|p| {
            azulejo_radiosity::probe_in_blocks(&scene, &tracer, &points, &options, (part, p))
        });
        match done {
            Ok(_) | Err(SolveError::Elsewhere) => Ok(()),
            Err(e) => Err(pass::failure(e)),
        }
    })?;
    Ok(report)
}

/// Takes part in the work of rank 0.
fn help(args: &ProbeArgs, session: &mut Session) -> Result<Report, Failure> {
    let points = shared_points(args)?;
    let prepared = args.first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    let points = points::read_points(points, args.normals.as_deref())?;
    let tracer = prepared.tracer(&scene)?;
    let options = pass::options(&args.first_pass, &prepared, session);
    let key = || pass::work_key(&scene, &tracer, &options, &points);
    Workers::new(None, None, session).compute(key, session, |journal, session| {
        probed(&scene, &tracer, &points, args, (&options, journal), session)
    })?;
    Ok(Report::default())
}

/// The points of a work that several processes share.
fn shared_points(args: &ProbeArgs) -> Result<&Path, Failure> {
    pass::refuse_time(&args.first_pass)?;
    args.probes.points.as_deref().ok_or_else(|| {
        Failure::misuse(
            "MPI processes share the work of --points; --radiance and --hits take a file of rays, which can be divided \
             itself",
        )
    })
}

/// Measures irradiance at points, with blocks that the journal holds or others compute.
fn probed(
    scene: &Scene,
    tracer: &Tracer,
    points: &[PointNormal],
    args: &ProbeArgs,
    (options, journal): (&FirstPass, &dyn Journal),
    session: &Session,
) -> Result<Probed, Failure> {
    session.limit_time(args.first_pass.limit());
    pass::with_forecast(&args.first_pass, session, |progress| {
        azulejo_radiosity::probe_in_blocks(scene, tracer, points, options, (journal, progress))
    })
    .map_err(pass::failure)
}

/// Measures at all points or rays, or makes that of parts, and writes it.
fn whole(
    args: &ProbeArgs,
    parts: Option<&MergedParts>,
    session: &mut Session,
) -> Result<Report, Failure> {
    let default = (!session.json()).then_some(Path::new("-"));
    let output = args.output.as_deref().or(default);
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
    session.share_files()?;
    if session.ranks().is_some() {
        shared_points(args)?;
    }
    let mut report = Report::default();
    let mut journal = None;
    let rows = match (&probes.points, &probes.radiance, &probes.hits) {
        (Some(path), _, _) => {
            let points = points::read_points(path, args.normals.as_deref())?;
            let workers = Workers::new(parts, output.as_ref().and_then(Output::file), session);
            let (rows, of_ranks) = irradiance(
                &scene,
                &points,
                args,
                workers,
                &prepared,
                session,
                &mut report,
            )?;
            journal = of_ranks;
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
    journal.iter().for_each(RankJournal::remove);
    Ok(report)
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

fn irradiance(
    scene: &Scene,
    points: &[PointNormal],
    args: &ProbeArgs,
    workers: Workers,
    prepared: &PreparedEngine,
    session: &mut Session,
    report: &mut Report,
) -> Result<(ProbeResults, Option<RankJournal>), Failure> {
    let tracer = build(scene, prepared, report)?;
    let options = pass::options(&args.first_pass, prepared, session);
    let clock = Clock::start();
    let key = || pass::work_key(scene, &tracer, &options, points);
    let (probed, journal) = workers.compute(key, session, |journal, session| {
        probed(scene, &tracer, points, args, (&options, journal), session)
    })?;
    spent("tracing", "trace", clock, report);
    pass::describe(&probed.report, &args.first_pass, prepared, scene, report)?;
    let row = |e: &azulejo_radiosity::Estimate| [e.value.to_array(), e.error.to_array()].concat();
    let values = probed.estimates.iter().flat_map(row).collect();
    Ok((ProbeResults::of_light(IRRADIANCE, values)?, journal))
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
    let found =
        session.with_progress(|p| azulejo_render::radiance(scene, &tracer, &rays, &options, p))?;
    spent("tracing", "trace", clock, report);
    report.fact("rays", rays.len(), "rays", count(rays.len()));
    ProbeResults::of_light(RADIANCE, found.iter().flat_map(|l| l.to_array()).collect())
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
    let found = session.with_progress(|p| trace(&tracer, &rays, p))?;
    let wall = clock.wall();
    spent("tracing", "trace", clock, report);
    let met = found.iter().filter(|h| h.is_hit()).count();
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
        values: found.iter().flat_map(row).collect(),
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
