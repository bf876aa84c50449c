//! `probe --year`: irradiance at points in all hours of a weather file.

use super::{ProbeArgs, spent};
use crate::clock::Clock;
use crate::engine::PreparedEngine;
use crate::failure::Failure;
use crate::input::InputArgs;
use crate::placement::PlaceArg;
use crate::report::{Report, bytes, count, number, percent, short};
use crate::runner::Runner;
use crate::session::Session;
use crate::surroundings::args::{GroundArg, Site, SurroundingsArgs};
use crate::{input, pass, points, surroundings};
use azulejo::machine;
use azulejo::output::Output;
use azulejo::surroundings::{DaylightUnits, GROUND_REFLECTANCE, WeatherFile, WeatherRecord};
use azulejo_exchange::daylight::{Daylight, YearAtPoints, bytes_of_year, year_at_points};
use azulejo_exchange::points::{SeenFromPoints, numbered};
use azulejo_exchange::{Enclosure, ExchangeError};
use azulejo_factors::form_factors::{FactorPoint, Plan};
use azulejo_factors::{Engine, FactorsError, FormFactorOptions, PatchSize};
use azulejo_scene::Scene;
use azulejo_scene::sky::{PerezWeather, SkyDivision, TYPICAL_DEW_POINT};
use jiff::Timestamp;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

/// About how many patches the model is divided into: with both sides of them as many rows as are solved at once, rather
/// than by iterations for each point.
const PATCHES: usize = 950;

/// Subdivisions of Tregenza's patches of the sky along each side.
const SUBDIVISIONS: usize = 2;

/// When the years begin whose sun shines, seconds: 2024 if there is a 29 February, else 2025.
const YEARS: [i64; 2] = [1_704_067_200, 1_735_689_600];

/// Computes the year, and writes it.
pub fn run(
    args: &ProbeArgs,
    path: &Path,
    runner: &Runner,
    session: &mut Session,
) -> Result<Report, Failure> {
    if let Some(by) = runner.shared_by() {
        return Err(Failure::misuse(format_args!(
            "{by} and --year: all hours come from one matrix; divide the file of points, if they are very many"
        )));
    }
    let output = output(args, session)?;
    let is_table = output.as_ref().is_some_and(|(_, is_table)| *is_table);
    session.claim_stdout(
        output
            .as_ref()
            .is_some_and(|(output, _)| output.is_stdout()),
    )?;
    let points = points::read_points(path, args.normals.as_deref())?;
    let points = points.iter().map(|p| FactorPoint {
        position: p.position,
        normal: Some(p.normal),
    });
    let points: Vec<FactorPoint> = points.collect();
    let Some(weather_path) = &args.input.outside.weather else {
        return Err(Failure::misuse("--year needs --weather FILE.epw"));
    };
    let weather = surroundings::read_weather(weather_path)?;
    let is_leap = weather.is_leap_year();
    let is_leap =
        is_leap.map_err(|e| Failure::failed(format_args!("{}: {e}", weather_path.display())))?;
    let scene = input::read_relit(&without_sky(&args.input), None, session)?;
    if scene.has_light() {
        session.note("--year: only the sun and the sky count, not the lights of the model");
    }
    let units = DaylightUnits {
        photometric: scene.units.photometric,
        solar: args.input.outside.solar || !scene.units.photometric,
    };
    let records = daylight(args, &weather, is_leap, units)?;
    let mut report = Report::default();
    let all = (&records[..], record_hours(&weather));
    let year = compute(args, &scene, (points, is_table), all, session, &mut report)?;
    if let Some((output, _)) = output {
        let write = if is_table {
            YearAtPoints::write_npz
        } else {
            YearAtPoints::write_csv
        };
        output.write(session.progress(), |out| write(&year, out))?;
        let path = output.path().display().to_string();
        report.fact("output", path.clone(), "wrote", path);
    }
    describe_weather(&weather, &records, &mut report);
    describe(
        &year,
        if units.solar { "kWh/m²" } else { "klx·h" },
        &mut report,
    );
    Ok(report)
}

