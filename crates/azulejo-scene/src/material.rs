//! Materials: what surfaces reflect, transmit and emit.

use crate::brdf::Lobes;
use crate::{
    Brdf, FinishMaps, IrradiancePicture, Opacity, Relief, Rgb, Texture, TextureId, fresnel,
};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Index of a material in [`Scene::materials`](crate::Scene::materials).
pub type MaterialId = u32;

/// The optical properties of a surface.
///
/// The model is additive (Sillion and Puech 1989): the fraction `diffuse` of the incident light is
/// reflected diffusely, the fraction `mirror` specularly, and the rest is absorbed; for every
/// channel `diffuse + mirror <= 1`. With a `dielectric`, the reflected and transmitted fractions
/// follow from Fresnel's equations instead, and `mirror` scales the reflected part. Diffuse and
/// mirror surfaces act on both sides; emission leaves the front only, unless `emits_back`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// Name in the file; may be empty.
    pub name: String,
    /// Diffuse reflectance ρ_d, 0..=1 per channel.
    pub diffuse: Rgb,
    /// Reflectance of the perfect mirror ρ_s, 0..=1 per channel.
    pub mirror: Rgb,
    /// Present on glass: the smooth boundary of a transparent body, or a thin pane.
    pub dielectric: Option<Dielectric>,
    /// Emitted radiance of the front side, W/(sr·m²), the same in all directions.
    pub emission: Rgb,
    /// A picture that multiplies `emission` where the mesh has texture coordinates; elsewhere its mean
    /// does. One that could not be loaded is black.
    pub emission_picture: Option<TextureId>,
    /// Whether the back emits the same.
    pub emits_back: bool,
    /// What the file says of the sides from which the surface is visible. Light does not depend on
    /// it; the first pass chooses by it which side's irradiance is stored.
    pub sidedness: Sidedness,
    /// Multiplies `diffuse`, where the mesh has texture coordinates. Several are multiplied
    /// with each other (GRF's multitexture).
    pub textures: Vec<TextureId>,
    /// A reflection model beyond Lambertian and perfectly specular reflection.
    ///
    /// `diffuse` and `mirror` hold its diffuse and specular parts, averaged over directions
    /// ([`Brdf::mean_diffuse`], [`Brdf::mean_mirror`]), for algorithms that need no more; its
    /// glossy lobes are additional. [`Material::with_brdf`] keeps the three consistent.
    pub brdf: Option<Arc<Brdf>>,
    /// How much of the surface is there; `None` is all of it. What it takes is as the other
    /// properties say ([`Material::see_through`]).
    pub opacity: Option<Opacity>,
    /// Pictures of metalness and roughness, for the second pass; `brdf` has their means.
    pub finish: Option<FinishMaps>,
    /// A picture of small relief, which tilts the shading normal in the second pass.
    pub relief: Option<Relief>,
    /// Irradiance in a picture, for the second pass, where the mesh has coordinates of lightmaps and no
    /// irradiance on its vertices. Surfaces that are not [one-sided](Sidedness::One) show it on both sides.
    pub lightmap: Option<IrradiancePicture>,
}

/// From which sides a surface is visible, by the file that it comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sidedness {
    /// The file does not say, or its format cannot.
    #[default]
    Unsaid,
    /// From the front only: backs are culled.
    One,
    /// From both sides.
    Two,
}

/// Glass: the smooth boundary between the outside and a transparent body, or a thin pane.
///
/// The front of a body's face points outward; a pane is the same from both sides. No absorption
/// inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction of the body relative to the outside, > 0.
    pub ior: f64,
    /// Scales the light that passes, 0..=1 per channel; white for clear glass.
    pub transmittance: Rgb,
    /// Whether the face stands for a whole pane with both of its surfaces: light passes straight
    /// through, and interreflection between the surfaces is included.
    pub thin: bool,
}

impl Dielectric {
    /// Whether light that passes goes straight on: through a pane, and into a body that does not
    /// refract.
    pub fn is_straight(&self) -> bool {
        self.thin || self.ior == 1.0
    }

    /// The share of the light in a unit direction that passes straight on, where it
    /// [does](Dielectric::is_straight); `normal` is unit and faces where the light comes from.
    pub fn straight_transmittance(&self, direction: DVec3, normal: DVec3) -> Rgb {
        let reflected = fresnel::pane(direction, normal, self.ior).reflectance;
        self.transmittance * (1.0 - reflected)
    }
}

impl Material {
    /// A matt surface.
    pub fn diffuse(name: impl Into<String>, reflectance: Rgb) -> Material {
        Material {
            name: name.into(),
            diffuse: reflectance,
            ..Material::default()
        }
    }

    /// A perfect mirror.
    pub fn mirror(name: impl Into<String>, reflectance: Rgb) -> Material {
        Material {
            name: name.into(),
            mirror: reflectance,
            ..Material::default()
        }
    }

