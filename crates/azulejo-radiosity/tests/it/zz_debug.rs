use azulejo_radiosity::analytic::visible_form_factor;
use azulejo_radiosity::*;
use azulejo_scene::synthetic::room_with_table;
use azulejo_trace::{Progress, Tracer};
use glam::DVec3;

#[test]
fn zz_debug() {
    let scene = room_with_table(150);
    let options = FormFactorOptions {
        engine: Engine::Analytic,
        size: PatchSize::Edge(0.0),
        ..FormFactorOptions::default()
    };
    let found = form_factors(&scene, &Tracer::new(&scene), &options, &Progress::new()).unwrap();
    let patches = Patches::new(&scene, PatchSize::Edge(0.0));
    let all: Vec<Vec<DVec3>> = (0..patches.len())
        .map(|i| patches.polygon(i).unwrap().to_vec())
        .collect();
    let sums = found.row_sums();
    for (i, s) in sums.iter().enumerate() {
        if (s - 1.0).abs() > 1e-4 {
            eprintln!("row {i}: {s:.6} n {:?} {:?}", patches.normal(i), all[i]);
        }
    }
    let worst = (0..all.len())
        .max_by(|&a, &b| (sums[a] - 1.0).abs().total_cmp(&(sums[b] - 1.0).abs()))
        .unwrap();
    let mut total = 0.0;
    for j in 0..all.len() {
        let exact = visible_form_factor(&all[worst], &all[j], &all, 1e-7);
        total += exact.value;
        let got = found.get(worst, j as u32).0;
        if (exact.value - got).abs() > 1e-5 {
            eprintln!(
                "{worst} {j}: {got:.7} exact {:.7} ± {:.1e} {:?} {:?}",
                exact.value,
                exact.error,
                patches.normal(j),
                all[j]
            );
        }
    }
    eprintln!("row {worst} sums to {} and exactly {total}", sums[worst]);
}