/// Where to write, if anywhere, and whether that holds all hours.
fn output(args: &ProbeArgs, session: &Session) -> Result<Option<(Output, bool)>, Failure> {
    let default = (!session.json()).then_some(Path::new("-"));
    let Some(path) = args.output.as_deref().or(default) else {
        return Ok(None);
    };
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let is_table = match extension.as_deref() {
        Some("npz") => true,
        Some("csv") => false,
        None if path == Path::new("-") => false,
        _ => {
            return Err(Failure::misuse(format_args!(
                "{}: a year is written as .csv, its sum, or .npz, with all hours",
                path.display()
            )));
        }
    };
    Ok(Some((Output::check(path)?, is_table)))
}

/// The models alone: sun and sky are those of all hours.
fn without_sky(input: &InputArgs) -> InputArgs {
    let mut reading = input.reading.clone();
    reading
        .place
        .retain(|place| matches!(place, PlaceArg::Model(_)));
    InputArgs {
        scenes: input.scenes.clone(),
        lights: None,
        lamp: Vec::new(),
        reading,
        outside: SurroundingsArgs::default(),
    }
}

/// Computes the factors, and with them all records.
fn compute(
    args: &ProbeArgs,
    scene: &Scene,
    (points, is_table): (Vec<FactorPoint>, bool),
    records: (&[Option<Daylight>], f64),
    session: &mut Session,
    report: &mut Report,
) -> Result<YearAtPoints, Failure> {
    let engine = args.first_pass.engine.prepare()?;
    let tracer = super::build(scene, &engine, report)?;
    let options = options(args, &engine, session)?;
    let plan = Plan::new(scene, &tracer, &options).map_err(pass::failure)?;
    plan.flaws().iter().for_each(|flaw| session.note(flaw));
    let prepared = plan.prepare();
    let division = SkyDivision::reinhart(SUBDIVISIONS).unwrap_or(SkyDivision::TREGENZA);
    let kept = if is_table { records.0.len() } else { 0 };
    let needed = bytes_of_year([points.len(), prepared.rows(), division.count(), kept]);
    if needed > options.memory {
        return Err(Failure::failed(format_args!(
            "{} points need {}, more than the {} that may be used: divide their file, allow more with --memory, or write \
             a .csv, which takes less",
            count(points.len()),
            bytes(needed),
            bytes(options.memory)
        )));
    }
    let clock = Clock::start();
    let sky = (division, args.input.outside.north.to_radians());
    let found = session.with_progress(|p| -> Result<_, FactorsError> {
        let mut enclosure = Enclosure::new(&prepared, scene, prepared.compute(p)?);
        enclosure.sky = Some(prepared.sky_factors(sky.0, sky.1, &enclosure.factors, p)?);
        let mut seen = SeenFromPoints::compute(&prepared, (scene, None), numbered(points), p)?;
        seen.add_sky(&prepared, sky, p)?;
        Ok((enclosure, seen))
    });
    let (enclosure, seen) = found.map_err(pass::failure)?;
    engine.describe(&enclosure.factors.engine_used, report);
    report.fact("rows", enclosure.len(), "rows", count(enclosure.len()));
    spent("matrix", "matrix", clock, report);
    let clock = Clock::start();
    let year = session
        .with_progress(|p| year_at_points((&prepared, &enclosure), seen, records, is_table, p));
    spent("all hours", "hours", clock, report);
    year.map_err(|e| match e {
        ExchangeError::Cancelled => Failure::Cancelled,
        other => Failure::failed(other),
    })
}

fn options(
    args: &ProbeArgs,
    engine: &PreparedEngine,
    session: &Session,
) -> Result<FormFactorOptions, Failure> {
    let default = FormFactorOptions::default();
    let pass = &args.first_pass;
    let engine = match (&engine.engine, pass.rays) {
        (Engine::Particles, _) => {
            return Err(Failure::misuse("--year: particles have no form factors"));
        }
        (Engine::Auto, Some(_)) => Engine::Rays,
        (engine, _) => engine.clone(),
    };
    Ok(FormFactorOptions {
        engine,
        size: pass::patch_size(&pass.division).unwrap_or(PatchSize::Count(PATCHES)),
        rays: pass.rays.unwrap_or(default.rays),
        two_sided: true,
        seed: pass.seed,
        memory: pass.memory.unwrap_or(machine::budget_of(session.memory())),
        ..default
    })
}

fn record_hours(weather: &WeatherFile) -> f64 {
    weather
        .records()
        .first()
        .map_or(1.0, |first| first.hours[1] - first.hours[0])
}