    /// A smooth clear dielectric.
    pub fn dielectric(name: impl Into<String>, ior: f64) -> Material {
        Material {
            name: name.into(),
            mirror: Rgb::WHITE,
            dielectric: Some(Dielectric {
                ior,
                transmittance: Rgb::WHITE,
                thin: false,
            }),
            ..Material::default()
        }
    }

    /// A thin clear pane.
    pub fn pane(name: impl Into<String>, ior: f64) -> Material {
        let mut pane = Material::dielectric(name, ior);
        if let Some(glass) = &mut pane.dielectric {
            glass.thin = true;
        }
        pane
    }

    /// A black surface that emits `radiance`, W/(sr·m²), from its front.
    pub fn emitter(name: impl Into<String>, radiance: Rgb) -> Material {
        Material {
            name: name.into(),
            emission: radiance,
            ..Material::default()
        }
    }

    /// A surface that reflects by a model, scaled down where it would create energy
    /// ([`Brdf::limited`]).
    pub fn with_brdf(name: impl Into<String>, brdf: Arc<Brdf>) -> Material {
        let brdf = brdf.limited();
        Material {
            name: name.into(),
            diffuse: brdf.mean_diffuse(),
            mirror: brdf.mean_mirror(),
            brdf: Some(brdf),
            ..Material::default()
        }
    }

    /// The lobes that reflect around the specular direction, if there are any; none on glass.
    pub fn glossy(&self) -> Option<&Lobes> {
        let glossy = self.brdf.as_deref().map(Brdf::glossy);
        glossy.filter(|lobes| !lobes.is_empty() && self.dielectric.is_none())
    }

    /// Whether [`mirror_at`](Material::mirror_at) depends on the angle.
    pub fn mirror_varies(&self) -> bool {
        self.glossy().is_some() && !self.mirror.is_black()
    }

    /// Reflectance of the perfect mirror for the cosine of the angle to the normal. Where lobes
    /// take what it leaves, it is that of the model at this angle: with its mean, mirror and lobes
    /// together would reflect more than arrives where the lobes are strongest. Elsewhere the mean.
    pub fn mirror_at(&self, cos: f64) -> Rgb {
        let model = self.brdf.as_deref().filter(|_| self.mirror_varies());
        let Some(brdf) = model else {
            return self.mirror;
        };
        let near_mirrors = brdf.narrow().mean_albedo();
        let (mean, here) = (brdf.mean_mirror(), near_mirrors + brdf.mirror(cos));
        let scaled = |k: usize| {
            if mean[k] > 0.0 {
                self.mirror[k] * here[k] / mean[k]
            } else {
                self.mirror[k]
            }
        };
        Rgb::new(scaled(0), scaled(1), scaled(2))
    }

    /// Fraction of uniform light that the glossy lobes reflect.
    pub fn mean_glossy(&self) -> Rgb {
        self.glossy().map_or(Rgb::BLACK, Lobes::mean_albedo)
    }

    /// By how much reflectances may exceed 1: rounding, and more beside glossy lobes, whose share
    /// is found by samples.
    pub(crate) fn energy_margin(glossy: f64) -> f64 {
        if glossy > 0.0 { 2e-3 } else { 1e-9 }
    }

    /// Makes reflectances possible; `false` if they were not.
    ///
    /// What is outside 0..=1 is clamped; where diffuse and mirror, with glossy lobes, reflect more
    /// than arrives, both are scaled down.
    pub fn limit_reflectance(&mut self) -> bool {
        let before = (self.diffuse, self.mirror);
        self.diffuse = self.diffuse.map(|x| x.clamp(0.0, 1.0));
        self.mirror = self.mirror.map(|x| x.clamp(0.0, 1.0));
        let glossy = self.mean_glossy();
        for channel in 0..3 {
            let sum = self.diffuse[channel] + self.mirror[channel];
            let room = (1.0 - glossy[channel]).max(0.0);
            // The margin is that of a valid scene, whose sums are left to the bit.
            if sum > room + Material::energy_margin(glossy[channel]) {
                self.diffuse[channel] *= room / sum;
                self.mirror[channel] *= room / sum;
            }
        }
        before == (self.diffuse, self.mirror)
    }

