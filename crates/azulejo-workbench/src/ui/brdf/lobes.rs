//! Sampled lobes and albedo curves, computed in the background.

use super::reflection::{BrdfSum, MaterialReflection};
use azulejo::scene::Rgb;
use azulejo::scene::brdf::check::direction;
use azulejo::scene::math::Frame;
use azulejo::trace::{Cancelled, Progress};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Number of rings around the mirror direction, and of points on each.
pub(super) const RINGS: usize = 44;
pub(super) const SECTORS: usize = 72;

/// Number of angles of the albedo curve.
const ANGLES: usize = 31;

/// Evaluations for each of them in successive passes.
const PASSES: [usize; 2] = [256, 4096];

/// The largest of the angles, degrees.
const MAX_ANGLE: f64 = 89.0;

/// Identifies sampled lobes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LobeKey {
    pub optics: MaterialReflection,
    /// Angles of incidence in degrees; the lobe in space is that of the first.
    pub incidences: Vec<f64>,
    /// Azimuth of the plane of incidence about the normal, degrees.
    pub azimuth: f64,
}

/// Lobes in the plane of incidence, and one of them in space.
#[derive(Clone, Debug)]
pub(super) struct SampledLobes {
    pub slices: Vec<LobeSlice>,
    pub body: LobeSurface,
}

/// A lobe in the plane of incidence.
#[derive(Clone, Debug)]
pub(super) struct LobeSlice {
    /// Angle of incidence in degrees.
    pub incidence: f64,
    /// Angle to the normal in degrees, negative on the light's side, and f_r there, 1/sr.
    pub points: Vec<(f64, Rgb)>,
    /// Mirror reflectance.
    pub mirrored: Rgb,
}

/// A lobe over the whole hemisphere.
#[derive(Clone, Debug)]
pub(super) struct LobeSurface {
    /// Direction to the light.
    pub light: DVec3,
    /// Directions with f_r, in rings around the mirror direction.
    pub rings: Vec<Vec<(DVec3, Rgb)>>,
    /// Mirror reflectance.
    pub mirrored: Rgb,
}

/// Samples lobes.
pub(super) fn lobes(
    key: &LobeKey,
    progress: &Progress,
    show: &mut dyn FnMut(SampledLobes),
) -> Result<(), Cancelled> {
    let reflector = key.optics.reflector();
    let slices = key.incidences.iter().map(|&incidence| {
        progress.advance(1)?;
        Ok(slice(&reflector, incidence, key.azimuth))
    });
    let slices = slices.collect::<Result<Vec<_>, Cancelled>>()?;
    let first = key.incidences.first().copied().unwrap_or(0.0);
    let body = body(&reflector, first, key.azimuth, progress)?;
    show(SampledLobes { slices, body });
    Ok(())
}

/// Samples a lobe in the plane of incidence, more densely around the mirror direction, where it may
/// be narrow.
fn slice(reflector: &BrdfSum, incidence: f64, azimuth: f64) -> LobeSlice {
    let wide = (-90..=90).map(f64::from);
    let close = (-120..=120).map(|k: i32| {
        let t = f64::from(k) / 120.0;
        incidence + 15.0 * t * t.abs()
    });
    // Not the mirror direction itself: where the half vector equals the normal, anisotropic models
    // have a value unlike their neighbours'.
    let is_drawn = |a: &f64| a.abs() < 89.99 && (a - incidence).abs() > 1e-7;
    let mut angles: Vec<f64> = wide.chain(close).filter(is_drawn).collect();
    angles.sort_by(f64::total_cmp);
    let wi = direction(-incidence, azimuth);
    let value = |a: f64| (a, reflector.eval(direction(a, azimuth), wi));
    LobeSlice {
        incidence,
        points: angles.into_iter().map(value).collect(),
        mirrored: reflector.mirror(wi.z),
    }
}

fn body(
    reflector: &BrdfSum,
    incidence: f64,
    azimuth: f64,
    progress: &Progress,
) -> Result<LobeSurface, Cancelled> {
    let light = direction(-incidence, azimuth);
    let axis = DVec3::new(-light.x, -light.y, light.z);
    let frame = Frame::from_normal(axis);
    let ring = |ring: usize| {
        progress.advance(1)?;
        let share = ring as f64 / RINGS as f64;
        let sector = |k: usize| {
            let w = around(&frame, share, TAU * k as f64 / SECTORS as f64);
            (w, reflector.eval(w, light))
        };
        Ok((0..SECTORS).map(sector).collect())
    };
    Ok(LobeSurface {
        light,
        rings: (0..=RINGS).map(ring).collect::<Result<_, Cancelled>>()?,
        mirrored: reflector.mirror(light.z),
    })
}

