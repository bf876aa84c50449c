//! `probe --grid`: light around the points of a grid.

use super::{ProbeArgs, build, spent};
use crate::clock::Clock;
use crate::failure::Failure;
use crate::report::{Report, count, number, percent, short};
use crate::runner::Runner;
use crate::session::Session;
use crate::values::numbers;
use crate::{input, pass};
use azulejo::output::Output;
use azulejo::probe_grid::{GridLight, ProbeGrid, grid_light};
use azulejo_formats::numpy::npy;
use azulejo_formats::numpy::npz::NpzWriter;
use azulejo_formats::picture::ktx2::{self, Ktx2Texels};
use azulejo_scene::harmonics::{HARMONICS, harmonic_irradiance};
use azulejo_scene::math::Aabb;
use azulejo_scene::{Image, Rgb, Units, Up};
use azulejo_trace::Run;
use azulejo_trace::run::Alone;
use glam::DVec3;
use serde_json::json;
use std::f64::consts::PI;
use std::io::{self, Write};

/// Most probes of a grid: their light takes some gigabytes.
const MOST_PROBES: u64 = 1 << 20;

/// Error beside the requested one up to which that counts as reached.
const TOLERATED: f64 = 1.2;

/// What a grid is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum GridFormat {
    Json,
    Npz,
    Ktx2,
}

/// `NX,NY,NZ`: cells along each axis.
pub fn resolution(text: &str) -> Result<[u32; 3], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let expected = "expected three numbers of cells, as in 16,8,16";
    let cells: [u32; 3] = numbers
        .ok()
        .and_then(|numbers| numbers.try_into().ok())
        .filter(|cells: &[u32; 3]| !cells.contains(&0))
        .ok_or(expected)?;
    let probes = cells
        .iter()
        .try_fold(1_u64, |all, &n| all.checked_mul(n.into()));
    match probes {
        Some(probes) if probes <= MOST_PROBES => Ok(cells),
        _ => Err(format!(
            "more than {MOST_PROBES} probes: divide the box among several files with --grid-box"
        )),
    }
}

/// `X0,Y0,Z0,X1,Y1,Z1`: two opposite corners.
pub fn bounds(text: &str) -> Result<Aabb, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers(text)?[..] else {
        return Err("expected six numbers, two corners of a box".to_owned());
    };
    let (a, b) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
    let bounds = Aabb {
        min: a.min(b),
        max: a.max(b),
    };
    if (bounds.max - bounds.min).min_element() > 0.0 {
        Ok(bounds)
    } else {
        Err("a box without a volume".to_owned())
    }
}

/// Computes the light of the grid, and writes it.
pub fn run(
    args: &ProbeArgs,
    resolution: [u32; 3],
    runner: &Runner,
    session: &mut Session,
) -> Result<Report, Failure> {
    if let Some(by) = runner.shared_by() {
        return Err(Failure::misuse(format_args!(
            "{by} and --grid: give each process a part of the box with --grid-box"
        )));
    }
    let (output, format) = output(args, session)?;
    let prepared = args.first_pass.engine.prepare()?;
    let scene = input::read_relit(&args.input, args.first_pass.instant(), session)?;
    let bounds = args.grid_box.unwrap_or_else(|| scene.bounds());
    if (bounds.max - bounds.min).min_element().partial_cmp(&0.0)
        != Some(std::cmp::Ordering::Greater)
    {
        return Err(Failure::failed(
            "the box of the scene has no volume: say where the grid is with --grid-box",
        ));
    }
    let mut report = Report::default();
    let tracer = build(&scene, &prepared, &mut report)?;
    let options = pass::options(&args.first_pass, &prepared, session);
    let clock = Clock::start();
    let grid = ProbeGrid { bounds, resolution };
    let light = pass::with_forecast(&args.first_pass, (&Alone, session), |run: Run| {
        grid_light(&scene, &tracer, grid, &options, run)
    })
    .map_err(pass::failure)?;
    pass::refuse_imbalance(&light.report, &args.first_pass)?;
    spent("tracing", "trace", clock, &mut report);
    describe(&light, args, &mut report);
    say_unreached(&light, args, session);
    let units = scene.units;
    let shown = match (format, units.up) {
        (GridFormat::Npz, _) | (_, Up::Y) => None,
        (_, Up::Z) => Some(light.turned_up()),
    };
    let shown = shown.as_ref().unwrap_or(&light);
    output.write(session.progress(), |out| match format {
        GridFormat::Json => write_json(shown, units, out),
        GridFormat::Npz => write_npz(shown, out),
        GridFormat::Ktx2 => write_ambient_cubes(shown, out),
    })?;
    report.value("output", output.path().display().to_string());
    Ok(report)
}

/// The file, and its format.
fn output(args: &ProbeArgs, session: &mut Session) -> Result<(Output, GridFormat), Failure> {
    let path = args
        .output
        .as_deref()
        .ok_or_else(|| Failure::misuse("--grid needs -o FILE"))?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let format = match extension.as_deref() {
        Some("json") => GridFormat::Json,
        Some("npz") => GridFormat::Npz,
        Some("ktx2") => GridFormat::Ktx2,
        _ => {
            return Err(Failure::misuse(format_args!(
                "{}: a grid is written as .json, .npz or .ktx2",
                path.display()
            )));
        }
    };
    let output = Output::check(path)?;
    session.claim_stdout(output.is_stdout())?;
    Ok((output, format))
}

