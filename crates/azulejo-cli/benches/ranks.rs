//! How work scales that MPI's processes share: strong and weak scaling by the ranks of one machine, what
//! they exchange beside what a model says, and what the model predicts for a cluster.
//!
//! `cargo bench -p azulejo-cli --features mpi --bench ranks`. Ranks have one thread each, and may be more
//! than there are processors: there CPU seconds count, not time. Needs `mpiexec`; without, it says so.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::time::Instant;

/// Ranks of the measurements: the last where there are this many processors.
const RANKS: [usize; 5] = [1, 2, 4, 8, 16];

/// Most ranks of more than there are processors.
const OVERSUBSCRIBED: usize = 8;

/// Ranks of the predictions.
const PREDICTED: [f64; 5] = [8.0, 16.0, 64.0, 1_000.0, 10_000.0];

/// A network as of clusters: seconds of one message, bytes per second.
const NETWORK: [f64; 2] = [2e-6, 10e9];

/// Seconds after which a waiting rank looks for messages again, on average: see `PAUSE` of the
/// messenger.
const PAUSE: f64 = 1e-4;

/// Seconds in which rank 0 hands out a block.
const HANDOUT: f64 = 10e-6;

/// A work, whose size grows with the square root of `{patches}`.
struct Work {
    name: &'static str,
    line: &'static str,
    /// Number of patches of strong scaling, and of one rank of weak scaling.
    patches: [f64; 2],
    /// With which power of the patches its CPU time grows.
    growth: f64,
    /// A work of the same kind of some CPU minutes, as one brings to a cluster, for which the model predicts.
    larger: &'static str,
}

impl Work {
    fn line_of(&self, patches: f64) -> String {
        self.line.replace("{patches}", &patches.round().to_string())
    }
}

const WORKS: [Work; 4] = [
    Work {
        name: "form-factors, rays",
        line: "form-factors examples/shapes.grf --patches {patches} --rays 16384 -o OUT.npz",
        patches: [2_000.0, 500.0],
        growth: 1.0,
        larger: "form-factors examples/shapes.grf --patches 2000 --rays 131072 -o OUT.npz",
    },
    Work {
        name: "form-factors, formulas",
        line: "form-factors examples/shapes.grf --patches {patches} --engine analytic -o OUT.npz",
        patches: [900.0, 300.0],
        growth: 2.0,
        larger: "form-factors examples/shapes.grf --patches 3600 --engine analytic -o OUT.npz",
    },
    Work {
        name: "solve, 0.4%",
        line: "solve examples/cornell.grf --patches {patches} --error 0.004 -o OUT.grf",
        patches: [4_000.0, 1_000.0],
        growth: 1.0,
        larger: "solve examples/cornell.grf --patches 4000 --error 0.001 -o OUT.grf",
    },
    Work {
        name: "bake, 2%",
        line: "bake examples/cornell.grf --patches 500 --texels {patches} --error 0.02 -o OUT.glb",
        patches: [80_000.0, 20_000.0],
        growth: 1.0,
        larger: "bake examples/cornell.grf --patches 500 --texels 80000 --rays 4096 -o OUT.glb",
    },
];