/// Sun and sky in the middle of each record; `None` at night.
fn daylight(
    args: &ProbeArgs,
    weather: &WeatherFile,
    is_leap: bool,
    units: DaylightUnits,
) -> Result<Vec<Option<Daylight>>, Failure> {
    let site = args.input.reading.site();
    let site = site.unwrap_or(Site::new(weather.latitude, weather.longitude));
    let ground = match args.input.outside.ground {
        Some(GroundArg::None) => 0.0,
        Some(GroundArg::Reflectance(share)) => share,
        None => GROUND_REFLECTANCE,
    };
    let begin = YEARS[usize::from(!is_leap)] as f64 - 3600.0 * weather.time_zone;
    let of_record = |(k, record): (usize, &WeatherRecord)| -> Result<_, String> {
        let hours = (k as f64 + 0.5) * record_hours(weather);
        let instant = Timestamp::from_second((begin + 3600.0 * hours) as i64);
        let sun = site.sun(instant.map_err(|e| e.to_string())?)?;
        let weather = PerezWeather {
            dni: record.direct_normal.unwrap_or_default(),
            dhi: record.diffuse_horizontal.unwrap_or_default(),
            sun_altitude: sun.altitude,
            day_of_year: (hours / 24.0) as u32 + 1,
            dew_point: record.dew_point.unwrap_or(TYPICAL_DEW_POINT),
        };
        if weather.is_night() {
            return Ok(None);
        }
        let toward_sun = sun.toward();
        let (mut sky, beam) = units.perez_sky(&weather, toward_sun);
        let direct_normal = if sun.is_up() { beam } else { 0.0 };
        let diffuse_horizontal = sky.diffuse_horizontal();
        sky.ground = ground * (diffuse_horizontal + direct_normal * toward_sun.z) / PI;
        Ok(Some(Daylight {
            sky,
            diffuse_horizontal,
            toward_sun,
            direct_normal,
        }))
    };
    let records = weather.records().par_iter().enumerate().map(of_record);
    records.collect::<Result<_, _>>().map_err(Failure::misuse)
}

/// Adds what was read, and the share of the direct light that does not count because the sun is not up.
fn describe_weather(weather: &WeatherFile, records: &[Option<Daylight>], report: &mut Report) {
    let lit = records.iter().flatten().count();
    let words = format!(
        "{} of {}, {} of them with light",
        count(records.len()),
        weather.city,
        count(lit)
    );
    report.fact("records", records.len(), "records", words);
    let beam = |record: &WeatherRecord| record.direct_normal.unwrap_or_default();
    let all: f64 = weather.records().iter().map(beam).sum();
    let pairs = weather.records().iter().zip(records);
    let below = pairs.filter(|(_, daylight)| daylight.is_some_and(|d| d.direct_normal == 0.0));
    let lost = below.map(|(record, _)| beam(record)).sum::<f64>() / all.max(f64::MIN_POSITIVE);
    let words = format!(
        "{} of what faces it, while it is below the horizon",
        percent(lost)
    );
    report.fact("sun_not_counted", number(lost), "sun not counted", words);
}

/// Adds the means over all points.
fn describe(year: &YearAtPoints, unit: &str, report: &mut Report) {
    let points = year.points.len();
    report.fact("points", points, "points", count(points));
    let mean = |sums: &[f64]| sums.iter().sum::<f64>() / 1000.0 / points.max(1) as f64;
    let [sum, sun, sky] = [&year.sum, &year.direct_sun, &year.sky].map(|sums| mean(sums));
    let reflected = mean(&year.reflected());
    let [a, b, c, d] = [sum, sun, sky, reflected].map(short);
    let words = format!(
        "{a} {unit}, the mean of all points: {b} by the sun, {c} by the sky, {d} reflected"
    );
    report.fact("sum_mean", number(sum), "year", words);
    report.value("direct_sun_mean", number(sun));
    report.value("sky_mean", number(sky));
    report.value("reflected_mean", number(reflected));
    let error = year
        .standard_error
        .iter()
        .fold(0.0, |a: f64, e| a.max(e / 1000.0));
    let words = format!("{} {unit}, the largest, of what points see", short(error));
    report.fact("std_error_max", number(error), "standard error", words);
}