/// Says that the requested error is not reached.
fn say_unreached(light: &GridLight, args: &ProbeArgs, session: &mut Session) {
    if let Some(requested) = args.first_pass.error
        && light.noise > TOLERATED * requested
    {
        session.note(&format!(
            "the noise is {}, not {}: the time is over, or the noisiest probes have all the rays that they get",
            percent(light.noise),
            percent(requested)
        ));
    }
}

fn describe(light: &GridLight, args: &ProbeArgs, report: &mut Report) {
    let inside = light.is_inside.iter().filter(|inside| **inside).count();
    let [x, y, z] = light.grid.resolution;
    let words = format!(
        "{} ({x} × {y} × {z}), {} inside of solids",
        count(light.grid.len()),
        count(inside)
    );
    report.fact("probes", light.grid.len(), "probes", words);
    report.value("inside", inside);
    report.fact(
        "rays_per_probe",
        number(light.rays),
        "rays",
        format!("{} per probe", short(light.rays)),
    );
    let request = args.first_pass.error.map_or(String::new(), |requested| {
        format!(", {} requested", percent(requested))
    });
    let words = format!("{} of the mean irradiance{request}", percent(light.noise));
    report.fact("noise", number(light.noise), "noise", words);
    let words = match light.systematic {
        Some(off) => format!(
            "{}: what bands 0 to 2 cannot say of hard light, and patches of light nearby",
            percent(off)
        ),
        None => "not measured: no time was left".to_owned(),
    };
    report.fact(
        "systematic",
        light.systematic.map(number),
        "beside noise",
        words,
    );
}

/// The grid with its box and all coefficients, in the axes and the metres of glTF.
fn write_json(light: &GridLight, units: Units, out: &mut dyn Write) -> io::Result<()> {
    let of = |values: &[[Rgb; HARMONICS]]| -> Vec<f32> {
        let all = values.iter().flatten().flat_map(|rgb| rgb.to_f32());
        all.collect()
    };
    let inside: Vec<usize> = (0..light.grid.len())
        .filter(|&p| light.is_inside[p])
        .collect();
    let bounds = light.grid.bounds;
    let [min, max] = [bounds.min, bounds.max].map(|corner| (corner * units.metres()).to_array());
    let value = json!({
        "generator": "azulejo",
        "content": "radiance around each probe as real spherical harmonics of bands 0 to 2: for each probe nine \
            coefficients, Y00, Y1-1 (y), Y10 (z), Y11 (x), Y2-2 to Y22, of red, green and blue each; y is up, and the box is in metres",
        "unit": if units.photometric { "cd/m2" } else { "W/(sr m2)" },
        "order": "x fastest, then y, then z; probes are in the middle of their cells",
        "resolution": light.grid.resolution,
        "min": min,
        "max": max,
        "coefficients": of(&light.coefficients),
        "standardErrors": of(&light.standard_errors),
        "inside": inside,
        "noise": light.noise,
        "systematic": light.systematic,
    });
    serde_json::to_writer(out, &value)?;
    Ok(())
}

/// Arrays by z, y and x, in the axes of the scene.
fn write_npz(light: &GridLight, out: &mut dyn Write) -> io::Result<()> {
    let [x, y, z] = light.grid.resolution.map(|n| n as usize);
    let of = |values: &[[Rgb; HARMONICS]]| -> Vec<f64> {
        let all = values.iter().flatten().flat_map(|rgb| rgb.to_array());
        all.collect()
    };
    let positions: Vec<f64> = (0..light.grid.len())
        .flat_map(|probe| light.grid.position(probe).to_array())
        .collect();
    let inside: Vec<i32> = light
        .is_inside
        .iter()
        .map(|&inside| inside.into())
        .collect();
    let mut archive = NpzWriter::new(out);
    let shape = [z, y, x, HARMONICS, 3];
    archive.add("coefficients", |out| {
        npy::write(&shape, &of(&light.coefficients), out)
    })?;
    archive.add("std_error", |out| {
        npy::write(&shape, &of(&light.standard_errors), out)
    })?;
    archive.add("positions", |out| {
        npy::write(&[z, y, x, 3], &positions, out)
    })?;
    archive.add("inside", |out| npy::write(&[z, y, x], &inside, out))?;
    archive.finish()
}

/// Ambient cubes as Bevy reads them: a volume of NX × 2 NY × 3 NZ texels with E/π of the six sides of each cell. Sides of
/// x, y and z follow each other in depth; those to positive directions are in the first NY rows.
///
/// Mitchell, McTaggart and Green, *Shading in Valve's Source engine*, SIGGRAPH 2006.
fn write_ambient_cubes(light: &GridLight, out: &mut dyn Write) -> io::Result<()> {
    let [x, y, z] = light.grid.resolution;
    let mut layers = Vec::new();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for back in 0..z {
            let sides = [axis, -axis].into_iter();
            let texels = sides.flat_map(|side| {
                let cells = (0..y).flat_map(move |row| (0..x).map(move |column| (column, row)));
                cells.map(move |(column, row)| {
                    let coefficients = &light.coefficients[light.grid.probe([column, row, back])];
                    (harmonic_irradiance(coefficients, side) / PI).to_f32()
                })
            });
            layers.push(Image::opaque(x, 2 * y, texels.collect()));
        }
    }
    ktx2::write_volume(&layers, Ktx2Texels::SharedExponent, out)
}
