//! How fast models are read, whole process against whole process: `azulejo info FILE` beside
//! `assimp info FILE`, in turns, in one run; and how much memory reading takes against what the
//! scene needs.
//!
//! `cargo bench -p azulejo-cli --bench doors -- [FILE...]`; without files, the largest of each format
//! in the corpus (environment variable `AZULEJO_DATA`), and large ones made up here. Assimp is an
//! optional program (Debian: `apt-get install assimp-utils`); without it its columns stay empty.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo_formats::{Folder, gltf, grf, obj, ply};
use azulejo_scene::{Attribute, Mesh, Scene, Shape, synthetic};
use nix::sys::resource::{UsageWho, getrusage};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Each program runs this often on each file, and at least for this long.
const RUNS: usize = 5;
/// See [`RUNS`].
const LEAST: Duration = Duration::from_millis(300);

fn main() {
    // Cargo itself passes `--bench`.
    let mut files: Vec<PathBuf> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .map(PathBuf::from)
        .collect();
    let folder = std::env::temp_dir().join(format!("azulejo-doors-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a temporary folder");
    if files.is_empty() {
        files = largest_of_the_corpus();
        files.extend(made_up(&folder));
        files.extend(forest(&folder));
    }
    println!(
        "{:>9} | {:>8} {:>8} | {:>8} {:>8} | {:>6} {:>6} | {:>8} {:>8} {:>6} | file",
        "MB", "cpu ms", "MB/s", "assimp", "MB/s", "cpu x", "wall x", "scene", "peak", "x"
    );
    let smallest = folder.join("triangle.obj");
    fs::write(&smallest, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("space for a file");
    files.iter().for_each(|file| measure(file, &smallest));
    let _ = fs::remove_dir_all(folder);
}

/// The largest file of each format.
fn largest_of_the_corpus() -> Vec<PathBuf> {
    let Some(data) = std::env::var_os("AZULEJO_DATA") else {
        println!("the corpus is left out: AZULEJO_DATA is not set");
        return Vec::new();
    };
    let formats = [
        "obj", "ply", "stl", "3ds", "dxf", "gltf", "flt", "wrl", "x3d", "mgf",
    ];
    let largest = |format: &&str| {
        let mut files = Vec::new();
        files_below(&Path::new(&data).join("corpus").join(format), &mut files);
        files.retain(|f| f.extension().is_none_or(|e| e != "bin" && e != "mtl"));
        files.into_iter().max_by_key(|f| size(f))
    };
    formats.iter().filter_map(largest).collect()
}

fn files_below(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_below(&path, files)
        } else {
            files.push(path)
        }
    }
}

fn size(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |m| m.len())
}

/// A ball with bumps, of half a million triangles, in the formats that are written here or that
/// are simple enough.
fn made_up(folder: &Path) -> Vec<PathBuf> {
    let scene = synthetic::displaced_sphere(500_000);
    let write = |name: &str, content: Vec<u8>| {
        let path = folder.join(name);
        fs::write(&path, content).expect("space for a file");
        path
    };
    let bytes = |write: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = Vec::new();
        write(&mut bytes);
        bytes
    };
    let in_memory = "memory takes all";
    vec![
        write(
            "ball.obj",
            bytes(&|out| obj::write(&scene, "ball.mtl", out, &mut Vec::new()).expect(in_memory)),
        ),
        write(
            "ball.ply",
            bytes(&|out| ply::write(&scene, out).expect(in_memory)),
        ),
        write(
            "ball.glb",
            bytes(&|out| gltf::write(&scene, out).expect(in_memory)),
        ),
        write("ball-ascii.ply", ascii_ply(&scene).into_bytes()),
        write("ball.stl", binary_stl(&scene)),
        write("ball.dxf", faces_as_dxf(&scene).into_bytes()),
    ]
}

/// 1,900 places of a ball of some 4,000 triangles: a GRF that includes it in each, and a GLB of as many
/// nodes.
fn forest(folder: &Path) -> Vec<PathBuf> {
    let mut part = Vec::new();
    grf::write(&synthetic::displaced_sphere(4_000), &mut part).expect("memory takes all");
    fs::write(folder.join("tree.grf"), part).expect("space for a file");
    let mut text = String::new();
    for k in 0..1900 {
        let (x, z) = (10 * (k % 50), 10 * (k / 50));
        let place = format!("translation ({x}, 0, {z})");
        writeln!(text, "transform {place} begin include \"tree.grf\" end").expect("memory");
    }
    let path = folder.join("forest.grf");
    fs::write(&path, &text).expect("space for a file");
    let loaded = azulejo_formats::read(text.as_bytes(), "forest.grf", &Folder::of_model(&path));
    let mut glb = Vec::new();
    gltf::write(&loaded.expect("own text").scene, &mut glb).expect("memory takes all");
    let nodes = folder.join("forest.glb");
    fs::write(&nodes, glb).expect("space for a file");
    vec![path, nodes]
}

/// The meshes of a scene, those that are shared once.
fn meshes(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    let own = scene.objects.iter().filter_map(|o| match &o.shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    });
    own.chain(scene.shared_meshes().into_iter().map(|m| &**m))
}

fn ascii_ply(scene: &Scene) -> String {
    let mesh = meshes(scene).next().expect("a mesh");
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    );
    for p in &mesh.positions {
        let _ = writeln!(text, "{:.6} {:.6} {:.6}", p.x, p.y, p.z);
    }
    for face in mesh.faces.iter() {
        let _ = writeln!(text, "3 {} {} {}", face[0], face[1], face[2]);
    }
    text
}

