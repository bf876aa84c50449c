//! Lightmaps as viewers read them: `azulejo bake` as a whole process, against irradiance of other origin.
//!
//! `cargo bench -p azulejo-cli --bench lightmaps -- [NAME...]`, with the environment variable `AZULEJO_DATA`:
//! `reference/real/NAME_{points,normals,E,E_se}.npy` for each `scenes/real/NAME`, path traced by others; for
//! `scenes/s1.obj`, points of `azulejo probe` without patches or interpolation. The file that was written is
//! read again, and the EXR beside it is interpolated at its texture coordinates. Of each chart the side is baked
//! that is the default of OBJ files, and points on the other are left out, which such a lightmap cannot have. The
//! references have the light of facets; where shading normals differ from theirs, lightmaps have that of the smooth
//! surface, as pictures do, and such points are left out too.
//!
//! All errors are over the mean irradiance of the points, less the reference's own noise; what is said is the
//! root mean square of the error map at the points.
#![allow(clippy::print_stdout, reason = "printing is what a benchmark is for")]

use azulejo::models;
use azulejo_cli::parsers::parse_npy;
use azulejo_formats::picture;
use azulejo_scene::math::Ray;
use azulejo_scene::{Image, IrradiancePicture, Scene, Shape};
use azulejo_trace::sampling::hash;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What is baked: the model, the options, and what others took for the like where that was measured.
const WORKS: [(&str, &str, &str); 8] = [
    (
        "s1",
        "--texels 1e5 --error 1%",
        "Blender 51 CPU s, error 2.8% (47,000 texels)",
    ),
    (
        "s1",
        "--texels 1e6 --error 1%",
        "Blender 53 CPU s, error 10.7%",
    ),
    ("hut", "--size 512 --error 4%", ""),
    ("dining", "--size 512 --error 4%", ""),
    ("dining", "--size 1024 --error 2%", ""),
    ("dining", "--size 1024 --error 2% --density auto", ""),
    ("sponza", "--size 512 --error 5%", ""),
    ("sponza", "--size 2048 --error 2%", ""),
];

/// Points of scenes that have no reference of others.
const POINTS: usize = 2000;

/// Part of the scene's size within which a point lies on a surface.
const NEAR: f64 = 1e-5;

/// Cosine of the angle up to which a shading normal is that of the facet.
const SAME_NORMAL: f64 = 0.9999;

/// Difference over the mean above which a point is off.
const OFF: f64 = 0.2;