/// A direction at a fraction of the way from the axis of `frame` to the horizon.
fn around(frame: &Frame, share: f64, turn: f64) -> DVec3 {
    let side = frame.to_world(DVec3::new(turn.cos(), turn.sin(), 0.0));
    // Angle along the great circle toward `side` up to the horizon.
    let reach = frame.z.z.atan2(-side.z).min(PI);
    // Denser around the axis, where the lobe may be narrow.
    let (sin, cos) = (0.9999 * reach * share.powf(2.2)).sin_cos();
    frame.z * cos + side * sin
}

/// Identifies an albedo curve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AlbedoKey {
    pub optics: MaterialReflection,
    /// Degrees.
    pub azimuth: f64,
}

/// Angles of incidence in degrees, with the albedo.
pub(super) type AlbedoCurve = Vec<(f64, Rgb)>;

/// Samples an albedo curve: a first one that can follow a slider, then the final one.
pub(super) fn albedo(
    key: &AlbedoKey,
    progress: &Progress,
    show: &mut dyn FnMut(AlbedoCurve),
) -> Result<(), Cancelled> {
    let reflector = key.optics.reflector();
    for samples in PASSES {
        let point = |k: usize| {
            progress.advance(1)?;
            let angle = MAX_ANGLE * k as f64 / (ANGLES - 1) as f64;
            let wo = direction(angle, key.azimuth);
            Ok((angle, reflector.albedo(wo, samples)))
        };
        show((0..ANGLES).map(point).collect::<Result<_, Cancelled>>()?);
    }
    Ok(())
}

/// The largest difference between two lobes for the same direction of light: of f_r cos θ over all
/// channels, in 1/sr, with its angle to the normal in degrees.
pub(super) fn largest_difference(a: &LobeSurface, b: &LobeSurface) -> (f64, f64) {
    let pairs = a.rings.iter().flatten().zip(b.rings.iter().flatten());
    let off = pairs.map(|(&(w, f), &(_, g))| {
        let difference = (0..3).map(|c| (f[c] - g[c]).abs()).fold(0.0, f64::max);
        (difference * w.z, w.z.clamp(-1.0, 1.0).acos().to_degrees())
    });
    off.fold(
        (0.0, 0.0),
        |most, value| if value.0 > most.0 { value } else { most },
    )
}

/// The largest difference between two curves over all channels, with its angle in degrees.
pub(super) fn largest_albedo_difference(a: &AlbedoCurve, b: &AlbedoCurve) -> (f64, f64) {
    let off = a.iter().zip(b).map(|((angle, x), (_, y))| {
        (
            (0..3).map(|c| (x[c] - y[c]).abs()).fold(0.0, f64::max),
            *angle,
        )
    });
    off.fold(
        (0.0, 0.0),
        |most, value| if value.0 > most.0 { value } else { most },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use azulejo::scene::Material;

    fn found(material: &Material, incidence: f64) -> SampledLobes {
        let key = LobeKey {
            optics: MaterialReflection::of(material),
            incidences: vec![incidence],
            azimuth: 0.0,
        };
        let mut result = None;
        lobes(&key, &Progress::new(), &mut |lobes| result = Some(lobes)).unwrap();
        result.unwrap()
    }

    #[test]
    fn a_matt_surface_is_the_same_in_all_directions() {
        let lobes = found(&Material::diffuse("", Rgb::grey(0.5)), 45.0);
        let value = 0.5 / PI;
        let slice = lobes.slices[0].points.iter().map(|p| p.1);
        let body = lobes.body.rings.iter().flatten().map(|p| p.1);
        assert!(slice.chain(body).all(|f| (f.r - value).abs() < 1e-12));
        let lowest = lobes.body.rings.iter().flatten().map(|p| p.0.z);
        assert!(lowest.fold(1.0, f64::min) > 0.0);
    }

    #[test]
    fn differences_are_found_where_they_are() {
        let at = |grey: f64| found(&Material::diffuse("", Rgb::grey(grey)), 0.0);
        let (most, angle) = largest_difference(&at(0.5).body, &at(0.2).body);
        assert!(
            (most - 0.3 / PI).abs() < 1e-3 && angle < 1.0,
            "{most} {angle}"
        );
        let curve = |grey| vec![(0.0, Rgb::grey(0.1)), (60.0, Rgb::grey(grey))];
        let (most, angle) = largest_albedo_difference(&curve(0.4), &curve(0.9));
        assert!((most - 0.5).abs() < 1e-12 && angle == 60.0);
    }

    #[test]
    fn cancelled_work_stops() {
        let key = AlbedoKey {
            optics: MaterialReflection::of(&Material::default()),
            azimuth: 0.0,
        };
        let progress = Progress::new();
        progress.cancel();
        let mut shown = false;
        assert!(albedo(&key, &progress, &mut |_| shown = true).is_err() && !shown);
    }
}