fn binary_stl(scene: &Scene) -> Vec<u8> {
    let mesh = meshes(scene).next().expect("a mesh");
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.faces.len() as u32).to_le_bytes());
    for face in 0..mesh.faces.len() {
        bytes.extend([0; 12]);
        for p in mesh.face_positions(face) {
            p.to_array()
                .iter()
                .for_each(|&x| bytes.extend((x as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn faces_as_dxf(scene: &Scene) -> String {
    let mesh = meshes(scene).next().expect("a mesh");
    let mut text = String::from("0\nSECTION\n2\nENTITIES\n");
    for face in 0..mesh.faces.len() / 4 {
        text.push_str("0\n3DFACE\n8\nball\n");
        let corners = mesh.face_positions(face);
        for (k, p) in corners.iter().chain(&corners[2..]).enumerate() {
            let _ = write!(
                text,
                "1{k}\n{:.6}\n2{k}\n{:.6}\n3{k}\n{:.6}\n",
                p.x, p.y, p.z
            );
        }
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

/// Wall and processor seconds of one program on one file: the least of its runs.
#[derive(Clone, Copy)]
struct Cost {
    wall: f64,
    cpu: f64,
}

impl Cost {
    const WORST: Cost = Cost {
        wall: f64::INFINITY,
        cpu: f64::INFINITY,
    };

    fn least(self, other: Cost) -> Cost {
        Cost {
            wall: self.wall.min(other.wall),
            cpu: self.cpu.min(other.cpu),
        }
    }
}

/// Runs a program once; `None` if it is not there or fails.
fn run(program: &str, file: &Path) -> Option<Cost> {
    let before = children_cpu();
    let start = Instant::now();
    let status = Command::new(program)
        .arg("info")
        .arg(file)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .ok()?;
    let cost = Cost {
        wall: start.elapsed().as_secs_f64(),
        cpu: children_cpu() - before,
    };
    status.success().then_some(cost)
}

fn children_cpu() -> f64 {
    let seconds = |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).expect("the system's own numbers");
    seconds(usage.user_time()) + seconds(usage.system_time())
}

/// Both programs in turns, so that what else the machine does hits both.
fn race(file: &Path) -> [Option<Cost>; 2] {
    let programs = [env!("CARGO_BIN_EXE_azulejo"), "assimp"];
    let mut best = [Some(Cost::WORST); 2];
    let start = Instant::now();
    for turn in 0.. {
        if turn >= RUNS && start.elapsed() >= LEAST {
            break;
        }
        for (program, best) in programs.iter().zip(&mut best) {
            *best = best.and_then(|b| Some(b.least(run(program, file)?)));
        }
    }
    best
}

fn measure(file: &Path, smallest: &Path) {
    let megabytes = size(file) as f64 / 1e6;
    let [own, other] = race(file);
    let Some(own) = own else {
        return println!("{}: not read", file.display());
    };
    let cells = |cost: Option<Cost>| match cost {
        Some(c) => (
            format!("{:.1}", c.cpu * 1e3),
            format!("{:.0}", megabytes / c.cpu),
        ),
        None => Default::default(),
    };
    let ratio =
        |of: fn(&Cost) -> f64| other.map_or(String::new(), |o| format!("{:.1}", of(&o) / of(&own)));
    let (own_cpu, own_speed) = cells(Some(own));
    let (other_cpu, other_speed) = cells(other);
    let (scene, peak) = memory(file, smallest);
    let share = if scene > 0.0 {
        format!("{:.1}", peak / scene)
    } else {
        String::new()
    };
    println!(
        "{megabytes:9.3} | {own_cpu:>8} {own_speed:>8} | {other_cpu:>8} {other_speed:>8} | {:>6} {:>6} | {:>7.1}M {:>7.1}M {share:>6} | {}",
        ratio(|c| c.cpu),
        ratio(|c| c.wall),
        scene / 1e6,
        peak / 1e6,
        file.file_name().unwrap_or_default().display(),
    );
}

/// Bytes of the scene's own lists, and most bytes that the process held beyond what it takes to
/// start.
fn memory(file: &Path, smallest: &Path) -> (f64, f64) {
    let Ok(bytes) = fs::read(file) else {
        return (0.0, 0.0);
    };
    let name = file.to_string_lossy();
    let loaded = azulejo_formats::read(&bytes, &name, &Folder::of_model(file));
    let scene = loaded.map_or(0, |l| meshes(&l.scene).map(bytes_of).sum::<usize>());
    let peak = peak_of(file) - peak_of(smallest);
    (scene as f64, peak.max(0.0))
}

fn bytes_of(mesh: &Mesh) -> usize {
    fn attribute<T>(a: &Option<Attribute<T>>) -> usize {
        a.as_ref().map_or(0, |a| {
            let corners = a.corners.as_ref().map_or(0, Vec::len);
            size_of::<T>() * a.values.len() + 4 * corners
        })
    }
    24 * (mesh.positions.len() + mesh.colors.len())
        + attribute(&mesh.normals)
        + attribute(&mesh.uvs)
        + 4 * (mesh.faces.starts.len() + mesh.faces.corners.len())
        + 4 * (mesh.face_materials.len() + mesh.smoothing.len())
}

/// Most bytes that a run of `azulejo info` held at once, as it says itself.
fn peak_of(file: &Path) -> f64 {
    let output = Command::new(env!("CARGO_BIN_EXE_azulejo"))
        .arg("info")
        .arg(file)
        .arg("--json")
        .output();
    let said = output
        .ok()
        .and_then(|o| serde_json::from_slice(&o.stdout).ok());
    said.and_then(|v: serde_json::Value| v["peak_memory_bytes"].as_f64())
        .unwrap_or(0.0)
}
