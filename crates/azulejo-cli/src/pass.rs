//! The first pass: its options, solution and summary.

use super::content_key::ContentHasher;
use super::engine::{self, PreparedEngine};
use super::failure::Failure;
use super::first_pass::{DivisionArgs, FirstPassArgs, SidesArg};
use super::report::{Report, bytes, count, number, numbers, percent, seconds, short, triple};
use super::runner::WorkKey;
use super::session::Session;
use azulejo::machine;
use azulejo_radiosity::{
    EnergyBalance, Engine, FirstPass, LightSolution, Method, PatchSize, PointNormal, SolveError,
    StoredSides,
};
use azulejo_scene::{Material, MaterialId, Rgb, Scene, Shape, Units};
use azulejo_trace::run::Alone;
use azulejo_trace::{Blocks, Measure, Measured, Run, Tracer};
use std::time::Instant;

/// The patch size for the library; `None` if the command line does not specify one.
pub fn patch_size(division: &DivisionArgs) -> Option<PatchSize> {
    let count = division.patches.map(|n| PatchSize::Count(n as usize));
    count.or(division.patch_size.map(PatchSize::Edge))
}

/// The library's options.
pub fn options(args: &FirstPassArgs, prepared: &PreparedEngine, session: &Session) -> FirstPass {
    FirstPass {
        size: patch_size(&args.division).unwrap_or(FirstPass::default().size),
        error: args.requested_error(),
        error_each: args.error_each.is_some(),
        rays: args.rays,
        ray_budget: None,
        bounces: args.bounces,
        seed: args.seed,
        memory: args.memory.unwrap_or(machine::budget_of(session.memory())),
        interpolate: !args.no_interpolation,
        keep_mesh: args.keep_mesh,
        sides: sides(args.sides),
        engine: prepared.engine.clone(),
    }
}

fn sides(arg: Option<SidesArg>) -> StoredSides {
    match arg {
        None => StoredSides::BySurface,
        Some(SidesArg::Front) => StoredSides::Front,
        Some(SidesArg::Brighter) => StoredSides::Brighter,
        Some(SidesArg::Split) => StoredSides::Split,
        Some(SidesArg::Unturned) => StoredSides::Unturned,
    }
}

/// Solves under a progress bar.
pub fn solve(
    scene: &Scene,
    tracer: &Tracer,
    args: &FirstPassArgs,
    prepared: &PreparedEngine,
    session: &Session,
) -> Result<LightSolution, Failure> {
    let options = options(args, prepared, session);
    solve_with(scene, tracer, args, &options, session)
}

/// The same with other options than those that `args` give, but within their time.
pub fn solve_with(
    scene: &Scene,
    tracer: &Tracer,
    args: &FirstPassArgs,
    options: &FirstPass,
    session: &Session,
) -> Result<LightSolution, Failure> {
    with_forecast(args, (&Alone, session), |run| {
        azulejo_radiosity::solve(scene, tracer, options, run)
    })
    .map_err(failure)
}

/// What blocks of points depend on, besides the light between patches.
pub fn work_key(
    scene: &Scene,
    tracer: &Tracer,
    options: &FirstPass,
    points: &[PointNormal],
) -> WorkKey {
    let plain = FirstPass {
        engine: Engine::Auto,
        // What it changes is told by the light between patches.
        memory: 0,
        ..options.clone()
    };
    let mut settings = ContentHasher::new();
    settings
        .add(env!("CARGO_PKG_VERSION"))
        .add(&tracer.kernel_name())
        .add(&format!("{plain:?}"));
    engine::add_to_key(&options.engine, &mut settings);
    for point in points {
        settings.add(&point.position).add(&point.normal);
    }
    WorkKey {
        scene: ContentHasher::new().add(scene).key(),
        settings: settings.key(),
        engine: engine::word(&options.engine).to_owned(),
    }
}

/// Runs work on blocks under a progress bar and within the time, and says as soon as it is known if the requested
/// error will not be reached.
pub fn with_forecast<T>(
    args: &FirstPassArgs,
    (blocks, session): (&dyn Blocks, &Session),
    work: impl FnOnce(Run) -> T,
) -> T {
    session.limit_time(args.limit());
    let start = Instant::now();
    let words = |measured: &Measured| forecast(measured, args, start);
    session.with_measures(&words, |progress| work(Run::new(blocks, progress)))
}

