//! What thermal and urban work takes: `cargo bench -p azulejo-exchange --bench thermal -- WORK [FACETS]`,
//! with the work `urban`, `archive`, `exchange` or `network`. Each in a process of its own, because its peak of
//! memory is printed.
//!
//! | work | what it does | facets |
//! |---|---|---|
//! | `urban` | form factors of an array of cubes below the sky, by rays, and the error of their rows | 23,328 |
//! | `archive` | size of the `.npz` of a closed room, by rays | 17,600 |
//! | `exchange` | temperatures of a closed room, given on half of the rows and adiabatic on the others, in two bands and in one | 10,000 |
//! | `network` | conductances between 20 nodes of such a room | 10,000 |

#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

#[path = "../../azulejo-factors/benches/usage/mod.rs"]
mod usage;

use azulejo_exchange::archive::{self, ArchivePrecision};
use azulejo_exchange::{
    Enclosure, GroupBy, Groups, HeatProblem, RowCondition, SpectralRange, SurfaceBand,
    exchange_factors, heat_balance,
};
use azulejo_factors::form_factors::{Closure, Plan};
use azulejo_factors::{Engine, FormFactorOptions, PatchSize};
use azulejo_scene::Scene;
use azulejo_scene::synthetic::{cube_array, room_with_table};
use azulejo_trace::{Progress, Tracer};
use std::io::{self, Write};
use std::time::Instant;
use usage::{cpu_seconds, peak_mebibytes};

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let number = |place: usize| words.get(place).and_then(|w| w.parse::<usize>().ok());
    let size = |usual: usize| number(1).unwrap_or(usual);
    match words.first().map(String::as_str) {
        Some("urban") => urban(size(23_328), number(2).unwrap_or(4_096) as u32),
        Some("archive") => stored(size(17_600)),
        Some("exchange") => temperatures(size(10_000)),
        Some("network") => conductances(size(10_000)),
        _ => println!(
            "expected urban, archive, exchange or network, the number of facets, and of rays from each if urban"
        ),
    }
}

/// Prints wall and CPU seconds of some work, and the peak of memory after it.
fn measured<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let (wall, cpu) = (Instant::now(), cpu_seconds());
    let done = work();
    println!(
        "{what:44} {:8.2} s wall {:8.2} s CPU {:8.0} MiB",
        wall.elapsed().as_secs_f64(),
        cpu_seconds() - cpu,
        peak_mebibytes()
    );
    done
}

fn enclosure(scene: &Scene, options: &FormFactorOptions) -> Enclosure {
    let tracer = Tracer::new(scene);
    let plan = Plan::new(scene, &tracer, options).expect("a scene of faces");
    let prepared = plan.prepare();
    let factors = prepared.compute(&Progress::new()).expect("factors");
    Enclosure::new(&prepared, scene, factors)
}

fn faces(engine: Engine) -> FormFactorOptions {
    FormFactorOptions {
        engine,
        size: PatchSize::Edge(0.0),
        ..FormFactorOptions::default()
    }
}

/// An array of cubes with 3 × 3 facets on each side, by rays. Their number decides the error of a row, which
/// two seeds show: the share of the sky differs between them by √2 of it.
fn urban(facets: usize, rays: u32) {
    let count = (facets as f64 / 72.0).sqrt().round() as u32;
    let scene = cube_array(count, 3);
    let seeds = [1, 2].map(|seed| {
        let options = FormFactorOptions {
            closure: Closure::Never,
            rays,
            seed,
            ..faces(Engine::Rays)
        };
        let factors = measured("form factors of an array of cubes", || {
            enclosure(&scene, &options)
        });
        println!(
            "{} facets, {} pairs",
            factors.len(),
            factors.factors.exchange.pairs()
        );
        factors.factors.rest
    });
    let rms = |of: &mut dyn Iterator<Item = f64>| {
        let squares: Vec<f64> = of.map(|x| x * x).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    };
    let differences = seeds[0].iter().zip(&seeds[1]).map(|(a, b)| a.sky - b.sky);
    let stated = seeds[0].iter().map(|rest| rest.sky_error);
    println!(
        "error of the sky of a row: {:.2e} between the seeds, {:.2e} as stated (RMS)",
        rms(&mut differences.into_iter()) / 2.0f64.sqrt(),
        rms(&mut stated.into_iter())
    );
}

/// Counts bytes.
struct ByteCount(u64);

impl Write for ByteCount {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn stored(facets: usize) {
    let factors = measured("form factors of a room", || {
        enclosure(&room_with_table(facets), &faces(Engine::Rays))
    });
    let mut count = ByteCount(0);
    measured("npz", || {
        archive::write(&factors, ArchivePrecision::Auto, &mut count).expect("memory");
    });
    let entries = factors.factors.exchange.entries();
    println!(
        "{} facets, {entries} entries, {:.3} GB, {:.2} bytes per entry",
        factors.len(),
        count.0 as f64 * 1e-9,
        count.0 as f64 / entries as f64
    );
}

/// Emissivities that differ from row to row.
fn emissivities(rows: usize, phase: usize) -> Vec<f64> {
    (0..rows)
        .map(|i| 0.2 + 0.1 * ((i + phase) % 8) as f64)
        .collect()
}

fn temperatures(facets: usize) {
    let factors = measured("form factors of a room", || {
        enclosure(&room_with_table(facets), &faces(Engine::Rays))
    });
    let n = factors.len();
    let condition = |i: usize| match i % 2 {
        0 => RowCondition::Temperature(300.0 + (i % 700) as f64),
        _ => RowCondition::Flux(0.0),
    };
    let conditions: Vec<RowCondition> = (0..n).map(condition).collect();
    let nodes = factors.groups(GroupBy::Object);
    let band = |range, phase| SurfaceBand {
        enclosure: &factors,
        range,
        emissivity: emissivities(n, phase),
    };
    let one = [band(SpectralRange::Thermal, 0)];
    let two = [
        band(SpectralRange::Between(0.0, 5.0), 0),
        band(SpectralRange::Between(5.0, f64::INFINITY), 3),
    ];
    for (name, bands) in [("one band", &one[..]), ("two bands", &two[..])] {
        let problem = HeatProblem {
            bands,
            conditions: &conditions,
            surroundings: [0.0; 2],
            solar: &[],
        };
        let heat = measured(&format!("temperatures, {name}"), || {
            heat_balance(&problem, &nodes, &Progress::new()).expect("temperatures")
        });
        println!("{n} facets, {} steps of Newton's method", heat.iterations);
    }
}

/// Nodes of a network.
const NODES: usize = 20;

fn conductances(facets: usize) {
    let factors = measured("form factors of a room", || {
        enclosure(&room_with_table(facets), &faces(Engine::Rays))
    });
    let n = factors.len();
    let nodes = Groups {
        of_rows: (0..n).map(|i| Some((i * NODES / n) as u32)).collect(),
        names: (0..NODES).map(|node| format!("node {node}")).collect(),
    };
    for phase in [0, 3] {
        let band = SurfaceBand {
            enclosure: &factors,
            range: SpectralRange::Thermal,
            emissivity: emissivities(n, phase),
        };
        let network = measured("conductances between nodes", || {
            exchange_factors(&band, &nodes, &Progress::new()).expect("conductances")
        });
        println!("{n} facets, {} nodes", network.len());
    }
}
