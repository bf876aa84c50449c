//! What no reader would accept is refused before it is written.

use azulejo_scene::{BackIrradiance, Mesh, Rgb, Scene, Shape};

/// Why a scene must not be written, if so: it breaks the promises of scenes, as one does whose light
/// overflowed, or `is_single` and it has light that numbers of 32 bits cannot hold.
pub(super) fn problem(scene: &Scene, is_single: bool) -> Option<String> {
    if let Err(invalid) = scene.validate() {
        return Some(format!("the result is not a valid scene: {invalid}"));
    }
    let brightest = if is_single { brightest(scene) } else { 0.0 };
    (brightest > f64::from(f32::MAX)).then(|| {
        format!("light of {brightest:e} is beyond what numbers of 32 bits hold, as this format has")
    })
}

/// The largest number for light in a scene.
fn brightest(scene: &Scene) -> f64 {
    let largest = |list: &[Rgb]| list.iter().map(|c| c.max_channel()).fold(0.0, f64::max);
    let light = |irradiance: &[Rgb], error: &[Rgb], back: Option<&BackIrradiance>| {
        let back = back.into_iter().flat_map(|b| {
            let lit = b.irradiance.iter().flatten();
            lit.chain(&b.error).map(|c| c.max_channel())
        });
        let front = largest(irradiance).max(largest(error));
        back.fold(front, f64::max)
    };
    let mesh = |m: &Mesh| light(&m.irradiance, &m.irradiance_error, m.back.as_deref());
    let objects = scene.objects.iter().map(|o| match &o.shape {
        Shape::Mesh(m) => mesh(m),
        Shape::Instance(instance) => (instance.light.iter())
            .map(|l| light(&l.irradiance, &l.error, l.back.as_deref()))
            .fold(0.0, f64::max),
        Shape::Primitive(p) => (p.light.iter())
            .map(|l| largest(&l.irradiance).max(largest(&l.error)))
            .fold(0.0, f64::max),
        Shape::Exact(exact) => exact.proxy.iter().map(|m| mesh(m)).fold(0.0, f64::max),
    });
    let emitted = scene.materials.iter().map(|m| m.emission.max_channel());
    let lights = scene.lights.iter().map(|l| l.kind.strength().max_channel());
    objects.chain(emitted).chain(lights).fold(0.0, f64::max)
}