/// What a measure says of a requested error that will not be reached.
fn forecast(measured: &Measured, args: &FirstPassArgs, start: Instant) -> Option<String> {
    let Measure::OutOfReach {
        error,
        seconds: more,
        rays,
    } = measured.measure
    else {
        return None;
    };
    args.requested_error()?;
    let spent = measured.at.saturating_duration_since(start).as_secs_f64();
    let needed = seconds((spent + more).max(1.0).round());
    let rays = match args.rays {
        Some(most) if rays > f64::from(most) => {
            format!(" and {} rays per point", count(rays.round() as u64))
        }
        _ => String::new(),
    };
    let limits = match (args.limit(), args.rays) {
        (Some(time), _) => format!("in {}", seconds(time.as_secs_f64())),
        (None, Some(most)) => format!("with {} rays per point", count(most)),
        (None, None) => "with the most rays per point".to_owned(),
    };
    let goal = percent(error);
    Some(format!(
        "{goal} will not be reached {limits}: about {needed}{rays} would be needed"
    ))
}

/// An error of the solver as a failure of the command.
pub fn failure(error: impl Into<SolveError>) -> Failure {
    match error.into() {
        SolveError::Cancelled => Failure::Cancelled,
        error @ SolveError::NoLight => Failure::failed(format_args!(
            "{error}; or light it with --studio (a floor and three lamps), --sky 1, or --sky cie:12 \
             --sun 135,40"
        )),
        other => Failure::failed(other),
    }
}

/// What this process has of a result: nothing where another makes it.
///
/// # Errors
/// Other errors of the solver.
pub fn unless_elsewhere<T>(
    outcome: Result<T, impl Into<SolveError>>,
) -> Result<Option<T>, Failure> {
    match outcome.map_err(Into::into) {
        Ok(value) => Ok(Some(value)),
        Err(SolveError::Elsewhere) => Ok(None),
        Err(error) => Err(failure(error)),
    }
}

/// The unit of power in a scene.
pub fn power_unit(units: Units) -> &'static str {
    if units.photometric { "lm" } else { "W" }
}

/// Adds what the first pass did, and the error of its result.
///
/// # Errors
/// If so much of the emitted power is missing that the result cannot be trusted, unless `args` allow
/// it.
pub fn describe(
    pass: &azulejo_radiosity::Report,
    args: &FirstPassArgs,
    prepared: &PreparedEngine,
    scene: &Scene,
    report: &mut Report,
) -> Result<(), Failure> {
    // A result that cannot be trusted is refused before anything of it is reported.
    refuse_imbalance(pass, args)?;
    prepared.describe(&pass.engine_used, report);
    // State the method, and the patches and memory that it takes.
    let method = match pass.method {
        Method::Matrix => "matrix",
        Method::Stochastic => "stochastic",
        Method::Paths => "paths",
    };
    report.value("method", method);
    let words = match pass.method {
        Method::Matrix => format!(
            "{}, {} of rows",
            count(pass.patches),
            bytes(pass.bytes as u64)
        ),
        Method::Stochastic => format!("{}, without a matrix", count(pass.patches)),
        Method::Paths => format!("{}, without radiosity", count(pass.patches)),
    };
    report.fact("patches", pass.patches, "patches", words);
    report.value("matrix_bytes", pass.bytes);
    // Count the rays of patches and of points apart: they reduce different parts of the error.
    let gathered = pass.points as u64 * u64::from(pass.point_rays);
    report.line(
        "rays",
        format!(
            "{} from patches, {} from {} {}",
            count(pass.patch_rays),
            count(gathered),
            count(pass.points),
            if pass.points == 1 { "point" } else { "points" }
        ),
    );
    report.value("patch_rays", pass.patch_rays);
    if pass.method == Method::Matrix {
        let words = match pass.refined_rows {
            0 => percent(pass.patch_error),
            rows => format!(
                "{}, {} rows refined",
                percent(pass.patch_error),
                count(rows)
            ),
        };
        report.line("error of patches", words);
    }
    report.value("patch_error", number(pass.patch_error));
    report.value("refined_rows", pass.refined_rows);
    report.value("points", pass.points);
    report.value("rays_per_point", pass.point_rays);
    report.value("rays", pass.patch_rays + gathered);
    // Only light between patches has bounces that converge, and an energy balance.
    if pass.method != Method::Paths {
        let words = format!("{}, residual {}", pass.iterations, short(pass.residual));
        report.fact("iterations", pass.iterations, "bounces", words);
        report.value("residual", number(pass.residual));
        energy(&pass.balance, args.bounces.is_some(), scene, report);
        report.value("energy_error_se", number(pass.balance_error));
    }
    errors(pass, args, report);
    Ok(())
}

/// Refuses a result from which so much of the emitted power is missing that it cannot be trusted, unless `args` allow it.
pub fn refuse_imbalance(
    pass: &azulejo_radiosity::Report,
    args: &FirstPassArgs,
) -> Result<(), Failure> {
    let balance = &pass.balance;
    if balance.is_broken(pass.balance_error) && !args.allow_imbalance && args.bounces.is_none() {
        if balance.missing() < 0.0 {
            return Err(Failure::failed(format_args!(
                "{} more power is absorbed than is emitted, so nothing was written: faces that coincide, as those of a \
                 mesh that is there twice, count several times; remove duplicates, or accept it with --allow-imbalance",
                percent(balance.error())
            )));
        }
        return Err(Failure::failed(format_args!(
            "{} of the emitted power is not accounted for, so nothing was written: request a smaller \
             error, more rays or more time, or accept it with --allow-imbalance",
            percent(balance.error())
        )));
    }
    Ok(())
}

