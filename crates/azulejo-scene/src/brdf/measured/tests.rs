//! Tables made of known models.

use super::warp::{Tables, Warp, mix};
use super::*;
use crate::brdf::vndf::Ggx;
use crate::brdf::{Brdf, Content, Description};
use std::f64::consts::FRAC_PI_2;

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

fn brdf(measured: Measured) -> Brdf {
    Brdf::new(Description::File {
        path: "measured".to_owned(),
        content: Some(Arc::new(Content::Measured(Arc::new(measured)))),
    })
    .unwrap()
}

fn merl(model: &str) -> (Brdf, Brdf) {
    let model = Brdf::new(model.parse().unwrap()).unwrap();
    let table = Merl::tabulated([45, 30, 36], |wo, wi| model.eval(wo, wi)).unwrap();
    (model, brdf(Measured::Merl(table)))
}

/// The table reproduces the model where it is smooth over bins, and has the same albedo.
#[test]
fn merl_tables_are_near_their_models() {
    let check = |text: &str, tolerance: f64| {
        let (model, table) = merl(text);
        for (o, i) in [((30.0, 10.0), (40.0, 170.0)), ((0.0, 0.0), (10.0, 77.0))] {
            let (wo, wi) = (direction(o.0, o.1), direction(i.0, i.1));
            let (value, expected) = (table.eval(wo, wi).g, model.eval(wo, wi).g);
            let off = (value / expected - 1.0).abs();
            assert!(off < tolerance, "{text}: {value}, expected {expected}");
            let back = table.eval(wi, wo).g;
            assert!((value / back - 1.0).abs() < 1e-12, "{text}: reciprocity");
        }
        for theta in [0.0, 30.0, 60.0] {
            let wo = direction(theta, 50.0);
            let (value, expected) = (table.albedo(wo).g, model.albedo(wo).g);
            let off = (value / expected - 1.0).abs();
            assert!(off < tolerance, "{text} at {theta}°: {value}, {expected}");
        }
    };
    check("diffuse kd = 0.6", 0.01);
    check("lewis kd = 0.2 ks = 0.6 n = 20", 0.03);
    check("ward_gmd rd = 0.1 rs = 0.5 ax = 0.2 ay = 0.2", 0.05);
}

/// Perfectly reflecting GGX facets on RGL's warped grid. The tables agree with the model.
fn rgl(phi_i: &[f32], facets: Ggx) -> Rgl {
    let theta_i: Vec<f32> = (0..8).map(|k| k as f32 / 7.0 * 1.5).collect();
    let (w, h) = (48, 32);
    let node = |k: usize, n: usize| k as f64 / (n - 1) as f64;
    let half = |place: [f64; 2]| {
        let (sin, cos) = (place[0] * place[0] * FRAC_PI_2).sin_cos();
        let (sp, cp) = (std::f64::consts::TAU * (place[1] - 0.5)).sin_cos();
        DVec3::new(sin * cp, sin * sp, cos)
    };
    let places = || (0..w * h).map(|k| [node(k % w, w), node(k / w, h)]);
    let grid = |values: Vec<f32>| Grid {
        width: w,
        height: h,
        values,
    };
    let ndf = places().map(|p| facets.density(half(p)) as f32).collect();
    let sigma = |p| 1.0 / facets.visible_over_cos(half(p));
    let sigma = places().map(|p| sigma(p) as f32).collect();
    let (mut vndf, mut rgb) = (Vec::new(), Vec::new());
    for phi in phi_i {
        for theta in &theta_i {
            let wo = direction(f64::from(*theta).to_degrees(), f64::from(*phi).to_degrees());
            let seen = |p: [f64; 2]| {
                let h = half(p);
                let area = p[0] * (p[0] * p[0] * FRAC_PI_2).sin();
                (facets.density(h) * wo.dot(h).max(0.0) * area) as f32
            };
            let table: Vec<f32> = places().map(seen).collect();
            let warp = Warp::new(Tables::new(w, h, table.clone()).unwrap());
            vndf.extend(table);
            let light = |p: [f64; 2]| {
                let m = half(warp.sample(&mix([&[0.0], &[0.0]], [0.0, 0.0]), p));
                let wi = m * (2.0 * wo.dot(m)) - wo;
                let seen = wi.z * facets.visible_over_cos(wi);
                if wi.z > 0.0 { seen as f32 } else { 0.0 }
            };
            let reflected: Vec<f32> = places().map(light).collect();
            (0..3).for_each(|_| rgb.extend(&reflected));
        }
    }
    Rgl::new(RglTensors {
        luminance: grid(
            rgb.chunks(3 * w * h)
                .flat_map(|t| t[..w * h].to_vec())
                .collect(),
        ),
        theta_i,
        phi_i: phi_i.to_vec(),
        ndf: grid(ndf),
        sigma: grid(sigma),
        vndf: grid(vndf),
        rgb: grid(rgb),
        jacobian: true,
    })
    .unwrap()
}

