//! Against a sampled section, with rays that find occluders.

use super::profile::{Profile, normal};
use super::*;
use glam::DVec2;

fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((st, ct), (sp, cp)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(st * cp, st * sp, ct)
}

/// Whether a ray in the section leaves the surface without hitting a cylinder or the floor.
fn is_open(d: f64, h: f64, from: DVec2, towards: DVec2) -> bool {
    let reach = (2.0 / towards.y.max(1e-3) / d).ceil() as i32 + 2;
    let clear = |k: i32| {
        let to_axis = DVec2::new(f64::from(k) * d, 0.0) - from;
        let along = to_axis.dot(towards);
        let off = towards.perp_dot(to_axis).abs();
        // Points of the cylinder itself lie on its circle.
        let chord = (1.0 - off * off).max(0.0).sqrt();
        off > 1.0 || along + chord < 1e-9
    };
    let meets_floor = 2.0 * (1.0 - h * h).sqrt() < d && towards.y < 0.0;
    !meets_floor && (-reach..=reach).all(clear)
}

/// Points of one period with their normals and lengths.
fn sampled(d: f64, h: f64, count: usize) -> Vec<(DVec2, DVec3, f64)> {
    let half = (0.5 * d).min((1.0 - h * h).sqrt());
    let arc = half.asin();
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    let on_arc = |k: usize| {
        let angle = arc * (2.0 * share(k) - 1.0);
        let n = normal(angle);
        (DVec2::new(n.y, n.z), n, 2.0 * arc / count as f64)
    };
    let on_floor = |k: usize| {
        let y = half + (d - 2.0 * half) * share(k);
        (DVec2::new(y, h), DVec3::Z, (d - 2.0 * half) / count as f64)
    };
    let floor = if d - 2.0 * half > 1e-12 { count } else { 0 };
    let arc = (0..count).map(on_arc);
    arc.chain((0..floor).map(on_floor)).collect()
}

fn brute_force(d: f64, h: f64, (kd, ks, n): (f64, f64, f64), wo: DVec3, wi: DVec3) -> f64 {
    let half = (wo + wi).normalize();
    let section = |w: DVec3| DVec2::new(w.y, w.z).normalize();
    let of = |(point, normal, length): (DVec2, DVec3, f64)| {
        let (ni, no) = (normal.dot(wi), normal.dot(wo));
        if ni <= 0.0 || no <= 0.0 {
            return 0.0;
        }
        let open = is_open(d, h, point, section(wi)) && is_open(d, h, point, section(wo));
        let lobe = ks * normalization(n) * normal.dot(half).max(0.0).powf(n);
        f64::from(u8::from(open)) * (kd / std::f64::consts::PI + lobe) * ni * no * length
    };
    let points = sampled(d, h, 20_000);
    points.into_iter().map(of).sum::<f64>() / (d * wo.z * wi.z)
}

#[test]
fn cylinders_are_those_of_brute_force() {
    let check = |d: f64, h: f64, wo: DVec3, wi: DVec3| {
        let (kd, ks, n) = (0.4, 0.6, 30.0);
        let profile = Profile::new(d, h);
        let matt = MattCylinders {
            albedo: Rgb::grey(kd),
            profile,
        };
        let shiny = ShinyCylinders::new(Rgb::grey(ks), n, profile);
        let reflected = matt.eval(wo, wi).r + shiny.eval(wo, wi).r;
        let expected = brute_force(d, h, (kd, ks, n), wo, wi);
        // The error comes from shadow edges between samples.
        assert!(
            (reflected - expected).abs() < 5e-4 * expected + 1e-6,
            "d = {d}, h = {h}, {wo} {wi}: {reflected} instead of {expected}"
        );
    };
    let directions = [
        (30.0, 90.0),
        (62.0, 250.0),
        (75.0, 85.0),
        (20.0, 300.0),
        (80.0, 130.0),
        (45.0, 5.0),
    ];
    for (d, h) in [
        (2.0, 0.0),
        (1.2, 0.2),
        (3.0, 0.5),
        (4.0, 0.0),
        (10.0, 0.9),
        (0.3, 0.0),
    ] {
        for (k, (to, po)) in directions.into_iter().enumerate() {
            for (ti, pi) in directions.into_iter().skip(k) {
                check(d, h, direction(to, po), direction(ti, pi));
            }
        }
    }
}

#[test]
fn what_is_seen_fills_the_view() {
    // The projected width of the visible parts is that of one period, shadowed or not.
    for (d, h) in [
        (2.0, 0.0),
        (1.2, 0.2),
        (3.0, 0.5),
        (4.0, 0.6),
        (1e-3, 0.0),
        (1e3, 0.0),
    ] {
        for (theta, phi) in [
            (0.0, 0.0),
            (30.0, 10.0),
            (70.0, 95.0),
            (89.0, 270.0),
            (89.99, 90.0),
        ] {
            let w = direction(theta, phi);
            let width = Profile::new(d, h).seen(w).projected(w) / (d * w.z);
            assert!(
                (width - 1.0).abs() < 1e-9,
                "d = {d}, h = {h}, {theta}°: {width}"
            );
        }
    }
}

#[test]
fn far_apart_cylinders_are_their_floor() {
    let shiny = ShinyCylinders::new(Rgb::WHITE, 20.0, Profile::new(1e6, 0.5));
    let (wo, wi) = (direction(40.0, 170.0), direction(30.0, 0.0));
    let floor = normalization(20.0) * HalfVector::new(wo, wi).cos_h().powf(20.0);
    assert!((shiny.eval(wo, wi).r / floor - 1.0).abs() < 1e-5);
}
