//! The reflection of a material as evaluated by the plots.

use azulejo::scene::brdf::{Content, Description, Model, Value};
use azulejo::scene::{Brdf, Dielectric, Material, Rgb};
use glam::DVec3;
use std::sync::Arc;

/// The part of a material that determines its reflection: the key of cached results.
#[derive(Clone, Debug)]
pub(super) struct MaterialReflection {
    diffuse: Rgb,
    mirror: Rgb,
    dielectric: Option<Dielectric>,
    brdf: Option<Arc<Brdf>>,
}

impl MaterialReflection {
    pub fn of(material: &Material) -> MaterialReflection {
        MaterialReflection {
            diffuse: material.diffuse,
            mirror: material.mirror,
            dielectric: material.dielectric,
            brdf: material.brdf.clone(),
        }
    }

    /// A material with this reflection.
    pub fn material(&self) -> Material {
        Material {
            diffuse: self.diffuse,
            mirror: self.mirror,
            dielectric: self.dielectric,
            brdf: self.brdf.clone(),
            ..Material::default()
        }
    }

    /// The functions to evaluate.
    pub fn reflector(&self) -> BrdfSum {
        let parts = match (&self.brdf, self.dielectric) {
            (_, Some(glass)) => vec![fresnel(glass.ior, self.mirror.max_channel())],
            (Some(brdf), None) => return BrdfSum(vec![brdf.clone()]),
            (None, None) => vec![
                one("diffuse", "kd", self.diffuse),
                one("specular", "ks", self.mirror),
            ],
        };
        let made = parts.into_iter().filter_map(|d| Brdf::new(d).ok());
        BrdfSum(made.map(Arc::new).collect())
    }
}

fn one(name: &str, parameter: &str, color: Rgb) -> Description {
    Description::model(name, [(parameter, Value::Color(color))])
}

/// Reflection at the boundary of glass.
fn fresnel(ior: f64, share: f64) -> Description {
    let model = Model::new("fresnel_dielectric", [("eta", Value::Number(ior))]);
    Description::Combination(vec![(share.min(1.0), model)])
}

impl PartialEq for MaterialReflection {
    fn eq(&self, other: &MaterialReflection) -> bool {
        let plain = |o: &MaterialReflection| (o.diffuse, o.mirror, o.dielectric);
        plain(self) == plain(other) && is_same_model(self.brdf.as_ref(), other.brdf.as_ref())
    }
}

/// Whether two models are the same, without comparing a million measured values.
pub(super) fn is_same_model(a: Option<&Arc<Brdf>>, b: Option<&Arc<Brdf>>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            Arc::ptr_eq(a, b) || is_same_description(a.description(), b.description())
        }
        _ => false,
    }
}

/// Whether two descriptions are the same; files are equal if they hold the same data in memory.
pub(super) fn is_same_description(a: &Description, b: &Description) -> bool {
    let shared = |a: &Option<Arc<Content>>, b: &Option<Arc<Content>>| match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    match (a, b) {
        (
            Description::File { path, content },
            Description::File {
                path: other,
                content: other_content,
            },
        ) => path == other && shared(content, other_content),
        (a, b) => a == b,
    }
}

/// A sum of reflection models.
pub(super) struct BrdfSum(Vec<Arc<Brdf>>);

impl BrdfSum {
    /// f_r, 1/sr, without mirror reflection.
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.0.iter().map(|brdf| brdf.eval(wo, wi)).sum()
    }

    /// Mirror reflectance, for the cosine of the angle to the normal.
    pub fn mirror(&self, cos: f64) -> Rgb {
        self.0.iter().map(|brdf| brdf.mirror(cos)).sum()
    }

    /// Albedo for light along `wo`, mirror reflection included, from that many evaluations.
    pub fn albedo(&self, wo: DVec3, samples: usize) -> Rgb {
        let of = |brdf: &Arc<Brdf>| brdf.albedo_by(wo, samples);
        self.0.iter().map(of).sum()
    }

    /// The models.
    pub fn parts(&self) -> &[Arc<Brdf>] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matt_mirror_reflects_both() {
        let mut material = Material::diffuse("", Rgb::grey(0.3));
        material.mirror = Rgb::grey(0.5);
        let both = MaterialReflection::of(&material).reflector();
        let wo = DVec3::new(0.6, 0.0, 0.8);
        assert!((both.albedo(wo, 256).r - 0.8).abs() < 1e-9);
        assert!((both.mirror(0.8).r - 0.5).abs() < 1e-9);
    }

    #[test]
    fn glass_mirrors_as_fresnel_says() {
        let glass = MaterialReflection::of(&Material::dielectric("", 1.5)).reflector();
        assert!((glass.mirror(1.0).r - 0.04).abs() < 1e-9);
    }

    #[test]
    fn names_and_emission_are_not_optics() {
        let a = Material::diffuse("a", Rgb::grey(0.5));
        let mut b = Material {
            name: "b".into(),
            emission: Rgb::WHITE,
            ..a.clone()
        };
        assert!(MaterialReflection::of(&a) == MaterialReflection::of(&b));
        b.diffuse = Rgb::grey(0.4);
        assert!(MaterialReflection::of(&a) != MaterialReflection::of(&b));
    }
}