/// Adds the estimated error, by its causes and by brightness, beside the one that was requested.
fn errors(pass: &azulejo_radiosity::Report, args: &FirstPassArgs, report: &mut Report) {
    // State the error by its causes; what these do not explain is energy that is unaccounted for.
    let parts = pass.error_parts;
    let stated = parts.noise.hypot(parts.discretization);
    let balance = if pass.error > 1.001 * stated.hypot(parts.interpolation) {
        ", but as much energy is unaccounted for"
    } else {
        ""
    };
    let mut words = format!(
        "{} of the mean irradiance ({} noise, {} discretization",
        percent(pass.error),
        percent(parts.noise),
        percent(parts.discretization)
    );
    if pass.interpolated > 0.0 {
        words += &format!(", {} interpolation", percent(parts.interpolation));
    }
    words.push(')');
    words += balance;
    report.fact("error", number(pass.error), "estimated error", words);
    // An error requested for each point is held against that of each point, not against that of the whole.
    let mut reached = pass.error;
    if let Some(requested) = args.error_each {
        reached = pass.error_each;
        let words = format!(
            "{} of its irradiance ({} was requested; root mean square over the points)",
            percent(pass.error_each),
            percent(requested)
        );
        report.line("error of each point", words);
    }
    report.value("error_each", number(pass.error_each));
    report.value("error_noise", number(parts.noise));
    report.value("error_discretization", number(parts.discretization));
    report.value("error_interpolation", number(parts.interpolation));
    // Split the error from dark to bright: one number may hide that the dark is known less well.
    let relative = pass
        .quarters
        .map(|q| q.error / q.mean.max(f64::MIN_POSITIVE));
    let share = |&r: &f64| {
        if r < 10.0 {
            percent(r)
        } else {
            "more than its light".to_owned()
        }
    };
    let words: Vec<String> = relative.iter().map(share).collect();
    report.line(
        "by quarters",
        format!("{} (dark to bright)", words.join(", ")),
    );
    report.value("quarter_means", numbers(pass.quarters.map(|q| q.mean)));
    report.value("quarter_errors", numbers(pass.quarters.map(|q| q.error)));
    // State how many points have light of another kind: by paths from there, or between other points.
    if pass.path_traced > 0.0 && pass.method != Method::Paths {
        let share = percent(pass.path_traced);
        let points = if pass.points == 1 { "point" } else { "points" };
        let words = format!("{share} of the {points}, where patches are too coarse");
        report.line("path traced", words);
    }
    report.value("path_traced", number(pass.path_traced));
    if pass.interpolated > 0.0 {
        let words = percent(pass.interpolated) + " of the points, in indirect light";
        report.line("interpolated", words);
    }
    report.value("interpolated", number(pass.interpolated));
    report.value("rays_needed", number(pass.rays_needed));
    // State what the requested error would take if it was not reached and more rays would help, or what kept it.
    let Some(requested) = args.requested_error().filter(|&most| reached > most) else {
        return;
    };
    let why = if pass.rays_needed > 1.0 {
        let more = times(pass.rays_needed);
        format!(
            "it would take {more} the rays from points; allow more time or rays, or request a larger error"
        )
    } else if !balance.is_empty() {
        "so much of the energy is unaccounted for; more rays from patches (--rays) may find it"
            .to_owned()
    } else {
        return;
    };
    let requested = percent(requested);
    report.line("caution", format!("{requested} was not reached: {why}"));
}

/// How many times as much, where forecasts beyond a thousand mean little.
pub fn times(factor: f64) -> String {
    if factor > 1000.0 {
        "more than a thousand times".to_owned()
    } else {
        format!("about {} times", short(factor))
    }
}

