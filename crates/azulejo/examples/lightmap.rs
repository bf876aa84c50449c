//! Bakes the lightmap of models and compares it with the light of given points.
use azulejo::bake::UnwrapOptions;
use azulejo::lightmap::{BakeOptions, BakedLight, BakedSides, bake};
use azulejo::models;
use azulejo::radiosity::{FirstPass, PatchSize};
use azulejo::scene::math::Aabb;
use azulejo::trace::{Progress, Tracer};
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let number = |name: &str, rest: f64| {
        let at = args.iter().position(|a| a == name);
        at.map_or(rest, |at| args[at + 1].parse().unwrap())
    };
    let progress = Progress::new();
    let mut scene: Option<azulejo::scene::Scene> = None;
    for path in args[1..].iter().take_while(|a| !a.starts_with("--")) {
        let model = models::read(path.as_ref(), &models::Reading::default(), &progress).unwrap();
        match &mut scene {
            None => scene = Some(model.scene),
            Some(whole) => whole.merge(model.scene),
        }
    }
    let mut scene = scene.unwrap();
    if args.iter().any(|a| a == "--cut") { scene = azulejo::lightmap::meshes_of(&scene, true); }
    let start = Instant::now();
    let tracer = Tracer::new(&scene);
    let options = BakeOptions {
        charts: UnwrapOptions { size: number("--size", 512.0) as u32, ..Default::default() },
        pass: FirstPass {
            error: Some(number("--error", 1.0) / 100.0),
            size: PatchSize::Squares(number("--patches", 1500.0) as usize),
            ..FirstPass::default()
        },
        light: BakedLight::Total,
        sides: BakedSides::Brighter,
    };
    let objects: Vec<u32> = (0..scene.objects.len() as u32).collect();
    let done = std::sync::atomic::AtomicBool::new(false);
    let baked = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut last = (String::new(), Instant::now());
            while !done.load(std::sync::atomic::Ordering::Relaxed) {
                std::thread::sleep(std::time::Duration::from_millis(20));
                if progress.stage() != last.0 {
                    eprintln!("{:24} {:.2} s", last.0, last.1.elapsed().as_secs_f64());
                    last = (progress.stage(), Instant::now());
                }
            }
        });
        let baked = bake(&scene, &tracer, &objects, &options, &progress);
        done.store(true, std::sync::atomic::Ordering::Relaxed);
        baked.unwrap()
    });
    let cpu = std::fs::read_to_string("/proc/self/stat").unwrap();
    let cpu: Vec<&str> = cpu.split(' ').collect();
    let cpu = (cpu[13].parse::<f64>().unwrap() + cpu[14].parse::<f64>().unwrap()) / 100.0;
    let r = &baked.report;
    println!(
        "{} charts, {} texels covered, {} nodes, {:.2} s, {cpu:.2} CPU s; patches {}, error {:.3}% ({:?}), {} rays/pt, path traced {:.1}%",
        baked.atlas.layout.charts, baked.texels.samples, baked.texels.nodes,
        start.elapsed().as_secs_f64(), r.patches, 100.0 * r.error, r.error_parts, r.point_rays, 100.0 * r.path_traced,
    );
    println!("stated {:.3}%, mean {:?}, interpolation {:.3}%, buried {}, seams {:?}", 100.0 * baked.lightmap.relative_error(), baked.lightmap.mean(), 100.0 * baked.texels.interpolation / baked.lightmap.mean().mean(), baked.lightmap.buried, baked.seams);
    if let Some(at) = args.iter().position(|a| a == "--points") {
        let (mut squares, mut sum, mut bias, mut n, mut missing, mut off) = (0.0, 0.0, 0.0, 0, 0, 0);
        let text = std::fs::read_to_string(&args[at + 1]).unwrap();
        let rows: Vec<Vec<f64>> = text.lines().map(|l| l.split_whitespace().map(|x| x.parse().unwrap()).collect()).collect();
        let all: f64 = rows.iter().map(|r| (r[6] + r[7] + r[8]) / 3.0).sum::<f64>() / rows.len() as f64;
        let bounds = scene.objects.iter().fold(Aabb::EMPTY, |b, o| b.union(o.bounds()));
        let near = 1e-4 * bounds.diagonal();
        // The nearest triangle by brute force over a grid of boxes would be faster; this is a tool.
        let mut boxes = Vec::new();
        for (k, receiver) in baked.atlas.receivers.iter().enumerate() {
            for t in 0..receiver.triangles.len() { boxes.push((k, t, Aabb::around(receiver.corners(t).into_iter()))); }
        }
        let mut worst = Vec::new();
        for row in &rows {
            let p = glam::DVec3::new(row[0], row[1], row[2]);
            let normal = glam::DVec3::new(row[3], row[4], row[5]);
            let mut found: Option<(f64, usize, usize, [f64; 3])> = None;
            for (k, t, b) in &boxes {
                if (p - p.clamp(b.min, b.max)).length() > near { continue; }
                let receiver = &baked.atlas.receivers[*k];
                let c = receiver.corners(*t);
                let area = receiver.area_vector(*t);
                let flat = area.normalize_or_zero();
                if flat.dot(normal).abs() < 0.9 { continue; }
                let w = |a: glam::DVec3, b: glam::DVec3| 0.5 * (a - p).cross(b - p).dot(flat) / area.length();
                let weights = [w(c[1], c[2]), w(c[2], c[0]), w(c[0], c[1])];
                let off = (p - c[0]).dot(flat).abs();
                if weights.iter().all(|&w| w > -1e-3) && off < near && found.is_none_or(|(o, ..)| off < o) { found = Some((off, *k, *t, weights)); }
            }
            let Some((_, k, t, weights)) = found else { missing += 1; continue };
            let Some(e) = baked.irradiance(k, t, weights) else { missing += 1; continue };
            for (c, x) in e.to_array().iter().enumerate() {
                let d = x - row[6 + c];
                squares += d * d; bias += d; sum += row[6 + c];
            }
            let far = (e.mean() - (row[6] + row[7] + row[8]) / 3.0).abs() / all;
            if far > 0.2 { off += 1; worst.push((far, p, e.mean(), (row[6] + row[7] + row[8]) / 3.0)); }
            n += 3;
        }
        let mean = sum / n as f64;
        println!("points {}: RMSE {:.3}%, bias {:+.3}%, off by 20%: {:.3}%, missing {:.3}%", rows.len(), 100.0 * (squares / n as f64).sqrt() / mean, 100.0 * bias / sum, 100.0 * off as f64 / rows.len() as f64, 100.0 * missing as f64 / rows.len() as f64);
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        for w in worst.iter().take(10) { println!("  {w:?}"); }
    }
}