fn main() {
    let Some(data) = std::env::var_os("AZULEJO_DATA").map(PathBuf::from) else {
        println!("nothing to measure: AZULEJO_DATA is not set");
        return;
    };
    let names: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let folder = std::env::temp_dir().join(format!("azulejo-lightmaps-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for the results");
    println!(
        "{:<45} {:>9} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>6} {:>7} {:>6}",
        "work",
        "texels",
        "said",
        "found",
        "bias",
        "off 20%",
        "none",
        "seams",
        "CPU s",
        "wall s",
        "MiB",
        "in 2SE",
    );
    for (name, options, others) in WORKS {
        if names.is_empty() || names.iter().any(|n| n == name) {
            let work = Work::of(&data, name, &folder);
            println!("{}", work.measured(&folder, options));
            if !others.is_empty() {
                println!("    {others}");
            }
        }
    }
    let _ = fs::remove_dir_all(&folder);
}

/// A model, and its light at some points.
struct Work {
    name: String,
    models: Vec<PathBuf>,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    /// Irradiance, W/m², and its standard errors.
    light: Vec<[f64; 3]>,
    errors: Vec<[f64; 3]>,
}

impl Work {
    fn of(data: &Path, name: &str, folder: &Path) -> Work {
        let real = data.join("scenes/real").join(name);
        if !real.exists() {
            return Work::probed(
                name,
                data.join("scenes").join(format!("{name}.obj")),
                folder,
            );
        }
        let lights = real.join("lights.grf");
        let array = |what: &str| {
            let file = format!("reference/real/{name}_{what}.npy");
            rows(&data.join(file))
                .iter()
                .map(|r| [r[0], r[1], r[2]])
                .collect::<Vec<_>>()
        };
        let vectors = |what| array(what).into_iter().map(DVec3::from).collect();
        Work {
            name: name.to_owned(),
            models: [real.join(format!("{name}.obj")), lights]
                .into_iter()
                .filter(|path| path.exists())
                .collect(),
            points: vectors("points"),
            normals: vectors("normals"),
            light: array("E"),
            errors: array("E_se"),
        }
    }

    /// Points of our own, evenly on the fronts.
    fn probed(name: &str, model: PathBuf, folder: &Path) -> Work {
        let scene = read(&model);
        let (points, normals) = random_points(&scene);
        let mut text = String::new();
        for (p, n) in points.iter().zip(&normals) {
            let _ = writeln!(text, "{} {} {} {} {} {}", p.x, p.y, p.z, n.x, n.y, n.z);
        }
        let [given, found] = ["points.txt", "found.npy"].map(|file| folder.join(file));
        fs::write(&given, text).expect("points are written");
        let options = "--patches 20000 --no-interpolation --error 0.3%";
        let run = Command::new(env!("CARGO_BIN_EXE_azulejo"))
            .arg("probe")
            .arg(&model)
            .args(options.split(' '))
            .arg("--points")
            .arg(&given)
            .arg("-o")
            .arg(&found)
            .output()
            .expect("the program runs");
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        let rows = rows(&found);
        Work {
            name: name.to_owned(),
            models: vec![model],
            points,
            normals,
            light: rows.iter().map(|r| [r[0], r[1], r[2]]).collect(),
            errors: rows.iter().map(|r| [r[3], r[4], r[5]]).collect(),
        }
    }

    /// A line of the table.
    fn measured(&self, folder: &Path, options: &str) -> String {
        let [model, map, error_map] = ["lit.glb", "E.exr", "SE.exr"].map(|file| folder.join(file));
        let run = Command::new(env!("CARGO_BIN_EXE_azulejo"))
            .arg("bake")
            .args(&self.models)
            .args(options.split(' '))
            .args(["--pages", "1", "--json", "-o"])
            .arg(&model)
            .arg("--lightmap")
            .arg(&map)
            .arg("--error-map")
            .arg(&error_map)
            .output()
            .expect("the program runs");
        let work = format!("{} {options}", self.name);
        if !run.status.success() {
            return format!("{work:<45} {}", String::from_utf8_lossy(&run.stderr));
        }
        let report: Value = serde_json::from_slice(&run.stdout).expect("a report");
        let number = |key: &str| report[key].as_f64().unwrap_or(f64::NAN);
        let found = self.compared(&read(&model), &image(&map), &image(&error_map));
        format!(
            "{work:<45} {:>9} {:>6.2}% {:>6.2}% {:>+6.2}% {:>6.2}% {:>6.2}% {:>6.2}% {:>6.1} {:>6.1} {:>7.0} {:>5.0}%",
            number("texels"),
            100.0 * found.stated,
            100.0 * found.error,
            100.0 * found.bias,
            100.0 * found.off,
            100.0 * found.missing,
            100.0 * number("seams"),
            number("cpu_seconds"),
            number("wall_seconds"),
            number("peak_memory_bytes") / f64::from(1 << 20),
            100.0 * found.within,
        )
    }

    fn compared(&self, scene: &Scene, map: &Image, error_map: &Image) -> Comparison {
        let tracer = Tracer::new(scene);
        let read = |at: &Place, image| -> Option<[f64; 3]> {
            let picture = IrradiancePicture {
                texture: 0,
                scale: 1.0,
            };
            Some(picture.at(image, lightmap_uv(scene, at)?).to_array())
        };
        let (mut square, mut sum, mut bias, mut of_map) = (0.0, 0.0, 0.0, 0.0);
        let (mut count, mut missing, mut off, mut within) = (0, 0, 0, 0);
        let mean = self.light.iter().flatten().sum::<f64>() / (3 * self.light.len()) as f64;
        for (place, (light, error)) in self.light.iter().zip(&self.errors).enumerate() {
            let at = match place_of(&tracer, self.points[place], self.normals[place]) {
                Side::Back => continue,
                Side::None => {
                    missing += 1;
                    continue;
                }
                Side::Front(at) => at,
            };
            if is_bent(scene, &at, self.normals[place]) {
                continue;
            }
            let (Some(found), Some(stated)) = (read(&at, map), read(&at, error_map)) else {
                missing += 1;
                continue;
            };
            count += 1;
            let mut difference = 0.0;
            for k in 0..3 {
                let d = found[k] - light[k];
                square += d * d - error[k] * error[k];
                bias += d;
                of_map += stated[k] * stated[k];
                sum += light[k];
                difference += d / 3.0;
                within += usize::from(d.abs() <= 2.0 * stated[k].hypot(error[k]));
            }
            if difference.abs() > OFF * mean {
                off += 1;
            }
        }
        let all = f64::from(count + missing).max(1.0);
        let values = f64::from(3 * count).max(1.0);
        Comparison {
            error: f64::max(square / values, 0.0).sqrt() / (sum / values),
            stated: (of_map / values).sqrt() / (sum / values),
            bias: bias / sum,
            off: f64::from(off) / all,
            missing: f64::from(missing) / all,
            within: within as f64 / values,
        }
    }
}

/// A lightmap beside the truth.
struct Comparison {
    error: f64,
    /// What the error map says of the points.
    stated: f64,
    bias: f64,
    /// Share of the points that differ by more than [`OFF`] of the mean.
    off: f64,
    /// Share of the points without a texel.
    missing: f64,
    /// Share of the values within two standard errors, those of both.
    within: f64,
}

/// A place on a triangle.
struct Place {
    object: u32,
    face: u32,
    u: f64,
    v: f64,
}

/// What lies at a point.
enum Side {
    Front(Place),
    Back,
    None,
}

/// The surface at a point that is seen from where its normal points.
fn place_of(tracer: &Tracer, point: DVec3, normal: DVec3) -> Side {
    let near = NEAR * tracer.bounds().diagonal();
    let ray = Ray {
        origin: point + near * normal,
        direction: -normal,
        t_min: 0.0,
        t_max: 2.0 * near,
    };
    match tracer.hit(&ray) {
        None => Side::None,
        Some(hit) if !hit.entering => Side::Back,
        Some(hit) => Side::Front(Place {
            object: hit.object,
            face: hit.face,
            u: hit.u,
            v: hit.v,
        }),
    }
}

/// Coordinates of the lightmap at a place of a model whose faces are triangles.
fn lightmap_uv(scene: &Scene, at: &Place) -> Option<glam::DVec2> {
    let Shape::Mesh(mesh) = &scene.objects[at.object as usize].shape else {
        return None;
    };
    let first = mesh.faces.corner_range(at.face as usize).start;
    let weights = [1.0 - at.u - at.v, at.u, at.v];
    let corner = |k: usize| Some(weights[k] * mesh.lightmap_uv(first + k)?);
    Some(corner(0)? + corner(1)? + corner(2)?)
}

/// Whether the shading normal at a place is another than that of the facet.
fn is_bent(scene: &Scene, at: &Place, facet: DVec3) -> bool {
    let Shape::Mesh(mesh) = &scene.objects[at.object as usize].shape else {
        return false;
    };
    let Some(normals) = &mesh.normals else {
        return false;
    };
    let first = mesh.faces.corner_range(at.face as usize).start;
    let weights = [1.0 - at.u - at.v, at.u, at.v];
    let corner = |k: usize| normals.at(first + k, mesh.faces.corners[first + k]);
    let normal: DVec3 = (0..3).map(|k| weights[k] * corner(k)).sum();
    normal.normalize_or(facet).dot(facet) < SAME_NORMAL
}

/// Points evenly on the fronts of a scene, with normals.
fn random_points(scene: &Scene) -> (Vec<DVec3>, Vec<DVec3>) {
    let mut triangles = Vec::new();
    let mut area = 0.0;
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else {
            continue;
        };
        for face in 0..mesh.faces.len() {
            let corners = mesh.faces.get(face);
            for t in mesh.triangulate(face) {
                let [a, b, c] = t.map(|k| mesh.positions[corners[k as usize] as usize]);
                area += (b - a).cross(c - a).length();
                triangles.push((area, [a, b, c]));
            }
        }
    }
    let number = |point: usize, dimension: u32| {
        f64::from(hash(&[point as u32, dimension, 77])) / f64::from(u32::MAX)
    };
    let point = |i: usize| {
        let at = area * (i as f64 + number(i, 0)) / POINTS as f64;
        let place = triangles
            .partition_point(|t| t.0 < at)
            .min(triangles.len() - 1);
        let [a, b, c] = triangles[place].1;
        let (root, along) = (number(i, 1).sqrt(), number(i, 2));
        let position = a + root * ((b - a) + along * (c - b));
        (position, (b - a).cross(c - a).normalize())
    };
    (0..POINTS).map(point).unzip()
}

fn read(path: &Path) -> Scene {
    let reading = models::Reading::default();
    let model = models::read(path, &reading, &Progress::new());
    model
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        .scene
}

fn image(path: &Path) -> Image {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    picture::decode(&bytes).expect("a picture")
}

/// Rows of a `.npy` file.
fn rows(path: &Path) -> Vec<Vec<f64>> {
    let bytes = fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let array = parse_npy(&bytes).expect("an array");
    let width = array.shape.get(1).copied().unwrap_or(1);
    array.values.chunks(width).map(<[f64]>::to_vec).collect()
}