fn ggx(facets: &Ggx, wo: DVec3, wi: DVec3) -> f64 {
    let h = (wo + wi).normalize();
    let seen = facets.visible_over_cos(wo) * facets.visible_over_cos(wi);
    0.25 * facets.density(h) * seen
}

#[test]
fn rgl_tables_are_near_their_models() {
    let check = |phi: &[f32], ax: f64, ay: f64| {
        let facets = Ggx { ax, ay };
        let table = brdf(Measured::Rgl(Box::new(rgl(phi, facets))));
        for (o, i) in [
            ((30.0, 10.0), (40.0, 170.0)),
            ((20.0, 200.0), (10.0, 77.0)),
            ((50.0, 300.0), (45.0, 110.0)),
        ] {
            let (wo, wi) = (direction(o.0, o.1), direction(i.0, i.1));
            let (value, expected) = (table.eval(wo, wi).g, ggx(&facets, wo, wi));
            let off = (value / expected - 1.0).abs();
            assert!(off < 0.1, "{phi:?} {o:?}: {value}, expected {expected}");
        }
    };
    let whole: Vec<f32> = (0..17)
        .map(|k| (k as f32 / 8.0 - 1.0) * std::f32::consts::PI)
        .collect();
    check(&[0.0], 0.4, 0.4);
    check(&whole, 0.3, 0.5);
    check(&whole[8..], 0.3, 0.5);
    check(&whole[8..13], 0.3, 0.5);
}

/// Samples follow their density in every cell of a grid over the hemisphere.
#[test]
fn samples_follow_their_density() {
    let facets = Ggx { ax: 0.3, ay: 0.5 };
    let quarter = [0.0, 0.4, 0.8, 1.2, 1.570_796_4];
    let tables = [
        merl("lewis kd = 0.2 ks = 0.6 n = 20").1,
        brdf(Measured::Rgl(Box::new(rgl(&[0.0], facets)))),
        brdf(Measured::Rgl(Box::new(rgl(&quarter, facets)))),
    ];
    for table in &tables {
        for wo in [
            direction(0.0, 0.0),
            direction(50.0, 20.0),
            direction(75.0, 250.0),
        ] {
            let worst = deviation(table, wo);
            assert!(worst < 5.5, "{table:?} {wo}: {worst} σ");
        }
    }
}

/// The largest deviation of a cell's count from its expectation by the density, in standard
/// deviations.
fn deviation(brdf: &Brdf, wo: DVec3) -> f64 {
    const N: usize = 60_000;
    let (rows, columns) = (8, 16);
    let cell = |wi: DVec3| {
        let row = ((wi.z * rows as f64) as usize).min(rows - 1);
        let turn = square::azimuth_coordinate(square::azimuth(wi));
        row * columns + ((turn * columns as f64) as usize).min(columns - 1)
    };
    let mut counts = vec![0.0; rows * columns];
    let mut state = 1u64;
    let mut random = || {
        // Knuth's linear congruence; the high bits are good enough to count with.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..N {
        if let Some(sample) = brdf.sample(wo, [random(), random(), random()]) {
            counts[cell(sample.wi)] += 1.0;
        }
    }
    let fine = 24;
    let mut expected = vec![0.0; rows * columns];
    for k in 0..rows * fine * columns * fine {
        let z = ((k / (columns * fine)) as f64 + 0.5) / (rows * fine) as f64;
        let phi = ((k % (columns * fine)) as f64 + 0.5) / (columns * fine) as f64;
        let (sin, cos) = (std::f64::consts::TAU * phi).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let wi = DVec3::new(r * cos, r * sin, z);
        let area = std::f64::consts::TAU / (rows * fine * columns * fine) as f64;
        expected[cell(wi)] += brdf.pdf(wo, wi) * area * N as f64;
    }
    // Allows for an error of 1 % of the expectation, which is found by quadrature.
    let off = |(n, e): (&f64, &f64)| ((n - e).abs() - 0.01 * e).max(0.0) / e.max(10.0).sqrt();
    counts.iter().zip(&expected).map(off).fold(0.0, f64::max)
}
