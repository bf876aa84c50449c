//! Engines on the command line: what ran is said, what is missing too.

use crate::support::Folder;

#[test]
fn the_report_says_what_ran() {
    let folder = Folder::with_room();
    for line in [
        "solve room.obj -o lit.grf --patches 100 --rays 16",
        "form-factors room.obj -o f.npz --patches 100 --rays 16 --engine rays",
    ] {
        let report = folder.json(line);
        assert_eq!(report["engine"], "rays", "{line}");
        let device = report["device"].as_str().unwrap_or("");
        assert!(device.starts_with("built-in kernel"), "{line}: {report}");
    }
}

#[test]
fn missing_embree_is_said_with_what_to_do() {
    let folder = Folder::with_room();
    for engine in ["embree", "rays", "hybrid", "hemicube"] {
        let asked = format!("solve room.obj -o lit.grf --engine {engine} --embree=missing.so");
        folder.fails(&asked, 1, "Embree");
        folder.fails(&asked, 1, "apt install");
    }
    // `--embree` alone does not require Embree: the built-in kernel takes over, with a note.
    let wished = "solve room.obj -o lit.grf --embree=missing.so --patches 100 --rays 16";
    let report = folder.json(wished);
    assert!(
        report["device"]
            .as_str()
            .is_some_and(|d| d.starts_with("built-in kernel"))
    );
    assert!(
        report["engine_notes"]
            .to_string()
            .contains("instead of Embree"),
        "{report}"
    );
}

#[test]
fn options_that_an_engine_does_not_have_are_refused() {
    let folder = Folder::with_room();
    for options in [
        "--engine rays --resolution 64",
        "--patch-points 4",
        "--engine analytic --gpu off",
        "--engine hemicube --resolution 63",
    ] {
        folder.fails(&format!("solve room.obj -o lit.grf {options}"), 2, "--");
    }
}

#[test]
fn a_card_that_is_asked_for_is_opened_or_missed() {
    let folder = Folder::with_room();
    let asked =
        "solve room.obj -o lit.grf --patches 100 --engine hemicube --resolution 16 --gpu vulkan";
    #[cfg(not(feature = "gpu"))]
    folder.fails(asked, 1, "--features gpu");
    #[cfg(feature = "gpu")]
    match azulejo::gpu::Card::open(azulejo::gpu::Backend::Vulkan) {
        Ok(_) => assert!(folder.json(asked)["engine"].is_string()),
        Err(_) => folder.fails(asked, 1, "mesa-vulkan-drivers"),
    }
}

/// Particles solve light, and have no form factors.
#[test]
fn particles_solve_light_alone() {
    let folder = Folder::with_room();
    let report =
        folder.json("solve room.obj -o lit.grf --engine particles --patches 100 --rays 64");
    assert_eq!(report["engine"], "particles");
    let report = folder.json("solve room.obj -o lit.grf --engine rays --patches 100 --rays 64");
    assert_eq!(report["engine"], "rays");
    let refused = "form-factors room.obj -o f.npz --engine particles --patches 100";
    folder.fails(refused, 2, "no form factors");
}

/// In the Cornell box of the common data particles leave as much light as rays do.
#[test]
fn particles_agree_with_rays_in_the_cornell_box() {
    let Some(data) = azulejo_testing::data() else {
        return;
    };
    let scene = data.join("scenes/s1.obj");
    let folder = Folder::new();
    let absorbed = |engine: &str| {
        let line = format!(
            "solve {} -o lit.grf --patches 1500 --rays 256 --engine {engine}",
            scene.display()
        );
        let report = folder.json(&line);
        [0, 1, 2].map(|k| report["absorbed"][k].as_f64().unwrap_or(f64::NAN))
    };
    let (shot, rays) = (absorbed("particles"), absorbed("rays"));
    for (shot, rays) in shot.into_iter().zip(rays) {
        // Rays have 0.3 to 0.5% too much here, half of that with four times as many.
        assert!((shot / rays - 1.0).abs() < 1e-2, "{shot} {rays}");
    }
}

/// The pairing of Sena's thesis: item buffers, and Embree's rays from mirrors.
#[test]
fn hybrid_takes_rays_from_embree() {
    use azulejo::trace::embree::Embree;
    use azulejo_testing::Need;
    if azulejo_testing::require(Need::Embree, Embree::load(None)).is_none() {
        return;
    }
    let folder = Folder::new();
    let example = crate::support::project().join("examples/cornell-mirror.grf");
    let solve = |options: &str| {
        folder.json(&format!(
            "solve {} -o lit.grf --patches 100 --engine hybrid --gpu off --resolution 16 {options}",
            example.display()
        ))
    };
    let (ours, theirs) = (solve(""), solve("--embree"));
    let device = |report: &serde_json::Value| report["device"].as_str().unwrap_or("").to_owned();
    assert_eq!(device(&ours), "processor");
    assert!(
        device(&theirs).starts_with("processor, rays by Embree "),
        "{theirs}"
    );
    let absorbed = |report: &serde_json::Value| report["absorbed"][1].as_f64().unwrap_or(f64::NAN);
    let ratio = absorbed(&theirs) / absorbed(&ours);
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn embree_gives_the_same_light_and_factors() {
    use azulejo::factors::{FormFactorOptions, PatchSize, form_factors};
    use azulejo::trace::{Kernel, Progress, Tracer, embree::Embree};
    use azulejo_testing::Need;
    let Some(embree) = azulejo_testing::require(Need::Embree, Embree::load(None)) else {
        return;
    };
    let kernel = Kernel::Embree(embree);
    let folder = Folder::with_room();
    let report = folder.json("solve room.obj -o lit.grf --engine embree --patches 100 --rays 16");
    assert!(
        report["device"]
            .as_str()
            .is_some_and(|d| d.starts_with("Embree ")),
        "{report}"
    );
    for name in ["cornell.grf", "cornell-mirror.grf"] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
        let bytes = std::fs::read(path.join(name)).unwrap();
        let files = azulejo::formats::Folder::new(&path);
        let scene = azulejo::formats::grf::read(&bytes, name, &files)
            .unwrap()
            .scene;
        let options = FormFactorOptions {
            size: PatchSize::Count(300),
            rays: 256,
            ..Default::default()
        };
        let factors =
            |tracer: &Tracer| form_factors(&scene, tracer, &options, &Progress::new()).unwrap();
        let (ours, theirs) = (
            factors(&Tracer::new(&scene)),
            factors(&Tracer::with_kernel(&scene, &kernel)),
        );
        assert!(theirs.engine_used.device.starts_with("Embree"));
        // A ray that passes an edge within rounding may go either way, once in many thousands.
        let one_ray = 4.0 / 256.0;
        let mut apart = 0.0;
        for i in 0..ours.len() {
            for j in 0..ours.len() as u32 {
                apart += (ours.get(i, j).0 - theirs.get(i, j).0).abs();
            }
        }
        let rows = ours.len() as f64;
        assert!(
            apart < 0.01 * rows * one_ray,
            "{name}: {apart} in {rows} rows"
        );
    }
}