/// Adds the energy balance, in W or lm and as shares.
///
/// Where bounces are limited, what is missing was reflected by the last of them.
fn energy(balance: &EnergyBalance, is_limited: bool, scene: &Scene, report: &mut Report) {
    let emitted = balance.emitted.mean();
    let share = |power: Rgb| percent(power.mean() / emitted);
    let unit = power_unit(scene.units);
    let words = if emitted > 0.0 {
        format!(
            "{} {unit} emitted, {} absorbed, {} escaped, {} {}",
            triple(balance.emitted.to_array()),
            share(balance.absorbed),
            share(balance.escaped),
            percent(balance.error()),
            if is_limited {
                "reflected once more, or unaccounted for"
            } else {
                "unaccounted for"
            }
        )
    } else {
        // What lights without area send was not counted, only where it ended.
        let [absorbed, escaped] = [balance.absorbed, balance.escaped].map(|p| triple(p.to_array()));
        format!("{absorbed} {unit} absorbed, {escaped} {unit} escaped")
    };
    report.line("energy", words);
    if let Some(words) = caution(balance, scene).filter(|_| !is_limited) {
        report.line("caution", words);
    }
    report.value("emitted", numbers(balance.emitted.to_array()));
    report.value("absorbed", numbers(balance.absorbed.to_array()));
    report.value("escaped", numbers(balance.escaped.to_array()));
    report.value("cut", numbers(balance.cut.to_array()));
    report.value("energy_error", number(balance.error()));
}

/// A reflectance from which light needs a thousand bounces to die out.
const NEARLY_ALL: f64 = 0.999;

/// What a balance that is off says about the scene, and what to do; `None` if it is not off.
fn caution(balance: &EnergyBalance, scene: &Scene) -> Option<&'static str> {
    if !balance.is_off() {
        return None;
    }
    let accounted =
        (balance.absorbed + balance.escaped + balance.cut).mean() / balance.emitted.mean();
    // Glass sends on all that it does not absorb, and light leaves it.
    let reflects_all =
        |m: &Material| m.dielectric.is_none() && (m.diffuse + m.mirror).max_channel() > NEARLY_ALL;
    let is_used = |id: usize| {
        scene
            .objects
            .iter()
            .any(|o| uses(&o.shape, id as MaterialId))
    };
    let mut materials = scene.materials.iter().enumerate();
    let is_endless = materials.any(|(id, m)| reflects_all(m) && is_used(id));
    Some(match accounted {
        share if share < 1.0 && is_endless => {
            "light goes on without end between surfaces that absorb nothing, so irradiance has no \
             limit: lower the reflectances of 1, or open the scene"
        }
        share if share > 1.0 => {
            "more light is absorbed than emitted: request a smaller error, more rays or more time, \
             unless faces coincide, as in a box without thickness, and count several times"
        }
        _ => "the energy balance is off: request a smaller error, more rays or more time",
    })
}

/// Whether any surface of a shape has a material.
fn uses(shape: &Shape, material: MaterialId) -> bool {
    match shape {
        Shape::Mesh(mesh) => mesh.face_materials.contains(&material),
        Shape::Instance(instance) => instance.mesh.face_materials.contains(&material),
        Shape::Primitive(primitive) => primitive.material == material,
        Shape::Exact(exact) => exact.leaves().iter().any(|l| l.material() == material),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo_scene::{Object, Primitive};
    use glam::DVec3;

    #[test]
    fn cautions_name_the_cause() {
        let check = |reflectance: f64, absorbed: f64, escaped: f64, expected: Option<&str>| {
            let mut scene = Scene::default();
            let wall = scene.add_material(Material::diffuse("wall", Rgb::grey(reflectance)));
            scene.add_material(Material::diffuse("not used", Rgb::WHITE));
            let sphere = Primitive::sphere(DVec3::ZERO, 1.0, wall);
            let sphere = Object::new("sphere", Shape::Primitive(sphere));
            scene.objects.push(sphere);
            let balance = EnergyBalance {
                emitted: Rgb::grey(10.0),
                absorbed: Rgb::grey(absorbed),
                escaped: Rgb::grey(escaped),
                cut: Rgb::BLACK,
            };
            let warning = caution(&balance, &scene);
            match expected {
                None => assert_eq!(warning, None),
                Some(words) => assert!(warning.is_some_and(|f| f.contains(words)), "{warning:?}"),
            }
        };
        check(1.0, 6.0, 3.9, None);
        check(1.0, 0.0, 0.0, Some("without end"));
        check(0.9, 0.0, 0.0, Some("smaller error"));
        check(0.9, 8.0, 1.0, Some("smaller error"));
        check(1.0, 290.0, 0.0, Some("coincide"));
    }

    /// Glass has a mirror reflectance of 1, which its interfaces have a part of.
    #[test]
    fn glass_is_not_blamed_for_endless_light() {
        let mut scene = Scene::default();
        let glass = scene.add_material(Material::dielectric("glass", 1.5));
        let ball = Primitive::sphere(DVec3::ZERO, 1.0, glass);
        scene
            .objects
            .push(Object::new("ball", Shape::Primitive(ball)));
        let balance = EnergyBalance {
            emitted: Rgb::grey(10.0),
            absorbed: Rgb::grey(8.0),
            ..EnergyBalance::default()
        };
        let warning = caution(&balance, &scene);
        assert!(
            warning.is_some_and(|f| f.contains("smaller error")),
            "{warning:?}"
        );
    }
}
