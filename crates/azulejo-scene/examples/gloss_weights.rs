use azulejo_scene::brdf::Brdf;
use glam::DVec3;
fn main() {
    for text in std::env::args().skip(1) {
        let brdf = Brdf::new(text.parse().unwrap()).unwrap();
        println!("{text}");
        let mut all = [0.0; 3];
        for k in 0..10 {
            let cos = (k as f64 + 0.5) / 10.0;
            let sin = (1.0 - cos * cos as f64).sqrt();
            let wo = DVec3::new(sin, 0.0, cos);
            let n = 20000;
            let (mut s1, mut s2, mut lost, mut top) = (0.0, 0.0, 0.0, 0.0f64);
            for i in 0..n {
                let u = [1.0, 2.0, 3.0].map(|d: f64| {
                    let a = [0.0, 0.8191725133961645, 0.6710436067037893, 0.5497004779019703][d as usize];
                    (0.5 + a * i as f64).fract()
                });
                match brdf.glossy().sample(wo, [u[0], u[1], u[2]]) {
                    Some(s) => { let w = s.weight.mean(); s1 += w; s2 += w * w; top = top.max(w); }
                    None => lost += 1.0,
                }
            }
            let n = n as f64;
            let (m, q) = (s1 / n, s2 / n);
            all[0] += 2.0 * cos * 0.1 * m; all[1] += 2.0 * cos * 0.1 * q;
            println!("  cos {cos:.2} mean {m:.3} mirror {:.3} E[w2]/m2 {:.3} lost {:.3} max {top:.2}", brdf.narrow().mirror(cos).mean(), q / (m * m), lost / n);
        }
        println!("  all mean {:.3} E[w2] {:.3}", all[0], all[1]);
    }
}
