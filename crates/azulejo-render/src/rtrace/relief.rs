//! Bump maps: textures that perturb the normal.

use super::noise::{Octaves, noise, vector_noise, wave};
use super::texture::TexturedSurface;
use azulejo_scene::rtrace::RtraceTextureKind;
use azulejo_trace::sampling::uniform;
use glam::DVec3;

/// Number of sources of ripples and waves.
const SOURCES: u32 = 10;

/// Applies a texture that perturbs the normal; ignores other kinds.
pub(super) fn apply(textured: &mut TexturedSurface, kind: &RtraceTextureKind, point: &mut DVec3) {
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
        Round { k } => round(textured.normal, k, point),
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
        Bump3 { k, size } => return displace(textured, k, size, point),
        _ => return,
    };
    textured.normal = (textured.normal + bent).normalize_or(textured.normal);
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

/// Circular waves from all sources, each with its frequency multiplied by `factor`.
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

/// Displaces the surface, and computes its normal from four displaced points around.
fn displace(textured: &mut TexturedSurface, k: f64, size: f64, point: &mut DVec3) {
    if k < 1e-12 {
        return;
    }
    let p = *point;
    let moved = |p: DVec3| p + k * vector_noise(p);
    *point = moved(p);
    textured.position += *point - p;
    let [u, v] = across(textured.normal).map(|d| size * d);
    let around = [v, u, -v, -u].map(|d| moved(p + d) - *point);
    let normal: DVec3 = (0..4).map(|i| around[i].cross(around[(i + 1) % 4])).sum();
    textured.normal = normal.try_normalize().unwrap_or(textured.normal);
}
