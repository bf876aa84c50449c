//! Textures that bend the normal.

use super::noise::{Octaves, noise, vector_noise, wave};
use super::texture::Painted;
use azulejo_scene::rtrace::RtraceTextureKind;
use azulejo_trace::sampling::uniform;
use glam::DVec3;

/// Where ripples and waves come from.
const SOURCES: u32 = 10;

/// Applies a texture that bends the normal; others do nothing here.
pub(super) fn apply(painted: &mut Painted, kind: &RtraceTextureKind, point: &mut DVec3) {
    use RtraceTextureKind::*;
    let p = *point;
    let bent = match *kind {
        Bump { k } => k * vector_noise(p),
        FbmBump {
            offset,
            k,
            omega,
            lambda,
            octaves,
        } => {
            let sum = Octaves::brownian(omega, lambda, octaves).vector_sum(p);
            k * (sum + DVec3::splat(offset))
        }
        Round { k } => round(painted.normal, k, point),
        Ripples {
            frequency,
            phase,
            k,
        } => ripples(p, frequency, phase, k, |_| 1.0),
        Waves {
            frequency,
            phase,
            k,
        } => ripples(p, frequency, phase, k, source_frequency),
        Dents { k } => k * noise(p) * vector_noise(p),
        Wrinkles { k } => k * wrinkles(p),
        Bump3 { k, size } => return displace(painted, k, size, point),
        _ => return,
    };
    painted.normal = (painted.normal + bent).normalize_or(painted.normal);
}

/// Two directions across a normal.
fn across(normal: DVec3) -> [DVec3; 2] {
    let other = if normal.y.abs() > 1.0 - 1e-12 {
        DVec3::X
    } else {
        DVec3::Y
    };
    let u = normal.cross(other).normalize_or_zero();
    [u, u.cross(normal)]
}

/// Two amounts of noise across the normal; the point moves by the first.
fn round(normal: DVec3, k: f64, point: &mut DVec3) -> DVec3 {
    let strength = 1.0 - k;
    if strength < 1e-12 {
        return DVec3::ZERO;
    }
    let [u, v] = across(normal);
    let first = 2.0 * noise(*point) - 1.0;
    *point += DVec3::splat(first);
    let second = (2.0 * noise(*point) - 1.0) * (1.0 - first * first).sqrt();
    strength * (first * u + second * v)
}

/// Round waves from all sources, each as fast as `factor` says.
fn ripples(p: DVec3, frequency: f64, phase: f64, k: f64, factor: impl Fn(u32) -> f64) -> DVec3 {
    let waves = (0..SOURCES).map(|i| {
        let away = p - source(i);
        let distance = match away.length() {
            d if d < 1e-12 => 1.0,
            d => d,
        };
        let f = factor(i);
        f * wave(distance * frequency * f + phase) / distance * away
    });
    k / f64::from(SOURCES) * waves.sum::<DVec3>()
}

fn source(i: u32) -> DVec3 {
    vector_noise(DVec3::new(f64::from(i), 0.0, 0.0)).normalize_or(DVec3::X)
}

fn source_frequency(i: u32) -> f64 {
    f64::from(uniform(&[i]))
}

fn wrinkles(p: DVec3) -> DVec3 {
    let folds = (1..10).map(|k| {
        let f = f64::from(1 << k);
        vector_noise(f * p).abs() / f
    });
    vector_noise(p) + folds.sum::<DVec3>()
}

/// Moves the surface itself, and takes the normal of what it became, from four points around.
fn displace(painted: &mut Painted, k: f64, size: f64, point: &mut DVec3) {
    if k < 1e-12 {
        return;
    }
    let p = *point;
    let moved = |p: DVec3| p + k * vector_noise(p);
    *point = moved(p);
    painted.position += *point - p;
    let [u, v] = across(painted.normal).map(|d| size * d);
    let around = [v, u, -v, -u].map(|d| moved(p + d) - *point);
    let normal: DVec3 = (0..4).map(|i| around[i].cross(around[(i + 1) % 4])).sum();
    painted.normal = normal.try_normalize().unwrap_or(painted.normal);
}
