//! Closed formulas of grey enclosures. Emissivities and reflectances are 0..1, lengths metres, areas square
//! metres, and so are conductances GR: Q = σ GR (T₁⁴ − T₂⁴); of infinitely long enclosures per metre.

/// The Stefan–Boltzmann constant, W/(m²K⁴), CODATA 2018.
pub const SIGMA: f64 = 5.670_374_419e-8;

/// GR of two infinite parallel plates over their area, whatever part of their reflection is specular.
pub fn plates(e1: f64, e2: f64) -> f64 {
    1.0 / (1.0 / e1 + 1.0 / e2 - 1.0)
}

/// GR of conductances in series: their resistances are added.
pub fn in_series(conductances: &[f64]) -> f64 {
    1.0 / conductances.iter().map(|g| 1.0 / g).sum::<f64>()
}

/// GR of a grey surface of emissivity e and its own radiosity, e A/(1 − e).
pub fn surface_conductance(e: f64, area: f64) -> f64 {
    e * area / (1.0 - e)
}

/// GR of concentric spheres or long cylinders, the first inside. Of the outer one's reflectance the
/// share `mirror2` is specular; that of the inner one may be anything. A disk under a dome follows the
/// same formula without mirror.
pub fn concentric(areas: [f64; 2], emissivity: [f64; 2], mirror2: f64) -> f64 {
    let ([a1, a2], [e1, e2]) = (areas, emissivity);
    let ends = 1.0 - mirror2;
    a1 / (1.0 / e1 + a1 / a2 * (1.0 / e2 - 1.0 / ends) + mirror2 / ends)
}

/// B_ij of the inside of a sphere in parts of these areas and emissivities, the same for every i:
/// F_ij = A_j/A.
pub fn part_of_sphere(areas: &[f64], emissivity: &[f64], j: usize) -> f64 {
    let absorbing: f64 = areas.iter().zip(emissivity).map(|(a, e)| a * e).sum();
    areas[j] * emissivity[j] / absorbing
}

/// Apparent emissivity of the hole of a spherical cavity of emissivity e, where the hole is the share f
/// of the sphere.
pub fn hole_of_sphere(e: f64, f: f64) -> f64 {
    e / (1.0 - (1.0 - e) * (1.0 - f))
}

/// GR of two black surfaces that do not see themselves, and all of whose other directions end on a
/// reradiating surface (Hottel): F̄₁₂ A₁ = A₁ (A₂ − A₁F₁₂²)/(A₁ + A₂ − 2 A₁F₁₂).
pub fn reradiating(a1: f64, a2: f64, f12: f64) -> f64 {
    a1 * (a2 - a1 * f12 * f12) / (a1 + a2 - 2.0 * a1 * f12)
}

/// Apparent emissivity of a symmetric groove of two diffuse strips whose opening is `opening` times as
/// wide as both; each strip has one radiosity.
pub fn groove(e: f64, opening: f64) -> f64 {
    e / (opening + e * (1.0 - opening))
}

/// Temperature in kelvin of a plate under the sun with an insulated back: a S + e σ T_sky⁴ = e σ T⁴, with
/// the sun's irradiation S in W/m².
pub fn sunlit_plate(absorptance: f64, emissivity: f64, sun: f64, sky: f64) -> f64 {
    (absorptance * sun / (emissivity * SIGMA) + sky.powi(4)).powf(0.25)
}

/// Temperature in kelvin of shadow in a crater that is the share f of a sphere (Ingersoll, Svitek and
/// Murray, *Stability of polar frosts in spherical bowl-shaped craters*, Icarus 100, 1992), where the
/// sun's light on the plane of the rim is `sun` W/m²:
/// σT⁴ = S f (1 − A)/(1 − A f) (1 + A (1 − f)/ε).
pub fn crater_shadow(f: f64, albedo: f64, emissivity: f64, sun: f64) -> f64 {
    let scattered = 1.0 + albedo * (1.0 - f) / emissivity;
    let emitted = sun * f * (1.0 - albedo) / (1.0 - albedo * f) * scattered;
    (emitted / SIGMA).powf(0.25)
}

/// F from a disk of radius r1 to a coaxial one of radius r2 at distance h:
/// ½ (X − √(X² − 4 (r2/r1)²)), X = 1 + (r2² + h²)/r1².
pub fn disks(r1: f64, r2: f64, h: f64) -> f64 {
    let x = 1.0 + (r2 * r2 + h * h) / (r1 * r1);
    0.5 * (x - (x * x - 4.0 * (r2 / r1).powi(2)).sqrt())
}

/// F of infinitely long opposed strips of width w at distance h, by crossed strings.
pub fn opposed_strips(w: f64, h: f64) -> f64 {
    ((w * w + h * h).sqrt() - h) / w
}

/// F from a side a of an infinitely long triangle to the side b, where c is the third.
pub fn triangle_factor(a: f64, b: f64, c: f64) -> f64 {
    0.5 * (a + b - c) / a
}