fn main() {
    if cfg!(not(feature = "mpi")) {
        println!("built without MPI: cargo bench -p azulejo-cli --features mpi --bench ranks");
        return;
    }
    let folder = std::env::temp_dir().join(format!("azulejo-ranks-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    for work in &WORKS {
        println!("{}", work.name);
        println!("  strong scaling");
        println!(
            "  ranks  CPU s  most of one  seconds  waited  blocks  exchanges  given MB  gathered MB  efficiency"
        );
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let counts: Vec<usize> = (RANKS.into_iter())
            .filter(|&n| n <= processors.max(OVERSUBSCRIBED))
            .collect();
        let mut strong = Vec::new();
        for &ranks in &counts {
            let Some(run) = Run::of(work, work.patches[0], ranks, &folder) else {
                return;
            };
            run.print(strong.first().unwrap_or(&run));
            strong.push(run);
        }
        if let Some(two) = strong.get(1) {
            two.predict(&work.line_of(work.patches[0]));
        }
        if let Some(larger) = Run::of_line(work.larger, 2, &folder) {
            larger.predict(work.larger);
        }
        println!("  weak scaling");
        let mut first: Option<Run> = None;
        for &ranks in &counts {
            let patches = work.patches[1] * (ranks as f64).powf(1.0 / work.growth);
            let Some(run) = Run::of(work, patches, ranks, &folder) else {
                return;
            };
            let each = run.cpu() / ranks as f64;
            let one = first.as_ref().map_or(each, Run::cpu);
            println!(
                "  {ranks:>5} {:>6.2} in all, {each:.2} each: {:.0}%",
                run.cpu(),
                100.0 * one / each
            );
            first.get_or_insert(run);
        }
    }
    let _ = fs::remove_dir_all(folder);
}

/// What a work took, and each of its ranks.
struct Run {
    seconds: f64,
    /// Seconds of rank 0 from its start to its end.
    wall: f64,
    ranks: Vec<RankCosts>,
}

#[derive(Clone, Copy)]
struct RankCosts {
    cpu: f64,
    divided: f64,
    waited: f64,
    blocks: f64,
    exchanges: f64,
    given: f64,
    gathered: f64,
}

impl Run {
    fn of(work: &Work, patches: f64, ranks: usize, folder: &Path) -> Option<Run> {
        Run::of_line(&work.line_of(patches), ranks, folder)
    }

    /// `None` without MPI.
    fn of_line(line: &str, ranks: usize, folder: &Path) -> Option<Run> {
        let line = line.replace("OUT", &folder.join("out").to_string_lossy());
        let mut command = azulejo_testing::mpiexec(ranks)?;
        command.arg(env!("CARGO_BIN_EXE_azulejo"));
        command.args(line.split(' '));
        command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
        let start = Instant::now();
        let output = command.args(["--threads", "1", "--json"]).output().ok()?;
        let seconds = start.elapsed().as_secs_f64();
        let said: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let number = |v: &Value, key: &str| v[key].as_f64().unwrap_or(f64::NAN);
        // One process has no ranks.
        let alone = [serde_json::json!({ "cpu_seconds": said["cpu_seconds"] })];
        let costs = said["rank_costs"]
            .as_array()
            .map_or(&alone[..], Vec::as_slice);
        assert_eq!(
            costs.len(),
            ranks,
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let of = |v: &Value| RankCosts {
            cpu: number(v, "cpu_seconds"),
            divided: number(v, "divided_seconds"),
            waited: number(v, "waited_seconds"),
            blocks: number(v, "blocks"),
            exchanges: number(v, "exchanges"),
            given: number(v, "given_bytes"),
            gathered: number(v, "gathered_bytes"),
        };
        Some(Run {
            seconds,
            wall: number(&said, "wall_seconds"),
            ranks: costs.iter().map(of).collect(),
        })
    }

    fn sum(&self, of: impl Fn(&RankCosts) -> f64) -> f64 {
        self.ranks.iter().map(of).sum()
    }

    fn cpu(&self) -> f64 {
        self.sum(|r| r.cpu)
    }

    fn print(&self, first: &Run) {
        let most = self.ranks.iter().map(|r| r.cpu).fold(0.0, f64::max);
        let count = self.ranks.len() as f64;
        println!(
            "  {:>5} {:>6.2} {most:>12.2} {:>8.2} {:>7.2} {:>7.0} {:>10.0} {:>9.2} {:>12.2} {:>10.0}%",
            self.ranks.len(),
            self.cpu(),
            self.seconds,
            self.sum(|r| r.waited),
            self.sum(|r| r.blocks),
            self.ranks[0].exchanges,
            self.sum(|r| r.given) * 1e-6,
            self.ranks[0].gathered * 1e-6,
            // Were there a processor for each: the slowest rank ends the work.
            100.0 * first.cpu() / (count * most)
        );
    }

    /// What the model says for more ranks, of a run of two, each of which had a processor: T(n) = s + p/n + c(n). What is
    /// not divided, s, is the time that rank 0 takes beside its blocks and waiting; p is the time that all take for
    /// blocks. Communication c(n) is the exchanges, each of which waits for the last and then passes through log₂ n
    /// ranks, the bytes that each rank receives, and rank 0 handing out blocks where that takes longer than computing
    /// them.
    fn predict(&self, line: &str) {
        let rank = &self.ranks[0];
        let own = (self.wall - rank.divided - rank.waited).max(0.0);
        let divided = self.sum(|r| r.divided);
        let blocks = self.sum(|r| r.blocks);
        println!("  {line}");
        println!(
            "  not divided {own:.3} s, divided {divided:.2} s: {:.2}%, {} exchanges, {:.1} MB to each rank",
            100.0 * own / (own + divided),
            rank.exchanges,
            rank.gathered * 1e-6
        );
        for n in PREDICTED {
            let [latency, bandwidth] = NETWORK;
            let talk = rank.exchanges * (PAUSE + latency * n.log2()) + rank.gathered / bandwidth;
            let handing = (blocks * HANDOUT - divided / n).max(0.0);
            let time = own + divided / n + talk + handing;
            println!(
                "  predicted for {n:>6} ranks: {time:>8.3} s, efficiency {:>3.0}%",
                100.0 * (own + divided) / (n * time)
            );
        }
    }
}