    /// Diffuse reflectance at a point of vertex colour `color` and texture coordinates `uv`;
    /// `texture` returns a texture.
    ///
    /// Textures that could not be loaded are ignored, and all are where there are no coordinates.
    pub fn painted<'a>(
        &self,
        color: Rgb,
        uv: Option<DVec2>,
        texture: impl Fn(TextureId) -> Option<&'a Texture>,
    ) -> Rgb {
        self.diffuse * self.pattern(color, uv, texture)
    }

    /// The factor by which a vertex colour and textures change the diffuse reflectance, as
    /// [`painted`](Material::painted).
    pub fn pattern<'a>(
        &self,
        color: Rgb,
        uv: Option<DVec2>,
        texture: impl Fn(TextureId) -> Option<&'a Texture>,
    ) -> Rgb {
        let mut pattern = color;
        if let Some(uv) = uv {
            let textures = self.textures.iter().filter_map(|&id| texture(id));
            for color in textures.filter_map(|texture| texture.sample(uv)) {
                pattern *= Rgb::from(color.map(f64::from));
            }
        }
        pattern
    }

    /// Emitted exitance M = πL of the front, W/m²; a picture of it multiplies this.
    pub fn exitance(&self) -> Rgb {
        self.emission * std::f64::consts::PI
    }

    /// Emitted radiance of one side, W/(sr·m²); a picture of it multiplies this.
    pub fn emission_from(&self, front: bool) -> Rgb {
        if front || self.emits_back {
            self.emission
        } else {
            Rgb::BLACK
        }
    }

    /// Whether incident light can leave in or near the specular or refracted direction.
    pub fn is_specular(&self) -> bool {
        self.dielectric.is_some() || !self.mirror.is_black() || self.glossy().is_some()
    }

    /// The opacity of a surface through which light passes; `None` if none does. Surfaces that emit are
    /// opaque, whatever their opacity: what a half transparent lamp emits is not defined by the formats.
    pub fn see_through(&self) -> Option<&Opacity> {
        let opacity = self.opacity.as_ref().filter(|o| !o.is_opaque());
        opacity.filter(|_| !self.is_emitter())
    }

    /// All pictures that it shows: of its colour, its opacity, its emission, its relief, its
    /// lightmap and its finish.
    pub fn pictures(&self) -> impl Iterator<Item = TextureId> + '_ {
        let opacity = self.opacity.and_then(|o| o.picture).map(|p| p.texture);
        let relief = self.relief.map(|r| r.texture);
        let light = self.lightmap.map(|l| l.texture);
        let rest = [opacity, self.emission_picture, relief, light];
        let finish = self.finish.iter().flat_map(FinishMaps::pictures);
        (self.textures.iter().copied())
            .chain(rest.into_iter().flatten())
            .chain(finish)
    }

    /// Numbers its pictures `by` more, as where their list is appended to another.
    pub fn renumber_pictures(&mut self, by: TextureId) {
        self.number_pictures(|t| t + by);
    }

    /// Numbers its pictures anew.
    pub(crate) fn number_pictures(&mut self, number: impl Fn(TextureId) -> TextureId) {
        self.textures.iter_mut().for_each(|t| *t = number(*t));
        let opacity = self.opacity.as_mut().and_then(|o| o.picture.as_mut());
        let rest = [
            opacity.map(|p| &mut p.texture),
            self.emission_picture.as_mut(),
            self.relief.as_mut().map(|r| &mut r.texture),
            self.lightmap.as_mut().map(|l| &mut l.texture),
        ];
        rest.into_iter().flatten().for_each(|t| *t = number(*t));
        if let Some(finish) = &mut self.finish {
            finish.renumber(&number);
        }
    }

    /// Forgets its pictures.
    pub fn drop_pictures(&mut self) {
        self.textures.clear();
        (self.emission_picture, self.relief, self.finish) = (None, None, None);
        self.lightmap = None;
        if let Some(opacity) = &mut self.opacity {
            opacity.picture = None;
        }
    }

    /// Whether the front emits light.
    pub fn is_emitter(&self) -> bool {
        !self.emission.is_black()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(text: &str) -> Arc<Brdf> {
        Arc::new(Brdf::new(text.parse().unwrap()).unwrap())
    }

    /// About what lobes leave (the model itself exceeds 1 by 3% toward grazing angles), where the mean of
    /// all angles would make 1.1 near the normal.
    #[test]
    fn mirrors_beside_lobes_reflect_by_their_angle() {
        let model = model("he_torrance sigma0 = 0.05 tau = 2 lambda = 0.55");
        let material = Material::with_brdf("smooth", model);
        let lobes = material.glossy().unwrap();
        let mut mean = 0.0;
        for k in 0..32 {
            let cos = (f64::from(k) + 0.5) / 32.0;
            let wo = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let mirror = material.mirror_at(cos).r;
            let whole = mirror + lobes.albedo(wo).r;
            assert!(whole < 1.05, "cos {cos}: {mirror} of {whole}");
            mean += mirror * 2.0 * cos / 32.0;
        }
        assert!((mean / material.mirror.r - 1.0).abs() < 0.01, "{mean}");
        let chrome = Material::with_brdf("chrome", self::model("specular ks = 0.6"));
        assert_eq!(chrome.mirror_at(0.3), chrome.mirror);
    }
}
